//! Logs of a robot: everything that can be wrong with one, order, memory, and writing what is read again.

use nalgebra::Matrix3;
use proptest::prelude::*;
use reference::camera::Camera;
use std::cell::Cell;
use std::fs;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use verify::log::{
    Capture, Estimate, EstimateWriter, Event, Fault, Knowledge, LogReader, LogWriter, Motion, Reading, Reason, Sources,
    Summary, Time, Truth,
};

const STEPS: &str = "t_s,left_steps,right_steps\n";
const VELOCITIES: &str = "t_s,forward_m_s,turn_rad_s\n";
const FRAMES: &str = "t_start_s,t_end_s,t_processed_s,file\n";
const TRUTH: &str = "t_s,x_m,y_m,theta_rad\n";
const OBSERVATIONS: &str =
    "t_s,landmark_x_m,landmark_y_m,landmark_theta_rad,x_m,y_m,theta_rad,c_xx,c_xy,c_xt,c_yy,c_yt,c_tt\n";

/// A new folder.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("log").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn seconds(text: &str) -> Time {
    text.parse().unwrap()
}

type Items = Vec<Result<Event, Fault>>;

fn all(mut reader: LogReader) -> (Items, Summary) {
    let items = reader.by_ref().collect();
    (items, reader.summary().clone())
}

/// A log of texts; images are in `folder`.
fn try_read(folder: &Path, tables: &[(&str, &str)]) -> Result<(Items, Summary), Fault> {
    let mut sources = Sources::default();
    for (name, text) in tables {
        let source: Option<Box<dyn Read>> = Some(Box::new(Cursor::new(text.as_bytes().to_vec())));
        match *name {
            "odometry" => sources.odometry = source,
            "frames" => sources.frames = source,
            "observations" => sources.observations = source,
            "truth" => sources.truth = source,
            other => panic!("{other}"),
        }
    }
    LogReader::from_sources(folder, &Camera::epuck(), sources).map(all)
}

fn read(tables: &[(&str, &str)]) -> (Items, Summary) {
    try_read(Path::new("log"), tables).unwrap_or_else(|fault| panic!("{fault}"))
}

/// Arrivals in microseconds of what was used.
fn arrivals(items: &Items) -> Vec<u64> {
    items.iter().flatten().map(|event| event.arrival().micros()).collect()
}

/// Every fault as its sentence.
fn sentences(items: &Items) -> Vec<String> {
    items.iter().filter_map(|item| item.as_ref().err().map(ToString::to_string)).collect()
}

