//! Target `scene`: what the reference's renderer draws, through both pipelines.
//!
//! Input: a byte of options, then the camera, where it stands, the light, the sensor, and until the bytes end landmarks and
//! dark strips. A landmark's payload is drawn as the code word that it has, so that its check byte is always right.

use crate::draw::Draw;
use crate::lockstep;
use core::f64::consts::FRAC_PI_3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reference::camera::Camera;
use reference::codeword;
use reference::crossing::CrossingRule;
use reference::frame::{self, Point, Pose, World};
use reference::landmark::{Format, Landmark};
use reference::render::{Clutter, Light, Patch, Posted, Scene, Sensor, render};
use verify::lockstep::Setting;
use verify::port::{Cameras, Landmarks};
use verify::scenes::{space, viewpoint};
use verify::trace::Trace;

/// The most landmarks and the most strips of a scene.
const MOST: usize = 3;

/// One input.
///
/// # Panics
/// If the pipelines differ by more than `SAME` allows, or accept something in a scene of the certificate's kind that is not
/// there.
pub fn run(data: &[u8]) {
    let mut draw = Draw::new(data);
    let options = draw.byte();
    let is_plain = options & 1 == 0;
    let camera = if is_plain || options & 2 == 0 { Camera::epuck() } else { any_camera(&mut draw) };
    let mut scene = if is_plain { plain(&mut draw) } else { anything(&mut draw) };
    let seed = u64::from(draw.word());
    furnish(&mut scene, is_plain, &mut draw);
    let Some(cameras) = camera.checked().ok().and_then(Cameras::new) else { return };
    let Some(landmarks) = searched(&scene, options) else { return };
    let rule = if options & 4 == 0 { CrossingRule::Interpolated } else { CrossingRule::WholePixel };
    let setting = Setting { cameras, landmarks, rule };
    let lines = render(&camera, &scene, &mut ChaCha8Rng::seed_from_u64(seed));
    let [upper, lower] = lines.expect("only payloads with a code word are drawn");
    let traces = lockstep::run(&setting, &upper, &lower);
    if is_plain && rule == CrossingRule::Interpolated {
        for trace in &traces {
            only_what_is_there(&scene, trace);
        }
    }
}

/// A camera that CAM-7 allows.
fn any_camera(draw: &mut Draw<'_>) -> Camera {
    let width = 32 + usize::from(draw.word()) % 609;
    let shortest = width as f64 / 2.0;
    Camera {
        width,
        focal_length: shortest * (2048.0 / shortest).powf(draw.within(0.0..1.0)),
        principal_column: draw.within(0.0..width as f64 - 1.0),
        ..Camera::epuck()
    }
}

/// A view and a light of the space that the certificate draws from.
fn plain(draw: &mut Draw<'_>) -> Scene {
    let camera_in_world =
        viewpoint(draw.within(space::DISTANCE), draw.within(space::INCLINATION), draw.within(space::BEARING));
    let light =
        Light { exposure: draw.within(space::EXPOSURE), gradient: draw.within(space::GRADIENT), ..Light::default() };
    let sensor = Sensor { blur: draw.within(space::BLUR), noise: draw.within(space::NOISE) };
    Scene { camera_in_world, landmarks: Vec::new(), clutter: Vec::new(), light, sensor }
}

/// Views, lights and sensors beyond that.
fn anything(draw: &mut Draw<'_>) -> Scene {
    let camera_in_world =
        viewpoint(draw.within(0.02..2.0), draw.within(-1.5 * FRAC_PI_3..1.5 * FRAC_PI_3), draw.within(-1.0..1.0));
    let mut light = Light {
        exposure: draw.within(0.05..3.0),
        gradient: draw.within(-1.9..1.9),
        white: draw.within(0.0..255.0),
        black: draw.within(0.0..255.0),
        patch: None,
    };
    let sensor = Sensor { blur: draw.within(0.0..2.0), noise: draw.within(0.0..12.0) };
    let (left, width) = (draw.within(-50.0..690.0), draw.within(0.0..400.0));
    let factor = draw.within(0.0..3.0);
    if width > 0.0 {
        light.patch = Some(Patch { left, right: left + width, factor });
    }
    Scene { camera_in_world, landmarks: Vec::new(), clutter: Vec::new(), light, sensor }
}

