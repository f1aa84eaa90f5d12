//! The forward model: the two scan lines of a scene (RENDER).

use crate::camera::Camera;
use crate::codeword::{self, EncodeRefusal};
use crate::frame::{self, Point, Pose, World};
use crate::landmark::Landmark;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// What the camera looks at, and how well it sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The camera in the world.
    pub camera_in_world: Pose<World, frame::Camera>,
    /// Landmarks on white walls. They do not hide each other: the ink of what overlaps adds up to at most 1 (RENDER-8).
    pub landmarks: Vec<Posted>,
    /// Other dark things.
    pub clutter: Vec<Clutter>,
    /// Light and the two colours.
    pub light: Light,
    /// Blur and noise.
    pub sensor: Sensor,
}

/// A landmark on a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posted {
    /// The landmark in the world.
    pub landmark_in_world: Pose<World, frame::Landmark>,
    /// Its format and dimensions.
    pub landmark: Landmark,
    /// What it carries.
    pub payload: u32,
}

/// An upright strip that fills both rows' height, dark from either side: a post, a door frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clutter {
    /// One of its two upright edges.
    pub left: Point<World>,
    /// The other one; seen from the strip's far side the two change places.
    pub right: Point<World>,
    /// From 0 for white to 1 for black.
    pub ink: f64,
}

/// Light, and the grey levels of the two colours in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Factor on every grey level, nominally 1.
    pub exposure: f64,
    /// Change from the left end of the line to the right one, relative to the middle, above -2 and below 2: the ends differ
    /// by `(2 + gradient) : (2 - gradient)`, 4:1 at 1.2.
    pub gradient: f64,
    /// Grey level of a white wall in the middle of the line at exposure 1.
    pub white: f64,
    /// Grey level of ink in the middle of the line at exposure 1.
    pub black: f64,
    /// Where the light is another one, if anywhere.
    pub patch: Option<Patch>,
}

/// A part of the line that light or shadow falls on, in both rows: a shadow's edge, a reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Column at which it begins; minus infinity where it comes from beyond the image.
    pub left: f64,
    /// Column at which it ends, not below `left`; infinity where it goes on beyond the image.
    pub right: f64,
    /// Factor on the grey levels, 0 or more: below 1 in a shadow.
    pub factor: f64,
}

impl Patch {
    /// What it multiplies a pixel by, of which it covers a share.
    fn on(&self, pixel: usize) -> f64 {
        let middle = pixel as f64;
        let share = (self.right.min(middle + 0.5) - self.left.max(middle - 0.5)).max(0.0);
        1.0 + (self.factor - 1.0) * share
    }
}

impl Default for Light {
    /// Even light at exposure 1 on a white of 200 and a black of 40 grey levels.
    fn default() -> Self {
        Self { exposure: 1.0, gradient: 0.0, white: 200.0, black: 40.0, patch: None }
    }
}

impl Light {
    /// The grey level of a pixel covered by `ink` in a line of the given width (RENDER-4).
    //= reference/SPEC.md#render
    //# - **RENDER-4** Light MUST multiply the radiance by the exposure, by a gradient linear in the column, 1 in the
    //# middle of the line, and by the factor of a patch of light or shadow in the share of the pixel that it covers.
    fn grey(&self, ink: f64, pixel: usize, width: usize) -> f64 {
        let place = pixel as f64 / (width as f64 - 1.0);
        let patch = self.patch.map_or(1.0, |patch| patch.on(pixel));
        let light = self.exposure * (1.0 + self.gradient * (place - 0.5)) * patch;
        light * (self.white - (self.white - self.black) * ink)
    }
}

/// Blur and noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Standard deviation of the optical blur, pixels, 0 or more (RENDER-2).
    pub blur: f64,
    /// Standard deviation of the noise, grey levels (RENDER-5).
    pub noise: f64,
}

impl Default for Sensor {
    /// A blur of 0.5 px and a noise of 2 grey levels.
    fn default() -> Self {
        Self { blur: 0.5, noise: 2.0 }
    }
}

/// The upper and the lower scan line of a scene, as wide as the camera (RENDER-1 to RENDER-8).
///
/// `rng` gives one normal deviate for every pixel, from left to right, the upper line's first; also where the noise
/// is 0. `camera` is one that CAM-7 allows. A payload without a code word is refused, whether it is in view or not.
//= reference/SPEC.md#render
//# - **RENDER-6** The same scene and seed MUST give the same bytes.
pub fn render<R: Rng + ?Sized>(camera: &Camera, scene: &Scene, rng: &mut R) -> Result<[Vec<u8>; 2], EncodeRefusal> {
    let lines = render_radiance(camera, scene)?;
    Ok(lines.map(|line| digitise(&line, scene.sensor.noise, rng)))
}

