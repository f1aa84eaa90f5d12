//! Coverage along a route (SITE-12, SITE-13).

use super::{CoverageError, View, check};
use crate::site::{Route, Site};
use rayon::prelude::*;
use reference::camera::Camera;
use reference::frame::{Pose, Robot, World};

/// A pose on a route, in the middle of the piece of the route that it stands for.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Distance along the route from its first point, metres.
    pub along: f64,
    /// Length of its piece, metres.
    pub length: f64,
    /// The robot on the route, looking along it.
    pub robot_in_world: Pose<World, Robot>,
}

/// A piece of a route on which nothing is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Where it begins, metres along the route.
    pub from: f64,
    /// How long it is, metres; on a closed route it may go on beyond the route's first point.
    pub length: f64,
}

/// What is read along a route.
#[derive(Clone, Debug)]
pub struct RouteCoverage {
    /// Length of the route (of a lap), metres.
    pub length: f64,
    /// The poses that were looked at.
    pub samples: Vec<Sample>,
    /// For every sample the numbers of the landmarks that are readable.
    pub readable: Vec<Vec<usize>>,
    /// The longest piece without a readable landmark; none on a closed route on which nothing is ever read.
    pub longest_gap: Option<Gap>,
}

impl RouteCoverage {
    /// Length of the pieces on which something is read, metres.
    #[must_use]
    pub fn readable_length(&self) -> f64 {
        let read = self.samples.iter().zip(&self.readable).filter(|(_, numbers)| !numbers.is_empty());
        // From 0.0: an empty sum of floats is -0.
        read.fold(0.0, |sum, (sample, _)| sum + sample.length)
    }

    /// Share of the route on which something is read, 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.readable_length() / self.length
    }
}

/// Poses along a route: every leg in the least number of equal pieces of at most `step` metres, each of these again in
/// `refine` pieces, which for odd numbers keeps the middles of the former (SITE-12).
//= reference/SPEC.md#site
//# - **SITE-12** A route MUST be looked at from the middles of equal pieces of each leg that are no longer than the
//# step, by default 5 mm, with the robot's heading along the leg.
pub fn samples(route: &Route, step: f64, refine: usize) -> Result<Vec<Sample>, CoverageError> {
    let legs: Vec<_> = legs(route).collect();
    check(step, refine as f64 * legs.iter().map(|&leg| (length(leg) / step).ceil()).sum::<f64>())?;
    let mut samples = Vec::new();
    let mut start = 0.0;
    for leg in legs {
        let [a, b] = leg;
        let leg_length = length(leg);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most MOST_POSES")]
        let pieces = (leg_length / step).ceil() as usize * refine;
        let heading = (b[1] - a[1]).atan2(b[0] - a[0]);
        samples.extend((0..pieces).map(|i| {
            let part = (i as f64 + 0.5) / pieces as f64;
            let at = [0, 1].map(|axis| a[axis] + part * (b[axis] - a[axis]));
            Sample {
                along: start + part * leg_length,
                length: leg_length / pieces as f64,
                robot_in_world: Pose::new(at[0], at[1], heading),
            }
        }));
        start += leg_length;
    }
    Ok(samples)
}

/// The legs of a route, the way back to its first point among them if it is closed.
fn legs(route: &Route) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let count = route.points.len() - usize::from(!route.closed);
    crate::site::sides(&route.points).take(count)
}

