//! One run, tick by tick (WORLD-4, WORLD-5, WORLD-18 to WORLD-22).

use super::shutter::View;
use super::track::Track;
use super::wheels::StepCounter;
use super::{
    Command, Lifted, Pilot, READING_PERIOD, Reading, Setup, Shot, Start, TICK, TICK_SECONDS, Told, Truth, Wheels,
};
use crate::frame::{Pose, Robot, World, wrap};
use crate::motion::Ways;
use core::f64::consts::PI;
use core::ops::Range;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;

/// How far a wrong start is from the true one, metres (WORLD-19).
const WRONG_BY: Range<f64> = 0.3..1.0;

/// What random numbers of a run are for: each purpose has a stream of its own, so that one of them asked for less or more
/// leaves the others as they are.
#[derive(Clone, Copy, Debug)]
enum Purpose {
    Robot,
    Ride,
    Noise,
    Disturbance,
    Carrying,
}

/// Streams that a run has room for.
const PURPOSES: u64 = 8;

/// The generator of a run for a purpose (WORLD-22).
//= reference/SPEC.md#world
//# - **WORLD-22** A run MUST follow from its setup, a seed and its number alone, with random streams of their own for
//# the wheels, the ride, the noise, the disturbances and the carrying, so that a change of one leaves the others.
fn generator(seed: u64, number: u64, purpose: Purpose) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number.wrapping_mul(PURPOSES) + purpose as u64);
    rng
}

/// What the robot gets to know.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A reading of the wheels, and the truth at its time.
    Reading(Reading, Truth),
    /// An image whose processing has ended.
    Shot(Shot),
}

/// How the robot is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moved {
    ByPilot,
    /// In somebody's hands until this time.
    Carried(Lifted),
    /// It stands where the ride has ended.
    Done,
}

/// A run: an iterator over what the robot gets to know, in the order of these times, a reading before an image that is
/// known at the same time.
#[derive(Debug)]
pub struct Run<'a> {
    setup: &'a Setup,
    wheels: Wheels,
    start: Start,
    pilot: Pilot<'a>,
    pose: Pose<World, Robot>,
    moved: Moved,
    lifted: Option<Lifted>,
    counter: StepCounter,
    track: Track,
    /// Microseconds, a multiple of [`TICK`].
    time: u64,
    /// When the next image begins.
    next_image: u64,
    known: VecDeque<Event>,
    ended: bool,
    ride: ChaCha8Rng,
    noise: ChaCha8Rng,
    disturbance: ChaCha8Rng,
    carrying: ChaCha8Rng,
}

impl<'a> Run<'a> {
    /// A run at its beginning; the setup was checked.
    pub(super) fn new(setup: &'a Setup, seed: u64, number: u64) -> Self {
        let mut robot = generator(seed, number, Purpose::Robot);
        let pose = setup.ride.begin();
        Self {
            setup,
            wheels: Wheels::draw(&setup.imperfections, &mut robot),
            start: told(&pose, &setup.told, &mut robot),
            pilot: Pilot::new(&setup.ride),
            pose,
            moved: Moved::ByPilot,
            lifted: None,
            counter: StepCounter::default(),
            track: Track::new(pose),
            time: 0,
            next_image: 0,
            known: VecDeque::new(),
            ended: false,
            ride: generator(seed, number, Purpose::Ride),
            noise: generator(seed, number, Purpose::Noise),
            disturbance: generator(seed, number, Purpose::Disturbance),
            carrying: generator(seed, number, Purpose::Carrying),
        }
    }

    /// The robot's wheels.
    #[must_use]
    pub fn wheels(&self) -> Wheels {
        self.wheels
    }

    /// What the robot is told.
    #[must_use]
    pub fn start(&self) -> Start {
        self.start
    }

    /// From when to when the robot was off the ground, as far as the run has come.
    #[must_use]
    pub fn lifted(&self) -> Option<Lifted> {
        self.lifted
    }

    /// Moves the robot by a tick and takes note of what it knows then.
    fn tick(&mut self) {
        if self.moved == Moved::ByPilot {
            self.look_for_a_lift();
        }
        self.time += TICK;
        match self.moved {
            Moved::ByPilot => self.drive(),
            Moved::Carried(lifted) => self.carry(lifted),
            Moved::Done => self.track.push(self.pose, false),
        }
        self.image_known_before(self.time);
        if self.time.is_multiple_of(READING_PERIOD) {
            self.read();
            self.ended = self.moved == Moved::Done;
        }
        self.image_known_before(self.time + 1);
    }

