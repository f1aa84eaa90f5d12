//! Robots on a route, by both pipelines: how well they know where they are, how they find back, and that a log says the same.
//!
//! `BARLOC_RUNS` sets the runs of a scenario (default 12; the claims are made for 100). Run with `--nocapture` to see them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use verify::log::knowledge::States;
use verify::route::{Differing, Errors, Method, Recovery, Report, Run, report, runs};
use verify::scenario::{Scenario, load};

/// A seed of its own, so that nothing was chosen by what another gives.
const SEED: u64 = 20_130_505;

fn count() -> u64 {
    std::env::var("BARLOC_RUNS").map_or(12, |runs| runs.parse().expect("BARLOC_RUNS is a number"))
}

fn scenario(name: &str) -> Scenario {
    load(Path::new(name)).unwrap()
}

const THREE: Method = Method {
    states: States::Three,
    observe: verify::log::knowledge::Observe::Image,
    stamp: verify::log::knowledge::Stamp::Exposure,
};

/// Runs with five states and with three.
fn both(scenario: &Scenario, name: &str) -> [Report; 2] {
    let by_method = runs(&scenario.setup, &[Method::default(), THREE], (count(), SEED), &|| {}).unwrap();
    let reports: Vec<Report> = by_method.iter().map(|runs| report(name, SEED, runs).unwrap()).collect();
    for (states, report) in [5, 3].into_iter().zip(&reports) {
        println!("{name}, {states} states\n{}", serde_json::to_string(report).unwrap());
    }
    reports.try_into().unwrap()
}

static TRIANGLE: LazyLock<[Report; 2]> = LazyLock::new(|| both(&scenario("triangle"), "triangle"));

