//! Records what the port does.

use crate::sensitivity::Sensitivity;
use crate::trace::{
    DetectionFit, DetectionTrace, FitTrace, HomographyTrace, LightTrace, Outcome, PairTrace, PoseTrace, RegionsTrace,
    ResidualTrace, SampleTrace, Trace,
};
use core::f64::consts::PI;
use fixedpoint::covariance::{Covariance, PoseCovariance};
use fixedpoint::crossing::Crossing;
use fixedpoint::decode::DecodedLayer;
use fixedpoint::extents::Extent;
use fixedpoint::fit::{Fitted, LayerLight};
use fixedpoint::formats::Angle;
use fixedpoint::homography::Homography;
use fixedpoint::hypotheses::Hypothesis;
use fixedpoint::merge::{Detection, FitSummary, Reading};
use fixedpoint::observer::Observer;
use fixedpoint::regions::{Colour, Regions};
use fixedpoint::sampling::{Residual, Sample};
use fixedpoint::threshold::{Threshold, Thresholding as PortThresholding};
use nalgebra::Matrix3;
use reference::landmark::Format;
use reference::merge::Decoder;
use reference::observer::Layer;
use reference::refusal::{CandidateRefusal, FitRefusal, HypothesisRefusal, LineRefusal, PairRefusal};
use reference::threshold::Thresholding;

/// Observer of the port.
#[derive(Clone, Debug, Default)]
pub struct RecordFixedpoint {
    /// What was recorded.
    pub trace: Trace,
}

/// A detection of the port in the form of a trace; what it does not keep of its fit is in the `trace` of its making.
#[must_use]
pub fn detection_trace(detection: &Detection, trace: &Trace) -> DetectionTrace {
    let pose = &detection.camera_in_landmark;
    DetectionTrace {
        format: format(detection.format),
        payload: detection.payload,
        decoder: decoder(detection.decoder),
        pixels: [&detection.upper, &detection.lower].map(ends),
        half_words: (u32::from(detection.upper.half_word), u32::from(detection.lower.half_word)),
        homography: homography_trace(&detection.homography),
        fit: detection.fit.map(|fit| detection_fit(&fit, &homography_trace(&detection.homography), trace)),
        pose: PoseTrace { x: pose.x.to_num(), y: pose.y.to_num(), theta: radians(pose.theta) },
        covariance: pose_covariance(&detection.covariance),
    }
}

fn ends(reading: &Reading) -> (usize, usize) {
    (usize::from(reading.first_pixel), usize::from(reading.last_pixel))
}

fn detection_fit(summary: &FitSummary, homography: &HomographyTrace, trace: &Trace) -> DetectionFit {
    let blur = summary.blur.to_num();
    let fit = trace.fit(homography, blur);
    DetectionFit {
        blur,
        variance: variance(summary.variance),
        covariance: covariance(&summary.covariance),
        margin: f64::from(summary.margin) / 256.0,
        blur_deviation: 0.0,
        // Without the fit nothing equals it.
        degrees_of_freedom: fit.map_or(f64::NAN, |fit| fit.degrees_of_freedom),
        steps: fit.map_or(0, |fit| fit.steps),
        lights: fit.map(|fit| fit.lights).unwrap_or_default(),
        sensitivity: Sensitivity::default(),
    }
}

fn fit_trace(fitted: &Fitted) -> FitTrace {
    let light = |layer: usize| fitted.lights.get(layer).map(light_trace).unwrap_or_default();
    FitTrace {
        homography: homography_trace(&fitted.homography),
        blur: fitted.blur.to_num(),
        blur_deviation: 0.0,
        variance: variance(fitted.variance),
        covariance: covariance(&fitted.covariance),
        degrees_of_freedom: f64::from(fitted.degrees_of_freedom),
        steps: usize::from(fitted.steps),
        last_decrease: 0.0,
        lights: [light(0), light(1)],
        step_slack: f64::INFINITY,
        sensitivity: Sensitivity::default(),
    }
}

fn light_trace(light: &LayerLight) -> LightTrace {
    let LayerLight { offset, gain, offset_slope, gain_slope, step } = *light;
    let levels = [offset, gain, offset_slope, gain_slope].map(|level| f64::from(level) / 256.0);
    LightTrace { levels, step: step.map(usize::from) }
}

/// Of 16 fraction bits.
fn variance(bits: u32) -> f64 {
    f64::from(bits) / 65536.0
}

fn symmetric([xx, xy, xz, yy, yz, zz]: [i64; 6], fraction_bits: i32) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).map(|bits| bits as f64 / 2.0_f64.powi(fraction_bits))
}

fn covariance(of: &Covariance) -> Matrix3<f64> {
    symmetric([of.aa, of.as_, of.ak, of.ss, of.sk, of.kk], 50)
}

