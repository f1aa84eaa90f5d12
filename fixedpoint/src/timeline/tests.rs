#![allow(clippy::cast_possible_truncation)] // of numbers in range

use super::*;
use crate::camera::Camera;
use crate::covariance::PoseCovariance;
use crate::filter::Build;
use crate::formats::{Angle, Length, Steps};
use crate::frame::Pose;
use crate::landmark::Landmark;
use crate::motion::{Drive, MotionModel, SLIP_OF_THREE};
use crate::observation::{Seen, mounted_ahead};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::vec::Vec;

const MILLISECOND: u64 = 1_000;

fn ms(milliseconds: u64) -> Time {
    Time::from_micros(milliseconds * MILLISECOND)
}

fn pose<Parent, Child>([x, y, theta]: [f64; 3]) -> Pose<Parent, Child> {
    let angle = Angle::from_bits((theta / std::f64::consts::PI * 2_f64.powi(31)) as i32);
    Pose::new(Length::from_num(x), Length::from_num(y), angle)
}

fn variances([x, y, theta]: [f64; 3]) -> PoseCovariance {
    let variance = |deviation: f64| (deviation * deviation * 2_f64.powi(48)) as i64;
    PoseCovariance { xx: variance(x), yy: variance(y), tt: variance(theta), ..PoseCovariance::default() }
}

/// A robot at the world's origin.
fn filter() -> Filter {
    let build = Build {
        camera: Camera::epuck(),
        mounting: mounted_ahead(),
        drive: Drive::epuck(),
        model: MotionModel::Arc,
        slip: SLIP_OF_THREE,
    };
    Filter::new(build, State::new(&pose([0.0; 3]), &variances([0.01, 0.01, 0.05])))
}

fn timeline() -> Timeline {
    Timeline::new(filter(), ms(1_000))
}

/// 30 cm from a landmark that the world has at its origin, looking along x, and so much aside.
pub(super) fn observation(time: Time, image: u32, aside: f64) -> Observation {
    let sighting = Sighting {
        place: pose([0.33, 0.0, std::f64::consts::PI]),
        landmark: Landmark::paper(),
        pose: pose([0.3, aside, -3.1]),
        covariance: variances([0.004, 0.01, 0.03]),
        seen: Seen::Pose,
    };
    Observation { time, image, payload: 7, layer: MeasuredLayer::Upper, sighting }
}

fn reading(time: Time, left: i16, right: i16) -> Reading {
    Reading { time, left: left.into(), right: right.into() }
}

fn ways(left: f64, right: f64) -> Ways {
    Ways { left: Steps::from_num(left), right: Steps::from_num(right) }
}

/// TIME-1 to TIME-4 as they are written, of everything at once: the filter of all readings and of what these reach.
fn in_order(begin: Time, readings: &[Reading], observations: &[Observation]) -> Filter {
    let (mut readings, mut observations) = (readings.to_vec(), observations.to_vec());
    readings.sort_by_key(|reading| reading.time);
    observations.sort_by_key(|seen| (seen.time, seen.image, seen.format() == Format::Wide, seen.payload, seen.layer));
    let mut filter = filter();
    let mut waiting = observations.into_iter().peekable();
    let mut from = begin;
    for Reading { time, left, right } in readings {
        let all = i128::from(time.as_micros() - from.as_micros());
        let made = |steps: Steps, at: Time| {
            let passed = i128::from(at.as_micros() - from.as_micros());
            ((2 * i128::from(steps.to_bits()) * passed + all).div_euclid(2 * all)) as i32
        };
        let part = |steps, from, to| Steps::from_bits(made(steps, to) - made(steps, from));
        let mut at = from;
        while let Some(seen) = waiting.next_if(|seen| seen.time <= time) {
            filter.predict(&Ways { left: part(left, at, seen.time), right: part(right, at, seen.time) });
            filter.observe(&seen.sighting, seen.image);
            at = seen.time;
        }
        filter.predict(&Ways { left: part(left, at, time), right: part(right, at, time) });
        from = time;
    }
    filter
}

#[derive(Clone, Copy, Debug)]
enum Item {
    Reading(Reading),
    Observation(Observation),
}

