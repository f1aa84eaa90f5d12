//! Views of a point, seen by both pipelines.

use super::point::{Point, Rows};
use super::spread::{Band, Spread};
use crate::lockstep::Setting;
use crate::paper_estimate::paper_estimates;
use crate::port::{Cameras, Landmarks};
use crate::scenes::{Lines, generator, payload, viewpoint};
use crate::trace::{DetectionTrace, Trace};
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rayon::prelude::*;
use reference::bound::{Bound, bound, homography_of};
use reference::camera::Camera;
use reference::codeword;
use reference::crossing::CrossingRule;
use reference::frame::{self, Pose, wrap};
use reference::homography::Homography;
use reference::landmark::{Format, Landmark};
use reference::render::{Light, Posted, Scene, Sensor, render};

/// One of the two pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pipeline {
    /// In float64.
    Reference,
    /// In fixed point.
    Fixedpoint,
}

/// What a pose is computed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// The fit to the grey levels.
    Fit,
    /// Whole-pixel transitions, with the covariance of (11) and (12).
    Paper,
}

/// Errors of one pipeline and estimator over the views of a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Views.
    pub views: u64,
    /// Views in which the landmark was found.
    pub found: u64,
    /// Width of the narrowest stripe, pixels.
    pub stripe: Spread,
    /// Error along the major axis of each view's bound, metres.
    pub major: Spread,
    /// Error along its minor axis, metres.
    pub minor: Spread,
    /// Error of the heading, radians.
    pub theta: Spread,
    /// The bound along the major axis, metres.
    pub major_bound: Spread,
    /// The bound along the minor axis, through the bend, metres (BOUND-3).
    pub minor_bound: Spread,
    /// The bound on the heading, radians.
    pub theta_bound: Spread,
    /// The first and the last of these errors by the view's bound.
    pub major_ratio: Spread,
    /// Heading's error by the view's bound.
    pub theta_ratio: Spread,
    /// Errors of `a`, `s` and `k` by the view's bound.
    pub image_ratio: [Spread; 3],
    /// Normalised squared error in `(x, y, θ)`.
    pub nees: Spread,
    /// Normalised squared error in `(a, s, k)`, of the fit.
    pub image_nees: Spread,
    /// Degrees of freedom of the fit's noise.
    pub freedom: Spread,
}

impl Measured {
    /// Where the mean of `image_nees` has to lie.
    #[must_use]
    pub fn band(&self) -> Band {
        Band::of(self.freedom.mean(), self.found)
    }

    fn add(&mut self, view: &View, estimate: Option<&Estimate>) {
        self.views += 1;
        self.stripe.add(view.narrowest);
        let Some(estimate) = estimate else { return };
        self.found += 1;
        let axes = view.bound.pose.fixed_view::<2, 2>(0, 0).into_owned().symmetric_eigen();
        let long = usize::from(axes.eigenvalues[1] > axes.eigenvalues[0]);
        let error = estimate.error(view);
        let along = |axis: usize| axes.eigenvectors.column(axis).dot(&error.fixed_rows::<2>(0));
        let (major, minor) = (along(long), along(1 - long));
        let short = axes.eigenvectors.column(1 - long);
        let bent = (short.transpose() * view.bound.bent.covariance.fixed_view::<2, 2>(0, 0) * short)[0].sqrt();
        let (major_bound, theta_bound) = (axes.eigenvalues[long].sqrt(), view.bound.pose[(2, 2)].sqrt());
        for (spread, value) in [
            (&mut self.major, major),
            (&mut self.minor, minor),
            (&mut self.theta, error[2]),
            (&mut self.major_bound, major_bound),
            (&mut self.minor_bound, bent),
            (&mut self.theta_bound, theta_bound),
            (&mut self.major_ratio, major / major_bound),
            (&mut self.theta_ratio, error[2] / theta_bound),
        ] {
            spread.add(value);
        }
        self.nees.add(squared(&error, &estimate.covariance));
        let image = Vector3::new(
            estimate.homography.a - view.homography.a,
            estimate.homography.s - view.homography.s,
            estimate.homography.k - view.homography.k,
        );
        for i in 0..3 {
            self.image_ratio[i].add(image[i] / view.bound.image[(i, i)].sqrt());
        }
        if let Some((covariance, freedom)) = &estimate.image {
            self.image_nees.add(squared(&image, covariance));
            self.freedom.add(*freedom);
        }
    }
}

/// The error in standard deviations, squared; infinite where the covariance says nothing.
fn squared(error: &Vector3<f64>, covariance: &Matrix3<f64>) -> f64 {
    covariance.try_inverse().map_or(f64::INFINITY, |inverse| (error.transpose() * inverse * error)[0])
}

/// A view: what is seen, and what can be known of it.
struct View {
    lines: Lines,
    payload: u32,
    landmark: Landmark,
    camera_in_landmark: Pose<frame::Landmark, frame::Camera>,
    homography: Homography,
    bound: Bound,
    narrowest: f64,
}

/// A pose and what is claimed of it.
struct Estimate {
    homography: Homography,
    /// Covariance of `(a, s, k)`, and degrees of freedom of the noise.
    image: Option<(Matrix3<f64>, f64)>,
    pose: (f64, f64, f64),
    covariance: Matrix3<f64>,
}

