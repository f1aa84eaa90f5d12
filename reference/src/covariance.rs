//! The covariance of a pose `(x, y, θ)` (COV).

use crate::camera::Camera;
use crate::frame::{self, Pose, wrap};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::pose::pose;
use crate::regression::{MAJOR, MINOR};
use core::f64::consts::PI;
use nalgebra::{Matrix2, Matrix3, Matrix3x2, SMatrix, Vector2, Vector3};

/// Gauss-Hermite nodes of the standard normal distribution and their weights (COV-2): the roots of
/// `He5 = ξ⁵ - 10 ξ³ + 15 ξ`, which are 0 and `±sqrt(5 ± sqrt 10)`, and `24/(25 He4²)` with `He4 = ξ⁴ - 6 ξ² + 3`.
pub const NODES: [(f64, f64); 5] = [
    (-2.856_970_013_872_805_6, 0.011_257_411_327_720_69),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (2.856_970_013_872_805_6, 0.011_257_411_327_720_69),
];

/// Largest distance at which (11) is used, metres (COV-5).
const MAX_DISTANCE: f64 = 1.0;

/// A pose and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainPose {
    /// The camera in the landmark's frame: the mean.
    pub camera_in_landmark: Pose<frame::Landmark, frame::Camera>,
    /// Covariance of `(x, y, θ)` in L: metres and radians, squared.
    pub covariance: Matrix3<f64>,
}

/// The pose of a Gaussian `(a, s, k)` and its covariance (COV-1 to COV-3).
//= reference/SPEC.md#cov
//# - **COV-2** The mean of a fitted pose MUST be the mean of POSE over the five Gauss-Hermite nodes of `k`, at the mean
//# of `(a, s)` given each.
//= reference/SPEC.md#cov
//# - **COV-3** Its covariance MUST be that of the five nodes about their mean, plus the mean over the nodes of the
//# covariance of `(a, s)` given `k` carried through the derivatives of POSE by `a` and `s`.
#[must_use]
pub fn transform(
    homography: &Homography,
    covariance: &Matrix3<f64>,
    camera: &Camera,
    landmark: &Landmark,
) -> UncertainPose {
    let k_variance = covariance[(2, 2)];
    //= reference/SPEC.md#cov
    //# - **COV-1** The distribution of `(a, s, k)` MUST be split into that of `k` and that of `(a, s)` given `k`, whose
    //# mean moves by `Σ_{as,k}/Σ_kk` per unit of k and whose covariance is `Σ_as - Σ_{as,k} Σ_{k,as}/Σ_kk`.
    // COV-1
    let by_k: Vector2<f64> = covariance.fixed_view::<2, 1>(0, 2) / k_variance;
    let given_k: Matrix2<f64> = covariance.fixed_view::<2, 2>(0, 0) - by_k * by_k.transpose() * k_variance;
    let middle = pose(homography, camera, landmark);
    let mut mean = Vector3::zeros();
    let mut within = Matrix3::zeros();
    let mut differences = [Vector3::zeros(); NODES.len()];
    for ((node, weight), difference) in NODES.iter().zip(&mut differences) {
        let dk = node * k_variance.sqrt();
        let at = Homography { a: homography.a + by_k[0] * dk, s: homography.s + by_k[1] * dk, k: homography.k + dk };
        let there = pose(&at, camera, landmark);
        *difference =
            Vector3::new(there.x() - middle.x(), there.y() - middle.y(), wrap(there.theta() - middle.theta()));
        mean += *difference * *weight;
        let slope = by_a_and_s(&at, camera, landmark);
        within += slope * given_k * slope.transpose() * *weight;
    }
    let spread: Matrix3<f64> = NODES
        .iter()
        .zip(&differences)
        .map(|((_, weight), difference)| (difference - mean) * (difference - mean).transpose() * *weight)
        .sum();
    let camera_in_landmark = Pose::new(middle.x() + mean[0], middle.y() + mean[1], wrap(middle.theta() + mean[2]));
    UncertainPose { camera_in_landmark, covariance: spread + within }
}

