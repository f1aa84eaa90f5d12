//! Noise as a scene.

use super::sensor::normal;
use super::{Ink, MAX_WIDTH};
use rand::{Rng, RngExt};

/// Independent pixels, evenly distributed.
pub(super) fn white<R: Rng>(rng: &mut R) -> Ink {
    [(); 2].map(|()| {
        let mut pixels = [0_u8; MAX_WIDTH];
        rng.fill(&mut pixels[..]);
        pixels.map(|pixel| f32::from(pixel) / 255.0)
    })
}

/// `x_i = α x_{i-1} + sqrt(1 - α²) n_i` with a random correlation α, about a middle grey.
pub(super) fn smooth<R: Rng>(same_rows: bool, rng: &mut R) -> Ink {
    let correlation: f32 = rng.random_range(0.3..0.98);
    let upper = first_order(correlation, rng);
    let lower = if same_rows { upper } else { first_order(correlation, rng) };
    [upper, lower]
}

fn first_order<R: Rng>(correlation: f32, rng: &mut R) -> [f32; MAX_WIDTH] {
    let innovation = (1.0 - correlation * correlation).sqrt();
    let mut x = 0.0;
    normal(rng).map(|deviate| {
        x = correlation * x + innovation * deviate;
        0.5 + 0.25 * x
    })
}
