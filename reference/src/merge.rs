//! Both layers together: code word, payload, detection (MERGE).

use crate::accept::{Accepted, AcceptedFit, View, accept, accept_fit};
use crate::codeword;
use crate::decode::DecodedLayer;
use crate::extents::{Extent, MAX_PAIRS, Pair, extents};
use crate::fit::{FitLayer, Fitted};
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::landmark::{Format, stripes};
use crate::observer::Observer;
use crate::refusal::{CandidateRefusal, PairRefusal};
use crate::skew::Ends;
use crate::threshold::Thresholding;
use crate::trellis::{self, Settled};
use nalgebra::Matrix3;

/// Largest difference in pixels between the ends of two layers of one barcode (MERGE-1).
pub const MERGE_DISTANCE: usize = 3;

/// Most detections of two scan lines (MERGE-10).
pub const MAX_DETECTIONS: usize = 8;

/// How a code word was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Decoder {
    /// By sampling what a threshold left (SAMPLE).
    Threshold,
    /// As the most likely one (TRELLIS).
    Trellis,
}

/// What a pose was computed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Estimator {
    /// The fit to the grey levels (FIT).
    Fit,
    /// The transitions, as in the paper (ACCEPT-10).
    Paper,
}

/// One layer of a landmark: where it was read, and what it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// First pixel of its ROI or extent.
    pub first_pixel: usize,
    /// Last pixel of its ROI or extent.
    pub last_pixel: usize,
    /// `N_code` bits, the left-most stripe as the most significant.
    pub half_word: u32,
}

impl Reading {
    fn of_layer(layer: &DecodedLayer) -> Self {
        let (first_pixel, last_pixel) = (layer.hypothesis.first_pixel, layer.hypothesis.last_pixel);
        Self { first_pixel, last_pixel, half_word: layer.half_word }
    }

    fn of_extent(extent: &Extent, half_word: u32) -> Self {
        Self { first_pixel: extent.first, last_pixel: extent.last, half_word }
    }

    fn extent(&self) -> Extent {
        Extent { first: self.first_pixel, last: self.last_pixel }
    }

    fn shares_a_pixel_with(&self, first: usize, last: usize) -> bool {
        self.first_pixel <= last && first <= self.last_pixel
    }
}

/// A landmark that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// Its format.
    pub format: Format,
    /// Its payload.
    pub payload: u32,
    /// How it was read.
    pub decoder: Decoder,
    /// The upper layer.
    pub upper: Reading,
    /// The lower layer.
    pub lower: Reading,
    /// The fitted homography, or the merged one (MERGE-4); of a moving camera at the upper row's time (SKEW-8).
    pub homography: Homography,
    /// The fit, `None` for the paper's estimate (ACCEPT-10).
    pub fit: Option<AcceptedFit>,
    /// The lower layer's own fit where the camera moved; the other one is the upper layer's then (SKEW-7).
    pub lower_fit: Option<Fitted>,
    /// The merged homography of its transitions (MERGE-4), `None` where no threshold decoded it.
    pub transitions: Option<Homography>,
    /// The camera's pose in the landmark's frame (COV-4).
    pub camera_in_landmark: Pose<frame::Landmark, frame::Camera>,
    /// The covariance of its `(x, y, θ)`, metres and radians squared (COV-4, COV-5).
    pub covariance: Matrix3<f64>,
}

impl Detection {
    /// What its pose was computed from.
    #[must_use]
    pub fn estimator(&self) -> Estimator {
        if self.fit.is_some() { Estimator::Fit } else { Estimator::Paper }
    }
}

/// A code word on its way to a detection.
struct Candidate {
    format: Format,
    payload: u32,
    decoder: Decoder,
    upper: Reading,
    lower: Reading,
}

impl Candidate {
    /// MERGE-9, MERGE-10
    //= reference/SPEC.md#merge
    //# - **MERGE-9** A candidate MUST become a detection if ACCEPT accepts it, and otherwise be refused by the first of
    //# ACCEPT's reasons.
    //= reference/SPEC.md#merge
    //# - **MERGE-10** A line pair MUST give at most 8 detections before MERGE-7, and what comes after them be refused
    //# (`TooMany`).
    fn conclude<O: Observer>(
        self,
        result: Result<Accepted, CandidateRefusal>,
        detections: &mut Vec<Detection>,
        observer: &mut O,
    ) {
        let Self { format, payload, decoder, upper, lower } = self;
        let room = detections.len() < MAX_DETECTIONS;
        match result.and_then(|accepted| if room { Ok(accepted) } else { Err(CandidateRefusal::TooMany) }) {
            Err(refusal) => observer.candidate_refused(format, decoder, refusal),
            Ok(Accepted { homography, fit, lower: lower_fit, transitions, pose }) => {
                let (camera_in_landmark, covariance) = (pose.camera_in_landmark, pose.covariance);
                detections.push(Detection {
                    format,
                    payload,
                    decoder,
                    upper,
                    lower,
                    homography,
                    fit,
                    lower_fit,
                    transitions,
                    camera_in_landmark,
                    covariance,
                });
            }
        }
    }
}

