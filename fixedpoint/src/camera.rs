//! The pinhole scan-line camera: what the detector has to know of it.

use crate::formats::{Column, FocalLength};
use crate::refusal::CameraRefusal;

/// The most pixels of a scan line (`CAM-7`).
pub const MAX_WIDTH: u16 = 640;

/// A camera. Pixel `i` covers the columns from `i - 1/2` to `i + 1/2` (`CAM-1`).
///
/// The vertical focal length and the rows of the scan lines (`CAM-5`) concern whoever takes or draws the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Camera {
    width: u16,
    principal_column: Column,
    focal_length: FocalLength,
}

impl Camera {
    /// A camera of `width` pixels (`CAM-7`).
    ///
    /// # Errors
    /// Unless the width is in 32 to 640 px, the focal length in `width/2` to 2048 px and the principal column in 0 to
    /// `width - 1`.
    //= reference/SPEC.md#cam
    //# - **CAM-7** A camera whose width is outside 32 to 640 px, whose focal length is outside `Q_x/2` to 2048 px,
    //# whose vertical focal length is outside 1 to 2048 px, whose principal column is outside 0 to `Q_x - 1`, whose
    //# height is outside 2 to 4096 rows, or whose scan lines are not two rows of the image, the upper above the lower,
    //# MUST be refused.
    pub fn new(width: u16, principal_column: Column, focal_length: FocalLength) -> Result<Self, CameraRefusal> {
        if !(32..=MAX_WIDTH).contains(&width) {
            return Err(CameraRefusal::Width);
        }
        // Whole numbers up to 2048 compare exactly with every format.
        if focal_length < FocalLength::from_num(width) / 2 || focal_length > 2048_u16 {
            return Err(CameraRefusal::FocalLength);
        }
        if principal_column < 0_u16 || principal_column > width.saturating_sub(1) {
            return Err(CameraRefusal::PrincipalColumn);
        }
        Ok(Self { width, principal_column, focal_length })
    }

    /// The preset `epuck`: 480 px, focal length 640 px, principal column 239.5 (`CAM-6`).
    #[must_use]
    pub const fn epuck() -> Self {
        Self {
            width: 480,
            principal_column: Column::from_bits(479 << 19),
            focal_length: FocalLength::from_bits(640 << 16),
        }
    }

    /// The number of pixels of a scan line, 32 to 640.
    #[must_use]
    pub const fn width(&self) -> u16 {
        self.width
    }

    /// The principal column `o_x` in px, 0 to `width - 1`.
    #[must_use]
    pub const fn principal_column(&self) -> Column {
        self.principal_column
    }

    /// The horizontal focal length `f` in px, `width/2` to 2048.
    #[must_use]
    pub const fn focal_length(&self) -> FocalLength {
        self.focal_length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(width: u16, column: f64, focal_length: f64) -> Result<Camera, CameraRefusal> {
        Camera::new(width, Column::from_num(column), FocalLength::from_num(focal_length))
    }

    #[test]
    fn the_preset_is_a_camera() {
        assert_eq!(camera(480, 239.5, 640.0), Ok(Camera::epuck()));
    }

    //= reference/SPEC.md#cam
    //= type=test
    //# - **CAM-7** A camera whose width is outside 32 to 640 px, whose focal length is outside `Q_x/2` to 2048 px,
    //# whose vertical focal length is outside 1 to 2048 px, whose principal column is outside 0 to `Q_x - 1`, whose
    //# height is outside 2 to 4096 rows, or whose scan lines are not two rows of the image, the upper above the lower,
    //# MUST be refused.
    #[test]
    fn the_domain_of_cam_7_is_kept() {
        assert_eq!(camera(31, 15.0, 640.0), Err(CameraRefusal::Width));
        assert!(camera(32, 0.0, 16.0).is_ok());
        assert!(camera(640, 639.0, 2048.0).is_ok());
        assert_eq!(camera(641, 320.0, 640.0), Err(CameraRefusal::Width));
        assert_eq!(camera(481, 240.0, 240.25), Err(CameraRefusal::FocalLength));
        assert!(camera(481, 240.0, 240.5).is_ok());
        assert_eq!(camera(480, 239.5, 2048.5), Err(CameraRefusal::FocalLength));
        assert_eq!(camera(480, -0.5, 640.0), Err(CameraRefusal::PrincipalColumn));
        assert_eq!(camera(480, 479.5, 640.0), Err(CameraRefusal::PrincipalColumn));
    }
}