impl Item {
    fn time(&self) -> Time {
        match self {
            Self::Reading(reading) => reading.time,
            Self::Observation(observation) => observation.time,
        }
    }

    fn give(&self, timeline: &mut Timeline) -> Result<(), Untimely> {
        match self {
            Self::Reading(reading) => timeline.read(reading),
            Self::Observation(observation) => timeline.observe(observation).map(|_| ()),
        }
    }
}

/// Six seconds of a drive: as many readings and observations as the queue has room for, some observations at a reading's
/// time or two of one time, some of them far off.
fn drive(random: &mut ChaCha8Rng) -> (Vec<Reading>, Vec<Observation>) {
    let mut readings = Vec::new();
    let mut at = 1_000 * MILLISECOND;
    while at < 7_000 * MILLISECOND {
        at += random.random_range(120 * MILLISECOND..250 * MILLISECOND);
        let steps = random.random_range(-200..200);
        readings.push(reading(Time::from_micros(at), steps + random.random_range(-9..9), steps));
    }
    let mut observations = Vec::new();
    let (mut at, mut image) = (1_000 * MILLISECOND, 0);
    loop {
        at += random.random_range(470 * MILLISECOND..700 * MILLISECOND);
        let meets = readings.iter().map(|reading| reading.time.as_micros()).find(|&time| time >= at);
        let Some(met) = meets else { break };
        if random.random_bool(0.3) && met < at + 20 * MILLISECOND {
            at = met;
        }
        image += u32::from(random.random_bool(0.8));
        let aside = random.random_range(-0.02..0.02) + if random.random_bool(0.3) { 0.5 } else { 0.0 };
        let seen = observation(Time::from_micros(at), image, aside);
        observations.push(seen);
        if random.random_bool(0.4) {
            let mut other = observation(seen.time, seen.image, aside + random.random_range(-0.02..0.02));
            match random.random_range(0..4) {
                0 => other.layer = MeasuredLayer::Lower,
                1 => other.payload = 6,
                2 => other.sighting.landmark = Landmark::wide(),
                _ => other.image += 1,
            }
            observations.push(other);
        }
    }
    (readings, observations)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// TIME-5, to the last bit, against TIME-1 to TIME-4 in the order of time; what comes again is refused.
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-5** What comes late MUST have the same effect as if it had come in order, if its time is after the
    //# newest reading's less 600 ms.
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-8** A reading of the time of one in the queue, and an observation of the time, image, format, payload
    //# and layer of one in the queue, MUST be refused (`Duplicate`), whatever it says.
    #[test]
    fn what_comes_late_has_the_same_effect_as_in_order(seed in any::<u64>()) {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let (readings, observations) = drive(random);
        let items = readings.iter().copied().map(Item::Reading).chain(observations.iter().copied().map(Item::Observation));
        let mut arrivals: Vec<(u64, Item)> =
            items.map(|item| (item.time().as_micros() + random.random_range(0..600 * MILLISECOND), item)).collect();
        arrivals.sort_by_key(|(arrival, _)| *arrival);
        let mut timeline = timeline();
        let mut repeated = 0;
        for (_, item) in &arrivals {
            prop_assert_eq!(item.give(&mut timeline), Ok(()));
            if repeated == 0 || random.random_bool(0.2) {
                let before = timeline.clone();
                prop_assert!(item.give(&mut timeline).is_err());
                repeated += 1;
                timeline.refused = before.refused;
                prop_assert_eq!(&timeline, &before);
            }
        }
        let expected = in_order(ms(1_000), &readings, &observations);
        prop_assert_eq!(timeline.estimate(), expected.state());
        prop_assert_eq!(timeline.counts(), Counts { filter: expected.counts(), ..Counts::default() });
        prop_assert_eq!(timeline.time(), readings.last().unwrap().time);
    }
}

