//! A low-discrepancy sequence that can be entered at any index.
//!
//! Additive recurrence on the generalised golden ratio (M. Roberts, 2018, "The unreasonable effectiveness of
//! quasirandom sequences"): point i is `frac(offset + (i + 1) α)` with `α_j = φ^-(j+1)` and `φ` the positive root of
//! `φ^(D+1) = φ + 1`. Products are taken modulo 2^64, so that point 10^9 is as exact as point 0.

use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

/// Points of the unit cube of `D` dimensions.
#[derive(Clone, Debug)]
pub struct Sequence<const D: usize> {
    /// Steps as fractions of 2^64.
    steps: [u64; D],
    /// Random shift (Cranley-Patterson) by the seed.
    offsets: [u64; D],
}

impl<const D: usize> Sequence<D> {
    /// The sequence of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let root = generalised_golden_ratio(D);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut power = 1.0;
        let steps = core::array::from_fn(|_| {
            power /= root;
            fraction(power)
        });
        Self { steps, offsets: core::array::from_fn(|_| rng.random()) }
    }

    /// The point of an index, each coordinate in [0, 1).
    #[must_use]
    pub fn point(&self, index: u64) -> [f64; D] {
        core::array::from_fn(|j| {
            let turned = self.offsets[j].wrapping_add(self.steps[j].wrapping_mul(index.wrapping_add(1)));
            (turned >> 11) as f64 / (1_u64 << 53) as f64
        })
    }
}

/// Newton's method from above; the function is convex there.
fn generalised_golden_ratio(dimensions: usize) -> f64 {
    let n = i32::try_from(dimensions + 1).unwrap_or(i32::MAX);
    (0..60).fold(2.0_f64, |x, _| x - (x.powi(n) - x - 1.0) / (f64::from(n) * x.powi(n - 1) - 1.0))
}

/// A number in [0, 1) as a fraction of 2^64.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "x 2^64 is in [0, 2^64)")]
fn fraction(x: f64) -> u64 {
    (x * 2.0_f64.powi(64)) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_of_one_dimension_is_the_golden_ratio() {
        assert!((generalised_golden_ratio(1) - 1.618_033_988_749_895).abs() < 1e-15);
        assert!((generalised_golden_ratio(2) - 1.324_717_957_244_746).abs() < 1e-15);
    }

    /// 20 points in each of 1,000 boxes: of random points the chi-square is 999 with a standard deviation of 45.
    #[test]
    fn points_fill_the_cube_more_evenly_than_random_ones() {
        let sequence = Sequence::<3>::new(5);
        let mut boxes = [0.0; 1000];
        for i in 0..20_000 {
            let [x, y, z] = sequence.point(i).map(|u| {
                assert!((0.0..1.0).contains(&u));
                (u * 10.0).floor()
            });
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 1000")]
            let index = (100.0 * x + 10.0 * y + z) as usize;
            boxes[index] += 1.0;
        }
        let chi_square: f64 = boxes.iter().map(|count: &f64| (count - 20.0).powi(2) / 20.0).sum();
        assert!(chi_square < 999.0 - 6.0 * 45.0, "{chi_square}");
    }

    #[test]
    fn seeds_differ_and_repeat() {
        let bits = |seed| Sequence::<2>::new(seed).point(7).map(f64::to_bits);
        assert_eq!(bits(1), bits(1));
        assert_ne!(bits(1), bits(2));
    }
}
