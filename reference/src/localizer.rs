//! From two scan lines and the wheels' steps to the robot's pose (LOCATE).

use crate::camera::Camera;
use crate::covariance::{UncertainPose, paper};
use crate::crossing::CrossingRule;
use crate::detect::detect_moving;
use crate::exposure::{Capture, CaptureRefusal, Stamp, Time};
use crate::filter::{Estimate, Filter, Outcome};
use crate::frame::{self, Pose, Robot, World};
use crate::landmark::{Format, Landmark};
use crate::layers::{Measurement, Part, layers};
use crate::merge::Detection;
use crate::motion::{Drive, Ways};
use crate::observation::{Seen, Sighting};
use crate::observer::Observer;
use crate::places::Places;
use crate::pose::pose;
use crate::skew::Skew;
use crate::timeline::{Counts, Observation, Reading, Timeline, Untimely};

/// What of a detection the filter is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Observe {
    /// `(a, s, k)` of each layer (LAYER-3).
    #[default]
    Image,
    /// The pose that follows from it (LOCATE-4).
    Pose,
    /// The pose that follows from the transitions (LOCATE-5).
    Paper,
}

/// A robot, and what it knows of its site.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Its camera.
    pub camera: Camera,
    /// How that is mounted.
    pub camera_in_robot: Pose<Robot, frame::Camera>,
    /// Its wheels.
    pub drive: Drive,
    /// The landmarks it looks for, one of each format.
    pub landmarks: Vec<Landmark>,
    /// Where they are.
    pub places: Places,
    /// Where transitions lie, if it is not the paper's estimator that is asked.
    pub rule: CrossingRule,
    /// Which time an observation is given.
    pub stamp: Stamp,
    /// What the filter is given.
    pub observe: Observe,
}

/// What became of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed {
    /// The landmark's format.
    pub format: Format,
    /// Its payload, or the number that it came with.
    pub payload: u32,
    /// Of what it was made.
    pub part: Part,
    /// When it was made.
    pub time: Time,
    /// What the filter did; `None` while it waits for a reading.
    pub result: Result<Option<Outcome>, Untimely>,
}

/// What an image gave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sights {
    /// The landmarks that were found.
    pub detections: Vec<Detection>,
    /// What became of their measurements, in the order of their times.
    pub observed: Vec<Observed>,
}

/// A robot that knows where it is.
#[derive(Clone, Debug)]
pub struct Localizer {
    setup: Setup,
    timeline: Timeline,
    images: u64,
    unknown: u64,
    last_from_elsewhere: Option<Time>,
}

impl Setup {
    /// Where transitions lie: by the paper's estimator at whole pixels (LOCATE-5).
    //= reference/SPEC.md#locate
    //# - **LOCATE-5** By the paper's estimator, transitions MUST be placed by CROSS-1's whole-pixel rule, and each
    //# detection that a threshold decoded give one pose instead, the merged homography's (MERGE-4), with COV-5's
    //# covariance, at the upper row's time, and the others none.
    fn crossing_rule(&self) -> CrossingRule {
        if self.observe == Observe::Paper { CrossingRule::WholePixel } else { self.rule }
    }
}

impl Localizer {
    /// A robot that begins with an estimate at a time.
    #[must_use]
    pub fn new(setup: Setup, start: Estimate, begin: Time) -> Self {
        let timeline = Timeline::new(Filter::new(setup.drive, start), begin);
        Self { setup, timeline, images: 0, unknown: 0, last_from_elsewhere: None }
    }

    /// The estimate at the newest reading's time.
    #[must_use]
    pub fn estimate(&self) -> &Estimate {
        self.timeline.estimate()
    }

    /// The newest reading's time.
    #[must_use]
    pub fn time(&self) -> Time {
        self.timeline.time()
    }