/// Landmarks and strips until the bytes or the places for them end.
fn furnish(scene: &mut Scene, is_plain: bool, draw: &mut Draw<'_>) {
    while !draw.is_empty() && scene.landmarks.len() < MOST && scene.clutter.len() < MOST {
        let kind = draw.byte();
        if kind & 1 == 0 {
            let landmark_in_world = place(scene.landmarks.len(), is_plain, draw);
            scene.landmarks.extend(post(kind, is_plain, landmark_in_world, draw));
        } else {
            scene.clutter.push(strip(is_plain, draw));
        }
    }
}

/// In a plain scene as the certificate's scenes have them: the first landmark at the origin, others 10 to 16 cm to either
/// side of it; anywhere otherwise.
fn place(before: usize, is_plain: bool, draw: &mut Draw<'_>) -> Pose<World, frame::Landmark> {
    let aside = draw.within(0.10..0.16);
    match (is_plain, before) {
        (true, 1) => Pose::new(0.0, -aside, 0.0),
        (true, 2) => Pose::new(0.0, aside, 0.0),
        (true, _) => Pose::new(0.0, 0.0, 0.0),
        (false, _) => Pose::new(draw.within(-0.3..0.3), draw.within(-0.5..0.5), draw.within(-1.5..1.5)),
    }
}

/// A landmark that has a code word (CODE-5, CODE-6).
fn post(
    kind: u8,
    is_plain: bool,
    landmark_in_world: Pose<World, frame::Landmark>,
    draw: &mut Draw<'_>,
) -> Option<Posted> {
    let format = if kind & 2 == 0 { Format::Paper } else { Format::Wide };
    let payload = draw.long() & ((1 << format.payload_bits()) - 1);
    let mut landmark = Landmark::new(format);
    if !is_plain && kind & 4 != 0 {
        landmark.stripe_width = draw.within(0.5e-3..20e-3);
        landmark.stripe_height = draw.within(1e-3..0.5);
    }
    codeword::encode(format, payload).is_ok().then_some(Posted { landmark_in_world, landmark, payload })
}

/// A dark strip on the wall; in a plain scene beyond the places of landmarks.
fn strip(is_plain: bool, draw: &mut Draw<'_>) -> Clutter {
    let side = if draw.byte() & 1 == 0 { 1.0 } else { -1.0 };
    let inner = if is_plain { draw.within(0.23..0.40) } else { draw.within(-0.1..0.4) };
    let outer = inner + draw.within(0.002..0.06);
    let (one, other) = (side * inner, side * outer);
    let ink = draw.within(0.3..1.0);
    Clutter { left: Point::new(0.0, one.min(other)), right: Point::new(0.0, one.max(other)), ink }
}

/// Both formats, with the dimensions of the first landmark of each.
fn searched(scene: &Scene, options: u8) -> Option<Landmarks> {
    let of = |format: Format| {
        let posted = scene.landmarks.iter().find(|posted| posted.landmark.format == format);
        posted.map_or(Landmark::new(format), |posted| posted.landmark)
    };
    let [paper, wide] = [Format::Paper, Format::Wide].map(of);
    Landmarks::of(if options & 8 == 0 { vec![paper, wide] } else { vec![wide, paper] })
}

/// What is accepted is what was drawn, as the certificate counts it.
fn only_what_is_there(scene: &Scene, trace: &Trace) {
    for found in &trace.detections {
        let here = |posted: &Posted| (posted.landmark.format, posted.payload) == (found.format, found.payload);
        assert!(scene.landmarks.iter().any(here), "{:?} {:#x} is not in the scene", found.format, found.payload);
    }
}
