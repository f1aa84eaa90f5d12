#![allow(clippy::cast_possible_truncation)] // of an angle in range

use super::*;
use crate::camera::Camera;
use crate::codeword::encode;
use crate::crossing::CrossingRule;
use crate::drawing::View;
use crate::fit::Fitted;
use crate::formats::Angle;
use crate::landmark::Landmark;
use crate::refusal::FitRefusal;
use crate::skew::Skew;
use crate::threshold::Threshold;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::format;
use std::string::String;
use std::vec::Vec as List;

/// A layer from pixel `first` to `last`, straight in front of the camera.
fn layer(first_pixel: u16, last_pixel: u16, half_word: u16) -> DecodedLayer {
    let hypothesis = Hypothesis { first_region: 1, last_region: 9, first_pixel, last_pixel };
    let (a, s, k) = (Column::ZERO, Column::from_num(40), Obliquity::ZERO);
    DecodedLayer { thresholding: Thresholding::Global, hypothesis, half_word, homography: Homography { a, s, k } }
}

#[derive(Default)]
struct Recorder {
    pairs: List<(u16, u16, Result<u32, PairRefusal>)>,
    refused: List<(Format, Decoder, CandidateRefusal)>,
    found: List<(&'static str, Format, u16)>,
}

impl Observer for Recorder {
    fn pair(&mut self, _: Format, _: Decoder, upper: &Reading, lower: &Reading, result: Result<u32, PairRefusal>) {
        self.pairs.push((upper.first_pixel, lower.first_pixel, result));
    }

    fn candidate_refused(&mut self, format: Format, decoder: Decoder, refusal: CandidateRefusal) {
        self.refused.push((format, decoder, refusal));
    }

    fn detection(&mut self, detection: &Detection) {
        self.found.push(("found", detection.format, detection.upper.first_pixel));
    }

    fn ambiguous(&mut self, detection: &Detection) {
        self.found.push(("ambiguous", detection.format, detection.upper.first_pixel));
    }
}

/// Merges layers of white lines, which no fit explains, so that the layers' homographies decide (`ACCEPT-10`).
fn merged(landmark: Landmark, layers: &[(DecodedLayer, DecodedLayer)], detections: &mut Detections) -> Recorder {
    merged_moving(landmark, layers, &Skew::AT_REST, detections)
}

fn merged_moving(
    landmark: Landmark,
    layers: &[(DecodedLayer, DecodedLayer)],
    skew: &Skew,
    detections: &mut Detections,
) -> Recorder {
    let mut recorder = Recorder::default();
    let (upper, lower): (List<_>, List<_>) = layers.iter().copied().unzip();
    let (white, camera) = ([255; 480], Camera::epuck());
    let rule = CrossingRule::Interpolated;
    let setting = Setting { lines: [&white, &white], camera: &camera, landmark: &landmark, rule, skew };
    Merger::new(setting, detections, &mut recorder).merge(&upper, &lower);
    recorder
}

//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-1** An upper and a lower layer MUST be paired where their ROIs' first pixels differ by at most 3 px and
//# their last pixels by at most 3 px.
#[test]
fn ends_may_differ_by_three_pixels() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let paired = |first, last| {
        let layers = [(layer(100, 180, one), layer(first, last, other))];
        merged(Landmark::paper(), &layers, &mut Detections::new()).pairs.len() == 1
    };
    assert!(paired(97, 183) && paired(103, 177) && paired(100, 180));
    assert!(!paired(96, 180) && !paired(104, 180) && !paired(100, 176) && !paired(100, 184));
}

/// `SKEW-6`: the play is added to 3 px, and the upper one's ends are shifted. A turn of 10/640 to the left moves the middle of the
/// image 10 px to the right.
//= reference/SPEC.md#skew
//= type=test
//# - **SKEW-6** In MERGE-1 the lower layer's ends MUST be compared with the upper one's ends plus the shifts of the
//# upper layer's homography, `T` px added to the 3 px, and in ACCEPT-2 the lower layer's `(a, s, k)` count less the
//# shift of the upper layer's, `T` px added to the limit of `a`.
#[test]
fn ends_of_a_moving_camera_may_differ_by_its_play_too() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let paired = |first: u16, last: u16, skew: &Skew| {
        let (upper, lower) = (layer(200, 279, one), layer(first, last, other));
        let landmark = Landmark::paper();
        !merged_moving(landmark, &[(upper, lower)], skew, &mut Detections::new()).pairs.is_empty()
    };
    let hardly = Skew { play: 4, ..Skew::AT_REST };
    assert!(paired(207, 272, &hardly) && paired(193, 286, &hardly));
    assert!(!paired(208, 279, &hardly) && !paired(200, 287, &hardly) && !paired(204, 279, &Skew::AT_REST));
    let turn = Angle::from_bits((10.0 / 640.0 / std::f64::consts::PI * 2_f64.powi(31)) as i32);
    let turned = Skew { turn, ..hardly };
    assert!(paired(217, 282, &turned) && paired(203, 296, &turned));
    assert!(!paired(218, 289, &turned) && !paired(210, 297, &turned) && !paired(202, 289, &turned));
}

