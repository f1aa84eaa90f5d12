//! Scenario files.

use super::*;
use crate::coverage::View;
use reference::camera::Camera;
use reference::codeword::encode;
use reference::crossing::CrossingRule;
use reference::decode::DecodedLayer;
use reference::detect::detect;
use reference::frame::{Pose, Robot, World};
use reference::landmark::{Format, Landmark};
use reference::observer::{Layer, Observer};
use reference::render::Posted;
use reference::threshold::Threshold;
use reference::world::{Disturbance, Imperfections, Lift, Shutter, Told};

const CORRIDOR: &str = "[site.route]\npoints_m = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5]]\n";

fn no_file(path: &Path) -> Result<String, SiteError> {
    Err(SiteError::whole_file(path, "is not there"))
}

fn parse(text: &str) -> Result<Scenario, SiteError> {
    of_toml(text, Path::new("here.toml"), no_file)
}

fn built_in(name: &str) -> Scenario {
    load(Path::new(name)).unwrap_or_else(|error| panic!("{error}"))
}

//= reference/SPEC.md#scenario
//= type=test
//# - **SCENARIO-7** `triangle` and `kidnap` MUST be known without a file.
#[test]
fn built_in_scenarios_are_the_files_in_the_tree() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    for (name, file) in BUILT_IN {
        assert_eq!(built_in(name), load(&folder.join(file)).unwrap());
    }
    let error = load(Path::new("no-such-scenario")).unwrap_err().to_string();
    assert!(error.starts_with("no-such-scenario: cannot be read"), "{error}");
}

#[test]
fn the_triangle_is_what_the_issue_asks_for() {
    let Scenario { site, setup } = built_in("triangle");
    let ride = &setup.ride;
    assert_eq!((ride.laps, ride.speed, ride.turn), (5, 0.05, 1.0));
    for (a, b) in ride.points.iter().zip(ride.points.iter().cycle().skip(1)) {
        assert!(((b.x - a.x).hypot(b.y - a.y) - 1.2).abs() < 1e-6);
    }
    assert_eq!(setup.imperfections, Imperfections { wheel_difference: 0.002, axle_excess: 0.005, slip: 1e-3 });
    let shutter = Shutter { period: 400_000, capture: 300_000, processing: 100_000, exposure: 37_500 };
    assert_eq!((setup.shutter, setup.lift, setup.told.wrong), (shutter, None, false));
    assert_eq!(setup.disturbance, Disturbance { occlusion: 0.0, false_decodes: 0.0 });
    // The corridor of the site that is kept for tests, but for landmarks.
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/sites/triangle.toml");
    assert_eq!(Site { landmarks: vec![], ..site.clone() }, site::load(&data).unwrap());
    assert_eq!(site.landmarks, setup.place.landmarks);
}

/// Each landmark hangs at the point of the grid next to where its leg meets the wall ahead, points being 30 or 60 mm apart,
/// faces the leg under 30 degrees, and is readable from 45 cm on until the leg ends.
#[test]
fn each_leg_of_the_triangle_reads_the_landmark_ahead() {
    let Scenario { site, setup } = built_in("triangle");
    let camera = Camera::epuck();
    let view = View::of(&site, &camera);
    let points = &setup.ride.points;
    for (i, posted) in site.landmarks.iter().enumerate() {
        let (a, b) = (points[i], points[(i + 1) % 3]);
        let start: Pose<World, Robot> = Pose::new(a.x, a.y, (b.y - a.y).atan2(b.x - a.x));
        let place = posted.landmark_in_world;
        let on_leg = start.inverse() * place;
        assert!((on_leg.theta().abs() - 150_f64.to_radians()).abs() < 1e-9, "30 degrees from straight back");
        // The nearest of points 60 mm apart along a wall that the leg meets under 60 degrees.
        let spacing = if place.y().abs() < 1e-9 { 0.03 } else { 0.06 };
        assert!(on_leg.y().abs() <= spacing / 2.0 * 60_f64.to_radians().sin(), "{}", on_leg.y());
        // Where the leg meets the wall: 0.1992 m from the route, under 60 degrees.
        let wall = 1.2 + 0.199_185_843 / 60_f64.to_radians().sin();
        for centimetres in 20..=45 {
            let along = wall - f64::from(centimetres) / 100.0 - 0.03;
            let robot = start * Pose::<Robot, Robot>::new(along.min(1.2), 0.0, 0.0);
            assert_eq!(view.readable(&robot, &site.landmarks), [i], "{centimetres} cm");
        }
    }
}

/// The half words that each line gave by itself: here a moving robot's lines need not belong together.
#[derive(Default)]
struct HalfWords {
    lower: bool,
    found: [Vec<u32>; 2],
}

impl Observer for HalfWords {
    fn threshold(&mut self, layer: Layer, _threshold: &Threshold) {
        self.lower = layer == Layer::Lower;
    }

    fn decoded(&mut self, layer: &DecodedLayer) {
        self.found[usize::from(self.lower)].push(layer.half_word);
    }
}

