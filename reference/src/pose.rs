//! The camera's pose from the homography (8), (9) (POSE).

use crate::camera::Camera;
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::landmark::Landmark;
use nalgebra::{Matrix2, Rotation2};

/// The pose of a camera that sees `landmark` by `homography`, columns relative to the principal one (POSE-1 to POSE-3).
//= reference/SPEC.md#pose
//# - **POSE-1** With `α_0 = (f, 0)`, `α_1 = (0, -1)`, `A = [α_1 α_0]` and `H = [[s/W, a], [k/W, 1]]`, `B = [β_1 β_0]`
//# MUST be `A H` scaled so that `β_1` is a unit vector and `β_0`'s first component is positive (ERRATA-4).
//= reference/SPEC.md#pose
//# - **POSE-2** The camera's heading MUST be `θ = atan2(β_1x, β_1y)` (ERRATA-5).
//= reference/SPEC.md#pose
//# - **POSE-3** The camera's position MUST be `-R(θ) β_0`, the rigid transform (9).
//= reference/SPEC.md#errata
//# - **ERRATA-4** (7) MUST be read with `A = [α_1 α_0]` and `B = [β_1 β_0]`, and `H` as the map from the barcode to the
//# image.
//= reference/SPEC.md#errata
//# - **ERRATA-5** (8) MUST be replaced by the heading that (9) implies.
#[must_use]
pub fn pose(homography: &Homography, camera: &Camera, landmark: &Landmark) -> Pose<frame::Landmark, frame::Camera> {
    let Homography { a, s, k } = *homography;
    let w = landmark.half_width();
    // Columns of A: the image's direction (columns grow to the right, y to the left) and its position.
    let image = Matrix2::new(0.0, camera.focal_length, -1.0, 0.0);
    let h = Matrix2::new(s / w, a, k / w, 1.0);
    // The second row of H ends in 1, so the barcode's centre is in front of the camera and the factor positive.
    let barcode = image * h;
    let factor = 1.0 / barcode.column(0).norm();
    let direction = barcode.column(0) * factor;
    let position = barcode.column(1) * factor;
    let theta = direction.x.atan2(direction.y);
    let camera_position = -(Rotation2::new(theta) * position);
    Pose::new(camera_position.x, camera_position.y, theta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark::Format;
    use core::f64::consts::PI;
    use proptest::prelude::*;

    proptest! {
        /// The pose from which (a, s, k) were projected comes back.
        //= reference/SPEC.md#pose
        //= type=test
        //# - **POSE-1** With `α_0 = (f, 0)`, `α_1 = (0, -1)`, `A = [α_1 α_0]` and `H = [[s/W, a], [k/W, 1]]`, `B = [β_1
        //# β_0]` MUST be `A H` scaled so that `β_1` is a unit vector and `β_0`'s first component is positive
        //# (ERRATA-4).
        //= reference/SPEC.md#pose
        //= type=test
        //# - **POSE-3** The camera's position MUST be `-R(θ) β_0`, the rigid transform (9).
        //= reference/SPEC.md#errata
        //= type=test
        //# - **ERRATA-4** (7) MUST be read with `A = [α_1 α_0]` and `B = [β_1 β_0]`, and `H` as the map from the
        //# barcode to the image.
        #[test]
        fn the_pose_undoes_the_projection(
            distance in 0.05..1.0f64, polar in -1.2..1.2f64, off in -0.35..0.35f64, wide in any::<bool>(),
        ) {
            let camera = Camera::epuck();
            let landmark = Landmark::new(if wide { Format::Wide } else { Format::Paper });
            let truth: Pose<frame::Landmark, frame::Camera> =
                Pose::new(distance * polar.cos(), distance * polar.sin(), PI + polar + off);
            // (1): depth and offset of the barcode's centre and of its right end.
            let w = landmark.half_width();
            let centre = camera.project_stripe(&truth, 0.0);
            let right = camera.project_stripe(&truth, w);
            prop_assume!(right.depth > 0.0 && camera.project_stripe(&truth, -w).depth > 0.0);
            let k = right.depth / centre.depth - 1.0;
            let a = centre.column - camera.principal_column;
            let s = (right.column - camera.principal_column) * (1.0 + k) - a;
            let found = pose(&Homography { a, s, k }, &camera, &landmark);
            prop_assert!((found.x() - truth.x()).abs() < 1e-10 && (found.y() - truth.y()).abs() < 1e-10);
            prop_assert!(frame::wrap(found.theta() - truth.theta()).abs() < 1e-10);
        }
    }

    //= reference/SPEC.md#pose
    //= type=test
    //# - **POSE-2** The camera's heading MUST be `θ = atan2(β_1x, β_1y)` (ERRATA-5).
    //= reference/SPEC.md#errata
    //= type=test
    //# - **ERRATA-5** (8) MUST be replaced by the heading that (9) implies.
    #[test]
    fn looking_straight_at_a_landmark_is_a_heading_of_pi() {
        // 30 mm are 64 px wide at 0.3 m.
        let found = pose(&Homography { a: 0.0, s: 32.0, k: 0.0 }, &Camera::epuck(), &Landmark::new(Format::Paper));
        assert!((found.x() - 0.3).abs() < 1e-12 && found.y().abs() < 1e-12 && (found.theta() - PI).abs() < 1e-15);
    }
}