    /// WORLD-20: once, where the share of the ride is reached.
    //= reference/SPEC.md#world
    //# - **WORLD-20** A robot that is to be lifted MUST be lifted at the first tick at which the stated share of the
    //# ride's legs is done, for a stated time in which no step is counted.
    fn look_for_a_lift(&mut self) {
        if let (Some(lift), None) = (self.setup.lift, self.lifted)
            && self.pilot.share(&self.pose) >= lift.at
        {
            let ticks = lift.lasts.div_ceil(TICK).max(1);
            let lifted = Lifted { from: self.time, to: self.time + ticks * TICK };
            self.lifted = Some(lifted);
            self.moved = Moved::Carried(lifted);
        }
    }

    fn drive(&mut self) {
        let Some(Command { speed, turn }) = self.pilot.steer(&self.pose, &mut self.ride) else {
            self.moved = Moved::Done;
            return self.track.push(self.pose, false);
        };
        let aside = turn * self.setup.drive.axle / 2.0;
        let ways = Ways { left: (speed - aside) * TICK_SECONDS, right: (speed + aside) * TICK_SECONDS };
        self.counter.roll(&ways);
        self.pose = self.wheels.roll(&self.pose, &ways, &self.setup.drive, &mut self.ride);
        self.track.push(self.pose, false);
    }

    fn carry(&mut self, lifted: Lifted) {
        if self.time == lifted.to {
            self.pose = self.pilot.put_elsewhere(&mut self.carrying);
            self.moved = Moved::ByPilot;
        }
        self.track.push(self.pose, true);
    }

    fn read(&mut self) {
        let [left, right] = self.counter.read(self.setup.drive.step());
        let lifted = matches!(self.moved, Moved::Carried(_));
        let truth = Truth { time: self.time, pose: self.pose, lifted };
        self.known.push_back(Event::Reading(Reading { time: self.time, left, right }, truth));
    }

    /// Takes the image whose processing has ended before a time; there is at most one in a tick's time that is new.
    fn image_known_before(&mut self, time: u64) {
        let shutter = &self.setup.shutter;
        while self.next_image + shutter.capture + shutter.processing < time {
            let (start, end) = (self.next_image, self.next_image + shutter.capture);
            let view = View { place: &self.setup.place, track: &self.track };
            let disturbed = view.disturb(&self.setup.disturbance, start, end, &mut self.disturbance);
            let lines = view.expose(shutter, start, &disturbed, &mut self.noise);
            let processed = end + shutter.processing;
            let shot = Shot { start, end, processed, lines, seen: disturbed.seen, obstacle: disturbed.obstacle };
            self.known.push_back(Event::Shot(shot));
            self.next_image += shutter.period;
            self.track.forget_before(self.next_image);
        }
    }
}

impl Iterator for Run<'_> {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        while self.known.is_empty() && !self.ended {
            self.tick();
        }
        self.known.pop_front()
    }
}

/// What the robot is told of where it stands (WORLD-18, WORLD-19): three normal deviates, then three uniform ones.
//= reference/SPEC.md#world
//# - **WORLD-18** The robot MUST be told its start with a normal error, by default of 5 mm along x and y and of 0.02
//# rad, and these standard deviations.
//= reference/SPEC.md#world
//# - **WORLD-19** A start that is wrong MUST be 0.3 to 1 m farther away in any direction, with any heading, and be told
//# with the same standard deviations.
fn told<R: Rng + ?Sized>(pose: &Pose<World, Robot>, told: &Told, rng: &mut R) -> Start {
    let mut deviate = |sigma: f64| {
        let deviate: f64 = StandardNormal.sample(rng);
        sigma * deviate
    };
    let [x, y, theta] = told.sigma.map(&mut deviate);
    let (far, direction, turned) = (rng.random_range(WRONG_BY), rng.random_range(-PI..PI), rng.random_range(-PI..PI));
    let (far, turned) = if told.wrong { (far, turned) } else { (0.0, 0.0) };
    let (x, y) = (pose.x() + x + far * direction.cos(), pose.y() + y + far * direction.sin());
    Start { pose: Pose::new(x, y, wrap(pose.theta() + theta + turned)), sigma: told.sigma }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_purposes_of_any_runs_share_a_stream() {
        let purposes = [Purpose::Robot, Purpose::Ride, Purpose::Noise, Purpose::Disturbance, Purpose::Carrying];
        let all = (0..100).flat_map(|number| purposes.map(|purpose| generator(1, number, purpose).random::<u64>()));
        assert_eq!(all.collect::<BTreeSet<_>>().len(), 500);
    }
}