/// MERGE-1, with the shifts of the upper layer's ends and the play of a moving camera (SKEW-6).
//= reference/SPEC.md#merge
//# - **MERGE-1** An upper and a lower layer MUST be paired where their ROIs' first pixels differ by at most 3 px and
//# their last pixels by at most 3 px.
//= reference/SPEC.md#skew
//# - **SKEW-6** In MERGE-1 the lower layer's ends MUST be compared with the upper one's ends plus the shifts of the
//# upper layer's homography, `T` px added to the 3 px, and in ACCEPT-2 the lower layer's `(a, s, k)` count less the
//# shift of the upper layer's, `T` px added to the limit of `a`.
#[must_use]
pub fn belong_together(upper: &DecodedLayer, lower: &DecodedLayer, ends: &Ends, play: u32) -> bool {
    let of = |layer: &DecodedLayer| (layer.hypothesis.first_pixel, layer.hypothesis.last_pixel);
    ends.join(of(upper), of(lower), MERGE_DISTANCE + play as usize)
}

/// Pairs the layers of one format, which come in the order of MERGE-6, and adds what they say to the
/// detections, in the order of the upper layers and then of the lower ones (MERGE-5). The result is the number of pairs
/// that were decided again (TRELLIS-9).
//= reference/SPEC.md#merge
//# - **MERGE-5** Pairs MUST be formed in the order of the upper layers, and for one upper layer in the order of the
//# lower ones.
//= reference/SPEC.md#merge
//# - **MERGE-6** Layers MUST be ordered as their seeds were taken, those of the global threshold before those of the
//# local one.
pub fn merge<O: Observer>(
    upper: &[DecodedLayer],
    lower: &[DecodedLayer],
    view: &View<'_>,
    detections: &mut Vec<Detection>,
    observer: &mut O,
) -> usize {
    let (format, decoder) = (view.landmark.format, Decoder::Threshold);
    let mut tried = 0;
    for one in upper {
        let Some(ends) = view.ends(&one.homography) else { continue };
        for other in lower.iter().filter(|other| belong_together(one, other, &ends, view.skew.play())) {
            //= reference/SPEC.md#merge
            //# - **MERGE-2** A pair MUST give the code word of CODE-4.
            //= reference/SPEC.md#merge
            //# - **MERGE-3** A pair MUST be refused by CODE-7 before CODE-8 is asked.
            // MERGE-2, MERGE-3
            let result = codeword::decode(format, one.half_word, other.half_word);
            let (upper, lower) = (Reading::of_layer(one), Reading::of_layer(other));
            observer.pair(format, decoder, &upper, &lower, result);
            if let Ok(payload) = result {
                let accepted = accept([one, other], view, observer);
                Candidate { format, payload, decoder, upper, lower }.conclude(accepted, detections, observer);
            } else if result == Err(PairRefusal::Crc)
                && tried < MAX_PAIRS
                && shadowed([one, other])
                && !view.skew.moves()
            {
                tried += 1;
                let pair = [upper.extent(), lower.extent()];
                let half_words = [upper.half_word, lower.half_word];
                let start = one.homography.mean(&other.homography);
                let settled = trellis::decode_again(&pair, half_words, &start, view, observer);
                conclude_settled(&pair, settled, view, detections, observer);
            }
        }
    }
    tried
}

/// Whether a pair of layers may have been misread at the edge of a shadow (TRELLIS-9).
fn shadowed(layers: [&DecodedLayer; 2]) -> bool {
    layers.iter().any(|layer| layer.thresholding == Thresholding::Local)
}

/// A pair of extents or of ROIs whose half words have settled, or why they have not (TRELLIS-8).
//= reference/SPEC.md#trellis
//# - **TRELLIS-8** The half words MUST be checked as those of two decoded layers (MERGE-2, MERGE-3) when they have
//# settled.
pub fn conclude_settled<O: Observer>(
    pair: &Pair,
    settled: Result<Settled, CandidateRefusal>,
    view: &View<'_>,
    detections: &mut Vec<Detection>,
    observer: &mut O,
) {
    let (format, decoder) = (view.landmark.format, Decoder::Trellis);
    let settled = match settled {
        Ok(settled) => settled,
        Err(refusal) => return observer.candidate_refused(format, decoder, refusal),
    };
    let [above, below] = settled.half_words;
    let (upper, lower) = (Reading::of_extent(&pair[0], above), Reading::of_extent(&pair[1], below));
    let result = codeword::decode(format, above, below);
    observer.pair(format, decoder, &upper, &lower, result);
    if let Ok(payload) = result {
        let colours = settled.half_words.map(|word| stripes(format, word));
        let layers = [0, 1].map(|i| FitLayer {
            line: view.lines[i],
            first_pixel: pair[i].first,
            last_pixel: pair[i].last,
            stripes: &colours[i],
        });
        let accepted = accept_fit(&layers, settled.fitted, decoder, view, observer);
        Candidate { format, payload, decoder, upper, lower }.conclude(accepted, detections, observer);
    }
}

