//! Site files: grid, robot, walls, landmarks and routes of a building (SITE).
//!
//! ```toml
//! [grid]                        # the default: 50 mm from (0, 0), as many headings as the format has
//! step_mm = [50.0, 50.0]
//! origin_m = [0.0, 0.0]
//! theta_steps = 16
//!
//! [robot]                       # where the camera stands on it; the default: 30 mm ahead of the axle, looking ahead
//! camera_x_mm = 30.0
//! camera_y_mm = 0.0
//! camera_heading_deg = 0.0
//!
//! [[wall]]                      # a segment, and the side of it that is seen: left or right of its direction, or both
//! from_m = [0.0, 0.0]
//! to_m = [2.0, 0.0]
//! face = "left"
//!
//! [[landmark]]                  # its pose as codes of x, y and heading ...
//! codes = [20, 0, 4]
//! format = "paper"
//!
//! [[landmark]]                  # ... or in the world, then also off the grid if it carries an identifier
//! x_m = 1.234
//! y_m = 0.0
//! heading_deg = 90.0
//! identifier = 17
//! stripe_width_mm = 2.0
//! stripe_height_mm = 25.0
//!
//! [route]                       # way-points of the axle's middle; the robot looks along it and turns on the spot
//! points_m = [[0.2, 1.0], [1.8, 1.0]]
//! closed = false
//!
//! [region]                      # where the axle's middle may be
//! polygon_m = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]
//! holes_m = []
//! ```
//!
//! Every part may be left out. Lengths in the library are metres, angles radians.

pub(crate) mod check;
pub(crate) mod fault;
pub(crate) mod form;
mod hang;
mod line;
mod write;

pub(crate) use check::{positive, site as of_form, within};
pub(crate) use fault::Fault;
pub use fault::SiteError;
pub(crate) use form::{SiteForm, WITHOUT_UNIT, parse_with_units};
pub(crate) use hang::{gap, on_wall};
pub use line::Wall;
pub(crate) use line::sides;
pub use write::with_landmarks;

use reference::frame::{Camera, Pose, Robot};
use reference::grid::Grid;
use reference::render::Posted;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest site file that is read, bytes.
const LARGEST_FILE: u64 = 1 << 22;

/// Largest coordinate of a site, metres (SITE-3).
pub const LARGEST_COORDINATE: f64 = 1000.0;

/// How far a landmark may be from its wall's plane, metres (SITE-5).
pub const OFF_WALL: f64 = 1e-3;

/// How far a landmark's heading may be from its wall's normal, radians (SITE-5).
pub const ASKEW: f64 = 0.01;

/// A building.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Poses that payloads stand for.
    pub grid: Grid,
    /// Where the camera stands on the robot.
    pub camera_in_robot: Pose<Robot, Camera>,
    /// What landmarks hang on and what hides them.
    pub walls: Vec<Wall>,
    /// Landmarks, each on a wall.
    pub landmarks: Vec<Posted>,
    /// Where the robot drives.
    pub route: Option<Route>,
    /// Where the robot may be.
    pub region: Option<Region>,
}

impl Default for Site {
    /// Nothing but the default grid and a camera 30 mm ahead of the robot's axle (SITE-8).
    fn default() -> Self {
        Self {
            grid: Grid::default(),
            camera_in_robot: Pose::new(form::CAMERA_AHEAD_MM / 1000.0, 0.0, 0.0),
            walls: vec![],
            landmarks: vec![],
            route: None,
            region: None,
        }
    }
}

/// Way-points of the robot's axle, at least two; neighbours differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// World coordinates, metres.
    pub points: Vec<[f64; 2]>,
    /// Whether it goes on from the last point to the first, lap after lap.
    pub closed: bool,
}

/// A polygon, by the even-odd rule of all of its rings.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The outline and then the holes, world coordinates in metres, at least three points each.
    pub rings: Vec<Vec<[f64; 2]>>,
}

impl Region {
    /// Whether the region has the point (metres) in it.
    #[must_use]
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let crossed =
            |[a, b]: [[f64; 2]; 2]| (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        self.rings.iter().flat_map(|ring| line::sides(ring)).filter(|&side| crossed(side)).count() % 2 == 1
    }
}

/// The site that a TOML file describes (SITE-1).
pub fn load(path: &Path) -> Result<Site, SiteError> {
    let text = read(path)?;
    parse(&text).map_err(|fault| fault.in_file(path, &text))
}

/// A site file's text; it is no site yet.
pub fn read(path: &Path) -> Result<String, SiteError> {
    let mut text = String::new();
    let read = File::open(path).and_then(|file| file.take(LARGEST_FILE + 1).read_to_string(&mut text));
    match read {
        Err(error) => Err(SiteError::whole_file(path, &format!("cannot be read: {error}"))),
        Ok(bytes) if bytes as u64 > LARGEST_FILE => Err(SiteError::whole_file(path, "is larger than 4 MB")),
        Ok(_) => Ok(text),
    }
}

/// The site that a TOML text describes, under the name `path` (SITE-1).
pub fn of_toml(text: &str, path: &Path) -> Result<Site, SiteError> {
    parse(text).map_err(|fault| fault.in_file(path, text))
}

fn parse(text: &str) -> Result<Site, Fault> {
    check::site(&form::parse(text)?)
}

#[cfg(test)]
mod tests;
