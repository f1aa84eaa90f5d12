//! A certificate as a person reads it.

use crate::bounds::Class;
use crate::certificate::{CellReport, Certificate, FoundReport, RenderReport};
use crate::findings::{Both, Rate};
use crate::scenes::{FRONTAL_VIEWS, PAPER_VIEWS};
use comfy_table::{Cell, CellAlignment, Table, presets};
use std::collections::BTreeMap;
use std::fmt::Write;

/// All tables of a certificate, and its verdict.
#[must_use]
pub fn summary(certificate: &Certificate) -> String {
    let mut text = String::new();
    section(&mut text, "Images with known truth", &renders(certificate));
    section(
        &mut text,
        &format!("Detection, paper's data set, found of {PAPER_VIEWS} views (reference/fixedpoint)"),
        &paper(certificate),
    );
    section(&mut text, &format!("Detection, frontal, per cent of {FRONTAL_VIEWS} views"), &frontal(certificate));
    section(&mut text, "Random scenes", &scenes(certificate));
    section(&mut text, "False detections (reference/fixedpoint)", &parts(certificate));
    section(&mut text, "Pairs of layers and of extents, and how they ended", &candidates(certificate));
    section(&mut text, "Both pipelines, stage by stage", &stages(certificate));
    if !certificate.routes.is_empty() {
        section(&mut text, "Routes", &routes(certificate));
    }
    section(&mut text, "Checks", &checks(certificate));
    let _ = writeln!(
        text,
        "{}: {} frames, {} marginal, seed {}",
        certificate.verdict.word(),
        certificate.frames,
        certificate.marginal,
        certificate.seed
    );
    text
}

fn section(text: &mut String, title: &str, body: &str) {
    let _ = writeln!(text, "{title}\n{}\n", body.trim_end());
}

/// A table without frame, its first column to the left and the others to the right.
fn table<H: Into<Cell>>(header: impl IntoIterator<Item = H>) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(header);
    table
}

fn right_aligned(mut table: Table, from: usize) -> String {
    for column in table.column_iter_mut().skip(from) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}

fn stages(certificate: &Certificate) -> String {
    let header = ["stage", "class", "cases", "largest difference", "bound", "", "used", "marginal", "verdict"];
    let mut table = table(header);
    for stage in &certificate.stages {
        let exact = stage.class == Class::Exact;
        let number = |value: f64| if value == 0.0 { "0".to_owned() } else { format!("{value:.2e}") };
        table.add_row([
            stage.stage.to_owned(),
            format!("{:?}", stage.class).to_lowercase(),
            stage.cases.to_string(),
            number(stage.max),
            if exact { "identical".to_owned() } else { number(stage.bound) },
            stage.unit.to_owned(),
            if exact { String::new() } else { format!("{:.0} %", 100.0 * stage.share) },
            stage.marginal.to_string(),
            stage.verdict.word().to_owned(),
        ]);
    }
    let mut text = right_aligned(table, 2);
    for stage in &certificate.stages {
        if let Some(frame) = stage.first_failure {
            let _ = write!(text, "\n{}: first not the same in {} {}", stage.stage, frame.part, frame.index);
        }
    }
    text
}

fn candidates(certificate: &Certificate) -> String {
    let mut table = table(["decoder", "end", "reference", "fixedpoint"]);
    for report in &certificate.candidates {
        let counts = [report.count.reference, report.count.fixedpoint].map(|count| count.to_string());
        table.add_row([report.decoder.to_owned(), report.end.clone()].into_iter().chain(counts));
    }
    right_aligned(table, 2)
}

fn checks(certificate: &Certificate) -> String {
    let mut table = table(["check", "found", "verdict"]);
    for check in &certificate.checks {
        table.add_row([check.check, &check.found, check.verdict.word()]);
    }
    table.trim_fmt()
}

fn routes(certificate: &Certificate) -> String {
    let mut table =
        table(["route", "runs", "pipeline", "mean error cm", "95 %", "NEES", "used", "not used", "recoveries"]);
    for route in &certificate.routes {
        for (pipeline, errors) in [("reference", &route.reference), ("fixedpoint", &route.fixedpoint)] {
            table.add_row([
                route.scenario.clone(),
                route.runs.to_string(),
                pipeline.to_owned(),
                format!("{:.3}", 100.0 * errors.mean_position_error_m),
                format!("{:.3}", 100.0 * errors.p95_position_error_m),
                format!("{:.2}", errors.mean_nees),
                errors.observations_used.to_string(),
                errors.observations_gated.to_string(),
                errors.recoveries.len().to_string(),
            ]);
        }
    }
    right_aligned(table, 3)
}

fn renders(certificate: &Certificate) -> String {
    let header = ["image", "truth", "x cm", "y cm", "heading °", "reference: error mm, °", "fixedpoint: error mm, °"];
    let mut table = table(header);
    let blank = |render: &&RenderReport| render.truth.is_none();
    for render in certificate.renders.iter().filter(|render| !blank(render)) {
        let pose = &render.camera_in_landmark;
        table.add_row([
            render.image.clone(),
            render.truth.clone().unwrap_or_default(),
            format!("{:.2}", 100.0 * pose.x_m),
            format!("{:.2}", 100.0 * pose.y_m),
            format!("{:.2}", pose.theta_rad.to_degrees()),
            errors(&render.reference, render.truth.as_ref()),
            errors(&render.fixedpoint, render.truth.as_ref()),
        ]);
    }
    let mut text = right_aligned(table, 2);
    let blanks: Vec<_> = certificate.renders.iter().filter(blank).collect();
    let phantoms =
        |found: fn(&RenderReport) -> &Vec<FoundReport>| blanks.iter().filter(|r| !found(r).is_empty()).count();
    let _ = write!(
        text,
        "\n{} blank images: something found on {} by the reference, on {} by the port",
        blanks.len(),
        phantoms(|render| &render.reference),
        phantoms(|render| &render.fixedpoint)
    );
    text
}

