//! Observers: every stage reports its result to one, so that no second, instrumented pipeline exists.

use crate::accept::Test;
use crate::crossing::Crossing;
use crate::decode::DecodedLayer;
use crate::extents::Pair;
use crate::filter::Outcome;
use crate::fit::Fitted;
use crate::homography::Homography;
use crate::hypotheses::Hypothesis;
use crate::landmark::Format;
use crate::merge::{Decoder, Detection, Reading};
use crate::refusal::{CandidateRefusal, FitRefusal, HypothesisRefusal, LineRefusal, PairRefusal};
use crate::regions::Region;
use crate::sampling::{Residual, Sample};
use crate::skew::Skew;
use crate::threshold::{Threshold, Thresholding};
use crate::timeline::{Observation, Untimely};

/// One of the two scan lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// The upper layer, read by the upper scan line.
    Upper,
    /// The lower layer, read by the lower scan line.
    Lower,
}

/// Hears every stage's result, in the order in which the stages run. Methods that are not overridden cost nothing.
#[expect(unused_variables, reason = "the empty default methods name their arguments for the reader")]
pub trait Observer {
    /// A line's global threshold.
    fn threshold(&mut self, layer: Layer, threshold: &Threshold) {}
    /// A line's regions by one of its thresholds.
    fn regions(&mut self, layer: Layer, thresholding: Thresholding, regions: &[Region]) {}
    /// A line gives nothing (`Width`, `LowContrast`, with `Global`), no ROIs by the given threshold (`TooManyRegions`), or
    /// no layers of the format that is being searched, by the given threshold at the ninth (`TooManyLayers`).
    fn line_refused(&mut self, layer: Layer, thresholding: Thresholding, refusal: LineRefusal) {}
    /// An ROI, before its checks.
    fn hypothesis(&mut self, layer: Layer, thresholding: Thresholding, format: Format, hypothesis: &Hypothesis) {}
    /// A transition that enters the ROI's homography.
    fn crossing(&mut self, crossing: &Crossing) {}
    /// The ROI's homography relative to its middle, before HOMOG-3.
    fn homography(&mut self, homography: &Homography) {}
    /// A sampled stripe of the ROI.
    fn sample(&mut self, sample: &Sample) {}
    /// How the ROI's transitions fit the format.
    fn residual(&mut self, residual: &Residual) {}
    /// The ROI is refused.
    fn refused(&mut self, refusal: HypothesisRefusal) {}
    /// The ROI is decoded.
    fn decoded(&mut self, layer: &DecodedLayer) {}
    /// A pair of half words and its payload.
    fn pair(
        &mut self,
        format: Format,
        decoder: Decoder,
        upper: &Reading,
        lower: &Reading,
        result: Result<u32, PairRefusal>,
    ) {
    }
    /// A pair of extents that is tried.
    fn extents(&mut self, format: Format, pair: &Pair) {}
    /// The result of a fit.
    fn fitted(&mut self, result: Result<&Fitted, FitRefusal>) {}
    /// Tests of a candidate, in the order in which they are asked, whether they hold or not.
    fn tested(&mut self, tests: &[Test]) {}
    /// A candidate that is no detection.
    fn candidate_refused(&mut self, format: Format, decoder: Decoder, refusal: CandidateRefusal) {}
    /// A result of the detector.
    fn detection(&mut self, detection: &Detection) {}
    /// A detection that MERGE-7 withdraws.
    fn ambiguous(&mut self, detection: &Detection) {}
    /// How the camera moved while an image was exposed.
    fn skew(&mut self, skew: &Skew) {}
    /// A detection of which the site knows no pose.
    fn unknown(&mut self, detection: &Detection) {}
    /// What became of an observation of an image.
    fn observed(&mut self, observation: &Observation, result: Result<Option<Outcome>, Untimely>) {}
}

/// An observer that hears nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}
