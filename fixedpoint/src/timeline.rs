//! The order in which a filter takes what has happened.
//!
//! Readings of the wheels and observations of landmarks come out of order: an image is seen before it is processed, and
//! messages overtake each other. Whatever comes within 600 ms has the same effect, to the last bit, as if it had come in
//! order (`TIME-5`).
//!
//! Two filters do this. One is *settled*: it has taken what nothing can come before any more. What came after that is in a
//! queue. The other is *current*: the settled one taken through the queue. A reading that comes in order moves the current
//! filter on; whatever comes before the newest reading takes a copy of the settled one through the queue once more.

pub mod queue;

use crate::exposure::Time;
use crate::filter::{self, Filter, Outcome};
use crate::formats::Steps;
use crate::landmark::Format;
use crate::layers::MeasuredLayer;
use crate::motion::{State, Ways};
use crate::observation::Sighting;
use crate::refusal::Untimely;
use queue::Queue;

/// How late something may come, 600 ms in microseconds (`TIME-5`).
pub const LATENESS: u64 = 600_000;

/// The most readings in the queue (`TIME-9`).
pub const MAX_READINGS: usize = 16;

/// The most observations in the queue (`TIME-9`).
pub const MAX_OBSERVATIONS: usize = 8;

/// How many steps both wheels have made since the reading before it in time, or since the timeline began, with parts of one where
/// a robot tells its velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// When they had made them.
    pub time: Time,
    /// Steps of the left wheel, forward positive.
    pub left: Steps,
    /// Steps of the right wheel.
    pub right: Steps,
}

/// What was seen of one landmark at one time. Its format is that of the sighting's landmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observation {
    /// When it was seen.
    pub time: Time,
    /// The number of the image that showed it.
    pub image: u32,
    /// The landmark's payload.
    pub payload: u32,
    /// Which of its layers were seen.
    pub layer: MeasuredLayer,
    /// What was seen.
    pub sighting: Sighting,
}

impl Observation {
    /// The landmark's format.
    #[must_use]
    pub fn format(&self) -> Format {
        self.sighting.landmark.format
    }

    /// What orders observations (`TIME-2`), and is the same of no two of them (`TIME-8`).
    //= reference/SPEC.md#time
    //# - **TIME-8** A reading of the time of one in the queue, and an observation of the time, image, format, payload
    //# and layer of one in the queue, MUST be refused (`Duplicate`), whatever it says.
    fn rank(&self) -> (Time, u32, Format, u32, MeasuredLayer) {
        (self.time, self.image, self.format(), self.payload, self.layer)
    }
}

/// What became of readings and observations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// The observations that the estimate has taken, by outcome.
    pub filter: filter::Counts,
    /// [`Untimely::Late`] ones.
    pub late: u32,
    /// [`Untimely::Duplicate`] ones.
    pub duplicate: u32,
    /// [`Untimely::Full`] ones.
    pub full: u32,
    /// Observations that still waited for a reading at a restart (`TIME-11`).
    pub dropped: u32,
}

/// A filter, and what it has still to be taken through.
///
/// Memory on a 32-bit target: 2.4 KB, two filters of 376 bytes, 16 readings of 16 and 8 observations of 168.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Timeline {
    /// Has taken everything up to the queue's begin.
    settled: Filter,
    /// Has taken everything up to the newest reading.
    current: Filter,
    queue: Queue,
    /// Those of the filter are counted by it.
    refused: Counts,
}

impl Timeline {
    /// A timeline that begins at a time with a filter, which has taken nothing that the timeline will be given.
    #[must_use]
    pub fn new(filter: Filter, begin: Time) -> Self {
        Self { settled: filter, current: filter, queue: Queue::new(begin), refused: Counts::default() }
    }

