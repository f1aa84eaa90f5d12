//! A pose at a node, finer than one that is reported.

use crate::camera::Camera;
use crate::cordic::atan2;
use crate::formats::Angle;
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::{binary, ratio};

/// What [`crate::pose`] computes, before anything is rounded to its formats.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Metres with 36 fraction bits.
    pub(super) x: i64,
    /// Likewise.
    pub(super) y: i64,
    pub(super) theta: Angle,
    /// `m = f k` in px with 20 fraction bits.
    pub(super) m: i64,
    /// `ρ² = s² + m²` in px² with 40 fraction bits.
    pub(super) square: i64,
    /// `W` in m with 32 fraction bits.
    pub(super) half_width: i64,
}

impl Node {
    /// The node of a homography (`POSE-1` to `POSE-3`).
    ///
    /// Rounding errors: `m` and `s - a k` 2^-21 px each, `x/W` and `y/W` 2^-37, `x` and `y` 2^-37 m; `θ` as [`atan2`].
    pub(super) fn at(homography: &Homography, camera: &Camera, landmark: &Landmark) -> Self {
        let a = i64::from(homography.a.to_bits()); // 20 fraction bits
        let s = i64::from(homography.s.to_bits()); // 20
        let k = i64::from(homography.k.to_bits()); // 30
        let f = i64::from(camera.focal_length().to_bits()); // 16, at most 2^27
        let half_width = i64::from(landmark.stripe_width().to_bits()) * i64::from(landmark.format.stripes() / 2);
        let m = ratio::dropped(f * k, 26); // 20
        let g = s.saturating_sub(binary::product(a, k, 30)); // 20
        let square = s.saturating_mul(s).saturating_add(m.saturating_mul(m));
        let x = f.saturating_mul(g); // 36
        let y = f.saturating_mul(m).saturating_mul(-16).saturating_sub(a.saturating_mul(s)); // 40
        let metres = |numerator: i64, bits: u8| {
            let far = if numerator < 0 { i64::MIN } else { i64::MAX };
            binary::product(ratio::rounded(numerator, square, bits).unwrap_or(far), half_width, 32)
        };
        let theta = atan2(f.saturating_mul(k), s.saturating_neg().saturating_mul(1 << 26));
        Self { x: metres(x, 40), y: metres(y, 36), theta, m, square, half_width }
    }
}