/// The grey levels of both scan lines before noise, rounding and limiting (RENDER-1 to RENDER-4, RENDER-7).
///
/// A pixel's ink is, for every layer, the integral of its blurred stripes over the pixel's columns times its share of
/// the row; light and share are those of the pixel's middle. A landmark is drawn whole or not at all: not if it is
/// seen from behind, or if one of its edges is not in front of the camera. The same goes for clutter and its edges.
pub fn render_radiance(camera: &Camera, scene: &Scene) -> Result<[Vec<f64>; 2], EncodeRefusal> {
    let ink = ink(camera, scene, [camera.upper_row, camera.lower_row])?;
    Ok(ink.map(|line| radiance(&line, &scene.light)))
}

/// The ink of one row of a scene, from 0 for white to 1 for black in every pixel (RENDER-1 to RENDER-3, RENDER-7,
/// RENDER-8).
//= reference/SPEC.md#render
//# - **RENDER-8** Ink of several objects in one pixel MUST add up to at most black; objects hide nothing.
pub fn row_ink(camera: &Camera, scene: &Scene, row: usize) -> Result<Vec<f64>, EncodeRefusal> {
    let [line] = ink(camera, scene, [row])?;
    Ok(line)
}

/// The grey levels of a line of ink, 0 to 1, in this light (RENDER-4).
#[must_use]
pub fn radiance(ink: &[f64], light: &Light) -> Vec<f64> {
    ink.iter().enumerate().map(|(i, &covered)| light.grey(covered, i, ink.len())).collect()
}