impl Estimate {
    fn error(&self, view: &View) -> Vector3<f64> {
        let truth = &view.camera_in_landmark;
        let (x, y, theta) = self.pose;
        Vector3::new(x - truth.x(), y - truth.y(), wrap(theta - truth.theta()))
    }

    fn fitted(found: &DetectionTrace) -> Option<Self> {
        let fit = found.fit.as_ref()?;
        Some(Self {
            homography: Homography { a: found.homography.a, s: found.homography.s, k: found.homography.k },
            image: Some((fit.covariance, fit.degrees_of_freedom)),
            pose: (found.pose.x, found.pose.y, found.pose.theta),
            covariance: found.covariance,
        })
    }

    fn of_paper(trace: &Trace, view: &View, camera: &Camera) -> Option<Self> {
        let found = paper_estimates(trace, camera, &[view.landmark]);
        let found = found.iter().find(|found| found.payload == view.payload)?;
        let pose = &found.camera_in_landmark;
        Some(Self {
            homography: found.homography,
            image: None,
            pose: (pose.x(), pose.y(), pose.theta()),
            covariance: found.covariance,
        })
    }
}

/// The errors of both pipelines and both estimators over so many views of a point; the same seed gives the same views,
/// whatever the threads.
///
/// # Panics
/// Never: the camera and the landmarks are those of the grid, which the port holds.
#[must_use]
pub fn measure(point: &Point, views: u64, seed: u64) -> Vec<(Pipeline, Estimator, Measured)> {
    let setting = |rule| Setting {
        cameras: Cameras::new(Camera::epuck()).expect("the e-puck's camera is one of the port's"),
        landmarks: Landmarks::of(vec![point.landmark()]).expect("the default stripe width is one of the port's"),
        rule,
    };
    let (fit, paper) = (setting(CrossingRule::Interpolated), setting(CrossingRule::WholePixel));
    let seen: Vec<(View, [Option<Estimate>; 4])> =
        (0..views).into_par_iter().filter_map(|index| look(point, index, seed, &fit, &paper)).collect();
    let columns = [
        (Pipeline::Reference, Estimator::Fit),
        (Pipeline::Fixedpoint, Estimator::Fit),
        (Pipeline::Reference, Estimator::Paper),
        (Pipeline::Fixedpoint, Estimator::Paper),
    ];
    let mut measured = columns.map(|(pipeline, estimator)| (pipeline, estimator, Measured::default()));
    for (view, estimates) in &seen {
        for ((_, _, measured), estimate) in measured.iter_mut().zip(estimates) {
            measured.add(view, estimate.as_ref());
        }
    }
    measured.to_vec()
}

fn look(point: &Point, index: u64, seed: u64, fit: &Setting, paper: &Setting) -> Option<(View, [Option<Estimate>; 4])> {
    let view = view(point, index, seed)?;
    let [upper, lower] = &view.lines;
    let [reference, port] = fit.run(upper, lower);
    let [reference_paper, port_paper] = paper.run(upper, lower);
    let fitted =
        |trace: &Trace| trace.detections.iter().find(|found| found.payload == view.payload).and_then(Estimate::fitted);
    let camera = &fit.cameras.reference;
    let estimates = [
        fitted(&reference),
        fitted(&port),
        Estimate::of_paper(&reference_paper, &view, camera),
        Estimate::of_paper(&port_paper, &view, camera),
    ];
    Some((view, estimates))
}

/// View `index` of a point: heading up to 0.1 rad off the barcode, less where it would leave the image, a payload and
/// noise of its own, the inclination to either side. `None` if the barcode is not in view.
fn view(point: &Point, index: u64, seed: u64) -> Option<View> {
    let camera = Camera::epuck();
    let stream = u64::from(point.centimetres) << 48 | u64::from(point.degrees) << 40 | index;
    let mut rng = generator(seed, stream);
    let distance = f64::from(point.centimetres) / 100.0;
    let bearing = rng.random_range(-0.1..0.1) * (distance / 0.2).min(1.0);
    let side = if rng.random() { 1.0 } else { -1.0 };
    let word = payload(Format::Paper, &mut rng);
    let landmark = point.landmark();
    let camera_in_world = viewpoint(distance, side * f64::from(point.degrees).to_radians() + bearing, bearing);
    let camera_in_landmark = Pose::new(camera_in_world.x(), camera_in_world.y(), camera_in_world.theta());
    let sensor = Sensor { blur: point.conditions.blur, noise: point.conditions.noise };
    let light = Light::default();
    let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload: word };
    let scene = Scene { camera_in_world, landmarks: vec![posted], clutter: Vec::new(), light, sensor };
    let lines = render(&camera, &scene, &mut rng).ok()?;
    let layers = codeword::layers(Format::Paper, word).ok()?;
    let bound = bound(&camera, &landmark, &camera_in_landmark, &layers, &light, (sensor.blur, sensor.noise))?;
    let edges: Vec<f64> =
        landmark.edges().iter().map(|&b| camera.project_stripe(&camera_in_landmark, b).column).collect();
    let narrowest = edges.windows(2).map(|pair| pair[0] - pair[1]).fold(f64::INFINITY, f64::min);
    Some(View {
        lines,
        payload: word,
        landmark,
        camera_in_landmark,
        homography: homography_of(&camera, &landmark, &camera_in_landmark)?,
        bound,
        narrowest,
    })
}

impl Point {
    /// Both rows see nothing but stripes, as the bound assumes.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        self.rows == Rows::Inside
    }
}
