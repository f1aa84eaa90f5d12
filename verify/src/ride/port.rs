//! The port.

use super::{Known, Rider, Taken, reference::Numbers, setup};
use crate::filters::{held_pose, matrix, radians};
use crate::log::knowledge::{Knowledge, Landmarks, Listed, Observe, Stamp, States};
use crate::log::{Event, Motion};
use crate::port::Cameras;
use core::fmt;
use fixedpoint::covariance::PoseCovariance;
use fixedpoint::crossing::CrossingRule;
use fixedpoint::detect::Workspace;
use fixedpoint::exposure::{Capture, Time};
use fixedpoint::filter::Build;
use fixedpoint::formats::{GridStep, Length, Share, Slip, Steps, WheelLength};
use fixedpoint::grid::Grid;
use fixedpoint::localizer::{Config, Counts, Estimation, Localizer, Rows};
use fixedpoint::motion::{MotionModel, SLIP_OF_FIVE, SLIP_OF_THREE, State};
use fixedpoint::observation::Mounting;
use fixedpoint::observer::Silent;
use fixedpoint::places::{self, Places};
use fixedpoint::timeline::Reading;
use nalgebra::Matrix3;
use reference::exposure;
use reference::frame::Pose;
use reference::landmark::Format;
use reference::motion::Drive;

/// Largest coordinate that the port holds, metres.
const LARGEST: f64 = 128.0;

/// What of a robot's knowledge the port cannot hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortRefusal {
    /// The camera.
    Camera,
    /// The wheels or the axle.
    Wheels,
    /// The grid.
    Grid,
    /// The place of a landmark, of the camera on the robot, or of the robot at the start.
    Place,
}

impl fmt::Display for PortRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Camera => "the port cannot hold this camera",
            Self::Wheels => {
                "the port holds wheels of 5 to 250 mm in diameter, 20 to 800 mm apart, with 64 to 65535 whole steps a turn"
            }
            Self::Grid => "the port holds a grid with steps below 4 m whose origin is within 128 m of the world's",
            Self::Place => "the port holds places within 128 m of the world's origin, and a camera within 1 m of the robot's",
        })
    }
}

impl core::error::Error for PortRefusal {}

/// A robot's knowledge in the port's formats; its riders borrow it.
#[derive(Clone, Debug)]
pub struct PortSetup {
    build: Build,
    rows: Rows,
    landmarks: Vec<fixedpoint::landmark::Landmark>,
    grid: Option<Grid>,
    listed: Vec<places::Listed>,
    stamp: fixedpoint::exposure::Stamp,
    estimation: Estimation,
    start: State,
    /// To make steps of velocities.
    drive: Drive,
}

impl PortSetup {
    /// What a robot knows.
    pub fn new(knowledge: &Knowledge) -> Result<Self, PortRefusal> {
        let (grid, listed) = match &knowledge.landmarks {
            Landmarks::Grid(of) => (Some(grid(of)?), Vec::new()),
            Landmarks::Table(table) => (None, table.iter().map(place).collect::<Result<_, _>>()?),
        };
        let landmarks = knowledge.formats.iter().map(|format| match format {
            Format::Paper => fixedpoint::landmark::Landmark::paper(),
            Format::Wide => fixedpoint::landmark::Landmark::wide(),
        });
        let row = |row: usize| u16::try_from(row).map_err(|_| PortRefusal::Camera);
        let camera = &knowledge.camera;
        Ok(Self {
            build: build(knowledge)?,
            rows: Rows { height: row(camera.height)?, upper: row(camera.upper_row)?, lower: row(camera.lower_row)? },
            landmarks: landmarks.collect(),
            grid,
            listed,
            stamp: match knowledge.stamp {
                Stamp::Exposure => fixedpoint::exposure::Stamp::MidExposure,
                Stamp::Processing => fixedpoint::exposure::Stamp::Processing,
            },
            estimation: match knowledge.observe {
                Observe::Image => Estimation::Image,
                Observe::Pose => Estimation::Pose,
                Observe::Paper => Estimation::Paper,
            },
            start: start(knowledge)?,
            drive: setup::drive(knowledge),
        })
    }

