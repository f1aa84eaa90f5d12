//! What a robot knows about itself and its site (LOG-15 to LOG-17).
//!
//! ```toml
//! states = 5                    # what the filter estimates: 3 or 5
//! observe = "image"             # (a, s, k); "pose", OBSERVE-2's pose; "paper", the paper's estimator
//! stamp = "exposure"            # when an image was seen: as its rows were exposed, or "processing", the paper's rule
//! formats = ["paper"]           # that are looked for
//!
//! [grid]                        # as in a site file
//! step_mm = [30.0, 25.98]
//! theta_steps = 12
//!
//! [[landmark]]                  # or a table of landmarks
//! format = "wide"
//! identifier = 17
//! x_m = 1.234
//! y_m = 0.0
//! heading_deg = 90.0
//!
//! [camera]                      # as in a camera file
//! width_px = 480
//!
//! [robot]                       # where the camera stands on it, as in a site file, and its wheels
//! camera_x_mm = 30.0
//! wheel_diameter_mm = 41.0
//! axle_mm = 53.0
//! steps_per_turn = 1000.0
//!
//! [start]                       # where it begins, and the standard deviations of that
//! x_m = 0.0
//! y_m = 0.0
//! theta_rad = 0.0
//! deviation_x_m = 0.005
//! deviation_y_m = 0.005
//! deviation_theta_rad = 0.02
//! ```

mod check;
mod form;
mod text;

use super::ROBOT;
use crate::site::{self, SiteError};
use reference::camera::Camera;
use reference::frame::{self, Landmark, Pose, Robot, World};
use reference::grid::Grid;
use reference::landmark::Format;
use reference::motion::{Drive, MotionModel};
use serde::Deserialize;
use std::path::Path;

/// What a robot knows. Numbers are kept as they are written: a [`Pose`] may be a rounding away from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Knowledge {
    /// What payloads stand for.
    pub landmarks: Landmarks,
    /// Formats that are looked for, at least one.
    pub formats: Vec<Format>,
    /// The camera.
    pub camera: Camera,
    /// Where it is mounted.
    pub mounting: Mounting,
    /// The wheels.
    pub wheels: Wheels,
    /// Where the robot begins.
    pub start: Start,
    /// What is estimated.
    pub states: States,
    /// What an image says.
    pub observe: Observe,
    /// When an image was seen.
    pub stamp: Stamp,
}

/// What payloads stand for.
#[derive(Clone, Debug, PartialEq)]
pub enum Landmarks {
    /// Poses on a grid.
    Grid(Grid),
    /// Landmarks by format and identifier.
    Table(Vec<Listed>),
}

/// A landmark of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Listed {
    /// Its format.
    pub format: Format,
    /// Its payload.
    pub identifier: u32,
    /// World coordinates, metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
}

impl Listed {
    /// Where it is.
    #[must_use]
    pub fn landmark_in_world(&self) -> Pose<World, Landmark> {
        Pose::new(self.x, self.y, self.heading)
    }
}

/// Where the camera stands on the robot (OBSERVE-1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Ahead of the axle's middle, metres.
    pub x: f64,
    /// To the left of it, metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
}

impl Mounting {
    /// As a pose.
    #[must_use]
    pub fn camera_in_robot(&self) -> Pose<Robot, frame::Camera> {
        Pose::new(self.x, self.y, self.heading)
    }
}

/// The wheels (MOTION-8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheels {
    /// Nominal diameter of both, metres.
    pub diameter: f64,
    /// Their nominal distance, metres.
    pub axle: f64,
    /// Steps in a turn.
    pub steps_per_turn: f64,
}

impl Wheels {
    /// The drive that these are part of, with its slip in metres (MOTION-6).
    #[must_use]
    pub fn drive(&self, slip: f64, model: MotionModel) -> Drive {
        Drive { wheel_diameter: self.diameter, axle: self.axle, steps_per_turn: self.steps_per_turn, slip, model }
    }
}

/// Where the robot begins, and how well that is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// World coordinates, metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub theta: f64,
    /// Standard deviations of the three, above 0.
    pub deviations: [f64; 3],
}

impl Start {
    /// As a pose.
    #[must_use]
    pub fn robot_in_world(&self) -> Pose<World, Robot> {
        Pose::new(self.x, self.y, self.theta)
    }
}

/// What the filter estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum States {
    /// The pose.
    Three,
    /// The pose, the wheels' difference and the axle's scale.
    #[default]
    Five,
}

/// What an image says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Observe {
    /// `(a, s, k)` (OBSERVE-3).
    #[default]
    Image,
    /// A pose, from the fit (OBSERVE-2).
    Pose,
    /// A pose, by the paper's estimator and covariance (COV-5).
    Paper,
}

/// When an image was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stamp {
    /// In the middle of each row's exposure.
    #[default]
    Exposure,
    /// In the middle of its processing (ERRATA-11).
    Processing,
}

impl Default for Knowledge {
    /// An e-puck on the default grid (LOG-16).
    //= reference/SPEC.md#log
    //# - **LOG-16** What it leaves out MUST be: GRID's default grid, both formats or those of its landmarks, the
    //# `epuck` camera, OBSERVE-1's mounting, MOTION-8's wheels, a start at (0, 0, 0) known to 5 mm, 5 mm and 0.02 rad,
    //# five states, images as observations, and mid-exposure as the stamp.
    fn default() -> Self {
        let epuck = Drive::epuck();
        Self {
            landmarks: Landmarks::Grid(Grid::default()),
            formats: Format::ALL.to_vec(),
            camera: Camera::epuck(),
            mounting: Mounting { x: 0.03, y: 0.0, heading: 0.0 },
            wheels: Wheels { diameter: epuck.wheel_diameter, axle: epuck.axle, steps_per_turn: epuck.steps_per_turn },
            start: Start { x: 0.0, y: 0.0, theta: 0.0, deviations: [0.005, 0.005, 0.02] },
            states: States::default(),
            observe: Observe::default(),
            stamp: Stamp::default(),
        }
    }
}

impl Knowledge {
    /// What `robot.toml` in a log's folder says, the default without one.
    pub fn of_log(folder: &Path) -> Result<Self, SiteError> {
        let path = folder.join(ROBOT);
        match path.try_exists() {
            Ok(false) => Ok(Self::default()),
            _ => Self::of_toml(&site::read(&path)?, &path),
        }
    }

    /// What a TOML text says, under the name `path` (LOG-15).
    pub fn of_toml(text: &str, path: &Path) -> Result<Self, SiteError> {
        form::parse(text).and_then(|form| check::knowledge(&form, text)).map_err(|fault| fault.in_file(path, text))
    }
}

#[cfg(test)]
mod tests;
