//! What the runs of a scenario come to.

use super::{Differing, Recovery, Run, Score};
use core::f64::consts::PI;
use serde::Serialize;

/// Errors of one robot over all runs (ROUTE-3).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Mean distance from the truth over all samples of all runs, metres.
    pub mean_position_error_m: f64,
    /// What 95 % of the samples are below.
    pub p95_position_error_m: f64,
    /// The largest.
    pub max_position_error_m: f64,
    /// Mean difference in heading, radians.
    pub mean_heading_error_rad: f64,
    /// What 95 % of the samples are below.
    pub p95_heading_error_rad: f64,
    /// The largest.
    pub max_heading_error_rad: f64,
    /// Mean of the runs' mean NEES.
    pub mean_nees: f64,
    /// Between what the mean NEES of so many runs lies in 95 of 100 cases, each of them counted as one chi-square of three.
    pub nees_band: [f64; 2],
    /// Observations that were used, in all runs.
    pub observations_used: u64,
    /// Those that were not.
    pub observations_gated: u64,
    /// Where the filter began again, run by run.
    pub recoveries: Vec<Recovery>,
    /// How often a robot that was lost never found back.
    pub lost: u64,
}

/// Errors of the wheels alone.
#[expect(clippy::struct_field_names, reason = "named as in the JSON that is asked for")]
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OdometryErrors {
    /// Mean distance from the truth at the runs' ends, metres.
    pub mean_final_error_m: f64,
    /// Mean distance over all samples.
    pub mean_position_error_m: f64,
    /// The largest.
    pub max_position_error_m: f64,
}

/// How far the pipelines are from each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Metres.
    pub position_m: f64,
    /// Radians.
    pub heading_rad: f64,
}

impl From<(f64, f64)> for Difference {
    fn from((position_m, heading_rad): (f64, f64)) -> Self {
        Self { position_m, heading_rad }
    }
}

/// What the runs of a scenario come to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The scenario's name or file.
    pub scenario: String,
    /// Number of runs.
    pub runs: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// The reference.
    pub reference: Errors,
    /// The port.
    pub fixedpoint: Errors,
    /// The wheels alone.
    pub odometry: OdometryErrors,
    /// The largest difference between both pipelines.
    pub largest_difference: Difference,
    /// The same where both had taken the same decisions, or had both used two images since.
    pub largest_difference_decided_alike: Difference,
    /// Readings at which they had not decided alike since the one before, and why.
    pub decided_differently: Differing,
}

/// How far the filters may be from each other along a route: metres, and radians (SAME-7).
pub const TOGETHER: (f64, f64) = (1e-3, 0.1 * PI / 180.0);

impl Report {
    /// Whether both filters have stayed together (SAME-7).
    //= reference/SPEC.md#same
    //# - **SAME-7** Along a route both filters that are given LAYER's measurements at EXPOSE-1's times MUST stay within
    //# 1 mm and 0.1° of each other wherever they have decided alike (ROUTE-7), and decide otherwise only where one of
    //# them accepts a landmark that the other does not by SAME-5, where the reference's NIS, by its estimate or by its
    //# candidate, is within 1 in 1,000 of FILTER-4's limit, or where they already have and not both used observations
    //# twice since.
    #[must_use]
    pub fn stays_together(&self) -> bool {
        let Difference { position_m, heading_rad } = self.largest_difference_decided_alike;
        position_m <= TOGETHER.0 && heading_rad <= TOGETHER.1 && self.decided_differently.unexplained == 0
    }
}

/// The report on runs; `None` without any.
#[must_use]
pub fn report(scenario: &str, seed: u64, runs: &[Run]) -> Option<Report> {
    let largest = |of: fn(&Run) -> (f64, f64)| {
        let both = runs.iter().map(of);
        Difference::from(both.fold((0.0_f64, 0.0_f64), |most, one| (most.0.max(one.0), most.1.max(one.1))))
    };
    let of = |robot: usize| runs.iter().map(|run| &run.scores[robot]).collect::<Vec<_>>();
    Some(Report {
        scenario: scenario.to_owned(),
        runs: runs.len(),
        seed,
        reference: errors(&of(0))?,
        fixedpoint: errors(&of(1))?,
        odometry: odometry(&of(2))?,
        largest_difference: largest(|run| run.apart),
        largest_difference_decided_alike: largest(|run| run.apart_alike),
        decided_differently: runs.iter().fold(Differing::default(), |sum, run| sum.and(&run.differing)),
    })
}

