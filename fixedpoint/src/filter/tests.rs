#![allow(clippy::cast_possible_truncation, clippy::needless_range_loop)] // of numbers in range; indices of matrices

use super::*;
use crate::covariance::Covariance;
use crate::formats::{Angle, Column, Length, Obliquity, Steps};
use crate::frame;
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::motion::{COVARIANCE_BITS, SLIP_OF_FIVE, STATES, StateCovariance};
use crate::observation::{Seen, mounted_ahead};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use std::vec::Vec;

type Vector = [f64; STATES];
type Matrix = [[f64; STATES]; STATES];

const F: f64 = 640.0;
const GATE: f64 = 16.266;
const STEP: f64 = PI * 0.041 / 1000.0;
const AXLE: f64 = 0.053;

fn power(exponent: i32) -> f64 {
    2_f64.powi(exponent)
}

fn unit(i: usize) -> f64 {
    if i < 3 { 1.0 } else { power(-6) }
}

fn short(angle: f64) -> f64 {
    (angle + PI).rem_euclid(2.0 * PI) - PI
}

fn pose<Parent, Child>([x, y, theta]: [f64; 3]) -> Pose<Parent, Child> {
    let angle = Angle::from_bits((short(theta) / PI * power(31)) as i32);
    Pose::new(Length::from_num(x), Length::from_num(y), angle)
}

fn floats<Parent, Child>(pose: &Pose<Parent, Child>) -> [f64; 3] {
    [pose.x.to_num(), pose.y.to_num(), f64::from(pose.theta.to_bits()) * PI / power(31)]
}

fn numbers(state: &State) -> Vector {
    let shares = [state.e, state.g].map(|share| share.to_num::<f64>());
    [
        state.x as f64 * power(-40),
        state.y as f64 * power(-40),
        state.heading as f64 * PI * power(-63),
        shares[0],
        shares[1],
    ]
}

fn entries(covariance: &StateCovariance) -> Matrix {
    let bits = -i32::from(COVARIANCE_BITS);
    core::array::from_fn(|i| core::array::from_fn(|j| covariance.entry(i, j) as f64 * power(bits) * unit(i) * unit(j)))
}

fn set(state: &mut State, covariance: &Matrix) {
    for i in 0..STATES {
        for j in i..STATES {
            let entry = covariance[i][j] / unit(i) / unit(j) * power(i32::from(COVARIANCE_BITS));
            state.covariance.set(i, j, entry.round() as i64);
        }
    }
}

fn composed(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = outer[2].sin_cos();
    [outer[0] + cos * inner[0] - sin * inner[1], outer[1] + sin * inner[0] + cos * inner[1], outer[2] + inner[2]]
}

fn inverted([x, y, theta]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = theta.sin_cos();
    [-(cos * x + sin * y), sin * x - cos * y, -theta]
}

fn half_width() -> f64 {
    Landmark::paper().stripe_width().to_num::<f64>() * 10.0
}

/// OBSERVE-3, and the depth.
fn image(robot: [f64; 3], place: [f64; 3]) -> ([f64; 3], f64) {
    let camera = composed(inverted(place), composed(robot, floats(&mounted_ahead())));
    let centre = inverted(camera);
    let (sin, cos) = camera[2].sin_cos();
    let w = half_width();
    ([-F * centre[1] / centre[0], -F * w * cos / centre[0], w * sin / centre[0]], centre[0])
}

