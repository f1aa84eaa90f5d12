//! `barloc accuracy`

use super::{Exit, Failure};
use crate::accuracy::{Conditions, Estimator, Pipeline, Point, Rows, grid, measure};
use crate::drawing::accuracy::{Row, draw};
use clap::Args;
use comfy_table::{CellAlignment, Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::fs;
use std::io::Write;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_help = "Examples:
  barloc accuracy                                   noise 2, blur 0.5 px, as a table
  barloc accuracy --noise 1,2,4,8 --blur 0.3,0.8    other sensors as well
  barloc accuracy --svg target/accuracy.svg         the standard deviations beside the bound, drawn
  barloc accuracy --json --views 1000               all numbers, more certain ones

The fit always starts from a blur of 0.5 px. A noise is combined with a blur of 0.5 px, a blur with a noise of 2.
Ratios are standard deviations of the errors in units of the Cramer-Rao bound, along the major axis of (x, y), in heading
and in the image parameters a, s and k; the bound along the minor axis is the one carried through the bend of (x, y, theta).
Beyond 45 cm a landmark with layers of 50 mm is seen; the default one, whose layers no longer fill the rows, is listed apart.")]
pub(super) struct Arguments {
    /// Views of each point
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u64).range(10..=1_000_000))]
    views: u64,
    /// Seed of everything random
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Standard deviations of the noise, grey levels
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [Conditions::NOMINAL.noise], value_parser = noise)]
    noise: Vec<f64>,
    /// Standard deviations of the true blur, pixels
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [Conditions::NOMINAL.blur], value_parser = blur)]
    blur: Vec<f64>,
    /// Draw the first conditions into this file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// All numbers as JSON instead of a table
    #[arg(long)]
    json: bool,
}

fn noise(text: &str) -> Result<f64, String> {
    within(text, 0.1, 30.0, "grey levels")
}

fn blur(text: &str) -> Result<f64, String> {
    within(text, 0.2, 1.2, "pixels")
}

fn within(text: &str, least: f64, most: f64, unit: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("it must be a number from {least} to {most} {unit}")),
    }
}

/// A line of `--json`.
#[derive(Serialize)]
struct Line {
    pipeline: &'static str,
    estimator: &'static str,
    distance_m: f64,
    inclination_deg: f64,
    noise_grey: f64,
    blur_px: f64,
    rows: &'static str,
    narrowest_stripe_px: f64,
    views: u64,
    found: u64,
    sigma_major_m: f64,
    sigma_minor_m: f64,
    sigma_theta_rad: f64,
    bound_major_m: f64,
    bound_minor_m: f64,
    bound_theta_rad: f64,
    ratio_major: f64,
    ratio_theta: f64,
    /// Of a, s and k: standard deviation in units of the bound.
    ratio_image: [f64; 3],
    /// Of a, s and k: mean error in standard deviations.
    bias: [f64; 3],
    /// In (x, y, theta).
    nees: f64,
    nees_image: Option<f64>,
    nees_image_band: Option<[f64; 2]>,
}

fn pipeline_name(pipeline: Pipeline) -> &'static str {
    match pipeline {
        Pipeline::Reference => "reference",
        Pipeline::Fixedpoint => "fixedpoint",
    }
}

fn estimator_name(estimator: Estimator) -> &'static str {
    match estimator {
        Estimator::Fit => "fit",
        Estimator::Paper => "paper",
    }
}

/// Two-sided 95 % of a normal distribution, standard deviations.
const NINETY_FIVE_PERCENT: f64 = 1.96;

