//! Robots on the runs of a scenario: how well each knew where it was.

mod pictures;
mod report;
mod score;

pub use pictures::{PictureRefusal, pictures};
pub use report::{Errors, Report, TOGETHER, report};
pub use score::{Recovery, Score, note};

use crate::log::knowledge::{Landmarks, Mounting, Observe, Stamp, Start, States, Wheels};
use crate::log::{Capture, Event, Image, Knowledge, Motion, Reading, Truth};
use crate::ride::{PortRefusal, ROBOTS, Robots, Row, Taken, apart};
use crate::scenario;
use core::fmt;
use rayon::prelude::*;
use reference::exposure::Time;
use reference::landmark::Format;
use reference::world::{Place, Recording, Setup, SetupRefusal};
use serde::Serialize;
use std::path::Path;

/// How near a NIS may be to the gate for the pipelines to differ, as a share: both linearise until a step is below 2e-5 m, so that
/// the last one is off by its square, and the port normalises by 2^-27 (SAME-7).
const NEAR_GATE: f64 = 1e-3;

/// A run: scores in the order of [`ROBOTS`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// How well each knew where it was.
    pub scores: Vec<Score>,
    /// The largest difference between both pipelines: metres, and radians.
    pub apart: (f64, f64),
    /// The same while both had taken the same decisions.
    pub apart_alike: (f64, f64),
    /// Readings at which both pipelines had not decided alike since the reading before.
    pub differing: Differing,
}

/// Why both pipelines did not decide alike at a reading (SAME-7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Differing {
    /// One saw a landmark in an image that the other did not accept.
    pub seen: u64,
    /// An observation's NIS was within 1 in 1,000 of the gate.
    pub gate: u64,
    /// They had not decided alike before, and not both used observations twice since.
    pub follows: u64,
    /// None of these.
    pub unexplained: u64,
}

impl Differing {
    /// Readings in all.
    #[must_use]
    pub fn all(&self) -> u64 {
        self.seen + self.gate + self.follows + self.unexplained
    }

    fn add(&mut self, by_reference: &Taken, by_port: &Taken, alike: &Alike) {
        let count = if !by_reference.saw_as_much_as(by_port) {
            &mut self.seen
        } else if by_reference.from_gate < NEAR_GATE {
            &mut self.gate
        } else if alike.used_since < 2 {
            &mut self.follows
        } else {
            &mut self.unexplained
        };
        *count += 1;
    }

    /// Both together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            seen: self.seen + other.seen,
            gate: self.gate + other.gate,
            follows: self.follows + other.follows,
            unexplained: self.unexplained + other.unexplained,
        }
    }
}

impl Run {
    fn compare(&mut self, row: &Row, alike: &mut Alike) {
        let [one, other] = [&row.known[0], &row.known[1]];
        let (position, heading) = apart(&one.pose, &other.pose);
        let larger = |of: (f64, f64)| (of.0.max(position), of.1.max(heading));
        self.apart = larger(self.apart);
        let [by_reference, by_port] = [&row.taken[0], &row.taken[1]];
        let same = by_reference.decided_as(by_port);
        if !same {
            self.differing.add(by_reference, by_port, alike);
        }
        if alike.after(same, row.taken[0].used > 0) {
            self.apart_alike = larger(self.apart_alike);
        }
    }
}

/// Whether both pipelines have decided alike, or have both used observations twice since they last did not (ROUTE-7).
#[derive(Clone, Copy, Debug)]
struct Alike {
    used_since: u32,
}

impl Alike {
    //= reference/SPEC.md#route
    //# - **ROUTE-7** The pipelines' largest difference MUST be reported over all samples, and over those at which both
    //# have decided alike on everything so far, or have both used observations at two samples since they last did not.
    fn after(&mut self, same: bool, used: bool) -> bool {
        self.used_since = if same { self.used_since.saturating_add(u32::from(used)) } else { 0 };
        self.used_since >= 2
    }
}

/// Why a scenario was not driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RouteRefusal {
    /// The world cannot be built.
    Setup(SetupRefusal),
    /// The port cannot hold what the robot knows.
    Port(PortRefusal),
    /// A built-in scenario has no run.
    Scenario,
}

