//! Light and sensor of one pair of lines (RENDER-4, RENDER-5).

use super::{Ink, MAX_WIDTH};
use core::f64::consts::{FRAC_1_SQRT_2, TAU};
use core::ops::Range;
use rand::{Rng, RngExt};
use std::sync::LazyLock;

/// Grey level of white.
const WHITE: Range<f32> = 90.0..270.0;
/// Share of white by which ink is darker.
const CONTRAST: Range<f32> = 0.3..0.95;
/// Change of the light from end to end of the line.
const GRADIENT: Range<f32> = -0.4..0.4;
/// Standard deviation of the noise, grey levels.
const NOISE: Range<f32> = 1.0..4.0;

/// How many normal deviates there are. The largest is 4.2.
const QUANTILES: usize = 1 << 16;

/// The normal distribution's quantiles in the middles of as many equal parts: a deviate is one of them.
static DEVIATES: LazyLock<Vec<f32>> = LazyLock::new(deviates);

/// Φ(z) - p, solved by Newton's method from the quantile before, where Φ is concave: it comes from below.
fn deviates() -> Vec<f32> {
    let mut deviates = vec![0.0; QUANTILES];
    let mut z = 0.0;
    for k in QUANTILES / 2..QUANTILES {
        let p = (k as f64 + 0.5) / QUANTILES as f64;
        for _ in 0..6 {
            z += (p - 0.5 * libm::erfc(-z * FRAC_1_SQRT_2)) * TAU.sqrt() * libm::exp(0.5 * z * z);
        }
        #[expect(clippy::cast_possible_truncation, reason = "noise is a few grey levels")]
        let rounded = z as f32;
        deviates[k] = rounded;
        deviates[QUANTILES - 1 - k] = -rounded;
    }
    deviates
}

/// A normal deviate for every pixel of a line.
pub(super) fn normal<R: Rng>(rng: &mut R) -> [f32; MAX_WIDTH] {
    let mut which = [0_u16; MAX_WIDTH];
    rng.fill(&mut which[..]);
    let deviates = DEVIATES.as_slice();
    which.map(|k| deviates[usize::from(k)])
}

/// Light and noise.
pub(super) struct Sensor {
    white: f32,
    contrast: f32,
    gradient: f32,
    noise: f32,
}

impl Sensor {
    pub(super) fn draw<R: Rng>(rng: &mut R) -> Self {
        Self {
            white: rng.random_range(WHITE),
            contrast: rng.random_range(CONTRAST),
            gradient: rng.random_range(GRADIENT),
            noise: rng.random_range(NOISE),
        }
    }

    /// Grey levels: light on limited ink (RENDER-8), noise, rounding half up, limiting.
    pub(super) fn digitise<R: Rng>(&self, ink: &Ink, width: usize, rng: &mut R) -> [Vec<u8>; 2] {
        let slope = self.gradient / (width as f32 - 1.0);
        [&ink[0], &ink[1]].map(|ink| {
            let noise = normal(rng);
            let pixels = ink.iter().zip(&noise).zip(0_u16..).take(width);
            let line = pixels.map(|((ink, noise), i)| {
                let light = self.white * (1.0 - 0.5 * self.gradient + slope * f32::from(i));
                let grey = light * (1.0 - self.contrast * ink.clamp(0.0, 1.0)) + self.noise * noise;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast limits")]
                let pixel = (grey + 0.5) as u8;
                pixel
            });
            line.collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::generator;

    #[test]
    fn deviates_are_normal() {
        // Φ(1) and Φ(3) from the tables of the normal distribution.
        let share = |limit: f32| DEVIATES.iter().filter(|&&z| z <= limit).count() as f64 / QUANTILES as f64;
        assert!((share(1.0) - 0.841_344_7).abs() < 1.0 / QUANTILES as f64);
        assert!((share(3.0) - 0.998_650_1).abs() < 1.0 / QUANTILES as f64);
        assert!(DEVIATES.is_sorted() && DEVIATES[QUANTILES - 1] > 4.1 && DEVIATES[QUANTILES - 1] < 4.4);
        let variance = DEVIATES.iter().map(|z| f64::from(z * z)).sum::<f64>() / QUANTILES as f64;
        assert!((variance - 1.0).abs() < 1e-3, "{variance}");
    }

    #[test]
    fn grey_levels_are_lit_rounded_half_up_and_limited() {
        let level = |white: f32, gradient: f32, ink: f32| {
            let sensor = Sensor { white, contrast: 0.5, gradient, noise: 0.0 };
            sensor.digitise(&[[ink; MAX_WIDTH]; 2], 101, &mut generator(1, 0))[1].clone()
        };
        assert!(level(100.5, 0.0, 0.0).iter().all(|&grey| grey == 101));
        assert!(level(100.4, 0.0, 0.0).iter().all(|&grey| grey == 100));
        assert!(level(300.0, 0.0, 0.0).iter().all(|&grey| grey == 255));
        assert!(level(100.0, 0.0, 7.0).iter().all(|&grey| grey == 50));
        let lit = level(100.0, 0.4, 0.0);
        assert_eq!((lit.len(), lit[0], lit[50], lit[100]), (101, 80, 100, 120));
    }
}
