//! The extended Kalman filter of the robot's pose, and how it finds back (FILTER).

use crate::frame::{Pose, wrap};
use crate::motion::{self, Drive, STATES, State, StateCovariance, Ways};
use crate::observation::{Linearised, Sighting};
use nalgebra::{Matrix3, SVector, Vector3};

/// The largest NIS of an observation that is used: 1 in 1,000 of a chi-square of three (FILTER-4).
pub const GATE: f64 = 16.266;

/// Linearisations of an observation at the most (FILTER-2).
pub const ROUNDS: usize = 10;

/// Steps that end the linearisations: metres, and radians (FILTER-2).
const SETTLED: f64 = 2e-5;

/// Images whose observations agree with each other and not with the filter before it believes them (FILTER-7).
pub const AGREEING: usize = 2;

/// What became of an observation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// It was used.
    Used {
        /// Its NIS.
        nis: f64,
    },
    /// It was not, and is remembered as where the robot might be instead.
    Gated {
        /// Its NIS; `None` where the landmark is behind the camera, or the linearisations have not settled.
        nis: Option<f64>,
        /// Its NIS by the candidate that there was; `None` also without one.
        by_candidate: Option<f64>,
    },
    /// It was not, but agreed with one of another image, and the filter begins again where they say.
    Recovered {
        /// Its NIS by the estimate that is given up; `None` as for the gate.
        nis: Option<f64>,
        /// Its NIS by the candidate that it agrees with.
        by_candidate: Option<f64>,
    },
}

impl Outcome {
    /// How near a NIS that decided was to the gate, as a share of it; infinite if none did.
    #[must_use]
    pub fn from_gate(&self) -> f64 {
        let share = |nis: f64| (nis / GATE - 1.0).abs();
        match *self {
            Self::Used { nis } => share(nis),
            Self::Gated { nis, by_candidate } | Self::Recovered { nis, by_candidate } => {
                [nis, by_candidate].into_iter().flatten().map(share).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

/// How often what became of observations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Used ones.
    pub used: u64,
    /// Others that led to no recovery.
    pub gated: u64,
    /// Recoveries.
    pub recovered: u64,
}

/// A state with its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The state.
    pub state: State,
    /// Its covariance.
    pub covariance: StateCovariance,
}

/// Where the robot is if the filter is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    estimate: Estimate,
    /// Images that agree on it, and the last of them.
    images: usize,
    last: u64,
}

/// The filter of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    drive: Drive,
    estimate: Estimate,
    candidate: Option<Candidate>,
    counts: Counts,
}

impl Filter {
    /// A filter that begins with an estimate.
    #[must_use]
    pub fn new(drive: Drive, estimate: Estimate) -> Self {
        Self { drive, estimate, candidate: None, counts: Counts::default() }
    }

    /// The estimate.
    #[must_use]
    pub fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// What became of the observations.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The wheels have moved (FILTER-1).
    //= reference/SPEC.md#filter
    //# - **FILTER-1** The wheels' ways MUST move the state, and the candidate of FILTER-6 if there is one, by MOTION.
    pub fn predict(&mut self, ways: &Ways) {
        self.estimate = self.estimate.predicted(ways, &self.drive);
        if let Some(candidate) = &mut self.candidate {
            candidate.estimate = candidate.estimate.predicted(ways, &self.drive);
        }
    }

    /// A landmark was seen in an image (FILTER-2 to FILTER-8).
    pub fn observe(&mut self, sighting: &Sighting, image: u64) -> Outcome {
        let update = self.estimate.updated(sighting, &self.drive);
        let nis = update.as_ref().map(|update| update.nis);
        match update {
            Some(update) if update.nis <= GATE => {
                self.estimate = update.estimate;
                self.candidate = None;
                self.counts.used += 1;
                Outcome::Used { nis: update.nis }
            }
            _ => self.consider(sighting, image, nis),
        }
    }

