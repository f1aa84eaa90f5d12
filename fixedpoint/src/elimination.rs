//! Normal equations: scaled, eliminated and solved in 32-bit numbers.
//!
//! A symmetric, positive semidefinite matrix `M` is kept as `m_ij 2^(e_i + e_j)` with `2^28 <= m_ii < 2^30` (Jacobi's
//! scaling by powers of two). Then `|m_ij| < 2^30` by the inequality of Cauchy and Schwarz, before and after any pivot
//! is eliminated. The right side is one more column, the residuals', which is scaled like the others; its diagonal is
//! their sum of squares. Eliminating the pivot `o` subtracts `m_oi m_oj/m_oo` and leaves the factors `m_oi/m_oo`.

use crate::binary;
use crate::reciprocal::Reciprocal;

/// The smallest pivot, of at least 2^28 before any elimination: what is less is not told from 0.
const SMALLEST_PIVOT: i32 = 1 << 12;

/// Fraction bits of a solution in units of the scaled columns.
pub const SOLUTION_BITS: u8 = 24;

/// Normal equations in `N` columns, in an order of the caller's, of which the first are to be eliminated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Equations<const N: usize> {
    /// `m_ij` for `i <= j`; of an eliminated pivot's row the factors `m_oj/m_oo` in `2^-shift`.
    rows: [[i32; N]; N],
    shifts: [u8; N],
    /// `e_i`.
    pub exponents: [i32; N],
}

impl<const N: usize> Equations<N> {
    /// The equations of a matrix whose entry `(i, j)`, `i <= j`, is `entry(i, j)`.
    ///
    /// Rounding error: `2^-1` of each `m_ij`, of a diagonal of at least 2^28.
    #[must_use]
    pub fn scaled(entry: impl Fn(usize, usize) -> i64) -> Self {
        let mut equations = Self::empty();
        equations.scale(entry);
        equations
    }

    /// Equations that say nothing, a place for others.
    #[must_use]
    pub fn empty() -> Self {
        Self { rows: [[0; N]; N], shifts: [0; N], exponents: [0; N] }
    }

    /// [`Equations::scaled`] in place: two layers' are a large part of a small stack.
    pub fn scale(&mut self, entry: impl Fn(usize, usize) -> i64) {
        for (i, exponent) in self.exponents.iter_mut().enumerate() {
            *exponent = (binary::size(entry(i, i)) - 29).div_euclid(2);
        }
        for (i, (row, first)) in self.rows.iter_mut().zip(self.exponents).enumerate() {
            for (j, (place, second)) in row.iter_mut().zip(self.exponents).enumerate().skip(i) {
                let limited = binary::scaled(entry(i, j), -first - second).clamp(-(1 << 30), 1 << 30);
                *place = i32::try_from(limited).unwrap_or_default();
            }
        }
    }

