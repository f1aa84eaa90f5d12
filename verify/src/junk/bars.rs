//! Upright bars, seen under perspective and slant.

use super::Ink;
use super::edges::{Blur, Edges};
use super::symbols::Symbol;
use rand::{Rng, RngExt};
use reference::camera::Camera;

/// Whether both rows see the same.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Rows {
    /// Each row has its own.
    Own,
    /// Both have the same.
    Same,
    /// The same, but for a slant and up to 0.3 px of every edge.
    Slanted,
}

/// Alternating runs from end to end of the line, of 1 to `2 m + 1` px with a random `m`, or, in half of the pairs, of
/// whole modules of `m` px.
pub(super) fn runs<R: Rng>(rows: Rows, camera: &Camera, blur: Blur, rng: &mut R) -> Ink {
    let mean = rng.random_range(1.0..8.0);
    let whole = rng.random();
    let upper = run_columns(mean, whole, camera.width as f32, rng);
    let lower = match rows {
        Rows::Own => run_columns(mean, whole, camera.width as f32, rng),
        Rows::Same => upper.clone(),
        Rows::Slanted => {
            let (shift, scale) = (rng.random_range(-4.0..4.0_f32), rng.random_range(0.98..1.02_f32));
            upper.iter().map(|column| column * scale + shift + rng.random_range(-0.3..0.3)).collect()
        }
    };
    let mut edges = Edges::new(camera.width, blur);
    for (row, columns) in [upper, lower].iter().enumerate() {
        columns.iter().zip([1.0, -1.0].iter().cycle()).for_each(|(&column, &change)| edges.step(row, column, change));
    }
    edges.into_ink()
}

/// Columns of the edges of runs.
fn run_columns<R: Rng>(mean: f32, whole: bool, width: f32, rng: &mut R) -> Vec<f32> {
    let mut column = -rng.random_range(0.0..3.0 * mean);
    let mut columns = Vec::with_capacity(256);
    while column < width {
        columns.push(column);
        column += if !whole {
            rng.random_range(1.0..2.0 * mean + 1.0)
        } else if rng.random() {
            mean
        } else {
            mean * f32::from(rng.random_range(1..=4_u8))
        };
    }
    columns
}

/// Where a plane thing of half width 1 is seen: `t` from -1 to 1 at the column `c + s t / (1 + k t)` (HOMOG).
#[derive(Clone, Copy)]
struct View {
    centre: f32,
    half_width: f32,
    obliquity: f32,
}

impl View {
    fn column(&self, t: f32) -> f32 {
        self.centre + self.half_width * t / (1.0 + self.obliquity * t)
    }

    /// A thing of `modules`, each `range` px wide, evenly distributed in the logarithm. What does not fit into the line is
    /// drawn smaller in three of four views.
    fn draw<R: Rng>(modules: f32, range: core::ops::Range<f32>, camera: &Camera, rng: &mut R) -> Self {
        let width = camera.width as f32;
        let fitting = (0.9 * width / modules).max(range.start * 1.01);
        let largest = if rng.random_range(0..4) == 0 { range.end } else { range.end.min(fitting) };
        let module = range.start * (largest / range.start).powf(rng.random());
        let half_width = 0.5 * modules * module;
        let slack = (0.5 * width - half_width).abs().max(0.1 * width);
        let centre = 0.5 * width + rng.random_range(-slack..slack);
        let obliquity = if rng.random() { 0.0 } else { rng.random_range(-0.25..0.25) };
        Self { centre, half_width, obliquity }
    }

    /// The view of the other row: the same or, in half of the views, up to 3 px beside it and up to 1 % larger or smaller.
    fn slanted<R: Rng>(self, rng: &mut R) -> Self {
        if rng.random() {
            return self;
        }
        let centre = self.centre + rng.random_range(-3.0..3.0);
        Self { centre, half_width: self.half_width * rng.random_range(0.99..1.01), ..self }
    }
}

/// What is beside the quiet zones.
#[derive(Clone, Copy)]
enum Surround {
    White,
    Dark(f32),
    /// Bars every so many modules, half of it ink.
    Bars(f32),
}

