//! Everything that the figures show, as numbers. The same plan gives the same bytes.

use super::limits::{HalfRange, Prediction, RowReading};
use super::regressions::{Regressions, Sample};
use super::sightings::{PerRule, Sightings};
use super::spread::Spread;
use super::statements::{Statement, statements};
use super::studies::{Change, Plan, Sector, Study, changed};
use crate::bounds::Stage;
use crate::findings::Both;
use crate::scenes::{self, FIRST_BARCODE_ROW, PAPER_INCLINATIONS};
use crate::tally::Tally;
use reference::camera::Camera;
use reference::landmark::{Format, Landmark};
use reference::range::{MIN_STRIPE_PIXELS, scan_line_range, stripe_width_range};
use reference::regression::{EQUAL_WIDTH, Growth, MAJOR, MINOR, ROTATION, Rotation};
use serde::Serialize;

/// All figures.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Seed of everything random.
    pub seed: u64,
    /// Views of each cell of Fig. 10 and of the ranges; Fig. 9 has the paper's 30.
    pub views: u32,
    /// Both pipelines over all views by both rules.
    pub pipelines: Pipelines,
    /// Detection of four barcodes frontally (Fig. 9 a), in the order of barcode and distance.
    pub barcodes: Vec<CellRates>,
    /// Detection of one barcode under five inclinations (Fig. 9 b), in the order of inclination and distance.
    pub inclinations: Vec<CellRates>,
    /// How far the landmark is found.
    pub ranges: PerRule<Ranges>,
    /// Statistics of the poses (Fig. 10), in the order of inclination and distance.
    pub poses: Vec<CellPoses>,
    /// (11) and (12) fitted to them; none if too few cells have enough poses.
    pub regressions: PerRule<Option<Regressions>>,
    /// (11) and (12).
    pub paper: PaperRegressions,
    /// What the regressions by the paper's rule become where one of our choices is another.
    pub changes: Vec<Changed>,
    /// Where we agree with the paper, where not, and why.
    pub statements: Vec<Statement>,
}

/// How far the pipelines agree.
#[derive(Clone, Debug, Serialize)]
pub struct Pipelines {
    /// Frames that both ran over.
    pub frames: u64,
    /// Frames with a decision whose margin is below the reference's declared error (SAME-4).
    pub marginal: u64,
    /// Marginal frames in which they decided differently.
    pub differing: u64,
    /// Stages up to the half words that differ more than they may.
    pub failing: Vec<&'static str>,
}

impl Pipelines {
    /// Nothing differs more than it may.
    #[must_use]
    pub fn agree(&self) -> bool {
        self.failing.is_empty()
    }

    fn of(tally: &Tally) -> Self {
        let used = tally.failing().into_iter().filter(|stage| *stage <= Stage::Decode);
        Self {
            frames: tally.frames,
            marginal: tally.marginal_frames,
            differing: tally.differing_frames,
            // The paper's estimate needs no more than half words and homographies.
            failing: used.map(|stage| stage.row().name).collect(),
        }
    }
}

/// What was found in a cell by one rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Found {
    /// Views.
    pub views: u64,
    /// Views in which the landmark was found.
    pub found: Both,
    /// Detections that are not in the scene.
    pub wrong: Both,
}

impl Found {
    /// The reference's detection rate, 0 to 1.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.found.reference as f64 / self.views.max(1) as f64
    }
}

impl Found {
    fn of(seen: &Sightings) -> Self {
        Self { views: seen.rate.views, found: seen.rate.found, wrong: seen.wrong }
    }
}

/// A cell of Fig. 9.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CellRates {
    /// Inclination in degrees, or the barcode's number from 0 in Fig. 9 a).
    pub row: u32,
    /// Distance, centimetres.
    pub distance_cm: u32,
    /// What was found.
    pub seen: PerRule<Found>,
}

/// How far the landmark is found by one rule.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Ranges {
    /// By inclination.
    pub inclinations: Vec<InclinationRange>,
    /// By reading of (6), with the paper's `L_min` of 1.5 px. Empty unless every inclination has a range.
    pub paper: Vec<Prediction>,
    /// By reading of (6), with the `L_min` that fits best. Empty unless every inclination has a range.
    pub best: Vec<Prediction>,
}

