#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of numbers that are small and positive

use super::*;
use crate::codeword::encode;
use crate::drawing::{View, draw, draw_halves, stripes};
use crate::extents::Extent;
use crate::fit::Fitted;
use crate::formats::{Angle, Column, FocalLength, Length, Obliquity};
use crate::hypotheses::Hypothesis;
use crate::merge::{Decoder, Detection, Estimator, Reading};
use crate::observer::Silent;
use crate::refusal::{CandidateRefusal, FitRefusal, HypothesisRefusal, PairRefusal};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::{format, ops::Range, string::String, vec::Vec};

const RULES: [CrossingRule; 2] = [CrossingRule::Interpolated, CrossingRule::WholePixel];
const BOTH: [Landmark; 2] = [Landmark::paper(), Landmark::wide()];

/// Two white lines of 480 px.
struct Lines([Vec<u8>; 2]);

impl Lines {
    fn white() -> Self {
        Self([std::vec![255; 480], std::vec![255; 480]])
    }

    /// Adds a landmark with stripes of `width` px.
    fn with(mut self, format: Format, payload: u32, first: usize, width: usize) -> Self {
        let (upper, lower) = encode(format, payload).unwrap();
        draw(&mut self.0[0], first, width, &stripes(format, upper));
        draw(&mut self.0[1], first, width, &stripes(format, lower));
        self
    }

    /// Adds a landmark with stripes of 1.5 px.
    fn with_narrow(mut self, format: Format, payload: u32, first: usize) -> Self {
        let (upper, lower) = encode(format, payload).unwrap();
        draw_halves(&mut self.0[0], first, &stripes(format, upper));
        draw_halves(&mut self.0[1], first, &stripes(format, lower));
        self
    }

    /// Lays a shadow that leaves a quarter of the light over the right of both lines. Black is 12 and white 242 in the
    /// light, so that the fit has pixels.
    fn with_shadow(mut self, first: usize) -> Self {
        self.0.iter_mut().flatten().for_each(|pixel| *pixel = 12 + (u16::from(*pixel) * 230 / 255) as u8);
        self.0.iter_mut().flat_map(|line| &mut line[first..]).for_each(|pixel| *pixel /= 4);
        self
    }

    fn detect<O: Observer>(&self, landmarks: &[Landmark], rule: CrossingRule, observer: &mut O) -> Detections {
        let (camera, mut workspace) = (Camera::epuck(), Workspace::new());
        detect(&self.0[0], &self.0[1], &camera, landmarks, rule, &mut workspace, observer)
    }

    fn events(&self, landmarks: &[Landmark]) -> Vec<String> {
        let mut recorder = Recorder::default();
        self.detect(landmarks, CrossingRule::Interpolated, &mut recorder);
        recorder.0
    }
}

/// One word for each event.
#[derive(Default)]
struct Recorder(Vec<String>);

impl Observer for Recorder {
    fn threshold(&mut self, layer: Layer, _: &Threshold) {
        self.0.push(format!("{layer:?} threshold"));
    }

    fn regions(&mut self, layer: Layer, by: Thresholding, _: &Regions) {
        self.0.push(format!("{layer:?} {by:?} regions"));
    }

    fn line_refused(&mut self, layer: Layer, by: Thresholding, refusal: LineRefusal) {
        self.0.push(format!("{layer:?} {by:?} {refusal:?}"));
    }

    fn hypothesis(&mut self, layer: Layer, by: Thresholding, format: Format, hypothesis: &Hypothesis) {
        self.0.push(format!("{layer:?} {by:?} {format:?} {}", hypothesis.first_pixel));
    }

    fn refused(&mut self, refusal: HypothesisRefusal) {
        self.0.push(format!("{refusal:?}"));
    }

    fn decoded(&mut self, layer: &DecodedLayer) {
        self.0.push(format!("decoded {:x}", layer.half_word));
    }

    fn extents(&mut self, format: Format, upper: Extent, lower: Extent) {
        self.0.push(format!("{format:?} extents {} {}", upper.0, lower.0));
    }

