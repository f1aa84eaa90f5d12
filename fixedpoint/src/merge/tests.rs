use super::*;
use crate::codeword::encode;
use crate::formats::Column;
use crate::refusal::PairRefusal;
use std::vec::Vec as List;

/// A layer from pixel `first` to `last`, straight in front of the camera.
fn layer(first_pixel: u16, last_pixel: u16, half_word: u16) -> DecodedLayer {
    let hypothesis = Hypothesis { first_region: 1, last_region: 9, first_pixel, last_pixel };
    let (a, s, k) = (Column::ZERO, Column::from_num(40), Obliquity::ZERO);
    DecodedLayer { hypothesis, half_word, homography: Homography { a, s, k } }
}

#[derive(Default)]
struct Recorder {
    pairs: List<(u16, u16, Result<u32, PairRefusal>)>,
    found: List<(&'static str, Format, u16)>,
}

impl Observer for Recorder {
    fn pair(&mut self, _format: Format, upper: &DecodedLayer, lower: &DecodedLayer, result: Result<u32, PairRefusal>) {
        self.pairs.push((upper.hypothesis.first_pixel, lower.hypothesis.first_pixel, result));
    }

    fn detection(&mut self, detection: &Detection) {
        self.found.push(("found", detection.format, detection.upper.hypothesis.first_pixel));
    }

    fn ambiguous(&mut self, detection: &Detection) {
        self.found.push(("ambiguous", detection.format, detection.upper.hypothesis.first_pixel));
    }
}

fn merged(landmark: Landmark, layers: &[(DecodedLayer, DecodedLayer)], detections: &mut Detections) -> Recorder {
    let mut recorder = Recorder::default();
    let (upper, lower): (List<_>, List<_>) = layers.iter().copied().unzip();
    merge(&upper, &lower, &Camera::epuck(), &landmark, detections, &mut recorder);
    recorder
}

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
    assert_eq!((detections[0].payload, detections[0].upper), (0x1234, layers[0].0));
    assert_eq!(detections[0].lower, layers[0].1);
}

#[test]
fn the_homography_is_the_mean() {
    let (one, other) = encode(Format::Wide, 0x1234).unwrap();
    let (mut upper, mut lower) = (layer(100, 180, one), layer(100, 180, other));
    let homography = |a, s, k| Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) };
    upper.homography = homography(-1500.0, 30.0, 0.5);
    lower.homography = homography(-1000.0, 33.0, -0.25);
    let mut detections = Detections::new();
    merged(Landmark::wide(), &[(upper, lower)], &mut detections);
    assert_eq!(detections[0].homography, homography(-1250.0, 31.5, 0.125));
}

#[test]
fn the_mean_of_two_integers_always_fits() {
    assert_eq!((halfway(3, 4), halfway(-3, -4), halfway(-1, 0), halfway(1, -2)), (4, -3, 0, 0));
    assert_eq!((halfway(i32::MAX, i32::MAX), halfway(i32::MIN, i32::MIN)), (i32::MAX, i32::MIN));
    assert_eq!((halfway(i32::MAX, i32::MIN), halfway(i32::MIN, i32::MAX)), (0, 0));
}

/// A wide landmark over the ends of two of three paper ones: it and both go, the third stays.
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
    let left: List<_> = detections.iter().map(|d| (d.format, d.upper.hypothesis.first_pixel)).collect();
    assert_eq!(left, [(Format::Paper, 10), (Format::Wide, 91)]);
}
