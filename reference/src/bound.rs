//! How well a pose can be known: the Cramer-Rao bound of a view (BOUND).

use crate::camera::Camera;
use crate::covariance::{UncertainPose, jacobian, transform};
use crate::fit::{Imaging, inks};
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::render::Light;
use nalgebra::{Matrix3, SMatrix, SVector};

/// The `(a, s, k)` of a view (CAM-2), columns relative to the principal one; `None` if the barcode is not in front.
#[must_use]
pub fn homography_of(
    camera: &Camera,
    landmark: &Landmark,
    camera_in_landmark: &Pose<frame::Landmark, frame::Camera>,
) -> Option<Homography> {
    let w = landmark.half_width();
    let centre = camera.project_stripe(camera_in_landmark, 0.0);
    let right = camera.project_stripe(camera_in_landmark, w);
    let left = camera.project_stripe(camera_in_landmark, -w);
    if centre.depth <= 0.0 || right.depth <= 0.0 || left.depth <= 0.0 {
        return None;
    }
    // Depth is linear along the barcode, and column times depth too.
    let k = right.depth / centre.depth - 1.0;
    let a = centre.column - camera.principal_column;
    let s = (right.column - camera.principal_column) * (1.0 + k) - a;
    Some(Homography { a, s, k })
}

/// What two scan lines can say about a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// On the covariance of `(a, s, k)` (BOUND-1).
    pub image: Matrix3<f64>,
    /// On the covariance of `(x, y, θ)`, linearly (BOUND-2).
    pub pose: Matrix3<f64>,
    /// The same through the bend (BOUND-3).
    pub bent: UncertainPose,
}

/// The bound of a view of `layers` stripes, upper first, whose rows lie wholly inside the layers, in even light.
///
/// `blur` in pixels and `noise` in grey levels are the standard deviations of RENDER-2 and RENDER-5. `None` if the barcode
/// is not in front of the camera and in its line, or if the stripes do not determine a homography.
#[must_use]
pub fn bound(
    camera: &Camera,
    landmark: &Landmark,
    camera_in_landmark: &Pose<frame::Landmark, frame::Camera>,
    layers: &[Vec<bool>; 2],
    light: &Light,
    (blur, noise): (f64, f64),
) -> Option<Bound> {
    let homography = homography_of(camera, landmark, camera_in_landmark)?;
    let imaging = Imaging { homography, blur };
    let mut information = SMatrix::<f64, 7, 7>::zeros();
    let gain = light.exposure * (light.black - light.white);
    for (layer, stripes) in layers.iter().enumerate() {
        let window = (0, camera.width - 1);
        for ink in inks(&imaging, camera, landmark.format, stripes, window) {
            let mut row = SVector::<f64, 7>::zeros();
            row.fixed_rows_mut::<3>(0).copy_from(&(ink.gradient.fixed_rows::<3>(0) * gain));
            row[3 + 2 * layer] = 1.0;
            row[4 + 2 * layer] = ink.ink;
            information += row * row.transpose();
        }
    }
    // Rounding to whole grey levels is noise of a twelfth.
    let image = information.try_inverse()?.fixed_view::<3, 3>(0, 0) * (noise * noise + 1.0 / 12.0);
    let j = jacobian(&homography, camera, landmark);
    let bent = transform(&homography, &image, camera, landmark);
    Some(Bound { image, pose: j * image * j.transpose(), bent })
}