/// The inverse of a covariance, by Gauss and Jordan on its correlations, the largest pivot first, and two steps of Newton's.
fn inverse(m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let scale: [f64; 3] = core::array::from_fn(|i| m[i][i].sqrt());
    let c: [[f64; 3]; 3] = core::array::from_fn(|i| core::array::from_fn(|j| m[i][j] / scale[i] / scale[j]));
    let mut rows: [[f64; 6]; 3] = core::array::from_fn(|i| {
        core::array::from_fn(|j| if j < 3 { c[i][j] } else { f64::from(u8::from(i + 3 == j)) })
    });
    for pivot in 0..3 {
        let largest = (pivot..3).max_by(|&a, &b| rows[a][pivot].abs().total_cmp(&rows[b][pivot].abs())).unwrap();
        rows.swap(pivot, largest);
        let size = rows[pivot][pivot];
        rows[pivot] = rows[pivot].map(|value| value / size);
        for i in (0..3).filter(|&i| i != pivot) {
            let factor = rows[i][pivot];
            rows[i] = core::array::from_fn(|j| rows[i][j] - factor * rows[pivot][j]);
        }
    }
    let times = |one: [[f64; 3]; 3], other: [[f64; 3]; 3]| -> [[f64; 3]; 3] {
        core::array::from_fn(|i| core::array::from_fn(|j| (0..3).map(|n| one[i][n] * other[n][j]).sum()))
    };
    let mut found: [[f64; 3]; 3] = core::array::from_fn(|i| core::array::from_fn(|j| rows[i][j + 3]));
    for _ in 0..2 {
        let product = times(c, found);
        let rest =
            core::array::from_fn(|i| core::array::from_fn(|j| 2.0 * f64::from(u8::from(i == j)) - product[i][j]));
        found = times(found, rest);
    }
    core::array::from_fn(|i| core::array::from_fn(|j| found[i][j] / scale[i] / scale[j]))
}

/// FILTER-2 to FILTER-5 in floating point: the estimate, its covariance and the NIS.
fn iterated(
    start: Vector,
    p: &Matrix,
    seen: [f64; 3],
    fitted: [[f64; 3]; 3],
    place: [f64; 3],
) -> Option<(Vector, Matrix, f64)> {
    let mut at = start;
    let (mut share, mut before) = (1.0_f64, None::<[f64; 3]>);
    for _ in 0..10 {
        let robot = [at[0], at[1], at[2]];
        let (expected, depth) = image(robot, place);
        if depth <= power(-8) {
            return None;
        }
        let mut h = [[0.0; STATES]; 3];
        for j in 0..3 {
            let (mut up, mut down) = (robot, robot);
            up[j] += 1e-6;
            down[j] -= 1e-6;
            let (up, down) = (image(up, place).0, image(down, place).0);
            (0..3).for_each(|i| h[i][j] = (up[i] - down[i]) / 2e-6);
        }
        let (sin, cos) = at[2].sin_cos();
        let axle = AXLE * (1.0 + at[4]);
        let wheels = [-1.0, 1.0].map(|side| {
            let way = 0.5 * (1.0 + side * at[3] / 2.0);
            [cos * way, sin * way, 2.0 * side * way / axle]
        });
        let through = |i: usize, wheel: usize| (0..3).map(|n| h[i][n] * wheels[wheel][n]).sum::<f64>();
        let noise: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let unmodelled = if i == j { [0.01, 0.0025, 2.5e-7][i] } else { 0.0 };
                let steps = (0..2).map(|w| through(i, w) * through(j, w)).sum::<f64>() * STEP * STEP / 12.0;
                fitted[i][j] + unmodelled + steps
            })
        });
        let ph: [[f64; 3]; STATES] =
            core::array::from_fn(|i| core::array::from_fn(|j| (0..STATES).map(|n| p[i][n] * h[j][n]).sum()));
        let s: [[f64; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| noise[i][j] + (0..STATES).map(|n| h[i][n] * ph[n][j]).sum::<f64>())
        });
        let inverse = inverse(s);
        let k: [[f64; 3]; STATES] =
            core::array::from_fn(|i| core::array::from_fn(|j| (0..3).map(|n| ph[i][n] * inverse[n][j]).sum()));
        let innovation: [f64; 3] = core::array::from_fn(|i| {
            seen[i] - expected[i] + (0..STATES).map(|n| h[i][n] * (at[n] - start[n])).sum::<f64>()
        });
        let nis = (0..9).map(|n| innovation[n / 3] * inverse[n / 3][n % 3] * innovation[n % 3]).sum();
        let next: Vector = core::array::from_fn(|i| start[i] + (0..3).map(|n| k[i][n] * innovation[n]).sum::<f64>());
        let rest: Matrix = core::array::from_fn(|i| {
            core::array::from_fn(|j| f64::from(u8::from(i == j)) - (0..3).map(|n| k[i][n] * h[n][j]).sum::<f64>())
        });
        let after: Matrix = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let kept: f64 = (0..25).map(|n| rest[i][n / 5] * p[n / 5][n % 5] * rest[j][n % 5]).sum();
                kept + (0..9).map(|n| k[i][n / 3] * noise[n / 3][n % 3] * k[j][n % 3]).sum::<f64>()
            })
        });
        let settled = (next[0] - at[0]).abs() + (next[1] - at[1]).abs() < 2e-5 && (next[2] - at[2]).abs() < 2e-5;
        if settled {
            return Some((next, after, nis));
        }
        // FILTER-9
        let way: [f64; 3] = core::array::from_fn(|i| next[i] - at[i]);
        let dot = |one: [f64; 3], other: [f64; 3]| (0..3).map(|i| one[i] * other[i]).sum::<f64>();
        if let Some(before) = before.replace(way) {
            let r = dot(way, before) / dot(before, before);
            share = if r < 1.0 { (share / (1.0 - r)).clamp(0.25, 4.0) } else { 4.0 };
        }
        at = core::array::from_fn(|i| at[i] + share * (next[i] - at[i]));
    }
    // FILTER-4: it has not settled.
    None
}

