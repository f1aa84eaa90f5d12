//! The camera's pose from a homography.
//!
//! `A H` of `POSE-1` has the columns `(f k, -s)/W` and `(f, -a)`. With `m = f k` and `ρ² = s² + m²`, scaling by `W/ρ`
//! makes the first a unit vector: `β_1 = (m, -s)/ρ`, `β_0 = (f, -a) W/ρ`. So `sin θ = m/ρ`, `cos θ = -s/ρ`, and
//! `-R(θ) β_0` is
//!
//! `x = W f (s - a k)/(s² + m²)`, `y = -W (f m + a s)/(s² + m²)`, `θ = atan2(m, -s)`,
//!
//! without a root or a trigonometric function, and with lengths in px under the fraction, so that neither `a/f` nor
//! `s/f` is divided out first.

use crate::camera::Camera;
use crate::cordic::atan2;
use crate::formats::Length;
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::ratio;

/// The camera's pose in the landmark's frame (`POSE-1` to `POSE-3`).
///
/// Domain: a merged homography, `|a|` and `|s|` up to 1800 px and `|k| <= 1/2`. A coordinate outside [`Length`]'s range
/// of ±128 m saturates; with stripes of 1.5 mm that asks for a barcode less than 1 px wide.
///
/// Rounding errors, in this order: `m = f k` and `g = s - a k` 2^-21 px each; `x/W = f g/(s² + m²)` and
/// `y/W = -(f m + a s)/(s² + m²)` 2^-25 each; `x` and `y` 2^-25 m each; `θ` as [`atan2`], from `f k` and `s` without
/// further rounding. `W` is exact for the landmark's [`crate::formats::StripeWidth`].
//= reference/SPEC.md#pose
//# - **POSE-1** With `α_0 = (f, 0)`, `α_1 = (0, -1)`, `A = [α_1 α_0]` and `H = [[s/W, a], [k/W, 1]]`, `B = [β_1 β_0]`
//# MUST be `A H` scaled so that `β_1` is a unit vector and `β_0`'s first component is positive (ERRATA-4).
//= reference/SPEC.md#pose
//# - **POSE-2** The camera's heading MUST be `θ = atan2(β_1x, β_1y)` (ERRATA-5).
//= reference/SPEC.md#pose
//# - **POSE-3** The camera's position MUST be `-R(θ) β_0`, the rigid transform (9).
#[must_use]
pub fn pose(homography: &Homography, camera: &Camera, landmark: &Landmark) -> Pose<frame::Landmark, frame::Camera> {
    let a = i64::from(homography.a.to_bits()); // 20 fraction bits
    let s = i64::from(homography.s.to_bits()); // 20
    let k = i64::from(homography.k.to_bits()); // 30
    let f = i64::from(camera.focal_length().to_bits()); // 16, at most 2^27
    let fk = f * k; // 46; at most 2^56 in the domain, 2^58 for any homography
    let m = ratio::dropped(fk, 26); // 20; at most 2^30 in the domain
    let g = ratio::dropped(s * (1 << 30) - a * k, 30); // 20; the difference is below 2^61.3
    // 40 fraction bits, below 2^62 in the domain; only homographies outside of it saturate.
    let rho_squared = (s * s).saturating_add(m.saturating_mul(m));
    let x = f.saturating_mul(g); // 36, below 2^58.3
    let y = f.saturating_mul(m).saturating_mul(-16).saturating_sub(a * s); // 40, below 2^62.3
    // 24 fraction bits of the ratio.
    let x = in_metres(ratio::rounded(x, rho_squared, 28), x, landmark);
    let y = in_metres(ratio::rounded(y, rho_squared, 24), y, landmark);
    Pose::new(x, y, atan2(fk, -s * (1 << 26)))
}

/// A coordinate from half widths, with 24 fraction bits, to metres. `None` is a ratio of the given sign out of reach.
fn in_metres(half_widths: Option<i64>, sign: i64, landmark: &Landmark) -> Length {
    let half_stripes = u32::from(landmark.format.stripes() / 2);
    let w = i128::from(landmark.stripe_width().to_bits()) * i128::from(half_stripes); // 32, below 2^30
    let far = if sign < 0 { i64::MIN } else { i64::MAX };
    let product = i128::from(half_widths.unwrap_or(far)) * w; // 56, below 2^93
    let rounded = (product + (1 << 31)) >> 32;
    let limited = rounded.clamp(i128::from(i32::MIN), i128::from(i32::MAX));
    Length::from_bits(i32::try_from(limited).unwrap_or_default())
}

#[cfg(test)]
mod tests;
