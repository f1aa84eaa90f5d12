//! Where the robot was of late (WORLD-9).

use super::TICK;
use crate::frame::{Pose, Robot, World, wrap};
use std::collections::VecDeque;

/// The robot at every tick since some time.
#[derive(Clone, Debug)]
pub(super) struct Track {
    /// Number of the first tick that is still known.
    first: u64,
    ticks: VecDeque<Tick>,
}

#[derive(Clone, Copy, Debug)]
struct Tick {
    pose: Pose<World, Robot>,
    /// Whether the robot was off the ground since the tick before.
    lifted: bool,
}

impl Track {
    /// A robot that stands there at the time 0.
    pub(super) fn new(pose: Pose<World, Robot>) -> Self {
        Self { first: 0, ticks: VecDeque::from([Tick { pose, lifted: false }]) }
    }

    /// The robot a tick later, and whether it was lifted in between.
    pub(super) fn push(&mut self, pose: Pose<World, Robot>, lifted: bool) {
        self.ticks.push_back(Tick { pose, lifted });
    }

    /// Forgets what was before a time, microseconds.
    pub(super) fn forget_before(&mut self, time: u64) {
        while self.ticks.len() > 1 && (self.first + 1) * TICK <= time {
            self.ticks.pop_front();
            self.first += 1;
        }
    }

    /// The robot's pose at a time, microseconds, between ticks in proportion; none while it was lifted.
    ///
    /// Before the first tick that is known, and after the last one, it is that one's.
    //= reference/SPEC.md#world
    //# - **WORLD-9** Between two ticks the robot MUST count as moving evenly from one pose to the other.
    pub(super) fn at(&self, time: f64) -> Option<Pose<World, Robot>> {
        let ticks = (time / TICK as f64 - self.first as f64).clamp(0.0, (self.ticks.len() - 1) as f64);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to the number of ticks")]
        let before = ticks as usize;
        let part = ticks - before as f64;
        let (Tick { pose: a, lifted }, Some(&b)) = (self.ticks[before], self.ticks.get(before + 1)) else {
            return (!self.ticks[before].lifted).then_some(self.ticks[before].pose);
        };
        if part <= 0.0 {
            return (!lifted).then_some(a);
        }
        let between = |from: f64, to: f64| from + part * (to - from);
        let theta = a.theta() + part * wrap(b.pose.theta() - a.theta());
        (!b.lifted).then(|| Pose::new(between(a.x(), b.pose.x()), between(a.y(), b.pose.y()), wrap(theta)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-9** Between two ticks the robot MUST count as moving evenly from one pose to the other.
    #[test]
    fn between_ticks_a_pose_is_in_proportion_and_turns_the_short_way() {
        let mut track = Track::new(Pose::new(0.0, 1.0, 3.1));
        track.push(Pose::new(0.4, 1.0, -3.1), false);
        let pose = track.at(0.25 * 6250.0).unwrap();
        let theta = 3.1 + 0.25 * (2.0 * PI - 6.2);
        assert!((pose.x() - 0.1).abs() < 1e-12 && (pose.theta() - theta).abs() < 1e-12);
        assert_eq!(track.at(-5.0), Some(Pose::new(0.0, 1.0, 3.1)));
        assert_eq!(track.at(1e9), Some(Pose::new(0.4, 1.0, -3.1)));
    }

    #[test]
    fn nothing_is_known_of_a_lift_and_all_is_known_after_forgetting() {
        let mut track = Track::new(Pose::new(0.0, 0.0, 0.0));
        for (i, lifted) in [(1, false), (2, true), (3, false)] {
            track.push(Pose::new(f64::from(i), 0.0, 0.0), lifted);
        }
        let x = |track: &Track, ticks: f64| track.at(ticks * 6250.0).map(|pose| pose.x());
        let all = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0].map(|ticks| x(&track, ticks));
        assert_eq!(all, [Some(0.5), Some(1.0), None, None, Some(2.5), Some(3.0)]);
        track.forget_before(6250 * 5 / 2);
        assert_eq!(track.ticks.len(), 2);
        assert_eq!([2.25, 2.5, 3.0].map(|ticks| x(&track, ticks)), [Some(2.25), Some(2.5), Some(3.0)]);
    }
}
