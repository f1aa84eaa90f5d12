//! Whole runs.

use super::*;
use crate::frame::{Point, wrap};
use crate::landmark::{Format, Landmark};
use crate::motion::{State, Ways, advance};
use crate::render::Posted;
use core::f64::consts::PI;

/// A corridor around an equilateral triangle of 1.2 m, 40 cm wide, with a landmark on the wall ahead at each corner.
fn triangle(laps: u32) -> Setup {
    let corner = |radius: f64, i: u32| {
        let angle = (f64::from(i) * 120.0 - 150.0).to_radians();
        Point::new(radius * angle.cos(), radius * angle.sin())
    };
    let radius = 1.2 / 3.0_f64.sqrt();
    let ring = |radius: f64| (0..3).map(move |i| Wall { from: corner(radius, i), to: corner(radius, i + 1) });
    // A triangle's sides are half its radius from its middle.
    let walls = ring(radius + 0.4).chain(ring(radius - 0.4)).collect();
    let landmark = Landmark::new(Format::Paper);
    let landmarks = (0..3).map(|i| {
        let (heading, end) = ((f64::from(i) * 120.0).to_radians(), corner(radius, i + 1));
        let ahead = 0.2 / (PI / 6.0).cos();
        let landmark_in_world =
            Pose::new(end.x + ahead * heading.cos(), end.y + ahead * heading.sin(), wrap(heading + 7.0 * PI / 6.0));
        Posted { landmark_in_world, landmark, payload: 0xcc0d + i }
    });
    let place = Place { walls, landmarks: landmarks.collect(), ..Place::default() };
    let points = (0..3).map(|i| corner(radius, i)).collect();
    Setup::new(place, Ride { points, laps, speed: 0.05, turn: 1.0, wander: 0.02 })
}

/// The same without images, which take the time.
fn blind(laps: u32) -> Setup {
    let mut setup = triangle(laps);
    setup.shutter.period = u64::MAX / 4;
    setup
}

/// Distance of a point from the route of [`triangle`], metres.
fn off_route(setup: &Setup, pose: &Pose<World, Robot>) -> f64 {
    let points = &setup.ride.points;
    let distance = |i: usize| {
        let (a, b) = (points[i], points[(i + 1) % 3]);
        let (along, length) = ([b.x - a.x, b.y - a.y], (b.x - a.x).hypot(b.y - a.y));
        let from = [pose.x() - a.x, pose.y() - a.y];
        let part = ((from[0] * along[0] + from[1] * along[1]) / length / length).clamp(0.0, 1.0);
        (from[0] - part * along[0]).hypot(from[1] - part * along[1])
    };
    (0..3).map(distance).fold(f64::INFINITY, f64::min)
}

/// Where a robot thinks it is that starts at the truth and knows its wheels.
fn dead_reckoning(setup: &Setup, recording: &Recording, wheels: &Wheels) -> Vec<Pose<World, Robot>> {
    let (wheel_difference, axle_excess) = (wheels.wheel_difference, wheels.axle_excess);
    let mut state = State { pose: setup.ride.begin(), wheel_difference, axle_excess };
    let step = setup.drive.step();
    let move_on = |reading: &Reading| {
        let ways = Ways { left: f64::from(reading.left) * step, right: f64::from(reading.right) * step };
        state = advance(&state, &ways, &setup.drive);
        state.pose
    };
    recording.readings.iter().map(move_on).collect()
}

/// The largest differences of position, metres, and heading, radians.
fn largest(found: &[Pose<World, Robot>], truth: &[Truth]) -> [f64; 2] {
    let apart = |(found, truth): (&Pose<World, Robot>, &Truth)| {
        let (x, y) = (found.x() - truth.pose.x(), found.y() - truth.pose.y());
        [x.hypot(y), wrap(found.theta() - truth.pose.theta()).abs()]
    };
    found.iter().zip(truth).map(apart).fold([0.0, 0.0], |most, one| [most[0].max(one[0]), most[1].max(one[1])])
}

