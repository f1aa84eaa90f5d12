//! The state: where the robot is, what is known of its wheels, and how well.

use super::covariance::{SHARE_UNIT_BITS, STATES, StateCovariance};
use crate::binary::times;
use crate::covariance::PoseCovariance;
use crate::formats::{Angle, Length, Share};
use crate::frame::{Pose, Robot, World};
use crate::ratio;

/// Fraction bits of a state's x and y, in metres.
pub const POSITION_BITS: u8 = 40;

/// The robot's pose in the world, `e` and `g`, and their covariance.
///
/// Finer than the formats of what is reported: were all roundings of a million predictions of one sign, they would move the
/// robot by 2 µm and, with an axle of 5 cm, turn it by 4e-5 rad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// Metres with [`POSITION_BITS`].
    pub(crate) x: i64,
    /// Likewise.
    pub(crate) y: i64,
    /// In units of π/2^63; wraps as the integers do.
    pub(crate) heading: i64,
    /// The right wheel's share more than the left one's, within ±1/8.
    pub(crate) e: Share,
    /// The axle's share more than nominal, within ±1/8.
    pub(crate) g: Share,
    pub(crate) covariance: StateCovariance,
}

impl State {
    /// `e` and `g` stay within ±1/8.
    pub const LARGEST_SHARE: Share = Share::from_bits(1 << 29);

    /// A state of a pose and its covariance, of which `e` and `g` are known to be 0.
    #[must_use]
    pub fn new(pose: &Pose<World, Robot>, covariance: &PoseCovariance) -> Self {
        Self {
            x: i64::from(pose.x.to_bits()) << 16,
            y: i64::from(pose.y.to_bits()) << 16,
            heading: i64::from(pose.theta.to_bits()) << 32,
            e: Share::ZERO,
            g: Share::ZERO,
            covariance: StateCovariance::of_pose(covariance),
        }
    }

    /// The same with `e` and `g` to be estimated: their standard deviations, at most 1/16, and no correlation.
    ///
    /// A deviation of 0 is a number that is known.
    #[must_use]
    pub fn with_wheels(mut self, imbalance: Share, axle: Share) -> Self {
        for (i, deviation) in [(3, imbalance), (4, axle)] {
            let bits = i64::from(deviation.to_bits()).clamp(0, 1 << 28);
            self.covariance.set(i, i, (bits * bits) << (2 * SHARE_UNIT_BITS - 8)); // 64 fraction bits to 56
        }
        self
    }

    /// The pose, limited to what [`Length`] holds; errors 2^-25 m and 2^-32 π.
    #[must_use]
    pub fn pose(&self) -> Pose<World, Robot> {
        let length = |value: i64| {
            let coarse = ratio::dropped(value, POSITION_BITS - 24).clamp(i64::from(i32::MIN), i64::from(i32::MAX));
            Length::from_bits(i32::try_from(coarse).unwrap_or_default())
        };
        Pose::new(length(self.x), length(self.y), angle(self.heading))
    }

    /// By how much the right wheel is larger than the left one, as a share of both.
    #[must_use]
    pub fn e(&self) -> Share {
        self.e
    }

    /// By how much the axle is longer than nominal.
    #[must_use]
    pub fn g(&self) -> Share {
        self.g
    }

    /// The state by so much from here: x, y, the heading, `e` and `g` in the covariance's units, 40 fraction bits.
    ///
    /// Errors: 2^-40 π of the heading, 2^-33 of `e` and `g`, which stay within ±1/8.
    pub(crate) fn moved(&self, [x, y, turn, imbalance, axle]: [i64; STATES]) -> Self {
        const INVERSE_PI: i32 = 1_367_130_551; // 32 fraction bits
        let share = |from: Share, change: i64| {
            let sum = i64::from(from.to_bits()).saturating_add(ratio::dropped(change, 40 + SHARE_UNIT_BITS - 32));
            let limit = i64::from(Self::LARGEST_SHARE.to_bits());
            Share::from_bits(i32::try_from(sum.clamp(-limit, limit)).unwrap_or_default())
        };
        Self {
            x: self.x.saturating_add(x),
            y: self.y.saturating_add(y),
            heading: self.heading.wrapping_add(times(turn, INVERSE_PI, 32) << 23),
            e: share(self.e, imbalance),
            g: share(self.g, axle),
            covariance: self.covariance,
        }
    }

    /// A state somewhere else with what this one knows of `e` and `g`.
    pub(crate) fn elsewhere(&self, pose: &Pose<World, Robot>, covariance: &PoseCovariance) -> Self {
        let mut other = Self { e: self.e, g: self.g, ..Self::new(pose, covariance) };
        for (i, j) in [(3, 3), (3, 4), (4, 4)] {
            other.covariance.set(i, j, self.covariance.entry(i, j));
        }
        other
    }

    /// The covariance.
    #[must_use]
    pub fn covariance(&self) -> &StateCovariance {
        &self.covariance
    }
}

/// A heading in units of π/2^63, rounded to an angle.
pub(crate) fn angle(heading: i64) -> Angle {
    let rounded = heading.wrapping_add(1 << 31) >> 32;
    Angle::from_bits(i32::try_from(rounded).unwrap_or_default())
}