impl fmt::Display for RouteRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Setup(refusal) => refusal.fmt(f),
            Self::Port(refusal) => refusal.fmt(f),
            Self::Scenario => f.write_str("a built-in scenario was not run"),
        }
    }
}

impl core::error::Error for RouteRefusal {}

impl From<SetupRefusal> for RouteRefusal {
    fn from(refusal: SetupRefusal) -> Self {
        Self::Setup(refusal)
    }
}

impl From<PortRefusal> for RouteRefusal {
    fn from(refusal: PortRefusal) -> Self {
        Self::Port(refusal)
    }
}

/// How a robot is to find its way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Method {
    /// What the filter estimates.
    pub states: States,
    /// What of an image it is given.
    pub observe: Observe,
    /// When an image counts as seen.
    pub stamp: Stamp,
}

impl Method {
    /// The paper's: a pose by whole pixels, three states, the stamp of ERRATA-11.
    //= reference/SPEC.md#errata
    //# - **ERRATA-11** The image's time stamp MUST be the paper's, the middle of its processing, only in what
    //# reproduces the paper.
    #[must_use]
    pub fn paper() -> Self {
        Self { states: States::Three, observe: Observe::Paper, stamp: Stamp::Processing }
    }
}

/// What the robot of a recording is told.
#[must_use]
pub fn told(world: &Setup, recording: &Recording, method: Method) -> Knowledge {
    let Place { camera, camera_in_robot, grid, landmarks, .. } = &world.place;
    let formats = Format::ALL.into_iter().filter(|format| landmarks.iter().any(|one| one.landmark.format == *format));
    let formats: Vec<Format> = formats.collect();
    let start = &recording.start;
    Knowledge {
        landmarks: Landmarks::Grid(*grid),
        formats: if formats.is_empty() { vec![Format::Paper] } else { formats },
        camera: *camera,
        mounting: Mounting { x: camera_in_robot.x(), y: camera_in_robot.y(), heading: camera_in_robot.theta() },
        wheels: Wheels {
            diameter: world.drive.wheel_diameter,
            axle: world.drive.axle,
            steps_per_turn: world.drive.steps_per_turn,
        },
        start: Start { x: start.pose.x(), y: start.pose.y(), theta: start.pose.theta(), deviations: start.sigma },
        states: method.states,
        observe: method.observe,
        stamp: method.stamp,
    }
}

/// When a robot was lost: told a wrong start, or put down elsewhere.
fn lost_at(world: &Setup, recording: &Recording) -> Vec<Time> {
    let start = world.told.wrong.then(Time::default);
    start.into_iter().chain(recording.lifts.iter().map(|lift| Time::from_micros(lift.to))).collect()
}

/// A run of robots through a recording; `each` is shown every row.
pub fn run(
    world: &Setup,
    recording: &Recording,
    method: Method,
    mut each: impl FnMut(&Row),
) -> Result<Run, PortRefusal> {
    let knowledge = told(world, recording, method);
    let robots = Robots::new(&knowledge)?;
    let mut ride = robots.ride(Time::default());
    let mut lost_at = lost_at(world, recording);
    let mut run = Run { scores: vec![Score::default(); ROBOTS.len()], ..Run::default() };
    let mut alike = Alike { used_since: 2 };
    let mut heed = |row: Row| {
        note(&mut run.scores, &row, &mut lost_at);
        run.compare(&row, &mut alike);
        each(&row);
    };
    for event in events(recording) {
        ride.take(&event).into_iter().for_each(&mut heed);
    }
    ride.close().into_iter().for_each(&mut heed);
    run.scores.iter_mut().for_each(Score::end);
    Ok(run)
}

