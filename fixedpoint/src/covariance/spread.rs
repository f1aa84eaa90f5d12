//! How a pose moves with `a` and `s`.

use super::node::Node;
use super::{Conditional, PoseCovariance};
use crate::binary::{product, scaled, size};
use crate::camera::Camera;
use crate::homography::Homography;
use crate::reciprocal::Reciprocal;

/// The derivatives of `x`, `y` in m/px and of `θ` in 1/px, by `a` and by `s`: 40 fraction bits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Derivatives {
    x: [i64; 2],
    y: [i64; 2],
    t: [i64; 2],
}

impl Derivatives {
    /// Those at a homography and its pose.
    ///
    /// Errors: relative 2^-28 from `1/ρ²`, and absolute 2^-40.
    pub(super) fn at(homography: &Homography, node: &Node, camera: &Camera) -> Self {
        let a = i64::from(homography.a.to_bits()); // 20 fraction bits
        let s = i64::from(homography.s.to_bits()); // 20
        let f = i64::from(camera.focal_length().to_bits()); // 16
        let (m, w) = (node.m, node.half_width); // 20 and 32
        let inverse = inverse(node.square); // 50
        let by_w = |length: i64| product(product(length, inverse, 20), w, 42);
        let twice = |length: i64| product(s, length, 15); // 2 s x with 40 fraction bits
        let over = |numerator: i64| product(numerator, inverse, 50);
        Self {
            x: [by_w(-m), over(product(w, f, 8).saturating_sub(twice(node.x)))],
            y: [by_w(-s), over(product(w, -a, 12).saturating_sub(twice(node.y)))],
            t: [0, product(m, inverse, 30)],
        }
    }

    /// The covariance of `(a, s)` carried to the pose.
    pub(super) fn carried(&self, given: &Conditional) -> PoseCovariance {
        let dot = |[a, s]: [i64; 2], [one, other]: [i64; 2]| product(a, one, 40).saturating_add(product(s, other, 40));
        // The rows of J Σ, 50 fraction bits.
        let row = |by: [i64; 2]| [dot(by, [given.aa, given.as_]), dot(by, [given.as_, given.ss])];
        let last = |[a, s]: [i64; 2], [one, other]: [i64; 2]| product(a, one, 42).saturating_add(product(s, other, 42));
        let (x, y, t) = (row(self.x), row(self.y), row(self.t));
        PoseCovariance {
            xx: last(self.x, x),
            xy: last(self.x, y),
            xt: last(self.x, t),
            yy: last(self.y, y),
            yt: last(self.y, t),
            tt: last(self.t, t),
        }
    }
}

/// `1/value` of a value with 40 fraction bits, with 50 of them; 0 of 0.
fn inverse(value: i64) -> i64 {
    let bits = size(value);
    let normal = u32::try_from(scaled(value, 32 - bits).min(i64::from(u32::MAX))).unwrap_or(0);
    let Some(reciprocal) = Reciprocal::of(normal) else { return 0 };
    scaled(i64::from(reciprocal.mantissa), i32::from(reciprocal.shift) + 60 - bits)
}
