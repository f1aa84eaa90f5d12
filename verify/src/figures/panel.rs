//! One diagram of a figure, and its legend, in black and grey.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::FontStyle;

/// Where a figure is drawn.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Why a figure cannot be drawn, in the library's words.
pub type DrawError = String;

/// A line's look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pen {
    /// From 0, black, to 255, white.
    pub grey: u8,
    /// Pixels.
    pub width: u32,
    /// How it is broken.
    pub dash: Dash,
}

/// How a line is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// Not at all.
    Solid,
    /// Long pieces.
    Dashed,
    /// Short pieces.
    Dotted,
    /// No line.
    None,
}

/// A point's look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// No mark.
    None,
    /// A filled circle.
    Dot,
    /// A circle.
    Ring,
    /// A filled triangle.
    Triangle,
    /// A cross.
    Cross,
    /// A filled square.
    Square,
}

/// Points and how they are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// In the axes' units.
    pub points: Vec<(f64, f64)>,
    /// The line through them.
    pub pen: Pen,
    /// The mark on each.
    pub mark: Mark,
}

/// A scale's kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Even steps.
    Linear,
    /// Decades; what is not positive is left out.
    Log,
}

/// A scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: &'static str,
    /// Its ends, in its unit.
    pub ends: (f64, f64),
    /// Its kind; a horizontal scale is linear.
    pub scale: Scale,
}

impl Axis {
    /// Where a value is drawn: itself, or its decimal logarithm.
    fn place(&self, value: f64) -> Option<f64> {
        match self.scale {
            Scale::Linear => Some(value),
            Scale::Log => (value > 0.0).then(|| value.log10()),
        }
    }

    fn range(&self) -> core::ops::Range<f64> {
        let place = |end| self.place(end).unwrap_or(0.0);
        place(self.ends.0)..place(self.ends.1)
    }

    fn name(&self, place: f64) -> String {
        match self.scale {
            Scale::Linear if self.ends.1 - self.ends.0 < 5.0 => format!("{place:.1}"),
            Scale::Linear => format!("{place:.0}"),
            // Whole decades only.
            Scale::Log if (place - place.round()).abs() > 1e-6 => String::new(),
            Scale::Log => {
                let value = 10_f64.powf(place);
                if value < 1.0 { format!("{value:.2}").trim_end_matches('0').to_owned() } else { format!("{value:.0}") }
            }
        }
    }
}

/// One diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Its heading.
    pub title: String,
    /// Horizontal scale, linear.
    pub x: Axis,
    /// Vertical scale.
    pub y: Axis,
    /// Labels of the horizontal scale, about.
    pub x_labels: usize,
    /// What is shown; points outside the scales are left out.
    pub curves: Vec<Curve>,
}

/// Text size, pixels.
const TEXT: i32 = 15;

fn style(pen: &Pen) -> ShapeStyle {
    RGBColor(pen.grey, pen.grey, pen.grey).stroke_width(pen.width)
}

fn text_style<'a>() -> TextStyle<'a> {
    ("sans-serif", TEXT).into_font().color(&BLACK)
}

fn said(error: &impl core::fmt::Display) -> DrawError {
    error.to_string()
}