/// The derivatives of `(x, y, θ)` by `a` and `s`.
///
/// With `m = f k` and `ρ² = s² + m²`, POSE is `x = W f (s - a k)/ρ²`, `y = -W (f m + a s)/ρ²`, `θ = atan2(m, -s)`.
fn by_a_and_s(homography: &Homography, camera: &Camera, landmark: &Landmark) -> Matrix3x2<f64> {
    let Homography { a, s, k } = *homography;
    let (f, w) = (camera.focal_length, landmark.half_width());
    let m = f * k;
    let rho2 = s * s + m * m;
    let (x, y) = (w * f * (s - a * k) / rho2, -w * (f * m + a * s) / rho2);
    Matrix3x2::new(
        -w * m / rho2,
        (w * f - 2.0 * s * x) / rho2,
        -w * s / rho2,
        -(w * a + 2.0 * s * y) / rho2,
        0.0,
        m / rho2,
    )
}

/// The derivatives of `(x, y, θ)` by `(a, s, k)` (BOUND-2).
#[must_use]
pub fn jacobian(homography: &Homography, camera: &Camera, landmark: &Landmark) -> Matrix3<f64> {
    let Homography { a, s, k } = *homography;
    let (f, w) = (camera.focal_length, landmark.half_width());
    let m = f * k;
    let rho2 = s * s + m * m;
    let (x, y) = (w * f * (s - a * k) / rho2, -w * (f * m + a * s) / rho2);
    let rho2_by_k = 2.0 * f * m;
    let by_k = Vector3::new((-w * f * a - x * rho2_by_k) / rho2, (-w * f * f - y * rho2_by_k) / rho2, -f * s / rho2);
    let by_a_and_s = by_a_and_s(homography, camera, landmark);
    Matrix3::from_columns(&[by_a_and_s.column(0).into_owned(), by_a_and_s.column(1).into_owned(), by_k])
}

