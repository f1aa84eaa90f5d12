//! A square root of a covariance, which a scalar observation makes smaller without making anything negative.

use crate::binary::{product, scaled, size, times};
use crate::inverse::Inverse;
use crate::motion::{STATES, StateCovariance};
use crate::ratio;

/// Fraction bits of a root's entries.
pub const ROOT_BITS: u8 = 48;

/// Fraction bits of a normalised observation, whose noise has the variance 1.
pub const NORMAL_BITS: u8 = 28;

/// `L` of `P = L Lᵀ`, whatever its shape; rows and columns from `size` on are 0.
#[derive(Clone, Copy, Debug)]
pub struct Root {
    rows: [[i64; STATES]; STATES],
    size: usize,
}

/// What observations so far change, and how unlikely they were.
#[derive(Clone, Copy, Debug, Default)]
pub struct Correction {
    /// Of x, y, the heading, `e` and `g` in the covariance's units, 40 fraction bits.
    pub moved: [i64; STATES],
    /// `νᵀ S⁻¹ ν`, 20 fraction bits.
    pub nis: i64,
}

impl Root {
    /// Cholesky's root, lower triangular.
    ///
    /// Errors: 2^-49 of the entries, so that a pivot is off by up to 2^-44, which is a deviation of 0.2 µm; a pivot that comes
    /// out negative is 0.
    #[must_use]
    pub fn of(covariance: &StateCovariance, size: usize) -> Self {
        let mut root = Self { rows: [[0; STATES]; STATES], size };
        for j in 0..size {
            let pivot = square_root(root.reduced(covariance, j, j));
            root.set(j, j, pivot);
            for i in j + 1..size {
                let entry = ratio::rounded(root.reduced(covariance, i, j), pivot, 2 * ROOT_BITS - 56).unwrap_or(0);
                root.set(i, j, entry);
            }
        }
        root
    }

    /// An entry of the covariance less what the columns before `j` explain, 56 fraction bits.
    fn reduced(&self, covariance: &StateCovariance, i: usize, j: usize) -> i64 {
        let explained = self.row(i).iter().zip(self.row(j)).take(j);
        explained.fold(covariance.entry(i, j), |left, (&one, &other)| {
            left.saturating_sub(product(one, other, 2 * ROOT_BITS - 56))
        })
    }

    /// A row.
    #[must_use]
    pub fn row(&self, i: usize) -> &[i64] {
        self.rows.get(i).map_or(&[], |row| row.as_slice())
    }

