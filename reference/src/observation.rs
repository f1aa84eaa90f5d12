//! What a sighting of a landmark says about the robot (OBSERVE).

use crate::camera::Camera;
use crate::covariance::{UncertainPose, transform};
use crate::frame::{self, Pose, Robot, World, wrap};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::motion::{STATES, State};
use nalgebra::{Matrix3, Rotation2, SMatrix, Vector2, Vector3};

/// Standard deviations of what no model of the camera covers: `a` and `s` in pixels, and `k` (OBSERVE-4).
pub const FLOOR: [f64; 3] = [0.1, 0.05, 5e-4];

/// How far in front of the camera a barcode's centre is at least, metres (FILTER-4).
pub const NEAREST: f64 = 1.0 / 256.0;

/// The largest `|a|` and `|s|`, px, and `|k|` that a linearisation may expect (FILTER-10).
const FARTHEST: f64 = 2048.0;
const STEEPEST: f64 = 4.0;

/// A landmark as it is known and was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Where it is.
    pub landmark_in_world: Pose<World, frame::Landmark>,
    /// Its dimensions.
    pub landmark: Landmark,
    /// The camera that saw it.
    pub camera: Camera,
    /// How the camera is mounted (OBSERVE-1).
    pub camera_in_robot: Pose<Robot, frame::Camera>,
    /// What was seen.
    pub seen: Seen,
}

/// What is taken as the measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// `(a, s, k)`, columns relative to the principal one, with their covariance.
    Image {
        /// The fitted homography.
        homography: Homography,
        /// Its covariance, px² and 1 (FIT-14).
        covariance: Matrix3<f64>,
    },
    /// The camera's pose in the landmark's frame with its covariance.
    Pose(UncertainPose),
}

/// An observation beside a state: what it says more, by what it depends on the state, and how uncertain it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearised {
    /// The measurement less its prediction.
    pub residual: Vector3<f64>,
    /// The derivative of the prediction by the state.
    pub by_state: SMatrix<f64, 3, STATES>,
    /// The covariance of the measurement.
    pub noise: Matrix3<f64>,
}

impl Sighting {
    /// The observation beside a state; `None` if the landmark is not in front of the camera there (FILTER-4), or where it would be
    /// seen as no camera sees it (FILTER-10).
    #[must_use]
    pub fn linearised(&self, state: &State) -> Option<Linearised> {
        match &self.seen {
            Seen::Image { homography, covariance } => self.image(state, homography, covariance),
            Seen::Pose(seen) => Some(self.pose(state, seen)),
        }
    }

    /// The camera's pose in the landmark's frame by the sighting alone, through the bend (COV-2, COV-3).
    #[must_use]
    pub fn camera_pose(&self) -> UncertainPose {
        match &self.seen {
            Seen::Image { homography, covariance } => transform(homography, covariance, &self.camera, &self.landmark),
            Seen::Pose(seen) => *seen,
        }
    }

    /// (10): the robot in the world by a pose of the camera, with its covariance (OBSERVE-2).
    //= reference/SPEC.md#observe
    //# - **OBSERVE-2** As a pose, a sighting MUST be (10), the camera's pose in the landmark's frame taken to the robot
    //# and the world, with its covariance (COV-4, COV-5) carried through the derivatives.
    #[must_use]
    pub fn robot_in_world(&self, seen: &UncertainPose) -> (Pose<World, Robot>, Matrix3<f64>) {
        let camera_in_world = self.landmark_in_world * seen.camera_in_landmark;
        let robot = camera_in_world * self.camera_in_robot.inverse();
        // The landmark's heading turns the position, and the camera's heading swings the robot around the camera.
        let turned = Rotation2::new(self.landmark_in_world.theta());
        let lever = self.lever(&robot);
        let mut by_camera = Matrix3::identity();
        by_camera.fixed_view_mut::<2, 2>(0, 0).copy_from(turned.matrix());
        by_camera[(0, 2)] = lever.y;
        by_camera[(1, 2)] = -lever.x;
        (robot, by_camera * seen.covariance * by_camera.transpose())
    }

    /// From the robot's origin to the camera, in the world.
    fn lever(&self, robot: &Pose<World, Robot>) -> Vector2<f64> {
        Rotation2::new(robot.theta()) * Vector2::new(self.camera_in_robot.x(), self.camera_in_robot.y())
    }