    fn config(&self) -> Config<'_> {
        Config {
            build: self.build,
            rows: self.rows,
            landmarks: &self.landmarks,
            places: self.grid.map_or(Places::Table(&self.listed), Places::Grid),
            stamp: self.stamp,
            estimation: self.estimation,
            rule: CrossingRule::Interpolated,
        }
    }
}

fn build(knowledge: &Knowledge) -> Result<Build, PortRefusal> {
    let camera = Cameras::new(knowledge.camera).ok_or(PortRefusal::Camera)?.port;
    let wheels = &knowledge.wheels;
    let length = |metres: f64| WheelLength::checked_from_num(metres).ok_or(PortRefusal::Wheels);
    let whole = wheels.steps_per_turn.fract().abs() <= 0.0 && (64.0..=65535.0).contains(&wheels.steps_per_turn);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked just above")]
    let steps = if whole { wheels.steps_per_turn as u16 } else { return Err(PortRefusal::Wheels) };
    let drive = fixedpoint::motion::Drive::new(length(wheels.diameter)?, length(wheels.axle)?, steps);
    let slip: Slip = if knowledge.states == States::Five { SLIP_OF_FIVE } else { SLIP_OF_THREE };
    let paper = knowledge.observe == Observe::Paper;
    Ok(Build {
        camera,
        mounting: mounting(knowledge)?,
        drive: drive.map_err(|_| PortRefusal::Wheels)?,
        model: if paper { MotionModel::Linear } else { MotionModel::Arc },
        slip,
    })
}

fn mounting(knowledge: &Knowledge) -> Result<Mounting, PortRefusal> {
    let pose = knowledge.mounting.camera_in_robot();
    let near = pose.x().abs() <= 1.0 && pose.y().abs() <= 1.0;
    if near { Ok(held_pose(&pose).0) } else { Err(PortRefusal::Place) }
}

fn grid(grid: &reference::grid::Grid) -> Result<Grid, PortRefusal> {
    let origin = grid.origin.map(Length::checked_from_num);
    let step = grid.step.map(GridStep::checked_from_num);
    let headings = u8::try_from(grid.theta_steps.unwrap_or(16)).map_err(|_| PortRefusal::Grid)?;
    match (origin, step) {
        ([Some(x), Some(y)], [Some(dx), Some(dy)]) => {
            Grid::new([x, y], [dx, dy], headings).map_err(|_| PortRefusal::Grid)
        }
        _ => Err(PortRefusal::Grid),
    }
}

fn within<A, B>(pose: &Pose<A, B>) -> Result<(), PortRefusal> {
    if pose.x().abs().max(pose.y().abs()) < LARGEST { Ok(()) } else { Err(PortRefusal::Place) }
}

fn place(listed: &Listed) -> Result<places::Listed, PortRefusal> {
    let pose = listed.landmark_in_world();
    within(&pose)?;
    let format = match listed.format {
        Format::Paper => fixedpoint::landmark::Format::Paper,
        Format::Wide => fixedpoint::landmark::Format::Wide,
    };
    Ok(places::Listed { format, payload: listed.identifier, pose: held_pose(&pose).0 })
}

fn start(knowledge: &Knowledge) -> Result<State, PortRefusal> {
    let pose = knowledge.start.robot_in_world();
    within(&pose)?;
    let covariance = Matrix3::from_diagonal(&knowledge.start.deviations.map(|deviation| deviation * deviation).into());
    let state = State::new(&held_pose(&pose).0, &held_covariance(&covariance));
    Ok(match knowledge.states {
        States::Three => state,
        States::Five => {
            let [difference, excess] = setup::WHEELS.map(Share::from_num);
            state.with_wheels(difference, excess)
        }
    })
}

