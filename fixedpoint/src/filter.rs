//! An iterated extended Kalman filter: where the robot is, by its steps and by the landmarks that it sees.
//!
//! # How the covariance stays one
//! Predictions work on the covariance itself, and add to its diagonal what rounding could have taken
//! ([`StateCovariance`](crate::motion::StateCovariance)). An observation works on a square root `L` of it, by the method of Potter: whatever is rounded
//! there, what comes out is a square, `L Lᵀ`. A standard deviation of 2 m that an observation reduces to 10 µm is thirty-five
//! binary digits of variance, but eighteen of `L`, which 32-bit factors carry.

pub mod root;
mod update;

use crate::camera::Camera;
use crate::covariance::PoseCovariance;
use crate::formats::{Share, Slip};
use crate::frame::{Pose, Robot, World};
use crate::motion::{self, Drive, MotionModel, State, Ways};
use crate::observation::{self, Mounting, Sighting};
use update::updated;

/// What became of an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The estimate used it (`FILTER-4`).
    Used,
    /// It does not agree with the estimate; the candidate used it or is now it (`FILTER-6`).
    Gated,
    /// The candidate used it and replaced the estimate (`FILTER-7`).
    Recovered,
}

/// How many observations had which outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// [`Outcome::Used`].
    pub used: u32,
    /// [`Outcome::Gated`].
    pub gated: u32,
    /// [`Outcome::Recovered`].
    pub recovered: u32,
}

/// What the filter says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// The robot's pose in the world.
    pub pose: Pose<World, Robot>,
    /// Its covariance.
    pub covariance: PoseCovariance,
    /// By how much the right wheel is larger than the left one, as a share of both.
    pub e: Share,
    /// By how much the axle is longer than nominal.
    pub g: Share,
}

/// What the filter knows of the robot's build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Build {
    /// The camera.
    pub camera: Camera,
    /// Where it is mounted.
    pub mounting: Mounting,
    /// The wheels.
    pub drive: Drive,
    /// How they move the robot.
    pub model: MotionModel,
    /// How much they slip.
    pub slip: Slip,
}

/// Another idea of where the robot is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Candidate {
    state: State,
    /// The image of its first observation.
    image: u32,
}

/// The filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    build: Build,
    state: State,
    candidate: Option<Candidate>,
    counts: Counts,
}

impl Filter {
    /// A filter that starts from a state, of three numbers or of five.
    #[must_use]
    pub fn new(build: Build, state: State) -> Self {
        Self { build, state, candidate: None, counts: Counts::default() }
    }

    /// Moves the estimate, and the candidate if there is one, by the ways of the wheels (`FILTER-1`).
    //= reference/SPEC.md#filter
    //# - **FILTER-1** The wheels' ways MUST move the state, and the candidate of FILTER-6 if there is one, by MOTION.
    pub fn predict(&mut self, ways: &Ways) {
        let Build { drive, model, slip, .. } = &self.build;
        motion::predict(&mut self.state, ways, drive, *model, *slip);
        if let Some(candidate) = &mut self.candidate {
            motion::predict(&mut candidate.state, ways, drive, *model, *slip);
        }
    }

    /// Uses a sighting, of the image with the number `image`, for the estimate or for the candidate (`FILTER-2` to `FILTER-8`).
    //= reference/SPEC.md#filter
    //# - **FILTER-6** An observation that is not used MUST become the candidate, its pose and covariance by OBSERVE-2
    //# and of `e` and `g` what the filter knows, unless it agrees with the candidate there is by FILTER-4 and is used
    //# for that.
    //= reference/SPEC.md#filter
    //# - **FILTER-7** A candidate on which observations of two images agree MUST replace the estimate *(choice: both
    //# layers of an image share a check byte)*.
    //= reference/SPEC.md#filter
    //# - **FILTER-8** An observation that is used MUST end the candidate.
    pub fn observe(&mut self, sighting: &Sighting, image: u32) -> Outcome {
        let outcome = self.place(sighting, image);
        let count = match outcome {
            Outcome::Used => &mut self.counts.used,
            Outcome::Gated => &mut self.counts.gated,
            Outcome::Recovered => &mut self.counts.recovered,
        };
        *count = count.saturating_add(1);
        outcome
    }

    fn place(&mut self, sighting: &Sighting, image: u32) -> Outcome {
        let Build { camera, mounting, drive, .. } = &self.build;
        let at = |state: &State| observation::linearised(sighting, state, camera, mounting, drive);
        if let Some(state) = updated(&self.state, at) {
            (self.state, self.candidate) = (state, None);
            return Outcome::Used;
        }
        let agreed = self.candidate.and_then(|known| Some((known.image, updated(&known.state, at)?)));
        match agreed {
            Some((first, state)) if first != image => {
                (self.state, self.candidate) = (state, None);
                Outcome::Recovered
            }
            Some((first, state)) => {
                self.candidate = Some(Candidate { state, image: first });
                Outcome::Gated
            }
            None => {
                let (pose, covariance) = observation::robot_in_world(sighting, mounting);
                self.candidate = Some(Candidate { state: self.state.elsewhere(&pose, &covariance), image });
                Outcome::Gated
            }
        }
    }

    /// What the filter says.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        let State { e, g, covariance, .. } = &self.state;
        Estimate { pose: self.state.pose(), covariance: covariance.pose(), e: *e, g: *g }
    }

    /// The state behind the estimate.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// How many observations had which outcome.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

#[cfg(test)]
mod tests;
