//! What the camera's motion between the two rows' exposures does to an image (SKEW).

use crate::camera::Camera;
use crate::frame::{self, Pose, Robot};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::motion::{Drive, MotionModel, State, StateCovariance, Ways, predict};
use nalgebra::{Rotation2, Vector2};

/// By how much nearer the camera may come to a barcode, as a share of its depth (SKEW-3).
const NEAREST: f64 = 1.0 / 4.0;

/// Largest obliquity that is carried (SKEW-3, FIT-13).
const MAX_OBLIQUITY: f64 = 0.75;

/// Variance of a wheel's way by its length, metres (SKEW-5).
const SLIP: f64 = 1e-6;

/// Standard deviations of the turn that are allowed for, and what the image's corners move by more than its middle (SKEW-5).
const PLAY: f64 = 5.0;

/// How the camera moves from the upper row's exposure to the lower row's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skew {
    /// `None` at rest.
    motion: Option<Motion>,
}

/// A motion between both exposures.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Motion {
    /// The camera at the lower row's time in the camera at the upper row's.
    lower_in_upper: Pose<frame::Camera, frame::Camera>,
    /// What its turn may be off by, pixels (SKEW-5).
    play: u32,
}

impl Skew {
    /// A camera that does not move.
    #[must_use]
    pub fn at_rest() -> Self {
        Self { motion: None }
    }

    /// A camera that is at this pose, in the camera at the upper row's time, when the lower row is exposed, its turn known to
    /// so many pixels.
    #[must_use]
    pub fn of(lower_in_upper: Pose<frame::Camera, frame::Camera>, play: u32) -> Self {
        Self { motion: Some(Motion { lower_in_upper, play }) }
    }

    /// The motion of a robot's camera by the ways of its wheels, one arc after the other (SKEW-1, SKEW-5).
    //= reference/SPEC.md#skew
    //# - **SKEW-1** The motion of the camera MUST be that of the robot through its mounting: MOTION-2 and MOTION-3 with
    //# `e = g = 0` over the readings between both times, a reading's steps taken in proportion to the part of its time.
    //= reference/SPEC.md#skew
    //# - **SKEW-5** The *play* of a moving camera MUST be `T = ceil(5 f/b √(q (|l| + |r|) + u²/3))` pixels, with `q =
    //# 1e-6 m`, `u` of MOTION-1, the axle `b`, and `|l|` and `|r|` the sums of the lengths of the wheels' ways between
    //# both times; at rest it is 0.
    #[must_use]
    pub fn of_ways(
        ways: &[Ways],
        drive: &Drive,
        camera_in_robot: &Pose<Robot, frame::Camera>,
        camera: &Camera,
    ) -> Self {
        let length: f64 = ways.iter().map(|ways| ways.left.abs() + ways.right.abs()).sum();
        if length <= 0.0 {
            return Self::at_rest();
        }
        let arcs = Drive { model: MotionModel::Arc, ..*drive };
        let upper = State { pose: Pose::new(0.0, 0.0, 0.0), wheel_difference: 0.0, axle_excess: 0.0 };
        let lower = ways.iter().fold(upper, |state, ways| predict(&state, &StateCovariance::zeros(), ways, &arcs).0);
        let at = |state: &State| state.pose * *camera_in_robot;
        let turn = (SLIP * length + drive.step().powi(2) / 3.0).sqrt() / drive.axle;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "limited to a wide image's width")]
        let play = (PLAY * camera.focal_length * turn).ceil().clamp(0.0, 65535.0) as u32;
        Self::of(at(&upper).inverse() * at(&lower), play)
    }

    /// Whether the camera moves.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// `T`, pixels by which the lower line's barcodes may be beside where they are expected; 0 at rest (SKEW-5).
    #[must_use]
    pub fn play(&self) -> u32 {
        self.motion.map_or(0, |motion| motion.play)
    }

    /// The merged homography of both layers at the upper row's time, the lower one already less its shift (MERGE-4, SKEW-8).
    #[must_use]
    pub fn merged(&self, upper: &Homography, lower: &Homography) -> Homography {
        let mean = upper.mean(lower);
        if self.moves() { Homography { a: upper.a, ..mean } } else { mean }
    }

    /// What the lower row sees where the upper one sees `homography` (SKEW-2); `None` by SKEW-3.
    //= reference/SPEC.md#skew
    //# - **SKEW-2** A homography `(a, s, k)` MUST be carried to the lower row by `1/ρ = √(k² + (s/f)²)/W`, `u = (1 -
    //# t_x/ρ, -a/f - t_y/ρ)` and `v = (k, -s/f)`, which are turned by `-φ` into `u'` and `v'`: `a' = -f u'_y/u'_x`, `s'
    //# = -f v'_y/u'_x`, `k' = v'_x/u'_x`; its *shift* is `Δ = (a' - a, s' - s, k' - k)`.
    //= reference/SPEC.md#skew
    //# - **SKEW-3** A homography that is carried to `u'_x < 1/4`, `|k'| > 3/4`, `s' < N/4` or `s' <= a' k'` MUST be
    //# paired with nothing.
    #[must_use]
    pub fn carried(&self, homography: &Homography, camera: &Camera, landmark: &Landmark) -> Option<Homography> {
        let Some(Motion { lower_in_upper: motion, .. }) = &self.motion else { return Some(*homography) };
        let (f, Homography { a, s, k }) = (camera.focal_length, *homography);
        // Of the barcode's centre, by its half width.
        let inverse_depth = k.hypot(s / f) / landmark.half_width();
        let back = Rotation2::new(-motion.theta());
        let centre = back * Vector2::new(1.0 - motion.x() * inverse_depth, -a / f - motion.y() * inverse_depth);
        let half = back * Vector2::new(k, -s / f);
        if centre.x < NEAREST {
            return None;
        }
        let carried = Homography { a: -f * centre.y / centre.x, s: -f * half.y / centre.x, k: half.x / centre.x };
        let Homography { a, s, k } = carried;
        let is_possible = k.abs() <= MAX_OBLIQUITY && s >= landmark.format.stripes() as f64 / 4.0 && s > a * k;
        is_possible.then_some(carried)
    }

    /// What the lower row's `(a, s, k)` are more than the upper one's, 0 at rest (SKEW-2); `None` by SKEW-3.
    #[must_use]
    pub fn shift(&self, homography: &Homography, camera: &Camera, landmark: &Landmark) -> Option<Homography> {
        match self.motion {
            None => Some(Homography::NONE),
            Some(_) => self.carried(homography, camera, landmark).map(|carried| carried.minus(homography)),
        }
    }
}

