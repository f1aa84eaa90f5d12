//! The wheels alone.

use super::{Known, Rider, Taken, ways};
use crate::log::Event;
use nalgebra::Matrix3;
use reference::exposure::Time;
use reference::filter::Estimate;
use reference::motion::{Drive, predict};

/// A robot that sees nothing.
#[derive(Clone, Debug)]
pub struct Odometry {
    drive: Drive,
    estimate: Estimate,
    time: Time,
}

impl Odometry {
    /// A robot that begins with an estimate at a time.
    #[must_use]
    pub fn new(drive: Drive, start: Estimate, begin: Time) -> Self {
        Self { drive, estimate: start, time: begin }
    }
}

impl Rider for Odometry {
    fn take(&mut self, event: &Event) -> Taken {
        let Event::Reading(reading) = event else { return Taken::default() };
        if Time::from(reading.time) <= self.time {
            return Taken { refused: 1, ..Taken::default() };
        }
        let seconds = Time::from(reading.time).since(self.time) as f64 / 1e6;
        let Estimate { state, covariance } = &self.estimate;
        let (state, covariance) = predict(state, covariance, &ways(&reading.motion, seconds, &self.drive), &self.drive);
        self.estimate = Estimate { state, covariance };
        self.time = reading.time.into();
        Taken::default()
    }

    fn known(&self) -> Known {
        let covariance: Matrix3<f64> = self.estimate.covariance.fixed_view::<3, 3>(0, 0).into();
        Known { pose: self.estimate.state.pose, covariance }
    }
}
