//! Records what the port does.

use crate::trace::{DetectionTrace, HomographyTrace, Outcome, PairTrace, PoseTrace, ResidualTrace, SampleTrace, Trace};
use core::f64::consts::PI;
use fixedpoint::crossing::Crossing;
use fixedpoint::decode::DecodedLayer;
use fixedpoint::formats::Angle;
use fixedpoint::homography::Homography;
use fixedpoint::hypotheses::Hypothesis;
use fixedpoint::merge::Detection;
use fixedpoint::observer::Observer;
use fixedpoint::regions::{Colour, Regions};
use fixedpoint::sampling::{Residual, Sample};
use fixedpoint::threshold::Threshold;
use reference::landmark::Format;
use reference::observer::Layer;
use reference::refusal::{HypothesisRefusal, LineRefusal, PairRefusal};

/// Observer of the port.
#[derive(Clone, Debug, Default)]
pub struct RecordFixedpoint {
    /// What was recorded.
    pub trace: Trace,
}

/// A detection of the port in the form of a trace.
#[must_use]
pub fn detection_trace(detection: &Detection) -> DetectionTrace {
    let pose = &detection.camera_in_landmark;
    DetectionTrace {
        format: format(detection.format),
        payload: detection.payload,
        half_words: (u32::from(detection.upper.half_word), u32::from(detection.lower.half_word)),
        homography: homography_trace(&detection.homography),
        pose: PoseTrace { x: pose.x.to_num(), y: pose.y.to_num(), theta: radians(pose.theta) },
    }
}

/// In (-π, π]: the format's smallest value stands for π.
fn radians(angle: Angle) -> f64 {
    if angle == Angle::PI { PI } else { f64::from(angle.to_bits()) * PI / (1_u64 << 31) as f64 }
}

fn homography_trace(homography: &Homography) -> HomographyTrace {
    HomographyTrace { a: homography.a.to_num(), s: homography.s.to_num(), k: homography.k.to_num() }
}

/// An exact ratio of the port, as near as float64 comes to it, in pixels.
#[expect(clippy::cast_precision_loss, reason = "2^-53 of a column is far below the declared error")]
fn pixels(numerator: i64, denominator: i64, subpixel_bits: u8) -> f64 {
    numerator as f64 / denominator as f64 / f64::from(1 << subpixel_bits)
}

fn layer(layer: fixedpoint::observer::Layer) -> Layer {
    match layer {
        fixedpoint::observer::Layer::Upper => Layer::Upper,
        fixedpoint::observer::Layer::Lower => Layer::Lower,
    }
}

fn format(format: fixedpoint::landmark::Format) -> Format {
    match format {
        fixedpoint::landmark::Format::Paper => Format::Paper,
        fixedpoint::landmark::Format::Wide => Format::Wide,
    }
}

fn line_refusal(refusal: fixedpoint::refusal::LineRefusal) -> LineRefusal {
    use fixedpoint::refusal::LineRefusal as Port;
    match refusal {
        Port::Width => LineRefusal::Width,
        Port::LowContrast => LineRefusal::LowContrast,
        Port::TooManyRegions => LineRefusal::TooManyRegions,
        Port::TooManyLayers => LineRefusal::TooManyLayers,
    }
}

fn hypothesis_refusal(refusal: fixedpoint::refusal::HypothesisRefusal) -> HypothesisRefusal {
    use fixedpoint::refusal::HypothesisRefusal as Port;
    match refusal {
        Port::TooFewBars => HypothesisRefusal::TooFewBars,
        Port::TooManyBars => HypothesisRefusal::TooManyBars,
        Port::CutOff => HypothesisRefusal::CutOff,
        Port::QuietZone => HypothesisRefusal::QuietZone,
        Port::TooNarrow => HypothesisRefusal::TooNarrow,
        Port::Implausible => HypothesisRefusal::Implausible,
        Port::Guard => HypothesisRefusal::Guard,
        Port::Transition => HypothesisRefusal::Transition,
        Port::Residual => HypothesisRefusal::Residual,
    }
}

fn pair_refusal(refusal: fixedpoint::refusal::PairRefusal) -> PairRefusal {
    use fixedpoint::refusal::PairRefusal as Port;
    match refusal {
        Port::EqualHalves => PairRefusal::EqualHalves,
        Port::Crc => PairRefusal::Crc,
    }
}

impl Observer for RecordFixedpoint {
    fn threshold(&mut self, line: fixedpoint::observer::Layer, threshold: &Threshold) {
        self.trace.line(layer(line)).threshold = Some((threshold.darkest, threshold.brightest));
    }

    fn regions(&mut self, line: fixedpoint::observer::Layer, regions: &Regions) {
        let first_is_black = regions.colour(0) == Colour::Black;
        let firsts = (0..regions.len()).filter_map(|region| regions.first(region)).collect();
        self.trace.line(layer(line)).regions = Some((first_is_black, firsts));
    }

    fn line_refused(&mut self, line: fixedpoint::observer::Layer, refusal: fixedpoint::refusal::LineRefusal) {
        self.trace.refuse_line(layer(line), line_refusal(refusal));
    }

    fn hypothesis(
        &mut self,
        line: fixedpoint::observer::Layer,
        searched: fixedpoint::landmark::Format,
        hypothesis: &Hypothesis,
    ) {
        let regions = (usize::from(hypothesis.first_region), usize::from(hypothesis.last_region));
        let pixels = (usize::from(hypothesis.first_pixel), usize::from(hypothesis.last_pixel));
        self.trace.begin(layer(line), format(searched), regions, pixels);
    }

    fn crossing(&mut self, crossing: &Crossing) {
        self.trace.cross(i32::from(crossing.edge), i32::from(crossing.column));
    }

    fn sample(&mut self, sample: &Sample) {
        let sample = SampleTrace {
            stripe: usize::from(sample.stripe),
            region: sample.region.map(usize::from),
            middle: pixels(sample.numerator, sample.denominator, sample.subpixel_bits),
            margin: f64::INFINITY,
        };
        self.trace.current(|hypothesis| hypothesis.samples.push(sample));
    }

    fn residual(&mut self, residual: &Residual) {
        let difference = pixels(residual.numerator, residual.denominator, residual.subpixel_bits);
        self.trace.current(|hypothesis| {
            hypothesis.residual = Some(ResidualTrace { difference, margin: f64::INFINITY });
        });
    }

    fn refused(&mut self, refusal: fixedpoint::refusal::HypothesisRefusal) {
        self.trace.end(Outcome::Refused(hypothesis_refusal(refusal)));
    }

    fn decoded(&mut self, layer: &DecodedLayer) {
        let homography = homography_trace(&layer.homography);
        self.trace.end(Outcome::Decoded { half_word: u32::from(layer.half_word), homography });
    }

    fn pair(
        &mut self,
        searched: fixedpoint::landmark::Format,
        upper: &DecodedLayer,
        lower: &DecodedLayer,
        result: Result<u32, fixedpoint::refusal::PairRefusal>,
    ) {
        let first_pixels = (usize::from(upper.hypothesis.first_pixel), usize::from(lower.hypothesis.first_pixel));
        let result = result.map_err(pair_refusal);
        self.trace.pairs.push(PairTrace { format: format(searched), first_pixels, result });
    }

    fn detection(&mut self, detection: &Detection) {
        self.trace.detections.push(detection_trace(detection));
    }

    fn ambiguous(&mut self, detection: &Detection) {
        self.trace.ambiguous.push((format(detection.format), detection.payload));
    }
}