/// A lap: from each landmark both lines are read on the way to it, and no line reads anything else.
#[test]
fn landmarks_of_the_triangle_are_read_on_the_way() {
    let Scenario { site, mut setup } = built_in("triangle");
    setup.ride.laps = 1;
    let recording = setup.record(1, 0).unwrap();
    let (mut seen, mut read, mut other) = ([0; 3], [0; 3], 0);
    for shot in &recording.shots {
        let ([upper, lower], mut half_words) = (&shot.lines, HalfWords::default());
        let formats = [Landmark::new(Format::Paper)];
        detect(upper, lower, &setup.place.camera, &formats, CrossingRule::default(), &mut half_words);
        let [above, below] = half_words.found;
        let carries = |landmark: &Posted| encode(Format::Paper, landmark.payload).unwrap();
        let own = |i: usize| carries(&site.landmarks[i]);
        for i in shot.seen.iter().map(|seen| seen.landmark) {
            seen[i] += 1;
            read[i] += usize::from(above.contains(&own(i).0) && below.contains(&own(i).1));
        }
        let known = |half: u32| (0..3).any(|i| half == own(i).0 || half == own(i).1);
        other += above.iter().chain(&below).filter(|&&half| !known(half)).count();
    }
    // 25 cm between 45 and 20 cm at 2 cm an image: 12.
    assert!((0..3).all(|i| read[i] >= 10 && read[i] <= seen[i]), "{read:?} of {seen:?}");
    assert!(other <= 2, "{other} half words that nobody carries");
}

#[test]
fn the_kidnapped_robot_starts_wrong_and_is_lifted_half_way() {
    let Scenario { site, setup } = built_in("kidnap");
    let triangle = built_in("triangle");
    assert_eq!(site, triangle.site);
    assert_eq!(setup.told, Told { wrong: true, ..Told::default() });
    assert_eq!(setup.lift, Some(Lift { at: 0.5, lasts: 1_000_000 }));
    assert_eq!(Setup { told: triangle.setup.told, lift: None, ..setup }, triangle.setup);
}

//= reference/SPEC.md#scenario
//= type=test
//# - **SCENARIO-1** A scenario file MUST be TOML with the parts `site`, `run`, `image`, `robot`, `start`, `occlusion`,
//# `false_decodes` and `kidnap`, of which only `site` has to be there, and with its unit in every key that has one.
//= reference/SPEC.md#scenario
//= type=test
//# - **SCENARIO-8** A lap of an open route MUST lead to its end and back.
#[test]
fn everything_but_the_site_has_a_default_and_a_unit() {
    let plain = parse(CORRIDOR).unwrap().setup;
    assert_eq!(plain, Setup { ride: plain.ride.clone(), place: plain.place.clone(), ..built_in("triangle").setup });
    // An open route leads back to where it began.
    let points: Vec<_> = plain.ride.points.iter().map(|point| [point.x, point.y]).collect();
    assert_eq!(points, [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 0.0]]);
    let text = format!(
        "{CORRIDOR}[run]\nlaps = 2\nspeed_m_s = 0.1\nturn_rad_s = 2\nwander_rad_s = 0.01\n[image]\nperiod_ms = 200\n\
         capture_ms = 80\nprocessing_ms = 20.5\nexposure_ms = 2.5\nblur_px = 0.7\nnoise_grey = 3\n[robot]\n\
         wheel_difference_sigma = 0.001\naxle_excess_sigma = 0.01\nslip_mm_per_root_m = 2\n[start]\nposition_sigma_mm = 20\n\
         heading_sigma_rad = 0.1\n[occlusion]\nprobability = 0.25\n[false_decodes]\nrate = 0.5\n[kidnap]\nat = 0.25\n\
         lifted_ms = 1500\n"
    );
    let setup = parse(&text).unwrap().setup;
    assert_eq!((setup.ride.laps, setup.ride.speed, setup.ride.turn, setup.ride.wander), (2, 0.1, 2.0, 0.01));
    assert_eq!(setup.shutter, Shutter { period: 200_000, capture: 80_000, processing: 20_500, exposure: 2_500 });
    assert_eq!((setup.place.sensor.blur, setup.place.sensor.noise), (0.7, 3.0));
    assert_eq!(setup.imperfections, Imperfections { wheel_difference: 0.001, axle_excess: 0.01, slip: 2e-3 });
    assert_eq!(setup.told, Told { sigma: [0.02, 0.02, 0.1], wrong: false });
    assert_eq!(setup.disturbance, Disturbance { occlusion: 0.25, false_decodes: 0.5 });
    assert_eq!(setup.lift, Some(Lift { at: 0.25, lasts: 1_500_000 }));
    // A row's share of a shorter capture.
    assert_eq!(parse(&format!("{CORRIDOR}[image]\ncapture_ms = 100")).unwrap().setup.shutter.exposure, 12_500);
}

#[test]
fn whatever_is_accepted_can_be_run() {
    let image = "[image]\nperiod_ms = 0.0334\ncapture_ms = 0.0084\nprocessing_ms = 0.025\nexposure_ms = 0.00104\n";
    for extra in
        [image, "[run]\nspeed_m_s = 0.12\nturn_rad_s = 4.8\nwander_rad_s = 0\n", "[occlusion]\nprobability = 1\n"]
    {
        let scenario = parse(&format!("{CORRIDOR}{extra}")).unwrap();
        assert!(scenario.setup.run(1, 1).is_ok(), "{extra}");
    }
}

