//! The pinhole scan-line camera and projection (1), (2) (CAM).

use crate::frame::{self, Point, Pose};
use core::fmt;

/// A camera that reads two of its rows. Column `i` is the middle of pixel `i` (CAM-1).
//= reference/SPEC.md#cam
//# - **CAM-1** Pixel `i` MUST cover the columns from `i - 1/2` to `i + 1/2`, with `i` growing from left to right as the
//# robot sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// `Q_x`, pixels.
    pub width: usize,
    /// `Q_y`, rows.
    pub height: usize,
    /// Horizontal focal length `f`, pixels.
    pub focal_length: f64,
    /// Vertical focal length, rows.
    pub focal_length_vertical: f64,
    /// Principal column `o_x`, pixels (CAM-6).
    pub principal_column: f64,
    /// Row of the upper scan line (CAM-5).
    pub upper_row: usize,
    /// Row of the lower scan line (CAM-5).
    pub lower_row: usize,
}

/// Why a description is no camera (CAM-7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraRefusal {
    /// `Q_x` outside 32 to 640 px.
    Width,
    /// `Q_y` outside 2 to 4096 rows.
    Height,
    /// `f` not a number from `Q_x/2` to 2048 px.
    FocalLength,
    /// The vertical focal length is not a number from 1 to 2048 px.
    FocalLengthVertical,
    /// `o_x` not a number from 0 to `Q_x - 1`.
    PrincipalColumn,
    /// The scan lines are not two rows of the image, the upper one above the lower.
    Rows,
}

impl fmt::Display for CameraRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Width => "the width must be from 32 to 640 px",
            Self::Height => "the height must be from 2 to 4096 rows",
            Self::FocalLength => "the focal length must be from half the width to 2048 px",
            Self::FocalLengthVertical => "the vertical focal length must be from 1 to 2048 px",
            Self::PrincipalColumn => "the principal column must lie in the image",
            Self::Rows => "the scan lines must be two rows of the image, the upper one above the lower",
        })
    }
}

impl core::error::Error for CameraRefusal {}

/// Where a point lies as a camera sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Column; only meaningful where the depth is positive.
    pub column: f64,
    /// Distance along the optical axis, metres.
    pub depth: f64,
}

impl Camera {
    /// The e-puck's camera: 480 x 8 pixels, f = 640 px horizontally and 80 px vertically, first and last row.
    //= reference/SPEC.md#cam
    //# - **CAM-5** The scan lines MUST be the rows that the camera's description names, by default the first (upper
    //# layer) and the last (lower layer).
    //= reference/SPEC.md#cam
    //# - **CAM-6** The principal column MUST default to `(Q_x - 1)/2`.
    #[must_use]
    pub fn epuck() -> Self {
        Self {
            width: 480,
            height: 8,
            focal_length: 640.0,
            focal_length_vertical: 80.0,
            principal_column: 239.5,
            upper_row: 0,
            lower_row: 7,
        }
    }

    /// The camera itself if CAM-7 allows it.
    //= reference/SPEC.md#cam
    //# - **CAM-7** A camera whose width is outside 32 to 640 px, whose focal length is outside `Q_x/2` to 2048 px,
    //# whose vertical focal length is outside 1 to 2048 px, whose principal column is outside 0 to `Q_x - 1`, whose
    //# height is outside 2 to 4096 rows, or whose scan lines are not two rows of the image, the upper above the lower,
    //# MUST be refused.
    pub fn checked(self) -> Result<Self, CameraRefusal> {
        let width = self.width as f64;
        // Written so that NaN fails each test.
        let tests = [
            ((32..=640).contains(&self.width), CameraRefusal::Width),
            ((2..=4096).contains(&self.height), CameraRefusal::Height),
            ((width / 2.0..=2048.0).contains(&self.focal_length), CameraRefusal::FocalLength),
            ((1.0..=2048.0).contains(&self.focal_length_vertical), CameraRefusal::FocalLengthVertical),
            ((0.0..=width - 1.0).contains(&self.principal_column), CameraRefusal::PrincipalColumn),
            (self.upper_row < self.lower_row && self.lower_row < self.height, CameraRefusal::Rows),
        ];
        match tests.iter().find(|(holds, _)| !holds) {
            Some((_, refusal)) => Err(*refusal),
            None => Ok(self),
        }
    }

    /// Where the camera sees a point of its own frame (CAM-2).
    //= reference/SPEC.md#cam
    //# - **CAM-2** A point at depth `D` (along the optical axis) and offset `r` to the right of it MUST project to the
    //# column `o_x + f r / D`.
    #[must_use]
    pub fn project(&self, point: &Point<frame::Camera>) -> Sight {
        // y points left and columns grow to the right.
        Sight { column: self.principal_column - self.focal_length * point.y / point.x, depth: point.x }
    }

