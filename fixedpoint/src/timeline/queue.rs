//! What has come and is not settled, in the order of its time.

use super::{LATENESS, MAX_OBSERVATIONS, MAX_READINGS, Observation, Reading};
use crate::exposure::Time;
use crate::filter::{Filter, Outcome};
use crate::formats::Steps;
use crate::in_order;
use crate::motion::Ways;
use crate::ratio;
use crate::refusal::Untimely;
use heapless::Vec;

/// Readings and observations after a time, each in `TIME-2`'s order.
///
/// Of other sizes only where it is shown what holds for any size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Queue<const READINGS: usize = MAX_READINGS, const OBSERVATIONS: usize = MAX_OBSERVATIONS> {
    begin: Time,
    readings: Vec<Reading, READINGS, u8>,
    observations: Vec<Observation, OBSERVATIONS, u8>,
}

impl<const READINGS: usize, const OBSERVATIONS: usize> Queue<READINGS, OBSERVATIONS> {
    /// An empty queue.
    #[must_use]
    pub fn new(begin: Time) -> Self {
        Self { begin, readings: Vec::new(), observations: Vec::new() }
    }

    /// The readings, in the order of their time.
    #[must_use]
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// The observations, in the order of their rank.
    #[must_use]
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// Nothing is in the queue that is not after this.
    #[must_use]
    pub fn begin(&self) -> Time {
        self.begin
    }

    /// The newest reading's time, or the begin if there is none.
    #[must_use]
    pub fn newest(&self) -> Time {
        self.readings.last().map_or(self.begin, |reading| reading.time)
    }

    /// How many observations are after the newest reading.
    #[must_use]
    pub fn waiting(&self) -> u8 {
        let newest = self.newest();
        self.observations.iter().filter(|observation| observation.time > newest).fold(0, |count, _| count + 1)
    }

    /// Up to which reading the queue has to be settled so that there is room for one more (`TIME-9`).
    ///
    /// # Errors
    /// `Late` by `TIME-7` and `TIME-9`, `Duplicate` by `TIME-8`.
    pub fn admit_reading(&self, reading: &Reading) -> Result<Option<Time>, Untimely> {
        self.admit(reading.time, self.readings.iter().any(|known| known.time == reading.time))?;
        if !self.readings.is_full() {
            return Ok(None);
        }
        let earliest = self.readings.first().map(|earliest| earliest.time);
        if earliest.is_some_and(|earliest| reading.time <= earliest) { Err(Untimely::Late) } else { Ok(earliest) }
    }

    /// Up to which reading the queue has to be settled so that there is room for one more observation (`TIME-9`).
    ///
    /// # Errors
    /// `Late` by `TIME-7` and `TIME-9`, `Duplicate` by `TIME-8`, `Full` by `TIME-9`.
    //= reference/SPEC.md#time
    //# - **TIME-9** The queue MUST hold 16 readings and 8 observations, where there is no room the earliest readings
    //# and the observations up to these being settled one after the other until there is, except the newest one, and
    //# what would then be late, or finds no room even so, being refused (`Late`, `Full`).
    pub fn admit_observation(&self, observation: &Observation) -> Result<Option<Time>, Untimely> {
        let rank = observation.rank();
        self.admit(observation.time, self.observations.iter().any(|known| known.rank() == rank))?;
        if !self.observations.is_full() {
            return Ok(None);
        }
        let (_, but_the_newest) = self.readings.split_last().ok_or(Untimely::Full)?;
        let makes_room = |time: &Time| self.observations.first().is_some_and(|earliest| earliest.time <= *time);
        let room = but_the_newest.iter().map(|reading| reading.time).find(makes_room);
        let settled = room.or(but_the_newest.last().map(|reading| reading.time));
        if settled.is_some_and(|settled| observation.time <= settled) {
            return Err(Untimely::Late);
        }
        room.map(Some).ok_or(Untimely::Full)
    }

    /// `TIME-7` and `TIME-8`.
    //= reference/SPEC.md#time
    //# - **TIME-7** A reading or an observation that is not after what is settled, or after the timeline's begin where
    //# nothing is, MUST be refused (`Late`).
    fn admit(&self, time: Time, is_known: bool) -> Result<(), Untimely> {
        if time <= self.begin {
            return Err(Untimely::Late);
        }
        if is_known { Err(Untimely::Duplicate) } else { Ok(()) }
    }

