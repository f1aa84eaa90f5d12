//! Drawings of a made-up drive around a triangle, read back as XML and through somebody else's renderer.

use super::errors::Errors;
use super::map::{Landmark, Map};
use super::{BLUE, GREEN, ORANGE, PURPLE, Pose, SKY, Sample, Seen, VERMILLION, errors, map};
use plotters::prelude::{BLACK, RGBColor};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::roxmltree::{Document, Node};
use resvg::usvg::{Options, Tree};

const TITLE: &str = "A triangle: 4000 samples & \"gates\" <3 σ>\nsecond line";
/// The robot's corners, and the walls' around them, metres.
const CORNERS: [[f64; 2]; 3] = [[0.2, 0.2], [1.0, 0.2], [0.6, 0.9]];
const WALLS: [[[f64; 2]; 2]; 3] = [[[0.0, 0.05], [1.2, 0.05]], [[1.2, 0.05], [0.6, 1.15]], [[0.6, 1.15], [0.0, 0.05]]];
/// In the middles of the walls.
const LANDMARKS: [Landmark; 3] = [
    Landmark { pose: [0.6, 0.05, 1.571], width: 0.036 },
    Landmark { pose: [0.9, 0.6, 3.641], width: 0.036 },
    Landmark { pose: [0.3, 0.6, -0.5], width: 0.036 },
];

/// The pose of who has driven so far around the triangle, metres.
fn on_triangle(along: f64) -> Pose {
    let legs = [0, 1, 2].map(|i| (CORNERS[i], CORNERS[(i + 1) % 3]));
    let lengths = legs.map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1]));
    let mut rest = along % lengths.iter().sum::<f64>();
    let mut leg = 0;
    while rest >= lengths[leg] {
        rest -= lengths[leg];
        leg += 1;
    }
    let ((a, b), part) = (legs[leg], rest / lengths[leg]);
    [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), (b[1] - a[1]).atan2(b[0] - a[0])]
}

/// A drive of so many samples, 4 mm and 0.1 s each, with noise of a few millimetres; if `carried`, the robot is lifted in
/// the middle for 3 s and put down 0.9 m farther on, and the estimate follows 10 s later.
fn drive(samples: usize, carried: bool) -> Vec<Sample> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut noise = |size: f64| size * (random.random::<f64>() - 0.5);
    let (off, on, found) = (samples / 2, samples / 2 + 30, samples / 2 + 130);
    let sample = |i: usize| {
        let driven = 0.004 * i as f64;
        let jump = |from: usize| if carried && i >= from { 0.9 } else { 0.0 };
        let truth = on_triangle(driven + jump(on));
        let believed = on_triangle(driven + jump(found));
        let drift = i as f64 / samples as f64;
        Sample {
            time: 0.1 * i as f64,
            truth,
            estimate: [believed[0] + noise(0.02), believed[1] + noise(0.02), believed[2] + noise(0.05)],
            port: Some([believed[0] + noise(0.02), believed[1] + noise(0.02), believed[2] + noise(0.05)]),
            odometry: Some([believed[0] + 0.3 * drift, believed[1] - 0.2 * drift, believed[2] + 0.4 * drift]),
            deviation: Some(0.005 + 0.0001 * (i % 60) as f64),
            lifted: carried && (off..on).contains(&i),
            seen: Seen { used: i % 5 == 1, gated: i % 100 == 50, recovered: carried && i == found },
        }
    };
    (0..samples).map(sample).collect()
}

fn map_of(samples: &[Sample]) -> String {
    map::draw(&Map { title: TITLE, walls: &WALLS, landmarks: &LANDMARKS, samples }).unwrap()
}

fn errors_of(samples: &[Sample]) -> String {
    errors::draw(&Errors { title: TITLE, samples, robot_radius: Some(0.035) }).unwrap()
}

/// A robot on the spot whose estimate is wrong by a vector: an error that does not change.
fn still(estimate: Pose) -> Vec<Sample> {
    (0..50).map(|i| Sample { time: f64::from(i), estimate, ..Sample::default() }).collect()
}

/// Elements with this name and this colour in one of their attributes.
fn elements<'a>(svg: &'a Document<'_>, name: &str, colour: RGBColor) -> Vec<Node<'a, 'a>> {
    let colour = format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2);
    let named = svg.descendants().filter(|node| node.has_tag_name(name));
    named.filter(|node| ["stroke", "fill"].iter().any(|key| node.attribute(*key) == Some(&colour))).collect()
}