    /// What became of readings and observations.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.timeline.counts()
    }

    /// Detections of which the site knows no pose (LOCATE-2).
    #[must_use]
    pub fn unknown(&self) -> u64 {
        self.unknown
    }

    /// The wheels have made these ways, metres by their nominal diameter, since they were read before.
    pub fn read(&mut self, time: Time, ways: Ways) -> Result<(), Untimely> {
        self.timeline.read(&Reading { time, ways })
    }

    /// An image was taken: its two scan lines and when (LOCATE-1 to LOCATE-6).
    //= reference/SPEC.md#locate
    //# - **LOCATE-2** A detection of which the site knows no pose MUST be left out and counted (`unknown`).
    pub fn image<O: Observer>(
        &mut self,
        lines: [&[u8]; 2],
        capture: &Capture,
        observer: &mut O,
    ) -> Result<Sights, CaptureRefusal> {
        capture.check()?;
        self.images += 1;
        let setup = &self.setup;
        let [upper, lower] = lines;
        let rows = [setup.camera.upper_row, setup.camera.lower_row];
        let [above, below] = rows.map(|row| capture.row_time(row, setup.camera.height));
        let ways = self.timeline.ways_between(above, below);
        let skew = Skew::of_ways(&ways, &setup.drive, &setup.camera_in_robot, &setup.camera);
        observer.skew(&skew);
        let detections =
            detect_moving(upper, lower, &setup.camera, &setup.landmarks, setup.crossing_rule(), &skew, observer);
        let mut observations = Vec::new();
        for detection in &detections {
            match setup.places.landmark_in_world(detection.format, detection.payload) {
                None => {
                    self.unknown += 1;
                    observer.unknown(detection);
                }
                Some(place) => observations.extend(self.observations(lines, capture, detection, &place)),
            }
        }
        observations.sort_by_key(|observation| observation.time);
        let mut give = |observation: &Observation| {
            let observed = self.observe(observation);
            observer.observed(observation, observed.result);
            observed
        };
        let observed = observations.iter().map(&mut give).collect();
        Ok(Sights { detections, observed })
    }

    /// The robot was seen in a landmark's frame by somebody else, who tells landmarks apart by a number (LOCATE-7).
    //= reference/SPEC.md#locate
    //# - **LOCATE-7** An observation of the robot's pose in a landmark's frame that comes from elsewhere MUST be taken
    //# as a pose (OBSERVE-2) of a camera in the robot's own place, of a new image if the last one that came from
    //# elsewhere was of another time, its landmark told apart by a number that it comes with.
    pub fn observe_pose(
        &mut self,
        time: Time,
        landmark: u32,
        landmark_in_world: &Pose<World, frame::Landmark>,
        robot_in_landmark: &UncertainPose,
    ) -> Observed {
        if self.last_from_elsewhere != Some(time) {
            self.images += 1;
            self.last_from_elsewhere = Some(time);
        }
        let sighting = Sighting {
            landmark_in_world: *landmark_in_world,
            landmark: Landmark::new(Format::Paper),
            camera: self.setup.camera,
            camera_in_robot: Pose::new(0.0, 0.0, 0.0),
            seen: Seen::Pose(*robot_in_landmark),
        };
        let landmark = (Format::Paper, landmark);
        self.observe(&Observation { time, image: self.images, landmark, part: Part::Both, sighting })
    }

    fn observe(&mut self, observation: &Observation) -> Observed {
        let result = self.timeline.observe(observation);
        let (format, payload) = observation.landmark;
        Observed { format, payload, part: observation.part, time: observation.time, result }
    }

    /// What a detection of a known landmark says (LAYER, LOCATE-3 to LOCATE-5).
    //= reference/SPEC.md#locate
    //# - **LOCATE-3** The measurements of an image (LAYER) MUST be given to the timeline in the order of their times,
    //# the image's number being that of its arrival.
    //= reference/SPEC.md#locate
    //# - **LOCATE-4** A filter that is given poses MUST be given OBSERVE-2's of the transform (COV-2, COV-3) of each
    //# measurement.
    fn observations(
        &self,
        lines: [&[u8]; 2],
        capture: &Capture,
        detection: &Detection,
        place: &Pose<World, frame::Landmark>,
    ) -> Vec<Observation> {
        let Setup { camera, camera_in_robot, stamp, .. } = self.setup;
        let Some(landmark) = self.setup.landmarks.iter().find(|landmark| landmark.format == detection.format) else {
            return Vec::new();
        };
        let measured = match self.setup.observe {
            Observe::Paper => by_transitions(detection, &camera, landmark).into_iter().collect(),
            Observe::Image | Observe::Pose => layers(lines, &camera, detection),
        };
        let observation = |Measurement { part, seen }| {
            let row = if part == Part::Lower { camera.lower_row } else { camera.upper_row };
            let mut sighting =
                Sighting { landmark_in_world: *place, landmark: *landmark, camera, camera_in_robot, seen };
            if self.setup.observe == Observe::Pose {
                sighting.seen = Seen::Pose(sighting.camera_pose());
            }
            let time = capture.seen(row, camera.height, stamp);
            Observation { time, image: self.images, landmark: (detection.format, detection.payload), part, sighting }
        };
        measured.into_iter().map(observation).collect()
    }
}