    /// OBSERVE-2 as a measurement: the pose itself.
    fn pose(&self, state: &State, seen: &UncertainPose) -> Linearised {
        let (robot, noise) = self.robot_in_world(seen);
        let turn = wrap(robot.theta() - state.pose.theta());
        let residual = Vector3::new(robot.x() - state.pose.x(), robot.y() - state.pose.y(), turn);
        let mut by_state = SMatrix::<f64, 3, STATES>::zeros();
        by_state.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
        Linearised { residual, by_state, noise }
    }

    /// OBSERVE-3, OBSERVE-4
    //= reference/SPEC.md#observe
    //# - **OBSERVE-4** The noise of an image MUST be the fit's covariance (FIT-14) with `0.1² px²`, `0.05² px²` and
    //# `0.0005²` added for what no model covers.
    fn image(&self, state: &State, seen: &Homography, covariance: &Matrix3<f64>) -> Option<Linearised> {
        let camera_in_landmark = self.landmark_in_world.inverse() * state.pose * self.camera_in_robot;
        let (predicted, by_camera) = predicted(&self.camera, &self.landmark, &camera_in_landmark)?;
        // The camera moves with the robot, and on a circle around it.
        let lever = self.lever(&state.pose);
        let turned = Rotation2::new(-self.landmark_in_world.theta());
        let mut by_robot = Matrix3::identity();
        by_robot.fixed_view_mut::<2, 2>(0, 0).copy_from(turned.matrix());
        by_robot.fixed_view_mut::<2, 1>(0, 2).copy_from(&(turned * Vector2::new(-lever.y, lever.x)));
        let mut by_state = SMatrix::<f64, 3, STATES>::zeros();
        by_state.fixed_view_mut::<3, 3>(0, 0).copy_from(&(by_camera * by_robot));
        let residual = Vector3::new(seen.a - predicted.a, seen.s - predicted.s, seen.k - predicted.k);
        let floor = Vector3::from(FLOOR.map(|deviation| deviation * deviation));
        Some(Linearised { residual, by_state, noise: covariance + Matrix3::from_diagonal(&floor) })
    }
}