/// How far the ends of a barcode in the lower line are to the right of those in the upper one, whole pixels (SKEW-4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ends {
    /// Of the first pixel.
    pub first: isize,
    /// Of the last pixel.
    pub last: isize,
}

impl Ends {
    /// Those of a homography and what it is carried to (SKEW-4).
    //= reference/SPEC.md#skew
    //# - **SKEW-4** The *shift of an end* `t`, -1 for the first pixel and 1 for the last one, MUST be `c'(t) - c(t)`
    //# with `c(t) = (a + s t)/(1 + k t)`, rounded to the nearest pixel, halves up.
    #[must_use]
    pub fn of(upper: &Homography, lower: &Homography) -> Self {
        let shift = |t: f64| whole(lower.column(t) - upper.column(t));
        Self { first: shift(-1.0), last: shift(1.0) }
    }

    /// Whether the ends of a layer below are at most so many pixels from where those of one above lead (SKEW-6).
    #[must_use]
    pub fn join(&self, upper: (usize, usize), lower: (usize, usize), pixels: usize) -> bool {
        // An end may lead out of the line.
        let near = |one: usize, by: isize, other: usize| (one as f64 + by as f64 - other as f64).abs() <= pixels as f64;
        near(upper.0, self.first, lower.0) && near(upper.1, self.last, lower.1)
    }
}

