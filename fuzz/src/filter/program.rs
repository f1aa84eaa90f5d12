//! Bytes as what happens to a robot.

use crate::draw::Draw;
use core::f64::consts::PI;
use fixedpoint::formats::Steps;
use fixedpoint::layers::MeasuredLayer;
use nalgebra::Matrix3;
use reference::bound::homography_of;
use reference::camera::Camera;
use reference::frame::{self, Pose, Robot, World};
use reference::homography::Homography;
use reference::landmark::{Format, Landmark};
use reference::layers::Part;
use reference::motion::{Drive, Ways};
use reference::timeline::Timeline;
use verify::filters::{Filters, Measure, Sight, Sightings};
use verify::port::{Cameras, Landmarks};

/// Standard deviations of a start: metres, radians, and of the wheels. What a robot is told by default (WORLD-18, ROUTE-10),
/// of five states and of three; ten times as much; and all, to the port's unit of 2^-48 m².
///
/// A robot that knows nothing, to 3.9 m and 3 rad, is not on a route (SAME-7): only to it a landmark that it would have to see
/// 87° off its camera's axis may be the one that it sees ahead, and the port cannot hold the noise of such a view.
const STARTS: [[f64; 5]; 4] = [
    [0.005, 0.005, 0.02, 0.002, 0.005],
    [0.005, 0.005, 0.02, 0.0, 0.0],
    [0.05, 0.05, 0.2, 0.002, 0.005],
    [6e-8, 6e-8, 6e-8, 0.0, 0.0],
];

/// Most steps of a wheel in a second (SCENARIO-4).
const FASTEST: i64 = 1000;

/// How far a robot goes from the world's origin, metres: the port holds 128.
const FARTHEST: f64 = 100.0;

/// What happens.
#[derive(Clone, Debug)]
pub(super) enum Step {
    Read(Reading),
    Observe(Box<Observation>),
    /// At a time in microseconds.
    Restart(u64),
    Nothing,
}

/// The wheels are read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    pub(super) micros: u64,
    left: i16,
    right: i16,
}

impl Reading {
    pub(super) fn ways(&self) -> Ways {
        let step = Drive::epuck().step();
        Ways { left: f64::from(self.left) * step, right: f64::from(self.right) * step }
    }

    pub(super) fn reference(&self) -> reference::timeline::Reading {
        reference::timeline::Reading { time: reference::exposure::Time::from_micros(self.micros), ways: self.ways() }
    }

    pub(super) fn port(&self) -> fixedpoint::timeline::Reading {
        let [left, right] = [self.left, self.right].map(Steps::from_num);
        fixedpoint::timeline::Reading { time: fixedpoint::exposure::Time::from_micros(self.micros), left, right }
    }
}

/// A landmark is seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observation {
    pub(super) micros: u64,
    pub(super) image: u32,
    format: Format,
    payload: u32,
    part: Part,
    pub(super) sightings: Sightings,
}

impl Observation {
    /// TIME-2
    pub(super) fn rank(&self) -> (u64, u32, bool, u32, Part) {
        (self.micros, self.image, self.format == Format::Wide, self.payload, self.part)
    }

    pub(super) fn reference(&self) -> reference::timeline::Observation {
        reference::timeline::Observation {
            time: reference::exposure::Time::from_micros(self.micros),
            image: u64::from(self.image),
            landmark: (self.format, self.payload),
            part: self.part,
            sighting: self.sightings.reference,
        }
    }

    pub(super) fn port(&self) -> fixedpoint::timeline::Observation {
        fixedpoint::timeline::Observation {
            time: fixedpoint::exposure::Time::from_micros(self.micros),
            image: self.image,
            payload: self.payload,
            layer: match self.part {
                Part::Upper => MeasuredLayer::Upper,
                Part::Lower => MeasuredLayer::Lower,
                Part::Both => MeasuredLayer::Both,
            },
            sighting: self.sightings.port,
        }
    }
}

/// A robot, and what it was given last.
pub(super) struct Program {
    /// With a landmark of either format.
    filters: [Filters; 2],
    measure: Measure,
    begin: u64,
    image: u32,
    last: Option<Step>,
}

impl Program {
    pub(super) fn new(draw: &mut Draw<'_>) -> Self {
        let options = draw.byte();
        let deviations = STARTS[usize::from(options & 3)];
        let cameras = Cameras::new(Camera::epuck()).expect("CAM-7");
        let filters = Format::ALL.map(|format| {
            let landmarks = Landmarks::new(&[format]).expect("LAND-6");
            Filters::new(cameras, landmarks, &Pose::new(0.0, 0.0, 0.0), deviations)
        });
        let measure = if options & 4 == 0 { Measure::Image } else { Measure::Pose };
        // Now and then a clock that has run for weeks, or begins with the robot.
        let begin = match options >> 3 & 3 {
            0 => 1_000_000,
            1 => 0,
            2 => 1 << 40,
            _ => (1 << 62) + 12_345,
        };
        Self { filters, measure, begin, image: 0, last: None }
    }