impl Panel {
    /// Draws it over the whole area.
    pub fn draw(&self, area: &Area<'_>) -> Result<(), DrawError> {
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", TEXT + 1, FontStyle::Bold))
            .margin(8)
            .x_label_area_size(42)
            .y_label_area_size(56)
            .build_cartesian_2d(self.x.range(), self.y.range())
            .map_err(|error| said(&error))?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(225, 225, 225))
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .x_labels(self.x_labels)
            .y_labels(7)
            .x_label_formatter(&|place| self.x.name(*place))
            .y_label_formatter(&|place| self.y.name(*place))
            .label_style(("sans-serif", TEXT - 1))
            .axis_desc_style(("sans-serif", TEXT))
            .draw()
            .map_err(|error| said(&error))?;
        for curve in &self.curves {
            let points = self.visible(curve);
            let pen = style(&curve.pen);
            let drawn = match curve.pen.dash {
                Dash::Solid => chart.draw_series(LineSeries::new(points.iter().copied(), pen)).map(|_| ()),
                Dash::Dashed => chart.draw_series(DashedLineSeries::new(points.iter().copied(), 9, 5, pen)).map(|_| ()),
                Dash::Dotted => chart.draw_series(DashedLineSeries::new(points.iter().copied(), 2, 4, pen)).map(|_| ()),
                Dash::None => Ok(()),
            };
            drawn.map_err(|error| said(&error))?;
            let plane = chart.plotting_area().strip_coord_spec();
            let (across, down) = plane.get_pixel_range();
            for point in &points {
                let (x, y) = chart.backend_coord(point);
                mark(&plane, curve.mark, &curve.pen, (x - across.start, y - down.start))?;
            }
        }
        Ok(())
    }

    fn visible(&self, curve: &Curve) -> Vec<(f64, f64)> {
        let (xs, ys) = (self.x.range(), self.y.range());
        let inside = |range: &core::ops::Range<f64>, value: f64| range.start <= value && value <= range.end;
        let place = |&(x, y): &(f64, f64)| Some((x, self.y.place(y)?));
        curve.points.iter().filter_map(place).filter(|&(x, y)| inside(&xs, x) && inside(&ys, y)).collect()
    }
}

/// Draws a mark at a pixel of an area.
fn mark(area: &Area<'_>, mark: Mark, pen: &Pen, place: (i32, i32)) -> Result<(), DrawError> {
    let colour = RGBColor(pen.grey, pen.grey, pen.grey);
    match mark {
        Mark::None => Ok(()),
        Mark::Dot => area.draw(&Circle::new(place, 4, colour.filled())),
        Mark::Ring => area.draw(&Circle::new(place, 4, colour.stroke_width(1))),
        Mark::Triangle => area.draw(&TriangleMarker::new(place, 5, colour.filled())),
        Mark::Cross => area.draw(&Cross::new(place, 4, colour.stroke_width(2))),
        Mark::Square => {
            let corner = |step: i32| (place.0 + step, place.1 + step);
            area.draw(&Rectangle::new([corner(-4), corner(4)], colour.filled()))
        }
    }
    .map_err(|error| said(&error))
}

/// A line of a legend.
pub type Entry<'a> = (Pen, Mark, &'a str);

/// Draws a legend of so many columns, line by line.
pub fn legend(area: &Area<'_>, columns: usize, entries: &[Entry<'_>]) -> Result<(), DrawError> {
    let (width, _) = area.dim_in_pixel();
    let columns = i32::try_from(columns.max(1)).unwrap_or(1);
    let width = i32::try_from(width).unwrap_or(i32::MAX) / columns;
    for (number, (pen, sign, text)) in (0..).zip(entries) {
        let (x, y) = (20 + number % columns * width, 24 + number / columns * (TEXT + 9));
        let ends = [(x, y), (x + 44, y)];
        let pieces = match pen.dash {
            Dash::Solid => vec![(0, 44)],
            Dash::Dashed => vec![(0, 9), (14, 23), (28, 37)],
            Dash::Dotted => (0..8).map(|piece| (6 * piece, 6 * piece + 2)).collect(),
            Dash::None => vec![],
        };
        for (from, to) in pieces {
            let piece = PathElement::new(vec![(x + from, y), (x + to, y)], style(pen));
            area.draw(&piece).map_err(|error| said(&error))?;
        }
        let middle = (i32::midpoint(ends[0].0, ends[1].0), y);
        mark(area, *sign, pen, middle)?;
        let label = Text::new((*text).to_owned(), (x + 54, y - TEXT / 2), text_style());
        area.draw(&label).map_err(|error| said(&error))?;
    }
    Ok(())
}
