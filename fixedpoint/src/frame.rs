//! Frames as marker types, and poses that carry them.

use crate::formats::{Angle, Length};
use core::marker::PhantomData;

/// The world frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct World;

/// A landmark's frame: origin at the barcode's centre, x out of the wall, y to the right as seen (`FRAME-2`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Landmark;

/// The camera's frame: x forward, y left (`FRAME-3`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Camera;

/// The robot's frame: origin in the middle of the axle, x forward, y left (`FRAME-3`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Robot;

/// The pose of frame `Child` in frame `Parent` (`FRAME-1`, `FRAME-4`): metres, and an angle counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pose<Parent, Child> {
    /// The child's origin, first coordinate in the parent, metres.
    pub x: Length,
    /// The child's origin, second coordinate in the parent, metres.
    pub y: Length,
    /// The child's heading in the parent, in (-π, π] (`FRAME-5`).
    pub theta: Angle,
    frames: PhantomData<(Parent, Child)>,
}

impl<Parent, Child> Pose<Parent, Child> {
    /// A pose from its coordinates.
    #[must_use]
    pub const fn new(x: Length, y: Length, theta: Angle) -> Self {
        Self { x, y, theta, frames: PhantomData }
    }
}
