//! Both layers together: code word, payload, one homography (MERGE).

use crate::codeword;
use crate::decode::DecodedLayer;
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::landmark::Format;
use crate::refusal::PairRefusal;

/// Largest difference in pixels between the ends of two layers of one barcode (MERGE-1).
pub const MERGE_DISTANCE: usize = 3;

/// A landmark that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Its format.
    pub format: Format,
    /// Its payload.
    pub payload: u32,
    /// The upper layer.
    pub upper: DecodedLayer,
    /// The lower layer.
    pub lower: DecodedLayer,
    /// The merged homography (MERGE-4).
    pub homography: Homography,
    /// The camera's pose in the landmark's frame.
    pub camera_in_landmark: Pose<frame::Landmark, frame::Camera>,
}

/// MERGE-1
#[must_use]
pub fn pairs(upper: &DecodedLayer, lower: &DecodedLayer) -> bool {
    let (u, l) = (&upper.hypothesis, &lower.hypothesis);
    u.first_pixel.abs_diff(l.first_pixel) <= MERGE_DISTANCE && u.last_pixel.abs_diff(l.last_pixel) <= MERGE_DISTANCE
}

/// The payload of a pair and its merged homography (MERGE-2 to MERGE-4).
pub fn merge(format: Format, upper: &DecodedLayer, lower: &DecodedLayer) -> Result<(u32, Homography), PairRefusal> {
    let payload = codeword::decode(format, upper.half_word, lower.half_word)?;
    Ok((payload, upper.homography.mean(&lower.homography)))
}

/// Whether two detections read the same place as different formats (MERGE-7).
#[must_use]
pub fn contradict(one: &Detection, other: &Detection) -> bool {
    let (a, b) = (&one.upper.hypothesis, &other.upper.hypothesis);
    one.format != other.format && a.first_pixel <= b.last_pixel && b.first_pixel <= a.last_pixel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::Hypothesis;

    fn layer(first_pixel: usize, last_pixel: usize, half_word: u32) -> DecodedLayer {
        let hypothesis = Hypothesis { first_region: 1, last_region: 9, first_pixel, last_pixel };
        DecodedLayer { hypothesis, half_word, homography: Homography { a: 1.0, s: 20.0, k: 0.1 } }
    }

    #[test]
    fn both_ends_must_be_within_three_pixels() {
        let upper = layer(100, 160, 0);
        assert!(pairs(&upper, &layer(103, 157, 0)) && pairs(&upper, &layer(97, 163, 0)));
        assert!(!pairs(&upper, &layer(104, 160, 0)) && !pairs(&upper, &layer(100, 156, 0)));
    }

    #[test]
    fn a_pair_gives_payload_and_mean_homography() {
        let (upper, lower) = codeword::encode(Format::Paper, 0xcc0d).unwrap();
        let mut second = layer(100, 160, lower);
        second.homography = Homography { a: 2.0, s: 22.0, k: 0.2 };
        let (payload, merged) = merge(Format::Paper, &layer(100, 160, upper), &second).unwrap();
        assert_eq!((payload, merged.a, merged.s), (0xcc0d, 1.5, 21.0));
        assert!((merged.k - 0.15).abs() < 1e-15);
        let wrong = merge(Format::Paper, &layer(100, 160, upper ^ 1), &second);
        assert_eq!(wrong, Err(PairRefusal::Crc));
    }
}
