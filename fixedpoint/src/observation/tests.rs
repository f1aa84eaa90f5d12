#![allow(clippy::needless_range_loop)] // indices of vectors and matrices

use super::*;
use crate::formats::{Column, Obliquity, Share, StripeWidth};
use crate::landmark::Format;
use proptest::prelude::*;
use std::f64::consts::PI;

fn power(exponent: i32) -> f64 {
    2_f64.powi(exponent)
}

fn angle(value: f64) -> Angle {
    #[expect(clippy::cast_possible_truncation, reason = "of a number in range")]
    Angle::from_bits((((value / PI + 1.0).rem_euclid(2.0) - 1.0) * power(31)) as i32)
}

fn pose<Parent, Child>([x, y, theta]: [f64; 3]) -> Pose<Parent, Child> {
    Pose::new(Length::from_num(x), Length::from_num(y), angle(theta))
}

fn floats<Parent, Child>(pose: &Pose<Parent, Child>) -> [f64; 3] {
    [pose.x.to_num(), pose.y.to_num(), f64::from(pose.theta.to_bits()) * PI / power(31)]
}

/// `inner`'s pose in the frame of `outer`.
fn composed(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = outer[2].sin_cos();
    [outer[0] + cos * inner[0] - sin * inner[1], outer[1] + sin * inner[0] + cos * inner[1], outer[2] + inner[2]]
}

fn inverted([x, y, theta]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = theta.sin_cos();
    [-(cos * x + sin * y), sin * x - cos * y, -theta]
}

/// OBSERVE-3 of a robot in the world.
fn image(robot: [f64; 3], place: [f64; 3], mounting: [f64; 3], f: f64, w: f64) -> [f64; 3] {
    let camera = composed(inverted(place), composed(robot, mounting));
    let centre = inverted(camera);
    let (sin, cos) = camera[2].sin_cos();
    [-f * centre[1] / centre[0], -f * w * cos / centre[0], w * sin / centre[0]]
}

fn sighting(place: [f64; 3], seen: Seen, covariance: PoseCovariance, at: [f64; 3]) -> Sighting {
    Sighting { place: pose(place), landmark: Landmark::paper(), pose: pose(at), covariance, seen }
}