/// The places that a line goes through, pixels.
fn points(line: &Node<'_, '_>) -> Vec<(i32, i32)> {
    let number = |text: &str| text.parse().unwrap();
    let pairs = line.attribute("points").unwrap().split_whitespace();
    pairs.map(|pair| pair.split_once(',').map(|(x, y)| (number(x), number(y))).unwrap()).collect()
}

/// Lines that are longer than those of the legend.
fn long_lines(svg: &Document<'_>, colour: RGBColor, width: &str) -> Vec<Vec<(i32, i32)>> {
    let lines = elements(svg, "polyline", colour);
    let wide = lines.iter().filter(|line| line.attribute("stroke-width") == Some(width));
    wide.map(points).filter(|line| line.len() > 2 || line[0].0.abs_diff(line[1].0) > 64).collect()
}

/// All texts.
fn texts(svg: &Document<'_>) -> Vec<String> {
    let texts = svg.descendants().filter(|node| node.has_tag_name("text"));
    texts.map(|node| node.text().unwrap().trim().to_owned()).collect()
}

/// How far down the page something is written, the topmost of several.
fn height_of(svg: &Document<'_>, text: &str) -> f64 {
    let texts = svg.descendants().filter(|node| node.has_tag_name("text"));
    let same = texts.filter(|node| node.text().unwrap().trim() == text);
    same.map(|node| node.attribute("y").unwrap().parse::<f64>().unwrap()).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_map_has_everything_that_happened() {
    let samples = drive(4000, true);
    let svg = map_of(&samples);
    let svg = Document::parse(&svg).unwrap();
    let texts = texts(&svg);
    // 4000 / 5 and 4000 / 100.
    for entry in [
        "1",
        "2",
        "3",
        "wall",
        "true path",
        "estimate",
        "odometry alone",
        "observation used (800)",
        "observation gated (40)",
        "filter recovered (1)",
        "robot lifted (1)",
        "robot put down",
        "x (m)",
        "y (m)",
    ] {
        assert!(texts.iter().any(|text| text == entry), "{entry} is not in {texts:?}");
    }
    assert!(TITLE.lines().all(|line| texts.iter().any(|text| text == line)));
    // Before and after the robot was carried, before and after the filter began anew.
    assert_eq!(long_lines(&svg, BLACK, "2").len(), 2 + frame_lines(&svg));
    assert_eq!(long_lines(&svg, BLUE, "4").len(), 2);
    assert_eq!(long_lines(&svg, VERMILLION, "2").len(), 1);
    // One of each is in the legend; a cross has two strokes.
    assert!(elements(&svg, "circle", ORANGE).len() > 50);
    assert!(elements(&svg, "polyline", PURPLE).len() > 2 * 10);
    assert_eq!(elements(&svg, "circle", GREEN).len(), 2);
}

/// Lines of the grid: they are black and as wide as the truth's, but faint.
fn frame_lines(svg: &Document<'_>) -> usize {
    let lines = elements(svg, "polyline", BLACK);
    let faint = lines.iter().filter(|line| line.attribute("opacity") == Some("0.15"));
    faint.map(points).filter(|line| line[0].0.abs_diff(line[1].0) > 64).count()
}

#[test]
fn the_errors_have_everything_that_happened() {
    let samples = drive(4000, true);
    let svg = errors_of(&samples);
    let svg = Document::parse(&svg).unwrap();
    let texts = texts(&svg);
    for entry in [
        "position error (cm)",
        "heading error (degrees)",
        "time (s)",
        "estimate, reference",
        "estimate, fixed point (beneath)",
        "odometry alone",
        "observation used (800)",
        "observation gated (40)",
        "filter recovered (1)",
        "robot lifted (1)",
        "2σ of the position",
        "robot's radius, 3.5 cm",
    ] {
        assert!(texts.iter().any(|text| text == entry), "{entry} is not in {texts:?}");
    }
    for (colour, width) in [(BLUE, "4"), (SKY, "8")] {
        assert_eq!(long_lines(&svg, colour, width).len(), 2, "one line in each panel");
    }
    assert!(!long_lines(&svg, VERMILLION, "2").is_empty());
    assert_eq!(elements(&svg, "polygon", SKY).len(), 1);
    assert_eq!(elements(&svg, "polyline", GREEN).len(), 3);
    assert!(elements(&svg, "circle", ORANGE).len() > 100);
}

#[test]
fn what_did_not_happen_is_not_in_the_legends() {
    let samples = still([0.01, 0.0, 0.0]);
    for svg in [map_of(&samples), errors_of(&samples)] {
        let svg = Document::parse(&svg).unwrap();
        for colour in [VERMILLION, GREEN, ORANGE, PURPLE, SKY] {
            let coloured = ["circle", "polyline", "polygon", "rect"].map(|name| elements(&svg, name, colour).len());
            assert_eq!(coloured, [0; 4], "{colour:?}");
        }
        let odd = ["odometry", "lifted", "put down", "gated", "used", "recovered", "fixed", "start of", "2σ"];
        assert!(texts(&svg).iter().all(|text| odd.iter().all(|word| !text.contains(word))));
    }
}

#[test]
fn same_run_same_bytes() {
    let run = || (map_of(&drive(4000, true)), errors_of(&drive(4000, true)));
    assert!(run() == run());
}

#[test]
fn a_long_run_makes_no_large_file() {
    for carried in [false, true] {
        let samples = drive(4000, carried);
        let sizes = [map_of(&samples).len(), errors_of(&samples).len()];
        assert!(sizes.iter().all(|&size| size < 400_000), "{sizes:?}");
    }
    // A straight line has one point for every two pixels at most, however slow the robot is.
    let pose = |i: u32| [1e-5 * f64::from(i), 0.0, 0.0];
    let slow: Vec<Sample> = (0..100_000).map(|i| Sample { truth: pose(i), ..Sample::default() }).collect();
    let svg = map::draw(&Map { title: "", walls: &[], landmarks: &[], samples: &slow }).unwrap();
    assert!(svg.len() < 30_000, "{}", svg.len());
}

#[test]
fn text_is_at_least_12_px_where_the_drawing_is_1000_wide() {
    let samples = drive(500, true);
    for svg in [map_of(&samples), errors_of(&samples)] {
        let svg = Document::parse(&svg).unwrap();
        let number = |node: Node<'_, '_>, key| node.attribute(key)?.parse::<f64>().ok();
        let width = number(svg.root_element(), "width").unwrap();
        let sizes: Vec<f64> = svg.descendants().filter_map(|node| number(node, "font-size")).collect();
        assert!(sizes.len() > 10);
        assert!(sizes.iter().all(|size| size * 1000.0 / width >= 12.0), "{sizes:?} of {width}");
    }
}

/// A metre of wall is as long across the page as down, and y runs upwards.
#[test]
fn both_axes_of_the_map_have_one_scale() {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]];
    let walls = [[corners[0], corners[1]], [corners[1], corners[2]]];
    let svg = map::draw(&Map { title: "", walls: &walls, landmarks: &[], samples: &[] }).unwrap();
    let svg = Document::parse(&svg).unwrap();
    let grey = elements(&svg, "polyline", BLACK);
    let grey: Vec<_> = grey.iter().filter(|line| line.attribute("opacity") == Some("0.45")).map(points).collect();
    let (across, upwards) = (grey[0][1].0 - grey[0][0].0, grey[1][0].1 - grey[1][1].1);
    assert!(across > 1000 && (across - 2 * upwards).abs() <= 2, "{across} and {upwards}");
}

