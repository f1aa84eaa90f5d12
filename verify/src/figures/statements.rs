//! Where we agree with the paper, where not, and why: sentences made from the numbers, by thresholds that they state.

use super::limits::{Prediction, RowReading, row_share};
use super::regressions::{Regressions, Sample};
use super::report::{Found, InclinationRange, Report};
use super::sightings::PerRule;
use super::spread::Spread;
use crate::findings::Both;
use reference::camera::Camera;
use reference::landmark::{Format, Landmark};
use reference::range::MIN_STRIPE_PIXELS;
use reference::regression::{EQUAL_WIDTH, MAJOR, MINOR, ROTATION};
use reference::render::Light;
use serde::Serialize;

/// One comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statement {
    /// What is compared.
    pub subject: String,
    /// What the paper has, or what is expected.
    pub paper: String,
    /// What we have.
    pub ours: String,
    /// When they agree.
    pub threshold: String,
    /// Whether they do.
    pub agrees: bool,
    /// Why, or what else there is to know.
    pub why: String,
}

/// Relative deviation of a range from its prediction that still is agreement.
pub const RANGE_TOLERANCE: f64 = 0.10;
/// Factor between standard deviations that still is the same order of magnitude: √10 either way.
pub const MAGNITUDE: f64 = 3.162_277_660_168_379_5;
/// Relative deviation of a regression's slope that still is agreement.
pub const SLOPE_TOLERANCE: f64 = 0.25;
/// Share of the variance of ln λ that an exponential growth must explain.
pub const EXPONENTIAL: f64 = 0.80;
/// Deviation of the rotation's gain that still is agreement.
pub const GAIN_TOLERANCE: f64 = 0.20;
/// Deviation of the rotation's step, radians, that still is agreement.
pub const STEP_TOLERANCE: f64 = 0.20;
/// By what factor interpolated crossings must be better: half of the smallest of design.md's table, 110 to 16 mm, 32 to
/// 4.5 mm, 159 to 34 mm and 168 to 39 mm, is 2.2.
pub const BETTER: f64 = 2.0;
/// Factor within which a cause explains a standard deviation.
pub const MOSTLY: f64 = 1.5;
/// The paper's false detections and views of Fig. 9 a).
pub const PAPER_FALSE: (u64, u64) = (3, 1320);
/// Where the paper's detection rate drops frontally, metres.
pub const PAPER_DROP: f64 = 0.50;

/// All comparisons, in the order of the figures.
#[must_use]
pub fn statements(report: &Report) -> Vec<Statement> {
    let mut all = vec![same(report)];
    all.extend(drop_statement(report));
    all.push(false_detections(report));
    all.extend(range_statements(report));
    if let Some(fits) = report.regressions.whole_pixel {
        let samples: Vec<Sample> = report.poses.iter().map(|cell| cell.sample(|errors| errors.whole_pixel)).collect();
        all.push(magnitude("λ1, standard deviation", &samples, |d| MAJOR.variance(d), |spread| spread.major));
        all.push(magnitude("λ2, standard deviation", &samples, |d| MINOR.variance(d), |spread| spread.minor));
        all.push(exponential(&fits));
        all.push(major_slope(report, &fits));
        all.push(minor_slope(&fits, &samples));
        all.push(rotation(&fits));
        all.push(independence(&samples));
    }
    all.extend(better(report));
    all
}

