//! Both filters side by side, fed with the same numbers: those of the port's formats.

use crate::port::{Cameras, Landmarks};
use core::f64::consts::PI;
use fixedpoint::covariance::{Covariance, PoseCovariance};
use fixedpoint::filter::Build;
use fixedpoint::formats::{Angle, Column, Length, Obliquity, Share, Slip, Steps};
use fixedpoint::observation::{Mounting, mounted_ahead};
use nalgebra::Matrix3;
use reference::covariance::UncertainPose;
use reference::filter::Outcome;
use reference::frame::{self, Pose, Robot, World, wrap};
use reference::homography::Homography;
use reference::motion::{Drive, STATES, State, StateCovariance};
use reference::observation::Seen;

/// What of a sight is compared with the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// `(a, s, k)` (OBSERVE-3).
    Image,
    /// The robot's pose (OBSERVE-2).
    Pose,
}

/// A landmark as an image shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where it is.
    pub landmark_in_world: Pose<World, frame::Landmark>,
    /// `(a, s, k)`, columns relative to the principal one.
    pub homography: Homography,
    /// Its covariance, px² and 1.
    pub covariance: Matrix3<f64>,
}

/// The port's numbers and what they are.
fn held<T>(value: f64, unit: f64, of: impl Fn(i64) -> T) -> (T, f64) {
    #[expect(clippy::cast_possible_truncation, reason = "within the formats' ranges")]
    let bits = (value / unit).round() as i64;
    (of(bits), bits as f64 * unit)
}

/// 2 to the power of `-bits`.
fn ulp(bits: i32) -> f64 {
    2.0_f64.powi(-bits)
}

fn to_32(bits: i64) -> i32 {
    i32::try_from(bits).expect("within the format")
}

/// A pose and what the port holds of it: 2^-24 m and 2^-31 π.
///
/// # Panics
/// Beyond ±128 m.
#[must_use]
pub fn held_pose<A, B, C, D>(pose: &Pose<A, B>) -> (fixedpoint::frame::Pose<C, D>, Pose<A, B>) {
    let length = |value: f64| held(value, ulp(24), |bits| Length::from_bits(to_32(bits)));
    let ((x, held_x), (y, held_y)) = (length(pose.x()), length(pose.y()));
    // π itself is the format's -1.
    let turn = |bits: i64| Angle::from_bits(i32::try_from(bits).unwrap_or(i32::MIN));
    let (theta, held_theta) = held(pose.theta(), PI * ulp(31), turn);
    (fixedpoint::frame::Pose::new(x, y, theta), Pose::new(held_x, held_y, wrap(held_theta)))
}

/// The two filters.
#[derive(Clone, Debug)]
pub struct Filters {
    /// The reference's.
    pub reference: reference::filter::Filter,
    /// The port's.
    pub port: fixedpoint::filter::Filter,
    cameras: Cameras,
    landmarks: Landmarks,
    camera_in_robot: Pose<Robot, frame::Camera>,
    drive: Drive,
}

/// The same sight as each is told of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sightings {
    /// The reference.
    pub reference: reference::observation::Sighting,
    /// The port.
    pub port: fixedpoint::observation::Sighting,
}

/// What both made of a sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcomes {
    /// The reference.
    pub reference: Outcome,
    /// The port.
    pub port: fixedpoint::filter::Outcome,
}

impl Outcomes {
    /// Whether they did the same.
    #[must_use]
    pub fn agree(&self) -> bool {
        use fixedpoint::filter::Outcome as Port;
        matches!(
            (self.reference, self.port),
            (Outcome::Used { .. }, Port::Used)
                | (Outcome::Gated { .. }, Port::Gated)
                | (Outcome::Recovered { .. }, Port::Recovered)
        )
    }
}

/// How far the port's estimate is from the reference's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Apart {
    /// Metres.
    pub position: f64,
    /// Radians.
    pub heading: f64,
    /// The largest difference of a covariance's entry, in standard deviations of the reference.
    pub covariance: f64,
}

impl Filters {
    /// Filters that begin at a pose with standard deviations of it, metres and radians, and of the wheels.
    ///
    /// # Panics
    /// If the camera or what is begun with does not fit the port's formats.
    #[must_use]
    pub fn new(cameras: Cameras, landmarks: Landmarks, start: &Pose<World, Robot>, deviations: [f64; STATES]) -> Self {
        let five = deviations[3] > 0.0;
        let slip = if five { fixedpoint::motion::SLIP_OF_FIVE } else { fixedpoint::motion::SLIP_OF_THREE };
        let drive = Drive { slip: f64::from(slip.to_bits()) * ulp(32), ..Drive::epuck() };
        let (pose, held_start) = held_pose(start);
        let variance = |i: usize| held(deviations[i] * deviations[i], ulp(48), |bits| bits);
        let share = |i: usize| held(deviations[i], ulp(32), |bits| Share::from_bits(to_32(bits)));
        let spread = PoseCovariance { xx: variance(0).0, yy: variance(1).0, tt: variance(2).0, ..Default::default() };
        let ((imbalance, e), (axle, g)) = (share(3), share(4));
        let state = fixedpoint::motion::State::new(&pose, &spread).with_wheels(imbalance, axle);
        let variances = [variance(0).1, variance(1).1, variance(2).1, e * e, g * g];
        let estimate = reference::filter::Estimate {
            state: State { pose: held_start, wheel_difference: 0.0, axle_excess: 0.0 },
            covariance: StateCovariance::from_diagonal(&variances.into()),
        };
        let mounting = mounted_ahead();
        Self {
            reference: reference::filter::Filter::new(drive, estimate),
            port: fixedpoint::filter::Filter::new(build(&cameras, mounting, slip), state),
            cameras,
            landmarks,
            camera_in_robot: Pose::new(mounting.x.to_num(), mounting.y.to_num(), 0.0),
            drive,
        }
    }

