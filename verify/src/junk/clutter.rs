//! Dark strips that fill both rows: posts, door frames, fences.

use super::Ink;
use super::edges::{Blur, Edges};
use rand::{Rng, RngExt};
use reference::camera::Camera;

/// Posts, a fence, or both.
pub(super) fn draw<R: Rng>(camera: &Camera, blur: Blur, rng: &mut R) -> Ink {
    let mut edges = Edges::new(camera.width, blur);
    let width = camera.width as f32;
    // In half of the pairs the camera is tilted, and a strip lies up to 3 px beside itself.
    let tilt = if rng.random() { 0.0 } else { rng.random_range(-3.0..3.0) };
    let what = rng.random_range(0..4);
    if what < 3 {
        for _ in 0..rng.random_range(1..=20) {
            let post = 60.0_f32.powf(rng.random());
            strip(&mut edges, rng.random_range(-post..width), post, tilt, rng.random_range(0.3..=1.0));
        }
    }
    if what > 0 {
        fence(&mut edges, width, tilt, rng);
    }
    edges.into_ink()
}

/// Equal pickets at equal distances, seen under perspective, each a little out of its place.
fn fence<R: Rng>(edges: &mut Edges, width: f32, tilt: f32, rng: &mut R) {
    let ink = rng.random_range(0.5..=1.0);
    let share = rng.random_range(0.2..0.8);
    let jitter = rng.random_range(0.0..0.2);
    // The pitch grows from picket to picket by up to 4 %.
    let growth: f32 = rng.random_range(0.96..1.04);
    let mut pitch: f32 = rng.random_range(3.0..40.0);
    let mut left = rng.random_range(-100.0..0.5 * width);
    let end = rng.random_range(left..1.5 * width);
    while left < end.min(width) && pitch > 1.0 {
        strip(edges, left + pitch * rng.random_range(-jitter..=jitter), share * pitch, tilt, ink);
        left += pitch;
        pitch *= growth;
    }
}

fn strip(edges: &mut Edges, left: f32, width: f32, tilt: f32, ink: f32) {
    edges.bar(0, left, left + width, ink);
    edges.bar(1, left + tilt, left + width + tilt, ink);
}
