//! How the robot moves by its wheels' steps (MOTION).

use crate::frame::{Pose, Robot, World, wrap};
use core::f64::consts::PI;
use nalgebra::{Matrix2, SMatrix, SVector};

/// Parameters of a state: x, y, θ, the wheels' difference and the axle's scale.
pub const STATES: usize = 5;

/// A covariance of the state: m², m rad, rad², and 1.
pub type StateCovariance = SMatrix<f64, STATES, STATES>;

/// The drive of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Nominal diameter of both wheels, metres.
    pub wheel_diameter: f64,
    /// Nominal distance of the wheels, metres.
    pub axle: f64,
    /// Steps in a turn of a wheel.
    pub steps_per_turn: f64,
    /// Variance of a wheel's way by its length, metres (MOTION-6).
    pub slip: f64,
    /// How steps become a way.
    pub model: MotionModel,
}

/// How a pose moves between two readings of the steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionModel {
    /// Along an arc (MOTION-3).
    #[default]
    Arc,
    /// Straight on, and turned then, as in the paper (MOTION-4).
    Linear,
}

impl Drive {
    /// The e-puck's (MOTION-8).
    //= reference/SPEC.md#motion
    //# - **MOTION-6** The slip MUST by default be `q = 1e-6 m` with five states, 1 mm per root metre, and `3e-6 m` with
    //# three, of which `e` and `g` are known to be 0 *(choice: what is not estimated is slip)*.
    //= reference/SPEC.md#motion
    //# - **MOTION-8** The e-puck's wheels MUST be 41 mm in diameter, 53 mm apart, with 1000 steps a turn.
    #[must_use]
    pub fn epuck() -> Self {
        Self { wheel_diameter: 0.041, axle: 0.053, steps_per_turn: 1000.0, slip: 1e-6, model: MotionModel::Arc }
    }

    /// The way of a wheel in a step, metres (MOTION-1).
    //= reference/SPEC.md#motion
    //# - **MOTION-1** The way of a wheel MUST be its steps times `u = π D/S`, with its nominal diameter D and S steps a
    //# turn.
    #[must_use]
    pub fn step(&self) -> f64 {
        PI * self.wheel_diameter / self.steps_per_turn
    }
}

/// What the filter estimates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// The robot in the world.
    pub pose: Pose<World, Robot>,
    /// `e`: by how much the right wheel is larger than the left one, as a share of both.
    pub wheel_difference: f64,
    /// `g`: by how much the axle is longer than nominal, as a share.
    pub axle_excess: f64,
}

/// Ways of both wheels since the last prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ways {
    /// Of the left wheel, metres, by its nominal diameter.
    pub left: f64,
    /// Of the right wheel.
    pub right: f64,
}

/// The way of the axle's middle and the turn, and how both follow from the wheels (MOTION-2).
struct Turned {
    way: f64,
    turn: f64,
    /// Derivatives of way and turn by the ways of the left and the right wheel.
    by_wheels: Matrix2<f64>,
    /// Those by `e` and `g`.
    by_scales: Matrix2<f64>,
}

impl Turned {
    //= reference/SPEC.md#motion
    //# - **MOTION-2** With the ways `l` and `r` and the nominal axle `b`, the axle's middle MUST go `d = (l' + r')/2`
    //# and turn by `φ = (r' - l')/(b (1 + g))`, `l' = l (1 - e/2)` and `r' = r (1 + e/2)`.
    fn of(ways: &Ways, drive: &Drive, state: &State) -> Self {
        let (e, g) = (state.wheel_difference, state.axle_excess);
        let axle = drive.axle * (1.0 + g);
        let [left, right] = [ways.left * (1.0 - e / 2.0), ways.right * (1.0 + e / 2.0)];
        let turn = (right - left) / axle;
        let [by_left, by_right] = [1.0 - e / 2.0, 1.0 + e / 2.0];
        Self {
            way: f64::midpoint(left, right),
            turn,
            by_wheels: Matrix2::new(by_left / 2.0, by_right / 2.0, -by_left / axle, by_right / axle),
            by_scales: Matrix2::new(
                (ways.right - ways.left) / 4.0,
                0.0,
                (ways.left + ways.right) / (2.0 * axle),
                -turn / (1.0 + g),
            ),
        }
    }
}

