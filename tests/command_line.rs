//! The command as its users meet it: results, one clear line for bad input, exit codes.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn barloc(arguments: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    Command::new(env!("CARGO_BIN_EXE_barloc")).args(arguments).current_dir(root).output().unwrap()
}

/// A folder for one test's files.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Exit 2 and just one line on standard error that names the file and has the words.
fn assert_refused(output: &Output, file: &str, words: &str) {
    let complaint = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{complaint}");
    assert_eq!(complaint.lines().count(), 1, "{complaint}");
    assert!(complaint.contains(file) && complaint.contains(words), "{complaint}");
}

const IMAGE: &str = "tests/data/renders/000.png";

#[test]
fn detect_gives_one_json_line_per_image_and_pipeline() {
    let output = barloc(&["detect", "--json", IMAGE, "tests/data/renders/014.png"]);
    assert_eq!(output.status.code(), Some(0));
    let lines: Vec<Value> = text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let names: Vec<_> = lines.iter().map(|line| (line["image"].as_str(), line["pipeline"].as_str())).collect();
    assert_eq!(
        names,
        [
            (Some(IMAGE), Some("reference")),
            (Some(IMAGE), Some("fixedpoint")),
            (Some("tests/data/renders/014.png"), Some("reference")),
            (Some("tests/data/renders/014.png"), Some("fixedpoint")),
        ]
    );
    // Truth from truth.csv; the position within 5 mm at 15 cm.
    for line in &lines[..2] {
        let found = &line["detections"][0];
        assert_eq!(found["format"], "paper");
        assert_eq!(found["payload"], "cc0d");
        assert_eq!(found["upper"], "110011000000");
        assert_eq!(found["lower"], "110101000000");
        let pose = &found["camera_in_landmark"];
        assert!((pose["x_m"].as_f64().unwrap() - 0.096_565_518).abs() < 5e-3);
        assert!((pose["y_m"].as_f64().unwrap() - 0.120_902_002).abs() < 5e-3);
        assert!((pose["theta_rad"].as_f64().unwrap() + 2.408_778_574).abs() < 0.02);
        assert_eq!((&found["estimator"], &found["decoder"]), (&"fit".into(), &"threshold".into()));
        // Both are within four standard deviations of what is claimed, and less than a millimetre is claimed.
        let deviation = |i: usize| found["covariance"][i][i].as_f64().unwrap().sqrt();
        assert!((pose["x_m"].as_f64().unwrap() - 0.096_565_518).abs() < 4.0 * deviation(0) && deviation(0) < 1e-3);
        assert!((pose["y_m"].as_f64().unwrap() - 0.120_902_002).abs() < 4.0 * deviation(1) && deviation(1) < 1e-3);
        let image = &found["image"];
        assert!(["a_px", "s_px", "k"].iter().all(|name| image[name].is_f64()));
        assert!(image["covariance"][2][0].is_f64() && found["margin"].as_f64().unwrap() > 0.0);
    }
    assert!(lines[2..].iter().all(|line| line["detections"].as_array().unwrap().is_empty()));
}

#[test]
fn detect_searches_the_formats_and_runs_the_pipelines_it_is_told_to() {
    let output = barloc(&["detect", "--json", "--pipeline", "fixedpoint", "--landmark", "wide", IMAGE]);
    assert_eq!(
        text(&output.stdout),
        format!("{{\"image\":\"{IMAGE}\",\"pipeline\":\"fixedpoint\",\"detections\":[]}}\n")
    );
    let output = barloc(&["detect", "--pipeline", "reference", IMAGE]);
    let lines = text(&output.stdout);
    assert!(lines.starts_with(&format!("{IMAGE} reference: paper cc0d, camera in landmark x 9.")), "{lines}");
    assert_eq!(lines.lines().count(), 1);
}

/// Files of one kind of fault each, and the words that name it.
fn bad_images(folder: &Path) -> Vec<(PathBuf, &'static str)> {
    let pgm = |width: usize, height: usize| {
        let mut bytes = format!("P5\n{width} {height}\n255\n").into_bytes();
        bytes.extend(std::iter::repeat_n(128, width * height));
        bytes
    };
    let deep = {
        let mut bytes = b"P5\n480 8\n65535\n".to_vec();
        bytes.extend(std::iter::repeat_n(1, 2 * 480 * 8));
        bytes
    };
    let whole = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(IMAGE)).unwrap();
    let files: [(&str, Vec<u8>, &str); 9] = [
        ("narrow.pgm", pgm(479, 8), "479 x 8"),
        ("one_row.pgm", pgm(480, 1), "480 x 1"),
        ("huge.pgm", b"P5\n4000000000 4000000000\n255\n".to_vec(), "4000000000 x 4000000000"),
        ("truncated.pgm", pgm(480, 8)[..2000].to_vec(), "broken"),
        ("truncated.png", whole[..whole.len() / 2].to_vec(), "broken"),
        ("header.png", whole[..20].to_vec(), "broken"),
        ("deep.pgm", deep, "8 bits"),
        ("text.png", b"this is not an image".to_vec(), "neither a PNG nor a PNM"),
        ("empty.png", Vec::new(), "neither a PNG nor a PNM"),
    ];
    let mut bad: Vec<_> = files
        .into_iter()
        .map(|(name, bytes, words)| {
            let path = folder.join(name);
            fs::write(&path, bytes).unwrap();
            (path, words)
        })
        .collect();
    bad.push((folder.join("missing.png"), "cannot be read"));
    bad.push((folder.to_owned(), "cannot be read"));
    bad
}

