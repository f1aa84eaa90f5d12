//! The observer: every stage reports its result to it, and it costs nothing where it does not listen.

use crate::crossing::Crossing;
use crate::decode::DecodedLayer;
use crate::extents::Extent;
use crate::filter::Outcome;
use crate::fit::Fitted;
use crate::hypotheses::Hypothesis;
use crate::landmark::Format;
use crate::merge::{Decoder, Detection, Reading};
use crate::refusal::{CandidateRefusal, FitRefusal, HypothesisRefusal, LineRefusal, PairRefusal, Untimely};
use crate::regions::Regions;
use crate::sampling::{Residual, Sample};
use crate::skew::Skew;
use crate::threshold::{Threshold, Thresholding};
use crate::timeline::Observation;

/// One of the two scan lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The upper layer's.
    Upper,
    /// The lower layer's.
    Lower,
}

/// What happens in [`crate::detect::detect`], in this order (`LINE-5`): for each line, the upper one first, its global
/// threshold, or why it was refused; then, by its global threshold and after that by its local one, its regions, or why
/// there are none, and for each format the hypotheses, each with its crossings and samples and its end. When both lines
/// are searched, for each format the pairs of layers and then the pairs of extents, and in the end the detections.
///
/// A pair of layers is reported and, if it has a payload, its fits; a pair of extents before it is tried, then its fits and,
/// when its half words have settled, what they say; a pair of layers that is decided again (`TRELLIS-9`) likewise, after the
/// refusal of its code word. A candidate of either that is refused says why after that. Of a moving camera the fits of the upper layer
/// come before those of the lower one (`SKEW-7`), and there are no pairs of extents and nothing is decided again (`SKEW-9`).
///
/// [`crate::localizer::Localizer::image`] reports the skew before, and after it the detections that it has no place for, in their
/// order, and the observations, in that of their times.
pub trait Observer {
    /// A line's global threshold.
    fn threshold(&mut self, _layer: Layer, _threshold: &Threshold) {}

    /// A line's regions by one of its thresholds.
    fn regions(&mut self, _layer: Layer, _thresholding: Thresholding, _regions: &Regions) {}

    /// A line was refused; for `TooManyRegions` by this threshold only, and for `TooManyLayers` its layers of one format
    /// by both, of which the last one was found by this. `Width` and `LowContrast` come with the global one.
    fn line_refused(&mut self, _layer: Layer, _thresholding: Thresholding, _refusal: LineRefusal) {}

    /// An ROI of the regions by this threshold, before its checks.
    fn hypothesis(&mut self, _layer: Layer, _thresholding: Thresholding, _format: Format, _hypothesis: &Hypothesis) {}

    /// A transition that enters the ROI's homography.
    fn crossing(&mut self, _crossing: &Crossing) {}

    /// A stripe that was sampled.
    fn sample(&mut self, _sample: &Sample) {}

    /// How well the ROI's transitions fit the format, before `SAMPLE-10` decides.
    fn residual(&mut self, _residual: &Residual) {}

    /// The ROI was refused.
    fn refused(&mut self, _refusal: HypothesisRefusal) {}

    /// The ROI was decoded.
    fn decoded(&mut self, _layer: &DecodedLayer) {}

    /// A pair of extents is about to be tried.
    fn extents(&mut self, _format: Format, _upper: Extent, _lower: Extent) {}

    /// Two layers were paired, or the half words of a pair of extents have settled: their payload or why they are none.
    fn pair(
        &mut self,
        _format: Format,
        _decoder: Decoder,
        _upper: &Reading,
        _lower: &Reading,
        _result: Result<u32, PairRefusal>,
    ) {
    }

    /// Both layers were fitted with their half words (`FIT`), but for the guard fit of `TRELLIS-1`, which is not reported.
    fn fitted(&mut self, _fit: Result<&Fitted, FitRefusal>) {}

    /// A pair with a payload, or a pair of extents without one, does not become a detection.
    fn candidate_refused(&mut self, _format: Format, _decoder: Decoder, _refusal: CandidateRefusal) {}

    /// A detection, in the order of `MERGE-8`.
    fn detection(&mut self, _detection: &Detection) {}

    /// A pair that `MERGE-7` refused, in the same order.
    fn ambiguous(&mut self, _detection: &Detection) {}

    /// How the camera moved between both rows (`LOCATE-6`).
    fn skew(&mut self, _skew: &Skew) {}

    /// The site knows no pose of a detection (`LOCATE-2`).
    fn unknown(&mut self, _detection: &Detection) {}

    /// An observation was given to the timeline: what became of it, nothing yet if it waits for its reading (`TIME-4`).
    fn observed(&mut self, _observation: &Observation, _outcome: Result<Option<Outcome>, Untimely>) {}
}

/// The observer that does not listen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}
