#![allow(clippy::cast_possible_truncation)] // of numbers in range

use super::*;
use crate::camera::Camera;
use crate::codeword::encode;
use crate::decode::DecodedLayer;
use crate::drawing::View;
use crate::formats::{Angle, GridStep, Length};
use crate::grid::Grid;
use crate::homography::Homography;
use crate::landmark::Format;
use crate::merge::{Detection, mean};
use crate::motion::{Drive, MotionModel, SLIP_OF_THREE};
use crate::observation::{Seen as Compared, mounted_ahead};
use crate::observer::Silent;
use crate::places::Listed;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use std::vec::Vec;

const F: f64 = 640.0;
const PAYLOAD: u32 = 0x1C37;
const LANDMARKS: [Landmark; 2] = [Landmark::paper(), Landmark::wide()];

fn ms(milliseconds: u64) -> Time {
    Time::from_micros(milliseconds * 1_000)
}

fn fixed<Parent, Child>([x, y, theta]: [f64; 3]) -> Pose<Parent, Child> {
    let turn = ((theta + PI).rem_euclid(2.0 * PI) - PI) / PI * 2_f64.powi(31);
    Pose::new(Length::from_num(x), Length::from_num(y), Angle::from_bits(turn as i32))
}

fn composed([x, y, theta]: [f64; 3], [ahead, aside, turn]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = theta.sin_cos();
    [x + cos * ahead - sin * aside, y + sin * ahead + cos * aside, theta + turn]
}

fn inverted([x, y, theta]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = theta.sin_cos();
    [-(cos * x + sin * y), sin * x - cos * y, -theta]
}

fn variances([x, y, theta]: [f64; 3]) -> PoseCovariance {
    let variance = |deviation: f64| (deviation * deviation * 2_f64.powi(48)) as i64;
    PoseCovariance { xx: variance(x), yy: variance(y), tt: variance(theta), ..PoseCovariance::default() }
}

/// Where the landmark of the tests stands, 40 cm ahead of the world's origin.
const PLACE: [f64; 3] = [0.4, 0.1, PI + 0.2];

fn listed(format: Format, payload: u32) -> [Listed; 1] {
    [Listed { format, payload, pose: fixed(PLACE) }]
}

fn config(places: Places<'_>) -> Config<'_> {
    let build = Build {
        camera: Camera::epuck(),
        mounting: mounted_ahead(),
        drive: Drive::epuck(),
        model: MotionModel::Arc,
        slip: SLIP_OF_THREE,
    };
    Config {
        build,
        rows: Rows::epuck(),
        landmarks: &LANDMARKS,
        places,
        stamp: Stamp::default(),
        estimation: Estimation::default(),
        rule: CrossingRule::default(),
    }
}

fn reading(time: Time, left: i16, right: i16) -> Reading {
    Reading { time, left: left.into(), right: right.into() }
}

/// It begins at 1 s, with a robot that is known to be near a pose.
fn localizer<'a>(config: &Config<'a>, robot: [f64; 3]) -> Localizer<'a> {
    Localizer::new(*config, State::new(&fixed(robot), &variances([0.02, 0.02, 0.05])), ms(1_000))
}

/// What a robot sees of the landmark (`OBSERVE-3`).
fn view(format: Format, robot: [f64; 3]) -> View {
    let camera = composed(inverted(PLACE), composed(robot, [0.03, 0.0, 0.0]));
    let [depth, left, _] = inverted(camera);
    let half_width = 0.0015 * f64::from(format.stripes()) / 2.0;
    let (sin, cos) = camera[2].sin_cos();
    let [a, s, k] = [-F * left / depth, -F * half_width * cos / depth, half_width * sin / depth];
    View { format, a, s, k, blur: 0.5, white: 200.0, gain: -160.0, noise: 2.0 }
}

/// Both scan lines, the robot being at one pose for the upper one and at another for the lower one.
fn lines(format: Format, [first, then]: [[f64; 3]; 2]) -> [Vec<u8>; 2] {
    let random = &mut ChaCha8Rng::seed_from_u64(7);
    let (upper, lower) = encode(format, PAYLOAD).unwrap();
    [view(format, first).line(480, upper, random), view(format, then).line(480, lower, random)]
}

