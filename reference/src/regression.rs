//! The paper's empirical covariance of the camera's position: its eigenvalues (11) and its rotation (12), and the closed
//! form of the rotation.
//!
//! They describe the noise of one detector on one camera, and no stage of either pipeline uses them: they are here to be
//! compared with. Position is `(x, y)` in the landmark frame L; a landmark is seen from the polar angle `θ` of that
//! position at the distance `d`.

use crate::frame::{self, Pose};
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::{Matrix2, Rotation2};

/// A variance that grows exponentially with the distance: `λ(d) = exp(slope d + intercept)` (11).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Per metre.
    pub slope: f64,
    /// Logarithm of the variance, in m², at no distance.
    pub intercept: f64,
}

impl Growth {
    /// The variance, in m², at `distance` in metres (ERRATA-7).
    //= reference/SPEC.md#errata
    //# - **ERRATA-7** (11) MUST be read with λ in m² and d in m.
    #[must_use]
    pub fn variance(&self, distance: f64) -> f64 {
        (self.slope * distance + self.intercept).exp()
    }
}

/// The paper's larger eigenvalue, λ1 of (11) (ERRATA-7).
pub const MAJOR: Growth = Growth { slope: 25.70, intercept: -15.46 };

/// The paper's smaller eigenvalue, λ2 of (11) (ERRATA-7).
pub const MINOR: Growth = Growth { slope: 16.15, intercept: -17.27 };

/// The direction of the larger eigenvalue's axis in L by polar angle: `gain θ - step sgn θ` (12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Radians per radian.
    pub gain: f64,
    /// Radians.
    pub step: f64,
}

/// The paper's rotation (12).
pub const ROTATION: Rotation = Rotation { gain: 1.91, step: 1.43 };

/// The direction in which the apparent width of the barcode stays the same, in the form of (12) (ERRATA-6).
///
/// Frontally the width goes as `cos θ / d = x/(x² + y²)`. Its level lines are circles through the barcode, and their
/// tangent has the direction `atan2(cos 2θ, -sin 2θ) = 2θ + π/2`, which modulo π is `2 θ - (π/2) sgn θ`.
pub const EQUAL_WIDTH: Rotation = Rotation { gain: 2.0, step: FRAC_PI_2 };

impl Rotation {
    /// The axis at the polar angle `theta`, in radians, both; modulo π in (-π/2, π/2], with sgn(0) = +1 (ERRATA-6).
    //= reference/SPEC.md#errata
    //# - **ERRATA-6** (12) MUST be read with `sgn(0) = +1`, the rotation being that of an axis, modulo π.
    #[must_use]
    pub fn axis(&self, theta: f64) -> f64 {
        let sign = if theta < 0.0 { -1.0 } else { 1.0 };
        wrap_axis(self.gain * theta - self.step * sign)
    }
}

/// The angle in (-π/2, π/2] that differs from `angle`, in radians, by a multiple of π: the direction of an axis, which
/// has no head (ERRATA-6).
#[must_use]
pub fn wrap_axis(angle: f64) -> f64 {
    let turned = angle.rem_euclid(PI);
    if turned > FRAC_PI_2 { turned - PI } else { turned }
}