fn length([a, b]: [[f64; 2]; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Length of a route (of a lap), metres.
pub(crate) fn route_length(route: &Route) -> f64 {
    legs(route).map(length).sum()
}

/// What the site's robot reads along a route (SITE-12, SITE-13).
pub fn cover_route(
    site: &Site,
    route: &Route,
    camera: &Camera,
    step: f64,
    refine: usize,
) -> Result<RouteCoverage, CoverageError> {
    let samples = samples(route, step, refine)?;
    let view = View::of(site, camera);
    let readable: Vec<Vec<usize>> =
        samples.par_iter().map(|sample| view.readable(&sample.robot_in_world, &site.landmarks)).collect();
    let length = route_length(route);
    let read: Vec<f64> = samples
        .iter()
        .zip(&readable)
        .filter(|(_, numbers)| !numbers.is_empty())
        .map(|(sample, _)| sample.along)
        .collect();
    let longest_gap = longest_gap(&read, length, route.closed);
    Ok(RouteCoverage { length, samples, readable, longest_gap })
}

/// The longest way between neighbouring points of `read`, metres along a route of the given length, to and from the ends
/// of an open one (SITE-13).
///
/// These are points of the route from which something is read, so that whatever lies between the samples, no piece
/// without a readable landmark is longer.
//= reference/SPEC.md#site
//# - **SITE-13** The longest gap of a route MUST be the longest way between neighbouring poses from which something is
//# readable, on a closed route also over its end, on an open one also from and to its ends.
#[must_use]
pub fn longest_gap(read: &[f64], length: f64, closed: bool) -> Option<Gap> {
    let (Some(&first), Some(&last)) = (read.first(), read.last()) else {
        return (!closed).then_some(Gap { from: 0.0, length });
    };
    let between = read.windows(2).map(|pair| Gap { from: pair[0], length: pair[1] - pair[0] });
    let ends = if closed {
        vec![Gap { from: last, length: first + length - last }]
    } else {
        vec![Gap { from: 0.0, length: first }, Gap { from: last, length: length - last }]
    };
    between.chain(ends).reduce(|most, gap| if gap.length > most.length { gap } else { most })
}

#[cfg(test)]
mod tests {
    use super::*;

    //= reference/SPEC.md#site
    //= type=test
    //# - **SITE-13** The longest gap of a route MUST be the longest way between neighbouring poses from which something
    //# is readable, on a closed route also over its end, on an open one also from and to its ends.
    #[test]
    fn gaps_reach_around_a_closed_route_and_to_the_ends_of_an_open_one() {
        let read = [1.0, 2.0, 4.5];
        assert_eq!(longest_gap(&read, 6.5, true), Some(Gap { from: 4.5, length: 3.0 }));
        assert_eq!(longest_gap(&read, 5.0, true), Some(Gap { from: 2.0, length: 2.5 }));
        assert_eq!(longest_gap(&read, 8.0, false), Some(Gap { from: 4.5, length: 3.5 }));
        assert_eq!(longest_gap(&[3.0], 4.0, false), Some(Gap { from: 0.0, length: 3.0 }));
        assert_eq!(longest_gap(&[], 4.0, false), Some(Gap { from: 0.0, length: 4.0 }));
        assert_eq!(longest_gap(&[], 4.0, true), None);
    }

    //= reference/SPEC.md#site
    //= type=test
    //# - **SITE-12** A route MUST be looked at from the middles of equal pieces of each leg that are no longer than the
    //# step, by default 5 mm, with the robot's heading along the leg.
    #[test]
    fn samples_are_the_middles_of_equal_pieces() {
        let route = Route { points: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.5]], closed: false };
        let found = samples(&route, 0.4, 1).unwrap();
        // 1 m in three pieces, 0.5 m in two.
        let along: Vec<f64> = found.iter().map(|sample| sample.along).collect();
        for (found, expected) in along.iter().zip([1.0 / 6.0, 0.5, 5.0 / 6.0, 1.125, 1.375]) {
            assert!((found - expected).abs() < 1e-12, "{along:?}");
        }
        assert_eq!(along.len(), 5);
        assert!((found[4].robot_in_world.theta() - core::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((found[4].robot_in_world.y() - 0.375).abs() < 1e-12);
        // Odd refinement keeps them.
        let fine = samples(&route, 0.4, 5).unwrap();
        assert!(along.iter().all(|a| fine.iter().any(|sample| (sample.along - a).abs() < 1e-12)));
        assert_eq!(samples(&route, 0.0, 1).unwrap_err(), CoverageError::Step);
        assert_eq!(samples(&route, f64::NAN, 1).unwrap_err(), CoverageError::Step);
        assert_eq!(samples(&route, 1e-9, 1).unwrap_err(), CoverageError::TooManyPoses);
    }
}