/// Odometry that is lost leaves the frame and is cut there; it does not shrink the site.
#[test]
fn what_strays_is_cut_at_the_frame() {
    let mut samples = drive(400, false);
    let near = map_of(&samples);
    for (i, sample) in samples.iter_mut().enumerate() {
        sample.odometry = Some([5.0 * i as f64, 0.5 - 3.0 * i as f64, 0.0]);
    }
    let far = map_of(&samples);
    let (near, far) = (Document::parse(&near).unwrap(), Document::parse(&far).unwrap());
    let side = |svg: &Document<'_>| {
        let walls = elements(svg, "polyline", BLACK);
        let walls = walls.iter().filter(|line| line.attribute("opacity") == Some("0.45"));
        walls.map(points).map(|line| line[0].0.abs_diff(line[1].0)).max().unwrap()
    };
    assert!(side(&far) * 10 > side(&near) * 7, "{} of {}", side(&far), side(&near));
    let grid = elements(&far, "rect", BLACK);
    let key = |name| grid[0].attribute(name).unwrap().parse::<i32>().unwrap();
    let (left, top, right, bottom) = (key("x"), key("y"), key("x") + key("width"), key("y") + key("height"));
    let lost = long_lines(&far, VERMILLION, "2");
    assert_eq!(lost.len(), 1);
    assert!(lost[0].iter().all(|&(x, y)| (left..=right).contains(&x) && (top..=bottom).contains(&y)));
    assert!(lost[0].iter().any(|&(x, y)| x == right || y == bottom), "it goes as far as the frame");
}