fn cm(metres: f64) -> String {
    format!("{:.1} cm", 100.0 * metres)
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn same(report: &Report) -> Statement {
    let pipelines = &report.pipelines;
    Statement {
        subject: "reference and port".to_owned(),
        paper: "the same".to_owned(),
        ours: if pipelines.agree() {
            "the same".to_owned()
        } else {
            format!("differ in {}", pipelines.failing.join(", "))
        },
        threshold: "every stage within its bound in every frame".to_owned(),
        agrees: pipelines.agree(),
        why: format!(
            "{} frames in lockstep, {} with a marginal decision, {} of them decided differently",
            pipelines.frames, pipelines.marginal, pipelines.differing
        ),
    }
}

/// Fig. 9 a): the frontal drop.
fn drop_statement(report: &Report) -> Option<Statement> {
    let range = report.ranges.whole_pixel.inclinations.first()?;
    let found = range.half?.metres;
    let (camera, landmark, light) = (Camera::epuck(), Landmark::new(Format::Paper), Light::default());
    let share = row_share(&camera, &landmark, found);
    let at_drop: Vec<&Found> =
        report.barcodes.iter().filter(|cell| cell.distance_cm == 50).map(|cell| &cell.seen.whole_pixel).collect();
    let at_drop = at_drop.iter().map(|found| found.rate()).sum::<f64>() / at_drop.len().max(1) as f64;
    Some(Statement {
        subject: "9 a) frontal drop".to_owned(),
        paper: format!("{}, which is (6) as printed", cm(PAPER_DROP)),
        ours: format!("half of the views at {}", cm(found)),
        threshold: format!("within {}", percent(RANGE_TOLERANCE)),
        agrees: (found / PAPER_DROP - 1.0).abs() <= RANGE_TOLERANCE,
        why: format!(
            "(6) is where the outermost part of the row leaves the stripes; a row integrates over its height, so there the \
             contrast only begins to fade. At {} {} of the row still sees stripes, {:.0} of {:.0} grey levels, where \
             THRESH-4 asks for 24; it is 0 at {}. At 50 cm, {:.2} px per stripe, whole pixels find {} of the four \
             barcodes' views",
            cm(found),
            percent(share),
            share * (light.white - light.black),
            light.white - light.black,
            cm(RowReading::AnyRow.range(&camera, &landmark, 0.0)),
            camera.focal_length * landmark.stripe_width / PAPER_DROP,
            percent(at_drop),
        ),
    })
}

fn sum(cells: impl Iterator<Item = Both>) -> Both {
    cells.fold(Both::default(), |sum, it| Both {
        reference: sum.reference + it.reference,
        fixedpoint: sum.fixedpoint + it.fixedpoint,
    })
}

fn false_detections(report: &Report) -> Statement {
    let wrong = report.barcodes.iter().map(|cell| cell.seen.whole_pixel.wrong);
    let wrong = sum(wrong);
    let interpolated = sum(report.barcodes.iter().map(|cell| cell.seen.interpolated.wrong));
    let views: u64 = report.barcodes.iter().map(|cell| cell.seen.whole_pixel.views).sum();
    let (paper, of) = PAPER_FALSE;
    Statement {
        subject: "9 a) false detections".to_owned(),
        paper: format!("{paper} of {of}"),
        ours: format!("{} of {views} (port {})", wrong.reference, wrong.fixedpoint),
        threshold: "no more often".to_owned(),
        agrees: wrong.reference * of <= paper * views,
        why: format!("by interpolated crossings {} (port {})", interpolated.reference, interpolated.fixedpoint),
    }
}

fn reading(predictions: &[Prediction], wanted: RowReading) -> Option<&Prediction> {
    predictions.iter().find(|prediction| prediction.reading == wanted)
}

/// Fig. 9 b): ranges by inclination.
fn range_statements(report: &Report) -> Vec<Statement> {
    let mut all = Vec::new();
    for (rule, ranges) in report.ranges.named() {
        for prediction in &ranges.best {
            let paper = reading(&ranges.paper, prediction.reading).map_or(f64::NAN, |paper| paper.worst);
            let deviations: Vec<String> =
                prediction.deviations.iter().map(|deviation| format!("{:+.1}", 100.0 * deviation)).collect();
            all.push(Statement {
                subject: format!("9 b) ranges, {rule}, (6) {}", prediction.reading.name()),
                paper: "min((5), (6)) with one L_min".to_owned(),
                ours: format!("L_min {:.2} px: worst {}", prediction.min_stripe_pixels, percent(prediction.worst)),
                threshold: format!("within {} at every inclination", percent(RANGE_TOLERANCE)),
                agrees: prediction.worst <= RANGE_TOLERANCE,
                why: format!(
                    "by inclination {} %; with the paper's 1.5 px the worst is {}",
                    deviations.join(", "),
                    percent(paper)
                ),
            });
        }
        all.extend(min_stripe(rule, &ranges.inclinations, reading(&ranges.best, RowReading::Contrast)));
    }
    all
}

/// The `L_min` that explains the ranges.
fn min_stripe(rule: &str, ranges: &[InclinationRange], best: Option<&Prediction>) -> Option<Statement> {
    let best = best?;
    // Rates where the narrowest stripe is 1.5 px wide and (6) still holds as printed.
    let rates = ranges.iter().filter(|range| range.stripe_width_m <= range.scan_line_m).filter_map(|range| {
        let (_, rate) = range.rates.iter().rfind(|(cm, _)| f64::from(*cm) / 100.0 <= range.stripe_width_m)?;
        Some(format!("{}° {:.0} %", range.inclination_deg, 100.0 * rate))
    });
    let rates: Vec<String> = rates.collect();
    Some(Statement {
        subject: format!("9 b) L_min, {rule}"),
        paper: format!("{MIN_STRIPE_PIXELS:.2} px"),
        ours: format!("{:.2} px", best.min_stripe_pixels),
        threshold: format!("within {}", percent(RANGE_TOLERANCE)),
        agrees: (best.min_stripe_pixels / MIN_STRIPE_PIXELS - 1.0).abs() <= RANGE_TOLERANCE,
        why: format!(
            "where (5) has 1.5 px and (6) does not end it sooner, {} of the views are found; here a barcode is refused below \
             1.25 px on the average of its stripes (HYPO-11), the paper does not say what ended its detection",
            rates.join(", ")
        ),
    })
}

/// Our standard deviations over the paper's, cell by cell, in ascending order.
fn ratios(samples: &[Sample], paper: fn(f64) -> f64, ours: fn(&Spread) -> f64) -> Vec<f64> {
    let ratio = |sample: &Sample| Some((ours(sample.usable()?) / paper(sample.distance)).sqrt());
    let mut ratios: Vec<f64> = samples.iter().filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

/// The geometric mean; 1 of none.
fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len().max(1) as f64).exp()
}