/// Pairs the extents of both lines and adds what they say to the detections (EXTENT-4 to EXTENT-7, TRELLIS-8), after
/// `tried` other pairs.
//= reference/SPEC.md#extent
//# - **EXTENT-7** Of each format at most 4 pairs MUST be tried, those of TRELLIS-9 first.
pub fn merge_extents<O: Observer>(
    upper: &[Extent],
    lower: &[Extent],
    view: &View<'_>,
    detections: &mut Vec<Detection>,
    mut tried: usize,
    observer: &mut O,
) {
    let format = view.landmark.format;
    //= reference/SPEC.md#skew
    //# - **SKEW-9** Of a moving camera TRELLIS MUST NOT be asked.
    // SKEW-9
    if view.skew.moves() {
        return;
    }
    for pair in extents(upper, lower) {
        //= reference/SPEC.md#extent
        //# - **EXTENT-5** A pair of which an extent shares a pixel with the same line's ROI or extent of a detection of
        //# any format MUST be left out.
        // EXTENT-5
        let taken = |found: &Detection| {
            found.upper.shares_a_pixel_with(pair[0].first, pair[0].last)
                || found.lower.shares_a_pixel_with(pair[1].first, pair[1].last)
        };
        if detections.iter().any(taken) {
            continue;
        }
        if tried == MAX_PAIRS {
            break;
        }
        tried += 1;
        observer.extents(format, &pair);
        let settled = trellis::decode(&pair, view, observer);
        conclude_settled(&pair, settled, view, detections, observer);
    }
}

/// What is left when the detections that contradict each other are withdrawn, all of them (MERGE-7, MERGE-8).
//= reference/SPEC.md#merge
//# - **MERGE-7** Detections of different formats whose upper ROIs share a pixel MUST be refused, all of them
//# (`Ambiguous`).
//= reference/SPEC.md#merge
//# - **MERGE-8** Each format MUST report its detections in the order of MERGE-5, those of TRELLIS after them, and the
//# formats in the order in which they were asked for.
pub fn withdraw_ambiguous<O: Observer>(detections: &[Detection], observer: &mut O) -> Vec<Detection> {
    let mut kept = Vec::new();
    for detection in detections {
        if detections.iter().any(|other| contradict(detection, other)) {
            observer.ambiguous(detection);
        } else {
            observer.detection(detection);
            kept.push(detection.clone());
        }
    }
    kept
}