/// Exposed at 1518.75 ms and 1781.25 ms, 262.5 ms apart.
fn capture() -> Capture {
    Capture::new(ms(1_500), ms(1_800), ms(1_881)).unwrap()
}

const UPPER_TIME: Time = Time::from_micros(1_518_750);
const LOWER_TIME: Time = Time::from_micros(1_781_250);

/// What a localizer reports beside the detector's own.
#[derive(Default)]
struct Recorder {
    skew: Skew,
    layers: Vec<Homography>,
    detections: Vec<Detection>,
    unknown: Vec<u32>,
    observed: Vec<(Observation, Result<Option<Outcome>, Untimely>)>,
}

impl Observer for Recorder {
    fn skew(&mut self, skew: &Skew) {
        self.skew = *skew;
    }
    fn decoded(&mut self, layer: &DecodedLayer) {
        self.layers.push(layer.homography);
    }
    fn detection(&mut self, detection: &Detection) {
        self.detections.push(*detection);
    }
    fn unknown(&mut self, detection: &Detection) {
        self.unknown.push(detection.payload);
    }
    fn observed(&mut self, observation: &Observation, outcome: Result<Option<Outcome>, Untimely>) {
        self.observed.push((*observation, outcome));
    }
}

fn image(localizer: &mut Localizer<'_>, lines: &[Vec<u8>; 2]) -> (Seen, Recorder) {
    let mut recorder = Recorder::default();
    let [upper, lower] = lines;
    let seen = localizer.image(upper, lower, &capture(), &mut Workspace::new(), &mut recorder);
    (seen, recorder)
}

/// A state's distance from a pose in its standard deviations, of x, y and heading each.
fn deviations(state: &State, [x, y, theta]: [f64; 3]) -> [f64; 3] {
    let (pose, covariance) = (state.pose(), state.covariance().pose());
    let turn = f64::from(pose.theta.to_bits()) * PI / 2_f64.powi(31) - theta;
    let apart = [pose.x.to_num::<f64>() - x, pose.y.to_num::<f64>() - y, (turn + PI).rem_euclid(2.0 * PI) - PI];
    let variances = [covariance.xx, covariance.yy, covariance.tt].map(|variance| variance as f64 / 2_f64.powi(48));
    core::array::from_fn(|i| apart[i].abs() / variances[i].sqrt())
}

/// A robot at rest 2 cm from where it thinks it is: by images and by poses it learns where it is, each layer telling it at its time.
//= reference/SPEC.md#locate
//= type=test
//# - **LOCATE-4** A filter that is given poses MUST be given OBSERVE-2's of the transform (COV-2, COV-3) of each
//# measurement.
#[test]
fn a_robot_at_rest_learns_from_both_layers() {
    let (robot, believed) = ([0.01, -0.01, 0.05], [0.0, 0.0, 0.0]);
    for (format, estimation) in [(Format::Paper, Estimation::Image), (Format::Wide, Estimation::Pose)] {
        let known = listed(format, PAYLOAD);
        let mut localizer = localizer(&Config { estimation, ..config(Places::Table(&known)) }, believed);
        localizer.read(&reading(ms(1_900), 0, 0)).unwrap();
        let before = localizer.estimate().covariance().pose();
        let (seen, heard) = image(&mut localizer, &lines(format, [robot; 2]));
        assert_eq!(seen, Seen { detections: 1, used: 2, ..Seen::default() });
        let order: Vec<_> = heard.observed.iter().map(|(seen, _)| (seen.time, seen.layer, seen.image)).collect();
        assert_eq!(order, [(UPPER_TIME, MeasuredLayer::Upper, 0), (LOWER_TIME, MeasuredLayer::Lower, 0)]);
        let by_image = heard.observed.iter().all(|(seen, _)| matches!(seen.sighting.seen, Compared::Image { .. }));
        assert_eq!(by_image, estimation == Estimation::Image);
        assert_eq!(localizer.counts().timeline.filter.used, 2);
        let after = localizer.estimate().covariance().pose();
        assert!(after.xx < before.xx / 16 && after.yy < before.yy / 4 && after.tt < before.tt / 4, "{after:?}");
        let apart = deviations(localizer.estimate(), robot);
        assert!(apart.iter().all(|apart| *apart < 4.0), "{apart:?}");
        assert_eq!(heard.skew, Skew::AT_REST);
    }
}