fn magnitude(name: &str, samples: &[Sample], paper: fn(f64) -> f64, ours: fn(&Spread) -> f64) -> Statement {
    let ratios = ratios(samples, paper, ours);
    let within = ratios.iter().filter(|&&ratio| (1.0 / MAGNITUDE..=MAGNITUDE).contains(&ratio)).count();
    let mean = geometric_mean(&ratios);
    Statement {
        subject: format!("10, (11) {name}"),
        paper: "(11) at the cells' distances".to_owned(),
        ours: format!(
            "{mean:.2} times, from {:.2} to {:.2}",
            ratios.first().unwrap_or(&f64::NAN),
            ratios.last().unwrap_or(&f64::NAN)
        ),
        threshold: format!("geometric mean and half of the cells within a factor of {MAGNITUDE:.2}"),
        agrees: (1.0 / MAGNITUDE..=MAGNITUDE).contains(&mean) && 2 * within >= ratios.len(),
        why: format!("{within} of {} cells are within that factor one by one", ratios.len()),
    }
}

fn exponential(fits: &Regressions) -> Statement {
    let (major, minor) = (fits.major.r_squared, fits.minor.r_squared);
    let (exponentials, powers) = (major + minor, fits.major_power.r_squared + fits.minor_power.r_squared);
    Statement {
        subject: "10, (11) exponential growth".to_owned(),
        paper: "ln λ linear in d".to_owned(),
        ours: format!("R² {major:.2} and {minor:.2}"),
        threshold: format!("R² at least {EXPONENTIAL:.2} for both"),
        agrees: major >= EXPONENTIAL && minor >= EXPONENTIAL,
        why: format!(
            "a power of the distance explains {}, {:.2} and {:.2}: λ1 as d^{:.1}, λ2 as d^{:.1}. By the geometry it is d⁶ and \
             d⁴ for small errors: a transition's error in pixels turns the obliquity's angle by d² and scales the distance \
             by d, so the position is off by d³ along the circle of equal width and by d² across it",
            if powers > exponentials { "more" } else { "no more" },
            fits.major_power.r_squared,
            fits.minor_power.r_squared,
            fits.major_power.slope,
            fits.minor_power.slope
        ),
    }
}

