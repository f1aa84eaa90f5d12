//! What a pipeline did with one frame, stage by stage, in numbers that can be compared.
//!
//! Both recorders fill this form from the observers of their pipeline. Enumerations are the reference's.

use crate::sensitivity::Sensitivity;
use nalgebra::Matrix3;
use reference::accept::Test;
use reference::landmark::Format;
use reference::merge::{Decoder, Estimator};
use reference::observer::Layer;
use reference::refusal::{CandidateRefusal, FitRefusal, HypothesisRefusal, LineRefusal, PairRefusal};
use reference::threshold::Thresholding;

/// Everything that a pipeline reported about one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Upper and lower scan line.
    pub lines: [LineTrace; 2],
    /// All ROIs in the order in which they were looked at.
    pub hypotheses: Vec<HypothesisTrace>,
    /// Lines refused during the search in a format (DECODE-2).
    pub crowded: Vec<(Layer, Thresholding, LineRefusal)>,
    /// All pairs of layers, and of extents whose half words have settled.
    pub pairs: Vec<PairTrace>,
    /// All pairs of layers and all pairs of extents that were tried, in their order.
    pub trials: Vec<TrialTrace>,
    /// Results.
    pub detections: Vec<DetectionTrace>,
    /// Detections withdrawn by MERGE-7.
    pub ambiguous: Vec<(Format, u32)>,
    /// Whether the observer heard of just the detections that the detector returned.
    pub heard_is_returned: bool,
}

impl Default for Trace {
    fn default() -> Self {
        Self {
            lines: Default::default(),
            hypotheses: Vec::new(),
            crowded: Vec::new(),
            pairs: Vec::new(),
            trials: Vec::new(),
            detections: Vec::new(),
            ambiguous: Vec::new(),
            heard_is_returned: true,
        }
    }
}

/// The first two stages on one line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineTrace {
    /// Its grey values.
    pub values: Vec<u8>,
    /// Darkest and brightest value.
    pub threshold: Option<(u8, u8)>,
    /// The regions by each threshold, in the order in which they were reported.
    pub regions: Vec<RegionsTrace>,
    /// Why there are none, by which threshold.
    pub refusals: Vec<(Thresholding, LineRefusal)>,
}

/// The regions of one line by one threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionsTrace {
    /// The threshold.
    pub thresholding: Thresholding,
    /// Whether the first region is black.
    pub first_is_black: bool,
    /// The first pixel of every region.
    pub firsts: Vec<u16>,
}

/// One ROI.
#[derive(Clone, Debug, PartialEq)]
pub struct HypothesisTrace {
    /// Its line.
    pub layer: Layer,
    /// The threshold by which it was found.
    pub thresholding: Thresholding,
    /// The format that was looked for.
    pub format: Format,
    /// Its first and last region.
    pub regions: (usize, usize),
    /// Its first and last pixel.
    pub pixels: (usize, usize),
    /// Edges `v` and columns `z` of the transitions used, ordered by edge.
    pub crossings: Vec<(i32, i32)>,
    /// Smallest margin of HOMOG-3; infinite where none is known (the port decides exactly).
    pub plausibility_margin: f64,
    /// Sampled stripes in order.
    pub samples: Vec<SampleTrace>,
    /// How the transitions fit the format, if it came to that.
    pub residual: Option<ResidualTrace>,
    /// How it ended.
    pub outcome: Outcome,
}

/// The test of SAMPLE-10.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualTrace {
    /// Largest difference between two like transitions, pixels.
    pub difference: f64,
    /// Distance from the limit, pixels; infinite where none is known.
    pub margin: f64,
}

/// One sampled stripe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleTrace {
    /// Which stripe, from the left.
    pub stripe: usize,
    /// The region it fell in.
    pub region: Option<usize>,
    /// Column of its middle relative to the ROI's middle, pixels.
    pub middle: f64,
    /// Distance from the nearest boundary that decides, pixels; infinite where none is known.
    pub margin: f64,
}

/// How an ROI ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Still open: the search in the line ended with it (DECODE-2).
    Open,
    /// Refused.
    Refused(HypothesisRefusal),
    /// Decoded.
    Decoded {
        /// The code bits.
        half_word: u32,
        /// The homography relative to the principal column.
        homography: HomographyTrace,
    },
}

/// A homography: pixels, pixels, dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomographyTrace {
    /// Centre.
    pub a: f64,
    /// Half width.
    pub s: f64,
    /// Obliquity.
    pub k: f64,
}

