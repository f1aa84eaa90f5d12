//! The homography (7) from the barcode to the image (HOMOG).

use crate::crossing::Crossing;
use crate::landmark::Format;
use nalgebra::{Matrix3, Vector3};

/// Largest `|k|` of a plausible homography (HOMOG-3).
pub const MAX_OBLIQUITY: f64 = 0.5;

/// `column = (a + s t)/(1 + k t)`, with t = -1 at the barcode's left edge and 1 at its right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography {
    /// Image of the barcode's centre, pixels.
    pub a: f64,
    /// Half width in the image where the barcode is seen frontally, pixels.
    pub s: f64,
    /// Obliquity.
    pub k: f64,
}

impl Homography {
    /// The difference of a homography from itself.
    pub const NONE: Self = Self { a: 0.0, s: 0.0, k: 0.0 };

    /// Column of the normalised barcode coordinate `t`, pixels.
    #[must_use]
    pub fn column(&self, t: f64) -> f64 {
        (self.a + self.s * t) / (1.0 + self.k * t)
    }

    /// The residual `ρ = a + s t - k t z - z` of HOMOG-1 of a point `t` seen at column `z`, pixels (SAMPLE-10).
    #[must_use]
    pub fn residual(&self, t: f64, z: f64) -> f64 {
        self.a + self.s * t - self.k * t * z - z
    }

    /// HOMOG-3; a `|k|` within `error` of the limit counts as on it (HOMOG-5).
    //= reference/SPEC.md#homog
    //# - **HOMOG-3** A homography MUST be refused (`Implausible`) unless `s > 0` and `|k| <= 1/2`.
    //= reference/SPEC.md#homog
    //# - **HOMOG-5** A pipeline whose arithmetic is not exact MUST treat a `|k|` within its declared error of 1/2 as on
    //# it.
    #[must_use]
    pub fn is_plausible(&self, error: f64) -> bool {
        self.s > 0.0 && self.k.abs() <= MAX_OBLIQUITY + error
    }

    /// Distance from the nearer limit of HOMOG-3: pixels for s, dimensionless for k.
    #[must_use]
    pub fn margin(&self) -> f64 {
        self.s.abs().min((self.k.abs() - MAX_OBLIQUITY).abs())
    }

    /// The same map with columns counted from a point `origin` px to the left (HOMOG-4).
    //= reference/SPEC.md#homog
    //# - **HOMOG-4** The homography that a layer reports MUST be relative to the principal column, `a' = a + δ`, `s' =
    //# s + δ k` with `δ` the ROI's middle minus `o_x`.
    #[must_use]
    pub fn shifted(&self, origin: f64) -> Self {
        Self { a: self.a + origin, s: self.s + origin * self.k, k: self.k }
    }

    /// The sum of a homography and a difference of such, parameter by parameter (SKEW-2).
    #[must_use]
    pub fn plus(&self, difference: &Self) -> Self {
        Self { a: self.a + difference.a, s: self.s + difference.s, k: self.k + difference.k }
    }

    /// The difference of two homographies, parameter by parameter (SKEW-6).
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        Self { a: self.a - other.a, s: self.s - other.s, k: self.k - other.k }
    }

    /// MERGE-4
    //= reference/SPEC.md#merge
    //# - **MERGE-4** The merged homography MUST be the mean of the two layers' `a`, `s` and `k`.
    #[must_use]
    pub fn mean(&self, other: &Self) -> Self {
        Self { a: f64::midpoint(self.a, other.a), s: f64::midpoint(self.s, other.s), k: f64::midpoint(self.k, other.k) }
    }
}

/// The normalised coordinate `t` of an edge `v`.
#[must_use]
pub fn coordinate(format: Format, edge: i32) -> f64 {
    f64::from(edge) / (format.stripes() as f64 / 2.0)
}

/// Sums of the linear least-squares problem of HOMOG-1, one row `(1, t, -t z)` with right side `z` per transition.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    format: Format,
    /// Pixels per unit of the problem's columns.
    scale: f64,
    /// Units of `Crossing::column` per unit of the problem's columns.
    units: f64,
    normal: Matrix3<f64>,
    right: Vector3<f64>,
}

impl Fit {
    /// An empty problem for an ROI of `extent` pixels whose crossings have `subpixel_bits` fraction bits. Columns are
    /// scaled to about [-1, 1], which keeps the normal matrix well conditioned.
    #[must_use]
    pub fn new(format: Format, extent: usize, subpixel_bits: u32) -> Self {
        let scale = (extent + 1) as f64 / 2.0;
        let units = scale * f64::from(1 << subpixel_bits);
        Self { format, scale, units, normal: Matrix3::zeros(), right: Vector3::zeros() }
    }

