#![allow(clippy::cast_possible_truncation)] // of numbers in range

use super::*;
use crate::formats::{Angle, Length, Share, WheelLength};
use crate::frame::Pose;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

type Vector = [f64; STATES];
type Matrix = [[f64; STATES]; STATES];

/// A drive in floating point: u, b.
#[derive(Clone, Copy, Debug)]
struct Robot {
    step: f64,
    axle: f64,
}

fn power(exponent: i32) -> f64 {
    2_f64.powi(exponent)
}

fn drive(diameter: f64, axle: f64, steps: u16) -> (Drive, Robot) {
    let [diameter, axle] = [diameter, axle].map(WheelLength::from_num);
    let robot = Robot { step: PI * diameter.to_num::<f64>() / f64::from(steps), axle: axle.to_num() };
    (Drive::new(diameter, axle, steps).unwrap(), robot)
}

/// MOTION-2 to MOTION-4.
fn moved([x, y, theta, e, g]: Vector, robot: Robot, [left, right]: [f64; 2], model: MotionModel) -> Vector {
    let (left, right) = (left * (1.0 - e / 2.0), right * (1.0 + e / 2.0));
    let (way, turn) = (f64::midpoint(left, right), (right - left) / (robot.axle * (1.0 + g)));
    let (chord, direction) = match model {
        MotionModel::Arc if turn.abs() > 1e-9 => (way * (turn / 2.0).sin() / (turn / 2.0), theta + turn / 2.0),
        MotionModel::Arc => (way, theta + turn / 2.0),
        MotionModel::Linear => (way, theta),
    };
    [x + chord * direction.cos(), y + chord * direction.sin(), theta + turn, e, g]
}

/// The derivatives of [`moved`] by the state and by the ways, by differences.
fn derivatives(state: Vector, robot: Robot, ways: [f64; 2], model: MotionModel) -> (Matrix, [[f64; 2]; STATES]) {
    let step = 1e-5;
    let mut transition = [[0.0; STATES]; STATES];
    let mut by_ways = [[0.0; 2]; STATES];
    for j in 0..STATES {
        let (mut up, mut down) = (state, state);
        up[j] += step;
        down[j] -= step;
        let (up, down) = (moved(up, robot, ways, model), moved(down, robot, ways, model));
        (0..STATES).for_each(|i| transition[i][j] = (up[i] - down[i]) / (2.0 * step));
    }
    for j in 0..2 {
        let (mut up, mut down) = (ways, ways);
        up[j] += step;
        down[j] -= step;
        let (up, down) = (moved(state, robot, up, model), moved(state, robot, down, model));
        (0..STATES).for_each(|i| by_ways[i][j] = (up[i] - down[i]) / (2.0 * step));
    }
    (transition, by_ways)
}

/// MOTION-5.
fn carried(covariance: &Matrix, transition: &Matrix, by_ways: &[[f64; 2]; STATES], slipped: [f64; 2]) -> Matrix {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            let through: f64 =
                (0..25).map(|n| transition[i][n / 5] * covariance[n / 5][n % 5] * transition[j][n % 5]).sum();
            through + (0..2).map(|w| by_ways[i][w] * slipped[w] * by_ways[j][w]).sum::<f64>()
        })
    })
}

fn state_in_floats(state: &State) -> Vector {
    [
        state.x as f64 * power(-40),
        state.y as f64 * power(-40),
        state.heading as f64 * PI * power(-63),
        state.e.to_num(),
        state.g.to_num(),
    ]
}

fn covariance_in_floats(state: &State) -> Matrix {
    let unit = |i: usize| if i < 3 { 1.0 } else { power(-6) };
    core::array::from_fn(|i| {
        core::array::from_fn(|j| state.covariance.entry(i, j) as f64 * power(-56) * unit(i) * unit(j))
    })
}

/// A state with a covariance of given deviations and one correlation that all share.
fn state(pose: [f64; 3], shares: [f64; 2], deviations: Vector, correlation: f64) -> State {
    let [x, y, theta] = pose;
    let angle = Angle::from_bits((theta / PI * power(31)).clamp(-power(31), power(31) - 1.0) as i32);
    let pose = Pose::new(Length::from_num(x), Length::from_num(y), angle);
    let mut state = State::new(&pose, &PoseCovariance::default());
    [state.e, state.g] = shares.map(Share::from_num);
    let unit = |i: usize| if i < 3 { 1.0 } else { power(6) };
    for i in 0..STATES {
        for j in i..STATES {
            let share = if i == j { 1.0 } else { correlation };
            let entry = share * deviations[i] * unit(i) * deviations[j] * unit(j);
            state.covariance.set(i, j, (entry * power(56)).round() as i64);
        }
    }
    state
}

