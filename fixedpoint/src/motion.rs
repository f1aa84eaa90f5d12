//! How the robot moves by the steps of its wheels.
//!
//! A state is the robot's pose in the world, `e`, by how much the right wheel is larger than the left one, `g`, by how much
//! the axle is longer than nominal, and their covariance. Where `e` and `g` are known, their variances being 0, three
//! numbers are left and cost what three do.
//!
//! Between two odometry readings the ways are parts of steps, so steps have fraction bits.

pub mod covariance;
mod drive;
mod state;
mod step;

use crate::covariance::PoseCovariance;
use crate::formats::{Slip, Steps};
use crate::ratio;
pub use covariance::{COVARIANCE_BITS, SHARE_UNIT_BITS, STATES, StateCovariance};
pub use drive::{Drive, MotionModel};
pub(crate) use state::angle;
pub use state::{POSITION_BITS, State};
use step::Step;

/// The slip when `e` and `g` are estimated: 1e-6 m, rounded to 2^-32 (`MOTION-6`).
//= reference/SPEC.md#motion
//# - **MOTION-6** The slip MUST by default be `q = 1e-6 m` with five states, 1 mm per root metre, and `3e-6 m` with
//# three, of which `e` and `g` are known to be 0 *(choice: what is not estimated is slip)*.
pub const SLIP_OF_FIVE: Slip = Slip::from_bits(4_295);

/// The slip when `e` and `g` are known to be 0: 3e-6 m, rounded to 2^-32 (`MOTION-6`).
pub const SLIP_OF_THREE: Slip = Slip::from_bits(12_885);

/// The largest slip, 2^-12 m, 16 mm per root metre; a larger one counts as this.
pub const LARGEST_SLIP: Slip = Slip::from_bits(1 << 20);

/// What the wheels turned since the last prediction: steps, forward positive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ways {
    /// Steps of the left wheel.
    pub left: Steps,
    /// Steps of the right wheel.
    pub right: Steps,
}

/// Moves a state by the ways of its wheels (`MOTION-1` to `MOTION-5`).
///
/// A way that is longer than the axle is moved in 2^n equal parts that are not: the pose and `F` are the same, and slip is
/// independent from part to part. No way at all changes nothing.
///
/// Rounding errors: of the ways 2^-41 m and 2^-30 of them; of the heading 2^-39 m over the axle, 2^-40 rad
/// and 2^-29 of the turn; of x and y 2^-40 m
/// and 2^-29 of the way; of the derivatives 2^-29, of those by the ways 2^-23; of the covariance what [`StateCovariance`]
/// says.
pub fn predict(state: &mut State, ways: &Ways, drive: &Drive, model: MotionModel, slip: Slip) {
    let slip = slip.min(LARGEST_SLIP);
    let [left, right] = [ways.left, ways.right].map(|steps| drive.way(steps.to_bits()));
    if left == 0 && right == 0 {
        return;
    }
    let farther = left.unsigned_abs().max(right.unsigned_abs());
    let mut parts = 0_u32; // as a power of two; below 2^16, as 2^15 steps are at most 402 m
    while farther >> parts > drive.axle().unsigned_abs() {
        parts += 1;
    }
    for part in 0..1_i64 << parts {
        // Differences of what is rounded, so that nothing is lost in the sum; below 2^49 2^15.
        let [left, right] =
            [left, right].map(|way| ((way * (part + 1)) >> parts).saturating_sub((way * part) >> parts));
        Step::new(state, drive, model, left, right).take(state, drive, slip, left, right);
    }
}

/// The uncertainty of a pose by steps that are not yet complete, `G diag(u²/12, u²/12) Gᵀ` at rest (`MOTION-7`).
///
/// Errors: 2^-49, and 2^-22 from the derivatives.
//= reference/SPEC.md#motion
//# - **MOTION-7** At an observation the pose MUST count as uncertain by `G diag(u²/12, u²/12) Gᵀ` more, G at rest
//# *(choice: a step that is not yet complete is an error of the reading that the next one does not inherit)*.
#[must_use]
pub fn step_noise(state: &State, drive: &Drive) -> PoseCovariance {
    let at_rest = Step::new(state, drive, MotionModel::Linear, 0, 0);
    let wheels = at_rest.noise(state, [drive.step_variance(); 2]);
    let entry = |i: usize, j: usize| {
        let sum = wheels.iter().fold(0_i64, |sum, wheel| sum.saturating_add(wheel.entry(i, j)));
        ratio::dropped(sum, COVARIANCE_BITS - 48)
    };
    PoseCovariance {
        xx: entry(0, 0),
        xy: entry(0, 1),
        xt: entry(0, 2),
        yy: entry(1, 1),
        yt: entry(1, 2),
        tt: entry(2, 2),
    }
}

#[cfg(test)]
mod tests;
