//! The order in which a filter takes what has happened (TIME).

use crate::exposure::Time;
use crate::filter::{self, Estimate, Filter, Outcome};
use crate::landmark::Format;
use crate::layers::Part;
use crate::motion::Ways;
use crate::observation::Sighting;
use core::fmt;

/// How late something may come, microseconds (TIME-5).
pub const LATENESS: u64 = 600_000;

/// Readings that the queue holds (TIME-9).
pub const READINGS: usize = 16;

/// Observations that the queue holds (TIME-9).
pub const OBSERVATIONS: usize = 8;

/// What the wheels did since the reading before it in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// When it was read.
    pub time: Time,
    /// The ways of both wheels since then.
    pub ways: Ways,
}

/// What was seen of one landmark at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// When.
    pub time: Time,
    /// In which image.
    pub image: u64,
    /// The landmark's format and payload.
    pub landmark: (Format, u32),
    /// Of what it was made.
    pub part: Part,
    /// What was seen.
    pub sighting: Sighting,
}

impl Observation {
    /// The order of observations, and what makes two of them the same (TIME-2, TIME-8).
    //= reference/SPEC.md#time
    //# - **TIME-8** A reading of the time of one in the queue, and an observation of the time, image, format, payload
    //# and layer of one in the queue, MUST be refused (`Duplicate`), whatever it says.
    fn key(&self) -> (Time, u64, bool, u32, Part) {
        let (format, payload) = self.landmark;
        (self.time, self.image, format == Format::Wide, payload, self.part)
    }
}

/// Why something was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Untimely {
    /// TIME-7
    Late,
    /// TIME-8
    Duplicate,
    /// TIME-9
    Full,
}

impl fmt::Display for Untimely {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Late => "it is from before what is settled",
            Self::Duplicate => "it is there already",
            Self::Full => "the queue is full",
        })
    }
}

impl core::error::Error for Untimely {}

/// How often what became of readings and observations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// What the filter did.
    pub filter: filter::Counts,
    /// Refused as late.
    pub late: u64,
    /// Refused as duplicates.
    pub duplicate: u64,
    /// Refused for want of room.
    pub full: u64,
    /// Observations that no reading reached before a restart.
    pub dropped: u64,
}

/// A filter and what it has been or will be given, in order.
#[derive(Clone, Debug)]
pub struct Timeline {
    /// After everything up to the settled time.
    settled: Filter,
    settled_time: Time,
    /// After everything in the queue that a reading has reached.
    current: Filter,
    readings: Vec<Reading>,
    observations: Vec<Observation>,
    counts: Counts,
}

impl Timeline {
    /// A timeline that begins with a filter at a time.
    #[must_use]
    pub fn new(filter: Filter, begin: Time) -> Self {
        Self {
            settled: filter.clone(),
            settled_time: begin,
            current: filter,
            readings: Vec::new(),
            observations: Vec::new(),
            counts: Counts::default(),
        }
    }

    /// The estimate at the newest reading's time (TIME-4).
    //= reference/SPEC.md#time
    //# - **TIME-4** The estimate MUST be that of the newest reading's time; an observation after it waits for the
    //# reading that reaches it.
    #[must_use]
    pub fn estimate(&self) -> &Estimate {
        self.current.estimate()
    }

    /// The newest reading's time, or the one at which the timeline began (TIME-4, TIME-10).
    #[must_use]
    pub fn time(&self) -> Time {
        self.readings.last().map_or(self.settled_time, |reading| reading.time)
    }