fn turn_between(one: f64, other: f64) -> f64 {
    (one - other + PI).rem_euclid(2.0 * PI) - PI
}

fn steps(steps: f64) -> Steps {
    Steps::from_num(steps)
}

//= reference/SPEC.md#motion
//= type=test
//# - **MOTION-1** The way of a wheel MUST be its steps times `u = π D/S`, with its nominal diameter D and S steps a
//# turn.
//= reference/SPEC.md#motion
//= type=test
//# - **MOTION-8** The e-puck's wheels MUST be 41 mm in diameter, 53 mm apart, with 1000 steps a turn.
#[test]
fn the_epuck_is_that_of_the_specification() {
    let (made, robot) = drive(0.041, 0.053, 1000);
    assert_eq!(made, Drive::epuck());
    assert!((made.way(1 << 16) as f64 * power(-40) - robot.step).abs() < power(-40));
    let exact = robot.step.powi(2) / 12.0;
    assert!((made.step_variance() as f64 * power(-62) / exact - 1.0).abs() < 1e-8);
}

#[test]
fn drives_have_a_domain() {
    use crate::refusal::DriveRefusal::{Axle, Diameter, Steps};
    let drive = |diameter: f64, axle: f64, steps: u16| {
        Drive::new(WheelLength::from_num(diameter), WheelLength::from_num(axle), steps).err()
    };
    assert_eq!(drive(0.004_99, 0.05, 100), Some(Diameter));
    assert_eq!(drive(0.2501, 0.05, 100), Some(Diameter));
    assert_eq!(drive(0.04, 0.0199, 100), Some(Axle));
    assert_eq!(drive(0.04, 0.801, 100), Some(Axle));
    assert_eq!(drive(0.04, 0.05, 63), Some(Steps));
    assert_eq!((drive(0.005, 0.02, u16::MAX), drive(0.25, 0.8, 64)), (None, None));
}

