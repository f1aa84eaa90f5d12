use super::*;
use crate::codeword::encode;
use crate::drawing::{draw, draw_halves, stripes};
use crate::formats::{Angle, Column, FocalLength, Length, Obliquity};
use crate::hypotheses::Hypothesis;
use crate::merge::Detection;
use crate::observer::Silent;
use crate::refusal::{HypothesisRefusal, PairRefusal};
use proptest::prelude::*;
use std::{format, string::String, vec::Vec};

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

    fn regions(&mut self, layer: Layer, _: &Regions) {
        self.0.push(format!("{layer:?} regions"));
    }

    fn line_refused(&mut self, layer: Layer, refusal: LineRefusal) {
        self.0.push(format!("{layer:?} {refusal:?}"));
    }

    fn hypothesis(&mut self, layer: Layer, format: Format, hypothesis: &Hypothesis) {
        self.0.push(format!("{layer:?} {format:?} {}", hypothesis.first_pixel));
    }

    fn refused(&mut self, refusal: HypothesisRefusal) {
        self.0.push(format!("{refusal:?}"));
    }

    fn decoded(&mut self, layer: &DecodedLayer) {
        self.0.push(format!("decoded {:x}", layer.half_word));
    }

    fn pair(&mut self, format: Format, _: &DecodedLayer, _: &DecodedLayer, result: Result<u32, PairRefusal>) {
        self.0.push(format!("{format:?} {result:x?}"));
    }

    fn detection(&mut self, detection: &Detection) {
        self.0.push(format!("detection {:x}", detection.payload));
    }
}

/// The left edge is at 99.5 px and the stripes are 4 px wide: everything about the landmark is known.
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

#[test]
fn events_come_in_their_order() {
    let lines = Lines::white().with(Format::Wide, 0x00F2_0183, 100, 4);
    let expected = [
        "Upper threshold",
        "Upper regions",
        "Lower threshold",
        "Lower regions",
        "Upper Wide 100",
        "decoded f201",
        "Lower Wide 100",
        "decoded 83c2",
        "Wide Ok(f20183)",
        "detection f20183",
    ];
    assert_eq!(lines.events(&[Landmark::wide()]), expected);
    // A repeated format is not searched again.
    assert_eq!(lines.events(&[Landmark::wide(); 3]), expected);
    // As the other format the layers are refused: 24 stripes have more bars, or other places for them.
    let both = lines.events(&BOTH);
    assert_eq!(both[..5], ["Upper threshold", "Upper regions", "Lower threshold", "Lower regions", "Upper Paper 100"]);
    assert_eq!(both[6], "Lower Paper 100");
    assert_eq!(both[8..], expected[4..]);
}

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

#[test]
fn a_refused_line_does_not_change_the_other() {
    let mut lines = Lines::white().with(Format::Wide, 0x00F2_0183, 100, 4);
    lines.0[0].pop();
    let upper_is_short = lines.events(&[Landmark::wide()]);
    let expected = ["Upper Width", "Lower threshold", "Lower regions", "Lower Wide 100", "decoded 83c2"];
    assert_eq!(upper_is_short, expected);
    lines.0[0] = std::vec![200; 480];
    assert_eq!(lines.events(&[Landmark::wide()])[0], "Upper LowContrast");
    lines.0[0] = (0..480).map(|i| if i % 2 == 0 { 0 } else { 255 }).collect();
    let stripes = lines.events(&[Landmark::wide()]);
    assert_eq!(stripes[..2], ["Upper threshold", "Upper TooManyRegions"]);
    assert_eq!(stripes[2..], expected[1..]);
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
    assert_eq!(run(&lines.0[0], &lines.0[1]), 1);
}

/// Barcodes of 30 px with 22 px between them: bars of 1.5 px are seeds of 1 px, which reach 50 px.
#[test]
fn nine_layers_in_a_line_are_too_many() {
    let row = |count: u32| {
        (0..count).fold(Lines::white(), |lines, i| lines.with_narrow(Format::Paper, 0x1234 + i, 10 + 52 * i as usize))
    };
    let eight = row(8).detect(&BOTH, CrossingRule::Interpolated, &mut Silent);
    let payloads: Vec<u32> = eight.iter().map(|detection| detection.payload).collect();
    assert_eq!(payloads, (0x1234..0x123C).collect::<Vec<u32>>());

    let mut nine = row(9);
    let events = nine.events(&[Landmark::paper()]);
    assert_eq!(events.iter().filter(|event| event.starts_with("decoded")).count(), 16);
    assert_eq!(events[20..22], ["Upper Paper 426", "Upper TooManyLayers"]);
    assert_eq!(events[events.len() - 2..], ["Lower Paper 426", "Lower TooManyLayers"]);
    // The other line keeps its layers, but they have no partners.
    nine.0[1][420..].fill(255);
    let events = nine.events(&[Landmark::paper()]);
    assert_eq!(events.iter().filter(|event| event.starts_with("decoded")).count(), 16);
    assert!(!events.iter().any(|event| event.contains("Ok")));
}

#[test]
fn memory_keeps_to_its_budget() {
    assert!(size_of::<Workspace>() <= 1536);
    assert!(size_of::<Workspace>() + 2 * 480 < 4096);
    assert!(size_of::<Detections>() <= 1280);
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
            prop_assert!(found.len() <= 16);
        }
    }
}