    /// What became of everything so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts { filter: self.current.counts(), ..self.counts }
    }

    /// The wheels were read (TIME-1 to TIME-10).
    //= reference/SPEC.md#time
    //# - **TIME-10** What is refused MUST change nothing but its counter, and the estimate's time never decrease: while
    //# a clock that was set back has not caught up, everything is late.
    pub fn read(&mut self, reading: &Reading) -> Result<(), Untimely> {
        let result = self.take_reading(reading);
        self.count(result.err());
        result
    }

    /// A landmark was seen: what became of it, `None` while it waits for a reading (TIME-2 to TIME-10).
    //= reference/SPEC.md#time
    //# - **TIME-5** What comes late MUST have the same effect as if it had come in order, if its time is after the
    //# newest reading's less 600 ms.
    //= reference/SPEC.md#time
    //# - **TIME-7** A reading or an observation that is not after what is settled, or after the timeline's begin where
    //# nothing is, MUST be refused (`Late`).
    pub fn observe(&mut self, observation: &Observation) -> Result<Option<Outcome>, Untimely> {
        let result = self.take_observation(observation);
        self.count(result.err());
        result
    }

    /// Begins again at a time, with the estimate as it is (TIME-11).
    //= reference/SPEC.md#time
    //# - **TIME-11** A timeline MUST be restarted on demand at a given time: everything is settled, observations that
    //# still wait are dropped and counted, and times count from the given one.
    pub fn restart(&mut self, time: Time) {
        let newest = self.time();
        let waiting = self.observations.iter().filter(|observation| observation.time > newest).count();
        self.counts.dropped += waiting as u64;
        self.readings.clear();
        self.observations.clear();
        self.settled = self.current.clone();
        self.settled_time = time;
    }

    /// The ways of the wheels from one time to another, reading by reading, as far as the readings reach (SKEW-1, LOCATE-6).
    //= reference/SPEC.md#locate
    //# - **LOCATE-6** The skew MUST be that of the readings the timeline holds; where they do not reach back to the
    //# upper row's time or on to the lower row's, it counts as at rest for what is missing.
    #[must_use]
    pub fn ways_between(&self, from: Time, to: Time) -> Vec<Ways> {
        let mut begin = self.settled_time;
        let mut ways = Vec::new();
        for reading in &self.readings {
            let (first, last) = (begin.max(from), reading.time.min(to));
            if first < last {
                ways.push(part(&reading.ways, last.since(first), reading.time.since(begin)));
            }
            begin = reading.time;
        }
        ways
    }

    fn count(&mut self, refused: Option<Untimely>) {
        match refused {
            Some(Untimely::Late) => self.counts.late += 1,
            Some(Untimely::Duplicate) => self.counts.duplicate += 1,
            Some(Untimely::Full) => self.counts.full += 1,
            None => {}
        }
    }

    fn take_reading(&mut self, reading: &Reading) -> Result<(), Untimely> {
        if reading.time <= self.settled_time {
            return Err(Untimely::Late);
        }
        if self.readings.iter().any(|other| other.time == reading.time) {
            return Err(Untimely::Duplicate);
        }
        if self.readings.len() == READINGS {
            if reading.time <= self.readings[0].time {
                return Err(Untimely::Late);
            }
            self.settle_next();
        }
        let is_newest = reading.time > self.time();
        let place = self.readings.partition_point(|other| other.time < reading.time);
        self.readings.insert(place, *reading);
        // TIME-6: a reading that comes late settles nothing, however old it is.
        while is_newest && self.readings.first().is_some_and(|first| self.time().since(first.time) >= LATENESS) {
            self.settle_next();
        }
        self.replay(None);
        Ok(())
    }

    fn take_observation(&mut self, observation: &Observation) -> Result<Option<Outcome>, Untimely> {
        if observation.time <= self.settled_time {
            return Err(Untimely::Late);
        }
        if self.observations.iter().any(|other| other.key() == observation.key()) {
            return Err(Untimely::Duplicate);
        }
        if self.observations.len() == OBSERVATIONS {
            let settles = self.frees_observations();
            // If nothing makes room, all but the newest reading would be settled for it.
            let settled = settles.unwrap_or_else(|| self.readings.len().saturating_sub(1));
            if self.readings[..settled].last().is_some_and(|reading| observation.time <= reading.time) {
                return Err(Untimely::Late);
            }
            (0..settles.ok_or(Untimely::Full)?).for_each(|_| self.settle_next());
        }
        let place = self.observations.partition_point(|other| other.key() < observation.key());
        self.observations.insert(place, observation.clone());
        Ok(self.replay(Some(place)))
    }

    /// How many readings have to be settled before the earliest observation is; `None` if the newest one would (TIME-9).
    //= reference/SPEC.md#time
    //# - **TIME-9** The queue MUST hold 16 readings and 8 observations, where there is no room the earliest readings
    //# and the observations up to these being settled one after the other until there is, except the newest one, and
    //# what would then be late, or finds no room even so, being refused (`Late`, `Full`).
    fn frees_observations(&self) -> Option<usize> {
        let earliest = self.observations.first()?.time;
        let before = self.readings.partition_point(|reading| reading.time < earliest);
        (before + 1 < self.readings.len()).then_some(before + 1)
    }

    /// Settles the earliest reading and the observations up to it (TIME-6, TIME-9).
    //= reference/SPEC.md#time
    //# - **TIME-6** What is no longer needed for TIME-5 MUST be *settled*: whenever the newest reading changes, all
    //# readings that are at least 600 ms older than it, and the observations up to the last of these.
    fn settle_next(&mut self) {
        let reading = self.readings.remove(0);
        let up_to = self.observations.partition_point(|observation| observation.time <= reading.time);
        let observations: Vec<Observation> = self.observations.drain(..up_to).collect();
        run(&mut self.settled, self.settled_time, &reading, &observations);
        self.settled_time = reading.time;
    }

    /// Takes the queue anew from what is settled; what became of the observation at a place, if a reading reaches it.
    fn replay(&mut self, of: Option<usize>) -> Option<Outcome> {
        self.current = self.settled.clone();
        let (mut begin, mut taken, mut outcome) = (self.settled_time, 0, None);
        for reading in &self.readings {
            let up_to = self.observations.partition_point(|observation| observation.time <= reading.time);
            let outcomes = run(&mut self.current, begin, reading, &self.observations[taken..up_to]);
            if let Some(place) = of.filter(|place| (taken..up_to).contains(place)) {
                outcome = outcomes.get(place - taken).copied();
            }
            (begin, taken) = (reading.time, up_to);
        }
        outcome
    }
}

