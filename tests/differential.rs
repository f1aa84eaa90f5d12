//! Both pipelines on arbitrary scan lines: random, adversarial run lengths, saturated, constant, drifting, and layers of
//! real stripes with faults. Whatever the bytes, exact stages never differ and bounded ones stay in their bounds.
//!
//! `BARLOC_LINES` sets the number of lines (default 1,000,000). A failure prints the shrunk lines.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use reference::camera::Camera;
use reference::codeword::layers;
use reference::crossing::CrossingRule;
use reference::frame::Pose;
use reference::landmark::{Format, Landmark, stripes};
use reference::render::{Light, Posted, Scene, Sensor, render};
use std::cell::RefCell;
use std::fmt;
use std::thread;
use verify::bounds::{Class, Stage, TABLE};
use verify::lockstep::{Setting, compare};
use verify::port::{Cameras, Landmarks};
use verify::scenes::viewpoint;
use verify::tally::{Frame, Part, Tally};

const WIDTH: usize = 480;

/// A scan line that prints as its runs, `width x level`.
#[derive(Clone)]
struct Line(Vec<u8>);

impl fmt::Debug for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let runs = self.0.chunk_by(|one, next| one == next).map(|run| format!("{}x{}", run.len(), run[0]));
        f.write_str(&runs.collect::<Vec<_>>().join(" "))
    }
}

/// A line made of runs of (width, level), repeated until it is full.
fn of_runs(runs: &[(usize, u8)]) -> Vec<u8> {
    runs.iter().cycle().flat_map(|&(width, level)| std::iter::repeat_n(level, width)).take(WIDTH).collect()
}

/// A layer of stripes of `width` px (in quarters of a pixel, averaged over pixels) that begins at `start`, with faults:
/// pixels that have another value.
fn of_stripes(bars: &[bool], start: usize, quarters: usize, levels: (u8, u8), faults: &[(usize, u8)]) -> Vec<u8> {
    let (black, white) = (usize::from(levels.0), usize::from(levels.1));
    let ink = |quarter: usize| {
        let stripe = quarter.checked_sub(4 * start).map(|q| q / quarters);
        stripe.and_then(|stripe| bars.get(stripe)).copied().unwrap_or(false)
    };
    let mut line: Vec<u8> = (0..WIDTH)
        .map(|pixel| {
            let covered = (4 * pixel..4 * pixel + 4).filter(|&quarter| ink(quarter)).count();
            u8::try_from((covered * black + (4 - covered) * white) / 4).unwrap_or(u8::MAX)
        })
        .collect();
    for &(pixel, level) in faults {
        line[pixel] = level;
    }
    line
}

fn arbitrary_runs(widest: usize) -> impl Strategy<Value = Vec<u8>> {
    vec((1..=widest, any::<u8>()), 1..120).prop_map(|runs| of_runs(&runs))
}

/// Dark and bright runs of few pixels: what bars look like, and fill every buffer.
fn bars(widest: usize) -> impl Strategy<Value = Vec<u8>> {
    (vec(1..=widest, 2..160), 0..60_u8, 130..=255_u8).prop_map(|(widths, dark, bright)| {
        let runs: Vec<_> =
            widths.iter().enumerate().map(|(i, &width)| (width, if i % 2 == 0 { bright } else { dark })).collect();
        of_runs(&runs)
    })
}

fn layer() -> impl Strategy<Value = Vec<u8>> {
    (
        any::<bool>(),
        any::<u16>(),
        1..200_usize,
        4..60_usize,
        (0..60_u8, 130..=255_u8),
        vec((0..WIDTH, any::<u8>()), 0..4),
    )
        .prop_map(|(wide, word, start, quarters, levels, faults)| {
            let format = if wide { Format::Wide } else { Format::Paper };
            of_stripes(&stripes(format, u32::from(word)), start, quarters, levels, &faults)
        })
}

fn drifting() -> impl Strategy<Value = Vec<u8>> {
    (any::<u8>(), vec(-40..40_i16, WIDTH)).prop_map(|(start, steps)| {
        let mut level = i16::from(start);
        let step = |step: &i16| {
            level = (level + step).clamp(0, 255);
            u8::try_from(level).unwrap_or(0)
        };
        steps.iter().map(step).collect()
    })
}

