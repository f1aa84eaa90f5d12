//! The paper's regressions (11) and (12) fitted to our poses.

use super::line::Line;
use super::spread::Spread;
use reference::regression::{EQUAL_WIDTH, wrap_axis};
use serde::Serialize;

/// A cell's place and its statistics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Inclination, radians, 0 or more.
    pub inclination: f64,
    /// Distance, metres.
    pub distance: f64,
    /// Views of the cell.
    pub views: u64,
    /// Statistics of those in which the landmark was found.
    pub spread: Option<Spread>,
}

/// Fewest poses of a cell that enters a regression: a variance is then known to √(2/9), 47 %.
pub const FEWEST_POSES: usize = 10;

/// Smallest standard deviation of a cell that enters a regression, metres: below it all views gave the same pose.
pub const SMALLEST_DEVIATION: f64 = 1e-9;

impl Sample {
    /// Whether at least half of the views and [`FEWEST_POSES`] gave a pose.
    #[must_use]
    pub fn is_seen(&self) -> bool {
        let poses = self.spread.map_or(0, |spread| spread.poses);
        poses >= FEWEST_POSES && 2 * poses as u64 >= self.views
    }

    /// The statistics if they enter the regressions: enough views gave a pose, and the poses are not all the same.
    #[must_use]
    pub fn usable(&self) -> Option<&Spread> {
        self.spread.as_ref().filter(|spread| self.is_seen() && spread.minor.sqrt() > SMALLEST_DEVIATION)
    }
}

/// The regressions over the cells that enter them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Regressions {
    /// Cells that enter.
    pub cells: usize,
    /// ln λ1 in m² by distance in metres (11).
    pub major: Line,
    /// ln λ2 in m² by distance in metres (11).
    pub minor: Line,
    /// ln λ1 by the logarithm of the distance in metres: the slope is a power.
    pub major_power: Line,
    /// ln λ2 by the logarithm of the distance in metres.
    pub minor_power: Line,
    /// The rotation by inclination, radians both: slope and minus intercept are the gain and the step of (12).
    pub rotation: Line,
}

impl Regressions {
    /// None where the cells that enter do not determine all of them.
    #[must_use]
    pub fn of(samples: &[Sample]) -> Option<Self> {
        let used: Vec<(&Sample, &Spread)> =
            samples.iter().filter_map(|sample| Some((sample, sample.usable()?))).collect();
        let fit = |point: fn(&Sample, &Spread) -> (f64, f64)| {
            Line::through(&used.iter().map(|(sample, spread)| point(sample, spread)).collect::<Vec<_>>())
        };
        Some(Self {
            cells: used.len(),
            major: fit(|sample, spread| (sample.distance, spread.major.ln()))?,
            minor: fit(|sample, spread| (sample.distance, spread.minor.ln()))?,
            major_power: fit(|sample, spread| (sample.distance.ln(), spread.major.ln()))?,
            minor_power: fit(|sample, spread| (sample.distance.ln(), spread.minor.ln()))?,
            rotation: fit(|sample, spread| (sample.inclination, unwrapped(sample.inclination, spread.rotation)))?,
        })
    }
}

/// The axis `rotation` without the modulus of ERRATA-6: the one of its angles that is nearest to the closed form
/// `2θ - π/2`, for inclinations of 0 or more, in radians. An axis has no head, and a line can only be laid through
/// angles that do not jump.
#[must_use]
pub fn unwrapped(inclination: f64, rotation: f64) -> f64 {
    let closed = EQUAL_WIDTH.gain * inclination - EQUAL_WIDTH.step;
    closed + wrap_axis(rotation - closed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::sightings::PoseError;
    use reference::regression::{MAJOR, MINOR, ROTATION};

    fn paper(inclination: f64, distance: f64, poses: usize) -> Sample {
        let nothing = PoseError { x: 0.0, y: 0.0, theta: 0.0 };
        let spread = Spread {
            poses,
            mean: nothing,
            deviation: nothing,
            correlation: 0.0,
            heading_correlation: 0.0,
            major: MAJOR.variance(distance),
            minor: MINOR.variance(distance),
            rotation: ROTATION.axis(inclination),
        };
        Sample { inclination, distance, views: 30, spread: Some(spread) }
    }

    #[test]
    fn the_papers_own_regressions_come_back() {
        let mut samples = Vec::new();
        for step in 0..5_u8 {
            for distance in [0.1, 0.3, 0.5] {
                samples.push(paper(f64::from(step) * 15_f64.to_radians(), distance, 30));
            }
        }
        // Too few poses: these must not count.
        samples.push(Sample { spread: paper(0.0, 0.9, 14).spread, ..paper(0.0, 0.2, 30) });
        samples.push(Sample { views: 4, ..paper(0.0, 0.9, 9) });
        let found = Regressions::of(&samples).unwrap();
        assert_eq!(found.cells, 15);
        for (line, slope, intercept) in
            [(found.major, 25.70, -15.46), (found.minor, 16.15, -17.27), (found.rotation, 1.91, -1.43)]
        {
            assert!((line.slope - slope).abs() < 1e-9 && (line.intercept - intercept).abs() < 1e-9, "{line:?}");
        }
    }

    #[test]
    fn nothing_gives_nothing() {
        assert_eq!(Regressions::of(&[]), None);
        assert_eq!(Regressions::of(&[Sample { spread: None, ..paper(0.0, 0.1, 30) }]), None);
    }
}