/// 40 steps left and 140 right between both rows' times turn the robot by 14°, and the camera with it: to a camera at rest
/// both layers are not of one barcode. Readings are 50 ms apart and reach beyond the rows' times.
#[test]
fn a_turning_robot_learns_by_the_skew_of_its_readings() {
    let known = listed(Format::Paper, PAYLOAD);
    let config = config(Places::Table(&known));
    let step = PI * 0.041 / 1000.0;
    // 10 steps and 30 in 50 ms: the pose at a time, along one arc.
    let at = |time: Time| {
        let share = time.since(ms(1_400)) as f64 / 50_000.0;
        let (way, turn) = (20.0 * share * step, 20.0 * share * step / 0.053);
        let chord = way * (turn / 2.0).sin() / (turn / 2.0);
        [chord * (turn / 2.0 - 0.1).cos(), chord * (turn / 2.0 - 0.1).sin(), turn - 0.1]
    };
    let lines = lines(Format::Paper, [at(UPPER_TIME), at(LOWER_TIME)]);
    let mut moving =
        Localizer::new(config, State::new(&fixed([0.0, 0.0, -0.1]), &variances([0.02, 0.02, 0.05])), ms(1_400));
    let mut resting = moving.clone();
    for i in 1..=10 {
        moving.read(&reading(ms(1_400 + 50 * i), 10, 30)).unwrap();
    }
    let (seen, heard) = image(&mut moving, &lines);
    assert_eq!(seen, Seen { detections: 1, used: 2, ..Seen::default() });
    let apart = deviations(moving.estimate(), at(ms(1_900)));
    assert!(apart.iter().all(|apart| *apart < 4.0), "{apart:?}");
    // SKEW-1 in floating point: the camera at the lower row's time in the one at the upper row's.
    let camera = |time| composed(at(time), [0.03, 0.0, 0.0]);
    let [x, y, turn] = composed(inverted(camera(UPPER_TIME)), camera(LOWER_TIME));
    let found = f64::from(heard.skew.turn.to_bits()) * PI / 2_f64.powi(31);
    let apart = [heard.skew.x.to_num::<f64>() - x, heard.skew.y.to_num::<f64>() - y, found - turn];
    assert!(apart.iter().all(|apart| apart.abs() < 1e-6) && turn > 0.2, "{apart:?}");
    // EXPOSE-3: another stamp, the same skew.
    let mut stamped = Localizer::new(Config { stamp: Stamp::Processing, ..config }, *moving.estimate(), ms(1_400));
    for i in 1..=10 {
        stamped.read(&reading(ms(1_400 + 50 * i), 10, 30)).unwrap();
    }
    let (seen, at_once) = image(&mut stamped, &lines);
    assert_eq!((seen.detections, at_once.skew), (1, heard.skew));
    // LOCATE-6: readings that are not there are those of a camera at rest.
    resting.read(&reading(ms(1_500), 20, 60)).unwrap();
    let (seen, heard) = image(&mut resting, &lines);
    assert_eq!((seen.detections, heard.skew), (0, Skew::AT_REST));
}

/// LOCATE-6: readings up to the middle between both rows' times, 1650 ms, tell half of it.
//= reference/SPEC.md#locate
//= type=test
//# - **LOCATE-6** The skew MUST be that of the readings the timeline holds; where they do not reach back to the upper
//# row's time or on to the lower row's, it counts as at rest for what is missing.
#[test]
fn a_camera_counts_as_at_rest_where_there_is_no_reading() {
    let known = listed(Format::Paper, PAYLOAD);
    let config = config(Places::Table(&known));
    let mut localizer = localizer(&config, [0.0; 3]);
    localizer.read(&reading(ms(1_500), 900, 900)).unwrap();
    localizer.read(&reading(ms(1_650), 80, 80)).unwrap();
    let white = [std::vec![255; 480], std::vec![255; 480]];
    let (seen, heard) = image(&mut localizer, &white);
    assert_eq!(seen, Seen::default());
    // From 1518.75 ms on: 131.25 of 150 ms, 70 steps straight ahead.
    let ahead = 70.0 * PI * 0.041 / 1000.0;
    assert!((heard.skew.x.to_num::<f64>() - ahead).abs() < 1e-8 && heard.skew.turn == Angle::ZERO, "{:?}", heard.skew);
}

