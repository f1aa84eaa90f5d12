//! The certificate: what was run, what was seen, and the verdict. The same seed gives the same bytes.

use crate::bounds::{Class, TABLE};
use crate::campaign::{Plan, RenderResult};
use crate::findings::{Both, CandidateEnd, Findings, PartCount, Rate, SceneRates};
use crate::route::Report;
use crate::scenes::{BOXES, FIRST_BARCODE_ROW};
use crate::tally::{Frame, Part};
use crate::trace::DetectionTrace;
use reference::camera::Camera;
use reference::frame::wrap;
use reference::landmark::{Format, Landmark};
use reference::merge::Decoder;
use reference::range::blind_range;
use serde::Serialize;

/// Pass or fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing differs more than it may.
    Pass,
    /// Something does, or was never compared.
    Fail,
}

impl Verdict {
    fn of(passes: bool) -> Self {
        if passes { Self::Pass } else { Self::Fail }
    }

    /// The word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "FAIL",
        }
    }
}

/// Everything that a campaign certifies.
#[derive(Clone, Debug, Serialize)]
pub struct Certificate {
    /// All stages and all checks.
    pub verdict: Verdict,
    /// Seed of everything random.
    pub seed: u64,
    /// The commit that was built, with `-modified` if its pipelines or the comparison were changed.
    pub commit: &'static str,
    /// The compiler.
    pub toolchain: &'static str,
    /// Frames compared.
    pub frames: u64,
    /// Frames with a marginal decision.
    pub marginal: u64,
    /// Marginal frames in which the pipelines decided differently.
    pub differing: u64,
    /// The comparison, stage by stage.
    pub stages: Vec<StageReport>,
    /// What the specification asks of both pipelines besides being the same.
    pub checks: Vec<Check>,
    /// Counts by part.
    pub parts: Vec<PartReport>,
    /// What became of the pairs of layers and of extents.
    pub candidates: Vec<CandidateReport>,
    /// Detection rates.
    pub detection: Detection,
    /// Coverage of the pose space by the random scenes.
    pub coverage: Coverage,
    /// The images, one by one.
    pub renders: Vec<RenderReport>,
    /// Both pipelines on routes.
    pub routes: Vec<Report>,
}

/// A row of the comparison.
#[derive(Clone, Debug, Serialize)]
pub struct StageReport {
    /// Name.
    pub stage: &'static str,
    /// How it is compared.
    pub class: Class,
    /// Unit of `max` and `bound`.
    pub unit: &'static str,
    /// Results compared.
    pub cases: u64,
    /// The difference that used most of its bound; 1 where something that must be identical is not.
    pub max: f64,
    /// Its bound.
    pub bound: f64,
    /// Share of the bound used.
    pub share: f64,
    /// Marginal decisions.
    pub marginal: u64,
    /// Results that are not the same.
    pub failures: u64,
    /// The frame of `max`.
    pub worst_frame: Option<FrameName>,
    /// The first frame that failed.
    pub first_failure: Option<FrameName>,
    /// Where the bound comes from.
    pub origin: &'static str,
    /// Pass or fail.
    pub verdict: Verdict,
}

/// A frame by name.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FrameName {
    /// Part of the campaign.
    pub part: &'static str,
    /// Number in it.
    pub index: u64,
}

impl From<Frame> for FrameName {
    fn from(frame: Frame) -> Self {
        Self { part: frame.part.name(), index: frame.index }
    }
}

/// A requirement on both pipelines.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// What must hold.
    pub check: &'static str,
    /// What was found, in words.
    pub found: String,
    /// Pass or fail.
    pub verdict: Verdict,
}

/// Counts of one part.
#[derive(Clone, Debug, Serialize)]
pub struct PartReport {
    /// Name.
    pub part: &'static str,
    /// Counts.
    #[serde(flatten)]
    pub count: PartCount,
}

/// How many pairs ended in one way.
#[derive(Clone, Debug, Serialize)]
pub struct CandidateReport {
    /// Who read them.
    pub decoder: &'static str,
    /// How they ended.
    pub end: String,
    /// How many.
    #[serde(flatten)]
    pub count: Both,
}

/// Detection rates.
#[derive(Clone, Debug, Serialize)]
pub struct Detection {
    /// The paper's Fig. 9 b.
    pub paper: Vec<CellReport>,
    /// The paper's Fig. 9 a.
    pub paper_barcodes: Vec<CellReport>,
    /// Frontally, centimetre by centimetre.
    pub frontal: Vec<CellReport>,
    /// The same by the whole-pixel rule.
    pub frontal_whole_pixel: Vec<CellReport>,
    /// Random scenes.
    pub scenes: SceneRates,
}

/// The rate of one pose.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CellReport {
    /// Inclination in degrees.
    pub inclination_deg: u32,
    /// Number of the barcode, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub barcode: Option<u32>,
    /// Distance in centimetres.
    pub distance_cm: u32,
    /// Views and found.
    #[serde(flatten)]
    pub rate: Rate,
}

