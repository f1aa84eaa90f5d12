//! How far the estimate is from the truth over a run, as in the paper's Figs. 12 and 13: position above, heading below.

use super::frame::{Frame, Scale, apart};
use super::sign::{Entry, Sign, draw_legend, estimate_line, legend_height, odometry_line, port_line, recovery_line};
use super::{Has, MARGIN, Page, Pose, SKY, Sample, WIDTH, count, draw_title, lifts, title_height};
use crate::drawing::DrawingError;
use crate::drawing::area::grid_step;
use core::f64::consts::{PI, TAU};
use core::ops::Range;
use plotters::prelude::*;

/// Height of a panel, pixels.
const PANEL: i32 = 500;
/// Between the panels, pixels.
const GAP: i32 = 40;
/// Room for the numbers and the name of an axis, left and below, pixels.
const LABELS: (i32, i32) = (150, 116);
/// Columns of the legend.
const COLUMNS: i32 = 3;
/// The grid's steps along an axis of a panel, at most.
const STEPS: f64 = 7.0;
/// The grid's steps along the time, at most.
const TIME_STEPS: f64 = 13.0;
/// From a dot or a cross to the next of its kind, pixels at least.
const DOTS: i32 = 8;
/// A lift is drawn at least so wide, pixels.
const LIFT: i32 = 6;

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Errors<'a> {
    /// Lines of about 110 characters; the first one is bold.
    pub title: &'a str,
    /// The run.
    pub samples: &'a [Sample],
    /// The robot's radius, metres: what the paper compares the error of the position with. The
    /// scale reaches it.
    pub robot_radius: Option<f64>,
}

/// The drawing as the text of an SVG file, the same for the same input.
pub fn draw(errors: &Errors<'_>) -> Result<String, DrawingError> {
    let samples = errors.samples;
    let (upper, lower) = (Panel::position(errors), Panel::heading(errors));
    let entries = entries(errors);
    let legend = lower.frame.sides()[3] + LABELS.1;
    let size = (WIDTH, legend + legend_height(COLUMNS, &entries) + MARGIN);
    let left = lower.frame.corner.0;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (size.0.unsigned_abs(), size.1.unsigned_abs()));
        let page = root.into_drawing_area();
        page.fill(&WHITE)?;
        draw_title(&page, left, errors.title)?;
        upper.draw(&page, samples, None)?;
        lower.draw(&page, samples, Some("time (s)"))?;
        draw_legend(&page, (left, legend), (COLUMNS, (WIDTH - left - MARGIN) / COLUMNS), &entries)?;
        page.present()?;
    }
    Ok(svg)
}

/// An error's size, in its panel's unit.
type Measure = fn(&Pose, &Pose) -> f64;

/// Distance of a belief from the truth, centimetres.
fn position_error(belief: &Pose, truth: &Pose) -> f64 {
    100.0 * (belief[0] - truth[0]).hypot(belief[1] - truth[1])
}

/// The smaller angle between a believed and a true heading, degrees from 0 to 180.
fn heading_error(belief: &Pose, truth: &Pose) -> f64 {
    let turn = (belief[2] - truth[2]).rem_euclid(TAU);
    turn.min(TAU - turn) * 180.0 / PI
}

/// Two standard deviations, centimetres.
fn two_sigma(sample: &Sample) -> Option<f64> {
    sample.deviation.map(|deviation| 200.0 * deviation)
}

/// One of the two diagrams.
struct Panel {
    frame: Frame,
    name: &'static str,
    measure: Measure,
    /// What the filter itself expects of the error.
    expected: fn(&Sample) -> Option<f64>,
    /// A value with a line across the panel.
    level: Option<f64>,
}

impl Panel {
    fn position(errors: &Errors<'_>) -> Self {
        let level = errors.robot_radius.map(|radius| 100.0 * radius);
        let largest = largest(errors.samples, position_error);
        let scale = if largest > 10.0 {
            Scale::log(0.1, 10_f64.powf(largest.log10().ceil()))
        } else {
            // A band that is much wider than the errors is cut, so that these can be read.
            let band =
                errors.samples.iter().filter_map(two_sigma).filter(|value| value.is_finite()).fold(0.0, f64::max);
            let most = band.min(2.0 * largest).max(1.1 * largest).max(1.1 * level.unwrap_or(0.0));
            Scale::from_zero(most.max(0.1), STEPS)
        };
        let name = "position error (cm)";
        Self { frame: frame(errors, 0, scale), name, measure: position_error, expected: two_sigma, level }
    }

    fn heading(errors: &Errors<'_>) -> Self {
        let largest = largest(errors.samples, heading_error);
        let scale =
            if largest > 20.0 { Scale::log(0.1, 200.0) } else { Scale::from_zero((1.1 * largest).max(0.1), STEPS) };
        let name = "heading error (degrees)";
        Self { frame: frame(errors, 1, scale), name, measure: heading_error, expected: |_| None, level: None }
    }

    fn draw(&self, page: &Page<'_>, samples: &[Sample], x_name: Option<&str>) -> Result<(), DrawingError> {
        let [_, top, _, bottom] = self.frame.sides();
        let expected = samples.iter().filter_map(|sample| Some([sample.time, (self.expected)(sample)?]));
        self.frame.fill_below(page, &expected.collect::<Vec<_>>(), band())?;
        for lift in lifts(samples) {
            let (left, right) = self.spanned(samples, lift);
            page.draw(&Rectangle::new([(left, top), (right, bottom)], shade()))?;
        }
        self.frame.draw_grid(page, x_name, self.name)?;
        if let Some(level) = self.level {
            self.frame.draw_line(page, &self.frame.across(level), level_line())?;
        }
        self.draw_lines(page, samples)?;
        self.draw_marks(page, samples)
    }

