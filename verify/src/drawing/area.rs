//! Detection areas seen from above, to scale.
//!
//! x, out of the wall, runs to the right of the page and y, to the right as a robot sees that looks at the wall, upwards:
//! the landmark frame L as it is. Units are centimetres.

use super::DrawingError;
use crate::certificate::format_name;
use core::ops::Range;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use reference::area::{Area, Limit};
use reference::camera::Camera;
use reference::landmark::{Landmark, stripes};

/// The longer side of the chart, pixels; the drawing can be scaled.
const CHART: f64 = 960.0;
/// Room for the numbers and the name of an axis, pixels.
const LABELS: i32 = 90;
/// Room for the title's two lines, pixels.
const TITLE: i32 = 90;
/// Room for the legend beside the chart, pixels.
const LEGEND: i32 = 530;
/// The least width of the drawing, in which the title fits, pixels.
const LEAST_WIDTH: i32 = 1300;
/// White around everything, pixels.
const MARGIN: i32 = 20;
/// Text, pixels; the library draws it at 1/1.24 of the size it is given.
const TEXT: f64 = 24.0 * 1.24;
/// From one line of text to the next, pixels.
const LINE: i32 = 36;
/// Steps of the grid along the longer side, at most.
const STEPS: f64 = 9.0;
/// A layer to draw at the origin; which one makes no difference to the area.
const HALF_WORD: u32 = 0b1100_1100_0000;

/// Colours that can be told apart by people who do not tell red from green (Okabe and Ito), in the legend's order.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// A rectangle of the page, in pixels.
type Page<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The chart's axes, in centimetres.
type Axes = Cartesian2d<RangedCoordf64, RangedCoordf64>;

/// What is drawn: areas of one camera and one landmark.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The landmark, which stands at the origin.
    pub landmark: &'a Landmark,
    /// Narrowest stripe `L_min`, pixels.
    pub min_stripe_pixels: f64,
    /// Its areas, in the order of the legend.
    pub areas: &'a [Area],
}

/// The drawing as the text of an SVG file.
pub fn draw(subject: &Subject<'_>) -> Result<String, DrawingError> {
    let outlines: Vec<Vec<(f64, f64)>> = subject.areas.iter().map(centimetres).collect();
    let frame = Frame::around(outlines.iter().flatten(), 100.0 * subject.landmark.half_width());
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, frame.size()).into_drawing_area();
        root.fill(&WHITE)?;
        let page = root.margin(MARGIN, MARGIN, MARGIN, MARGIN);
        let (title, rest) = page.split_vertically(TITLE);
        let (chart, legend) = rest.split_horizontally(LABELS + frame.pixels_of(&frame.x));
        draw_title(&title, subject)?;
        draw_chart(&chart, &frame, subject, &outlines)?;
        draw_legend(&legend, subject.areas)?;
        root.present()?;
    }
    Ok(svg)
}

/// An area's outline in centimetres, its first point repeated at the end.
fn centimetres(area: &Area) -> Vec<(f64, f64)> {
    let mut outline: Vec<(f64, f64)> = area.outline().iter().map(|&(x, y)| (100.0 * x, 100.0 * y)).collect();
    outline.extend(outline.first().copied());
    outline
}

/// The part of the landmark frame that is shown, in whole steps of the grid, centimetres.
struct Frame {
    x: Range<f64>,
    y: Range<f64>,
    step: f64,
    /// Pixels of a step: the same along both axes.
    pixels: f64,
}

