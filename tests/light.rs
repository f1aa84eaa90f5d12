//! Uneven light: shadow edges, gradients and reflections, over frontal scenes with stripes of at least 2 px.

use core::ops::RangeInclusive;
use rand::{Rng, RngExt};
use rayon::prelude::*;
use reference::camera::Camera;
use reference::crossing::CrossingRule;
use reference::frame::Pose;
use reference::landmark::{Format, Landmark};
use reference::merge::Decoder;
use reference::range;
use reference::render::{Light, Patch, Posted, Scene, Sensor};
use verify::lockstep::Setting;
use verify::port::{Cameras, Landmarks};
use verify::scenes::{self, Staged};
use verify::trace::Trace;

/// Scenes of each kind.
const SCENES: u64 = 4000;

/// Distances, centimetres: 45 cm is where stripes of 1.5 mm are 2.1 px wide.
const CENTIMETRES: [u32; 8] = [10, 15, 20, 25, 30, 35, 40, 45];

/// Columns beside the barcode at which a shadow's edge counts as inside, pixels.
const BESIDE: f64 = 4.0;

/// A pipeline as a function of setting and scan lines.
type Pipeline = fn(&Setting, &[u8], &[u8]) -> Trace;

/// The pipelines that are measured, by name.
const PIPELINES: [(&str, Pipeline); 2] =
    [("reference", Setting::run_reference), ("fixedpoint", Setting::run_fixedpoint)];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Nothing but even light, for comparison.
    Even,
    /// A shadow's edge at a random column: 3:1, either side dark.
    ShadowEdge,
    /// A shadow's edge within the barcode or up to [`BESIDE`] beside it.
    ShadowEdgeInside,
    /// 4:1 from one end of the line to the other, 200 grey levels at the bright one.
    Gradient,
    /// Two fifths of the light, and 24 px of five times that, at least 20 px from the barcode.
    Reflection,
    /// 60 px of a third of the light.
    ShadowBand,
}

/// A frontal view and the columns of the barcode's ends.
fn frontal(seed: u64, index: u64) -> (Staged, RangeInclusive<f64>) {
    let mut rng = scenes::generator(seed, index);
    let distance = f64::from(CENTIMETRES[usize::try_from(index).unwrap() % CENTIMETRES.len()]) / 100.0;
    let bearing = rng.random_range(-0.1..0.1) * (distance / 0.2).min(1.0);
    let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
    let camera_in_world = scenes::viewpoint(distance, bearing, bearing);
    let landmark_in_world = Pose::new(0.0, 0.0, 0.0);
    let pose = landmark_in_world.inverse() * camera_in_world;
    assert!(range::narrowest_stripe(&camera, &landmark, &pose) >= 2.0);
    let [a, b] = [-1.0, 1.0].map(|end| camera.project_stripe(&pose, end * landmark.half_width()).column);
    let scene = Scene {
        camera_in_world,
        landmarks: vec![Posted { landmark_in_world, landmark, payload: scenes::payload(Format::Paper, &mut rng) }],
        clutter: Vec::new(),
        light: Light::default(),
        sensor: Sensor { blur: 0.5, noise: 2.0 },
    };
    (Staged { scene, rng }, a.min(b)..=a.max(b))
}

/// The light of a kind of scene; `code` are the columns that the barcode covers.
fn light<R: Rng>(kind: Kind, code: &RangeInclusive<f64>, rng: &mut R) -> Light {
    let even = Light::default();
    let last = Camera::epuck().width as f64 - 1.0;
    let shadow = |left, right| Light { patch: Some(Patch { left, right, factor: 1.0 / 3.0 }), ..even };
    match kind {
        Kind::Even => even,
        Kind::ShadowEdge | Kind::ShadowEdgeInside => {
            let columns = if kind == Kind::ShadowEdge { 0.0..last } else { code.start() - BESIDE..code.end() + BESIDE };
            let edge = rng.random_range(columns);
            if rng.random() { shadow(f64::NEG_INFINITY, edge) } else { shadow(edge, f64::INFINITY) }
        }
        Kind::Gradient => Light { exposure: 0.625, gradient: if rng.random() { 1.2 } else { -1.2 }, ..even },
        Kind::Reflection => {
            let (width, apart) = (24.0, 20.0);
            let left = loop {
                let left = rng.random_range(0.0..last - width);
                if left + width <= code.start() - apart || left >= code.end() + apart {
                    break left;
                }
            };
            Light { exposure: 0.4, patch: Some(Patch { left, right: left + width, factor: 5.0 }), ..even }
        }
        Kind::ShadowBand => {
            let left = rng.random_range(0.0..last - 60.0);
            shadow(left, left + 60.0)
        }
    }
}

