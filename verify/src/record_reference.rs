//! Records what the reference does.

use crate::sensitivity::Sensitivity;
use crate::trace::{
    DetectionFit, DetectionTrace, FitTrace, HomographyTrace, LightTrace, Outcome, PairTrace, PoseTrace, RegionsTrace,
    ResidualTrace, SampleTrace, Trace,
};
use reference::accept::{AcceptedFit, Test};
use reference::crossing::Crossing;
use reference::decode::DecodedLayer;
use reference::extents::Pair;
use reference::fit::{Fitted, LayerLight};
use reference::homography::Homography;
use reference::hypotheses::Hypothesis;
use reference::landmark::Format;
use reference::merge::{Decoder, Detection, Reading};
use reference::observer::{Layer, Observer};
use reference::refusal::{CandidateRefusal, FitRefusal, HypothesisRefusal, LineRefusal, PairRefusal};
use reference::regions::{Colour, Region};
use reference::sampling::{Residual, Sample};
use reference::threshold::{Threshold, Thresholding};

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
        decoder: detection.decoder,
        pixels: [&detection.upper, &detection.lower].map(pixels),
        half_words: (detection.upper.half_word, detection.lower.half_word),
        homography: homography_trace(&detection.homography),
        fit: detection.fit.as_ref().map(detection_fit),
        pose: PoseTrace { x: pose.x(), y: pose.y(), theta: pose.theta() },
        covariance: detection.covariance,
    }
}

fn pixels(reading: &Reading) -> (usize, usize) {
    (reading.first_pixel, reading.last_pixel)
}

fn detection_fit(AcceptedFit { fitted, margin }: &AcceptedFit) -> DetectionFit {
    fit_trace(fitted).with_margin(*margin)
}

fn fit_trace(fitted: &Fitted) -> FitTrace {
    let light = |layer: usize| fitted.lights.get(layer).map(light_trace).unwrap_or_default();
    FitTrace {
        homography: homography_trace(&fitted.imaging.homography),
        blur: fitted.imaging.blur,
        blur_deviation: fitted.blur_variance.sqrt(),
        variance: fitted.variance,
        covariance: fitted.covariance,
        degrees_of_freedom: fitted.degrees_of_freedom as f64,
        steps: fitted.steps,
        last_decrease: fitted.last_decrease,
        lights: [light(0), light(1)],
        step_slack: fitted.step_slack,
        sensitivity: Sensitivity::default(),
    }
}

fn light_trace(light: &LayerLight) -> LightTrace {
    let LayerLight { offset, gain, offset_slope, gain_slope, step } = *light;
    LightTrace { levels: [offset, gain, offset_slope, gain_slope], step }
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

    fn regions(&mut self, layer: Layer, thresholding: Thresholding, regions: &[Region]) {
        let first_is_black = regions.first().is_some_and(|region| region.colour == Colour::Black);
        let firsts = regions.iter().map(first_pixel).collect();
        self.trace.line(layer).regions.push(RegionsTrace { thresholding, first_is_black, firsts });
    }

    fn line_refused(&mut self, layer: Layer, thresholding: Thresholding, refusal: LineRefusal) {
        self.trace.refuse_line(layer, thresholding, refusal);
    }

    fn hypothesis(&mut self, layer: Layer, thresholding: Thresholding, format: Format, hypothesis: &Hypothesis) {
        let Hypothesis { first_region, last_region, first_pixel, last_pixel } = *hypothesis;
        self.trace.begin(layer, thresholding, format, (first_region, last_region), (first_pixel, last_pixel));
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

    fn pair(
        &mut self,
        format: Format,
        decoder: Decoder,
        upper: &Reading,
        lower: &Reading,
        result: Result<u32, PairRefusal>,
    ) {
        let first_pixels = (upper.first_pixel, lower.first_pixel);
        self.trace.read(PairTrace { format, decoder, first_pixels, result }, [upper, lower].map(pixels));
    }

    fn extents(&mut self, format: Format, pair: &Pair) {
        self.trace.begin_trial(format, Decoder::Trellis, pair.map(|extent| (extent.first, extent.last)));
    }

    fn fitted(&mut self, result: Result<&Fitted, FitRefusal>) {
        self.trace.trial(|trial| trial.fits.push(result.map(fit_trace)));
    }

    fn tested(&mut self, tests: &[Test]) {
        self.trace.trial(|trial| trial.tests.extend_from_slice(tests));
    }

    fn candidate_refused(&mut self, _: Format, decoder: Decoder, refusal: CandidateRefusal) {
        self.trace.trial(|trial| trial.refusal = Some((decoder, refusal)));
    }

    fn detection(&mut self, detection: &Detection) {
        self.trace.detections.push(detection_trace(detection));
    }

    fn ambiguous(&mut self, detection: &Detection) {
        self.trace.ambiguous.push((detection.format, detection.payload));
    }
}
