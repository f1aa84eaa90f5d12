//! The accuracy of both pipelines beside the bound, by distance, for three inclinations.

use crate::accuracy::{Estimator, Measured, Pipeline, Point};
use crate::figures::panel::{Axis, Curve, Dash, DrawError, Entry, Mark, Panel, Pen, Scale, legend};
use plotters::prelude::{IntoDrawingArea, SVGBackend, WHITE};

/// Inclinations that are drawn, degrees.
const DRAWN: [u32; 3] = [0, 30, 60];

/// Page and its strip for the legend, pixels.
const SIZE: (u32, u32) = (1080, 760);
const STRIP: u32 = 70;

const fn pen(grey: u8, width: u32, dash: Dash) -> Pen {
    Pen { grey, width, dash }
}

const BOUND: Pen = pen(0, 1, Dash::Solid);
const FIT: Pen = pen(0, 1, Dash::None);
const PAPER: Pen = pen(120, 2, Dash::Dashed);

/// A point and what was measured there.
pub type Row = (Point, Pipeline, Estimator, Measured);

/// What is shown of a measurement, in the units of its axis.
type Quantity = fn(&Measured) -> f64;

/// Draws the points of one set of conditions whose rows see nothing but stripes.
pub fn draw(rows: &[Row]) -> Result<String, DrawError> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(|error| error.to_string())?;
        let (upper, lower) = root.split_vertically(SIZE.1 - STRIP);
        let cells = upper.split_evenly((2, DRAWN.len()));
        for (column, degrees) in DRAWN.into_iter().enumerate() {
            position(rows, degrees).draw(&cells[column])?;
            heading(rows, degrees).draw(&cells[DRAWN.len() + column])?;
        }
        let entries: [Entry<'_>; 4] = [
            (BOUND, Mark::None, "Cramer-Rao bound"),
            (FIT, Mark::Ring, "fit, reference"),
            (FIT, Mark::Cross, "fit, fixed point"),
            (PAPER, Mark::Triangle, "whole pixels (paper)"),
        ];
        legend(&lower, 4, &entries)?;
        root.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

fn position(rows: &[Row], degrees: u32) -> Panel {
    Panel {
        title: format!("position, major axis, {degrees}°"),
        x: Axis { label: "distance, cm", ends: (5.0, 55.0), scale: Scale::Linear },
        y: Axis { label: "standard deviation, mm", ends: (0.01, 1000.0), scale: Scale::Log },
        x_labels: 6,
        curves: curves(rows, degrees, |m| 1e3 * m.major.deviation(), |m| 1e3 * m.major_bound.root_mean_square()),
    }
}

fn heading(rows: &[Row], degrees: u32) -> Panel {
    Panel {
        title: format!("heading, {degrees}°"),
        x: Axis { label: "distance, cm", ends: (5.0, 55.0), scale: Scale::Linear },
        y: Axis { label: "standard deviation, degrees", ends: (0.01, 100.0), scale: Scale::Log },
        x_labels: 6,
        curves: curves(
            rows,
            degrees,
            |m| m.theta.deviation().to_degrees(),
            |m| m.theta_bound.root_mean_square().to_degrees(),
        ),
    }
}

fn curves(rows: &[Row], degrees: u32, deviation: Quantity, bound: Quantity) -> Vec<Curve> {
    let of = |pipeline: Pipeline, estimator: Estimator, quantity: Quantity| -> Vec<(f64, f64)> {
        rows.iter()
            .filter(|(point, p, e, _)| {
                point.is_bounded() && point.degrees == degrees && *p == pipeline && *e == estimator
            })
            .map(|(point, _, _, measured)| (f64::from(point.centimetres), quantity(measured)))
            .filter(|(_, value)| value.is_finite())
            .collect()
    };
    let fit = |pipeline| of(pipeline, Estimator::Fit, deviation);
    vec![
        Curve { points: of(Pipeline::Reference, Estimator::Fit, bound), pen: BOUND, mark: Mark::None },
        Curve { points: of(Pipeline::Reference, Estimator::Paper, deviation), pen: PAPER, mark: Mark::Triangle },
        Curve { points: fit(Pipeline::Reference), pen: FIT, mark: Mark::Ring },
        Curve { points: fit(Pipeline::Fixedpoint), pen: FIT, mark: Mark::Cross },
    ]
}
