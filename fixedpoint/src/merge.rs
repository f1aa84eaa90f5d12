//! Merging the layers of both lines to detections.

use crate::camera::Camera;
use crate::codeword;
use crate::decode::{DecodedLayer, MAX_LAYERS};
use crate::formats::{Column, Obliquity};
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::hypotheses::Hypothesis;
use crate::landmark::{Format, Landmark};
use crate::observer::Observer;
use crate::pose::pose;
use heapless::Vec;

/// A landmark that was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detection {
    /// Its format.
    pub format: Format,
    /// What it says, 16 or 24 bits.
    pub payload: u32,
    /// The upper layer.
    pub upper: DecodedLayer,
    /// The lower layer.
    pub lower: DecodedLayer,
    /// The mean of both layers' homographies.
    pub homography: Homography,
    /// The pose that follows from it.
    pub camera_in_landmark: Pose<frame::Landmark, frame::Camera>,
}

/// The most detections: one for each upper layer of two formats.
///
/// An ROI that was decoded is at least 7 px wide, and ROIs of one format do not overlap, so the first pixels of two of
/// them differ by at least 8: at most one lower layer begins within 3 px of an upper one.
pub const MAX_DETECTIONS: usize = 2 * MAX_LAYERS;

/// Detections in the order of `MERGE-8`.
pub type Detections = Vec<Detection, MAX_DETECTIONS>;

/// Pairs the layers of one format and adds what they say to the detections (`MERGE-1` to `MERGE-6`).
///
/// Layers come in the order of their seeds. There is room for all pairs (see [`MAX_DETECTIONS`]) if `detections` has
/// none of this format yet; a pair without room would be left out, although reported to the observer.
pub fn merge<O: Observer>(
    upper: &[DecodedLayer],
    lower: &[DecodedLayer],
    camera: &Camera,
    landmark: &Landmark,
    detections: &mut Detections,
    observer: &mut O,
) {
    let format = landmark.format;
    for upper in upper {
        for lower in lower.iter().filter(|lower| belong_together(upper, lower)) {
            let payload = codeword::decode(format, upper.half_word, lower.half_word);
            observer.pair(format, upper, lower, payload);
            let Ok(payload) = payload else { continue };
            let homography = mean(&upper.homography, &lower.homography);
            let camera_in_landmark = pose(&homography, camera, landmark);
            let (upper, lower) = (*upper, *lower);
            let found = Detection { format, payload, upper, lower, homography, camera_in_landmark };
            detections.push(found).ok();
        }
    }
}

/// Whether both ends of the ROIs differ by at most 3 px (`MERGE-1`).
fn belong_together(upper: &DecodedLayer, lower: &DecodedLayer) -> bool {
    let (upper, lower) = (&upper.hypothesis, &lower.hypothesis);
    upper.first_pixel.abs_diff(lower.first_pixel) <= 3 && upper.last_pixel.abs_diff(lower.last_pixel) <= 3
}

/// The mean of two homographies (`MERGE-4`). Rounding errors: 2^-21 px for `a` and `s`, 2^-31 for `k`.
fn mean(upper: &Homography, lower: &Homography) -> Homography {
    let column = |upper: Column, lower: Column| Column::from_bits(halfway(upper.to_bits(), lower.to_bits()));
    Homography {
        a: column(upper.a, lower.a),
        s: column(upper.s, lower.s),
        k: Obliquity::from_bits(halfway(upper.k.to_bits(), lower.k.to_bits())),
    }
}

/// The mean of two integers, halves up, which always fits: `x + y = (x ^ y) + 2 (x & y)`.
fn halfway(x: i32, y: i32) -> i32 {
    let (odd, whole) = (x ^ y, x & y);
    whole + (odd >> 1) + (odd & 1)
}

/// Removes the detections of different formats whose upper ROIs share a pixel, all of them, and reports what was
/// removed and what is left (`MERGE-7`, `MERGE-8`).
pub fn withdraw_ambiguous<O: Observer>(detections: &mut Detections, observer: &mut O) {
    let mut ambiguous = [false; MAX_DETECTIONS];
    for (flag, detection) in ambiguous.iter_mut().zip(detections.iter()) {
        *flag = detections.iter().any(|other| contradict(detection, other));
    }
    let mut flags = ambiguous.into_iter();
    detections.retain(|detection| {
        let withdrawn = flags.next().unwrap_or(false);
        if withdrawn {
            observer.ambiguous(detection);
        } else {
            observer.detection(detection);
        }
        !withdrawn
    });
}

fn contradict(one: &Detection, other: &Detection) -> bool {
    let shares_a_pixel = |one: &Hypothesis, other: &Hypothesis| {
        one.first_pixel <= other.last_pixel && other.first_pixel <= one.last_pixel
    };
    one.format != other.format && shares_a_pixel(&one.upper.hypothesis, &other.upper.hypothesis)
}

#[cfg(test)]
mod tests;
