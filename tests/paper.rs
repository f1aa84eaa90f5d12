//! The figures of the paper, made anew: what of them must hold, that they repeat, and the command that shows them.

use rayon::ThreadPoolBuilder;
use reference::regression::{EQUAL_WIDTH, MAJOR, ROTATION};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;
use verify::figures::drawing::FIGURES;
use verify::figures::limits::{Prediction, RowReading};
use verify::figures::report::{CellPoses, Report};
use verify::figures::statements::{BETTER, EXPONENTIAL, MAGNITUDE, PAPER_FALSE, RANGE_TOLERANCE};
use verify::figures::studies::Plan;

/// A seed of its own, so that nothing was chosen by what seed 1 gives.
static REPORT: LazyLock<Report> = LazyLock::new(|| Report::new(&Plan { views: 200, seed: 20_130_101 }, &|_| {}));

fn cell(inclination_deg: u32, distance_cm: u32) -> &'static CellPoses {
    REPORT.poses.iter().find(|cell| (cell.inclination_deg, cell.distance_cm) == (inclination_deg, distance_cm)).unwrap()
}

/// Standard deviations along the major axis, mm: whole-pixel, interpolated.
fn major(cell: &CellPoses) -> (f64, f64) {
    let along = |spread: verify::figures::spread::Spread| 1000.0 * spread.major.sqrt();
    (along(cell.errors.whole_pixel.unwrap()), along(cell.errors.interpolated.unwrap()))
}

#[test]
fn both_pipelines_find_the_same() {
    assert!(REPORT.pipelines.agree(), "{:?}", REPORT.pipelines);
    // SAME-4 counts them. They are ties that both decide alike; more than 1 in 200 frames would be no evidence.
    assert!(200 * REPORT.pipelines.marginal <= REPORT.pipelines.frames, "{:?}", REPORT.pipelines);
    let apart = |cell: &verify::figures::report::CellRates| {
        let seen = [cell.seen.whole_pixel, cell.seen.interpolated];
        seen.iter().map(|it| it.found.reference.abs_diff(it.found.fixedpoint)).sum::<u64>()
    };
    let apart: u64 = REPORT.barcodes.iter().chain(&REPORT.inclinations).map(apart).sum();
    assert!(apart <= REPORT.pipelines.differing);
}

/// 4 barcodes at 11 distances, 30 views each: the paper's 1,320, of which it had 3 false detections.
#[test]
fn fig_9a_has_the_papers_views_and_no_more_false_detections() {
    let views: u64 = REPORT.barcodes.iter().map(|cell| cell.seen.whole_pixel.views).sum();
    assert_eq!((REPORT.barcodes.len(), views), (44, PAPER_FALSE.1));
    let wrong = |cell: &verify::figures::report::CellRates| cell.seen.whole_pixel.wrong;
    assert!(REPORT.barcodes.iter().map(|cell| wrong(cell).reference).sum::<u64>() <= PAPER_FALSE.0);
    assert!(REPORT.barcodes.iter().map(|cell| wrong(cell).fixedpoint).sum::<u64>() <= PAPER_FALSE.0);
}

/// RANGE-3 asks for 99 % up to 45 cm: at that rate more than 2 of 30 views are missed in 0.3 % of the cells. The paper's rule is asked for the same only up to 40 cm, 2.4 px per stripe, since whole pixels repeat
/// their phase towards 2 px.
#[test]
fn frontally_the_landmark_is_found() {
    for cell in &REPORT.barcodes {
        let [whole, interpolated] =
            [cell.seen.whole_pixel, cell.seen.interpolated].map(|it| it.views - it.found.reference);
        assert!(cell.distance_cm > 45 || interpolated <= 2, "{cell:?}");
        assert!(cell.distance_cm > 40 || whole <= 2, "{cell:?}");
    }
}

fn best(predictions: &[Prediction], reading: RowReading) -> &Prediction {
    predictions.iter().find(|prediction| prediction.reading == reading).unwrap()
}

