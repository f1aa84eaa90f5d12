//! What a sighting of a landmark says about the robot.

mod image;

use crate::binary::times;
use crate::camera::Camera;
use crate::covariance::{Covariance, PoseCovariance};
use crate::formats::{Angle, Length};
use crate::frame::{self, Pose, Robot, World};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::motion::{self, Drive, State, StateCovariance};
use crate::ratio::dropped;
use crate::rotation::sin_cos;

/// How a sighting is compared with a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// By what the image shows (`OBSERVE-3`).
    Image {
        /// `(a, s, k)`.
        homography: Homography,
        /// The fit's covariance (`FIT-14`).
        covariance: Covariance,
    },
    /// By the robot's pose (`OBSERVE-2`).
    Pose,
}

/// A landmark of which it is known where it stands, and how the camera saw it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sighting {
    /// Where it stands.
    pub place: Pose<World, frame::Landmark>,
    /// Its dimensions.
    pub landmark: Landmark,
    /// The camera's pose as reported.
    pub pose: Pose<frame::Landmark, frame::Camera>,
    /// Its covariance (`COV-4`, `COV-5`).
    pub covariance: PoseCovariance,
    /// What a filter compares.
    pub seen: Seen,
}

/// The camera's pose in the robot's frame, its position within ±1 m.
pub type Mounting = Pose<Robot, frame::Camera>;

/// 3 cm ahead of the axle's middle, looking ahead, rounded to 2^-24 m (`OBSERVE-1`).
//= reference/SPEC.md#observe
//# - **OBSERVE-1** The camera MUST by default be mounted 3 cm ahead of the axle's middle, looking ahead.
#[must_use]
pub const fn mounted_ahead() -> Mounting {
    Pose::new(Length::from_bits(503_316), Length::ZERO, Angle::ZERO)
}

/// Fraction bits of a [`Linearised`]'s residuals.
pub const RESIDUAL_BITS: u8 = 36;

/// Fraction bits of a [`Linearised`]'s derivatives.
pub const DERIVATIVE_BITS: u8 = 32;

/// A sighting as it is seen from a state.
///
/// Units: of an image 16 px for `a` and `s` and 1/16 for `k`, so that their variances are of similar sizes; of a pose metres and
/// radians.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Linearised {
    /// What was seen less what the state predicts, [`RESIDUAL_BITS`].
    pub residual: [i64; 3],
    /// The derivatives of the prediction by x, y and the heading: per metre and per radian, [`DERIVATIVE_BITS`].
    pub by_pose: [[i64; 3]; 3],
    /// The covariance of the noise, the incomplete steps' among it (`OBSERVE-4`, `MOTION-7`).
    pub noise: StateCovariance,
}

/// A sighting linearised at a state; `None` if the landmark's centre is less than 2^-8 m in front of the camera (`FILTER-4`), or
/// where it would be seen as no camera sees it (`FILTER-10`).
///
/// Errors of an image: of the prediction 2^-27 of it and 2^-29 rad times the focal length; of the derivatives 2^-27 of the
/// largest in their row. Of a pose: 2^-25 m and 2^-32 π, and the derivatives are exact.
#[must_use]
pub fn linearised(
    sighting: &Sighting,
    state: &State,
    camera: &Camera,
    mounting: &Mounting,
    drive: &Drive,
) -> Option<Linearised> {
    let steps = motion::step_noise(state, drive);
    match &sighting.seen {
        Seen::Image { homography, covariance } => {
            let view = image::View::new(sighting, state, camera, mounting)?;
            Some(view.linearised(homography, covariance, &steps))
        }
        Seen::Pose => {
            let (pose, covariance) = robot_in_world(sighting, mounting);
            let one = 1 << DERIVATIVE_BITS;
            let length = |seen: Length, known: i64| (i64::from(seen.to_bits()) << 12).saturating_sub(dropped(known, 4));
            Some(Linearised {
                residual: [length(pose.x, state.x), length(pose.y, state.y), turn(pose.theta, state.heading)],
                by_pose: [[one, 0, 0], [0, one, 0], [0, 0, one]],
                noise: StateCovariance::of_pose(&sum(&covariance, &steps)),
            })
        }
    }
}

/// An angle less a heading in units of π/2^63, the short way round: radians with [`RESIDUAL_BITS`], relative error 2^-29.
fn turn(seen: Angle, heading: i64) -> i64 {
    const PI: i32 = 421_657_428; // 27 fraction bits
    let difference = (i64::from(seen.to_bits()) << 32).wrapping_sub(heading);
    times(difference >> 22, PI, 32)
}

fn sum(one: &PoseCovariance, other: &PoseCovariance) -> PoseCovariance {
    PoseCovariance {
        xx: one.xx.saturating_add(other.xx),
        xy: one.xy.saturating_add(other.xy),
        xt: one.xt.saturating_add(other.xt),
        yy: one.yy.saturating_add(other.yy),
        yt: one.yt.saturating_add(other.yt),
        tt: one.tt.saturating_add(other.tt),
    }
}

