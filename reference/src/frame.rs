//! Frames as types (FRAME-1 to FRAME-5).
//!
//! `Pose<World, Robot>` is the robot in the world. Composing `Pose<A, B>` with `Pose<B, C>` gives `Pose<A, C>`;
//! any other order does not compile:
//!
//! ```compile_fail
//! use reference::frame::{Camera, Landmark, Pose, World};
//! let landmark: Pose<World, Landmark> = Pose::new(1.0, 2.0, 0.0);
//! let robot: Pose<World, Camera> = Pose::new(0.0, 0.0, 0.0);
//! let wrong = landmark * robot;
//! ```

use core::marker::PhantomData;
use core::ops::Mul;
use nalgebra::{Isometry2, Point2, Vector2};

/// World frame W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct World;

/// Landmark frame L: origin at the barcode's centre, x out of the wall, y to the right as seen.
//= reference/SPEC.md#frame
//# - **FRAME-2** The landmark frame L MUST have its origin at the barcode's centre, x out of the wall and y to the
//# right as a robot sees it that looks at the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark;

/// Camera frame C: x along the optical axis, y to the left.
//= reference/SPEC.md#frame
//# - **FRAME-3** The camera frame C and the robot frame R MUST have x forward and y left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera;

/// Robot frame R: x forward, y left, origin between the wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robot;

/// The pose of frame `Child` in frame `Parent`, in metres and radians.
//= reference/SPEC.md#frame
//# - **FRAME-1** Every frame MUST be planar and right-handed, in metres and radians, with angles counter-clockwise seen
//# from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<Parent, Child> {
    isometry: Isometry2<f64>,
    frames: PhantomData<(Parent, Child)>,
}

impl<Parent, Child> Pose<Parent, Child> {
    /// The child's origin at (`x`, `y`) in the parent, in metres, turned by `theta` radians counter-clockwise.
    #[must_use]
    pub fn new(x: f64, y: f64, theta: f64) -> Self {
        Self { isometry: Isometry2::new(Vector2::new(x, y), theta), frames: PhantomData }
    }

    /// x of the child's origin in the parent, in metres.
    #[must_use]
    pub fn x(&self) -> f64 {
        self.isometry.translation.x
    }

    /// y of the child's origin in the parent, in metres.
    #[must_use]
    pub fn y(&self) -> f64 {
        self.isometry.translation.y
    }

    /// The child's rotation in the parent, in (-π, π] radians (FRAME-5).
    //= reference/SPEC.md#frame
    //# - **FRAME-5** An angle that a pose reports MUST lie in (-π, π].
    #[must_use]
    pub fn theta(&self) -> f64 {
        wrap(self.isometry.rotation.angle())
    }

    /// The parent in the child.
    #[must_use]
    pub fn inverse(&self) -> Pose<Child, Parent> {
        Pose { isometry: self.isometry.inverse(), frames: PhantomData }
    }

    /// A point of the child frame in the parent frame.
    #[must_use]
    pub fn place(&self, point: &Point<Child>) -> Point<Parent> {
        let placed = self.isometry * Point2::new(point.x, point.y);
        Point::new(placed.x, placed.y)
    }
}

impl<A, B, C> Mul<Pose<B, C>> for Pose<A, B> {
    type Output = Pose<A, C>;

    //= reference/SPEC.md#frame
    //# - **FRAME-4** A pose of frame B in frame A MUST carry both frames in its type, so that composing poses whose
    //# inner frames differ does not compile.
    fn mul(self, inner: Pose<B, C>) -> Pose<A, C> {
        Pose { isometry: self.isometry * inner.isometry, frames: PhantomData }
    }
}

/// A point of the frame `F`, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<F> {
    /// First coordinate, in metres.
    pub x: f64,
    /// Second coordinate, in metres.
    pub y: f64,
    frame: PhantomData<F>,
}

impl<F> Point<F> {
    /// The point (`x`, `y`), in metres.
    #[must_use]
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, frame: PhantomData }
    }
}

/// The angle in (-π, π] that differs from `angle` by a multiple of 2π (FRAME-5).
#[must_use]
pub fn wrap(angle: f64) -> f64 {
    use core::f64::consts::{PI, TAU};
    let turned = angle.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};

    //= reference/SPEC.md#frame
    //= type=test
    //# - **FRAME-1** Every frame MUST be planar and right-handed, in metres and radians, with angles counter-clockwise
    //# seen from above.
    #[test]
    fn poses_compose_as_rigid_transforms() {
        // A landmark at (2, 1) that faces along world y, a camera 0.5 m in front of it that looks at it.
        let landmark: Pose<World, Landmark> = Pose::new(2.0, 1.0, FRAC_PI_2);
        let camera: Pose<Landmark, Camera> = Pose::new(0.5, 0.0, PI);
        let in_world = landmark * camera;
        assert!((in_world.x() - 2.0).abs() < 1e-15 && (in_world.y() - 1.5).abs() < 1e-15);
        assert!((in_world.theta() + FRAC_PI_2).abs() < 1e-15);
        // The barcode's right end lies at the camera's right: negative y in C.
        let right_end = camera.inverse().place(&Point::new(0.0, 0.015));
        assert!((right_end.x - 0.5).abs() < 1e-15 && (right_end.y + 0.015).abs() < 1e-15);
    }

    //= reference/SPEC.md#frame
    //= type=test
    //# - **FRAME-5** An angle that a pose reports MUST lie in (-π, π].
    #[test]
    fn angles_wrap_into_the_half_open_interval() {
        assert!((wrap(PI) - PI).abs() < 1e-15 && (wrap(-PI) - PI).abs() < 1e-15);
        assert!((wrap(3.0 * PI + 0.25) + PI - 0.25).abs() < 1e-12);
        assert!(wrap(0.0).abs() < 1e-15);
    }
}