/// How far the landmark is found under one inclination.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InclinationRange {
    /// Degrees.
    pub inclination_deg: u32,
    /// Where half of the views find it; none if the distances that were tried do not show it.
    pub half: Option<HalfRange>,
    /// (5) with 1.5 px, metres (RANGE-1).
    pub stripe_width_m: f64,
    /// (6) as printed, metres (RANGE-2).
    pub scan_line_m: f64,
    /// Detection rate by whole centimetre.
    pub rates: Vec<(u32, f64)>,
}

/// A cell of Fig. 10.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CellPoses {
    /// Inclination, degrees.
    pub inclination_deg: u32,
    /// Distance, centimetres.
    pub distance_cm: u32,
    /// Views.
    pub views: u64,
    /// Statistics of the errors; none where fewer than two views gave a pose.
    pub errors: PerRule<Option<Spread>>,
}

impl CellPoses {
    /// The cell as it may enter the regressions.
    #[must_use]
    pub fn sample(&self, rule: fn(&PerRule<Option<Spread>>) -> Option<Spread>) -> Sample {
        sample(self.inclination_deg, self.distance_cm, self.views, rule(&self.errors))
    }
}

/// (11) and (12) as the paper has them, and the closed form of (12).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PaperRegressions {
    /// ln λ1: per metre, and ln m².
    pub major: [f64; 2],
    /// ln λ2: per metre, and ln m².
    pub minor: [f64; 2],
    /// Rotation: gain, and step in radians.
    pub rotation: [f64; 2],
    /// The same of the closed form.
    pub closed_form: [f64; 2],
}

impl PaperRegressions {
    fn new() -> Self {
        let growth = |growth: Growth| [growth.slope, growth.intercept];
        let rotation = |rotation: Rotation| [rotation.gain, rotation.step];
        Self {
            major: growth(MAJOR),
            minor: growth(MINOR),
            rotation: rotation(ROTATION),
            closed_form: rotation(EQUAL_WIDTH),
        }
    }
}

/// The regressions with one choice changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Changed {
    /// What is changed.
    pub change: &'static str,
    /// Cells at least half of whose views gave a pose.
    pub cells: usize,
    /// Those of them in which all poses are the same, which enter no regression.
    pub without_spread: usize,
    /// The regressions over the others.
    pub regressions: Option<Regressions>,
    /// Without the change, over the same cells: a change that loses the far cells alters the slopes by that alone.
    pub unchanged: Option<Regressions>,
}

/// Frames that a report takes, for a progress bar.
#[must_use]
pub fn frames(plan: &Plan) -> u64 {
    let cells = (PAPER_INCLINATIONS.len() * scenes::PAPER_DISTANCES.len()) as u64;
    let range_cells = PAPER_INCLINATIONS.len() as u64 * super::studies::RANGE_CENTIMETRES.count() as u64;
    scenes::paper_frames() + u64::from(plan.views) * (cells * (1 + Change::ALL.len() as u64) + range_cells)
}

impl Report {
    /// Runs everything. `progress` is called with the number of frames that have just been run.
    #[must_use]
    pub fn new(plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Self {
        let rates = Study::rates(plan, progress);
        let ranges = Study::ranges(plan, progress);
        let poses = Study::poses(plan, progress);
        let tally = rates.tally.merged(&ranges.tally).merged(&poses.tally);
        let cells: Vec<CellPoses> = poses.sectors.iter().map(cell_poses).collect();
        let regressions = |rule: fn(&PerRule<Option<Spread>>) -> Option<Spread>| {
            Regressions::of(&cells.iter().map(|cell| cell.sample(rule)).collect::<Vec<_>>())
        };
        let (frontal, inclined): (Vec<&Sector>, Vec<&Sector>) =
            rates.sectors.iter().partition(|sector| sector.row >= FIRST_BARCODE_ROW);
        let mut report = Self {
            seed: plan.seed,
            views: plan.views,
            pipelines: Pipelines::of(&tally),
            barcodes: frontal.into_iter().map(|sector| cell_rates(sector, FIRST_BARCODE_ROW)).collect(),
            inclinations: inclined.into_iter().map(|sector| cell_rates(sector, 0)).collect(),
            ranges: PerRule {
                whole_pixel: Ranges::of(&ranges, |seen| &seen.whole_pixel),
                interpolated: Ranges::of(&ranges, |seen| &seen.interpolated),
            },
            regressions: PerRule {
                whole_pixel: regressions(|errors| errors.whole_pixel),
                interpolated: regressions(|errors| errors.interpolated),
            },
            poses: cells,
            paper: PaperRegressions::new(),
            changes: changes(plan, progress),
            statements: Vec::new(),
        };
        report.statements = statements(&report);
        report
    }

    /// As JSON with a line feed at its end.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Strings, numbers and sequences only, which always have a JSON form.
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }
}