/// One `L_min` explains the range at every inclination where (6) is read for a row that integrates over its height:
/// by half of the row, and by THRESH-4's contrast. At 45° and 60° it is (5) that ends the range.
#[test]
fn ranges_are_within_a_tenth_of_the_prediction() {
    for (rule, ranges) in REPORT.ranges.named() {
        for reading in [RowReading::HalfRow, RowReading::Contrast] {
            let best = best(&ranges.best, reading);
            assert!(best.worst <= RANGE_TOLERANCE, "{rule}: {best:?}");
            // Not below Nyquist's limit of 1 px, and not above the paper's 1.5 px, at which views are still found.
            assert!((1.0..=1.5).contains(&best.min_stripe_pixels), "{rule}: {best:?}");
        }
        for inclination in ranges.inclinations.iter().filter(|range| range.inclination_deg >= 45) {
            // 4 m / 6.3 rows less 15 mm sin 60°.
            assert!(inclination.half.unwrap().metres < 0.622, "{rule}: {inclination:?}");
        }
    }
}

/// What does not hold, and why: the renderer's row integrates over its height (RENDER-3), so that at 55 cm, a tenth beyond
/// (6) as printed, 2/0.55 - 3 = 64 % of it still see stripes. Of 160 grey levels that leaves 102, where THRESH-4 asks for
/// 24, and no detector of this specification drops there; RANGE-4 ends it at 66.7 cm.
#[test]
fn the_frontal_drop_is_between_the_printed_range_and_the_blind_one() {
    for (rule, ranges) in REPORT.ranges.named() {
        let frontal = ranges.inclinations[0].half.unwrap().metres;
        assert!(frontal > 0.5 * (1.0 + RANGE_TOLERANCE) && frontal < 2.0 / 3.0, "{rule}: {frontal}");
        assert!(best(&ranges.best, RowReading::WholeRow).worst > RANGE_TOLERANCE, "{rule}");
    }
}

/// From 30° on half of the views are found farther away than where (5) has the paper's 1.5 px, and nearer than where it has
/// 1.1 px: HYPO-11 refuses 1.25 px on the average of the stripes, of which the farthest, 13 mm deeper than the centre at
/// 36 cm and 60°, is less than a tenth narrower.
#[test]
fn detection_ends_between_the_papers_minimum_and_the_refusal_of_narrow_barcodes() {
    for (rule, ranges) in REPORT.ranges.named() {
        for range in ranges.inclinations.iter().filter(|range| range.inclination_deg >= 30) {
            let (camera, landmark) = (
                reference::camera::Camera::epuck(),
                reference::landmark::Landmark::new(reference::landmark::Format::Paper),
            );
            let at = |pixels: f64| {
                let inclination = f64::from(range.inclination_deg).to_radians();
                reference::range::stripe_width_range(&camera, &landmark, inclination, pixels)
            };
            let half = range.half.unwrap().metres;
            assert!(at(1.5) < half && half < at(1.1), "{rule}: {range:?}");
        }
    }
}

/// design.md's table comes from another program, in another language, with other barcodes: the number of transitions,
/// from 8 to 20 in a layer, changes a standard deviation by up to √(20/8) = 1.6, half of that either way: 1.26. With
/// 60 of its views (9 %) and 200 of ours (5 %), at two standard deviations of their difference (20 %), a factor of 1.5.
#[test]
fn standard_deviations_are_those_of_an_independent_program() {
    let table = [(30, 0, 32.0, 4.5), (40, 30, 110.0, 16.0), (50, 0, 159.0, 34.0), (50, 45, 168.0, 39.0)];
    for (cm, degrees, whole_pixel, interpolated) in table {
        let (whole, inter) = major(cell(degrees, cm));
        for (found, stated) in [(whole, whole_pixel), (inter, interpolated)] {
            assert!((2.0 / 3.0..=1.5).contains(&(found / stated)), "{cm} cm, {degrees}°: {found} for {stated}");
        }
    }
}