#[test]
fn a_bad_image_is_named_and_the_others_are_still_done() {
    for (path, words) in bad_images(&folder("bad_images")) {
        let name = path.to_str().unwrap();
        let output = barloc(&["detect", "--json", "--pipeline", "reference", IMAGE, name, IMAGE]);
        assert_refused(&output, name, words);
        assert_eq!(text(&output.stdout).matches("cc0d").count(), 2, "{name}");
    }
}

#[test]
fn colour_and_pgm_are_read() {
    let folder = folder("good_images");
    let grey = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(IMAGE)).unwrap();
    let grey = image::load_from_memory(&grey).unwrap();
    let pgm = folder.join("000.pgm");
    let colour = folder.join("000_colour.png");
    grey.save(&pgm).unwrap();
    grey.to_rgb8().save(&colour).unwrap();
    let output = barloc(&["detect", "--json", pgm.to_str().unwrap(), colour.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout).matches("cc0d").count(), 4);
}

#[test]
fn a_camera_file_is_used_and_a_nonsensical_one_is_refused() {
    let folder = folder("cameras");
    let refused = [
        ("zero.toml", "focal_length_px = 0.0", "focal length"),
        ("nan.toml", "focal_length_px = nan", "focal length"),
        ("rows.toml", "lower_row = 8", "rows"),
        ("unknown.toml", "focal = 640.0", "focal"),
        ("broken.toml", "= =", "does not describe a camera"),
    ];
    for (name, content, words) in refused {
        let path = folder.join(name);
        fs::write(&path, content).unwrap();
        let output = barloc(&["detect", "--camera", path.to_str().unwrap(), IMAGE]);
        assert_refused(&output, name, words);
    }
    assert_refused(&barloc(&["detect", "--camera", "missing.toml", IMAGE]), "missing.toml", "cannot be read");
    // Half the focal length halves the distance.
    let path = folder.join("half.toml");
    fs::write(&path, "focal_length_px = 320.0").unwrap();
    let output = barloc(&["detect", "--json", "--camera", path.to_str().unwrap(), "tests/data/renders/022.png"]);
    let line: Value = serde_json::from_str(text(&output.stdout).lines().next().unwrap()).unwrap();
    let pose = &line["detections"][0]["camera_in_landmark"];
    let distance = pose["x_m"].as_f64().unwrap().hypot(pose["y_m"].as_f64().unwrap());
    // The image was taken from 45.5 cm.
    assert!((distance - 0.227).abs() < 0.02, "{distance}");
}

#[test]
fn bad_usage_is_one_line() {
    assert_refused(&barloc(&["detect"]), "barloc", "IMAGE");
    assert_refused(&barloc(&["detect", "--colour", IMAGE]), "barloc", "--colour");
    assert_refused(&barloc(&["certfy"]), "barloc", "certfy");
    assert_refused(&barloc(&["certify", "--frames", "many"]), "barloc", "many");
    assert_refused(&barloc(&["certify", "--renders", "nowhere"]), "nowhere", "truth.csv");
    let file = folder("usage").join("file");
    fs::write(&file, "").unwrap();
    let inside = file.join("certify");
    let output = barloc(&["certify", "--frames", "10", "--out", inside.to_str().unwrap()]);
    assert_refused(&output, inside.to_str().unwrap(), "cannot be made a folder");
    let taken = folder("usage").join("taken");
    fs::create_dir_all(taken.join("certificate.json")).unwrap();
    let output = barloc(&["certify", "--frames", "10", "--out", taken.to_str().unwrap()]);
    assert_refused(&output, "certificate.json", "cannot be written");
    assert_eq!(fs::read_dir(&taken).unwrap().count(), 1);
    assert_refused(&barloc(&["certify", "--self-test", "--json"]), "barloc", "--json");
    assert_refused(&barloc(&["detect", "new\nline.png"]), "new\\nline.png", "cannot be read");
}

