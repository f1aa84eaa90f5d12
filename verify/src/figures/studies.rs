//! The views behind the figures, and what was found in them cell by cell.
//!
//! Cells run in parallel and are collected in their order, so that nothing depends on the number of threads.

use super::sightings::{PerRule, Sides, Sightings, Spectator};
use super::spread::Spread;
use crate::scenes::{self, PAPER_DISTANCES, PAPER_INCLINATIONS, PAPER_VIEWS, Staged};
use crate::tally::Tally;
use rayon::prelude::*;
use reference::frame::Pose;
use reference::landmark::Format;
use std::ops::RangeInclusive;

/// What is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Views of each cell of Fig. 10 and of the ranges; Fig. 9 has the paper's 30.
    pub views: u32,
    /// Seed of everything random.
    pub seed: u64,
}

/// Centimetres of the ranges: from where every inclination is found to where none is.
pub const RANGE_CENTIMETRES: RangeInclusive<u32> = 15..=75;

/// Added to the seed so that no view is another's: `scenes` has the seed itself and the next three.
const SPREAD_SEED: u64 = 11;
const RANGE_SEED: u64 = 12;

/// A cell of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Sector {
    /// Inclination in degrees, or the number of the barcode in the frontal case of [`scenes::paper_view`].
    pub row: u32,
    /// Distance of the camera, centimetres.
    pub centimetres: u32,
    /// What was found.
    pub seen: PerRule<Sightings>,
}

/// The cells of a study and the comparison of both pipelines over all of its views.
#[derive(Clone, Debug, Default)]
pub struct Study {
    /// The cells, row by row.
    pub sectors: Vec<Sector>,
    /// The comparison.
    pub tally: Tally,
}

