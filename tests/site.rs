//! Sites: what is wrong with their files, from where landmarks are readable, and where they are put.

use proptest::prelude::*;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reference::camera::Camera;
use reference::landmark::Format;
use serde_json::Value;
use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use verify::coverage::{cover_region, cover_route};
use verify::place::{Wish, candidates, place};
use verify::site::{self, Site};

const TRIANGLE: &str = "tests/data/sites/triangle.toml";
const PLACED: &str = "tests/data/sites/triangle-placed.toml";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn barloc_on(threads: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_barloc"));
    command.args(arguments).env("RAYON_NUM_THREADS", threads).current_dir(root()).output().unwrap()
}

fn barloc(arguments: &[&str]) -> Output {
    barloc_on("2", arguments)
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn json(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn parse(text: &str) -> Site {
    site::of_toml(text, Path::new("site.toml")).unwrap_or_else(|error| panic!("{error}"))
}

// An account of readability of its own, from SITE-10's sentence: plain vectors, every edge and its line of sight.

type Point = [f64; 2];

/// A barcode of 20 stripes of 1.5 mm and 50 mm height: where it is and where it looks.
#[derive(Clone, Copy, Debug)]
struct Barcode {
    at: Point,
    heading: f64,
}

/// Whether the epuck's camera at a point and heading reads the barcode past the walls.
fn reads(eye: Point, heading: f64, barcode: Barcode, walls: &[[Point; 2]]) -> bool {
    let out = [barcode.heading.cos(), barcode.heading.sin()];
    if (eye[0] - barcode.at[0]) * out[0] + (eye[1] - barcode.at[1]) * out[1] <= 0.0 {
        return false;
    }
    let ahead = [heading.cos(), heading.sin()];
    let mut last: Option<f64> = None;
    for k in 0..=20 {
        let along = (f64::from(k) - 10.0) * 1.5e-3;
        // To the right of someone who looks at the wall is the wall's left-hand tangent.
        let point = [barcode.at[0] - out[1] * along, barcode.at[1] + out[0] * along];
        let sight = [point[0] - eye[0], point[1] - eye[1]];
        let depth = sight[0] * ahead[0] + sight[1] * ahead[1];
        let right = sight[0] * ahead[1] - sight[1] * ahead[0];
        let column = 239.5 + 640.0 * right / depth;
        // (6) at 0°: 50 mm * 80 / 8.
        if depth <= 0.0 || depth > 0.5 || !(-0.5..=479.5).contains(&column) {
            return false;
        }
        if last.is_some_and(|last| column - last < 1.5) || walls.iter().any(|wall| meets(eye, sight, wall)) {
            return false;
        }
        last = Some(column);
    }
    true
}

/// Whether a line of sight, but for its last 3 mm, meets a wall: by Cramer's rule.
fn meets(eye: Point, sight: Point, wall: &[Point; 2]) -> bool {
    let run = [wall[1][0] - wall[0][0], wall[1][1] - wall[0][1]];
    let determinant = sight[1] * run[0] - sight[0] * run[1];
    let start = [wall[0][0] - eye[0], wall[0][1] - eye[1]];
    let t = (start[1] * run[0] - start[0] * run[1]) / determinant;
    let u = (sight[0] * start[1] - sight[1] * start[0]) / determinant;
    let end = 1.0 - 3e-3 / sight[0].hypot(sight[1]);
    determinant != 0.0 && (0.0..end).contains(&t) && (0.0..=1.0).contains(&u)
}

const WALL: &str = "[robot]\ncamera_x_mm = 0\n[[wall]]\nfrom_m = [1.0, 0.0]\nto_m = [1.0, 2.0]\nface = \"left\"\n\
                    [[landmark]]\ncodes = [20, 20, 8]\n";

const ON_WALL: Barcode = Barcode { at: [1.0, 1.0], heading: PI };

/// Frontally the barcode is in the image where `|y| + 15 mm <= 240/640 x` and near enough to 50 cm (1.5 px would do to
/// 64 cm): `∫ 2 (0.375 x - 0.015) dx` from 0.04 to 0.5 is 0.07935 m² of the region's 1.4 m².
//= reference/SPEC.md#site
//= type=test
//# - **SITE-14** A region MUST be looked at from the middles of square cells, by default of 20 mm, each with equally
//# many headings, by default 72.
#[test]
fn the_frontal_share_is_the_trapezium_s() {
    let site = parse(&format!("{WALL}[region]\npolygon_m = [[0.0, 0.3], [1.0, 0.3], [1.0, 1.7], [0.0, 1.7]]"));
    let region = site.region.as_ref().unwrap();
    let found = cover_region(&site, region, &Camera::epuck(), 0.0025, 1).unwrap();
    // Its outline, 1.5 m long, goes through cells of 2.5 mm: half of these would be 0.0019 m², a random half much less.
    assert!((1.4 * found.share() - 0.07935).abs() < 3e-4, "{}", 1.4 * found.share());
    assert_eq!(found.cells.len(), 400 * 560);
}

/// Random poses of a rectangle of which the given account says that the barcode is readable: share and its deviation.
fn monte_carlo(seed: u64, [low, high]: [Point; 2], read: impl Fn(Point, f64) -> bool) -> (f64, f64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let draws = 400_000;
    let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut count = 0.0;
    for _ in 0..draws {
        let eye = [between(low[0], high[0]), between(low[1], high[1])];
        count += f64::from(u8::from(read(eye, between(0.0, TAU))));
    }
    let share = count / f64::from(draws);
    (share, (share * (1.0 - share) / f64::from(draws)).sqrt())
}

//= reference/SPEC.md#site
//= type=test
//# - **SITE-10** A landmark MUST count as readable from a pose of the robot where the camera is in front of its wall,
//# all of its edges are in the image at a positive depth of at most RANGE-2's distance at 0°, its narrowest stripe is
//# at least `L_min` (RANGE-1) wide, and no wall comes between the camera and any part of the barcode, but for the last
//# 2 mm before it.
#[test]
fn shares_are_those_of_random_poses_by_another_account() {
    let region = "[region]\npolygon_m = [[0.4, 0.5], [1.0, 0.5], [1.0, 1.5], [0.4, 1.5]]";
    let post = |x: f64, from: f64, to: f64| {
        (
            format!("[[wall]]\nfrom_m = [{x:?}, {from:?}]\nto_m = [{x:?}, {to:?}]\nface = \"both\"\n"),
            [[x, from], [x, to]],
        )
    };
    let cases = [vec![], vec![post(0.8, 0.9, 1.0)], vec![post(0.7, 1.02, 1.1), post(0.85, 0.9, 0.95)]];
    let mut shares = Vec::new();
    for (seed, posts) in (1..).zip(cases) {
        let walls: String = posts.iter().map(|(text, _)| text.as_str()).collect();
        let site = parse(&format!("{WALL}{walls}{region}"));
        let found = cover_region(&site, site.region.as_ref().unwrap(), &Camera::epuck(), 0.01, 180).unwrap().share();
        let lines: Vec<[Point; 2]> = posts.iter().map(|(_, line)| *line).collect();
        let (share, deviation) =
            monte_carlo(seed, [[0.4, 0.5], [1.0, 1.5]], |eye, heading| reads(eye, heading, ON_WALL, &lines));
        // Four deviations of the random share, and 1 % for the cells.
        assert!((found - share).abs() < 4.0 * deviation + 0.01 * share, "{found} against {share}, {posts:?}");
        shares.push(share);
    }
    // The posts hide something.
    assert!(shares[1] < 0.9 * shares[0] && shares[2] < 0.95 * shares[0], "{shares:?}");
}

#[test]
fn a_wall_across_the_view_hides_everything() {
    let route = "[route]\npoints_m = [[0.55, 1.0], [0.9, 1.0]]";
    let camera = Camera::epuck();
    let share = |wall: &str| {
        let site = parse(&format!("{WALL}{wall}{route}"));
        cover_route(&site, site.route.as_ref().unwrap(), &camera, 0.001, 1).unwrap()
    };
    // Frontally the barcode is in the image from 4 cm on, at x = 0.96, and readable from 50 cm, at 0.5: everywhere.
    let free = share("");
    assert!((free.share() - 1.0).abs() < 1e-12 && free.longest_gap.unwrap().length < 0.002);
    let closed = share("[[wall]]\nfrom_m = [0.95, 0.5]\nto_m = [0.95, 1.5]\nface = \"right\"\n");
    assert!(closed.share().abs() < 1e-12 && (closed.longest_gap.unwrap().length - 0.35).abs() < 1e-12);
    // Behind the wall at 0.7 nothing is seen, before it everything: 0.2 m of 0.35 m.
    let half = share("[[wall]]\nfrom_m = [0.7, 0.5]\nto_m = [0.7, 1.5]\nface = \"right\"\n");
    assert!((half.share() - 0.2 / 0.35).abs() < 0.01, "{}", half.share());
    assert!((half.longest_gap.unwrap().length - 0.15).abs() < 0.002);
}

/// Two barcodes of 30 mm: with a gap of 40 mm, less than 1.5 widths, they crowd each other; with 50 mm they do not.
//= reference/SPEC.md#site
//= type=test
//# - **SITE-11** A landmark MUST NOT count as readable where another one that darkens the image is nearer to it there
//# than 1.5 times the narrower of both barcodes.
#[test]
fn neighbours_in_the_image_are_told_apart_from_one_and_a_half_widths_on() {
    let camera = Camera::epuck();
    for (codes, readable) in [(68, 0), (70, 2)] {
        // Steps of 5 mm: centres 70 or 80 mm apart.
        let site = parse(&format!(
            "[grid]\nstep_mm = [100, 5]\norigin_m = [0.0, 0.7]\n[robot]\ncamera_x_mm = 0\n[[wall]]\nfrom_m = [1.0, 0.0]\n\
             to_m = [1.0, 2.0]\nface = \"left\"\n[[landmark]]\ncodes = [10, 54, 8]\nformat = \"wide\"\nstripe_width_mm = 1.25\n\
             [[landmark]]\ncodes = [10, {codes}, 8]\nformat = \"wide\"\nstripe_width_mm = 1.25\n\
             [route]\npoints_m = [[0.65, 1.005], [0.7, 1.005]]"
        ));
        let found = cover_route(&site, site.route.as_ref().unwrap(), &camera, 0.01, 1).unwrap();
        assert!(found.readable.iter().all(|numbers| numbers.len() == readable), "{:?}", found.readable);
    }
}

/// Where the triangle's landmarks count as readable and are not beyond RANGE-3's 45 cm, the detector reads them from
/// rendered lines, RANGE-3's 99 %.
#[test]
fn what_counts_as_readable_is_read() {
    use reference::crossing::CrossingRule;
    use reference::detect::detect;
    use reference::observer::Silent;
    use reference::render::{Light, Scene, Sensor, render};
    let site = site::load(&root().join(PLACED)).unwrap();
    let camera = Camera::epuck();
    let found = cover_route(&site, site.route.as_ref().unwrap(), &camera, 0.002, 1).unwrap();
    let (mut tried, mut read) = (0, 0);
    for (seed, (sample, numbers)) in (0..).zip(found.samples.iter().zip(&found.readable)) {
        let camera_in_world = sample.robot_in_world * site.camera_in_robot;
        let scene = Scene {
            camera_in_world,
            landmarks: site.landmarks.clone(),
            clutter: vec![],
            light: Light::default(),
            sensor: Sensor::default(),
        };
        for &number in numbers {
            let posted = site.landmarks[number];
            let view = posted.landmark_in_world.inverse() * camera_in_world;
            if view.x().hypot(view.y()) > 0.45 {
                continue;
            }
            let [upper, lower] = render(&camera, &scene, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap();
            let detections = detect(&upper, &lower, &camera, &[posted.landmark], CrossingRule::default(), &mut Silent);
            tried += 1;
            read += usize::from(detections.iter().any(|detection| detection.payload == posted.payload));
        }
    }
    assert!(tried > 300 && 100 * read >= 99 * tried, "{read} of {tried}");
}

// The triangle.

fn distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn the_triangle_is_as_it_is_described() {
    let site = site::load(&root().join(TRIANGLE)).unwrap();
    let route = site.route.as_ref().unwrap();
    assert!(route.closed && route.points.len() == 3 && site.landmarks.is_empty() && site.walls.len() == 6);
    for (i, &point) in route.points.iter().enumerate() {
        let next = route.points[(i + 1) % 3];
        assert!((distance(point, next) - 1.2).abs() < 1e-8);
        // Outer wall i and inner wall i are parallel to leg i, on either side, as far from it.
        for (wall, side) in [(site.walls[i], 1.0), (site.walls[i + 3], -1.0)] {
            for end in [point, next] {
                let [_, left] = wall.coordinates(end);
                assert!((left * side - 0.2).abs() < 1e-3, "{left}");
            }
        }
        assert!((site.walls[i].length() - 1.89).abs() < 1e-8 && (site.walls[i + 3].length() - 0.51).abs() < 1e-8);
    }
    let ratio = site.grid.step[0] / site.grid.step[1];
    assert!((ratio * 3_f64.sqrt() / 2.0 - 1.0).abs() < 1e-12 && site.grid.theta_steps == Some(12));
}

fn point_of(value: &Value, keys: [&str; 2]) -> Point {
    keys.map(|key| value[key].as_f64().unwrap())
}

fn barcodes_of(value: &Value) -> Vec<Barcode> {
    let one = |added: &Value| Barcode {
        at: point_of(added, ["x_m", "y_m"]),
        heading: added["heading_deg"].as_f64().unwrap().to_radians(),
    };
    value.as_array().unwrap().iter().map(one).collect()
}

/// Camera positions 30 mm ahead of a triangle's route and headings, with the distance along it.
fn along_triangle(site: &Site, step: f64) -> Vec<(f64, Point, f64)> {
    let points = &site.route.as_ref().unwrap().points;
    let mut found = Vec::new();
    for (i, &[x, y]) in points.iter().enumerate() {
        let [to_x, to_y] = points[(i + 1) % 3];
        let heading = (to_y - y).atan2(to_x - x);
        let leg = (to_x - x).hypot(to_y - y);
        let mut s = step / 2.0;
        while s < leg {
            let eye = [x + (s + 0.03) * heading.cos(), y + (s + 0.03) * heading.sin()];
            found.push((1.2 * i as f64 + s, eye, heading));
            s += step;
        }
    }
    found
}

//= reference/SPEC.md#place
//= type=test
//# - **PLACE-2** The gap MUST by default be 1 m.
#[test]
fn placing_on_the_triangle_keeps_to_the_gap_with_the_fewest() {
    let output = folder("place").join("placed.toml");
    let report = json(&barloc(&["place", "--json", "-o", output.to_str().unwrap(), TRIANGLE]));
    let count = report["landmarks"].as_u64().unwrap();
    let bound = report["lower_bound"].as_u64().unwrap();
    assert!(count >= bound && 4 * count <= 5 * bound, "{count} against {bound}");
    let added = report["added"].as_array().unwrap();
    assert_eq!(added.len() as u64, count);
    for wall in 1..=6 {
        assert!(added.iter().filter(|one| one["wall"] == wall).count() <= 4);
    }
    // The committed file is what the command makes.
    assert_eq!(fs::read_to_string(&output).unwrap(), fs::read_to_string(root().join(PLACED)).unwrap());
    // By the other account, at another step.
    let site = site::load(&root().join(TRIANGLE)).unwrap();
    let walls: Vec<[Point; 2]> = site.walls.iter().map(|wall| [wall.from, wall.to]).collect();
    let barcodes = barcodes_of(&report["added"]);
    let read: Vec<f64> = along_triangle(&site, 1.7e-3)
        .into_iter()
        .filter(|&(_, eye, heading)| barcodes.iter().any(|&barcode| reads(eye, heading, barcode, &walls)))
        .map(|(along, ..)| along)
        .collect();
    let around = read[0] + 3.6 - read[read.len() - 1];
    let longest = read.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    assert!(longest <= 1.0, "{longest}");
    assert!((longest - report["route"]["longest_gap_m"].as_f64().unwrap()).abs() < 2.0 * 1.7e-3 + 1e-3);
}

/// The bound's own evidence: no point of the grid on an outer wall is readable from two of the stretches that it names.
//= reference/SPEC.md#place
//= type=test
//# - **PLACE-8** The number of landmarks MUST be reported with a lower bound: the most of the linear relaxation's
//# optimum, rounded up, the number of windows of which no landmark serves two, and, if branch and bound came to its
//# end, its optimum.
#[test]
fn no_landmark_serves_two_of_the_bound_s_stretches() {
    let report = json(&barloc(&["place", "--json", TRIANGLE]));
    let starts: Vec<f64> =
        report["disjoint_stretches_from_m"].as_array().unwrap().iter().map(|from| from.as_f64().unwrap()).collect();
    assert_eq!(starts.len() as u64, report["lower_bound"].as_u64().unwrap());
    let site = site::load(&root().join(TRIANGLE)).unwrap();
    let walls: Vec<[Point; 2]> = site.walls.iter().map(|wall| [wall.from, wall.to]).collect();
    let row = 0.03 * 3_f64.sqrt() / 2.0;
    let mut barcodes: Vec<Barcode> =
        (0..=63).map(|i| Barcode { at: [0.03 * f64::from(i), 0.0], heading: PI / 2.0 }).collect();
    // A row up is 15 mm along x: the slanted walls meet points of the grid in every other row.
    for y in (0..=62).step_by(2).map(|i| row * f64::from(i)) {
        barcodes.push(Barcode { at: [y / 3_f64.sqrt(), y], heading: -PI / 6.0 });
        barcodes.push(Barcode { at: [1.89 - y / 3_f64.sqrt(), y], heading: 7.0 * PI / 6.0 });
    }
    // The bound is one for the poses of the step.
    let poses = along_triangle(&site, 5e-3);
    let serves = |barcode: Barcode, from: f64| {
        poses.iter().any(|&(along, eye, heading)| {
            let behind = (along - from).rem_euclid(3.6);
            behind > 1e-6 && behind < 1.0 + 1e-6 && reads(eye, heading, barcode, &walls)
        })
    };
    let mut useful = 0;
    for barcode in barcodes {
        let served = starts.iter().filter(|&&from| serves(barcode, from)).count();
        assert!(served <= 1, "{barcode:?} serves {served}");
        useful += served;
    }
    assert!(useful > 0);
}

#[test]
fn landmarks_that_are_there_count_and_stay() {
    // With its own landmarks the placed triangle needs none.
    let report = json(&barloc(&["place", "--json", PLACED]));
    assert_eq!((report["landmarks"].as_u64(), report["lower_bound"].as_u64()), (Some(0), Some(0)));
    // Without its last one, one.
    let text = fs::read_to_string(root().join(PLACED)).unwrap();
    let (fewer, _) = text.rsplit_once("[[landmark]]").unwrap();
    let path = folder("fewer").join("two.toml");
    fs::write(&path, fewer).unwrap();
    let report = json(&barloc(&["place", "--json", path.to_str().unwrap()]));
    assert_eq!((report["landmarks"].as_u64(), report["lower_bound"].as_u64()), (Some(1), Some(1)));
}

/// A post of 20 mm at x = 1 hides the wall behind it, 0.2 m further, and may carry a barcode of 10 mm that is too fine to be
/// read. The camera drives at y = 0.5 from 0.26 m to 0.22 m before it. On the wall's grid of 25 mm the nearest place whose
/// barcode of 30 mm is not hidden is y = 0.55: its inner edge is seen at 640 * 35/460 = 48.7 px from the axis at first. The
/// fine barcode ends at 640 * 5/260 = 12.3 px and is 24.6 px wide, the narrower of both, so that the gap of 36.4 px is less
/// than 1.5 of it, 36.9 px; at the end it is 38.8 px of 43.6 px. At y = 0.575 it is 71.2 px.
//= reference/SPEC.md#place
//= type=test
//# - **PLACE-1** Landmarks MUST be put on points of the grid that lie on a wall (SITE-5), with the normal of a visible
//# face as heading, inside the codes and with unequal halves (CODE-6).
//= reference/SPEC.md#place
//= type=test
//# - **PLACE-6** Two landmarks that crowd each other in the image (SITE-11) from a sample of the route MUST be excluded
//# as a pair, if otherwise the check fails, and the choice made again.
//= reference/SPEC.md#place
//= type=test
//# - **PLACE-7** The result MUST be checked as the site that it is, by SITE-10 to SITE-13 at a fifth of the step, and
//# be refused if its longest gap is above `G`.
#[test]
fn a_neighbour_in_the_image_moves_the_landmark_on() {
    let site = |fine: &str| {
        parse(&format!(
            "[grid]\nstep_mm = [25, 25]\n[robot]\ncamera_x_mm = 0\n[[wall]]\nfrom_m = [1.2, 0.44]\nto_m = [1.2, 0.8]\n\
             face = \"left\"\n[[wall]]\nfrom_m = [1.0, 0.49]\nto_m = [1.0, 0.51]\nface = \"left\"\n{fine}\
             [route]\npoints_m = [[0.74, 0.5], [0.78, 0.5]]"
        ))
    };
    let fine = "[[landmark]]\nx_m = 1.0\ny_m = 0.5\nheading_deg = 180\nidentifier = 77\nstripe_width_mm = 0.5\n";
    let wish = Wish { gap: 0.02, format: Format::Paper, step: 0.005 };
    // Every place from 0.55 on would do without the fine barcode, but not 0.55 with it.
    let alone = place(&site(""), &Camera::epuck(), &wish).unwrap();
    assert_eq!((alone.chosen.len(), alone.bound.landmarks), (1, 1));
    let free = candidates(&site(""), Format::Paper).into_iter().filter(|candidate| candidate.codes.y >= 22);
    assert_eq!(free.map(|candidate| candidate.codes.y).collect::<Vec<_>>(), (22..=31).collect::<Vec<_>>());
    let mut with_fine = site(fine);
    let moved = place(&with_fine, &Camera::epuck(), &wish).unwrap();
    assert!(moved.chosen.len() == 1 && moved.chosen[0].codes.y >= 23, "{:?}", moved.chosen);
    // And indeed: put at 0.55 it is read nowhere.
    with_fine
        .landmarks
        .push(candidates(&site(""), Format::Paper).into_iter().find(|one| one.codes.y == 22).unwrap().posted);
    let found = cover_route(&with_fine, with_fine.route.as_ref().unwrap(), &Camera::epuck(), 0.005, 1).unwrap();
    assert!(found.readable.iter().all(Vec::is_empty), "{:?}", found.readable);
}

#[test]
fn help_shows_examples() {
    for command in ["coverage", "place"] {
        assert!(text(&barloc(&[command, "--help"]).stdout).contains("Examples:"));
    }
}

#[test]
fn what_cannot_be_placed_is_said_in_one_line() {
    let short = barloc(&["place", "--gap", "0.3", TRIANGLE]);
    assert_refused(&short, &["triangle.toml", "with a landmark at every possible place"]);
    assert_refused(&barloc(&["place", "--gap=-1", TRIANGLE]), &["gap"]);
    assert_refused(&barloc(&["place", "--gap", "nan", TRIANGLE]), &["gap"]);
    assert_refused(&barloc(&["place", "--step", "0", TRIANGLE]), &["steps"]);
    assert_refused(&barloc(&["coverage", "--step", "1e-12", TRIANGLE]), &["20 million"]);
    assert_refused(&barloc(&["coverage", "--headings", "0", TRIANGLE]), &["heading"]);
    let path = folder("empty").join("empty.toml");
    fs::write(&path, "").unwrap();
    assert_refused(&barloc(&["coverage", path.to_str().unwrap()]), &["empty.toml", "neither a route nor a region"]);
    assert_refused(&barloc(&["place", path.to_str().unwrap()]), &["empty.toml", "no route"]);
    assert_refused(&barloc(&["coverage", "missing.toml"]), &["missing.toml", "cannot be read"]);
}

fn assert_refused(output: &Output, words: &[&str]) {
    let complaint = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert_eq!(complaint.lines().count(), 1, "{complaint}");
    assert!(words.iter().all(|word| complaint.contains(word)), "{complaint} lacks {words:?}");
}

//= reference/SPEC.md#site
//= type=test
//# - **SITE-15** The heat map MUST show walls, landmarks, the route, the share of headings with a colour legend, axes
//# in metres and a scale.
#[test]
fn the_same_bytes_whatever_the_threads() {
    let folder = folder("threads");
    let run = |threads: &str| {
        let [coverage, place] = ["coverage.svg", "place.svg"].map(|name| folder.join(format!("{threads}-{name}")));
        let outputs = [
            barloc_on(threads, &["coverage", "--json", "--svg", coverage.to_str().unwrap(), PLACED]),
            barloc_on(threads, &["place", "--json", "--svg", place.to_str().unwrap(), TRIANGLE]),
        ];
        assert!(outputs.iter().all(|output| output.status.success()));
        (outputs.map(|output| output.stdout), [coverage, place].map(|path| fs::read_to_string(path).unwrap()))
    };
    let (one, five) = (run("1"), run("5"));
    assert_eq!(one, five);
    for word in ["x (m)", "y (m)", "20 cm", "wall", "route, readable", "Share of headings", "1: paper 2403"] {
        assert!(one.1[0].contains(word), "{word} is not on the map");
    }
}

// Files with something wrong.

/// The triangle's grid on a wall from (0, 0) to (2, 0) that is seen from the left.
const ROOM: &str = "[grid]\nstep_mm = [50, 50]\n[[wall]]\nfrom_m = [0.0, 0.0]\nto_m = [2.0, 0.0]\nface = \"left\"\n";

//= reference/SPEC.md#site
//= type=test
//# - **SITE-2** Whatever is wrong with a site file MUST be reported in one line with the file, the line and, where
//# there is one, the key.
//= reference/SPEC.md#site
//= type=test
//# - **SITE-3** Unknown keys, keys without their unit, numbers that are not finite, sizes that are not above 0, walls
//# and legs shorter than 1 mm, and coordinates beyond 1000 m MUST be refused.
//= reference/SPEC.md#site
//= type=test
//# - **SITE-5** A landmark MUST be refused unless it hangs on a wall: its centre at most 1 mm from the wall's plane,
//# its heading at most 0.01 rad from the normal of a visible face, its barcode and quiet zones between the wall's ends.
//= reference/SPEC.md#site
//= type=test
//# - **SITE-7** Two landmarks of which one's barcode reaches into the other's barcode or quiet zone, or that carry the
//# same payload in the same format, MUST be refused.
#[test]
fn what_is_wrong_is_said_with_line_and_key() {
    // What is added behind the six lines of the room, the line, the key, and words of the sentence.
    let cases: &[(&str, usize, &str, &str)] = &[
        ("[grids]", 7, "grids", "unknown field"),
        ("[robot]\ncolour = 1", 8, "robot.colour", "unknown field"),
        ("[[landmark]]\nx = 1.0", 8, "landmark[1].x", "no unit; write x_m"),
        ("[[wall]]\nfrom = [0, 0]", 8, "wall[2].from", "no unit; write from_m"),
        ("[[wall]]\nfrom_m = [0, 0]\nto_m = [0, 0]\nface = \"left\"", 9, "wall[2].to_m", "shorter than 1 mm"),
        ("[[wall]]\nfrom_m = [0, nan]\nto_m = [0, 1]\nface = \"left\"", 8, "wall[2].from_m", "not a finite number"),
        ("[[wall]]\nfrom_m = [0, 0]\nto_m = [-inf, 1]\nface = \"left\"", 9, "wall[2].to_m", "not a finite number"),
        ("[[wall]]\nfrom_m = [0, 0]\nto_m = [5e9, 1]\nface = \"left\"", 9, "wall[2].to_m", "too large"),
        ("[[wall]]\nfrom_m = [0, 0]\nto_m = [0, 1]\nface = \"up\"", 10, "wall[2].face", "unknown variant"),
        ("[[wall]]\nfrom_m = [0, 0]\nto_m = [0, 1]", 7, "wall[2]", "missing field `face`"),
        (
            "[[wall]]\nfrom_m = [0, 0, 0]\nto_m = [0, 1]\nface = \"left\"",
            8,
            "wall[2].from_m",
            "3 numbers where 2 are expected",
        ),
        ("[robot]\ncamera_x_mm = \"far\"", 8, "robot.camera_x_mm", "string"),
        ("[robot]\ncamera_heading_deg = nan", 8, "robot.camera_heading_deg", "not a finite number"),
        ("[[landmark]]\ncodes = [20, 1, 4]", 8, "landmark[1].codes", "not within 1 mm of any wall"),
        ("[[landmark]]\ncodes = [20, 0, 12]", 8, "landmark[1].codes", "faces into its wall"),
        ("[[landmark]]\nx_m = 1\ny_m = 0\nheading_deg = 270", 10, "landmark[1].heading_deg", "faces into its wall"),
        (
            "[[landmark]]\nx_m = 1\ny_m = 0\nheading_deg = 80\nidentifier = 1",
            10,
            "landmark[1].heading_deg",
            "not its wall's normal",
        ),
        ("[[landmark]]\ncodes = [0, 0, 4]", 8, "landmark[1].codes", "past the end of its wall"),
        ("[[landmark]]\ncodes = [64, 0, 4]", 8, "landmark[1].codes", "64 is not a code from 0 to 63"),
        ("[[landmark]]\ncodes = [20, 0]", 8, "landmark[1].codes", "2 numbers where 3 are expected"),
        ("[[landmark]]\ncodes = [20, 0, -4]", 8, "landmark[1].codes", "-4 is not a code from 0 to 15"),
        ("[[landmark]]\nx_m = 1.01\ny_m = 0\nheading_deg = 90", 8, "landmark[1].x_m", "not on the site's grid"),
        ("[[landmark]]\nx_m = -1\ny_m = 0\nheading_deg = 90", 8, "landmark[1].x_m", "outside the site's grid"),
        ("[[landmark]]\nx_m = 1.0\nheading_deg = 90", 8, "landmark[1].x_m", "all of x_m, y_m and heading_deg"),
        ("[[landmark]]\ncodes = [20, 0, 4]\nx_m = 1", 8, "landmark[1].codes", "either codes or"),
        ("[[landmark]]\n", 7, "landmark[1]", "needs codes"),
        ("[[landmark]]\ncodes = [20, 0, 4]\nstripe_width_mm = 0", 9, "landmark[1].stripe_width_mm", "not above 0"),
        ("[[landmark]]\ncodes = [20, 0, 4]\nstripe_width_mm = 40", 9, "landmark[1].stripe_width_mm", "20 mm"),
        ("[[landmark]]\ncodes = [20, 0, 4]\nstripe_height_mm = -25", 9, "landmark[1].stripe_height_mm", "not above 0"),
        ("[[landmark]]\ncodes = [20, 0, 4]\nidentifier = 65536", 9, "landmark[1].identifier", "does not fit"),
        ("[[landmark]]\ncodes = [20, 0, 4]\nidentifier = -1", 9, "landmark[1].identifier", "does not fit"),
        ("[[landmark]]\ncodes = [20, 0, 4]\nformat = \"large\"", 9, "landmark[1].format", "unknown variant"),
        (
            "[[landmark]]\ncodes = [20, 0, 4]\nidentifier = 1\n[[landmark]]\ncodes = [20, 0, 4]",
            11,
            "landmark[2].codes",
            "overlaps landmark[1]",
        ),
        (
            "[[landmark]]\ncodes = [20, 0, 4]\nidentifier = 9\n[[landmark]]\ncodes = [30, 0, 4]\nidentifier = 9",
            11,
            "landmark[2].codes",
            "same payload as landmark[1]",
        ),
        ("[route]\npoints_m = [[0, 1]]", 8, "route.points_m", "at least two points"),
        ("[route]\npoints_m = [[0, 1], [1, 1],\n [1, 1]]", 8, "route.points_m", "less than 1 mm away"),
        ("[route]\nclosed = true\npoints_m = [[0, 1], [1, 1], [0, 1]]", 9, "route.points_m", "less than 1 mm away"),
        ("[route]\npoints_m = [[0, 1], [1, 1]]\nclosed = 3", 9, "route.closed", "integer"),
        ("[route]\npoints = [[0, 1], [1, 1]]", 8, "route.points", "no unit; write points_m"),
        ("[region]\npolygon_m = [[0, 1], [1, 1]]", 8, "region.polygon_m", "at least three points"),
        ("[region]\npolygon_m = [[0, 1], [1, 1], [2, 1]]", 8, "region.polygon_m", "no area"),
        ("[grid]", 7, "grid", "duplicate"),
        ("[robot\n", 7, "", ""),
        ("= 3", 7, "", ""),
    ];
    for (added, line, key, words) in cases {
        assert_wrong(&format!("{ROOM}{added}"), *line, key, words);
    }
    assert_wrong("[grid]\nstep_mm = [0, 50]", 2, "grid.step_mm", "not above 0");
    assert_wrong("[grid]\nstep_mm = [50, -50]", 2, "grid.step_mm", "not above 0");
    assert_wrong("[grid]\nstep_mm = 50", 2, "grid.step_mm", "sequence");
    assert_wrong("[grid]\nstep = [50, 50]", 2, "grid.step", "no unit; write step_mm");
    assert_wrong("[grid]\ntheta_steps = 17", 2, "grid.theta_steps", "from 1 to 16");
    assert_wrong("[grid]\ntheta_steps = 0", 2, "grid.theta_steps", "from 1 to 16");
    assert_wrong("\n[grid]\norigin_m = [nan, 0]", 3, "grid.origin_m", "not a finite number");
}

fn assert_wrong(text: &str, line: usize, key: &str, words: &str) {
    let error = site::of_toml(text, Path::new("some/site.toml")).expect_err(text);
    let sentence = error.to_string();
    assert_eq!((error.line(), error.key()), (Some(line), key), "{sentence} for\n{text}");
    assert!(sentence.starts_with(&format!("some/site.toml:{line}: {key}")), "{sentence}");
    assert!(sentence.contains(words) && sentence.lines().count() == 1, "{sentence}");
}

/// CODE-6: a pose whose code word has equal halves. Found by encoding every pose along a wall.
#[test]
fn equal_halves_are_refused_by_name() {
    use reference::codeword::encode;
    // Any payload that cannot be encoded, its heading, and a wall through it with that normal.
    let payload = (0..=0xffff_u32).find(|&payload| encode(Format::Paper, payload).is_err()).unwrap();
    let (x, y, theta) = (payload >> 10, payload >> 4 & 63, payload & 15);
    let at = [f64::from(x) * 0.05, f64::from(y) * 0.05];
    // The wall's left is a quarter turn from its direction.
    let heading = f64::from(theta) * TAU / 16.0 - PI / 2.0;
    let [from, to] = [-0.5, 0.5].map(|s| [at[0] + s * heading.cos(), at[1] + s * heading.sin()]);
    let wall = format!("[[wall]]\nfrom_m = {from:?}\nto_m = {to:?}\nface = \"left\"\n");
    let landmark = format!("[[landmark]]\ncodes = [{x}, {y}, {theta}]");
    assert_wrong(&format!("{wall}{landmark}"), 6, "landmark[1].codes", "look the same");
    let identifier = format!("{wall}{landmark}\nidentifier = {payload}");
    assert_wrong(&identifier, 7, "landmark[1].identifier", "look the same");
}

#[test]
fn files_that_are_no_text_are_refused() {
    let folder = folder("bytes");
    let path = folder.join("binary.toml");
    fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    assert_refused(&barloc(&["coverage", path.to_str().unwrap()]), &["binary.toml", "cannot be read"]);
    let large = folder.join("large.toml");
    fs::write(&large, vec![b'#'; (1 << 22) + 1]).unwrap();
    assert_refused(&barloc(&["coverage", large.to_str().unwrap()]), &["large.toml", "larger than 4 MB"]);
    // Through the command: file, line and key in one line.
    let unit = folder.join("unit.toml");
    fs::write(&unit, "[[wall]]\nfrom = [0, 0]").unwrap();
    assert_refused(&barloc(&["place", unit.to_str().unwrap()]), &["unit.toml:2: wall[1].from: has no unit"]);
}

proptest! {
    /// Whatever the bytes, there is an answer of one line: arbitrary ones, and the triangle's with some changed.
    #[test]
    fn no_bytes_make_it_panic(
        bytes in proptest::collection::vec(any::<u8>(), 0..200),
        changes in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..8),
        numbers in proptest::collection::vec((any::<proptest::sample::Index>(), any::<f64>()), 0..4),
    ) {
        let placed = fs::read_to_string(root().join(PLACED)).unwrap();
        let mut changed = placed.clone().into_bytes();
        for (place, value) in changes {
            *place.get_mut(&mut changed) = value;
        }
        // Numbers of any size, where a number was.
        let mut words: Vec<String> = placed.split(' ').map(str::to_owned).collect();
        for (place, value) in numbers {
            let word = place.get_mut(&mut words);
            if let Some(digits) = word.trim_matches(['[', ',', ']', '\n']).parse::<f64>().ok().map(|_| format!("{value:?}")) {
                *word = word.replace(word.trim_matches(['[', ',', ']', '\n']), &digits);
            }
        }
        for text in [String::from_utf8_lossy(&bytes), String::from_utf8_lossy(&changed), words.join(" ").into()] {
            match site::of_toml(&text, Path::new("any.toml")) {
                Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
                Ok(site) => {
                    let route = site.route.as_ref();
                    route.map(|route| cover_route(&site, route, &Camera::epuck(), 0.05, 1));
                }
            }
        }
    }
}