#[test]
fn accuracy_lists_every_point_for_both_pipelines_and_estimators() {
    let output = barloc(&["accuracy", "--views", "10", "--noise", "2,4", "--blur", "0.5,0.3", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let lines: Value = serde_json::from_slice(&output.stdout).unwrap();
    let lines = lines.as_array().unwrap();
    // Three conditions; 25 points and five of them again with the default landmark at 50 cm; four estimates each.
    assert_eq!(lines.len(), 3 * 30 * 4);
    let first = &lines[0];
    assert_eq!((&first["pipeline"], &first["estimator"]), (&"reference".into(), &"fit".into()));
    for name in ["distance_m", "inclination_deg", "noise_grey", "blur_px", "sigma_major_m", "sigma_minor_m"] {
        assert!(first[name].is_f64(), "{name}");
    }
    for name in ["sigma_theta_rad", "bound_major_m", "bound_minor_m", "bound_theta_rad", "nees", "nees_image"] {
        assert!(first[name].is_f64(), "{name}");
    }
    assert!(first["views"] == 10 && first["bias"].as_array().unwrap().len() == 3);
    let again = barloc(&["accuracy", "--views", "10", "--noise", "2,4", "--blur", "0.5,0.3", "--json"]);
    assert_eq!(output.stdout, again.stdout);
    assert_refused(&barloc(&["accuracy", "--noise", "loud"]), "barloc", "must be a number from 0.1 to 30");
    assert_refused(&barloc(&["accuracy", "--blur", "2"]), "barloc", "must be a number from 0.2 to 1.2");
    assert_refused(&barloc(&["accuracy", "--views", "10", "--svg", "no/such/folder.svg"]), "folder.svg", "");
}

#[test]
fn help_shows_examples() {
    for arguments in [&["--help"][..], &["certify", "--help"], &["detect", "--help"], &["accuracy", "--help"]] {
        let output = barloc(arguments);
        assert_eq!(output.status.code(), Some(0));
        assert!(text(&output.stdout).contains("Examples:"));
    }
}

#[test]
fn certify_writes_the_same_bytes_for_the_same_seed() {
    let folders = ["one", "two", "three"].map(|name| folder("certify").join(name));
    let run = |folder: &Path, seed: &str| {
        barloc(&["certify", "--frames", "200", "--seed", seed, "--json", "--out", folder.to_str().unwrap()])
    };
    let outputs = [run(&folders[0], "9"), run(&folders[1], "9"), run(&folders[2], "10")];
    for output in &outputs {
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    let files = folders.map(|folder| fs::read(folder.join("certificate.json")).unwrap());
    assert_eq!(files[0], files[1]);
    assert_ne!(files[0], files[2]);
    assert_eq!(files[0], outputs[0].stdout);
    let certificate: Value = serde_json::from_slice(&files[0]).unwrap();
    assert_eq!(certificate["verdict"], "pass");
    for key in ["seed", "commit", "toolchain", "frames", "marginal"] {
        assert!(!certificate[key].is_null(), "{key}");
    }
    for key in ["stage", "class", "cases", "max", "bound", "marginal", "verdict"] {
        assert!(certificate["stages"].as_array().unwrap().iter().all(|stage| !stage[key].is_null()), "{key}");
    }
}

/// A copy of the images with one payload of the table changed: the run must fail, and say so whoever reads it.
#[test]
fn a_wrong_truth_fails_the_verdict() {
    let images = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/renders");
    let copy = folder("renders");
    for entry in fs::read_dir(images).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, copy.join(path.file_name().unwrap())).unwrap();
    }
    let truth = fs::read_to_string(copy.join("truth.csv")).unwrap();
    fs::write(copy.join("truth.csv"), truth.replace("16,cc0d,", "16,cc0e,")).unwrap();
    let (copy, out) = (copy.to_str().unwrap().to_owned(), folder("renders_out"));
    let arguments = ["certify", "--frames", "10", "--json", "--renders", &copy, "--out", out.to_str().unwrap()];
    let output = barloc(&arguments);
    assert_eq!(output.status.code(), Some(1));
    let certificate: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(certificate["verdict"], "fail");
    let failing: Vec<_> = certificate["checks"].as_array().unwrap().iter().filter(|c| c["verdict"] == "fail").collect();
    assert!(failing.len() == 1 && failing[0]["found"] == "59 of 60", "{failing:?}");
    // A reader that does not wait changes nothing.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut command = Command::new(env!("CARGO_BIN_EXE_barloc"));
    let mut child = command.args(arguments).current_dir(root).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    for (from, to) in [("16,cc0d,", "16,1cc0d,"), ("16,cc0d,", "16,spam,"), ("0.096565518", "nan")] {
        fs::write(Path::new(&copy).join("truth.csv"), truth.replace(from, to)).unwrap();
        assert_refused(&barloc(&["certify", "--renders", &copy]), "truth.csv", "000.png");
    }
}

#[test]
fn a_disturbed_stage_fails_the_run_and_is_named() {
    let output = barloc(&["certify", "--self-test"]);
    let lines = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{lines}");
    for stage in verify::bounds::TABLE {
        let caught = lines
            .lines()
            .any(|line| line.starts_with(&format!("{}: ", stage.name)) && line.contains("run fails and names it"));
        assert!(caught, "{} is not in\n{lines}", stage.name);
    }
}
