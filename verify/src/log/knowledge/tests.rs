//! `robot.toml`: what it says, what it may leave out, what is wrong with it.

use super::*;
use proptest::prelude::*;

fn knowledge(text: &str) -> Knowledge {
    Knowledge::of_toml(text, Path::new("robot.toml")).unwrap_or_else(|error| panic!("{error}"))
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-16** What it leaves out MUST be: GRID's default grid, both formats or those of its landmarks, the `epuck`
//# camera, OBSERVE-1's mounting, MOTION-8's wheels, a start at (0, 0, 0) known to 5 mm, 5 mm and 0.02 rad, five states,
//# images as observations, and mid-exposure as the stamp.
#[test]
fn what_is_left_out_is_an_e_puck_on_the_default_grid() {
    let found = knowledge("");
    assert_eq!(found, Knowledge::default());
    // Numbers of LOG-16, OBSERVE-1 and MOTION-8.
    assert_eq!(found.landmarks, Landmarks::Grid(Grid { origin: [0.0, 0.0], step: [0.05, 0.05], theta_steps: None }));
    assert_eq!(found.mounting, Mounting { x: 0.03, y: 0.0, heading: 0.0 });
    assert_eq!(found.wheels, Wheels { diameter: 0.041, axle: 0.053, steps_per_turn: 1000.0 });
    assert_eq!(found.start, Start { x: 0.0, y: 0.0, theta: 0.0, deviations: [0.005, 0.005, 0.02] });
    assert_eq!((found.states, found.observe, found.stamp), (States::Five, Observe::Image, Stamp::Exposure));
    assert_eq!(found.formats, [Format::Paper, Format::Wide]);
    // A part that is there and empty is the same.
    assert_eq!(knowledge("[grid]\n[camera]\n[robot]\n[start]"), Knowledge::default());
}

#[test]
fn what_is_said_is_known() {
    let text = "states = 3\nobserve = \"paper\"\nstamp = \"processing\"\nformats = [\"paper\"]\n[grid]\nstep_mm = [30, 25.98]\n\
                theta_steps = 12\n[camera]\nwidth_px = 320\n[robot]\ncamera_y_mm = -5\ncamera_heading_deg = 90\n\
                wheel_diameter_mm = 40\naxle_mm = 52.5\nsteps_per_turn = 1200\n[start]\nx_m = 1\ny_m = -2.5\n\
                theta_rad = 3.5\ndeviation_x_m = 1\ndeviation_theta_rad = 0.5";
    let found = knowledge(text);
    let grid = Grid { origin: [0.0, 0.0], step: [0.03, 0.02598], theta_steps: Some(12) };
    assert_eq!(found.landmarks, Landmarks::Grid(grid));
    assert_eq!((found.states, found.observe, found.stamp), (States::Three, Observe::Paper, Stamp::Processing));
    assert_eq!((found.formats, found.camera.width), (vec![Format::Paper], 320));
    assert_eq!((found.mounting.x, found.mounting.y), (0.03, -0.005));
    assert!((found.mounting.heading - core::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert_eq!(found.wheels, Wheels { diameter: 0.04, axle: 0.0525, steps_per_turn: 1200.0 });
    assert_eq!(found.start, Start { x: 1.0, y: -2.5, theta: 3.5, deviations: [1.0, 0.005, 0.5] });
}

const TABLE: &str = "[[landmark]]\nformat = \"wide\"\nidentifier = 17\nx_m = 1.0\ny_m = 2.0\nheading_deg = 180.0\n";

#[test]
fn a_table_of_landmarks_takes_the_grids_place() {
    let found = knowledge(TABLE);
    let Landmarks::Table(table) = &found.landmarks else { panic!("{found:?}") };
    assert_eq!((table[0].format, table[0].identifier, table[0].x, table[0].y), (Format::Wide, 17, 1.0, 2.0));
    assert!((table[0].heading - core::f64::consts::PI).abs() < 1e-15);
    // Only what is there is looked for, unless it says otherwise.
    assert_eq!(found.formats, [Format::Wide]);
    assert_eq!(knowledge(&format!("formats = [\"wide\", \"paper\"]\n{TABLE}")).formats, Format::ALL);
}

/// The line, the key and a few words of what is wrong.
//= reference/SPEC.md#log
//= type=test
//# - **LOG-15** What a robot knows MUST be TOML with the parts `grid` or `landmark`, `camera`, `robot` and `start` and
//# the keys `states`, `observe`, `stamp` and `formats`, with its unit in every key that has one, and be refused as a
//# site file is (SITE-2, SITE-3).
//= reference/SPEC.md#log
//= type=test
//# - **LOG-17** A table of landmarks MUST give each a format, an identifier that can be encoded (CODE-5, CODE-6), and a
//# pose, and no two of them the same format and identifier.
#[test]
fn nonsense_is_named_with_line_and_key() {
    let twice = format!("{TABLE}\n{TABLE}");
    let both = format!("[grid]\nstep_mm = [50, 50]\n{TABLE}");
    let other = format!("formats = [\"paper\"]\n{TABLE}");
    let unequal = TABLE.replace("17", "-1");
    for (text, line, key, words) in [
        ("states = 4", 1, "states", "neither 3 nor 5"),
        ("\nobserve = \"sonar\"", 2, "observe", "unknown variant"),
        ("stamp = 3", 1, "stamp", ""),
        ("formats = []", 1, "formats", "no format"),
        (&other, 1, "formats", "format of a landmark"),
        ("[start]\ntheta = 1", 2, "start.theta", "write theta_rad"),
        ("[robot]\naxle = 53", 2, "robot.axle", "write axle_mm"),
        ("[grid]\nstep = 1", 2, "grid.step", "write step_mm"),
        ("[robot]\nwheels = 3", 2, "robot.wheels", "unknown field"),
        ("[wall]\nfrom_m = [0, 0]", 1, "wall", "unknown field"),
        ("[robot]\n\naxle_mm = 0", 3, "robot.axle_mm", "not above 0"),
        ("[robot]\naxle_mm = nan", 2, "robot.axle_mm", "not a finite number"),
        ("[robot]\ncamera_x_mm = 1001", 2, "robot.camera_x_mm", "too large"),
        ("[start]\nx_m = 100.5", 2, "start.x_m", "too large"),
        ("[start]\ndeviation_x_m = 0.0", 2, "start.deviation_x_m", "not above 0"),
        ("[grid]\nstep_mm = [50, 200]", 1, "grid", "beyond ±100 m"),
        ("[grid]\norigin_m = [-101, 0]", 1, "grid", "beyond ±100 m"),
        ("[camera]\nheight_px = 8\nfocal_length_px = 1", 3, "camera.focal_length_px", "focal length"),
        ("[camera]\nheight_px = 1", 2, "camera.height_px", "height"),
        ("[camera]\nwide = 1", 2, "camera.wide", "unknown field"),
        (&both, 3, "landmark[1]", "a grid as well"),
        (&twice, 10, "landmark[2].identifier", "landmark[1] has the same"),
        (&unequal, 3, "landmark[1].identifier", "does not fit"),
        ("states = 3\nstates = 5", 2, "states", "duplicate"),
    ] {
        let error = Knowledge::of_toml(text, Path::new("robot.toml")).expect_err(text);
        let sentence = error.to_string();
        assert_eq!((error.line(), error.key()), (Some(line), key), "{text}\n{sentence}");
        assert!(sentence.starts_with(&format!("robot.toml:{line}: ")) && sentence.contains(words), "{sentence}");
        assert!(!sentence.contains('\n'));
    }
}

/// A grid of 200 mm is within ±100 m for the smaller format.
#[test]
fn a_coarse_grid_may_do_without_the_larger_format() {
    let found = knowledge("formats = [\"paper\"]\n[grid]\nstep_mm = [200, 200]");
    assert_eq!(found.landmarks, Landmarks::Grid(Grid { step: [0.2, 0.2], ..Grid::default() }));
}

proptest! {
    /// Whatever a file says in millimetres and degrees is written so that it is read as the same.
    #[test]
    fn what_is_written_is_read_as_the_same(
        steps in [1..3_000_000_u32, 1..3_000_000_u32], millis in proptest::array::uniform5(1e-3..900.0f64), table in any::<bool>(),
        degrees in [-360.0..360.0f64, -360.0..360.0f64], start in proptest::array::uniform3(-99.0..99.0f64),
        deviations in proptest::array::uniform3(1e-9..9.0f64), theta_steps in proptest::option::of(1..17_u32),
        three in any::<bool>(), observe in 0..3_usize, processing in any::<bool>(),
    ) {
        let [x_step, y_step] = steps.map(|step| f64::from(step) / 1e6);
        let grid = Grid { origin: [start[0] / 100.0, start[1] / 100.0], step: [x_step / 1000.0, y_step / 1000.0], theta_steps };
        let listed = Listed { format: Format::Paper, identifier: 5, x: start[1], y: start[2], heading: degrees[1].to_radians() };
        let known = Knowledge {
            landmarks: if table { Landmarks::Table(vec![listed]) } else { Landmarks::Grid(grid) },
            formats: vec![Format::Paper],
            camera: Camera { focal_length: 400.0 + millis[0], ..Camera::epuck() },
            mounting: Mounting { x: millis[0] / 1000.0, y: -millis[1] / 1000.0, heading: degrees[0].to_radians() },
            wheels: Wheels { diameter: millis[2] / 1000.0, axle: millis[3] / 1000.0, steps_per_turn: millis[4] },
            start: Start { x: start[0], y: start[1], theta: start[2], deviations },
            states: if three { States::Three } else { States::Five },
            observe: [Observe::Image, Observe::Pose, Observe::Paper][observe],
            stamp: if processing { Stamp::Processing } else { Stamp::Exposure },
        };
        prop_assert_eq!(knowledge(&known.to_toml()), known);
    }

    /// Whatever the bytes, there is an answer in one line.
    #[test]
    fn no_text_makes_it_panic(text in "[a-z_\\[\\]=\"0-9.\n -]{0,80}") {
        if let Err(error) = Knowledge::of_toml(&text, Path::new("robot.toml")) {
            prop_assert!(!error.to_string().contains('\n'));
        }
    }
}