fn derivatives(of: impl Fn([f64; 3]) -> [f64; 3], at: [f64; 3]) -> [[f64; 3]; 3] {
    let step = 1e-6;
    let columns: [[f64; 3]; 3] = core::array::from_fn(|j| {
        let (mut up, mut down) = (at, at);
        up[j] += step;
        down[j] -= step;
        let (up, down) = (of(up), of(down));
        core::array::from_fn(|i| (up[i] - down[i]) / (2.0 * step))
    });
    core::array::from_fn(|i| core::array::from_fn(|j| columns[j][i]))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    //= reference/SPEC.md#observe
    //= type=test
    //# - **OBSERVE-3** As an image, a sighting MUST be `(a, s, k)`, compared with what the camera at the state's pose
    //# would see: `a = -f l/d`, `s = -f W cos θ/d`, `k = W sin θ/d` of its heading θ in L, the depth `d` of the
    //# barcode's centre and its offset `l` to the left.
    //= reference/SPEC.md#observe
    //= type=test
    //# - **OBSERVE-4** The noise of an image MUST be the fit's covariance (FIT-14) with `0.1² px²`, `0.05² px²` and
    //# `0.0005²` added for what no model covers.
    #[test]
    fn an_image_is_that_of_the_specification(
        place in [-100.0..100.0_f64, -100.0..100.0_f64, -PI..PI],
        (depth, side, slant) in (0.05..0.8_f64, -0.35..0.35_f64, -1.2..1.2_f64),
        mounting in [-0.1..0.1_f64, -0.1..0.1_f64, -3.0..3.0_f64],
    ) {
        let (place, mounting) = (pose::<World, frame::Landmark>(place), pose::<Robot, frame::Camera>(mounting));
        // A camera from which the barcode is at (depth, depth side), and the robot that carries it.
        let camera = composed(floats(&place), inverted([depth, depth * side, slant - PI]));
        let robot = pose::<World, Robot>(composed(camera, inverted(floats(&mounting))));
        let state = State::new(&robot, &PoseCovariance::default());
        let (robot, at, carried) = (floats(&robot), floats(&place), floats(&mounting));
        let w = Landmark::paper().stripe_width().to_num::<f64>() * 10.0;
        let predict = |robot: [f64; 3]| image(robot, at, carried, 640.0, w);
        let exact = predict(robot);
        let homography = Homography { a: Column::ZERO, s: Column::ZERO, k: Obliquity::ZERO };
        let seen = Seen::Image { homography, covariance: Covariance::default() };
        let sighting = Sighting { place, ..sighting([0.0; 3], seen, PoseCovariance::default(), [0.0; 3]) };
        let found = linearised(&sighting, &state, &Camera::epuck(), &mounting, &Drive::epuck()).unwrap();
        let units = [16.0, 16.0, 1.0 / 16.0];
        let by = derivatives(predict, robot);
        for i in 0..3 {
            let size = exact[i].abs();
            let value = -(found.residual[i] as f64) * power(-36) * units[i];
            // 2^-29 rad and the depth's reciprocal.
            let rounding = size * power(-26) + power(-28) * [640.0 * 1.2, exact[1].abs() + 640.0 * w / depth, w / depth][i] + 1e-10;
            prop_assert!((value - exact[i]).abs() < rounding, "{} {} {:e}", value, exact[i], rounding);
            let largest = by[i].into_iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            for j in 0..3 {
                let value = found.by_pose[i][j] as f64 * power(-32) * units[i];
                prop_assert!((value - by[i][j]).abs() < 1e-5 * largest + 1e-7, "{} {}: {} {}", i, j, value, by[i][j]);
            }
        }
        // The noise of a perfect fit: what no model covers, and the steps'.
        let step = PI * 0.041 / 1000.0;
        let (sin, cos) = robot[2].sin_cos();
        let wheels = [[cos / 2.0, sin / 2.0, -1.0 / 0.053], [cos / 2.0, sin / 2.0, 1.0 / 0.053]];
        let through = |i: usize, wheel: usize| (0..3).map(|n| by[i][n] * wheels[wheel][n]).sum::<f64>();
        let reach = |i: usize| by[i].into_iter().map(f64::abs).sum::<f64>();
        for i in 0..3 {
            for j in 0..3 {
                let unmodelled = if i == j { [0.01, 0.0025, 2.5e-7][i] } else { 0.0 };
                let steps = (0..2).map(|wheel| through(i, wheel) * through(j, wheel)).sum::<f64>() * step * step / 12.0;
                let value = found.noise.entry(i, j) as f64 * power(-56) * units[i] * units[j];
                let size = |i: usize| [0.01, 0.0025, 2.5e-7][i] + (0..2).map(|wheel| through(i, wheel).powi(2)).sum::<f64>() * step * step / 12.0;
                // The entries of the steps' covariance are half a unit of 2^-48 off, in whatever directions.
                let bound = 2e-5 * (size(i) * size(j)).sqrt() + power(-49) * reach(i) * reach(j);
                prop_assert!((value - unmodelled - steps).abs() < bound, "{} {}: {} {}", i, j, value, unmodelled + steps);
            }
        }
    }

    //= reference/SPEC.md#observe
    //= type=test
    //# - **OBSERVE-2** As a pose, a sighting MUST be (10), the camera's pose in the landmark's frame taken to the robot
    //# and the world, with its covariance (COV-4, COV-5) carried through the derivatives.
    #[test]
    fn a_pose_is_that_of_the_specification(
        place in [-50.0..50.0_f64, -50.0..50.0_f64, -PI..PI],
        camera in [0.05..1.0_f64, -0.6..0.6_f64, -PI..PI],
        mounting in [-0.1..0.1_f64, -0.1..0.1_f64, -3.0..3.0_f64],
        rows in [[-0.1..0.1_f64, -0.1..0.1_f64, -0.3..0.3_f64], [-0.1..0.1_f64, -0.1..0.1_f64, -0.3..0.3_f64], [-0.1..0.1_f64, -0.1..0.1_f64, -0.3..0.3_f64]],
        known in [-50.0..50.0_f64, -50.0..50.0_f64, -PI..PI],
    ) {
        let entry = |i: usize, j: usize| (0..3).map(|n| rows[n][i] * rows[n][j]).sum::<f64>();
        #[expect(clippy::cast_possible_truncation, reason = "of a number in range")]
        let bits = |i: usize, j: usize| (entry(i, j) * power(48)).round() as i64;
        let covariance =
            PoseCovariance { xx: bits(0, 0), xy: bits(0, 1), xt: bits(0, 2), yy: bits(1, 1), yt: bits(1, 2), tt: bits(2, 2) };
        let sighting = sighting(place, Seen::Pose, covariance, camera);
        let mounting = pose(mounting);
        let (found, spread) = robot_in_world(&sighting, &mounting);
        let (place, camera) = (floats(&sighting.place), floats(&sighting.pose));
        let through = |camera: [f64; 3]| composed(composed(place, camera), inverted(floats(&mounting)));
        let (robot, exact) = (floats(&found), through(camera));
        let short = |one: f64, other: f64| (one - other + PI).rem_euclid(2.0 * PI) - PI;
        prop_assert!((robot[0] - exact[0]).abs() < power(-24) && (robot[1] - exact[1]).abs() < power(-24));
        prop_assert!(short(robot[2], exact[2]).abs() < 1e-8);
        let by = derivatives(through, camera);
        let PoseCovariance { xx, xy, xt, yy, yt, tt } = spread;
        let spread = [[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]].map(|row| row.map(|entry| entry as f64 * power(-48)));
        for i in 0..3 {
            for j in 0..3 {
                let exact: f64 = (0..9).map(|n| by[i][n / 3] * entry(n / 3, n % 3) * by[j][n % 3]).sum();
                prop_assert!((spread[i][j] - exact).abs() < 1e-8, "{} {}: {} {}", i, j, spread[i][j], exact);
            }
        }
        let known = pose(known);
        let state = State::new(&known, &PoseCovariance::default()).with_wheels(Share::ZERO, Share::ZERO);
        let compared = linearised(&sighting, &state, &Camera::epuck(), &mounting, &Drive::epuck()).unwrap();
        let known = floats(&known);
        let residual = compared.residual.map(|residual| residual as f64 * power(-36));
        prop_assert!((residual[0] - (robot[0] - known[0])).abs() < 1e-9);
        prop_assert!((residual[1] - (robot[1] - known[1])).abs() < 1e-9);
        prop_assert!((residual[2] - short(robot[2], known[2])).abs() < 1e-8);
    }

    /// To the camera and back: the robot's pose in the landmark's frame and its covariance, turned as the landmark is.
    #[test]
    fn a_pose_from_elsewhere_comes_back_through_any_mounting(
        place in [-50.0..50.0_f64, -50.0..50.0_f64, -PI..PI],
        robot in [0.05..1.0_f64, -0.6..0.6_f64, -PI..PI],
        mounting in [-0.7..0.7_f64, -0.7..0.7_f64, -3.0..3.0_f64],
        entries in [1e-6..1e-2_f64, -0.9..0.9_f64, 1e-6..1e-2_f64, 1e-6..1e-2_f64],
    ) {
        #[expect(clippy::cast_possible_truncation, reason = "of a number in range")]
        let bits = |entry: f64| (entry * power(48)).round() as i64;
        let [xx, share, yy, tt] = entries;
        let [xy, yt] = [xx * yy, yy * tt].map(|product: f64| share * product.sqrt() / 2.0);
        let covariance = PoseCovariance { xx: bits(xx), xy: bits(xy), xt: 0, yy: bits(yy), yt: bits(yt), tt: bits(tt) };
        let (place, robot, mounting) = (pose(place), pose(robot), pose(mounting));
        let sighting = of_robot(&place, &robot, &covariance, &mounting);
        let (found, spread) = robot_in_world(&sighting, &mounting);
        let (found, exact) = (floats(&found), composed(floats(&place), floats(&robot)));
        let short = |one: f64, other: f64| (one - other + PI).rem_euclid(2.0 * PI) - PI;
        prop_assert!((found[0] - exact[0]).abs() < power(-23) && (found[1] - exact[1]).abs() < power(-23));
        prop_assert!(short(found[2], exact[2]).abs() < 1e-8);
        let (sin, cos) = floats(&place)[2].sin_cos();
        let turned = [
            (spread.xx, cos * cos * xx - 2.0 * sin * cos * xy + sin * sin * yy),
            (spread.xy, sin * cos * (xx - yy) + (cos * cos - sin * sin) * xy),
            (spread.yy, sin * sin * xx + 2.0 * sin * cos * xy + cos * cos * yy),
            (spread.xt, -sin * yt),
            (spread.yt, cos * yt),
            (spread.tt, tt),
        ];
        for (found, exact) in turned {
            prop_assert!((found as f64 * power(-48) - exact).abs() < 1e-10, "{found} {exact}");
        }
    }
}