/// A filter through a reading that began at a time and the observations during it (TIME-1 to TIME-3).
//= reference/SPEC.md#time
//# - **TIME-2** Readings and observations MUST have the effect of being taken in the order of their times, a reading
//# before the observations of its own time, and observations of one time by their image, then their format (`paper`
//# first), payload and layer (upper, lower, both).
//= reference/SPEC.md#time
//# - **TIME-3** An observation between two readings MUST part the later one's steps in proportion to the time.
fn run(filter: &mut Filter, begin: Time, reading: &Reading, observations: &[Observation]) -> Vec<Outcome> {
    let whole = reading.time.since(begin);
    let mut now = begin;
    let mut outcomes = Vec::new();
    for observation in observations {
        if observation.time > now {
            filter.predict(&part(&reading.ways, observation.time.since(now), whole));
            now = observation.time;
        }
        outcomes.push(filter.observe(&observation.sighting, observation.image));
    }
    if reading.time > now {
        filter.predict(&part(&reading.ways, reading.time.since(now), whole));
    }
    outcomes
}

/// The ways during a part of the time (TIME-1, TIME-3).
//= reference/SPEC.md#time
//# - **TIME-1** A reading's steps MUST count as made evenly from the end of the reading before it to its own time.
fn part(ways: &Ways, micros: u64, whole: u64) -> Ways {
    let share = micros as f64 / whole as f64;
    Ways { left: ways.left * share, right: ways.right * share }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::covariance::UncertainPose;
    use crate::filter::difference;
    use crate::frame::Pose;
    use crate::landmark::Landmark;
    use crate::motion::{Drive, State, StateCovariance, predict};
    use crate::observation::Seen;
    use nalgebra::Matrix3;
    use proptest::prelude::*;

    fn at(millis: u64) -> Time {
        Time::from_micros(1000 * millis)
    }

    fn start() -> Filter {
        let state = State { pose: Pose::new(0.0, 0.0, 0.0), wheel_difference: 0.0, axle_excess: 0.0 };
        let covariance = StateCovariance::from_diagonal(&[2.5e-5, 2.5e-5, 4e-4, 4e-6, 2.5e-5].into());
        Filter::new(Drive::epuck(), Estimate { state, covariance })
    }

    fn timeline() -> Timeline {
        Timeline::new(start(), at(0))
    }

    fn reading(millis: u64) -> Reading {
        // Never the same ways, so that none can stand for another.
        let left = 0.004 + 1e-6 * millis as f64;
        Reading { time: at(millis), ways: Ways { left, right: left + 2e-4 } }
    }

    /// The robot's pose is seen, about where it is.
    fn observation(millis: u64, payload: u32) -> Observation {
        let camera_in_landmark = Pose::new(0.05 * millis as f64 / 1000.0, 0.001 * f64::from(payload), 0.002);
        let seen = Seen::Pose(UncertainPose { camera_in_landmark, covariance: Matrix3::from_diagonal_element(1e-5) });
        Observation {
            time: at(millis),
            image: millis / 400,
            landmark: (Format::Paper, payload),
            part: Part::Both,
            sighting: Sighting {
                landmark_in_world: Pose::new(0.0, 0.0, 0.0),
                landmark: Landmark::new(Format::Paper),
                camera: Camera::epuck(),
                camera_in_robot: Pose::new(0.0, 0.0, 0.0),
                seen,
            },
        }
    }

    #[derive(Clone, Debug)]
    enum Event {
        Read(Reading),
        Observe(Box<Observation>),
    }

    impl Event {
        fn time(&self) -> Time {
            match self {
                Self::Read(reading) => reading.time,
                Self::Observe(observation) => observation.time,
            }
        }
    }

    fn give(timeline: &mut Timeline, event: &Event) -> Result<(), Untimely> {
        match event {
            Event::Read(reading) => timeline.read(reading),
            Event::Observe(observation) => timeline.observe(observation).map(drop),
        }
    }

    /// Readings every 100 ms and an observation every 170 ms, and for each by how much it is delayed.
    fn delayed() -> impl Strategy<Value = Vec<(Event, u64)>> {
        proptest::collection::vec(0..600_u64, 44).prop_map(|delays| {
            let readings = (1..=28).map(|i| Event::Read(reading(100 * i)));
            let observations =
                (1..=16).map(|i| Event::Observe(Box::new(observation(170 * i - 7, u32::try_from(i % 3).unwrap()))));
            readings.chain(observations).zip(delays).collect()
        })
    }

    /// In the order in which they come.
    fn arrived(mut events: Vec<(Event, u64)>) -> Vec<Event> {
        events.sort_by_key(|(event, delay)| event.time().as_micros() + 1000 * delay);
        events.into_iter().map(|(event, _)| event).collect()
    }

    proptest! {
        /// TIME-5: whatever comes at most 600 ms late, the result is that of the sorted order, to the bit.
        //= reference/SPEC.md#time
        //= type=test
        //# - **TIME-5** What comes late MUST have the same effect as if it had come in order, if its time is after the
        //# newest reading's less 600 ms.
        #[test]
        fn any_interleaving_gives_the_result_of_the_sorted_order(events in delayed()) {
            let (mut sorted, mut mixed) = (timeline(), timeline());
            let mut in_order: Vec<Event> = events.iter().map(|(event, _)| event.clone()).collect();
            in_order.sort_by_key(Event::time);
            for event in &in_order {
                prop_assert_eq!(give(&mut sorted, event), Ok(()));
            }
            let mut before = mixed.time();
            for event in &arrived(events) {
                prop_assert_eq!(give(&mut mixed, event), Ok(()));
                prop_assert!(mixed.time() >= before, "time of the estimate");
                before = mixed.time();
            }
            prop_assert_eq!(sorted.time(), mixed.time());
            prop_assert_eq!(sorted.estimate(), mixed.estimate());
            prop_assert_eq!(sorted.counts(), mixed.counts());
        }

        /// TIME-8, TIME-10: what comes again in time changes nothing, even if it says something else.
        //= reference/SPEC.md#time
        //= type=test
        //# - **TIME-8** A reading of the time of one in the queue, and an observation of the time, image, format,
        //# payload and layer of one in the queue, MUST be refused (`Duplicate`), whatever it says.
        #[test]
        fn duplicates_change_nothing(events in delayed(), again in proptest::collection::vec(0..5_usize, 44)) {
            let (mut once, mut twice) = (timeline(), timeline());
            let events = arrived(events);
            for (i, event) in events.iter().enumerate() {
                let _ = give(&mut once, event);
                let _ = give(&mut twice, event);
                let earlier = &events[i.saturating_sub(again[i])];
                let other = match earlier.clone() {
                    Event::Read(reading) => Event::Read(Reading { ways: Ways { left: 1.0, right: -1.0 }, ..reading }),
                    Event::Observe(observation) => Event::Observe(observation),
                };
                prop_assert!(matches!(give(&mut twice, &other), Err(Untimely::Duplicate | Untimely::Late)));
                prop_assert_eq!(once.estimate(), twice.estimate());
                prop_assert_eq!(once.time(), twice.time());
            }
        }
    }

    /// What an observation parts is the same way (TIME-3), and it is taken in the middle of it.
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-1** A reading's steps MUST count as made evenly from the end of the reading before it to its own time.
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-3** An observation between two readings MUST part the later one's steps in proportion to the time.
    #[test]
    fn an_observation_parts_a_reading() {
        let mut timeline = timeline();
        timeline.read(&reading(100)).unwrap();
        timeline.read(&reading(200)).unwrap();
        assert!(timeline.observe(&observation(125, 1)).unwrap().is_some());
        let mut filter = start();
        filter.predict(&reading(100).ways);
        let Ways { left, right } = reading(200).ways;
        filter.predict(&Ways { left: left / 4.0, right: right / 4.0 });
        filter.observe(&observation(125, 1).sighting, 0);
        filter.predict(&Ways { left: left * 0.75, right: right * 0.75 });
        assert_eq!(timeline.estimate(), filter.estimate());
        // Observations do not change how far the wheels went.
        let Estimate { state, covariance } = *start().estimate();
        let whole = predict(&state, &covariance, &reading(100).ways, &Drive::epuck());
        assert!(difference(&timeline.estimate().state, &whole.0).norm() > 1e-4);
    }

    #[test]
    fn a_reading_comes_before_the_observations_of_its_time() {
        let mut timeline = timeline();
        assert_eq!(timeline.observe(&observation(100, 1)), Ok(None));
        assert_eq!(timeline.counts().filter.used, 0);
        timeline.read(&reading(100)).unwrap();
        let mut filter = start();
        filter.predict(&reading(100).ways);
        filter.observe(&observation(100, 1).sighting, 0);
        assert_eq!(timeline.estimate(), filter.estimate());
        assert_eq!(timeline.counts().filter.used, 1);
    }

    /// TIME-2: of one time by image, format, payload and layer, whichever comes first. What the later one of two says is seen
    /// in the estimate, since each is said to know the pose for certain.
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-2** Readings and observations MUST have the effect of being taken in the order of their times, a
    //# reading before the observations of its own time, and observations of one time by their image, then their format
    //# (`paper` first), payload and layer (upper, lower, both).
    #[test]
    fn observations_of_one_time_have_an_order() {
        use crate::landmark::Format::{Paper, Wide};
        let seen = |image: u64, format, payload: u32, part, off: f64| {
            let mut one = observation(150, payload);
            (one.image, one.landmark, one.part) = (image, (format, payload), part);
            if let Seen::Pose(pose) = &mut one.sighting.seen {
                let at = pose.camera_in_landmark;
                pose.camera_in_landmark = Pose::new(at.x() + off, at.y(), at.theta());
                pose.covariance = Matrix3::from_diagonal_element(1e-6);
            }
            one
        };
        let pairs = [
            [(1, Wide, 9, Part::Both), (2, Paper, 1, Part::Upper)],
            [(1, Paper, 9, Part::Both), (1, Wide, 1, Part::Upper)],
            [(1, Paper, 1, Part::Both), (1, Paper, 2, Part::Upper)],
            [(1, Paper, 1, Part::Upper), (1, Paper, 1, Part::Lower)],
            [(1, Paper, 1, Part::Lower), (1, Paper, 1, Part::Both)],
        ];
        for [one, other] in pairs {
            let [first, second] = [(one, 0.0), (other, 1e-3)].map(|((i, f, p, part), off)| seen(i, f, p, part, off));
            let mut filter = start();
            let Ways { left, right } = reading(200).ways;
            let half = Ways { left: left / 2.0, right: right / 2.0 };
            filter.predict(&reading(100).ways);
            filter.predict(&half);
            filter.observe(&first.sighting, first.image);
            filter.observe(&second.sighting, second.image);
            filter.predict(&half);
            for order in [[&first, &second], [&second, &first]] {
                let mut timeline = timeline();
                timeline.read(&reading(100)).unwrap();
                timeline.read(&reading(200)).unwrap();
                for one in order {
                    assert!(timeline.observe(one).unwrap().is_some());
                }
                assert_eq!(timeline.estimate(), filter.estimate(), "{one:?} {other:?}");
            }
        }
    }

    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-6** What is no longer needed for TIME-5 MUST be *settled*: whenever the newest reading changes, all
    //# readings that are at least 600 ms older than it, and the observations up to the last of these.
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-7** A reading or an observation that is not after what is settled, or after the timeline's begin where
    //# nothing is, MUST be refused (`Late`).
    #[test]
    fn what_is_settled_is_not_taken_back() {
        let mut timeline = timeline();
        (1..=10).for_each(|i| timeline.read(&reading(100 * i)).unwrap());
        // 1,000 less 600: the reading of 400 is settled.
        let before = *timeline.estimate();
        assert_eq!(timeline.observe(&observation(400, 1)), Err(Untimely::Late));
        assert_eq!(timeline.read(&reading(399)), Err(Untimely::Late));
        assert_eq!((*timeline.estimate(), timeline.counts().late), (before, 2));
        assert!(timeline.observe(&observation(401, 1)).unwrap().is_some());
    }

    /// A clock that is set back by 10 s: nothing is taken until it has caught up, or the timeline is restarted.
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-10** What is refused MUST change nothing but its counter, and the estimate's time never decrease: while
    //# a clock that was set back has not caught up, everything is late.
    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-11** A timeline MUST be restarted on demand at a given time: everything is settled, observations that
    //# still wait are dropped and counted, and times count from the given one.
    #[test]
    fn a_clock_that_is_set_back_changes_nothing_until_it_has_caught_up() {
        let mut timeline = Timeline::new(start(), at(10_000));
        (1..=10).for_each(|i| timeline.read(&reading(10_000 + 100 * i)).unwrap());
        let before = *timeline.estimate();
        for i in 1..=104 {
            assert_eq!(timeline.read(&reading(100 * i)), Err(Untimely::Late));
        }
        assert_eq!((*timeline.estimate(), timeline.time()), (before, at(11_000)));
        assert_eq!(timeline.read(&reading(11_100)), Ok(()));
        assert_eq!(timeline.observe(&observation(12_000, 1)), Ok(None));
        let before = *timeline.estimate();
        timeline.restart(at(0));
        assert_eq!((*timeline.estimate(), timeline.time(), timeline.counts().dropped), (before, at(0), 1));
        assert_eq!(timeline.read(&reading(100)), Ok(()));
    }

    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-9** The queue MUST hold 16 readings and 8 observations, where there is no room the earliest readings
    //# and the observations up to these being settled one after the other until there is, except the newest one, and
    //# what would then be late, or finds no room even so, being refused (`Late`, `Full`).
    #[test]
    fn a_full_queue_settles_what_is_earliest() {
        // Sixteen readings within 600 ms, and a seventeenth.
        let mut timeline = timeline();
        (1..=16).for_each(|i| timeline.read(&reading(20 * i)).unwrap());
        assert!(timeline.observe(&observation(10, 1)).is_ok());
        timeline.read(&reading(340)).unwrap();
        assert_eq!(timeline.observe(&observation(20, 1)), Err(Untimely::Late));
        assert!(timeline.observe(&observation(21, 1)).is_ok());
        // What would be late then is refused, and nothing is settled for it.
        assert_eq!(timeline.read(&reading(30)), Err(Untimely::Late));
        assert!(timeline.observe(&observation(22, 1)).is_ok());
        // Eight observations, of which the first is after 20 ms, by the reading of 40 ms.
        (23..=28).for_each(|i| assert!(timeline.observe(&observation(i, 1)).is_ok()));
        assert_eq!(timeline.observe(&observation(29, 1)), Err(Untimely::Late));
        assert_eq!(timeline.counts().filter.used, 9);
        assert!(timeline.observe(&observation(41, 1)).is_ok());
    }

    //= reference/SPEC.md#time
    //= type=test
    //# - **TIME-4** The estimate MUST be that of the newest reading's time; an observation after it waits for the
    //# reading that reaches it.
    #[test]
    fn observations_that_wait_fill_the_queue() {
        let mut timeline = timeline();
        timeline.read(&reading(100)).unwrap();
        (1..=8).for_each(|i| assert_eq!(timeline.observe(&observation(100 + i, 1)), Ok(None)));
        assert_eq!(timeline.observe(&observation(109, 1)), Err(Untimely::Full));
        assert_eq!(timeline.counts().full, 1);
        timeline.read(&reading(200)).unwrap();
        assert_eq!(timeline.counts().filter.used, 8);
    }

    /// TIME-6: what is settled is so from when the newest reading changes.
    #[test]
    fn a_late_reading_settles_nothing() {
        let mut timeline = timeline();
        timeline.read(&reading(1000)).unwrap();
        timeline.read(&reading(100)).unwrap();
        assert_eq!(timeline.read(&reading(100)), Err(Untimely::Duplicate));
        assert!(matches!(timeline.observe(&observation(50, 1)), Ok(Some(_))));
        timeline.read(&reading(1100)).unwrap();
        assert_eq!(timeline.read(&reading(100)), Err(Untimely::Late));
        assert_eq!(timeline.observe(&observation(60, 1)), Err(Untimely::Late));
    }

    /// Where nothing makes room, all but the newest reading would be settled for it (TIME-9).
    #[test]
    fn what_would_be_late_is_late_even_where_the_queue_stays_full() {
        let mut timeline = timeline();
        (1..=2).for_each(|i| timeline.read(&reading(100 * i)).unwrap());
        (1..=8).for_each(|i| assert_eq!(timeline.observe(&observation(200 + i, 1)), Ok(None)));
        assert_eq!(timeline.observe(&observation(100, 1)), Err(Untimely::Late));
        assert_eq!(timeline.observe(&observation(101, 1)), Err(Untimely::Full));
        assert_eq!((timeline.counts().late, timeline.counts().full), (1, 1));
    }

    //= reference/SPEC.md#locate
    //= type=test
    //# - **LOCATE-6** The skew MUST be that of the readings the timeline holds; where they do not reach back to the
    //# upper row's time or on to the lower row's, it counts as at rest for what is missing.
    #[test]
    fn ways_are_parted_by_time() {
        let mut timeline = timeline();
        (1..=3).for_each(|i| timeline.read(&reading(100 * i)).unwrap());
        let ways = timeline.ways_between(at(150), at(225));
        assert_eq!(ways.len(), 2);
        assert!((ways[0].left - reading(200).ways.left / 2.0).abs() < 1e-15);
        assert!((ways[1].right - reading(300).ways.right / 4.0).abs() < 1e-15);
        // Beyond the readings the robot stands (LOCATE-6).
        assert_eq!(timeline.ways_between(at(250), at(900)).len(), 1);
        assert_eq!(timeline.ways_between(at(300), at(900)).len(), 0);
    }
}
