//! A camera that looks at a raster, and what its pictures say about where it stands. Made from SPEC's CAM and ERRATA
//! alone: nothing of `reference` is used.

use super::raster::Raster;
use core::f64::consts::{PI, SQRT_2, TAU};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The e-puck's camera (CAM).
const COLUMNS: usize = 480;
const FOCAL_LENGTH: f64 = 640.0;
const FOCAL_LENGTH_VERTICAL: f64 = 80.0;
const PRINCIPAL_COLUMN: f64 = 239.5;
/// Rows above the axis at which a scan line's row ends, the upper one first: rows 0 and 7 of 8.
const ROW_TOPS: [f64; 2] = [4.0, -3.0];

/// Grey levels of paper and ink; standard deviations of the noise in grey levels and of the blur in pixels.
const WHITE: f64 = 200.0;
const BLACK: f64 = 40.0;
const NOISE: f64 = 2.0;
const BLUR: f64 = 0.5;

/// Stripe width, metres.
const STRIPE: f64 = 1.5e-3;

/// Where the camera stands in the landmark's frame: metres, and the inclination in radians.
pub(crate) struct View {
    x: f64,
    y: f64,
    inclination: f64,
}

impl View {
    /// At `distance` from the barcode, which appears `bearing` to the right of the optical axis.
    pub(crate) fn new(distance: f64, inclination: f64, bearing: f64) -> Self {
        let polar = inclination - bearing;
        Self { x: distance * polar.cos(), y: distance * polar.sin(), inclination }
    }

    /// Centre, half width and obliquity of the barcode's image for a half width of `half` metres: from
    /// `r(b) = x sin θ + (b - y) cos θ` and `D(b) = x cos θ + (y - b) sin θ` with `b = t W`.
    fn homography(&self, half: f64) -> Vector3<f64> {
        let (sine, cosine) = self.inclination.sin_cos();
        let depth = self.x * cosine + self.y * sine;
        let aside = self.x * sine - self.y * cosine;
        Vector3::new(FOCAL_LENGTH * aside / depth, FOCAL_LENGTH * half * cosine / depth, -half * sine / depth)
    }
}

/// The pose x, y, heading that sees a homography: the inverse of [`View::homography`], the heading from 0 to 2π.
fn pose_of(h: &Vector3<f64>, half: f64) -> Vector3<f64> {
    let inclination = (-h[2] * FOCAL_LENGTH / h[1]).atan();
    let (sine, cosine) = inclination.sin_cos();
    let depth = FOCAL_LENGTH * half * cosine / h[1];
    let aside = h[0] * depth / FOCAL_LENGTH;
    Vector3::new(depth * cosine + aside * sine, depth * sine - aside * cosine, PI + inclination)
}

/// Both scan lines of the page that hangs on the wall with `centre` (mm) in the landmark's origin.
///
/// Every pixel is the mean of rays over its columns, its row's height and the blur's Gaussian.
pub(crate) fn photograph(raster: &Raster, centre: [f64; 2], view: &View, rng: &mut ChaCha8Rng) -> [Vec<u8>; 2] {
    let blurs: Vec<f64> = (-8..=8).map(|k| f64::from(k) * 0.375 * BLUR).collect();
    let weights: Vec<f64> = blurs.iter().map(|offset| (-0.5 * (offset / BLUR).powi(2)).exp()).collect();
    let whole: f64 = weights.iter().sum();
    let steps = 12;
    let share = |k: u32| (f64::from(k) + 0.5) / f64::from(steps);
    ROW_TOPS.map(|top| {
        let pixel = |i: usize| {
            let mut ink = 0.0;
            for (offset, weight) in blurs.iter().zip(&weights) {
                for column in (0..steps).map(|k| i as f64 - 0.5 + share(k) + offset) {
                    ink += weight
                        * (0..4)
                            .map(|k| ray(raster, centre, view, column, top - (f64::from(k) + 0.5) / 4.0))
                            .sum::<f64>();
                }
            }
            WHITE - (WHITE - BLACK) * ink / (whole * 4.0 * f64::from(steps))
        };
        let line: Vec<f64> = (0..COLUMNS).map(pixel).collect();
        line.into_iter().map(|grey| (grey + NOISE * normal(rng)).round().clamp(0.0, 255.0) as u8).collect()
    })
}

/// Ink where a ray meets the page.
fn ray(raster: &Raster, centre: [f64; 2], view: &View, column: f64, rows_up: f64) -> f64 {
    let right = (column - PRINCIPAL_COLUMN) / FOCAL_LENGTH;
    let (sine, cosine) = view.inclination.sin_cos();
    // The axis is (-cos θ, -sin θ) and the camera's right (-sin θ, cos θ).
    let towards = [-cosine - right * sine, -sine + right * cosine];
    if towards[0] >= -1e-9 {
        return 0.0;
    }
    let depth = -view.x / towards[0];
    let (along, up) = (view.y + depth * towards[1], depth * rows_up / FOCAL_LENGTH_VERTICAL);
    raster.at([centre[0] + 1e3 * along, centre[1] - 1e3 * up])
}

/// A normal deviate (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// Chi-square of three degrees of freedom that one view in a million exceeds.
pub(crate) const LARGEST_CHI_SQUARE: f64 = 30.66;

/// How well a view can be known: the covariance of its homography, from the noise of the transitions.
pub(crate) struct Budget {
    truth: Vector3<f64>,
    covariance: Matrix3<f64>,
    half: f64,
}