    /// The pixels between the sample before the robot was lifted and the one after it was put down.
    fn spanned(&self, samples: &[Sample], lift: Range<usize>) -> (i32, i32) {
        let pixel = |i: usize| samples.get(i).map_or(0, |sample| self.frame.nearest_pixel([sample.time, 0.0]).0);
        let (from, to) = (pixel(lift.start.saturating_sub(1)), pixel(lift.end.min(samples.len() - 1)));
        let wider = (LIFT - (to - from)).max(0) / 2;
        (from - wider, to + wider)
    }

    /// The error of a belief at a time.
    fn point(&self, sample: &Sample, belief: &Pose) -> [f64; 2] {
        [sample.time, (self.measure)(belief, &sample.truth)]
    }

    fn draw_lines(&self, page: &Page<'_>, samples: &[Sample]) -> Result<(), DrawingError> {
        let line = |belief: fn(&Sample) -> Option<Pose>| -> Vec<[f64; 2]> {
            let point = |sample: &Sample| belief(sample).map_or([f64::NAN; 2], |pose| self.point(sample, &pose));
            samples.iter().map(point).collect()
        };
        self.frame.draw_line(page, &line(|sample| sample.odometry), odometry_line())?;
        let [_, top, _, bottom] = self.frame.sides();
        for sample in samples.iter().filter(|sample| sample.seen.recovered) {
            let x = self.frame.nearest_pixel([sample.time, 0.0]).0;
            page.draw(&PathElement::new(vec![(x, top), (x, bottom)], recovery_line()))?;
        }
        self.frame.draw_line(page, &line(|sample| sample.port), port_line())?;
        self.frame.draw_line(page, &line(|sample| Some(sample.estimate)), estimate_line())
    }

    fn draw_marks(&self, page: &Page<'_>, samples: &[Sample]) -> Result<(), DrawingError> {
        let marks: [(Sign, Has); 2] =
            [(Sign::Used, |sample| sample.seen.used), (Sign::Gated, |sample| sample.seen.gated)];
        for (sign, has) in marks {
            let marked = samples.iter().filter(|sample| has(sample));
            let places = marked.filter_map(|sample| self.frame.pixel(self.point(sample, &sample.estimate)));
            for pixel in apart(places, DOTS) {
                sign.draw(page, pixel)?;
            }
        }
        Ok(())
    }
}

/// The largest error of the reference or the port.
fn largest(samples: &[Sample], measure: Measure) -> f64 {
    let beliefs = samples.iter().flat_map(|sample| [Some(sample.estimate), sample.port].map(|belief| (sample, belief)));
    let errors = beliefs.filter_map(|(sample, belief)| Some(measure(&belief?, &sample.truth)));
    errors.filter(|error| error.is_finite()).fold(0.0, f64::max)
}

/// The frame of the panel so far from the top.
fn frame(errors: &Errors<'_>, number: i32, y: Scale) -> Frame {
    let time = |sample: Option<&Sample>| sample.map_or(0.0, |sample| sample.time);
    let (first, last) = (time(errors.samples.first()), time(errors.samples.last()));
    let last = if last > first { last } else { first + 1.0 };
    let left = MARGIN + LABELS.0;
    Frame {
        corner: (left, title_height(errors.title) + number * (PANEL + GAP)),
        size: (WIDTH - left - 2 * MARGIN, PANEL),
        x: Scale::linear(first, last, grid_step((last - first) / TIME_STEPS)),
        y,
    }
}

fn band() -> ShapeStyle {
    SKY.mix(0.25).filled()
}

fn shade() -> ShapeStyle {
    BLACK.mix(0.18).filled()
}

fn level_line() -> ShapeStyle {
    BLACK.mix(0.6).stroke_width(2)
}

/// The legend: what there is in this drawing.
fn entries(errors: &Errors<'_>) -> Vec<Entry> {
    let samples = errors.samples;
    let (used, gated) = (count(samples, |sample| sample.seen.used), count(samples, |sample| sample.seen.gated));
    let (recovered, lifts) = (count(samples, |sample| sample.seen.recovered), lifts(samples).len());
    let port = count(samples, |sample| sample.port.is_some());
    let estimate = if port > 0 { "estimate, reference" } else { "estimate" };
    let radius =
        errors.robot_radius.map_or(String::new(), |radius| format!("robot's radius, {:.1} cm", 100.0 * radius));
    let all = [
        (samples.len(), Sign::Line(estimate_line()), estimate.to_owned()),
        (port, Sign::Line(port_line()), "estimate, fixed point (beneath)".to_owned()),
        (count(samples, |sample| sample.odometry.is_some()), Sign::Line(odometry_line()), "odometry alone".to_owned()),
        (used, Sign::Used, format!("observation used ({used})")),
        (gated, Sign::Gated, format!("observation gated ({gated})")),
        (recovered, Sign::Upright(recovery_line()), format!("filter recovered ({recovered})")),
        (lifts, Sign::Band(shade()), format!("robot lifted ({lifts})")),
        (count(samples, |sample| two_sigma(sample).is_some()), Sign::Band(band()), "2σ of the position".to_owned()),
        (usize::from(errors.robot_radius.is_some()), Sign::Line(level_line()), radius),
    ];
    all.into_iter().filter(|(there, ..)| *there > 0).map(|(_, sign, text)| (sign, text)).collect()
}