    fn pair(&mut self, format: Format, by: Decoder, _: &Reading, _: &Reading, result: Result<u32, PairRefusal>) {
        self.0.push(format!("{format:?} {by:?} {result:x?}"));
    }

    fn fitted(&mut self, fit: Result<&Fitted, FitRefusal>) {
        let fit = fit.map(|fit| fit.lights.iter().any(|light| light.step.is_some()));
        self.0.push(match fit {
            Ok(step) => format!("fitted {}", if step { "step" } else { "even" }),
            Err(refusal) => format!("{refusal:?}"),
        });
    }

    fn candidate_refused(&mut self, format: Format, by: Decoder, refusal: CandidateRefusal) {
        self.0.push(format!("{format:?} {by:?} {refusal:?}"));
    }

    fn detection(&mut self, detection: &Detection) {
        self.0.push(format!("detection {:x}", detection.payload));
    }
}

/// The left edge is at 99.5 px and the stripes are 4 px wide: everything about the landmark is known.
//= reference/SPEC.md#code
//= type=test
//# - **CODE-3** Bits MUST become stripes by NRZ: 1 is a bar (black), 0 a space (white).
//= reference/SPEC.md#code
//= type=test
//# - **CODE-4** The first half of the code word MUST stand on the upper layer and the second half on the lower, each
//# from left to right as seen.
#[test]
fn an_ideal_landmark_is_found() {
    for rule in RULES {
        for (format, payload) in [(Format::Paper, 0xBEEF), (Format::Wide, 0x00C0_FFEE)] {
            let found = Lines::white().with(format, payload, 100, 4).detect(&BOTH, rule, &mut Silent);
            assert_eq!(found.len(), 1);
            let Detection { format: f, payload: p, homography, camera_in_landmark, .. } = found[0];
            assert_eq!((f, p), (format, payload));
            let half = 2 * u32::from(format.stripes());
            assert_eq!(homography.s, Column::from_num(half));
            assert_eq!(homography.a, Column::from_num(half) + Column::from_num(99.5 - 239.5));
            assert_eq!(homography.k, Obliquity::ZERO);
            // Stripes of 1.5 mm are 4 px at 0.24 m; X_dim itself is rounded by 2^-33 m.
            assert_eq!(camera_in_landmark.x, Length::from_num(0.24));
            assert_eq!(camera_in_landmark.theta, Angle::PI);
            let y = (140.0 - f64::from(half)) * 0.24 / 640.0;
            assert!((camera_in_landmark.y.to_num::<f64>() - y).abs() <= 2_f64.powi(-23));
        }
    }
}

//= reference/SPEC.md#line
//= type=test
//# - **LINE-4** Several formats MUST be searched one after the other, each as if it were the only one but for EXTENT-5,
//# before MERGE-7 compares them.
//= reference/SPEC.md#line
//= type=test
//# - **LINE-5** The upper line MUST be searched before the lower one, each in all formats by its global threshold
//# (THRESH-1) and then in all formats by its local one (THRESH-6).
#[test]
fn events_come_in_their_order() {
    let lines = Lines::white().with(Format::Wide, 0x00F2_0183, 100, 4);
    let expected = [
        "Upper threshold",
        "Upper Global regions",
        "Upper Global Wide 100",
        "decoded f201",
        "Upper Local regions",
        "Upper Local Wide 100",
        "Repeated",
        "Lower threshold",
        "Lower Global regions",
        "Lower Global Wide 100",
        "decoded 83c2",
        "Lower Local regions",
        "Lower Local Wide 100",
        "Repeated",
        "Wide Threshold Ok(f20183)",
        "TooFewPixels",
        "TooFewPixels",
        "detection f20183",
    ];
    assert_eq!(lines.events(&[Landmark::wide()]), expected);
    // A repeated format is not searched again.
    assert_eq!(lines.events(&[Landmark::wide(); 3]), expected);
    // As the other format the layers are refused: 24 stripes have more bars, or other places for them.
    // What is refused by the global threshold is tried again by the local one.
    let both = lines.events(&BOTH);
    assert_eq!(both[..3], ["Upper threshold", "Upper Global regions", "Upper Global Paper 100"]);
    assert_eq!(both[4..8], ["Upper Global Wide 100", "decoded f201", "Upper Local regions", "Upper Local Paper 100"]);
    assert_eq!((&both[8], &both[9]), (&both[3], &expected[5].into()));
    assert_eq!(both[11..14], ["Lower threshold", "Lower Global regions", "Lower Global Paper 100"]);
    assert_eq!(both[22..], expected[14..]);
}