/// TIME-10, of anything: the time does not decrease, and what is refused changes nothing but its counter.
//= reference/SPEC.md#time
//= type=test
//# - **TIME-10** What is refused MUST change nothing but its counter, and the estimate's time never decrease: while a
//# clock that was set back has not caught up, everything is late.
#[test]
fn what_is_refused_changes_one_counter() {
    let mut in_all = [0; 3];
    for seed in 0..200 {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let mut timeline = timeline();
        let mut refused = [0; 3];
        for image in 0..150 {
            let latest = timeline.time().as_micros();
            let time = Time::from_micros(latest + 400 * MILLISECOND - random.random_range(0..20) * 50 * MILLISECOND);
            let item = if random.random_bool(0.5) {
                Item::Reading(reading(time, random.random_range(-99..99), random.random_range(-99..99)))
            } else {
                Item::Observation(observation(time, image / 20, random.random_range(-0.02..0.02)))
            };
            let before = timeline.clone();
            if let Err(why) = item.give(&mut timeline) {
                let reasons = [Untimely::Late, Untimely::Duplicate, Untimely::Full];
                refused[reasons.iter().position(|reason| *reason == why).unwrap()] += 1;
                let unchanged = Timeline { refused: before.refused, ..timeline.clone() };
                assert_eq!(unchanged, before);
            }
            assert!(timeline.time() >= before.time());
            let Counts { late, duplicate, full, .. } = timeline.counts();
            assert_eq!([late, duplicate, full], refused);
        }
        for (in_all, refused) in in_all.iter_mut().zip(refused) {
            *in_all += refused;
        }
    }
    assert!(in_all.iter().all(|&refused| refused > 0), "{in_all:?}");
}

/// 10 and 20 steps in 100 ms, seen after 40 of them: 4 and 8 steps before it, 6 and 12 after it, exact in binary.
#[test]
fn an_observation_parts_the_steps_of_a_reading() {
    let mut timeline = timeline();
    timeline.read(&reading(ms(1_100), 5, 5)).unwrap();
    timeline.read(&reading(ms(1_200), 10, 20)).unwrap();
    let seen = observation(ms(1_140), 0, 0.01);
    assert_eq!(timeline.observe(&seen), Ok(Some(Outcome::Used)));
    let mut expected = filter();
    expected.predict(&ways(5.0, 5.0));
    expected.predict(&ways(4.0, 8.0));
    expected.observe(&seen.sighting, 0);
    expected.predict(&ways(6.0, 12.0));
    assert_eq!(timeline.estimate(), expected.state());
    // Not what it would be at either end.
    let elsewhere = |parts: [f64; 2]| {
        let mut filter = filter();
        filter.predict(&ways(5.0, 5.0));
        filter.predict(&ways(parts[0], 2.0 * parts[0]));
        filter.observe(&seen.sighting, 0);
        filter.predict(&ways(parts[1], 2.0 * parts[1]));
        *filter.state()
    };
    assert!(*timeline.estimate() != elsewhere([0.0, 10.0]) && *timeline.estimate() != elsewhere([10.0, 0.0]));
}

/// TIME-2: the reading first.
#[test]
fn an_observation_at_a_reading_s_time_comes_after_its_steps() {
    let seen = observation(ms(1_100), 0, 0.01);
    let mut expected = filter();
    expected.predict(&ways(50.0, 60.0));
    expected.observe(&seen.sighting, 0);
    let mut after = timeline();
    after.read(&reading(ms(1_100), 50, 60)).unwrap();
    assert_eq!(after.observe(&seen), Ok(Some(Outcome::Used)));
    let mut before = timeline();
    assert_eq!(before.observe(&seen), Ok(None));
    before.read(&reading(ms(1_100), 50, 60)).unwrap();
    assert_eq!((after.estimate(), before.estimate()), (expected.state(), expected.state()));
}

/// An observation half a metre off before and after one that agrees.
#[test]
fn an_outcome_is_that_of_the_observation_which_was_given() {
    let mut timeline = timeline();
    timeline.read(&reading(ms(1_200), 50, 60)).unwrap();
    assert_eq!(timeline.observe(&observation(ms(1_100), 1, 0.01)), Ok(Some(Outcome::Used)));
    assert_eq!(timeline.observe(&observation(ms(1_050), 0, 0.5)), Ok(Some(Outcome::Gated)));
    assert_eq!(timeline.observe(&observation(ms(1_150), 2, 0.5)), Ok(Some(Outcome::Gated)));
    assert_eq!(timeline.observe(&observation(ms(1_060), 3, 0.01)), Ok(Some(Outcome::Used)));
}