/// One bad row on line 3 between two good ones is left out for its reason, and both others are used.
fn bad_row(table: &str, header: &str, [before, after]: [&str; 2], bad: &str, reason: Reason, words: &str) {
    let text = format!("{header}{before}\n{bad}\n{after}\n");
    let odometry = if table == "odometry" { text.clone() } else { STEPS.to_owned() };
    let tables = [("odometry", &odometry[..]), (table, &text[..])];
    let (items, summary) = read(if table == "odometry" { &tables[..1] } else { &tables });
    let faults: Vec<&Fault> = items.iter().filter_map(|item| item.as_ref().err()).collect();
    assert_eq!(faults.len(), 1, "{bad}: {items:?}");
    assert_eq!((faults[0].line, faults[0].reason), (Some(3), reason), "{bad}: {}", faults[0]);
    let sentence = faults[0].to_string();
    assert!(sentence.starts_with(&format!("log/{table}.csv:3: ")) && sentence.contains(words), "{sentence}");
    assert_eq!(items.iter().flatten().count(), 2, "{bad}");
    let rows = summary.files[&format!("{table}.csv")];
    assert_eq!((rows.used, rows.left_out, rows.warned, summary.faults[&reason].count), (2, 1, 0, 1), "{bad}");
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-4** Steps MUST be whole numbers from -32768 to 32767, and velocities at most 10 m/s and 100 rad/s.
//= reference/SPEC.md#log
//= type=test
//# - **LOG-7** Coordinates beyond ±100 m, angles beyond ±10^6 rad and numbers that are not finite MUST be refused.
//= reference/SPEC.md#log
//= type=test
//# - **LOG-8** A row that cannot be used MUST be left out alone, with file, line and reason in one line, and the rows
//# after it be read.
#[test]
fn bad_readings_are_left_out_alone() {
    let long = format!("0.2,{},1", "1".repeat(9000));
    for (bad, reason, words) in [
        ("0.2,12", Reason::Fields, "too few fields: 2 where 3"),
        ("0.2,12,13,14", Reason::Fields, "too many fields: 4 where 3"),
        ("0.2,many,13", Reason::NotANumber, "left_steps: \"many\" is not a number"),
        ("0.2,12,", Reason::NotANumber, "right_steps: \"\" is not a number"),
        ("soon,12,13", Reason::NotANumber, "t_s: \"soon\" is not a number"),
        ("0.2,NaN,13", Reason::NotFinite, "left_steps: \"NaN\" is not a finite number"),
        ("0.2,12,-inf", Reason::NotFinite, "right_steps: \"-inf\""),
        ("inf,12,13", Reason::NotFinite, "t_s: \"inf\""),
        ("-0.2,12,13", Reason::Time, "t_s: \"-0.2\" is a negative time"),
        ("1e30,12,13", Reason::Time, "too large"),
        ("0.2,40000,13", Reason::Steps, "left_steps: \"40000\" is more steps than a reading holds"),
        ("0.2,12.5,13", Reason::Steps, "not a whole number"),
        ("0.2,\"12,13", Reason::Line, "a quote is not closed"),
        (&long, Reason::Line, "longer than 8192 bytes"),
    ] {
        bad_row("odometry", STEPS, ["0.1,1,2", "0.3,3,4"], bad, reason, words);
    }
    for (bad, reason, words) in [
        ("0.2,fast,0", Reason::NotANumber, "forward_m_s: \"fast\" is not a number"),
        ("0.2,10.01,0", Reason::OutOfRange, "forward_m_s: \"10.01\" is beyond ±10"),
        ("0.2,0,-101", Reason::OutOfRange, "turn_rad_s: \"-101\" is beyond ±100"),
        ("0.2,0,nan", Reason::NotFinite, "turn_rad_s"),
    ] {
        bad_row("odometry", VELOCITIES, ["0.1,0.05,0", "0.3,0.05,-1e-3"], bad, reason, words);
    }
    for (bad, reason, words) in [
        ("0.2,100.5,0,0", Reason::OutOfRange, "x_m: \"100.5\" is beyond ±100"),
        ("0.2,0,0,2e6", Reason::OutOfRange, "theta_rad: \"2e6\" is beyond ±1000000"),
    ] {
        bad_row("truth", TRUTH, ["0.1,0,0,0", "0.3,100,-100,7"], bad, reason, words);
    }
}

#[test]
fn a_line_that_is_not_utf_8_is_left_out_alone() {
    let text = [STEPS.as_bytes(), b"0.1,1,2\n0.2,\xFF\xFE,3\n0.3,3,4\n"].concat();
    let sources = Sources { odometry: Some(Box::new(Cursor::new(text))), ..Sources::default() };
    let (items, _) = all(LogReader::from_sources(Path::new("log"), &Camera::epuck(), sources).unwrap());
    assert_eq!(sentences(&items), ["log/odometry.csv:3: is not UTF-8 text"]);
    assert_eq!(arrivals(&items), [100_000, 300_000]);
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-6** A covariance MUST be positive definite, with variances of at most 10,000 m² and 10,000 rad².
#[test]
fn bad_observations_are_left_out_alone() {
    let good = |t: &str| format!("{t},1,2,3,0.5,0,3.1,1e-4,0,0,1e-4,1e-5,4e-4");
    let (before, after) = (good("0.1"), good("0.3"));
    for (bad, reason, words) in [
        ("0.2,1,2,3,0.5,0,3.1,1e-4,0,0,1e-4,3e-4,4e-4", Reason::Covariance, "not positive definite"),
        ("0.2,1,2,3,0.5,0,3.1,-1e-4,0,0,1e-4,0,4e-4", Reason::Covariance, "not positive definite"),
        ("0.2,1,2,3,0.5,0,3.1,0,0,0,1e-4,0,4e-4", Reason::Covariance, "not positive definite"),
        // Each pair of correlations is possible, all three are not.
        ("0.2,1,2,3,0.5,0,3.1,1,0.9,0.9,1,-0.9,1", Reason::Covariance, "not positive definite"),
        ("0.2,1,2,3,0.5,0,3.1,1e-4,0,0,inf,0,4e-4", Reason::NotFinite, "c_yy: \"inf\""),
        ("0.2,1,2,3,0.5,0,3.1,10001,0,0,1e-4,0,4e-4", Reason::OutOfRange, "c_xx: \"10001\" is beyond ±10000"),
        ("0.2,-128,2,3,0.5,0,3.1,1e-4,0,0,1e-4,0,4e-4", Reason::OutOfRange, "landmark_x_m: \"-128\" is beyond ±100"),
        ("0.2,1,2,3,0.5,0,3.1,1e-4,0,0,1e-4,0", Reason::Fields, "too few fields: 12 where 13"),
    ] {
        bad_row("observations", OBSERVATIONS, [&before, &after], bad, reason, words);
    }
}

#[test]
fn an_observation_is_what_its_row_says() {
    let text = format!("{OBSERVATIONS}0.25,1,2,3,0.5,-0.25,3.125,4,1,0.5,9,0.25,16\n");
    let (items, _) = read(&[("odometry", STEPS), ("observations", &text)]);
    let Ok(Event::Observation(found)) = &items[0] else { panic!("{items:?}") };
    assert_eq!(found.time.micros(), 250_000);
    let (landmark, robot) = (found.landmark_in_world, found.robot_in_landmark);
    assert_eq!((landmark.x(), landmark.y(), robot.x(), robot.y()), (1.0, 2.0, 0.5, -0.25));
    assert!((landmark.theta() - 3.0).abs() < 1e-15 && (robot.theta() - 3.125).abs() < 1e-15);
    assert_eq!(found.covariance, Matrix3::new(4.0, 1.0, 0.5, 1.0, 9.0, 0.25, 0.5, 0.25, 16.0));
}

/// A folder with an image of each kind.
fn images(name: &str) -> PathBuf {
    let folder = folder(name);
    let save = |file: &str, width: u32, height: u32| {
        image::GrayImage::from_fn(width, height, |x, y| image::Luma([u8::try_from((x + 10 * y) % 256).unwrap()]))
            .save(folder.join(file))
            .unwrap();
    };
    save("good.png", 480, 8);
    save("good.pgm", 480, 8);
    save("one-row-less.png", 480, 7);
    save("one-row.pgm", 480, 1);
    save("narrow.png", 479, 8);
    image::ImageBuffer::<image::Luma<u16>, Vec<u16>>::new(480, 8).save(folder.join("deep.png")).unwrap();
    let png = fs::read(folder.join("good.png")).unwrap();
    fs::write(folder.join("cut.png"), &png[..png.len() / 2]).unwrap();
    fs::write(folder.join("text.png"), "no image").unwrap();
    fs::create_dir(folder.join("directory.png")).unwrap();
    folder
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-5** An image MUST be an 8-bit PNG or PNM file of the camera's size in or below the folder, whose times
//# fulfil EXPOSE-2.
#[test]
fn bad_images_are_left_out_alone() {
    let folder = images("bad-images");
    for (bad, reason, words) in [
        ("0.4,0.7,0.8,gone.png", Reason::ImageMissing, "file: \"gone.png\" is missing"),
        ("0.4,0.7,0.8,one-row-less.png", Reason::Image, "is 480 x 7 pixels, the camera's images are 480 x 8"),
        ("0.4,0.7,0.8,one-row.pgm", Reason::Image, "is 480 x 1 pixels"),
        ("0.4,0.7,0.8,narrow.png", Reason::Image, "is 479 x 8 pixels"),
        ("0.4,0.7,0.8,deep.png", Reason::Image, "more than 8 bits"),
        ("0.4,0.7,0.8,cut.png", Reason::Image, "broken image"),
        ("0.4,0.7,0.8,text.png", Reason::Image, "neither a PNG nor a PNM"),
        ("0.4,0.7,0.8,directory.png", Reason::Image, "is not a file"),
        ("0.4,0.7,0.8,", Reason::Image, "not the name of a file"),
        ("0.4,0.7,0.8,../bad-images/good.png", Reason::Image, "in or below the log's folder"),
        ("0.4,0.7,0.8,/dev/zero", Reason::Image, "in or below the log's folder"),
        ("0.7,0.7,0.8,good.png", Reason::Capture, "t_end_s: \"0.7\" is not after t_start_s, 0.7"),
        ("0.4,0.7,0.6,good.png", Reason::Capture, "t_processed_s: \"0.6\" is before t_end_s, 0.7"),
        ("0.4,1.400001,1.5,good.png", Reason::Capture, "more than 1 s after t_start_s"),
        ("0.4,0.7,good.png", Reason::Fields, "too few fields: 3 where 4"),
        ("0.4,0.7,-1,good.png", Reason::Time, "t_processed_s"),
    ] {
        let text = format!("{FRAMES}0.0,0.3,0.4,good.png\n{bad}\n0.8,1.8,1.8,./good.pgm\n");
        let (items, summary) = try_read(&folder, &[("odometry", STEPS), ("frames", &text)]).unwrap();
        let [sentence] = &sentences(&items)[..] else { panic!("{bad}: {items:?}") };
        let place = format!("{}:3: ", folder.join("frames.csv").display());
        assert!(sentence.starts_with(&place) && sentence.contains(words), "{sentence}");
        assert_eq!(summary.faults.keys().collect::<Vec<_>>(), [&reason], "{bad}");
        assert_eq!(arrivals(&items), [400_000, 1_800_000], "{bad}");
    }
}

#[test]
fn an_image_is_its_scan_lines() {
    let folder = images("good-image");
    let text = format!("{FRAMES}0.0,0.3,0.4,good.png\n");
    let (items, _) = try_read(&folder, &[("odometry", STEPS), ("frames", &text)]).unwrap();
    let Ok(Event::Image(image)) = &items[0] else { panic!("{items:?}") };
    let row = |y: usize| (0..480).map(|x| u8::try_from((x + 10 * y) % 256).unwrap()).collect::<Vec<u8>>();
    assert_eq!((image.lines.clone(), image.line), ([row(0), row(7)], 2));
    let capture = Capture { start: seconds("0"), end: seconds("0.3"), processed: seconds("0.4") };
    assert_eq!(image.capture, capture);
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-2** A table whose first line that is not blank is none of its headers, name for name, MUST be refused as a
//# whole.
#[test]
fn headers_are_known_or_the_whole_file_is_refused() {
    let refused = |text: &str| {
        let fault = try_read(Path::new("log"), &[("odometry", text)]).expect_err(text);
        (fault.line, fault.reason, fault.to_string())
    };
    for text in ["", "\n\n", "\u{feff}", " \r\n\t\r\n"] {
        let (line, reason, sentence) = refused(text);
        assert_eq!((line, reason, &sentence[..]), (None, Reason::Empty, "log/odometry.csv: is empty"), "{text:?}");
    }
    for (text, at) in [
        ("0.1,1,2\n0.2,1,2\n", 1),
        ("t_s,left,right\n0.1,1,2\n", 1),
        ("\n\nt_s,right_steps,left_steps\n", 3),
        ("t_s,left_steps\n", 1),
        ("t_s,left_steps,right_steps,battery\n", 1),
        ("t_s;left_steps;right_steps\n", 1),
        ("\"t_s,left_steps,right_steps\n", 1),
    ] {
        let (line, reason, sentence) = refused(text);
        assert_eq!((line, reason), (Some(at), Reason::Header), "{text:?}");
        let words = "is not the header t_s,left_steps,right_steps or t_s,forward_m_s,turn_rad_s";
        assert_eq!(sentence, format!("log/odometry.csv:{at}: {words}"));
    }
    let (_, reason, _) = refused(&"x".repeat(100_000));
    assert_eq!(reason, Reason::Header);
    // No other table's header either.
    let fault = try_read(Path::new("log"), &[("odometry", STEPS), ("truth", STEPS)]).unwrap_err();
    assert!(fault.to_string().starts_with("log/truth.csv:1: is not the header t_s,x_m,y_m,theta_rad"), "{fault}");
    // A header without rows is a log of nothing.
    let (items, summary) = read(&[("odometry", STEPS.trim_end())]);
    assert!(items.is_empty() && summary.files["odometry.csv"].used == 0);
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-9** A byte order mark, blank lines, lines that end in CR LF, and blanks around a field MUST be read over.
#[test]
fn marks_blank_lines_and_line_ends_of_others_are_read_over() {
    let text = "\u{feff}\r\n t_s , left_steps,right_steps \r\n\r\n 0.1 ,\t1,2\r\n\n\"0.2\",3,\"4\"\r\n0.3,x,1\r\n   \n0.4,5.0,+6\n";
    let (items, _) = read(&[("odometry", text)]);
    let steps = |time: &str, left, right| Reading { time: seconds(time), motion: Motion::Steps { left, right } };
    let expected = [steps("0.1", 1, 2), steps("0.2", 3, 4), steps("0.4", 5, 6)].map(Event::Reading);
    assert_eq!(items.iter().flatten().collect::<Vec<_>>(), expected.iter().collect::<Vec<_>>());
    // The number that an editor shows.
    assert_eq!(sentences(&items), ["log/odometry.csv:7: left_steps: \"x\" is not a number"]);
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-10** A last line without a line end, a line of more than 8192 bytes, one that is not UTF-8, one with a quote
//# that is not closed and one with too few or too many fields MUST be left out.
#[test]
fn a_file_that_ends_in_the_middle_of_a_line_loses_that_line() {
    for cut in ["0.2,1", "0.2,1,2", "0.2,\"1,2", "0."] {
        let (items, summary) = read(&[("odometry", &format!("{STEPS}0.1,1,2\n{cut}"))]);
        let words = "the file ends in this line: it is cut off, or lacks its line end";
        assert_eq!(sentences(&items), [format!("log/odometry.csv:3: {words}")], "{cut}");
        assert_eq!((arrivals(&items), summary.faults[&Reason::CutOff].count), (vec![100_000], 1));
    }
    let (items, _) = read(&[("odometry", &format!("{STEPS}0.1,1,2\n  "))]);
    assert!(sentences(&items).is_empty(), "blanks at the end are no line");
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-1** A log MUST be a folder with `odometry.csv`, at most one of `frames.csv` and `observations.csv`, and,
//# where they exist, `truth.csv` and `robot.toml`; both of the two are refused.
#[test]
fn a_folder_has_one_kind_of_sights_and_odometry() {
    let folder = folder("both");
    let error = |folder: &Path| LogReader::open(folder, &Camera::epuck()).err().unwrap().to_string();
    assert_eq!(error(&folder), format!("{}: is missing", folder.join("odometry.csv").display()));
    fs::write(folder.join("odometry.csv"), STEPS).unwrap();
    assert_eq!(all(LogReader::open(&folder, &Camera::epuck()).unwrap()).0.len(), 0);
    fs::write(folder.join("frames.csv"), FRAMES).unwrap();
    fs::write(folder.join("observations.csv"), OBSERVATIONS).unwrap();
    let words = "has both frames.csv and observations.csv; one of them has to go";
    assert_eq!(error(&folder), format!("{}: {words}", folder.display()));
    // A folder in a file's place.
    fs::remove_file(folder.join("frames.csv")).unwrap();
    fs::create_dir(folder.join("frames.csv")).unwrap();
    fs::remove_file(folder.join("observations.csv")).unwrap();
    assert!(error(&folder).contains("frames.csv: cannot be read"), "{}", error(&folder));
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-12** A row whose arrival is before that of the row before it in its file MUST be warned, as a reading is
//# that repeats the time before it, that comes more than 1 s after it, or that comes after more than five times the
//# median of the up to 99 last steps of time.
#[test]
fn odd_times_are_warned_and_used() {
    let text = format!("{STEPS}0.1,1,1\n0.2,1,1\n0.15,1,1\n0.25,1,1\n0.25,1,1\n0.9,1,1\n2.0,1,1\n");
    let truth = format!("{TRUTH}5,0,0,0\n4,0,0,0\n");
    let (items, summary) = read(&[("odometry", &text), ("truth", &truth)]);
    assert_eq!(sentences(&items).len(), 0);
    assert_eq!(arrivals(&items).len(), 9);
    let examples = |reason: Reason| summary.faults[&reason].examples.clone();
    let back = [
        "log/odometry.csv:4: 0.15 s is before the row before, 0.2 s",
        "log/truth.csv:3: 4.0 s is before the row before, 5.0 s",
    ];
    assert_eq!(examples(Reason::StepBack), back);
    assert_eq!(examples(Reason::Repeated), ["log/odometry.csv:6: 0.25 s is the time of the row before"]);
    let gaps = [
        "log/odometry.csv:7: 0.9 s is 0.65 s after the row before",
        "log/odometry.csv:8: 2.0 s is 1.1 s after the row before",
    ];
    assert_eq!(examples(Reason::Gap), gaps);
    let rows = summary.total();
    assert_eq!((rows.used, rows.left_out, rows.warned), (9, 0, 5));
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-11** Rows MUST be delivered in the order of their arrival, which is `t_s` and of an image `t_processed_s`,
//# at one time readings first, then what was seen, then the truth; within a file its own order stands.
#[test]
fn events_come_as_they_arrive() {
    let folder = images("order");
    let odometry = format!("{STEPS}0.1,1,0\n0.4,2,0\n0.3,3,0\n0.5,4,0\n1.3,5,0\n");
    let frames = format!("{FRAMES}0.0,0.3,0.4,good.png\n0.4,0.5,0.55,good.png\n0.1,0.2,0.3,good.png\n");
    let truth = format!("{TRUTH}0.1,0,0,0\n0.4,0,0,0\n2,0,0,0\n");
    let (items, _) = try_read(&folder, &[("odometry", &odometry), ("frames", &frames), ("truth", &truth)]).unwrap();
    let name = |event: &Event| match event {
        Event::Reading(Reading { motion: Motion::Steps { left, .. }, .. }) => format!("reading {left}"),
        Event::Image(image) => format!("image {}", image.line),
        other => format!("truth {}", other.arrival()),
    };
    let found: Vec<String> = items.iter().flatten().map(name).collect();
    // At 0.4 s the reading first, and so the next one, which is late; then the image and the truth.
    let expected = [
        "reading 1",
        "truth 0.1",
        "reading 2",
        "reading 3",
        "image 2",
        "truth 0.4",
        "reading 4",
        "image 3",
        "image 4",
        "reading 5",
        "truth 2.0",
    ];
    assert_eq!(found, expected);
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-14** Reading MUST end with a summary of how many rows of each file were used and, by reason, left out and
//# warned, with the first three places of each.
#[test]
fn the_summary_counts_by_reason_and_shows_the_first() {
    let bad = "0.0,x,1\n".repeat(20);
    let (_, summary) = read(&[("odometry", &format!("{STEPS}{bad}9,1,1\n0.5,1,1\n"))]);
    let text = summary.to_string();
    let expected = "odometry.csv: 2 rows used, 20 left out, 1 warned
left out, text where a number belongs: 20
  log/odometry.csv:2: left_steps: \"x\" is not a number
  log/odometry.csv:3: left_steps: \"x\" is not a number
  log/odometry.csv:4: left_steps: \"x\" is not a number
  ...
warned, step back in time: 1
  log/odometry.csv:23: 0.5 s is before the row before, 9.0 s
";
    assert_eq!(text, expected);
}

#[test]
fn a_message_is_one_line_whatever_is_in_the_file() {
    let text = format!("{STEPS}0.1,\u{1b}[31m\r\u{7},1\n");
    let (items, _) = read(&[("odometry", &text)]);
    let sentence = &sentences(&items)[0];
    assert!(!sentence.contains(char::is_control), "{sentence:?}");
}

/// Rows of an odometry that are made when they are asked for.
struct Made {
    row: u64,
    rows: u64,
    text: Cursor<Vec<u8>>,
    given: Rc<Cell<u64>>,
}

impl Made {
    fn new(rows: u64, given: &Rc<Cell<u64>>) -> Self {
        Self { row: 0, rows, text: Cursor::new(STEPS.as_bytes().to_vec()), given: Rc::clone(given) }
    }

    /// Every hundredth row is bad, and every thousandth comes early.
    fn text(row: u64) -> String {
        match row {
            _ if row.is_multiple_of(100) => format!("0.1,{row},oh\n"),
            _ if row % 1000 == 1 => format!("{}.00,1,2\n", row / 10),
            _ => format!("{}.{}5,{},{}\n", row / 10, row % 10, row % 1000, row % 777),
        }
    }
}

impl Read for Made {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut read = self.text.read(buffer)?;
        if read == 0 && self.row < self.rows {
            self.row += 1;
            self.text = Cursor::new(Self::text(self.row).into_bytes());
            read = self.text.read(buffer)?;
        }
        self.given.set(self.given.get() + read as u64);
        Ok(read)
    }
}

/// No row is taken before those in front of it are delivered, but for a buffer's worth; what is kept of them is a few sentences.
//= reference/SPEC.md#log
//= type=test
//# - **LOG-13** The memory that reading takes MUST NOT grow with the number of rows.
#[test]
fn a_million_rows_take_no_more_memory_than_a_hundred() {
    let given = Rc::new(Cell::new(0));
    let rows = 1_000_000;
    let sources = Sources { odometry: Some(Box::new(Made::new(rows, &given))), ..Sources::default() };
    let mut reader = LogReader::from_sources(Path::new("log"), &Camera::epuck(), sources).unwrap();
    let mut delivered = STEPS.len() as u64;
    for row in 1..=rows {
        let item = reader.next().expect("one item for each row");
        assert_eq!(item.is_err(), row.is_multiple_of(100));
        delivered += Made::text(row).len() as u64;
        assert!(given.get() <= delivered + 16_384, "{} of {delivered} bytes at row {row}", given.get());
    }
    assert!(reader.next().is_none());
    let summary = reader.summary();
    let total = summary.total();
    assert_eq!((total.used, total.left_out), (rows - rows / 100, rows / 100));
    assert_eq!(summary.faults[&Reason::NotANumber].examples.len(), 3);
    assert!(serde_json::to_string(summary).unwrap().len() < 2000);
}

/// A disk that fails in the middle of a file.
struct Failing(Cursor<Vec<u8>>);

impl Read for Failing {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.0.read(buffer)? {
            0 => Err(io::Error::other("the card is gone")),
            read => Ok(read),
        }
    }
}

#[test]
fn a_file_that_cannot_be_read_on_ends_there() {
    let text = format!("{STEPS}0.1,1,2\n0.2,1,2\n");
    let odometry: Option<Box<dyn Read>> = Some(Box::new(Failing(Cursor::new(text.into_bytes()))));
    let truth: Option<Box<dyn Read>> = Some(Box::new(Cursor::new(format!("{TRUTH}9,0,0,0\n").into_bytes())));
    let sources = Sources { odometry, truth, ..Sources::default() };
    let (items, _) = all(LogReader::from_sources(Path::new("log"), &Camera::epuck(), sources).unwrap());
    assert_eq!(sentences(&items), ["log/odometry.csv: cannot be read on: the card is gone"]);
    assert_eq!(arrivals(&items), [100_000, 200_000, 9_000_000]);
}

// Writing.

fn image_lines(seed: u8) -> [Vec<u8>; 2] {
    let line =
        |offset: usize| (0..480).map(|i| u8::try_from((i * 7 + offset + usize::from(seed)) % 256).unwrap()).collect();
    [line(0), line(100)]
}

fn capture(start: u64) -> Capture {
    let time = |micros| Time::from_micros(micros).unwrap();
    Capture { start: time(start), end: time(start + 300_000), processed: time(start + 400_000) }
}

fn write(folder: &Path, events: &[Event], knowledge: &Knowledge) {
    let mut writer = LogWriter::create(folder, knowledge).unwrap();
    for event in events {
        match event {
            Event::Reading(Reading { time, motion: Motion::Steps { left, right } }) => {
                writer.reading(*time, *left, *right).unwrap();
            }
            Event::Image(image) => writer.image(&image.capture, &image.lines).unwrap(),
            Event::Truth(truth) => writer.truth(truth).unwrap(),
            other => panic!("{other:?}"),
        }
    }
    writer.finish().unwrap();
}

/// Names and contents of all files below a folder.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(contents(&path)) } else { found.push((path.clone(), fs::read(path).unwrap())) }
    }
    found.sort();
    found
}

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![-100.0..=100.0, Just(0.0), Just(-0.0), -1e-300..1e-300f64, Just(5e-324)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// What is written is read as the same numbers, and the same log gives the same bytes.
    //= reference/SPEC.md#log
    //= type=test
    //# - **LOG-19** What is read from a written log MUST be the numbers that were written.
    #[test]
    fn what_is_written_is_read_as_the_same(
        readings in proptest::collection::vec((0..1_u64 << 40, any::<i16>(), any::<i16>()), 0..20),
        truths in proptest::collection::vec((0..1_u64 << 62, finite(), finite(), finite()), 0..20),
        starts in proptest::collection::vec((0..1_u64 << 40, any::<u8>()), 0..4),
    ) {
        let time = |micros| Time::from_micros(micros).unwrap();
        let mut events: Vec<Event> = Vec::new();
        for &(t, left, right) in &readings {
            events.push(Event::Reading(Reading { time: time(t), motion: Motion::Steps { left, right } }));
        }
        for (line, &(start, seed)) in (2..).zip(&starts) {
            let image = verify::log::Image { capture: capture(start), lines: image_lines(seed), line };
            events.push(Event::Image(image));
        }
        for &(t, x, y, theta) in &truths {
            events.push(Event::Truth(Truth { time: time(t), x, y, theta }));
        }
        let folder = folder("round-trip");
        write(&folder, &events, &Knowledge::default());
        let first = contents(&folder);
        let (items, summary) = all(LogReader::open(&folder, &Camera::epuck()).unwrap());
        prop_assert_eq!(summary.total().left_out, 0);
        // Each file's rows in its own order, as they were written; Debug shows every bit, the sign of 0 too.
        let kind = |event: &&Event| core::mem::discriminant(*event);
        let mut read: Vec<&Event> = items.iter().flatten().collect();
        prop_assert_eq!(read.len(), events.len());
        read.sort_by_key(|event| events.iter().position(|other| kind(&other) == kind(event)));
        prop_assert_eq!(format!("{:?}", read), format!("{:?}", events.iter().collect::<Vec<_>>()));
        // Over the former log, and with fewer images: nothing of the former stays.
        let more: Vec<Event> = events.iter().cloned().chain((0..3).map(|i| {
            Event::Image(verify::log::Image { capture: capture(i), lines: image_lines(1), line: 0 })
        })).collect();
        write(&folder, &more, &Knowledge::default());
        write(&folder, &events, &Knowledge::default());
        prop_assert!(contents(&folder) == first, "other bytes");
    }
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-20** Of a written image the rows MUST be those of the nearer scan line, of two equally near ones the upper,
//# so that first and last row are the scan lines of a camera that reads these.
#[test]
fn a_log_is_as_a_robot_would_write_it() {
    let folder = folder("written");
    let mut writer = LogWriter::create(&folder, &Knowledge::default()).unwrap();
    writer.reading(seconds("0.1"), 39, -40).unwrap();
    writer.image(&capture(0), &image_lines(3)).unwrap();
    writer.truth(&Truth { time: seconds("0.1"), x: 0.1, y: -1e-7, theta: 3.0 }).unwrap();
    writer.finish().unwrap();
    let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(text("odometry.csv"), format!("{STEPS}0.1,39,-40\n"));
    assert_eq!(text("frames.csv"), format!("{FRAMES}0.0,0.3,0.4,frames/000000.png\n"));
    assert_eq!(text("truth.csv"), format!("{TRUTH}0.1,0.1,-0.0000001,3\n"));
    assert_eq!(Knowledge::of_log(&folder).unwrap(), Knowledge::default());
    // Four rows of the upper scan line above four of the lower.
    let image = image::open(folder.join("frames/000000.png")).unwrap().into_luma8();
    let [upper, lower] = image_lines(3);
    for (y, row) in image.as_raw().chunks(480).enumerate() {
        assert_eq!(row, if y < 4 { &upper[..] } else { &lower[..] }, "row {y}");
    }
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-18** A log's files MUST be written whole or not at all, and the same log give the same bytes.
#[test]
fn a_log_that_is_not_finished_is_none() {
    let folder = folder("unfinished");
    fs::write(folder.join("notes.txt"), "mine").unwrap();
    let mut writer = LogWriter::create(&folder, &Knowledge::default()).unwrap();
    writer.reading(seconds("0.1"), 1, 1).unwrap();
    writer.image(&capture(0), &image_lines(0)).unwrap();
    drop(writer);
    let names: Vec<PathBuf> = contents(&folder).into_iter().map(|(path, _)| path).collect();
    assert_eq!(names, [folder.join("frames/000000.png"), folder.join("notes.txt")]);
    // Nor is one begun beside observations, or in a file's place.
    fs::write(folder.join("observations.csv"), OBSERVATIONS).unwrap();
    let error = LogWriter::create(&folder, &Knowledge::default()).unwrap_err().to_string();
    assert!(error.contains("observations.csv of another log"), "{error}");
    let error = LogWriter::create(&folder.join("notes.txt"), &Knowledge::default()).unwrap_err().to_string();
    assert!(error.contains("notes.txt"), "{error}");
}

//= reference/SPEC.md#log
//= type=test
//# - **LOG-21** An estimate MUST be written as `t_s,x_m,y_m,theta_rad,c_xx,c_xy,c_xt,c_yy,c_yt,c_tt,event`, its numbers
//# as the shortest decimals that are read as the same.
#[test]
fn estimates_are_written_in_their_shortest_form() {
    let folder = folder("estimates");
    let path = folder.join("estimate_reference.csv");
    let covariance = Matrix3::new(2.5e-5, -1e-7, 0.0, -1e-7, 0.1, 1.0 / 3.0, 0.0, 1.0 / 3.0, 4e-4);
    let estimate = Estimate { time: seconds("0.1"), pose: [0.1, -0.25, 1.0 / 3.0], covariance };
    let mut writer = EstimateWriter::create(path.clone()).unwrap();
    writer.row(&estimate, "odometry").unwrap();
    assert!(!path.exists(), "it is not finished");
    writer.finish().unwrap();
    let expected = "t_s,x_m,y_m,theta_rad,c_xx,c_xy,c_xt,c_yy,c_yt,c_tt,event\n\
                    0.1,0.1,-0.25,0.3333333333333333,2.5e-5,-1e-7,0e0,1e-1,3.333333333333333e-1,4e-4,odometry\n";
    assert_eq!(fs::read_to_string(&path).unwrap(), expected);
    assert_eq!(contents(&folder).len(), 1);
}