//= reference/SPEC.md#observe
//= type=test
//# - **OBSERVE-1** The camera MUST by default be mounted 3 cm ahead of the axle's middle, looking ahead.
#[test]
fn the_camera_is_three_centimetres_ahead() {
    let [ahead, left, turned] = floats(&mounted_ahead());
    assert!((ahead - 0.03).abs() < power(-25) && left == 0.0 && turned == 0.0);
}

#[test]
fn a_landmark_behind_the_camera_is_not_seen() {
    let homography = Homography { a: Column::ZERO, s: Column::ONE, k: Obliquity::ZERO };
    let seen = Seen::Image { homography, covariance: Covariance::default() };
    // Of stripes of 0.5 mm, so that 2^-8 m before it `s` is less than FILTER-10 allows.
    let landmark = Landmark::new(Format::Paper, StripeWidth::from_num(0.000_501)).unwrap();
    let sighting = Sighting { landmark, ..sighting([1.0, 0.0, PI], seen, PoseCovariance::default(), [0.0; 3]) };
    let from = |x: f64, theta: f64| {
        let state = State::new(&pose([x, 0.0, theta]), &PoseCovariance::default());
        linearised(&sighting, &state, &Camera::epuck(), &mounted_ahead(), &Drive::epuck())
    };
    assert!(from(0.5, 0.0).is_some());
    assert!(from(0.5, 3.0).is_none());
    assert!(from(0.98, 0.0).is_none());
    // 2^-8 m before it, 3.906 mm; the axle is 30 mm behind the camera.
    assert!(from(0.966_09, 0.0).is_some() && from(0.966_1, 0.0).is_none());
}