fn pipelines(report: &Report) -> [(&'static str, &Errors); 2] {
    [("reference", &report.reference), ("fixedpoint", &report.fixedpoint)]
}

/// The paper: 1.5 cm in the mean.
#[test]
fn a_robot_knows_where_it_is_to_half_a_centimetre() {
    for (report, mean, most) in [(&TRIANGLE[0], 0.005, 0.021), (&TRIANGLE[1], 0.0065, 0.028)] {
        for (name, errors) in pipelines(report) {
            let (found, p95) = (errors.mean_position_error_m, errors.p95_position_error_m);
            assert!(found < mean && p95 < most, "{name}: {found} m in the mean, 95 % within {p95} m");
        }
        assert!(report.odometry.mean_final_error_m > 0.2, "the wheels alone: {:?}", report.odometry);
    }
}

#[test]
fn five_states_say_how_far_off_they_may_be() {
    for (name, errors) in pipelines(&TRIANGLE[0]) {
        let [low, high] = errors.nees_band;
        assert!((low..high).contains(&errors.mean_nees), "{name}: {} outside {low} to {high}", errors.mean_nees);
    }
}

/// Without false landmarks a filter begins again at most three times in a hundred runs.
#[test]
fn nobody_is_lost_without_a_reason() {
    for report in TRIANGLE.iter() {
        for (name, errors) in pipelines(report) {
            let allowed = 3 * report.runs.div_ceil(100);
            assert!(errors.recoveries.len() <= allowed && errors.lost == 0, "{name}: {:?}", errors.recoveries);
        }
    }
}

/// SAME-7
fn stay_together(report: &Report) {
    assert!(report.stays_together(), "{:?} {:?}", report.largest_difference_decided_alike, report.decided_differently);
    let Differing { seen, gate, .. } = report.decided_differently;
    // Marginal views are 1 in 1,000, of some 265 images a run that show a landmark.
    assert!(seen + gate <= 1 + report.runs as u64, "{:?}", report.decided_differently);
}

//= reference/SPEC.md#same
//= type=test
//# - **SAME-7** Along a route both filters that are given LAYER's measurements at EXPOSE-1's times MUST stay within 1
//# mm and 0.1° of each other wherever they have decided alike (ROUTE-7), and decide otherwise only where one of them
//# accepts a landmark that the other does not by SAME-5, where the reference's NIS, by its estimate or by its
//# candidate, is within 1 in 1,000 of FILTER-4's limit, or where they already have and not both used observations twice
//# since.
#[test]
fn both_pipelines_stay_within_a_millimetre() {
    TRIANGLE.iter().for_each(stay_together);
}

/// The paper: two to four observations.
#[test]
fn a_kidnapped_robot_finds_back_within_three_images() {
    for report in both(&scenario("kidnap"), "kidnap") {
        stay_together(&report);
        for (name, errors) in pipelines(&report) {
            let (lost, others): (Vec<&Recovery>, Vec<&Recovery>) =
                errors.recoveries.iter().partition(|recovery| recovery.was_lost);
            assert_eq!((lost.len(), errors.lost), (2 * report.runs, 0), "{name}: a start and a lift for each run");
            let mut images: Vec<u64> = lost.iter().map(|recovery| recovery.images).collect();
            images.sort_unstable();
            assert!(images[images.len() / 2] <= 2 && images[images.len() - 1] <= 3, "{name}: {images:?}");
            assert!(others.len() <= 3 * report.runs.div_ceil(100), "{name}: {others:?}");
            assert!(!errors.recoveries.iter().any(|recovery| recovery.harmful), "{name}");
        }
    }
}

/// At the paper's rate, 3 in 1,320.
#[test]
fn false_landmarks_carry_nobody_away() {
    let mut scenario = scenario("triangle");
    scenario.setup.disturbance.false_decodes = 3.0 / 1320.0;
    for report in both(&scenario, "triangle with false landmarks") {
        stay_together(&report);
        for (name, errors) in pipelines(&report) {
            let harmful: Vec<&Recovery> = errors.recoveries.iter().filter(|recovery| recovery.harmful).collect();
            assert!(harmful.is_empty() && errors.lost == 0, "{name}: {harmful:?}");
        }
        // About 0.6 a run, two layers each.
        assert!(report.reference.observations_gated > 0, "nothing false was seen");
    }
}

#[test]
fn the_same_seed_gives_the_same_report_whatever_the_threads() {
    let scenario = scenario("kidnap");
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let runs: Vec<Vec<Run>> = pool.install(|| runs(&scenario.setup, &[Method::default()], (3, 7), &|| {})).unwrap();
        serde_json::to_string(&report("kidnap", 7, &runs[0])).unwrap()
    };
    assert_eq!(with(1), with(4));
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("route").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The command's output and exit code.
fn barloc(arguments: &[&str]) -> (String, String, i32) {
    let output = Command::new(env!("CARGO_BIN_EXE_barloc")).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (text(&output.stdout), text(&output.stderr), output.status.code().unwrap())
}

/// A scenario of one lap with everything that may happen to a robot.
fn lively(folder: &Path) -> PathBuf {
    let corridor = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/corridor.toml")).unwrap();
    fs::write(folder.join("corridor.toml"), corridor).unwrap();
    let text = "site = \"corridor.toml\"\n[run]\nlaps = 1\nspeed_m_s = 0.05\n[false_decodes]\nrate = 0.05\n\
                [occlusion]\nprobability = 0.1\n[kidnap]\nat = 0.5\nlifted_ms = 1000.0\n";
    let path = folder.join("lively.toml");
    fs::write(&path, text).unwrap();
    path
}

/// ROUTE-9
//= reference/SPEC.md#route
//= type=test
//# - **ROUTE-1** Both pipelines and the wheels alone MUST be given the same events in the order of their arrival, of
//# one time readings first, then images and observations: an image arrives when its processing ends.
//= reference/SPEC.md#route
//= type=test
//# - **ROUTE-9** A log that is written of a run and replayed MUST give the same estimates, byte for byte.
#[test]
fn a_log_replays_to_the_same_bytes() {
    for (observe, states) in [("image", "5"), ("pose", "3"), ("paper", "3")] {
        let folder = folder(observe);
        let (log, again) = (folder.join("log"), folder.join("again"));
        let scenario = lively(&folder);
        let [scenario, log_name, again_name] = [&scenario, &log, &again].map(|path| path.to_str().unwrap());
        let options = ["--runs", "1", "--seed", "3", "--observe", observe, "--states", states, "--out", log_name];
        let (_, error, code) = barloc(&[&["route", scenario][..], &options].concat());
        assert_eq!((error.as_str(), code), ("", 0));
        let (out, error, code) = barloc(&["replay", log_name, "--out", again_name]);
        assert_eq!((error.as_str(), code), ("", 0), "{out}");
        for file in verify::ride::FILES {
            let [written, replayed] = [&log, &again].map(|folder| fs::read(folder.join(file)).unwrap());
            assert!(written == replayed, "{observe}: {file} differs");
            assert!(written.len() > 10_000, "{file} has {} bytes", written.len());
        }
    }
}

/// Velocities and poses from elsewhere instead of steps and images.
//= reference/SPEC.md#route
//= type=test
//# - **ROUTE-2** A sample MUST be what is believed when everything that has arrived by a reading's time was taken,
//# beside where the robot is then.
#[test]
fn a_log_of_velocities_and_poses_is_replayed() {
    let folder = folder("poses");
    // Half a metre ahead at 5 cm/s, seen at the half and at the end by a landmark at (1, 0) that looks back.
    let readings: Vec<String> = (1..=100).map(|i| format!("{}.{},0.05,0.0\n", i / 10, i % 10)).collect();
    fs::write(folder.join("odometry.csv"), format!("t_s,forward_m_s,turn_rad_s\n{}", readings.concat())).unwrap();
    let poses = "5.05,1.0,0.0,3.141592653589793,0.745,-0.002,3.141592653589793,1e-6,0,0,1e-6,0,1e-6\n\
                 9.95,1.0,0.0,3.141592653589793,0.5,-0.004,3.141592653589793,1e-6,0,0,1e-6,0,1e-6\n";
    let header = "t_s,landmark_x_m,landmark_y_m,landmark_theta_rad,x_m,y_m,theta_rad,c_xx,c_xy,c_xt,c_yy,c_yt,c_tt\n";
    fs::write(folder.join("observations.csv"), format!("{header}{poses}")).unwrap();
    let (out, error, code) = barloc(&["replay", folder.to_str().unwrap()]);
    assert_eq!((error.as_str(), code), ("", 0), "{out}");
    for file in verify::ride::FILES {
        let text = fs::read_to_string(folder.join(file)).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
        assert_eq!(rows.len(), 100);
        let last: Vec<f64> = rows[99][..4].iter().map(|field| field.parse().unwrap()).collect();
        // The landmark's y is the robot's -y: it is 4 mm to the left.
        assert!((last[0] - 10.0).abs() < 1e-9 && (last[1] - 0.5025).abs() < 0.002, "{file}: {last:?}");
        assert!((last[2] - 0.004).abs() < 0.001 && last[3].abs() < 0.01, "{file}: {last:?}");
        let used = rows.iter().filter(|row| row[10] == "used:1").count();
        assert_eq!(used, 2, "{file}");
    }
}

/// A row that cannot be used takes nothing else with it, and is named.
#[test]
fn what_is_wrong_with_a_log_is_said_and_left_out() {
    let folder = folder("wrong");
    let rows = "0.1,39,39\n0.2,39,39\nnow,39,39\n0.3,39,39\n0.3,39,39\n0.25,39,39\n0.4,39,inf\n0.4,39,39\n9.0,39,39\n9.1,39,39\n";
    fs::write(folder.join("odometry.csv"), format!("t_s,left_steps,right_steps\n{rows}")).unwrap();
    let (out, error, code) = barloc(&["replay", folder.to_str().unwrap()]);
    assert_eq!((error.as_str(), code), ("", 0), "{out}");
    for said in ["odometry.csv:4:", "odometry.csv:6:", "odometry.csv:7:", "odometry.csv:8:", "odometry.csv:10:"] {
        assert!(out.contains(said), "{said} is not in {out}");
    }
    let text = fs::read_to_string(folder.join("estimate_fixedpoint.csv")).unwrap();
    let last: Vec<&str> = text.lines().last().unwrap().split(',').collect();
    // The readings of 0.1, 0.2, 0.25, 0.3, 0.4, 9.0 and 9.1 s: 273 steps.
    let way = 273.0 * core::f64::consts::PI * 0.041 / 1000.0;
    assert!((last[1].parse::<f64>().unwrap() - way).abs() < 1e-6, "{last:?}");
}

#[test]
fn a_folder_without_a_log_is_refused_in_a_line() {
    let folder = folder("empty");
    let (out, error, code) = barloc(&["replay", folder.to_str().unwrap()]);
    assert_eq!((out.as_str(), code), ("", 2));
    assert!(error.contains("odometry.csv") && error.lines().count() == 1, "{error}");
    let (_, error, code) = barloc(&["route", "no-such.toml"]);
    assert!(code == 2 && error.contains("no-such.toml") && error.lines().count() == 1, "{error}");
}