    /// FILTER-6 to FILTER-8
    //= reference/SPEC.md#filter
    //# - **FILTER-6** An observation that is not used MUST become the candidate, its pose and covariance by OBSERVE-2
    //# and of `e` and `g` what the filter knows, unless it agrees with the candidate there is by FILTER-4 and is used
    //# for that.
    //= reference/SPEC.md#filter
    //# - **FILTER-7** A candidate on which observations of two images agree MUST replace the estimate *(choice: both
    //# layers of an image share a check byte)*.
    //= reference/SPEC.md#filter
    //# - **FILTER-8** An observation that is used MUST end the candidate.
    fn consider(&mut self, sighting: &Sighting, image: u64, nis: Option<f64>) -> Outcome {
        let updated = self.candidate.and_then(|candidate| {
            let images = candidate.images + usize::from(image != candidate.last);
            Some((candidate.estimate.updated(sighting, &self.drive)?, images))
        });
        let by_candidate = updated.as_ref().map(|(update, _)| update.nis);
        let agreeing = updated.filter(|(update, _)| update.nis <= GATE);
        let agreeing = agreeing.map(|(update, images)| Candidate { estimate: update.estimate, images, last: image });
        let candidate = agreeing.unwrap_or_else(|| self.estimate.replaced(sighting, image));
        if candidate.images < AGREEING {
            self.candidate = Some(candidate);
            self.counts.gated += 1;
            return Outcome::Gated { nis, by_candidate };
        }
        self.estimate = candidate.estimate;
        self.candidate = None;
        self.counts.recovered += 1;
        Outcome::Recovered { nis, by_candidate }
    }
}

/// How much of the way to where a linearisation leads the next one goes (FILTER-9).
///
/// Where an observation bends more than its noise hides, each linearisation goes too far or not far enough by the same share of
/// the way, which two of them show (Aitken's method, along the way).
struct Pace {
    share: f64,
    /// The way before.
    way: Option<Vector3<f64>>,
}

impl Pace {
    /// The share, for the way that the latest linearisation leads.
    //= reference/SPEC.md#filter
    //# - **FILTER-9** Each further linearisation MUST be the share `ω` of the way from the one before to where that
    //# leads, `ω` being 1 at first and then `ω/(1 - r)` within 1/4 and 4, or 4 if `r >= 1`, with `r = d·d'/(d'·d')` of
    //# this way `d` and the way before, `d'`, in metres and radians.
    fn next(&mut self, way: Vector3<f64>) -> f64 {
        if let Some(before) = self.way.replace(way) {
            let rest = 1.0 - way.dot(&before) / before.norm_squared();
            self.share = if rest > 0.0 { (self.share / rest).clamp(0.25, 4.0) } else { 4.0 };
        }
        self.share
    }
}

/// An estimate after an observation.
struct Update {
    estimate: Estimate,
    nis: f64,
}

impl Estimate {
    fn predicted(&self, ways: &Ways, drive: &Drive) -> Self {
        let (state, covariance) = motion::predict(&self.state, &self.covariance, ways, drive);
        Self { state, covariance }
    }

    /// The estimate after an observation: linearised where it leads, until that settles (FILTER-2 to FILTER-5); `None` if
    /// it does not settle, if the landmark is not in front of the camera on the way, or if the innovation's covariance is not
    /// positive definite.
    //= reference/SPEC.md#filter
    //# - **FILTER-2** An observation MUST be linearised at the estimate and again towards where that leads (FILTER-9),
    //# until the position moves by less than 2e-5 m along x and y together and the heading by less than 2e-5 rad, 10
    //# times at most.
    //= reference/SPEC.md#filter
    //# - **FILTER-3** The innovation MUST be `ν = z - h(x_i) + H (x_i - x_0)`, its covariance `S = H P Hᵀ + R`, and the
    //# estimate `x_0 + P Hᵀ S⁻¹ ν`, with `R` the noise and MOTION-7's, angles the short way round.
    //= reference/SPEC.md#filter
    //# - **FILTER-4** An observation MUST be used if its linearisations end before or with the tenth, if its NIS, `νᵀ
    //# S⁻¹ ν` at the last one, is at most 16.266 *(1 in 1,000 of a chi-square of three)*, and if its landmark's centre
    //# is at least 2^-8 m in front of the camera wherever it is linearised.
    //= reference/SPEC.md#filter
    //# - **FILTER-5** The covariance MUST become `(I - K H) P (I - K H)ᵀ + K R Kᵀ`, or what is the same without
    //# rounding.
    fn updated(&self, sighting: &Sighting, drive: &Drive) -> Option<Update> {
        let coarse = motion::step_noise(&self.state, drive);
        let mut state = self.state;
        let mut pace = Pace { share: 1.0, way: None };
        let mut round = 1;
        loop {
            let Linearised { residual, by_state: h, noise } = sighting.linearised(&state)?;
            let noise: Matrix3<f64> = noise + h * coarse * h.transpose();
            // The innovation as if the observation were linear here.
            let innovation = residual + h * difference(&state, &self.state);
            let inverse = (h * self.covariance * h.transpose() + noise).cholesky()?.inverse();
            let gain = self.covariance * h.transpose() * inverse;
            let next = moved(&self.state, &(gain * innovation));
            let step = difference(&next, &state);
            if step[0].abs() + step[1].abs() < SETTLED && step[2].abs() < SETTLED {
                // Joseph's form: positive semidefinite whatever the gain.
                let kept = StateCovariance::identity() - gain * h;
                let covariance = kept * self.covariance * kept.transpose() + gain * noise * gain.transpose();
                let covariance = (covariance + covariance.transpose()) * 0.5;
                let nis = innovation.dot(&(inverse * innovation));
                return Some(Update { estimate: Self { state: next, covariance }, nis });
            }
            if round == ROUNDS {
                return None;
            }
            round += 1;
            state = moved(&state, &(step * pace.next(step.fixed_rows::<3>(0).into())));
        }
    }