/// 2048 px are 3.2 times the focal length: `a` of a barcode 3.2 times as far aside as ahead, `s` of one whose half is 3.2 times as
/// wide, and `k` is 4 of one that stands endwise and whose half is 4 times as long, 0.2 m of stripes of 20 mm.
//= reference/SPEC.md#filter
//= type=test
//# - **FILTER-10** An image MUST NOT be used if one of its linearisations expects `|a|` or `|s|` above 2048 px or
//# `|k|` above 4.
#[test]
fn what_no_camera_sees_is_not_expected() {
    let homography = Homography { a: Column::ZERO, s: Column::ONE, k: Obliquity::ZERO };
    let seen = Seen::Image { homography, covariance: Covariance::default() };
    let expects = |landmark: Landmark, camera: [f64; 3]| {
        let sighting = Sighting { landmark, ..sighting([0.0; 3], seen, PoseCovariance::default(), [0.0; 3]) };
        let robot = composed(camera, inverted(floats(&mounted_ahead())));
        let state = State::new(&pose(robot), &PoseCovariance::default());
        linearised(&sighting, &state, &Camera::epuck(), &mounted_ahead(), &Drive::epuck()).is_some()
    };
    let (paper, large) = (Landmark::paper(), Landmark::new(Format::Paper, StripeWidth::from_num(0.02)).unwrap());
    for side in [-1.0, 1.0] {
        assert!(expects(paper, [0.1, side * 0.3199, PI]) && !expects(paper, [0.1, side * 0.3201, PI]));
        assert!(expects(large, [0.0, side * 0.0501, -side * PI / 2.0]));
        assert!(!expects(large, [0.0, side * 0.0499, -side * PI / 2.0]));
    }
    assert!(expects(paper, [0.0047, 0.0, PI]) && !expects(paper, [0.0046, 0.0, PI]));
}