//= reference/SPEC.md#world
//= type=test
//# - **WORLD-5** The pilot MUST command a speed and a turn rate for each tick, from the robot's true pose at its
//# beginning, until all laps are driven; the run ends with the next reading.
#[test]
fn the_robot_keeps_to_the_route() {
    let setup = blind(2);
    for number in 0..10 {
        let recording = setup.record(1, number).unwrap();
        // 15 mm of wander (see the pilot's tests), and slip; a corridor of 40 cm leaves 165 mm.
        let farthest = recording.truth.iter().map(|truth| off_route(&setup, &truth.pose)).fold(0.0, f64::max);
        assert!(farthest < 0.03 && farthest > 0.002, "{farthest}");
        // Six legs of 24 s, five corners of 2.4 s.
        let seconds = recording.truth.last().unwrap().time as f64 * 1e-6;
        assert!((seconds - 156.0).abs() < 2.0, "{seconds}");
    }
}

/// A wheel's steps lag less than a step behind: the heading is right to two of them over the axle, 4.9 mrad, as long as
/// nothing slips, and the position to that times the way, with 0.3 mm at a corner, where straight on and turn share a reading.
#[test]
fn odometry_of_known_wheels_is_right_but_for_the_steps() {
    let mut setup = blind(1);
    let [position, heading] = [3.6 * 4.9e-3 + 1e-3, 4.9e-3];
    setup.imperfections = Imperfections::none();
    let recording = setup.record(2, 0).unwrap();
    assert_eq!(recording.wheels, Wheels { wheel_difference: 0.0, axle_excess: 0.0, slip: 0.0 });
    let perfect = largest(&dead_reckoning(&setup, &recording, &recording.wheels), &recording.truth);
    assert!(perfect[0] < position && perfect[1] < heading, "{perfect:?}");

    setup.imperfections = Imperfections { slip: 0.0, ..Imperfections::default() };
    for number in 0..5 {
        let recording = setup.record(2, number).unwrap();
        let known = largest(&dead_reckoning(&setup, &recording, &recording.wheels), &recording.truth);
        assert!(known[0] < position && known[1] < heading, "{known:?}");
        // Not knowing them: e times the way over the axle, and g times two corners.
        let Wheels { wheel_difference: e, axle_excess: g, .. } = recording.wheels;
        let naive = Wheels { wheel_difference: 0.0, axle_excess: 0.0, slip: 0.0 };
        let found = dead_reckoning(&setup, &recording, &naive);
        let (last, truth) = (found.last().unwrap(), recording.truth.last().unwrap());
        let drift = wrap(truth.pose.theta() - last.theta());
        let turned = 4.0 * PI / 3.0;
        let expected = e * 3.6 / 0.053 - g * turned;
        // The truth turns by 240 degrees whatever the wheels; what they rolled for it is 1 + g times that.
        assert!((drift - expected).abs() < heading + 0.02 * expected.abs() + 0.01, "{drift} for {expected}");
    }
}

//= reference/SPEC.md#world
//= type=test
//# - **WORLD-22** A run MUST follow from its setup, a seed and its number alone, with random streams of their own for
//# the wheels, the ride, the noise, the disturbances and the carrying, so that a change of one leaves the others.
#[test]
fn the_same_seed_gives_the_same_run_in_any_thread() {
    let mut setup = triangle(1);
    setup.ride.points.truncate(2);
    setup.disturbance = Disturbance { occlusion: 0.1, false_decodes: 0.1 };
    let first = setup.record(3, 5).unwrap();
    let threads: Vec<_> = std::thread::scope(|scope| {
        let handles: Vec<_> = (4..7)
            .map(|number| {
                scope.spawn({
                    let setup = &setup;
                    move || setup.record(3, number).unwrap()
                })
            })
            .collect();
        handles.into_iter().map(|handle| handle.join().unwrap()).collect()
    });
    assert_eq!(first, threads[1]);
    assert!(first.wheels != threads[0].wheels && first.shots[0].lines != threads[0].shots[0].lines);
    assert_ne!(first.wheels, setup.record(4, 5).unwrap().wheels);
    // What disturbs an image leaves the ride as it is.
    setup.disturbance = Disturbance::default();
    let calm = setup.record(3, 5).unwrap();
    assert!(calm.truth == first.truth && calm.readings == first.readings && calm.start == first.start);
    assert_ne!(calm.shots, first.shots);
}