fn slopes(fits: Option<Regressions>) -> String {
    fits.map_or("-".to_owned(), |fits| format!("{:.1}", fits.major.slope))
}

/// By how much the slope of ln λ1 moves at most when a choice is changed over the same cells, and when only the cells
/// are those that the change leaves.
fn largest_effects(report: &Report, fits: &Regressions) -> (f64, f64) {
    let slopes = report.changes.iter().filter_map(|it| Some((it.regressions?.major.slope, it.unchanged?.major.slope)));
    slopes.fold((0.0, 0.0), |(choice, selection): (f64, f64), (changed, unchanged)| {
        (choice.max((changed - unchanged).abs()), selection.max((unchanged - fits.major.slope).abs()))
    })
}

fn major_slope(report: &Report, fits: &Regressions) -> Statement {
    let changes: Vec<String> = report
        .changes
        .iter()
        .skip(1)
        .map(|it| format!("{} {} ({})", it.change, slopes(it.regressions), slopes(it.unchanged)))
        .collect();
    let (choice, selection) = largest_effects(report, fits);
    let frozen = report.changes.last().map_or(0, |last| last.without_spread);
    let cells = report.changes.last().map_or(0, |last| last.cells);
    Statement {
        subject: "10, (11) slope of ln λ1".to_owned(),
        paper: format!("{:.2} d {:+.2}", MAJOR.slope, MAJOR.intercept),
        ours: format!("{:.2} d {:+.2}", fits.major.slope, fits.major.intercept),
        threshold: format!("slope within {}", percent(SLOPE_TOLERANCE)),
        agrees: (fits.major.slope / MAJOR.slope - 1.0).abs() <= SLOPE_TOLERANCE,
        why: format!(
            "with one choice changed (and without, over the same cells) the slope is: {}. The choices themselves move it by \
             up to {choice:.1}, the cells that are left by up to {selection:.1}. From one heading instead of many, whole \
             pixels repeat: in {frozen} of {cells} cells every view gives the same pose; the paper does not say how its \
             views differed",
            changes.join("; ")
        ),
    }
}

/// The standard deviation across a circle of equal width that an error along it leaves by its bend: the circle has the
/// diameter `d / cos θ`, an error `u` leaves the tangent by `u² cos θ / d`, and `u²` of a Gaussian `u` has the standard
/// deviation `√2 λ1`.
fn bend(sample: &Sample, spread: &Spread) -> f64 {
    core::f64::consts::SQRT_2 * spread.major * sample.inclination.cos() / sample.distance
}

