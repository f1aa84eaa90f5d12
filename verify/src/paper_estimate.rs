//! The paper's estimate of a pose from a trace, whatever the detector made of the same pair afterwards.

use crate::trace::{HypothesisTrace, Outcome, Trace};
use nalgebra::Matrix3;
use reference::camera::Camera;
use reference::covariance::paper;
use reference::frame::{self, Pose};
use reference::homography::Homography;
use reference::landmark::{Format, Landmark};
use reference::merge::Decoder;
use reference::observer::Layer;
use reference::pose::pose;

/// A pair of layers that the threshold decoder read, with the pose of its merged homography (MERGE-4, POSE).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperEstimate {
    /// Its format.
    pub format: Format,
    /// Its payload.
    pub payload: u32,
    /// The mean of both layers' homographies.
    pub homography: Homography,
    /// The camera in the landmark's frame.
    pub camera_in_landmark: Pose<frame::Landmark, frame::Camera>,
    /// (11), (12) and the heading (COV-5).
    pub covariance: Matrix3<f64>,
}

/// All pairs of a trace with a payload, in their order.
#[must_use]
pub fn paper_estimates(trace: &Trace, camera: &Camera, landmarks: &[Landmark]) -> Vec<PaperEstimate> {
    let read = trace.pairs.iter().filter(|pair| pair.decoder == Decoder::Threshold);
    read.filter_map(|pair| {
        let landmark = landmarks.iter().find(|landmark| landmark.format == pair.format)?;
        let upper = layer(trace, Layer::Upper, pair.format, pair.first_pixels.0)?;
        let homography = upper.mean(&layer(trace, Layer::Lower, pair.format, pair.first_pixels.1)?);
        let camera_in_landmark = pose(&homography, camera, landmark);
        let covariance = paper(&camera_in_landmark, camera);
        let payload = pair.result.ok()?;
        Some(PaperEstimate { format: pair.format, payload, homography, camera_in_landmark, covariance })
    })
    .collect()
}

/// The homography of the decoded layer that begins at a pixel; ROIs of one line and format that are decoded share none.
fn layer(trace: &Trace, layer: Layer, format: Format, first_pixel: usize) -> Option<Homography> {
    let at = |roi: &&HypothesisTrace| roi.layer == layer && roi.format == format && roi.pixels.0 == first_pixel;
    trace.hypotheses.iter().filter(at).find_map(|roi| match &roi.outcome {
        Outcome::Decoded { homography, .. } => Some(Homography { a: homography.a, s: homography.s, k: homography.k }),
        _ => None,
    })
}
