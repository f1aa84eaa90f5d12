//! A landmark as the camera sees it from a state.

use super::{DERIVATIVE_BITS, Linearised, Mounting, Sighting, position, rotated};
use crate::binary::{product, scaled, times};
use crate::camera::Camera;
use crate::covariance::{Covariance, PoseCovariance};
use crate::homography::Homography;
use crate::inverse::Inverse;
use crate::motion::{State, StateCovariance};
use crate::ratio::dropped;
use crate::rotation::sin_cos;

/// The least depth, 2^-8 m, with 40 fraction bits.
const NEAREST: i64 = 1 << 32;

/// The largest `|a|` and `|s|`, 2048 px with 32 fraction bits, and `|k|`, 4 with 40 (`FILTER-10`).
const FARTHEST: u64 = 2048 << 32;
const STEEPEST: u64 = 4 << 40;

/// What a camera at a state's pose sees of a landmark.
///
/// `a = -f l/d`, `s = -f W cos θ/d`, `k = W sin θ/d` (`OBSERVE-3`). Moved by `δd`, `δl` and `δθ` they change by
/// `-(f δl + a δd)/d`, `f k δθ - s δd/d` and `W cos θ/d δθ - k δd/d`.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// Focal length in px, 16 fraction bits.
    f: i32,
    /// `1/d`, d with 40 fraction bits.
    over_depth: Inverse,
    /// px with 32 fraction bits.
    a: i64,
    /// Likewise.
    s: i64,
    /// 40 fraction bits.
    k: i64,
    /// `W cos θ/d`, 40 fraction bits.
    facing: i64,
    /// `d` and `l` by x, y and the heading: 1 and metres with 40 fraction bits.
    moves: [[i64; 2]; 3],
}

impl View {
    /// `None` if the barcode's centre is nearer than [`NEAREST`] or behind the camera, or seen as no camera sees it (`FILTER-10`), which
    /// also keeps the noise by the steps within its format.
    //= reference/SPEC.md#filter
    //# - **FILTER-10** An image MUST NOT be used if one of its linearisations expects `|a|` or `|s|` above 2048 px or
    //# `|k|` above 4.
    //= reference/SPEC.md#observe
    //# - **OBSERVE-3** As an image, a sighting MUST be `(a, s, k)`, compared with what the camera at the state's pose
    //# would see: `a = -f l/d`, `s = -f W cos θ/d`, `k = W sin θ/d` of its heading θ in L, the depth `d` of the
    //# barcode's centre and its offset `l` to the left.
    pub(super) fn new(sighting: &Sighting, state: &State, camera: &Camera, mounting: &Mounting) -> Option<Self> {
        let heading = crate::motion::angle(state.heading);
        let direction = heading + mounting.theta;
        let [ahead_x, ahead_y] = rotated(position(mounting), heading);
        let [place_x, place_y] = position(&sighting.place);
        let to_x = place_x.saturating_sub(state.x).saturating_sub(ahead_x);
        let to_y = place_y.saturating_sub(state.y).saturating_sub(ahead_y);
        let [depth, left] = rotated([to_x, to_y], -direction);
        if depth < NEAREST {
            return None;
        }
        let f = i32::try_from(camera.focal_length().to_bits()).ok()?; // at most 2^27
        let over_depth = Inverse::of(depth)?;
        let landmark = &sighting.landmark;
        let half_width = i64::from(landmark.stripe_width().to_bits()) * i64::from(landmark.format.stripes() / 2); // 32
        let [sin, cos] = sin_cos(direction - sighting.place.theta);
        let over = |share: i32| over_depth.times(times(half_width << 8, share, 30), 40);
        let (facing, k) = (over(cos), over(sin));
        let (a, s) = (-over_depth.times(times(left, f, 16), 32), -times(facing, f, 24));
        if a.unsigned_abs() > FARTHEST || s.unsigned_abs() > FARTHEST || k.unsigned_abs() > STEEPEST {
            return None;
        }
        // The camera's place, in its own directions, turns with the robot.
        let [mounted_x, mounted_y] = rotated(position(mounting), -mounting.theta);
        let [along_sin, along_cos] = sin_cos(direction).map(|value| i64::from(value) << 10);
        Some(Self {
            f,
            over_depth,
            a,
            s,
            k,
            facing,
            moves: [[-along_cos, along_sin], [-along_sin, -along_cos], [left + mounted_y, -depth - mounted_x]],
        })
    }

    /// The derivatives of `a`, `s` and `k` by one of x, y and the heading, in [`Linearised`]'s units.
    fn derivatives(&self, [depth, left]: [i64; 2], turns: bool) -> [i64; 3] {
        let over = |numerator: i64| self.over_depth.times(numerator, 36);
        let aside = dropped(times(left, self.f, 16), 8).saturating_add(product(self.a, depth, 40));
        let nearer = over(-product(self.s, depth, 40));
        let slanted = over(-product(self.k, depth, 40));
        let [by_turn_s, by_turn_k] =
            if turns { [product(i64::from(self.f), self.k, 28), dropped(self.facing, 4)] } else { [0, 0] };
        [over(-aside), nearer.saturating_add(by_turn_s), slanted.saturating_add(by_turn_k)]
    }

