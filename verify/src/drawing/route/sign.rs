//! Signs in the drawings and what a legend says about them.

use super::frame::Pixel;
use super::{BLUE, GREEN, LINE, ORANGE, PURPLE, Page, SKY, VERMILLION, text_style};
use crate::drawing::DrawingError;
use crate::drawing::area::whole;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Something that has an entry in a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sign {
    /// A line that has length.
    Line(ShapeStyle),
    /// A surface.
    Band(ShapeStyle),
    /// A line from the bottom to the top.
    Upright(ShapeStyle),
    /// A landmark on a wall.
    Landmark,
    /// An observation was used.
    Used,
    /// An observation was refused.
    Gated,
    /// The filter began anew.
    Recovered,
    /// The robot was taken off the floor.
    Lifted,
    /// The robot was put on the floor.
    PutDown,
    /// Where the run begins; it points to where the robot looks, radians.
    Start(f64),
    /// Where the estimate begins.
    FirstBelief(f64),
}

/// The line between where the robot was lifted and where it was put down.
pub(super) fn draw_carried(page: &Page<'_>, from: Pixel, to: Pixel) -> Result<(), DrawingError> {
    page.draw(&DashedPathElement::new([from, to], 12, 10, BLACK.mix(0.7).stroke_width(2)))?;
    Ok(())
}

/// The path of the truth, upon the estimate's.
pub(super) fn truth_line() -> ShapeStyle {
    BLACK.stroke_width(2)
}

/// What is drawn of the estimate.
pub(super) fn estimate_line() -> ShapeStyle {
    BLUE.stroke_width(4)
}

/// What is drawn of odometry alone.
pub(super) fn odometry_line() -> ShapeStyle {
    VERMILLION.mix(0.8).stroke_width(2)
}

/// What is drawn of the port, beneath the reference: a wide line shows on either side where both are the same.
pub(super) fn port_line() -> ShapeStyle {
    SKY.stroke_width(8)
}

/// When the filter began anew.
pub(super) fn recovery_line() -> ShapeStyle {
    GREEN.stroke_width(4)
}

impl Sign {
    /// Draws it around a place; lines, bands and uprights as in a legend.
    pub(super) fn draw(self, page: &Page<'_>, (x, y): Pixel) -> Result<(), DrawingError> {
        let triangle = |base: i32, tip: i32| vec![(x - 13, y + base), (x + 13, y + base), (x, y + tip)];
        match self {
            Self::Line(style) => page.draw(&PathElement::new(vec![(x - 32, y), (x + 32, y)], style)),
            Self::Band(style) => page.draw(&Rectangle::new([(x - 32, y - 14), (x + 32, y + 14)], style)),
            Self::Upright(style) => page.draw(&PathElement::new(vec![(x, y - 18), (x, y + 18)], style)),
            Self::Landmark => {
                page.draw(&PathElement::new(vec![(x - 20, y + 8), (x + 20, y + 8)], BLACK.stroke_width(10)))?;
                page.draw(&PathElement::new(vec![(x, y + 8), (x, y - 16)], BLACK.stroke_width(3)))
            }
            Self::Used => page.draw(&Circle::new((x, y), 5, ORANGE.filled())),
            Self::Gated => {
                page.draw(&PathElement::new(vec![(x - 8, y - 8), (x + 8, y + 8)], PURPLE.stroke_width(3)))?;
                page.draw(&PathElement::new(vec![(x - 8, y + 8), (x + 8, y - 8)], PURPLE.stroke_width(3)))
            }
            Self::Recovered => page.draw(&Circle::new((x, y), 16, GREEN.stroke_width(5))),
            Self::Lifted => {
                page.draw(&Polygon::new(triangle(10, -14), WHITE.filled()))?;
                let mut outline = triangle(10, -14);
                outline.extend(triangle(10, -14).into_iter().take(2));
                page.draw(&PathElement::new(outline, BLACK.stroke_width(3)))
            }
            Self::PutDown => page.draw(&Polygon::new(triangle(-10, 14), BLACK.filled())),
            Self::Start(heading) => page.draw(&Polygon::new(wedge((x, y), heading), BLACK.filled())),
            Self::FirstBelief(heading) => page.draw(&Polygon::new(wedge((x, y), heading), BLUE.filled())),
        }?;
        Ok(())
    }
}

/// An arrow head around a place that points to `heading`, radians from the right towards the top of the page.
fn wedge((x, y): Pixel, heading: f64) -> Vec<Pixel> {
    let corner = |(ahead, aside): (f64, f64)| {
        let (sine, cosine) = heading.sin_cos();
        let step = (ahead * cosine - aside * sine, ahead * sine + aside * cosine);
        (x + whole(step.0), y - whole(step.1))
    };
    [(26.0, 0.0), (-16.0, 15.0), (-8.0, 0.0), (-16.0, -15.0)].map(corner).to_vec()
}

/// An entry of a legend.
pub(super) type Entry = (Sign, String);

/// Draws a legend from a corner, line by line, in so many columns, each `width` pixels wide.
pub(super) fn draw_legend(
    page: &Page<'_>,
    (left, top): Pixel,
    (columns, width): (i32, i32),
    entries: &[Entry],
) -> Result<(), DrawingError> {
    for ((sign, text), i) in entries.iter().zip(0..) {
        let (x, y) = (left + i % columns * width, top + i / columns * LINE + LINE / 2);
        sign.draw(page, (x + 32, y))?;
        page.draw_text(text, &text_style().pos(Pos::new(HPos::Left, VPos::Center)), (x + 80, y))?;
    }
    Ok(())
}

/// Height of a legend, pixels.
pub(super) fn legend_height(columns: i32, entries: &[Entry]) -> i32 {
    let entries = i32::try_from(entries.len()).unwrap_or(i32::MAX / LINE);
    (entries + columns - 1) / columns * LINE
}