#[test]
fn no_way_changes_nothing() {
    let before = state([1.0, 2.0, 3.0], [0.01, 0.01], [0.01, 0.01, 0.1, 0.001, 0.001], 0.5);
    let mut after = before;
    predict(&mut after, &Ways::default(), &Drive::epuck(), MotionModel::Arc, SLIP_OF_FIVE);
    assert_eq!(after, before);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-2** With the ways `l` and `r` and the nominal axle `b`, the axle's middle MUST go `d = (l' + r')/2`
    //# and turn by `φ = (r' - l')/(b (1 + g))`, `l' = l (1 - e/2)` and `r' = r (1 + e/2)`.
    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-3** The pose MUST move along an arc, by `d sin(φ/2)/(φ/2)` in the direction `θ + φ/2`.
    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-4** In the paper's linear model the pose MUST move by `d` in the direction `θ`.
    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-5** The covariance MUST become `F P Fᵀ + G diag(q |l|, q |r|) Gᵀ`, with the derivatives F by the
    //# state and G by `l` and `r` of what was moved.
    #[test]
    fn a_prediction_is_that_of_the_specification(
        (x, y, theta) in (-100.0..100.0_f64, -100.0..100.0_f64, -PI..PI),
        shares in [-0.12..0.12_f64, -0.12..0.12_f64],
        deviations in [-11.5..0.69_f64, -11.5..0.69_f64, -9.9..1.1_f64, -13.8..-3.0_f64, -13.8..-3.0_f64],
        correlation in -0.2..0.95_f64,
        (diameter, axle, step_count) in (0.02..0.1_f64, 0.03..0.4_f64, 200_u16..2000),
        ways in [-1.0..1.0_f64, -1.0..1.0_f64],
        size in -9.0..0.0_f64,
        linear in any::<bool>(),
        slip in 0.0..1e-5_f64,
    ) {
        let model = if linear { MotionModel::Linear } else { MotionModel::Arc };
        let (drive, robot) = drive(diameter, axle, step_count);
        let deviations = deviations.map(f64::exp);
        let mut found = state([x, y, theta], shares, deviations, correlation);
        // Ways of up to an axle.
        let reach = robot.axle / robot.step * size.exp();
        let [left, right] = ways.map(|way| steps(way * reach));
        let slip = Slip::from_num(slip);
        let (before, covariance) = (state_in_floats(&found), covariance_in_floats(&found));
        let ways = [left, right].map(|steps| steps.to_num::<f64>() * robot.step);
        predict(&mut found, &Ways { left, right }, &drive, model, slip);
        let expected = moved(before, robot, ways, model);
        let after = state_in_floats(&found);
        let way = ways[0].abs().max(ways[1].abs());
        let turn = way / robot.axle * 2.0;
        for i in 0..2 {
            // The doubles of a position of 100 m themselves are rounded to 1.4e-14.
            let bound = 4.0 * power(-40) + power(-28) * way * (1.0 + turn) + 1e-13;
            prop_assert!((after[i] - expected[i]).abs() <= bound, "{} {} {:e}", after[i], expected[i], bound);
        }
        prop_assert!(turn_between(after[2], expected[2]).abs() <= power(-38) / robot.axle + power(-38) + power(-28) * turn);
        let (transition, by_ways) = derivatives(before, robot, ways, model);
        let exact = carried(&covariance, &transition, &by_ways, ways.map(|way| way.abs() * slip.to_num::<f64>()));
        let found = covariance_in_floats(&found);
        for i in 0..STATES {
            for j in 0..STATES {
                let (one, other) = (exact[i][i].sqrt(), exact[j][j].sqrt());
                // Derivatives of the state are off by 2^-29, those of the ways by 2^-23; variances grow by 24 units of 2^-56.
                let sources = (covariance[2][2].sqrt() + 64.0 * (covariance[3][3].sqrt() + covariance[4][4].sqrt())) * power(-29);
                let unit = |i: usize| if i < 3 { 1.0 } else { power(-6) };
                // A turn's derivative is 1/b of a way's; what is off by 2^-23 meets the slip's own deviation.
                let turned = |i: usize| if i == 2 { 1.0 / robot.axle } else { 1.0 };
                let slipped = (slip.to_num::<f64>() * (ways[0].abs() + ways[1].abs())).sqrt() * power(-23);
                let by_ways = slipped * (one * turned(j) + other * turned(i));
                let bound = sources * (one * unit(j) + other * unit(i))
                    + by_ways
                    + 5e-7 * one * other
                    + 31.0 * power(-56) * unit(i) * unit(j);
                prop_assert!((found[i][j] - exact[i][j]).abs() < bound, "entry {} {} {:e}: {:?} {:?}", i, j, bound, found, exact);
            }
        }
    }

    /// A reciprocal of 2^30 to 2^31 units: half a unit, and 2^-32 of a divisor of 2^32 to 2^33.
    #[test]
    fn a_length_over_the_axle_is_precise(axle in 0.02..0.8_f64, share in -0.125..0.125_f64) {
        let ((drive, robot), g) = (drive(0.041, axle, 1000), Share::from_num(share));
        let exact = 1.0 / (robot.axle * (1.0 + g.to_num::<f64>()));
        let found = drive.over_axle(g).of(1 << 40) as f64 * power(-40);
        prop_assert!((found / exact - 1.0).abs() < 2_f64.powf(-30.5), "{}", found / exact - 1.0);
    }

    /// Long ways go in parts: the same pose, and the same covariance but for the slip.
    #[test]
    fn long_ways_are_moved_in_parts(ways in [-4000.0..4000.0_f64, -4000.0..4000.0_f64], theta in -3.0..3.0_f64) {
        let (drive, robot) = drive(0.041, 0.053, 1000);
        let mut found = state([0.0, 0.0, theta], [0.01, -0.02], [0.01, 0.02, 0.03, 0.001, 0.002], 0.3);
        let (before, covariance) = (state_in_floats(&found), covariance_in_floats(&found));
        let [left, right] = ways.map(steps);
        predict(&mut found, &Ways { left, right }, &drive, MotionModel::Arc, Slip::ZERO);
        let ways = [left, right].map(|steps| steps.to_num::<f64>() * robot.step);
        let expected = moved(before, robot, ways, MotionModel::Arc);
        let after = state_in_floats(&found);
        prop_assert!((after[0] - expected[0]).hypot(after[1] - expected[1]) < 1e-8);
        prop_assert!(turn_between(after[2], expected[2]).abs() < 1e-7);
        let (transition, by_ways) = derivatives(before, robot, ways, MotionModel::Arc);
        let exact = carried(&covariance, &transition, &by_ways, [0.0; 2]);
        let found = covariance_in_floats(&found);
        for i in 0..STATES {
            for j in 0..STATES {
                let wrong = (found[i][j] - exact[i][j]).abs() / (exact[i][i] * exact[j][j]).sqrt();
                prop_assert!(wrong < 1e-4, "entry {} {} by {}: {:?} {:?}", i, j, wrong, found, exact);
            }
        }
    }

    //= reference/SPEC.md#motion
    //= type=test
    //# - **MOTION-7** At an observation the pose MUST count as uncertain by `G diag(u²/12, u²/12) Gᵀ` more, G at rest
    //# *(choice: a step that is not yet complete is an error of the reading that the next one does not inherit)*.
    #[test]
    fn incomplete_steps_make_a_pose_uncertain(theta in -PI..PI, shares in [-0.12..0.12_f64, -0.12..0.12_f64]) {
        let (drive, robot) = drive(0.041, 0.053, 1000);
        let state = state([0.0, 0.0, theta], shares, [0.0; STATES], 0.0);
        let (_, by_ways) = derivatives(state_in_floats(&state), robot, [0.0; 2], MotionModel::Arc);
        let exact = carried(&[[0.0; STATES]; STATES], &[[0.0; STATES]; STATES], &by_ways, [robot.step.powi(2) / 12.0; 2]);
        let PoseCovariance { xx, xy, xt, yy, yt, tt } = step_noise(&state, &drive);
        let found = [[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]].map(|row| row.map(|entry| entry as f64 * power(-48)));
        for i in 0..3 {
            for j in 0..3 {
                let off = (found[i][j] - exact[i][j]).abs();
                let size = by_ways[i][0].hypot(by_ways[i][1]) * by_ways[j][0].hypot(by_ways[j][1]);
                // The differences are good to 1e-9 or so; slants to 2^-22 of the longer derivative.
                prop_assert!(off <= 2.0 * power(-48) + 1e-6 * size.max(1.0) * robot.step.powi(2), "{} {}: {:?} {:?}", i, j, found, exact);
            }
        }
    }
}