/// ERRATA-7: whole-pixel transitions give (11)'s order of magnitude, √10 either way.
#[test]
fn the_papers_larger_eigenvalue_has_our_order_of_magnitude() {
    let ratios: Vec<f64> = REPORT
        .poses
        .iter()
        .filter_map(|cell| {
            let sample = cell.sample(|errors| errors.whole_pixel);
            Some((sample.usable()?.major / MAJOR.variance(sample.distance)).sqrt().ln())
        })
        .collect();
    assert!(ratios.len() >= 40, "{}", ratios.len());
    let mean = (ratios.iter().sum::<f64>() / ratios.len() as f64).exp();
    assert!((1.0 / MAGNITUDE..=MAGNITUDE).contains(&mean), "{mean}");
}

/// (11): ln λ grows linearly with the distance, with at least four fifths of its variance explained. The slopes lie
/// around the local ones of the geometry's d⁶ and d⁴ in the middle of the distances, 6/0.3 = 20 and 4/0.3 = 13 per metre,
/// up to a factor of 2; λ2 grows faster where the errors' bend adds to it, as λ1², hence up to 2 * 20.
#[test]
fn eigenvalues_grow_exponentially_with_the_distance() {
    for (rule, fits) in REPORT.regressions.named() {
        let fits = fits.unwrap();
        assert!(fits.major.r_squared >= EXPONENTIAL && fits.minor.r_squared >= EXPONENTIAL, "{rule}: {fits:?}");
        assert!((10.0..=40.0).contains(&fits.major.slope), "{rule}: {fits:?}");
        assert!((6.5..=40.0).contains(&fits.minor.slope), "{rule}: {fits:?}");
    }
}

/// (12) and its closed form (ERRATA-6). The paper's own fit is 0.09 and 0.14 rad off the closed form: with its rule ours
/// may be twice that off either, interpolated crossings must come nearer to the closed form than the paper did.
#[test]
fn the_rotation_is_the_closed_form_and_the_papers() {
    let of = |fits: Option<verify::figures::regressions::Regressions>| {
        let line = fits.unwrap().rotation;
        (line.slope, -line.intercept)
    };
    let (gain, step) = of(REPORT.regressions.whole_pixel);
    for expected in [ROTATION, EQUAL_WIDTH] {
        assert!((gain - expected.gain).abs() <= 0.18 && (step - expected.step).abs() <= 0.28, "{gain} {step}");
    }
    let (gain, step) = of(REPORT.regressions.interpolated);
    assert!((gain - EQUAL_WIDTH.gain).abs() < (ROTATION.gain - EQUAL_WIDTH.gain).abs(), "{gain}");
    assert!((step - EQUAL_WIDTH.step).abs() < (ROTATION.step - EQUAL_WIDTH.step).abs(), "{step}");
}

/// In design.md's table interpolated crossings are 7.1, 6.9, 4.7 and 4.3 times more precise: on the average over the cells
/// at least as much as the least of these, and half of it in every one.
#[test]
fn interpolated_crossings_are_better() {
    let factors: Vec<f64> = REPORT
        .poses
        .iter()
        .filter_map(|cell| {
            let whole = *cell.sample(|errors| errors.whole_pixel).usable()?;
            let interpolated = *cell.sample(|errors| errors.interpolated).usable()?;
            Some((whole.major / interpolated.major).sqrt())
        })
        .collect();
    let mean = (factors.iter().map(|factor| factor.ln()).sum::<f64>() / factors.len() as f64).exp();
    assert!(mean >= 4.3, "{mean}");
    assert!(factors.iter().all(|factor| *factor >= BETTER), "{factors:?}");
}