    /// Adds a transition.
    pub fn add(&mut self, crossing: &Crossing) {
        let t = coordinate(self.format, crossing.edge);
        let z = f64::from(crossing.column) / self.units;
        let row = Vector3::new(1.0, t, -t * z);
        self.normal += row * row.transpose();
        self.right += row * z;
    }

    /// The homography relative to the ROI's middle (HOMOG-1), `None` if the transitions do not determine one.
    //= reference/SPEC.md#homog
    //# - **HOMOG-1** The homography MUST be the one that minimises `Σ (a + s t - k t z - z)²` over its transitions.
    #[must_use]
    pub fn solve(&self) -> Option<Homography> {
        let solution = self.normal.cholesky()?.solve(&self.right);
        Some(Homography { a: solution.x * self.scale, s: solution.y * self.scale, k: solution.z })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Columns that a homography made are explained by it, up to their rounding to 1/32 px.
        //= reference/SPEC.md#homog
        //= type=test
        //# - **HOMOG-1** The homography MUST be the one that minimises `Σ (a + s t - k t z - z)²` over its transitions.
        #[test]
        fn a_fit_recovers_the_homography(a in -3.0..3.0f64, s in 20.0..28.0f64, k in -0.3..0.3f64) {
            let truth = Homography { a, s, k };
            let mut fit = Fit::new(Format::Paper, 63, 6);
            for v in (-10..=-7).chain(7..=10) {
                let column = truth.column(f64::from(v) / 10.0) * 64.0;
                #[expect(clippy::cast_possible_truncation, reason = "a column within 2^12 units")]
                fit.add(&Crossing { edge: v, column: column.round() as i32 });
            }
            let found = fit.solve().unwrap();
            // Half a unit is 1/128 px; the guards see the centre and the obliquity with a gain below 4.
            prop_assert!((found.a - a).abs() < 4.0 / 128.0);
            prop_assert!((found.s - s).abs() < 4.0 / 128.0);
            prop_assert!((found.k - k).abs() < 4.0 / 128.0 / 20.0 * 2.0);
        }
    }

    //= reference/SPEC.md#homog
    //= type=test
    //# - **HOMOG-4** The homography that a layer reports MUST be relative to the principal column, `a' = a + δ`, `s' =
    //# s + δ k` with `δ` the ROI's middle minus `o_x`.
    #[test]
    fn shifting_the_origin_moves_columns_and_nothing_else() {
        let h = Homography { a: 3.0, s: 25.0, k: 0.2 };
        for t in [-1.0, -0.35, 0.0, 0.8] {
            assert!((h.shifted(100.5).column(t) - h.column(t) - 100.5).abs() < 1e-12);
        }
    }

    #[test]
    fn the_margin_is_the_distance_from_the_nearer_limit() {
        let margin = |s, k| Homography { a: 0.0, s, k }.margin();
        assert!((margin(30.0, 0.4) - 0.1).abs() < 1e-15 && (margin(30.0, -0.6) - 0.1).abs() < 1e-15);
        assert!((margin(-0.01, 0.2) - 0.01).abs() < 1e-15);
    }

    //= reference/SPEC.md#homog
    //= type=test
    //# - **HOMOG-3** A homography MUST be refused (`Implausible`) unless `s > 0` and `|k| <= 1/2`.
    //= reference/SPEC.md#homog
    //= type=test
    //# - **HOMOG-5** A pipeline whose arithmetic is not exact MUST treat a `|k|` within its declared error of 1/2 as on
    //# it.
    #[test]
    fn limits_belong_to_the_plausible() {
        let with = |s, k| Homography { a: 0.0, s, k }.is_plausible(0.0);
        assert!(with(1.0, 0.5) && with(1.0, -0.5));
        assert!(
            !with(0.0, 0.0) && !with(-1.0, 0.0) && !with(1.0, 0.501) && !with(1.0, f64::NAN) && !with(f64::NAN, 0.0)
        );
        // What is not farther from the limit than arithmetic may have taken it is on it.
        let within = |k| Homography { a: 0.0, s: 1.0, k }.is_plausible(1e-8);
        assert!(within(0.5 + 0.9e-8) && within(-0.5 - 0.9e-8) && !within(0.5 + 1.1e-8) && !within(-0.5 - 1.1e-8));
    }
}
