//! One movement: where it leads, and its derivatives.

use super::covariance::{MOVING, SHARE_UNIT_BITS, WheelNoise};
use super::drive::{Drive, MotionModel, OverAxle};
use super::state::{self, State};
use crate::binary::times;
use crate::formats::Slip;
use crate::ratio::dropped;
use crate::rotation;

/// A movement by `d` and `φ` (`MOTION-2`) and its derivatives.
///
/// Along the direction `ψ` by `d σ`, of an arc `ψ = θ + φ/2` and `σ = sin(φ/2)/(φ/2)`, otherwise `ψ = θ` and `σ = 1`. With `u` the
/// unit vector along `ψ` and `n` the one to its left, by `d` it is `σ u`, by `θ` it is `d σ n`, and by `φ` of an arc it is
/// `d (σ' u + σ n/2)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// By how much x and y change, metres with 40 fraction bits.
    moved: [i64; 2],
    /// By how much the heading does, in units of π/2^63.
    turned: i64,
    /// The turn in radians with 40 fraction bits.
    turn: i64,
    /// The derivatives of x and y by `d`, 30 fraction bits.
    by_way: [i32; 2],
    /// Those by `φ`, metres with 30 fraction bits.
    by_turn: [i32; 2],
    over_axle: OverAxle,
}

impl Step {
    /// The movement of a state by the nominal ways `left` and `right`, metres with 40 fraction bits.
    ///
    /// Rounding errors: `l'`, `r'` and `d` 2^-41 m each; `φ` 2^-39 m over the axle, 2^-40 rad, and 2^-30 of it; the direction 2^-32 π, the
    /// chord and the unit vector as [`rotation`] says, about 2^-30 of `d`; x and y 2^-40 m. Of the derivatives 2^-29.
    //= reference/SPEC.md#motion
    //# - **MOTION-2** With the ways `l` and `r` and the nominal axle `b`, the axle's middle MUST go `d = (l' + r')/2`
    //# and turn by `φ = (r' - l')/(b (1 + g))`, `l' = l (1 - e/2)` and `r' = r (1 + e/2)`.
    pub(super) fn new(state: &State, drive: &Drive, model: MotionModel, left: i64, right: i64) -> Self {
        const INVERSE_PI: i32 = 1_367_130_551; // 32 fraction bits
        let half_e = state.e.to_bits() >> 1; // below 2^28
        let (left, right) = (left - times(left, half_e, 32), right + times(right, half_e, 32));
        let way = (left + right + 1) >> 1;
        let over_axle = drive.over_axle(state.g);
        let turn = over_axle.of(right - left); // below 2.6, so that it does not wrap
        let turned = times(turn, INVERSE_PI, 32) << 23;
        //= reference/SPEC.md#motion
        //# - **MOTION-3** The pose MUST move along an arc, by `d sin(φ/2)/(φ/2)` in the direction `θ + φ/2`.
        //= reference/SPEC.md#motion
        //# - **MOTION-4** In the paper's linear model the pose MUST move by `d` in the direction `θ`.
        let (direction, [chord, shorter]) = match model {
            MotionModel::Arc => (state.heading.wrapping_add(turned >> 1), rotation::chord(dropped(turn, 11))),
            MotionModel::Linear => (state.heading, [1 << 30, 0]),
        };
        let [sin, cos] = rotation::sin_cos(state::angle(direction));
        let along = times(way, chord, 30);
        let by_turn = |u: i32, n: i32| match model {
            MotionModel::Arc => {
                let sideways = i64::from(chord) * i64::from(n) / 2;
                let by = dropped(i64::from(shorter) * i64::from(u) + sideways, 30);
                narrow(dropped(times(way, narrow(by), 30), 10))
            }
            MotionModel::Linear => 0,
        };
        let by_way = |u: i32| narrow(dropped(i64::from(chord) * i64::from(u), 30));
        Self {
            moved: [times(along, cos, 30), times(along, sin, 30)],
            turned,
            turn,
            by_way: [by_way(cos), by_way(sin)],
            by_turn: [by_turn(cos, -sin), by_turn(sin, cos)],
            over_axle,
        }
    }

