//! What a detector accepts in scan lines that show no landmark ([`crate::junk`]), and how far the rest comes.

use crate::junk::{self, Kind};
use crate::lockstep::Setting;
use crate::port::{Cameras, Landmarks};
use crate::trace::{HomographyTrace, HypothesisTrace, Outcome, Trace, TrialTrace};
use comfy_table::{CellAlignment, Table, presets};
use rayon::prelude::*;
use reference::accept::{View, accept, accept_fit};
use reference::camera::Camera;
use reference::crossing::CrossingRule;
use reference::decode::DecodedLayer;
use reference::extents::{Extent, Pair};
use reference::fit::FitLayer;
use reference::homography::Homography;
use reference::hypotheses::Hypothesis;
use reference::landmark::{Format, stripes};
use reference::merge::Decoder;
use reference::observer::{Layer, Silent};
use reference::refusal::PairRefusal;
use reference::skew::Skew;
use reference::trellis::{self, Settled};
use std::collections::BTreeMap;

/// A pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pipeline {
    /// The float64 reference.
    Reference,
    /// The fixed-point port.
    Fixedpoint,
}

/// What was seen of one kind of lines.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Pairs of lines.
    pub frames: u64,
    /// Layers that were decoded.
    pub layers: u64,
    /// Pairs of layers that have a payload, before MERGE-7.
    pub passed: u64,
    /// Pairs of layers or extents that were refused, by the name of the refusal.
    pub refused: BTreeMap<String, u64>,
    /// Pairs that pass all tests of ACCEPT, with or without the check byte: of the threshold and of the trellis.
    pub before_crc: [u64; 2],
    /// Detections: all of them are false.
    pub accepted: u64,
    /// The first frame with a detection.
    pub first_accepted: Option<u64>,
}

impl Count {
    /// What one frame adds.
    #[must_use]
    pub fn of(index: u64, setting: &Setting, trace: &Trace) -> Self {
        let mut count = Self { frames: 1, accepted: trace.detections.len() as u64, ..Self::default() };
        let decoded = |outcome: &Outcome| matches!(outcome, Outcome::Decoded { .. });
        count.layers = trace.hypotheses.iter().filter(|roi| decoded(&roi.outcome)).count() as u64;
        for trial in &trace.trials {
            let last = trial.readings.last();
            count.passed += u64::from(last.is_some_and(|(_, result)| result.is_ok()));
            let refusal = match (trial.refusal, last) {
                (Some((_, refusal)), _) => Some(format!("{refusal:?}")),
                (None, Some((_, Err(refusal)))) => Some(format!("{refusal:?}")),
                _ => None,
            };
            if let Some(refusal) = refusal {
                *count.refused.entry(refusal).or_default() += 1;
            }
            match explained(setting, trace, trial) {
                Some(Decoder::Threshold) => count.before_crc[0] += 1,
                Some(Decoder::Trellis) => count.before_crc[1] += 1,
                None => {}
            }
        }
        count.first_accepted = (count.accepted > 0).then_some(index);
        count
    }

    /// Pairs of layers and of extents.
    #[must_use]
    pub fn pairs(&self) -> u64 {
        self.accepted + self.refused.values().sum::<u64>()
    }

    /// Both together.
    #[must_use]
    pub fn merged(mut self, other: &Self) -> Self {
        self.frames += other.frames;
        self.layers += other.layers;
        self.passed += other.passed;
        self.accepted += other.accepted;
        self.before_crc = [0, 1].map(|decoder| self.before_crc[decoder] + other.before_crc[decoder]);
        for (refusal, pairs) in &other.refused {
            *self.refused.entry(refusal.clone()).or_default() += pairs;
        }
        self.first_accepted = self.first_accepted.into_iter().chain(other.first_accepted).min();
        self
    }
}