fn scan_line() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        3 => vec(any::<u8>(), WIDTH),
        3 => arbitrary_runs(40),
        4 => bars(3),
        4 => bars(24),
        8 => layer(),
        2 => vec(prop_oneof![Just(0_u8), Just(255_u8)], WIDTH),
        2 => drifting(),
        1 => any::<u8>().prop_map(|level| vec![level; WIDTH]),
        // Near the threshold everywhere: what the contrast filter is for.
        2 => vec(100..156_u8, WIDTH),
    ]
}

/// Both layers of one payload with faults of their own, the lower one up to 4 px aside.
fn landmark() -> impl Strategy<Value = [Line; 2]> {
    let faults = || vec((0..WIDTH, any::<u8>()), 0..3);
    (any::<bool>(), any::<u32>(), 1..200_usize, 0..5_usize, 5..60_usize, (0..60_u8, 130..=255_u8), [faults(), faults()])
        .prop_filter_map("both layers are the same", |(wide, payload, start, aside, quarters, levels, faults)| {
            let format = if wide { Format::Wide } else { Format::Paper };
            let [upper, lower] = layers(format, payload >> (32 - format.payload_bits())).ok()?;
            let upper = of_stripes(&upper, start, quarters, levels, &faults[0]);
            Some([Line(upper), Line(of_stripes(&lower, start + aside, quarters, levels, &faults[1]))])
        })
}

/// Two lines: independent, twice the same, or a landmark's.
fn pair() -> impl Strategy<Value = [Line; 2]> {
    prop_oneof![
        2 => [scan_line(), scan_line()].prop_map(|lines| lines.map(Line)),
        1 => scan_line().prop_map(|line| [Line(line.clone()), Line(line)]),
        1 => landmark(),
    ]
}

fn check(rule: CrossingRule, cases: u32, seed: u8) -> Tally {
    let cameras = Cameras::new(Camera::epuck()).unwrap();
    let setting = Setting { cameras, landmarks: Landmarks::both(), rule };
    let tally = RefCell::new(Tally::default());
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]));
    let outcome = runner.run(&pair(), |[Line(upper), Line(lower)]| {
        let [reference, port] = setting.run(&upper, &lower);
        let mut one = Tally::default();
        let frame = Frame { part: Part::Lines, index: tally.borrow().frames };
        compare(&setting, frame, &reference, &port, &mut one);
        let failing = one.failing();
        if !failing.is_empty() {
            return Err(TestCaseError::fail(format!("not the same: {failing:?}")));
        }
        let sum = tally.take().merged(&one);
        *tally.borrow_mut() = sum;
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{rule:?}: {failure}");
    }
    tally.into_inner()
}

/// A camera within CAM-7 and a view of a landmark by it: distances at which stripes are 1 to 30 px wide.
fn views_by_any_camera() -> impl Strategy<Value = (Camera, Vec<Landmark>, Scene, u64)> {
    let camera = (32..=640_usize, 0.5..1.0_f64, 0.0..1.0_f64).prop_map(|(width, length, column)| Camera {
        width,
        // From half the width to 2048 px, most of them short.
        focal_length: width as f64 / 2.0 * (4096.0 / width as f64).powf(2.0 * length - 1.0),
        principal_column: column * (width as f64 - 1.0),
        ..Camera::epuck()
    });
    let landmark = (any::<bool>(), any::<u32>(), 0.5e-3..20e-3_f64);
    let view = (1.0..30.0_f64, -1.0..1.0_f64, -0.5..0.5_f64, 0.0..4.0_f64, any::<u64>());
    (camera, landmark, view).prop_filter_map("no such view", |(camera, landmark, view)| {
        let (wide, payload, stripe_width) = landmark;
        let format = if wide { Format::Wide } else { Format::Paper };
        let payload = payload >> (32 - format.payload_bits());
        layers(format, payload).ok()?;
        let camera = camera.checked().ok()?;
        let (pixels, inclination, place, noise, seed) = view;
        let distance = camera.focal_length * stripe_width / pixels;
        // Somewhere in the middle half of the image.
        let column = (0.5 + place) * camera.width as f64 - camera.principal_column;
        let bearing = (column / camera.focal_length).atan();
        let landmark = Landmark { stripe_width, stripe_height: 10.0 * distance, ..Landmark::new(format) };
        let scene = Scene {
            camera_in_world: viewpoint(distance, inclination, bearing),
            landmarks: vec![Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload }],
            clutter: Vec::new(),
            light: Light::default(),
            sensor: Sensor { noise, ..Sensor::default() },
        };
        let other = if wide { Format::Paper } else { Format::Wide };
        Some((camera, vec![landmark, Landmark { format: other, ..landmark }], scene, seed))
    })
}

