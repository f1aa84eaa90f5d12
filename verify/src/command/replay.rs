//! `barloc replay`

use super::{Exit, Failure};
use crate::log::{Event, Knowledge, LogReader};
use crate::print::files::Unwritten;
use crate::ride::{Estimates, ROBOTS, Ride, Robots, Row, Taken, apart};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget};
use reference::exposure::Time;
use reference::frame::{Pose, Robot, World, wrap};
use std::collections::VecDeque;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A clock that has run longer than this when the wheels are first read was not started with the log, microseconds (ROUTE-8).
const STARTED_WITH_THE_LOG: u64 = 1_000_000;

/// Rows that wait for a truth at the most.
const WAITING: usize = 1000;

/// The longest time between two truths that is bridged, microseconds.
const LONGEST_GAP: u64 = 500_000;

/// Rows between two looks at the progress.
const TICK: u64 = 1000;

#[derive(Args)]
#[command(after_help = "Examples:
  barloc route triangle --runs 1 --out target/log    a log to replay
  barloc replay target/log                           where the robot was, by both pipelines

DIR has odometry.csv (t_s,left_steps,right_steps: steps since the row before; or t_s,forward_m_s,turn_rad_s), either frames.csv
(t_start_s,t_end_s,t_processed_s,file: images) or observations.csv (poses of the robot in the frames of landmarks, with their
covariances), robot.toml (what the robot knows; without it an e-puck on the default grid) and, to compare with, truth.csv
(t_s,x_m,y_m,theta_rad).")]
pub(super) struct Arguments {
    /// Folder with a robot's log
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Folder for the estimates of both pipelines [default: that of the log]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Differences of which none is kept: metres, and radians.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    count: u64,
    sum: (f64, f64),
    largest: (f64, f64),
    last: (f64, f64),
}

impl Errors {
    fn add(&mut self, (position, heading): (f64, f64)) {
        self.count += 1;
        self.sum = (self.sum.0 + position, self.sum.1 + heading);
        self.largest = (self.largest.0.max(position), self.largest.1.max(heading));
        self.last = (position, heading);
    }

    fn mean(&self) -> (f64, f64) {
        let count = self.count.max(1) as f64;
        (self.sum.0 / count, self.sum.1 / count)
    }
}

/// The truth between its stamps, which need not be those of the wheels (ROUTE-11).
#[derive(Default)]
struct Truth {
    /// The last two.
    known: [Option<(Time, Pose<World, Robot>)>; 2],
    /// Rows after the newest truth, or at most [`WAITING`] of them.
    waiting: VecDeque<Row>,
}

impl Truth {
    fn wait(&mut self, row: Row) {
        if self.waiting.len() == WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(row);
    }

    /// A truth that is not later than the one before is nothing to go by.
    fn add(&mut self, time: Time, pose: Pose<World, Robot>) {
        if self.known[1].is_none_or(|(last, _)| time > last) {
            self.known = [self.known[1], Some((time, pose))];
        }
    }

    /// The next row that a truth has reached, and the truth at its time; rows for which there is none are passed over.
    fn next(&mut self) -> Option<(Row, Pose<World, Robot>)> {
        let (newest, _) = self.known[1]?;
        while self.waiting.front().is_some_and(|row| row.time <= newest) {
            let row = self.waiting.pop_front()?;
            if let Some(truth) = self.at(row.time) {
                return Some((row, truth));
            }
        }
        None
    }

    //= reference/SPEC.md#route
    //# - **ROUTE-11** With a log's truth each estimate MUST be compared with the truth at its time, in proportion
    //# between two stamps that are at most 500 ms apart, and not at all elsewhere.
    fn at(&self, time: Time) -> Option<Pose<World, Robot>> {
        let (to, after) = self.known[1]?;
        if time == to {
            return Some(after);
        }
        let (from, before) = self.known[0]?;
        if time < from || to.since(from) > LONGEST_GAP {
            return None;
        }
        let share = time.since(from) as f64 / to.since(from) as f64;
        let between = |one: f64, other: f64| one + share * (other - one);
        let theta = before.theta() + share * wrap(after.theta() - before.theta());
        Some(Pose::new(between(before.x(), after.x()), between(before.y(), after.y()), theta))
    }
}