fn build() -> Build {
    Build {
        camera: Camera::epuck(),
        mounting: mounted_ahead(),
        drive: Drive::epuck(),
        model: MotionModel::Arc,
        slip: SLIP_OF_FIVE,
    }
}

/// A fit's covariance by its standard deviations, without correlations.
fn fitted(deviations: [f64; 3]) -> (Covariance, [[f64; 3]; 3]) {
    let [aa, ss, kk] = deviations.map(|deviation| (deviation * deviation * power(50)).round() as i64);
    let exact = core::array::from_fn(|i| {
        core::array::from_fn(|j| if i == j { [aa, ss, kk][i] as f64 * power(-50) } else { 0.0 })
    });
    (Covariance { aa, ss, kk, ..Covariance::default() }, exact)
}

/// What a robot sees of a landmark, with errors in multiples of the fit's deviations.
fn sighting(robot: [f64; 3], place: [f64; 3], deviations: [f64; 3], errors: [f64; 3]) -> Sighting {
    let (exact, _) = image(robot, place);
    let [a, s, k]: [f64; 3] = core::array::from_fn(|i| exact[i] + deviations[i] * errors[i]);
    let homography = Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) };
    let landmark = Landmark::paper();
    let (covariance, _) = fitted(deviations);
    let seen = Seen::Image { homography, covariance };
    let (camera, spread) = crate::covariance::transform(&homography, &covariance, &Camera::epuck(), &landmark).unwrap();
    Sighting { place: pose(place), landmark, pose: camera, covariance: spread, seen }
}

/// A robot that sees a barcode at a depth, aside by a share of it, and slanted.
fn robot_before(place: [f64; 3], depth: f64, side: f64, slant: f64) -> [f64; 3] {
    let camera = composed(place, inverted([depth, depth * side, slant - PI]));
    composed(camera, inverted(floats(&mounted_ahead())))
}

fn seen(sighting: &Sighting) -> [f64; 3] {
    let Seen::Image { homography, .. } = sighting.seen else { return [0.0; 3] };
    [homography.a.to_num(), homography.s.to_num(), homography.k.to_num()]
}