#[test]
fn events_come_in_the_order_in_which_they_are_known() {
    let mut setup = triangle(1);
    setup.shutter = Shutter { period: 230_000, capture: 90_000, processing: 110_000, exposure: 5_000 };
    let (mut last, mut readings, mut shots) = ((0, 0), 0_u64, 0_u64);
    for event in setup.run(1, 1).unwrap().take(400) {
        let now = match event {
            Event::Reading(reading, truth) => {
                readings += 1;
                assert_eq!((reading.time, truth.time), (readings * 100_000, readings * 100_000));
                (reading.time, 0)
            }
            Event::Shot(shot) => {
                let start = shots * 230_000;
                shots += 1;
                assert_eq!([shot.start, shot.end, shot.processed], [start, start + 90_000, start + 200_000]);
                (shot.processed, 1)
            }
        };
        assert!(last < now, "{last:?} before {now:?}");
        last = now;
    }
    assert!(readings > 200 && shots > 100);
}

/// Each corner's landmark is seen over the last quarter of its leg, and the images of the way show it.
#[test]
fn images_show_the_landmark_ahead() {
    let setup = triangle(1);
    let recording = setup.record(6, 0).unwrap();
    for landmark in 0..3 {
        let seen = recording.shots.iter().filter(|shot| shot.seen.iter().any(|seen| seen.landmark == landmark));
        let own = 0xcc0d + u32::try_from(landmark).unwrap();
        let shots: Vec<_> = seen.inspect(|shot| assert_eq!(shot.seen[0].payload, own)).collect();
        // From 67 cm to 20 cm before the camera at 2 cm an image: 23, and a few on the spot.
        assert!((18..32).contains(&shots.len()), "{}", shots.len());
        assert!(shots.iter().any(|shot| shot.lines.iter().all(|line| line.iter().any(|&pixel| pixel < 60))));
    }
    let nothing = recording.shots.iter().find(|shot| shot.seen.is_empty() && shot.start > 2_000_000).unwrap();
    assert!(nothing.lines.iter().flatten().all(|&pixel| pixel > 185), "7 standard deviations below white");
}

//= reference/SPEC.md#world
//= type=test
//# - **WORLD-20** A robot that is to be lifted MUST be lifted at the first tick at which the stated share of the ride's
//# legs is done, for a stated time in which no step is counted.
#[test]
fn a_lift_is_blind_and_deaf_and_ends_on_another_leg() {
    let mut setup = triangle(1);
    // Nine tenths of the first leg, where its landmark is seen from 32 cm.
    setup.lift = Some(Lift { at: 0.3, lasts: 1_000_000 });
    let recording = setup.record(8, 0).unwrap();
    let [Lifted { from, to }] = recording.lifts[..] else { panic!("{:?}", recording.lifts) };
    assert!(to - from == 1_000_000 && from.abs_diff(21_600_000) < 500_000, "{from}");
    let last = recording.shots.iter().rfind(|shot| shot.end <= from).unwrap();
    assert!(last.seen.len() == 1 && last.lines.iter().flatten().any(|&pixel| pixel < 100));
    let within = |time: u64| time > from && time < to;
    assert!(recording.truth.iter().all(|truth| truth.lifted == within(truth.time)));
    let still = recording.readings.iter().filter(|reading| reading.time >= from + READING_PERIOD && reading.time <= to);
    assert!(still.inspect(|reading| assert_eq!([reading.left, reading.right], [0, 0])).count() >= 9);
    let blank = recording.shots.iter().filter(|shot| shot.start >= from && shot.end <= to);
    let white = |shot: &&Shot| shot.seen.is_empty() && shot.lines.iter().flatten().all(|&pixel| pixel > 185);
    assert!(blank.inspect(|shot| assert!(white(shot))).count() >= 1);
    // Elsewhere, near the route, and on its way again.
    let truth = |time: u64| recording.truth.iter().find(|truth| truth.time >= time).unwrap().pose;
    let (before, after) = (truth(from - READING_PERIOD), truth(to));
    assert!((before.x() - after.x()).hypot(before.y() - after.y()) > 0.1);
    assert!(wrap(after.theta() - before.theta()).abs() > 1.5, "another leg's heading");
    assert!(off_route(&setup, &after) < 0.07);
    assert!(recording.readings.iter().any(|reading| reading.time > to + READING_PERIOD && reading.left > 30));
    // The legs are as many as before: the rest of the other one, and two more.
    let seconds = recording.truth.last().unwrap().time as f64 * 1e-6;
    assert!((85.0..99.0).contains(&seconds), "{seconds}");
}