    /// What `F` has more than ones: x, y and the heading by the heading, `e` and `g`, the latter two in units of 1/64;
    /// 30 fraction bits. `left` and `right` are the nominal ways.
    ///
    /// `∂d/∂e = (r - l)/4`, `∂φ/∂e = (l + r)/(2 b (1 + g))`, `∂φ/∂g = -φ/(1 + g)`.
    pub(super) fn transition(&self, drive: &Drive, left: i64, right: i64) -> [[i32; 3]; MOVING] {
        const UNIT: u8 = SHARE_UNIT_BITS;
        let turn_by_e = narrow(dropped(self.over_axle.of(left + right), 10 + 1 + UNIT));
        let turn_by_g = narrow(dropped(-times(self.turn, self.over_axle.share(drive), 30), 10 + UNIT));
        let way_by_e = |by_way: i32| dropped(times(right - left, by_way, 30), 10 + 2 + UNIT);
        let through = |by_turn: i32, turn: i32| dropped(i64::from(by_turn) * i64::from(turn), 30);
        let [x, y] = self.moved;
        let [ways, turns] = [self.by_way, self.by_turn];
        let row = |by_heading: i64, by_way: i32, by_turn: i32| {
            [
                narrow(dropped(by_heading, 10)),
                narrow(way_by_e(by_way) + through(by_turn, turn_by_e)),
                narrow(through(by_turn, turn_by_g)),
            ]
        };
        let [way_x, way_y] = ways;
        let [turn_x, turn_y] = turns;
        [row(-y, way_x, turn_x), row(x, way_y, turn_y), [0, turn_by_e, turn_by_g]]
    }

    /// The wheels' columns of `G`, with a variance of each of the ways.
    pub(super) fn noise(&self, state: &State, variances: [i64; 2]) -> [WheelNoise; 2] {
        let quarter_e = i64::from(state.e.to_bits() >> 4); // e/4 with 30 fraction bits
        let inverse = i64::from(self.over_axle.inverse());
        let wheel = |sign: i64, variance: i64| {
            let way = (1 << 29) + sign * quarter_e; // ∂d/∂l or ∂d/∂r, 30 fraction bits
            let turn = sign * dropped(way * inverse, 29); // 24
            let by = |by_way: i32, by_turn: i32| {
                narrow(dropped(i64::from(by_way) * way, 36) + dropped(i64::from(by_turn) * turn, 30))
            };
            let [way_x, way_y] = self.by_way;
            let [turn_x, turn_y] = self.by_turn;
            WheelNoise { by: [by(way_x, turn_x), by(way_y, turn_y), narrow(turn)], variance }
        };
        let [left, right] = variances;
        [wheel(-1, left), wheel(1, right)]
    }

    /// Moves the state, and its covariance by the slip of the ways (`MOTION-5`).
    pub(super) fn take(&self, state: &mut State, drive: &Drive, slip: Slip, left: i64, right: i64) {
        // At most 2^40 and 2^20: 72 fraction bits, 62 remain.
        let slipped = |way: i64| dropped(way.abs().saturating_mul(i64::from(slip.to_bits())), 10);
        let noise = self.noise(state, [slipped(left), slipped(right)]);
        state.covariance.moved(&self.transition(drive, left, right), &noise);
        let [x, y] = self.moved;
        state.x = state.x.saturating_add(x);
        state.y = state.y.saturating_add(y);
        state.heading = state.heading.wrapping_add(self.turned);
    }
}

/// What is within the format by its range.
fn narrow(value: i64) -> i32 {
    i32::try_from(value.clamp(i64::from(i32::MIN), i64::from(i32::MAX))).unwrap_or_default()
}