/// `sin(x)/x`, and its derivative.
fn sinc(x: f64) -> (f64, f64) {
    if x.abs() < 1e-4 {
        // To the next term, x^4/120.
        (1.0 - x * x / 6.0, -x / 3.0)
    } else {
        (x.sin() / x, (x * x.cos() - x.sin()) / (x * x))
    }
}

/// How far the axle's middle moves along the world's axes, and its derivatives by way, turn and heading.
struct Moved {
    displacement: [f64; 2],
    by_way: [f64; 2],
    by_turn: [f64; 2],
}

impl Moved {
    fn of(turned: &Turned, heading: f64, model: MotionModel) -> Self {
        //= reference/SPEC.md#motion
        //# - **MOTION-3** The pose MUST move along an arc, by `d sin(φ/2)/(φ/2)` in the direction `θ + φ/2`.
        //= reference/SPEC.md#motion
        //# - **MOTION-4** In the paper's linear model the pose MUST move by `d` in the direction `θ`.
        // MOTION-4 is MOTION-3 without the turn of the chord and without its shortening.
        let (half, (chord, by_half)) = match model {
            MotionModel::Arc => (turned.turn / 2.0, sinc(turned.turn / 2.0)),
            MotionModel::Linear => (0.0, (1.0, 0.0)),
        };
        let (sin, cos) = (heading + half).sin_cos();
        let way = turned.way;
        let turns = if model == MotionModel::Arc { 0.5 } else { 0.0 };
        Self {
            displacement: [way * chord * cos, way * chord * sin],
            by_way: [chord * cos, chord * sin],
            by_turn: [turns * way * (by_half * cos - chord * sin), turns * way * (by_half * sin + chord * cos)],
        }
    }
}

/// The state and its covariance after the wheels' ways (MOTION-2 to MOTION-5).
//= reference/SPEC.md#motion
//# - **MOTION-5** The covariance MUST become `F P Fᵀ + G diag(q |l|, q |r|) Gᵀ`, with the derivatives F by the state
//# and G by `l` and `r` of what was moved.
#[must_use]
pub fn predict(state: &State, covariance: &StateCovariance, ways: &Ways, drive: &Drive) -> (State, StateCovariance) {
    let turned = Turned::of(ways, drive, state);
    let moved = Moved::of(&turned, state.pose.theta(), drive.model);
    let (f, g) = derivatives(&turned, &moved);
    let ways = SVector::<f64, 2>::new(ways.left.abs(), ways.right.abs()) * drive.slip;
    let spread = f * covariance * f.transpose() + g * Matrix2::from_diagonal(&ways) * g.transpose();
    (arrive(state, &turned, &moved), symmetric(&spread))
}

/// The state after the wheels' ways (MOTION-2 to MOTION-4).
#[must_use]
pub fn advance(state: &State, ways: &Ways, drive: &Drive) -> State {
    let turned = Turned::of(ways, drive, state);
    arrive(state, &turned, &Moved::of(&turned, state.pose.theta(), drive.model))
}

fn arrive(state: &State, turned: &Turned, moved: &Moved) -> State {
    let [dx, dy] = moved.displacement;
    let pose = Pose::new(state.pose.x() + dx, state.pose.y() + dy, wrap(state.pose.theta() + turned.turn));
    State { pose, ..*state }
}

/// The covariance of the pose that follows from how coarse a step is (MOTION-7), for a state after these ways.
//= reference/SPEC.md#motion
//# - **MOTION-7** At an observation the pose MUST count as uncertain by `G diag(u²/12, u²/12) Gᵀ` more, G at rest
//# *(choice: a step that is not yet complete is an error of the reading that the next one does not inherit)*.
#[must_use]
pub fn step_noise(state: &State, drive: &Drive) -> StateCovariance {
    let still = Turned::of(&Ways::default(), drive, state);
    let moved = Moved::of(&still, state.pose.theta(), drive.model);
    let (_, g) = derivatives(&still, &moved);
    let variance = drive.step().powi(2) / 12.0;
    symmetric(&(g * g.transpose() * variance))
}