/// The `(a, s, k)` that a camera sees, and their derivatives by its `(x, y, θ)` in the landmark's frame (OBSERVE-3); `None`
/// if the barcode's centre is not in front of it, or seen as no camera sees it (FILTER-10).
///
/// With depth `d_0` and offset to the left `l_0` of the centre, both change along `t` by `W sin θ` and `W cos θ`:
/// `a = -f l_0/d_0`, `s = -f W cos θ/d_0`, `k = W sin θ/d_0`.
//= reference/SPEC.md#observe
//# - **OBSERVE-3** As an image, a sighting MUST be `(a, s, k)`, compared with what the camera at the state's pose would
//# see: `a = -f l/d`, `s = -f W cos θ/d`, `k = W sin θ/d` of its heading θ in L, the depth `d` of the barcode's centre
//# and its offset `l` to the left.
fn predicted(
    camera: &Camera,
    landmark: &Landmark,
    at: &Pose<frame::Landmark, frame::Camera>,
) -> Option<(Homography, Matrix3<f64>)> {
    let (f, w) = (camera.focal_length, landmark.half_width());
    let (sin, cos) = at.theta().sin_cos();
    let depth = -(at.x() * cos + at.y() * sin);
    let left = at.x() * sin - at.y() * cos;
    if depth < NEAREST {
        return None;
    }
    let homography = Homography { a: -f * left / depth, s: -f * w * cos / depth, k: w * sin / depth };
    let Homography { a, s, k } = homography;
    //= reference/SPEC.md#filter
    //# - **FILTER-10** An image MUST NOT be used if one of its linearisations expects `|a|` or `|s|` above 2048 px or
    //# `|k|` above 4.
    if a.abs() > FARTHEST || s.abs() > FARTHEST || k.abs() > STEEPEST {
        return None;
    }
    // Of the depth by x, y and θ, and of the offset.
    let by_depth = Vector3::new(-cos, -sin, left);
    let by_left = Vector3::new(sin, -cos, -depth);
    let of_a = (by_left * -f - by_depth * a) / depth;
    let of_s = (Vector3::new(0.0, 0.0, f * w * sin) - by_depth * s) / depth;
    let of_k = (Vector3::new(0.0, 0.0, w * cos) - by_depth * k) / depth;
    Some((homography, Matrix3::from_rows(&[of_a.transpose(), of_s.transpose(), of_k.transpose()])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bound::homography_of;
    use crate::landmark::Format;
    use crate::pose;
    use core::f64::consts::PI;
    use proptest::prelude::*;

    fn sighting(seen: Seen) -> Sighting {
        Sighting {
            landmark_in_world: Pose::new(0.4, -0.2, 2.1),
            landmark: Landmark::new(Format::Paper),
            camera: Camera::epuck(),
            camera_in_robot: Pose::new(0.03, 0.004, 0.02),
            seen,
        }
    }

    /// A robot whose camera is at a pose in the landmark's frame.
    fn state(x: f64, y: f64, theta: f64) -> State {
        let sighting =
            sighting(Seen::Image { homography: Homography { a: 0.0, s: 1.0, k: 0.0 }, covariance: Matrix3::zeros() });
        let camera: Pose<frame::Landmark, frame::Camera> = Pose::new(x, y, theta);
        let pose = sighting.landmark_in_world * camera * sighting.camera_in_robot.inverse();
        State { pose, wheel_difference: 0.0, axle_excess: 0.0 }
    }

    fn shifted(state: &State, change: [f64; 3]) -> State {
        let [x, y, theta] = change;
        let pose = Pose::new(state.pose.x() + x, state.pose.y() + y, state.pose.theta() + theta);
        State { pose, ..*state }
    }

    proptest! {
        /// What the camera model projects is predicted, and the derivatives are those of it.
        //= reference/SPEC.md#observe
        //= type=test
        //# - **OBSERVE-3** As an image, a sighting MUST be `(a, s, k)`, compared with what the camera at the state's
        //# pose would see: `a = -f l/d`, `s = -f W cos θ/d`, `k = W sin θ/d` of its heading θ in L, the depth `d` of
        //# the barcode's centre and its offset `l` to the left.
        #[test]
        fn a_sighting_is_predicted(distance in 0.08..0.6f64, polar in -1.0..1.0f64, off in -0.3..0.3f64) {
            let (x, y, theta) = (distance * polar.cos(), distance * polar.sin(), PI + polar + off);
            let truth: Pose<frame::Landmark, frame::Camera> = Pose::new(x, y, theta);
            let homography = homography_of(&Camera::epuck(), &Landmark::new(Format::Paper), &truth);
            prop_assume!(homography.is_some());
            let seen = sighting(Seen::Image { homography: homography.unwrap(), covariance: Matrix3::zeros() });
            let here = state(x, y, theta);
            let found = seen.linearised(&here).unwrap();
            prop_assert!(found.residual.amax() < 1e-9, "{}", found.residual);
            for column in 0..3 {
                let residual = |sign: f64| {
                    let mut change = [0.0; 3];
                    change[column] = sign * 1e-6;
                    seen.linearised(&shifted(&here, change)).unwrap().residual
                };
                let difference = (residual(-1.0) - residual(1.0)) / 2e-6;
                let error = (difference - found.by_state.column(column)).component_div(&Vector3::new(1e4, 1e4, 1e2));
                prop_assert!(error.amax() < 1e-6, "{column}: {difference} {}", found.by_state);
            }
        }

        /// (10) takes a camera's pose to the robot's, and its covariance by the derivatives.
        //= reference/SPEC.md#observe
        //= type=test
        //# - **OBSERVE-2** As a pose, a sighting MUST be (10), the camera's pose in the landmark's frame taken to the
        //# robot and the world, with its covariance (COV-4, COV-5) carried through the derivatives.
        #[test]
        fn a_pose_is_carried_to_the_robot(x in 0.1..0.5f64, y in -0.3..0.3f64, theta in 2.5..3.8f64) {
            let at = |change: [f64; 3]| UncertainPose {
                camera_in_landmark: Pose::new(x + change[0], y + change[1], theta + change[2]),
                covariance: Matrix3::identity(),
            };
            let seen = sighting(Seen::Pose(at([0.0; 3])));
            let (robot, covariance) = seen.robot_in_world(&at([0.0; 3]));
            prop_assert!(seen.linearised(&state(x, y, theta)).unwrap().residual.amax() < 1e-12);
            let mut by_camera = Matrix3::zeros();
            for column in 0..3 {
                let mut change = [0.0; 3];
                change[column] = 1e-6;
                let (moved, _) = seen.robot_in_world(&at(change));
                let turn = wrap(moved.theta() - robot.theta());
                let difference = Vector3::new(moved.x() - robot.x(), moved.y() - robot.y(), turn) / 1e-6;
                by_camera.set_column(column, &difference);
            }
            prop_assert!((by_camera * by_camera.transpose() - covariance).amax() < 1e-5);
        }
    }

    #[test]
    fn what_is_behind_the_camera_says_nothing() {
        let homography = Homography { a: 0.0, s: 30.0, k: 0.0 };
        let seen = sighting(Seen::Image { homography, covariance: Matrix3::zeros() });
        assert!(seen.linearised(&state(0.3, 0.0, 0.0)).is_none());
        assert!(seen.linearised(&state(0.3, 0.0, PI)).is_some());
        // 2^-8 m before it, where stripes of 0.5 mm are not yet what FILTER-10 speaks of.
        let landmark = Landmark { stripe_width: 0.0005, ..seen.landmark };
        let seen = Sighting { landmark, ..seen };
        assert!(seen.linearised(&state(0.003_91, 0.0, PI)).is_some());
        assert!(seen.linearised(&state(0.003_90, 0.0, PI)).is_none());
    }

    /// 2048 px are 3.2 times the focal length: `a` of a barcode 3.2 times as far aside as ahead, `s` of one whose half is 3.2 times
    /// as wide, and `k` is 4 of one that stands endwise and whose half is 4 times as long.
    //= reference/SPEC.md#filter
    //= type=test
    //# - **FILTER-10** An image MUST NOT be used if one of its linearisations expects `|a|` or `|s|` above 2048 px or
    //# `|k|` above 4.
    #[test]
    fn what_no_camera_sees_is_not_expected() {
        let homography = Homography { a: 0.0, s: 30.0, k: 0.0 };
        let mut seen = sighting(Seen::Image { homography, covariance: Matrix3::zeros() });
        let expects = |seen: &Sighting, x, y, theta| seen.linearised(&state(x, y, theta)).is_some();
        for side in [-1.0, 1.0] {
            assert!(expects(&seen, 0.1, side * 0.3199, PI) && !expects(&seen, 0.1, side * 0.3201, PI));
        }
        assert!(expects(&seen, 0.0047, 0.0, PI) && !expects(&seen, 0.0046, 0.0, PI));
        seen.landmark.stripe_width = 0.02;
        assert!(expects(&seen, 0.0, -0.0501, PI / 2.0) && !expects(&seen, 0.0, -0.0499, PI / 2.0));
        assert!(expects(&seen, 0.0, 0.0501, -PI / 2.0) && !expects(&seen, 0.0, 0.0499, -PI / 2.0));
    }

    //= reference/SPEC.md#observe
    //= type=test
    //# - **OBSERVE-4** The noise of an image MUST be the fit's covariance (FIT-14) with `0.1² px²`, `0.05² px²` and
    //# `0.0005²` added for what no model covers.
    #[test]
    fn what_no_model_covers_is_added() {
        let homography = Homography { a: 0.0, s: 32.0, k: 0.0 };
        let seen = sighting(Seen::Image { homography, covariance: Matrix3::identity() });
        let noise = seen.linearised(&state(0.3, 0.0, PI)).unwrap().noise;
        assert!((noise[(0, 0)] - 1.01).abs() < 1e-12 && (noise[(1, 1)] - 1.0025).abs() < 1e-12);
        assert!((noise[(2, 2)] - 1.0 - 2.5e-7).abs() < 1e-12 && noise[(0, 1)].abs() < 1e-15);
        let middle = pose::pose(&homography, &Camera::epuck(), &Landmark::new(Format::Paper));
        assert!((middle.x() - 0.3).abs() < 1e-12);
    }
}
