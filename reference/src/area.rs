//! Detection area: where a camera may stand to read a landmark, the paper's design framework (3) to (6) (AREA).
//!
//! Lengths are metres in the landmark frame L, angles radians. The camera has the heading `π + inclination`, so an
//! inclination of 0 looks along the wall's normal wherever the camera stands. Cameras are those that CAM-7 allows,
//! landmarks those that LAND-7 allows.

mod outline;
mod required;
#[cfg(test)]
mod tests;

pub use required::{Dimensions, NotWithThisCamera, required};

use crate::camera::Camera;
use crate::landmark::Landmark;
use crate::range::{scan_line_depth, scan_line_range, stripe_width_range_along};
use core::f64::consts::FRAC_PI_2;
use core::fmt;

/// Inclinations that AREA-8 allows, radians.
pub const INCLINATIONS: core::ops::RangeInclusive<f64> = -FRAC_PI_2..=FRAC_PI_2;

/// Narrowest stripes `L_min` that AREA-8 allows, pixels.
pub const MIN_STRIPES: core::ops::RangeInclusive<f64> = 0.1..=100.0;

/// What bounds a detection area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limit {
    /// Every edge in the field of view, (3) and (4).
    FieldOfView,
    /// The narrowest stripe, (5).
    StripeWidth,
    /// Scan lines that leave their layers, (6).
    ScanLineInclination,
}

/// Why a question has no meaning (AREA-8).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaRefusal {
    /// The inclination is not a number from -π/2 to π/2.
    Inclination,
    /// `L_min` is not a number from 0.1 to 100 px.
    MinStripe,
    /// The range that is asked for is not a positive number.
    Reach,
}

impl fmt::Display for AreaRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Inclination => "the inclination must be from -90 to 90 degrees",
            Self::MinStripe => "the narrowest stripe must be from 0.1 to 100 px",
            Self::Reach => "the range must be a positive number of metres",
        })
    }
}

impl core::error::Error for AreaRefusal {}

/// AREA-8, written so that NaN is refused.
//= reference/SPEC.md#area
//# - **AREA-8** An inclination outside ±90°, an `L_min` outside 0.1 to 100 px and a range that is not a positive number
//# MUST be refused.
fn check(inclination: f64, min_stripe_pixels: f64) -> Result<(), AreaRefusal> {
    if !INCLINATIONS.contains(&inclination) {
        Err(AreaRefusal::Inclination)
    } else if MIN_STRIPES.contains(&min_stripe_pixels) {
        Ok(())
    } else {
        Err(AreaRefusal::MinStripe)
    }
}

/// What bounds the distance from the barcode's centre along one direction, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// (3), (4): every edge is in the field of view from here on; infinity if it never is.
    pub field_of_view: f64,
    /// (5): no stripe is narrower than `L_min` up to here; 0 if there is no such distance.
    pub stripe_width: f64,
    /// (6): the scan lines see nothing but their layers up to here; not above 0 if they never do.
    pub scan_line: f64,
}

impl Bounds {
    /// The smaller one of (5) and (6), 0 if one of them leaves nothing, and which one it is.
    #[must_use]
    pub fn farthest(&self) -> Range {
        let (distance, limit) = if self.stripe_width <= self.scan_line {
            (self.stripe_width, Limit::StripeWidth)
        } else {
            (self.scan_line, Limit::ScanLineInclination)
        };
        Range { distance: distance.max(0.0), limit }
    }

    /// The largest distance within the area (AREA-5); 0 if there is none, limited by what leaves none.
    #[must_use]
    pub fn range(&self) -> Range {
        let farthest = self.farthest();
        if farthest.distance <= 0.0 || self.field_of_view <= farthest.distance {
            farthest
        } else {
            Range { distance: 0.0, limit: Limit::FieldOfView }
        }
    }
}

/// A largest distance and what bounds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Distance from the barcode's centre, metres.
    pub distance: f64,
    /// The bound.
    pub limit: Limit,
}

/// The places from which a camera of one inclination reads a landmark (AREA-1): a convex set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    camera: Camera,
    landmark: Landmark,
    inclination: f64,
    min_stripe_pixels: f64,
    sine: f64,
    cosine: f64,
}

impl Area {
    /// The detection area at an inclination in radians for a narrowest stripe `L_min` in pixels (AREA-1, AREA-8).
    pub fn new(
        camera: &Camera,
        landmark: &Landmark,
        inclination: f64,
        min_stripe_pixels: f64,
    ) -> Result<Self, AreaRefusal> {
        check(inclination, min_stripe_pixels)?;
        let (sine, cosine) = inclination.sin_cos();
        Ok(Self { camera: *camera, landmark: *landmark, inclination, min_stripe_pixels, sine, cosine })
    }

    /// The inclination, radians.
    #[must_use]
    pub fn inclination(&self) -> f64 {
        self.inclination
    }