/// How evenly the random scenes fill the space of distance, inclination and bearing.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Coverage {
    /// Boxes, ten for each dimension.
    pub boxes: usize,
    /// Boxes with at least one scene.
    pub visited: usize,
    /// Scenes in the emptiest box.
    pub fewest: u64,
    /// Scenes in the fullest box.
    pub most: u64,
}

/// One image.
#[derive(Clone, Debug, Serialize)]
pub struct RenderReport {
    /// File.
    pub image: String,
    /// Format and payload on it, if any.
    pub truth: Option<String>,
    /// Truth of the camera in the landmark's frame.
    pub camera_in_landmark: PoseReport,
    /// What the reference found.
    pub reference: Vec<FoundReport>,
    /// What the port found.
    pub fixedpoint: Vec<FoundReport>,
}

/// A detection on an image and its error.
#[derive(Clone, Debug, Serialize)]
pub struct FoundReport {
    /// Format and payload.
    pub landmark: String,
    /// Found less true pose.
    pub error: PoseReport,
}

/// A pose or its error.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PoseReport {
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Radians.
    pub theta_rad: f64,
}

/// A landmark in words.
#[must_use]
pub fn landmark_name(format: Format, payload: u32) -> String {
    format!("{} {}", format_name(format), payload_hex(format, payload))
}

/// A format's name.
#[must_use]
pub fn format_name(format: Format) -> &'static str {
    match format {
        Format::Paper => "paper",
        Format::Wide => "wide",
    }
}

/// A payload in hexadecimal digits.
#[must_use]
pub fn payload_hex(format: Format, payload: u32) -> String {
    let digits = format.payload_bits() / 4;
    format!("{payload:0digits$x}")
}

impl Certificate {
    /// The certificate of a campaign.
    #[must_use]
    pub fn new(plan: &Plan, findings: &Findings, renders: &[RenderResult]) -> Self {
        let stages: Vec<StageReport> = TABLE.iter().map(|row| stage_report(row, findings)).collect();
        let checks = checks(findings, renders);
        let same = stages.iter().all(|stage| stage.verdict == Verdict::Pass);
        let checked = checks.iter().all(|check| check.verdict == Verdict::Pass);
        Self {
            verdict: Verdict::of(same && checked),
            seed: plan.seed,
            commit: env!("BARLOC_COMMIT"),
            toolchain: env!("BARLOC_TOOLCHAIN"),
            frames: findings.tally.frames,
            marginal: findings.tally.marginal_frames,
            differing: findings.tally.differing_frames,
            stages,
            checks,
            parts: findings.parts.iter().map(|(part, count)| PartReport { part: part.name(), count: *count }).collect(),
            candidates: findings.candidates.iter().map(candidate_report).collect(),
            detection: detection(findings),
            coverage: coverage(findings),
            renders: renders.iter().map(render_report).collect(),
            routes: Vec::new(),
        }
    }

    /// The same with both pipelines on routes, which have to stay together (SAME-7).
    #[must_use]
    pub fn with_routes(mut self, routes: Vec<Report>) -> Self {
        let checks = routes.iter().map(route_check);
        self.checks.extend(checks);
        let checked = self.checks.iter().all(|check| check.verdict == Verdict::Pass);
        self.verdict = Verdict::of(checked && self.verdict == Verdict::Pass);
        self.routes = routes;
        self
    }

    /// As JSON, ending in a newline.
    ///
    /// # Panics
    /// Never: every part of it has a JSON form.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a certificate has a JSON form") + "\n"
    }
}

fn candidate_report((&(decoder, end), &count): (&(Decoder, CandidateEnd), &Both)) -> CandidateReport {
    let decoder = match decoder {
        Decoder::Threshold => "threshold",
        Decoder::Trellis => "trellis",
    };
    CandidateReport { decoder, end: end.describe(), count }
}

fn stage_report(row: &crate::bounds::Row, findings: &Findings) -> StageReport {
    let tally = findings.tally.stage(row.stage);
    StageReport {
        stage: row.name,
        class: row.class,
        unit: row.unit,
        cases: tally.cases,
        max: tally.worst.map_or(0.0, |case| case.difference),
        bound: tally.worst.map_or(0.0, |case| case.bound),
        share: tally.worst.map_or(0.0, |case| case.share().min(f64::MAX)),
        marginal: tally.marginal,
        failures: tally.failures,
        // Where nothing differs, no frame is worse than another.
        worst_frame: tally.worst.filter(|case| case.difference > 0.0).map(|case| case.frame.into()),
        first_failure: tally.first_failure.map(FrameName::from),
        origin: row.origin,
        verdict: Verdict::of(tally.passes()),
    }
}

