//! Skew: how the camera moves between the exposures of the two scan lines, and what that does to an image.
//!
//! `SKEW-2` times the focal length: with `m = f k`, `ρ` the depth of the barcode's centre and `f/ρ = √(m² + s²)/W`,
//! `U = (f - t_x f/ρ, -a - t_y f/ρ)` and `V = (m, -s)` are lengths in px, of which none is divided before both are turned;
//! `a' = -f U'_y/U'_x`, `s' = -f V'_y/U'_x`, `k' = V'_x/U'_x`.

mod play;
mod shift;

use crate::binary::{product, times};
use crate::camera::Camera;
use crate::covariance::PoseCovariance;
use crate::formats::{Angle, Column, Displacement, Length, Obliquity, Slip};
use crate::frame::Pose;
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::motion::{self, Drive, MotionModel, State, Ways};
use crate::observation::{Mounting, position, rotated};
use crate::ratio::{self, dropped};
use crate::rotation::sin_cos;
pub use shift::{EndShifts, Shift};

/// The camera at the lower row's time in the camera at the upper row's: `(t_x, t_y, φ)`, ahead and to the left, and how far odometry
/// may be wrong about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skew {
    /// `t_x` in m.
    pub x: Displacement,
    /// `t_y` in m.
    pub y: Displacement,
    /// `φ`, counter-clockwise.
    pub turn: Angle,
    /// The play `T` in px, 0 at rest only (`SKEW-5`).
    pub play: u32,
}

/// Fraction bits of `U` and `V`, in px.
const PLANE_BITS: u8 = 30;

impl Skew {
    /// A camera that does not move.
    pub const AT_REST: Self = Self { x: Displacement::ZERO, y: Displacement::ZERO, turn: Angle::ZERO, play: 0 };

    /// Whether it is [`Self::AT_REST`]: no wheel has moved.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        *self == Self::AT_REST
    }

    /// The camera's motion through its mounting, by what the wheels turned between both rows' times, reading after reading
    /// (`SKEW-1`), and the play of it (`SKEW-5`).
    ///
    /// With the robot moved to `p` and turned by `φ`, and the camera mounted at `(m, μ)`, it is `R(-μ)(p + R(φ) m - m)` and `φ`.
    /// Rounding errors: those of [`motion::predict`] for each reading, of the turn 2^-32 π, and of the lever 2^-29 of `m`. The play is
    /// exact unless the real number is within 2^-10 px of a whole one.
    //= reference/SPEC.md#skew
    //# - **SKEW-1** The motion of the camera MUST be that of the robot through its mounting: MOTION-2 and MOTION-3 with
    //# `e = g = 0` over the readings between both times, a reading's steps taken in proportion to the part of its time.
    #[must_use]
    pub fn of_ways(
        readings: impl IntoIterator<Item = Ways>,
        drive: &Drive,
        mounting: &Mounting,
        camera: &Camera,
    ) -> Self {
        let origin = Pose::new(Length::ZERO, Length::ZERO, Angle::ZERO);
        let mut robot = State::new(&origin, &PoseCovariance::default());
        let mut steps = 0_u64;
        for ways in readings {
            steps = steps.saturating_add(play::steps_of(&ways));
            motion::predict(&mut robot, &ways, drive, MotionModel::Arc, Slip::ZERO);
        }
        let turn = motion::angle(robot.heading);
        let mounted = position(mounting);
        let [ahead, aside] = rotated(mounted, turn);
        let [mounted_x, mounted_y] = mounted;
        let moved = [robot.x.saturating_add(ahead - mounted_x), robot.y.saturating_add(aside - mounted_y)];
        let [x, y] = rotated(moved, -mounting.theta).map(Displacement::from_bits);
        Self { x, y, turn, play: play::play(steps, drive, camera) }
    }

    /// A homography as the camera sees it at the lower row's time (`SKEW-2`); `None` where it is paired with nothing
    /// (`SKEW-3`) or does not fit its formats. At rest it is the same.
    ///
    /// Rounding errors: of `m` 2^-21 px and of `√(m² + s²)` 2^-20 px more, which count times `t/W`, and 2^-30 px; of the
    /// turn 2^-30 of what is turned and 2^-30 px; and of `a'` and `s'` 2^-21 px, of `k'` 2^-31.
    //= reference/SPEC.md#skew
    //# - **SKEW-2** A homography `(a, s, k)` MUST be carried to the lower row by `1/ρ = √(k² + (s/f)²)/W`, `u = (1 -
    //# t_x/ρ, -a/f - t_y/ρ)` and `v = (k, -s/f)`, which are turned by `-φ` into `u'` and `v'`: `a' = -f u'_y/u'_x`, `s'
    //# = -f v'_y/u'_x`, `k' = v'_x/u'_x`; its *shift* is `Δ = (a' - a, s' - s, k' - k)`.
    #[must_use]
    pub fn carry(&self, homography: &Homography, camera: &Camera, landmark: &Landmark) -> Option<Homography> {
        if self.is_at_rest() {
            return Some(*homography);
        }
        let Plane { centre, half } = Plane::of(homography, camera, landmark, self)?;
        let [depth, aside] = turned_back(centre, self.turn);
        let [nearer, width] = turned_back(half, self.turn);
        let f = i64::from(camera.focal_length().to_bits()); // 16 fraction bits
        if depth < f << (PLANE_BITS - 18) {
            return None;
        }
        // Of a ratio 40 fraction bits, of the focal length 16.
        let column = |length: i64| {
            let column = product(ratio::rounded(length.checked_neg()?, depth, 40)?, f, 36);
            Some(Column::from_bits(i32::try_from(column).ok()?))
        };
        let k = i32::try_from(ratio::rounded(nearer, depth, 30)?).ok()?;
        let carried = Homography { a: column(aside)?, s: column(width)?, k: Obliquity::from_bits(k) };
        is_barcode(&carried, landmark).then_some(carried)
    }

    /// The shift of a homography (`SKEW-2`), 0 at rest; `None` where it is paired with nothing (`SKEW-3`).
    ///
    /// The errors are those of [`Self::carry`].
    #[must_use]
    pub fn shift(&self, homography: &Homography, camera: &Camera, landmark: &Landmark) -> Option<Shift> {
        Shift::between(homography, &self.carry(homography, camera, landmark)?)
    }
}