    /// Whether a camera at (`x`, `y`) in L, metres, reads the landmark (AREA-1 to AREA-4).
    //= reference/SPEC.md#area
    //# - **AREA-1** The detection area of a camera, a landmark, an inclination θ and an `L_min` MUST be the places `(x,
    //# y)` with `x > 0` and `D(b_k) > 0`, k = 0..N, that meet AREA-2 to AREA-4, their boundaries included.
    #[must_use]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        let place = self.seen_from(x, y);
        let (right, left) = self.lateral_bounds(place.depth);
        x > 0.0
            && place.depth > self.far_end()
            && place.depth <= self.greatest_depth()
            && (right..=left).contains(&place.lateral)
            && self.narrowness(&place) <= 0.0
    }

    /// What bounds the distance along a direction, in radians from the wall's normal towards y (AREA-5).
    #[must_use]
    pub fn bounds(&self, direction: f64) -> Bounds {
        let foreshortening = (direction - self.inclination).cos();
        let scan_line = scan_line_range(&self.camera, &self.landmark, self.inclination);
        Bounds {
            field_of_view: self.in_view_from(direction),
            stripe_width: stripe_width_range_along(
                &self.camera,
                &self.landmark,
                self.inclination,
                direction,
                self.min_stripe_pixels,
            ),
            scan_line: if foreshortening > 0.0 { scan_line / foreshortening } else { 0.0 },
        }
    }

    /// The largest distance within the area from the barcode's centre along a direction, in radians from the wall's
    /// normal towards y (AREA-5).
    //= reference/SPEC.md#area
    //# - **AREA-5** The range along a direction MUST be the largest distance from the barcode's centre within the area,
    //# and name the equation that bounds it.
    #[must_use]
    pub fn range(&self, direction: f64) -> Range {
        self.bounds(direction).range()
    }

    /// The distance along a direction from which on every edge is in the field of view; infinity if it never is.
    ///
    /// With `ψ = φ - θ` the edge `b` at the distance `d` has the depth `d cos ψ - b sin θ` and lies `b cos θ - d sin ψ`
    /// to the right of the axis, which makes AREA-2 linear in `d`. Depths need no test of their own: an end behind the
    /// camera, with both ends within these lines, would put the camera behind the wall.
    fn in_view_from(&self, direction: f64) -> f64 {
        let (turned_sine, turned_cosine) = (direction - self.inclination).sin_cos();
        let (left, right) = self.field_of_view();
        let half = self.landmark.half_width();
        // How fast the right end comes in from the right with the distance, and the left end from the left.
        let (from_right, from_left) = (turned_sine + right * turned_cosine, -turned_sine - left * turned_cosine);
        let ahead = direction.cos() > 0.0 && turned_cosine > 0.0;
        if !(ahead && from_right > 0.0 && from_left > 0.0) {
            return f64::INFINITY;
        }
        let right_end = half * (self.cosine + right * self.sine) / from_right;
        let left_end = half * (self.cosine + left * self.sine) / from_left;
        right_end.max(left_end)
    }

    /// The tangents of the field of view's left and right end, the first negative, the second positive (CAM-1).
    fn field_of_view(&self) -> (f64, f64) {
        let tangent = |column: f64| (column - self.camera.principal_column) / self.camera.focal_length;
        (tangent(-0.5), tangent(self.camera.width as f64 - 0.5))
    }

    /// How much deeper than the barcode's centre its deepest edge is, metres.
    fn far_end(&self) -> f64 {
        self.landmark.half_width() * self.sine.abs()
    }

    /// The greatest depth of the barcode's centre that AREA-4 allows, metres.
    //= reference/SPEC.md#area
    //# - **AREA-4** The deepest edge MUST NOT be deeper than both scan lines see nothing but stripes, `u + N X_dim |sin
    //# θ|/2 <= h f_y/(2 q)` with RANGE-2's `h` and `q` (6), and the area be empty if a scan line does not lie on its
    //# own layer's side of the axis.
    fn greatest_depth(&self) -> f64 {
        scan_line_depth(&self.camera, &self.landmark) - self.far_end()
    }

    /// AREA-2: between which lateral places the whole barcode is in view, given the depth of its centre.
    ///
    /// With `v` the lateral place the edge `b` lies `b cos θ - v` to the right of the axis.
    //= reference/SPEC.md#area
    //# - **AREA-2** Every edge MUST be in the horizontal field of view, `-1/2 <= o_x + f r(b_k)/D(b_k) <= Q_x - 1/2`
    //# for k = 0 and k = N (3), (4).
    fn lateral_bounds(&self, depth: f64) -> (f64, f64) {
        let (left, right) = self.field_of_view();
        let half = self.landmark.half_width();
        let lowest = half * self.cosine - right * (depth - half * self.sine);
        let highest = -half * self.cosine - left * (depth + half * self.sine);
        (lowest, highest)
    }

    /// `f X_dim/L_min`, metres: the distance at which a stripe is `L_min` wide at 0°.
    fn magnification(&self) -> f64 {
        self.camera.focal_length * self.landmark.stripe_width / self.min_stripe_pixels
    }

    /// AREA-3 as a function that is at most 0 where no stripe is narrower than `L_min`, m².
    //= reference/SPEC.md#area
    //# - **AREA-3** The narrowest stripe MUST be at least `L_min` wide, `(u + N X_dim |sin θ|/2)(u + (N - 2) X_dim |sin
    //# θ|/2) <= f X_dim x/L_min` (5) (ERRATA-2).
    fn narrowness(&self, place: &Place) -> f64 {
        let outer = self.far_end();
        let inner = outer - self.landmark.stripe_width * self.sine.abs();
        let from_wall = place.depth * self.cosine - place.lateral * self.sine;
        (place.depth + outer) * (place.depth + inner) - self.magnification() * from_wall
    }

    /// A place of L in terms of the camera's axis.
    fn seen_from(&self, x: f64, y: f64) -> Place {
        Place { depth: x * self.cosine + y * self.sine, lateral: y * self.cosine - x * self.sine }
    }
}

/// A place of the camera: L turned by the inclination.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    /// Depth of the barcode's centre, `u = x cos θ + y sin θ`, metres.
    depth: f64,
    /// To the left of where the camera would look straight at the centre: `v = y cos θ - x sin θ`, metres.
    lateral: f64,
}
