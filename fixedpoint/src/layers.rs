//! What a detection measures: each layer by itself, since each has its own time.

use crate::accept::is_explained;
use crate::camera::Camera;
use crate::covariance::{self, Covariance, PoseCovariance};
use crate::exposure::Time;
use crate::fit::{self, Start};
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::landmark::Landmark;
use crate::merge::{Detection, Estimator, FitSummary, LayerFit, Reading};
use heapless::Vec;

/// Which layers a measurement is of, in the order in which measurements of one time are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MeasuredLayer {
    /// The upper one.
    Upper,
    /// The lower one.
    Lower,
    /// Both, which were fitted together, or not at all (`LAYER-4`).
    Both,
}

/// Where the camera was, as one layer or both of a detection say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measurement {
    /// The layer.
    pub layer: MeasuredLayer,
    /// What the camera saw at the measurement's time.
    pub homography: Homography,
    /// The covariance of `(a, s, k)` (`FIT-14`); none without a fit.
    pub covariance: Option<Covariance>,
    /// The camera's pose at the measurement's time: the mean of `COV-2`, or `POSE` of the merged homography.
    pub pose: Pose<frame::Landmark, frame::Camera>,
    /// The covariance of this pose (`COV-3`, `COV-5`).
    pub pose_covariance: PoseCovariance,
    /// What gave the pose.
    pub estimator: Estimator,
}

impl Measurement {
    /// When the camera was there, both rows' times being given, the upper one's first (`LAYER-3`, `LAYER-4`).
    //= reference/SPEC.md#layer
    //# - **LAYER-3** A layer's measurement MUST be its `(a, s, k)` with the covariance of its own fit, at its row's
    //# time (EXPOSE-1).
    #[must_use]
    pub fn time(&self, [upper, lower]: [Time; 2]) -> Time {
        match self.layer {
            MeasuredLayer::Upper | MeasuredLayer::Both => upper,
            MeasuredLayer::Lower => lower,
        }
    }

    /// The detection's own (`LAYER-4`).
    //= reference/SPEC.md#layer
    //# - **LAYER-4** A detection with a fit of which no layer gives a measurement MUST give one, the detection's own,
    //# and a detection without a fit its pose with COV-5's covariance, both at the upper row's time (SKEW-8).
    fn own(detection: &Detection) -> Self {
        Self {
            layer: MeasuredLayer::Both,
            homography: detection.homography,
            covariance: detection.fit.map(|fit| fit.covariance),
            pose: detection.camera_in_landmark,
            pose_covariance: detection.covariance,
            estimator: detection.estimator(),
        }
    }
}

/// One measurement for each layer, or one for both.
pub type Measurements = Vec<Measurement, 2>;

/// What a detection measures (`LAYER-1` to `LAYER-4`), `lines` being the two scan lines that it was found in and `landmark` the
/// dimensions that it was found with. There is at least one measurement, the upper row's first.
#[must_use]
pub fn layers(lines: [&[u8]; 2], camera: &Camera, landmark: &Landmark, detection: &Detection) -> Measurements {
    let upper = of_upper_row(lines, camera, landmark, detection);
    upper.into_iter().chain(of_lower_row(lines, camera, landmark, detection)).collect()
}

/// What it measures at the upper row's time: the upper layer, or the detection's own measurement if no layer gives one (`LAYER-4`).
#[must_use]
pub fn of_upper_row(
    lines: [&[u8]; 2],
    camera: &Camera,
    landmark: &Landmark,
    detection: &Detection,
) -> Option<Measurement> {
    let source = Source { lines, camera, landmark, detection };
    let own = || source.lower().is_none().then(|| Measurement::own(detection));
    source.upper().or_else(own)
}

/// What it measures at the lower row's time: the lower layer.
#[must_use]
pub fn of_lower_row(
    lines: [&[u8]; 2],
    camera: &Camera,
    landmark: &Landmark,
    detection: &Detection,
) -> Option<Measurement> {
    Source { lines, camera, landmark, detection }.lower()
}

/// What measurements come from.
struct Source<'a> {
    lines: [&'a [u8]; 2],
    camera: &'a Camera,
    landmark: &'a Landmark,
    detection: &'a Detection,
}

impl Source<'_> {
    /// The upper layer's measurement; of a moving camera by the fit that the detection itself is by (`LAYER-1`, `SKEW-8`).
    fn upper(&self) -> Option<Measurement> {
        let ([line, _], layer) = (self.lines, MeasuredLayer::Upper);
        match self.detection.lower_fit {
            Some(_) => Some(Measurement { layer, ..Measurement::own(self.detection) }),
            None => self.alone(layer, line, &self.detection.upper),
        }
    }

    /// The lower layer's measurement; of a moving camera by the fit that it was accepted by (`LAYER-1`, `SKEW-7`).
    fn lower(&self) -> Option<Measurement> {
        let ([_, line], layer) = (self.lines, MeasuredLayer::Lower);
        match &self.detection.lower_fit {
            Some(LayerFit { homography, fit }) => self.measurement(layer, homography, &fit.covariance),
            None => self.alone(layer, line, &self.detection.lower),
        }
    }

    /// At rest: a layer is fitted alone from the fit of both (`LAYER-1`); none without that, or if its own fit is refused or leaves too
    /// much noise (`LAYER-2`).
    //= reference/SPEC.md#layer
    //# - **LAYER-1** Each layer of a detection with a fit MUST be fitted alone (FIT, with one layer), from that fit's
    //# `(a, s, k, σ)` under the light, even or a step, that the fit was made under; of a moving camera these are the
    //# fits of SKEW-7.
    //= reference/SPEC.md#layer
    //# - **LAYER-2** A layer whose own fit is refused, or whose `s²` is above ACCEPT-6's `v` of the detection's decoder
    //# with its own gain, or which COV-4 calls undetermined, MUST give no measurement.
    fn alone(&self, layer: MeasuredLayer, line: &[u8], reading: &Reading) -> Option<Measurement> {
        let Self { camera, detection, .. } = *self;
        let FitSummary { blur, illumination, .. } = detection.fit?;
        let start = Start { homography: detection.homography, blur };
        let alone = [reading.layer(line, detection.format)];
        let fitted = fit::fit(&alone, &start, camera, detection.format, illumination).ok()?;
        if !is_explained(&fitted, detection.decoder) {
            return None;
        }
        self.measurement(layer, &fitted.homography, &fitted.covariance)
    }

    /// `LAYER-3`; none if the fit leaves the heading open (`LAYER-2`).
    fn measurement(
        &self,
        layer: MeasuredLayer,
        homography: &Homography,
        covariance: &Covariance,
    ) -> Option<Measurement> {
        let (pose, pose_covariance) = covariance::transform(homography, covariance, self.camera, self.landmark).ok()?;
        let (homography, covariance, estimator) = (*homography, Some(*covariance), Estimator::Fit);
        Some(Measurement { layer, homography, covariance, pose, pose_covariance, estimator })
    }
}

#[cfg(test)]
mod tests;
