//! A rectangle of the page with a scale along either side, and lines that stay inside.

use super::{Page, text_style};
use crate::drawing::DrawingError;
use crate::drawing::area::{grid_step, whole};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Points of a line that are nearer to the last drawn one are left out, pixels.
const NEAR: i32 = 2;

/// A place on the page, pixels.
pub(super) type Pixel = (i32, i32);

/// A scale along a side of a frame.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    from: f64,
    to: f64,
    /// From one line of the grid to the next; of a logarithmic scale none, the lines are decades.
    step: Option<f64>,
}

impl Scale {
    /// Even steps.
    pub(super) fn linear(from: f64, to: f64, step: f64) -> Self {
        Self { from, to, step: Some(step) }
    }

    /// From 0 to a multiple of a round step that is at least `most`.
    pub(super) fn from_zero(most: f64, steps: f64) -> Self {
        let step = grid_step(most / steps);
        Self::linear(0.0, (most / step).ceil() * step, step)
    }

    /// Decades; what is below the first end is drawn there.
    pub(super) fn log(from: f64, to: f64) -> Self {
        Self { from, to, step: None }
    }

    /// How far along the scale a value is: 0 at its beginning, 1 at its end.
    fn share(&self, value: f64) -> f64 {
        match self.step {
            Some(_) => (value - self.from) / (self.to - self.from),
            None if value.is_nan() => f64::NAN,
            None => (value.max(self.from) / self.from).log10() / (self.to / self.from).log10(),
        }
    }

    /// Values with a line of the grid, and what is written beside it.
    fn lines(&self) -> Vec<(f64, Option<String>)> {
        let Some(step) = self.step else { return self.decades() };
        let digits = usize::try_from(-whole(step.log10().floor())).unwrap_or(0);
        // A hair of a step to spare for ends that are multiples but for rounding.
        let first = whole((self.from / step - 1e-6).ceil());
        let last = whole((self.to / step + 1e-6).floor());
        // Adding 0 makes a zero of a negative one.
        (first..=last)
            .map(|k| f64::from(k) * step + 0.0)
            .map(|value| (value, Some(format!("{value:.digits$}"))))
            .collect()
    }

    fn decades(&self) -> Vec<(f64, Option<String>)> {
        let (first, last) = (whole(self.from.log10().floor()), whole(self.to.log10().ceil()));
        let lines = (first..=last).flat_map(|decade| {
            let digits = usize::try_from(-decade).unwrap_or(0);
            let value = 10_f64.powi(decade);
            let between = (2..10).map(move |factor| (f64::from(factor) * value, None));
            core::iter::once((value, Some(format!("{value:.digits$}")))).chain(between)
        });
        lines.filter(|(value, _)| *value >= self.from * 0.999 && *value <= self.to * 1.001).collect()
    }
}

/// A rectangle of the page with scales.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Its upper left corner.
    pub(super) corner: Pixel,
    /// Its width and height, pixels.
    pub(super) size: Pixel,
    /// To the right.
    pub(super) x: Scale,
    /// Upwards.
    pub(super) y: Scale,
}

