//! `barloc place`

use super::coverage::{RouteReport, describe_route, write_file};
use super::{Exit, Failure, LandmarkFormat, camera};
use crate::certificate::{format_name, payload_hex};
use crate::coverage::{ROUTE_STEP, heat_map};
use crate::place::{Candidate, DEFAULT_GAP, Placement, REFINE, Wish, place};
use crate::site;
use clap::Args;
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_help = "Examples:
  barloc place tests/data/sites/triangle.toml
  barloc place -o target/site.toml --svg target/site.svg tests/data/sites/triangle.toml
  barloc place --json --gap 2.5 --landmark wide site.toml

Landmarks hang on points of the site's grid that lie on walls. Those that the site has already stay and count. The default
gap is 1 m, in which the odometry of an uncalibrated e-puck drifts about 46 mm after a turn of 120° (SPEC.md, PLACE-2).")]
pub(super) struct Arguments {
    /// Site file (TOML) with a route
    #[arg(value_name = "SITE")]
    site: PathBuf,
    /// Longest way along the route without a readable landmark
    #[arg(long, value_name = "METRES", default_value_t = DEFAULT_GAP)]
    gap: f64,
    /// Format of the landmarks
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = LandmarkFormat::Paper)]
    landmark: LandmarkFormat,
    /// Distance of poses along the route; the result is checked at a fifth of it
    #[arg(long, value_name = "METRES", default_value_t = ROUTE_STEP)]
    step: f64,
    /// Camera description (TOML); the e-puck's camera if left out
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Write the site with the landmarks in it
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw the site with the landmarks in it
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// One line of JSON instead of text
    #[arg(long)]
    json: bool,
}

/// The line of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    site: &'a str,
    gap_m: f64,
    step_m: f64,
    check_step_m: f64,
    landmarks: usize,
    /// No placement has fewer.
    lower_bound: usize,
    /// Optimum of the linear relaxation.
    relaxation: f64,
    /// Stretches of the route, a gap long, of which no landmark serves two: where they begin.
    disjoint_stretches_from_m: Vec<f64>,
    /// Whether branch and bound proved that fewer do not do.
    proven_fewest: bool,
    route: RouteReport,
    added: Vec<Added>,
}

#[derive(Serialize)]
struct Added {
    /// Counted from 1, in the order of the file.
    wall: usize,
    format: &'static str,
    payload: String,
    codes: [u32; 3],
    x_m: f64,
    y_m: f64,
    heading_deg: f64,
}

impl From<&Candidate> for Added {
    fn from(chosen: &Candidate) -> Self {
        let (pose, format) = (&chosen.posted.landmark_in_world, chosen.posted.landmark.format);
        Self {
            wall: chosen.wall + 1,
            format: format_name(format),
            payload: payload_hex(format, chosen.posted.payload),
            codes: [chosen.codes.x, chosen.codes.y, chosen.codes.theta],
            x_m: pose.x(),
            y_m: pose.y(),
            heading_deg: pose.theta().to_degrees(),
        }
    }
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let camera = camera(arguments.camera.as_deref())?;
    let path = &arguments.site;
    let refused = |error: site::SiteError| Failure::Input(error.to_string());
    let text = site::read(path).map_err(refused)?;
    let site = site::of_toml(&text, path).map_err(refused)?;
    let wish = Wish { gap: arguments.gap, format: arguments.landmark.into(), step: arguments.step };
    let placed =
        place(&site, &camera, &wish).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
    if let Some(output) = &arguments.output {
        let added: Vec<_> = placed.chosen.iter().map(|chosen| (wish.format, chosen.codes)).collect();
        write_file(output, &site::with_landmarks(&text, path, &added).map_err(refused)?)?;
    }
    if let Some(svg) = &arguments.svg {
        write_file(svg, &heat_map(&placed.site, None, Some(&placed.checked)))?;
    }
    let report = report(arguments, &placed);
    if arguments.json {
        serde_json::to_writer(&mut *out, &report).map_err(std::io::Error::from)?;
        writeln!(out)?;
    } else {
        describe(&report, out)?;
    }
    Ok(Exit::Success)
}

fn report<'a>(arguments: &'a Arguments, placed: &Placement) -> Report<'a> {
    Report {
        site: arguments.site.to_str().unwrap_or("(not Unicode)"),
        gap_m: arguments.gap,
        step_m: arguments.step,
        check_step_m: arguments.step / REFINE as f64,
        landmarks: placed.chosen.len(),
        lower_bound: placed.bound.landmarks,
        relaxation: placed.bound.relaxation,
        disjoint_stretches_from_m: placed.bound.disjoint.iter().map(|stretch| stretch.from).collect(),
        proven_fewest: placed.bound.proven,
        route: RouteReport::of(&placed.site, &placed.checked),
        added: placed.chosen.iter().map(Added::from).collect(),
    }
}

fn describe(report: &Report<'_>, out: &mut impl Write) -> Result<(), Failure> {
    writeln!(
        out,
        "{} landmarks, lower bound {} (linear relaxation {:.3}, {} stretches that share no landmark{})",
        report.landmarks,
        report.lower_bound,
        report.relaxation,
        report.disjoint_stretches_from_m.len(),
        if report.proven_fewest { ", branch and bound complete" } else { "" }
    )?;
    describe_route(&report.route, out)?;
    for added in &report.added {
        let [x, y, theta] = added.codes;
        writeln!(
            out,
            "wall {}: {} {}, codes {x} {y} {theta}, x {:.4} m, y {:.4} m, heading {:.1}°",
            added.wall, added.format, added.payload, added.x_m, added.y_m, added.heading_deg
        )?;
    }
    Ok(())
}