//= reference/SPEC.md#route
//# - **ROUTE-3** Mean, 95th percentile and largest error MUST be those of all samples of all runs together, and the
//# mean NEES that of the runs' means.
fn errors(scores: &[&Score]) -> Option<Errors> {
    let position = pooled(scores, |score| &score.position)?;
    let heading = pooled(scores, |score| &score.heading)?;
    let nees: Vec<f64> = scores.iter().filter_map(|score| mean(&score.nees)).collect();
    Some(Errors {
        mean_position_error_m: mean(&position)?,
        p95_position_error_m: quantile(&position, 0.95),
        max_position_error_m: quantile(&position, 1.0),
        mean_heading_error_rad: mean(&heading)?,
        p95_heading_error_rad: quantile(&heading, 0.95),
        max_heading_error_rad: quantile(&heading, 1.0),
        mean_nees: mean(&nees)?,
        nees_band: chi_square_band(3 * scores.len()).map(|bound| bound / scores.len() as f64),
        observations_used: scores.iter().map(|score| score.taken.used).sum(),
        observations_gated: scores.iter().map(|score| score.taken.gated).sum(),
        recoveries: scores.iter().flat_map(|score| score.recoveries.iter().copied()).collect(),
        lost: scores.iter().map(|score| score.lost).sum(),
    })
}

fn odometry(scores: &[&Score]) -> Option<OdometryErrors> {
    let position = pooled(scores, |score| &score.position)?;
    let ends: Vec<f64> = scores.iter().filter_map(|score| score.position.last().copied()).collect();
    Some(OdometryErrors {
        mean_final_error_m: mean(&ends)?,
        mean_position_error_m: mean(&position)?,
        max_position_error_m: quantile(&position, 1.0),
    })
}

/// All runs' samples, sorted; `None` without any.
fn pooled(scores: &[&Score], of: fn(&Score) -> &Vec<f64>) -> Option<Vec<f64>> {
    let mut all: Vec<f64> = scores.iter().flat_map(|score| of(score).iter().copied()).collect();
    all.sort_by(f64::total_cmp);
    (!all.is_empty()).then_some(all)
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// What a share of the sorted values is at most.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to their number")]
    let count = (share * sorted.len() as f64).ceil() as usize;
    sorted[count.clamp(1, sorted.len()) - 1]
}

/// Between what a chi-square of so many degrees of freedom lies in 95 of 100 cases, by Wilson and Hilferty's cube: within
/// 0.1 % from 30 degrees of freedom on, those of ten runs.
fn chi_square_band(degrees: usize) -> [f64; 2] {
    let n = degrees as f64;
    [-1.959_964, 1.959_964].map(|z| n * (1.0 - 2.0 / (9.0 * n) + z * (2.0 / (9.0 * n)).sqrt()).powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SAME-7: 1.02 mm or 0.102° are too far, and a decision without a reason is one too many.
    #[test]
    fn what_is_not_together_is_noticed() {
        let score = Score { position: vec![0.0], heading: vec![0.0], nees: vec![3.0], ..Score::default() };
        let of = |apart_alike: (f64, f64), unexplained: u64| {
            let differing = Differing { unexplained, follows: 3, ..Differing::default() };
            let run = Run { scores: vec![score.clone(); 3], apart_alike, differing, ..Run::default() };
            report("any", 1, &[run]).unwrap().stays_together()
        };
        let degrees = |angle: f64| angle.to_radians();
        assert!(of((0.98e-3, degrees(0.098)), 0));
        assert!(!of((1.02e-3, 0.0), 0) && !of((0.0, degrees(0.102)), 0) && !of((0.0, 0.0), 1));
    }

    /// The 2.5 % and 97.5 % points of published tables.
    #[test]
    fn the_band_is_that_of_the_tables() {
        for (degrees, low, high) in [(30, 16.791, 46.979), (100, 74.222, 129.561), (300, 253.912, 349.874)] {
            let [from, to] = chi_square_band(degrees);
            assert!((from / low - 1.0).abs() < 1e-3 && (to / high - 1.0).abs() < 1e-3, "{degrees}: {from} {to}");
        }
    }

    #[test]
    fn quantiles_are_of_the_sorted_values() {
        let sorted: Vec<f64> = (1..=20).map(f64::from).collect();
        assert!((quantile(&sorted, 0.95) - 19.0).abs() < 1e-12);
        assert!((quantile(&sorted, 1.0) - 20.0).abs() < 1e-12);
        assert!((quantile(&sorted[..1], 0.95) - 1.0).abs() < 1e-12);
    }

    //= reference/SPEC.md#route
    //= type=test
    //# - **ROUTE-3** Mean, 95th percentile and largest error MUST be those of all samples of all runs together, and the
    //# mean NEES that of the runs' means.
    #[test]
    fn samples_of_all_runs_count_alike() {
        let score =
            |position: Vec<f64>| Score { heading: position.clone(), nees: vec![3.0], position, ..Score::default() };
        let (short, long) = (score(vec![4.0]), score(vec![1.0, 1.0, 2.0]));
        let found = errors(&[&short, &long]).unwrap();
        assert!((found.mean_position_error_m - 2.0).abs() < 1e-12 && (found.max_position_error_m - 4.0).abs() < 1e-12);
    }
}
