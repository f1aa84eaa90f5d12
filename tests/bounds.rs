//! The bounds are neither stale nor loose: they are used, and they are small beside the estimate's own uncertainty.

use nalgebra::{Matrix3, Vector3};
use reference::camera::Camera;
use reference::frame::{self, Pose};
use reference::homography::Homography;
use reference::landmark::{Format, Landmark};
use reference::pose::pose;
use verify::bounds::{self, Class};
use verify::campaign::{Campaign, Plan};
use verify::certificate::Certificate;
use verify::port::Cameras;
use verify::trace::HomographyTrace;

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

/// Standard deviation of one interpolated crossing, pixels, no larger than it can be: noise of 2 grey levels on a contrast
/// of 160, an edge of a 0.5 px Gaussian seen by a pixel (160 · 0.683 grey levels per pixel), the mean of two pixels.
const CROSSING_SIGMA: f64 = 2.0 / (160.0 * 0.683 * core::f64::consts::SQRT_2);

/// (a, s, k) of a view and their covariance if every edge of both layers were a transition.
fn view(
    camera: &Camera,
    landmark: &Landmark,
    truth: &Pose<frame::Landmark, frame::Camera>,
) -> (Homography, Matrix3<f64>) {
    let w = landmark.half_width();
    let [centre, right] = [0.0, w].map(|b| camera.project_stripe(truth, b));
    let k = right.depth / centre.depth - 1.0;
    let a = centre.column - camera.principal_column;
    let s = (right.column - camera.principal_column) * (1.0 + k) - a;
    let mut information = Matrix3::zeros();
    for &b in &landmark.edges() {
        let t = b / w;
        let column = camera.project_stripe(truth, b).column - camera.principal_column;
        let depth = 1.0 + k * t;
        let gradient = Vector3::new(1.0, t, -t * column) / depth;
        information += gradient * gradient.transpose() * (2.0 / CROSSING_SIGMA.powi(2));
    }
    (Homography { a, s, k }, information.try_inverse().unwrap())
}

#[test]
fn pose_bounds_are_at_most_a_twentieth_of_the_standard_deviation() {
    let cameras = Cameras::new(Camera::epuck()).unwrap();
    let camera = &cameras.reference;
    let mut largest: f64 = 0.0;
    for format in Format::ALL {
        let landmark = Landmark::new(format);
        for centimetres in (6..=70).step_by(4) {
            for degrees in (-60..=60).step_by(15) {
                let (distance, theta) = (f64::from(centimetres) / 100.0, f64::from(degrees).to_radians());
                let truth =
                    Pose::new(distance * theta.cos(), distance * theta.sin(), core::f64::consts::PI + theta + 0.1);
                let (h, covariance) = view(camera, &landmark, &truth);
                let found = pose(&h, camera, &landmark);
                let step = [1e-5, 1e-5, 1e-7];
                let moved = |axis: usize| {
                    let mut moved = [h.a, h.s, h.k];
                    moved[axis] += step[axis];
                    pose(&Homography { a: moved[0], s: moved[1], k: moved[2] }, camera, &landmark)
                };
                let sigma = |value: fn(&Pose<frame::Landmark, frame::Camera>) -> f64| {
                    let slope = |axis: usize| frame::wrap(value(&moved(axis)) - value(&found)) / step[axis];
                    let gradient = Vector3::from_fn(|axis, _| slope(axis));
                    gradient.dot(&(covariance * gradient)).sqrt()
                };
                let trace = HomographyTrace { a: h.a, s: h.s, k: h.k };
                let bound = bounds::pose_of_detection(&cameras, &landmark, &trace);
                let shares = [bound.x / sigma(Pose::x), bound.y / sigma(Pose::y), bound.theta / sigma(Pose::theta)];
                for share in shares {
                    assert!(share <= YARDSTICK, "{format:?} {centimetres} cm {degrees}°: {shares:?}");
                    largest = largest.max(share);
                }
            }
        }
    }
    // The standard deviations are not absurdly large, so that the test can fail.
    assert!(largest > 1e-6, "{largest}");
}