/// The paper's covariance of the position `(x, y)` in L, in m², of a camera at `pose` (11), (12).
///
/// `d` and `θ` are what the paper says they can be replaced with: the distance from the barcode's centre, and the
/// heading in L plus π.
#[must_use]
pub fn covariance(pose: &Pose<frame::Landmark, frame::Camera>) -> Matrix2<f64> {
    let distance = pose.x().hypot(pose.y());
    let axes = Rotation2::new(ROTATION.axis(frame::wrap(pose.theta() + PI)));
    let variances = Matrix2::new(MAJOR.variance(distance), 0.0, 0.0, MINOR.variance(distance));
    axes.matrix() * variances * axes.matrix().transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::landmark::{Format, Landmark};
    use proptest::prelude::*;

    fn degrees(rotation: &Rotation) -> [f64; 4] {
        [0.0, 30.0, 45.0, 60.0].map(|theta: f64| rotation.axis(theta.to_radians()).to_degrees())
    }

    /// ERRATA-6's two rows.
    //= reference/SPEC.md#errata
    //= type=test
    //# - **ERRATA-6** (12) MUST be read with `sgn(0) = +1`, the rotation being that of an axis, modulo π.
    #[test]
    fn axes_are_those_of_the_specification() {
        for (found, stated) in degrees(&ROTATION).into_iter().zip([-82.0, -24.6, 4.0, 33.0]) {
            assert!((found - stated).abs() < 0.4, "{found} for {stated}");
        }
        for (found, stated) in degrees(&EQUAL_WIDTH).into_iter().zip([90.0, -30.0, 0.0, 30.0]) {
            assert!(wrap_axis((found - stated).to_radians()).abs() < 1e-12, "{found} for {stated}");
        }
    }

    /// ERRATA-7: 4.3e-4 m², 21 mm, at 30 cm.
    //= reference/SPEC.md#errata
    //= type=test
    //# - **ERRATA-7** (11) MUST be read with λ in m² and d in m.
    #[test]
    fn variances_are_in_square_metres() {
        assert!((MAJOR.variance(0.3) - 4.3e-4).abs() < 0.05e-4);
        assert!((MAJOR.variance(0.3).sqrt() - 21e-3).abs() < 0.5e-3);
        // 16.15 * 0.3 - 17.27 = -12.425: a standard deviation of exp(-6.2125) = 2.0 mm.
        assert!((MINOR.variance(0.3).sqrt() - 2.0e-3).abs() < 0.01e-3);
    }

    #[test]
    fn the_covariance_has_the_regressions_as_eigenvalues_and_axis() {
        let theta = 30_f64.to_radians();
        let pose = Pose::new(0.4 * theta.cos(), 0.4 * theta.sin(), PI + theta);
        let found = covariance(&pose);
        let (major, minor) = ((25.70 * 0.4 - 15.46_f64).exp(), (16.15 * 0.4 - 17.27_f64).exp());
        assert!((found.trace() - major - minor).abs() < 1e-12);
        assert!((found.determinant() / (major * minor) - 1.0).abs() < 1e-9);
        let axis = 0.5 * (2.0 * found[(0, 1)]).atan2(found[(0, 0)] - found[(1, 1)]);
        assert!((axis - (1.91 * theta - 1.43)).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn an_axis_has_no_head(angle in -20.0..20.0f64, turns in -5..5i32) {
            let axis = wrap_axis(angle);
            prop_assert!(axis > -FRAC_PI_2 - 1e-12 && axis <= FRAC_PI_2);
            prop_assert!(((axis - angle) / PI - ((axis - angle) / PI).round()).abs() < 1e-9);
            let turned = wrap_axis(angle + f64::from(turns) * PI);
            prop_assert!(wrap_axis(turned - axis).abs() < 1e-9);
        }

        /// The closed form by projection: one step along the axis leaves the width of a narrow landmark as it is, while
        /// one across it does not.
        #[test]
        fn along_the_closed_form_the_apparent_width_stays_the_same(theta in -1.3..1.3f64, distance in 0.2..0.6f64) {
            let narrow = Landmark { stripe_width: 1e-5, ..Landmark::new(Format::Paper) };
            let width = |x: f64, y: f64| {
                // Looking at the centre, so that the image's own stretching towards its ends plays no part.
                let pose = Pose::new(x, y, PI + y.atan2(x));
                let [left, right] = [-1.0, 1.0].map(|side| {
                    Camera::epuck().project_stripe(&pose, side * narrow.half_width()).column
                });
                right - left
            };
            let (x, y) = (distance * theta.cos(), distance * theta.sin());
            let axis = EQUAL_WIDTH.axis(theta);
            let change = |direction: f64| {
                let step = 1e-4 * distance;
                let (dx, dy) = (step * direction.cos(), step * direction.sin());
                (width(x + dx, y + dy) - width(x - dx, y - dy)).abs() / width(x, y)
            };
            // The width falls as fast as 1/d across the level line: 2e-4 for this step, over cos θ.
            prop_assert!(change(axis) < 1e-7, "along: {}", change(axis));
            prop_assert!(change(axis + FRAC_PI_2) > 1.9e-4, "across: {}", change(axis + FRAC_PI_2));
        }
    }
}