/// The derivatives of the next state by the state and by the wheels' ways (MOTION-5).
fn derivatives(turned: &Turned, moved: &Moved) -> (StateCovariance, SMatrix<f64, STATES, 2>) {
    let mut f = StateCovariance::identity();
    let mut g = SMatrix::<f64, STATES, 2>::zeros();
    // By the heading the displacement turns.
    f[(0, 2)] = -moved.displacement[1];
    f[(1, 2)] = moved.displacement[0];
    for column in 0..2 {
        for row in 0..2 {
            let by = |of: &Matrix2<f64>| moved.by_way[row] * of[(0, column)] + moved.by_turn[row] * of[(1, column)];
            g[(row, column)] = by(&turned.by_wheels);
            f[(row, 3 + column)] = by(&turned.by_scales);
        }
        g[(2, column)] = turned.by_wheels[(1, column)];
        f[(2, 3 + column)] = turned.by_scales[(1, column)];
    }
    (f, g)
}

/// What rounding leaves asymmetric is made symmetric.
fn symmetric(matrix: &StateCovariance) -> StateCovariance {
    (matrix + matrix.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn state(x: f64, y: f64, theta: f64, e: f64, g: f64) -> State {
        State { pose: Pose::new(x, y, theta), wheel_difference: e, axle_excess: g }
    }

    fn moved(state: &State, ways: &Ways, drive: &Drive) -> State {
        predict(state, &StateCovariance::zeros(), ways, drive).0
    }

    /// The state in numbers.
    fn numbers(state: &State) -> [f64; STATES] {
        [state.pose.x(), state.pose.y(), state.pose.theta(), state.wheel_difference, state.axle_excess]
    }

    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-1** The way of a wheel MUST be its steps times `u = π D/S`, with its nominal diameter D and S steps a
    //# turn.
    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-8** The e-puck's wheels MUST be 41 mm in diameter, 53 mm apart, with 1000 steps a turn.
    #[test]
    fn a_step_of_the_e_puck_is_an_eighth_of_a_millimetre() {
        // π 41 mm/1000.
        assert!((Drive::epuck().step() - 0.000_128_805).abs() < 1e-9);
        // 1 mm per root metre.
        assert!((Drive::epuck().slip.sqrt() - 1e-3).abs() < 1e-15);
    }

    #[test]
    fn wheels_that_turn_against_each_other_turn_on_the_spot() {
        // A quarter turn is a quarter of the circle that the axle draws.
        let way = 0.053 * PI / 4.0;
        let after = moved(&state(1.0, 2.0, 0.5, 0.0, 0.0), &Ways { left: -way, right: way }, &Drive::epuck());
        assert!((after.pose.x() - 1.0).abs() < 1e-15 && (after.pose.y() - 2.0).abs() < 1e-15);
        assert!((after.pose.theta() - (0.5 + PI / 2.0)).abs() < 1e-14);
    }

    #[test]
    fn a_circle_ends_where_it_began() {
        // Around a centre 0.2 m to the left, in 36 equal parts.
        let mut now = state(0.0, 0.0, 0.0, 0.0, 0.0);
        let part = |radius: f64| 2.0 * PI * radius / 36.0;
        let ways = Ways { left: part(0.2 - 0.0265), right: part(0.2 + 0.0265) };
        for _ in 0..18 {
            now = moved(&now, &ways, &Drive::epuck());
        }
        assert!(now.pose.x().abs() < 1e-12 && (now.pose.y() - 0.4).abs() < 1e-12);
        for _ in 0..18 {
            now = moved(&now, &ways, &Drive::epuck());
        }
        assert!(numbers(&now).iter().all(|number| number.abs() < 1e-12), "{now:?}");
    }

    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-4** In the paper's linear model the pose MUST move by `d` in the direction `θ`.
    #[test]
    fn the_paper_goes_straight_on_and_turns_then() {
        let drive = Drive { model: MotionModel::Linear, ..Drive::epuck() };
        let after = moved(&state(0.0, 0.0, PI / 2.0, 0.0, 0.0), &Ways { left: 0.01, right: 0.02 }, &drive);
        assert!(after.pose.x().abs() < 1e-15 && (after.pose.y() - 0.015).abs() < 1e-15);
        assert!((after.pose.theta() - PI / 2.0 - 0.01 / 0.053).abs() < 1e-14);
    }

    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-7** At an observation the pose MUST count as uncertain by `G diag(u²/12, u²/12) Gᵀ` more, G at rest
    //# *(choice: a step that is not yet complete is an error of the reading that the next one does not inherit)*.
    #[test]
    fn a_coarse_step_is_uncertain_along_the_heading_and_in_it() {
        let noise = step_noise(&state(0.0, 0.0, PI / 2.0, 0.0, 0.0), &Drive::epuck());
        let variance = 0.000_128_805_f64.powi(2) / 12.0;
        // Both wheels halve: u²/24 along; u²/(6 b²) of the heading, 0.99 mrad.
        assert!((noise[(1, 1)] / (variance / 2.0) - 1.0).abs() < 1e-5 && noise[(0, 0)] < 1e-20);
        assert!((noise[(2, 2)].sqrt() - 0.000_992).abs() < 1e-6);
    }

    proptest! {
        /// The arc is what many short straight ways come to.
        //= reference/SPEC.md#motion
        //= type=test
        //# - **MOTION-3** The pose MUST move along an arc, by `d sin(φ/2)/(φ/2)` in the direction `θ + φ/2`.
        #[test]
        fn the_arc_is_the_limit_of_short_ways(
            theta in -3.0..3.0f64, left in -0.02..0.02f64, right in -0.02..0.02f64, e in -0.01..0.01f64, g in -0.02..0.02f64,
        ) {
            let (start, arc) = (state(0.3, -0.2, theta, e, g), Drive::epuck());
            let linear = Drive { model: MotionModel::Linear, ..arc };
            let parts = 2000.0;
            let part = Ways { left: left / parts, right: right / parts };
            let at_once = moved(&start, &Ways { left, right }, &arc);
            let slowly = (0..2000).fold(start, |now, _| moved(&now, &part, &linear));
            // Euler's error is half of the way times the turn, by the number of parts.
            let bound = 0.5 * 0.02 * 0.8 / parts + 1e-12;
            prop_assert!((at_once.pose.x() - slowly.pose.x()).abs() < bound);
            prop_assert!((at_once.pose.y() - slowly.pose.y()).abs() < bound);
            prop_assert!(wrap(at_once.pose.theta() - slowly.pose.theta()).abs() < 1e-11);
        }

        /// The covariance is carried by the derivatives: against differences, for both models.
        //= reference/SPEC.md#motion
        //= type=test
        //# - **MOTION-5** The covariance MUST become `F P Fᵀ + G diag(q |l|, q |r|) Gᵀ`, with the derivatives F by the
        //# state and G by `l` and `r` of what was moved.
        #[test]
        fn derivatives_are_those_of_the_motion(
            theta in -3.0..3.0f64, left in -0.02..0.02f64, right in -0.02..0.02f64, linear in any::<bool>(),
            e in -0.01..0.01f64, g in -0.02..0.02f64,
        ) {
            let model = if linear { MotionModel::Linear } else { MotionModel::Arc };
            let drive = Drive { model, ..Drive::epuck() };
            let at = |change: &[f64; 7]| {
                let start = state(0.1 + change[0], change[1], theta + change[2], e + change[3], g + change[4]);
                numbers(&moved(&start, &Ways { left: left + change[5], right: right + change[6] }, &drive))
            };
            let start = state(0.1, 0.0, theta, e, g);
            let turned = Turned::of(&Ways { left, right }, &drive, &start);
            let (f, wheels) = derivatives(&turned, &Moved::of(&turned, theta, model));
            for column in 0..7 {
                let difference = |sign: f64| {
                    let mut change = [0.0; 7];
                    change[column] = sign * 1e-6;
                    at(&change)
                };
                let (low, high) = (difference(-1.0), difference(1.0));
                for row in 0..STATES {
                    let found = if row == 2 { wrap(high[row] - low[row]) } else { high[row] - low[row] } / 2e-6;
                    let expected = if column < STATES { f[(row, column)] } else { wheels[(row, column - STATES)] };
                    prop_assert!((found - expected).abs() < 1e-7, "{row} {column}: {found} {expected}");
                }
            }
        }
    }
}
