//! The table of what "the same" means, stage by stage (SAME).
//!
//! Bounds are derived from the port's rounding errors, one term per operation, as its documentation lists them; none is
//! fitted to what was seen. `tests/bounds.rs` fails where one is more than four times looser than anything seen in a
//! campaign, or more than 5 % of the standard deviation of what it bounds. The reference's declared error is no bound of
//! that kind: it is how near to a boundary its decisions are not trusted, a worst case of float64 that is not met.

use crate::port::{Cameras, stripe_width_error};
use crate::trace::{HomographyTrace, PoseTrace};
use core::f64::consts::PI;
use reference::landmark::Landmark;
pub use reference::sampling::DECLARED_ERROR;
use serde::Serialize;

/// How a stage's results are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Identical (SAME-1).
    Exact,
    /// Differ by no more than the bound (SAME-2).
    Bounded,
    /// Decisions: identical unless the reference's own margin is below the bound (SAME-3).
    Marginal,
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Darkest and brightest value.
    Threshold,
    /// Regions, and refused lines.
    Regions,
    /// ROIs and their checks.
    Hypotheses,
    /// Edges and columns of all transitions used.
    Crossings,
    /// Stripe middles, the regions they fall in, and the refusals that follow.
    Sampling,
    /// `a` of a layer.
    Centre,
    /// `s` of a layer.
    HalfWidth,
    /// `k` of a layer.
    Obliquity,
    /// Half words.
    Decode,
    /// Pairs, payloads, refusals, detections and their order.
    Merge,
    /// x of the camera in the landmark's frame.
    PoseX,
    /// y of the camera in the landmark's frame.
    PoseY,
    /// Heading of the camera in the landmark's frame.
    PoseTheta,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// What is compared.
    pub stage: Stage,
    /// Its name in tables and certificates.
    pub name: &'static str,
    /// How it is compared.
    pub class: Class,
    /// Unit of difference and bound.
    pub unit: &'static str,
    /// Where the bound comes from.
    pub origin: &'static str,
}

const fn row(stage: Stage, name: &'static str, class: Class, unit: &'static str, origin: &'static str) -> Row {
    Row { stage, name, class, unit, origin }
}

/// The table, in the order of the stages.
pub const TABLE: [Row; 13] = [
    row(Stage::Threshold, "threshold", Class::Exact, "", "integers in both pipelines"),
    row(Stage::Regions, "regions", Class::Exact, "", "integers in both pipelines"),
    row(Stage::Hypotheses, "hypotheses", Class::Exact, "", "integers in both pipelines"),
    row(Stage::Crossings, "crossings", Class::Exact, "", "integers in both pipelines (CROSS-1)"),
    row(Stage::Sampling, "sampling", Class::Marginal, "px", "float64 rounding in the reference; the port is exact"),
    row(Stage::Centre, "homography.centre", Class::Bounded, "px", "rounding of A/D; camera"),
    row(
        Stage::HalfWidth,
        "homography.half_width",
        Class::Bounded,
        "px",
        "rounding of S/D, of k times the shift; camera",
    ),
    row(Stage::Obliquity, "homography.obliquity", Class::Bounded, "1", "rounding of K/D"),
    row(Stage::Decode, "decode", Class::Exact, "", "follows from sampling"),
    row(Stage::Merge, "merge", Class::Exact, "", "follows from decode"),
    row(
        Stage::PoseX,
        "pose.x",
        Class::Bounded,
        "m",
        "homography's bounds through (9), rounding of quotient and product",
    ),
    row(
        Stage::PoseY,
        "pose.y",
        Class::Bounded,
        "m",
        "homography's bounds through (9), rounding of quotient and product",
    ),
    row(Stage::PoseTheta, "pose.theta", Class::Bounded, "rad", "homography's bounds through (9), CORDIC"),
];

impl Stage {
    /// Its row of the table.
    ///
    /// # Panics
    /// Never: a test looks up every stage.
    #[must_use]
    pub fn row(self) -> &'static Row {
        TABLE.iter().find(|row| row.stage == self).expect("the table has a row for every stage")
    }
}

/// 2 to the power of `-bits`.
fn ulp(bits: i32) -> f64 {
    2.0_f64.powi(-bits)
}

