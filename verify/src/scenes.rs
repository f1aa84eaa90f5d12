//! Scenes to run both pipelines over: the paper's data set, frontal views, and random scenes by frame number.
//!
//! Every scene stands on one wall, the y axis of the world, and is a function of seed and index alone.

use crate::sequence::Sequence;
use core::f64::consts::PI;
use core::ops::Range;
use rand::{Rng, RngExt};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use reference::camera::Camera;
use reference::codeword;
use reference::frame::{self, Point, Pose, World};
use reference::landmark::{Format, Landmark};
use reference::range::{self, MIN_STRIPE_PIXELS};
use reference::render::{Clutter, Light, Posted, Scene, Sensor, render};

/// Two scan lines, upper first.
pub type Lines = [Vec<u8>; 2];

/// A scene and the generator of its noise.
#[derive(Clone, Debug)]
pub struct Staged {
    /// What is in view.
    pub scene: Scene,
    /// Noise of the sensor.
    pub rng: ChaCha8Rng,
}

impl Staged {
    /// The scan lines.
    ///
    /// # Panics
    /// Never: only payloads with a code word are staged.
    #[must_use]
    pub fn render(&mut self, camera: &Camera) -> Lines {
        render(camera, &self.scene, &mut self.rng).expect("staged payloads have code words")
    }

    /// Format and payload of every landmark in the scene.
    #[must_use]
    pub fn truth(&self) -> Vec<(Format, u32)> {
        self.scene.landmarks.iter().map(|posted| (posted.landmark.format, posted.payload)).collect()
    }
}

/// The generator of one frame: a stream of its own for every index.
#[must_use]
pub fn generator(seed: u64, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(index);
    rng
}

/// A payload that has a code word.
#[must_use]
pub fn payload<R: Rng>(format: Format, rng: &mut R) -> u32 {
    loop {
        let candidate = rng.random_range(0..1_u32 << format.payload_bits());
        if codeword::encode(format, candidate).is_ok() {
            return candidate;
        }
    }
}

/// A landmark at `y` metres along the wall.
fn post(format: Format, payload: u32, y: f64) -> Posted {
    Posted { landmark_in_world: Pose::new(0.0, y, 0.0), landmark: Landmark::new(format), payload }
}

/// A camera at `distance` metres that looks at the wall under `inclination` and sees the world's origin `bearing`
/// radians to the right of its axis.
#[must_use]
pub fn viewpoint(distance: f64, inclination: f64, bearing: f64) -> Pose<World, frame::Camera> {
    let polar = inclination - bearing;
    Pose::new(distance * polar.cos(), distance * polar.sin(), PI + inclination)
}

/// Distances of the paper's data set, centimetres.
pub const PAPER_DISTANCES: [u32; 11] = [10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60];

/// Inclinations of the paper's data set, degrees.
pub const PAPER_INCLINATIONS: [u32; 5] = [0, 15, 30, 45, 60];

/// Views of each distance and inclination.
pub const PAPER_VIEWS: u64 = 30;

/// Barcodes of the paper's frontal case.
pub const PAPER_BARCODES: u64 = 4;

/// Centimetres of the frontal range: RANGE-3 ends at 45 cm, RANGE-4 begins at 66.7 cm.
pub const FRONTAL_CENTIMETRES: Range<u32> = 10..71;

/// Views of each centimetre of the frontal range.
pub const FRONTAL_VIEWS: u64 = 300;

/// A cell of a table of detection rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Inclination in degrees, or the number of the barcode in the frontal case.
    pub row: u32,
    /// Distance in centimetres.
    pub centimetres: u32,
}

/// A view of one `paper` barcode from where the paper took its images.
///
/// The paper does not say how its 30 views of a pose differ: here the heading is up to 0.1 rad off the barcode (less where
/// it would leave the image), the inclination is to either side, and the noise is new.
#[must_use]
pub fn view(seed: u64, index: u64, payload: u32, centimetres: u32, degrees: u32) -> Staged {
    let mut rng = generator(seed, index);
    let distance = f64::from(centimetres) / 100.0;
    let bearing = rng.random_range(-0.1..0.1) * (distance / 0.2).min(1.0);
    let side = if rng.random() { 1.0 } else { -1.0 };
    let scene = Scene {
        camera_in_world: viewpoint(distance, side * f64::from(degrees).to_radians() + bearing, bearing),
        landmarks: vec![post(Format::Paper, payload, 0.0)],
        clutter: Vec::new(),
        light: Light::default(),
        sensor: Sensor::default(),
    };
    Staged { scene, rng }
}

/// Frames of the paper's data set: 30 views of each distance and inclination (Fig. 9 b), and four barcodes frontally
/// (Fig. 9 a).
#[must_use]
pub fn paper_frames() -> u64 {
    let cells = PAPER_INCLINATIONS.len() as u64 + PAPER_BARCODES;
    cells * PAPER_DISTANCES.len() as u64 * PAPER_VIEWS
}