    /// `m_ij`, `i <= j`.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> i32 {
        self.rows.get(i).and_then(|row| row.get(j)).copied().unwrap_or_default()
    }

    /// Eliminates the pivot `o`, those before it having been eliminated; `None` if it is not positive.
    ///
    /// Errors: of a factor half its unit, `2^-shift`, and 2^-27 of it; of an entry half a unit, 2^-27 of what is subtracted, and
    /// the factor's half unit times `m_oj`: at most `sqrt(m_jj/m_oo)`, by the inequality of Cauchy and Schwarz.
    #[must_use]
    #[inline(never)] // two copies of a row, not for each of the callers
    pub fn eliminate(&mut self, o: usize) -> Option<()> {
        let row = *self.rows.get(o)?;
        let pivot = row.get(o).copied().filter(|&pivot| pivot >= SMALLEST_PIVOT)?;
        let reciprocal = Reciprocal::of(pivot.unsigned_abs())?;
        let shift = 30 - reciprocal.shift.min(29); // at least 11
        let half = 1_i64 << shift >> 1;
        let mut factors = row;
        for factor in factors.iter_mut().skip(o + 1) {
            // At most 2^30 sqrt(2^30/m_oo) 2^-zeros, below 2^30.
            let scaled = (i64::from(*factor) * i64::from(reciprocal.mantissa) + (1 << 31)) >> 32;
            *factor = i32::try_from(scaled).ok()?;
        }
        for (i, (target, &factor)) in self.rows.iter_mut().zip(&factors).enumerate().skip(o + 1) {
            for (entry, &other) in target.iter_mut().zip(&row).skip(i) {
                let reduced = i64::from(*entry) - ((i64::from(factor) * i64::from(other) + half) >> shift);
                *entry = i32::try_from(reduced.clamp(-(1 << 30), 1 << 30)).ok()?;
            }
        }
        *self.rows.get_mut(o)? = factors;
        *self.shifts.get_mut(o)? = shift;
        Some(())
    }

    /// The factor `m_oj/m_oo` times `value`, of an eliminated pivot, rounded; `|value| <= 2^32`.
    fn times_factor(&self, o: usize, j: usize, value: i64) -> i64 {
        let shift = self.shifts.get(o).copied().unwrap_or_default();
        (i64::from(self.entry(o, j)) * value + (1 << shift >> 1)) >> shift
    }

    /// Solves for the unknown `o` when the later ones of `solution` are known, the last column being the right side.
    ///
    /// A solution `x_i`, in units of [`SOLUTION_BITS`], says that the unknown is `x_i 2^(e_N - e_i)`. It is limited to
    /// ±256, 2^32 units: a step as long as the residuals is 1, where the columns are not nearly dependent.
    pub fn substitute(&self, o: usize, solution: &mut [i64; N]) {
        let right = N.saturating_sub(1);
        let mut value = self.times_factor(o, right, 1 << SOLUTION_BITS);
        for (j, &known) in solution.iter().enumerate().take(right).skip(o + 1) {
            value = value.saturating_sub(self.times_factor(o, j, known));
        }
        if let Some(place) = solution.get_mut(o) {
            *place = limited(value);
        }
    }

    /// The inverse of the first `pivots` columns' block, all of them eliminated, at `(i, j)`, of the scaled matrix.
    ///
    /// As `m^-1 2^30` in 2^-20, that is `2^50 m^-1`. With `F` the unit upper triangle of the factors and `D` the pivots it is
    /// `F^-1 D^-1 F^-T`.
    #[must_use]
    pub fn inverse(&self, i: usize, j: usize, pivots: usize) -> i64 {
        let (first, second) = (self.inverted_row(i, pivots), self.inverted_row(j, pivots));
        let mut sum = 0_i64;
        for (o, (&one, &other)) in first.iter().zip(&second).enumerate().take(pivots) {
            let Some(reciprocal) = Reciprocal::of(self.entry(o, o).unsigned_abs()) else { continue };
            // 2^30/m_oo is mantissa 2^(zeros - 32); both rows have 24 fraction bits.
            let weighted = binary::product(binary::product(one, other, 28), i64::from(reciprocal.mantissa), 0);
            sum = sum.saturating_add(binary::scaled(weighted, i32::from(reciprocal.shift) - 32));
        }
        sum
    }

    /// Row `i` of `F^-1` in units of 2^-24: `g_ij = -Σ_{i <= m < j} g_im f_mj`.
    fn inverted_row(&self, i: usize, pivots: usize) -> [i64; N] {
        let mut row = [0; N];
        if let Some(place) = row.get_mut(i) {
            *place = 1 << SOLUTION_BITS;
        }
        for j in i + 1..pivots {
            let mut value = 0_i64;
            for (m, &known) in row.iter().enumerate().take(j).skip(i) {
                value = value.saturating_sub(self.times_factor(m, j, known));
            }
            if let Some(place) = row.get_mut(j) {
                *place = limited(value);
            }
        }
        row
    }
}

/// A solution limited to ±2^32 units.
fn limited(value: i64) -> i64 {
    value.clamp(-(1 << 32), 1 << 32)
}

#[cfg(test)]
mod tests;