    /// Compares it with what was seen.
    pub(super) fn linearised(&self, seen: &Homography, covariance: &Covariance, steps: &PoseCovariance) -> Linearised {
        let [by_x, by_y, by_heading] = self.moves;
        let columns =
            [self.derivatives(by_x, false), self.derivatives(by_y, false), self.derivatives(by_heading, true)];
        let [[ax, sx, kx], [ay, sy, ky], [at, st, kt]] = columns;
        let by_pose = [[ax, ay, at], [sx, sy, st], [kx, ky, kt]];
        Linearised {
            // px with 32 fraction bits are 16 px with 36, as are 1/16 with 36 those of 1 with 40.
            residual: [
                (i64::from(seen.a.to_bits()) << 12).saturating_sub(self.a),
                (i64::from(seen.s.to_bits()) << 12).saturating_sub(self.s),
                (i64::from(seen.k.to_bits()) << 10).saturating_sub(self.k),
            ],
            by_pose,
            noise: noise(covariance, &by_pose, steps),
        }
    }
}

/// The noise of an image: the fit's, what no model covers, and the incomplete steps' (`OBSERVE-4`, `MOTION-7`).
///
/// Errors: 2^-56, and of the steps' part 2^-49 of the squares of the derivatives.
//= reference/SPEC.md#observe
//# - **OBSERVE-4** The noise of an image MUST be the fit's covariance (FIT-14) with `0.1² px²`, `0.05² px²` and
//# `0.0005²` added for what no model covers.
fn noise(covariance: &Covariance, by_pose: &[[i64; 3]; 3], steps: &PoseCovariance) -> StateCovariance {
    /// 0.1² px², 0.05² px² and 0.0005², with 56 fraction bits of their units' squares.
    const UNMODELLED: [i64; 3] = [2_814_749_767_107, 703_687_441_777, 4_611_686_018_427];
    let Covariance { aa, as_, ak, ss, sk, kk } = *covariance;
    // From 50 fraction bits: px² by 2^-8, px as they are, 1 by 2^8.
    let fitted = [
        [scaled(aa, -2), scaled(as_, -2), scaled(ak, 6)],
        [scaled(as_, -2), scaled(ss, -2), scaled(sk, 6)],
        [scaled(ak, 6), scaled(sk, 6), scaled(kk, 14)],
    ];
    let PoseCovariance { xx, xy, xt, yy, yt, tt } = *steps;
    let dot = |by: &[i64; 3], values: [i64; 3], bits: u8| {
        by.iter().zip(values).fold(0_i64, |sum, (&by, value)| sum.saturating_add(product(by, value, bits)))
    };
    let mut noise = StateCovariance::default();
    for ((i, by), (row, more)) in by_pose.iter().enumerate().zip(fitted.iter().zip(UNMODELLED)) {
        let row_of_steps = [[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]].map(|values| dot(by, values, DERIVATIVE_BITS));
        for ((j, other), &entry) in by_pose.iter().enumerate().zip(row).skip(i) {
            let diagonal = if i == j { more } else { 0 };
            noise.set(i, j, entry.saturating_add(diagonal).saturating_add(dot(other, row_of_steps, 24)));
        }
    }
    noise.settle([1, 1, 1, 0, 0]);
    noise
}

#[cfg(test)]
mod tests {
    #![allow(clippy::cast_possible_truncation)] // of numbers in range

    use super::*;

    /// `OBSERVE-4` at rest: the fit's covariance in units of 16 px, 16 px and 1/16, and on the diagonal what no model covers.
    #[test]
    fn noise_is_the_fit_s_and_what_no_model_covers() {
        let of = |value: f64| (value * 2_f64.powi(50)).round() as i64;
        let covariance =
            Covariance { aa: of(0.25), as_: of(-0.125), ak: of(1e-4), ss: of(0.5), sk: of(-2e-4), kk: of(1e-6) };
        let noise = noise(&covariance, &[[0; 3]; 3], &PoseCovariance::default());
        let exact = [
            ((0, 0), (0.25 + 0.01) / 256.0),
            ((0, 1), -0.125 / 256.0),
            ((0, 2), 1e-4),
            ((1, 1), (0.5 + 0.0025) / 256.0),
            ((1, 2), -2e-4),
            ((2, 2), (1e-6 + 2.5e-7) * 256.0),
        ];
        for ((i, j), exact) in exact {
            let found = noise.entry(i, j) as f64 / 2_f64.powi(56);
            assert!((found - exact).abs() <= 2_f64.powi(-42), "{i} {j} {found} {exact}");
        }
    }
}
