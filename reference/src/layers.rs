//! One measurement for each layer, since each has its own time (LAYER).

use crate::accept::{Limits, determination};
use crate::camera::Camera;
use crate::covariance::UncertainPose;
use crate::fit::{FitLayer, Fitted, Illumination, fit};
use crate::landmark::stripes;
use crate::merge::{Detection, Reading};
use crate::observation::Seen;

/// Of what of an image a measurement is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    /// The upper layer.
    Upper,
    /// The lower layer.
    Lower,
    /// Both layers together.
    Both,
}

/// What one layer of a landmark, or both together, say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Of what it is made.
    pub part: Part,
    /// What was measured.
    pub seen: Seen,
}

/// The measurements of a detection in two lines of the camera (LAYER-1 to LAYER-4).
//= reference/SPEC.md#layer
//# - **LAYER-3** A layer's measurement MUST be its `(a, s, k)` with the covariance of its own fit, at its row's time
//# (EXPOSE-1).
//= reference/SPEC.md#layer
//# - **LAYER-4** A detection with a fit of which no layer gives a measurement MUST give one, the detection's own, and a
//# detection without a fit its pose with COV-5's covariance, both at the upper row's time (SKEW-8).
#[must_use]
pub fn layers(lines: [&[u8]; 2], camera: &Camera, detection: &Detection) -> Vec<Measurement> {
    let Some(accepted) = &detection.fit else {
        let (camera_in_landmark, covariance) = (detection.camera_in_landmark, detection.covariance);
        let seen = Seen::Pose(UncertainPose { camera_in_landmark, covariance });
        return vec![Measurement { part: Part::Both, seen }];
    };
    let together = &accepted.fitted;
    let image = |part, fitted: &Fitted| {
        let seen = Seen::Image { homography: fitted.imaging.homography, covariance: fitted.covariance };
        Measurement { part, seen }
    };
    if let Some(lower) = &detection.lower_fit {
        return vec![image(Part::Upper, together), image(Part::Lower, lower)];
    }
    let own = |part: Part, line: &[u8], reading: &Reading| {
        let found = alone(line, reading, together, camera, detection)?;
        Some(image(part, &found))
    };
    let measured: Vec<Measurement> =
        [own(Part::Upper, lines[0], &detection.upper), own(Part::Lower, lines[1], &detection.lower)]
            .into_iter()
            .flatten()
            .collect();
    if measured.is_empty() { vec![image(Part::Both, together)] } else { measured }
}

/// The light under which a fit was made.
fn illumination(fitted: &Fitted) -> Illumination {
    if fitted.lights.iter().any(|light| light.step.is_some()) { Illumination::Step } else { Illumination::Even }
}