//= reference/SPEC.md#world
//= type=test
//# - **WORLD-18** The robot MUST be told its start with a normal error, by default of 5 mm along x and y and of 0.02
//# rad, and these standard deviations.
//= reference/SPEC.md#world
//= type=test
//# - **WORLD-19** A start that is wrong MUST be 0.3 to 1 m farther away in any direction, with any heading, and be told
//# with the same standard deviations.
#[test]
fn the_robot_is_told_where_it_starts_more_or_less() {
    let mut setup = blind(0);
    let begin = setup.ride.begin();
    let starts: Vec<_> = (0..3000).map(|number| setup.run(9, number).unwrap().start()).collect();
    for axis in 0..3 {
        let deviate = |start: &Start| {
            let by = [start.pose.x() - begin.x(), start.pose.y() - begin.y(), wrap(start.pose.theta() - begin.theta())];
            by[axis] / [5e-3, 5e-3, 0.02][axis]
        };
        let square = starts.iter().map(|start| deviate(start).powi(2)).sum::<f64>() / 3000.0;
        // Four standard errors of a mean square.
        assert!((square - 1.0).abs() < 4.0 * (2.0_f64 / 3000.0).sqrt(), "axis {axis}: {square}");
    }
    setup.told = Told { sigma: [0.0; 3], wrong: true };
    let wrong: Vec<_> = (0..1000).map(|number| setup.run(9, number).unwrap().start().pose).collect();
    let far: Vec<f64> = wrong.iter().map(|pose| (pose.x() - begin.x()).hypot(pose.y() - begin.y())).collect();
    assert!(far.iter().all(|far| (0.3 - 1e-9..1.0).contains(far)) && far.iter().any(|&far| far > 0.95));
    let around = wrong.iter().filter(|pose| wrap(pose.theta() - begin.theta()).abs() > PI / 2.0).count();
    assert!(around.abs_diff(500) < 64, "half of the headings are backwards: {around}");
}

//= reference/SPEC.md#observe
//= type=test
//# - **OBSERVE-1** The camera MUST by default be mounted 3 cm ahead of the axle's middle, looking ahead.
#[test]
fn the_camera_is_three_centimetres_ahead() {
    let camera = Place::default().camera_in_robot;
    assert!((camera.x() - 0.03).abs() < 1e-15 && camera.y().abs() < 1e-15 && camera.theta().abs() < 1e-15);
}

#[test]
fn nonsense_is_refused() {
    let refusal = |change: fn(&mut Setup)| {
        let mut setup = triangle(1);
        change(&mut setup);
        setup.run(1, 1).unwrap_err()
    };
    assert!(matches!(refusal(|setup| setup.place.camera.width = 3), SetupRefusal::Camera(_)));
    assert!(matches!(refusal(|setup| setup.place.landmarks[1].payload = 1 << 16), SetupRefusal::Payload(_)));
    let ride: [fn(&mut Setup); 5] = [
        |setup| setup.ride.points.truncate(1),
        |setup| setup.ride.points[0] = setup.ride.points[2],
        |setup| setup.ride.speed = 0.0,
        |setup| setup.ride.turn = f64::NAN,
        |setup| setup.drive.axle = f64::INFINITY,
    ];
    assert!(ride.iter().all(|&change| refusal(change) == SetupRefusal::Ride));
    let shutter: [fn(&mut Setup); 5] = [
        |setup| setup.shutter.period = 399_999,
        |setup| setup.shutter.processing = u64::MAX,
        |setup| setup.shutter.capture = 0,
        |setup| setup.shutter.exposure = 37_501,
        |setup| setup.shutter.exposure = 0,
    ];
    assert!(shutter.iter().all(|&change| refusal(change) == SetupRefusal::Shutter));
    let shares: [fn(&mut Setup); 5] = [
        |setup| setup.disturbance.occlusion = 1.1,
        |setup| setup.disturbance.false_decodes = f64::NAN,
        |setup| setup.lift = Some(Lift { at: 1.0, lasts: 1 }),
        |setup| setup.imperfections.slip = -1.0,
        |setup| setup.told.sigma[2] = f64::INFINITY,
    ];
    assert!(shares.iter().all(|&change| refusal(change) == SetupRefusal::Share));
}