/// A robot that wanders for 100,000 predictions: in floating point the same steps, and where it ends.
#[test]
fn many_predictions_do_not_drift() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let (drive, robot) = drive(0.041, 0.053, 1000);
    let mut found = state([0.0; 3], [0.003, -0.004], [0.01, 0.01, 0.02, 0.002, 0.005], 0.0);
    let mut expected = state_in_floats(&found);
    for _ in 0..100_000 {
        // More to one side, so that the turns add up: to about 1,800 rad.
        let [left, right] = [random.random_range(-40..=90), random.random_range(-35..=100)];
        let turned = [left, right].map(|count| f64::from(count) * robot.step);
        expected = moved(expected, robot, turned, MotionModel::Arc);
        let ways = Ways { left: Steps::from_num(left), right: Steps::from_num(right) };
        predict(&mut found, &ways, &drive, MotionModel::Arc, SLIP_OF_FIVE);
    }
    let after = state_in_floats(&found);
    assert!(expected[2].abs() > 1000.0, "the test turns");
    // A tenth of 1 mm and of 0.1 degrees over ten times as many, a tenth of it again.
    assert!((after[0] - expected[0]).hypot(after[1] - expected[1]) < 1e-5, "{after:?} {expected:?}");
    assert!(turn_between(after[2], expected[2]).abs() < 1.7e-5, "{after:?} {expected:?}");
}

/// Whether a covariance has no negative direction, by Cholesky in floating point of its correlations.
fn is_semidefinite(covariance: &Matrix) -> bool {
    let mut rows = *covariance;
    for pivot in 0..STATES {
        let size = covariance[pivot][pivot];
        if size < 0.0 {
            return false;
        }
        let left = rows[pivot][pivot];
        if left <= 1e-15 * size {
            if left < -1e-15 * size {
                return false;
            }
            continue;
        }
        let row = rows[pivot];
        for i in pivot + 1..STATES {
            for j in pivot + 1..STATES {
                rows[i][j] -= row[i] * row[j] / left;
            }
        }
    }
    true
}

