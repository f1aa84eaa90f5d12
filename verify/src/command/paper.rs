//! `barloc paper`

use super::{Exit, Failure};
use crate::figures::drawing;
use crate::figures::report::{Report, frames};
use crate::figures::studies::Plan;
use crate::figures::tables::tables;
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Views of each cell by default: a variance is then known to 8 %.
const DEFAULT_VIEWS: u32 = 300;

#[derive(Args)]
#[command(after_help = "Examples:
  barloc paper                                  Fig. 9 a), 9 b) and 10 with (11) and (12), as tables
  barloc paper --svg target/paper               and as fig9a.svg, fig9b.svg and fig10.svg in that folder
  barloc paper --views 30                       as many views as the paper had: quicker, and rougher
  barloc paper --json > target/paper.json       all numbers

Fig. 9 has the paper's 30 views of each distance and inclination. For Fig. 10 these are too few, a variance would be
known to 26 %: it has --views, and so has every centimetre of the detection ranges.")]
pub(super) struct Arguments {
    /// Views of each cell of Fig. 10 and of the ranges
    #[arg(long, value_name = "N", default_value_t = DEFAULT_VIEWS, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    views: u32,
    /// Seed of everything random
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Print all numbers as JSON instead of tables
    #[arg(long)]
    json: bool,
    /// Folder for fig9a.svg, fig9b.svg and fig10.svg
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    if let Some(folder) = &arguments.svg {
        check_writable(folder)?;
    }
    let report = report(&Plan { views: arguments.views, seed: arguments.seed });
    if let Some(folder) = &arguments.svg {
        draw(&report, folder)?;
    }
    if arguments.json {
        out.write_all(report.to_json().as_bytes())?;
    } else {
        write!(out, "{}", tables(&report))?;
        if let Some(folder) = &arguments.svg {
            writeln!(out, "pictures: {}", folder.display())?;
        }
    }
    Ok(if report.pipelines.agree() { Exit::Success } else { Exit::Different })
}

/// Makes the folder and its files, so that what is wrong with it is said before the work and not after it. Pictures
/// that are already there stay as they are.
fn check_writable(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    for (name, _) in drawing::FIGURES {
        let path = folder.join(name);
        OpenOptions::new().append(true).create(true).open(&path).map_err(|error| unwritable(&path, &error))?;
    }
    Ok(())
}

fn draw(report: &Report, folder: &Path) -> Result<(), Failure> {
    for (name, draw) in drawing::FIGURES {
        let picture = draw(report).map_err(|error| Failure::Input(format!("{name} cannot be drawn: {error}")))?;
        let path = folder.join(name);
        fs::write(&path, picture).map_err(|error| unwritable(&path, &error))?;
    }
    Ok(())
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Input(format!("{}: cannot be written: {error}", path.display()))
}

fn report(plan: &Plan) -> Report {
    let bar = ProgressBar::with_draw_target(Some(frames(plan)), ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left") {
        bar.set_style(style);
    }
    let report = Report::new(plan, &|frames| bar.inc(frames));
    bar.finish_and_clear();
    report
}
