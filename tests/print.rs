//! Landmarks on paper: measured on rasters of programs that this project did not write, photographed from these rasters
//! by a camera that knows nothing of `reference::render`, and read by both pipelines.

// Pixels and grey levels: whole numbers of a few thousand.
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]

#[path = "print/camera.rs"]
mod camera;
#[path = "print/raster.rs"]
mod raster;

use camera::{Budget, View, photograph};
use nalgebra::Vector3;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use raster::{Raster, barcode_box, pdf, svg, words};
use reference::camera::Camera;
use reference::codeword::layers;
use reference::crossing::CrossingRule;
use reference::landmark::Format;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use verify::lockstep::Setting;
use verify::port::{Cameras, Landmarks};
use verify::trace::DetectionTrace;

/// PRINT-2, millimetres.
const TOLERANCE: f64 = 0.02;

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("print").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn barloc_print(arguments: &[&str], output: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_barloc"));
    command.arg("print").args(arguments).arg("-o").arg(output).output().unwrap()
}

fn printed(arguments: &[&str], output: &Path) {
    let outcome = barloc_print(arguments, output);
    assert!(outcome.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&outcome.stderr));
}

fn name(format: Format) -> &'static str {
    match format {
        Format::Paper => "paper",
        Format::Wide => "wide",
    }
}

/// One landmark as PDF and as SVG, and how to make a raster of each.
fn both_outputs(folder: &Path, arguments: &[&str]) -> [(PathBuf, raster::Rasterise); 2] {
    let outputs: [(PathBuf, raster::Rasterise); 2] = [(folder.join("one.pdf"), pdf), (folder.join("one.svg"), svg)];
    for (path, _) in &outputs {
        printed(arguments, path);
    }
    outputs
}

/// Twelve payloads that have a code word: the code words of tests/data/renders, the smallest and largest, and between.
const PAPER_PAYLOADS: [u32; 12] =
    [0xcc0d, 0x020b, 0x0000, 0xffff, 0x0001, 0x8000, 0x5555, 0xaaaa, 0x0ff0, 0x1234, 0xbeef, 0x0c54];
const WIDE_PAYLOADS: [u32; 12] = [
    0x30_5e2a, 0x00_0000, 0xff_ffff, 0x00_0001, 0x80_0000, 0x55_5555, 0xaa_aaaa, 0x0f_f0f0, 0x12_3456, 0xbe_ef00,
    0x00_c054, 0xc0_ffee,
];