/// LOCATE-2: another payload, the payload of another format, and no such heading.
//= reference/SPEC.md#locate
//= type=test
//# - **LOCATE-2** A detection of which the site knows no pose MUST be left out and counted (`unknown`).
#[test]
fn what_the_site_does_not_know_is_counted() {
    let lines = lines(Format::Paper, [[0.0; 3]; 2]);
    let (other, wide) = (listed(Format::Paper, PAYLOAD + 1), listed(Format::Wide, PAYLOAD));
    let seven = Grid::new([Length::ZERO; 2], [GridStep::ONE; 2], 7).unwrap(); // the payload's heading is 7
    for places in [Places::Table(&other), Places::Table(&wide), Places::Grid(seven), Places::Table(&[])] {
        let mut localizer = localizer(&config(places), [0.0; 3]);
        let before = *localizer.estimate();
        let (seen, heard) = image(&mut localizer, &lines);
        assert_eq!(seen, Seen { detections: 1, unknown: 1, ..Seen::default() });
        assert_eq!((heard.unknown, heard.observed.len()), (std::vec![PAYLOAD], 0));
        assert_eq!((localizer.counts().unknown, *localizer.estimate()), (1, before));
        image(&mut localizer, &lines);
        assert_eq!(localizer.counts().unknown, 2);
    }
}

/// LOCATE-5: the mean of both layers' homographies, which the detector reports beside its fit; at the upper row's time, or by the
/// paper's stamp half-way through the processing.
//= reference/SPEC.md#locate
//= type=test
//# - **LOCATE-5** By the paper's estimator, transitions MUST be placed by CROSS-1's whole-pixel rule, and each
//# detection that a threshold decoded give one pose instead, the merged homography's (MERGE-4), with COV-5's
//# covariance, at the upper row's time, and the others none.
#[test]
fn the_paper_s_estimator_takes_the_merged_homography() {
    let known = listed(Format::Paper, PAYLOAD);
    let lines = lines(Format::Paper, [[0.17, 0.06, 0.1]; 2]);
    for (stamp, time) in [(Stamp::MidExposure, UPPER_TIME), (Stamp::Processing, Time::from_micros(1_840_500))] {
        let landmarks = &LANDMARKS[..1]; // whose layers are not taken for those of the other format
        let paper = Config { estimation: Estimation::Paper, stamp, landmarks, ..config(Places::Table(&known)) };
        let (seen, heard) = image(&mut localizer(&paper, [0.0; 3]), &lines);
        assert_eq!(seen, Seen { detections: 1, waiting: 1, ..Seen::default() });
        let (observation, outcome) = heard.observed[0];
        assert_eq!((observation.time, observation.layer, outcome), (time, MeasuredLayer::Both, Ok(None)));
        let [upper, lower] = heard.layers[..] else { panic!("{:?}", heard.layers) };
        let merged = mean(&upper, &lower);
        let camera = Camera::epuck();
        let pose = crate::pose::pose(&merged, &camera, &Landmark::paper());
        let Observation { sighting, .. } = observation;
        assert_eq!((sighting.pose, sighting.seen), (pose, Compared::Pose));
        assert_eq!(sighting.covariance, crate::covariance::paper(&pose, &camera));
        assert_ne!(merged, heard.detections[0].homography);
        assert_eq!(heard.detections[0].transitions, Some(merged));
        // By whole pixels, whatever the configuration says.
        let (_, by_rule) = image(&mut localizer(&Config { rule: CrossingRule::WholePixel, ..paper }, [0.0; 3]), &lines);
        assert_eq!(by_rule.layers, heard.layers);
        let images = Config { estimation: Estimation::Image, ..paper };
        assert_ne!(image(&mut localizer(&images, [0.0; 3]), &lines).1.layers, heard.layers);
    }
}