fn minor_slope(fits: &Regressions, samples: &[Sample]) -> Statement {
    let bent = |sample: &Sample| {
        let spread = sample.usable()?;
        (sample.distance >= 0.35).then(|| bend(sample, spread) / spread.minor.sqrt())
    };
    let bends: Vec<f64> = samples.iter().filter_map(bent).collect();
    let share = geometric_mean(&bends);
    Statement {
        subject: "10, (11) slope of ln λ2".to_owned(),
        paper: format!("{:.2} d {:+.2}", MINOR.slope, MINOR.intercept),
        ours: format!("{:.2} d {:+.2}", fits.minor.slope, fits.minor.intercept),
        threshold: format!("slope within {}", percent(SLOPE_TOLERANCE)),
        agrees: (fits.minor.slope / MINOR.slope - 1.0).abs() <= SLOPE_TOLERANCE,
        why: format!(
            "errors lie along the circle of equal width, whose bend alone makes them √2 λ1 cos θ/d wide: from 35 cm on that \
             is {share:.2} times what we see (geometric mean), {}",
            if (1.0 / MOSTLY..=MOSTLY).contains(&share) {
                "so that λ2 grows as λ1² there"
            } else {
                "which does not explain it"
            }
        ),
    }
}

fn rotation(fits: &Regressions) -> Statement {
    let (gain, step) = (fits.rotation.slope, -fits.rotation.intercept);
    let near = |gain_is: f64, step_is: f64| {
        (gain - gain_is).abs() <= GAIN_TOLERANCE && (step - step_is).abs() <= STEP_TOLERANCE
    };
    let (paper, closed) = (near(ROTATION.gain, ROTATION.step), near(EQUAL_WIDTH.gain, EQUAL_WIDTH.step));
    Statement {
        subject: "10, (12) rotation".to_owned(),
        paper: format!("{:.2} θ - {:.2} sgn θ", ROTATION.gain, ROTATION.step),
        ours: format!("{gain:.2} θ - {step:.2} sgn θ"),
        threshold: format!("gain within {GAIN_TOLERANCE:.2} and step within {STEP_TOLERANCE:.2} rad"),
        agrees: paper,
        why: format!(
            "the closed form, 2 θ - π/2 sgn θ, {}; R² {:.2}",
            if closed { "agrees as well" } else { "does not agree" },
            fits.rotation.r_squared
        ),
    }
}

/// The paper takes (x, y) as independent of θ.
fn independence(samples: &[Sample]) -> Statement {
    let correlations: Vec<f64> =
        samples.iter().filter_map(|sample| Some(sample.usable()?.heading_correlation.abs())).collect();
    let mean = correlations.iter().sum::<f64>() / correlations.len().max(1) as f64;
    Statement {
        subject: "10, (x, y) and θ".to_owned(),
        paper: "assumed independent".to_owned(),
        ours: format!("mean correlation along the major axis {mean:.2}"),
        threshold: "at most 0.30".to_owned(),
        agrees: mean <= 0.30,
        why: "the landmark's bearing in the image is known to a pixel: who stands elsewhere on the circle of equal width \
              looks from elsewhere (ERRATA-9)"
            .to_owned(),
    }
}

/// By what factor interpolated crossings are better, cell by cell, in ascending order.
fn improvements(report: &Report) -> Vec<f64> {
    let improvement = |errors: &PerRule<Option<Sample>>| {
        let major = |sample: &Option<Sample>| Some(sample.as_ref()?.usable()?.major);
        Some((major(&errors.whole_pixel)? / major(&errors.interpolated)?).sqrt())
    };
    let cells = report.poses.iter().map(|cell| PerRule {
        whole_pixel: Some(cell.sample(|errors| errors.whole_pixel)),
        interpolated: Some(cell.sample(|errors| errors.interpolated)),
    });
    let mut factors: Vec<f64> = cells.filter_map(|cell| improvement(&cell)).collect();
    factors.sort_by(f64::total_cmp);
    factors
}

fn better(report: &Report) -> Option<Statement> {
    let factors = improvements(report);
    let (least, most) = (factors.first()?, factors.last()?);
    Some(Statement {
        subject: "10, interpolated crossings".to_owned(),
        paper: "whole pixels".to_owned(),
        ours: format!("{:.1} times more precise, from {least:.1} to {most:.1}", geometric_mean(&factors)),
        threshold: format!("at least {BETTER:.1} times in every cell"),
        agrees: *least >= BETTER,
        why: "standard deviation along the major axis".to_owned(),
    })
}
