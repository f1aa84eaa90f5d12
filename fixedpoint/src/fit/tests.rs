#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_possible_wrap)] // of numbers in range

use super::*;
use crate::formats::{FocalLength, Obliquity};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rand::{RngExt, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::PI;
use std::vec::Vec as List;

const PRINCIPAL: f64 = 319.5;

fn camera() -> Camera {
    Camera::new(640, Column::from_num(PRINCIPAL), FocalLength::from_num(640)).unwrap()
}

fn cumulative(z: f64) -> f64 {
    libm::erfc(-z / 2_f64.sqrt()) / 2.0
}

fn density(z: f64) -> f64 {
    (-z * z / 2.0).exp() / (2.0 * PI).sqrt()
}

/// Ink of a pixel at `z` from the principal column and its derivatives by a, s, k and σ (EDGE-1, EDGE-2).
fn ink(z: f64, [a, s, k, sigma]: [f64; 4], stripes: u32, format: Format) -> (f64, [f64; 4]) {
    let n = u32::from(format.stripes());
    let (mut sum, mut by) = (0.0, [0.0; 4]);
    for j in 0..=n {
        let colour = |stripe: Option<u32>| stripe.filter(|&j| j < n).map_or(0, |j| stripes >> (n - 1 - j) & 1);
        let sign = f64::from(colour(Some(j))) - f64::from(colour(j.checked_sub(1)));
        let t = 2.0 * f64::from(j) / f64::from(n) - 1.0;
        let x = (a + s * t) / (1.0 + k * t);
        let rho = |t: f64| t * cumulative(t / sigma) + sigma * density(t / sigma);
        let (right, left) = (z - x + 0.5, z - x - 0.5);
        sum += sign * (rho(right) - rho(left));
        let along = sign * (cumulative(right / sigma) - cumulative(left / sigma));
        by[0] -= along / (1.0 + k * t);
        by[1] -= along * t / (1.0 + k * t);
        by[2] += along * x * t / (1.0 + k * t);
        by[3] += sign * (density(right / sigma) - density(left / sigma));
    }
    (sum, by)
}

/// Solves `m x = r` by Gauss and Jordan; returns the solution and the inverse.
fn solved(m: &[List<f64>], r: &[f64]) -> (List<f64>, List<List<f64>>) {
    let n = r.len();
    let mut rows: List<List<f64>> = (0..n)
        .map(|i| {
            let mut row = m[i].clone();
            row.extend((0..n).map(|j| f64::from(u8::from(i == j))));
            row.push(r[i]);
            row
        })
        .collect();
    for pivot in 0..n {
        let largest = (pivot..n).max_by(|&i, &j| rows[i][pivot].abs().total_cmp(&rows[j][pivot].abs())).unwrap();
        rows.swap(pivot, largest);
        let scale = rows[pivot][pivot];
        rows[pivot].iter_mut().for_each(|value| *value /= scale);
        let row = rows[pivot].clone();
        for (i, other) in rows.iter_mut().enumerate() {
            if i != pivot {
                let factor = other[pivot];
                other.iter_mut().zip(&row).for_each(|(value, pivot)| *value -= factor * pivot);
            }
        }
    }
    (rows.iter().map(|row| row[2 * n]).collect(), rows.iter().map(|row| row[n..2 * n].to_vec()).collect())
}

/// A step to the specification's minimum.
struct Step {
    /// Where it leads: `a, s, k`.
    homography: [f64; 3],
    /// And the first layer's `o`, grey levels.
    white: f64,
    /// Of FIT-14, with what it is made of, at the step's beginning.
    covariance: [[f64; 3]; 3],
    variance: f64,
    /// Its length, by the limit of FIT-11: the root of what it lowers, so that 1 of it is a 15th of a standard deviation.
    length: f64,
}

/// All steps to the specification's minimum.
struct Minimum {
    taken: List<Step>,
    /// How many of them a fit takes (FIT-11).
    steps: usize,
}

/// A layer's window by FIT-1.
fn window(layer: &FitLayer<'_>, format: Format) -> (i32, i32) {
    let extent = i32::from(layer.last_pixel) - i32::from(layer.first_pixel) + 1;
    let margin = (2 * extent / i32::from(format.stripes())).min(4);
    let end = layer.line.len() as i32 - 1;
    ((i32::from(layer.first_pixel) - margin).max(0), (i32::from(layer.last_pixel) + margin).min(end))
}

/// Gauss-Newton over all parameters at once, from the start that FIT-7 says, until nothing moves.
fn minimum(layers: &[FitLayer<'_>], start: &Start, format: Format, steps: &[Option<u16>]) -> Option<Minimum> {
    let Homography { a, s, k } = start.homography;
    let mut parameters = std::vec![a.to_num(), s.to_num(), k.to_num(), start.blur.to_num::<f64>()];
    for layer in layers {
        let (first, last) = window(layer, format);
        let values = &layer.line[first as usize..=last as usize];
        let (darkest, brightest) = (*values.iter().min().unwrap(), *values.iter().max().unwrap());
        parameters.extend([f64::from(brightest), f64::from(darkest) - f64::from(brightest), 0.0, 0.0]);
    }
    let n = parameters.len();
    let begun = parameters.clone();
    let damping: f64 = (4..n).step_by(4).map(|own| begun[own + 1] * begun[own + 1] / 64.0).sum();
    let mut taken = List::new();
    for _ in 0..60 {
        let (mut matrix, mut right) = (std::vec![std::vec![0.0; n]; n], std::vec![0.0; n]);
        let (mut squares, mut count) = (0.0, 0);
        for (index, layer) in layers.iter().enumerate() {
            let (first, last) = window(layer, format);
            let own = 4 + 4 * index;
            for pixel in first..=last {
                let value = layer.line[pixel as usize];
                let step = steps[index].map(i32::from);
                if value == 0 || value == 255 || step == Some(pixel) {
                    continue;
                }
                let lambda = match step {
                    None => f64::from(2 * pixel - first - last) / f64::from(last - first),
                    Some(step) if pixel < step => -1.0,
                    Some(_) => 1.0,
                };
                let shared: [f64; 4] = parameters[..4].try_into().unwrap();
                let (c, by) = ink(f64::from(pixel) - PRINCIPAL, shared, layer.stripes, format);
                let light = &parameters[own..own + 4];
                let gain = light[1] + lambda * light[3];
                let residual = f64::from(value) - light[0] - lambda * light[2] - gain * c;
                let mut derivative = std::vec![0.0; n];
                (0..4).for_each(|i| derivative[i] = gain * by[i]);
                derivative[own..own + 4].copy_from_slice(&[1.0, c, lambda, lambda * c]);
                for i in 0..n {
                    right[i] += derivative[i] * residual;
                    (0..n).for_each(|j| matrix[i][j] += derivative[i] * derivative[j]);
                }
                squares += residual * residual;
                count += 1;
            }
        }
        for own in (4..n).step_by(4) {
            for i in [own, own + 2, own + 3] {
                matrix[i][i] += 1.0 / 256.0;
                right[i] -= (parameters[i] - begun[i]) / 256.0;
            }
        }
        let (_, inverse) = solved(&matrix, &right);
        let mut damped = matrix.clone();
        damped[3][3] += damping;
        let (mut change, _) = solved(&damped, &right);
        let variance = f64::max(squares / f64::from(count - n as i32), 0.25);
        // The layers' own parameters, for a given change of the common ones.
        let own = |common: &[f64]| {
            let block: List<List<f64>> = matrix[4..].iter().map(|row| row[4..].to_vec()).collect();
            let rest: List<f64> = (4..n)
                .map(|i| right[i] - common.iter().zip(&matrix[i]).map(|(change, entry)| change * entry).sum::<f64>())
                .collect();
            solved(&block, &rest).0
        };
        let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
        let pulled: List<f64> = matrix.iter().map(|row| dot(row, &change)).collect();
        let lowered = 225.0 * (2.0 * dot(&right, &change) - dot(&pulled, &change));
        let far = [change[0], change[1], change[2] / 0.1, change[3] / 0.2]
            .iter()
            .fold(1.0_f64, |far, part| far.max(part.abs()));
        if !far.is_finite() {
            return None;
        }
        for change in &mut change {
            *change /= far;
        }
        let follow = own(&change[..4]);
        change[4..].copy_from_slice(&follow);
        parameters.iter_mut().zip(&change).for_each(|(parameter, change)| *parameter += change);
        taken.push(Step {
            homography: [parameters[0], parameters[1], parameters[2]],
            white: parameters[4],
            covariance: core::array::from_fn(|i| core::array::from_fn(|j| inverse[i][j] * variance)),
            variance,
            length: (lowered / variance).sqrt(),
        });
        if !(0.2..=1.2).contains(&parameters[3]) {
            return None;
        }
        if change[0].abs() < 1e-7 && change[3].abs() < 1e-7 {
            let steps = 1 + taken.iter().position(|step| step.length <= 1.0)?;
            return Some(Minimum { taken, steps });
        }
    }
    None
}

fn gauss(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// A view of both layers of a barcode.
#[derive(Clone, Debug)]
struct View {
    format: Format,
    truth: List<f64>,
    lines: [List<u8>; 2],
    stripes: [u32; 2],
    ends: (u16, u16),
    start: Start,
}

impl View {
    /// A view by the model of the specification, its noise rounded and limited (RENDER-5), and a start up to a quarter of a
    /// stripe off. `None` if it does not fit in the line.
    fn new(format: Format, homography: [f64; 4], contrast: f64, slope: f64, noise: f64, seed: u64) -> Option<Self> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let stripes =
            [(); 2].map(|()| stripes(format, random.random::<u16>() & ((1_u32 << format.code_stripes()) - 1) as u16));
        let white = 40.0 + contrast + slope.abs();
        let mut truth = homography.to_vec();
        truth.extend([white, -contrast, slope, -slope * contrast / white].repeat(2));
        let [a, s, k, _] = homography;
        let (left, right) = ((a - s) / (1.0 - k) + PRINCIPAL, (a + s) / (1.0 + k) + PRINCIPAL);
        if left < 8.0 || right > 631.0 || s - a * k <= 0.0 {
            return None;
        }
        let ends = ((left + 0.5).round() as u16, (right - 0.5).round() as u16);
        let mut view = Self {
            format,
            truth,
            lines: [List::new(), List::new()],
            stripes,
            ends,
            start: Start::at(&Homography { a: Column::ZERO, s: Column::ZERO, k: Obliquity::ZERO }),
        };
        let windows = view.layers().map(|layer| (layer.first_pixel, layer.last_pixel));
        assert_eq!(windows[0], windows[1]);
        for (index, &stripes) in stripes.iter().enumerate() {
            let line = (0..640_i32).map(|pixel| {
                let lambda = (2.0 * f64::from(pixel) - left - right) / (right - left);
                let (c, _) = ink(f64::from(pixel) - PRINCIPAL, homography, stripes, format);
                let grey = white + lambda * slope + (-contrast - lambda * slope * contrast / white) * c;
                let disturbed = grey + noise * gauss(&mut random);
                disturbed.round().clamp(0.0, 255.0) as u8
            });
            view.lines[index] = line.collect();
        }
        // The middle moves by up to 0.1 stripes, the ends by 0.1 and by 0.05 more in opposite ways.
        let stripe = 2.0 * s / f64::from(format.stripes());
        let mut part = |share: f64| random.random_range(-share..share) * stripe;
        let origin = f64::midpoint(left, right) - PRINCIPAL;
        let k_start = k + part(0.05) / s;
        let (a_start, s_start) = (a - origin + part(0.1), s - origin * k + part(0.1));
        view.start = Start::at(&Homography {
            a: Column::from_num(a_start + origin),
            s: Column::from_num(s_start + origin * k_start),
            k: Obliquity::from_num(k_start),
        });
        Some(view)
    }

    fn layers(&self) -> [FitLayer<'_>; 2] {
        core::array::from_fn(|index| FitLayer {
            line: &self.lines[index],
            first_pixel: self.ends.0,
            last_pixel: self.ends.1,
            stripes: self.stripes[index],
        })
    }
}

fn entries(covariance: &Covariance) -> [[f64; 3]; 3] {
    let Covariance { aa, as_, ak, ss, sk, kk } = *covariance;
    [[aa, as_, ak], [as_, ss, sk], [ak, sk, kk]].map(|row| row.map(|entry| entry as f64 / 2_f64.powi(50)))
}

impl Minimum {
    /// The step with which a fit has ended.
    fn last_of(&self, fitted: &Fitted) -> &Step {
        &self.taken[usize::from(fitted.steps).min(self.taken.len()) - 1]
    }

    /// Whether that step may be thought the last (FIT-11) where either end of a step is known to a share of the standard
    /// deviation.
    fn may_end_with(&self, fitted: &Fitted, share: f64) -> bool {
        let unsure = 15.0 * 2.0 * share;
        let before = self.taken.iter().take(usize::from(fitted.steps) - 1);
        self.last_of(fitted).length <= 1.0 + unsure
            && before.map(|step| step.length).all(|length| length >= 1.0 - unsure)
    }
}

/// The farthest of a, s, k in standard deviations, and of their covariance in geometric means of the variances, after as many
/// steps.
fn differences(fitted: &Fitted, minimum: &Minimum) -> (f64, f64) {
    let expected = minimum.last_of(fitted);
    let found = [fitted.homography.a.to_num(), fitted.homography.s.to_num(), fitted.homography.k.to_num::<f64>()];
    let deviation = |i: usize| expected.covariance[i][i].sqrt();
    let off = (0..3).map(|i| (found[i] - expected.homography[i]).abs() / deviation(i)).fold(0.0, f64::max);
    let entries = entries(&fitted.covariance);
    let entry = |i: usize, j: usize| (entries[i][j] - expected.covariance[i][j]).abs() / (deviation(i) * deviation(j));
    let wrong = (0..9).map(|place| entry(place / 3, place % 3)).fold(0.0, f64::max);
    (off, wrong)
}

fn views() -> impl Strategy<Value = View> {
    let format = prop_oneof![Just(Format::Paper), Just(Format::Wide)];
    let homography = (-180.0..180.0_f64, 12_f64.ln()..100_f64.ln(), -1.7..1.7_f64, 0.3..0.8_f64);
    (format, homography, 30_f64.ln()..160_f64.ln(), -20.0..20.0_f64, 0.0..8_f64.ln(), any::<u64>()).prop_filter_map(
        "outside of the line or too small",
        |(format, (a, s, tangent, blur), contrast, slope, noise, seed)| {
            let s = s.exp();
            // HYPO-11: 1.25 px per stripe.
            if s < 0.625 * f64::from(format.stripes()) {
                return None;
            }
            let k = tangent * s / 640.0;
            View::new(format, [a, s, k, blur], contrast.exp(), slope, noise.exp(), seed)
        },
    )
}

/// The sum of squares of FIT-15 for every pixel of a window that may part it.
fn partings(layer: &FitLayer<'_>, start: &Start, format: Format) -> List<(u16, f64)> {
    let (first, last) = window(layer, format);
    let values = &layer.line[first as usize..=last as usize];
    let gain = f64::from(*values.iter().min().unwrap()) - f64::from(*values.iter().max().unwrap());
    let Homography { a, s, k } = start.homography;
    let shared = [a.to_num(), s.to_num(), k.to_num(), start.blur.to_num()];
    let inks: List<f64> =
        (first..=last).map(|pixel| ink(f64::from(pixel) - PRINCIPAL, shared, layer.stripes, format).0).collect();
    // o and g of one side from 2 x 2 equations, the pull on g an observation of its own.
    let side = |range: core::ops::Range<usize>| {
        let used = || range.clone().filter(|&i| values[i] != 0 && values[i] != 255);
        let sum = |term: &dyn Fn(usize) -> f64| used().map(term).sum::<f64>();
        let (n, c, cc) = (sum(&|_| 1.0), sum(&|i| inks[i]), sum(&|i| inks[i] * inks[i]) + 1.0 / 16.0);
        let (y, cy) = (sum(&|i| f64::from(values[i])), sum(&|i| inks[i] * f64::from(values[i])) + gain / 16.0);
        if n == 0.0 {
            return 0.0;
        }
        let (o, g) = ((y * cc - c * cy) / (n * cc - c * c), (n * cy - c * y) / (n * cc - c * c));
        sum(&|i| (f64::from(values[i]) - o - g * inks[i]).powi(2)) + (g - gain).powi(2) / 16.0
    };
    let count = values.len();
    (1..count - 1).map(|m| (first as u16 + m as u16, side(0..m) + side(m + 1..count))).collect()
}

/// How far a fit may be from the oracle's after as many steps, in standard deviations.
const CLAIMED: f64 = 0.02;

/// Asserts that a fit is the oracle's, by shares of the standard deviations; both may fail to converge.
fn assert_fitted(
    view: &View,
    layers: &[FitLayer<'_>],
    illumination: Illumination,
    steps: &[Option<u16>],
) -> Result<(), TestCaseError> {
    let expected = minimum(layers, &view.start, view.format, steps);
    let fitted = fit(layers, &view.start, &camera(), view.format, illumination);
    let (Some(minimum), Ok(fitted)) = (&expected, &fitted) else {
        // At a limit of σ, or with the 10th step or a later one; where both disagree it is about a step.
        prop_assert!(expected.is_none_or(|minimum| minimum.steps >= 9), "{:?} of {:?}", fitted, view);
        return Ok(());
    };
    let (off, wrong) = differences(fitted, minimum);
    prop_assert!(off < CLAIMED, "by {} standard deviations: {:?} of {:?}", off, fitted, view);
    prop_assert!(wrong < 0.02, "a covariance by {}: {:?} of {:?}", wrong, fitted, view);
    prop_assert!(minimum.may_end_with(fitted, CLAIMED), "{} steps, {}", fitted.steps, minimum.steps);
    // An error of 0.015 grey levels of the residuals (the ink's 7e-5 of 160 grey levels, and roundings), independent of a
    // noise of 1, is 3e-3 of 100 squares.
    let (variance, expected) = (f64::from(fitted.variance) / 65_536.0, minimum.last_of(fitted).variance);
    prop_assert!((variance / expected - 1.0).abs() < 4e-3, "{} {}", variance, expected);
    Ok(())
}

fn config() -> ProptestConfig {
    let cases = if std::env::var_os("BARLOC_SURVEY").is_some() { 3000 } else { 300 };
    let rng_seed = RngSeed::Fixed(20_130_102);
    ProptestConfig {
        cases,
        rng_seed,
        max_global_rejects: 100_000,
        max_local_rejects: 1_000_000,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-1** The window of a layer MUST be the pixels from `first - P` to `last + P` within the line, with `P =
    //# min(4, floor(2 e/N))` and `e` the ROI's extent.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-2** The model of pixel `i` MUST be `o + g c_i + λ_i (o' + g' c_i)` with its ink `c_i` (EDGE-2).
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-3** Under even light `λ_i` MUST be `(2 i - l - r)/(r - l)`, with `l` and `r` the window's first and last
    //# pixel.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-6** The estimate MUST be the minimum, over all parameters, that Gauss-Newton steps lead to, of the sum
    //# of the squared differences between the pixels of all layers and their model, and of `(o - o_0)²/256`, `o'²/256`
    //# and `g'²/256` for each layer, `o_0` being FIT-7's `o`.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-7** The start MUST be the given `(a, s, k)`, σ = 1/2, and for each layer the largest value of its window
    //# as `o`, the smallest less the largest as `g`, and 0 as `o'` and `g'`.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-8** A step `(Δa, Δs, Δk, Δσ)` MUST be the solution of FIT-6's normal equations from which each layer's
    //# own parameters have been eliminated, with a 64th of the square of FIT-7's `g` of each layer added to the
    //# diagonal for σ.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-9** A step MUST be shortened as a whole until `|Δa|` and `|Δs|` are at most 1 px, `|Δk|` at most 0.1 and
    //# `|Δσ|` at most 0.2 px, before the layers' own steps follow from it.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-11** With `s² = max(SSE/(n - p), 1/4)`, SSE the sum over the pixels alone, n pixels, `p = 4 + 4` per
    //# layer, the fit MUST have converged when a step, before it is shortened, lowers FIT-6's sum of the linearised
    //# model by at most `s²/225`; that step is the last one.
    #[test]
    fn a_fit_is_the_minimum(view in views()) {
        assert_fitted(&view, &view.layers(), Illumination::Even, &[None, None])?;
        // One layer says half as much; of 10 degrees of freedom too little for two paths to the minimum to stay together.
        if view.ends.1 - view.ends.0 >= 48 {
            assert_fitted(&view, &view.layers()[1..], Illumination::Even, &[None])?;
        }
    }

    /// A shadow over the right part of the lower layer (RENDER-4): half of the light.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-4** Under a step of light `λ_i` MUST be -1 to the left and 1 to the right of the pixel `m` of the
    //# layer's step, which is left out.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-15** The pixel `m` of a layer's step of light MUST be the one for which the model without λ, fitted to
    //# either side of it alone, leaves the smallest sum of squares, `c_i` being those of the start, `g` of either side
    //# being drawn towards its start by adding `(g - g_0)²/16` to the sum; the left-most of equals, among those with at
    //# least one pixel of the window on either side.
    #[test]
    fn a_step_of_light_is_found(view in views(), place in -0.02..1.02_f64) {
        let mut view = view;
        prop_assume!(view.ends.1 - view.ends.0 > 60 && view.truth[5] < -60.0);
        let edge = view.ends.0 + (f64::from(view.ends.1 - view.ends.0) * place) as u16;
        for value in &mut view.lines[1][usize::from(edge)..] {
            *value = (f64::from(*value) * 0.5).round().max(1.0) as u8;
        }
        let layers = view.layers();
        let fitted = fit(&layers, &view.start, &camera(), view.format, Illumination::Step);
        prop_assume!(fitted.is_ok());
        let fitted = fitted.unwrap();
        let found = fitted.lights[1].step.unwrap();
        let costs = partings(&layers[1], &view.start, view.format);
        let least = costs.iter().map(|&(_, cost)| cost).fold(f64::INFINITY, f64::min);
        let cost = costs.iter().find(|&&(pixel, _)| pixel == found).unwrap().1;
        prop_assert!(cost <= least * 1.001 + 1.0, "{} for {}: {} {}", found, edge, cost, least);
        let steps: List<_> = fitted.lights.iter().map(|light| light.step).collect();
        assert_fitted(&view, &layers, Illumination::Step, &steps)?;
    }

    /// TRELLIS-1 to TRELLIS-3: the guards alone tell the homography, whatever the code.
    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-3** The guard fit MUST end as FIT-11 says or with its 12th step, with 2^-8 added to the diagonal for
    //# each layer's `g`, which counts as if FIT-6 had added it, and be refused as FIT-12, with `n < p + 8`, and FIT-13
    //# otherwise say.
    #[test]
    fn guards_are_fitted_without_the_code(view in views()) {
        let blank = view.layers().map(|layer| FitLayer { stripes: stripes(view.format, 0), ..layer });
        let Ok(fitted) = fit_guards(&blank, &view.start, &camera(), view.format) else { return Ok(()) };
        prop_assert!(fitted.lights.iter().all(|light| light.offset_slope == 0 && light.gain_slope == 0));
        // The same lines with other codes in their middle.
        let mut other = view.clone();
        let (left, right) = hidden(&view);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for line in &mut other.lines {
            // The extremes of the window, FIT-7's start, stay.
            let middle = &mut line[left..=right];
            middle.reverse();
            let _: u8 = random.random();
        }
        let layers = other.layers().map(|layer| FitLayer { stripes: stripes(view.format, 0), ..layer });
        prop_assert_eq!(Ok(fitted), fit_guards(&layers, &view.start, &camera(), view.format));
    }
}

/// White of 300 grey levels that is limited to 255 in every pixel: what `FIT-6` says of it is then a part of the estimate.
#[test]
fn white_that_no_pixel_measures_has_a_hint() {
    for seed in 0..10 {
        let view = View::new(Format::Paper, [20.0, 18.0, 0.02, 0.5], 260.0, 0.0, 1.0, seed).unwrap();
        let even = Illumination::Even;
        let fitted = fit(&view.layers(), &view.start, &camera(), view.format, even).unwrap();
        assert!(fitted.lights.iter().all(|light| light.offset > 280 << 8), "{fitted:?}");
        assert_fitted(&view, &view.layers(), even, &[None, None]).unwrap();
        let expected = minimum(&view.layers(), &view.start, view.format, &[None, None]).unwrap();
        let (found, white) = (f64::from(fitted.lights[0].offset) / 256.0, expected.last_of(&fitted).white);
        // Rounding may move it by 0.5 % of its deviation, which a weight of 2^-8 and a noise of 1 leave at 16 grey levels: 0.08.
        assert!((found - white).abs() < 0.05, "{found} {white}");
    }
}

/// `FIT-13` and `TRELLIS-3`: of views in which pixels tell little, and from up to 1.5 px away, no fit takes more than 9
/// steps, and guard fits take up to 12.
#[test]
fn fits_take_nine_steps_and_guard_fits_twelve() {
    let (mut steps, mut guards) = ([0; 16], [0; 16]);
    for seed in 0..300 {
        let view = View::new(Format::Wide, [20.0, 24.0, 0.02, 0.7], 300.0, 0.0, 3.0, seed).unwrap();
        let blank = view.layers().map(|layer| FitLayer { stripes: stripes(view.format, 0), ..layer });
        let Homography { a, .. } = view.start.homography;
        let far = Homography { a: a + Column::from_num(seed) / 200, ..view.start.homography };
        for (fitted, counts) in [
            (fit(&view.layers(), &Start::at(&far), &camera(), view.format, Illumination::Even), &mut steps),
            (fit_guards(&blank, &view.start, &camera(), view.format), &mut guards),
        ] {
            if let Ok(fitted) = fitted {
                counts[usize::from(fitted.steps)] += 1;
            }
        }
    }
    assert!(steps[8..=9].iter().sum::<i32>() > 0 && steps[10..].iter().sum::<i32>() == 0, "{steps:?}");
    assert!(guards[12] > 0 && guards[13..].iter().sum::<i32>() == 0, "{guards:?}");
}

/// The pixels between the outer edges of the code by the start, widened by 3/2 px (TRELLIS-2).
fn hidden(view: &View) -> (usize, usize) {
    let Homography { a, s, k } = view.start.homography;
    let share = f64::from(view.format.code_stripes()) / f64::from(view.format.stripes());
    let column = |t: f64| (a.to_num::<f64>() + s.to_num::<f64>() * t) / (1.0 + k.to_num::<f64>() * t) + PRINCIPAL;
    ((column(-share) - 1.5).ceil() as usize, (column(share) + 1.5).floor() as usize)
}

/// The largest differences of many views, for the error budget: `BARLOC_SURVEY=1 cargo test -p barloc-fixedpoint survey`.
#[test]
fn survey() {
    use proptest::strategy::ValueTree as _;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let (mut list, mut steps) = (List::new(), [0; 10]);
    for _ in 0..if std::env::var_os("BARLOC_SURVEY").is_some() { 4000 } else { 100 } {
        let view = views().new_tree(&mut runner).unwrap().current();
        let layers = view.layers();
        let Some(minimum) = minimum(&layers, &view.start, view.format, &[None, None]) else { continue };
        if let Ok(fitted) = fit(&layers, &view.start, &camera(), view.format, Illumination::Even) {
            list.push(differences(&fitted, &minimum));
            steps[usize::from(fitted.steps)] += 1;
        }
    }
    let mut sorted = |by: fn(&(f64, f64)) -> f64| {
        list.sort_by(|one, other| by(one).total_cmp(&by(other)));
        [list.len() / 2, list.len() * 95 / 100, list.len() - 1].map(|place| by(&list[place]))
    };
    let (off, wrong) = (sorted(|pair| pair.0), sorted(|pair| pair.1));
    std::println!("median, 95 %, largest: {off:?} of a standard deviation; {wrong:?} of a covariance; steps {steps:?}");
    assert!(off[1] < 0.01 && wrong[1] < 0.01);
}

//= reference/SPEC.md#fit
//= type=test
//# - **FIT-5** Pixels of the value 0 or 255 MUST be left out, since RENDER-5 limits them.
//= reference/SPEC.md#fit
//= type=test
//# - **FIT-12** A fit MUST be refused (`TooFewPixels`) if `n < 3 p`, or if the values of a layer's pixels that are not
//# left out all lie within less than 12 grey levels.
//= reference/SPEC.md#fit
//= type=test
//# - **FIT-13** A fit MUST be refused (`NotConverged`) if it has not converged with its 9th step, if its equations are
//# not positive definite, or if a step leads to `|k| > 3/4`, to `s < N/4`, to columns that do not grow, `s <= a k`, or
//# to a light of `|o| + |o'|` or `|g| + |g'|` above 511 grey levels.
#[test]
fn what_cannot_be_fitted_is_refused() {
    let view = View::new(Format::Paper, [0.0, 40.0, 0.0, 0.5], 100.0, 0.0, 2.0, 1).unwrap();
    let fitted = |line: &[u8], first_pixel, last_pixel, start: &Start| {
        let layer = FitLayer { line, first_pixel, last_pixel, stripes: view.stripes[0] };
        fit(&[layer], start, &camera(), Format::Paper, Illumination::Even).map(|fitted| fitted.steps)
    };
    // Three times 8 parameters: 24 pixels count, 20 and a margin of 2; one that is limited is one less.
    let start = Start::at(&Homography { a: Column::ZERO, s: Column::from_num(10), k: Obliquity::ZERO });
    let mut line: List<u8> = (0..640_u32).map(|pixel| 100 + (pixel * 37 % 50) as u8).collect();
    assert_ne!(fitted(&line, 309, 328, &start), Err(FitRefusal::TooFewPixels));
    line[320] = 255;
    assert_eq!(fitted(&line, 309, 328, &start), Err(FitRefusal::TooFewPixels));
    assert_eq!(fitted(&[255; 640], 279, 360, &view.start), Err(FitRefusal::TooFewPixels));
    assert_eq!(fit(&[], &start, &camera(), Format::Paper, Illumination::Even), Err(FitRefusal::TooFewPixels));
    // A flat line has no gain: nothing tells where the edges are. 12 grey levels may.
    let stripes =
        |dark: u8| -> List<u8> { (0..640_u32).map(|pixel| if pixel / 8 % 2 == 0 { dark } else { 100 }).collect() };
    assert_eq!(fitted(&stripes(100), 279, 360, &view.start), Err(FitRefusal::TooFewPixels));
    assert_eq!(fitted(&stripes(89), 279, 360, &view.start), Err(FitRefusal::TooFewPixels));
    assert_ne!(fitted(&stripes(88), 279, 360, &view.start), Err(FitRefusal::TooFewPixels));
    assert!(fitted(&view.lines[0], view.ends.0, view.ends.1, &view.start).is_ok());
    let mirrored = Start::at(&Homography { s: Column::from_num(-40), ..view.start.homography });
    assert_eq!(fitted(&view.lines[0], view.ends.0, view.ends.1, &mirrored), Err(FitRefusal::NotConverged));
}

/// Six parameters and eight more: 14 pixels, beside the code and not limited.
#[test]
fn guards_need_fourteen_pixels() {
    let start = Start::at(&Homography { a: Column::ZERO, s: Column::from_num(20), k: Obliquity::ZERO });
    let fitted = |count: usize| {
        // Beside the code, of 12 px and 1.5 px more to either side of the middle, 319.5.
        let beside = (295..=344_usize).filter(|&pixel| (pixel as f64 - 319.5).abs() > 13.5);
        let mut line = std::vec![255_u8; 640];
        beside.take(count).for_each(|pixel| line[pixel] = 100 + (pixel * 37 % 50) as u8);
        let layer = FitLayer { line: &line, first_pixel: 299, last_pixel: 340, stripes: stripes(Format::Paper, 0) };
        fit_guards(&[layer], &start, &camera(), Format::Paper).map(|fitted| fitted.steps)
    };
    assert_eq!(fitted(13), Err(FitRefusal::TooFewPixels));
    assert_ne!(fitted(14), Err(FitRefusal::TooFewPixels));
}

/// `FIT-10`: of a sharper and of a more blurred image than a fit may have it stays at the limit, and finds the edges.
//= reference/SPEC.md#fit
//= type=test
//# - **FIT-10** A step that would take σ out of 0.2 to 1.2 px MUST, before FIT-9, be the one that takes it to that
//# limit and solves the equations for `a`, `s` and `k` there.
#[test]
fn the_blur_stays_within_its_limits() {
    for (blur, limit) in [(0.1, 0.2), (1.5, 1.2)] {
        let view = View::new(Format::Paper, [20.0, 50.0, 0.02, blur], 120.0, 0.0, 0.5, 3).unwrap();
        let fitted = fit(&view.layers(), &view.start, &camera(), view.format, Illumination::Even).unwrap();
        let off = |found: f64, truth: f64| (found - truth).abs();
        assert!(off(fitted.blur.to_num(), limit) <= 2_f64.powi(-20), "{}", fitted.blur);
        let Homography { a, s, k } = fitted.homography;
        assert!(off(a.to_num(), 20.0) < 0.05 && off(s.to_num(), 50.0) < 0.05 && off(k.to_num(), 0.02) < 2e-3);
    }
}

/// `TRELLIS-10`: gains of -60 allow 9 grey levels squared and 3600/9, 3600/16 and 3600/64 of them in the second, the third and
/// the fifth step, which is 409, 234 and 65.25; a gain above -12 gives up in every step.
//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-10** The guard fit MUST be refused if in the equations of its second, third or fifth step `s²` is more
//# than `9 + ḡ²/9`, `9 + ḡ²/16` or `9 + ḡ²/64`, `ḡ` being the mean of the gains that these equations start from, or if
//# in one of its steps `ḡ` is above -12.
#[test]
fn guard_fits_are_given_up_early() {
    let given_up = |step: u8, variance: f64, gain: f64| {
        let squares = (variance * 20.0 * 65536.0) as i64;
        no_guards(step, squares, 20, (2.0 * gain * 256.0) as i64)
    };
    for (step, limit) in [(2, 409.0), (3, 234.0), (5, 65.25)] {
        assert!(!given_up(step, limit, -60.0) && given_up(step, limit + 0.001, -60.0), "{step}");
    }
    assert!(!given_up(1, 1e6, -60.0) && !given_up(4, 1e6, -60.0));
    for step in 1..=5 {
        assert!(!given_up(step, 0.0, -12.0) && given_up(step, 0.0, -11.99) && given_up(step, 0.0, 60.0), "{step}");
    }
}

/// `FIT-11` asks for a step of `s²/225`, which without noise is not far from what the residuals are rounded to: with a noise
/// of 0.3 and rounding `s²` is 1/4 and the limit 1.1e-3, or 0.01 grey levels for each of 12 parameters. Rounding an ink of
/// 160 grey levels to 2^-14 is 0.003, and offsets to 2^-8 is 0.02 over 250 pixels.
#[test]
fn nearly_noise_free_lines_are_fitted() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (mut all, mut refused) = (0, 0);
    for seed in 0..200 {
        let format = if seed % 2 == 0 { Format::Paper } else { Format::Wide };
        let s = random.random_range(15_f64.ln()..100_f64.ln()).exp();
        let (a, k) = (random.random_range(-150.0..150.0), random.random_range(-1.0..1.0) * s / 640.0);
        let Some(view) = View::new(format, [a, s, k, 0.5], 160.0, 0.0, 0.3, seed) else { continue };
        let layers = view.layers();
        let expected = minimum(&layers, &view.start, format, &[None, None]);
        if expected.is_some_and(|minimum| minimum.steps <= 6) {
            all += 1;
            refused += u32::from(fit(&layers, &view.start, &camera(), format, Illumination::Even).is_err());
        }
    }
    assert!(all >= 150 && refused * 33 <= all, "{refused} of {all}");
}
