//! How well a robot knew where it was.

use crate::ride::{Known, Row, Taken, apart, nees};
use reference::exposure::Time;
use reference::frame::{Pose, Robot, World};
use serde::Serialize;

/// Errors after a recovery beyond this, and beyond those before it, are harmful, metres (ROUTE-6).
//= reference/SPEC.md#route
//# - **ROUTE-6** A recovery MUST count as harmful where the filter began again and the error is then above 2 cm and
//# above that of the sample before.
const HARMFUL: f64 = 0.02;

/// A robot that was lost knows again where it is within this: metres, and radians (ROUTE-4).
//= reference/SPEC.md#route
//# - **ROUTE-4** A robot MUST count as lost from a wrong start or from when it is put down elsewhere, until its filter
//# begins again elsewhere, or uses an observation and is within 5 cm and 0.2 rad of the truth then.
const FOUND: (f64, f64) = (0.05, 0.2);

/// A time at which a filter began again elsewhere, or a lost robot was found (ROUTE-5).
//= reference/SPEC.md#route
//# - **ROUTE-5** Each time a filter begins again, and each time a lost robot is found, MUST count as a recovery with
//# the number of images that showed a known landmark since the robot was lost, or otherwise since an observation was
//# last used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Recovery {
    /// Images that showed a known landmark since the robot was lost, or since an observation was last used.
    pub images: u64,
    /// Whether the error is over 2 cm and larger than before.
    pub harmful: bool,
    /// Whether the robot had been lost: begun with a wrong pose, or lifted.
    #[serde(skip)]
    pub was_lost: bool,
}

/// A run's errors and what became of what was seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Distance from the truth at every reading, metres.
    pub position: Vec<f64>,
    /// Difference in heading from the truth, radians.
    pub heading: Vec<f64>,
    /// Normalised estimation error squared.
    pub nees: Vec<f64>,
    /// What happened in all.
    pub taken: Taken,
    /// Where it began again.
    pub recoveries: Vec<Recovery>,
    /// How often it was lost and did not find back before the end or before it was lost again.
    pub lost: u64,
    pub(super) state: State,
}

/// Where a robot is in being lost and found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct State {
    lost: bool,
    images: u64,
    error: f64,
}

impl Score {
    /// The robot is given a wrong pose, or is put elsewhere.
    pub fn lose(&mut self) {
        self.lost += u64::from(self.state.lost);
        self.state = State { lost: true, images: 0, ..self.state };
    }

    /// The robot at a reading.
    pub fn note(&mut self, known: &Known, taken: &Taken, truth: &Pose<World, Robot>) {
        let (position, heading) = apart(&known.pose, truth);
        self.position.push(position);
        self.heading.push(heading);
        self.nees.extend(nees(known, truth));
        self.taken = self.taken.and(taken);
        self.state.images += taken.images;
        let found = self.state.lost && taken.used > 0 && position < FOUND.0 && heading < FOUND.1;
        if taken.recovered > 0 || found {
            let harmful = taken.recovered > 0 && position > HARMFUL && position > self.state.error;
            self.recoveries.push(Recovery { images: self.state.images, harmful, was_lost: self.state.lost });
            self.state.lost = false;
        }
        if taken.used > 0 && !self.state.lost {
            self.state.images = 0;
        }
        self.state.error = position;
    }

    /// The run is over.
    pub fn end(&mut self) {
        self.lost += u64::from(std::mem::take(&mut self.state.lost));
    }
}