/// `SKEW-9`: neither extents nor what the check byte refuses (`TRELLIS-9`) is tried.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-11** A pair of extents of which a fit is refused MUST be refused (`NoFit`).
#[test]
fn pairs_of_a_moving_camera_are_not_decided_again() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let pair = (local(layer(100, 180, one)), local(layer(100, 180, other ^ 1)));
    let refused = |skew: &Skew| {
        let recorder = merged_moving(Landmark::paper(), &[pair], skew, &mut Detections::new());
        assert_eq!(recorder.pairs, [(100, 100, Err(PairRefusal::Crc))]);
        recorder.refused
    };
    assert_eq!(refused(&Skew::AT_REST), [(Format::Paper, Decoder::Trellis, CandidateRefusal::NoFit)]);
    assert_eq!(refused(&Skew { play: 4, ..Skew::AT_REST }), []);
}

//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-2** A pair MUST give the code word of CODE-4.
//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-3** A pair MUST be refused by CODE-7 before CODE-8 is asked.
//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-5** Pairs MUST be formed in the order of the upper layers, and for one upper layer in the order of the
//# lower ones.
#[test]
fn pairs_say_a_payload_or_why_they_do_not() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let layers = [
        (layer(300, 380, one), layer(301, 380, other)),
        (layer(100, 180, one), layer(100, 180, one)),
        (layer(200, 280, one), layer(200, 280, other ^ 1)),
    ];
    let mut detections = Detections::new();
    let recorder = merged(Landmark::paper(), &layers, &mut detections);
    let expected =
        [(300, 301, Ok(0x1234)), (100, 100, Err(PairRefusal::EqualHalves)), (200, 200, Err(PairRefusal::Crc))];
    assert_eq!(recorder.pairs, expected);
    assert_eq!(detections.len(), 1);
    assert_eq!(detections[0].payload, 0x1234);
    let reading = |first_pixel, half_word| Reading { first_pixel, last_pixel: 380, half_word };
    assert_eq!((detections[0].upper, detections[0].lower), (reading(300, one), reading(301, other)));
    assert_eq!((detections[0].decoder, detections[0].estimator()), (Decoder::Threshold, Estimator::Paper));
}

/// What is heard of pairs, their fits and their ends.
#[derive(Default)]
struct Events(List<String>);

impl Observer for Events {
    fn extents(&mut self, _: Format, _: Extent, _: Extent) {
        self.0.push("extents".into());
    }

    fn pair(&mut self, _: Format, by: Decoder, _: &Reading, _: &Reading, result: Result<u32, PairRefusal>) {
        self.0.push(format!("{by:?} {result:x?}"));
    }

    fn fitted(&mut self, fit: Result<&Fitted, FitRefusal>) {
        let step = |fit: &Fitted| fit.lights.iter().all(|light| light.step.is_some());
        self.0.push(format!("{:?}", fit.map(step)));
    }

    fn candidate_refused(&mut self, _: Format, by: Decoder, refusal: CandidateRefusal) {
        self.0.push(format!("{by:?} {refusal:?}"));
    }
}

/// What is heard of `paper` layers in the middle of both lines, and of extents after them.
fn heard(lines: [&[u8]; 2], upper: &[DecodedLayer], lower: &[DecodedLayer]) -> (List<String>, Detections) {
    let (camera, landmark) = (Camera::epuck(), Landmark::paper());
    let setting =
        Setting { lines, camera: &camera, landmark: &landmark, rule: CrossingRule::Interpolated, skew: &Skew::AT_REST };
    let (mut events, mut detections) = (Events::default(), Detections::new());
    let mut merger = Merger::new(setting, &mut detections, &mut events);
    merger.merge(upper, lower);
    let threshold = Threshold { darkest: 40, brightest: 220 };
    merger.merge_extents(Shade::new(lines[0], &threshold), Shade::new(lines[1], &threshold));
    (events.0, detections)
}

