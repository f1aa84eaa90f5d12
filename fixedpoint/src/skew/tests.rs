use super::*;
use crate::drawing::View;
use crate::formats::{Steps, StripeWidth};
use crate::landmark::Format;
use crate::observation::mounted_ahead;
use proptest::prelude::*;
use std::{f64::consts::PI, vec::Vec};

fn skew(x: f64, y: f64, turn: f64) -> Skew {
    let bits = (turn / PI * 2_f64.powi(31)).round();
    #[allow(clippy::cast_possible_truncation)] // of an angle in range
    let turn = Angle::from_bits(bits as i32);
    Skew { x: Displacement::from_num(x), y: Displacement::from_num(y), turn, play: 0 }
}

/// A skew in m and rad, as its formats have it.
fn exact(skew: &Skew) -> [f64; 3] {
    [skew.x.to_num(), skew.y.to_num(), f64::from(skew.turn.to_bits()) / 2_f64.powi(31) * PI]
}

fn landmark(format: Format) -> Landmark {
    if format == Format::Paper { Landmark::paper() } else { Landmark::wide() }
}

fn homography(a: f64, s: f64, k: f64) -> Homography {
    Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) }
}

fn carried(homography: &Homography, x: f64, y: f64, turn: f64) -> Option<Homography> {
    skew(x, y, turn).carry(homography, &Camera::epuck(), &Landmark::paper())
}

/// A view whose homography is what the format holds.
fn view(format: Format, a: f64, s: f64, k: f64) -> View {
    let Homography { a, s, k } = homography(a, s, k);
    View { a: a.to_num(), s: s.to_num(), k: k.to_num(), ..View::turned(format, 1.0, 0.0) }
}