//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-8** Each format MUST report its detections in the order of MERGE-5, those of TRELLIS after them, and the
//# formats in the order in which they were asked for.
#[test]
fn formats_report_in_the_order_they_were_asked_for() {
    let lines = Lines::white().with(Format::Paper, 0xBEEF, 300, 4).with(Format::Wide, 0xC0_FFEE, 20, 4);
    let payloads = |landmarks: &[Landmark]| -> Vec<u32> {
        let found = lines.detect(landmarks, CrossingRule::Interpolated, &mut Silent);
        found.iter().map(|detection| detection.payload).collect()
    };
    assert_eq!(payloads(&[Landmark::paper(), Landmark::wide()]), [0xBEEF, 0x00C0_FFEE]);
    assert_eq!(payloads(&[Landmark::wide(), Landmark::paper()]), [0x00C0_FFEE, 0xBEEF]);
    assert_eq!(payloads(&[]), [0; 0]);
}

//= reference/SPEC.md#line
//= type=test
//# - **LINE-2** A scan line whose length is not the camera's width MUST be refused (`Width`).
//= reference/SPEC.md#line
//= type=test
//# - **LINE-3** A refusal on one scan line MUST NOT change the results of the other.
#[test]
fn a_refused_line_does_not_change_the_other() {
    let mut lines = Lines::white().with(Format::Wide, 0x00F2_0183, 100, 4);
    lines.0[0].pop();
    let upper_is_short = lines.events(&[Landmark::wide()]);
    let expected = [
        "Upper Global Width",
        "Lower threshold",
        "Lower Global regions",
        "Lower Global Wide 100",
        "decoded 83c2",
        "Lower Local regions",
        "Lower Local Wide 100",
        "Repeated",
    ];
    assert_eq!(upper_is_short, expected);
    lines.0[0] = std::vec![200; 480];
    let grey = lines.events(&[Landmark::wide()]);
    assert_eq!((grey[0].as_str(), &grey[1..]), ("Upper Global LowContrast", &upper_is_short[1..]));
    lines.0[0] = (0..480).map(|i| if i % 2 == 0 { 0 } else { 255 }).collect();
    let stripes = lines.events(&[Landmark::wide()]);
    let refused = ["Upper threshold", "Upper Global TooManyRegions", "Upper Local TooManyRegions"];
    assert_eq!(stripes[..3], refused);
    assert_eq!(stripes[3..], expected[1..]);
}

/// Stripes of one pixel in the shadow, beside a landmark in the light: black to the global threshold, 300 regions to the
/// local one. Without the landmark's partner nothing is paired.
#[test]
fn a_threshold_with_too_many_regions_leaves_the_other() {
    let mut lines = Lines::white().with(Format::Paper, 0xBEEF, 50, 4);
    lines.0[1].fill(255);
    for (i, pixel) in lines.0[0].iter_mut().enumerate().skip(180) {
        *pixel = if i % 2 == 0 { 0 } else { 60 };
    }
    let events = lines.events(&[Landmark::paper()]);
    let upper = ["Upper threshold", "Upper Global regions", "Upper Global Paper 50", "decoded bee"];
    assert_eq!(events[..4], upper);
    // The shadow is one bar.
    assert_eq!(events[4..7], ["Upper Global Paper 180", "TooFewBars", "Upper Local TooManyRegions"]);

    // The other way round: 10 grey levels from the middle are distinct in a range of 160, but no local range of 24.
    lines.0[0] = (0..480).map(|i| if i < 100 { [0, 160][i / 50] } else { [70, 90][i % 2] }).collect();
    let events = lines.events(&[Landmark::paper()]);
    let all = ["Upper threshold", "Upper Global TooManyRegions", "Upper Local regions", "Lower Global LowContrast"];
    assert_eq!(events, all);
}