/// A statement and what it is made from say the same.
#[test]
fn statements_follow_the_numbers() {
    let statement = |subject: &str| REPORT.statements.iter().find(|it| it.subject.starts_with(subject)).unwrap();
    let frontal = REPORT.ranges.whole_pixel.inclinations[0].half.unwrap().metres;
    let drop = statement("9 a) frontal drop");
    assert_eq!(drop.agrees, (frontal / 0.5 - 1.0).abs() <= RANGE_TOLERANCE);
    assert!(drop.ours.contains(&format!("{:.1} cm", 100.0 * frontal)), "{drop:?}");
    let mut other = REPORT.clone();
    other.ranges.whole_pixel.inclinations[0].half.as_mut().unwrap().metres = 0.51;
    let other = verify::figures::statements::statements(&other);
    assert!(other.iter().any(|it| it.subject.starts_with("9 a) frontal drop") && it.agrees));
}

#[test]
fn figures_do_not_depend_on_the_number_of_threads() {
    let plan = Plan { views: 12, seed: 5 };
    let made = [1, 2, 5].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let report = pool.install(|| Report::new(&plan, &|_| {}));
        let pictures = FIGURES.map(|(_, draw)| draw(&report).unwrap());
        (report.to_json(), pictures)
    });
    assert!(made[0] == made[1] && made[0] == made[2]);
    assert!(made[0].0 != Report::new(&Plan { seed: 6, ..plan }, &|_| {}).to_json());
}

fn barloc(arguments: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    Command::new(env!("CARGO_BIN_EXE_barloc")).args(arguments).current_dir(root).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn the_command_writes_json_and_pictures() {
    let folder = folder("paper").join("figures");
    let _ = fs::remove_dir_all(&folder);
    let output = barloc(&["paper", "--views", "10", "--seed", "3", "--json", "--svg", folder.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((json["views"].as_u64(), json["seed"].as_u64()), (Some(10), Some(3)));
    assert_eq!(json["paper"]["major"], serde_json::json!([25.7, -15.46]));
    for (key, count) in [("barcodes", 44), ("inclinations", 55), ("poses", 55), ("changes", 6)] {
        assert_eq!(json[key].as_array().unwrap().len(), count, "{key}");
    }
    let labels = [
        ("fig9a.svg", &["distance, cm", "found, % of the views", "barcode 4 of 4", "whole-pixel", "paper: "][..]),
        ("fig9b.svg", &["distance, cm", "inclination 60°", "(5)", "(6)", "interpolated"]),
        ("fig10.svg", &["σ, mm", "σ θ, degrees", "correlation", "√λ, mm", "rotation, degrees", "closed form", "(11)"]),
    ];
    for (name, labels) in labels {
        let picture = fs::read_to_string(folder.join(name)).unwrap();
        assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"), "{name}");
        for label in labels {
            assert!(picture.contains(label), "{name} has no {label}");
        }
        // The paper's dashed and our solid lines, in black and grey only.
        let colours = picture.split('#').skip(1).map(|rest| &rest[..6]);
        assert!(colours.filter(|it| it.len() == 6).all(|it| it[..2] == it[2..4] && it[..2] == it[4..6]), "{name}");
    }
}

/// A single view has no variance and no regression, and says so.
#[test]
fn few_views_are_said_to_be_too_few() {
    let output = barloc(&["paper", "--views", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("too few cells"));
}

#[test]
fn bad_input_is_one_line() {
    let refused = |arguments: &[&str], words: &str| {
        let output = barloc(arguments);
        let complaint = text(&output.stderr);
        assert_eq!((output.status.code(), complaint.lines().count()), (Some(2), 1), "{complaint}");
        assert!(complaint.contains(words) && output.stdout.is_empty(), "{complaint}");
    };
    refused(&["paper", "--views", "0"], "0");
    refused(&["paper", "--views", "-1"], "-1");
    refused(&["paper", "--seed", "x"], "x");
    let file = folder("paper_bad").join("file");
    fs::write(&file, "").unwrap();
    refused(&["paper", "--svg", file.to_str().unwrap()], "cannot be written");
    refused(&["paper", "--svg", file.join("inside").to_str().unwrap()], "cannot be written");
    assert!(text(&barloc(&["paper", "--help"]).stdout).contains("Examples:"));
}
