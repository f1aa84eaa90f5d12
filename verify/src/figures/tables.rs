//! The figures as tables in the terminal.

use super::limits::Prediction;
use super::regressions::Regressions;
use super::report::{CellPoses, CellRates, InclinationRange, Report};
use super::sightings::PerRule;
use super::spread::Spread;
use crate::scenes::PAPER_DISTANCES;
use comfy_table::{CellAlignment, Table, presets};
use std::fmt::Write;

/// All tables and statements.
#[must_use]
pub fn tables(report: &Report) -> String {
    let mut text = String::new();
    let views = report.views;
    section(
        &mut text,
        "Fig. 9 a) four random barcodes frontally, found of 30 views (reference; /port where it differs)",
        &rates(&report.barcodes, |barcode| format!("barcode {}", barcode + 1)),
    );
    section(
        &mut text,
        "Fig. 9 b) one random barcode by inclination, found of 30 views",
        &rates(&report.inclinations, |degrees| format!("{degrees}°")),
    );
    let title = format!(
        "Range: where half of {views} views for each centimetre find the landmark, beside (5) at 1.5 px and (6)"
    );
    section(&mut text, &title, &ranges(report));
    section(
        &mut text,
        "Range predicted by min((5), (6)) with one L_min: deviation of the range found, per cent",
        &predictions(report),
    );
    for (rule, pick) in RULES {
        let title = format!("Fig. 10, {rule}, {views} views for each cell: errors of the pose in the landmark's frame");
        section(&mut text, &title, &poses(report, pick));
    }
    section(&mut text, "(11) and (12): ln λ in m² by d in m, rotation in rad by θ in rad", &regressions(report));
    section(&mut text, "The same with one of our choices changed (whole-pixel, reference)", &changes(report));
    section(&mut text, "Beside the paper", &statements(report));
    text
}

/// A rule's name and its statistics.
type Rule = (&'static str, fn(&PerRule<Option<Spread>>) -> Option<Spread>);

const RULES: [Rule; 2] = [("whole-pixel", |errors| errors.whole_pixel), ("interpolated", |errors| errors.interpolated)];

fn section(text: &mut String, title: &str, body: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{title}\n{}\n", body.trim_end());
}

fn table<S: ToString>(header: impl IntoIterator<Item = S>) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(header.into_iter().map(|it| it.to_string()));
    table
}

/// The text of a table whose columns from `from` on are numbers.
fn aligned(mut table: Table, from: usize) -> String {
    for column in table.column_iter_mut().skip(from) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}

fn rates(cells: &[CellRates], name: fn(u32) -> String) -> String {
    let distances = PAPER_DISTANCES.map(|cm| format!("{cm} cm"));
    let mut table = table([String::new(), "rule".to_owned()].into_iter().chain(distances).chain(["wrong".to_owned()]));
    let mut rows: Vec<u32> = cells.iter().map(|cell| cell.row).collect();
    rows.dedup();
    for row in rows {
        for rule in 0..2 {
            let seen: Vec<_> =
                cells.iter().filter(|cell| cell.row == row).map(|cell| cell.seen.named()[rule]).collect();
            let both = |reference: u64, port: u64| {
                if reference == port { reference.to_string() } else { format!("{reference}/{port}") }
            };
            let found = seen.iter().map(|(_, seen)| both(seen.found.reference, seen.found.fixedpoint));
            let wrong = |count: fn(&crate::findings::Both) -> u64| seen.iter().map(|(_, it)| count(&it.wrong)).sum();
            let wrong = both(wrong(|it| it.reference), wrong(|it| it.fixedpoint));
            let label = seen.first().map_or("", |(rule, _)| rule);
            table.add_row([name(row), label.to_owned()].into_iter().chain(found).chain([wrong]));
        }
    }
    aligned(table, 2)
}

fn cm(metres: f64) -> String {
    format!("{:.1}", 100.0 * metres)
}

fn ranges(report: &Report) -> String {
    let mut table = table(["inclination", "whole-pixel", "(first)", "interpolated", "(first)", "(5)", "(6)"]);
    let [whole, interpolated] = report.ranges.named().map(|(_, ranges)| &ranges.inclinations);
    for (whole, interpolated) in whole.iter().zip(interpolated) {
        let half = |range: &InclinationRange| {
            range.half.map_or(["-".to_owned(), "-".to_owned()], |half| [cm(half.metres), cm(half.first_metres)])
        };
        let name = [format!("{}°", whole.inclination_deg)];
        let predicted = [cm(whole.stripe_width_m), cm(whole.scan_line_m)];
        table.add_row(name.into_iter().chain(half(whole)).chain(half(interpolated)).chain(predicted));
    }
    aligned(table, 1) + "\ncm; (first): where the rate falls below one half for the first time"
}

fn predictions(report: &Report) -> String {
    let mut table = table(["(6) read as", "rule", "L_min px", "0°", "15°", "30°", "45°", "60°", "worst"]);
    for (rule, ranges) in report.ranges.named() {
        for prediction in ranges.paper.iter().chain(&ranges.best) {
            table.add_row(prediction_row(rule, prediction));
        }
    }
    aligned(table, 2)
}