impl Frame {
    /// Around points and a barcode that reaches `half_width` to either side of the origin.
    fn around<'p>(points: impl Iterator<Item = &'p (f64, f64)>, half_width: f64) -> Self {
        let (mut right, mut bottom, mut top) = (half_width, -half_width, half_width);
        for &(x, y) in points {
            right = right.max(x);
            bottom = bottom.min(y);
            top = top.max(y);
        }
        let step = grid_step(right.max(top - bottom) / STEPS);
        // A sixth of a step to spare for what is written at the border.
        let below = |value: f64| (value / step - 1.0 / 6.0).floor() * step;
        let above = |value: f64| (value / step + 1.0 / 6.0).ceil() * step;
        // Behind the wall there is room for the barcode.
        let (x, y) = (-step..above(right), below(bottom)..above(top));
        let steps = ((x.end - x.start).max(y.end - y.start) / step).round();
        Self { x, y, step, pixels: (CHART / steps).floor() }
    }

    /// How many pixels a part of an axis is long.
    fn pixels_of(&self, range: &Range<f64>) -> i32 {
        i32::from(self.steps_of(range)) * whole(self.pixels)
    }

    /// How many steps of the grid a part of an axis is long.
    fn steps_of(&self, range: &Range<f64>) -> u8 {
        u8::try_from(whole((range.end - range.start) / self.step)).unwrap_or(u8::MAX)
    }

    /// Width and height of the drawing, pixels.
    fn size(&self) -> (u32, u32) {
        let width = 2 * MARGIN + LABELS + self.pixels_of(&self.x) + LEGEND;
        let height = 2 * MARGIN + TITLE + self.pixels_of(&self.y) + LABELS;
        (width.max(LEAST_WIDTH).unsigned_abs(), height.unsigned_abs())
    }
}

/// The nearest integer to a number of pixels or of steps.
#[expect(clippy::cast_possible_truncation, reason = "a page has a few thousand pixels, and a cast saturates")]
pub(super) fn whole(value: f64) -> i32 {
    value.round() as i32
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `least`, a positive number.
pub(super) fn grid_step(least: f64) -> f64 {
    let decade = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].map(|step| step * decade).into_iter().find(|&step| step >= least).unwrap_or(10.0 * decade)
}

/// The style of all text.
fn text_style() -> TextStyle<'static> {
    ("sans-serif", TEXT).into_font().color(&BLACK)
}

fn draw_title(page: &Page<'_>, subject: &Subject<'_>) -> Result<(), DrawingError> {
    let (camera, landmark) = (subject.camera, subject.landmark);
    let landmark_line = format!(
        "Where a camera reads a landmark of format {}: stripes {:.2} mm wide, layers {:.1} mm high",
        format_name(landmark.format),
        1e3 * landmark.stripe_width,
        1e3 * landmark.stripe_height
    );
    let camera_line = format!(
        "Camera: {} x {} px, focal length {:.0} x {:.0} px, narrowest stripe {} px",
        camera.width, camera.height, camera.focal_length, camera.focal_length_vertical, subject.min_stripe_pixels
    );
    page.draw_text(&landmark_line, &text_style(), (LABELS, 0))?;
    page.draw_text(&camera_line, &text_style(), (LABELS, LINE))?;
    Ok(())
}

fn draw_chart(
    page: &Page<'_>,
    frame: &Frame,
    subject: &Subject<'_>,
    outlines: &[Vec<(f64, f64)>],
) -> Result<(), DrawingError> {
    let mut chart = ChartBuilder::on(page)
        .x_label_area_size(LABELS)
        .y_label_area_size(LABELS)
        .build_cartesian_2d(frame.x.clone(), frame.y.clone())?;
    // A multiple of the step is not always a short number.
    let number = |value: &f64| format!("{}", (value * 1e6).round() / 1e6);
    chart
        .configure_mesh()
        .label_style(text_style())
        .axis_desc_style(text_style())
        .bold_line_style(BLACK.mix(0.15))
        .light_line_style(TRANSPARENT)
        .x_labels(usize::from(frame.steps_of(&frame.x)) + 1)
        .y_labels(usize::from(frame.steps_of(&frame.y)) + 1)
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .x_desc("x, out of the wall (cm)")
        .y_desc("y, to the right as seen by who faces the wall (cm)")
        .draw()?;
    let plot = chart.plotting_area();
    draw_wall(plot, frame, subject.landmark)?;
    let colours = || COLOURS.iter().cycle();
    for (outline, colour) in outlines.iter().zip(colours()) {
        plot.draw(&Polygon::new(outline.clone(), colour.mix(0.12).filled()))?;
    }
    for (outline, colour) in outlines.iter().zip(colours()) {
        plot.draw(&PathElement::new(outline.clone(), colour.stroke_width(3)))?;
    }
    for (area, colour) in subject.areas.iter().zip(colours()) {
        draw_range(plot, area, *colour)?;
    }
    Ok(())
}