impl Study {
    /// Runs cells given by row and centimetres.
    fn run<I: Iterator<Item = (u64, Staged)>>(
        cells: &[(u32, u32)],
        views: impl Fn(u64, u32, u32) -> I + Sync,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Self {
        let spectator = Spectator::new();
        let watch = |(number, &(row, centimetres)): (usize, &(u32, u32))| {
            // The rows of the frontal case are barcodes.
            let sides = if row >= scenes::FIRST_BARCODE_ROW { Sides::Frontal } else { Sides::of(row) };
            let (seen, tally) = spectator.watch(sides, views(number as u64, row, centimetres));
            progress(seen.whole_pixel.rate.views);
            (Sector { row, centimetres, seen }, tally)
        };
        let watched: Vec<(Sector, Tally)> = cells.par_iter().enumerate().map(watch).collect();
        let mut study = Self::default();
        for (sector, tally) in watched {
            study.tally = study.tally.merged(&tally);
            study.sectors.push(sector);
        }
        study
    }

    /// The paper's data set: 30 views of each distance and inclination, and of four barcodes frontally (Fig. 9).
    #[must_use]
    pub fn rates(plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Self {
        let barcodes = (0..scenes::PAPER_BARCODES).filter_map(|barcode| u32::try_from(barcode).ok());
        let rows = PAPER_INCLINATIONS.into_iter().chain(barcodes.map(|it| scenes::FIRST_BARCODE_ROW + it));
        let seed = plan.seed;
        let views = |number: u64, _, _| {
            let frames = number * PAPER_VIEWS..(number + 1) * PAPER_VIEWS;
            frames.map(move |frame| (frame, scenes::paper_view(seed, frame).1))
        };
        Self::run(&grid(rows, PAPER_DISTANCES), views, progress)
    }

    /// The poses of the paper's cells in as many views as the plan says, of the barcode of [`Study::rates`] (Fig. 10).
    #[must_use]
    pub fn poses(plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Self {
        Self::run(&paper_cells(), |number, row, cm| pose_views(plan, number, row, cm), progress)
    }

    /// Every centimetre of each inclination; every view has a barcode of its own, because (5) and (6) know none.
    #[must_use]
    pub fn ranges(plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Self {
        let seed = plan.seed.wrapping_add(RANGE_SEED);
        let views = |number: u64, row: u32, centimetres: u32| {
            frames(plan, number).map(move |frame| {
                let payload = scenes::payload(Format::Paper, &mut scenes::generator(seed, !frame));
                (frame, scenes::view(seed, frame, payload, centimetres, row))
            })
        };
        Self::run(&grid(PAPER_INCLINATIONS, RANGE_CENTIMETRES), views, progress)
    }

    /// The cells of a row, nearest first.
    pub fn row(&self, row: u32) -> impl Iterator<Item = &Sector> {
        self.sectors.iter().filter(move |sector| sector.row == row)
    }
}

/// A choice of ours that the paper's experiment may have made otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// As everywhere else.
    Nothing,
    /// No sensor noise instead of 2 grey levels: rounding remains.
    NoNoise,
    /// A noise of 6 grey levels.
    MoreNoise,
    /// A blur of 0.25 px instead of 0.5 px.
    Sharper,
    /// A blur of 1 px.
    Softer,
    /// The camera looks straight at the barcode instead of up to 0.1 rad past it.
    Straight,
}

impl Change {
    /// All of them, what is changed in none first.
    pub const ALL: [Self; 6] =
        [Self::Nothing, Self::NoNoise, Self::MoreNoise, Self::Sharper, Self::Softer, Self::Straight];

    /// In a table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "blur 0.5 px, noise 2, heading ±0.1 rad",
            Self::NoNoise => "noise 0",
            Self::MoreNoise => "noise 6",
            Self::Sharper => "blur 0.25 px",
            Self::Softer => "blur 1 px",
            Self::Straight => "heading at the barcode",
        }
    }

    fn apply(self, staged: &mut Staged) {
        let scene = &mut staged.scene;
        match self {
            Self::Nothing => {}
            Self::NoNoise => scene.sensor.noise = 0.0,
            Self::MoreNoise => scene.sensor.noise = 6.0,
            Self::Sharper => scene.sensor.blur = 0.25,
            Self::Softer => scene.sensor.blur = 1.0,
            Self::Straight => {
                let (x, y) = (scene.camera_in_world.x(), scene.camera_in_world.y());
                // Back to the landmark, which stands at the world's origin.
                scene.camera_in_world = Pose::new(x, y, (-y).atan2(-x));
            }
        }
    }
}

/// Row in degrees, centimetres, and statistics of each of the paper's cells with one choice changed: by the reference
/// and the paper's rule.
#[must_use]
pub fn changed(plan: &Plan, change: Change, progress: &(dyn Fn(u64) + Sync)) -> Vec<(u32, u32, Option<Spread>)> {
    let spectator = Spectator::new();
    let watch = |(number, &(row, centimetres)): (usize, &(u32, u32))| {
        let views = pose_views(plan, number as u64, row, centimetres).map(|(_, mut staged)| {
            change.apply(&mut staged);
            staged
        });
        let errors = spectator.watch_by_reference(Sides::of(row), views);
        progress(u64::from(plan.views));
        (row, centimetres, Spread::of(&errors))
    };
    paper_cells().par_iter().enumerate().map(watch).collect()
}

/// Every row at every distance.
fn grid(rows: impl IntoIterator<Item = u32>, distances: impl IntoIterator<Item = u32>) -> Vec<(u32, u32)> {
    let distances: Vec<u32> = distances.into_iter().collect();
    let cells = |row: u32| distances.iter().map(move |&centimetres| (row, centimetres)).collect::<Vec<_>>();
    rows.into_iter().flat_map(cells).collect()
}

fn paper_cells() -> Vec<(u32, u32)> {
    grid(PAPER_INCLINATIONS, PAPER_DISTANCES)
}

/// Numbers of a cell's views.
fn frames(plan: &Plan, cell: u64) -> std::ops::Range<u64> {
    let views = u64::from(plan.views);
    cell * views..(cell + 1) * views
}

/// Views of the paper's random barcode.
fn pose_views(plan: &Plan, cell: u64, degrees: u32, centimetres: u32) -> impl Iterator<Item = (u64, Staged)> {
    let barcode = scenes::paper_view(plan.seed, 0).1.truth();
    let payload = barcode.first().map_or(0, |&(_, payload)| payload);
    let seed = plan.seed.wrapping_add(SPREAD_SEED);
    frames(plan, cell).map(move |frame| (frame, scenes::view(seed, frame, payload, centimetres, degrees)))
}