/// A shadow whose white, 60, is darker than half of the white in the light lies over the right half of a landmark.
#[test]
fn a_landmark_at_a_shadow_s_edge_is_found() {
    for rule in RULES {
        for (format, payload) in [(Format::Paper, 0xBEEF), (Format::Wide, 0x00C0_FFEE)] {
            let lines = Lines::white().with(format, payload, 100, 4).with_shadow(145);
            let found = lines.detect(&BOTH, rule, &mut Silent);
            assert_eq!(found.iter().map(|detection| detection.payload).collect::<Vec<_>>(), [payload]);
            let events = if rule == CrossingRule::Interpolated { lines.events(&BOTH) } else { continue };
            // In one line it may be read as a layer of the other format, too (SAMPLE-10).
            let pairs: Vec<_> = events.iter().filter(|event| event.contains(" Threshold ")).collect();
            assert_eq!(pairs, [&format!("{format:?} Threshold Ok({payload:x})")]);
            assert!(!events.iter().any(|event| event == "Repeated"));
        }
    }
}

/// The landmark in the light is found by the global threshold, the one in the shadow, at its left, by the local one.
//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-6** Layers MUST be ordered as their seeds were taken, those of the global threshold before those of the
//# local one.
#[test]
fn layers_of_the_global_threshold_come_first() {
    let lines = Lines::white().with(Format::Paper, 0x1234, 100, 3).with(Format::Paper, 0xBEEF, 300, 4);
    let mut lines = lines.with_shadow(0);
    for (line, lit) in lines.0.iter_mut().zip(Lines::white().with(Format::Paper, 0xBEEF, 300, 4).0) {
        line[240..].copy_from_slice(&lit[240..]);
    }
    let found = lines.detect(&BOTH, CrossingRule::Interpolated, &mut Silent);
    let payloads: Vec<_> = found.iter().map(|detection| detection.payload).collect();
    assert_eq!(payloads, [0xBEEF, 0x1234]);
}

/// What a call leaves in the workspace does not show in the next.
#[test]
fn the_workspace_is_not_remembered() {
    let lines = Lines::white().with(Format::Paper, 0xBEEF, 100, 4);
    let camera = Camera::epuck();
    let mut workspace = Workspace::new();
    let mut run = |upper: &[u8], lower: &[u8]| {
        let rule = CrossingRule::Interpolated;
        detect(upper, lower, &camera, &BOTH, rule, &mut workspace, &mut Silent).len()
    };
    let white = std::vec![255; 480];
    assert_eq!(run(&lines.0[0], &lines.0[1]), 1);
    assert_eq!(run(&white, &lines.0[1]), 0);
    assert_eq!(run(&lines.0[0], &[]), 0);
    assert_eq!(run(&row(0..9).0[0], &row(0..9).0[1]), 0);
    assert_eq!(run(&lines.0[0], &lines.0[1]), 1);
}

/// Barcodes of 30 px with 22 px between them: bars of 1.5 px are seeds of 1 px, which reach 50 px.
fn row(numbers: Range<u32>) -> Lines {
    let add = |lines: Lines, i: u32| lines.with_narrow(Format::Paper, 0x1234 + i, 10 + 52 * i as usize);
    numbers.fold(Lines::white(), add)
}

