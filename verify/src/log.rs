//! A robot's log: a folder of what its wheels did, what it saw, where it was and what it knows (LOG).
//!
//! ```text
//! odometry.csv       t_s,left_steps,right_steps            or  t_s,forward_m_s,turn_rad_s
//! frames.csv         t_start_s,t_end_s,t_processed_s,file  and the images; or observations.csv
//! observations.csv   t_s,landmark_x_m,landmark_y_m,landmark_theta_rad,x_m,y_m,theta_rad,c_xx,c_xy,c_xt,c_yy,c_yt,c_tt
//! truth.csv          t_s,x_m,y_m,theta_rad                 if it is known
//! robot.toml         what the robot knows                  if it is not an e-puck on the default grid (see [`knowledge`])
//! ```
//!
//! [`LogReader`] gives what happened in the order in which the robot learnt of it, one row at a time, however long the
//! log is. A row that cannot be used is a [`Fault`] in its place; the [`Summary`] counts.

mod clock;
mod fault;
pub mod knowledge;
mod lines;
mod pace;
mod reader;
mod row;
mod summary;
mod table;
mod time;
mod unfinished;
mod writer;

pub use fault::{Fault, Reason};
pub use knowledge::Knowledge;
pub use reader::{LogReader, Sources};
pub use summary::{Cases, Rows, Summary};
pub use time::{Time, TimeRefusal};
pub use unfinished::Unfinished;
pub use writer::{Estimate, EstimateWriter, LogWriter};

use crate::scenes::Lines;
use nalgebra::Matrix3;
use reference::frame::{Landmark, Pose, Robot, World};

/// Names of a log's files.
pub const ODOMETRY: &str = "odometry.csv";
/// Images of a log.
pub const FRAMES: &str = "frames.csv";
/// Observations of a log.
pub const OBSERVATIONS: &str = "observations.csv";
/// Where the robot was.
pub const TRUTH: &str = "truth.csv";
/// What the robot knows.
pub const ROBOT: &str = "robot.toml";

/// Largest coordinate, metres (LOG-7).
pub const LARGEST_COORDINATE: f64 = 100.0;

/// Largest angle, radians (LOG-7).
pub const LARGEST_ANGLE: f64 = 1e6;

/// What a robot learns, in the order in which it learns it (LOG-11).
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// How it moved.
    Reading(Reading),
    /// What its camera saw.
    Image(Image),
    /// Where it was in the frame of a landmark.
    Observation(Observation),
    /// Where it was, which it does not learn; the last of its time.
    Truth(Truth),
}

impl Event {
    /// When the robot learns of it.
    #[must_use]
    pub fn arrival(&self) -> Time {
        match self {
            Self::Reading(reading) => reading.time,
            Self::Image(image) => image.capture.processed,
            Self::Observation(observation) => observation.time,
            Self::Truth(truth) => truth.time,
        }
    }
}

/// How the robot has moved until a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// When it was read.
    pub time: Time,
    /// Since the reading before.
    pub motion: Motion,
}

/// A motion as a log has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Steps of the wheels since the row before.
    Steps {
        /// Of the left wheel.
        left: i16,
        /// Of the right wheel.
        right: i16,
    },
    /// Velocities that held since the row before.
    Velocity {
        /// Of the axle's middle, m/s.
        forward: f64,
        /// Of the heading, counter-clockwise, rad/s.
        turn: f64,
    },
}

/// When an image was captured and processed (EXPOSE-2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capture {
    /// Begin of its first row.
    pub start: Time,
    /// End of its last row.
    pub end: Time,
    /// When its processing was done.
    pub processed: Time,
}

/// An image's scan lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// When.
    pub capture: Capture,
    /// Upper and lower scan line of the camera that the log is read with.
    pub lines: Lines,
    /// Its line in `frames.csv`, for messages.
    pub line: u64,
}

/// Where the robot saw itself from a landmark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// When.
    pub time: Time,
    /// The landmark.
    pub landmark_in_world: Pose<World, Landmark>,
    /// The robot.
    pub robot_in_landmark: Pose<Landmark, Robot>,
    /// Of x, y and heading of the robot in the landmark's frame: m², m rad, rad².
    pub covariance: Matrix3<f64>,
}

/// Where the robot was. The numbers as they are written: those of a [`Pose`] may be a rounding away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// When.
    pub time: Time,
    /// World coordinates of the axle's middle, metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Heading, radians.
    pub theta: f64,
}

impl Truth {
    /// As a pose.
    #[must_use]
    pub fn robot_in_world(&self) -> Pose<World, Robot> {
        Pose::new(self.x, self.y, self.theta)
    }
}