/// What became of a scene.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    scenes: u64,
    /// The landmark's payload is among the detections.
    decoded: u64,
    /// It is even among those that the trellis read.
    by_trellis: u64,
    /// Detections of any other payload.
    wrong: u64,
}

impl Count {
    fn of(trace: &Trace, truth: (Format, u32)) -> Self {
        let right = trace.detections.iter().filter(|found| (found.format, found.payload) == truth);
        Self {
            scenes: 1,
            decoded: u64::from(right.clone().count() > 0),
            by_trellis: u64::from(right.clone().any(|found| found.decoder == Decoder::Trellis)),
            wrong: (trace.detections.len() - right.count()) as u64,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            scenes: self.scenes + other.scenes,
            decoded: self.decoded + other.decoded,
            by_trellis: self.by_trellis + other.by_trellis,
            wrong: self.wrong + other.wrong,
        }
    }

    fn percent(&self, of: u64) -> f64 {
        100.0 * of as f64 / self.scenes as f64
    }
}

/// Scenes of a kind through a pipeline, by distance.
fn measure(kind: Kind, seed: u64, pipeline: Pipeline) -> [Count; CENTIMETRES.len()] {
    let cameras = Cameras::new(Camera::epuck()).unwrap();
    let setting = Setting { cameras, landmarks: Landmarks::both(), rule: CrossingRule::Interpolated };
    let one = |index: u64| {
        let (mut staged, code) = frontal(seed, index);
        staged.scene.light = light(kind, &code, &mut staged.rng);
        let truth = staged.truth()[0];
        let [upper, lower] = staged.render(&setting.cameras.reference);
        let mut counts = [Count::default(); CENTIMETRES.len()];
        counts[usize::try_from(index).unwrap() % CENTIMETRES.len()] =
            Count::of(&pipeline(&setting, &upper, &lower), truth);
        counts
    };
    let sum = |a: [Count; CENTIMETRES.len()], b: [Count; CENTIMETRES.len()]| core::array::from_fn(|i| a[i].plus(b[i]));
    (0..SCENES).into_par_iter().map(one).reduce(|| [Count::default(); CENTIMETRES.len()], sum)
}

/// Measures, prints and asserts the smallest share, in per cent.
fn check(kind: Kind, seed: u64, at_least: f64) {
    for (name, pipeline) in PIPELINES {
        let by_distance = measure(kind, seed, pipeline);
        let total = by_distance.into_iter().fold(Count::default(), Count::plus);
        let (decoded, trellis) = (total.percent(total.decoded), total.percent(total.by_trellis));
        let each: Vec<String> =
            by_distance.iter().map(|count| format!("{:.1}", count.percent(count.decoded))).collect();
        println!(
            "{name}, {kind:?}: {decoded:.2} % of {} decoded, {trellis:.2} % by the trellis, {} wrong; \
             by distance {}",
            total.scenes,
            total.wrong,
            each.join(" ")
        );
        assert_eq!(total.scenes, SCENES);
        let share = if kind == Kind::ShadowEdgeInside { of_random_columns(&by_distance) } else { decoded };
        assert!(share >= at_least, "{name}, {kind:?}: {share:.2} % of {} decoded", total.scenes);
    }
}

/// The share in per cent of edges at a random column of the line that are inside the code: as many scenes of each distance
/// were drawn, but a wide code has more edges inside.
fn of_random_columns(by_distance: &[Count; CENTIMETRES.len()]) -> f64 {
    // 30 mm at 640 px, and what counts beside it.
    let width = |centimetres: u32| 30.0 * 64.0 / f64::from(centimetres) + 2.0 * BESIDE;
    let (mut sum, mut weights) = (0.0, 0.0);
    for (count, &centimetres) in by_distance.iter().zip(&CENTIMETRES) {
        sum += width(centimetres) * count.percent(count.decoded);
        weights += width(centimetres);
    }
    println!("of edges at a random column that are inside: {:.2} %", sum / weights);
    sum / weights
}

#[test]
fn even_light() {
    check(Kind::Even, 1, 99.0);
}

#[test]
fn a_shadow_edge_anywhere() {
    check(Kind::ShadowEdge, 2, 99.0);
}

#[test]
fn a_shadow_edge_inside_the_barcode() {
    check(Kind::ShadowEdgeInside, 3, 97.0);
}

#[test]
fn a_gradient_of_four_to_one() {
    check(Kind::Gradient, 4, 99.0);
}

#[test]
fn a_reflection_beside_the_barcode() {
    check(Kind::Reflection, 5, 99.0);
}

/// Where the band covers the barcode in part, dark is between bright on both sides: no threshold of either kind. Printed.
#[test]
fn a_shadow_band() {
    check(Kind::ShadowBand, 6, 0.0);
}
