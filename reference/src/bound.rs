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
    //= reference/SPEC.md#bound
    //# - **BOUND-2** The bound on `(x, y, θ)` MUST be that of `(a, s, k)` carried through the derivatives of POSE, its
    //# major and minor axes those of `(x, y)`.
    pub pose: Matrix3<f64>,
    /// The same through the bend (BOUND-3).
    //= reference/SPEC.md#bound
    //# - **BOUND-3** The bound through the bend MUST be that of `(a, s, k)` carried through COV-2 and COV-3.
    pub bent: UncertainPose,
}

/// The bound of a view of `layers` stripes, upper first, whose rows lie wholly inside the layers, in even light.
///
/// `blur` in pixels and `noise` in grey levels are the standard deviations of RENDER-2 and RENDER-5. `None` if the barcode
/// is not in front of the camera and in its line, or if the stripes do not determine a homography.
//= reference/SPEC.md#bound
//# - **BOUND-1** The Cramer-Rao bound on `(a, s, k)` of a view MUST be the inverse of the Fisher information of the two
//# noisy scan lines, noise variance plus 1/12 for rounding, with the offset and the gain of either layer as unknowns
//# and the blur and the code known.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codeword;
    use crate::frame::World;
    use crate::landmark::Format;
    use crate::render::{Posted, Scene, Sensor, render_radiance};
    use core::f64::consts::PI;

    const PAYLOAD: u32 = 0xcc0d;
    const SENSOR: Sensor = Sensor { blur: 0.6, noise: 1.5 };

    /// A landmark whose layers fill both rows.
    fn landmark() -> Landmark {
        Landmark { stripe_height: 0.1, ..Landmark::new(Format::Paper) }
    }

    /// What the forward model says that a camera sees, and what is known of it.
    fn lines([x, y, theta]: [f64; 3]) -> [Vec<f64>; 2] {
        let camera_in_world: Pose<World, frame::Camera> = Pose::new(x, y, theta);
        let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark: landmark(), payload: PAYLOAD };
        let light = Light::default();
        let scene = Scene { camera_in_world, landmarks: vec![posted], clutter: vec![], light, sensor: SENSOR };
        render_radiance(&Camera::epuck(), &scene).unwrap()
    }

    fn bound_at([x, y, theta]: [f64; 3]) -> Bound {
        let layers = codeword::layers(Format::Paper, PAYLOAD).unwrap();
        let (camera, pose) = (Camera::epuck(), Pose::new(x, y, theta));
        bound(&camera, &landmark(), &pose, &layers, &Light::default(), (SENSOR.blur, SENSOR.noise)).unwrap()
    }

    const VIEWS: [[f64; 3]; 3] = [[0.3, 0.0, PI], [0.25, 0.08, PI + 0.5], [0.4, -0.2, PI - 0.3]];

    /// The information that the rendered lines have of the pose itself, by differences, with an offset and a gain of each line:
    /// a line of one offset and gain is a linear function of any other.
    //= reference/SPEC.md#bound
    //= type=test
    //# - **BOUND-1** The Cramer-Rao bound on `(a, s, k)` of a view MUST be the inverse of the Fisher information of the
    //# two noisy scan lines, noise variance plus 1/12 for rounding, with the offset and the gain of either layer as
    //# unknowns and the blur and the code known.
    #[test]
    fn the_bound_is_the_inverse_of_the_information_in_the_rendered_lines() {
        for view in VIEWS {
            let mut information = SMatrix::<f64, 7, 7>::zeros();
            let here = lines(view);
            let by = [0, 1, 2].map(|i| {
                let at = |change: f64| {
                    let mut moved = view;
                    moved[i] += change;
                    lines(moved)
                };
                (at(-1e-6), at(1e-6))
            });
            for (layer, line) in here.iter().enumerate() {
                for (pixel, value) in line.iter().enumerate() {
                    let mut row = SVector::<f64, 7>::zeros();
                    for (i, (low, high)) in by.iter().enumerate() {
                        row[i] = (high[layer][pixel] - low[layer][pixel]) / 2e-6;
                    }
                    (row[3 + 2 * layer], row[4 + 2 * layer]) = (1.0, value / 100.0);
                    information += row * row.transpose();
                }
            }
            let variance = SENSOR.noise * SENSOR.noise + 1.0 / 12.0;
            let expected = information.try_inverse().unwrap().fixed_view::<3, 3>(0, 0) * variance;
            let found = bound_at(view).pose;
            for i in 0..3 {
                for j in 0..3 {
                    let scale = (expected[(i, i)] * expected[(j, j)]).sqrt();
                    assert!((found[(i, j)] - expected[(i, j)]).abs() < 1e-4 * scale, "{view:?}: {found} {expected}");
                }
            }
        }
    }

    /// The bound on the pose is that on the image, carried by differences of the pose.
    //= reference/SPEC.md#bound
    //= type=test
    //# - **BOUND-2** The bound on `(x, y, θ)` MUST be that of `(a, s, k)` carried through the derivatives of POSE, its
    //# major and minor axes those of `(x, y)`.
    //= reference/SPEC.md#bound
    //= type=test
    //# - **BOUND-3** The bound through the bend MUST be that of `(a, s, k)` carried through COV-2 and COV-3.
    #[test]
    fn the_pose_s_bound_is_the_image_s() {
        for view in VIEWS {
            let Bound { image, pose, bent } = bound_at(view);
            let (camera, camera_in_landmark) = (Camera::epuck(), Pose::new(view[0], view[1], view[2]));
            let h = homography_of(&camera, &landmark(), &camera_in_landmark).unwrap();
            let at = |[a, s, k]: [f64; 3]| {
                let seen = Homography { a: h.a + a, s: h.s + s, k: h.k + k };
                let pose = crate::pose::pose(&seen, &camera, &landmark());
                SVector::<f64, 3>::new(pose.x(), pose.y(), frame::wrap(pose.theta() - view[2]))
            };
            let column = |i: usize| {
                let mut change = [0.0; 3];
                change[i] = 1e-6;
                (at(change) - at(change.map(|part| -part))) / 2e-6
            };
            let j = Matrix3::from_columns(&[column(0), column(1), column(2)]);
            let expected = j * image * j.transpose();
            assert!((pose - expected).amax() < 1e-5 * expected.amax(), "{pose} {expected}");
            assert_eq!(bent, transform(&h, &image, &camera, &landmark()));
        }
    }
}