/// The covariance of `(x, y, θ)` of the paper's estimate (11), (12) (COV-5, ERRATA-6, ERRATA-7, ERRATA-9).
//= reference/SPEC.md#cov
//# - **COV-5** The covariance of the paper's estimate MUST be that of (11) in the position, along the axis `(-sin 2η,
//# cos 2η)` with the inclination η (ERRATA-6) and across it, d at most 1 m; the heading turns with the polar angle, `δθ
//# = (x δy - y δx)/d²`, to which a variance of `1/(12 f²)` of the bearing is added.
//= reference/SPEC.md#errata
//# - **ERRATA-9** The variance of θ, for which the paper has no model, MUST be that of COV-5 where the paper's estimate
//# is used.
#[must_use]
pub fn paper(pose: &Pose<frame::Landmark, frame::Camera>, camera: &Camera) -> Matrix3<f64> {
    let (x, y) = (pose.x(), pose.y());
    let distance = x.hypot(y);
    let inclination = wrap(pose.theta() - PI);
    let (sine, cosine) = (2.0 * inclination).sin_cos();
    let (along, across) = (Vector2::new(-sine, cosine), Vector2::new(cosine, sine));
    let limited = distance.min(MAX_DISTANCE);
    let position =
        along * along.transpose() * MAJOR.variance(limited) + across * across.transpose() * MINOR.variance(limited);
    let turn = Vector2::new(-y, x) / (distance * distance);
    let with_heading = SMatrix::<f64, 3, 2>::from_rows(&[
        Vector2::new(1.0, 0.0).transpose(),
        Vector2::new(0.0, 1.0).transpose(),
        turn.transpose(),
    ]);
    let mut covariance = with_heading * position * with_heading.transpose();
    covariance[(2, 2)] += 1.0 / (12.0 * camera.focal_length * camera.focal_length);
    covariance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark::Format;
    use proptest::prelude::*;

    #[test]
    fn nodes_have_the_moments_of_the_normal_distribution() {
        // E ξ^n = (n - 1)!! for even n, up to the ninth degree.
        for (degree, moment) in [(0, 1.0), (1, 0.0), (2, 1.0), (3, 0.0), (4, 3.0), (6, 15.0), (7, 0.0), (8, 105.0)] {
            let sum: f64 = NODES.iter().map(|(node, weight)| weight * node.powi(degree)).sum();
            assert!((sum - moment).abs() < 1e-12 * (1.0 + moment), "degree {degree}: {sum}");
        }
    }

    proptest! {
        #[test]
        fn the_jacobian_is_that_of_the_pose(a in -200.0..200.0f64, s in 10.0..100.0f64, slope in -1.7..1.7f64) {
            let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
            let at = |da: f64, ds: f64, dk: f64| {
                let p = pose(&Homography { a: a + da, s: s + ds, k: slope * s / 640.0 + dk }, &camera, &landmark);
                Vector3::new(p.x(), p.y(), p.theta())
            };
            let found = jacobian(&Homography { a, s, k: slope * s / 640.0 }, &camera, &landmark);
            let h = 1e-6;
            for (column, (da, ds, dk)) in [(h, 0.0, 0.0), (0.0, h, 0.0), (0.0, 0.0, h)].into_iter().enumerate() {
                let mut difference = at(da, ds, dk) - at(-da, -ds, -dk);
                difference[2] = wrap(difference[2]);
                let numeric = difference / (2.0 * h);
                for row in 0..3 {
                    let scale = 1e-5 * (1.0 + numeric[row].abs());
                    prop_assert!((found[(row, column)] - numeric[row]).abs() < scale, "{row} {column}");
                }
            }
        }

        /// Where the bend does not matter the transform is the linear one.
        //= reference/SPEC.md#cov
        //= type=test
        //# - **COV-1** The distribution of `(a, s, k)` MUST be split into that of `k` and that of `(a, s)` given `k`,
        //# whose mean moves by `Σ_{as,k}/Σ_kk` per unit of k and whose covariance is `Σ_as - Σ_{as,k} Σ_{k,as}/Σ_kk`.
        //= reference/SPEC.md#cov
        //= type=test
        //# - **COV-3** Its covariance MUST be that of the five nodes about their mean, plus the mean over the nodes of
        //# the covariance of `(a, s)` given `k` carried through the derivatives of POSE by `a` and `s`.
        #[test]
        fn small_errors_go_through_linearly(a in -200.0..200.0f64, s in 20.0..100.0f64, slope in -1.7..1.7f64) {
            let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Wide));
            let homography = Homography { a, s, k: slope * s / 640.0 };
            let covariance = Matrix3::new(1.0, 0.3, 2e-3, 0.3, 0.8, -1e-3, 2e-3, -1e-3, 1e-4) * 1e-8;
            let found = transform(&homography, &covariance, &camera, &landmark);
            let j = jacobian(&homography, &camera, &landmark);
            let linear = j * covariance * j.transpose();
            prop_assert!((found.covariance - linear).abs().max() < 1e-3 * linear.abs().max());
        }
    }

    //= reference/SPEC.md#cov
    //= type=test
    //# - **COV-5** The covariance of the paper's estimate MUST be that of (11) in the position, along the axis `(-sin
    //# 2η, cos 2η)` with the inclination η (ERRATA-6) and across it, d at most 1 m; the heading turns with the polar
    //# angle, `δθ = (x δy - y δx)/d²`, to which a variance of `1/(12 f²)` of the bearing is added.
    //= reference/SPEC.md#errata
    //= type=test
    //# - **ERRATA-9** The variance of θ, for which the paper has no model, MUST be that of COV-5 where the paper's
    //# estimate is used.
    #[test]
    fn the_papers_covariance_has_the_papers_axes() {
        // 30 cm away under 30°: the long axis at -30° (ERRATA-6), sqrt(exp(25.7 0.3 - 15.46)) = 20.8 mm.
        let polar = PI / 6.0;
        let pose = Pose::new(0.3 * polar.cos(), 0.3 * polar.sin(), wrap(PI + polar));
        let covariance = paper(&pose, &Camera::epuck());
        let position: Matrix2<f64> = covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let long = Vector2::new((-polar).cos(), (-polar).sin());
        let major = long.dot(&(position * long)).sqrt();
        assert!((major - 0.0208).abs() < 1e-4, "{major}");
        // Along this axis the polar angle turns by sin 60° per distance.
        let heading = (covariance[(2, 2)]).sqrt();
        assert!((heading - 0.0208 / 0.3 * (PI / 3.0).sin()).abs() < 1e-3, "{heading}");
    }
}