fn prediction_row(rule: &str, prediction: &Prediction) -> Vec<String> {
    let mut row =
        vec![prediction.reading.name().to_owned(), rule.to_owned(), format!("{:.3}", prediction.min_stripe_pixels)];
    row.extend(prediction.deviations.iter().map(|deviation| format!("{:+.1}", 100.0 * deviation)));
    row.push(format!("{:.1}", 100.0 * prediction.worst));
    row
}

fn poses(report: &Report, rule: fn(&PerRule<Option<Spread>>) -> Option<Spread>) -> String {
    let header = [
        "inclination",
        "cm",
        "poses",
        "σ x mm",
        "σ y mm",
        "σ θ °",
        "corr(x, y)",
        "√λ1 mm",
        "√λ2 mm",
        "rotation °",
        "mean x mm",
        "mean y mm",
    ];
    let mut table = table(header);
    for cell in &report.poses {
        table.add_row(pose_row(cell, rule(&cell.errors)));
    }
    aligned(table, 1)
}

fn pose_row(cell: &CellPoses, spread: Option<Spread>) -> Vec<String> {
    let mut row = vec![format!("{}°", cell.inclination_deg), cell.distance_cm.to_string()];
    let Some(spread) = spread else {
        row.push("too few".to_owned());
        return row;
    };
    row.push(spread.poses.to_string());
    let millimetres = |metres: f64| format!("{:.2}", 1000.0 * metres);
    row.extend([millimetres(spread.deviation.x), millimetres(spread.deviation.y)]);
    row.push(format!("{:.2}", spread.deviation.theta.to_degrees()));
    row.push(format!("{:+.2}", spread.correlation));
    row.extend([millimetres(spread.major.sqrt()), millimetres(spread.minor.sqrt())]);
    row.push(format!("{:+.0}", spread.rotation.to_degrees()));
    row.extend([millimetres(spread.mean.x), millimetres(spread.mean.y)]);
    row
}

/// The cells of a row of regressions.
fn fitted(fits: Option<Regressions>) -> Vec<String> {
    let Some(fits) = fits else { return vec!["too few cells".to_owned()] };
    vec![
        format!("{:.2} d {:+.2}", fits.major.slope, fits.major.intercept),
        format!("{:.2}", fits.major.r_squared),
        format!("{:.2} d {:+.2}", fits.minor.slope, fits.minor.intercept),
        format!("{:.2}", fits.minor.r_squared),
        format!("{:.2} θ {:+.2} sgn θ", fits.rotation.slope, fits.rotation.intercept),
        format!("{:.2}", fits.rotation.r_squared),
    ]
}

const FITTED: [&str; 6] = ["ln λ1", "R²", "ln λ2", "R²", "rotation", "R²"];

fn regressions(report: &Report) -> String {
    let mut table = table(["", "cells"].into_iter().chain(FITTED));
    let paper = &report.paper;
    let line = |[slope, intercept]: [f64; 2]| format!("{slope:.2} d {intercept:+.2}");
    let turn = |[gain, step]: [f64; 2]| format!("{gain:.2} θ {:+.2} sgn θ", -step);
    let blank = String::new;
    table.add_row([
        "paper".to_owned(),
        blank(),
        line(paper.major),
        blank(),
        line(paper.minor),
        blank(),
        turn(paper.rotation),
        blank(),
    ]);
    table.add_row([
        "closed form".to_owned(),
        blank(),
        blank(),
        blank(),
        blank(),
        blank(),
        turn(paper.closed_form),
        blank(),
    ]);
    for (rule, fits) in report.regressions.named() {
        let cells = fits.map_or(0, |fits| fits.cells);
        table.add_row([rule.to_owned(), cells.to_string()].into_iter().chain(fitted(*fits)));
    }
    aligned(table, 1)
}

fn changes(report: &Report) -> String {
    let mut table = table(["changed", "cells", "no spread"].into_iter().chain(FITTED));
    for change in &report.changes {
        let head = [change.change.to_owned(), change.cells.to_string(), change.without_spread.to_string()];
        table.add_row(head.into_iter().chain(fitted(change.regressions)));
        if change.regressions.is_some_and(|fits| change.unchanged != Some(fits)) {
            let head = ["  unchanged, same cells".to_owned(), String::new(), String::new()];
            table.add_row(head.into_iter().chain(fitted(change.unchanged)));
        }
    }
    aligned(table, 1)
}

fn statements(report: &Report) -> String {
    let mut text = String::new();
    for it in &report.statements {
        let verdict = if it.agrees { "agrees" } else { "DIFFERS" };
        let _ = writeln!(text, "{verdict}  {}: {}; paper: {} ({})", it.subject, it.ours, it.paper, it.threshold);
        let _ = writeln!(text, "         {}", it.why);
    }
    text
}