/// Errors of what was found on an image, with its name where it is not what is there.
fn errors(found: &[FoundReport], truth: Option<&String>) -> String {
    let one = |found: &FoundReport| {
        let error = &found.error;
        let pose = format!("{:+.2} {:+.2} {:+.3}", 1e3 * error.x_m, 1e3 * error.y_m, error.theta_rad.to_degrees());
        if Some(&found.landmark) == truth { pose } else { format!("WRONG {} {pose}", found.landmark) }
    };
    if found.is_empty() { "not found".to_owned() } else { found.iter().map(one).collect::<Vec<_>>().join("; ") }
}

fn paper(certificate: &Certificate) -> String {
    let detection = &certificate.detection;
    let name = |cell: &CellReport| match cell.barcode {
        None => (0, cell.inclination_deg, format!("{}°", cell.inclination_deg)),
        Some(barcode) => (1, barcode, format!("0°, barcode {barcode}")),
    };
    let mut rows: BTreeMap<_, Vec<&CellReport>> = BTreeMap::new();
    for cell in detection.paper.iter().chain(&detection.paper_barcodes) {
        rows.entry(name(cell)).or_default().push(cell);
    }
    let distances = rows.values().next().into_iter().flatten().map(|cell| format!("{} cm", cell.distance_cm));
    let mut table = table(std::iter::once(String::new()).chain(distances));
    for ((_, _, name), cells) in rows {
        let found = cells.iter().map(|cell| both(cell.rate.found));
        table.add_row(std::iter::once(name).chain(found));
    }
    right_aligned(table, 1)
}

fn both(found: Both) -> String {
    format!("{}/{}", found.reference, found.fixedpoint)
}

/// Rates centimetre by centimetre, ten to a line, one line for both pipelines where they found the same.
fn frontal(certificate: &Certificate) -> String {
    let mut table =
        table(["cm", "rule", "pipeline"].map(str::to_owned).into_iter().chain((0..10).map(|unit| format!("+{unit}"))));
    let rows: [(&str, &[CellReport]); 2] =
        [("interpolated", &certificate.detection.frontal), ("whole-pixel", &certificate.detection.frontal_whole_pixel)];
    for decade in (10..=70).step_by(10) {
        for (rule, cells) in rows {
            let cells: Vec<_> = cells.iter().filter(|cell| cell.distance_cm / 10 * 10 == decade).collect();
            let same = cells.iter().all(|cell| cell.rate.found.reference == cell.rate.found.fixedpoint);
            let pipelines = if same { &[("both", 0)][..] } else { &[("reference", 0), ("fixedpoint", 1)] };
            for &(pipeline, found) in pipelines {
                let name = [decade.to_string(), rule.to_owned(), pipeline.to_owned()];
                table.add_row(name.into_iter().chain(cells.iter().map(|cell| percent(cell.rate, found))));
            }
        }
    }
    right_aligned(table, 3)
}

fn percent(rate: Rate, pipeline: usize) -> String {
    let found = if pipeline == 0 { rate.found.reference } else { rate.found.fixedpoint };
    if rate.views == 0 {
        return "-".to_owned();
    }
    let percent = 100.0 * found as f64 / rate.views as f64;
    if found == rate.views { "100".to_owned() } else { format!("{percent:.1}") }
}

fn scenes(certificate: &Certificate) -> String {
    let rates = certificate.detection.scenes;
    let mut text = String::new();
    for (name, rate) in [
        ("first landmark in range", rates.in_range),
        ("first landmark out of range or cut off", rates.out_of_range),
        ("blank walls with dark things: a landmark", rates.without_landmark.blank),
        ("rows of bars: a landmark", rates.without_landmark.bars),
    ] {
        let _ = writeln!(
            text,
            "{name}: found in {} % by the reference, {} % by the port, of {}",
            percent(rate, 0),
            percent(rate, 1),
            rate.views
        );
    }
    let coverage = certificate.coverage;
    let _ = writeln!(
        text,
        "distance x inclination x bearing: {} of {} boxes visited, {} to {} scenes in a box",
        coverage.visited, coverage.boxes, coverage.fewest, coverage.most
    );
    text
}

/// Wrong payloads by part, beside what the CRC alone would let through: 1 in 256 of the words that reach it, if those that
/// it refuses are random.
fn parts(certificate: &Certificate) -> String {
    let header = ["part", "frames", "wrong payloads", "refused by CRC", "by CRC alone", "equal layers", "ambiguous"];
    let mut table = table(header);
    for part in &certificate.parts {
        let count = &part.count;
        let by_crc_alone = count.refused_by_crc.reference as f64 / 255.0;
        table.add_row([
            part.part.to_owned(),
            count.frames.to_string(),
            both(count.wrong_payloads),
            both(count.refused_by_crc),
            format!("{by_crc_alone:.1}"),
            both(count.refused_as_equal),
            both(count.ambiguous),
        ]);
    }
    right_aligned(table, 1)
}
