//! A simulated robot among walls with landmarks: wheels, pilot, camera, and what goes wrong (WORLD).
//!
//! A [`Setup`] is where and how it drives. A run of it is an iterator over what the robot's clock, wheels and camera give it,
//! in the order in which it gets to know; [`Setup::record`] collects all of that, beside the truth.
//!
//! ```
//! use reference::frame::{Point, Pose};
//! use reference::world::{Place, Ride, Setup};
//!
//! // There and back without walls or landmarks, one lap.
//! let points = vec![Point::new(0.0, 0.0), Point::new(0.2, 0.0)];
//! let setup = Setup::new(Place::default(), Ride { points, laps: 1, speed: 0.05, turn: 1.0, wander: 0.02 });
//! let recording = setup.record(7, 0)?;
//! // 8 s on both legs and 3 s on the spot, an image every 400 ms.
//! assert!(recording.readings.len() > 100 && recording.shots.len() > 25);
//! assert_eq!(recording, setup.record(7, 0)?);
//! # Ok::<(), reference::world::SetupRefusal>(())
//! ```

mod pilot;
mod run;
mod shutter;
mod sight;
mod track;
mod wheels;

pub use pilot::{Command, Pilot, Ride};
pub use run::{Event, Run};
pub use shutter::{Disturbance, Obstacle, Seen, Shutter};
pub use sight::Wall;
pub use wheels::{Imperfections, Wheels};

use crate::camera::{Camera, CameraRefusal};
use crate::codeword::{self, EncodeRefusal};
use crate::frame::{self, Pose, Robot, World};
use crate::grid::Grid;
use crate::motion::Drive;
use crate::render::{Light, Posted, Sensor};
use core::fmt;

/// Steps of a wheel between two readings, forward positive.
pub type Step = i32;

/// Time in which the robot moves along one arc, microseconds (WORLD-5).
pub const TICK: u64 = 6_250;

/// The same in seconds.
pub(crate) const TICK_SECONDS: f64 = TICK as f64 * 1e-6;

/// Time between two readings of the wheels, microseconds (WORLD-4).
pub const READING_PERIOD: u64 = 100_000;

/// Where the robot drives, and what it sees with.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The camera.
    pub camera: Camera,
    /// The camera on the robot.
    pub camera_in_robot: Pose<Robot, frame::Camera>,
    /// Poses that payloads stand for.
    pub grid: Grid,
    /// What hides landmarks.
    pub walls: Vec<Wall>,
    /// Landmarks.
    pub landmarks: Vec<Posted>,
    /// Light and the two colours.
    pub light: Light,
    /// Blur and noise.
    pub sensor: Sensor,
}

impl Default for Place {
    /// Nothing around an e-puck, whose camera stands 3 cm ahead of the axle (OBSERVE-1).
    //= reference/SPEC.md#observe
    //# - **OBSERVE-1** The camera MUST by default be mounted 3 cm ahead of the axle's middle, looking ahead.
    fn default() -> Self {
        Self {
            camera: Camera::epuck(),
            camera_in_robot: Pose::new(0.03, 0.0, 0.0),
            grid: Grid::default(),
            walls: vec![],
            landmarks: vec![],
            light: Light::default(),
            sensor: Sensor::default(),
        }
    }
}

/// How well the robot is told where it starts (WORLD-18, WORLD-19).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// Standard deviations of x and y, metres, and of the heading, radians.
    pub sigma: [f64; 3],
    /// Whether it is told something else altogether, with the same standard deviations.
    pub wrong: bool,
}

impl Default for Told {
    /// To 5 mm and 0.02 rad, and right.
    fn default() -> Self {
        Self { sigma: [5e-3, 5e-3, 0.02], wrong: false }
    }
}

/// Somebody lifts the robot and puts it down elsewhere (WORLD-20, WORLD-21).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lift {
    /// The share of the ride after which this happens, from 0 to below 1.
    pub at: f64,
    /// How long the robot is off the ground, microseconds.
    pub lasts: u64,
}

/// All that a run follows from, but for its seed and number.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Where the robot drives.
    pub place: Place,
    /// How it is driven.
    pub ride: Ride,
    /// Nominal wheels; slip and model are not looked at.
    pub drive: Drive,
    /// How much a robot's wheels differ from these.
    pub imperfections: Imperfections,
    /// When images are taken.
    pub shutter: Shutter,
    /// What is wrong in them.
    pub disturbance: Disturbance,
    /// What the robot is told at the start.
    pub told: Told,
    /// Whether it is carried elsewhere.
    pub lift: Option<Lift>,
}

/// What is wrong with a setup.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetupRefusal {
    /// The camera is none (CAM-7).
    Camera(CameraRefusal),
    /// A landmark's payload has no code word.
    Payload(EncodeRefusal),
    /// The ride has less than two points, two neighbours are the same, or a number is not finite and above 0.
    Ride,
    /// Times that do not follow each other, or an exposure beyond a row's share.
    Shutter,
    /// A probability or a share outside 0 to 1, or a standard deviation below 0.
    Share,
}

impl fmt::Display for SetupRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Camera(refusal) => refusal.fmt(f),
            Self::Payload(refusal) => refusal.fmt(f),
            Self::Ride => f.write_str("the ride needs two distinct points, and speeds above 0"),
            Self::Shutter => f.write_str(
                "an image needs a capture of at most 1 s, no longer a period than that and the processing, and an \
                 exposure of at most a row's share",
            ),
            Self::Share => f.write_str("probabilities are from 0 to 1 and standard deviations not below 0"),
        }
    }
}