/// What a replay comes to.
#[derive(Default)]
struct Totals {
    rows: u64,
    errors: [Errors; ROBOTS.len()],
    between: Errors,
    taken: [Taken; 2],
    truth: Truth,
}

impl Totals {
    fn note(&mut self, row: Row) {
        self.rows += 1;
        self.between.add(apart(&row.known[0].pose, &row.known[1].pose));
        for (all, taken) in self.taken.iter_mut().zip(&row.taken) {
            *all = all.and(taken);
        }
        self.truth.wait(row);
        self.compare();
    }

    fn truth(&mut self, time: Time, pose: Pose<World, Robot>) {
        self.truth.add(time, pose);
        self.compare();
    }

    fn compare(&mut self) {
        while let Some((row, truth)) = self.truth.next() {
            for (errors, known) in self.errors.iter_mut().zip(&row.known) {
                errors.add(apart(&known.pose, &truth));
            }
        }
    }
}

/// When a ride begins whose first reading is at a time (ROUTE-8).
//= reference/SPEC.md#route
//# - **ROUTE-8** A log MUST begin at the clock's zero if its first reading is later than that by at most 1 s, and
//# otherwise with its first reading, of which only the time counts then.
fn begin(first: Time) -> Time {
    if (1..=STARTED_WITH_THE_LOG).contains(&first.as_micros()) { Time::default() } else { first }
}

/// A log on its way through both pipelines.
struct Replay<'a> {
    robots: &'a Robots,
    /// `None` before the first reading.
    ride: Option<Ride<'a>>,
    /// What came before it.
    early: Vec<Event>,
    estimates: Estimates,
    totals: Totals,
    bar: ProgressBar,
}

impl Replay<'_> {
    fn take(&mut self, event: Event) -> Result<(), Failure> {
        if self.ride.is_none() {
            let Event::Reading(reading) = &event else {
                self.early.push(event);
                return Ok(());
            };
            let from = begin(reading.time.into());
            let mut ride = self.robots.ride(from);
            for event in self.early.drain(..) {
                ride.take(&event);
            }
            self.ride = Some(ride);
            if from == Time::from(reading.time) {
                return Ok(());
            }
        }
        let row = self.ride.as_mut().and_then(|ride| ride.take(&event));
        row.map_or(Ok(()), |row| self.row(row))?;
        if let Event::Truth(truth) = &event {
            self.totals.truth(truth.time.into(), truth.robot_in_world());
        }
        Ok(())
    }

    fn row(&mut self, row: Row) -> Result<(), Failure> {
        let written = self.estimates.row(&row).map_err(|error| Failure::Input(error.to_string()));
        self.totals.note(row);
        if self.totals.rows.is_multiple_of(TICK) {
            self.bar.set_message(format!("{} readings", self.totals.rows));
            self.bar.tick();
        }
        written
    }

    fn finish(mut self) -> Result<(Totals, Vec<PathBuf>), Failure> {
        if let Some(row) = self.ride.as_mut().and_then(Ride::close) {
            self.row(row)?;
        }
        self.bar.finish_and_clear();
        if self.totals.rows == 0 {
            return Ok((self.totals, Vec::new()));
        }
        let paths = self.estimates.finish().map_err(|error| Failure::Input(error.to_string()))?;
        Ok((self.totals, paths))
    }
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let folder = &arguments.folder;
    let knowledge = Knowledge::of_log(folder).map_err(|error| Failure::Input(error.to_string()))?;
    let robots = Robots::new(&knowledge).map_err(|error| Failure::Input(error.to_string()))?;
    let mut reader = LogReader::open(folder, &knowledge.camera).map_err(|fault| Failure::Input(fault.to_string()))?;
    let results = arguments.out.as_ref().unwrap_or(folder);
    let mut replay = Replay {
        robots: &robots,
        ride: None,
        early: Vec::new(),
        estimates: create(results).map_err(|error| Failure::Input(error.to_string()))?,
        totals: Totals::default(),
        bar: ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(4)),
    };
    // What is left out is counted by the reader.
    for event in reader.by_ref().flatten() {
        replay.take(event)?;
    }
    let (totals, paths) = replay.finish()?;
    write!(out, "{}", reader.summary())?;
    if totals.rows == 0 {
        return Err(Failure::Input(format!("{}: no reading of the wheels could be used", folder.display())));
    }
    print(&totals, &paths, out)?;
    Ok(Exit::Success)
}