/// Bounds on a layer's reported homography, whose ROI's middle is `shift` px from the principal column.
///
/// The port has `a`, `s` and `k` as exact ratios of integers and rounds each once: `a` to 2^-20 px; `k` to 2^-30; `s` to
/// 2^-30 px, to which `shift k` is added before it is rounded to 2^-20 px. Half a unit each. The camera's principal
/// column is off by what its conversion lost. The reference's own rounding is its declared error.
#[must_use]
pub fn homography(cameras: &Cameras, shift: f64, k: f64) -> HomographyTrace {
    let column = cameras.configuration_error().principal_column;
    let obliquity = ulp(31);
    HomographyTrace {
        a: ulp(21) + column + DECLARED_ERROR,
        s: ulp(21) + ulp(31) + shift.abs() * obliquity + k.abs() * column + DECLARED_ERROR,
        k: obliquity + DECLARED_ERROR * 2.0 / cameras.reference.width as f64,
    }
}

/// Bounds on a merged homography from those of its layers: the port rounds the mean once, to the next integer up.
#[must_use]
pub fn merged(upper: &HomographyTrace, lower: &HomographyTrace) -> HomographyTrace {
    HomographyTrace {
        a: f64::midpoint(upper.a, lower.a) + ulp(21),
        s: f64::midpoint(upper.s, lower.s) + ulp(21),
        k: f64::midpoint(upper.k, lower.k) + ulp(31),
    }
}

/// Bounds on the pose of a homography known to within `error`.
///
/// With `m = f k`, `g = s - a k` and `ρ² = s² + m²`, in half widths `X = f g/ρ²` and `Y = -(f m + a s)/ρ²`, and
/// `θ = atan2(m, -s)`. First-order propagation, each term by its absolute value; what is left out is smaller by the
/// relative error of s, below 2^-16. The port rounds `m` and `g` to 2^-20 px, `X` and `Y` to 2^-24 and the products with
/// the half width to 2^-24 m; its arctangent is good to 0.55 · 2^-31 π.
#[must_use]
pub fn pose(cameras: &Cameras, landmark: &Landmark, h: &HomographyTrace, error: &HomographyTrace) -> PoseTrace {
    let f = cameras.reference.focal_length;
    let f_error = cameras.configuration_error().focal_length;
    let w = landmark.half_width();
    let w_error = stripe_width_error(landmark) * landmark.format.stripes() as f64 / 2.0;
    let (m, g) = (f * h.k, h.s - h.a * h.k);
    let rho2 = h.s * h.s + m * m;
    let m_propagated = f * error.k + h.k.abs() * f_error;
    let m_error = m_propagated + ulp(21);
    let g_error = error.s + h.a.abs() * error.k + h.k.abs() * error.a + ulp(21);
    let rho2_error = 2.0 * h.s.abs() * error.s + 2.0 * m.abs() * m_error;
    let x = f * g / rho2;
    let y = (f * m + h.a * h.s) / rho2;
    let x_error = (f * g_error + g.abs() * f_error + x.abs() * rho2_error) / rho2 + ulp(25);
    let y_error = (f * m_error + m.abs() * f_error + h.a.abs() * error.s + h.s.abs() * error.a + y.abs() * rho2_error)
        / rho2
        + ulp(25);
    PoseTrace {
        x: w * x_error + w_error * x.abs() + ulp(25),
        y: w * y_error + w_error * y.abs() + ulp(25),
        theta: (h.s.abs() * m_propagated + m.abs() * error.s) / rho2 + 0.55 * PI * ulp(31),
    }
}

/// Bounds on the pose of a detection, whose layers have about its own homography.
///
/// A layer's shift, the ROI's middle less the principal column, follows from it: the barcode's ends are imaged at the ROI's
/// ends `m ± e/2`, `(a ± s)/(1 ± k)`, so `m = (a - s k)/(1 - k²)`. The transitions' residuals move it by less than a pixel.
#[must_use]
pub fn pose_of_detection(cameras: &Cameras, landmark: &Landmark, h: &HomographyTrace) -> PoseTrace {
    let shift = (h.a - h.s * h.k).abs() / (1.0 - h.k * h.k) + 1.0;
    let layer = homography(cameras, shift, h.k);
    pose(cameras, landmark, h, &merged(&layer, &layer))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_has_one_row() {
        for row in &TABLE {
            assert_eq!(TABLE.iter().filter(|other| other.stage == row.stage).count(), 1, "{}", row.name);
            assert_eq!(row.stage.row().name, row.name);
        }
    }
}