/// A pair of layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairTrace {
    /// Its format.
    pub format: Format,
    /// How it was read.
    pub decoder: Decoder,
    /// First pixels of both ROIs or extents.
    pub first_pixels: (usize, usize),
    /// Payload or refusal.
    pub result: Result<u32, PairRefusal>,
}

/// What became of a pair of layers, or of a pair of extents.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialTrace {
    /// Its format.
    pub format: Format,
    /// Whether it is a pair of layers, which the threshold has read, or one of extents.
    pub decoder: Decoder,
    /// First and last pixel of both ROIs or extents.
    pub pixels: [(usize, usize); 2],
    /// What was read, last by the trellis if it came to that: how, and the payload or why there is none.
    pub readings: Vec<(Decoder, Result<u32, PairRefusal>)>,
    /// The fits with all stripes.
    pub fits: Vec<Result<FitTrace, FitRefusal>>,
    /// What was asked of it; the port does not say.
    pub tests: Vec<Test>,
    /// Why there is no detection.
    pub refusal: Option<(Decoder, CandidateRefusal)>,
}

impl TrialTrace {
    /// The payload, and how it was read, if this became a detection.
    #[must_use]
    pub fn accepted(&self) -> Option<(Decoder, u32)> {
        match (self.refusal, self.readings.last()) {
            (None, Some(&(decoder, Ok(payload)))) => Some((decoder, payload)),
            _ => None,
        }
    }
}

/// A fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitTrace {
    /// Relative to the principal column.
    pub homography: HomographyTrace,
    /// Standard deviation of the blur, pixels.
    pub blur: f64,
    /// How well it is known, pixels; the port does not say and has 0.
    pub blur_deviation: f64,
    /// `s²`, squared grey levels.
    pub variance: f64,
    /// Covariance of `(a, s, k)`.
    pub covariance: Matrix3<f64>,
    /// `n - p`.
    pub degrees_of_freedom: f64,
    /// Steps taken.
    pub steps: usize,
    /// What the last one lowered the sum of squares by, as a share of FIT-11's limit; the port does not say and has 0.
    pub last_decrease: f64,
    /// The light of both layers.
    pub lights: [LightTrace; 2],
    /// How far the model of a pixel is from placing a step elsewhere, grey levels; infinite where none is known.
    pub step_slack: f64,
    /// What the rounding of a pixel does to it; the reference's fits that ACCEPT asks about have it.
    pub sensitivity: Sensitivity,
}

/// The light of a layer: grey levels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightTrace {
    /// `o`, `g`, `o'`, `g'`.
    pub levels: [f64; 4],
    /// Where it steps.
    pub step: Option<usize>,
}

impl FitTrace {
    /// What a detection says of it.
    #[must_use]
    pub fn with_margin(&self, margin: f64) -> DetectionFit {
        let Self { blur, blur_deviation, variance, covariance, degrees_of_freedom, steps, lights, .. } = *self;
        let sensitivity = self.sensitivity;
        DetectionFit {
            blur,
            variance,
            covariance,
            margin,
            blur_deviation,
            degrees_of_freedom,
            steps,
            lights,
            sensitivity,
        }
    }
}

/// What a detection says of its fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionFit {
    /// Standard deviation of the blur, pixels.
    pub blur: f64,
    /// `s²`, squared grey levels.
    pub variance: f64,
    /// Covariance of `(a, s, k)`.
    pub covariance: Matrix3<f64>,
    /// The decision margin, squared grey levels.
    pub margin: f64,
    /// Standard deviation of the blur, pixels; the port does not say and has 0.
    pub blur_deviation: f64,
    /// `n - p`, from the fit itself.
    pub degrees_of_freedom: f64,
    /// Steps taken, from the fit itself.
    pub steps: usize,
    /// The light of both layers, from the fit itself.
    pub lights: [LightTrace; 2],
    /// What the rounding of a pixel does to it, from the fit itself.
    pub sensitivity: Sensitivity,
}

/// A detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionTrace {
    /// Its format.
    pub format: Format,
    /// Its payload.
    pub payload: u32,
    /// How it was read.
    pub decoder: Decoder,
    /// First and last pixel of both ROIs or extents.
    pub pixels: [(usize, usize); 2],
    /// Half words of both layers.
    pub half_words: (u32, u32),
    /// The fitted homography, or the merged one.
    pub homography: HomographyTrace,
    /// The fit; none for the paper's estimate.
    pub fit: Option<DetectionFit>,
    /// The camera in the landmark's frame.
    pub pose: PoseTrace,
    /// The covariance of its pose: metres and radians, squared.
    pub covariance: Matrix3<f64>,
}

