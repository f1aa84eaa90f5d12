//! The inverse question: how large a landmark must be.

use super::{Area, AreaRefusal, check};
use crate::camera::Camera;
use crate::landmark::{Format, Landmark, STRIPE_WIDTHS};
use crate::range::scan_line_depth;
use core::fmt;

/// A landmark's dimensions, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimensions {
    /// `X_dim`.
    pub stripe_width: f64,
    /// Height of one layer.
    pub stripe_height: f64,
}

/// Why no landmark of the format reaches that far (AREA-7, AREA-8).
//= reference/SPEC.md#area
//# - **AREA-7** A range for which there are no such dimensions MUST be refused by the name of what stands against it:
//# (3) and (4), (5), (6) or LAND-7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NotWithThisCamera {
    /// The question has no meaning.
    Asked(AreaRefusal),
    /// (5): at this inclination the far stripe is narrower than `L_min`, whatever the size and the distance.
    StripeWidth,
    /// LAND-7: the stripes would have to be wider than 20 mm.
    Format {
        /// How wide, metres.
        stripe_width: f64,
    },
    /// (3), (4): the barcode would not fit into the field of view.
    FieldOfView {
        /// From which distance on it would fit, metres; infinity if from none.
        nearest: f64,
    },
    /// (6): a scan line does not lie on its layer's side of the axis, whatever the layer's height.
    ScanLineInclination,
}

impl fmt::Display for NotWithThisCamera {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked(refusal) => refusal.fmt(f),
            Self::StripeWidth => f.write_str("by (5) no stripe is wide enough at this inclination, whatever its size"),
            Self::Format { stripe_width } => {
                write!(f, "by (5) it takes stripes of {:.1} mm, and LAND-7 allows 20 mm", 1e3 * stripe_width)
            }
            Self::FieldOfView { nearest } if nearest.is_finite() => {
                write!(f, "by (3) and (4) the barcode is not whole in view nearer than {:.1} cm", 100.0 * nearest)
            }
            Self::FieldOfView { .. } => f.write_str("by (3) and (4) the barcode is nowhere whole in view"),
            Self::ScanLineInclination => f.write_str("by (6) a scan line sees the other layer, whatever its height"),
        }
    }
}

impl core::error::Error for NotWithThisCamera {}

impl From<AreaRefusal> for NotWithThisCamera {
    fn from(refusal: AreaRefusal) -> Self {
        Self::Asked(refusal)
    }
}

/// The smallest stripe width and height with which a camera that looks at the barcode's centre reads it from `reach`
/// metres away at an inclination in radians, for a narrowest stripe `L_min` in pixels (AREA-6 to AREA-8).
//= reference/SPEC.md#area
//# - **AREA-6** The dimensions required for a range at an inclination MUST be the smallest `X_dim` of LAND-7 and the
//# smallest stripe height for which a camera that looks at the barcode's centre from there stands in the detection
//# area.
pub fn required(
    camera: &Camera,
    format: Format,
    reach: f64,
    inclination: f64,
    min_stripe_pixels: f64,
) -> Result<Dimensions, NotWithThisCamera> {
    check(inclination, min_stripe_pixels)?;
    if !(reach.is_finite() && reach > 0.0) {
        return Err(AreaRefusal::Reach.into());
    }
    let stripe_width = smallest_stripe(camera, format, reach, inclination, min_stripe_pixels)?;
    let landmark = Landmark { format, stripe_width, stripe_height: 1.0 };
    let nearest = Area::new(camera, &landmark, inclination, min_stripe_pixels)?.bounds(inclination).field_of_view;
    if nearest > reach {
        return Err(NotWithThisCamera::FieldOfView { nearest });
    }
    // (6) is linear in the height: a layer of 1 m is left at this depth.
    let depth_of_a_metre = scan_line_depth(camera, &landmark);
    if depth_of_a_metre > 0.0 {
        let deepest = reach + landmark.half_width() * inclination.sin().abs();
        Ok(Dimensions { stripe_width, stripe_height: deepest / depth_of_a_metre })
    } else {
        Err(NotWithThisCamera::ScanLineInclination)
    }
}

/// The smallest `X_dim` that (5) and LAND-7 allow, metres.
///
/// (5) is homogeneous in distance and width: `κ = X_dim/d` is the smaller root of `a κ² - p κ + 1 = 0` with
/// `a = sin² θ N (N - 2)/4` and `p = f cos θ/L_min - |sin θ| (N - 1)`. LAND-7's smallest width lies beyond the larger
/// root only where the barcode reaches behind the camera, which the field of view then refuses.
fn smallest_stripe(
    camera: &Camera,
    format: Format,
    reach: f64,
    inclination: f64,
    min_stripe_pixels: f64,
) -> Result<f64, NotWithThisCamera> {
    let (stripes, sine) = (format.stripes() as f64, inclination.sin().abs());
    let sum = camera.focal_length * inclination.cos() / min_stripe_pixels - sine * (stripes - 1.0);
    let discriminant = sum * sum - sine * sine * stripes * (stripes - 2.0);
    if sum <= 0.0 || discriminant < 0.0 {
        return Err(NotWithThisCamera::StripeWidth);
    }
    // The smaller root as one over a times the larger one, which subtracts nothing.
    let stripe_width = reach / f64::midpoint(sum, discriminant.sqrt());
    if stripe_width > *STRIPE_WIDTHS.end() {
        Err(NotWithThisCamera::Format { stripe_width })
    } else {
        Ok(stripe_width.max(*STRIPE_WIDTHS.start()))
    }
}