/// A recording's events in the order of their arrival: at one time readings, then images, then the truth.
///
/// # Panics
/// If a wheel has made more than 32,767 steps between two readings, thirty times what SCENARIO-4 allows.
#[must_use]
pub fn events(recording: &Recording) -> Vec<Event> {
    let readings = recording.readings.iter().map(|reading| {
        // A stepper that is ten times as fast as an e-puck's makes 1,000 steps in 100 ms.
        let steps = |count: i32| i16::try_from(count).expect("a scenario's speeds are an e-puck's");
        let motion = Motion::Steps { left: steps(reading.left), right: steps(reading.right) };
        Event::Reading(Reading { time: Time::from_micros(reading.time).into(), motion })
    });
    let images = recording.shots.iter().map(|shot| {
        let [start, end, processed] = [shot.start, shot.end, shot.processed].map(|time| Time::from_micros(time).into());
        Event::Image(Image { capture: Capture { start, end, processed }, lines: shot.lines.clone(), line: 0 })
    });
    let truth = recording.truth.iter().map(|truth| {
        let (x, y, theta) = (truth.pose.x(), truth.pose.y(), truth.pose.theta());
        Event::Truth(Truth { time: Time::from_micros(truth.time).into(), x, y, theta })
    });
    let mut events: Vec<Event> = readings.chain(images).chain(truth).collect();
    events.sort_by_key(Event::arrival);
    events
}

/// Both pipelines on so many runs of each built-in scenario.
pub fn built_in(count: u64, seed: u64) -> Result<Vec<Report>, RouteRefusal> {
    let all = scenario::BUILT_IN.iter().map(|(name, _)| {
        let scenario = scenario::load(Path::new(name)).map_err(|_| RouteRefusal::Scenario)?;
        let by_method = runs(&scenario.setup, &[Method::default()], (count, seed), &|| {})?;
        report(name, seed, &by_method[0]).ok_or(RouteRefusal::Scenario)
    });
    all.collect()
}

/// All runs of a world under a seed by each method, in their order; `progress` is told of each run that is done.
pub fn runs(
    world: &Setup,
    methods: &[Method],
    (count, seed): (u64, u64),
    progress: &(impl Fn() + Sync),
) -> Result<Vec<Vec<Run>>, RouteRefusal> {
    let one = |number: u64| {
        let recording = world.record(seed, number)?;
        let by_method = methods.iter().map(|&method| Ok(run(world, &recording, method, |_| {})?)).collect();
        progress();
        by_method
    };
    let by_number: Result<Vec<Vec<Run>>, RouteRefusal> = (0..count).into_par_iter().map(one).collect();
    let by_number = by_number?;
    Ok((0..methods.len()).map(|method| by_number.iter().map(|runs| runs[method].clone()).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ride::Known;
    use nalgebra::Matrix3;
    use reference::exposure::Time;
    use reference::frame::Pose;

    /// The largest differences over all samples, and over those at which both had decided alike or had both used two since.
    //= reference/SPEC.md#route
    //= type=test
    //# - **ROUTE-7** The pipelines' largest difference MUST be reported over all samples, and over those at which both
    //# have decided alike on everything so far, or have both used observations at two samples since they last did not.
    #[test]
    fn what_follows_from_another_decision_counts_apart() {
        let (mut run, mut alike) = (Run::default(), Alike { used_since: 2 });
        let mut after = |apart: f64, used: [u64; 2]| {
            let known = |x: f64| Known { pose: Pose::new(x, 0.0, 0.0), covariance: Matrix3::identity() };
            let taken = used.map(|used| Taken { images: 1, used, gated: 1 - used, ..Taken::default() }).to_vec();
            let row = Row { time: Time::default(), known: vec![known(0.0), known(apart)], taken, truth: None };
            run.compare(&row, &mut alike);
            [run.apart.0, run.apart_alike.0].map(|metres| format!("{:.0} mm", 1e3 * metres))
        };
        assert_eq!(after(0.001, [0, 0]), ["1 mm", "1 mm"]);
        // Otherwise decided, and one sample that both use, and one that neither does.
        assert_eq!(after(0.002, [1, 0]), ["2 mm", "1 mm"]);
        assert_eq!(after(0.003, [1, 1]), ["3 mm", "1 mm"]);
        assert_eq!(after(0.004, [0, 0]), ["4 mm", "1 mm"]);
        // The second one that both use.
        assert_eq!(after(0.005, [1, 1]), ["5 mm", "5 mm"]);
    }
}