fn wheels(left: f64, right: f64) -> Ways {
    Ways { left: Steps::from_num(left), right: Steps::from_num(right) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// `SKEW-2` against the projection of the barcode's points, within the stated errors.
    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-2** A homography `(a, s, k)` MUST be carried to the lower row by `1/ρ = √(k² + (s/f)²)/W`, `u = (1 -
    //# t_x/ρ, -a/f - t_y/ρ)` and `v = (k, -s/f)`, which are turned by `-φ` into `u'` and `v'`: `a' = -f u'_y/u'_x`, `s'
    //# = -f v'_y/u'_x`, `k' = v'_x/u'_x`; its *shift* is `Δ = (a' - a, s' - s, k' - k)`.
    #[test]
    fn a_homography_is_carried_to_what_the_moved_camera_sees(
        wide in any::<bool>(),
        (a, s, k) in (-240.0..240.0, 12.0..150.0, -0.5..0.5),
        (x, y, turn) in (-0.05..0.05, -0.05..0.05, -0.2..0.2),
    ) {
        let format = if wide { Format::Wide } else { Format::Paper };
        let (seen, skew) = (view(format, a, s, k), skew(x, y, turn));
        let [x, y, turn] = exact(&skew);
        let expected = seen.moved([x, y, turn]);
        let half_width = 0.0015 * f64::from(format.stripes()) / 2.0;
        // u'_x, by the depths of the barcode's centre before and after.
        let before = half_width / seen.k.hypot(seen.s / 640.0);
        let after = (before - x) * turn.cos() - (before * seen.a / 640.0 + y) * turn.sin();
        let share = after / before;
        let Some(found) = skew.carry(&seen.homography(), &Camera::epuck(), &landmark(format)) else {
            let quarter = f64::from(format.stripes()) / 4.0;
            let hopeless = expected.k.abs() > 0.75 || expected.s < quarter || expected.s <= expected.a * expected.k;
            let beyond = expected.a.abs().max(expected.s) >= 2048.0; // the columns' format
            prop_assert!(hopeless || beyond || share < 0.250_001, "{:?}", expected);
            return Ok(());
        };
        // W is rounded by N/2 2^-33 m.
        let length = (640.0 * k).hypot(s);
        let displaced = x.hypot(y) / half_width;
        let lengths = 640.0 + a.abs() + length * displaced;
        let error = 2_f64.powi(-19) * displaced + 2_f64.powi(-29) * lengths + 2_f64.powi(-29)
            + length * displaced * 2_f64.powi(-33) / 0.0015;
        let columns = |value: f64| error / share * (1.0 + value.abs() / 640.0) + 2_f64.powi(-20);
        let off = found.a.to_num::<f64>() - expected.a;
        prop_assert!(off.abs() <= columns(expected.a), "a {} {}", off, columns(expected.a));
        let off = found.s.to_num::<f64>() - expected.s;
        prop_assert!(off.abs() <= columns(expected.s), "s {} {}", off, columns(expected.s));
        let off = found.k.to_num::<f64>() - expected.k;
        let bound = error / (640.0 * share) * (1.0 + expected.k.abs()) + 2_f64.powi(-30);
        prop_assert!(off.abs() <= bound, "k {} {}", off, bound);
    }

    /// `SKEW-4` by the homographies as they are rounded.
    #[test]
    fn ends_shift_by_whole_pixels(
        (a, s, k) in (-240.0..240.0, 12.0..150.0, -0.5..0.5),
        (x, y, turn) in (-0.05..0.05, -0.05..0.05, -0.2..0.2),
    ) {
        let seen = view(Format::Paper, a, s, k);
        let Some(shift) = skew(x, y, turn).shift(&seen.homography(), &Camera::epuck(), &Landmark::paper()) else {
            return Ok(());
        };
        let Homography { a, s, k } = shift.added(&seen.homography()).unwrap();
        let carried = View { a: a.to_num(), s: s.to_num(), k: k.to_num(), ..seen };
        let ends = shift.of_ends(&seen.homography()).unwrap();
        for (found, t) in [(ends.first, -1.0), (ends.last, 1.0)] {
            let moved = carried.column(t) - seen.column(t);
            let place = moved + 0.5;
            prop_assume!((place - place.round()).abs() > 1e-8);
            prop_assert!((f64::from(found) - place.floor()).abs() < 0.5, "{} {}", found, moved);
        }
    }

    /// `SKEW-1`: arcs one after the other, as rotations about the points where the wheels' axles meet.
    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-1** The motion of the camera MUST be that of the robot through its mounting: MOTION-2 and MOTION-3 with
    //# `e = g = 0` over the readings between both times, a reading's steps taken in proportion to the part of its time.
    #[test]
    fn a_camera_moves_as_the_robot_does(
        readings in prop::collection::vec((-150.0..150.0, -150.0..150.0), 0..6),
        (ahead, left, mounted) in (-0.1..0.1, -0.1..0.1, -3.0..3.0),
    ) {
        let steps: Vec<_> = readings.iter().map(|&(left, right)| wheels(left, right)).collect();
        let mounting = skew(ahead, left, mounted);
        let mounting = Mounting::new(Length::from_num(ahead), Length::from_num(left), mounting.turn);
        let found = exact(&Skew::of_ways(steps.iter().copied(), &Drive::epuck(), &mounting, &Camera::epuck()));
        let (mut x, mut y, mut heading) = (0.0, 0.0, 0.0_f64);
        for ways in &steps {
            let [l, r] = [ways.left, ways.right].map(|steps| steps.to_num::<f64>() * PI * 0.041 / 1000.0);
            let turn = (r - l) / 0.053;
            if turn.abs() < 1e-6 {
                x += f64::midpoint(l, r) * (heading + turn / 2.0).cos();
                y += f64::midpoint(l, r) * (heading + turn / 2.0).sin();
            } else {
                let radius = f64::midpoint(l, r) / turn;
                x += radius * ((heading + turn).sin() - heading.sin());
                y -= radius * ((heading + turn).cos() - heading.cos());
            }
            heading += turn;
        }
        let (ahead, left) = (mounting.x.to_num::<f64>(), mounting.y.to_num::<f64>());
        let to_x = x + heading.cos() * ahead - heading.sin() * left - ahead;
        let to_y = y + heading.sin() * ahead + heading.cos() * left - left;
        let mounted = f64::from(mounting.theta.to_bits()) / 2_f64.powi(31) * PI;
        let expected = [
            mounted.cos() * to_x + mounted.sin() * to_y,
            mounted.cos() * to_y - mounted.sin() * to_x,
            heading - 2.0 * PI * (heading / (2.0 * PI)).round(),
        ];
        // The drive's axle is rounded by 2^-33 m, a turn of up to 0.36 rad a reading by as much over the axle; 0.1 m of lever.
        for (found, expected) in found.into_iter().zip(expected) {
            let off = (found - expected).abs();
            prop_assert!(off < 2e-8 || (off - 2.0 * PI).abs() < 2e-8, "{} {}", found, expected);
        }
    }

    /// `SKEW-5` in floating point, of any robot and camera, where that is not near a whole number.
    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-5** The *play* of a moving camera MUST be `T = ceil(5 f/b √(q (|l| + |r|) + u²/3))` pixels, with `q =
    //# 1e-6 m`, `u` of MOTION-1, the axle `b`, and `|l|` and `|r|` the sums of the lengths of the wheels' ways between
    //# both times; at rest it is 0.
    #[test]
    fn the_play_is_the_least_whole_number_that_is_enough(
        readings in prop::collection::vec((-400.0..400.0, -400.0..400.0), 0..6),
        (diameter, axle, steps) in (0.005..0.25, 0.02..0.8, 64_u16..),
        f in 240.0..2048.0,
    ) {
        use crate::formats::{FocalLength, WheelLength};
        let drive = Drive::new(WheelLength::from_num(diameter), WheelLength::from_num(axle), steps).unwrap();
        let camera = Camera::new(480, Column::from_num(239.5), FocalLength::from_num(f)).unwrap();
        let ways: Vec<_> = readings.iter().map(|&(left, right)| wheels(left, right)).collect();
        let found = Skew::of_ways(ways.iter().copied(), &drive, &mounted_ahead(), &camera).play;
        let u: f64 = PI * diameter / f64::from(steps);
        let length = |steps: Steps| u * steps.to_num::<f64>().abs();
        let all: f64 = ways.iter().map(|ways| length(ways.left) + length(ways.right)).sum();
        let real: f64 = if ways.is_empty() { 0.0 } else { 5.0 * f / axle * (1e-6_f64 * all + u * u / 3.0).sqrt() };
        // Diameter and axle are rounded by 2^-33 m, of 5 mm 2^-25; the focal length by 2^-17 px, of 240 px 2^-24.
        prop_assume!(ways.is_empty() || (real - real.round()).abs() > 2_f64.powi(-10) + real * 2_f64.powi(-23));
        prop_assert!((f64::from(found) - real.ceil()).abs() < 0.5, "{} {}", found, real);
    }

    /// At rest all of it is 0, and nothing changes anything, whatever the homography.
    #[test]
    fn nothing_is_shifted_at_rest(a in any::<i32>(), s in any::<i32>(), k in -(1_i32 << 29)..=1 << 29) {
        let seen = Homography { a: Column::from_bits(a), s: Column::from_bits(s), k: Obliquity::from_bits(k) };
        let shift = Skew::AT_REST.shift(&seen, &Camera::epuck(), &Landmark::paper());
        prop_assert_eq!(shift, Some(Shift::NONE));
        prop_assert_eq!(Shift::NONE.of_ends(&seen), Some(EndShifts::NONE));
        prop_assert_eq!((Shift::NONE.added(&seen), Shift::NONE.taken_off(&seen)), (Some(seen), seen));
    }
}

/// 100 steps of a wheel of 41 mm, 1000 to a turn: π 4.1 mm ahead, wherever the camera stands on the robot.
#[test]
fn a_robot_that_goes_straight_on_carries_its_camera_along() {
    let of = |ways: &[Ways]| Skew::of_ways(ways.iter().copied(), &Drive::epuck(), &mounted_ahead(), &Camera::epuck());
    let found = exact(&of(&[wheels(40.0, 40.0), wheels(60.0, 60.0)]));
    assert!((found[0] - PI * 0.0041).abs() < 1e-10 && found[1..] == [0.0, 0.0], "{found:?}");
    assert_eq!((of(&[wheels(0.0, 0.0); 3]), of(&[])), (Skew::AT_REST, Skew::AT_REST));
    // There and back, or by the least part of a step, it is not at rest.
    assert!(!of(&[wheels(1.0, 1.0), wheels(-1.0, -1.0)]).is_at_rest());
    assert!(!of(&[Ways { left: Steps::from_bits(-1), right: Steps::ZERO }]).is_at_rest());
}

/// On the spot, 3 cm ahead of the axle's middle: by φ along a circle, backwards by its height and to the left.
#[test]
fn a_robot_that_turns_on_the_spot_moves_its_camera_aside() {
    let [x, y, turn] =
        exact(&Skew::of_ways([wheels(-50.0, 50.0)], &Drive::epuck(), &mounted_ahead(), &Camera::epuck()));
    let expected = 2.0 * 50.0 * PI * 0.041 / 1000.0 / 0.053;
    assert!((turn - expected).abs() < 1e-8, "{turn} {expected}");
    let ahead = mounted_ahead().x.to_num::<f64>();
    assert!((x - ahead * (expected.cos() - 1.0)).abs() < 1e-9 && (y - ahead * expected.sin()).abs() < 1e-9);
}

/// `SKEW-3`, limit by limit. A barcode of `W` = 15 mm with s = 20 px is 0.48 m away.
//= reference/SPEC.md#skew
//= type=test
//# - **SKEW-3** A homography that is carried to `u'_x < 1/4`, `|k'| > 3/4`, `s' < N/4` or `s' <= a' k'` MUST be paired
//# with nothing.
#[test]
fn what_no_barcode_can_be_is_not_carried() {
    let straight = homography(0.0, 20.0, 0.0);
    // Four times nearer, 0.36 m.
    let near = carried(&straight, 0.359_99, 0.0, 0.0).unwrap();
    assert!((near.s.to_num::<f64>() - 80.0).abs() < 0.01);
    assert_eq!(carried(&straight, 0.360_01, 0.0, 0.0), None);
    assert_eq!(carried(&straight, 0.5, 0.0, 0.0), None);
    // Four times farther: 5 px is N/4.
    assert!(carried(&straight, -1.439_99, 0.0, 0.0).is_some());
    assert_eq!(carried(&straight, -1.440_01, 0.0, 0.0), None);
    // k = 1/2 with s = 100 px is at W/√(k² + s²/f²), and 3/4 a third nearer.
    for k in [0.5, -0.5] {
        let oblique = homography(0.0, 100.0, k);
        let depth = 0.015 / k.hypot(100.0 / 640.0);
        assert!(carried(&oblique, depth / 3.0 - 1e-6, 0.0, 0.0).is_some());
        assert_eq!(carried(&oblique, depth / 3.0 + 1e-6, 0.0, 0.0), None);
    }
    // The camera comes into the wall's plane where a' = f t_y/ρ is s/k, 100 px.
    let edge_on = homography(0.0, 40.0, 0.4);
    let depth = 0.015 / 0.4_f64.hypot(40.0 / 640.0);
    assert!(carried(&edge_on, 0.0, depth * 100.0 / 640.0 - 1e-6, 0.0).is_some());
    assert_eq!(carried(&edge_on, 0.0, depth * 100.0 / 640.0 + 1e-6, 0.0), None);
}

/// `SKEW-4`: halves up.
//= reference/SPEC.md#skew
//= type=test
//# - **SKEW-4** The *shift of an end* `t`, -1 for the first pixel and 1 for the last one, MUST be `c'(t) - c(t)` with
//# `c(t) = (a + s t)/(1 + k t)`, rounded to the nearest pixel, halves up.
#[test]
fn halves_of_a_pixel_are_rounded_up() {
    let seen = homography(10.0, 40.0, 0.0);
    let ends = |a: f64, s: f64| {
        let shift = Shift { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::ZERO };
        let EndShifts { first, last } = shift.of_ends(&seen).unwrap();
        (first, last)
    };
    assert_eq!((ends(1.5, 0.0), ends(-1.5, 0.0), ends(0.5, 1.0)), ((2, 2), (-1, -1), (0, 2)));
    assert_eq!(ends(1.499, 0.0), (1, 1));
}

/// `SKEW-5` by hand, of the e-puck: 26.2 mm of both wheels' ways are `5 · 640 √(2.62e-8 + 0.128805e-3²/3)/0.053` = 10.8 px, and hardly
/// any are `5 · 640 · 0.128805e-3/(√3 · 0.053)` = 4.5 px.
#[test]
fn the_play_of_a_robot_at_5_centimetres_a_second_is_11_pixels() {
    let play =
        |left, right| Skew::of_ways([wheels(left, right)], &Drive::epuck(), &mounted_ahead(), &Camera::epuck()).play;
    let half = 0.0131 / 0.128_805e-3;
    assert_eq!((play(half, half), play(half, -half), play(0.0, 2.0 * half)), (11, 11, 11));
    assert_eq!((play(0.01, 0.0), play(0.0, -0.01), play(0.0, 0.0)), (5, 5, 0));
}

/// No displacement and no homography overflow anything.
#[test]
fn the_farthest_displacements_are_refused_or_carried() {
    let ends = [i64::MIN, -(1 << 40), -1, 0, 1, 1 << 40, i64::MAX].map(Displacement::from_bits);
    let turns = [i32::MIN, -(1 << 30), -1, 1, i32::MAX].map(Angle::from_bits);
    let columns = [i32::MIN, -1, 0, 1 << 20, i32::MAX];
    let widest = Landmark::new(Format::Wide, crate::formats::StripeWidth::from_num(0.0005)).unwrap();
    let camera = Camera::new(640, Column::from_num(320), crate::formats::FocalLength::from_num(2048)).unwrap();
    for (x, y) in ends.into_iter().flat_map(|x| ends.map(|y| (x, y))) {
        for turn in turns {
            for (a, s) in columns.into_iter().flat_map(|a| columns.map(|s| (a, s))) {
                for k in columns {
                    let seen =
                        Homography { a: Column::from_bits(a), s: Column::from_bits(s), k: Obliquity::from_bits(k) };
                    let shift = Skew { x, y, turn, play: 0 }.shift(&seen, &camera, &widest);
                    let ends = shift.and_then(|shift| shift.of_ends(&seen));
                    assert!(shift.is_none_or(|shift| shift.added(&seen).is_some()) || ends.is_none());
                }
            }
        }
    }
}

/// `SKEW-3` at its bounds. The half width is 10 · 2^-7 m, so that 40 px of it are 512 px to the metre: from 640 px, the focal
/// length, 480 px are 15/16 m.
#[test]
fn a_camera_may_come_four_times_nearer() {
    let landmark = Landmark::new(Format::Paper, StripeWidth::from_num(1.0 / 128.0)).unwrap();
    let nearer = |bits| {
        let x = Displacement::from_bits(Displacement::from_num(15.0 / 16.0).to_bits() + bits);
        Skew { x, ..skew(0.0, 0.0, 0.0) }.carry(&homography(0.0, 40.0, 0.0), &Camera::epuck(), &landmark)
    };
    assert_eq!(Camera::epuck().focal_length(), 640);
    assert_eq!((nearer(0).map(|carried| carried.s), nearer(1 << 20)), (Some(Column::from_num(160)), None));
}

/// `SKEW-3`: `s > a k`, so that the columns grow.
#[test]
fn columns_of_a_barcode_grow() {
    let is_barcode = |a, s, k| is_barcode(&homography(a, s, k), &Landmark::paper());
    assert!(is_barcode(79.0, 40.0, 0.5) && !is_barcode(80.0, 40.0, 0.5) && !is_barcode(-80.0, 40.0, -0.5));
    assert!(is_barcode(0.0, 5.0, 0.75) && !is_barcode(0.0, 4.99, 0.0) && !is_barcode(0.0, 5.0, 0.7501));
}