/// Random states in the declared domain: deviations from 10 µm to 2 m, 50 µrad to π, 1e-6 to 0.05, and any correlations.
//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-2** An observation MUST be linearised at the estimate and again towards where that leads (FILTER-9),
//# until the position moves by less than 2e-5 m along x and y together and the heading by less than 2e-5 rad, 10 times
//# at most.
//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-3** The innovation MUST be `ν = z - h(x_i) + H (x_i - x_0)`, its covariance `S = H P Hᵀ + R`, and the
//# estimate `x_0 + P Hᵀ S⁻¹ ν`, with `R` the noise and MOTION-7's, angles the short way round.
//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-4** An observation MUST be used if its linearisations end before or with the tenth, if its NIS, `νᵀ S⁻¹
//# ν` at the last one, is at most 16.266 *(1 in 1,000 of a chi-square of three)*, and if its landmark's centre is at
//# least 2^-8 m in front of the camera wherever it is linearised.
//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-5** The covariance MUST become `(I - K H) P (I - K H)ᵀ + K R Kᵀ`, or what is the same without rounding.
#[test]
fn an_update_is_that_of_the_specification() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (mut used, mut gated) = (0, 0);
    for case in 0..4000 {
        let place: [f64; 3] =
            [random.random_range(-50.0..50.0), random.random_range(-50.0..50.0), random.random_range(-3.1..3.1)];
        let truth = robot_before(
            floats(&pose::<World, frame::Landmark>(place)),
            random.random_range(0.1..0.5),
            random.random_range(-0.3..0.3),
            random.random_range(-1.0..1.0),
        );
        let largest: Vector = if case % 2 == 0 { [0.02, 0.02, 0.1, 0.01, 0.01] } else { [2.0, 2.0, 3.1, 0.05, 0.05] };
        let smallest: Vector = [1e-5, 1e-5, 5e-5, 1e-6, 1e-6];
        let deviations: Vector = core::array::from_fn(|i| random.random_range(smallest[i].ln()..largest[i].ln()).exp());
        let rows: Vec<Vector> = (0..6).map(|_| core::array::from_fn(|_| random.random_range(-1.0..1.0))).collect();
        let raw: Matrix = core::array::from_fn(|i| core::array::from_fn(|j| rows.iter().map(|r| r[i] * r[j]).sum()));
        let p: Matrix = core::array::from_fn(|i| {
            core::array::from_fn(|j| raw[i][j] / (raw[i][i] * raw[j][j]).sqrt() * deviations[i] * deviations[j])
        });
        let off: Vector = core::array::from_fn(|i| (0.5 * deviations[i]).min(0.03) * random.random_range(-1.0..1.0));
        let start = pose([truth[0] + off[0], truth[1] + off[1], truth[2] + off[2]]);
        let mut state = State::new(&start, &PoseCovariance::default());
        [state.e, state.g] = [off[3], off[4]].map(Share::from_num);
        set(&mut state, &p);
        let noise = [0.02, 0.03, 1e-4].map(|least: f64| least * random.random_range(0.0..3.0_f64).exp());
        // One in four so wrong that some of them are gated.
        let wrong = if case % 4 == 3 { 6.0 } else { 1.5 };
        let errors = core::array::from_fn(|_| random.random_range(-wrong..wrong));
        let sighting = sighting(truth, floats(&pose::<World, frame::Landmark>(place)), noise, errors);
        let (_, exact) = fitted(noise);
        let before = numbers(&state);
        let expected = iterated(before, &entries(&state.covariance), seen(&sighting), exact, floats(&sighting.place));
        let mut filter = Filter::new(build(), state);
        let outcome = filter.observe(&sighting, 1);
        let Some((expected, spread, nis)) = expected else {
            assert_eq!(outcome, Outcome::Gated);
            continue;
        };
        if (nis - GATE).abs() < 0.05 * GATE {
            continue; // Either may be right.
        }
        assert_eq!(outcome == Outcome::Used, nis < GATE, "case {case}: {nis}");
        if outcome != Outcome::Used {
            gated += 1;
            continue;
        }
        used += 1;
        let (found, covariance) = (numbers(filter.state()), entries(&filter.state().covariance));
        for i in 0..STATES {
            let deviation = spread[i][i].sqrt();
            let mut wrong = found[i] - expected[i];
            if i == 2 {
                wrong = short(wrong);
            }
            // One twentieth of a deviation; FILTER-2 stops within 2e-5.
            assert!(wrong.abs() < 0.05 * deviation + 1e-8, "case {case}, {i}: {wrong:e} of {deviation:e}");
            for j in 0..STATES {
                let off = (covariance[i][j] - spread[i][j]).abs() / (spread[i][i] * spread[j][j]).sqrt();
                assert!(off < 0.02, "case {case}, {i} {j}: {off:e} {covariance:?} {spread:?} {p:?}");
            }
        }
    }
    assert!(used > 3000 && gated > 100, "{used} {gated}");
}

