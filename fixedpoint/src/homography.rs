//! The homography of a layer: exact while it grows, rounded when it is reported.
//!
//! Unknown are, per edge number `v = j - N/2`, the centre `a`, the width `σ` and the obliquity `κ` of
//! `z (1 + κ v) = a + σ v`, so `s = σ N/2` and `k = κ N/2`. The normal equations of `HOMOG-1` have the rows
//! `(1, v, -v z)` and the right side `z`, all integers. Cramer's rule gives `a = A/D`, `σ = S/D` and `κ = K/D`.
//!
//! With at most 25 distinct edges `|v| <= 12`, hence `Σ v² <= 1300`, and `|z| <= 2^11`: Hadamard's inequality bounds
//! `D` by `n Σv² Σv²z² <= 2^47.4`; the inequality of Cauchy and Schwarz (over the minors of Cauchy and Binet) bounds
//! `|K| <= 2^44.5`, `|S| <= 2^55.5` and `|A| <= 2^58.4`. Every product of the expansions is below 2^59.

use crate::camera::Camera;
use crate::crossing::{Crossing, FARTHEST, Grid};
use crate::formats::{Column, Obliquity};
use crate::landmark::Format;
use crate::ratio;

/// A layer's homography `z (1 + k t) = a + s t`, relative to the principal column (`HOMOG-4`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Homography {
    /// Centre in px.
    pub a: Column,
    /// Half width in px.
    pub s: Column,
    /// Obliquity, -1/2 to 1/2.
    pub k: Obliquity,
}

/// The sums of the normal equations of `HOMOG-1`, one transition after another.
///
/// The largest is `Σ v²z²`, up to 1300 * 2^22 < 2^32.4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Normal {
    /// One bit for each edge that has been added.
    edges: u32,
    count: i64,
    v: i64,
    vv: i64,
    z: i64,
    vz: i64,
    vvz: i64,
    vzz: i64,
    vvzz: i64,
}

impl Normal {
    /// No transition.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a transition.
    ///
    /// `None`, and nothing is added, if the edge is outside ±12 or there already, or the column is outside ±2048: this
    /// is what the ranges rest on. It does not happen to the transitions of one ROI.
    #[must_use]
    pub fn add(&mut self, crossing: &Crossing) -> Option<()> {
        let place = u32::try_from(i16::from(crossing.edge) + 12).ok().filter(|&place| place <= 24)?;
        let edge = 1_u32 << place;
        let too_far = crossing.column.unsigned_abs() > FARTHEST.unsigned_abs();
        if too_far || self.edges & edge != 0 {
            return None;
        }
        self.edges |= edge;
        let (v, z) = (i64::from(crossing.edge), i64::from(crossing.column));
        self.count += 1;
        self.v += v;
        self.vv += v * v;
        self.z += z;
        self.vz += v * z;
        self.vvz += v * v * z;
        self.vzz += v * z * z;
        self.vvzz += v * v * z * z;
        Some(())
    }

    /// The solution of the normal equations, exactly (`HOMOG-1`).
    ///
    /// By the adjugate of the symmetric matrix, whose entries `c_ij` are below 2^42.7, 2^40.2, 2^29.6 (first row),
    /// 2^37, 2^26.5 (second) and 2^15.
    //= reference/SPEC.md#homog
    //# - **HOMOG-1** The homography MUST be the one that minimises `Σ (a + s t - k t z - z)²` over its transitions.
    #[must_use]
    pub fn solve(&self) -> Solution {
        let Self { count: n, v, vv, z, vz, vvz, vzz, vvzz, .. } = *self;
        let c11 = vv * vvzz - vvz * vvz;
        let c12 = vvz * vz - v * vvzz;
        let c13 = vv * vz - v * vvz;
        let c22 = n * vvzz - vz * vz;
        let c23 = n * vvz - v * vz;
        let c33 = n * vv - v * v;
        Solution {
            a: c11 * z + c12 * vz - c13 * vzz,
            s: c12 * z + c22 * vz - c23 * vzz,
            k: c13 * z + c23 * vz - c33 * vzz,
            d: c11 * n + c12 * v - c13 * vz,
        }
    }
}

/// An exact solution: numerators of centre, width and obliquity per edge, and their denominator (see the module).
///
/// Columns are those of an ROI's [`Grid`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Solution {
    a: i64,
    s: i64,
    k: i64,
    d: i64,
}