impl DetectionTrace {
    /// What its pose was computed from.
    #[must_use]
    pub fn estimator(&self) -> Estimator {
        if self.fit.is_some() { Estimator::Fit } else { Estimator::Paper }
    }
}

/// A pose: metres, metres, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseTrace {
    /// x in metres.
    pub x: f64,
    /// y in metres.
    pub y: f64,
    /// Heading in radians.
    pub theta: f64,
}

impl Trace {
    /// The line of a layer.
    pub fn line(&mut self, layer: Layer) -> &mut LineTrace {
        match layer {
            Layer::Upper => &mut self.lines[0],
            Layer::Lower => &mut self.lines[1],
        }
    }

    /// A line was refused: before its regions were known by THRESH or REGION, afterwards by DECODE-2.
    pub fn refuse_line(&mut self, layer: Layer, thresholding: Thresholding, refusal: LineRefusal) {
        if refusal == LineRefusal::TooManyLayers {
            self.crowded.push((layer, thresholding, refusal));
        } else {
            self.line(layer).refusals.push((thresholding, refusal));
        }
    }

    /// Begins an ROI.
    pub fn begin(
        &mut self,
        layer: Layer,
        thresholding: Thresholding,
        format: Format,
        regions: (usize, usize),
        pixels: (usize, usize),
    ) {
        self.hypotheses.push(HypothesisTrace {
            layer,
            thresholding,
            format,
            regions,
            pixels,
            crossings: Vec::new(),
            plausibility_margin: f64::INFINITY,
            samples: Vec::new(),
            residual: None,
            outcome: Outcome::Open,
        });
    }

    /// Notes something about the ROI that was begun last.
    pub fn current(&mut self, note: impl FnOnce(&mut HypothesisTrace)) {
        if let Some(hypothesis) = self.hypotheses.last_mut() {
            note(hypothesis);
        }
    }

    /// A pair was read: one of layers begins a trial, one by the trellis belongs to the one before it.
    pub fn read(&mut self, pair: PairTrace, pixels: [(usize, usize); 2]) {
        if pair.decoder == Decoder::Threshold {
            self.begin_trial(pair.format, pair.decoder, pixels);
        }
        self.trial(|trial| trial.readings.push((pair.decoder, pair.result)));
        self.pairs.push(pair);
    }

    /// Begins the trial of a pair of layers or of extents.
    pub fn begin_trial(&mut self, format: Format, decoder: Decoder, pixels: [(usize, usize); 2]) {
        self.trials.push(TrialTrace {
            format,
            decoder,
            pixels,
            readings: Vec::new(),
            fits: Vec::new(),
            tests: Vec::new(),
            refusal: None,
        });
    }

    /// Notes something about the trial that was begun last.
    pub fn trial(&mut self, note: impl FnOnce(&mut TrialTrace)) {
        if let Some(trial) = self.trials.last_mut() {
            note(trial);
        }
    }

    /// Keeps the scan lines, upper first.
    pub fn keep_lines(&mut self, upper: &[u8], lower: &[u8]) {
        for (line, values) in self.lines.iter_mut().zip([upper, lower]) {
            line.values = values.to_vec();
        }
    }

    /// The fit with this homography and blur.
    #[must_use]
    pub fn fit(&self, homography: &HomographyTrace, blur: f64) -> Option<&FitTrace> {
        let fits = self.trials.iter().flat_map(|trial| trial.fits.iter().flatten());
        fits.into_iter().find(|fit| fit.homography == *homography && fit.blur.to_bits() == blur.to_bits())
    }

    /// A transition of the ROI that was begun last. The order in which a pipeline adds them is its own affair.
    pub fn cross(&mut self, edge: i32, column: i32) {
        self.current(|hypothesis| {
            let place = hypothesis.crossings.partition_point(|before| *before < (edge, column));
            hypothesis.crossings.insert(place, (edge, column));
        });
    }

    /// Ends the ROI that was begun last.
    pub fn end(&mut self, outcome: Outcome) {
        self.current(|hypothesis| hypothesis.outcome = outcome);
    }
}