    /// Filters as they begin, and when.
    pub(super) fn begin(&self) -> (Filters, u64) {
        (self.filters[0].clone(), self.begin)
    }

    /// What happens next, to a robot that believes what a timeline says.
    pub(super) fn step(&mut self, timeline: &Timeline, draw: &mut Draw<'_>) -> Step {
        let now = timeline.time().as_micros();
        let kind = draw.byte();
        let step = match kind % 8 {
            0..=2 => reading(now, u64::from(draw.byte()) + 1, draw),
            3 => late_reading(now, draw),
            4 | 5 => self.observation(kind, now, timeline, draw),
            6 => return self.last.clone().unwrap_or(Step::Nothing),
            _ => Step::Restart(now.saturating_add_signed(1000 * i64::from(draw.word().cast_signed()))),
        };
        if !matches!(step, Step::Restart(_)) {
            self.last = Some(step.clone());
        }
        step
    }

    /// A landmark a little aside of where the robot believes to see it, or elsewhere; `Nothing` where the robot has left
    /// the world or the fit would not say where it is (COV-4).
    fn observation(&mut self, kind: u8, now: u64, timeline: &Timeline, draw: &mut Draw<'_>) -> Step {
        let believed = timeline.estimate().state.pose;
        if believed.x().hypot(believed.y()) > FARTHEST {
            return Step::Nothing;
        }
        // From 512 ms ago to 508 ms ahead.
        let micros = now.saturating_add_signed(4000 * i64::from(draw.signed()));
        // A new image, or the one before.
        self.image += u32::from(kind & 0x40 == 0);
        let format = if kind & 0x20 == 0 { Format::Paper } else { Format::Wide };
        let part = [Part::Upper, Part::Lower, Part::Both][draw.below(3)];
        let payload = u32::from(draw.byte());
        let seen_from = aside(&believed, kind & 0x80 != 0, draw);
        let Some(sight) = sight(format, &seen_from, draw) else { return Step::Nothing };
        let telling = &self.filters[usize::from(format == Format::Wide)];
        let Some(sightings) = telling.sightings(&sight, self.measure) else { return Step::Nothing };
        Step::Observe(Box::new(Observation { micros, image: self.image, format, payload, part, sightings }))
    }
}

/// Up to 256 ms after the newest.
fn reading(now: u64, millis: u64, draw: &mut Draw<'_>) -> Step {
    Step::Read(of_steps(now.saturating_add(1000 * millis), millis, draw))
}

/// Up to 1 s before the newest; 0 ms are the newest once more.
fn late_reading(now: u64, draw: &mut Draw<'_>) -> Step {
    let millis = 4 * u64::from(draw.byte());
    Step::Read(of_steps(now.saturating_sub(1000 * millis), 10, draw))
}

/// Steps that a wheel can make in so many milliseconds.
fn of_steps(micros: u64, millis: u64, draw: &mut Draw<'_>) -> Reading {
    let most = FASTEST * i64::try_from(millis).expect("at most 256") / 1000;
    let mut steps = || i16::try_from(i64::from(draw.signed()) * most / 128).expect("at most 256");
    Reading { micros, left: steps(), right: steps() }
}

/// Where the robot is if not where it believes: up to 127 mm and 0.25 rad off along each, or anywhere within 3 m.
fn aside(believed: &Pose<World, Robot>, elsewhere: bool, draw: &mut Draw<'_>) -> Pose<World, Robot> {
    let unit = if elsewhere { [0.023, 0.023, PI / 128.0] } else { [1e-3, 1e-3, 2e-3] };
    let [x, y, turn] = unit.map(|unit| unit * f64::from(draw.signed()));
    Pose::new(believed.x() + x, believed.y() + y, believed.theta() + turn)
}

/// A landmark that a robot sees 12 to 45 cm before it, as a fit of it measures it: 0.02 px of the centre, 0.03 px of the half
/// width and 0.06 px at the ends, times 1 to 5.
fn sight(format: Format, robot: &Pose<World, Robot>, draw: &mut Draw<'_>) -> Option<Sight> {
    let camera_in_robot: Pose<Robot, frame::Camera> = Pose::new(0.03, 0.0, 0.0);
    let (distance, bearing, inclination) = (draw.within(0.12..0.45), draw.within(-0.2..0.2), draw.within(-1.0..1.0));
    let polar = inclination - bearing;
    let camera_in_landmark: Pose<frame::Landmark, frame::Camera> =
        Pose::new(distance * polar.cos(), distance * polar.sin(), PI + inclination);
    let landmark_in_world = *robot * camera_in_robot * camera_in_landmark.inverse();
    let homography @ Homography { s, .. } =
        homography_of(&Camera::epuck(), &Landmark::new(format), &camera_in_landmark)?;
    let worse = 1.0 + f64::from(draw.byte()) / 64.0;
    let deviations = [0.02, 0.03, 0.06 / s].map(|deviation| worse * deviation);
    let covariance = Matrix3::from_diagonal(&deviations.map(|deviation| deviation * deviation).into());
    Some(Sight { landmark_in_world, homography, covariance })
}
