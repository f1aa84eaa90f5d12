//! How far the minimum of a fit moves when its pixels or its derivatives are rounded.
//!
//! Gauss-Newton's matrix `A = JᵀJ` says how well a minimum is known. How far it moves with an error of the pixels, and how fast
//! the steps come nearer to it, is said by the whole Hessian `A - S`, `S = Σ r ∇²f` over the residuals `r` of the model `f`.

use crate::trace::{FitTrace, TrialTrace};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Vector4};
use reference::camera::Camera;
use reference::codeword;
use reference::fit::{BLURS, Imaging, Ink, LayerLight, Window, inks, is_limited};
use reference::homography::Homography;

/// The curvature of the residuals beside that of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensitivity {
    /// The largest eigenvalue of `A⁻¹ S`, at least 0: the minimum moves by up to `1/(1 - it)` of what `A` says.
    pub softening: f64,
    /// The largest absolute eigenvalue of `(A + W)⁻¹ (S + W)`, with `W` what FIT-8 adds: what a step leaves of the way to the
    /// minimum.
    pub rate: f64,
    /// The largest standard deviation of a light's parameter, in those of a pixel.
    pub light: f64,
    /// How far FIT-6's prior draws the minimum from that of the pixels alone: the root of the change of their sum of
    /// squares, grey levels.
    pub pull: f64,
}

/// Parameters that the layers have in common, and those of each layer.
const COMMON: usize = 4;

/// What a squared grey level weighs by which a light changes, or white differs from its start, pixels (FIT-6).
const PRIOR: f64 = 1.0 / 256.0;

/// What is added to the diagonal for the blur, by the square of a layer's contrast (FIT-8).
const BLUR_DAMPING: f64 = 1.0 / 64.0;

/// The blur's place among the common parameters.
const BLUR: usize = 3;

/// By how much parameters are moved to see how derivatives change: pixels; `k` in as many of the half width.
const MOVE: f64 = 1e-4;

/// The sensitivity of the last fit of a trial, whose half words are those of its last reading; `None` without one.
#[must_use]
pub fn sensitivity(trial: &TrialTrace, lines: [&[u8]; 2], camera: &Camera) -> Option<Sensitivity> {
    let fit = trial.fits.iter().flatten().last()?;
    let (_, Ok(payload)) = *trial.readings.last()? else { return None };
    let colours = codeword::layers(trial.format, payload).ok()?;
    let columns = if is_limited_blur(fit.blur) { COMMON - 1 } else { COMMON };
    let (normal, curvature) = matrices(trial, fit, &colours, lines, camera, columns);
    let root = Cholesky::new(normal.clone())?;
    let softening = relative(&root, &curvature)?.symmetric_eigenvalues().max().max(0.0);
    let light = root.inverse().diagonal().rows_range(columns..).max().sqrt();
    let extremes = [0, 1].map(|layer| extremes(trial, layer, lines[layer]));
    let prior = DVector::from_fn(normal.nrows(), |j, _| match j.checked_sub(columns) {
        Some(own) => PRIOR * away(fit, extremes, own / 4)[own % 4],
        None => 0.0,
    });
    let pull = root.l().solve_lower_triangular(&prior)?.norm();
    let (mut damped, mut left) = (normal, curvature);
    if columns > BLUR {
        let damping = BLUR_DAMPING * extremes.iter().map(|(darkest, white)| (white - darkest).powi(2)).sum::<f64>();
        damped[(BLUR, BLUR)] += damping;
        left[(BLUR, BLUR)] += damping;
    }
    let rate = relative(&Cholesky::new(damped)?, &left)?.symmetric_eigenvalues().amax();
    Some(Sensitivity { softening, rate, light, pull })
}

/// The smallest and the largest value of a layer's window (FIT-7).
fn extremes(trial: &TrialTrace, layer: usize, line: &[u8]) -> (f64, f64) {
    let window = window(trial, layer, line);
    let values = &line[window.first..=window.last];
    let darkest = values.iter().copied().min().unwrap_or_default();
    let brightest = values.iter().copied().max().unwrap_or_default();
    (f64::from(darkest), f64::from(brightest))
}

/// How far a layer's `o`, `g`, `o'` and `g'` are from what FIT-6 draws them to, grey levels; `g` is not drawn.
fn away(fit: &FitTrace, extremes: [(f64, f64); 2], layer: usize) -> [f64; 4] {
    let [offset, _, offset_slope, gain_slope] = fit.lights[layer].levels;
    [offset - extremes[layer].1, 0.0, offset_slope, gain_slope]
}