/// Scores of all robots of a ride, by its rows.
pub fn note(scores: &mut [Score], row: &Row, lost_at: &mut Vec<Time>) {
    while lost_at.first().is_some_and(|time| *time <= row.time) {
        lost_at.remove(0);
        scores.iter_mut().for_each(Score::lose);
    }
    let Some(truth) = &row.truth else { return };
    for ((score, known), taken) in scores.iter_mut().zip(&row.known).zip(&row.taken) {
        score.note(known, taken, truth);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    /// A robot that is `off` metres beside the truth and turned by so much.
    fn known(off: f64, turned: f64) -> Known {
        Known { pose: Pose::new(off, 0.0, turned), covariance: Matrix3::identity() }
    }

    fn seen(score: &mut Score, off: f64, turned: f64, [images, used, recovered]: [u64; 3]) {
        let taken = Taken { images, used, recovered, ..Taken::default() };
        score.note(&known(off, turned), &taken, &Pose::new(0.0, 0.0, 0.0));
    }

    /// Lost until an observation is used within 5 cm and 0.2 rad of the truth, or the filter begins again.
    //= reference/SPEC.md#route
    //= type=test
    //# - **ROUTE-4** A robot MUST count as lost from a wrong start or from when it is put down elsewhere, until its
    //# filter begins again elsewhere, or uses an observation and is within 5 cm and 0.2 rad of the truth then.
    #[test]
    fn a_lost_robot_is_found_near_the_truth_or_where_its_filter_begins_again() {
        let lost_after = |off: f64, turned: f64, taken: [u64; 3]| {
            let mut score = Score::default();
            score.lose();
            seen(&mut score, off, turned, taken);
            score.end();
            (score.lost, score.recoveries.len())
        };
        assert_eq!(lost_after(0.049, 0.19, [1, 1, 0]), (0, 1));
        assert_eq!(lost_after(0.051, 0.0, [1, 1, 0]), (1, 0));
        assert_eq!(lost_after(0.0, 0.21, [1, 1, 0]), (1, 0));
        assert_eq!(lost_after(0.0, 0.0, [1, 0, 0]), (1, 0), "without an observation it does not know");
        assert_eq!(lost_after(0.4, 3.0, [1, 0, 1]), (0, 1));
    }

    /// A recovery has the images since the robot was lost, or since an observation was last used.
    //= reference/SPEC.md#route
    //= type=test
    //# - **ROUTE-5** Each time a filter begins again, and each time a lost robot is found, MUST count as a recovery
    //# with the number of images that showed a known landmark since the robot was lost, or otherwise since an
    //# observation was last used.
    #[test]
    fn a_recovery_counts_its_images() {
        let mut score = Score::default();
        seen(&mut score, 0.0, 0.0, [4, 1, 0]);
        seen(&mut score, 0.0, 0.0, [1, 0, 0]);
        seen(&mut score, 0.0, 0.0, [2, 0, 1]);
        let own = Recovery { images: 3, harmful: false, was_lost: false };
        assert_eq!(score.recoveries, [own]);
        seen(&mut score, 0.0, 0.0, [1, 1, 0]);
        score.lose();
        seen(&mut score, 1.0, 0.0, [1, 1, 0]);
        seen(&mut score, 0.01, 0.0, [1, 1, 0]);
        assert_eq!(score.recoveries, [own, Recovery { images: 2, harmful: false, was_lost: true }]);
    }

    /// Beginning again elsewhere is harmful beyond 2 cm, unless it was worse before.
    //= reference/SPEC.md#route
    //= type=test
    //# - **ROUTE-6** A recovery MUST count as harmful where the filter began again and the error is then above 2 cm and
    //# above that of the sample before.
    #[test]
    fn a_recovery_is_harmful_that_leads_away() {
        let harmful = |before: f64, after: f64, recovered: u64| {
            let mut score = Score::default();
            seen(&mut score, before, 0.0, [1, 1, 0]);
            score.lose();
            seen(&mut score, after, 0.0, [1, 1, recovered]);
            score.recoveries.iter().any(|recovery| recovery.harmful)
        };
        assert!(harmful(0.0, 0.021, 1));
        assert!(!harmful(0.0, 0.019, 1) && !harmful(0.03, 0.025, 1) && !harmful(0.0, 0.021, 0));
    }
}