    /// The last reading that is at least 600 ms older than the newest one (`TIME-6`).
    //= reference/SPEC.md#time
    //# - **TIME-6** What is no longer needed for TIME-5 MUST be *settled*: whenever the newest reading changes, all
    //# readings that are at least 600 ms older than it, and the observations up to the last of these.
    #[must_use]
    pub fn outdated(&self) -> Option<Time> {
        let newest = self.newest();
        let times = self.readings.iter().map(|reading| reading.time);
        times.take_while(|time| newest.since(*time) >= LATENESS).last()
    }

    /// Adds a reading that was admitted, in order.
    pub fn insert_reading(&mut self, reading: Reading) {
        in_order::insert(&mut self.readings, reading, |one, other| one.time < other.time);
    }

    /// Adds an observation that was admitted, in order.
    pub fn insert_observation(&mut self, observation: Observation) {
        in_order::insert(&mut self.observations, observation, |one, other| one.rank() < other.rank());
    }

    /// Removes the readings and the observations up to a reading's time, at which the queue now begins.
    pub fn forget(&mut self, to: Time) {
        self.begin = to;
        self.readings.retain(|reading| reading.time > to);
        self.observations.retain(|observation| observation.time > to);
    }

    /// Takes a filter that is at one reading's time, or the queue's begin, to another one's (`TIME-2`, `TIME-3`), and
    /// says what becomes of each observation.
    //= reference/SPEC.md#time
    //# - **TIME-2** Readings and observations MUST have the effect of being taken in the order of their times, a
    //# reading before the observations of its own time, and observations of one time by their image, then their format
    //# (`paper` first), payload and layer (upper, lower, both).
    //= reference/SPEC.md#time
    //# - **TIME-3** An observation between two readings MUST part the later one's steps in proportion to the time.
    pub fn take(&self, filter: &mut Filter, from: Time, to: Time, mut hear: impl FnMut(&Observation, Outcome)) {
        for stretch in self.stretches().filter(|stretch| stretch.from >= from && stretch.to <= to) {
            let mut at = stretch.from;
            for observation in self.observations.iter().filter(|observation| stretch.reaches(observation.time)) {
                filter.predict(&stretch.ways(at, observation.time));
                at = observation.time;
                hear(observation, filter.observe(&observation.sighting, observation.image));
            }
            filter.predict(&stretch.ways(at, stretch.to));
        }
    }

    /// As [`super::Timeline::ways_between`].
    pub fn ways_between(&self, from: Time, to: Time) -> impl Iterator<Item = Ways> + '_ {
        let between = move |stretch: &Stretch| stretch.from < to && from < stretch.to && from < to;
        self.stretches().filter(between).map(move |stretch| stretch.ways(from, to))
    }

    /// The time from each reading to the next.
    fn stretches(&self) -> impl Iterator<Item = Stretch> + '_ {
        let begins = core::iter::once(self.begin).chain(self.readings.iter().map(|reading| reading.time));
        begins.zip(&self.readings).map(|(from, &Reading { time, left, right })| Stretch { from, to: time, left, right })
    }
}

/// The time that a reading's steps were made in, evenly (`TIME-1`).
//= reference/SPEC.md#time
//# - **TIME-1** A reading's steps MUST count as made evenly from the end of the reading before it to its own time.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    from: Time,
    to: Time,
    left: Steps,
    right: Steps,
}

impl Stretch {
    /// Whether a time is after its begin and not after its end.
    fn reaches(&self, time: Time) -> bool {
        self.from < time && time <= self.to
    }

    /// The ways between two times, in order, as far as they are in the stretch (`TIME-3`): differences of what is rounded, so that
    /// the parts of a stretch add up to the whole.
    fn ways(&self, from: Time, to: Time) -> Ways {
        let between = |steps: Steps| {
            let made = |time| made(steps, time, self.from, self.to);
            Steps::from_bits(made(to).saturating_sub(made(from)))
        };
        Ways { left: between(self.left), right: between(self.right) }
    }
}

/// How many of a stretch's steps were made by a time, 16 fraction bits; error half a unit, and 2^-31 of the steps in a stretch
/// of an hour and more.
fn made(steps: Steps, time: Time, from: Time, to: Time) -> i32 {
    let whole = steps.to_bits();
    if time >= to {
        return whole;
    }
    let (passed, all) = (time.since(from), to.since(from));
    let surplus = 32_u32.saturating_sub(all.leading_zeros()); // below 2^32 each without these bits
    let [passed, all] = [passed, all].map(|time| i64::try_from(time >> surplus).unwrap_or_default());
    // The product is within ±2^63, as steps are at most 2^31.
    let part = ratio::rounded(i64::from(whole).saturating_mul(passed), all, 0).unwrap_or_default();
    i32::try_from(part).unwrap_or(whole)
}

#[cfg(test)]
mod tests;
