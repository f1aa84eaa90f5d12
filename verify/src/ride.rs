//! Robots that know where they are, side by side: both pipelines and the wheels alone, given the same events.

mod estimates;
mod odometry;
mod port;
mod reference;
mod setup;

pub use estimates::{Estimates, FILES};
pub use odometry::Odometry;
pub use port::{PortRefusal, PortRider, PortSetup};
pub use reference::ReferenceRider;

use crate::log::{Event, Knowledge, Motion};
use ::reference::exposure::Time;
use ::reference::frame::{Pose, Robot, World, wrap};
use ::reference::motion::{Drive, Ways};
use nalgebra::Matrix3;

/// Where a robot believes itself to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// The robot in the world.
    pub pose: Pose<World, Robot>,
    /// Covariance of `(x, y, θ)`: metres and radians, squared.
    pub covariance: Matrix3<f64>,
}

/// What an event led to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// Images that showed a landmark whose place is known.
    pub images: u64,
    /// Observations that were used.
    pub used: u64,
    /// Observations that were not.
    pub gated: u64,
    /// Whether the filter began again elsewhere.
    pub recovered: u64,
    /// Readings or observations that were refused as late, double or too many.
    pub refused: u64,
    /// How near the NIS of an observation was to the gate, as a share of it; infinite where none is known.
    pub from_gate: f64,
}

impl Default for Taken {
    fn default() -> Self {
        Self { images: 0, used: 0, gated: 0, recovered: 0, refused: 0, from_gate: f64::INFINITY }
    }
}

impl Taken {
    /// Whether the same was decided on the same observations.
    #[must_use]
    pub fn decided_as(&self, other: &Self) -> bool {
        Self { from_gate: 0.0, ..*self } == Self { from_gate: 0.0, ..*other }
    }

    /// Whether as many observations were decided on.
    #[must_use]
    pub fn saw_as_much_as(&self, other: &Self) -> bool {
        let seen = |of: &Self| (of.images, of.used + of.gated + of.recovered, of.refused);
        seen(self) == seen(other)
    }

    /// As the column `event` of an estimate has it: what happened, and how often.
    #[must_use]
    pub fn words(&self) -> String {
        let words =
            [("used", self.used), ("gated", self.gated), ("recovered", self.recovered), ("refused", self.refused)];
        let some = words.iter().filter(|(_, count)| *count > 0).map(|(word, count)| format!("{word}:{count}"));
        some.collect::<Vec<_>>().join(" ")
    }

    /// Both together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            images: self.images + other.images,
            used: self.used + other.used,
            gated: self.gated + other.gated,
            recovered: self.recovered + other.recovered,
            refused: self.refused + other.refused,
            from_gate: self.from_gate.min(other.from_gate),
        }
    }
}

/// A robot that is given events in the order of their arrival.
pub trait Rider {
    /// Something happened.
    fn take(&mut self, event: &Event) -> Taken;
    /// Where it is now.
    fn known(&self) -> Known;
}

/// The robots of a ride, in the order of its rows.
pub const ROBOTS: [&str; 3] = ["reference", "fixedpoint", "odometry"];

/// What robots are given that know the same.
#[derive(Clone, Debug)]
pub struct Robots {
    setup: ::reference::localizer::Setup,
    start: ::reference::filter::Estimate,
    port: PortSetup,
}

impl Robots {
    /// Robots that know this.
    pub fn new(knowledge: &Knowledge) -> Result<Self, PortRefusal> {
        Ok(Self { setup: setup::setup(knowledge), start: setup::start(knowledge), port: PortSetup::new(knowledge)? })
    }

    /// A ride of them that begins at a time, in the order of [`ROBOTS`].
    #[must_use]
    pub fn ride(&self, begin: Time) -> Ride<'_> {
        Ride::new(vec![
            Box::new(ReferenceRider::new(self.setup.clone(), self.start, begin)),
            Box::new(PortRider::new(&self.port, begin)),
            Box::new(Odometry::new(self.setup.drive, self.start, begin)),
        ])
    }
}