    /// The wheels have turned by whole steps.
    pub fn predict(&mut self, [left, right]: [i16; 2]) {
        let way = |steps: i16| f64::from(steps) * self.drive.step();
        self.reference.predict(&reference::motion::Ways { left: way(left), right: way(right) });
        let ways = fixedpoint::motion::Ways { left: Steps::from_num(left), right: Steps::from_num(right) };
        self.port.predict(&ways);
    }

    /// What both are told of a landmark of the first kind; `None` if the port cannot say where it saw it from (COV-4).
    #[must_use]
    pub fn sightings(&self, sight: &Sight, measure: Measure) -> Option<Sightings> {
        let (place, landmark_in_world) = held_pose(&sight.landmark_in_world);
        let (homography, held_homography) = held_homography(&sight.homography);
        let (covariance, held_covariance) = held_covariance(&sight.covariance);
        let (reference_landmark, landmark) = (self.landmarks.reference[0], self.landmarks.port[0]);
        let transformed = fixedpoint::covariance::transform(&homography, &covariance, &self.cameras.port, &landmark);
        let (pose, spread) = transformed.ok()?;
        let (seen, port_seen) = match measure {
            Measure::Image => (
                Seen::Image { homography: held_homography, covariance: held_covariance },
                fixedpoint::observation::Seen::Image { homography, covariance },
            ),
            Measure::Pose => {
                let camera_in_landmark = Pose::new(pose.x.to_num(), pose.y.to_num(), radians(pose.theta));
                let seen = UncertainPose { camera_in_landmark, covariance: matrix(&spread) };
                (Seen::Pose(seen), fixedpoint::observation::Seen::Pose)
            }
        };
        let port = fixedpoint::observation::Sighting { place, landmark, pose, covariance: spread, seen: port_seen };
        let reference = reference::observation::Sighting {
            landmark_in_world,
            landmark: reference_landmark,
            camera: self.cameras.reference,
            camera_in_robot: self.camera_in_robot,
            seen,
        };
        Some(Sightings { reference, port })
    }

    /// Both are shown a landmark of the first kind; `None` if the port cannot say where it saw it from (COV-4).
    pub fn observe(&mut self, sight: &Sight, measure: Measure, image: u32) -> Option<Outcomes> {
        let sightings = self.sightings(sight, measure)?;
        Some(Outcomes {
            reference: self.reference.observe(&sightings.reference, u64::from(image)),
            port: self.port.observe(&sightings.port, image),
        })
    }

    /// How far they are from each other.
    #[must_use]
    pub fn apart(&self) -> Apart {
        Apart::of(self.reference.estimate(), self.port.state())
    }
}

impl Apart {
    /// How far the port's state is from the reference's estimate.
    #[must_use]
    pub fn of(estimate: &reference::filter::Estimate, state: &fixedpoint::motion::State) -> Self {
        let held = state.pose();
        let [x, y] = [held.x, held.y].map(|length| length.to_num::<f64>());
        let theta = radians(held.theta);
        let pose = &estimate.state.pose;
        let found = matrix(&state.covariance().pose());
        let known: Matrix3<f64> = estimate.covariance.fixed_view::<3, 3>(0, 0).into();
        Self {
            position: (pose.x() - x).hypot(pose.y() - y),
            heading: wrap(pose.theta() - theta).abs(),
            covariance: crate::lockstep::relative(&known, &found),
        }
    }
}

fn build(cameras: &Cameras, mounting: Mounting, slip: Slip) -> Build {
    let (drive, model) = (fixedpoint::motion::Drive::epuck(), fixedpoint::motion::MotionModel::default());
    Build { camera: cameras.port, mounting, drive, model, slip }
}

/// The port's π is -1.
pub(crate) fn radians(angle: Angle) -> f64 {
    wrap(f64::from(angle.to_bits()) * PI * ulp(31))
}

/// A covariance of a pose in m², m rad and rad².
pub(crate) fn matrix(c: &PoseCovariance) -> Matrix3<f64> {
    Matrix3::new(c.xx, c.xy, c.xt, c.xy, c.yy, c.yt, c.xt, c.yt, c.tt).map(|bits| bits as f64 * ulp(48))
}

/// 2^-20 px and 2^-30.
fn held_homography(h: &Homography) -> (fixedpoint::homography::Homography, Homography) {
    let column = |value: f64| held(value, ulp(20), |bits| Column::from_bits(to_32(bits)));
    let ((a, held_a), (s, held_s)) = (column(h.a), column(h.s));
    let (k, held_k) = held(h.k, ulp(30), |bits| Obliquity::from_bits(to_32(bits)));
    (fixedpoint::homography::Homography { a, s, k }, Homography { a: held_a, s: held_s, k: held_k })
}

/// 2^-50 px².
fn held_covariance(c: &Matrix3<f64>) -> (Covariance, Matrix3<f64>) {
    let entry = |i: usize, j: usize| held(c[(i, j)], ulp(50), |bits| bits);
    let [aa, as_, ak, ss, sk, kk] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(i, j)| entry(i, j));
    let held = Matrix3::new(aa.1, as_.1, ak.1, as_.1, ss.1, sk.1, ak.1, sk.1, kk.1);
    (Covariance { aa: aa.0, as_: as_.0, ak: ak.0, ss: ss.0, sk: sk.0, kk: kk.0 }, held)
}