/// TIME-4: the estimate stays that of the newest reading's time.
//= reference/SPEC.md#time
//= type=test
//# - **TIME-4** The estimate MUST be that of the newest reading's time; an observation after it waits for the reading
//# that reaches it.
#[test]
fn an_observation_waits_for_the_reading_that_reaches_it() {
    let mut timeline = timeline();
    timeline.read(&reading(ms(1_100), 50, 60)).unwrap();
    let before = *timeline.estimate();
    assert_eq!(timeline.observe(&observation(ms(1_150), 0, 0.01)), Ok(None));
    assert_eq!((*timeline.estimate(), timeline.time()), (before, ms(1_100)));
    timeline.read(&reading(ms(1_149), 1, 1)).unwrap();
    assert_eq!(timeline.counts().filter.used, 0);
    timeline.read(&reading(ms(1_200), 50, 60)).unwrap();
    assert_eq!((timeline.counts().filter.used, timeline.time()), (1, ms(1_200)));
}

/// TIME-2: image, format, payload, layer; each pair given the wrong way round.
//= reference/SPEC.md#time
//= type=test
//# - **TIME-2** Readings and observations MUST have the effect of being taken in the order of their times, a reading
//# before the observations of its own time, and observations of one time by their image, then their format (`paper`
//# first), payload and layer (upper, lower, both).
#[test]
fn observations_of_one_time_have_an_order() {
    let first = observation(ms(1_100), 3, 0.01);
    let later = |change: fn(&mut Observation)| {
        let mut other = observation(ms(1_100), 3, -0.01);
        change(&mut other);
        other
    };
    let others = [
        later(|other| {
            other.image = 4;
            other.payload = 0;
        }),
        later(|other| {
            other.sighting.landmark = Landmark::wide();
            other.payload = 0;
        }),
        later(|other| other.payload = 8),
        later(|other| other.layer = MeasuredLayer::Lower),
        later(|other| other.layer = MeasuredLayer::Both),
    ];
    for other in others {
        let in_this_order = |seen: [&Observation; 2]| {
            let mut filter = filter();
            filter.predict(&ways(50.0, 60.0));
            for seen in seen {
                filter.observe(&seen.sighting, seen.image);
            }
            *filter.state()
        };
        let mut timeline = timeline();
        timeline.observe(&other).unwrap();
        timeline.read(&reading(ms(1_100), 50, 60)).unwrap();
        timeline.observe(&first).unwrap();
        assert_eq!(*timeline.estimate(), in_this_order([&first, &other]));
        assert_ne!(*timeline.estimate(), in_this_order([&other, &first]));
    }
}

/// TIME-6 and TIME-7: a reading exactly 600 ms older is settled, one that is younger is not.
//= reference/SPEC.md#time
//= type=test
//# - **TIME-6** What is no longer needed for TIME-5 MUST be *settled*: whenever the newest reading changes, all
//# readings that are at least 600 ms older than it, and the observations up to the last of these.
//= reference/SPEC.md#time
//= type=test
//# - **TIME-7** A reading or an observation that is not after what is settled, or after the timeline's begin where
//# nothing is, MUST be refused (`Late`).
#[test]
fn what_is_600_milliseconds_old_is_settled() {
    let [settled, open] = [0, 1].map(|micros| {
        let mut timeline = timeline();
        timeline.read(&reading(ms(1_100), 1, 1)).unwrap();
        timeline.read(&reading(Time::from_micros(1_200_000 + micros), 1, 1)).unwrap();
        timeline.read(&reading(ms(1_800), 1, 1)).unwrap();
        timeline
    });
    let at = Time::from_micros(1_150_000);
    let mut closed = settled.clone();
    assert_eq!(closed.observe(&observation(at, 0, 0.0)), Err(Untimely::Late));
    assert_eq!(closed.observe(&observation(ms(1_200), 0, 0.0)), Err(Untimely::Late));
    assert_eq!(closed.read(&reading(ms(1_200), 1, 1)), Err(Untimely::Late));
    assert!(closed.observe(&observation(Time::from_micros(1_200_001), 0, 0.0)).is_ok());
    let mut still = open;
    assert!(still.observe(&observation(at, 0, 0.0)).is_ok());
    // Older than 600 ms, but after what is settled: it stays open until the newest reading changes.
    assert!(still.read(&reading(ms(1_101), 1, 1)).is_ok());
    assert_eq!(still.read(&reading(ms(1_101), 1, 1)), Err(Untimely::Duplicate));
    still.read(&reading(ms(1_801), 0, 0)).unwrap();
    assert_eq!(still.read(&reading(ms(1_101), 1, 1)), Err(Untimely::Late));
}