impl Frame {
    /// Where a point is on the page, before it is rounded; it may be outside the frame.
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            f64::from(self.corner.0) + self.x.share(x) * f64::from(self.size.0),
            f64::from(self.corner.1) + (1.0 - self.y.share(y)) * f64::from(self.size.1),
        ]
    }

    /// The frame's left, top, right and bottom, pixels.
    pub(super) fn sides(&self) -> [i32; 4] {
        let (left, top) = self.corner;
        [left, top, left + self.size.0, top + self.size.1]
    }

    /// The pixel of a point, if it is inside the frame.
    pub(super) fn pixel(&self, point: [f64; 2]) -> Option<Pixel> {
        let [x, y] = self.at(point);
        let [left, top, right, bottom] = self.sides().map(f64::from);
        let inside = left <= x && x <= right && top <= y && y <= bottom;
        inside.then(|| (whole(x), whole(y)))
    }

    /// The pixel of a point, or the nearest one inside the frame.
    pub(super) fn nearest_pixel(&self, point: [f64; 2]) -> Pixel {
        let [x, y] = self.at(point);
        let [left, top, right, bottom] = self.sides();
        (whole(x).clamp(left, right), whole(y).clamp(top, bottom))
    }

    /// A line from the left to the right at a value of the upright scale.
    pub(super) fn across(&self, value: f64) -> [[f64; 2]; 2] {
        [[self.x.from, value], [self.x.to, value]]
    }

    /// The part of the line between two points that is inside the frame, pixels (Liang and Barsky).
    fn clipped(&self, from: [f64; 2], to: [f64; 2]) -> Option<[Pixel; 2]> {
        let (a, b) = (self.at(from), self.at(to));
        let [left, top, right, bottom] = self.sides().map(f64::from);
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for (start, step, low, high) in [(a[0], b[0] - a[0], left, right), (a[1], b[1] - a[1], top, bottom)] {
            if !step.is_finite() || (step == 0.0 && !(low..=high).contains(&start)) {
                return None;
            }
            if step != 0.0 {
                let (first, second) = ((low - start) / step, (high - start) / step);
                enters = enters.max(first.min(second));
                leaves = leaves.min(first.max(second));
            }
        }
        let part = |share: f64| (whole(a[0] + share * (b[0] - a[0])), whole(a[1] + share * (b[1] - a[1])));
        (enters <= leaves).then(|| [part(enters), part(leaves)])
    }

    /// The pieces of a line that are inside the frame, thinned out.
    fn pieces(&self, points: &[[f64; 2]]) -> Vec<Vec<Pixel>> {
        let mut pieces: Vec<Vec<Pixel>> = vec![];
        for pair in points.windows(2) {
            let Some([from, to]) = self.clipped(pair[0], pair[1]) else { continue };
            match pieces.last_mut() {
                Some(piece) if piece.last() == Some(&from) => piece.push(to),
                _ => pieces.push(vec![from, to]),
            }
        }
        pieces.iter().map(|piece| thinned(piece)).collect()
    }

    /// Draws a line through points.
    pub(super) fn draw_line(
        &self,
        page: &Page<'_>,
        points: &[[f64; 2]],
        style: ShapeStyle,
    ) -> Result<(), DrawingError> {
        for piece in self.pieces(points) {
            page.draw(&PathElement::new(piece, style))?;
        }
        Ok(())
    }

    /// Fills what is between a line and the frame's lower side.
    pub(super) fn fill_below(
        &self,
        page: &Page<'_>,
        points: &[[f64; 2]],
        style: ShapeStyle,
    ) -> Result<(), DrawingError> {
        let finite = points.iter().filter(|point| point.iter().all(|value| value.is_finite()));
        let mut outline = thinned(&finite.map(|&point| self.nearest_pixel(point)).collect::<Vec<_>>());
        let bottom = self.sides()[3];
        if let (Some(&(first, _)), Some(&(last, _))) = (outline.first(), outline.last()) {
            outline.extend([(last, bottom), (first, bottom)]);
            page.draw(&Polygon::new(outline, style))?;
        }
        Ok(())
    }

    /// Draws the lines of the grid and, if the scale along the lower side has a name, its numbers.
    pub(super) fn draw_grid(&self, page: &Page<'_>, x_name: Option<&str>, y_name: &str) -> Result<(), DrawingError> {
        let [left, top, right, bottom] = self.sides();
        for (value, label) in self.x.lines() {
            let (x, _) = self.nearest_pixel([value, self.y.from]);
            page.draw(&PathElement::new(vec![(x, top), (x, bottom)], BLACK.mix(0.15).stroke_width(2)))?;
            if let Some(label) = label.filter(|_| x_name.is_some()) {
                page.draw_text(&label, &text_style().pos(Pos::new(HPos::Center, VPos::Top)), (x, bottom + 14))?;
            }
        }
        for (value, label) in self.y.lines() {
            let (_, y) = self.nearest_pixel([self.x.from, value]);
            let line = if label.is_some() { BLACK.mix(0.15) } else { BLACK.mix(0.06) };
            page.draw(&PathElement::new(vec![(left, y), (right, y)], line.stroke_width(2)))?;
            if let Some(label) = label {
                page.draw_text(&label, &text_style().pos(Pos::new(HPos::Right, VPos::Center)), (left - 14, y))?;
            }
        }
        page.draw(&Rectangle::new([(left, top), (right, bottom)], BLACK.mix(0.6).stroke_width(2)))?;
        if let Some(name) = x_name {
            let place = (i32::midpoint(left, right), bottom + 56);
            page.draw_text(name, &text_style().pos(Pos::new(HPos::Center, VPos::Top)), place)?;
        }
        let upright = text_style().transform(FontTransform::Rotate270).pos(Pos::new(HPos::Center, VPos::Top));
        page.draw_text(y_name, &upright, (left - 126, i32::midpoint(top, bottom)))?;
        Ok(())
    }
}

/// A line without the points that are too near to the last one to be told apart; its ends stay.
fn thinned(line: &[Pixel]) -> Vec<Pixel> {
    let mut kept: Vec<Pixel> = vec![];
    for &point in line {
        if !kept.last().is_some_and(|&last| near(last, point, NEAR)) {
            kept.push(point);
        }
    }
    if let (Some(last), false) = (line.last(), line.last() == kept.last()) {
        kept.push(*last);
    }
    kept
}

/// Whether two places are less than so many pixels from each other both across and down the page.
pub(super) fn near(a: Pixel, b: Pixel, pixels: i32) -> bool {
    (a.0 - b.0).abs().max((a.1 - b.1).abs()) < pixels
}

/// Places of which no two are near to each other: what covers an earlier one is left out.
pub(super) fn apart(places: impl Iterator<Item = Pixel>, pixels: i32) -> Vec<Pixel> {
    let mut kept: Vec<Pixel> = vec![];
    for place in places {
        if !kept.iter().any(|&other| near(other, place, pixels)) {
            kept.push(place);
        }
    }
    kept
}