//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-7** A candidate on which observations of two images agree MUST replace the estimate *(choice: both layers
//# of an image share a check byte)*.
#[test]
fn recovery_takes_two_images() {
    let place = [1.0, 0.0, PI];
    let truth = robot_before(place, 0.3, 0.05, 0.2);
    let small = PoseCovariance { xx: 1 << 30, yy: 1 << 30, tt: 1 << 30, ..PoseCovariance::default() }; // 2 mm, 2 mrad
    let state = State::new(&pose([-0.5, 0.3, 1.0]), &small).with_wheels(Share::from_num(0.002), Share::from_num(0.005));
    let noise = [0.03, 0.03, 2e-4];
    let see = |errors: [f64; 3]| sighting(truth, place, noise, errors);
    let mut filter = Filter::new(build(), state);
    assert_eq!(filter.observe(&see([0.3, 0.2, -0.1]), 7), Outcome::Gated);
    // The other layer of the same image agrees, which is not enough.
    assert_eq!(filter.observe(&see([-0.4, 0.1, 0.5]), 7), Outcome::Gated);
    assert_eq!(filter.state(), &state);
    assert_eq!(filter.observe(&see([0.1, -0.5, 0.2]), 8), Outcome::Recovered);
    let found = numbers(filter.state());
    assert!((found[0] - truth[0]).hypot(found[1] - truth[1]) < 0.01, "{found:?} {truth:?}");
    assert_eq!(filter.counts(), Counts { used: 0, gated: 2, recovered: 1 });
    // What is known of the wheels is still estimated.
    assert_eq!(filter.state().covariance.uncertain(), STATES);
    assert_eq!(filter.observe(&see([0.0; 3]), 9), Outcome::Used);
    assert_eq!(filter.counts().used, 1);
}

//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-6** An observation that is not used MUST become the candidate, its pose and covariance by OBSERVE-2 and
//# of `e` and `g` what the filter knows, unless it agrees with the candidate there is by FILTER-4 and is used for that.
//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-8** An observation that is used MUST end the candidate.
#[test]
fn candidates_that_disagree_or_are_outdated_do_not_recover() {
    let place = [1.0, 0.0, PI];
    let (truth, elsewhere) = (robot_before(place, 0.3, 0.05, 0.2), robot_before(place, 0.2, -0.1, -0.5));
    let small = PoseCovariance { xx: 1 << 30, yy: 1 << 30, tt: 1 << 30, ..PoseCovariance::default() };
    let noise = [0.03, 0.03, 2e-4];
    let see = |robot: [f64; 3]| sighting(robot, place, noise, [0.0; 3]);
    let state = State::new(&pose(truth), &small);
    let mut filter = Filter::new(build(), state);
    assert_eq!(filter.observe(&see(elsewhere), 1), Outcome::Gated);
    assert_eq!(filter.observe(&see(robot_before(place, 0.4, 0.2, 0.6)), 2), Outcome::Gated);
    assert_eq!(filter.observe(&see(elsewhere), 3), Outcome::Gated);
    // An observation that is used ends the candidate (FILTER-8).
    assert_eq!(filter.observe(&see(truth), 4), Outcome::Used);
    assert_eq!(filter.observe(&see(elsewhere), 5), Outcome::Gated);
    assert_eq!(filter.counts(), Counts { used: 1, gated: 4, recovered: 0 });
}