//= reference/SPEC.md#decode
//= type=test
//# - **DECODE-2** A line MUST give no layers of a format of which it has more than 8 by both thresholds together, and
//# the search in that format end with the ninth (`TooManyLayers`).
#[test]
fn nine_layers_in_a_line_are_too_many() {
    let eight = row(0..8).detect(&BOTH, CrossingRule::Interpolated, &mut Silent);
    let payloads: Vec<u32> = eight.iter().map(|detection| detection.payload).collect();
    assert_eq!(payloads, (0x1234..0x123C).collect::<Vec<u32>>());

    let mut nine = row(0..9);
    let events = nine.events(&[Landmark::paper()]);
    assert_eq!(events.iter().filter(|event| event.starts_with("decoded")).count(), 16);
    // Nothing is looked for by the local threshold any more.
    let last = ["Upper Global Paper 426", "Upper Global TooManyLayers", "Upper Local regions", "Lower threshold"];
    assert_eq!(events[18..22], last);
    let last = ["Lower Global Paper 426", "Lower Global TooManyLayers", "Lower Local regions"];
    let searched = events.iter().take_while(|event| !event.starts_with("Paper")).collect::<Vec<_>>();
    assert_eq!(searched[searched.len() - 3..], last.iter().collect::<Vec<_>>());
    // The other line keeps its layers, but they have no partners.
    nine.0[1][420..].fill(255);
    let events = nine.events(&[Landmark::paper()]);
    assert_eq!(events.iter().filter(|event| event.starts_with("decoded")).count(), 16);
    assert!(!events.iter().any(|event| event.contains("Ok")));
}

/// The last barcode of a row lies in the shadow, where only the local threshold sees it.
#[test]
fn layers_of_both_thresholds_are_counted_together() {
    let eight = row(1..9).with_shadow(420).detect(&BOTH, CrossingRule::Interpolated, &mut Silent);
    let payloads: Vec<u32> = eight.iter().map(|detection| detection.payload).collect();
    assert_eq!(payloads, (0x1235..0x123D).collect::<Vec<u32>>());

    let events = row(0..9).with_shadow(420).events(&[Landmark::paper()]);
    assert_eq!(events.iter().filter(|event| event.starts_with("decoded")).count(), 16);
    assert_eq!(events.iter().filter(|event| *event == "Repeated").count(), 16);
    let searched = events.iter().take_while(|event| !event.starts_with("Paper")).collect::<Vec<_>>();
    assert_eq!(searched[searched.len() - 2..], ["Lower Local Paper 426", "Lower Local TooManyLayers"]);
}

/// Lines of a barcode as a camera sees it.
fn seen(view: &View, payload: u32) -> Lines {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let (upper, lower) = encode(view.format, payload).unwrap();
    Lines([upper, lower].map(|half_word| view.line(480, half_word, &mut random)))
}

/// `ERRATA-1`'s camera: the columns of a barcode's ends give its distance and heading back.
#[test]
fn a_seen_landmark_is_found_with_its_pose() {
    for (format, pixels, degrees, decoder) in [
        (Format::Paper, 3.0, 20.0_f64, Decoder::Threshold),
        (Format::Wide, 2.0, -40.0, Decoder::Threshold),
        (Format::Paper, 1.2, 0.0, Decoder::Trellis),
        (Format::Wide, 1.3, 30.0, Decoder::Trellis),
    ] {
        let view = View { blur: 0.6, ..View::turned(format, pixels, degrees.to_radians()) };
        let found = seen(&view, 0xBEEF).detect(&BOTH, CrossingRule::Interpolated, &mut Silent);
        assert_eq!(found.iter().map(|found| found.payload).collect::<Vec<_>>(), [0xBEEF]);
        let Detection { camera_in_landmark, covariance, fit, .. } = found[0];
        assert_eq!((found[0].decoder, found[0].format, found[0].estimator()), (decoder, format, Estimator::Fit));
        assert!(fit.unwrap().margin > 0);
        // s = f (W/d) cos of the inclination, at the middle of the image.
        let half_width = 0.0015 * f64::from(format.stripes()) / 2.0;
        let distance = 640.0 * half_width * degrees.to_radians().cos() / view.s;
        let (x, y) = (camera_in_landmark.x.to_num::<f64>(), camera_in_landmark.y.to_num::<f64>());
        let deviation = |variance: i64| (variance as f64 / 2_f64.powi(48)).sqrt();
        let off = (x.hypot(y) - distance).abs();
        assert!(off <= 4.0 * (deviation(covariance.xx) + deviation(covariance.yy)), "{off} {distance}");
        let heading = f64::from(camera_in_landmark.theta.to_bits()) / 2_f64.powi(31) * 180.0;
        let inclination = if heading > 0.0 { heading - 180.0 } else { heading + 180.0 };
        let off = (inclination.abs() - degrees.abs()).abs().to_radians();
        assert!(off <= 4.0 * deviation(covariance.tt), "{inclination} {degrees} {}", deviation(covariance.tt));
    }
}