fn create(folder: &Path) -> Result<Estimates, Unwritten> {
    fs::create_dir_all(folder).map_err(|error| Unwritten { path: folder.to_owned(), error })?;
    Estimates::create(folder)
}

fn print(totals: &Totals, paths: &[PathBuf], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "\n{} readings of the wheels", totals.rows)?;
    for (name, taken) in ROBOTS.iter().zip(&totals.taken) {
        let Taken { images, used, gated, recovered, refused, .. } = taken;
        writeln!(
            out,
            "{name:<11} {images} images with a known landmark, {used} observations used, {gated} not, {recovered} \
             recoveries, {refused} refused as late, double or too many"
        )?;
    }
    for (name, errors) in ROBOTS.iter().zip(&totals.errors).filter(|(_, errors)| errors.count > 0) {
        let (mean, degrees) = (errors.mean(), f64::to_degrees(1.0));
        writeln!(
            out,
            "{name:<11} error {:.2} cm and {:.2}° in the mean, {:.2} cm and {:.2}° at most, {:.2} cm and {:.2}° at the end",
            100.0 * mean.0,
            degrees * mean.1,
            100.0 * errors.largest.0,
            degrees * errors.largest.1,
            100.0 * errors.last.0,
            degrees * errors.last.1
        )?;
    }
    let (position, heading) = totals.between.largest;
    writeln!(out, "both pipelines within {:.4} mm and {:.5}° of each other", 1000.0 * position, heading.to_degrees())?;
    paths.iter().try_for_each(|path| writeln!(out, "{}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ride::Known;
    use core::f64::consts::TAU;
    use nalgebra::Matrix3;

    fn row(millis: u64) -> Row {
        let known = Known { pose: Pose::new(0.0, 0.0, 0.0), covariance: Matrix3::identity() };
        Row {
            time: Time::from_micros(1000 * millis),
            known: vec![known; 3],
            taken: vec![Taken::default(); 3],
            truth: None,
        }
    }

    /// Truths of a camera on the ceiling, which has a clock of its own: 1 m ahead and 0.4 rad more from 100 to 300 ms.
    //= reference/SPEC.md#route
    //= type=test
    //# - **ROUTE-11** With a log's truth each estimate MUST be compared with the truth at its time, in proportion
    //# between two stamps that are at most 500 ms apart, and not at all elsewhere.
    #[test]
    fn the_truth_is_taken_between_its_stamps() {
        let mut totals = Totals::default();
        let at = |millis: u64| Time::from_micros(1000 * millis);
        totals.truth(at(100), Pose::new(0.0, 0.0, 3.0));
        totals.note(row(50));
        totals.note(row(150));
        assert_eq!(totals.errors[0].count, 0, "what comes is not known yet");
        totals.truth(at(300), Pose::new(1.0, 0.0, -TAU + 3.4));
        assert_eq!(totals.errors[0].count, 1, "before the first truth nothing is compared");
        let (position, heading) = totals.errors[0].last;
        assert!((position - 0.25).abs() < 1e-12 && (heading - 3.1).abs() < 1e-12, "{position} {heading}");
        // Nothing is made up across a gap.
        totals.note(row(400));
        totals.truth(at(1400), Pose::new(1.0, 0.0, 0.0));
        assert_eq!(totals.errors[0].count, 1);
        totals.note(row(1400));
        assert_eq!(totals.errors[0].count, 2);
    }

    //= reference/SPEC.md#route
    //= type=test
    //# - **ROUTE-8** A log MUST begin at the clock's zero if its first reading is later than that by at most 1 s, and
    //# otherwise with its first reading, of which only the time counts then.
    #[test]
    fn a_clock_that_is_not_the_log_s_begins_with_the_first_reading() {
        let at = Time::from_micros;
        assert_eq!(begin(at(100_000)), at(0));
        assert_eq!(begin(at(0)), at(0));
        assert_eq!(begin(at(1_700_000_000_000_000)), at(1_700_000_000_000_000));
    }
}