fn cell_rates(sector: &Sector, first_row: u32) -> CellRates {
    CellRates { row: sector.row - first_row, distance_cm: sector.centimetres, seen: sector.seen.map(Found::of) }
}

fn cell_poses(sector: &Sector) -> CellPoses {
    CellPoses {
        inclination_deg: sector.row,
        distance_cm: sector.centimetres,
        views: sector.seen.whole_pixel.rate.views,
        errors: sector.seen.map(|seen| Spread::of(&seen.errors)),
    }
}

fn sample(degrees: u32, centimetres: u32, views: u64, spread: Option<Spread>) -> Sample {
    let (inclination, distance) = (f64::from(degrees).to_radians(), f64::from(centimetres) / 100.0);
    Sample { inclination, distance, views, spread }
}

impl Ranges {
    fn of(study: &Study, rule: fn(&PerRule<Sightings>) -> &Sightings) -> Self {
        let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
        let range = |degrees: u32| {
            let inclination = f64::from(degrees).to_radians();
            let rates: Vec<(u32, f64)> =
                study.row(degrees).map(|sector| (sector.centimetres, Found::of(rule(&sector.seen)).rate())).collect();
            let metres: Vec<(f64, f64)> = rates.iter().map(|&(cm, rate)| (f64::from(cm) / 100.0, rate)).collect();
            InclinationRange {
                inclination_deg: degrees,
                half: HalfRange::of(&metres),
                stripe_width_m: stripe_width_range(&camera, &landmark, inclination, MIN_STRIPE_PIXELS),
                scan_line_m: scan_line_range(&camera, &landmark, inclination),
                rates,
            }
        };
        let inclinations: Vec<InclinationRange> = PAPER_INCLINATIONS.into_iter().map(range).collect();
        let found: Option<Vec<(f64, f64)>> = inclinations
            .iter()
            .map(|range| Some((f64::from(range.inclination_deg).to_radians(), range.half?.metres)))
            .collect();
        let Some(found) = found else { return Self { inclinations, ..Self::default() } };
        Self {
            inclinations,
            paper: RowReading::ALL.map(|reading| Prediction::with(reading, MIN_STRIPE_PIXELS, &found)).to_vec(),
            best: RowReading::ALL.map(|reading| Prediction::best(reading, &found)).to_vec(),
        }
    }
}

/// Every change, what is changed in none first.
fn changes(plan: &Plan, progress: &(dyn Fn(u64) + Sync)) -> Vec<Changed> {
    let samples = |change| -> Vec<Sample> {
        let cells = changed(plan, change, progress);
        cells.into_iter().map(|(row, cm, spread)| sample(row, cm, u64::from(plan.views), spread)).collect()
    };
    let all = Change::ALL.map(|change| (change, samples(change)));
    let unchanged = &all[0].1;
    all.iter().map(|(change, samples)| Changed::of(*change, samples, unchanged)).collect()
}

impl Changed {
    fn of(change: Change, samples: &[Sample], unchanged: &[Sample]) -> Self {
        let both = samples.iter().zip(unchanged).filter(|(sample, _)| sample.usable().is_some());
        let same_cells: Vec<Sample> = both.map(|(_, unchanged)| *unchanged).collect();
        let seen = samples.iter().filter(|sample| sample.is_seen()).count();
        let used = samples.iter().filter(|sample| sample.usable().is_some()).count();
        Self {
            change: change.name(),
            cells: seen,
            without_spread: seen - used,
            regressions: Regressions::of(samples),
            unchanged: Regressions::of(&same_cells),
        }
    }
}
