//! Both layers together: code word, payload, one homography (MERGE).

use crate::camera::Camera;
use crate::codeword;
use crate::decode::DecodedLayer;
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::landmark::{Format, Landmark};
use crate::observer::Observer;
use crate::pose::pose;

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
pub fn belong_together(upper: &DecodedLayer, lower: &DecodedLayer) -> bool {
    let (u, l) = (&upper.hypothesis, &lower.hypothesis);
    u.first_pixel.abs_diff(l.first_pixel) <= MERGE_DISTANCE && u.last_pixel.abs_diff(l.last_pixel) <= MERGE_DISTANCE
}

/// Pairs the layers of one format, which come in the order of their seeds (MERGE-6), and adds what they say to the
/// detections, in the order of the upper layers and then of the lower ones (MERGE-5).
pub fn merge<O: Observer>(
    upper: &[DecodedLayer],
    lower: &[DecodedLayer],
    camera: &Camera,
    landmark: &Landmark,
    detections: &mut Vec<Detection>,
    observer: &mut O,
) {
    let format = landmark.format;
    for upper in upper {
        for lower in lower.iter().filter(|lower| belong_together(upper, lower)) {
            // MERGE-2, MERGE-3
            let payload = codeword::decode(format, upper.half_word, lower.half_word);
            observer.pair(format, upper, lower, payload);
            let Ok(payload) = payload else { continue };
            // MERGE-4
            let homography = upper.homography.mean(&lower.homography);
            let camera_in_landmark = pose(&homography, camera, landmark);
            let (upper, lower) = (*upper, *lower);
            detections.push(Detection { format, payload, upper, lower, homography, camera_in_landmark });
        }
    }
}

/// What is left when the detections that contradict each other are withdrawn, all of them (MERGE-7, MERGE-8).
pub fn withdraw_ambiguous<O: Observer>(detections: &[Detection], observer: &mut O) -> Vec<Detection> {
    let mut kept = Vec::new();
    for detection in detections {
        if detections.iter().any(|other| contradict(detection, other)) {
            observer.ambiguous(detection);
        } else {
            observer.detection(detection);
            kept.push(*detection);
        }
    }
    kept
}

/// Whether two detections read the same place as different formats (MERGE-7).
fn contradict(one: &Detection, other: &Detection) -> bool {
    let (a, b) = (&one.upper.hypothesis, &other.upper.hypothesis);
    one.format != other.format && a.first_pixel <= b.last_pixel && b.first_pixel <= a.last_pixel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::Hypothesis;
    use crate::observer::Silent;

    fn layer(first_pixel: usize, last_pixel: usize, half_word: u32) -> DecodedLayer {
        let hypothesis = Hypothesis { first_region: 1, last_region: 9, first_pixel, last_pixel };
        DecodedLayer { hypothesis, half_word, homography: Homography { a: 1.0, s: 20.0, k: 0.1 } }
    }

    #[test]
    fn both_ends_must_be_within_three_pixels() {
        let upper = layer(100, 160, 0);
        assert!(belong_together(&upper, &layer(103, 157, 0)) && belong_together(&upper, &layer(97, 163, 0)));
        assert!(!belong_together(&upper, &layer(104, 160, 0)) && !belong_together(&upper, &layer(100, 156, 0)));
    }

    fn merged(upper: &DecodedLayer, lower: &DecodedLayer) -> Vec<Detection> {
        let mut found = Vec::new();
        let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
        merge(&[*upper], &[*lower], &camera, &landmark, &mut found, &mut Silent);
        found
    }

    #[test]
    fn a_pair_gives_payload_and_mean_homography() {
        let (upper, lower) = codeword::encode(Format::Paper, 0xcc0d).unwrap();
        let mut second = layer(100, 160, lower);
        second.homography = Homography { a: 2.0, s: 22.0, k: 0.2 };
        let found = merged(&layer(100, 160, upper), &second);
        let Homography { a, s, k } = found[0].homography;
        assert_eq!(found[0].payload, 0xcc0d);
        assert!((a - 1.5).abs() < 1e-15 && (s - 21.0).abs() < 1e-14 && (k - 0.15).abs() < 1e-15);
        assert!(merged(&layer(100, 160, upper ^ 1), &second).is_empty());
        assert!(merged(&layer(104, 160, upper), &second).is_empty());
    }

    /// A detection of a format whose upper and lower ROIs are at the given pixels.
    fn detection(format: Format, upper: (usize, usize), lower: (usize, usize)) -> Detection {
        Detection {
            format,
            payload: 1,
            upper: layer(upper.0, upper.1, 0),
            lower: layer(lower.0, lower.1, 0),
            homography: Homography { a: 1.0, s: 20.0, k: 0.1 },
            camera_in_landmark: Pose::new(0.3, 0.0, 0.0),
        }
    }

    #[test]
    fn formats_that_share_a_pixel_of_the_upper_line_withdraw_each_other() {
        let paper = |upper, lower| detection(Format::Paper, upper, lower);
        let wide = |upper, lower| detection(Format::Wide, upper, lower);
        let left = |both: [Detection; 2]| withdraw_ambiguous(&both, &mut Silent).len();
        // One shared pixel of the upper line.
        assert_eq!(left([paper((100, 160), (100, 160)), wide((160, 220), (161, 221))]), 0);
        // None of the upper line, several of the lower.
        assert_eq!(left([paper((100, 160), (100, 163)), wide((161, 220), (158, 220))]), 2);
        // One format; apart.
        assert_eq!(left([paper((100, 160), (100, 160)), paper((160, 220), (160, 220))]), 2);
        assert_eq!(left([wide((200, 260), (200, 260)), paper((100, 160), (100, 160))]), 2);
    }
}
