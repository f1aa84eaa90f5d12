//! How well a robot knew where it was.

use crate::ride::{Known, Row, Taken, apart, nees};
use reference::exposure::Time;
use reference::frame::{Pose, Robot, World};
use serde::Serialize;

/// Errors after a recovery beyond this, and beyond those before it, are harmful, metres (ROUTE-6).
const HARMFUL: f64 = 0.02;

/// A robot that was lost knows again where it is within this: metres, and radians (ROUTE-4).
const FOUND: (f64, f64) = (0.05, 0.2);

/// A time at which a filter began again elsewhere, or a lost robot was found (ROUTE-5).
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
