//! `barloc design`

use super::{Exit, Failure, LandmarkFormat, camera};
use crate::certificate::format_name;
use crate::drawing::area::{Subject, draw};
use clap::Args;
use comfy_table::{CellAlignment, Table, presets};
use reference::area::{Area, AreaRefusal, Bounds, Dimensions, Limit, NotWithThisCamera, Range, required};
use reference::camera::Camera;
use reference::landmark::Landmark;
use reference::range::MIN_STRIPE_PIXELS;
use serde::Serialize;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Inclinations of the table and the drawing, degrees; by symmetry they stand for -15° and so on where the principal
/// column is central.
const INCLINATIONS: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];

#[derive(Args)]
#[command(after_help = "Examples:
  barloc design                                             ranges and areas of the paper's landmark
  barloc design --landmark wide --camera camera.toml --json
  barloc design --reach 0.8 --inclination 30                how large a landmark has to be
  barloc design --svg area.svg                              the areas seen from above

Inclination 0 looks along the wall's normal; a camera with a positive one stands to the right as seen.
Ranges are those of a camera that looks at the barcode's centre. A camera file is described by barloc detect --help.")]
pub(super) struct Arguments {
    /// Landmark format
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = LandmarkFormat::Paper)]
    landmark: LandmarkFormat,
    /// Camera description (TOML); the e-puck's camera if left out
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Narrowest stripe that is still found, pixels from 0.1 to 100
    #[arg(long, value_name = "PX", default_value_t = MIN_STRIPE_PIXELS, allow_negative_numbers = true)]
    min_stripe_px: f64,
    /// Ask for the smallest landmark that is read from this far away, metres
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    reach: Option<f64>,
    /// The inclination under which it is, degrees from -90 to 90
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true)]
    inclination: f64,
    /// Draw the areas into this file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// `--json`.
#[derive(Serialize)]
struct Report {
    landmark: &'static str,
    stripe_width_m: f64,
    stripe_height_m: f64,
    min_stripe_px: f64,
    ranges: Vec<RangeReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    required: Option<RequiredReport>,
}

/// The range at one inclination, the smaller one of (5) and (6), and what goes into it.
#[derive(Serialize)]
struct RangeReport {
    inclination_deg: f64,
    range_m: f64,
    limited_by: &'static str,
    /// (5)
    stripe_width_range_m: f64,
    /// (6)
    scan_line_range_m: f64,
    /// (3), (4): nearer the barcode is not whole in view; none if it never is.
    nearest_m: Option<f64>,
    area_m2: f64,
    /// The range if (3) and (4) are asked as well.
    #[serde(skip)]
    in_view: Range,
}

/// The answer to `--reach`.
#[derive(Serialize)]
struct RequiredReport {
    reach_m: f64,
    inclination_deg: f64,
    #[serde(flatten)]
    answer: Answer,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Answer {
    Dimensions { stripe_width_m: f64, stripe_height_m: f64 },
    Refused { refused_by: &'static str, reason: String },
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let camera = camera(arguments.camera.as_deref())?;
    let landmark = Landmark::new(arguments.landmark.into());
    let areas = areas(&camera, &landmark, arguments.min_stripe_px).map_err(refused)?;
    let report = Report {
        landmark: format_name(landmark.format),
        stripe_width_m: landmark.stripe_width,
        stripe_height_m: landmark.stripe_height,
        min_stripe_px: arguments.min_stripe_px,
        ranges: areas.iter().zip(INCLINATIONS).map(|(area, degrees)| RangeReport::new(area, degrees)).collect(),
        required: requirement(arguments, &camera, &landmark)?,
    };
    if let Some(path) = &arguments.svg {
        let min_stripe_pixels = arguments.min_stripe_px;
        write(path, &Subject { camera: &camera, landmark: &landmark, min_stripe_pixels, areas: &areas })?;
    }
    if arguments.json {
        serde_json::to_writer(&mut *out, &report).map_err(std::io::Error::from)?;
        writeln!(out)?;
    } else {
        describe(&report, out)?;
    }
    Ok(Exit::Success)
}

fn refused(refusal: AreaRefusal) -> Failure {
    Failure::Input(refusal.to_string())
}

/// The areas of all inclinations, in their order.
fn areas(camera: &Camera, landmark: &Landmark, min_stripe_pixels: f64) -> Result<Vec<Area>, AreaRefusal> {
    INCLINATIONS.iter().map(|degrees| Area::new(camera, landmark, degrees.to_radians(), min_stripe_pixels)).collect()
}

impl RangeReport {
    fn new(area: &Area, inclination_deg: f64) -> Self {
        let bounds: Bounds = area.bounds(area.inclination());
        let (farthest, nearest) = (bounds.farthest(), bounds.field_of_view);
        Self {
            inclination_deg,
            range_m: farthest.distance,
            limited_by: key(farthest.limit),
            stripe_width_range_m: bounds.stripe_width,
            scan_line_range_m: bounds.scan_line.max(0.0),
            nearest_m: nearest.is_finite().then_some(nearest),
            area_m2: area.area(),
            in_view: bounds.range(),
        }
    }
}

/// A bound's name in JSON.
fn key(limit: Limit) -> &'static str {
    match limit {
        Limit::FieldOfView => "field_of_view",
        Limit::StripeWidth => "stripe_width",
        Limit::ScanLineInclination => "scan_line_inclination",
    }
}

/// A bound's name in the table.
fn name(limit: Limit) -> &'static str {
    match limit {
        Limit::FieldOfView => "field of view",
        Limit::StripeWidth => "stripe width",
        Limit::ScanLineInclination => "scan lines",
    }
}