/// `U`, the barcode's centre, and `V`, the half of it, seen from where the camera is at the lower row's time, but not yet turned:
/// ahead and to the left, px with [`PLANE_BITS`].
struct Plane {
    centre: [i64; 2],
    half: [i64; 2],
}

impl Plane {
    /// `None` where a displacement is more than 2^22 px.
    fn of(homography: &Homography, camera: &Camera, landmark: &Landmark, skew: &Skew) -> Option<Self> {
        let [a, s] = [homography.a, homography.s].map(|column| i64::from(column.to_bits())); // 20 fraction bits
        let f = i64::from(camera.focal_length().to_bits()); // 16
        let fk = f * i64::from(homography.k.to_bits()); // 46, at most 2^58
        let m = dropped(fk, 26).unsigned_abs(); // 20, at most 2^32 for any homography
        // m² + s² with 40 fraction bits: at most 2^64, and 2^63 of |k| <= 1.
        let length = m.saturating_mul(m).saturating_add(s.unsigned_abs().saturating_mul(s.unsigned_abs())).isqrt();
        let length = i64::try_from(length).ok()?; // 20
        let half_width = i64::from(landmark.stripe_width().to_bits()) * i64::from(landmark.format.stripes() / 2); // 32
        // px m with 40 fraction bits over m with 32, and 22 more.
        let displaced = |way: Displacement| {
            let pixels = ratio::rounded(product(length, way.to_bits(), 20), half_width, PLANE_BITS - 8)?;
            (pixels.unsigned_abs() < 1 << (22 + PLANE_BITS)).then_some(pixels)
        };
        Some(Self {
            centre: [(f << (PLANE_BITS - 16)) - displaced(skew.x)?, -(a << (PLANE_BITS - 20)) - displaced(skew.y)?],
            half: [dropped(fk, 46 - PLANE_BITS), -(s << (PLANE_BITS - 20))],
        })
    }
}

/// A vector turned by `-φ`.
fn turned_back([x, y]: [i64; 2], turn: Angle) -> [i64; 2] {
    let [sin, cos] = sin_cos(turn);
    [times(x, cos, 30) + times(y, sin, 30), times(y, cos, 30) - times(x, sin, 30)]
}

/// Whether there can be a barcode there: `|k| <= 3/4`, `s >= N/4` and columns that grow, `s > a k` (`SKEW-3`), exactly.
//= reference/SPEC.md#skew
//# - **SKEW-3** A homography that is carried to `u'_x < 1/4`, `|k'| > 3/4`, `s' < N/4` or `s' <= a' k'` MUST be paired
//# with nothing.
fn is_barcode(homography: &Homography, landmark: &Landmark) -> bool {
    let [a, s] = [homography.a, homography.s].map(|column| i64::from(column.to_bits()));
    let k = i64::from(homography.k.to_bits());
    let quarter = i64::from(landmark.format.stripes()) << 18;
    k.unsigned_abs() <= 3 << 28 && s >= quarter && s << 30 > a * k
}

#[cfg(test)]
mod tests;
