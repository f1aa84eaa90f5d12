//! The covariance that the paper's regressions give its own estimate (`COV-5`).

use super::PoseCovariance;
use super::exponential::{exp, sin};
use crate::binary::product;
use crate::camera::Camera;
use crate::formats::Angle;
use crate::frame::{self, Pose};
use crate::ratio;

/// The covariance of a pose by the paper's (11), turned by ERRATA-6, with the heading's of ERRATA-9 (`COV-5`).
///
/// The variances along and across the axis are `exp(25.70 d - 15.46)` and `exp(16.15 d - 17.27)` m², `d` the distance
/// in m, at most 1. The inclination is the heading minus π, so that its double is that of the heading.
///
/// Relative errors: 2^-12 of the variances, of which 25.7 · 2^-24 from `d`; 2^-22 of the axis.
//= reference/SPEC.md#cov
//# - **COV-5** The covariance of the paper's estimate MUST be that of (11) in the position, along the axis `(-sin 2η,
//# cos 2η)` with the inclination η (ERRATA-6) and across it, d at most 1 m; the heading turns with the polar angle, `δθ
//# = (x δy - y δx)/d²`, to which a variance of `1/(12 f²)` of the bearing is added.
#[must_use]
pub fn paper(pose: &Pose<frame::Landmark, frame::Camera>, camera: &Camera) -> PoseCovariance {
    let (x, y) = (i64::from(pose.x.to_bits()), i64::from(pose.y.to_bits())); // 24 fraction bits
    let square = (x * x + y * y).unsigned_abs(); // 48
    let distance = i64::try_from(square.isqrt()).unwrap_or(1 << 24).min(1 << 24);
    let (along, across) = (exp(line(distance, 2570, 1546)), exp(line(distance, 1615, 1727)));
    let twice = (pose.theta + pose.theta).to_bits();
    let (sin, cos) = (sin(twice), sin((Angle::from_bits(twice) + Angle::from_bits(1 << 30)).to_bits()));
    let weighted = |one: i64, first: i64, other: i64, second: i64| {
        product(product(one, first, 30), first, 30).saturating_add(product(product(other, second, 30), second, 30))
    };
    let xx = weighted(along, sin, across, cos);
    let yy = weighted(along, cos, across, sin);
    let xy = product(product(across - along, sin, 30), cos, 30);
    // The heading turns by q · (δx, δy) with q = (-y, x)/d², in 1/m with 24 fraction bits.
    let turn = |length: i64| ratio::rounded(length, i64::try_from(square).unwrap_or(i64::MAX), 48).unwrap_or(0);
    let (by_x, by_y) = (turn(-y), turn(x));
    let row = |one: i64, other: i64| product(by_x, one, 24).saturating_add(product(by_y, other, 24));
    let (xt, yt) = (row(xx, xy), row(xy, yy));
    PoseCovariance { xx, xy, xt, yy, yt, tt: row(xt, yt).saturating_add(bearing(camera)) }
}

/// `slope d - offset` in 2^-24, both in hundredths.
fn line(distance: i64, slope: i64, offset: i64) -> i64 {
    (slope * distance - (offset << 24)).div_euclid(100)
}

/// `1/(12 f²)` with 48 fraction bits.
fn bearing(camera: &Camera) -> i64 {
    let f = i64::from(camera.focal_length().to_bits()); // 16 fraction bits
    let square = ratio::dropped(f * f, 20); // 12
    ratio::rounded(1, 12 * square, 60).unwrap_or(0)
}