/// Sizes, focal lengths and principal columns that the port's formats cannot hold exactly; stripes of any width.
//= reference/SPEC.md#extent
//= type=test
//# - **EXTENT-5** A pair of which an extent shares a pixel with the same line's ROI or extent of a detection of any
//# format MUST be left out.
//= reference/SPEC.md#cov
//= type=test
//# - **COV-2** The mean of a fitted pose MUST be the mean of POSE over the five Gauss-Hermite nodes of `k`, at the mean
//# of `(a, s)` given each.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-8** The decision margin MUST be the least change of the sum of squares over both layers and over the
//# changes of one code stripe, of two neighbours that differ and of three neighbours of which each differs from the
//# next, all other parameters kept and the pixel of a step of light left out.
//= reference/SPEC.md#same
//= type=test
//# - **SAME-2** Homographies, fits, covariances and poses MUST differ by no more than the bound that the error budget
//# derives.
#[test]
fn any_camera_and_stripe_width_give_the_same() {
    let tally = RefCell::new(Tally::default());
    let config = Config { cases: 40_000, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]));
    let outcome = runner.run(&views_by_any_camera(), |(camera, landmarks, scene, seed)| {
        let cameras = Cameras::new(camera).expect("a camera that CAM-7 allows");
        let landmarks = Landmarks::of(landmarks).expect("a landmark that LAND-7 allows");
        let setting = Setting { cameras, landmarks, rule: CrossingRule::Interpolated };
        let [upper, lower] = render(&camera, &scene, &mut ChaCha8Rng::seed_from_u64(seed)).expect("a code word");
        let [reference, port] = setting.run(&upper, &lower);
        let mut one = Tally::default();
        compare(&setting, Frame { part: Part::Lines, index: seed }, &reference, &port, &mut one);
        let failing: Vec<String> =
            one.failing().iter().map(|&stage| format!("{stage:?}: {:?}", one.stage(stage).worst)).collect();
        if !failing.is_empty() {
            return Err(TestCaseError::fail(format!("not the same: {failing:?}")));
        }
        let sum = tally.take().merged(&one);
        *tally.borrow_mut() = sum;
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
    let tally = tally.into_inner();
    for row in &TABLE {
        println!("{}: {} cases, worst {:?}", row.name, tally.stage(row.stage).cases, tally.stage(row.stage).worst);
    }
    assert!(tally.passes());
    let poses = tally.stage(Stage::PoseX).cases;
    assert!(poses > 5_000, "only {poses} poses were compared");
}

//= reference/SPEC.md#homog
//= type=test
//# - **HOMOG-2** The first homography of an ROI MUST be that of the `4 N_guard` transitions of its guards: from the
//# left end the edges `j = 0 .. 2 N_guard - 1`, from the right end `j = N .. N - 2 N_guard + 1`, each with the next
//# transition inwards.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-1** Stripes MUST be sampled from the borders to the centre, alternating, the left one first: 0, N-1, 1,
//# N-2, and so on.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-2** A stripe MUST have the colour of the region that contains the projection of its middle `t = (2 j +
//# 1)/N - 1` by the homography at that time.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-5** A guard stripe `j` from either end that does not fall in the region `j` places from that end of the
//# ROI MUST be refused (`Guard`).
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-6** A code stripe that does not fall in the region of the stripe sampled before it on its side, or in the
//# next region inwards within the ROI, MUST be refused (`Transition`).
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-7** Where a code stripe falls in the next region inwards, the transition between both MUST be added to
//# the homography as the edge between both stripes, and the homography be solved again before the next stripe.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-8** When all stripes are sampled, the left and the right side's last regions MUST be the same or
//# neighbours, with the left one at the left, or else the ROI be refused (`Transition`).
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-9** Where SAMPLE-8 finds neighbours, the transition between both MUST be added as the middle edge `j =
//# N/2`, and the homography be solved again.
//= reference/SPEC.md#sample
//= type=test
//# - **SAMPLE-10** With `ρ = a + s t - k t z - z` the residual of a transition in HOMOG-1 by the last homography, an
//# ROI MUST be refused (`Residual`) if two of its transitions that have one transition between them differ in ρ by more
//# than `e/64` px, to which the whole-pixel rule adds 1 px and the local threshold 1 px.
//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-5** Pairs MUST be formed in the order of the upper layers, and for one upper layer in the order of the
//# lower ones.
//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-6** Layers MUST be ordered as their seeds were taken, those of the global threshold before those of the
//# local one.
//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-8** Each format MUST report its detections in the order of MERGE-5, those of TRELLIS after them, and the
//# formats in the order in which they were asked for.
//= reference/SPEC.md#merge
//= type=test
//# - **MERGE-9** A candidate MUST become a detection if ACCEPT accepts it, and otherwise be refused by the first of
//# ACCEPT's reasons.
//= reference/SPEC.md#extent
//= type=test
//# - **EXTENT-6** Pairs MUST be tried in the order of the upper extent's first pixel, its last pixel, the lower
//# extent's first pixel and its last pixel.
//= reference/SPEC.md#extent
//= type=test
//# - **EXTENT-7** Of each format at most 4 pairs MUST be tried, those of TRELLIS-9 first.
//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-9** A pair of layers of which at least one was found by the local threshold and whose code word CODE-8
//# refuses MUST be decided again as one of EXTENT-7's pairs: fitted under a step of light from the merged homography,
//# with the half words as they were read and a blur of 1/2, and then as TRELLIS-6 to TRELLIS-8 say, each fit from the
//# one before it, under a step of light.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-1** A candidate of the threshold MUST be fitted (FIT) from its merged homography, under even light, and
//# if that is refused or ACCEPT-6 would refuse it, under a step of light.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-11** A pair of extents of which a fit is refused MUST be refused (`NoFit`).
//= reference/SPEC.md#same
//= type=test
//# - **SAME-1** Threshold, regions, hypotheses, crossings, refusals, decoded bits, pairs and payloads MUST be identical
//# in both pipelines, except after a marginal decision.
//= reference/SPEC.md#same
//= type=test
//# - **SAME-3** The decisions of HOMOG-3, SAMPLE-2 and SAMPLE-10 MUST be identical unless the reference's own margin is
//# below the reference's declared error.
#[test]
fn a_million_arbitrary_lines_give_the_same() {
    let lines: u32 = std::env::var("BARLOC_LINES").map_or(1_000_000, |lines| lines.parse().expect("BARLOC_LINES"));
    // Two lines a case, a quarter of the cases by the whole-pixel rule, one thread for each core of the smallest machine.
    let interpolated = lines * 3 / 16;
    let whole_pixel = lines / 16;
    let shards: Vec<_> = [0, 1]
        .map(|seed| {
            thread::spawn(move || {
                let tally = check(CrossingRule::Interpolated, interpolated, seed);
                tally.merged(&check(CrossingRule::WholePixel, whole_pixel, seed))
            })
        })
        .into_iter()
        .collect();
    let tally =
        shards.into_iter().map(|shard| shard.join().unwrap()).fold(Tally::default(), |sum, one| sum.merged(&one));
    println!("{} line pairs, {} marginal, {} differing", tally.frames, tally.marginal_frames, tally.differing_frames);
    for row in &TABLE {
        let stage = tally.stage(row.stage);
        println!("{}: {} cases, {} marginal", row.name, stage.cases, stage.marginal);
        assert!(stage.cases > 0, "{} was never compared", row.name);
        assert!(row.class == Class::Marginal || stage.marginal == 0);
    }
    assert!(tally.passes());
    // These lines tie on purpose: ideal stripes whose middles are edges, and shadows between equal pixels.
    let (marginal, differing) = (tally.marginal_frames, tally.differing_frames);
    assert!(50 * marginal <= tally.frames, "{marginal} of {} are marginal", tally.frames);
    assert!(10_000 * differing <= tally.frames, "{differing} of {} are decided differently", tally.frames);
}