/// Who read a pair that is a detection, or that only the check byte refuses (CODE-8): what it refuses is put to ACCEPT's tests
/// by the reference, whichever pipeline the trace is of.
fn explained(setting: &Setting, trace: &Trace, trial: &TrialTrace) -> Option<Decoder> {
    if let Some((decoder, _)) = trial.accepted() {
        return Some(decoder);
    }
    let landmark = setting.landmarks.reference.iter().find(|landmark| landmark.format == trial.format)?;
    let lines = [&trace.lines[0].values[..], &trace.lines[1].values[..]];
    let view = View { lines, camera: &setting.cameras.reference, landmark, rule: setting.rule, skew: Skew::at_rest() };
    let by = |decoder| trial.readings.contains(&(decoder, Err(PairRefusal::Crc)));
    let layers = || Some([layer(trace, trial, Layer::Upper)?, layer(trace, trial, Layer::Lower)?]);
    if by(Decoder::Threshold) {
        let [upper, lower] = layers()?;
        if accept([&upper, &lower], &view, &mut Silent).is_ok() {
            return Some(Decoder::Threshold);
        }
    }
    if !by(Decoder::Trellis) {
        return None;
    }
    let pair = trial.pixels.map(|(first, last)| Extent { first, last });
    let settled = match trial.decoder {
        Decoder::Trellis => trellis::decode(&pair, &view, &mut Silent),
        Decoder::Threshold => {
            let [upper, lower] = layers()?;
            let start = upper.homography.mean(&lower.homography);
            trellis::decode_again(&pair, [upper.half_word, lower.half_word], &start, &view, &mut Silent)
        }
    };
    explains(settled.ok()?, &pair, &view).then_some(Decoder::Trellis)
}

/// Whether a barcode with these half words explains the pixels (ACCEPT).
fn explains(settled: Settled, pair: &Pair, view: &View<'_>) -> bool {
    let colours = settled.half_words.map(|word| stripes(view.landmark.format, word));
    let layers = [0, 1].map(|i| FitLayer {
        line: view.lines[i],
        first_pixel: pair[i].first,
        last_pixel: pair[i].last,
        stripes: &colours[i],
    });
    accept_fit(&layers, settled.fitted, Decoder::Trellis, view, &mut Silent).is_ok()
}

/// The decoded layer of a trial in one line.
fn layer(trace: &Trace, trial: &TrialTrace, layer: Layer) -> Option<DecodedLayer> {
    let (first_pixel, last_pixel) = trial.pixels[usize::from(layer == Layer::Lower)];
    let here = |roi: &&HypothesisTrace| {
        (roi.layer, roi.format, roi.pixels) == (layer, trial.format, (first_pixel, last_pixel))
    };
    trace.hypotheses.iter().filter(here).find_map(|roi| match roi.outcome {
        Outcome::Decoded { half_word, homography: HomographyTrace { a, s, k } } => Some(DecodedLayer {
            thresholding: roi.thresholding,
            hypothesis: Hypothesis { first_region: roi.regions.0, last_region: roi.regions.1, first_pixel, last_pixel },
            half_word,
            homography: Homography { a, s, k },
        }),
        _ => None,
    })
}

/// Counts by kind.
pub type Counts = BTreeMap<Kind, Count>;

fn merged(mut one: Counts, other: &Counts) -> Counts {
    for (&kind, count) in other {
        let sum = std::mem::take(one.entry(kind).or_default()).merged(count);
        one.insert(kind, sum);
    }
    one
}

/// Runs `frames` pairs of lines of `kinds` in turn through `detect`, which is given the formats that it must not find
/// and the lines, and says how it was set. The result does not depend on the number of threads.
pub fn run<F>(kinds: &[Kind], frames: u64, seed: u64, camera: &Camera, detect: F) -> Counts
where
    F: Fn(&[Format], &[Vec<u8>; 2]) -> (Setting, Trace) + Sync,
{
    let shares = kinds.len() as u64;
    let one = |mut counts: Counts, frame: u64| {
        let (kind, index) = (kinds[usize::try_from(frame % shares).unwrap_or(0)], frame / shares);
        let (setting, trace) = detect(kind.formats(), &junk::lines(kind, seed, index, camera));
        let count = std::mem::take(counts.entry(kind).or_default()).merged(&Count::of(index, &setting, &trace));
        counts.insert(kind, count);
        counts
    };
    (0..frames).into_par_iter().fold(Counts::new, one).reduce(Counts::new, |one, other| merged(one, &other))
}