#[test]
fn a_covariance_remains_one() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for case in 0..20 {
        let size = 10_f64.powi(-(case % 5) - 1);
        let mut moving = state([0.0; 3], [0.0; 2], [size, size, size, 0.05 * size, 0.05 * size], 0.999);
        if case % 2 == 0 {
            // All of one error, about 10 µm, in whole numbers: without what settling adds, rounding makes it indefinite.
            let error: [i64; STATES] = core::array::from_fn(|_| random.random_range(1_000..4_000));
            for i in 0..STATES {
                (i..STATES).for_each(|j| moving.covariance.set(i, j, error[i] * error[j]));
            }
        }
        for _ in 0..2_000 {
            let [left, right] = [random.random_range(-200..=400), random.random_range(-200..=400)];
            let ways = Ways { left: Steps::from_num(left), right: Steps::from_num(right) };
            predict(&mut moving, &ways, &Drive::epuck(), MotionModel::Arc, Slip::ZERO);
            assert!(is_semidefinite(&covariance_in_floats(&moving)), "{moving:?}");
            assert!((0..STATES).all(|i| (1..=covariance::LARGEST).contains(&moving.covariance.entry(i, i))));
        }
    }
}

#[test]
fn three_numbers_are_five_of_which_two_are_known() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let start = state([0.1, 0.2, 0.3], [0.0; 2], [0.01, 0.02, 0.03, 0.0, 0.0], 0.2);
    // What is not quite known costs five numbers' arithmetic and gives the same.
    let mut hardly = start;
    hardly.covariance.set(3, 3, 1);
    hardly.covariance.set(4, 4, 1);
    let mut three = start;
    for _ in 0..1000 {
        let [left, right] = [random.random_range(-20..=40), random.random_range(-20..=40)];
        let ways = Ways { left: Steps::from_num(left), right: Steps::from_num(right) };
        predict(&mut three, &ways, &Drive::epuck(), MotionModel::Arc, SLIP_OF_THREE);
        predict(&mut hardly, &ways, &Drive::epuck(), MotionModel::Arc, SLIP_OF_THREE);
    }
    assert_eq!(three.covariance.uncertain(), 3);
    assert_eq!(hardly.covariance.uncertain(), 5);
    let (three, hardly) = (covariance_in_floats(&three), covariance_in_floats(&hardly));
    for i in 0..STATES {
        for j in 0..STATES {
            assert!((three[i][j] - hardly[i][j]).abs() < 1e-12, "{i} {j}");
            assert!(i < 3 && j < 3 || three[i][j] == 0.0);
        }
    }
}

#[test]
fn what_is_too_uncertain_is_limited() {
    let everywhere = PoseCovariance { xx: 28_000 << 48, yy: 28_000 << 48, tt: 10 << 48, ..PoseCovariance::default() };
    let state = State::new(&Pose::new(Length::ZERO, Length::ZERO, Angle::ZERO), &everywhere);
    for i in 0..2 {
        let variance = state.covariance.entry(i, i);
        assert!(variance <= covariance::LARGEST && variance > covariance::LARGEST >> 3);
    }
    assert!((state.covariance.pose().tt - (10 << 48)).abs() < 8);
}

/// A pose's covariance in m² and rad².
fn given([xx, xy, yy]: [f64; 3]) -> PoseCovariance {
    let [xx, xy, yy] = [xx, xy, yy].map(|value| (value * power(48)) as i64);
    PoseCovariance { xx, xy, yy, tt: 1 << 40, ..PoseCovariance::default() }
}

/// A standard deviation of 1/64 is the unit; 1/16 is the largest.
#[test]
fn wheels_are_as_uncertain_as_said() {
    let state = |e: f64, g: f64| {
        let state = state([0.0; 3], [0.0; 2], [0.1, 0.1, 0.1, 0.0, 0.0], 0.0);
        let wheels = state.with_wheels(Share::from_num(e), Share::from_num(g)).covariance;
        [(3, 3), (4, 4), (3, 4)].map(|(i, j)| wheels.entry(i, j))
    };
    assert_eq!(state(1.0 / 64.0, 1.0 / 32.0), [1 << 56, 4 << 56, 0]);
    assert_eq!(state(1.0 / 16.0, 0.4), [16 << 56, 16 << 56, 0]);
    assert_eq!(state(0.0, -0.1), [0; 3]);
}

