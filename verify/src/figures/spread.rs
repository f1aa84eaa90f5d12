//! Statistics of the errors of a cell's poses (Fig. 10).

use super::sightings::PoseError;
use reference::regression::wrap_axis;
use serde::Serialize;

/// Mean and covariance of pose errors in L.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Poses.
    pub poses: usize,
    /// Mean error: x and y in metres, θ in radians.
    pub mean: PoseError,
    /// Standard deviation: x and y in metres, θ in radians.
    pub deviation: PoseError,
    /// Correlation of x and y; 0 where one of them does not vary.
    pub correlation: f64,
    /// Correlation of θ and the error along the larger eigenvalue's axis; 0 where one of them does not vary.
    pub heading_correlation: f64,
    /// Larger eigenvalue of the covariance of (x, y), m².
    pub major: f64,
    /// Smaller eigenvalue, m².
    pub minor: f64,
    /// Direction of the larger eigenvalue's axis in L, in (-π/2, π/2] radians.
    pub rotation: f64,
}

impl Spread {
    /// Of at least two errors.
    #[must_use]
    pub fn of(errors: &[PoseError]) -> Option<Self> {
        if errors.len() < 2 {
            return None;
        }
        let count = errors.len() as f64;
        let mean = |part: fn(&PoseError) -> f64| errors.iter().map(part).sum::<f64>() / count;
        let mean = PoseError { x: mean(|e| e.x), y: mean(|e| e.y), theta: mean(|e| e.theta) };
        let moment = |product: &dyn Fn(f64, f64, f64) -> f64| {
            let products = errors.iter().map(|e| product(e.x - mean.x, e.y - mean.y, e.theta - mean.theta));
            products.sum::<f64>() / (count - 1.0)
        };
        let (xx, yy, xy) = (moment(&|x, _, _| x * x), moment(&|_, y, _| y * y), moment(&|x, y, _| x * y));
        let rotation = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (sine, cosine) = rotation.sin_cos();
        let tt = moment(&|_, _, t| t * t);
        // Along the axes rather than from trace and determinant: the smaller one is up to 10⁵ times smaller.
        let major = moment(&|x, y, _| (cosine * x + sine * y).powi(2));
        let minor = moment(&|x, y, _| (cosine * y - sine * x).powi(2));
        let along = moment(&|x, y, t| (cosine * x + sine * y) * t);
        let correlation = |covariance: f64, one: f64, other: f64| {
            let scale = (one * other).sqrt();
            if scale > 0.0 { covariance / scale } else { 0.0 }
        };
        Some(Self {
            poses: errors.len(),
            mean,
            deviation: PoseError { x: xx.sqrt(), y: yy.sqrt(), theta: tt.sqrt() },
            correlation: correlation(xy, xx, yy),
            heading_correlation: correlation(along, major, tt),
            major,
            minor,
            rotation: wrap_axis(rotation),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_6};

    /// Four points of a cross with half axes 2 and 1, turned by 30° and shifted.
    #[test]
    fn a_turned_cross_has_its_axes() {
        let (sine, cosine) = FRAC_PI_6.sin_cos();
        let cross = [(2.0, 0.0), (-2.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        let errors =
            cross.map(|(u, v)| PoseError { x: 5.0 + cosine * u - sine * v, y: sine * u + cosine * v, theta: u });
        let found = Spread::of(&errors).unwrap();
        // Sums of squares 8 and 2 over 4 - 1.
        assert!((found.major - 8.0 / 3.0).abs() < 1e-12 && (found.minor - 2.0 / 3.0).abs() < 1e-12);
        assert!((found.rotation - FRAC_PI_6).abs() < 1e-12 && (found.mean.x - 5.0).abs() < 1e-12);
        assert!((found.deviation.theta - (8.0 / 3.0_f64).sqrt()).abs() < 1e-12);
        // θ is the first coordinate itself.
        assert!((found.heading_correlation - 1.0).abs() < 1e-12);
        // cov = R diag(8, 2)/3 R': xx = 6.5/3, yy = 3.5/3, xy = 6/3 sin 30° cos 30°.
        let correlation = 6.0 * sine * cosine / (6.5_f64 * 3.5).sqrt();
        assert!((found.correlation - correlation).abs() < 1e-12);
    }

    #[test]
    fn one_error_has_no_spread_and_an_axis_along_y_is_a_right_angle() {
        let at = |y: f64| PoseError { x: 0.0, y, theta: 0.0 };
        assert_eq!(Spread::of(&[at(1.0)]), None);
        let found = Spread::of(&[at(1.0), at(-1.0)]).unwrap();
        assert!((found.rotation - FRAC_PI_2).abs() < 1e-12 && found.correlation.abs() < 1e-15);
    }
}
