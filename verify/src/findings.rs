//! What a campaign found. Merging findings is associative and commutative.

use crate::scenes::Cell;
use crate::tally::{Part, Tally};
use crate::trace::Trace;
use reference::landmark::Format;
use reference::merge::{Decoder, Estimator};
use reference::refusal::{CandidateRefusal, PairRefusal};
use serde::Serialize;
use std::collections::BTreeMap;

/// A number for each pipeline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Both {
    /// Of the reference.
    pub reference: u64,
    /// Of the port.
    pub fixedpoint: u64,
}

impl Both {
    /// The same count of both traces.
    pub fn count(traces: &[Trace; 2], count: impl Fn(&Trace) -> usize) -> Self {
        Self { reference: count(&traces[0]) as u64, fixedpoint: count(&traces[1]) as u64 }
    }

    fn add(&mut self, other: Self) {
        self.reference += other.reference;
        self.fixedpoint += other.fixedpoint;
    }
}

/// Views, and those in which the landmark was found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Rate {
    /// Views.
    pub views: u64,
    /// Found.
    pub found: Both,
}

impl Rate {
    /// Adds views.
    pub fn add(&mut self, other: Self) {
        self.views += other.views;
        self.found.add(other.found);
    }
}

/// Counts of one part of a campaign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PartCount {
    /// Frames.
    pub frames: u64,
    /// Detections that are not in the scene.
    pub wrong_payloads: Both,
    /// Pairs of layers whose check byte was wrong.
    pub refused_by_crc: Both,
    /// Pairs of equal layers.
    pub refused_as_equal: Both,
    /// Detections withdrawn because they decode in two formats.
    pub ambiguous: Both,
}

impl PartCount {
    fn add(&mut self, other: &Self) {
        self.frames += other.frames;
        self.wrong_payloads.add(other.wrong_payloads);
        self.refused_by_crc.add(other.refused_by_crc);
        self.refused_as_equal.add(other.refused_as_equal);
        self.ambiguous.add(other.ambiguous);
    }
}

/// Random scenes by whether their first landmark should be found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SceneRates {
    /// Within RANGE-1, RANGE-2 and the image.
    pub in_range: Rate,
    /// Not so.
    pub out_of_range: Rate,
    /// Scenes without a landmark: blank walls and rows of bars.
    pub without_landmark: Phantoms,
}

/// Scenes in which there is nothing to be found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Phantoms {
    /// Blank walls, with or without dark things.
    pub blank: Rate,
    /// Rows of bars.
    pub bars: Rate,
}

/// Everything that a campaign found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// The comparison.
    pub tally: Tally,
    /// Counts by part.
    pub parts: BTreeMap<Part, PartCount>,
    /// Detection rates by part and cell.
    pub rates: BTreeMap<(Part, Cell), Rate>,
    /// Detection rates of the random scenes.
    pub scenes: SceneRates,
    /// Random scenes in each box of the pose space.
    pub boxes: BTreeMap<usize, u64>,
    /// What became of the pairs that were tried, by decoder.
    pub candidates: BTreeMap<(Decoder, CandidateEnd), Both>,
}

/// How a pair of layers or extents ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CandidateEnd {
    /// As a detection, by a fit or by the paper's estimate.
    Detection(Estimator),
    /// It has no payload.
    Pair(PairRefusal),
    /// It was refused.
    Refused(CandidateRefusal),
}

impl CandidateEnd {
    /// In a few words.
    #[must_use]
    pub fn describe(self) -> String {
        match self {
            Self::Detection(Estimator::Fit) => "detection, fitted".to_owned(),
            Self::Detection(Estimator::Paper) => "detection, the paper's estimate".to_owned(),
            Self::Pair(refusal) => refusal.to_string(),
            Self::Refused(refusal) => refusal.to_string(),
        }
    }
}

/// How the pairs of a trace ended; those of layers that the trellis has decided again count for the trellis.
fn ends(trace: &Trace) -> impl Iterator<Item = (Decoder, CandidateEnd)> {
    let refused = trace.trials.iter().filter_map(|trial| match (trial.refusal, trial.readings.last()) {
        (Some((decoder, refusal)), _) => Some((decoder, CandidateEnd::Refused(refusal))),
        (None, Some(&(decoder, Err(refusal)))) => Some((decoder, CandidateEnd::Pair(refusal))),
        _ => None,
    });
    refused.chain(trace.detections.iter().map(|found| (found.decoder, CandidateEnd::Detection(found.estimator()))))
}

impl Findings {
    /// Adds other findings.
    #[must_use]
    pub fn merged(mut self, other: &Self) -> Self {
        self.tally = self.tally.merged(&other.tally);
        for (part, count) in &other.parts {
            self.parts.entry(*part).or_default().add(count);
        }
        for (cell, rate) in &other.rates {
            self.rates.entry(*cell).or_default().add(*rate);
        }
        self.scenes.in_range.add(other.scenes.in_range);
        self.scenes.out_of_range.add(other.scenes.out_of_range);
        self.scenes.without_landmark.blank.add(other.scenes.without_landmark.blank);
        self.scenes.without_landmark.bars.add(other.scenes.without_landmark.bars);
        for (end, count) in &other.candidates {
            self.candidates.entry(*end).or_default().add(*count);
        }
        for (place, count) in &other.boxes {
            *self.boxes.entry(*place).or_default() += count;
        }
        self
    }

    /// Adds one frame's results, given what is in the scene.
    pub fn add_frame(&mut self, part: Part, truth: &[(Format, u32)], traces: &[Trace; 2]) {
        for end in ends(&traces[0]) {
            self.candidates.entry(end).or_default().reference += 1;
        }
        for end in ends(&traces[1]) {
            self.candidates.entry(end).or_default().fixedpoint += 1;
        }
        let is_wrong = |found: (Format, u32)| !truth.contains(&found);
        let refused = |trace: &Trace, refusal| trace.pairs.iter().filter(|pair| pair.result == Err(refusal)).count();
        self.parts.entry(part).or_default().add(&PartCount {
            frames: 1,
            wrong_payloads: Both::count(traces, |trace| found(trace).filter(|&it| is_wrong(it)).count()),
            refused_by_crc: Both::count(traces, |trace| refused(trace, PairRefusal::Crc)),
            refused_as_equal: Both::count(traces, |trace| refused(trace, PairRefusal::EqualHalves)),
            ambiguous: Both::count(traces, |trace| trace.ambiguous.len()),
        });
    }
}

/// Format and payload of a trace's detections.
fn found(trace: &Trace) -> impl Iterator<Item = (Format, u32)> {
    trace.detections.iter().map(|detection| (detection.format, detection.payload))
}

/// One view of nothing: found is what was found all the same.
#[must_use]
pub fn view_of_nothing(traces: &[Trace; 2]) -> Rate {
    Rate { views: 1, found: Both::count(traces, |trace| usize::from(!trace.detections.is_empty())) }
}

/// One view of a landmark.
#[must_use]
pub fn view(landmark: (Format, u32), traces: &[Trace; 2]) -> Rate {
    Rate { views: 1, found: Both::count(traces, |trace| usize::from(found(trace).any(|it| it == landmark))) }
}
