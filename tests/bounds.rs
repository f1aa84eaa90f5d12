//! The bounds are neither stale nor loose: they are used, and they are small beside the estimate's own uncertainty.

use nalgebra::Matrix3;
use reference::camera::Camera;
use reference::crossing::CrossingRule;
use verify::bounds::Class;
use verify::campaign::{Campaign, Plan};
use verify::certificate::Certificate;
use verify::lockstep::Setting;
use verify::port::{Cameras, Landmarks};
use verify::scenes::Scenes;

/// Largest ratio of a bound to anything seen in a full campaign.
const STALE: f64 = 4.0;

/// Largest ratio of a pose's bound to the pose's standard deviation.
const YARDSTICK: f64 = 0.05;

#[test]
fn no_bound_is_stale() {
    let plan = Plan { frames: 20_000, seed: 11, renders: Vec::new() };
    let (findings, _) = Campaign::new(&plan, None, &|_| {}).run();
    for stage in Certificate::new(&plan, &findings, &[]).stages {
        if stage.class == Class::Bounded {
            assert!(stage.share >= 1.0 / STALE, "{} uses {:.3} of its bound: tighten it", stage.stage, stage.share);
        }
    }
}

/// Whatever is bounded of a fit is known to a twentieth of its standard deviation, in scenes with a sensor's noise and in
/// those without any, where rounding to whole grey levels is all there is.
#[test]
fn pose_bounds_are_at_most_a_twentieth_of_the_standard_deviation() {
    let cameras = Cameras::new(Camera::epuck()).unwrap();
    let setting = Setting { cameras, landmarks: Landmarks::both(), rule: CrossingRule::Interpolated };
    let camera = &setting.cameras.reference;
    let scenes = Scenes::new(12);
    let (mut seen, mut largest) = (0, 0.0_f64);
    for index in 0..2000 {
        let [upper, lower] = scenes.scene(camera, index).staged.render(camera);
        for found in setting.run_reference(&upper, &lower).detections {
            let Some(bounds) = setting.fit_bounds(&found) else { continue };
            let (fit, pose) = (found.fit.unwrap(), setting.pose_bounds(&found).unwrap());
            let deviation = |of: &Matrix3<f64>, i: usize| of[(i, i)].sqrt();
            let h = bounds.homography;
            let shares =
                [h.a, h.s, h.k].into_iter().enumerate().map(|(i, bound)| bound / deviation(&fit.covariance, i));
            // Less the resolution of a length, 2^-24 m: at 8 cm y is known to a micrometre.
            let resolution = 2.0_f64.powi(-24);
            let poses = [pose.x - resolution, pose.y - resolution, pose.theta].into_iter().enumerate();
            let shares = shares.chain(poses.map(|(i, bound)| bound / deviation(&found.covariance, i)));
            let worst = shares.fold(bounds.blur / fit.blur_deviation, f64::max);
            assert!(worst <= YARDSTICK, "scene {index}: {worst} of {found:?}");
            largest = largest.max(worst);
            seen += 1;
        }
    }
    assert!(seen > 1000 && largest > 0.1 * YARDSTICK, "{seen} {largest}");
}
