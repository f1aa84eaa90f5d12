//! Where to put the landmarks of a site (PLACE).
//!
//! A route is cut into samples. A *window* begins at a sample and is as long as the gap that is allowed; it is *served*
//! by a landmark that is readable from one of its samples. If every window is served, nowhere on the route does the robot
//! go farther than the gap without a readable landmark. The fewest landmarks that serve all windows are a set cover, with
//! pairs that stand too near to each other excluded: a mixed-integer program.

mod candidates;
mod cover;
mod solve;
mod windows;

pub use candidates::{Candidate, candidates};
pub use solve::Bound;
pub use windows::{Stretch, windows};

use crate::coverage::{CoverageError, Gap, RouteCoverage, Sample, View, cover_route, longest_gap, samples};
use crate::site::{Route, Site};
use core::fmt;
use cover::Cover;
use rayon::prelude::*;
use reference::camera::Camera;
use reference::landmark::Format;

/// Default of the longest way without a readable landmark, metres (PLACE-2).
//= reference/SPEC.md#place
//# - **PLACE-2** The gap MUST by default be 1 m.
pub const DEFAULT_GAP: f64 = 1.0;

/// How much finer the check's step is than the program's (PLACE-7); odd, so that it keeps the program's samples.
//= reference/SPEC.md#place
//# - **PLACE-7** The result MUST be checked as the site that it is, by SITE-10 to SITE-13 at a fifth of the step, and
//# be refused if its longest gap is above `G`.
pub const REFINE: usize = 5;

/// How often pairs that crowd each other in the image are excluded before it is given up (PLACE-6).
const ROUNDS: usize = 50;

/// Rounding of distances along a route, metres.
const ROUNDING: f64 = 1e-9;

/// What to place.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    /// Longest way without a readable landmark, metres.
    pub gap: f64,
    /// Format of the landmarks, of default dimensions.
    pub format: Format,
    /// Distance of samples along the route, metres.
    pub step: f64,
}

/// Landmarks that keep to the wish.
#[derive(Clone, Debug)]
pub struct Placement {
    /// What to add to the site, in the order of walls and codes.
    pub chosen: Vec<Candidate>,
    /// How few would do at best, and why (PLACE-8).
    pub bound: Bound,
    /// The check: the site with the landmarks, at [`REFINE`] times the samples.
    pub checked: RouteCoverage,
    /// The site with the landmarks.
    pub site: Site,
}

/// Why there is no placement.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaceError {
    /// The site has no route.
    NoRoute,
    /// The gap is not a finite number above 0.
    Gap,
    /// The steps along the route are none or too small.
    Coverage(CoverageError),
    /// There is no grid point on a wall at all.
    NoCandidates,
    /// Even with a landmark wherever one could be, there is a longer gap.
    Impossible(Option<Gap>),
    /// Landmarks that serve every window stand too near to each other.
    TooNear,
    /// Choice after choice, landmarks crowd each other in the image.
    Crowded,
    /// The solver gave up.
    Solver(String),
    /// The check at the finer step found this gap.
    Unverified(Option<Gap>),
}

impl fmt::Display for PlaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRoute => f.write_str("the site has no route along which to place landmarks"),
            Self::Gap => f.write_str("the gap must be finite and above 0"),
            Self::Coverage(error) => error.fmt(f),
            Self::NoCandidates => {
                f.write_str("no point of the grid lies on a wall with the wall's normal among the grid's headings")
            }
            Self::Impossible(Some(gap)) => write!(
                f,
                "with a landmark at every possible place nothing is readable for {:.3} m from {:.3} m along the route on",
                gap.length, gap.from
            ),
            Self::Impossible(None) => f.write_str("nothing is readable from the route, wherever a landmark is put"),
            Self::TooNear => f.write_str("every choice that keeps to the gap has landmarks too near to each other"),
            Self::Crowded => write!(f, "{ROUNDS} choices in turn had landmarks that crowd each other in the image"),
            Self::Solver(what) => write!(f, "the solver gave up: {what}"),
            Self::Unverified(gap) => match gap {
                Some(gap) => write!(f, "the check found a gap of {:.3} m from {:.3} m on", gap.length, gap.from),
                None => f.write_str("the check found nothing readable"),
            },
        }
    }
}

impl core::error::Error for PlaceError {}