    /// Where an observation alone says that the robot is; what is known of the wheels stays (FILTER-6).
    fn replaced(&self, sighting: &Sighting, image: u64) -> Candidate {
        let (pose, spread) = sighting.robot_in_world(&sighting.camera_pose());
        let mut covariance = self.covariance;
        covariance.fixed_view_mut::<3, STATES>(0, 0).fill(0.0);
        covariance.fixed_view_mut::<STATES, 3>(0, 0).fill(0.0);
        covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&spread);
        Candidate { estimate: Self { state: State { pose, ..self.state }, covariance }, images: 1, last: image }
    }
}

/// A state less another one, the angle the short way round.
#[must_use]
pub fn difference(state: &State, from: &State) -> SVector<f64, STATES> {
    let (one, other) = (&state.pose, &from.pose);
    SVector::from([
        one.x() - other.x(),
        one.y() - other.y(),
        wrap(one.theta() - other.theta()),
        state.wheel_difference - from.wheel_difference,
        state.axle_excess - from.axle_excess,
    ])
}

/// A state moved by a difference.
fn moved(state: &State, by: &SVector<f64, STATES>) -> State {
    let pose = &state.pose;
    State {
        pose: Pose::new(pose.x() + by[0], pose.y() + by[1], wrap(pose.theta() + by[2])),
        wheel_difference: state.wheel_difference + by[3],
        axle_excess: state.axle_excess + by[4],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bound::homography_of;
    use crate::camera::Camera;
    use crate::homography::Homography;
    use crate::landmark::{Format, Landmark};
    use crate::observation::Seen;
    use core::f64::consts::PI;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Standard deviations of `(a, s, k)` in these tests.
    const NOISE: [f64; 3] = [0.05, 0.03, 3e-4];

    fn covariance(deviations: [f64; STATES]) -> StateCovariance {
        StateCovariance::from_diagonal(&SVector::from(deviations.map(|deviation| deviation * deviation)))
    }

    fn state(x: f64, y: f64, theta: f64) -> State {
        State { pose: Pose::new(x, y, theta), wheel_difference: 0.0, axle_excess: 0.0 }
    }

    /// Landmarks at the ends of a corridor of 1 m along x.
    fn landmark(robot: &State) -> Pose<crate::frame::World, crate::frame::Landmark> {
        if robot.pose.theta().abs() < PI / 2.0 { Pose::new(1.0, 0.0, PI) } else { Pose::new(0.0, 0.0, 0.0) }
    }

    /// What a robot sees, with noise and the floor that OBSERVE-4 knows of.
    fn sighting(robot: &State, rng: &mut ChaCha8Rng) -> Sighting {
        let landmark_in_world = landmark(robot);
        let camera_in_robot = Pose::new(0.03, 0.0, 0.0);
        let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
        let truth = homography_of(&camera, &landmark, &(landmark_in_world.inverse() * robot.pose * camera_in_robot));
        let Homography { a, s, k } = truth.unwrap();
        let mut draw = |i: usize| {
            let normal: f64 = StandardNormal.sample(rng);
            normal * NOISE[i].hypot(crate::observation::FLOOR[i])
        };
        let homography = Homography { a: a + draw(0), s: s + draw(1), k: k + draw(2) };
        let covariance = Matrix3::from_diagonal(&NOISE.map(|deviation| deviation * deviation).into());
        let seen = Seen::Image { homography, covariance };
        Sighting { landmark_in_world, landmark, camera, camera_in_robot, seen }
    }

    fn filter(estimate: State, deviations: [f64; STATES]) -> Filter {
        Filter::new(Drive::epuck(), Estimate { state: estimate, covariance: covariance(deviations) })
    }

    const START: [f64; STATES] = [0.005, 0.005, 0.02, 0.002, 0.005];

    /// FILTER-9: a way that shrinks by the share `r` at each linearisation leads to its end at once.
    //= reference/SPEC.md#filter
    //= type=test
    //# - **FILTER-9** Each further linearisation MUST be the share `ω` of the way from the one before to where that
    //# leads, `ω` being 1 at first and then `ω/(1 - r)` within 1/4 and 4, or 4 if `r >= 1`, with `r = d·d'/(d'·d')` of
    //# this way `d` and the way before, `d'`, in metres and radians.
    #[test]
    fn the_next_linearisation_is_where_the_ways_lead() {
        let way = Vector3::new(0.3, -0.4, 1.2);
        for (r, share) in [(0.5, 2.0), (-0.8, 1.0 / 1.8), (0.0, 1.0), (0.9, 4.0), (1.0, 4.0), (1.5, 4.0), (-9.0, 0.25)]
        {
            let mut pace = Pace { share: 1.0, way: None };
            assert!((pace.next(way) - 1.0).abs() < 1e-12);
            assert!((pace.next(way * r) - share).abs() < 1e-12, "{r}");
        }
        // Ways across each other say nothing of each other.
        let mut pace = Pace { share: 1.0, way: Some(way) };
        assert!((pace.next(Vector3::new(0.4, 0.3, 0.0)) - 1.0).abs() < 1e-12);
        // With a share of 2 half of the way is left: twice as far still.
        let mut pace = Pace { share: 2.0, way: Some(way) };
        assert!((pace.next(way * 0.5) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn an_observation_draws_the_estimate_to_the_truth() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let truth = state(0.75, 0.01, 0.05);
        let mut filter = filter(state(0.752, 0.008, 0.06), START);
        for image in 0..20 {
            assert!(matches!(filter.observe(&sighting(&truth, &mut rng), image), Outcome::Used { .. }));
        }
        let error = difference(&filter.estimate().state, &truth);
        let known = filter.estimate().covariance.diagonal();
        assert!((0..3).all(|i| error[i].abs() < 4.0 * known[i].sqrt()), "{error}");
        assert!(known[0].sqrt() < 0.001 && known[2].sqrt() < 0.01);
    }

    /// The NIS of a filter that knows its noise is a chi-square of three.
    //= reference/SPEC.md#filter
    //= type=test
    //# - **FILTER-3** The innovation MUST be `ν = z - h(x_i) + H (x_i - x_0)`, its covariance `S = H P Hᵀ + R`, and the
    //# estimate `x_0 + P Hᵀ S⁻¹ ν`, with `R` the noise and MOTION-7's, angles the short way round.
    #[test]
    fn the_nis_is_a_chi_square() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let truth = state(0.7, 0.02, -0.1);
        let mut sum = 0.0;
        for _ in 0..400 {
            let mut draw = |deviation: f64| -> f64 {
                deviation * {
                    let normal: f64 = StandardNormal.sample(&mut rng);
                    normal
                }
            };
            let start = state(0.7 + draw(0.003), 0.02 + draw(0.003), -0.1 + draw(0.01));
            let mut filter = filter(start, [0.003, 0.003, 0.01, 1e-6, 1e-6]);
            match filter.observe(&sighting(&truth, &mut rng), 0) {
                Outcome::Used { nis } | Outcome::Gated { nis: Some(nis), .. } => sum += nis,
                other => panic!("{other:?}"),
            }
        }
        // 400 of a mean of 3 and a variance of 6: 0.12 of a standard deviation. The steps' noise is not drawn.
        let mean = sum / 400.0;
        assert!((2.5..3.5).contains(&mean), "{mean}");
    }

    //= reference/SPEC.md#filter
    //= type=test
    //# - **FILTER-6** An observation that is not used MUST become the candidate, its pose and covariance by OBSERVE-2
    //# and of `e` and `g` what the filter knows, unless it agrees with the candidate there is by FILTER-4 and is used
    //# for that.
    //= reference/SPEC.md#filter
    //= type=test
    //# - **FILTER-7** A candidate on which observations of two images agree MUST replace the estimate *(choice: both
    //# layers of an image share a check byte)*.
    #[test]
    fn two_images_that_agree_bring_a_kidnapped_robot_back() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let truth = state(0.3, 0.02, PI);
        let mut filter = filter(state(0.7, 0.0, 0.0), START);
        let first = filter.observe(&sighting(&truth, &mut rng), 7);
        assert!(matches!(first, Outcome::Gated { by_candidate: None, .. }), "{first:?}");
        // The other layer of the same image says nothing new.
        let again = filter.observe(&sighting(&truth, &mut rng), 7);
        assert!(matches!(again, Outcome::Gated { by_candidate: Some(nis), .. } if nis <= GATE), "{again:?}");
        let last = filter.observe(&sighting(&truth, &mut rng), 8);
        assert!(matches!(last, Outcome::Recovered { by_candidate: Some(nis), .. } if nis <= GATE), "{last:?}");
        let error = difference(&filter.estimate().state, &truth);
        assert!(error[0].hypot(error[1]) < 0.01 && error[2].abs() < 0.03, "{error}");
        assert_eq!(filter.counts(), Counts { used: 0, gated: 2, recovered: 1 });
    }

    /// SAME-7: whichever NIS decided.
    #[test]
    fn the_nearest_nis_is_how_near_to_the_gate_it_was() {
        let far = Some(2.0 * GATE);
        let near = |outcome: Outcome| (outcome.from_gate() - 0.25).abs() < 1e-12;
        assert!(near(Outcome::Used { nis: 0.75 * GATE }));
        assert!(near(Outcome::Gated { nis: Some(1.25 * GATE), by_candidate: None }));
        assert!(near(Outcome::Gated { nis: far, by_candidate: Some(1.25 * GATE) }));
        assert!(near(Outcome::Recovered { nis: far, by_candidate: Some(0.75 * GATE) }));
        assert!(Outcome::Gated { nis: None, by_candidate: None }.from_gate().is_infinite());
    }

    //= reference/SPEC.md#filter
    //= type=test
    //# - **FILTER-4** An observation MUST be used if its linearisations end before or with the tenth, if its NIS, `νᵀ
    //# S⁻¹ ν` at the last one, is at most 16.266 *(1 in 1,000 of a chi-square of three)*, and if its landmark's centre
    //# is at least 2^-8 m in front of the camera wherever it is linearised.
    //= reference/SPEC.md#filter
    //= type=test
    //# - **FILTER-8** An observation that is used MUST end the candidate.
    #[test]
    fn one_false_landmark_moves_nothing() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let truth = state(0.75, 0.0, 0.0);
        let mut filter = filter(truth, START);
        let mut wrong = sighting(&truth, &mut rng);
        wrong.landmark_in_world = Pose::new(-0.4, 0.6, 1.0);
        let before = *filter.estimate();
        assert!(matches!(filter.observe(&wrong, 1), Outcome::Gated { .. }));
        assert_eq!(*filter.estimate(), before);
        assert!(matches!(filter.observe(&sighting(&truth, &mut rng), 2), Outcome::Used { .. }));
        // What agreed once with the filter forgets the candidate.
        assert!(matches!(filter.observe(&wrong, 3), Outcome::Gated { .. }));
    }

    /// Three states are five of which two are known.
    #[test]
    fn what_is_known_of_the_wheels_stays_known() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let truth = state(0.75, 0.01, 0.05);
        let mut filter = filter(truth, [0.005, 0.005, 0.02, 0.0, 0.0]);
        for image in 0..5 {
            filter.predict(&Ways { left: 1e-9, right: 1e-9 });
            filter.observe(&sighting(&truth, &mut rng), image);
        }
        let Estimate { state, covariance } = filter.estimate();
        assert!(state.wheel_difference.abs() < 1e-18 && state.axle_excess.abs() < 1e-18);
        assert!(covariance.fixed_columns::<2>(3).amax() < 1e-30);
    }
}