/// The first threshold's candidate, and where it is found no extents are tried; without threshold extents alone.
//= reference/SPEC.md#extent
//= type=test
//# - **EXTENT-5** A pair of which an extent shares a pixel with the same line's ROI or extent of a detection of any
//# format MUST be left out.
#[test]
fn extents_are_tried_where_nothing_was_found() {
    let of = |pixels: f64| {
        let events = seen(&View::turned(Format::Paper, pixels, 0.0), 0xBEEF).events(&[Landmark::paper()]);
        events.into_iter().skip_while(|event| !event.starts_with("Paper")).collect::<Vec<_>>()
    };
    assert_eq!(of(2.0), ["Paper Threshold Ok(beef)", "fitted even", "detection beef"]);
    let trellis = of(1.15);
    assert!(trellis[0].starts_with("Paper extents"), "{trellis:?}");
    assert_eq!(trellis[1..], ["fitted even", "Paper Trellis Ok(beef)", "detection beef"]);
}

/// Bars of a foreign barcode give extents without end: four pairs are tried.
#[test]
fn four_pairs_of_extents_are_tried() {
    let text: Vec<u8> = (0..480).map(|pixel| if pixel % 13 < 6 { 40 } else { 220 }).collect();
    let events = Lines([text.clone(), text]).events(&BOTH);
    let tried = |format: &str| events.iter().filter(|event| event.starts_with(&format!("{format} extents"))).count();
    assert_eq!((tried("Paper"), tried("Wide")), (4, 4));
}

#[test]
fn memory_keeps_to_its_budget() {
    assert!(size_of::<Detection>() <= 256);
    assert!(size_of::<Workspace>() <= 1536);
    assert!(size_of::<Detections>() <= 2056);
    assert!(size_of::<Workspace>() + size_of::<Detections>() + 2 * 480 < 4608);
}

/// Lines between noise and barcodes: runs of any width and value.
fn line(width: usize) -> impl Strategy<Value = Vec<u8>> {
    let run = (prop_oneof![Just(0_u8), Just(255_u8), any::<u8>()], 1_usize..12);
    prop::collection::vec(run, 1..400).prop_map(move |runs| {
        let mut line: Vec<u8> = runs.iter().flat_map(|&(value, width)| std::iter::repeat_n(value, width)).collect();
        line.resize(width, 255);
        line
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_line_panics(
        width in 32_u16..=640,
        lines in (line(640), line(640)),
        principal in 0.0..1.0_f64,
        whole_pixel in any::<bool>(),
    ) {
        let principal = Column::from_num(principal * f64::from(width - 1));
        let camera = Camera::new(width, principal, FocalLength::from_num(width)).unwrap();
        let (upper, lower) = (&lines.0[..usize::from(width)], &lines.1[..usize::from(width)]);
        let rule = if whole_pixel { CrossingRule::WholePixel } else { CrossingRule::Interpolated };
        detect(upper, lower, &camera, &BOTH, rule, &mut Workspace::new(), &mut Silent);
    }

    /// Landmarks with damaged pixels: they get far into the pipeline before they fail.
    #[test]
    fn no_damaged_landmark_panics(
        payload in 0_u32..1 << 16,
        places in (0_usize..100, 250_usize..280, 1_usize..7),
        damage in prop::collection::vec((any::<bool>(), 0_usize..480, any::<u8>()), 0..40),
    ) {
        prop_assume!(encode(Format::Paper, payload).is_ok() && encode(Format::Wide, payload).is_ok());
        let mut lines = Lines::white()
            .with(Format::Paper, payload, places.0, places.2)
            .with(Format::Wide, payload, places.1, places.2);
        for (lower, pixel, value) in damage {
            lines.0[usize::from(lower)][pixel] = value;
        }
        for rule in RULES {
            let found = lines.detect(&BOTH, rule, &mut Silent);
            prop_assert!(found.len() <= 8);
        }
    }
}