/// The window of a layer (FIT-1).
fn window(trial: &TrialTrace, layer: usize, line: &[u8]) -> Window {
    let (first, last) = trial.pixels[layer];
    Window::of(first, last, trial.format, line.len())
}

/// `A` and `S` in the first `columns` of the common parameters and those of each layer.
fn matrices(
    trial: &TrialTrace,
    fit: &FitTrace,
    colours: &[Vec<bool>; 2],
    lines: [&[u8]; 2],
    camera: &Camera,
    columns: usize,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = columns + 4 * colours.len();
    let (mut normal, mut curvature) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for (i, stripes) in colours.iter().enumerate() {
        let own = columns + 4 * i;
        for pixel in pixels(trial, fit, i, stripes, lines[i], camera) {
            pixel.add(&mut normal, &mut curvature, columns, own);
        }
        // FIT-6
        for j in [own, own + 2, own + 3] {
            normal[(j, j)] += PRIOR;
        }
    }
    (normal, curvature)
}

/// Whether the blur is at one of FIT-10's limits, where it is no parameter any more.
#[must_use]
pub fn is_limited_blur(blur: f64) -> bool {
    let near = |limit: f64| (blur - limit).abs() <= 2.0_f64.powi(-15);
    near(*BLURS.start()) || near(*BLURS.end())
}

/// `L⁻¹ S L⁻ᵀ` with `A = L Lᵀ`, whose eigenvalues are those of `A⁻¹ S`.
fn relative(root: &Cholesky<f64, Dyn>, curvature: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let half = root.l().solve_lower_triangular(curvature)?;
    root.l().solve_lower_triangular(&half.transpose())
}

/// A pixel of the fit: its residual, its derivatives, and how these change.
struct Pixel {
    residual: f64,
    gain: f64,
    lambda: f64,
    ink: Ink,
    /// The second derivatives of its ink.
    bend: [Vector4<f64>; COMMON],
}

impl Pixel {
    fn add(&self, normal: &mut DMatrix<f64>, curvature: &mut DMatrix<f64>, columns: usize, own: usize) {
        let Self { residual, gain, lambda, ink, ref bend } = *self;
        let mut row = DVector::zeros(normal.nrows());
        for i in 0..columns {
            row[i] = gain * ink.gradient[i];
            for j in 0..columns {
                curvature[(i, j)] += residual * gain * f64::midpoint(bend[i][j], bend[j][i]);
            }
            // The gain's and its change's columns: the ink, and λ times it.
            for (place, by) in [(own + 1, 1.0), (own + 3, lambda)] {
                let mixed = residual * by * ink.gradient[i];
                curvature[(i, place)] += mixed;
                curvature[(place, i)] += mixed;
            }
        }
        for (place, value) in (own..).zip([1.0, ink.ink, lambda, lambda * ink.ink]) {
            row[place] = value;
        }
        normal.ger(1.0, &row, &row, 1.0);
    }
}

/// The pixels of a layer that count.
fn pixels(
    trial: &TrialTrace,
    fit: &FitTrace,
    layer: usize,
    stripes: &[bool],
    line: &[u8],
    camera: &Camera,
) -> Vec<Pixel> {
    let window = window(trial, layer, line);
    let imaging = imaging(fit);
    let inks = |imaging: &Imaging| inks(imaging, camera, trial.format, stripes, (window.first, window.last));
    let here = inks(&imaging);
    let bends: [Vec<Vector4<f64>>; COMMON] = std::array::from_fn(|i| {
        let there = inks(&moved(&imaging, i));
        here.iter().zip(&there).map(|(here, there)| (there.gradient - here.gradient) / size(&imaging, i)).collect()
    });
    let [offset, gain, offset_slope, gain_slope] = fit.lights[layer].levels;
    let light = LayerLight { offset, gain, offset_slope, gain_slope, step: fit.lights[layer].step };
    let counts = |pixel: usize| !is_limited(line[pixel]) && light.step != Some(pixel);
    let pixel = |(pixel, ink): (usize, Ink)| {
        let gain = light.gain_at(&window, pixel);
        let residual = f64::from(line[pixel]) - light.white_at(&window, pixel) - gain * ink.ink;
        let bend = std::array::from_fn(|i| bends[i][pixel - window.first]);
        Pixel { residual, gain, lambda: window.lambda(pixel, &light), ink, bend }
    };
    (window.first..).zip(here).filter(|&(pixel, _)| counts(pixel)).map(pixel).collect()
}