/// TIME-9 of readings: sixteen in 400 ms, and one more settles the first one, unless it would then be late.
#[test]
fn a_full_queue_of_readings_settles_the_earliest() {
    let mut full = timeline();
    for i in 1..=16 {
        full.read(&reading(ms(1_000 + 25 * i), 3, 4)).unwrap();
    }
    let before = full.clone();
    assert_eq!(full.read(&reading(ms(1_024), 3, 4)), Err(Untimely::Late));
    assert_eq!(full.observe(&observation(ms(1_024), 0, 0.0)).map(|_| ()), Ok(()));
    let mut full = before;
    full.read(&reading(ms(1_026), 3, 4)).unwrap();
    assert_eq!(full.observe(&observation(ms(1_024), 0, 0.0)), Err(Untimely::Late));
    assert_eq!(full.observe(&observation(ms(1_026), 0, 0.0)), Ok(Some(Outcome::Used)));
    assert_eq!(full.counts(), Counts { filter: full.current.counts(), late: 1, ..Counts::default() });
}

/// TIME-9 of observations: the second reading is the first that takes one along.
//= reference/SPEC.md#time
//= type=test
//# - **TIME-9** The queue MUST hold 16 readings and 8 observations, where there is no room the earliest readings and
//# the observations up to these being settled one after the other until there is, except the newest one, and what would
//# then be late, or finds no room even so, being refused (`Late`, `Full`).
#[test]
fn a_full_queue_of_observations_settles_readings_up_to_the_first_of_them() {
    let mut timeline = timeline();
    for i in 1..=5 {
        timeline.read(&reading(ms(1_000 + 100 * i), 3, 4)).unwrap();
    }
    for i in 0..8 {
        timeline.observe(&observation(ms(1_150 + 10 * i), u32::try_from(i).unwrap(), 0.0)).unwrap();
    }
    // Six of the eight are up to 1200 ms, which has to be settled: 1199 ms would be late then.
    let before = timeline.clone();
    assert_eq!(timeline.observe(&observation(ms(1_199), 9, 0.0)), Err(Untimely::Late));
    assert_eq!(timeline.queue, before.queue);
    assert_eq!(timeline.observe(&observation(ms(1_200), 9, 0.0)), Err(Untimely::Late));
    assert_eq!(timeline.observe(&observation(ms(1_201), 9, 0.0)), Ok(Some(Outcome::Used)));
    assert_eq!((timeline.queue.begin(), timeline.settled.counts().used), (ms(1_200), 6));
    assert_eq!(timeline.counts().filter.used, 9);
}

/// TIME-9: nothing can be settled that would make room, be it that all wait or that the newest reading alone reaches them.
#[test]
fn a_full_queue_that_cannot_be_settled_refuses() {
    for (newest, in_the_end) in [(1_050, Err(Untimely::Full)), (1_300, Ok(None))] {
        let mut timeline = timeline();
        timeline.read(&reading(ms(1_010), 3, 4)).unwrap();
        timeline.read(&reading(ms(newest), 3, 4)).unwrap();
        for image in 0..8 {
            timeline.observe(&observation(ms(1_100), image, 0.0)).unwrap();
        }
        let before = timeline.clone();
        assert_eq!(timeline.observe(&observation(ms(1_100), 8, 0.0)), Err(Untimely::Full));
        assert_eq!(timeline.observe(&observation(ms(1_100), 7, 0.0)), Err(Untimely::Duplicate));
        // Were the first reading settled in vain, this would be late.
        assert_eq!(timeline.observe(&observation(ms(1_010), 8, 0.0)), Err(Untimely::Late));
        assert_eq!((timeline.counts().full, timeline.counts().duplicate, timeline.counts().late), (1, 1, 1));
        timeline.refused = before.refused;
        assert_eq!(timeline, before);
        // Once there is a newer reading, that at 1300 ms can be settled, and the observations with it.
        timeline.read(&reading(ms(1_400), 3, 4)).unwrap();
        assert_eq!(timeline.observe(&observation(ms(1_450), 8, 0.0)), in_the_end);
    }
}

