//! Coverage of a region (SITE-14).

use super::{CoverageError, View, check};
use crate::site::{Region, Site};
use core::f64::consts::TAU;
use rayon::prelude::*;
use reference::camera::Camera;
use reference::frame::Pose;

/// A position of a region.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// World coordinates of its middle, metres.
    pub middle: [f64; 2],
    /// Number of headings at which a landmark is readable.
    pub readable: usize,
}

/// What is read in a region.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionCoverage {
    /// Side of a cell, metres.
    pub cell: f64,
    /// Headings at every position, equal parts of a turn from world x on.
    pub headings: usize,
    /// Positions whose middle is in the region, row by row.
    pub cells: Vec<Cell>,
    /// For every landmark the number of poses from which it is readable.
    pub by_landmark: Vec<usize>,
}

impl RegionCoverage {
    /// Number of poses from which something is read.
    #[must_use]
    pub fn readable(&self) -> usize {
        self.cells.iter().map(|cell| cell.readable).sum()
    }

    /// Number of poses that were looked at.
    #[must_use]
    pub fn poses(&self) -> usize {
        self.cells.len() * self.headings
    }

    /// Share of the poses from which something is read, 0 to 1; 0 in a region that has no cell's middle in it.
    #[must_use]
    pub fn share(&self) -> f64 {
        if self.cells.is_empty() { 0.0 } else { self.readable() as f64 / self.poses() as f64 }
    }
}

/// What the site's robot reads in a region: square cells of `cell` metres from the corner of the region's bounding box,
/// and equally many headings in each (SITE-14).
pub fn cover_region(
    site: &Site,
    region: &Region,
    camera: &Camera,
    cell: f64,
    headings: usize,
) -> Result<RegionCoverage, CoverageError> {
    if headings == 0 {
        return Err(CoverageError::Step);
    }
    let middles = middles(region, cell, headings)?;
    let view = View::of(site, camera);
    let rows: Vec<(Cell, Vec<usize>)> = middles
        .into_par_iter()
        .map(|middle| {
            let mut by_landmark = vec![0; site.landmarks.len()];
            let mut readable = 0;
            for heading in (0..headings).map(|k| TAU * k as f64 / headings as f64) {
                let found = view.readable(&Pose::new(middle[0], middle[1], heading), &site.landmarks);
                readable += usize::from(!found.is_empty());
                for i in found {
                    by_landmark[i] += 1;
                }
            }
            (Cell { middle, readable }, by_landmark)
        })
        .collect();
    let mut by_landmark = vec![0; site.landmarks.len()];
    let mut cells = Vec::with_capacity(rows.len());
    for (cell, counts) in rows {
        by_landmark.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        cells.push(cell);
    }
    Ok(RegionCoverage { cell, headings, cells, by_landmark })
}

/// The middles of the cells that the region has in it.
//= reference/SPEC.md#site
//# - **SITE-14** A region MUST be looked at from the middles of square cells, by default of 20 mm, each with equally
//# many headings, by default 72.
fn middles(region: &Region, cell: f64, headings: usize) -> Result<Vec<[f64; 2]>, CoverageError> {
    let points = || region.rings.iter().flatten();
    let bound = |axis: usize| {
        points().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| {
            [low.min(point[axis]), high.max(point[axis])]
        })
    };
    let [[x_low, x_high], [y_low, y_high]] = [bound(0), bound(1)];
    let [columns, rows] = [(x_high - x_low) / cell, (y_high - y_low) / cell].map(f64::ceil);
    check(cell, columns * rows * headings as f64)?;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most MOST_POSES")]
    let (columns, rows) = (columns as usize, rows as usize);
    let middle = |i: usize| [x_low + ((i % columns) as f64 + 0.5) * cell, y_low + ((i / columns) as f64 + 0.5) * cell];
    Ok((0..columns * rows).map(middle).filter(|&middle| region.contains(middle)).collect())
}
