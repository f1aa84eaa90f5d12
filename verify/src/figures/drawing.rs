//! The figures as SVG, in black and grey, readable when printed.

use super::panel::{Area, Axis, Curve, Dash, DrawError, Entry, Mark, Panel, Pen, Scale, legend};
use super::regressions::{Regressions, unwrapped};
use super::report::{CellRates, Found, Report};
use super::sightings::PerRule;
use super::spread::Spread;
use crate::scenes::{PAPER_BARCODES, PAPER_INCLINATIONS};
use core::f64::consts::PI;
use plotters::prelude::{IntoDrawingArea, SVGBackend, WHITE};
use reference::regression::{EQUAL_WIDTH, Growth, MAJOR, MINOR, ROTATION, Rotation};

/// A figure's file name and how to draw it.
pub type Figure = (&'static str, fn(&Report) -> Result<String, DrawError>);

/// All figures.
pub const FIGURES: [Figure; 3] = [("fig9a.svg", fig9a), ("fig9b.svg", fig9b), ("fig10.svg", fig10)];

const fn pen(grey: u8, width: u32, dash: Dash) -> Pen {
    Pen { grey, width, dash }
}

/// The paper's estimator.
const WHOLE: Pen = pen(0, 2, Dash::Solid);
/// The default.
const INTERPOLATED: Pen = pen(140, 2, Dash::Solid);
/// What the paper has.
const PAPER: Pen = pen(0, 2, Dash::Dashed);
/// The same of the smaller eigenvalue.
const PAPER_MINOR: Pen = pen(140, 2, Dash::Dashed);
/// A closed form.
const FORM: Pen = pen(60, 2, Dash::Dotted);
/// What has no line.
const POINTS: Pen = pen(0, 1, Dash::None);
const GREY_POINTS: Pen = pen(110, 1, Dash::None);

/// Draws on a white page of the given size: `fill` has everything above the legend's strip, and the strip.
fn page(
    size: (u32, u32),
    strip: u32,
    fill: impl FnOnce(&Area<'_>, &Area<'_>) -> Result<(), DrawError>,
) -> Result<String, DrawError> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(|error| error.to_string())?;
        let (upper, lower) = root.split_vertically(size.1 - strip);
        fill(&upper, &lower)?;
        root.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

fn distance(ends: (f64, f64)) -> Axis {
    Axis { label: "distance, cm", ends, scale: Scale::Linear }
}

fn curve(points: Vec<(f64, f64)>, pen: Pen, mark: Mark) -> Curve {
    Curve { points, pen, mark }
}

/// Both rules' rates, in per cent, of a row of cells.
fn rates(cells: &[CellRates], row: u32, rule: fn(&PerRule<Found>) -> Found) -> Vec<(f64, f64)> {
    let cells = cells.iter().filter(|cell| cell.row == row);
    cells.map(|cell| (f64::from(cell.distance_cm), 100.0 * rule(&cell.seen).rate())).collect()
}

const RATE: Axis = Axis { label: "found, % of the views", ends: (0.0, 104.0), scale: Scale::Linear };

/// An upright line at a distance in metres.
fn upright(metres: f64, pen: Pen) -> Curve {
    curve(vec![(100.0 * metres, 0.0), (100.0 * metres, 104.0)], pen, Mark::None)
}

/// Detection of four barcodes frontally.
fn fig9a(report: &Report) -> Result<String, DrawError> {
    page((1000, 760), 100, |upper, lower| {
        for (area, barcode) in upper.split_evenly((2, 2)).iter().zip(0..) {
            let mut curves = vec![
                curve(rates(&report.barcodes, barcode, |seen| seen.interpolated), INTERPOLATED, Mark::Ring),
                curve(rates(&report.barcodes, barcode, |seen| seen.whole_pixel), WHOLE, Mark::Dot),
            ];
            if let Some(frontal) = report.ranges.whole_pixel.inclinations.first() {
                curves.push(upright(frontal.scan_line_m, PAPER));
                curves.extend(frontal.half.map(|half| upright(half.metres, FORM)));
            }
            let title = format!("barcode {} of {PAPER_BARCODES}, frontal", barcode + 1);
            Panel { title, x: distance((5.0, 75.0)), y: RATE, x_labels: 8, curves }.draw(area)?;
        }
        let entries: [Entry<'_>; 4] = [
            (WHOLE, Mark::Dot, "ours, whole-pixel (the paper's estimator), 30 views"),
            (PAPER, Mark::None, "paper: all four drop here, which is (6)"),
            (INTERPOLATED, Mark::Ring, "ours, interpolated crossings, 30 views"),
            (FORM, Mark::None, "ours: half of the views, whole-pixel, any barcode"),
        ];
        legend(lower, 2, &entries)
    })
}

/// Detection of a barcode by inclination.
fn fig9b(report: &Report) -> Result<String, DrawError> {
    page((1000, 1060), 120, |upper, lower| {
        for (number, (area, degrees)) in upper.split_evenly((3, 2)).iter().zip(PAPER_INCLINATIONS).enumerate() {
            let mut curves = Vec::new();
            for (range, pen) in [(&report.ranges.interpolated, INTERPOLATED), (&report.ranges.whole_pixel, WHOLE)] {
                let rates = range.inclinations.get(number).map(|range| &range.rates);
                let points = rates.into_iter().flatten().map(|&(cm, rate)| (f64::from(cm), 100.0 * rate));
                curves.push(curve(points.collect(), pen, Mark::None));
            }
            curves.push(curve(rates(&report.inclinations, degrees, |seen| seen.interpolated), GREY_POINTS, Mark::Ring));
            curves.push(curve(rates(&report.inclinations, degrees, |seen| seen.whole_pixel), POINTS, Mark::Dot));
            if let Some(range) = report.ranges.whole_pixel.inclinations.get(number) {
                curves.push(upright(range.stripe_width_m, PAPER));
                curves.push(upright(range.scan_line_m, FORM));
                curves.push(curve(vec![(100.0 * range.stripe_width_m, 50.0)], PAPER_DOT, Mark::Triangle));
                curves.push(curve(vec![(100.0 * range.scan_line_m, 50.0)], PAPER_DOT, Mark::Cross));
            }
            let title = format!("inclination {degrees}°");
            Panel { title, x: distance((5.0, 75.0)), y: RATE, x_labels: 8, curves }.draw(area)?;
        }
        let views = report.views;
        let whole = format!("ours, whole-pixel, {views} views a cm, any barcode");
        let interpolated = format!("ours, interpolated, {views} views a cm, any barcode");
        let entries: [Entry<'_>; 6] = [
            (WHOLE, Mark::None, &whole),
            (POINTS, Mark::Dot, "ours, whole-pixel, one barcode, 30 views"),
            (INTERPOLATED, Mark::None, &interpolated),
            (GREY_POINTS, Mark::Ring, "ours, interpolated, one barcode, 30 views"),
            (PAPER, Mark::Triangle, "paper: predicted by (5) with L_min 1.5 px"),
            (FORM, Mark::Cross, "paper: predicted by (6)"),
        ];
        legend(lower, 2, &entries)
    })
}

/// The dots of a prediction.
const PAPER_DOT: Pen = pen(0, 2, Dash::None);

/// A rule's name, its statistics and its regressions.
type Rule = (
    &'static str,
    fn(&PerRule<Option<Spread>>) -> Option<Spread>,
    fn(&PerRule<Option<Regressions>>) -> Option<Regressions>,
);

const RULES: [Rule; 2] = [
    ("whole-pixel", |errors| errors.whole_pixel, |fits| fits.whole_pixel),
    ("interpolated", |errors| errors.interpolated, |fits| fits.interpolated),
];

/// The look of each inclination.
const LOOKS: [(Pen, Mark); 5] = [
    (pen(0, 1, Dash::Solid), Mark::Dot),
    (pen(0, 1, Dash::Dashed), Mark::Ring),
    (pen(90, 1, Dash::Dotted), Mark::Triangle),
    (pen(130, 1, Dash::Solid), Mark::Cross),
    (pen(130, 1, Dash::Dashed), Mark::Square),
];

/// A statistic by distance: heading, vertical scale, and the statistic in the scale's unit.
type Statistic = (&'static str, Axis, fn(&Spread) -> f64);

const STATISTICS: [Statistic; 4] = [
    ("standard deviation of x", MILLIMETRES, |spread| 1000.0 * spread.deviation.x),
    ("standard deviation of y", MILLIMETRES, |spread| 1000.0 * spread.deviation.y),
    ("standard deviation of θ", Axis { label: "σ θ, degrees", ends: (0.05, 50.0), scale: Scale::Log }, |spread| {
        spread.deviation.theta.to_degrees()
    }),
    ("correlation of x and y", Axis { label: "correlation", ends: (-1.05, 1.05), scale: Scale::Linear }, |spread| {
        spread.correlation
    }),
];

const MILLIMETRES: Axis = Axis { label: "σ, mm", ends: (0.005, 1000.0), scale: Scale::Log };

/// Statistics of the poses, by both rules side by side.
fn fig10(report: &Report) -> Result<String, DrawError> {
    page((1000, 1940), 150, |upper, lower| {
        let areas = upper.split_evenly((6, 2));
        for (column, rule) in RULES.iter().enumerate() {
            for (area, statistic) in areas.iter().skip(column).step_by(2).zip(&STATISTICS) {
                by_distance(report, rule, statistic).draw(area)?;
            }
            if let [.., axes, turn] = areas.iter().skip(column).step_by(2).collect::<Vec<_>>()[..] {
                eigenvalues(report, rule).draw(axes)?;
                rotations(report, rule).draw(turn)?;
            }
        }
        let names = PAPER_INCLINATIONS.map(|degrees| format!("upper four: inclination {degrees}°"));
        let mut entries: Vec<Entry<'_>> =
            LOOKS.iter().zip(&names).map(|(&(pen, mark), name)| (pen, mark, name.as_str())).collect();
        entries.extend([
            (WHOLE, Mark::Dot, "√λ1 and rotation: ours, and our regression"),
            (PAPER, Mark::None, "√λ1 (11) and rotation (12): paper's regression"),
            (INTERPOLATED, Mark::Ring, "√λ2: ours, and our regression"),
            (PAPER_MINOR, Mark::None, "√λ2 (11): paper's regression"),
            (FORM, Mark::None, "rotation: closed form 2 θ - 90°"),
        ]);
        legend(lower, 2, &entries)
    })
}

fn by_distance(report: &Report, (rule, errors, _): &Rule, (name, axis, value): &Statistic) -> Panel {
    let row = |degrees: u32| {
        let cells = report.poses.iter().filter(move |cell| cell.inclination_deg == degrees);
        let point = |spread: &Spread, cm: u32| (f64::from(cm), value(spread));
        cells.filter_map(|cell| Some(point(cell.sample(*errors).usable()?, cell.distance_cm))).collect()
    };
    let curves = PAPER_INCLINATIONS.iter().zip(LOOKS).map(|(&degrees, (pen, mark))| curve(row(degrees), pen, mark));
    Panel {
        title: format!("{name}, {rule}"),
        x: distance((5.0, 65.0)),
        y: axis.clone(),
        x_labels: 7,
        curves: curves.collect(),
    }
}

/// The standard deviation, in mm, that a growth has at distances from 10 to 60 cm.
fn growth(growth: Growth) -> Vec<(f64, f64)> {
    let point = |cm: u32| (f64::from(cm), 1000.0 * growth.variance(f64::from(cm) / 100.0).sqrt());
    (10..=60).map(point).collect()
}

fn eigenvalues(report: &Report, (rule, errors, fits): &Rule) -> Panel {
    let points = |eigenvalue: fn(&Spread) -> f64| {
        let point = |cm: u32, spread: &Spread| (f64::from(cm), 1000.0 * eigenvalue(spread).sqrt());
        let cells = report.poses.iter();
        cells.filter_map(|cell| Some(point(cell.distance_cm, cell.sample(*errors).usable()?))).collect()
    };
    let mut curves = vec![
        curve(points(|spread| spread.minor), GREY_POINTS, Mark::Ring),
        curve(points(|spread| spread.major), POINTS, Mark::Dot),
        curve(growth(MINOR), PAPER_MINOR, Mark::None),
        curve(growth(MAJOR), PAPER, Mark::None),
    ];
    if let Some(fits) = fits(&report.regressions) {
        for (line, pen) in [(fits.minor, INTERPOLATED), (fits.major, WHOLE)] {
            curves.push(curve(growth(Growth { slope: line.slope, intercept: line.intercept }), pen, Mark::None));
        }
    }
    Panel {
        title: format!("axes of the covariance of (x, y), {rule}"),
        x: distance((5.0, 65.0)),
        y: Axis { label: "√λ, mm", ..MILLIMETRES },
        x_labels: 7,
        curves,
    }
}

fn rotations(report: &Report, (rule, errors, fits): &Rule) -> Panel {
    let line = |rotation: Rotation| -> Vec<(f64, f64)> {
        let axis = |degrees: u32| rotation.gain * f64::from(degrees).to_radians() - rotation.step;
        (0..=60).map(|degrees| (f64::from(degrees), axis(degrees).to_degrees())).collect()
    };
    let point = |sample: &super::regressions::Sample| {
        let rotation = unwrapped(sample.inclination, sample.usable()?.rotation);
        Some((sample.inclination.to_degrees(), rotation * 180.0 / PI))
    };
    let points = report.poses.iter().filter_map(|cell| point(&cell.sample(*errors))).collect();
    let mut curves = vec![
        curve(points, POINTS, Mark::Dot),
        curve(line(EQUAL_WIDTH), FORM, Mark::None),
        curve(line(ROTATION), PAPER, Mark::None),
    ];
    if let Some(fits) = fits(&report.regressions) {
        let ours = Rotation { gain: fits.rotation.slope, step: -fits.rotation.intercept };
        curves.push(curve(line(ours), WHOLE, Mark::None));
    }
    Panel {
        title: format!("direction of the larger axis, {rule}"),
        x: Axis { label: "inclination θ, degrees", ends: (-5.0, 65.0), scale: Scale::Linear },
        y: Axis { label: "rotation, degrees", ends: (-110.0, 60.0), scale: Scale::Linear },
        x_labels: 8,
        curves,
    }
}