/// The fit of one layer from that of both (LAYER-1) if it can be used (LAYER-2).
//= reference/SPEC.md#layer
//# - **LAYER-1** Each layer of a detection with a fit MUST be fitted alone (FIT, with one layer), from that fit's `(a,
//# s, k, σ)` under the light, even or a step, that the fit was made under; of a moving camera these are the fits of
//# SKEW-7.
//= reference/SPEC.md#layer
//# - **LAYER-2** A layer whose own fit is refused, or whose `s²` is above ACCEPT-6's `v` of the detection's decoder
//# with its own gain, or which COV-4 calls undetermined, MUST give no measurement.
fn alone(line: &[u8], reading: &Reading, together: &Fitted, camera: &Camera, detection: &Detection) -> Option<Fitted> {
    let stripes = stripes(detection.format, reading.half_word);
    let (first_pixel, last_pixel) = (reading.first_pixel, reading.last_pixel);
    let layer = FitLayer { line, first_pixel, last_pixel, stripes: &stripes };
    let fitted = fit(&[layer], &together.imaging, illumination(together), camera, detection.format).ok()?;
    let explained = fitted.variance <= Limits::of(detection.decoder).variance(&fitted);
    let determined = determination(&fitted.imaging.homography, &fitted.covariance, camera).holds();
    (explained && determined).then_some(fitted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bound::homography_of;
    use crate::crossing::CrossingRule;
    use crate::detect::{detect, detect_moving};
    use crate::frame::{self, Pose};
    use crate::landmark::{Format, Landmark};
    use crate::observer::Silent;
    use crate::render::{Light, Posted, Scene, Sensor, render};
    use crate::skew::Skew;
    use core::f64::consts::PI;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// The lines of a camera that is at `upper` when its upper row is exposed and at `lower` when its lower row is.
    fn lines(
        upper: &Pose<frame::World, frame::Camera>,
        lower: &Pose<frame::World, frame::Camera>,
        seed: u64,
    ) -> [Vec<u8>; 2] {
        let line = |pose: &Pose<frame::World, frame::Camera>, row: usize| {
            let landmark = Landmark::new(Format::Paper);
            let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload: 0xcc0d };
            let (clutter, light, sensor) = (vec![], Light::default(), Sensor::default());
            let scene = Scene { camera_in_world: *pose, landmarks: vec![posted], clutter, light, sensor };
            render(&Camera::epuck(), &scene, &mut ChaCha8Rng::seed_from_u64(seed + row as u64)).unwrap()[row].clone()
        };
        [line(upper, 0), line(lower, 1)]
    }

    fn found(lines: &[Vec<u8>; 2], skew: &Skew) -> Vec<Detection> {
        let (camera, rule) = (Camera::epuck(), CrossingRule::Interpolated);
        detect_moving(&lines[0], &lines[1], &camera, &[Landmark::new(Format::Paper)], rule, skew, &mut Silent)
    }

    /// The Mahalanobis distance of what was measured from what the camera at a pose sees.
    fn chi_square(seen: &Seen, pose: &Pose<frame::World, frame::Camera>) -> f64 {
        let in_landmark = Pose::new(pose.x(), pose.y(), pose.theta());
        let truth = homography_of(&Camera::epuck(), &Landmark::new(Format::Paper), &in_landmark).unwrap();
        let Seen::Image { homography, covariance } = seen else { panic!("{seen:?}") };
        let off = homography.minus(&truth);
        let off = nalgebra::Vector3::new(off.a, off.s, off.k);
        off.dot(&(covariance.try_inverse().unwrap() * off))
    }

    /// A robot that drives at 5 cm/s and turns at 0.1 rad/s: 13 mm and 26 mrad between both rows. Either layer is where its own
    /// row saw it: a chi-square of three on the average, 300 of them to a tenth.
    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-7** The layers of a moving camera MUST each be fitted alone from their own homography as ACCEPT-1 says,
    //# the fit of each be asked ACCEPT-3 to ACCEPT-9 and ACCEPT-12 to ACCEPT-17 alone, the upper one first, and both
    //# together ACCEPT-4's ratio of the gains before that; where either has no fit, ACCEPT-10 decides.
    //= reference/SPEC.md#layer
    //= type=test
    //# - **LAYER-1** Each layer of a detection with a fit MUST be fitted alone (FIT, with one layer), from that fit's
    //# `(a, s, k, σ)` under the light, even or a step, that the fit was made under; of a moving camera these are the
    //# fits of SKEW-7.
    #[test]
    fn each_layer_is_measured_where_its_own_row_saw_it() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let (mut sum, mut count, mut lost) = (0.0, 0, 0);
        for seed in 0..160 {
            let (distance, inclination) = (random.random_range(0.15..0.42), random.random_range(-0.7..0.7_f64));
            let upper: Pose<frame::World, frame::Camera> =
                Pose::new(distance * inclination.cos(), distance * inclination.sin(), PI + inclination);
            let motion = Pose::new(0.013, random.random_range(-0.001..0.001), random.random_range(-0.026..0.026));
            let lower = upper * motion;
            // The wheels say 3.3 mrad more or less.
            let noise: f64 = random.sample(StandardNormal);
            let odometry = Pose::new(0.013, motion.y(), motion.theta() + 3.3e-3 * noise);
            let lines = lines(&upper, &lower, 2 * seed);
            let detections = found(&lines, &Skew::of(odometry, 11));
            let [detection] = detections.as_slice() else {
                lost += 1;
                continue;
            };
            assert_eq!(detection.payload, 0xcc0d);
            for measured in layers([&lines[0], &lines[1]], &Camera::epuck(), detection) {
                let pose = if measured.part == Part::Lower { &lower } else { &upper };
                sum += chi_square(&measured.seen, pose);
                count += 1;
            }
        }
        let mean = sum / f64::from(count);
        assert!(lost <= 3 && count >= 300, "{lost} lost, {count} measurements");
        assert!((2.5..3.6).contains(&mean), "{mean}");
    }

    /// 15 cm away the barcode grows by 9 % between the rows, 5.5 px at either end.
    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-8** What a detection of a moving camera says MUST be what is seen at the upper row's time: by the upper
    //# layer's fit, or without a fit by MERGE-4's mean of `s` and `k`, the lower layer's less the shift, and the upper
    //# layer's `a`.
    #[test]
    fn near_the_wall_the_layers_belong_together_only_by_the_motion() {
        let upper = Pose::new(0.15, 0.0, PI);
        let motion = Pose::new(0.013, 0.0, 0.0);
        let lines = lines(&upper, &(upper * motion), 1);
        assert_eq!(found(&lines, &Skew::at_rest()).len(), 0);
        let seen = found(&lines, &Skew::of(motion, 11));
        assert_eq!(seen.len(), 1);
        assert!((seen[0].camera_in_landmark.x() - 0.15).abs() < 0.002, "SKEW-8");
    }

    #[test]
    fn at_rest_both_searches_are_the_same() {
        let pose = Pose::new(0.3, 0.01, PI);
        let lines = lines(&pose, &pose, 3);
        let (camera, rule) = (Camera::epuck(), CrossingRule::Interpolated);
        let still = detect(&lines[0], &lines[1], &camera, &[Landmark::new(Format::Paper)], rule, &mut Silent);
        assert_eq!(still, found(&lines, &Skew::at_rest()));
        assert_eq!(still.len(), 1);
    }

    /// A detection without a fit gives its pose (LAYER-4), and one of which a layer is not there gives the other.
    //= reference/SPEC.md#layer
    //= type=test
    //# - **LAYER-2** A layer whose own fit is refused, or whose `s²` is above ACCEPT-6's `v` of the detection's decoder
    //# with its own gain, or which COV-4 calls undetermined, MUST give no measurement.
    //= reference/SPEC.md#layer
    //= type=test
    //# - **LAYER-4** A detection with a fit of which no layer gives a measurement MUST give one, the detection's own,
    //# and a detection without a fit its pose with COV-5's covariance, both at the upper row's time (SKEW-8).
    #[test]
    fn what_cannot_be_fitted_gives_what_is_left() {
        let pose = Pose::new(0.3, 0.01, PI);
        let lines = lines(&pose, &pose, 3);
        let mut detection = found(&lines, &Skew::at_rest()).remove(0);
        let white = vec![255; 480];
        let measured = layers([&lines[0], &white], &Camera::epuck(), &detection);
        assert_eq!(measured.iter().map(|measured| measured.part).collect::<Vec<_>>(), [Part::Upper]);
        let measured = layers([&white, &white], &Camera::epuck(), &detection);
        assert!(matches!(measured.as_slice(), [Measurement { part: Part::Both, seen: Seen::Image { .. } }]));
        detection.fit = None;
        let measured = layers([&lines[0], &lines[1]], &Camera::epuck(), &detection);
        assert!(matches!(measured.as_slice(), [Measurement { part: Part::Both, seen: Seen::Pose(_) }]));
    }
}