/// Whether two detections read the same place as different formats (MERGE-7).
fn contradict(one: &Detection, other: &Detection) -> bool {
    one.format != other.format && one.upper.shares_a_pixel_with(other.upper.first_pixel, other.upper.last_pixel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::crossing::CrossingRule;
    use crate::hypotheses::Hypothesis;
    use crate::landmark::Landmark;
    use crate::observer::Silent;
    use crate::skew::Skew;
    use crate::threshold::Thresholding;

    fn layer(first_pixel: usize, last_pixel: usize, half_word: u32) -> DecodedLayer {
        let hypothesis = Hypothesis { first_region: 1, last_region: 9, first_pixel, last_pixel };
        let homography = Homography { a: 1.0, s: 20.0, k: 0.02 };
        DecodedLayer { thresholding: Thresholding::Global, hypothesis, half_word, homography }
    }

    //= reference/SPEC.md#merge
    //= type=test
    //# - **MERGE-1** An upper and a lower layer MUST be paired where their ROIs' first pixels differ by at most 3 px
    //# and their last pixels by at most 3 px.
    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-6** In MERGE-1 the lower layer's ends MUST be compared with the upper one's ends plus the shifts of the
    //# upper layer's homography, `T` px added to the 3 px, and in ACCEPT-2 the lower layer's `(a, s, k)` count less the
    //# shift of the upper layer's, `T` px added to the limit of `a`.
    #[test]
    fn both_ends_must_be_within_three_pixels() {
        let upper = layer(100, 160, 0);
        let near = |lower: &DecodedLayer| belong_together(&upper, lower, &Ends::default(), 0);
        assert!(near(&layer(103, 157, 0)) && near(&layer(97, 163, 0)));
        assert!(!near(&layer(104, 160, 0)) && !near(&layer(100, 156, 0)));
        // Of a camera that has moved on so far that the ends lie 10 and 12 px to the right, known to 2 px.
        let ends = Ends { first: 10, last: 12 };
        let moving = |lower: &DecodedLayer| belong_together(&upper, lower, &ends, 2);
        assert!(moving(&layer(115, 167, 0)) && moving(&layer(105, 177, 0)));
        assert!(!moving(&layer(116, 172, 0)) && !moving(&layer(110, 178, 0)) && !moving(&layer(104, 172, 0)));
    }

    fn merged(upper: &DecodedLayer, lower: &DecodedLayer) -> Vec<Detection> {
        let mut found = Vec::new();
        let (camera, landmark) = (&Camera::epuck(), &Landmark::new(Format::Paper));
        // Lines without a grey pixel cannot be fitted (FIT-5).
        let view =
            View { lines: [&[255; 480]; 2], camera, landmark, rule: CrossingRule::WholePixel, skew: Skew::at_rest() };
        merge(&[*upper], &[*lower], &view, &mut found, &mut Silent);
        found
    }

    //= reference/SPEC.md#merge
    //= type=test
    //# - **MERGE-2** A pair MUST give the code word of CODE-4.
    //= reference/SPEC.md#merge
    //= type=test
    //# - **MERGE-4** The merged homography MUST be the mean of the two layers' `a`, `s` and `k`.
    #[test]
    fn a_pair_gives_payload_and_mean_homography() {
        let (upper, lower) = codeword::encode(Format::Paper, 0xcc0d).unwrap();
        let mut second = layer(100, 160, lower);
        second.homography = Homography { a: 2.0, s: 22.0, k: 0.04 };
        let found = merged(&layer(100, 160, upper), &second);
        let Homography { a, s, k } = found[0].homography;
        assert_eq!(found[0].payload, 0xcc0d);
        assert!((a - 1.5).abs() < 1e-15 && (s - 21.0).abs() < 1e-14 && (k - 0.03).abs() < 1e-15);
        assert!(merged(&layer(100, 160, upper ^ 1), &second).is_empty());
        assert!(merged(&layer(104, 160, upper), &second).is_empty());
    }

    /// Eight landmarks side by side, and what comes after them.
    //= reference/SPEC.md#merge
    //= type=test
    //# - **MERGE-10** A line pair MUST give at most 8 detections before MERGE-7, and what comes after them be refused
    //# (`TooMany`).
    #[test]
    fn nine_detections_are_too_many() {
        struct Refused(Vec<CandidateRefusal>);
        impl Observer for Refused {
            fn candidate_refused(&mut self, _: Format, _: Decoder, refusal: CandidateRefusal) {
                self.0.push(refusal);
            }
        }
        let (upper, lower) = codeword::encode(Format::Paper, 0xcc0d).unwrap();
        let row = |count: usize, half_word: u32| -> Vec<DecodedLayer> {
            (0..count).map(|i| layer(10 + 40 * i, 40 + 40 * i, half_word)).collect()
        };
        let (camera, landmark) = (&Camera::epuck(), &Landmark::new(Format::Paper));
        let view =
            View { lines: [&[255; 480]; 2], camera, landmark, rule: CrossingRule::WholePixel, skew: Skew::at_rest() };
        for (count, refused) in [(8, vec![]), (9, vec![CandidateRefusal::TooMany])] {
            let (mut found, mut heard) = (Vec::new(), Refused(Vec::new()));
            merge(&row(count, upper), &row(count, lower), &view, &mut found, &mut heard);
            assert_eq!((found.len(), heard.0), (8, refused), "{count}");
        }
    }

    /// A detection of a format whose upper and lower ROIs are at the given pixels.
    fn detection(format: Format, upper: (usize, usize), lower: (usize, usize)) -> Detection {
        Detection {
            format,
            payload: 1,
            decoder: Decoder::Threshold,
            upper: Reading { first_pixel: upper.0, last_pixel: upper.1, half_word: 0 },
            lower: Reading { first_pixel: lower.0, last_pixel: lower.1, half_word: 0 },
            homography: Homography { a: 1.0, s: 20.0, k: 0.02 },
            lower_fit: None,
            transitions: None,
            fit: None,
            camera_in_landmark: Pose::new(0.3, 0.0, 0.0),
            covariance: Matrix3::identity(),
        }
    }

    //= reference/SPEC.md#merge
    //= type=test
    //# - **MERGE-7** Detections of different formats whose upper ROIs share a pixel MUST be refused, all of them
    //# (`Ambiguous`).
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