impl core::error::Error for SetupRefusal {}

impl Setup {
    /// A ride by an e-puck of the usual make, undisturbed.
    #[must_use]
    pub fn new(place: Place, ride: Ride) -> Self {
        Self {
            place,
            ride,
            drive: Drive::epuck(),
            imperfections: Imperfections::default(),
            shutter: Shutter::default(),
            disturbance: Disturbance::default(),
            told: Told::default(),
            lift: None,
        }
    }

    /// A run by its number under a seed (WORLD-22).
    pub fn run(&self, seed: u64, number: u64) -> Result<Run<'_>, SetupRefusal> {
        self.check()?;
        Ok(Run::new(self, seed, number))
    }

    /// A whole run by its number under a seed (WORLD-22).
    pub fn record(&self, seed: u64, number: u64) -> Result<Recording, SetupRefusal> {
        let mut run = self.run(seed, number)?;
        let mut recording = Recording {
            readings: Vec::new(),
            shots: Vec::new(),
            truth: Vec::new(),
            start: run.start(),
            wheels: run.wheels(),
            lifts: Vec::new(),
        };
        for event in &mut run {
            match event {
                Event::Reading(reading, truth) => {
                    recording.readings.push(reading);
                    recording.truth.push(truth);
                }
                Event::Shot(shot) => recording.shots.push(shot),
            }
        }
        recording.lifts.extend(run.lifted());
        Ok(recording)
    }

    fn check(&self) -> Result<(), SetupRefusal> {
        self.place.camera.checked().map_err(SetupRefusal::Camera)?;
        for posted in &self.place.landmarks {
            codeword::encode(posted.landmark.format, posted.payload).map_err(SetupRefusal::Payload)?;
        }
        let tests = [
            (self.ride_is_sound(), SetupRefusal::Ride),
            (self.shutter_is_sound(), SetupRefusal::Shutter),
            (self.shares_are_sound(), SetupRefusal::Share),
        ];
        tests.iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, refusal)| Err(*refusal))
    }

    fn ride_is_sound(&self) -> bool {
        let points = &self.ride.points;
        let ahead = points.iter().zip(points.iter().cycle().skip(1));
        let positive = |number: f64| number > 0.0 && number.is_finite();
        points.len() > 1
            && ahead.into_iter().all(|(a, b)| positive((b.x - a.x).hypot(b.y - a.y)))
            && [self.ride.speed, self.ride.turn, self.drive.step(), self.drive.axle].into_iter().all(positive)
    }

    fn shutter_is_sound(&self) -> bool {
        let Shutter { period, capture, processing, exposure } = self.shutter;
        (1..=1_000_000).contains(&capture)
            && capture.checked_add(processing).is_some_and(|busy| busy <= period)
            && exposure > 0
            && exposure.checked_mul(self.place.camera.height as u64).is_some_and(|all| all <= capture)
    }

    fn shares_are_sound(&self) -> bool {
        let share = |number: f64| (0.0..=1.0).contains(&number);
        let sigma = |number: f64| number >= 0.0 && number.is_finite();
        let Imperfections { wheel_difference, axle_excess, slip } = self.imperfections;
        let Place { sensor, .. } = &self.place;
        [self.disturbance.occlusion, self.disturbance.false_decodes].into_iter().all(share)
            && self.lift.is_none_or(|lift| (0.0..1.0).contains(&lift.at))
            && [wheel_difference, axle_excess, slip, self.ride.wander, sensor.blur, sensor.noise].into_iter().all(sigma)
            && self.told.sigma.into_iter().all(sigma)
    }
}

/// A reading of the wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Microseconds since the start.
    pub time: u64,
    /// Steps of the left wheel since the reading before, forward positive.
    pub left: Step,
    /// Those of the right wheel.
    pub right: Step,
}

/// An image.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// When its capture began, microseconds since the start.
    pub start: u64,
    /// When its capture ended.
    pub end: u64,
    /// When its processing ended and the robot knows what is in it.
    pub processed: u64,
    /// The upper and the lower scan line.
    pub lines: [Vec<u8>; 2],
    /// The landmarks of which all is on both lines, before anything stood in front of them.
    pub seen: Vec<Seen>,
    /// What stood in front of the lines.
    pub obstacle: Option<Obstacle>,
}

/// Where the robot is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Microseconds since the start.
    pub time: u64,
    /// The robot; while it is lifted, where that was done.
    pub pose: Pose<World, Robot>,
    /// Whether it is off the ground.
    pub lifted: bool,
}

/// What the robot is told at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Where it is said to be.
    pub pose: Pose<World, Robot>,
    /// Standard deviations of x and y, metres, and of the heading, radians.
    pub sigma: [f64; 3],
}

/// From when to when the robot was off the ground, microseconds since the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lifted {
    /// When it was lifted.
    pub from: u64,
    /// When it was put down.
    pub to: u64,
}

/// A run.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The wheels, every [`READING_PERIOD`].
    pub readings: Vec<Reading>,
    /// The images in the order of their times.
    pub shots: Vec<Shot>,
    /// The truth at every reading.
    pub truth: Vec<Truth>,
    /// What the robot was told.
    pub start: Start,
    /// The robot's wheels, which it is not told.
    pub wheels: Wheels,
    /// When it was carried elsewhere.
    pub lifts: Vec<Lifted>,
}

#[cfg(test)]
mod tests;