impl Budget {
    /// For stripes of both layers, true for a bar. Each layer's homography is HOMOG-1's least squares over its
    /// transitions, whose residual changes by `1 + k t` for each pixel of a column's error; the result is the layers' mean.
    pub(crate) fn new(view: &View, layers: &[Vec<bool>; 2]) -> Self {
        let half = layers[0].len() as f64 * STRIPE / 2.0;
        let truth = view.homography(half);
        let variance = crossing_variance();
        let covariance: Matrix3<f64> = layers.iter().map(|stripes| layer_covariance(stripes, &truth, variance)).sum();
        Self { truth, covariance: covariance / 4.0, half }
    }

    /// The squared distance of a homography from the truth in standard deviations.
    pub(crate) fn chi_square(&self, found: &Vector3<f64>) -> f64 {
        let error = found - self.truth;
        error.dot(&(self.covariance.try_inverse().unwrap() * error))
    }

    /// The true pose: x, y, heading.
    pub(crate) fn pose(&self) -> Vector3<f64> {
        pose_of(&self.truth, self.half)
    }

    /// The lowest and the highest x, y and heading of the homographies with the largest chi-square.
    pub(crate) fn poses(&self) -> [Vector3<f64>; 2] {
        let eigen = SymmetricEigen::new(self.covariance);
        let axes = eigen.eigenvectors * Matrix3::from_diagonal(&eigen.eigenvalues.map(f64::sqrt));
        let mut range = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
        for (i, j) in (0..=60).flat_map(|i| (0..120).map(move |j| (i, j))) {
            let (polar, turn) = (PI * f64::from(i) / 60.0, TAU * f64::from(j) / 120.0);
            let direction = Vector3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos());
            let pose = pose_of(&(self.truth + axes * direction * LARGEST_CHI_SQUARE.sqrt()), self.half);
            range = [range[0].inf(&pose), range[1].sup(&pose)];
        }
        range
    }
}

/// The covariance of one layer's homography.
fn layer_covariance(stripes: &[bool], truth: &Vector3<f64>, variance: f64) -> Matrix3<f64> {
    let count = stripes.len();
    let black = |j: Option<usize>| j.and_then(|j| stripes.get(j)).copied().unwrap_or(false);
    // HOMOG-2 counts the barcode's ends, 0 and N, among its transitions.
    let edges = (0..=count).filter(|&v| black(v.checked_sub(1)) != black(Some(v)));
    let (mut normal, mut scatter) = (Matrix3::zeros(), Matrix3::zeros());
    for t in edges.map(|v| 2.0 * v as f64 / count as f64 - 1.0) {
        let stretch = 1.0 + truth[2] * t;
        let column = (truth[0] + truth[1] * t) / stretch;
        let row = Vector3::new(1.0, t, -t * column);
        normal += row * row.transpose();
        scatter += row * row.transpose() * (variance * stretch * stretch);
    }
    let inverse = normal.try_inverse().unwrap();
    inverse * scatter * inverse
}

/// The mean square error of a transition by CROSS-2, in pixels squared, over all places of an edge between two pixels:
/// the rule's own error, the noise of both pixels with their rounding, and a threshold that is off by as much as one
/// pixel's noise.
fn crossing_variance() -> f64 {
    let places = 100;
    let noise = NOISE * NOISE + 1.0 / 12.0;
    let sum: f64 = (0..places)
        .map(|k| {
            let place = (f64::from(k) + 0.5) / f64::from(places);
            // Pixels 0 and 1 straddle the threshold where the edge is between their middles.
            let [left, right] = [grey(-place), grey(1.0 - place)];
            let crossing = |left: f64, right: f64, threshold: f64| (left - threshold) / (left - right);
            let middle = f64::midpoint(WHITE, BLACK);
            let slope = |left_more: f64, right_more: f64, threshold_more: f64| {
                let step = 1e-3;
                let by = |sign: f64| {
                    let moved = |level: f64, more: f64| level + sign * step * more;
                    crossing(moved(left, left_more), moved(right, right_more), moved(middle, threshold_more))
                };
                (by(1.0) - by(-1.0)) / (2.0 * step)
            };
            let slopes = [slope(1.0, 0.0, 0.0), slope(0.0, 1.0, 0.0), slope(0.0, 0.0, 1.0)];
            let error = crossing(left, right, middle) - place;
            error * error + slopes.iter().map(|slope| slope * slope * noise).sum::<f64>()
        })
        .sum();
    sum / f64::from(places)
}

/// The grey level of a pixel whose middle is `right` pixels to the right of an edge from white to black.
fn grey(right: f64) -> f64 {
    let samples = 200;
    let black = |k: i32| normal_share((right - 0.5 + (f64::from(k) + 0.5) / f64::from(samples)) / BLUR);
    WHITE - (WHITE - BLACK) * (0..samples).map(black).sum::<f64>() / f64::from(samples)
}

/// The normal distribution function, by the series `Φ(u) = 1/2 + φ(u) (u + u³/3 + u⁵/(3 5) + ...)`.
fn normal_share(u: f64) -> f64 {
    let (mut term, mut sum) = (u, u);
    for n in 1..200 {
        term *= u * u / f64::from(2 * n + 1);
        sum += term;
    }
    0.5 + sum * (-u * u / 2.0).exp() / (SQRT_2 * PI.sqrt())
}