/// What is known when everything that arrived by the time of a reading was taken (ROUTE-2).
//= reference/SPEC.md#route
//# - **ROUTE-2** A sample MUST be what is believed when everything that has arrived by a reading's time was taken,
//# beside where the robot is then.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The reading's time.
    pub time: Time,
    /// What the robots believe, in their order.
    pub known: Vec<Known>,
    /// What the events since the row before led to.
    pub taken: Vec<Taken>,
    /// Where the robot really is, where that is known.
    pub truth: Option<Pose<World, Robot>>,
}

/// Robots that take the same events in the order of their arrival (ROUTE-1).
pub struct Ride<'a> {
    riders: Vec<Box<dyn Rider + 'a>>,
    /// The reading after which no later event has arrived yet.
    open: Option<Time>,
    taken: Vec<Taken>,
    truth: Option<(Time, Pose<World, Robot>)>,
}

impl<'a> Ride<'a> {
    /// A ride of robots in this order.
    #[must_use]
    pub fn new(riders: Vec<Box<dyn Rider + 'a>>) -> Self {
        let taken = vec![Taken::default(); riders.len()];
        Self { riders, open: None, taken, truth: None }
    }

    /// Gives all robots an event; the row of the reading before it, if this event arrived after that.
    //= reference/SPEC.md#route
    //# - **ROUTE-1** Both pipelines and the wheels alone MUST be given the same events in the order of their arrival,
    //# of one time readings first, then images and observations: an image arrives when its processing ends.
    pub fn take(&mut self, event: &Event) -> Option<Row> {
        let row = if self.open.is_some_and(|open| Time::from(event.arrival()) > open) { self.close() } else { None };
        for (rider, taken) in self.riders.iter_mut().zip(&mut self.taken) {
            *taken = taken.and(&rider.take(event));
        }
        match event {
            // A clock that was set back opens nothing.
            Event::Reading(reading) => self.open = self.open.max(Some(reading.time.into())),
            Event::Truth(truth) => self.truth = Some((truth.time.into(), truth.robot_in_world())),
            Event::Image(_) | Event::Observation(_) => {}
        }
        row
    }

    /// The row of the last reading.
    pub fn close(&mut self) -> Option<Row> {
        let time = self.open.take()?;
        let known = self.riders.iter().map(|rider| rider.known()).collect();
        let taken = self.taken.iter_mut().map(std::mem::take).collect();
        let truth = self.truth.and_then(|(of, pose)| (of == time).then_some(pose));
        Some(Row { time, known, taken, truth })
    }
}

/// The ways of both wheels that a motion of so many seconds comes to, metres by their nominal diameter.
#[must_use]
pub fn ways(motion: &Motion, seconds: f64, drive: &Drive) -> Ways {
    match *motion {
        Motion::Steps { left, right } => {
            Ways { left: f64::from(left) * drive.step(), right: f64::from(right) * drive.step() }
        }
        Motion::Velocity { forward, turn } => {
            let (way, half) = (forward * seconds, turn * seconds * drive.axle / 2.0);
            Ways { left: way - half, right: way + half }
        }
    }
}

/// How far one robot's belief is from another's or from the truth: metres, and radians.
#[must_use]
pub fn apart(one: &Pose<World, Robot>, other: &Pose<World, Robot>) -> (f64, f64) {
    ((one.x() - other.x()).hypot(one.y() - other.y()), wrap(one.theta() - other.theta()).abs())
}

/// The normalised estimation error squared of a belief: a chi-square of three where its covariance is honest.
#[must_use]
pub fn nees(known: &Known, truth: &Pose<World, Robot>) -> Option<f64> {
    let pose = &known.pose;
    let turn = wrap(pose.theta() - truth.theta());
    let error = nalgebra::Vector3::new(pose.x() - truth.x(), pose.y() - truth.y(), turn);
    Some(error.dot(&known.covariance.cholesky()?.solve(&error)))
}