/// Chooses landmarks along the site's route (PLACE-1 to PLACE-8).
//= reference/SPEC.md#place
//# - **PLACE-5** Of the choices that fulfil PLACE-3 and PLACE-4 one with the fewest landmarks MUST be taken, and from
//# it, one landmark after the other exchanged as long as that makes more samples read.
pub fn place(site: &Site, camera: &Camera, wish: &Wish) -> Result<Placement, PlaceError> {
    let route = site.route.as_ref().ok_or(PlaceError::NoRoute)?;
    if !(wish.gap.is_finite() && wish.gap > 0.0) {
        return Err(PlaceError::Gap);
    }
    let samples = samples(route, wish.step, 1).map_err(PlaceError::Coverage)?;
    let problem = Problem::new(site, route, camera, wish, &samples);
    let mut cover = problem.cover()?;
    let bound = solve::bound(&cover)?;
    for _ in 0..ROUNDS {
        let (chosen, proven) = solve::fewest(&cover)?;
        let chosen = solve::exchange(&cover, chosen);
        let landmarks: Vec<Candidate> = chosen.iter().map(|&i| problem.candidates[i]).collect();
        let full = with(site, &landmarks);
        let checked = cover_route(&full, route, camera, wish.step, REFINE).map_err(PlaceError::Coverage)?;
        if checked.longest_gap.is_some_and(|gap| gap.length <= wish.gap + ROUNDING) {
            let bound = bound.with_solution(landmarks.len(), proven && cover.is_original());
            return Ok(Placement { chosen: landmarks, bound, checked, site: full });
        }
        if !problem.exclude_crowding(&mut cover, &chosen) {
            return Err(PlaceError::Unverified(checked.longest_gap));
        }
    }
    Err(PlaceError::Crowded)
}

/// The site with landmarks added.
fn with(site: &Site, added: &[Candidate]) -> Site {
    let mut full = site.clone();
    full.landmarks.extend(added.iter().map(|candidate| candidate.posted));
    full
}

/// Candidates, samples and who sees what.
struct Problem<'a> {
    site: &'a Site,
    view: View<'a>,
    samples: &'a [Sample],
    candidates: Vec<Candidate>,
    /// For every sample, whether a landmark that is there already is readable.
    served: Vec<bool>,
    /// For every candidate the numbers of the samples that show it, ascending.
    seen: Vec<Vec<usize>>,
    windows: Vec<Stretch>,
    length: f64,
    closed: bool,
}

impl<'a> Problem<'a> {
    fn new(site: &'a Site, route: &Route, camera: &'a Camera, wish: &Wish, samples: &'a [Sample]) -> Self {
        let view = View::of(site, camera);
        let candidates = candidates(site, wish.format);
        let shown = |candidate: &Candidate| -> Vec<usize> {
            let shows = |&i: &usize| view.shows(&samples[i].robot_in_world, &candidate.posted);
            (0..samples.len()).filter(shows).collect()
        };
        let seen = candidates.par_iter().map(shown).collect();
        let read = |sample: &Sample| !view.readable(&sample.robot_in_world, &site.landmarks).is_empty();
        let served = samples.par_iter().map(read).collect();
        let length = crate::coverage::route_length(route);
        let windows = windows(samples, length, route.closed, wish.gap);
        Self { site, view, samples, candidates, served, seen, windows, length, closed: route.closed }
    }

    fn cover(&self) -> Result<Cover, PlaceError> {
        let cover = Cover::new(&self.windows, self.samples.len(), &self.served, &self.seen, &self.candidates);
        if cover.is_possible() {
            return Ok(cover);
        }
        if self.candidates.is_empty() {
            return Err(PlaceError::NoCandidates);
        }
        let mut read = self.served.clone();
        self.seen.iter().flatten().for_each(|&i| read[i] = true);
        let read: Vec<f64> = (0..read.len()).filter(|&i| read[i]).map(|i| self.samples[i].along).collect();
        Err(PlaceError::Impossible(longest_gap(&read, self.length, self.closed)))
    }

    /// Excludes pairs of chosen candidates that spoil each other in the image, and candidates that spoil, or are spoilt
    /// by, landmarks that are there already (PLACE-6). Whether there were any.
    //= reference/SPEC.md#place
    //# - **PLACE-6** Two landmarks that crowd each other in the image (SITE-11) from a sample of the route MUST be
    //# excluded as a pair, if otherwise the check fails, and the choice made again.
    fn exclude_crowding(&self, cover: &mut Cover, chosen: &[usize]) -> bool {
        let mut any = false;
        for sample in self.samples {
            let pose = &sample.robot_in_world;
            for (k, &one) in chosen.iter().enumerate() {
                let posted = &self.candidates[one].posted;
                for &other in &chosen[k + 1..] {
                    if self.view.crowds(pose, &self.candidates[other].posted, posted) {
                        any |= cover.exclude_pair(one, other);
                    }
                }
                if self.site.landmarks.iter().any(|there| self.view.crowds(pose, there, posted)) {
                    any |= cover.exclude(one);
                }
            }
        }
        any
    }
}

#[cfg(test)]
mod tests;