/// The robot's pose in the world as a sighting's pose says, and its covariance (`OBSERVE-2`).
///
/// With the landmark at `(l, λ)`, the camera at `(p, θ)` in its frame, and the camera mounted at `(m, μ)`, the robot's heading is
/// `ϑ = λ + θ - μ` and its position `l + R(λ) p - R(ϑ) m`, which turns with `θ` by `-R(ϑ + π/2) m`.
///
/// Errors: 2^-25 m, and 2^-30 of the distances; of the covariance 2^-47 and 2^-29 of its largest entry. A position outside
/// ±128 m saturates.
//= reference/SPEC.md#observe
//# - **OBSERVE-2** As a pose, a sighting MUST be (10), the camera's pose in the landmark's frame taken to the robot and
//# the world, with its covariance (COV-4, COV-5) carried through the derivatives.
#[must_use]
pub fn robot_in_world(sighting: &Sighting, mounting: &Mounting) -> (Pose<World, Robot>, PoseCovariance) {
    let Sighting { place, pose, .. } = sighting;
    let heading = place.theta + pose.theta - mounting.theta;
    let [turned_x, turned_y] = rotated(position(pose), place.theta);
    let [mounted_x, mounted_y] = rotated(position(mounting), heading);
    let [place_x, place_y] = position(place);
    let robot = Pose::new(length(place_x + turned_x - mounted_x), length(place_y + turned_y - mounted_y), heading);
    let [sin, cos] = sin_cos(place.theta);
    let by = [[cos, -sin, lever(mounted_y)], [sin, cos, lever(-mounted_x)]];
    (robot, carried(&sighting.covariance, by))
}

/// The sighting that says where a robot is in a landmark's frame: the camera's pose there, by its mounting, so that
/// [`robot_in_world`] takes it back to the robot.
///
/// With the robot at `(p, θ)`, the camera is at `p + R(θ) m`, which turns with `θ` by `R(θ + π/2) m`, and its heading is `θ + μ`.
/// Errors: 2^-25 m; of the covariance 2^-47 and 2^-29 of its largest entry. A position outside ±128 m saturates.
#[must_use]
pub fn of_robot(
    place: &Pose<World, frame::Landmark>,
    robot: &Pose<frame::Landmark, Robot>,
    covariance: &PoseCovariance,
    mounting: &Mounting,
) -> Sighting {
    let [robot_x, robot_y] = position(robot);
    let [mounted_x, mounted_y] = rotated(position(mounting), robot.theta);
    let one = 1 << 30;
    Sighting {
        place: *place,
        landmark: Landmark::paper(), // whose dimensions a pose has no use for
        pose: Pose::new(length(robot_x + mounted_x), length(robot_y + mounted_y), robot.theta + mounting.theta),
        covariance: carried(covariance, [[one, 0, lever(-mounted_y)], [0, one, lever(mounted_x)]]),
        seen: Seen::Pose,
    }
}

/// A length of 40 fraction bits, limited to its format.
fn length(value: i64) -> Length {
    let limited = dropped(value, 16).clamp(i64::from(i32::MIN), i64::from(i32::MAX));
    Length::from_bits(i32::try_from(limited).unwrap_or_default())
}

/// A length within ±1.5 m, from 40 fraction bits to 30.
fn lever(value: i64) -> i32 {
    i32::try_from(dropped(value, 10)).unwrap_or_default()
}

/// A covariance through derivatives of x and y by x, y and θ, 30 fraction bits; θ stays.
fn carried(covariance: &PoseCovariance, [by_x, by_y]: [[i32; 3]; 2]) -> PoseCovariance {
    let PoseCovariance { xx, xy, xt, yy, yt, tt } = *covariance;
    let dot = |by: [i32; 3], values: [i64; 3]| {
        by.into_iter().zip(values).fold(0_i64, |sum, (by, value)| sum.saturating_add(times(value, by, 30)))
    };
    let row = |by: [i32; 3]| [dot(by, [xx, xy, xt]), dot(by, [xy, yy, yt]), dot(by, [xt, yt, tt])];
    let (x, y) = (row(by_x), row(by_y));
    let ([.., x_turn], [.., y_turn]) = (x, y);
    PoseCovariance { xx: dot(by_x, x), xy: dot(by_y, x), xt: x_turn, yy: dot(by_y, y), yt: y_turn, tt }
}

/// The position of a pose, metres with 40 fraction bits.
pub(crate) fn position<Parent, Child>(pose: &Pose<Parent, Child>) -> [i64; 2] {
    [pose.x, pose.y].map(|length| i64::from(length.to_bits()) << 16)
}

/// A vector turned by an angle; error 2^-30 of it.
pub(crate) fn rotated([x, y]: [i64; 2], angle: Angle) -> [i64; 2] {
    let [sin, cos] = sin_cos(angle);
    [times(x, cos, 30) - times(y, sin, 30), times(x, sin, 30) + times(y, cos, 30)]
}

#[cfg(test)]
mod tests;
