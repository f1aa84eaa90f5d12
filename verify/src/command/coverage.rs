//! `barloc coverage`

use super::{Exit, Failure, camera};
use crate::certificate::{format_name, payload_hex};
use crate::coverage::{
    CoverageError, REGION_CELL, REGION_HEADINGS, ROUTE_STEP, RegionCoverage, RouteCoverage, cover_region, cover_route,
    heat_map,
};
use crate::site::{self, Site};
use clap::Args;
use reference::render::Posted;
use serde::Serialize;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(after_help = "Examples:
  barloc coverage tests/data/sites/triangle-placed.toml
  barloc coverage --svg target/coverage.svg tests/data/sites/triangle-placed.toml
  barloc coverage --json --step 0.001 --camera camera.toml site.toml

Readable: the whole barcode in the image, its narrowest stripe at least 1.5 px wide, its far end within the range of the
scan lines, no wall before it, no other barcode too near to it in the image (SPEC.md, SITE-10 and SITE-11). Along the
route the robot looks where it drives; turns on the spot are not counted.")]
pub(super) struct Arguments {
    /// Site file (TOML)
    #[arg(value_name = "SITE")]
    site: PathBuf,
    /// Camera description (TOML); the e-puck's camera if left out
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Distance of poses along the route
    #[arg(long, value_name = "METRES", default_value_t = ROUTE_STEP)]
    step: f64,
    /// Distance of positions in the region
    #[arg(long, value_name = "METRES", default_value_t = REGION_CELL)]
    cell: f64,
    /// Number of headings at a position of the region
    #[arg(long, value_name = "COUNT", default_value_t = REGION_HEADINGS)]
    headings: usize,
    /// Draw a heat map
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
    route: Option<RouteReport>,
    region: Option<RegionReport>,
    landmarks: Vec<LandmarkReport>,
}

/// A route's figures.
#[derive(Serialize)]
pub(super) struct RouteReport {
    length_m: f64,
    closed: bool,
    poses: usize,
    readable_poses: usize,
    share: f64,
    /// None on a closed route on which nothing is ever read.
    longest_gap_m: Option<f64>,
    longest_gap_from_m: Option<f64>,
}

impl RouteReport {
    pub(super) fn of(site: &Site, found: &RouteCoverage) -> Self {
        Self {
            length_m: found.length,
            closed: site.route.as_ref().is_some_and(|route| route.closed),
            poses: found.samples.len(),
            readable_poses: found.readable.iter().filter(|numbers| !numbers.is_empty()).count(),
            share: found.share(),
            longest_gap_m: found.longest_gap.map(|gap| gap.length),
            longest_gap_from_m: found.longest_gap.map(|gap| gap.from),
        }
    }
}

#[derive(Serialize)]
struct RegionReport {
    cell_m: f64,
    headings: usize,
    positions: usize,
    poses: usize,
    readable_poses: usize,
    share: f64,
}

/// A landmark and from how many poses it is readable.
#[derive(Serialize)]
struct LandmarkReport {
    format: &'static str,
    payload: String,
    x_m: f64,
    y_m: f64,
    heading_deg: f64,
    route_poses: Option<usize>,
    region_poses: Option<usize>,
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let camera = camera(arguments.camera.as_deref())?;
    let site = site::load(&arguments.site).map_err(|error| Failure::Input(error.to_string()))?;
    if site.route.is_none() && site.region.is_none() {
        return Err(Failure::Input(format!("{}: has neither a route nor a region", arguments.site.display())));
    }
    let refused = |error: CoverageError| Failure::Input(error.to_string());
    let route = site.route.as_ref().map(|route| cover_route(&site, route, &camera, arguments.step, 1));
    let route = route.transpose().map_err(refused)?;
    let region =
        site.region.as_ref().map(|region| cover_region(&site, region, &camera, arguments.cell, arguments.headings));
    let region = region.transpose().map_err(refused)?;
    if let Some(path) = &arguments.svg {
        write_file(path, &heat_map(&site, region.as_ref(), route.as_ref()))?;
    }
    let report = report(arguments, &site, route.as_ref(), region.as_ref());
    if arguments.json {
        serde_json::to_writer(&mut *out, &report).map_err(std::io::Error::from)?;
        writeln!(out)?;
    } else {
        describe(&report, out)?;
    }
    Ok(Exit::Success)
}

/// Writes a file and the folders that it stands in.
pub(super) fn write_file(path: &Path, text: &str) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| fs::write(path, text))
        .map_err(|error| Failure::Input(format!("{}: cannot be written: {error}", path.display())))
}

fn report<'a>(
    arguments: &'a Arguments,
    site: &Site,
    route: Option<&RouteCoverage>,
    region: Option<&RegionCoverage>,
) -> Report<'a> {
    let landmarks = site.landmarks.iter().enumerate().map(|(i, posted)| landmark_report(i, posted, route, region));
    Report {
        site: arguments.site.to_str().unwrap_or("(not Unicode)"),
        route: route.map(|route| RouteReport::of(site, route)),
        region: region.map(|region| RegionReport {
            cell_m: region.cell,
            headings: region.headings,
            positions: region.cells.len(),
            poses: region.poses(),
            readable_poses: region.readable(),
            share: region.share(),
        }),
        landmarks: landmarks.collect(),
    }
}

fn landmark_report(
    number: usize,
    posted: &Posted,
    route: Option<&RouteCoverage>,
    region: Option<&RegionCoverage>,
) -> LandmarkReport {
    let pose = &posted.landmark_in_world;
    LandmarkReport {
        format: format_name(posted.landmark.format),
        payload: payload_hex(posted.landmark.format, posted.payload),
        x_m: pose.x(),
        y_m: pose.y(),
        heading_deg: pose.theta().to_degrees(),
        route_poses: route.map(|found| found.readable.iter().filter(|numbers| numbers.contains(&number)).count()),
        region_poses: region.map(|found| found.by_landmark[number]),
    }
}

fn describe(report: &Report<'_>, out: &mut impl Write) -> Result<(), Failure> {
    if let Some(region) = &report.region {
        writeln!(
            out,
            "region: a landmark is readable from {:.2} % of {} poses ({} positions {} mm apart, {} headings)",
            100.0 * region.share,
            region.poses,
            region.positions,
            1000.0 * region.cell_m,
            region.headings
        )?;
    }
    if let Some(route) = &report.route {
        describe_route(route, out)?;
    }
    for (landmark, number) in report.landmarks.iter().zip(1..) {
        let counts = [(landmark.route_poses, "poses of the route"), (landmark.region_poses, "poses of the region")];
        let counts: Vec<String> =
            counts.iter().filter_map(|(count, what)| count.map(|count| format!("{count} {what}"))).collect();
        writeln!(
            out,
            "landmark {number}: {} {} at x {:.4} m, y {:.4} m, heading {:.1}°, readable from {}",
            landmark.format,
            landmark.payload,
            landmark.x_m,
            landmark.y_m,
            landmark.heading_deg,
            counts.join(" and ")
        )?;
    }
    Ok(())
}

/// A route's figures in a line.
pub(super) fn describe_route(route: &RouteReport, out: &mut impl Write) -> Result<(), Failure> {
    let gap = match (route.longest_gap_m, route.longest_gap_from_m) {
        (Some(gap), Some(from)) => format!("at most {gap:.3} m without one, from {from:.3} m on"),
        _ => "none is ever readable".to_owned(),
    };
    writeln!(
        out,
        "route: a landmark is readable along {:.2} % of {:.3} m ({} poses); {gap}",
        100.0 * route.share,
        route.length_m,
        route.poses
    )?;
    Ok(())
}