    /// An entry.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> i64 {
        self.row(i).get(j).copied().unwrap_or_default()
    }

    fn set(&mut self, i: usize, j: usize, value: i64) {
        if let Some(entry) = self.rows.get_mut(i).and_then(|row| row.get_mut(j)) {
            *entry = value;
        }
    }

    /// Observes `h · x` with a noise of variance 1 (Potter): `by` are `h` and `seen` what was seen less what was expected
    /// before any correction, both with [`NORMAL_BITS`].
    ///
    /// With `f = Lᵀ h` and `s = 1 + f · f` the state moves by `L f/s` times the innovation, and `L` becomes
    /// `L (I - f fᵀ/(s + √s))`, of which the square is `L (I - f fᵀ/s) Lᵀ`. Errors: 2^-27 of a row's length, however small the
    /// row becomes; 2^-27 of the correction.
    pub fn observe(&mut self, by: &[i64; 3], seen: i64, correction: &mut Correction) {
        let innovation = by
            .iter()
            .zip(correction.moved)
            .fold(seen, |left, (&by, moved)| left.saturating_sub(product(by, moved, 40)));
        let mut f = [0_i64; STATES];
        for (row, &by) in self.rows.iter().zip(by) {
            for (sum, &entry) in f.iter_mut().zip(row) {
                *sum = sum.saturating_add(product(entry, by, ROOT_BITS));
            }
        }
        // 29-bit numbers with `bits` fraction bits.
        let longest = f.iter().map(|&value| size(value)).max().unwrap_or(0);
        let down = (longest - 29).max(0);
        let bits = i32::from(NORMAL_BITS) - down;
        let f = f.map(|value| i32::try_from(scaled(value, -down)).unwrap_or_default());
        let squares = f.iter().fold(0_i64, |sum, &value| sum + i64::from(value) * i64::from(value)); // below 2^60.4
        let s = squares + scaled(1, 2 * bits); // twice as many bits
        let s_and_root = s + scaled(i64::try_from(s.unsigned_abs().isqrt()).unwrap_or_default(), bits);
        let (Some(over_s), Some(over_both)) = (Inverse::of(s), Inverse::of(s_and_root)) else { return };
        // L f, without 30 of its `bits`.
        let mut along = [0_i64; STATES];
        for (sum, row) in along.iter_mut().zip(&self.rows) {
            *sum = row.iter().zip(f).fold(0, |sum, (&entry, f)| sum + times(entry, f, 30));
        }
        let share = over_s.times(innovation, 52 + bits); // 2^(30 + bits)/s times the innovation, 50 fraction bits
        for (moved, &along) in correction.moved.iter_mut().zip(&along) {
            *moved = moved.saturating_add(product(along, share, 58));
        }
        let square = scaled(product(innovation, share, 60), bits - i32::from(NORMAL_BITS));
        correction.nis = correction.nis.saturating_add(square);
        let weights = f.map(|f| i32::try_from(over_both.times(i64::from(f), 58)).unwrap_or_default()); // below 2^30
        for (row, &along) in self.rows.iter_mut().zip(&along) {
            for (entry, weight) in row.iter_mut().zip(weights) {
                *entry = entry.saturating_sub(times(along, weight, 28));
            }
        }
    }

    /// `L Lᵀ`, each row of `L` rounded to 29 bits; then errors of half a unit, for which the variances get 3.
    #[must_use]
    pub fn covariance(&self) -> StateCovariance {
        let mut exponents = [0_i32; STATES];
        let mut mantissas = [[0_i64; STATES]; STATES];
        for ((row, exponent), mantissa) in self.rows.iter().zip(&mut exponents).zip(&mut mantissas) {
            *exponent = row.iter().map(|&entry| size(entry)).max().unwrap_or(0) - 29;
            *mantissa = row.map(|entry| scaled(entry, -*exponent));
        }
        let mut covariance = StateCovariance::default();
        for (i, (row, first)) in mantissas.iter().zip(exponents).enumerate().take(self.size) {
            for (j, (other, second)) in mantissas.iter().zip(exponents).enumerate().take(self.size).skip(i) {
                let sum = row.iter().zip(other).fold(0_i64, |sum, (&one, &other)| sum + one * other); // below 2^60.4
                covariance.set(i, j, scaled(sum, first + second + 56 - 2 * i32::from(ROOT_BITS)));
            }
        }
        covariance.settle([3; STATES]);
        covariance
    }
}

/// The square root of a variance with 56 fraction bits, with [`ROOT_BITS`]; 0 of what is not positive.
///
/// The whole root of the variance, scaled up, and one step of Newton's method for 29 bits more: error 2^-48.9.
#[must_use]
pub fn square_root(variance: i64) -> i64 {
    let Ok(variance) = u64::try_from(variance.max(0)) else { return 0 };
    let up = variance.leading_zeros() & !1;
    let Some(normal) = variance.checked_shl(up) else { return 0 };
    let whole = normal.isqrt(); // 2^31 to 2^32
    let rest = normal - whole * whole; // at most twice the root
    let fraction = (rest << 28).checked_div(whole).unwrap_or(0);
    let root = i64::try_from((whole << 29) + fraction).unwrap_or_default();
    ratio::dropped(root, u8::try_from(9 + up / 2).unwrap_or(62))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn roots_of_squares_are_exact() {
        // 2^-8, 1/2, 1, 3 and 8; nothing negative has a root.
        let variances = [1 << 40, 1 << 54, 1 << 56, 9 << 56, 1 << 62].map(square_root);
        assert_eq!(variances, [1 << 40, 1 << 47, 1 << 48, 3 << 48, 1 << 51]);
        assert_eq!([0, -1, i64::MIN].map(square_root), [0; 3]);
    }

    proptest! {
        #[test]
        fn roots_keep_to_the_stated_error(variance in 1_i64..1 << 56, fewer in 0_u32..56) {
            let variance = (variance >> fewer).max(1);
            let exact = (variance as f64 / 2_f64.powi(56)).sqrt();
            let error = square_root(variance) as f64 / 2_f64.powi(48) - exact;
            prop_assert!(error.abs() <= 2_f64.powf(-48.9), "{}", error);
        }
    }
}