    /// Where the camera at `pose` sees the point `b` of a barcode (CAM-3).
    //= reference/SPEC.md#cam
    //# - **CAM-3** A point `b` of a barcode MUST project to `(Δ - o_x)/f = m (B_2 - b)/(B_1 - b)` with `m = -1/tan θ`
    //# where `sin θ` is not 0 (ERRATA-1).
    //= reference/SPEC.md#errata
    //# - **ERRATA-1** (1) MUST be read with the middle term `cos θ (b - B_2) / (sin θ (B_1 - b))` and columns that grow
    //# to the right.
    #[must_use]
    pub fn project_stripe(&self, pose: &Pose<frame::Landmark, frame::Camera>, b: f64) -> Sight {
        self.project(&pose.inverse().place(&Point::new(0.0, b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark::{Format, Landmark};
    use core::f64::consts::PI;
    use proptest::prelude::*;

    //= reference/SPEC.md#cam
    //= type=test
    //# - **CAM-2** A point at depth `D` (along the optical axis) and offset `r` to the right of it MUST project to the
    //# column `o_x + f r / D`.
    #[test]
    fn frontal_view_has_the_design_magnification() {
        // 30 mm at 0.3 m and f = 640 px are 64 px, centred on 239.5.
        let pose = Pose::new(0.3, 0.0, PI);
        let right = Camera::epuck().project_stripe(&pose, 0.015);
        assert!((right.column - (239.5 + 32.0)).abs() < 1e-9 && (right.depth - 0.3).abs() < 1e-12);
    }

    //= reference/SPEC.md#cam
    //= type=test
    //# - **CAM-7** A camera whose width is outside 32 to 640 px, whose focal length is outside `Q_x/2` to 2048 px,
    //# whose vertical focal length is outside 1 to 2048 px, whose principal column is outside 0 to `Q_x - 1`, whose
    //# height is outside 2 to 4096 rows, or whose scan lines are not two rows of the image, the upper above the lower,
    //# MUST be refused.
    #[test]
    fn nonsense_is_refused_by_name() {
        let epuck = Camera::epuck();
        let refusal = |camera: Camera| camera.checked().unwrap_err();
        assert_eq!(refusal(Camera { width: 31, ..epuck }), CameraRefusal::Width);
        assert_eq!(refusal(Camera { width: 641, ..epuck }), CameraRefusal::Width);
        assert_eq!(refusal(Camera { height: 1, ..epuck }), CameraRefusal::Height);
        assert_eq!(refusal(Camera { focal_length: 0.0, ..epuck }), CameraRefusal::FocalLength);
        assert_eq!(refusal(Camera { focal_length: f64::NAN, ..epuck }), CameraRefusal::FocalLength);
        assert_eq!(
            refusal(Camera { focal_length_vertical: f64::INFINITY, ..epuck }),
            CameraRefusal::FocalLengthVertical
        );
        assert_eq!(refusal(Camera { principal_column: 480.0, ..epuck }), CameraRefusal::PrincipalColumn);
        assert_eq!(refusal(Camera { lower_row: 8, ..epuck }), CameraRefusal::Rows);
        assert_eq!(refusal(Camera { upper_row: 7, lower_row: 7, ..epuck }), CameraRefusal::Rows);
        assert_eq!(epuck.checked(), Ok(epuck));
    }

    proptest! {
        /// The rigid transform and the paper's (1) and (2) are two derivations of the same column and width.
        //= reference/SPEC.md#frame
        //= type=test
        //# - **FRAME-2** The landmark frame L MUST have its origin at the barcode's centre, x out of the wall and y to
        //# the right as a robot sees it that looks at the wall.
        //= reference/SPEC.md#cam
        //= type=test
        //# - **CAM-3** A point `b` of a barcode MUST project to `(Δ - o_x)/f = m (B_2 - b)/(B_1 - b)` with `m = -1/tan
        //# θ` where `sin θ` is not 0 (ERRATA-1).
        //= reference/SPEC.md#cam
        //= type=test
        //# - **CAM-4** The width of stripe k in the image MUST be `L_k = |f X_dim m (B_1 - B_2) / ((B_1 - b_{k-1})(B_1
        //# - b_k))|` where `sin θ` is not 0.
        //= reference/SPEC.md#errata
        //= type=test
        //# - **ERRATA-1** (1) MUST be read with the middle term `cos θ (b - B_2) / (sin θ (B_1 - b))` and columns that
        //# grow to the right.
        #[test]
        fn projection_agrees_with_equations_1_and_2(
            distance in 0.1..0.6f64, inclination in 0.02..1.0f64, side in any::<bool>(), bearing in -0.2..0.2f64,
        ) {
            let camera = Camera::epuck();
            let theta = if side { inclination } else { -inclination };
            let (x, y) = (distance * (theta + bearing).cos(), distance * (theta + bearing).sin());
            let pose = Pose::new(x, y, PI + theta);
            let (m, b1, b2) = (-1.0 / theta.tan(), y + x / theta.tan(), y - x * theta.tan());
            let edges = Landmark::new(Format::Paper).edges();
            for (k, &b) in edges.iter().enumerate() {
                let seen = camera.project_stripe(&pose, b).column;
                let by_1 = camera.principal_column + camera.focal_length * m * (b2 - b) / (b1 - b);
                prop_assert!((seen - by_1).abs() < 1e-7, "edge {k}: {seen} against {by_1}");
                if k > 0 {
                    let by_2 = (camera.focal_length * 1.5e-3 * m * (b1 - b2) / ((b1 - edges[k - 1]) * (b1 - b))).abs();
                    let width = camera.project_stripe(&pose, edges[k - 1]).column - seen;
                    prop_assert!((width - by_2).abs() < 1e-7, "stripe {k}: {width} against {by_2}");
                }
            }
        }
    }
}