impl Line {
    fn new((point, pipeline, estimator, measured): &Row) -> Self {
        let fitted = *estimator == Estimator::Fit && measured.found > 1;
        let (least, most) = measured.band().ends(NINETY_FIVE_PERCENT);
        Self {
            pipeline: pipeline_name(*pipeline),
            estimator: estimator_name(*estimator),
            distance_m: f64::from(point.centimetres) / 100.0,
            inclination_deg: f64::from(point.degrees),
            noise_grey: point.conditions.noise,
            blur_px: point.conditions.blur,
            rows: if point.rows == Rows::Inside { "inside" } else { "partly off" },
            narrowest_stripe_px: measured.stripe.mean(),
            views: measured.views,
            found: measured.found,
            sigma_major_m: measured.major.deviation(),
            sigma_minor_m: measured.minor.deviation(),
            sigma_theta_rad: measured.theta.deviation(),
            bound_major_m: measured.major_bound.root_mean_square(),
            bound_minor_m: measured.minor_bound.root_mean_square(),
            bound_theta_rad: measured.theta_bound.root_mean_square(),
            ratio_major: measured.major_ratio.deviation(),
            ratio_theta: measured.theta_ratio.deviation(),
            ratio_image: measured.image_ratio.map(|spread| spread.deviation()),
            bias: measured.image_ratio.map(|spread| spread.mean() / spread.deviation()),
            nees: measured.nees.mean(),
            nees_image: fitted.then(|| measured.image_nees.mean()),
            nees_image_band: fitted.then_some([least, most]),
        }
    }
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let conditions = Conditions::crossed(&arguments.noise, &arguments.blur);
    // What is wrong with the file is said before the work and not after it.
    if let Some(path) = &arguments.svg {
        let opened = fs::OpenOptions::new().create(true).append(true).open(path);
        opened.map_err(|error| Failure::Input(format!("{}: cannot be written: {error}", path.display())))?;
    }
    let rows = rows(&grid(&conditions), arguments);
    if let Some(path) = &arguments.svg {
        let first: Vec<Row> = rows.iter().filter(|(point, ..)| point.conditions == conditions[0]).cloned().collect();
        let failed = |error: &dyn core::fmt::Display| Failure::Input(format!("{}: {error}", path.display()));
        let svg = draw(&first).map_err(|error| failed(&error))?;
        fs::write(path, svg).map_err(|error| failed(&error))?;
    }
    if arguments.json {
        let lines: Vec<Line> = rows.iter().map(Line::new).collect();
        serde_json::to_writer(&mut *out, &lines).map_err(std::io::Error::from)?;
        writeln!(out)?;
    } else {
        for condition in conditions {
            let these = rows.iter().filter(|(point, ..)| point.conditions == condition);
            writeln!(out, "noise {} grey levels, blur {} px", condition.noise, condition.blur)?;
            writeln!(out, "{}\n", table(these))?;
        }
    }
    Ok(Exit::Success)
}

fn rows(points: &[Point], arguments: &Arguments) -> Vec<Row> {
    let progress = ProgressBar::new(points.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} points, {eta} left") {
        progress.set_style(style);
    }
    let mut rows = Vec::new();
    for point in points {
        let measured = measure(point, arguments.views, arguments.seed);
        rows.extend(
            measured.into_iter().map(|(pipeline, estimator, measured)| (*point, pipeline, estimator, measured)),
        );
        progress.inc(1);
    }
    progress.finish_and_clear();
    rows
}

fn table<'a>(rows: impl Iterator<Item = &'a Row>) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header([
        "cm",
        "deg",
        "px",
        "estimator",
        "found",
        "major mm",
        "bound",
        "ratio",
        "minor mm",
        "bound",
        "theta deg",
        "ratio",
        "a",
        "s",
        "k",
        "NEES ask",
        "band",
        "NEES xyt",
    ]);
    for row in rows {
        table.add_row(cells(row));
    }
    table.column_iter_mut().enumerate().filter(|(column, _)| *column != 3).for_each(|(_, column)| {
        column.set_cell_alignment(CellAlignment::Right);
    });
    table
}

fn cells(row: &Row) -> Vec<String> {
    let (point, pipeline, estimator, measured) = row;
    let line = Line::new(row);
    let number = |value: f64, digits: usize| {
        if value.is_finite() { format!("{value:.digits$}") } else { "-".to_owned() }
    };
    let apart = if point.rows == Rows::Inside { "" } else { ", partly off" };
    let name = match estimator {
        Estimator::Fit => format!("fit {}{apart}", pipeline_name(*pipeline)),
        Estimator::Paper => format!("paper {}{apart}", pipeline_name(*pipeline)),
    };
    let band = line.nees_image_band.map_or("-".to_owned(), |[least, most]| format!("{least:.2} to {most:.2}"));
    let mut cells = vec![
        point.centimetres.to_string(),
        point.degrees.to_string(),
        number(line.narrowest_stripe_px, 2),
        name,
        format!("{}/{}", measured.found, measured.views),
        number(1e3 * line.sigma_major_m, 2),
        number(1e3 * line.bound_major_m, 2),
        number(line.ratio_major, 2),
        number(1e3 * line.sigma_minor_m, 3),
        number(1e3 * line.bound_minor_m, 3),
        number(line.sigma_theta_rad.to_degrees(), 3),
        number(line.ratio_theta, 2),
    ];
    cells.extend(line.ratio_image.map(|ratio| number(ratio, 2)));
    cells.extend([line.nees_image.map_or("-".to_owned(), |nees| number(nees, 2)), band, number(line.nees, 2)]);
    cells
}