/// The answer to `--reach`, if that is asked. `--inclination` must make sense in any case.
fn requirement(arguments: &Arguments, camera: &Camera, landmark: &Landmark) -> Result<Option<RequiredReport>, Failure> {
    let (inclination, pixels) = (arguments.inclination.to_radians(), arguments.min_stripe_px);
    Area::new(camera, landmark, inclination, pixels).map_err(refused)?;
    let Some(reach) = arguments.reach else { return Ok(None) };
    let answer = match required(camera, landmark.format, reach, inclination, pixels) {
        Ok(Dimensions { stripe_width, stripe_height }) => {
            Answer::Dimensions { stripe_width_m: stripe_width, stripe_height_m: stripe_height }
        }
        Err(NotWithThisCamera::Asked(refusal)) => return Err(refused(refusal)),
        Err(refusal) => Answer::Refused { refused_by: refusal_key(&refusal), reason: refusal.to_string() },
    };
    Ok(Some(RequiredReport { reach_m: reach, inclination_deg: arguments.inclination, answer }))
}

/// What stands against a range, by its name in JSON.
fn refusal_key(refusal: &NotWithThisCamera) -> &'static str {
    match refusal {
        NotWithThisCamera::Asked(_) => "question",
        NotWithThisCamera::StripeWidth => key(Limit::StripeWidth),
        NotWithThisCamera::Format { .. } => "landmark_stripe_width",
        NotWithThisCamera::FieldOfView { .. } => key(Limit::FieldOfView),
        NotWithThisCamera::ScanLineInclination => key(Limit::ScanLineInclination),
    }
}

/// Draws the areas.
fn write(path: &Path, subject: &Subject<'_>) -> Result<(), Failure> {
    let svg = draw(subject).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
    fs::write(path, svg).map_err(|error| Failure::Input(format!("{}: cannot be written: {error}", path.display())))
}

fn describe(report: &Report, out: &mut impl Write) -> Result<(), Failure> {
    writeln!(
        out,
        "{}, stripes {:.2} mm wide, layers {:.1} mm high, narrowest stripe {} px",
        report.landmark,
        1e3 * report.stripe_width_m,
        1e3 * report.stripe_height_m,
        report.min_stripe_px
    )?;
    writeln!(out, "{}", table(&report.ranges))?;
    if let Some(required) = &report.required {
        let question = format!("{} m at {}°", required.reach_m, required.inclination_deg);
        match &required.answer {
            Answer::Dimensions { stripe_width_m, stripe_height_m } => {
                let (width, height) = (1e3 * stripe_width_m, 1e3 * stripe_height_m);
                writeln!(out, "{question} takes stripes {width:.2} mm wide and layers {height:.1} mm high")?;
            }
            Answer::Refused { reason, .. } => writeln!(out, "{question} is beyond this camera: {reason}")?,
        }
    }
    Ok(())
}

fn table(ranges: &[RangeReport]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header(["inclination", "stripe width (5)", "scan lines (6)", "range", "limited by", "nearest", "area"]);
    let centimetres = |metres: f64| format!("{:.1} cm", 100.0 * metres);
    for range in ranges {
        let Range { distance, limit } = range.in_view;
        table.add_row([
            format!("{}°", range.inclination_deg),
            centimetres(range.stripe_width_range_m),
            centimetres(range.scan_line_range_m),
            if distance > 0.0 { centimetres(distance) } else { "none".to_owned() },
            name(limit).to_owned(),
            range.nearest_m.map_or("nowhere".to_owned(), centimetres),
            format!("{:.0} cm²", 1e4 * range.area_m2),
        ]);
    }
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_cell_alignment(if i == 4 { CellAlignment::Left } else { CellAlignment::Right });
    }
    table
}
