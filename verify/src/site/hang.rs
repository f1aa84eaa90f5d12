//! How landmarks hang on walls and beside each other (SITE-5, SITE-7).

use super::{ASKEW, OFF_WALL, Wall};
use core::fmt;
use reference::frame::{Point, wrap};
use reference::landmark::QUIET_ZONE_STRIPES;
use reference::render::Posted;

/// Why a landmark does not hang on a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OffWall {
    /// No wall is within 1 mm of its middle.
    NoWall,
    /// It looks into its wall, or out of the side that is not visible.
    Backwards,
    /// It does not look along the wall's normal.
    Askew,
    /// Barcode and quiet zones are not all on the wall.
    PastTheEnd,
}

impl OffWall {
    /// Whether the heading is at fault, and not the position.
    pub(super) fn is_heading(self) -> bool {
        matches!(self, Self::Backwards | Self::Askew)
    }
}

impl fmt::Display for OffWall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoWall => "the landmark is not within 1 mm of any wall",
            Self::Backwards => "the landmark faces into its wall",
            Self::Askew => "the landmark's heading is not its wall's normal",
            Self::PastTheEnd => "the landmark's barcode and quiet zones reach past the end of its wall",
        })
    }
}

/// Half of what a barcode takes up on its wall, quiet zones included, metres (LAND-5).
fn half_extent(posted: &Posted) -> f64 {
    posted.landmark.half_width() + QUIET_ZONE_STRIPES * posted.landmark.stripe_width
}

/// The number of the wall on which a landmark hangs (SITE-5).
//= reference/SPEC.md#site
//# - **SITE-5** A landmark MUST be refused unless it hangs on a wall: its centre at most 1 mm from the wall's plane,
//# its heading at most 0.01 rad from the normal of a visible face, its barcode and quiet zones between the wall's ends.
pub(crate) fn on_wall(walls: &[Wall], posted: &Posted) -> Result<usize, OffWall> {
    let mut reason = OffWall::NoWall;
    for (i, wall) in walls.iter().enumerate() {
        match fits(wall, posted) {
            Ok(()) => return Ok(i),
            // Of several walls' reasons, the one for which the landmark came nearest to hanging.
            Err(off) => reason = if rank(off) > rank(reason) { off } else { reason },
        }
    }
    Err(reason)
}

fn rank(off: OffWall) -> u8 {
    match off {
        OffWall::NoWall => 0,
        OffWall::Backwards => 1,
        OffWall::Askew => 2,
        OffWall::PastTheEnd => 3,
    }
}

fn fits(wall: &Wall, posted: &Posted) -> Result<(), OffWall> {
    let pose = &posted.landmark_in_world;
    let [along, left] = wall.coordinates([pose.x(), pose.y()]);
    if left.abs() > OFF_WALL || along < -OFF_WALL || along > wall.length() + OFF_WALL {
        return Err(OffWall::NoWall);
    }
    let turned = wall.normals().map(|normal| wrap(normal - pose.theta()).abs()).fold(f64::INFINITY, f64::min);
    if turned > core::f64::consts::FRAC_PI_2 {
        return Err(OffWall::Backwards);
    }
    if turned > ASKEW {
        return Err(OffWall::Askew);
    }
    let half = half_extent(posted);
    if along < half || along > wall.length() - half { Err(OffWall::PastTheEnd) } else { Ok(()) }
}

/// Distance between the barcodes of two landmarks of one plane that look the same way, in metres, negative where they
/// overlap; none for landmarks of different planes.
pub(crate) fn gap(one: &Posted, other: &Posted) -> Option<f64> {
    let (a, b) = (&one.landmark_in_world, &other.landmark_in_world);
    let seen = a.inverse().place(&Point::new(b.x(), b.y()));
    let same_plane = seen.x.abs() <= 2.0 * OFF_WALL && wrap(a.theta() - b.theta()).abs() <= 2.0 * ASKEW;
    same_plane.then(|| seen.y.abs() - one.landmark.half_width() - other.landmark.half_width())
}

/// Whether one landmark's barcode reaches into the other's barcode or quiet zone (SITE-7, LAND-5).
pub(crate) fn overlap(one: &Posted, other: &Posted) -> bool {
    let quiet = QUIET_ZONE_STRIPES * one.landmark.stripe_width.max(other.landmark.stripe_width);
    gap(one, other).is_some_and(|gap| gap < quiet)
}