/// TIME-10: a clock that loses a second.
#[test]
fn a_clock_that_was_set_back_is_late_until_it_has_caught_up() {
    let mut timeline = timeline();
    for i in 1..=20 {
        timeline.read(&reading(ms(1_000 + 100 * i), 3, 4)).unwrap();
    }
    let before = *timeline.estimate();
    for i in 11..=14 {
        assert_eq!(timeline.read(&reading(ms(100 * i), 3, 4)), Err(Untimely::Late));
    }
    assert_eq!((*timeline.estimate(), timeline.time(), timeline.counts().late), (before, ms(3_000), 4));
    timeline.read(&reading(ms(3_100), 3, 4)).unwrap();
    assert_eq!(timeline.time(), ms(3_100));
}

/// TIME-11: set back by two seconds, on demand.
//= reference/SPEC.md#time
//= type=test
//# - **TIME-11** A timeline MUST be restarted on demand at a given time: everything is settled, observations that still
//# wait are dropped and counted, and times count from the given one.
#[test]
fn a_restart_keeps_the_estimate_and_counts_times_anew() {
    let mut timeline = timeline();
    timeline.read(&reading(ms(3_000), 30, 40)).unwrap();
    timeline.observe(&observation(ms(2_900), 0, 0.01)).unwrap();
    timeline.observe(&observation(ms(3_100), 1, 0.01)).unwrap();
    let (estimate, used) = (*timeline.estimate(), timeline.counts().filter.used);
    timeline.restart(ms(1_500));
    assert_eq!((*timeline.estimate(), timeline.time()), (estimate, ms(1_500)));
    assert_eq!((timeline.counts().dropped, timeline.counts().filter.used), (1, used));
    assert_eq!(timeline.observe(&observation(ms(1_500), 2, 0.01)), Err(Untimely::Late));
    // 8 and 12 steps from 1500 ms on, parted in the middle.
    let seen = observation(ms(1_550), 2, 0.01);
    let mut expected = timeline.current;
    expected.predict(&ways(4.0, 6.0));
    expected.observe(&seen.sighting, 2);
    expected.predict(&ways(4.0, 6.0));
    // Late, so that it begins with what was settled.
    timeline.read(&reading(ms(1_600), 8, 12)).unwrap();
    timeline.observe(&seen).unwrap();
    assert_eq!(timeline.estimate(), expected.state());
}

/// A quarter of the first reading's steps, all of the second one's, half of the third one's; nothing beyond the readings.
#[test]
fn ways_between_two_times_are_parts_of_readings() {
    let mut timeline = timeline();
    for (time, steps) in [(1_100, 8), (1_200, 20), (1_300, 10)] {
        timeline.read(&reading(ms(time), steps, -steps)).unwrap();
    }
    let between = |from, to| timeline.ways_between(from, to).collect::<Vec<_>>();
    let expected = |parts: &[f64]| parts.iter().map(|&steps| ways(steps, -steps)).collect::<Vec<_>>();
    assert_eq!(between(ms(1_075), ms(1_250)), expected(&[2.0, 20.0, 5.0]));
    assert_eq!(between(ms(0), ms(9_000)), expected(&[8.0, 20.0, 10.0]));
    assert_eq!(between(ms(1_225), ms(1_250)), expected(&[2.5]));
    assert!(between(ms(1_250), ms(1_225)).is_empty() && between(ms(1_250), ms(1_250)).is_empty());
    assert!(between(ms(1_300), ms(1_400)).is_empty() && between(ms(900), ms(1_000)).is_empty());
}

/// The filters, 16 readings and 8 observations, and a word or two for what counts and orders them.
#[test]
fn its_memory_is_that_of_its_parts() {
    let parts = 2 * size_of::<Filter>() + 16 * size_of::<Reading>() + 8 * size_of::<Observation>();
    assert!(size_of::<Timeline>() <= parts + size_of::<Counts>() + 4 * size_of::<u64>());
    assert_eq!(size_of::<Reading>(), 16);
}