fn local(layer: DecodedLayer) -> DecodedLayer {
    DecodedLayer { thresholding: Thresholding::Local, ..layer }
}

/// A shadow's edge in a barcode of which one stripe was read wrong, by the local threshold in one of the layers.
//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-9** A pair of layers of which at least one was found by the local threshold and whose code word CODE-8
//# refuses MUST be decided again as one of EXTENT-7's pairs: fitted under a step of light from the merged homography,
//# with the half words as they were read and a blur of 1/2, and then as TRELLIS-6 to TRELLIS-8 say, each fit from the
//# one before it, under a step of light.
#[test]
fn a_pair_of_the_local_threshold_is_decided_again() {
    let view = View::turned(Format::Paper, 4.0, 0.0);
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let (one, other) = encode(Format::Paper, 0xBEEF).unwrap();
    let mut lines = [one, other].map(|half_word| view.line(480, half_word, &mut random));
    lines.iter_mut().flat_map(|line| &mut line[245..]).for_each(|pixel| *pixel /= 2);
    let heard = |upper, lower| heard([&lines[0], &lines[1]], &[upper], &[lower]);
    let (upper, lower) = (layer(200, 279, one ^ 1 << 5), layer(200, 279, other));
    let again = ["Threshold Err(Crc)", "Ok(true)", "Ok(true)", "Trellis Ok(beef)"];
    for (upper, lower) in [(upper, local(lower)), (local(upper), lower), (local(upper), local(lower))] {
        let (events, detections) = heard(upper, lower);
        assert_eq!(events, again);
        let found = &detections[0];
        assert_eq!((found.payload, found.decoder, found.upper.half_word), (0xBEEF, Decoder::Trellis, one));
        assert_eq!((found.upper.first_pixel, found.lower.last_pixel), (200, 279));
    }
    // Neither by the global threshold alone, nor where both halves are equal.
    assert_eq!(heard(upper, lower).0, again[..1]);
    assert_eq!(heard(local(upper), local(layer(200, 279, one ^ 1 << 5))).0, ["Threshold Err(EqualHalves)"]);
}

/// Four pairs of the format: those of layers first, then those of extents, of which bars of 6 px give a lot.
//= reference/SPEC.md#extent
//= type=test
//# - **EXTENT-7** Of each format at most 4 pairs MUST be tried, those of TRELLIS-9 first.
#[test]
fn four_pairs_are_tried_layers_first() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let text: List<u8> = (0..480).map(|pixel| if pixel % 13 < 6 { 40 } else { 220 }).collect();
    let tries = |layers: u16| -> (usize, usize, usize) {
        let pairs = (0..layers).map(|i| 20 + 70 * i);
        let (upper, lower): (List<_>, List<_>) = pairs
            .map(|first| (local(layer(first, first + 60, one)), local(layer(first, first + 60, other ^ 1))))
            .unzip();
        let (events, _) = heard([&text, &text], &upper, &lower);
        let first_extents = events.iter().position(|event| event == "extents").unwrap_or(events.len());
        let trellis = |events: &[String]| events.iter().filter(|event| event.starts_with("Trellis")).count();
        (trellis(&events[..first_extents]), trellis(&events[first_extents..]), count(&events, "Threshold Err(Crc)"))
    };
    assert_eq!([0, 1, 4, 5].map(tries), [(0, 4, 0), (1, 3, 1), (4, 0, 4), (4, 0, 5)]);
}

fn count(events: &[String], event: &str) -> usize {
    events.iter().filter(|other| *other == event).count()
}

//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-4** The merged homography MUST be the mean of the two layers' `a`, `s` and `k`.
#[test]
fn the_homography_is_the_mean() {
    let homography = |a, s, k| Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) };
    let (upper, lower) = (homography(-1500.0, 30.0, 0.5), homography(-1000.0, 33.0, -0.25));
    assert_eq!(mean(&upper, &lower), homography(-1250.0, 31.5, 0.125));
}