/// Row of the first barcode of the frontal case; rows below are inclinations in degrees.
pub const FIRST_BARCODE_ROW: u32 = 100;

/// Frame `index` of the paper's data set and its cell.
#[must_use]
pub fn paper_view(seed: u64, index: u64) -> (Cell, Staged) {
    let cell = index / PAPER_VIEWS;
    let distances = PAPER_DISTANCES.len() as u64;
    let (row, column) = (cell / distances, cell % distances);
    let centimetres = PAPER_DISTANCES[usize::try_from(column).unwrap_or(0)];
    let row = usize::try_from(row).unwrap_or(usize::MAX);
    let (row, degrees, barcode) = if let Some(&degrees) = PAPER_INCLINATIONS.get(row) {
        (degrees, degrees, 0)
    } else {
        let barcode = u32::try_from(row - PAPER_INCLINATIONS.len()).unwrap_or(u32::MAX);
        (FIRST_BARCODE_ROW + barcode, 0, barcode + 1)
    };
    // Streams that no frame has: one payload per barcode.
    let payload = payload(Format::Paper, &mut generator(seed, u64::MAX - u64::from(barcode)));
    (Cell { row, centimetres }, view(seed, index, payload, centimetres, degrees))
}

/// Frames of the frontal range.
#[must_use]
pub fn frontal_frames() -> u64 {
    FRONTAL_CENTIMETRES.len() as u64 * FRONTAL_VIEWS
}

/// Frame `index` of the frontal range, each with a payload of its own.
#[must_use]
pub fn frontal_view(seed: u64, index: u64) -> (Cell, Staged) {
    let seed = seed.wrapping_add(1);
    let centimetres = FRONTAL_CENTIMETRES.start + u32::try_from(index / FRONTAL_VIEWS).unwrap_or(0);
    let payload = payload(Format::Paper, &mut generator(seed, !index));
    (Cell { row: 0, centimetres }, view(seed, index, payload, centimetres, 0))
}

/// The space from which random scenes are drawn; each range is covered evenly.
pub mod space {
    use core::f64::consts::{FRAC_PI_3, PI};
    use core::ops::Range;

    /// Distance of the camera from the landmark, metres.
    pub const DISTANCE: Range<f64> = 0.08..0.60;
    /// Inclination, radians: 60° to either side.
    pub const INCLINATION: Range<f64> = -FRAC_PI_3..FRAC_PI_3;
    /// Bearing of the landmark, radians: 18° to either side, with half of the image's 41° at 20.6°.
    pub const BEARING: Range<f64> = -0.1 * PI..0.1 * PI;
    /// Exposure: from half the nominal light to a saturated wall.
    pub const EXPOSURE: Range<f64> = 0.5..1.3;
    /// Light gradient from one end of the line to the other.
    pub const GRADIENT: Range<f64> = -0.4..0.4;
    /// Optical blur, pixels.
    pub const BLUR: Range<f64> = 0.3..0.7;
    /// Sensor noise, grey levels.
    pub const NOISE: Range<f64> = 1.0..3.0;
}

/// Boxes per dimension of the pose space (distance, inclination, bearing) in which coverage is counted.
pub const BOXES: usize = 10;

/// A random scene, where in the pose space it is, and whether its first landmark should be found.
#[derive(Clone, Debug)]
pub struct RandomScene {
    /// The scene.
    pub staged: Staged,
    /// The box of the pose space, below `BOXES³`.
    pub cell: usize,
    /// What kind it is.
    pub kind: Kind,
    /// Whether the first landmark lies within RANGE-1 and RANGE-2 and in the image with its quiet zone.
    pub in_range: bool,
}

/// Kinds of random scenes, in the shares 85, 5 and 10 %.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One to three landmarks, up to two dark things on the wall.
    Landmarks,
    /// No landmark, up to two dark things.
    Blank,
    /// No landmark, many dark strips side by side, as fences and foreign bar codes are.
    Bars,
}

/// Draws random scenes by frame number.
#[derive(Clone, Debug)]
pub struct Scenes {
    seed: u64,
    /// Distance, inclination, bearing.
    pose: Sequence<3>,
    /// Exposure, gradient. A sequence of its own: the fewer dimensions, the more evenly they are filled.
    light: Sequence<2>,
}

/// A coordinate of the unit interval in a range.
fn scaled(u: f64, range: &Range<f64>) -> f64 {
    range.start + u * (range.end - range.start)
}