/// The nearest whole number of pixels, halves up (SKEW-4).
fn whole(pixels: f64) -> isize {
    #[expect(clippy::cast_possible_truncation, reason = "by SKEW-3 an end moves by less than 2^20 pixels")]
    let whole = (pixels + 0.5).floor() as isize;
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bound::homography_of;
    use crate::landmark::Format;
    use core::f64::consts::PI;
    use proptest::prelude::*;

    proptest! {
        /// What is carried is what the camera sees after its motion.
        //= reference/SPEC.md#skew
        //= type=test
        //# - **SKEW-2** A homography `(a, s, k)` MUST be carried to the lower row by `1/ρ = √(k² + (s/f)²)/W`, `u = (1
        //# - t_x/ρ, -a/f - t_y/ρ)` and `v = (k, -s/f)`, which are turned by `-φ` into `u'` and `v'`: `a' = -f
        //# u'_y/u'_x`, `s' = -f v'_y/u'_x`, `k' = v'_x/u'_x`; its *shift* is `Δ = (a' - a, s' - s, k' - k)`.
        #[test]
        fn a_homography_is_carried_to_where_the_camera_went(
            distance in 0.12..0.6f64, polar in -0.9..0.9f64, off in -0.3..0.3f64,
            ahead in -0.02..0.02f64, left in -0.02..0.02f64, turn in -0.1..0.1f64,
        ) {
            let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
            let before: Pose<frame::Landmark, frame::Camera> =
                Pose::new(distance * polar.cos(), distance * polar.sin(), PI + polar + off);
            let motion = Pose::new(ahead, left, turn);
            let upper = homography_of(&camera, &landmark, &before);
            let lower = homography_of(&camera, &landmark, &(before * motion));
            prop_assume!(upper.is_some() && lower.is_some());
            let (upper, lower) = (upper.unwrap(), lower.unwrap());
            let carried = Skew::of(motion, 0).carried(&upper, &camera, &landmark);
            prop_assume!(carried.is_some());
            let off = carried.unwrap().minus(&lower);
            prop_assert!(off.a.abs() < 1e-9 && off.s.abs() < 1e-9 && off.k.abs() < 1e-12, "{off:?}");
        }
    }

    #[test]
    fn at_rest_nothing_is_shifted() {
        let seen = Homography { a: 12.3, s: 31.7, k: 0.017 };
        let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
        let mounted = Pose::new(0.03, 0.0, 0.0);
        for skew in [Skew::at_rest(), Skew::of_ways(&[Ways::default()], &Drive::epuck(), &mounted, &camera)] {
            assert_eq!(skew.shift(&seen, &camera, &landmark), Some(Homography::NONE));
        }
    }

    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-3** A homography that is carried to `u'_x < 1/4`, `|k'| > 3/4`, `s' < N/4` or `s' <= a' k'` MUST be
    //# paired with nothing.
    #[test]
    fn what_comes_too_near_is_not_carried() {
        // 30 cm away, and 23 of them towards it.
        let seen = Homography { a: 0.0, s: 32.0, k: 0.0 };
        let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
        let carried = |ahead| Skew::of(Pose::new(ahead, 0.0, 0.0), 0).carried(&seen, &camera, &landmark);
        assert!(carried(0.22).is_some_and(|near| (near.s - 32.0 * 0.3 / 0.08).abs() < 1e-9));
        assert!(carried(0.226).is_none());
    }

    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-1** The motion of the camera MUST be that of the robot through its mounting: MOTION-2 and MOTION-3 with
    //# `e = g = 0` over the readings between both times, a reading's steps taken in proportion to the part of its time.
    #[test]
    fn a_robot_that_turns_swings_its_camera() {
        // Both wheels by a quarter of a circle of the axle's length: a quarter turn on the spot.
        let way = 0.053 * PI / 4.0;
        let mounted = Pose::new(0.03, 0.0, 0.0);
        let turn = Skew::of_ways(&[Ways { left: -way, right: way }], &Drive::epuck(), &mounted, &Camera::epuck());
        let motion = turn.motion.unwrap().lower_in_upper;
        assert!((motion.x() + 0.03).abs() < 1e-12 && (motion.y() - 0.03).abs() < 1e-12, "{motion:?}");
        assert!((motion.theta() - PI / 2.0).abs() < 1e-12);
    }

    /// 13.1 mm: 1e-6 of 26.2 mm and a third of (0.129 mm)² are (0.178 mm)², over 53 mm 3.36 mrad, five times 640 px of it 10.8.
    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-5** The *play* of a moving camera MUST be `T = ceil(5 f/b √(q (|l| + |r|) + u²/3))` pixels, with `q =
    //# 1e-6 m`, `u` of MOTION-1, the axle `b`, and `|l|` and `|r|` the sums of the lengths of the wheels' ways between
    //# both times; at rest it is 0.
    #[test]
    fn the_play_is_five_standard_deviations_of_the_turn() {
        let ways = [Ways { left: 0.006, right: 0.006 }, Ways { left: 0.0071, right: 0.0071 }];
        let skew = Skew::of_ways(&ways, &Drive::epuck(), &Pose::new(0.03, 0.0, 0.0), &Camera::epuck());
        assert_eq!(skew.play(), 11);
        assert_eq!(Skew::at_rest().play(), 0);
    }

    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-4** The *shift of an end* `t`, -1 for the first pixel and 1 for the last one, MUST be `c'(t) - c(t)`
    //# with `c(t) = (a + s t)/(1 + k t)`, rounded to the nearest pixel, halves up.
    #[test]
    fn ends_are_rounded_halves_up() {
        let at = |a: f64, s: f64| Homography { a, s, k: 0.0 };
        assert_eq!(Ends::of(&at(0.0, 20.0), &at(0.5, 20.0)), Ends { first: 1, last: 1 });
        assert_eq!(Ends::of(&at(0.0, 20.0), &at(-0.5, 20.0)), Ends { first: 0, last: 0 });
        assert_eq!(Ends::of(&at(0.0, 20.0), &at(-1.0, 22.0)), Ends { first: -3, last: 1 });
        let ends = Ends { first: -3, last: 1 };
        assert!(ends.join((100, 160), (100, 164), 3) && !ends.join((100, 160), (101, 161), 3));
        assert!(ends.join((1, 60), (0, 61), 2) && !ends.join((1, 60), (1, 61), 2));
    }
}
