//! `barloc detect`

use super::{Exit, Failure, LandmarkFormat, camera, complain, printable};
use crate::certificate::{format_name, payload_hex};
use crate::input;
use crate::lockstep::Setting;
use crate::port::{Cameras, Landmarks};
use crate::scenes::Lines;
use crate::trace::{DetectionTrace, HomographyTrace, Outcome, Trace};
use clap::{Args, ValueEnum};
use nalgebra::Matrix3;
use reference::covariance::jacobian;
use reference::crossing::CrossingRule;
use reference::homography::Homography;
use reference::landmark::{Format, Landmark};
use reference::merge::{Decoder, Estimator};
use reference::observer::Layer;
use reference::refusal::HypothesisRefusal;
use reference::threshold::Thresholding;
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
    decoder: &'static str,
    estimator: &'static str,
    camera_in_landmark: PoseReport,
    /// Of (x, y, theta), metres and radians squared.
    covariance: [[f64; 3]; 3],
    image: ImageEstimate,
    /// Squared grey levels; none for the paper's estimate.
    margin: Option<f64>,
}

/// `column = o_x + (a + s t)/(1 + k t)`.
#[derive(Serialize)]
struct ImageEstimate {
    a_px: f64,
    s_px: f64,
    k: f64,
    covariance: [[f64; 3]; 3],
}

#[derive(Serialize)]
struct PoseReport {
    x_m: f64,
    y_m: f64,
    theta_rad: f64,
}

impl DetectionReport {
    fn new(found: &DetectionTrace, setting: &Setting) -> Self {
        let digits = found.format.code_stripes();
        let (upper, lower) = found.half_words;
        Self {
            format: format_name(found.format),
            payload: payload_hex(found.format, found.payload),
            upper: format!("{upper:0digits$b}"),
            lower: format!("{lower:0digits$b}"),
            decoder: match found.decoder {
                Decoder::Threshold => "threshold",
                Decoder::Trellis => "trellis",
            },
            estimator: match found.estimator() {
                Estimator::Fit => "fit",
                Estimator::Paper => "paper",
            },
            camera_in_landmark: PoseReport { x_m: found.pose.x, y_m: found.pose.y, theta_rad: found.pose.theta },
            covariance: rows(&found.covariance),
            image: ImageEstimate {
                a_px: found.homography.a,
                s_px: found.homography.s,
                k: found.homography.k,
                covariance: rows(&image_covariance(found, setting)),
            },
            margin: found.fit.as_ref().map(|fit| fit.margin),
        }
    }

    /// Standard deviations of x and y in metres and of the heading in radians.
    fn deviations(&self) -> [f64; 3] {
        core::array::from_fn(|i| self.covariance[i][i].sqrt())
    }
}

fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| matrix[(i, j)]))
}

/// The covariance of `(a, s, k)`: the fit's own; for the paper's estimate that of its pose, carried back through the
/// derivatives of POSE.
fn image_covariance(found: &DetectionTrace, setting: &Setting) -> Matrix3<f64> {
    if let Some(fit) = &found.fit {
        return fit.covariance;
    }
    let HomographyTrace { a, s, k } = found.homography;
    let landmarks = &setting.landmarks.reference;
    let landmark = landmarks.iter().find(|landmark| landmark.format == found.format).copied();
    let landmark = landmark.unwrap_or(Landmark::new(found.format));
    let by_image = jacobian(&Homography { a, s, k }, &setting.cameras.reference, &landmark);
    by_image
        .try_inverse()
        .map_or(Matrix3::repeat(f64::INFINITY), |by_pose| by_pose * found.covariance * by_pose.transpose())
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
        let detections: Vec<DetectionReport> =
            trace.detections.iter().map(|found| DetectionReport::new(found, setting)).collect();
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
        let [x, y, theta] = detection.deviations();
        writeln!(
            out,
            "{image} {pipeline}: {} {}, camera in landmark x {:.3} ± {:.3} cm, y {:.3} ± {:.3} cm, heading {:.2} ± {:.2}°{}",
            detection.format,
            detection.payload,
            100.0 * pose.x_m,
            100.0 * x,
            100.0 * pose.y_m,
            100.0 * y,
            pose.theta_rad.to_degrees(),
            theta.to_degrees(),
            if detection.estimator == "fit" { "" } else { " by transitions only, no fit to the grey levels" },
        )?;
    }
    Ok(())
}

/// The words for a line's threshold: nothing for the one that is always meant.
fn by(thresholding: Thresholding) -> &'static str {
    match thresholding {
        Thresholding::Global => "",
        Thresholding::Local => " by its local threshold",
    }
}

/// Why a trace has no detections: what refused each line or region of interest, and each pair of layers.
fn why_nothing(trace: &Trace) -> String {
    let mut reasons = Vec::new();
    let layers = [(Layer::Upper, "upper line"), (Layer::Lower, "lower line")];
    for ((layer, name), line) in layers.into_iter().zip(&trace.lines) {
        reasons.extend(line.refusals.iter().map(|(threshold, refusal)| format!("{name}{}: {refusal}", by(*threshold))));
        for roi in trace.hypotheses.iter().filter(|roi| roi.layer == layer) {
            // What was read before is no reason.
            if let Outcome::Refused(refusal) = roi.outcome
                && refusal != HypothesisRefusal::Repeated
            {
                let (first, last) = roi.pixels;
                let (by, format) = (by(roi.thresholding), format_name(roi.format));
                reasons.push(format!("{name}{by}, pixels {first} to {last} as {format}: {refusal}"));
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