//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-9** A candidate MUST become a detection if ACCEPT accepts it, and otherwise be refused by the first of
//# ACCEPT's reasons.
#[test]
fn layers_that_disagree_are_no_detection() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let (upper, mut lower) = (layer(100, 180, one), layer(100, 180, other));
    lower.homography.a += Column::from_num(1.001);
    let mut detections = Detections::new();
    let recorder = merged(Landmark::paper(), &[(upper, lower)], &mut detections);
    assert_eq!(recorder.pairs, [(100, 100, Ok(0x1234))]);
    assert_eq!(recorder.refused, [(Format::Paper, Decoder::Threshold, CandidateRefusal::Disagree)]);
    assert!(detections.is_empty());
}

//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-10** A line pair MUST give at most 8 detections before MERGE-7, and what comes after them be refused
//# (`TooMany`).
#[test]
fn nine_detections_are_too_many() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let layers: List<_> = (0..8)
        .map(|i| 10 + 40 * i)
        .map(|first| (layer(first, first + 30, one), layer(first, first + 30, other)))
        .collect();
    let mut detections = Detections::new();
    assert!(merged(Landmark::paper(), &layers, &mut detections).refused.is_empty());
    let (one, other) = encode(Format::Wide, 0x1234).unwrap();
    let wide = [(layer(400, 440, one), layer(400, 440, other))];
    let recorder = merged(Landmark::wide(), &wide, &mut detections);
    assert_eq!(recorder.refused, [(Format::Wide, Decoder::Threshold, CandidateRefusal::TooMany)]);
    assert!(detections.len() == 8 && detections.iter().all(|found| found.format == Format::Paper));
}

#[test]
fn the_mean_of_two_integers_always_fits() {
    assert_eq!((halfway(3, 4), halfway(-3, -4), halfway(-1, 0), halfway(1, -2)), (4, -3, 0, 0));
    assert_eq!((halfway(i32::MAX, i32::MAX), halfway(i32::MIN, i32::MIN)), (i32::MAX, i32::MIN));
    assert_eq!((halfway(i32::MAX, i32::MIN), halfway(i32::MIN, i32::MAX)), (0, 0));
}

/// A wide landmark over the ends of two of three paper ones: it and both go, the third stays.
//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-7** Detections of different formats whose upper ROIs share a pixel MUST be refused, all of them
//# (`Ambiguous`).
#[test]
fn formats_that_share_a_pixel_are_withdrawn() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let at = |first: u16, last: u16| (layer(first, last, one), layer(first, last, other));
    let mut detections = Detections::new();
    merged(Landmark::paper(), &[at(300, 380), at(10, 90), at(200, 280)], &mut detections);
    let (one, other) = encode(Format::Wide, 0x1234).unwrap();
    let at = |first: u16, last: u16| (layer(first, last, one), layer(first, last, other));
    merged(Landmark::wide(), &[at(280, 300), at(91, 199)], &mut detections);

    let mut recorder = Recorder::default();
    withdraw_ambiguous(&mut detections, &mut recorder);
    let expected = [
        ("ambiguous", Format::Paper, 300),
        ("found", Format::Paper, 10),
        ("ambiguous", Format::Paper, 200),
        ("ambiguous", Format::Wide, 280),
        ("found", Format::Wide, 91),
    ];
    assert_eq!(recorder.found, expected);
    let left: List<_> = detections.iter().map(|d| (d.format, d.upper.first_pixel)).collect();
    assert_eq!(left, [(Format::Paper, 10), (Format::Wide, 91)]);
}

/// `EXTENT-5`: one pixel of either layer is enough.
#[test]
fn extents_with_a_pixel_of_a_detection_are_found_already() {
    let (one, other) = encode(Format::Paper, 0x1234).unwrap();
    let mut detections = Detections::new();
    merged(Landmark::paper(), &[(layer(100, 180, one), layer(102, 182, other))], &mut detections);
    let (white, camera, landmark, mut silent) = ([255; 480], Camera::epuck(), Landmark::wide(), Recorder::default());
    let rule = CrossingRule::Interpolated;
    let setting = Setting { lines: [&white, &white], camera: &camera, landmark: &landmark, rule, skew: &Skew::AT_REST };
    let merger = Merger::new(setting, &mut detections, &mut silent);
    let (left, right) = ((20, 99), (183, 240));
    assert!(!merger.is_found(left, left) && !merger.is_found(right, right) && !merger.is_found(left, right));
    assert!(merger.is_found((20, 100), left) && merger.is_found((180, 240), right));
    assert!(merger.is_found(left, (20, 102)) && merger.is_found(right, (182, 240)));
}