#[test]
fn what_is_printed_is_read_by_both_pipelines_where_the_camera_stands() {
    let setting = Setting {
        cameras: Cameras::new(Camera::epuck()).unwrap(),
        landmarks: Landmarks::both(),
        rule: CrossingRule::Interpolated,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut distances = Vec::new();
    for (format, payloads) in [(Format::Paper, PAPER_PAYLOADS), (Format::Wide, WIDE_PAYLOADS)] {
        for payload in payloads {
            let folder = folder(&format!("read_{payload:x}"));
            let arguments = ["--landmark", name(format), "--id", &payload.to_string()];
            for (path, rasterise) in both_outputs(&folder, &arguments) {
                let area = barcode_box(&rasterise(&path, 150.0, [0.0, 0.0, 210.0, 297.0]));
                let raster = rasterise(&path, 1200.0, area.grown(3.0));
                // 0.01 mm are 0.03 px from here, more than a layer's middle is uncertain by.
                let area = barcode_box(&raster);
                for degrees in [0.0, 30.0, -45.0_f64] {
                    let view = View::new(0.25, degrees.to_radians(), 0.05);
                    let lines = photograph(&raster, area.centre(), &view, &mut rng);
                    let found = read(&setting, &lines, format, payload);
                    let budget = Budget::new(&view, &layers(format, payload).unwrap());
                    distances.push(check(&budget, &found, &format!("{} {degrees}°", path.display())));
                }
            }
        }
    }
    // The budget is that of interpolated transitions, three degrees of freedom: 3 on the average, with a standard error of
    // 0.2 for 144 views; the fit to the grey levels is better than that. Errors of print as large as the noise of the
    // transitions would add 3.
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    println!(
        "{} views, mean chi-square {mean:.2}, largest {:.1}",
        distances.len(),
        distances.iter().copied().fold(0.0, f64::max)
    );
    assert_eq!(distances.len(), 144);
    assert!(mean < 3.0, "mean chi-square {mean}");
}

/// The one detection of each pipeline, which are the same within the pipelines' bounds.
fn read(setting: &Setting, [upper, lower]: &[Vec<u8>; 2], format: Format, payload: u32) -> DetectionTrace {
    let [reference, port] = setting.run(upper, lower).map(|trace| {
        assert_eq!(
            trace.detections.len(),
            1,
            "{payload:x}: {:?}",
            trace.hypotheses.iter().map(|h| h.outcome).collect::<Vec<_>>()
        );
        trace.detections[0]
    });
    for found in [&reference, &port] {
        assert_eq!((found.format, found.payload), (format, payload));
    }
    let bound = setting.pose_bounds(&reference).unwrap();
    assert!((reference.pose.x - port.pose.x).abs() <= bound.x);
    assert!((reference.pose.y - port.pose.y).abs() <= bound.y);
    assert!((reference.pose.theta - port.pose.theta).abs() <= bound.theta);
    reference
}

/// Homography and pose lie in the budget; the chi-square of the homography.
fn check(budget: &Budget, found: &DetectionTrace, what: &str) -> f64 {
    let h = &found.homography;
    let distance = budget.chi_square(&Vector3::new(h.a, h.s, h.k));
    assert!(distance < camera::LARGEST_CHI_SQUARE, "{what}: chi-square {distance}");
    let [lowest, highest] = budget.poses();
    let heading = if found.pose.theta < 0.0 { found.pose.theta + core::f64::consts::TAU } else { found.pose.theta };
    let pose = Vector3::new(found.pose.x, found.pose.y, heading);
    println!(
        "{what}: off by {:.2} of up to {:.2} mm in x, {:.2} of {:.2} mm in y, {:.3} of {:.3} degrees",
        1e3 * (pose[0] - budget.pose()[0]).abs(),
        5e2 * (highest[0] - lowest[0]),
        1e3 * (pose[1] - budget.pose()[1]).abs(),
        5e2 * (highest[1] - lowest[1]),
        (pose[2] - budget.pose()[2]).to_degrees().abs(),
        (highest[2] - lowest[2]).to_degrees() / 2.0
    );
    for axis in 0..3 {
        assert!((lowest[axis]..=highest[axis]).contains(&pose[axis]), "{what}: {pose} not in {lowest} to {highest}");
        // A budget that allows anything would be none: 40 mm and 9 degrees either way at 25 cm.
        assert!(highest[axis] - lowest[axis] < [0.08, 0.08, 0.32][axis], "{what}: {lowest} to {highest}");
    }
    distance
}

/// The stripes of 0xcc0d and 0x305e2a, whose code words are those of images that this project did not draw.
const KNOWN: [(Format, &str, [&str; 2]); 2] = [
    (Format::Paper, "0xcc0d", ["10101100110000000101", "10101101010000000101"]),
    (Format::Wide, "0x305e2a", ["101000110000010111100101", "101000101010111111110101"]),
];

//= reference/SPEC.md#print
//= type=test
//# - **PRINT-2** The edges of stripes and layers and the ends of the scale bar MUST lie within 0.02 mm of their place.
#[test]
fn edges_are_where_they_belong_in_both_outputs() {
    for (format, id, stripes) in KNOWN {
        for (stripe, height) in [("1.5", "25"), ("2.345", "31.7")] {
            let folder = folder(&format!("edges_{id}_{stripe}"));
            let arguments = ["--landmark", name(format), "--id", id, "--stripe-mm", stripe, "--height-mm", height];
            let (stripe, height): (f64, f64) = (stripe.parse().unwrap(), height.parse().unwrap());
            for (path, rasterise) in both_outputs(&folder, &arguments) {
                let area = barcode_box(&rasterise(&path, 150.0, [0.0, 0.0, 210.0, 297.0]));
                let raster = rasterise(&path, 2400.0, area.grown(2.0));
                assert_edges(&raster, area.centre(), stripe, height, &stripes, &path);
                assert_heights(&raster, area.centre(), stripe, height, &stripes, &path);
            }
        }
    }
}

/// Every edge of both layers, measured from the barcode's middle, which is that of its four outermost edges.
fn assert_edges(raster: &Raster, about: [f64; 2], stripe: f64, height: f64, stripes: &[&str; 2], path: &Path) {
    let half = stripes[0].len() as f64 / 2.0;
    let edges: Vec<Vec<(f64, f64)>> = [-0.5, 0.5]
        .iter()
        .zip(stripes)
        .map(|(&side, stripes)| {
            let band = [about[1] + side * height - 1.0, about[1] + side * height + 1.0];
            let padded = format!("0{stripes}0");
            let pairs = padded.as_bytes().windows(2).enumerate().filter(|(_, pair)| pair[0] != pair[1]);
            pairs
                .map(|(v, pair)| {
                    let nominal = (v as f64 - half) * stripe;
                    let place = about[0] + nominal;
                    let span = [place - stripe / 2.0, place + stripe / 2.0];
                    (nominal, raster.upright_edge(band, span, pair[0] == b'1'))
                })
                .collect()
        })
        .collect();
    let outermost: Vec<f64> = edges.iter().flat_map(|layer| [layer[0].1, layer[layer.len() - 1].1]).collect();
    let middle = outermost.iter().sum::<f64>() / 4.0;
    let mut largest = 0.0_f64;
    for (nominal, measured) in edges.iter().flatten() {
        let error = measured - middle - nominal;
        assert!(error.abs() <= TOLERANCE, "{}: edge at {nominal} mm is {error} mm off", path.display());
        largest = largest.max(error.abs());
    }
    println!("{}: edges within {largest:.4} mm", path.display());
}

/// Both layers together in a guard bar, and the upper layer alone in a bar that ends there.
fn assert_heights(raster: &Raster, about: [f64; 2], stripe: f64, height: f64, stripes: &[&str; 2], path: &Path) {
    let half = stripes[0].len() as f64 / 2.0;
    let lone = |one: &str, other: &str| one.bytes().zip(other.bytes()).position(|pair| pair == (b'1', b'0')).unwrap();
    let places = [(0, 2.0), (lone(stripes[0], stripes[1]), 1.0), (lone(stripes[1], stripes[0]), 1.0)];
    for (place, layers) in places {
        let left = about[0] + (place as f64 - half + 0.25) * stripe;
        let measured = raster.black_height([left, left + stripe / 2.0]);
        assert!((measured - layers * height).abs() <= 2.0 * TOLERANCE, "{}: {measured} mm high", path.display());
    }
}

#[test]
fn the_scale_bar_is_100_mm_long() {
    let folder = folder("scale");
    for (path, rasterise) in both_outputs(&folder, &["--id", "7"]) {
        // The lower left of the page; the words stand to the right of it.
        let raster = rasterise(&path, 1200.0, [5.0, 270.0, 106.0, 22.0]);
        let length = raster.longest_row();
        println!("{}: scale bar {length:.4} mm", path.display());
        assert!((length - 100.0).abs() <= TOLERANCE, "{}: {length} mm", path.display());
    }
}

/// 3.75 mm beside and above the barcode, which is 2.5 stripes, and 8.3 mm below it, a third of a layer; the cut marks of
/// a piece as wide as that stand at its corners (PRINT-3, PRINT-5, PRINT-6).
//= reference/SPEC.md#land
//= type=test
//# - **LAND-5** The quiet zone MUST be white for at least 2.5 `X_dim` on either side of a barcode.
//= reference/SPEC.md#print
//= type=test
//# - **PRINT-3** Inside the cut marks the paper MUST be white for at least 2.5 `X_dim` on either side of the barcode
//# and above it.
//= reference/SPEC.md#print
//= type=test
//# - **PRINT-5** Every piece MUST have cut marks at its corners that lie outside of it.
//= reference/SPEC.md#print
//= type=test
//# - **PRINT-6** A piece's caption MUST stand below the barcode, at least a third of the stripe height away from it.
#[test]
fn the_quiet_zone_is_white_inside_the_cut_marks() {
    let folder = folder("quiet");
    for (path, rasterise) in both_outputs(&folder, &["--id", "7"]) {
        let raster = rasterise(&path, 600.0, [0.0, 0.0, 210.0, 297.0]);
        let [[left, right], [top, bottom]] = barcode_box(&raster).sides();
        // A pixel away from the barcode's own edges.
        let (quiet, below, pixel) = (3.75, 25.0 / 3.0, 0.05);
        let height = [top - quiet, bottom + below];
        for x in [[left - quiet, left - pixel], [right + pixel, right + quiet]] {
            assert!(raster.blackest(x, height) < 0.01, "{}", path.display());
        }
        for y in [[height[0], top - pixel], [bottom + pixel, height[1]]] {
            assert!(raster.blackest([left - quiet, right + quiet], y) < 0.01, "{}", path.display());
        }
        for (corner, outwards) in [(left - quiet, -1.0), (right + quiet, 1.0)] {
            // Between 1 and 4 mm outside, on the piece's upper edge, and as far above it, on its side.
            let beside = [
                (corner + outwards * 2.0).min(corner + outwards * 3.0),
                (corner + outwards * 2.0).max(corner + outwards * 3.0),
            ];
            assert!(raster.blackest(beside, [height[0] - 0.15, height[0] + 0.15]) > 0.9, "{}", path.display());
            assert!(
                raster.blackest([corner - 0.15, corner + 0.15], [height[0] - 3.0, height[0] - 2.0]) > 0.9,
                "{}",
                path.display()
            );
            assert!(raster.blackest(beside, [height[0] + 0.3, height[1]]) < 0.01, "{}", path.display());
        }
    }
}

/// At resolutions that put edges between pixels, black stays black where bars touch.
//= reference/SPEC.md#print
//= type=test
//# - **PRINT-4** Bars that touch along an edge, in one layer or across both, MUST be one outline, so that no light line
//# runs through them whatever the resolution.
#[test]
fn no_light_line_runs_through_the_black() {
    for (format, id, stripes) in KNOWN {
        let folder = folder(&format!("hairlines_{id}"));
        for (path, rasterise) in both_outputs(&folder, &["--landmark", name(format), "--id", id]) {
            let area = barcode_box(&rasterise(&path, 150.0, [0.0, 0.0, 210.0, 297.0]));
            let [x, y] = area.centre();
            for dpi in [93.0, 137.0, 211.0, 307.0] {
                let raster = rasterise(&path, dpi, area.grown(2.0));
                // Far enough from a bar's own edges for a pixel to lie inside it.
                let pixel = 25.4 / dpi;
                let mut touching = 0;
                for (side, layer) in [(-1.0, stripes[0]), (1.0, stripes[1])] {
                    for (j, pair) in layer.as_bytes().windows(2).enumerate().filter(|(_, pair)| *pair == b"11") {
                        assert_eq!(pair.len(), 2);
                        let edge = x + (j as f64 + 1.0 - stripes[0].len() as f64 / 2.0) * 1.5;
                        let span = [edge - 1.5 + 2.0 * pixel, edge + 1.5 - 2.0 * pixel];
                        assert!(raster.lightest(span, [y + side * 12.5 - 1.0, y + side * 12.5 + 1.0]) > 0.99);
                        touching += 1;
                    }
                }
                let both = stripes[0].bytes().zip(stripes[1].bytes()).enumerate();
                for (j, _) in both.filter(|(_, pair)| *pair == (b'1', b'1')) {
                    let left = x + (j as f64 - stripes[0].len() as f64 / 2.0) * 1.5;
                    let span = [left + 2.0 * pixel, left + 1.5 - 2.0 * pixel];
                    assert!(
                        raster.lightest(span, [y - 1.0, y + 1.0]) > 0.99,
                        "{}: {dpi} dpi, stripe {j}",
                        path.display()
                    );
                    touching += 1;
                }
                assert!(touching > 8);
            }
        }
    }
}

/// Ten poses along a wall.
fn ten_poses(folder: &Path) -> PathBuf {
    let list = folder.join("poses.csv");
    let lines: Vec<String> = (1..=10).map(|i| format!("{:.2},3.15,337.5", f64::from(i) * 0.3)).collect();
    fs::write(&list, format!("x_m,y_m,theta_deg\n{}\n", lines.join("\n"))).unwrap();
    list
}

/// The words by pdftotext, the black by resvg, which is built without text.
//= reference/SPEC.md#print
//= type=test
//# - **PRINT-7** Every page MUST have a scale bar of 100 mm and say that the barcode's centre is mounted at the
//# camera's height.
//= reference/SPEC.md#print
//= type=test
//# - **PRINT-11** A caption MUST give the pose that the payload stands for, or the identifier, and the payload in
//# hexadecimal digits.
#[test]
fn captions_overlap_nothing() {
    let folder = folder("captions");
    let list = ten_poses(&folder);
    let [text, shapes] = ["sheet.pdf", "sheet.svg"].map(|name| folder.join(name));
    printed(&["--sheet", list.to_str().unwrap()], &text);
    printed(&["--sheet", list.to_str().unwrap()], &shapes);
    let words = words(&text);
    let raster = svg(&shapes, 300.0, [0.0, 0.0, 210.0, 297.0]);
    assert!(raster.blackest([0.0, 210.0], [0.0, 297.0]) > 0.99);
    for (i, (word, [left, top, right, bottom])) in words.iter().enumerate() {
        assert!(*left > 5.0 && *right < 205.0 && *top > 5.0 && *bottom < 292.0, "{word}");
        assert!(raster.blackest([*left, *right], [*top, *bottom]) < 0.01, "{word} lies on something black");
        for (other, [l, t, r, b]) in &words[..i] {
            // Lines of text may overlap in their boxes' white above and below the letters: a tenth of a millimetre.
            let apart = left >= r || l >= right || top + 0.1 >= *b || t + 0.1 >= *bottom;
            assert!(apart, "{word} lies on {other}");
        }
    }
    // 0.3 m is code 6, 3.15 m code 63, 337.5 degrees code 15: 000110 111111 1111; and 3 m code 60.
    for payload in ["0x1bff,", "0xf3ff,"] {
        assert!(words.iter().any(|(word, _)| word == payload), "{payload}");
    }
    let said: Vec<&str> = words.iter().map(|(word, _)| word.as_str()).collect();
    let said = said.join(" ");
    assert!(said.contains("the barcode's centre (where its two layers meet) at the camera's height"), "{said}");
    assert!(said.contains("100 mm") && said.contains("x 2.7 m, y 3.15 m heading 337.5°"), "{said}");
}

//= reference/SPEC.md#print
//= type=test
//# - **PRINT-14** The same request MUST give the same bytes.
#[test]
fn a_long_sheet_has_several_pages_and_the_same_bytes_every_time() {
    let folder = folder("pages");
    let list = folder.join("ids.csv");
    let ids: Vec<String> = (0..30).map(|id| id.to_string()).collect();
    fs::write(&list, format!("id\n{}\n", ids.join("\n"))).unwrap();
    let sheet = ["--sheet", list.to_str().unwrap()];
    // Two PDFs and two sets of SVGs; twelve to a page.
    for (name, files) in [("a.pdf", vec!["a.pdf"]), ("a.svg", vec!["a-1.svg", "a-2.svg", "a-3.svg"])] {
        let again = folder.join("again");
        fs::create_dir_all(&again).unwrap();
        printed(&sheet, &folder.join(name));
        printed(&sheet, &again.join(name));
        for file in files {
            assert_eq!(fs::read(folder.join(file)).unwrap(), fs::read(again.join(file)).unwrap(), "{file}");
        }
    }
    assert!(!folder.join("a.svg").exists() && !folder.join("a-4.svg").exists());
    let words = words(&folder.join("a.pdf"));
    let pages = words.windows(4).filter(|four| four[0].0 == "page" && four[2].0 == "of" && four[3].0 == "3").count();
    assert_eq!(pages, 3);
}

//= reference/SPEC.md#print
//= type=test
//# - **PRINT-13** Files MUST be written whole or not at all.
#[test]
fn bad_input_is_one_line_and_nothing_is_written() {
    let folder = folder("bad");
    let file = |name: &str, content: &str| {
        let path = folder.join(name);
        fs::write(&path, content).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let empty = file("empty.csv", "");
    let headed = file("headed.csv", "x_m,y_m,theta_deg\n");
    let broken = file("broken.csv", "x_m,y_m,theta_deg\n0,0,0\n0,abc,0\n");
    let off = file("off.csv", "x_m,y_m,theta_deg\n0,0,0\n0,0.02,0\n");
    let ids = file("ids.csv", "id\n65536\n");
    // 0x02a0, 0 m 2.1 m 0 degrees: upper and lower half are both 0000 0010 1010 (CODE-6).
    let equal = "672";
    let cases: &[(&[&str], &str, &[&str])] = &[
        (&["--id", "7"], "out.png", &["out.png", ".svg or .pdf"]),
        (&["--id", "7"], "out", &[".svg or .pdf"]),
        (&["--id", "7"], "nowhere/out.pdf", &["nowhere/out.pdf", "cannot be written"]),
        (&["--pose", "nan,0,0"], "out.pdf", &["--pose", "nan", "finite"]),
        (&["--pose", "0,inf,0"], "out.pdf", &["--pose", "inf", "finite"]),
        (&["--pose", "1,2"], "out.pdf", &["--pose", "three"]),
        (&["--pose", "1,2,3,4"], "out.pdf", &["--pose", "three"]),
        (&["--pose", "0,0,0", "--id", "7"], "out.pdf", &["--pose", "--id"]),
        (&["--id", "7", "--sheet", &off], "out.pdf", &["--id", "--sheet"]),
        (&[], "out.pdf", &["--pose", "--id", "--sheet"]),
        (&["--id", "-7"], "out.pdf", &["--id", "-7"]),
        (&["--id", "65536"], "out.pdf", &["65536", "65535, 65534, 65533, 65532"]),
        (&["--id", "18446744073709551616"], "out.pdf", &["--id"]),
        (&["--id", equal], "out.pdf", &["672", "same", "671, 673, 670, 674"]),
        (&["--pose", "0,2.1,0"], "out.pdf", &["same", "0,2.05,0; 0,2.15,0; 0.05,2.1,0; "]),
        (&["--pose", "0.16,0.25,90"], "out.pdf", &["not on", "0.15,0.25,90; 0.2,0.25,90; 0.15,0.2,90; 0.15,0.3,90"]),
        (&["--pose", "-1,0.25,90"], "out.pdf", &["outside", "0,0.25,90; 0,0.2,90; 0,0.3,90; 0,0.15,90"]),
        (&["--pose", "1e308,-1e308,0"], "out.pdf", &["outside", "3.15,0,0; 3.15,0,"]),
        (&["--sheet", &empty], "out.pdf", &["empty.csv", "line 1"]),
        (&["--sheet", &headed], "out.pdf", &["headed.csv", "line 2"]),
        (&["--sheet", &broken], "out.pdf", &["broken.csv", "line 3", "column y_m", "abc"]),
        (&["--sheet", &off], "out.svg", &["off.csv", "line 3", "column y_m", "0,0,0; 0,0.05,0"]),
        (&["--sheet", &ids], "out.svg", &["ids.csv", "line 2", "column id", "65535"]),
        (&["--sheet", "missing.csv"], "out.svg", &["missing.csv", "cannot be read"]),
        (&["--id", "7", "--stripe-mm", "0.49"], "out.pdf", &["0.5 to 20 mm"]),
        (&["--id", "7", "--stripe-mm", "20.1"], "out.pdf", &["0.5 to 20 mm"]),
        (&["--id", "7", "--stripe-mm", "nan"], "out.pdf", &["0.5 to 20 mm"]),
        (&["--id", "7", "--stripe-mm", "-1"], "out.pdf", &["0.5 to 20 mm"]),
        (&["--id", "7", "--stripe-mm", "20"], "out.pdf", &["500.0 x", "room for"]),
        (&["--id", "7", "--height-mm", "200"], "out.pdf", &["room for"]),
        (&["--id", "7", "--height-mm", "nan"], "out.pdf", &["height"]),
    ];
    let before = fs::read_dir(&folder).unwrap().count();
    for (arguments, output, sayings) in cases {
        let outcome = barloc_print(arguments, &folder.join(output));
        let complaint = String::from_utf8(outcome.stderr).unwrap();
        assert_eq!(outcome.status.code(), Some(2), "{arguments:?}: {complaint}");
        assert_eq!(complaint.lines().count(), 1, "{arguments:?}: {complaint}");
        for words in *sayings {
            assert!(complaint.contains(words), "{arguments:?} does not say {words}: {complaint}");
        }
        assert!(outcome.stdout.is_empty());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), before, "{arguments:?} left a file");
    }
    // A folder in the place of one of several files: none is written.
    let blocked = folder.join("set-2.svg");
    fs::create_dir_all(&blocked).unwrap();
    let many = file("many.csv", &format!("id\n{}", "7\n".repeat(20)));
    let outcome = barloc_print(&["--sheet", &many], &folder.join("set.svg"));
    assert_eq!(outcome.status.code(), Some(2));
    assert!(String::from_utf8(outcome.stderr).unwrap().contains("set-2.svg"));
    assert!(!folder.join("set-1.svg").exists() && !folder.join("set-1.svg.part").exists());
}

