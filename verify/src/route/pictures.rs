//! A run as pictures like the paper's Figs. 11 to 13.

use super::Method;
use crate::drawing::DrawingError;
use crate::drawing::route::map::{Landmark, Map};
use crate::drawing::route::{Pose, Sample, Seen, errors, map};
use crate::ride::{Known, PortRefusal, Row, Taken};
use crate::scenario::Scenario;
use core::fmt;
use reference::frame;
use reference::world::Recording;

/// Radius of an e-puck, which the paper's errors stay below, metres.
const ROBOT_RADIUS: f64 = 0.035;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PictureRefusal {
    /// The port cannot hold what the robot knows.
    Port(PortRefusal),
    /// The drawing library gave up.
    Drawing(DrawingError),
}

impl fmt::Display for PictureRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Port(refusal) => refusal.fmt(f),
            Self::Drawing(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for PictureRefusal {}

/// The pictures of a run by their files' names: the way on a map, and the errors over time.
pub fn pictures(
    name: &str,
    scenario: &Scenario,
    recording: &Recording,
    method: Method,
) -> Result<[(&'static str, String); 2], PictureRefusal> {
    let mut samples = Vec::new();
    let each = |row: &Row| samples.extend(sample(row, recording));
    super::run(&scenario.setup, recording, method, each).map_err(PictureRefusal::Port)?;
    let walls: Vec<[[f64; 2]; 2]> = scenario.site.walls.iter().map(|wall| [wall.from, wall.to]).collect();
    let landmarks: Vec<Landmark> = (scenario.site.landmarks.iter())
        .map(|posted| Landmark { pose: numbers(&posted.landmark_in_world), width: 2.0 * posted.landmark.half_width() })
        .collect();
    let title = format!("{name}: the way by the landmarks, by the wheels alone, and the true one");
    let way = map::draw(&Map { title: &title, walls: &walls, landmarks: &landmarks, samples: &samples });
    let title = format!("{name}: errors of position and heading");
    let errors = errors::draw(&errors::Errors { title: &title, samples: &samples, robot_radius: Some(ROBOT_RADIUS) });
    Ok([("map.svg", way.map_err(PictureRefusal::Drawing)?), ("errors.svg", errors.map_err(PictureRefusal::Drawing)?)])
}

fn numbers<A, B>(pose: &frame::Pose<A, B>) -> Pose {
    [pose.x(), pose.y(), pose.theta()]
}

fn sample(row: &Row, recording: &Recording) -> Option<Sample> {
    let micros = row.time.as_micros();
    let [reference, port, odometry] = row.known.as_slice() else { return None };
    let Taken { used, gated, recovered, .. } = row.taken[0];
    Some(Sample {
        time: micros as f64 / 1e6,
        truth: numbers(row.truth.as_ref()?),
        estimate: numbers(&reference.pose),
        port: Some(numbers(&port.pose)),
        odometry: Some(numbers(&odometry.pose)),
        deviation: Some(deviation(reference)),
        lifted: recording.lifts.iter().any(|lift| (lift.from..lift.to).contains(&micros)),
        seen: Seen { used: used > 0, gated: gated > 0, recovered: recovered > 0 },
    })
}

/// Standard deviation of the position along its worst direction, metres.
fn deviation(known: &Known) -> f64 {
    let c = &known.covariance;
    let (mean, half) = (f64::midpoint(c[(0, 0)], c[(1, 1)]), (c[(0, 0)] - c[(1, 1)]) / 2.0);
    (mean + half.hypot(c[(0, 1)])).max(0.0).sqrt()
}