//= reference/SPEC.md#scenario
//= type=test
//# - **SCENARIO-3** Whatever is wrong MUST be reported as SITE-2 and SITE-3 say, in the site's own file if it is there.
//= reference/SPEC.md#scenario
//= type=test
//# - **SCENARIO-4** Speeds MUST be above 0 and at most what 1000 steps a second allow, a correction of 0.3 rad/s
//# (WORLD-7) included.
//= reference/SPEC.md#scenario
//= type=test
//# - **SCENARIO-5** An image's period MUST be refused if it is shorter than capture and processing, and a row's
//# exposure if it is longer than its share of the capture.
//= reference/SPEC.md#scenario
//= type=test
//# - **SCENARIO-6** A kidnapping MUST be a start that is wrong (WORLD-19), a lift at a share of the ride from 0 to
//# below 1 (WORLD-20), or both.
#[test]
fn what_is_wrong_is_said_with_its_line_and_key() {
    let cases = [
        ("[run]\nlaps = 0", 2, "run.laps", "is not from 1 to"),
        ("[run]\nlaps = 1.5", 2, "run.laps", "invalid type"),
        ("[run]\nspeed_m_s = -0.05", 2, "run.speed_m_s", "is not above 0"),
        ("[run]\nspeed_m_s = 0.2", 2, "run.speed_m_s", "the most is 0.12"),
        ("[run]\nspeed = 0.05", 2, "run.speed", "has no unit; write speed_m_s"),
        ("[run]\n\nturn_rad_s = nan", 3, "run.turn_rad_s", "is not a finite number"),
        ("[run]\nwander_rad_s = -0.1", 2, "run.wander_rad_s", "is below 0"),
        ("[run]\nhurry = true", 2, "run.hurry", "unknown field"),
        ("[weather]\nrain = 1", 1, "weather", "unknown field"),
        ("[image]\nperiod_ms = 399", 2, "image.period_ms", "is shorter than capture and processing, 400 ms"),
        ("[image]\ncapture_ms = 350", 2, "image.capture_ms", "is shorter than capture and processing, 450 ms"),
        ("[image]\ncapture_ms = 1001", 2, "image.capture_ms", "the most is 1000"),
        ("[image]\nexposure_ms = 38", 2, "image.exposure_ms", "is longer than a row's share of the capture, 37.5 ms"),
        ("[image]\nexposure_ms = 1e-4", 2, "image.exposure_ms", "less than a microsecond"),
        ("[image]\nnoise_grey = inf", 2, "image.noise_grey", "is not a finite number"),
        ("[robot]\naxle_excess_sigma = 0.5", 2, "robot.axle_excess_sigma", "the most is 0.3"),
        ("[occlusion]\nprobability = 1.5", 2, "occlusion.probability", "the most is 1"),
        ("[false_decodes]\nrate = -0.1", 2, "false_decodes.rate", "is below 0"),
        ("[kidnap]\nat = 1.0", 2, "kidnap.at", "the end of the ride"),
        ("[kidnap]\nlifted_ms = 500", 2, "kidnap.lifted_ms", "not at which share"),
        ("[kidnap]\nwrong_start = 1", 2, "kidnap.wrong_start", "invalid type"),
        ("[[site.wall]]\nfrom_m = [0, 0]\nto_m = [0, 0]\nface = \"left\"", 3, "site.wall[1].to_m", "shorter than 1 mm"),
    ];
    let before = CORRIDOR.lines().count();
    for (text, line, key, what) in cases {
        let error = parse(&format!("{CORRIDOR}{text}\n")).unwrap_err();
        let shown = error.to_string();
        assert_eq!((error.line(), error.key()), (Some(before + line), key), "{shown}");
        assert!(shown.starts_with("here.toml:") && shown.contains(what), "{shown}");
    }
}

//= reference/SPEC.md#scenario
//= type=test
//# - **SCENARIO-2** The site MUST be the path of a site file, from the scenario file's folder, or a table with the
//# parts of one (SITE-1), and have a route.
#[test]
fn a_site_file_that_is_wrong_is_named_itself() {
    let read = |path: &Path| match path.to_str() {
        Some("folder/site.toml") => Ok("[grid]\nstep_mm = [0.0, 1.0]\n".to_owned()),
        Some("folder/bare.toml") => Ok(String::new()),
        _ => no_file(path),
    };
    let error = |text: &str| of_toml(text, Path::new("folder/run.toml"), read).unwrap_err().to_string();
    assert_eq!(error("site = \"site.toml\""), "folder/site.toml:2: grid.step_mm: 0 is not above 0");
    assert_eq!(error("site = \"other.toml\""), "folder/other.toml: is not there");
    assert_eq!(error("\nsite = \"bare.toml\""), "folder/run.toml:2: site: the scenario's site has no route");
    assert!(error("[run]\nlaps = 2").contains("missing field `site`"));
    assert!(error("site = 3").contains("invalid type"));
}