/// What a refusal names can be printed.
#[test]
fn the_poses_that_are_named_can_be_printed() {
    let folder = folder("named");
    let outcome = barloc_print(&["--pose", "1.234,2.345,100"], &folder.join("out.svg"));
    let complaint = String::from_utf8(outcome.stderr).unwrap();
    let poses: Vec<&str> = complaint.trim().rsplit_once(": ").unwrap().1.split("; ").collect();
    assert_eq!(poses.len(), 4, "{complaint}");
    for pose in poses {
        printed(&["--pose", pose], &folder.join("out.svg"));
    }
}

#[test]
fn help_shows_examples_and_how_many_files_there_are() {
    let outcome = Command::new(env!("CARGO_BIN_EXE_barloc")).args(["print", "--help"]).output().unwrap();
    let help = String::from_utf8(outcome.stdout).unwrap();
    assert!(outcome.status.success() && help.contains("Examples:") && help.contains("FILE-1.svg"), "{help}");
}

/// A landmark of the triangle's lower wall, on its grid of 30 mm and 30 mm sqrt(3)/2 with twelve headings (30° each):
/// codes 9, 0, 3 are 001001 000000 0011. A heading of 45° is none of them, and the file must be one.
#[test]
fn poses_are_those_of_the_site() {
    let folder = folder("site");
    let site = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/sites/triangle.toml");
    let site = site.to_str().unwrap();
    let output = folder.join("landmark.svg");
    printed(&["--site", site, "--pose", "0.27,0,90"], &output);
    assert!(fs::read_to_string(&output).unwrap().contains("2403"));
    let refused = |arguments: &[&str], words: &str| {
        let outcome = barloc_print(arguments, &folder.join("refused.svg"));
        let complaint = String::from_utf8(outcome.stderr).unwrap();
        assert_eq!((outcome.status.code(), complaint.lines().count()), (Some(2), 1), "{complaint}");
        assert!(complaint.contains(words) && !folder.join("refused.svg").exists(), "{complaint}");
    };
    refused(&["--site", site, "--pose", "0.27,0,45"], "0.27,0,60");
    refused(&["--site", site, "--pose", "0.25,0,90"], "0.24,0,90");
    let broken = folder.join("broken.toml");
    fs::write(&broken, "[grid]\nstep = [30.0, 30.0]\n").unwrap();
    refused(&["--site", broken.to_str().unwrap(), "--pose", "0,0,90"], "broken.toml:2");
}