/// The wall, and on it the barcode in its true width.
fn draw_wall(plot: &DrawingArea<SVGBackend<'_>, Axes>, frame: &Frame, landmark: &Landmark) -> Result<(), DrawingError> {
    let (back, begin, end) = (frame.x.start, frame.y.start, frame.y.end);
    plot.draw(&Rectangle::new([(back, begin), (0.0, end)], BLACK.mix(0.12).filled()))?;
    plot.draw(&PathElement::new(vec![(0.0, begin), (0.0, end)], BLACK.stroke_width(2)))?;
    let name =
        Text::new("wall", (back / 2.0, end - frame.step / 2.0), text_style().pos(Pos::new(HPos::Center, VPos::Center)));
    plot.draw(&name)?;
    let (half, width) = (100.0 * landmark.half_width(), 100.0 * landmark.stripe_width);
    let depth = 0.4 * back;
    plot.draw(&Rectangle::new([(depth, -half), (0.0, half)], WHITE.filled()))?;
    // Stripes are counted from the left as seen, where y is least.
    for (j, _) in stripes(landmark.format, HALF_WORD).iter().enumerate().filter(|(_, bar)| **bar) {
        let left = j as f64 * width - half;
        plot.draw(&Rectangle::new([(depth, left), (0.0, left + width)], BLACK.filled()))?;
    }
    Ok(())
}

/// A mark where an area's range ends on the inclination's axis, with its angle.
fn draw_range(plot: &DrawingArea<SVGBackend<'_>, Axes>, area: &Area, colour: RGBColor) -> Result<(), DrawingError> {
    let range = area.range(area.inclination());
    if range.distance > 0.0 {
        let (sine, cosine) = area.inclination().sin_cos();
        let place = (100.0 * range.distance * cosine, 100.0 * range.distance * sine);
        let style = text_style().pos(Pos::new(HPos::Right, VPos::Center));
        let mark = EmptyElement::at(place)
            + Circle::new((0, 0), 7, colour.filled())
            + Text::new(degrees(area), (-14, 0), style);
        plot.draw(&mark)?;
    }
    Ok(())
}

fn degrees(area: &Area) -> String {
    format!("{:.0}°", area.inclination().to_degrees())
}

/// One entry for every area: its colour, its range and what bounds it, its content.
fn draw_legend(page: &Page<'_>, areas: &[Area]) -> Result<(), DrawingError> {
    let left = 30;
    page.draw_text("Inclination, range facing the centre", &text_style(), (left, 0))?;
    for ((area, colour), i) in areas.iter().zip(COLOURS.iter().cycle()).zip(0..) {
        let top = LINE + LINE / 2 + i * (5 * LINE / 2);
        let swatch = [(left, top), (left + 40, top + LINE - 8)];
        page.draw(&Rectangle::new(swatch, colour.mix(0.12).filled()))?;
        page.draw(&Rectangle::new(swatch, colour.stroke_width(3)))?;
        let range = area.range(area.inclination());
        let reach = if range.distance > 0.0 { format!("{:.1} cm", 100.0 * range.distance) } else { "none".to_owned() };
        let first = format!("{}: {reach}, by {}", degrees(area), name(range.limit));
        page.draw_text(&first, &text_style(), (left + 60, top))?;
        page.draw_text(&format!("area {:.0} cm²", 1e4 * area.area()), &text_style(), (left + 60, top + LINE))?;
    }
    Ok(())
}

/// A bound by its name and the paper's equation.
fn name(limit: Limit) -> &'static str {
    match limit {
        Limit::FieldOfView => "field of view (3), (4)",
        Limit::StripeWidth => "stripe width (5)",
        Limit::ScanLineInclination => "scan lines (6)",
    }
}