impl Solution {
    /// Whether `s > 0` and `|k| <= 1/2` (`HOMOG-3`), that is `S > 0` and `N |K| <= D`: exact, so `HOMOG-5` asks
    /// for nothing here.
    ///
    /// `D` is positive once the guards' transitions are in. Otherwise all of them would fulfil one equation
    /// `c0 + c1 v + c2 v z = 0`: constant columns, or a hyperbola with its pole at `v = 0`, which falls on both sides or
    /// rises on both and is higher on the left. Columns from left to right do not fall, and are not all equal.
    //= reference/SPEC.md#homog
    //# - **HOMOG-3** A homography MUST be refused (`Implausible`) unless `s > 0` and `|k| <= 1/2`.
    //= reference/SPEC.md#homog
    //# - **HOMOG-5** A pipeline whose arithmetic is not exact MUST treat a `|k|` within its declared error of 1/2 as on
    //# it.
    #[must_use]
    pub fn is_plausible(&self, format: Format) -> bool {
        let obliquity = self.k.unsigned_abs() * u64::from(format.stripes()); // below 2^50
        self.d > 0 && self.s > 0 && obliquity <= self.d.unsigned_abs()
    }

    /// The residual of a transition in `HOMOG-1`, times `D` (`SAMPLE-10`): `A + S v - K v z - D z`, within ±2^60.8.
    #[must_use]
    pub fn residual(&self, crossing: &Crossing) -> i64 {
        let (v, z) = (i64::from(crossing.edge), i64::from(crossing.column));
        self.a + self.s * v - z * (self.d + self.k * v)
    }

    /// `D`, positive for a plausible solution.
    #[must_use]
    pub fn denominator(&self) -> i64 {
        self.d
    }

    /// The column of the middle of stripe `j`, as numerator and denominator (`SAMPLE-2`).
    ///
    /// With `v2 = 2 j + 1 - N` half edges it is `(2 A + S v2)/(2 D + K v2)`. If the solution is plausible the
    /// denominator is positive, between `D` and `3 D < 2^49`; the numerator is within ±2^60.8.
    #[must_use]
    pub fn middle(&self, stripe: u8, format: Format) -> (i64, i64) {
        let v2 = 2 * i64::from(stripe) + 1 - i64::from(format.stripes());
        (2 * self.a + self.s * v2, 2 * self.d + self.k * v2)
    }

    /// The homography relative to the principal column (`HOMOG-4`); `None` if it does not fit its formats.
    ///
    /// It fits if the solution is plausible. With `Z`, at most `(e + 1)/2` px, the farthest transition, the least
    /// squares are no worse than those of the homography 0, `n Z²`, so the mean square of `a + s t` is at most
    /// `(Z + 3/2 Z)²`; for the edges of a layer that bounds `|a| < 2.7 Z` and `s < 4.4 Z`, and for 640 px, with the
    /// shift, `|a'|` and `|s'|` to 1800 px.
    ///
    /// Rounding errors: `a` 2^-21 px, `k` 2^-31, `s` 2^-21 px + 2^-31 px + `|δ|` times the error of `k`.
    //= reference/SPEC.md#homog
    //# - **HOMOG-4** The homography that a layer reports MUST be relative to the principal column, `a' = a + δ`, `s' =
    //# s + δ k` with `δ` the ROI's middle minus `o_x`.
    #[must_use]
    pub fn reported(&self, format: Format, grid: &Grid, camera: &Camera) -> Option<Homography> {
        let half = i64::from(format.stripes() / 2);
        let unit = grid.subpixel_bits();
        // δ is exact: the middle is a multiple of half a pixel.
        let shift = (i64::from(grid.twice_middle()) << 19) - i64::from(camera.principal_column().to_bits());
        let a = ratio::rounded(self.a, self.d, 20 - unit)? + shift;
        let k = ratio::rounded(half * self.k, self.d, 30)?;
        let s = ratio::rounded(half * self.s, self.d, 30 - unit)?;
        // Both with 50 fraction bits: 2^11 px and 2^9.4 px are below 2^62.
        let s = s.checked_mul(1 << 20)?.checked_add(shift.checked_mul(k)?)?;
        Some(Homography {
            a: Column::from_bits(i32::try_from(a).ok()?),
            s: Column::from_bits(i32::try_from(ratio::dropped(s, 30)).ok()?),
            k: Obliquity::from_bits(i32::try_from(k).ok()?),
        })
    }
}

#[cfg(test)]
mod tests;