impl Scenes {
    /// The scenes of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed, pose: Sequence::new(seed), light: Sequence::new(seed.wrapping_add(3)) }
    }

    /// Scene `index`, which depends on nothing but the seed and the index.
    #[must_use]
    pub fn scene(&self, camera: &Camera, index: u64) -> RandomScene {
        let point = self.pose.point(index);
        let mut rng = generator(self.seed.wrapping_add(2), index);
        let kind = kind(&mut rng);
        let [distance, inclination, bearing] = point;
        let [exposure, gradient] = self.light.point(index);
        let camera_in_world = viewpoint(
            scaled(distance, &space::DISTANCE),
            scaled(inclination, &space::INCLINATION),
            scaled(bearing, &space::BEARING),
        );
        let (landmarks, clutter) = furnish(kind, &mut rng);
        let in_range = landmarks.first().is_some_and(|posted| is_in_range(camera, &camera_in_world, posted));
        let light = Light {
            exposure: scaled(exposure, &space::EXPOSURE),
            gradient: scaled(gradient, &space::GRADIENT),
            ..Light::default()
        };
        let sensor = Sensor { blur: rng.random_range(space::BLUR), noise: rng.random_range(space::NOISE) };
        let scene = Scene { camera_in_world, landmarks, clutter, light, sensor };
        RandomScene { staged: Staged { scene, rng }, cell: cell(&point), kind, in_range }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "coordinates are in [0, 1)")]
fn cell(point: &[f64; 3]) -> usize {
    point.iter().fold(0, |cell, u| cell * BOXES + (u * BOXES as f64) as usize)
}

fn kind<R: Rng>(rng: &mut R) -> Kind {
    match rng.random_range(0..100) {
        0..85 => Kind::Landmarks,
        85..90 => Kind::Blank,
        _ => Kind::Bars,
    }
}

/// Landmarks and clutter along the wall, kept apart as HYPO needs it: 1.5 barcode widths between landmarks.
fn furnish<R: Rng>(kind: Kind, rng: &mut R) -> (Vec<Posted>, Vec<Clutter>) {
    if kind == Kind::Bars {
        return (Vec::new(), bars(rng));
    }
    let mut landmarks = Vec::new();
    if kind == Kind::Landmarks {
        let first = if rng.random() { Format::Paper } else { Format::Wide };
        landmarks.push(post(first, payload(first, rng), 0.0));
        for side in [-1.0, 1.0] {
            if rng.random_bool(0.15) {
                let format = if rng.random() { Format::Paper } else { Format::Wide };
                let y = side * rng.random_range(0.10..0.16);
                landmarks.push(post(format, payload(format, rng), y));
            }
        }
    }
    // Beyond the neighbours: 5 cm from their edges at least.
    let mut clutter = Vec::new();
    for side in [-1.0, 1.0] {
        if rng.random_bool(0.3) {
            let inner = rng.random_range(0.23..0.40);
            let outer = inner + rng.random_range(0.002..0.06);
            clutter.push(strip(side * inner, side * outer, rng.random_range(0.3..1.0)));
        }
    }
    (landmarks, clutter)
}

/// A run of 4 to 24 strips of the widths that a barcode's bars have.
fn bars<R: Rng>(rng: &mut R) -> Vec<Clutter> {
    let count = rng.random_range(4..=24);
    let module = rng.random_range(0.8e-3..4e-3);
    let mut y = -f64::from(count) * module;
    (0..count)
        .map(|_| {
            let width = module * f64::from(rng.random_range(1..=3_u32));
            let bar = strip(y, y + width, rng.random_range(0.8..1.0));
            y += width + module * f64::from(rng.random_range(1..=3_u32));
            bar
        })
        .collect()
}

/// A dark strip on the wall between two places along it, metres.
fn strip(from: f64, to: f64, ink: f64) -> Clutter {
    // Seen from the front, y grows to the right.
    Clutter { left: Point::new(0.0, from.min(to)), right: Point::new(0.0, from.max(to)), ink }
}

/// Whether a landmark and its quiet zone are in the image, its stripes at least 1.5 px wide and no part of it deeper than
/// (6) allows.
fn is_in_range(camera: &Camera, camera_in_world: &Pose<World, frame::Camera>, posted: &Posted) -> bool {
    let pose = posted.landmark_in_world.inverse() * *camera_in_world;
    let landmark = &posted.landmark;
    let reach = landmark.half_width() + reference::landmark::QUIET_ZONE_STRIPES * landmark.stripe_width;
    let [left, right] = [-reach, reach].map(|b| camera.project_stripe(&pose, b));
    let seen = left.depth > 0.0 && right.depth > 0.0 && left.column >= 0.0 && right.column <= camera.width as f64 - 1.0;
    let deepest = [-landmark.half_width(), landmark.half_width()]
        .map(|b| camera.project_stripe(&pose, b).depth)
        .iter()
        .fold(0.0, |deepest: f64, depth| deepest.max(*depth));
    seen && range::narrowest_stripe(camera, landmark, &pose) >= MIN_STRIPE_PIXELS
        && deepest <= range::scan_line_range(camera, landmark, 0.0)
}