fn imaging(fit: &FitTrace) -> Imaging {
    let homography = Homography { a: fit.homography.a, s: fit.homography.s, k: fit.homography.k };
    Imaging { homography, blur: fit.blur }
}

/// How far the parameter `i` is moved.
fn size(imaging: &Imaging, i: usize) -> f64 {
    if i == 2 { MOVE / imaging.homography.s } else { MOVE }
}

fn moved(imaging: &Imaging, i: usize) -> Imaging {
    let mut moved = *imaging;
    let Homography { a, s, k } = &mut moved.homography;
    *[a, s, k, &mut moved.blur][i] += size(imaging, i);
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lockstep::Setting;
    use crate::port::{Cameras, Landmarks};
    use crate::scenes;
    use reference::crossing::CrossingRule;

    /// The sum of squares of a fit whose parameters are moved: a, s, k, blur, and both layers' own.
    fn squares(trial: &TrialTrace, fit: &FitTrace, by: &[f64], lines: [&[u8]; 2], camera: &Camera) -> f64 {
        let (_, Ok(payload)) = trial.readings[0] else { panic!("not read") };
        let colours = codeword::layers(trial.format, payload).unwrap();
        let mut moved = *fit;
        (moved.homography.a, moved.homography.s) = (fit.homography.a + by[0], fit.homography.s + by[1]);
        (moved.homography.k, moved.blur) = (fit.homography.k + by[2], fit.blur + by[3]);
        for (light, own) in moved.lights.iter_mut().zip([4, 8]) {
            light.levels.iter_mut().zip(&by[own..]).for_each(|(level, by)| *level += by);
        }
        let residuals = [0, 1].map(|i| pixels(trial, &moved, i, &colours[i], lines[i], camera));
        residuals.iter().flatten().map(|pixel| pixel.residual * pixel.residual).sum()
    }

    /// `2 (A - S)` is the second difference of the sum of squares, along each parameter and between two of them.
    #[test]
    fn the_hessian_is_that_of_the_sum_of_squares() {
        let camera = Camera::epuck();
        let setting = Setting {
            cameras: Cameras::new(camera).unwrap(),
            landmarks: Landmarks::both(),
            rule: CrossingRule::Interpolated,
        };
        // 40 cm, 45 degrees.
        let [upper, lower] = scenes::view(5, 0, 0xcc0d, 40, 45).render(&camera);
        let trace = setting.run_reference(&upper, &lower);
        let trial = trace.trials.iter().find(|trial| trial.accepted().is_some()).unwrap();
        // Beside the minimum the residuals are large, and S with them.
        let mut fit = *trial.fits[0].as_ref().unwrap();
        fit.homography.a += 0.2;
        let fit = &fit;
        let lines = [&upper[..], &lower[..]];
        let colours = codeword::layers(trial.format, 0xcc0d).unwrap();
        let (normal, curvature) = matrices(trial, fit, &colours, lines, &camera, COMMON);
        let mut expected = normal - &curvature;
        // The pixels' own, without what FIT-6 adds to them.
        for j in [4, 6, 7, 8, 10, 11] {
            expected[(j, j)] -= PRIOR;
        }
        let sizes = [1e-3, 1e-3, 3e-5, 1e-3, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1];
        for i in 0..12 {
            for j in 0..=i {
                let at = |one: f64, other: f64| {
                    let mut by = [0.0; 12];
                    by[i] += one * sizes[i];
                    by[j] += other * sizes[j];
                    squares(trial, fit, &by, lines, &camera)
                };
                let difference = (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / 8.0;
                let (found, scale) = (difference / (sizes[i] * sizes[j]), (expected[(i, i)] * expected[(j, j)]).sqrt());
                assert!((found - expected[(i, j)]).abs() < 2e-3 * scale, "{i} {j}: {found} {}", expected[(i, j)]);
            }
        }
        // Without S that would not hold.
        assert!((0..COMMON).any(|i| curvature[(i, i)].abs() > 0.02 * expected[(i, i)]), "{curvature}");
        let found = sensitivity(trial, lines, &camera).unwrap();
        assert!(found.softening <= found.rate && found.rate > 0.0 && found.rate < 0.5, "{found:?}");
    }
}
