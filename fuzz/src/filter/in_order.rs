//! What timelines have taken, in the order of its times: what a queue must come to (TIME-2, TIME-5).

use super::program::{Observation, Reading};
use fixedpoint::timeline::Timeline;
use reference::filter::{Filter, Outcome};
use reference::motion::Ways;

/// Since the beginning or a restart.
#[derive(Clone, Debug)]
struct Epoch {
    begin: u64,
    readings: Vec<Reading>,
    observations: Vec<Observation>,
}

/// Everything that was taken, in order.
#[derive(Clone, Debug)]
pub(super) struct InOrder(Vec<Epoch>);

impl InOrder {
    pub(super) fn new(begin: u64) -> Self {
        Self(vec![Epoch::new(begin)])
    }

    pub(super) fn reading(&mut self, reading: Reading) {
        let readings = &mut self.last().readings;
        let place = readings.partition_point(|other| other.micros < reading.micros);
        readings.insert(place, reading);
    }

    pub(super) fn observation(&mut self, observation: &Observation) {
        let observations = &mut self.last().observations;
        let place = observations.partition_point(|other| other.rank() < observation.rank());
        observations.insert(place, *observation);
    }

    pub(super) fn restart(&mut self, micros: u64) {
        self.0.push(Epoch::new(micros));
    }

    fn last(&mut self) -> &mut Epoch {
        self.0.last_mut().expect("there is always one")
    }

    /// The reference's filter through all of it, and what it made of the observations.
    pub(super) fn run(&self, from: &Filter) -> (Filter, Vec<Outcome>) {
        let mut filter = from.clone();
        let outcomes = self.0.iter().flat_map(|epoch| epoch.run(&mut filter)).collect();
        (filter, outcomes)
    }

    /// Another timeline of the port that is given all of it in order; `None` if its queue was too short for that.
    pub(super) fn run_port(&self, mut timeline: Timeline) -> Option<Timeline> {
        for (i, epoch) in self.0.iter().enumerate() {
            if i > 0 {
                timeline.restart(fixedpoint::exposure::Time::from_micros(epoch.begin));
            }
            epoch.run_port(&mut timeline)?;
        }
        Some(timeline)
    }
}

impl Epoch {
    fn new(begin: u64) -> Self {
        Self { begin, readings: Vec::new(), observations: Vec::new() }
    }

    /// TIME-1 to TIME-4: each reading's steps evenly over its time, parted by the observations in it.
    fn run(&self, filter: &mut Filter) -> Vec<Outcome> {
        let mut outcomes = Vec::new();
        let mut left = &self.observations[..];
        let mut from = self.begin;
        for reading in &self.readings {
            let (during, later) = left.split_at(left.partition_point(|seen| seen.micros <= reading.micros));
            let whole = reading.ways();
            let part = |micros: u64| {
                let share = micros as f64 / (reading.micros - from) as f64;
                Ways { left: whole.left * share, right: whole.right * share }
            };
            let mut now = from;
            for seen in during {
                if seen.micros > now {
                    filter.predict(&part(seen.micros - now));
                    now = seen.micros;
                }
                outcomes.push(filter.observe(&seen.sightings.reference, u64::from(seen.image)));
            }
            if reading.micros > now {
                filter.predict(&part(reading.micros - now));
            }
            (left, from) = (later, reading.micros);
        }
        outcomes
    }

    fn run_port(&self, timeline: &mut Timeline) -> Option<()> {
        let mut left = &self.observations[..];
        for reading in &self.readings {
            let (before, later) = left.split_at(left.partition_point(|seen| seen.micros < reading.micros));
            before.iter().try_for_each(|seen| timeline.observe(&seen.port()).map(|_| ()).ok())?;
            timeline.read(&reading.port()).ok()?;
            left = later;
        }
        left.iter().try_for_each(|seen| timeline.observe(&seen.port()).map(|_| ()).ok())
    }
}