fn pose_covariance(of: &PoseCovariance) -> Matrix3<f64> {
    symmetric([of.xx, of.xy, of.xt, of.yy, of.yt, of.tt], 48)
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

fn thresholding(thresholding: PortThresholding) -> Thresholding {
    match thresholding {
        PortThresholding::Global => Thresholding::Global,
        PortThresholding::Local => Thresholding::Local,
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
        Port::Repeated => HypothesisRefusal::Repeated,
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

fn decoder(decoder: fixedpoint::merge::Decoder) -> Decoder {
    match decoder {
        fixedpoint::merge::Decoder::Threshold => Decoder::Threshold,
        fixedpoint::merge::Decoder::Trellis => Decoder::Trellis,
    }
}

fn pair_refusal(refusal: fixedpoint::refusal::PairRefusal) -> PairRefusal {
    use fixedpoint::refusal::PairRefusal as Port;
    match refusal {
        Port::EqualHalves => PairRefusal::EqualHalves,
        Port::Crc => PairRefusal::Crc,
    }
}

fn fit_refusal(refusal: fixedpoint::refusal::FitRefusal) -> FitRefusal {
    use fixedpoint::refusal::FitRefusal as Port;
    match refusal {
        Port::TooFewPixels => FitRefusal::TooFewPixels,
        Port::NotConverged => FitRefusal::NotConverged,
    }
}

fn candidate_refusal(refusal: fixedpoint::refusal::CandidateRefusal) -> CandidateRefusal {
    use fixedpoint::refusal::CandidateRefusal as Port;
    match refusal {
        Port::Unsettled => CandidateRefusal::Unsettled,
        Port::NoFit => CandidateRefusal::NoFit,
        Port::Disagree => CandidateRefusal::Disagree,
        Port::Oblique => CandidateRefusal::Oblique,
        Port::Contrast => CandidateRefusal::Contrast,
        Port::Blur => CandidateRefusal::Blur,
        Port::Misfit => CandidateRefusal::Misfit,
        Port::Correlated => CandidateRefusal::Correlated,
        Port::QuietZone => CandidateRefusal::QuietZone,
        Port::Margin => CandidateRefusal::Margin,
        Port::Undetermined => CandidateRefusal::Undetermined,
        Port::TooMany => CandidateRefusal::TooMany,
    }
}

impl Observer for RecordFixedpoint {
    fn threshold(&mut self, line: fixedpoint::observer::Layer, threshold: &Threshold) {
        self.trace.line(layer(line)).threshold = Some((threshold.darkest, threshold.brightest));
    }

    fn regions(&mut self, line: fixedpoint::observer::Layer, by: PortThresholding, regions: &Regions) {
        let first_is_black = regions.colour(0) == Colour::Black;
        let firsts = (0..regions.len()).filter_map(|region| regions.first(region)).collect();
        let regions = RegionsTrace { thresholding: thresholding(by), first_is_black, firsts };
        self.trace.line(layer(line)).regions.push(regions);
    }

    fn line_refused(
        &mut self,
        line: fixedpoint::observer::Layer,
        by: PortThresholding,
        refusal: fixedpoint::refusal::LineRefusal,
    ) {
        self.trace.refuse_line(layer(line), thresholding(by), line_refusal(refusal));
    }

    fn hypothesis(
        &mut self,
        line: fixedpoint::observer::Layer,
        by: PortThresholding,
        searched: fixedpoint::landmark::Format,
        hypothesis: &Hypothesis,
    ) {
        let regions = (usize::from(hypothesis.first_region), usize::from(hypothesis.last_region));
        let pixels = (usize::from(hypothesis.first_pixel), usize::from(hypothesis.last_pixel));
        self.trace.begin(layer(line), thresholding(by), format(searched), regions, pixels);
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
        by: fixedpoint::merge::Decoder,
        upper: &Reading,
        lower: &Reading,
        result: Result<u32, fixedpoint::refusal::PairRefusal>,
    ) {
        let first_pixels = (usize::from(upper.first_pixel), usize::from(lower.first_pixel));
        let result = result.map_err(pair_refusal);
        let pair = PairTrace { format: format(searched), decoder: decoder(by), first_pixels, result };
        self.trace.read(pair, [upper, lower].map(ends));
    }

    fn extents(&mut self, searched: fixedpoint::landmark::Format, upper: Extent, lower: Extent) {
        let pixels = [upper, lower].map(|(first, last)| (usize::from(first), usize::from(last)));
        self.trace.begin_trial(format(searched), Decoder::Trellis, pixels);
    }

    fn fitted(&mut self, result: Result<&Fitted, fixedpoint::refusal::FitRefusal>) {
        self.trace.trial(|trial| trial.fits.push(result.map(fit_trace).map_err(fit_refusal)));
    }

    fn candidate_refused(
        &mut self,
        _: fixedpoint::landmark::Format,
        by: fixedpoint::merge::Decoder,
        refusal: fixedpoint::refusal::CandidateRefusal,
    ) {
        self.trace.trial(|trial| trial.refusal = Some((decoder(by), candidate_refusal(refusal))));
    }

    fn detection(&mut self, detection: &Detection) {
        let detection = detection_trace(detection, &self.trace);
        self.trace.detections.push(detection);
    }

    fn ambiguous(&mut self, detection: &Detection) {
        self.trace.ambiguous.push((format(detection.format), detection.payload));
    }
}