/// An error of 2 cm is drawn where the axis says 2, and one of 50 cm between 10 and 100 where the logarithm of 5 is.
#[test]
fn errors_are_where_the_axis_says() {
    let line = |svg: &Document<'_>| f64::from(long_lines(svg, BLUE, "4")[0][0].1);
    let svg = errors_of(&still([0.02, 0.0, 0.0]));
    let svg = Document::parse(&svg).unwrap();
    assert!((line(&svg) - height_of(&svg, "2")).abs() <= 1.0);
    let svg = errors_of(&still([0.3, -0.4, 0.0]));
    let svg = Document::parse(&svg).unwrap();
    let (ten, hundred) = (height_of(&svg, "10"), height_of(&svg, "100"));
    assert!((line(&svg) - (ten + 5.0_f64.log10() * (hundred - ten))).abs() <= 1.0);
}

/// From 3.1 to -3.1 radians it is 2π - 6.2 = 0.0832, which is 4.77 degrees and needs no logarithm.
#[test]
fn headings_differ_by_the_smaller_angle() {
    for believed in [-3.1, 3.1] {
        let mut samples = still([0.0, 0.0, believed]);
        for sample in &mut samples {
            sample.truth[2] = -believed;
        }
        let svg = errors::draw(&Errors { title: "", samples: &samples, robot_radius: None }).unwrap();
        let svg = Document::parse(&svg).unwrap();
        let heading = f64::from(long_lines(&svg, BLUE, "4")[1][0].1);
        let (four, five) = (height_of(&svg, "4"), height_of(&svg, "5"));
        assert!((heading - (four + 0.767 * (five - four))).abs() <= 1.0, "{heading} between {four} and {five}");
    }
}

/// A filter that begins half a metre off has its own start in the map and the legend.
#[test]
fn a_wrong_start_is_shown() {
    let svg = map_of(&still([0.5, 0.3, 2.0]));
    let svg = Document::parse(&svg).unwrap();
    assert!(texts(&svg).iter().any(|text| text == "start of the estimate"));
    assert_eq!(elements(&svg, "polygon", BLUE).len(), 2);
}

#[test]
fn what_is_not_a_number_is_left_out() {
    let mut samples = drive(400, false);
    samples[200].estimate = [f64::NAN; 3];
    samples[200].deviation = Some(f64::INFINITY);
    let svg = map_of(&samples);
    assert_eq!(long_lines(&Document::parse(&svg).unwrap(), BLUE, "4").len(), 2);
    let svg = errors_of(&samples);
    assert_eq!(long_lines(&Document::parse(&svg).unwrap(), BLUE, "4").len(), 4);
    for svg in [map_of(&[]), errors_of(&[])] {
        assert!(Document::parse(&svg).is_ok());
    }
}

/// The renderer has as much of the estimate's colour as a line of its length and width covers.
#[test]
fn a_renderer_shows_the_estimate() {
    let straight = |i: u32| Sample { estimate: [0.01 * f64::from(i), 0.2, 0.0], ..Sample::default() };
    let samples: Vec<Sample> = (0..=100).map(straight).collect();
    let svg = map::draw(&Map { title: "", walls: &WALLS, landmarks: &[], samples: &samples }).unwrap();
    let line = long_lines(&Document::parse(&svg).unwrap(), BLUE, "4")[0].clone();
    let length = line[line.len() - 1].0.abs_diff(line[0].0) as usize;
    let tree = Tree::from_str(&svg, &Options::default()).unwrap();
    let mut page = Pixmap::new(tree.size().to_int_size().width(), tree.size().to_int_size().height()).unwrap();
    resvg::render(&tree, Transform::identity(), &mut page.as_mut());
    let blue = |row: i32| {
        let row = usize::try_from(row).unwrap() * page.width() as usize;
        let pixels = &page.pixels()[row..row + page.width() as usize];
        pixels.iter().filter(|pixel| (pixel.red(), pixel.green(), pixel.blue()) == (BLUE.0, BLUE.1, BLUE.2)).count()
    };
    let found = blue(line[0].1);
    assert!(length > 500 && found.abs_diff(length) < 20, "{found} of {length}");
}
