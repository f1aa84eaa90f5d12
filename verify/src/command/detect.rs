//! `barloc detect`

use super::{Exit, Failure, LandmarkFormat, camera, complain, printable};
use crate::certificate::{format_name, payload_hex};
use crate::input;
use crate::lockstep::Setting;
use crate::port::{Cameras, Landmarks};
use crate::scenes::Lines;
use crate::trace::{DetectionTrace, Outcome, Trace};
use clap::{Args, ValueEnum};
use reference::crossing::CrossingRule;
use reference::landmark::Format;
use reference::observer::Layer;
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_help = "Examples:
  barloc detect tests/data/renders/000.png
  barloc detect --json --pipeline fixedpoint --landmark paper tests/data/renders/*.png
  barloc detect --camera camera.toml image.pgm

A camera file is TOML; what it leaves out is the e-puck's or follows from the rest:
  width_px = 480
  height_px = 8
  focal_length_px = 640.0
  focal_length_vertical_px = 80.0
  principal_column_px = 239.5
  upper_row = 0
  lower_row = 7")]
pub(super) struct Arguments {
    /// Which pipeline to run
    #[arg(long, value_enum, default_value_t = Pipelines::Both)]
    pipeline: Pipelines,
    /// Landmark format to search, may be repeated; both if left out
    #[arg(long, value_enum, value_name = "FORMAT")]
    landmark: Vec<LandmarkFormat>,
    /// Camera description (TOML); the e-puck's camera if left out
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Where a transition lies between two pixels
    #[arg(long, value_enum, default_value_t = Rule::Interpolated)]
    crossing: Rule,
    /// One line of JSON per image and pipeline
    #[arg(long)]
    json: bool,
    /// Images, PNG or PNM with at most 8 bits per sample
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Pipelines {
    Reference,
    Fixedpoint,
    Both,
}

#[derive(Clone, Copy, ValueEnum)]
enum Rule {
    Interpolated,
    WholePixel,
}

/// A line of `--json`.
#[derive(Serialize)]
struct ImageReport<'a> {
    image: &'a str,
    pipeline: &'a str,
    detections: Vec<DetectionReport>,
}

#[derive(Serialize)]
struct DetectionReport {
    format: &'static str,
    payload: String,
    upper: String,
    lower: String,
    camera_in_landmark: PoseReport,
}

#[derive(Serialize)]
struct PoseReport {
    x_m: f64,
    y_m: f64,
    theta_rad: f64,
}

impl From<&DetectionTrace> for DetectionReport {
    fn from(found: &DetectionTrace) -> Self {
        let digits = found.format.code_stripes();
        let (upper, lower) = found.half_words;
        Self {
            format: format_name(found.format),
            payload: payload_hex(found.format, found.payload),
            upper: format!("{upper:0digits$b}"),
            lower: format!("{lower:0digits$b}"),
            camera_in_landmark: PoseReport { x_m: found.pose.x, y_m: found.pose.y, theta_rad: found.pose.theta },
        }
    }
}

pub(super) fn run(arguments: &Arguments, out: &mut impl Write) -> Result<Exit, Failure> {
    let setting = setting(arguments)?;
    let mut exit = Exit::Success;
    for path in &arguments.images {
        match input::scan_lines(path, &setting.cameras.reference) {
            Ok(lines) => report(arguments, &setting, &path.to_string_lossy(), &lines, out)?,
            Err(error) => {
                complain(&format!("{}: {error}", path.display()));
                exit = Exit::BadInput;
            }
        }
    }
    Ok(exit)
}

fn setting(arguments: &Arguments) -> Result<Setting, Failure> {
    let camera = camera(arguments.camera.as_deref())?;
    let cameras = Cameras::new(camera).ok_or_else(|| Failure::Input("the port cannot hold this camera".to_owned()))?;
    let asked: Vec<Format> = arguments.landmark.iter().map(|&format| format.into()).collect();
    let formats = if asked.is_empty() { Format::ALL.to_vec() } else { asked };
    let landmarks =
        Landmarks::new(&formats).ok_or_else(|| Failure::Input("the port cannot hold this landmark".to_owned()))?;
    let rule = match arguments.crossing {
        Rule::Interpolated => CrossingRule::Interpolated,
        Rule::WholePixel => CrossingRule::WholePixel,
    };
    Ok(Setting { cameras, landmarks, rule })
}

/// A pipeline's name and how to run it.
type Pipeline = (&'static str, fn(&Setting, &[u8], &[u8]) -> Trace);

fn pipelines(which: Pipelines) -> Vec<Pipeline> {
    let reference: Pipeline = ("reference", Setting::run_reference);
    let fixedpoint: Pipeline = ("fixedpoint", Setting::run_fixedpoint);
    match which {
        Pipelines::Reference => vec![reference],
        Pipelines::Fixedpoint => vec![fixedpoint],
        Pipelines::Both => vec![reference, fixedpoint],
    }
}

fn report(
    arguments: &Arguments,
    setting: &Setting,
    image: &str,
    [upper, lower]: &Lines,
    out: &mut impl Write,
) -> Result<(), Failure> {
    for (pipeline, run) in pipelines(arguments.pipeline) {
        let trace = run(setting, upper, lower);
        let detections: Vec<DetectionReport> = trace.detections.iter().map(DetectionReport::from).collect();
        if arguments.json {
            let line = ImageReport { image, pipeline, detections };
            serde_json::to_writer(&mut *out, &line).map_err(std::io::Error::from)?;
            writeln!(out)?;
        } else {
            describe(&printable(image), pipeline, &trace, &detections, out)?;
        }
    }
    Ok(())
}

fn describe(
    image: &str,
    pipeline: &str,
    trace: &Trace,
    found: &[DetectionReport],
    out: &mut impl Write,
) -> Result<(), Failure> {
    if found.is_empty() {
        writeln!(out, "{image} {pipeline}: nothing found; {}", why_nothing(trace))?;
    }
    for detection in found {
        let pose = &detection.camera_in_landmark;
        writeln!(
            out,
            "{image} {pipeline}: {} {}, camera in landmark x {:.2} cm, y {:.2} cm, heading {:.2}°",
            detection.format,
            detection.payload,
            100.0 * pose.x_m,
            100.0 * pose.y_m,
            pose.theta_rad.to_degrees()
        )?;
    }
    Ok(())
}

/// Why a trace has no detections: what refused each line or region of interest, and each pair of layers.
fn why_nothing(trace: &Trace) -> String {
    let mut reasons = Vec::new();
    let layers = [(Layer::Upper, "upper line"), (Layer::Lower, "lower line")];
    for ((layer, name), line) in layers.into_iter().zip(&trace.lines) {
        reasons.extend(line.refusal.map(|refusal| format!("{name}: {refusal}")));
        for roi in trace.hypotheses.iter().filter(|roi| roi.layer == layer) {
            if let Outcome::Refused(refusal) = roi.outcome {
                let (first, last) = roi.pixels;
                reasons.push(format!("{name}, pixels {first} to {last} as {}: {refusal}", format_name(roi.format)));
            }
        }
    }
    let refused = trace.pairs.iter().filter_map(|pair| pair.result.err().map(|refusal| (pair, refusal)));
    reasons.extend(refused.map(|(pair, refusal)| {
        format!("both lines, from pixel {} as {}: {refusal}", pair.first_pixels.0, format_name(pair.format))
    }));
    reasons.extend(trace.ambiguous.first().map(|_| "it decodes in two formats".to_owned()));
    if reasons.is_empty() { "the layers found do not meet".to_owned() } else { reasons.join("; ") }
}