    /// Takes a reading (`TIME-1` to `TIME-6`).
    ///
    /// # Errors
    /// `Late` by `TIME-7` and `TIME-9`, `Duplicate` by `TIME-8`; then nothing has changed but a counter (`TIME-10`).
    //= reference/SPEC.md#time
    //# - **TIME-10** What is refused MUST change nothing but its counter, and the estimate's time never decrease: while
    //# a clock that was set back has not caught up, everything is late.
    pub fn read(&mut self, reading: &Reading) -> Result<(), Untimely> {
        let to_settle = self.queue.admit_reading(reading).map_err(|why| self.count(why))?;
        self.settle(to_settle);
        let newest = self.time();
        self.queue.insert_reading(*reading);
        if reading.time > newest {
            self.queue.take(&mut self.current, newest, reading.time, |_, _| {});
            self.settle(self.queue.outdated());
        } else {
            self.take_again(|_, _| {});
        }
        Ok(())
    }

    /// Takes an observation, and says what became of it, or nothing yet if it waits for its reading (`TIME-2` to `TIME-5`).
    ///
    /// What comes later, but is earlier, may change its outcome, and [`Timeline::counts`] then say so.
    ///
    /// # Errors
    /// `Late` by `TIME-7` and `TIME-9`, `Duplicate` by `TIME-8`, `Full` by `TIME-9`; then nothing has changed but a counter
    /// (`TIME-10`).
    //= reference/SPEC.md#time
    //# - **TIME-5** What comes late MUST have the same effect as if it had come in order, if its time is after the
    //# newest reading's less 600 ms.
    pub fn observe(&mut self, observation: &Observation) -> Result<Option<Outcome>, Untimely> {
        let to_settle = self.queue.admit_observation(observation).map_err(|why| self.count(why))?;
        self.settle(to_settle);
        self.queue.insert_observation(*observation);
        let mut outcome = None;
        if observation.time <= self.time() {
            self.take_again(|taken, its| {
                if taken.rank() == observation.rank() {
                    outcome = Some(its);
                }
            });
        }
        Ok(outcome)
    }

    /// Settles everything, drops the observations that still wait, and begins anew at a time (`TIME-11`).
    ///
    /// What the wheels do between the newest reading and that time is not known to the timeline.
    //= reference/SPEC.md#time
    //# - **TIME-11** A timeline MUST be restarted on demand at a given time: everything is settled, observations that
    //# still wait are dropped and counted, and times count from the given one.
    pub fn restart(&mut self, time: Time) {
        let waiting = u32::from(self.queue.waiting());
        self.refused.dropped = self.refused.dropped.saturating_add(waiting);
        self.settled = self.current;
        self.queue = Queue::new(time);
    }

    /// The state at the newest reading's time (`TIME-4`).
    //= reference/SPEC.md#time
    //# - **TIME-4** The estimate MUST be that of the newest reading's time; an observation after it waits for the
    //# reading that reaches it.
    #[must_use]
    pub fn estimate(&self) -> &State {
        self.current.state()
    }

    /// The newest reading's time, or when the timeline began if there is none; it decreases at a restart only (`TIME-10`).
    #[must_use]
    pub fn time(&self) -> Time {
        self.queue.newest()
    }

    /// What became of everything so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts { filter: self.current.counts(), ..self.refused }
    }

    /// The ways of the wheels between two times by the readings in the queue, one after the other; of what these do not reach
    /// there is none (`SKEW-1`, `LOCATE-6`).
    ///
    /// The queue reaches back 600 ms or more unless it is full or the timeline began later.
    pub fn ways_between(&self, from: Time, to: Time) -> impl Iterator<Item = Ways> + '_ {
        self.queue.ways_between(from, to)
    }

    /// Takes a copy of the settled filter through the queue.
    fn take_again(&mut self, hear: impl FnMut(&Observation, Outcome)) {
        self.current = self.settled;
        self.queue.take(&mut self.current, self.queue.begin(), self.queue.newest(), hear);
    }

    /// Settles the readings up to the one at a time, and the observations up to it.
    fn settle(&mut self, to: Option<Time>) {
        if let Some(to) = to {
            self.queue.take(&mut self.settled, self.queue.begin(), to, |_, _| {});
            self.queue.forget(to);
        }
    }

    fn count(&mut self, why: Untimely) -> Untimely {
        let count = match why {
            Untimely::Late => &mut self.refused.late,
            Untimely::Duplicate => &mut self.refused.duplicate,
            Untimely::Full => &mut self.refused.full,
        };
        *count = count.saturating_add(1);
        why
    }
}

#[cfg(test)]
mod tests;
