//! Site files that are right.

use super::*;
use core::f64::consts::{FRAC_PI_2, PI};

const ROOM: &str = "
[[wall]]
from_m = [0.0, 0.0]
to_m = [2.0, 0.0]
face = \"left\"
";

fn site(text: &str) -> Site {
    of_toml(text, Path::new("site.toml")).unwrap()
}

//= reference/SPEC.md#site
//= type=test
//# - **SITE-1** A site file MUST be TOML with the parts `grid`, `robot`, `wall`, `landmark`, `route` and `region`, each
//# of which may be left out, and with its unit in every key that has one (`_m`, `_mm`, `_deg`).
//= reference/SPEC.md#site
//= type=test
//# - **SITE-8** The camera MUST stand 30 mm ahead of the middle of the robot's axle and look ahead, if the file does
//# not say otherwise.
#[test]
fn an_empty_file_is_the_default_site() {
    assert_eq!(site(""), Site::default());
    assert!((Site::default().camera_in_robot.x() - 0.03).abs() < 1e-15);
}

//= reference/SPEC.md#site
//= type=test
//# - **SITE-4** A landmark's pose MUST be given either as the codes of the grid or as world coordinates and heading.
#[test]
fn codes_and_world_coordinates_say_the_same() {
    // 20 steps of 50 mm, and a quarter of 16 headings.
    let coded = site(&format!("{ROOM}[[landmark]]\ncodes = [20, 0, 4]"));
    let posed = site(&format!("{ROOM}[[landmark]]\nx_m = 1.0\ny_m = 0.0\nheading_deg = 90.0"));
    let [coded, posed] = [coded.landmarks[0], posed.landmarks[0]];
    assert_eq!(coded.payload, posed.payload);
    // 010100 000000 0100.
    assert_eq!(coded.payload, 0b0101_0000_0000_0100);
    assert!((coded.landmark_in_world.x() - 1.0).abs() < 1e-12);
    assert!((coded.landmark_in_world.theta() - FRAC_PI_2).abs() < 1e-12);
}

//= reference/SPEC.md#site
//= type=test
//# - **SITE-6** A landmark MUST carry the payload of its pose (GRID), or else the identifier that it is given, if it
//# can be encoded (CODE-5, CODE-6).
#[test]
fn an_identifier_needs_no_grid() {
    let text =
        format!("{ROOM}[[landmark]]\nx_m = 1.234\ny_m = 0.0\nheading_deg = 90\nidentifier = 17\nformat = \"wide\"");
    let posted = site(&text).landmarks[0];
    assert_eq!((posted.payload, posted.landmark.format), (17, reference::landmark::Format::Wide));
}

#[test]
fn units_are_converted() {
    let text = "[grid]\nstep_mm = [30, 20.5]\norigin_m = [-1.0, 2.0]\ntheta_steps = 12\n[robot]\ncamera_x_mm = 0\n\
                camera_y_mm = -5.0\ncamera_heading_deg = 180.0";
    let found = site(text);
    assert_eq!(found.grid, Grid { origin: [-1.0, 2.0], step: [0.03, 0.0205], theta_steps: Some(12) });
    let camera = found.camera_in_robot;
    assert!(camera.x().abs() < 1e-15 && (camera.y() + 0.005).abs() < 1e-15 && (camera.theta() - PI).abs() < 1e-12);
}

#[test]
fn regions_have_holes() {
    let text = "[region]\npolygon_m = [[0, 0], [4, 0], [4, 4], [0, 4]]\nholes_m = [[[1, 1], [3, 1], [3, 3], [1, 3]]]";
    let region = site(text).region.unwrap();
    assert!(region.contains([0.5, 2.0]) && region.contains([3.5, 3.5]));
    assert!(!region.contains([2.0, 2.0]) && !region.contains([4.5, 2.0]));
}

//= reference/SPEC.md#site
//= type=test
//# - **SITE-9** Writing landmarks into a site file MUST keep its comments, order and spelling.
#[test]
fn written_landmarks_are_read_again_and_the_rest_stays() {
    let codes = reference::grid::Codes { x: 20, y: 0, theta: 4 };
    let path = Path::new("site.toml");
    let added = [(reference::landmark::Format::Paper, codes)];
    for text in [
        format!("# Above.\n{ROOM}  # Beside.\n[route]   # Odd   spacing\npoints_m = [[0,1],\n  [2,1]]\n# Below.\n"),
        format!("# With one.\n{ROOM}[[landmark]] # The first.\ncodes = [ 5,0 , 4 ]\n[robot]\ncamera_x_mm = 30\n"),
    ] {
        let written = with_landmarks(&text, path, &added).unwrap();
        let (before, after) = (site(&text), site(&written));
        assert_eq!(after.landmarks.len(), before.landmarks.len() + 1);
        assert_eq!(after.landmarks.last().unwrap().payload, 0b0101_0000_0000_0100);
        assert_eq!(Site { landmarks: before.landmarks.clone(), ..after }, before);
        // Every line is still there, in order.
        let mut lines = written.lines();
        assert!(text.lines().all(|line| lines.any(|other| other == line)), "{written}");
    }
    // An inline array becomes tables.
    let inline = format!("landmark = [{{ codes = [5, 0, 4] }}] # one\n{ROOM}");
    assert_eq!(site(&with_landmarks(&inline, path, &added).unwrap()).landmarks.len(), 2);
    // A byte order mark stays where it is.
    let marked = with_landmarks(&format!("\u{feff}{ROOM}"), path, &added).unwrap();
    assert!(marked.starts_with(&format!("\u{feff}{}", ROOM.lines().next().unwrap())), "{marked:?}");
    assert_eq!(site(&marked).landmarks.len(), 1);
}