#[test]
fn three_numbers_are_five_of_which_two_are_known() {
    let place = [1.0, 0.0, PI];
    let truth = robot_before(place, 0.3, 0.05, 0.2);
    let spread = PoseCovariance { xx: 1 << 34, xy: 1 << 32, xt: 1 << 33, yy: 1 << 35, yt: -1 << 32, tt: 1 << 35 };
    let three = State::new(&pose([truth[0] + 0.005, truth[1] - 0.004, truth[2] + 0.005]), &spread);
    let mut five = three;
    five.covariance.set(3, 3, 1);
    five.covariance.set(4, 4, 1);
    let seen = sighting(truth, place, [0.03, 0.03, 2e-4], [0.2, -0.3, 0.4]);
    let [mut one, mut other] = [three, five].map(|state| Filter::new(build(), state));
    assert_eq!((one.observe(&seen, 1), other.observe(&seen, 1)), (Outcome::Used, Outcome::Used));
    assert_eq!(one.state().covariance.uncertain(), 3);
    assert_eq!((one.state().e, one.state().g), (Share::ZERO, Share::ZERO));
    let (one, other) = (numbers(one.state()), numbers(other.state()));
    assert!((0..3).all(|i| (one[i] - other[i]).abs() < 1e-9), "{one:?} {other:?}");
}

/// By Cholesky in floating point, of the correlations.
fn is_semidefinite(covariance: &Matrix) -> bool {
    let mut rows: Matrix = core::array::from_fn(|i| {
        core::array::from_fn(|j| covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt())
    });
    (0..STATES).all(|pivot| {
        let row = rows[pivot];
        for i in pivot + 1..STATES {
            for j in pivot + 1..STATES {
                rows[i][j] -= row[i] * row[j] / row[pivot].max(1e-13);
            }
        }
        row[pivot] > -1e-13
    })
}

/// A robot that turns on the spot and drives to and fro before two landmarks, 3,000 sightings.
//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-1** The wheels' ways MUST move the state, and the candidate of FILTER-6 if there is one, by MOTION.
#[test]
fn a_long_route_keeps_its_covariance_and_its_way() {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let place = [0.4, 0.0, PI];
    let spread = PoseCovariance { xx: 1 << 34, yy: 1 << 34, tt: 1 << 36, ..PoseCovariance::default() };
    let start =
        State::new(&pose([0.01, -0.01, 0.0]), &spread).with_wheels(Share::from_num(0.005), Share::from_num(0.01));
    let mut filter = Filter::new(build(), start);
    let mut truth = [0.0, 0.0, 0.0];
    for image in 0..3000 {
        // A hundred steps out and back, with a turn between.
        let count = [10, 10, -10, -10][image as usize % 4];
        let bend = [1, -1, 1, -1][(image / 4) as usize % 4];
        for _ in 0..5 {
            let turned = [count - bend, count + bend].map(|steps| f64::from(steps) * STEP);
            let (way, turn) = (f64::midpoint(turned[0], turned[1]), (turned[1] - turned[0]) / AXLE);
            let chord = if turn == 0.0 { way } else { way * (turn / 2.0).sin() / (turn / 2.0) };
            let direction: f64 = truth[2] + turn / 2.0;
            truth = [truth[0] + chord * direction.cos(), truth[1] + chord * direction.sin(), truth[2] + turn];
            filter.predict(&Ways { left: Steps::from_num(count - bend), right: Steps::from_num(count + bend) });
        }
        let errors = core::array::from_fn(|_| random.random_range(-1.0..1.0));
        assert_eq!(filter.observe(&sighting(truth, place, [0.1, 0.05, 5e-4], errors), image), Outcome::Used, "{image}");
        let covariance = entries(&filter.state().covariance);
        assert!(is_semidefinite(&covariance), "{image}: {covariance:?}");
        assert!((0..STATES).all(|i| covariance[i][i] > 0.0));
    }
    let found = numbers(filter.state());
    assert!((found[0] - truth[0]).hypot(found[1] - truth[1]) < 0.003, "{found:?} {truth:?}");
    let estimate = filter.estimate();
    assert!((estimate.pose.x.to_num::<f64>() - found[0]).abs() < power(-24));
    assert!(
        estimate.covariance.xx > 0
            && estimate.e.to_num::<f64>().abs() < 0.01
            && estimate.g.to_num::<f64>().abs() < 0.02
    );
}
