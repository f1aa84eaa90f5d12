//! The reference.

use super::{Known, Rider, Taken, ways};
use crate::log::Event;
use nalgebra::Matrix3;
use reference::covariance::UncertainPose;
use reference::exposure::Time;
use reference::filter::Estimate;
use reference::frame::Pose;
use reference::localizer::{Localizer, Observed, Setup};
use reference::observer::Silent;
use reference::timeline::Counts;

/// The reference's localizer.
#[derive(Clone, Debug)]
pub struct ReferenceRider {
    setup: Setup,
    localizer: Localizer,
    /// Where landmarks that were seen from elsewhere are, by their number.
    elsewhere: Numbers,
}

/// Numbers for landmarks that come with a pose only: the same pose has the same number.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers(Vec<[u64; 3]>);

impl Numbers {
    /// The number of a landmark at a pose.
    pub(super) fn of<A, B>(&mut self, pose: &Pose<A, B>) -> u32 {
        let bits = [pose.x(), pose.y(), pose.theta()].map(f64::to_bits);
        let place = self.0.iter().position(|other| *other == bits).unwrap_or_else(|| {
            self.0.push(bits);
            self.0.len() - 1
        });
        u32::try_from(place).unwrap_or(u32::MAX)
    }
}

impl ReferenceRider {
    /// A robot that begins with an estimate at a time.
    #[must_use]
    pub fn new(setup: Setup, start: Estimate, begin: Time) -> Self {
        let localizer = Localizer::new(setup.clone(), start, begin);
        Self { setup, localizer, elsewhere: Numbers::default() }
    }

    /// Gives it an event: whether it is an image that shows a landmark whose place is known, and how near the gate it was.
    fn give(&mut self, event: &Event) -> (u64, f64) {
        match event {
            Event::Reading(reading) => {
                let seconds = Time::from(reading.time).since(self.localizer.time()) as f64 / 1e6;
                let _ = self.localizer.read(reading.time.into(), ways(&reading.motion, seconds, &self.setup.drive));
                (0, f64::INFINITY)
            }
            Event::Image(image) => {
                let lines = [&image.lines[0][..], &image.lines[1][..]];
                let unknown = self.localizer.unknown();
                let sights = self.localizer.image(lines, &image.capture.into(), &mut Silent).unwrap_or_default();
                let known = sights.detections.len() as u64 > self.localizer.unknown() - unknown;
                (u64::from(known), sights.observed.iter().map(from_gate).fold(f64::INFINITY, f64::min))
            }
            Event::Observation(seen) => {
                let robot = &seen.robot_in_landmark;
                let camera_in_landmark = Pose::new(robot.x(), robot.y(), robot.theta());
                let pose = UncertainPose { camera_in_landmark, covariance: seen.covariance };
                let number = self.elsewhere.of(&seen.landmark_in_world);
                let seen = self.localizer.observe_pose(seen.time.into(), number, &seen.landmark_in_world, &pose);
                (1, from_gate(&seen))
            }
            Event::Truth(_) => (0, f64::INFINITY),
        }
    }
}

/// How near an observation's NIS was to the gate, as a share of it.
fn from_gate(seen: &Observed) -> f64 {
    seen.result.ok().flatten().map_or(f64::INFINITY, |outcome| outcome.from_gate())
}

/// What changed from one count to the next; what is taken anew may also end otherwise than before.
fn between(before: &Counts, after: &Counts) -> Taken {
    let refused = |counts: &Counts| counts.late + counts.duplicate + counts.full;
    Taken {
        used: after.filter.used.saturating_sub(before.filter.used),
        gated: after.filter.gated.saturating_sub(before.filter.gated),
        recovered: after.filter.recovered.saturating_sub(before.filter.recovered),
        refused: refused(after) - refused(before),
        ..Taken::default()
    }
}

impl Rider for ReferenceRider {
    fn take(&mut self, event: &Event) -> Taken {
        let before = self.localizer.counts();
        let (images, from_gate) = self.give(event);
        Taken { images, from_gate, ..between(&before, &self.localizer.counts()) }
    }

    fn known(&self) -> Known {
        let estimate = self.localizer.estimate();
        let covariance: Matrix3<f64> = estimate.covariance.fixed_view::<3, 3>(0, 0).into();
        Known { pose: estimate.state.pose, covariance }
    }
}