impl Surround {
    fn draw<R: Rng>(rng: &mut R) -> Self {
        match rng.random_range(0..4) {
            0 | 1 => Self::White,
            2 => Self::Dark(rng.random_range(0.3..1.0)),
            _ => Self::Bars(rng.random_range(2.0..12.0)),
        }
    }
}

/// Module width of foreign bar codes, pixels.
const MODULE: core::ops::Range<f32> = 1.0..8.0;

/// A bar code through which both rows go.
pub(super) fn symbol<R: Rng>(symbol: &Symbol, camera: &Camera, blur: Blur, rng: &mut R) -> Ink {
    let upper = View::draw(modules(symbol), MODULE, camera, rng);
    let lower = upper.slanted(rng);
    let surround = Surround::draw(rng);
    let mut edges = Edges::new(camera.width, blur);
    for (row, view) in [upper, lower].iter().enumerate() {
        paint(&mut edges, row, view, symbol, surround);
    }
    edges.into_ink()
}

/// Two bar codes of the same module width, one above the other, flush left or centred.
pub(super) fn stacked<R: Rng>(symbols: &[Symbol; 2], camera: &Camera, blur: Blur, rng: &mut R) -> Ink {
    let widths = [modules(&symbols[0]), modules(&symbols[1])];
    let upper = View::draw(widths[0], MODULE, camera, rng);
    let mut lower = upper.slanted(rng);
    lower.half_width *= widths[1] / widths[0];
    if rng.random() {
        lower.centre += lower.half_width - upper.half_width;
    }
    let surround = Surround::draw(rng);
    let mut edges = Edges::new(camera.width, blur);
    for (row, view) in [upper, lower].iter().enumerate() {
        paint(&mut edges, row, view, &symbols[row], surround);
    }
    edges.into_ink()
}

fn modules(symbol: &Symbol) -> f32 {
    symbol.widths.iter().map(|&width| f32::from(width)).sum()
}

fn paint(edges: &mut Edges, row: usize, view: &View, symbol: &Symbol, surround: Surround) {
    let total = modules(symbol);
    // Modules from the symbol's left end; beyond t = 2 the perspective is left alone.
    let column = |module: f32| view.column((2.0 * module / total - 1.0).clamp(-2.0, 2.0));
    let mut at = 0.0;
    for (element, &width) in symbol.widths.iter().enumerate() {
        let next = at + f32::from(width);
        if element % 2 == 0 {
            edges.bar(row, column(at), column(next), 1.0);
        }
        at = next;
    }
    let [left, right] = [-f32::from(symbol.quiet[0]), total + f32::from(symbol.quiet[1])];
    match surround {
        Surround::White => {}
        Surround::Dark(ink) => {
            edges.step(row, -1e3, ink);
            edges.step(row, column(left), -ink);
            edges.step(row, column(right), ink);
        }
        Surround::Bars(period) => {
            for bar in (0..20_u8).map(f32::from) {
                let (near, far) = (bar * period, (bar + 0.5) * period);
                edges.bar(row, column(left - far), column(left - near), 1.0);
                edges.bar(row, column(right + near), column(right + far), 1.0);
            }
        }
    }
}

/// Stripe width of dual-layer marks, pixels.
const STRIPE: core::ops::Range<f32> = 1.25..14.0;

/// Two layers of equally wide stripes on white.
pub(super) fn layers<R: Rng>(layers: &[Vec<bool>; 2], camera: &Camera, blur: Blur, rng: &mut R) -> Ink {
    let total = layers[0].len() as f32;
    let upper = View::draw(total, STRIPE, camera, rng);
    let lower = upper.slanted(rng);
    let mut edges = Edges::new(camera.width, blur);
    for (row, view) in [upper, lower].iter().enumerate() {
        for (stripe, _) in layers[row].iter().enumerate().filter(|(_, black)| **black) {
            let column = |stripe: usize| view.column(2.0 * stripe as f32 / total - 1.0);
            edges.bar(row, column(stripe), column(stripe + 1), 1.0);
        }
    }
    edges.into_ink()
}