/// 2^-48 m², m rad and rad², rounded; what does not fit is the largest that does.
fn held_covariance(c: &Matrix3<f64>) -> PoseCovariance {
    #[expect(clippy::cast_possible_truncation, reason = "saturates")]
    let held = |i: usize, j: usize| (c[(i, j)] * 2.0_f64.powi(48)).round() as i64;
    PoseCovariance { xx: held(0, 0), xy: held(0, 1), xt: held(0, 2), yy: held(1, 1), yt: held(1, 2), tt: held(2, 2) }
}

/// The port's localizer.
#[derive(Clone, Debug)]
pub struct PortRider<'a> {
    localizer: Localizer<'a>,
    workspace: Workspace,
    drive: Drive,
    elsewhere: Numbers,
}

impl<'a> PortRider<'a> {
    /// A robot that begins at a time.
    #[must_use]
    pub fn new(setup: &'a PortSetup, begin: exposure::Time) -> Self {
        let localizer = Localizer::new(setup.config(), setup.start, Time::from_micros(begin.as_micros()));
        Self { localizer, workspace: Workspace::new(), drive: setup.drive, elsewhere: Numbers::default() }
    }

    /// Gives it an event; 1 if it is an image that shows a landmark whose place is known.
    fn give(&mut self, event: &Event) -> u64 {
        match event {
            Event::Reading(reading) => {
                let time = Time::from_micros(reading.time.micros());
                let seconds = time.since(self.localizer.time()) as f64 / 1e6;
                let [left, right] = steps(&reading.motion, seconds, &self.drive);
                // What is refused is counted.
                let _ = self.localizer.read(&Reading { time, left, right });
                0
            }
            Event::Image(image) => {
                let [start, end, processed] = [image.capture.start, image.capture.end, image.capture.processed]
                    .map(|time| Time::from_micros(time.micros()));
                let Ok(capture) = Capture::new(start, end, processed) else { return 0 };
                let [upper, lower] = &image.lines;
                let seen = self.localizer.image(upper, lower, &capture, &mut self.workspace, &mut Silent);
                u64::from(seen.detections > seen.unknown)
            }
            Event::Observation(seen) => {
                let time = Time::from_micros(seen.time.micros());
                let number = self.elsewhere.of(&seen.landmark_in_world);
                let (landmark, robot) = (held_pose(&seen.landmark_in_world).0, held_pose(&seen.robot_in_landmark).0);
                let covariance = held_covariance(&seen.covariance);
                let _ = self.localizer.observe_pose(time, &landmark, &robot, &covariance, number);
                1
            }
            Event::Truth(_) => 0,
        }
    }
}

/// Steps of both wheels, with parts of one where the motion is a velocity.
fn steps(motion: &Motion, seconds: f64, drive: &Drive) -> [Steps; 2] {
    match *motion {
        Motion::Steps { left, right } => [left, right].map(Steps::from_num),
        Motion::Velocity { .. } => {
            let ways = super::ways(motion, seconds, drive);
            [ways.left, ways.right].map(|way| Steps::saturating_from_num(way / drive.step()))
        }
    }
}

/// What changed from one count to the next.
fn between(before: &Counts, after: &Counts) -> Taken {
    let refused = |counts: &Counts| counts.timeline.late + counts.timeline.duplicate + counts.timeline.full;
    let (earlier, later) = (&before.timeline.filter, &after.timeline.filter);
    Taken {
        used: u64::from(later.used.saturating_sub(earlier.used)),
        gated: u64::from(later.gated.saturating_sub(earlier.gated)),
        recovered: u64::from(later.recovered.saturating_sub(earlier.recovered)),
        refused: u64::from(refused(after) - refused(before)),
        ..Taken::default()
    }
}

impl Rider for PortRider<'_> {
    fn take(&mut self, event: &Event) -> Taken {
        let before = self.localizer.counts();
        let images = self.give(event);
        Taken { images, ..between(&before, &self.localizer.counts()) }
    }

    fn known(&self) -> Known {
        let state = self.localizer.estimate();
        let pose = state.pose();
        Known {
            pose: Pose::new(pose.x.to_num(), pose.y.to_num(), radians(pose.theta)),
            covariance: matrix(&state.covariance().pose()),
        }
    }
}
