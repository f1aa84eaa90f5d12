//! The observer: every stage reports its result to it, and it costs nothing where it does not listen.

use crate::crossing::Crossing;
use crate::decode::DecodedLayer;
use crate::hypotheses::Hypothesis;
use crate::landmark::Format;
use crate::merge::Detection;
use crate::refusal::{HypothesisRefusal, LineRefusal, PairRefusal};
use crate::regions::Regions;
use crate::sampling::{Residual, Sample};
use crate::threshold::Threshold;

/// One of the two scan lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The upper layer's.
    Upper,
    /// The lower layer's.
    Lower,
}

/// What happens in [`crate::detect::detect`], in this order: for each line its threshold and its regions, or why it was
/// refused; then for each format and line the hypotheses, each with its crossings and samples and its end; then the
/// format's pairs; and when all formats are searched, the detections.
pub trait Observer {
    /// A line's threshold.
    fn threshold(&mut self, _layer: Layer, _threshold: &Threshold) {}

    /// A line's regions.
    fn regions(&mut self, _layer: Layer, _regions: &Regions) {}

    /// A line, or for `TooManyLayers` the layers of one format in it, was refused.
    fn line_refused(&mut self, _layer: Layer, _refusal: LineRefusal) {}

    /// An ROI, before its checks.
    fn hypothesis(&mut self, _layer: Layer, _format: Format, _hypothesis: &Hypothesis) {}

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

    /// Two layers were paired: their payload or why they are none.
    fn pair(
        &mut self,
        _format: Format,
        _upper: &DecodedLayer,
        _lower: &DecodedLayer,
        _result: Result<u32, PairRefusal>,
    ) {
    }

    /// A detection, in the order of `MERGE-8`.
    fn detection(&mut self, _detection: &Detection) {}

    /// A pair that `MERGE-7` refused, in the same order.
    fn ambiguous(&mut self, _detection: &Detection) {}
}

/// The observer that does not listen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}