/// Runs a pipeline as it is configured by default: the `epuck` camera, landmarks of the default dimensions.
///
/// # Panics
/// Never: the port holds camera and landmarks.
#[must_use]
pub fn run_pipeline(pipeline: Pipeline, kinds: &[Kind], frames: u64, seed: u64) -> Counts {
    let camera = Camera::epuck();
    let cameras = Cameras::new(camera).expect("the port holds the e-puck's camera");
    let rule = CrossingRule::default();
    let setting = |formats: &[Format]| {
        let landmarks = Landmarks::new(formats).expect("the port holds the default stripe width");
        Setting { cameras, landmarks, rule }
    };
    run(kinds, frames, seed, &camera, |formats, [upper, lower]| {
        let setting = setting(formats);
        let trace = match pipeline {
            Pipeline::Reference => setting.run_reference(upper, lower),
            Pipeline::Fixedpoint => setting.run_fixedpoint(upper, lower),
        };
        (setting, trace)
    })
}

/// All kinds together.
#[must_use]
pub fn total(counts: &Counts) -> Count {
    counts.values().fold(Count::default(), Count::merged)
}

/// Counts by kind and of all together as a person reads them.
#[must_use]
pub fn table(counts: &Counts) -> String {
    let total = total(counts);
    let refusals: Vec<&String> = total.refused.keys().collect();
    let mut table = Table::new();
    let header = ["kind", "frames", "layers", "pairs"].into_iter().chain(refusals.iter().map(|name| name.as_str()));
    table.load_preset(presets::NOTHING).set_header(header.chain([
        "threshold before CRC",
        "trellis before CRC",
        "accepted",
        "first",
    ]));
    for (name, count) in counts.iter().map(|(kind, count)| (kind.name(), count)).chain([("all", &total)]) {
        let refused = refusals.iter().map(|&refusal| count.refused.get(refusal).copied().unwrap_or(0));
        let numbers = [count.frames, count.layers, count.pairs()].into_iter().chain(refused);
        let numbers = numbers.chain(count.before_crc).chain([count.accepted]).map(|number| number.to_string());
        let first = count.first_accepted.filter(|_| name != "all").map(|index| index.to_string());
        table.add_row([name.to_owned()].into_iter().chain(numbers).chain([first.unwrap_or_default()]));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::ThreadPoolBuilder;

    #[test]
    fn counts_do_not_depend_on_the_threads() {
        let counts = [1, 2, 5].map(|threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run_pipeline(Pipeline::Reference, &[Kind::MixedLayers, Kind::Text], 4001, 5))
        });
        assert_eq!(counts[0], counts[1]);
        assert_eq!(counts[0], counts[2]);
        let frames: Vec<u64> = counts[0].values().map(|count| count.frames).collect();
        assert_eq!(frames, [2000, 2001]);
    }

    /// Landmarks that are looked for are found, so that a count of nothing means something; in the format that is not
    /// theirs they are not looked for. Frame 7 of 3 kinds is the second kind's third.
    #[test]
    fn what_is_detected_is_counted() {
        let camera = Camera::epuck();
        let cameras = Cameras::new(camera).unwrap();
        let setting = Setting { cameras, landmarks: Landmarks::both(), rule: CrossingRule::default() };
        let counts = run(&[Kind::WideForPaper, Kind::PaperForWide], 400, 1, &camera, |_, [upper, lower]| {
            (setting.clone(), setting.run_reference(upper, lower))
        });
        for count in counts.values() {
            assert!(count.accepted > 50 && count.passed >= count.accepted, "{count:?}");
            assert!(count.first_accepted.is_some_and(|first| first < 10));
        }
        // As mixed layers reach the check byte, it refuses all but one in 256 of them.
        let mixed = run(&[Kind::MixedLayers], 400, 1, &camera, |_, [upper, lower]| {
            (setting.clone(), setting.run_reference(upper, lower))
        });
        let mixed = total(&mixed);
        assert!(mixed.before_crc[0] > 100 && mixed.refused["Crc"] >= mixed.before_crc[0] - mixed.accepted);
        assert!(mixed.passed < 10);
    }
}
