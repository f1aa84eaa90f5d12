//! What the detections of an image say about the robot.

use super::{Config, Estimation};
use crate::camera::Camera;
use crate::covariance;
use crate::exposure::Time;
use crate::filter::Build;
use crate::frame::{self, Pose, World};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::layers::{self, MeasuredLayer, Measurement, Measurements};
use crate::merge::{Detection, Estimator};
use crate::observation::{Seen, Sighting};
use crate::pose::pose;
use crate::timeline::Observation;
use heapless::Vec;

/// An image, and what it takes to place its detections.
pub(super) struct Sightings<'a> {
    pub(super) config: &'a Config<'a>,
    /// The scan lines.
    pub(super) lines: [&'a [u8]; 2],
    /// When they count as seen.
    pub(super) times: [Time; 2],
    /// The image's number.
    pub(super) image: u32,
}

/// Which of an image's observations: first all that are of the upper row's time, then the others, so that none has to be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    /// At the upper row's time.
    Upper,
    /// At the lower row's, if that is another one.
    Lower,
}

impl Sightings<'_> {
    /// The observations that a detection gives; `None` if the site knows no pose of it (`LOCATE-2`).
    //= reference/SPEC.md#locate
    //# - **LOCATE-2** A detection of which the site knows no pose MUST be left out and counted (`unknown`).
    pub(super) fn of(&self, detection: &Detection, turn: Turn) -> Option<Vec<Observation, 2>> {
        let Config { places, landmarks, .. } = self.config;
        let place = places.landmark_in_world(detection.format, detection.payload)?;
        let landmark = landmarks.iter().find(|landmark| landmark.format == detection.format)?;
        let measurements = self.measurements(detection, landmark, turn);
        let observation = |measurement: &Measurement| Observation {
            time: measurement.time(self.times),
            image: self.image,
            payload: detection.payload,
            layer: measurement.layer,
            sighting: self.sighting(measurement, &place, landmark),
        };
        Some(measurements.iter().map(observation).collect())
    }

    /// A detection's measurements; by the paper's estimator one of what a threshold decoded, and none of the others (`LOCATE-5`).
    //= reference/SPEC.md#locate
    //# - **LOCATE-5** By the paper's estimator, transitions MUST be placed by CROSS-1's whole-pixel rule, and each
    //# detection that a threshold decoded give one pose instead, the merged homography's (MERGE-4), with COV-5's
    //# covariance, at the upper row's time, and the others none.
    fn measurements(&self, detection: &Detection, landmark: &Landmark, turn: Turn) -> Measurements {
        let ([upper, lower], lines) = (self.times, self.lines);
        let Build { camera, .. } = &self.config.build;
        if self.config.estimation == Estimation::Paper {
            let merged = detection.transitions.filter(|_| matches!(turn, Turn::Upper));
            return merged.iter().map(|merged| by_the_paper(merged, landmark, camera)).collect();
        }
        match turn {
            Turn::Upper if upper == lower => layers::layers(lines, camera, landmark, detection),
            Turn::Upper => layers::of_upper_row(lines, camera, landmark, detection).into_iter().collect(),
            Turn::Lower if upper == lower => Measurements::new(),
            Turn::Lower => layers::of_lower_row(lines, camera, landmark, detection).into_iter().collect(),
        }
    }

    /// What a filter is told (`LOCATE-4`); without a covariance of what was seen it is a pose.
    //= reference/SPEC.md#locate
    //# - **LOCATE-4** A filter that is given poses MUST be given OBSERVE-2's of the transform (COV-2, COV-3) of each
    //# measurement.
    fn sighting(
        &self,
        measurement: &Measurement,
        place: &Pose<World, frame::Landmark>,
        landmark: &Landmark,
    ) -> Sighting {
        let Measurement { homography, covariance, pose, pose_covariance, .. } = *measurement;
        let seen = match (self.config.estimation, covariance) {
            (Estimation::Image, Some(covariance)) => Seen::Image { homography, covariance },
            _ => Seen::Pose,
        };
        Sighting { place: *place, landmark: *landmark, pose, covariance: pose_covariance, seen }
    }
}

/// The merged homography's pose (`LOCATE-5`).
fn by_the_paper(merged: &Homography, landmark: &Landmark, camera: &Camera) -> Measurement {
    let pose = pose(merged, camera, landmark);
    let pose_covariance = covariance::paper(&pose, camera);
    let (layer, estimator) = (MeasuredLayer::Both, Estimator::Paper);
    Measurement { layer, homography: *merged, covariance: None, pose, pose_covariance, estimator }
}