/// LOCATE-5
fn by_transitions(detection: &Detection, camera: &Camera, landmark: &Landmark) -> Option<Measurement> {
    let camera_in_landmark = pose(&detection.transitions?, camera, landmark);
    let covariance = paper(&camera_in_landmark, camera);
    Some(Measurement { part: Part::Both, seen: Seen::Pose(UncertainPose { camera_in_landmark, covariance }) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::motion::{State, StateCovariance};
    use crate::observer::Silent;
    use crate::render::{Light, Posted, Scene, Sensor, render};
    use nalgebra::Matrix3;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const CAPTURE: Capture =
        Capture { start: Time::from_micros(0), end: Time::from_micros(300_000), processed: Time::from_micros(400_000) };

    /// Where the robot stands: 28 cm before the landmark at (0.5, 0.1) that looks along -x.
    fn truth() -> Pose<World, Robot> {
        Pose::new(0.19, 0.105, 0.03)
    }

    fn setup(observe: Observe) -> Setup {
        Setup {
            camera: Camera::epuck(),
            camera_in_robot: Pose::new(0.03, 0.0, 0.0),
            drive: Drive::epuck(),
            landmarks: vec![Landmark::new(Format::Paper)],
            places: Places::Grid(Grid::default()),
            rule: CrossingRule::Interpolated,
            stamp: Stamp::MidExposure,
            observe,
        }
    }

    fn start() -> Estimate {
        let pose = Pose::new(truth().x() + 0.004, truth().y() - 0.003, truth().theta() + 0.015);
        let covariance = StateCovariance::from_diagonal(&[2.5e-5, 2.5e-5, 4e-4, 4e-6, 2.5e-5].into());
        Estimate { state: State { pose, wheel_difference: 0.0, axle_excess: 0.0 }, covariance }
    }

    fn lines(payload: u32) -> [Vec<u8>; 2] {
        let landmark_in_world = Pose::new(0.5, 0.1, core::f64::consts::PI);
        let posted = Posted { landmark_in_world, landmark: Landmark::new(Format::Paper), payload };
        let camera_in_world = truth() * Pose::new(0.03, 0.0, 0.0);
        let (light, sensor) = (Light::default(), Sensor::default());
        let scene = Scene { camera_in_world, landmarks: vec![posted], clutter: vec![], light, sensor };
        render(&Camera::epuck(), &scene, &mut ChaCha8Rng::seed_from_u64(2)).unwrap()
    }

    /// A robot that stands still and sees a landmark with a payload.
    fn seen(setup: Setup, payload: u32) -> (Localizer, Sights) {
        let mut localizer = Localizer::new(setup, start(), Time::default());
        for tenth in 1..=4 {
            localizer.read(Time::from_micros(100_000 * tenth), Ways::default()).unwrap();
        }
        let lines = lines(payload);
        let sights = localizer.image([&lines[0], &lines[1]], &CAPTURE, &mut Silent).unwrap();
        (localizer, sights)
    }

    fn payload() -> u32 {
        Grid::default().payload(Format::Paper, &Pose::new(0.5, 0.1, core::f64::consts::PI)).unwrap()
    }

    fn error(localizer: &Localizer) -> [f64; 2] {
        let pose = localizer.estimate().state.pose;
        [(pose.x() - truth().x()).hypot(pose.y() - truth().y()), (pose.theta() - truth().theta()).abs()]
    }

    //= reference/SPEC.md#layer
    //= type=test
    //# - **LAYER-3** A layer's measurement MUST be its `(a, s, k)` with the covariance of its own fit, at its row's
    //# time (EXPOSE-1).
    //= reference/SPEC.md#locate
    //= type=test
    //# - **LOCATE-3** The measurements of an image (LAYER) MUST be given to the timeline in the order of their times,
    //# the image's number being that of its arrival.
    #[test]
    fn both_layers_of_a_landmark_correct_the_pose() {
        let (localizer, sights) = seen(setup(Observe::Image), payload());
        let parts: Vec<(Part, u64)> = sights.observed.iter().map(|one| (one.part, one.time.as_micros())).collect();
        assert_eq!(parts, [(Part::Upper, 18_750), (Part::Lower, 281_250)]);
        assert_eq!(localizer.counts().filter.used, 2);
        let [position, heading] = error(&localizer);
        // The start was off by 5 mm and 15 mrad.
        assert!(position < 0.0025 && heading < 0.008, "{position} {heading}");
    }

    //= reference/SPEC.md#locate
    //= type=test
    //# - **LOCATE-4** A filter that is given poses MUST be given OBSERVE-2's of the transform (COV-2, COV-3) of each
    //# measurement.
    //= reference/SPEC.md#locate
    //= type=test
    //# - **LOCATE-5** By the paper's estimator, transitions MUST be placed by CROSS-1's whole-pixel rule, and each
    //# detection that a threshold decoded give one pose instead, the merged homography's (MERGE-4), with COV-5's
    //# covariance, at the upper row's time, and the others none.
    //= reference/SPEC.md#errata
    //= type=test
    //# - **ERRATA-11** The image's time stamp MUST be the paper's, the middle of its processing, only in what
    //# reproduces the paper.
    #[test]
    fn poses_and_the_paper_s_estimate_correct_it_too() {
        let (localizer, _) = seen(setup(Observe::Pose), payload());
        assert_eq!(localizer.counts().filter.used, 2);
        assert!(error(&localizer)[0] < 0.0035);
        let paper = Setup { stamp: Stamp::Processing, ..setup(Observe::Paper) };
        let (localizer, sights) = seen(paper, payload());
        assert_eq!(localizer.counts().filter.used, 1);
        assert_eq!((sights.observed[0].part, sights.observed[0].time.as_micros()), (Part::Both, 350_000));
        assert!(error(&localizer)[0] < 0.006);
    }

    //= reference/SPEC.md#locate
    //= type=test
    //# - **LOCATE-2** A detection of which the site knows no pose MUST be left out and counted (`unknown`).
    #[test]
    fn what_the_site_does_not_know_is_left_out_and_counted() {
        let twelve = Places::Grid(Grid { theta_steps: Some(12), ..Grid::default() });
        let unknown = payload() | 0xf;
        let (localizer, sights) = seen(Setup { places: twelve, ..setup(Observe::Image) }, unknown);
        assert_eq!((sights.detections.len(), sights.observed.len(), localizer.unknown()), (1, 0, 1));
        assert_eq!(localizer.counts().filter.used, 0);
    }

    #[test]
    fn an_image_whose_times_make_no_sense_is_refused() {
        let mut localizer = Localizer::new(setup(Observe::Image), start(), Time::default());
        let white = [255_u8; 480];
        let capture = Capture { end: CAPTURE.start, ..CAPTURE };
        assert_eq!(localizer.image([&white, &white], &capture, &mut Silent), Err(CaptureRefusal::Capture));
    }

    /// Two poses of one time are of one image, and do not confirm each other (LOCATE-7, FILTER-7).
    //= reference/SPEC.md#locate
    //= type=test
    //# - **LOCATE-7** An observation of the robot's pose in a landmark's frame that comes from elsewhere MUST be taken
    //# as a pose (OBSERVE-2) of a camera in the robot's own place, of a new image if the last one that came from
    //# elsewhere was of another time, its landmark told apart by a number that it comes with.
    #[test]
    fn poses_from_elsewhere_at_one_time_are_of_one_image() {
        let mut localizer = Localizer::new(setup(Observe::Image), start(), Time::default());
        let mut pose_at = |millis: u64, landmark: u32| {
            let time = Time::from_micros(1000 * millis);
            localizer.read(time, Ways::default()).ok();
            let far = UncertainPose {
                camera_in_landmark: Pose::new(0.3, 0.0, 1.0),
                covariance: Matrix3::from_diagonal_element(1e-6),
            };
            localizer.observe_pose(time, landmark, &Pose::new(3.0, 3.0, 0.0), &far).result.unwrap().unwrap()
        };
        assert!(matches!(pose_at(100, 1), Outcome::Gated { .. }));
        assert!(matches!(pose_at(100, 2), Outcome::Gated { .. }));
        assert!(matches!(pose_at(500, 1), Outcome::Recovered { .. }));
        let pose = localizer.estimate().state.pose;
        // With nothing mounted in between.
        assert!((pose.x() - 3.3).abs() < 1e-6 && (pose.theta() - 1.0).abs() < 1e-6);
    }
}
