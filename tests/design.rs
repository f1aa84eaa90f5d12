//! `barloc design` as its users meet it: the table, the requirement, the drawing, and one line for every bad question.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::{env, fs};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn design(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_barloc"));
    command.arg("design").args(arguments).current_dir(root()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The report of a run that goes well.
fn report(arguments: &[&str]) -> Value {
    let output = design(&[arguments, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout).lines().count(), 1);
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A path for a file of these tests.
fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("design");
    fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// SPEC.md's table (RANGE), in centimetres, and the smaller one of both rows.
#[test]
fn ranges_are_those_of_the_specification() {
    let (widths, lines) = ([64.0, 61.1, 54.0, 43.2, 29.5], [50.0, 49.6, 49.2, 48.9, 48.7]);
    let report = report(&[]);
    let ranges = report["ranges"].as_array().unwrap();
    assert_eq!(ranges.len(), 5);
    for (i, range) in ranges.iter().enumerate() {
        let near = |key: &str, expected: f64| (100.0 * number(&range[key]) - expected).abs() <= 0.05;
        assert!((number(&range["inclination_deg"]) - 15.0 * i as f64).abs() < 1e-12);
        assert!(near("stripe_width_range_m", widths[i]) && near("scan_line_range_m", lines[i]), "{range}");
        assert!(near("range_m", f64::min(widths[i], lines[i])), "{range}");
        assert_eq!(range["limited_by"], if i < 3 { "scan_line_inclination" } else { "stripe_width" });
    }
    // A triangle from 4 cm to 50 cm whose sides rise by 240/640 on either side.
    assert!((number(&ranges[0]["area_m2"]) - 0.375 * 0.46 * 0.46).abs() < 1e-9);
    assert!((number(&ranges[0]["nearest_m"]) - 0.04).abs() < 1e-9);
    assert!(report["required"].is_null());
}

/// 24 stripes of 1.5 mm are 36 mm wide: whole in view from 18 mm / 0.375 on; at 60° their far end is 18 mm · sin 60° deeper.
#[test]
fn the_format_the_camera_and_the_stripe_width_are_used() {
    let wide = report(&["--landmark", "wide"]);
    assert_eq!(wide["landmark"], "wide");
    assert!((number(&wide["ranges"][0]["nearest_m"]) - 0.048).abs() < 1e-9);
    assert!((number(&wide["ranges"][4]["scan_line_range_m"]) - (0.5 - 0.018 * 0.75_f64.sqrt())).abs() < 1e-9);
    // Half the focal length, half the range by stripes: 32 cm; a third of it for 4.5 px.
    let camera = file("half.toml");
    fs::write(&camera, "focal_length_px = 320.0").unwrap();
    let half = report(&["--camera", camera.to_str().unwrap()]);
    assert!((number(&half["ranges"][0]["range_m"]) - 0.32).abs() < 1e-9);
    assert_eq!(half["ranges"][0]["limited_by"], "stripe_width");
    assert!((number(&report(&["--min-stripe-px", "4.5"])["ranges"][0]["range_m"]) - 0.64 / 3.0).abs() < 1e-9);
}

/// 1 m frontally takes stripes of 1 m · 1.5/640 and layers of 1 m · 4/80.
#[test]
fn a_reach_is_answered_with_dimensions_or_with_what_stands_against_it() {
    let metre = report(&["--reach", "1"]);
    assert!((number(&metre["required"]["stripe_width_m"]) - 1.5 / 640.0).abs() < 1e-12);
    assert!((number(&metre["required"]["stripe_height_m"]) - 0.05).abs() < 1e-12);
    let refused = |arguments: &[&str]| report(arguments)["required"]["refused_by"].as_str().unwrap().to_owned();
    // 21.1 mm; 10 mm wide at 1 cm; edge-on.
    assert_eq!(refused(&["--reach", "9"]), "landmark_stripe_width");
    assert_eq!(refused(&["--reach", "0.01"]), "field_of_view");
    assert_eq!(refused(&["--reach", "0.5", "--inclination", "-90"]), "stripe_width");
    let camera = file("rows.toml");
    fs::write(&camera, "lower_row = 3").unwrap();
    assert_eq!(refused(&["--camera", camera.to_str().unwrap(), "--reach", "0.3"]), "scan_line_inclination");
    // For people.
    let lines = text(&design(&["--reach", "1"]).stdout);
    assert!(lines.contains("1 m at 0° takes stripes 2.34 mm wide and layers 50.0 mm high"), "{lines}");
    assert!(text(&design(&["--reach", "9"]).stdout).contains("LAND-7"));
    assert!(["43.2 cm  stripe width", "50.0 cm  scan lines"].iter().all(|words| lines.contains(words)), "{lines}");
}

#[test]
fn bad_questions_are_one_line() {
    let folder = file("");
    let inside = file("file").join("area.svg");
    fs::write(file("file"), "").unwrap();
    let missing = file("missing").join("area.svg");
    let questions: [(&[&str], &str); 14] = [
        (&["--reach", "-1"], "positive"),
        (&["--reach", "0"], "positive"),
        (&["--reach", "NaN"], "positive"),
        (&["--reach", "inf"], "positive"),
        (&["--reach", "far"], "far"),
        (&["--reach", "1", "--inclination", "90.1"], "-90 to 90"),
        (&["--reach", "1", "--inclination", "-91"], "-90 to 90"),
        (&["--inclination", "nan"], "-90 to 90"),
        (&["--min-stripe-px", "0"], "0.1 to 100"),
        (&["--min-stripe-px", "-1.5"], "0.1 to 100"),
        (&["--min-stripe-px", "NaN"], "0.1 to 100"),
        (&["--svg", inside.to_str().unwrap()], "cannot be written"),
        (&["--svg", missing.to_str().unwrap()], "cannot be written"),
        (&["--svg", folder.to_str().unwrap()], "cannot be written"),
    ];
    for (arguments, words) in questions {
        let output = design(arguments);
        let complaint = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {complaint}");
        assert!(complaint.lines().count() == 1 && complaint.contains(words), "{arguments:?}: {complaint}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}

#[test]
fn help_shows_examples() {
    let help = text(&design(&["--help"]).stdout);
    assert!(help.contains("Examples:") && help.contains("barloc design --reach"));
}

/// The drawing in the README: `BARLOC_REGENERATE=1` writes it anew.
#[test]
fn the_drawing_is_up_to_date() {
    let committed = root().join("reference/detection_area.svg");
    let fresh = file("detection_area.svg");
    assert_eq!(design(&["--svg", fresh.to_str().unwrap()]).status.code(), Some(0));
    let fresh = fs::read(fresh).unwrap();
    if env::var_os("BARLOC_REGENERATE").is_some() {
        fs::write(&committed, &fresh).unwrap();
    }
    assert!(fs::read(committed).unwrap() == fresh, "reference/detection_area.svg is stale");
    assert!(fresh.len() < 60_000);
}

/// Pixel coordinates of the drawing's marks; the barcode's centre is at the origin of both axes.
fn marks(svg: &str) -> Vec<(f64, f64)> {
    let attribute = |line: &str, name: &str| -> f64 {
        line.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    let circles = svg.lines().filter(|line| line.starts_with("<circle"));
    circles.map(|line| (attribute(line, "cx"), attribute(line, "cy"))).collect()
}

/// The five marks of the ranges lie where 50.0, 49.6, 49.2, 43.2 and 29.5 cm at 0 to 60° are, to the same scale both ways.
#[test]
fn the_drawing_is_to_scale() {
    let path = file("scale.svg");
    assert_eq!(design(&["--svg", path.to_str().unwrap()]).status.code(), Some(0));
    let svg = fs::read_to_string(&path).unwrap();
    let marks = marks(&svg);
    let places: Vec<(f64, f64)> = [50.0, 49.6, 49.2, 43.2, 29.5]
        .iter()
        .zip(0..)
        .map(|(range, i)| (range * f64::from(15 * i).to_radians().cos(), range * f64::from(15 * i).to_radians().sin()))
        .collect();
    assert_eq!(marks.len(), places.len());
    let scale = (marks[0].1 - marks[4].1) / (places[4].1 - places[0].1);
    for (mark, place) in marks.iter().zip(&places) {
        assert!((mark.0 - marks[0].0 - scale * (place.0 - places[0].0)).abs() <= 2.0, "{marks:?}");
        assert!((marks[0].1 - mark.1 - scale * (place.1 - places[0].1)).abs() <= 2.0, "{marks:?}");
    }
    // Where no stripe is 80 px wide with the barcode in view nothing is marked.
    assert_eq!(design(&["--min-stripe-px", "80", "--svg", path.to_str().unwrap()]).status.code(), Some(0));
    let empty = fs::read_to_string(&path).unwrap();
    assert!(self::marks(&empty).is_empty() && empty.contains("0°: none, by field of view (3), (4)"));
    for words in ["(cm)", "stripe width (5)", "scan lines (6)", "30°", "paper"] {
        assert!(svg.contains(words), "{words}");
    }
}