/// A line's grey levels with noise of the standard deviation `noise`, rounded half up and limited (RENDER-5).
///
/// `rng` gives one normal deviate for every pixel from left to right, also where the noise is 0.
//= reference/SPEC.md#render
//# - **RENDER-5** Sensor noise MUST be Gaussian and independent for every pixel, added before rounding to the nearest
//# integer and limiting to 0..255.
pub fn digitise<R: Rng + ?Sized>(radiance: &[f64], noise: f64, rng: &mut R) -> Vec<u8> {
    let pixel = |grey: &f64| {
        let deviate: f64 = StandardNormal.sample(rng);
        let rounded = (grey + noise * deviate + 0.5).floor().clamp(0.0, 255.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an integer from 0 to 255")]
        let pixel = rounded as u8;
        pixel
    };
    radiance.iter().map(pixel).collect()
}

/// The sum of what every object darkens in the given rows, limited to 1.
fn ink<const N: usize>(camera: &Camera, scene: &Scene, rows: [usize; N]) -> Result<[Vec<f64>; N], EncodeRefusal> {
    let mut lines = rows.map(|_| vec![0.0; camera.width]);
    for posted in &scene.landmarks {
        add_landmark(camera, scene, posted, rows, &mut lines)?;
    }
    let world_in_camera = scene.camera_in_world.inverse();
    for strip in &scene.clutter {
        let ends = [strip.left, strip.right].map(|end| camera.project(&world_in_camera.place(&end)));
        if ends.iter().all(|end| end.depth > 0.0) {
            let (left, right) = (ends[0].column.min(ends[1].column), ends[0].column.max(ends[1].column));
            let cover = coverage(camera.width, scene.sensor.blur, &[left, right], &[true]);
            for line in &mut lines {
                line.iter_mut().zip(&cover).for_each(|(ink, cover)| *ink += strip.ink * cover);
            }
        }
    }
    lines.iter_mut().flatten().for_each(|ink| *ink = ink.clamp(0.0, 1.0));
    Ok(lines)
}

/// Adds one landmark's ink to the rows' lines.
fn add_landmark<const N: usize>(
    camera: &Camera,
    scene: &Scene,
    posted: &Posted,
    rows: [usize; N],
    lines: &mut [Vec<f64>; N],
) -> Result<(), EncodeRefusal> {
    let layers = codeword::layers(posted.landmark.format, posted.payload)?;
    let pose = posted.landmark_in_world.inverse() * scene.camera_in_world;
    let Some(columns) = visible_edges(camera, &posted.landmark, &pose) else { return Ok(()) };
    let reach = Reach::new(camera, &posted.landmark, &pose);
    let share = |row: usize, layer: usize, column: usize| row_shares(camera, row, reach.at(column as f64))[layer];
    for (layer, stripes) in layers.iter().enumerate() {
        // A share is monotonic in the reach and that is linear: what has none at either end of the line has none.
        let shown = |row: usize| share(row, layer, 0) > 0.0 || share(row, layer, camera.width - 1) > 0.0;
        if !rows.iter().any(|&row| shown(row)) {
            continue;
        }
        let cover = coverage(camera.width, scene.sensor.blur, &columns, stripes);
        for (line, row) in lines.iter_mut().zip(rows) {
            for (i, ink) in line.iter_mut().enumerate() {
                *ink += share(row, layer, i) * cover[i];
            }
        }
    }
    Ok(())
}

/// The columns of a landmark's stripe edges from left to right, if it is drawn (RENDER-7).
//= reference/SPEC.md#render
//# - **RENDER-7** A landmark of which a part is behind the camera or whose wall is seen from behind MUST NOT be drawn.
fn visible_edges(
    camera: &Camera,
    landmark: &Landmark,
    pose: &Pose<frame::Landmark, frame::Camera>,
) -> Option<Vec<f64>> {
    if pose.x() <= 0.0 {
        return None;
    }
    // The right-most edge comes first (LAND-2).
    let sights = landmark.edges().into_iter().rev().map(|b| camera.project_stripe(pose, b));
    sights.map(|sight| (sight.depth > 0.0).then_some(sight.column)).collect()
}

/// How many rows high one layer of a landmark appears, column by column.
///
/// The ray of the column `o_x + f r` leaves the camera in the direction `R(θ) (1, -r)` and meets the landmark's plane,
/// `x = 0` in L, at the depth `D` with `x_C + D (cos θ + r sin θ) = 0`. The height `f_y h / (2 D)` is linear in `r`.
struct Reach {
    axis: f64,
    on_axis: f64,
    slope: f64,
}

impl Reach {
    fn new(camera: &Camera, landmark: &Landmark, pose: &Pose<frame::Landmark, frame::Camera>) -> Self {
        let scale = -camera.focal_length_vertical * landmark.stripe_height / pose.x();
        Self {
            axis: camera.principal_column,
            on_axis: scale * pose.theta().cos(),
            slope: scale * pose.theta().sin() / camera.focal_length,
        }
    }

    /// Rows at `column`; negative where the ray does not meet the plane in front of the camera.
    fn at(&self, column: f64) -> f64 {
        self.on_axis + self.slope * (column - self.axis)
    }
}

/// The shares of a row's height that lie in the upper and in the lower layer (RENDER-3), where a layer appears `reach`
/// rows high. Row `r` lies between `Q_y/2 - r - 1` and `Q_y/2 - r` rows above the axis.
//= reference/SPEC.md#render
//# - **RENDER-3** A landmark's stripe MUST darken a pixel by the share of its row's height in which the layer stands at
//# the pixel's middle, which falls below 1 where (6) says.
fn row_shares(camera: &Camera, row: usize, reach: f64) -> [f64; 2] {
    let top = camera.height as f64 / 2.0 - row as f64;
    let bottom = top - 1.0;
    let upper = top.min(reach) - bottom.max(0.0);
    let lower = top.min(0.0) - bottom.max(-reach);
    [upper.max(0.0), lower.max(0.0)]
}

/// The ink of every pixel of a line on which `stripes`, true for a bar, lie between `columns`, all from left to right;
/// beyond them it is white (RENDER-1, RENDER-2).
//= reference/SPEC.md#render
//# - **RENDER-1** A pixel's value MUST be the integral of the scene's radiance over the pixel's columns and its row's
//# height.
//= reference/SPEC.md#render
//# - **RENDER-2** Optical blur MUST be a Gaussian along the line, of the stated standard deviation in pixels, before
//# the pixel integrates.
fn coverage(width: usize, blur: f64, columns: &[f64], stripes: &[bool]) -> Vec<f64> {
    let mut edges = Edges::new(width, blur);
    let mut left = false;
    for (&column, &right) in columns.iter().zip(stripes.iter().chain(&[false])) {
        if left != right {
            edges.add(column, if right { 1.0 } else { -1.0 });
        }
        left = right;
    }
    edges.into_ink()
}

/// A sum of blurred edges: what each does to the pixels near it, and the full change from the next pixel on.
struct Edges {
    blur: f64,
    near: Vec<f64>,
    beyond: Vec<f64>,
}

impl Edges {
    fn new(width: usize, blur: f64) -> Self {
        Self { blur, near: vec![0.0; width], beyond: vec![0.0; width + 1] }
    }

    /// Changes the ink by `change` at `column` and to its right.
    fn add(&mut self, column: f64, change: f64) {
        // Beyond 6 standard deviations the edge is complete to 1e-9.
        let reach = 6.0 * self.blur + 1.0;
        let (first, end) = (self.pixel_from(column - reach), self.pixel_from(column + reach));
        let mut to_left = blurred_ramp(first as f64 - 0.5 - column, self.blur);
        for (i, ink) in self.near.iter_mut().enumerate().take(end).skip(first) {
            let to_right = blurred_ramp(i as f64 + 0.5 - column, self.blur);
            *ink += change * (to_right - to_left);
            to_left = to_right;
        }
        self.beyond[end] += change;
    }

    /// The first pixel whose middle lies at `column` or to its right, or the line's width.
    fn pixel_from(&self, column: f64) -> usize {
        let pixel = column.ceil().clamp(0.0, self.near.len() as f64);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an integer from 0 to the width")]
        let pixel = pixel as usize;
        pixel
    }

    fn into_ink(self) -> Vec<f64> {
        let mut ink = self.near;
        let mut level = 0.0;
        for (ink, change) in ink.iter_mut().zip(&self.beyond) {
            level += change;
            *ink += level;
        }
        ink
    }
}

/// The integral of a step at 0 from -∞ to `t` after a Gaussian blur of the standard deviation σ = `blur`:
/// `t Φ(t/σ) + σ φ(t/σ)`, and `max(t, 0)` for σ = 0.
fn blurred_ramp(t: f64, blur: f64) -> f64 {
    use core::f64::consts::{FRAC_1_SQRT_2, TAU};
    if blur <= 0.0 {
        return t.max(0.0);
    }
    let z = t / blur;
    // The standard library has no error function.
    t * 0.5 * libm::erfc(-z * FRAC_1_SQRT_2) + blur * libm::exp(-0.5 * z * z) / TAU.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark::Format;
    use core::f64::consts::{FRAC_PI_2, PI};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Upper layer 1010 1100 1100 0000 0101, lower layer 1010 1101 0100 0000 0101 (see `codeword`).
    const PAYLOAD: u32 = 0xcc0d;

    fn empty(blur: f64, noise: f64) -> Scene {
        Scene {
            camera_in_world: Pose::new(0.0, 0.0, 0.0),
            landmarks: Vec::new(),
            clutter: Vec::new(),
            light: Light::default(),
            sensor: Sensor { blur, noise },
        }
    }

    fn posted(landmark_in_world: Pose<World, frame::Landmark>) -> Posted {
        Posted { landmark_in_world, landmark: Landmark::new(Format::Paper), payload: PAYLOAD }
    }

    /// One landmark at the world's origin, so that L and W are the same, seen from `camera_in_world`.
    fn seen_from(camera_in_world: Pose<World, frame::Camera>, blur: f64) -> Scene {
        Scene { camera_in_world, landmarks: vec![posted(Pose::new(0.0, 0.0, 0.0))], ..empty(blur, 0.0) }
    }

    fn frontal(distance: f64, blur: f64) -> Scene {
        seen_from(Pose::new(distance, 0.0, PI), blur)
    }

    fn radiance_of(scene: &Scene) -> [Vec<f64>; 2] {
        render_radiance(&Camera::epuck(), scene).unwrap()
    }

    fn bytes(scene: &Scene, seed: u64) -> [Vec<u8>; 2] {
        render(&Camera::epuck(), scene, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap()
    }

    /// From grey levels back to ink, in the default light.
    fn inked(line: &[f64]) -> Vec<f64> {
        line.iter().map(|grey| (200.0 - grey) / 160.0).collect()
    }

    fn assert_pixels(line: &[f64], expected: &[(usize, f64)]) {
        for &(i, grey) in expected {
            assert!((line[i] - grey).abs() < 1e-9, "pixel {i} is {} instead of {grey}", line[i]);
        }
    }

    fn assert_blank(scene: &Scene) {
        assert!(radiance_of(scene).iter().flatten().all(|grey| (grey - 200.0).abs() < 1e-12));
    }

    /// An independent camera: the ink that the ray through `column`, `rows` rows above the axis, hits on a default
    /// landmark at the world's origin.
    fn cast_ray(pose: &Pose<World, frame::Camera>, stripe_width: f64, column: f64, rows: f64) -> f64 {
        let (sine, cosine) = pose.theta().sin_cos();
        let right = (column - 239.5) / 640.0;
        let depth = -pose.x() / (cosine + right * sine);
        let b = pose.y() + depth * (sine - right * cosine);
        let z = depth * rows / 80.0;
        let layer: &[u8; 20] = if z > 0.0 { b"10101100110000000101" } else { b"10101101010000000101" };
        let stripe = (b / stripe_width + 10.0).floor();
        if z.abs() > 0.025 || !(0.0..20.0).contains(&stripe) {
            return 0.0;
        }
        let (colour, _) = layer.iter().zip(0..).find(|&(_, j)| f64::from(j) >= stripe).unwrap();
        f64::from(colour - b'0')
    }

    /// One pixel's ink without any closed form: rays, averaged over the row, convolved with the blur, averaged over
    /// the pixel, all on a grid of 1/1000 px and 1/`per_row` row.
    fn brute_force(pose: &Pose<World, frame::Camera>, stripe_width: f64, pixel: f64, blur: f64, per_row: u16) -> f64 {
        const PER_PIXEL: i32 = 1000;
        let step = 1.0 / f64::from(PER_PIXEL);
        let spread: i32 = if blur > 0.0 { 8 * PER_PIXEL } else { 0 };
        let heights: Vec<f64> = (0..per_row).map(|k| 3.0 + (f64::from(k) + 0.5) / f64::from(per_row)).collect();
        let line: Vec<f64> = (-spread..PER_PIXEL + spread)
            .map(|k| pixel - 0.5 + (f64::from(k) + 0.5) * step)
            .map(|column| {
                heights.iter().map(|&rows| cast_ray(pose, stripe_width, column, rows)).sum::<f64>() / f64::from(per_row)
            })
            .collect();
        let kernel: Vec<f64> = if blur > 0.0 {
            (-spread..=spread).map(|k| (-0.5 * (f64::from(k) * step / blur).powi(2)).exp()).collect()
        } else {
            vec![1.0]
        };
        let blurred = line.windows(kernel.len()).map(|part| part.iter().zip(&kernel).map(|(a, b)| a * b).sum::<f64>());
        blurred.sum::<f64>() / kernel.iter().sum::<f64>() * step
    }

    //= reference/SPEC.md#render
    //= type=test
    //# - **RENDER-1** A pixel's value MUST be the integral of the scene's radiance over the pixel's columns and its
    //# row's height.
    //= reference/SPEC.md#render
    //= type=test
    //# - **RENDER-2** Optical blur MUST be a Gaussian along the line, of the stated standard deviation in pixels,
    //# before the pixel integrates.
    #[test]
    fn a_pixel_is_the_integral_of_the_blurred_stripes() {
        // 1.5 to 2.5 px per stripe; the landmark's middle lies left of the line's.
        let pose = Pose::new(0.4, 0.1, PI + 0.3);
        for blur in [0.0, 0.3, 0.5, 1.0] {
            let upper = inked(&radiance_of(&seen_from(pose, blur))[0]);
            let inside: Vec<usize> = (1..480).filter(|&i| (upper[i] - upper[i - 1]).abs() > 0.2).collect();
            assert!(inside.len() > 10);
            for &i in inside.iter().step_by(4) {
                let expected = brute_force(&pose, 1.5e-3, i as f64, blur, 1);
                assert!((upper[i] - expected).abs() < 1e-3, "blur {blur}, pixel {i}: {} for {expected}", upper[i]);
            }
        }
    }

    /// Stripes of 6 mm, whose ends are 0.45 and 0.55 m away: near and far side fade differently.
    #[test]
    fn the_row_share_is_that_of_the_pixels_own_depth() {
        let pose = Pose::new(0.5 * 0.9_f64.cos(), 0.5 * 0.9_f64.sin(), PI + 0.9);
        let mut scene = seen_from(pose, 0.0);
        scene.landmarks[0].landmark.stripe_width = 6e-3;
        let upper = inked(&radiance_of(&scene)[0]);
        let mut shares = Vec::new();
        for i in (180..320).filter(|&i| upper[i] > 0.0) {
            let expected = brute_force(&pose, 6e-3, i as f64, 0.0, 1000);
            assert!((upper[i] - expected).abs() < 4e-3, "pixel {i}: {} for {expected}", upper[i]);
            shares.push(expected);
        }
        assert!(shares.iter().any(|&share| share > 0.999) && shares.iter().any(|share| (0.6..0.8).contains(share)));
    }

    #[test]
    fn ink_is_conserved_by_blur_and_pixels() {
        // 8 bars of 640 * 1.5 mm / 0.37 m on either layer.
        let expected = 8.0 * 640.0 * 1.5e-3 / 0.37;
        for blur in [0.0, 1e-9, 0.3, 0.5, 1.0, 3.0] {
            for line in radiance_of(&frontal(0.37, blur)) {
                let total: f64 = inked(&line).iter().sum();
                assert!((total - expected).abs() < 1e-6, "blur {blur}: {total} for {expected}");
            }
        }
    }

    /// 3.2 px per stripe at 0.3 m: from 239.5 - 32 = 207.5 to 271.5.
    //= reference/SPEC.md#cam
    //= type=test
    //# - **CAM-1** Pixel `i` MUST cover the columns from `i - 1/2` to `i + 1/2`, with `i` growing from left to right as
    //# the robot sees.
    #[test]
    fn frontal_stripes_lie_at_the_pinholes_columns() {
        let [upper, lower] = radiance_of(&frontal(0.3, 0.0));
        for line in [&upper, &lower] {
            // Left guard: bars to 210.7 and from 213.9.
            assert_pixels(line, &[(207, 200.0), (208, 40.0), (210, 40.0), (211, 168.0), (212, 200.0), (214, 104.0)]);
            // Right guard: its last bar from 268.3, after a space from 265.1.
            assert_pixels(line, &[(266, 200.0), (267, 200.0), (268, 168.0), (269, 40.0), (271, 40.0), (272, 200.0)]);
            // Stripes 4, 5 are bars from 220.3 to 226.7; their mirror images 14, 15 are spaces from 252.3 to 258.7.
            assert_pixels(line, &[(221, 40.0), (226, 40.0), (253, 200.0), (258, 200.0)]);
        }
        // Stripe 7 (229.9 to 233.1) is a bar of the lower layer only, stripe 8 (to 236.3) of the upper one.
        assert_pixels(&upper, &[(231, 200.0), (232, 200.0), (234, 40.0), (235, 40.0)]);
        assert_pixels(&lower, &[(231, 40.0), (232, 40.0), (234, 200.0), (235, 200.0)]);
    }

    /// A landmark at (2, 1) facing along world y; a camera 0.3 m in front of it that turns by 0.1 to either side.
    //= reference/SPEC.md#frame
    //= type=test
    //# - **FRAME-3** The camera frame C and the robot frame R MUST have x forward and y left.
    #[test]
    fn a_camera_that_turns_left_sees_the_landmark_at_its_right() {
        for turn in [-0.1, 0.1_f64] {
            let mut scene = empty(0.5, 0.0);
            scene.landmarks.push(posted(Pose::new(2.0, 1.0, FRAC_PI_2)));
            scene.camera_in_world = Pose::new(2.0, 1.3, -FRAC_PI_2 + turn);
            let upper = inked(&radiance_of(&scene)[0]);
            let first = upper.iter().position(|&ink| ink > 0.5).unwrap() as f64;
            // The left end 0.05 rad to the left of the centre, and half a pixel of rounding.
            let left_end = 239.5 + 640.0 * (turn - (0.015_f64 / 0.3).atan()).tan();
            assert!((first - 0.5 - left_end).abs() <= 0.5, "{first} for {left_end}");
        }
    }

    /// The upper row sees the heights from `3 d/80` to `4 d/80`, of which `(0.025 - 3 d/80) / (d/80)` are stripes.
    //= reference/SPEC.md#render
    //= type=test
    //# - **RENDER-3** A landmark's stripe MUST darken a pixel by the share of its row's height in which the layer
    //# stands at the pixel's middle, which falls below 1 where (6) says.
    #[test]
    fn the_row_share_fades_from_50_to_67_centimetres() {
        for (distance, share) in [(0.3, 1.0), (0.5, 1.0), (4.0 / 7.0, 0.5), (0.62, 2.0 / 0.62 - 3.0), (2.0 / 3.0, 0.0)]
        {
            for line in radiance_of(&frontal(distance, 0.0)) {
                let darkest = inked(&line).into_iter().fold(0.0, f64::max);
                assert!((darkest - share).abs() < 1e-9, "{darkest} for {share} at {distance} m");
            }
        }
        assert_blank(&frontal(0.7, 0.5));
    }

    /// The upper row sees the heights from `3 d/f_y` to `4 d/f_y`: half of it is stripes where `3.5 d/f_y` is theirs.
    #[test]
    fn the_row_share_is_that_of_focal_length_and_stripe_height() {
        for (focal_length_vertical, stripe_height) in [(120.0, 25e-3), (80.0, 40e-3)] {
            let camera = Camera { focal_length_vertical, ..Camera::epuck() };
            let mut scene = frontal(stripe_height * focal_length_vertical / 3.5, 0.0);
            scene.landmarks[0].landmark = Landmark { format: Format::Paper, stripe_width: 6e-3, stripe_height };
            for line in render_radiance(&camera, &scene).unwrap() {
                let darkest = inked(&line).into_iter().fold(0.0, f64::max);
                assert!((darkest - 0.5).abs() < 1e-9, "{darkest}");
            }
        }
    }

    /// Rows 1, 2 and 3 of 5 lie above, astride and below the axis.
    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-4** The upper layer MUST fill the height from 0 to the stripe height above the camera's height, and the
    //# lower layer the same below it.
    #[test]
    fn a_row_astride_the_axis_sees_both_layers() {
        let camera = Camera { height: 5, upper_row: 1, lower_row: 2, ..Camera::epuck() };
        let [upper, middle] = render_radiance(&camera, &frontal(0.3, 0.0)).unwrap();
        assert_pixels(&upper, &[(225, 40.0), (231, 200.0), (234, 40.0)]);
        assert_pixels(&middle, &[(225, 40.0), (231, 120.0), (234, 120.0)]);
        let lower = render_radiance(&Camera { upper_row: 2, lower_row: 3, ..camera }, &frontal(0.3, 0.0)).unwrap();
        assert_pixels(&lower[0], &[(225, 40.0), (231, 120.0), (234, 120.0)]);
        assert_pixels(&lower[1], &[(225, 40.0), (231, 40.0), (234, 200.0)]);
    }

    #[test]
    fn light_is_exposure_times_a_gradient_about_the_middle() {
        let mut scene = frontal(0.3, 0.0);
        scene.light = Light { exposure: 0.5, gradient: 0.2, white: 210.0, black: 30.0, patch: None };
        let [upper, _] = radiance_of(&scene);
        assert_pixels(&upper, &[(0, 105.0 * 0.9), (479, 105.0 * 1.1)]);
        assert!((f64::midpoint(upper[100], upper[379]) - 105.0).abs() < 1e-9);
        // Ink has the same factors.
        assert_pixels(&upper, &[(209, 15.0 * (1.0 + 0.2 * (209.0 / 479.0 - 0.5)))]);
    }

    #[test]
    fn the_lights_ends_may_differ_by_four_to_one() {
        for (gradient, ends) in [(1.2, (40.0, 160.0)), (-1.2, (160.0, 40.0))] {
            let mut scene = empty(0.0, 0.0);
            scene.light = Light { exposure: 0.5, gradient, ..Light::default() };
            for line in radiance_of(&scene) {
                assert_pixels(&line, &[(0, ends.0), (479, ends.1)]);
            }
        }
    }

    /// A pixel reaches half a pixel to either side of its number; the landmark's ink and a gradient are under the patch.
    //= reference/SPEC.md#render
    //= type=test
    //# - **RENDER-4** Light MUST multiply the radiance by the exposure, by a gradient linear in the column, 1 in the
    //# middle of the line, and by the factor of a patch of light or shadow in the share of the pixel that it covers.
    #[test]
    fn a_patch_covers_shares_of_pixels() {
        let mut scene = frontal(0.3, 0.0);
        let plain = radiance_of(&scene);
        let mut shares = |left: f64, right: f64| {
            scene.light.patch = Some(Patch { left, right, factor: 0.5 });
            let patched = radiance_of(&scene);
            let share = |i: usize| {
                let [upper, lower] = [0, 1].map(|row: usize| 2.0 * (1.0 - patched[row][i] / plain[row][i]));
                assert!((upper - lower).abs() < 1e-12);
                upper
            };
            (0..480).map(share).enumerate().filter(|(_, share)| share.abs() > 1e-12).collect::<Vec<_>>()
        };
        let near = |found: &[(usize, f64)], expected: &[(usize, f64)]| {
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-12, "{found:?} for {expected:?}");
            }
        };
        near(&shares(209.75, 212.0), &[(210, 0.75), (211, 1.0), (212, 0.5)]);
        near(&shares(300.0, 300.25), &[(300, 0.25)]);
        near(&shares(f64::NEG_INFINITY, 1.0), &[(0, 1.0), (1, 0.5)]);
        near(&shares(478.25, f64::INFINITY), &[(478, 0.25), (479, 1.0)]);
        assert_eq!(shares(f64::NEG_INFINITY, f64::INFINITY).len(), 480);
        near(&shares(500.0, f64::INFINITY), &[]);
    }

    /// The mean and standard deviation of 960 * 200 pixels; rounding adds a variance of 1/12.
    //= reference/SPEC.md#render
    //= type=test
    //# - **RENDER-5** Sensor noise MUST be Gaussian and independent for every pixel, added before rounding to the
    //# nearest integer and limiting to 0..255.
    #[test]
    fn noise_is_gaussian_and_independent() {
        let mut scene = empty(0.5, 3.0);
        scene.light.white = 120.3;
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let frames: Vec<_> = (0..200).map(|_| render(&Camera::epuck(), &scene, &mut rng).unwrap()).collect();
        let deviation = |&pixel: &u8| f64::from(pixel) - 120.3;
        let all: Vec<f64> = frames.iter().flatten().flatten().map(deviation).collect();
        let count = all.len() as f64;
        let mean = all.iter().sum::<f64>() / count;
        let variance = all.iter().map(|d| d * d).sum::<f64>() / count;
        // Four standard errors: 4 * 3/sqrt(192000) and 4 * 9 * sqrt(2/192000).
        assert!(mean.abs() < 0.0275, "mean {mean}");
        assert!((variance - 9.0 - 1.0 / 12.0).abs() < 0.117, "variance {variance}");
        let within = all.iter().filter(|d| d.abs() < 3.0).count() as f64 / count;
        // From 117.5 to 123.5: Φ(3.2/3) - Φ(-2.8/3) = 0.6816.
        assert!((within - 0.6816).abs() < 0.0043, "{within} within one standard deviation");
        let neighbours = all.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / count / variance;
        let rows = frames.iter().flat_map(|[upper, lower]| upper.iter().zip(lower));
        let between = rows.map(|(upper, lower)| deviation(upper) * deviation(lower)).sum::<f64>();
        assert!(neighbours.abs() < 0.01 && (between / (count / 2.0) / variance).abs() < 0.013);
    }

    #[test]
    fn grey_levels_are_rounded_half_up_and_limited() {
        let constant = |white: f64| {
            let mut scene = empty(0.5, 0.0);
            scene.light.white = white;
            let [upper, lower] = bytes(&scene, 1);
            assert!(upper.iter().chain(&lower).all(|&pixel| pixel == upper[0]));
            upper[0]
        };
        let levels = [-5.0, -0.51, 0.49, 0.5, 99.49, 99.5, 100.5, 254.49, 255.5, 400.0].map(constant);
        assert_eq!(levels, [0, 0, 0, 1, 99, 100, 101, 254, 255, 255]);
    }

    //= reference/SPEC.md#render
    //= type=test
    //# - **RENDER-6** The same scene and seed MUST give the same bytes.
    #[test]
    fn the_same_seed_gives_the_same_bytes() {
        let scene = Scene { sensor: Sensor::default(), ..frontal(0.3, 0.5) };
        assert_eq!(bytes(&scene, 1), bytes(&scene, 1));
        assert_ne!(bytes(&scene, 1), bytes(&scene, 2));
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        render(&Camera::epuck(), &frontal(0.3, 0.5), &mut rng).unwrap();
        let mut other = ChaCha8Rng::seed_from_u64(3);
        render(&Camera::epuck(), &scene, &mut other).unwrap();
        assert_eq!(rng, other, "noise 0 leaves the generator where any noise does");
    }

    //= reference/SPEC.md#render
    //= type=test
    //# - **RENDER-7** A landmark of which a part is behind the camera or whose wall is seen from behind MUST NOT be
    //# drawn.
    #[test]
    fn what_is_behind_wall_or_camera_is_not_drawn() {
        let blur = 0.5;
        assert_blank(&seen_from(Pose::new(-0.3, 0.0, 0.0), blur));
        assert_blank(&seen_from(Pose::new(0.3, 0.0, 0.0), blur));
        // Along the wall, 2 mm from it: the right end would be 64 px left of the middle, but the left end is behind.
        assert_blank(&seen_from(Pose::new(0.002, -0.005, FRAC_PI_2), blur));
        // From behind it does not take ink away from what is dark already either.
        let dark = Clutter { left: Point::new(1.0, 0.5), right: Point::new(1.0, -0.5), ink: 1.0 };
        let both = Scene { clutter: vec![dark], ..seen_from(Pose::new(-0.3, 0.0, 0.0), blur) };
        assert!(radiance_of(&both).iter().flatten().all(|grey| (grey - 40.0).abs() < 1e-6));
        let behind = Clutter { left: Point::new(-1.0, -0.1), right: Point::new(-1.0, 0.1), ink: 1.0 };
        let partly = Clutter { left: Point::new(1.0, 0.1), right: Point::new(-0.1, 0.1), ink: 1.0 };
        assert_blank(&Scene { clutter: vec![behind, partly], ..empty(blur, 0.0) });
    }

    //= reference/SPEC.md#render
    //= type=test
    //# - **RENDER-8** Ink of several objects in one pixel MUST add up to at most black; objects hide nothing.
    #[test]
    fn objects_add_up_to_black() {
        // Two landmarks 60 mm apart at 0.3 m: 128 px.
        let mut scene = frontal(0.3, 0.0);
        scene.landmarks = vec![posted(Pose::new(0.0, -0.03, 0.0)), posted(Pose::new(0.0, 0.03, 0.0))];
        let both = radiance_of(&scene);
        let single = radiance_of(&frontal(0.3, 0.0));
        for (both, single) in both.iter().zip(&single) {
            for i in 207..272 {
                assert!((both[i - 64] - single[i]).abs() < 1e-9 && (both[i + 64] - single[i]).abs() < 1e-9);
            }
        }
        scene.landmarks = vec![posted(Pose::new(0.0, 0.0, 0.0)); 2];
        for (twice, once) in radiance_of(&scene)[0].iter().zip(&single[0]) {
            let ink = (2.0 * (200.0 - once) / 160.0).min(1.0);
            assert!((twice - (200.0 - 160.0 * ink)).abs() < 1e-9);
        }
    }

    /// A strip 1 m away, 64.25 to 32.25 px left of the middle, drawn alike from either side.
    #[test]
    fn clutter_fills_both_rows() {
        let (left, right) = (Point::new(1.0, 64.25 / 640.0), Point::new(1.0, 32.25 / 640.0));
        for (left, right) in [(left, right), (right, left)] {
            let scene = Scene { clutter: vec![Clutter { left, right, ink: 0.5 }], ..empty(0.0, 0.0) };
            for line in radiance_of(&scene) {
                // From 175.25 to 207.25.
                assert_pixels(
                    &line,
                    &[(174, 200.0), (175, 180.0), (176, 120.0), (206, 120.0), (207, 140.0), (208, 200.0)],
                );
            }
        }
    }

    #[test]
    fn a_payload_without_a_code_word_is_refused_even_out_of_view() {
        let mut scene = seen_from(Pose::new(-0.3, 0.0, 0.0), 0.5);
        scene.landmarks[0].payload = 0x1_0000;
        assert_eq!(render_radiance(&Camera::epuck(), &scene), Err(EncodeRefusal::TooLarge));
    }
}
