//! From where the landmarks of a site can be read (SITE-10 to SITE-14).

mod map;
mod region;
mod route;
mod sight;

pub use map::heat_map;
pub use region::{Cell, RegionCoverage, cover_region};
pub(crate) use route::route_length;
pub use route::{Gap, RouteCoverage, Sample, cover_route, longest_gap, samples};
pub use sight::View;

use core::fmt;

/// Default distance of poses along a route, metres.
pub const ROUTE_STEP: f64 = 0.005;

/// Default distance of positions in a region, metres.
pub const REGION_CELL: f64 = 0.02;

/// Default number of headings at a position of a region.
pub const REGION_HEADINGS: usize = 72;

/// Most poses that are looked at.
pub const MOST_POSES: f64 = 2e7;

/// Why there is no coverage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoverageError {
    /// A step or cell is not a finite number above 0, or there are no headings.
    Step,
    /// More than [`MOST_POSES`] poses.
    TooManyPoses,
}

impl fmt::Display for CoverageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Step => "steps must be finite and above 0, and there must be at least one heading",
            Self::TooManyPoses => "these are more than 20 million poses; choose larger steps",
        })
    }
}

impl core::error::Error for CoverageError {}

/// Refuses steps that are none and numbers of poses that are too large.
fn check(step: f64, poses: f64) -> Result<(), CoverageError> {
    if !(step.is_finite() && step > 0.0) {
        Err(CoverageError::Step)
    } else if poses > MOST_POSES {
        Err(CoverageError::TooManyPoses)
    } else {
        Ok(())
    }
}
