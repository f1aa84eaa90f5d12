//! Counts of what was compared. Merging tallies is associative and commutative, so that the order in which frames are
//! run leaves no trace.

use crate::bounds::{Stage, TABLE};
use std::collections::BTreeMap;

/// Parts of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    /// Images that this project did not draw.
    Renders,
    /// The paper's data set.
    Paper,
    /// Frontal views, centimetre by centimetre.
    Frontal,
    /// The same views by the whole-pixel rule.
    WholePixel,
    /// Random scenes.
    Scenes,
    /// Arbitrary scan lines.
    Lines,
}

impl Part {
    /// Its name in tables and certificates.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Renders => "renders",
            Self::Paper => "paper",
            Self::Frontal => "frontal",
            Self::WholePixel => "frontal, whole-pixel",
            Self::Scenes => "scenes",
            Self::Lines => "lines",
        }
    }
}

/// A frame of a campaign: enough to run it again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Frame {
    /// Its part.
    pub part: Part,
    /// Its number in the part.
    pub index: u64,
}

/// A difference, what it may be, and where it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Absolute difference.
    pub difference: f64,
    /// Its bound.
    pub bound: f64,
    /// Its frame.
    pub frame: Frame,
}

impl Case {
    /// Share of the bound used; a difference where none is allowed is infinite.
    #[must_use]
    pub fn share(&self) -> f64 {
        if self.bound > 0.0 {
            self.difference / self.bound
        } else if self.difference > 0.0 {
            f64::INFINITY
        } else {
            0.0
        }
    }

    /// The one that used more of its bound, the earlier frame of equals.
    fn worse(self, other: Self) -> Self {
        let order = self.share().total_cmp(&other.share()).then(other.frame.cmp(&self.frame));
        if order.is_lt() { other } else { self }
    }
}

/// What was seen of one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTally {
    /// Results compared.
    pub cases: u64,
    /// Results that are not the same.
    pub failures: u64,
    /// Decisions whose margin in the reference is below its declared error.
    pub marginal: u64,
    /// The case that used most of its bound.
    pub worst: Option<Case>,
    /// The first frame that failed.
    pub first_failure: Option<Frame>,
}

impl StageTally {
    /// Something was compared, and nothing differed more than it may.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.cases > 0 && self.failures == 0
    }

    fn merge(&mut self, other: &Self) {
        self.cases += other.cases;
        self.failures += other.failures;
        self.marginal += other.marginal;
        self.worst = either(self.worst, other.worst, Case::worse);
        self.first_failure = either(self.first_failure, other.first_failure, Frame::min);
    }
}

fn either<T>(one: Option<T>, other: Option<T>, both: impl FnOnce(T, T) -> T) -> Option<T> {
    match (one, other) {
        (Some(one), Some(other)) => Some(both(one, other)),
        (one, other) => one.or(other),
    }
}

/// What was seen of all stages.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Frames compared.
    pub frames: u64,
    /// Frames with a decision whose margin is below the reference's declared error (SAME-4).
    pub marginal_frames: u64,
    /// Marginal frames in which the pipelines decided differently.
    pub differing_frames: u64,
    stages: BTreeMap<Stage, StageTally>,
}

impl Tally {
    /// What was seen of a stage.
    #[must_use]
    pub fn stage(&self, stage: Stage) -> StageTally {
        self.stages.get(&stage).copied().unwrap_or_default()
    }

    /// Whether every stage passes.
    #[must_use]
    pub fn passes(&self) -> bool {
        TABLE.iter().all(|row| self.stage(row.stage).passes())
    }

    /// Stages with failures, in the table's order.
    #[must_use]
    pub fn failing(&self) -> Vec<Stage> {
        TABLE.iter().map(|row| row.stage).filter(|&stage| self.stage(stage).failures > 0).collect()
    }

    /// A result that must be identical.
    pub fn exact(&mut self, stage: Stage, frame: Frame, same: bool) {
        self.bounded(stage, frame, if same { 0.0 } else { 1.0 }, 0.0);
    }

    /// A result that may differ by `bound`; NaN is a failure.
    pub fn bounded(&mut self, stage: Stage, frame: Frame, difference: f64, bound: f64) {
        let case = Case { difference, bound, frame };
        let fails = difference.is_nan() || difference > bound;
        let one = StageTally {
            cases: 1,
            failures: u64::from(fails),
            marginal: 0,
            worst: Some(case),
            first_failure: fails.then_some(frame),
        };
        self.stages.entry(stage).or_default().merge(&one);
    }

    /// A decision whose margin is below the reference's declared error.
    //= reference/SPEC.md#same
    //# - **SAME-4** A frame with a margin below that error MUST be counted as marginal, whether the pipelines differ or
    //# not.
    pub fn marginal(&mut self, stage: Stage) {
        self.stages.entry(stage).or_default().marginal += 1;
    }

    /// Adds another tally.
    #[must_use]
    pub fn merged(mut self, other: &Self) -> Self {
        self.frames += other.frames;
        self.marginal_frames += other.marginal_frames;
        self.differing_frames += other.differing_frames;
        for (stage, tally) in &other.stages {
            self.stages.entry(*stage).or_default().merge(tally);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(index: u64) -> Frame {
        Frame { part: Part::Scenes, index }
    }

    #[test]
    fn a_difference_at_the_bound_passes_and_one_above_fails() {
        let mut tally = Tally::default();
        tally.bounded(Stage::PoseX, frame(1), 1.0, 1.0);
        assert!(tally.stage(Stage::PoseX).passes());
        tally.bounded(Stage::PoseX, frame(2), 1.0 + 1e-12, 1.0);
        assert_eq!(tally.failing(), [Stage::PoseX]);
        assert_eq!(tally.stage(Stage::PoseX).first_failure, Some(frame(2)));
    }

    #[test]
    fn nothing_compared_is_no_evidence_and_nan_no_agreement() {
        let mut tally = Tally::default();
        assert!(!tally.passes());
        tally.bounded(Stage::PoseX, frame(1), f64::NAN, 1.0);
        assert_eq!(tally.failing(), [Stage::PoseX]);
    }

    #[test]
    fn merging_does_not_depend_on_the_order() {
        let cases = [(3, 0.5, 1.0), (1, 0.9, 1.0), (4, 2.0, 1.0), (2, 0.9, 1.0), (0, 2.0, 1.0), (9, 0.1, 0.1)];
        let tallies: Vec<Tally> = cases
            .iter()
            .map(|&(index, difference, bound)| {
                let mut tally = Tally { frames: 1, marginal_frames: 2, differing_frames: 3, ..Tally::default() };
                tally.bounded(Stage::Centre, frame(index), difference, bound);
                tally.exact(Stage::Merge, frame(index), index % 2 == 0);
                tally.marginal(Stage::Sampling);
                tally
            })
            .collect();
        let forwards = tallies.iter().fold(Tally::default(), Tally::merged);
        let backwards = tallies.iter().rev().fold(Tally::default(), Tally::merged);
        assert_eq!(forwards, backwards);
        // Of equal shares the earlier frame.
        assert_eq!(forwards.stage(Stage::Centre).worst.map(|case| case.frame), Some(frame(0)));
        let merge = forwards.stage(Stage::Merge);
        assert_eq!((merge.cases, merge.failures, merge.first_failure), (6, 3, Some(frame(1))));
        assert_eq!((forwards.frames, forwards.marginal_frames, forwards.differing_frames), (6, 12, 18));
        assert_eq!(forwards.stage(Stage::Sampling).marginal, 6);
    }
}
