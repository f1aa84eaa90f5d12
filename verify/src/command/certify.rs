//! `barloc certify`

use super::{Exit, Failure};
use crate::campaign::{Campaign, Plan};
use crate::certificate::{Certificate, Verdict};
use crate::disturb::Disturbance;
use crate::renders;
use crate::route;
use crate::summary::summary;
use clap::Args;
use core::fmt::Display;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use reference::camera::Camera;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Random scenes by default.
const DEFAULT_FRAMES: u64 = 20_000;

/// Seed by default.
const DEFAULT_SEED: u64 = 1;

/// Runs of each route by default.
const DEFAULT_ROUTES: u64 = 2;

/// Folder by default.
const DEFAULT_OUT: &str = "target/certify";

/// Random scenes of a self-test run: enough for every stage to have cases.
const SELF_TEST_FRAMES: u64 = 200;

/// A disturbance that the comparison must see, and one that it must not mind, as shares of the bound.
const BEYOND: f64 = 1.02;
const WITHIN: f64 = 0.98;

#[derive(Args)]
#[command(after_help = "Examples:
  barloc certify                        60 images, the paper's data set, frontal views, 20,000 random scenes, 4 routes
  barloc certify --frames 100000        more scenes
  barloc certify --json                 the certificate on standard output
  barloc certify --self-test            disturb every stage and see that the comparison names it")]
pub(super) struct Arguments {
    /// Random scenes to run
    #[arg(long, value_name = "N", default_value_t = DEFAULT_FRAMES)]
    frames: u64,
    /// Seed of everything random
    #[arg(long, value_name = "S", default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Runs of each built-in route, triangle and kidnap
    #[arg(long, value_name = "N", default_value_t = DEFAULT_ROUTES)]
    routes: u64,
    /// Folder for certificate.json
    #[arg(long, value_name = "DIR", default_value = DEFAULT_OUT)]
    out: PathBuf,
    /// Folder of images with a truth.csv
    #[arg(long, value_name = "DIR", default_value_os_t = default_renders())]
    renders: PathBuf,
    /// Print the certificate instead of tables
    #[arg(long)]
    json: bool,
    /// Disturb each stage of the port slightly beyond its bound and show that the run fails and names it
    #[arg(long, conflicts_with_all = ["frames", "routes", "out", "json"])]
    self_test: bool,
}

impl Default for Arguments {
    /// What `barloc certify` means without arguments.
    fn default() -> Self {
        Self {
            frames: DEFAULT_FRAMES,
            seed: DEFAULT_SEED,
            routes: DEFAULT_ROUTES,
            out: PathBuf::from(DEFAULT_OUT),
            renders: default_renders(),
            json: false,
            self_test: false,
        }
    }
}

/// The images that come with the project: here, or where the command was built.
fn default_renders() -> PathBuf {
    let here = PathBuf::from("tests/data/renders");
    if here.is_dir() { here } else { Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/renders") }
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let renders =
        renders::load(&arguments.renders, &Camera::epuck()).map_err(|error| Failure::Input(error.to_string()))?;
    if arguments.self_test {
        let plan = Plan { frames: SELF_TEST_FRAMES, seed: arguments.seed, renders };
        return self_test(&plan, out);
    }
    let plan = Plan { frames: arguments.frames, seed: arguments.seed, renders };
    // Before the work: a campaign may take hours.
    let unwritten = Unwritten::create(&arguments.out)?;
    let started = Instant::now();
    let certificate = certify(&plan, arguments.routes)?;
    let seconds = started.elapsed().as_secs_f64();
    let path = unwritten.write(&certificate)?;
    if arguments.json {
        out.write_all(certificate.to_json().as_bytes())?;
    } else {
        write!(out, "{}", summary(&certificate))?;
        let speed = certificate.frames as f64 / seconds;
        writeln!(out, "{seconds:.1} s, {speed:.0} frames per second in lockstep; certificate: {}", path.display())?;
    }
    Ok(if certificate.verdict == Verdict::Pass { Exit::Success } else { Exit::Different })
}

fn certify(plan: &Plan, routes: u64) -> Result<Certificate, Failure> {
    let bar = ProgressBar::with_draw_target(Some(Campaign::frames(plan)), ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left") {
        bar.set_style(style);
    }
    let progress = |frames| bar.inc(frames);
    let (findings, renders) = Campaign::new(plan, None, &progress).run();
    bar.finish_and_clear();
    let certificate = Certificate::new(plan, &findings, &renders);
    if routes == 0 {
        return Ok(certificate);
    }
    let routes = route::built_in(routes, plan.seed).map_err(|error| Failure::Input(error.to_string()))?;
    Ok(certificate.with_routes(routes))
}

/// A certificate's file before there is a certificate: written whole or not at all.
struct Unwritten {
    path: PathBuf,
    part: PathBuf,
}

impl Unwritten {
    fn create(folder: &Path) -> Result<Self, Failure> {
        fs::create_dir_all(folder)
            .map_err(|error| Failure::Input(format!("{}: cannot be made a folder: {error}", folder.display())))?;
        let unwritten = Self { path: folder.join("certificate.json"), part: folder.join("certificate.json.part") };
        if unwritten.path.is_dir() {
            return Err(unwritten.failure(&"it is a folder"));
        }
        fs::write(&unwritten.part, "").map_err(|error| unwritten.failure(&error))?;
        Ok(unwritten)
    }

    fn write(&self, certificate: &Certificate) -> Result<&Path, Failure> {
        fs::write(&self.part, certificate.to_json())
            .and_then(|()| fs::rename(&self.part, &self.path))
            .map_err(|error| self.failure(&error))?;
        Ok(&self.path)
    }

    fn failure(&self, error: &dyn Display) -> Failure {
        Failure::Input(format!("{}: cannot be written: {error}", self.path.display()))
    }
}

impl Drop for Unwritten {
    /// Whatever happened, nothing half written stays behind.
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.part);
    }
}

/// Disturbs one stage at a time: beyond its bound the run must fail and name that stage alone, within it pass.
fn self_test(plan: &Plan, out: &mut impl Write) -> Result<Exit, Failure> {
    let run = |fault| {
        let campaign = Campaign::new(plan, fault, &|_| {});
        let (renders, _) = campaign.run_renders();
        let findings = renders.merged(&campaign.run_scenes(0..plan.frames));
        (findings.tally, campaign.disturbed())
    };
    let (undisturbed, _) = run(None);
    let mut works = undisturbed.passes();
    writeln!(out, "undisturbed: {}", if works { "passes" } else { "FAILS" })?;
    for disturbance in Disturbance::ALL {
        let (tally, disturbed) = run(Some((disturbance, BEYOND)));
        let named: Vec<&str> = tally.failing().iter().map(|stage| stage.row().name).collect();
        let caught = disturbed > 0 && !tally.passes() && tally.failing() == [disturbance.stage()];
        let minded = disturbance.is_scaled() && !run(Some((disturbance, WITHIN))).0.passes();
        works &= caught && !minded;
        writeln!(
            out,
            "{}: {}: {disturbed} results disturbed, {}{}",
            disturbance.stage().row().name,
            disturbance.describe(),
            if caught { "run fails and names it".to_owned() } else { format!("NOT CAUGHT, run names {named:?}") },
            match (disturbance.is_scaled(), minded) {
                (false, _) => "",
                (true, false) => "; within the bound it passes",
                (true, true) => "; WITHIN THE BOUND IT FAILS",
            }
        )?;
    }
    writeln!(out, "{}", if works { "self-test passes" } else { "self-test FAILS" })?;
    Ok(if works { Exit::Success } else { Exit::Different })
}
