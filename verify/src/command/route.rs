//! `barloc route`

use super::{Exit, Failure};
use crate::log::LogWriter;
use crate::log::knowledge::{Observe, Stamp, States};
use crate::print::files::{Unwritten, write_whole};
use crate::ride::{Estimates, Row};
use crate::route::{self, Errors, Method, Report};
use crate::scenario::{self, Scenario};
use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table, presets};
use core::fmt::Display;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use reference::world::Recording;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Runs by default.
const DEFAULT_RUNS: u64 = 10;

/// Seed by default.
const DEFAULT_SEED: u64 = 1;

#[derive(Args)]
#[command(after_help = "Examples:
  barloc route                                    ten runs of five laps around a triangle
  barloc route kidnap --runs 100 --compare        wrong start and lift; poses and the paper's estimator beside it
  barloc route triangle --runs 1 --svg target/route --out target/log
                                                  pictures like the paper's figures 11 to 13, and a log to replay
  barloc route my.toml --states 3 --json          a scenario of your own; verify/scenarios has examples")]
pub(super) struct Arguments {
    /// `triangle`, `kidnap` or a scenario file
    #[arg(value_name = "SCENARIO", default_value = "triangle")]
    scenario: String,
    /// Number of runs, each with wheels, noise and mishaps of its own
    #[arg(long, value_name = "N", default_value_t = DEFAULT_RUNS, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    runs: u64,
    /// Seed of everything random
    #[arg(long, value_name = "S", default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Estimate the pose alone, or the wheels too
    #[arg(long, value_name = "3|5", default_value = "5")]
    states: NumberOfStates,
    /// What the filter is given: where a barcode is in the image, the pose that follows, or the paper's estimate of it
    #[arg(long, value_name = "WHAT", default_value = "image")]
    observe: What,
    /// When an image counts as seen: row by row as it was exposed, or in the middle of its processing, as in the paper
    #[arg(long, value_name = "WHEN", default_value = "exposure")]
    stamp: When,
    /// Run poses as observations, the paper's stamp and the paper's estimator beside it
    #[arg(long)]
    compare: bool,
    /// Folder for each run's log and estimates; with one run, the log's own folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder for drawings of the first run
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum NumberOfStates {
    #[value(name = "3")]
    Three,
    #[value(name = "5")]
    Five,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    Image,
    Pose,
    Paper,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum When {
    Exposure,
    Processing,
}

impl Arguments {
    fn method(&self) -> Method {
        Method {
            states: match self.states {
                NumberOfStates::Three => States::Three,
                NumberOfStates::Five => States::Five,
            },
            observe: match self.observe {
                What::Image => Observe::Image,
                What::Pose => Observe::Pose,
                What::Paper => Observe::Paper,
            },
            stamp: match self.stamp {
                When::Exposure => Stamp::Exposure,
                When::Processing => Stamp::Processing,
            },
        }
    }

    /// What is run, by name; the first is what was asked for.
    fn methods(&self) -> Vec<(&'static str, Method)> {
        let asked = self.method();
        let mut methods = vec![("", asked)];
        if self.compare {
            methods.extend([
                ("three states", Method { states: States::Three, ..asked }),
                ("poses as observations", Method { observe: Observe::Pose, ..asked }),
                ("the paper's stamp", Method { stamp: Stamp::Processing, ..asked }),
                ("the paper's estimator", Method::paper()),
            ]);
        }
        methods
    }
}

fn input(error: impl Display) -> Failure {
    Failure::Input(error.to_string())
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let scenario = scenario::load(Path::new(&arguments.scenario)).map_err(input)?;
    let methods = arguments.methods();
    let bar = ProgressBar::with_draw_target(Some(arguments.runs), ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} runs, {eta} left") {
        bar.set_style(style);
    }
    let only: Vec<Method> = methods.iter().map(|(_, method)| *method).collect();
    let runs = route::runs(&scenario.setup, &only, (arguments.runs, arguments.seed), &|| bar.inc(1)).map_err(input)?;
    bar.finish_and_clear();
    let reports = runs.iter().filter_map(|runs| route::report(&arguments.scenario, arguments.seed, runs));
    let reports: Vec<Report> = reports.collect();
    let written = files(arguments, &scenario)?;
    if arguments.json {
        print_json(&methods, &reports, out)?;
    } else {
        print(&methods, &reports, out)?;
        for path in written {
            writeln!(out, "{}", path.display())?;
        }
    }
    Ok(Exit::Success)
}

/// The report that was asked for; those beside it, by name, under `compared`.
fn print_json(methods: &[(&str, Method)], reports: &[Report], out: &mut impl Write) -> Result<(), Failure> {
    let as_value = |report: &Report| serde_json::to_value(report).map_err(|error| Failure::Output(error.into()));
    let Some(first) = reports.first() else { return Ok(()) };
    let mut value = as_value(first)?;
    let beside = methods.iter().zip(reports).skip(1);
    let beside: Result<Vec<_>, Failure> =
        beside.map(|((name, _), report)| Ok(((*name).to_owned(), as_value(report)?))).collect();
    let beside = beside?;
    if !beside.is_empty() {
        value["compared"] = beside.into_iter().collect::<serde_json::Map<_, _>>().into();
    }
    let text = serde_json::to_string_pretty(&value).map_err(|error| Failure::Output(error.into()))?;
    Ok(writeln!(out, "{text}")?)
}

fn print(methods: &[(&str, Method)], reports: &[Report], out: &mut impl Write) -> Result<(), Failure> {
    let Some(first) = reports.first() else { return Ok(()) };
    writeln!(out, "{}, {} runs, seed {}\n", first.scenario, first.runs, first.seed)?;
    writeln!(out, "{}\n", table(methods, reports))?;
    let wheels = &first.odometry;
    writeln!(
        out,
        "wheels alone: {:.1} cm off at the end in the mean of the runs, {:.1} cm over all samples, {:.1} cm at most",
        100.0 * wheels.mean_final_error_m,
        100.0 * wheels.mean_position_error_m,
        100.0 * wheels.max_position_error_m
    )?;
    let [low, high] = first.reference.nees_band;
    writeln!(out, "the mean NEES of {} runs lies between {low:.2} and {high:.2} in 95 of 100 cases", first.runs)?;
    for ((name, _), report) in methods.iter().zip(reports) {
        let name = if name.is_empty() { "both pipelines" } else { name };
        let (all, alike) = (&report.largest_difference, &report.largest_difference_decided_alike);
        writeln!(
            out,
            "{name}: within {:.3} mm and {:.4}° of each other where they decided alike ({:.3} mm and {:.4}° everywhere; at {} \
             readings they had decided differently)",
            1000.0 * alike.position_m,
            alike.heading_rad.to_degrees(),
            1000.0 * all.position_m,
            all.heading_rad.to_degrees(),
            report.decided_differently.all()
        )?;
    }
    Ok(())
}

/// A row for each pipeline of each method.
fn table(methods: &[(&str, Method)], reports: &[Report]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    let heads = [
        "",
        "mean cm",
        "95 %",
        "most",
        "mean °",
        "95 %",
        "NEES",
        "used",
        "gated",
        "recoveries",
        "images",
        "harmful",
        "lost",
    ];
    table.set_header(heads);
    for ((name, _), report) in methods.iter().zip(reports) {
        for (pipeline, errors) in [("reference", &report.reference), ("fixedpoint", &report.fixedpoint)] {
            let name = if name.is_empty() { pipeline.to_owned() } else { format!("{pipeline}, {name}") };
            table.add_row(cells(name, errors));
        }
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn cells(name: String, errors: &Errors) -> Vec<String> {
    let centimetres = |metres: f64| format!("{:.2}", 100.0 * metres);
    let degrees = |radians: f64| format!("{:.2}", radians.to_degrees());
    let mut images: Vec<u64> = errors.recoveries.iter().map(|recovery| recovery.images).collect();
    images.sort_unstable();
    let span = match images.as_slice() {
        [] => String::from("-"),
        [.., last] => format!("{} to {last}", images[images.len() / 2]),
    };
    let harmful = errors.recoveries.iter().filter(|recovery| recovery.harmful).count();
    vec![
        name,
        centimetres(errors.mean_position_error_m),
        centimetres(errors.p95_position_error_m),
        centimetres(errors.max_position_error_m),
        degrees(errors.mean_heading_error_rad),
        degrees(errors.p95_heading_error_rad),
        format!("{:.2}", errors.mean_nees),
        errors.observations_used.to_string(),
        errors.observations_gated.to_string(),
        images.len().to_string(),
        span,
        harmful.to_string(),
        errors.lost.to_string(),
    ]
}

/// Logs, estimates and drawings that were asked for: their paths.
fn files(arguments: &Arguments, scenario: &Scenario) -> Result<Vec<PathBuf>, Failure> {
    let mut paths = Vec::new();
    if let Some(folder) = &arguments.out {
        for number in 0..arguments.runs {
            let folder = if arguments.runs == 1 { folder.clone() } else { folder.join(format!("{number:04}")) };
            log(arguments, scenario, number, &folder)?;
            paths.push(folder);
        }
    }
    if let Some(folder) = &arguments.svg {
        let recording = scenario.setup.record(arguments.seed, 0).map_err(input)?;
        let drawn = route::pictures(&arguments.scenario, scenario, &recording, arguments.method()).map_err(input)?;
        fs::create_dir_all(folder).map_err(|error| input(Unwritten { path: folder.clone(), error }))?;
        let files = drawn.map(|(name, text)| (folder.join(name), text.into_bytes()));
        write_whole(&files).map_err(input)?;
        paths.extend(files.into_iter().map(|(path, _)| path));
    }
    Ok(paths)
}

/// A run's log and what both pipelines make of it.
fn log(arguments: &Arguments, scenario: &Scenario, number: u64, folder: &Path) -> Result<(), Failure> {
    let recording = scenario.setup.record(arguments.seed, number).map_err(input)?;
    write_log(&recording, arguments, scenario, folder)?;
    let mut estimates = Estimates::create(folder).map_err(input)?;
    let mut unwritten = None;
    let each = |row: &Row| unwritten = unwritten.take().or_else(|| estimates.row(row).err());
    route::run(&scenario.setup, &recording, arguments.method(), each).map_err(input)?;
    unwritten.map_or(Ok(()), |error| Err(input(error)))?;
    estimates.finish().map_err(input)?;
    Ok(())
}

fn write_log(recording: &Recording, arguments: &Arguments, scenario: &Scenario, folder: &Path) -> Result<(), Failure> {
    let knowledge = route::told(&scenario.setup, recording, arguments.method());
    let mut log = LogWriter::create(folder, &knowledge).map_err(input)?;
    for event in route::events(recording) {
        log.event(&event).map_err(input)?;
    }
    log.finish().map_err(input)
}