/// The detection rates that SPEC.md asks for, and the images.
fn checks(findings: &Findings, renders: &[RenderResult]) -> Vec<Check> {
    let right = renders.iter().filter(|result| result.is_right(0) && result.is_right(1)).count();
    let frontal = |range: core::ops::RangeInclusive<u32>| {
        let cells = findings
            .rates
            .iter()
            .filter(move |((part, cell), _)| *part == Part::Frontal && range.contains(&cell.centimetres));
        cells.map(|(_, rate)| (rate.found.reference.min(rate.found.fixedpoint), *rate))
    };
    let worst = frontal(10..=45).map(|(found, rate)| 100.0 * found as f64 / rate.views as f64).fold(100.0, f64::min);
    let blind = blind_range(&Camera::epuck(), &Landmark::new(Format::Paper));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "66.7 cm")]
    let blind_cm = (blind * 100.0).ceil() as u32;
    let beyond: u64 = frontal(blind_cm..=u32::MAX).map(|(_, rate)| rate.found.reference + rate.found.fixedpoint).sum();
    let (marginal, frames) = (findings.tally.marginal_frames, findings.tally.frames);
    vec![
        Check {
            check: "SAME-4: at most 1 frame in 1,000 is marginal",
            found: format!("{marginal} of {frames}, {} decided differently", findings.tally.differing_frames),
            verdict: Verdict::of(marginal.saturating_mul(1000) <= frames),
        },
        Check {
            check: "renders: both pipelines find what is on every image, and nothing else",
            found: format!("{right} of {}", renders.len()),
            verdict: Verdict::of(right == renders.len() && !renders.is_empty()),
        },
        Check {
            //= reference/SPEC.md#range
            //# - **RANGE-3** At 0° the detection rate of `paper` MUST be at least 99 % at every whole centimetre from
            //# 10 to 45 cm.
            check: "RANGE-3: at least 99 % found frontally at every centimetre from 10 to 45",
            found: format!("{worst:.1} % at the worst centimetre"),
            verdict: Verdict::of(worst >= 99.0 && frontal(10..=45).count() == 36),
        },
        Check {
            check: "RANGE-4: nothing found frontally where the rows see none of the landmark",
            found: format!("{beyond} found from {blind_cm} cm on"),
            verdict: Verdict::of(beyond == 0),
        },
    ]
}

/// SAME-7
fn route_check(report: &Report) -> Check {
    let (apart, differing) = (&report.largest_difference_decided_alike, &report.decided_differently);
    Check {
        check: "SAME-7: along a route both filters stay within 1 mm and 0.1°",
        found: format!(
            "{}, {} runs: {:.3} mm, {:.4}°; at {} readings decided differently, {} of them without a reason",
            report.scenario,
            report.runs,
            1000.0 * apart.position_m,
            apart.heading_rad.to_degrees(),
            differing.all(),
            differing.unexplained
        ),
        verdict: Verdict::of(report.stays_together()),
    }
}

fn detection(findings: &Findings) -> Detection {
    let cells = |part: Part| findings.rates.iter().filter(move |((of, _), _)| *of == part);
    let report = |part: Part, barcodes: bool| -> Vec<CellReport> {
        cells(part)
            .filter(|((_, cell), _)| (cell.row >= FIRST_BARCODE_ROW) == barcodes)
            .map(|((_, cell), rate)| CellReport {
                inclination_deg: if barcodes { 0 } else { cell.row },
                barcode: barcodes.then(|| cell.row - FIRST_BARCODE_ROW + 1),
                distance_cm: cell.centimetres,
                rate: *rate,
            })
            .collect()
    };
    Detection {
        paper: report(Part::Paper, false),
        paper_barcodes: report(Part::Paper, true),
        frontal: report(Part::Frontal, false),
        frontal_whole_pixel: report(Part::WholePixel, false),
        scenes: findings.scenes,
    }
}

fn coverage(findings: &Findings) -> Coverage {
    let boxes = BOXES.pow(3);
    let visited = findings.boxes.len();
    let fewest = if visited < boxes { 0 } else { findings.boxes.values().copied().min().unwrap_or(0) };
    Coverage { boxes, visited, fewest, most: findings.boxes.values().copied().max().unwrap_or(0) }
}

fn render_report(result: &RenderResult) -> RenderReport {
    let [x_m, y_m, theta_rad] = result.render.pose;
    let found = |detections: &[DetectionTrace]| {
        let report = |detection: &DetectionTrace| FoundReport {
            landmark: landmark_name(detection.format, detection.payload),
            error: PoseReport {
                x_m: detection.pose.x - x_m,
                y_m: detection.pose.y - y_m,
                theta_rad: wrap(detection.pose.theta - theta_rad),
            },
        };
        detections.iter().map(report).collect()
    };
    RenderReport {
        image: result.render.file.clone(),
        truth: result.render.landmark.map(|(format, payload)| landmark_name(format, payload)),
        camera_in_landmark: PoseReport { x_m, y_m, theta_rad },
        reference: found(&result.detections[0]),
        fixedpoint: found(&result.detections[1]),
    }
}