/// LOCATE-3 of two landmarks side by side: the upper layers before the lower ones; by the paper's stamp, of one time, landmark
/// after landmark.
//= reference/SPEC.md#locate
//= type=test
//# - **LOCATE-3** The measurements of an image (LAYER) MUST be given to the timeline in the order of their times, the
//# image's number being that of its arrival.
#[test]
fn observations_are_given_in_the_order_of_their_times() {
    let random = &mut ChaCha8Rng::seed_from_u64(7);
    let mut beside = |format: Format, a: f64| {
        let (upper, lower) = encode(format, PAYLOAD).unwrap();
        let view = View::turned(format, 2.5, 0.1).at(a);
        [view.line(480, upper, random), view.line(480, lower, random)]
    };
    let (left, right) = (beside(Format::Paper, -150.0), beside(Format::Wide, 150.0));
    let [upper, lower]: [Vec<u8>; 2] =
        core::array::from_fn(|layer| left[layer][..240].iter().chain(&right[layer][240..]).copied().collect());
    let known = [listed(Format::Paper, PAYLOAD)[0], listed(Format::Wide, PAYLOAD)[0]];
    for (stamp, expected) in [
        (Stamp::MidExposure, [(0, UPPER_TIME), (1, UPPER_TIME), (0, LOWER_TIME), (1, LOWER_TIME)]),
        (Stamp::Processing, [0, 0, 1, 1].map(|which| (which, Time::from_micros(1_840_500)))),
    ] {
        let config = Config { stamp, ..config(Places::Table(&known)) };
        let (seen, heard) = image(&mut localizer(&config, [0.0; 3]), &[upper.clone(), lower.clone()]);
        assert_eq!(seen, Seen { detections: 2, waiting: 4, ..Seen::default() });
        let order: Vec<_> =
            heard.observed.iter().map(|(seen, _)| (u8::from(seen.format() == Format::Wide), seen.time)).collect();
        assert_eq!(order, expected);
    }
}

/// A pose from elsewhere, of a robot 30 cm before the landmark: where it is in the world, by hand.
//= reference/SPEC.md#locate
//= type=test
//# - **LOCATE-7** An observation of the robot's pose in a landmark's frame that comes from elsewhere MUST be taken as a
//# pose (OBSERVE-2) of a camera in the robot's own place, of a new image if the last one that came from elsewhere was
//# of another time, its landmark told apart by a number that it comes with.
#[test]
fn a_pose_from_elsewhere_is_observed() {
    let config = config(Places::Table(&[]));
    let mut localizer = localizer(&config, [0.11, 0.01, 0.0]);
    localizer.read(&reading(ms(1_100), 0, 0)).unwrap();
    let robot = [0.3, 0.02, PI - 0.1];
    let sure = variances([1e-4, 1e-4, 1e-4]);
    let outcome = localizer.observe_pose(ms(1_050), &fixed(PLACE), &fixed(robot), &sure, 7);
    assert_eq!(outcome, Ok(Some(Outcome::Used)));
    let [x, y, theta] = composed(PLACE, robot);
    let pose = localizer.estimate().pose();
    let turn = f64::from(pose.theta.to_bits()) * PI / 2_f64.powi(31) - theta;
    let apart = [pose.x.to_num::<f64>() - x, pose.y.to_num::<f64>() - y, (turn + PI).rem_euclid(2.0 * PI) - PI];
    assert!(apart.iter().all(|apart| apart.abs() < 1e-4), "{apart:?}");
    // LOCATE-7: of one time they are of one image, and told apart by their numbers.
    assert_eq!(localizer.observe_pose(ms(1_050), &fixed(PLACE), &fixed(robot), &sure, 7), Err(Untimely::Duplicate));
    assert!(localizer.observe_pose(ms(1_050), &fixed(PLACE), &fixed(robot), &sure, 8).is_ok());
    assert!(localizer.observe_pose(ms(1_060), &fixed(PLACE), &fixed(robot), &sure, 7).is_ok());
    // After one of another time it is a new image.
    assert!(localizer.observe_pose(ms(1_050), &fixed(PLACE), &fixed(robot), &sure, 7).is_ok());
    assert_eq!(localizer.observe_pose(ms(1_000), &fixed(PLACE), &fixed(robot), &sure, 7), Err(Untimely::Late));
    localizer.restart(ms(500));
    assert_eq!((localizer.time(), localizer.counts().timeline.late), (ms(500), 1));
}

/// A timeline, and a tenth of it.
#[test]
fn its_memory_is_that_of_its_parts() {
    assert!(size_of::<Localizer<'_>>() <= size_of::<Timeline>() + size_of::<Timeline>() / 10);
    let known = listed(Format::Paper, PAYLOAD);
    let config = config(Places::Table(&known));
    localizer(&config, [0.0; 3]).image(&[0], &[0], &capture(), &mut Workspace::new(), &mut Silent);
}
