//! Records what the reference does.

use crate::trace::{DetectionTrace, HomographyTrace, Outcome, PairTrace, PoseTrace, ResidualTrace, SampleTrace, Trace};
use reference::crossing::Crossing;
use reference::decode::DecodedLayer;
use reference::homography::Homography;
use reference::hypotheses::Hypothesis;
use reference::landmark::Format;
use reference::merge::Detection;
use reference::observer::{Layer, Observer};
use reference::refusal::{HypothesisRefusal, LineRefusal, PairRefusal};
use reference::regions::{Colour, Region};
use reference::sampling::{Residual, Sample};
use reference::threshold::Threshold;

/// Observer of the reference.
#[derive(Clone, Debug, Default)]
pub struct RecordReference {
    /// What was recorded.
    pub trace: Trace,
}

/// A detection of the reference in the form of a trace.
#[must_use]
pub fn detection_trace(detection: &Detection) -> DetectionTrace {
    let pose = &detection.camera_in_landmark;
    DetectionTrace {
        format: detection.format,
        payload: detection.payload,
        half_words: (detection.upper.half_word, detection.lower.half_word),
        homography: homography_trace(&detection.homography),
        pose: PoseTrace { x: pose.x(), y: pose.y(), theta: pose.theta() },
    }
}

fn homography_trace(homography: &Homography) -> HomographyTrace {
    HomographyTrace { a: homography.a, s: homography.s, k: homography.k }
}

/// Pixels are below 640.
#[expect(clippy::cast_possible_truncation, reason = "a line has at most 640 pixels")]
fn first_pixel(region: &Region) -> u16 {
    region.first as u16
}

impl Observer for RecordReference {
    fn threshold(&mut self, layer: Layer, threshold: &Threshold) {
        self.trace.line(layer).threshold = Some((threshold.darkest, threshold.brightest));
    }

    fn regions(&mut self, layer: Layer, regions: &[Region]) {
        let first_is_black = regions.first().is_some_and(|region| region.colour == Colour::Black);
        self.trace.line(layer).regions = Some((first_is_black, regions.iter().map(first_pixel).collect()));
    }

    fn line_refused(&mut self, layer: Layer, refusal: LineRefusal) {
        self.trace.refuse_line(layer, refusal);
    }

    fn hypothesis(&mut self, layer: Layer, format: Format, hypothesis: &Hypothesis) {
        let Hypothesis { first_region, last_region, first_pixel, last_pixel } = *hypothesis;
        self.trace.begin(layer, format, (first_region, last_region), (first_pixel, last_pixel));
    }

    fn crossing(&mut self, crossing: &Crossing) {
        self.trace.cross(crossing.edge, crossing.column);
    }

    fn homography(&mut self, homography: &Homography) {
        self.trace.current(|hypothesis| {
            hypothesis.plausibility_margin = hypothesis.plausibility_margin.min(homography.margin());
        });
    }

    fn sample(&mut self, sample: &Sample) {
        let Sample { stripe, region, middle, margin } = *sample;
        self.trace.current(|hypothesis| hypothesis.samples.push(SampleTrace { stripe, region, middle, margin }));
    }

    fn residual(&mut self, residual: &Residual) {
        let margin = (residual.difference - residual.limit).abs();
        let residual = ResidualTrace { difference: residual.difference, margin };
        self.trace.current(|hypothesis| hypothesis.residual = Some(residual));
    }

    fn refused(&mut self, refusal: HypothesisRefusal) {
        self.trace.end(Outcome::Refused(refusal));
    }

    fn decoded(&mut self, layer: &DecodedLayer) {
        let homography = homography_trace(&layer.homography);
        self.trace.end(Outcome::Decoded { half_word: layer.half_word, homography });
    }

    fn pair(&mut self, format: Format, upper: &DecodedLayer, lower: &DecodedLayer, result: Result<u32, PairRefusal>) {
        let first_pixels = (upper.hypothesis.first_pixel, lower.hypothesis.first_pixel);
        self.trace.pairs.push(PairTrace { format, first_pixels, result });
    }

    fn detection(&mut self, detection: &Detection) {
        self.trace.detections.push(detection_trace(detection));
    }

    fn ambiguous(&mut self, detection: &Detection) {
        self.trace.ambiguous.push((detection.format, detection.payload));
    }
}