/// `FILTER-6`: what is known of `e` and `g` is kept.
#[test]
fn a_state_elsewhere_knows_the_same_wheels() {
    let here = state([0.1, 0.2, 0.3], [0.05, -0.03], [0.01, 0.02, 0.03, 0.02, 0.01], 0.2);
    let there =
        here.elsewhere(&Pose::new(Length::from_num(2), Length::from_num(3), Angle::PI), &given([1.0, 0.5, 2.0]));
    assert_eq!(
        (there.e, there.g, there.pose().x, there.pose().theta),
        (here.e, here.g, Length::from_num(2), Angle::PI)
    );
    for (i, j) in [(3, 3), (3, 4), (4, 4)] {
        assert_eq!(there.covariance.entry(i, j), here.covariance.entry(i, j));
    }
    assert_eq!([3, 4].map(|i| there.covariance.entry(0, i)), [0; 2]);
    assert!((there.covariance.entry(0, 1) - (1 << 55)).abs() < 1 << 10);
}

/// A change of one and of two units of 2^-6.
#[test]
fn a_state_says_what_it_knows_of_its_wheels() {
    let moved = state([0.0; 3], [0.0; 2], [0.0; 5], 0.0).moved([0, 0, 0, 1 << 40, -2 << 40]);
    assert_eq!((moved.e(), moved.g()), (Share::from_num(1.0 / 64.0), Share::from_num(-1.0 / 32.0)));
}

#[test]
fn headings_are_rounded_to_nearest() {
    assert_eq!([(1 << 31) - 1, 1 << 31, -(1 << 31) - 1].map(|heading| state::angle(heading).to_bits()), [0, 1, -1]);
}

/// Half as uncertain is a quarter of the variance and half of the covariances; a few units of 2^-48 more make up for rounding.
#[test]
fn a_pose_of_more_than_16_square_metres_is_half_as_uncertain() {
    let limited = |given: PoseCovariance| {
        let found = StateCovariance::of_pose(&given);
        [(0, 0), (0, 1), (1, 1)].map(|(i, j)| found.entry(i, j) as f64 / power(56))
    };
    let more = |found: f64, expected: f64| (0.0..=6.0 * power(-48)).contains(&(found - expected));
    let [xx, xy, yy] = limited(given([60.0, -4.0, 1.0]));
    assert!(more(xx, 15.0) && (xy + 2.0).abs() <= power(-48) && more(yy, 1.0), "{xx} {xy} {yy}");
    let [xx, xy, yy] = limited(given([1.0, 3.0, 200.0]));
    assert!(more(xx, 1.0) && (xy - 0.75).abs() <= power(-47) && more(yy, 12.5), "{xx} {xy} {yy}");
    // 16 m² with the 3 units that are added anyway.
    let full = PoseCovariance { xx: (16 << 48) - 3, ..given([0.0, 0.0, 1.0]) };
    assert_eq!(StateCovariance::of_pose(&full).entry(0, 0), covariance::LARGEST);
}

/// Likewise of a state, in units of 2^-56, of which bounds of errors are added to what is uncertain.
#[test]
fn a_state_of_more_than_16_square_metres_is_half_as_uncertain() {
    let mut covariance = StateCovariance::default();
    for (i, j, value) in [(0, 0, 60_i64 << 56), (0, 1, -4 << 56), (0, 4, 2 << 56), (1, 1, 1 << 56), (4, 4, 1 << 50)] {
        covariance.set(i, j, value);
    }
    covariance.settle([4, 4, 4, 4, 4]);
    let more = |(i, j): (usize, usize), expected: i64| (0..=4).contains(&(covariance.entry(i, j) - expected));
    assert!(more((0, 0), 15 << 56) && more((0, 1), -2 << 56) && more((0, 4), 1 << 56) && more((1, 1), 1 << 56));
    // The heading has a variance of 0 and yet an error; `e` is known.
    assert_eq!([(2, 2), (3, 3), (4, 4)].map(|(i, j)| covariance.entry(i, j)), [4, 0, (1 << 50) + 4]);
    let mut full = StateCovariance::default();
    full.set(0, 0, covariance::LARGEST);
    full.settle([0; 5]);
    assert_eq!((full.entry(0, 0), full.uncertain()), (covariance::LARGEST, 3));
}

/// Found by a proof: a covariance at its format's limit once overflowed where it is reduced.
#[test]
fn a_covariance_at_its_format_s_limit_is_reduced() {
    let limit = i64::MAX;
    let PoseCovariance { xx, xy, xt, yy, yt, tt } =
        StateCovariance::of_pose(&PoseCovariance { xx: limit, xy: limit, xt: limit, yy: limit, yt: limit, tt: limit })
            .pose();
    // 2^15 m² is halved in both directions six times, which leaves 2^3 m².
    for entry in [xx, xy, xt, yy, yt, tt] {
        assert!(entry.abs_diff(1 << 51) < 16, "{entry}");
    }
}
