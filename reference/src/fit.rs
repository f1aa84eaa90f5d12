//! Least squares of the grey levels themselves: homography, blur, light (FIT).

use crate::camera::Camera;
use crate::edge;
use crate::homography::{Homography, coordinate};
use crate::landmark::Format;
use crate::refusal::FitRefusal;
use core::ops::RangeInclusive;
use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3, Vector4};

/// Blur at the start, pixels (FIT-7).
pub const START_BLUR: f64 = 0.5;

/// Blurs that a fit may find, pixels (FIT-10).
pub const BLURS: RangeInclusive<f64> = 0.2..=1.2;

/// The least by which the values of a layer's pixels differ, grey levels (FIT-12).
const MIN_SPREAD: u8 = 12;

/// The largest offset and gain of a light, grey levels (FIT-13).
const BRIGHTEST: f64 = 511.0;

/// The last step that may find a fit converged (FIT-13).
pub const MAX_STEPS: usize = 9;

/// Squared length, in standard deviations, of a step that ends a fit (FIT-11).
const CONVERGED: f64 = 1.0 / 225.0;

/// The least variance of a pixel, squared grey levels: half a grey level is lost to rounding (FIT-11).
pub const ROUNDING_VARIANCE: f64 = 1.0 / 4.0;

/// What a squared grey level weighs by which a light changes, or white differs from its start, pixels (FIT-6).
const PRIOR: f64 = 1.0 / 256.0;

/// What is added to the diagonal for the blur, by the square of a layer's contrast (FIT-8).
const BLUR_DAMPING: f64 = 1.0 / 64.0;

/// A layer as it was decoded.
#[derive(Clone, Copy, Debug)]
pub struct FitLayer<'a> {
    /// The scan line's grey values.
    pub line: &'a [u8],
    /// First pixel of the ROI.
    pub first_pixel: usize,
    /// Last pixel of the ROI.
    pub last_pixel: usize,
    /// The stripes from left to right, true for a bar.
    pub stripes: &'a [bool],
}

/// How the light changes along a layer (FIT-3, FIT-4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Illumination {
    /// Linearly.
    Even,
    /// At the edge of a shadow.
    Step,
}

/// The homography and the blur that a fit begins with or has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imaging {
    /// Columns relative to the principal one.
    pub homography: Homography,
    /// Standard deviation of the blur, pixels.
    pub blur: f64,
}

/// How grey a layer is: pixel `i` with the ink `c` has the value `o + g c + λ_i (o' + g' c)` (FIT-2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerLight {
    /// `o`, grey levels.
    pub offset: f64,
    /// `g`, grey levels.
    pub gain: f64,
    /// `o'`, grey levels.
    pub offset_slope: f64,
    /// `g'`, grey levels.
    pub gain_slope: f64,
    /// The pixel at which the light steps, if it does (FIT-4).
    pub step: Option<usize>,
}

impl LayerLight {
    fn own(&self) -> Vector4<f64> {
        Vector4::new(self.offset, self.gain, self.offset_slope, self.gain_slope)
    }

    /// `o + λ o'`, the grey level of white at a pixel of the window.
    #[must_use]
    pub fn white_at(&self, window: &Window, pixel: usize) -> f64 {
        self.offset + window.lambda(pixel, self) * self.offset_slope
    }

    /// `g + λ g'`, what ink changes at a pixel of the window, grey levels.
    #[must_use]
    pub fn gain_at(&self, window: &Window, pixel: usize) -> f64 {
        self.gain + window.lambda(pixel, self) * self.gain_slope
    }

    /// The model of a pixel of the window with some ink, grey levels (FIT-2).
    //= reference/SPEC.md#fit
    //# - **FIT-2** The model of pixel `i` MUST be `o + g c_i + λ_i (o' + g' c_i)` with its ink `c_i` (EDGE-2).
    #[must_use]
    pub fn model_at(&self, window: &Window, pixel: usize, ink: f64) -> f64 {
        self.white_at(window, pixel) + self.gain_at(window, pixel) * ink
    }

    /// FIT-13
    fn is_possible(&self) -> bool {
        let most = |level: f64, slope: f64| level.abs() + slope.abs();
        most(self.offset, self.offset_slope) <= BRIGHTEST && most(self.gain, self.gain_slope) <= BRIGHTEST
    }

    fn with(&self, own: &Vector4<f64>) -> Self {
        Self { offset: own[0], gain: own[1], offset_slope: own[2], gain_slope: own[3], step: self.step }
    }
}

/// Whether RENDER-5 may have limited a pixel's value (FIT-5).
#[must_use]
pub fn is_limited(value: u8) -> bool {
    matches!(value, 0 | 255)
}

/// How far a pixel's value is from a model, grey levels; beyond the limits of RENDER-5 it may be anything (TRELLIS-11).
//= reference/SPEC.md#trellis
//# - **TRELLIS-11** In TRELLIS-5 and ACCEPT-8 the model of a pixel of the value 255 MUST count as at most 255, and that
//# of one of the value 0 as at least 0, since RENDER-5 limits what is brighter or darker.
#[must_use]
pub fn difference(value: u8, model: f64) -> f64 {
    match value {
        u8::MAX => f64::from(value) - model.min(255.0),
        0 => -model.max(0.0),
        _ => f64::from(value) - model,
    }
}

/// Which pixels of a layer are fitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    /// First pixel (FIT-1).
    pub first: usize,
    /// Last pixel (FIT-1).
    pub last: usize,
    /// Pixels inside it that are left out (TRELLIS-2).
    pub gap: core::ops::Range<usize>,
}

impl Window {
    /// The window of an ROI (FIT-1).
    //= reference/SPEC.md#fit
    //# - **FIT-1** The window of a layer MUST be the pixels from `first - P` to `last + P` within the line, with `P =
    //# min(4, floor(2 e/N))` and `e` the ROI's extent.
    #[must_use]
    pub fn of(first_pixel: usize, last_pixel: usize, format: Format, width: usize) -> Self {
        let extent = last_pixel - first_pixel + 1;
        let pad = (2 * extent / format.stripes()).min(4);
        Self { first: first_pixel.saturating_sub(pad), last: (last_pixel + pad).min(width - 1), gap: 0..0 }
    }

    /// Whether a pixel is fitted (FIT-4, FIT-5, TRELLIS-2).
    //= reference/SPEC.md#fit
    //# - **FIT-5** Pixels of the value 0 or 255 MUST be left out, since RENDER-5 limits them.
    fn counts(&self, pixel: usize, value: u8, light: &LayerLight) -> bool {
        !is_limited(value) && !self.gap.contains(&pixel) && light.step != Some(pixel)
    }

    /// λ of a pixel (FIT-3, FIT-4).
    //= reference/SPEC.md#fit
    //# - **FIT-3** Under even light `λ_i` MUST be `(2 i - l - r)/(r - l)`, with `l` and `r` the window's first and last
    //# pixel.
    //= reference/SPEC.md#fit
    //# - **FIT-4** Under a step of light `λ_i` MUST be -1 to the left and 1 to the right of the pixel `m` of the
    //# layer's step, which is left out.
    #[must_use]
    pub fn lambda(&self, pixel: usize, light: &LayerLight) -> f64 {
        match light.step {
            Some(step) if pixel < step => -1.0,
            Some(_) => 1.0,
            None => ((2 * pixel) as f64 - (self.first + self.last) as f64) / (self.last - self.first) as f64,
        }
    }
}

/// What a fit has found.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Homography and blur.
    pub imaging: Imaging,
    /// Covariance of `(a, s, k)`, px and 1 (FIT-14).
    pub covariance: Matrix3<f64>,
    /// Variance of the blur, px², of the same inverse.
    pub blur_variance: f64,
    /// `s²`, the variance of a pixel about its model, squared grey levels (FIT-11).
    pub variance: f64,
    /// `n - p`.
    pub degrees_of_freedom: usize,
    /// Steps taken.
    pub steps: usize,
    /// What the last one lowered the sum of squares by, as a share of what FIT-11 allows.
    pub last_decrease: f64,
    /// The light of every layer.
    pub lights: Vec<LayerLight>,
    /// How far the model of a pixel is from placing a step of light elsewhere, grey levels: the smaller one of the layers
    /// (FIT-15); infinite under even light.
    pub step_slack: f64,
}

/// How a fit goes about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plan {
    /// Until it has converged, with all parameters of the light.
    Converge,
    /// The same of the guards, without λ (TRELLIS-1, TRELLIS-3).
    Guards,
}

impl Plan {
    fn own_parameters(self) -> usize {
        match self {
            Self::Converge => 4,
            Self::Guards => 2,
        }
    }

    /// The fewest pixels by which `p` parameters may be fitted (FIT-12, TRELLIS-3).
    fn least_pixels(self, parameters: usize) -> usize {
        match self {
            Self::Converge => 3 * parameters,
            Self::Guards => parameters + 8,
        }
    }

    /// The last step (FIT-13, TRELLIS-3).
    fn most_steps(self) -> usize {
        match self {
            Self::Converge => MAX_STEPS,
            Self::Guards => 12,
        }
    }

    /// What is added to the diagonal for a gain, pixels (TRELLIS-3).
    fn damping(self) -> f64 {
        match self {
            Self::Converge => 0.0,
            Self::Guards => 1.0 / 256.0,
        }
    }
}

/// A pixel of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ink {
    /// `c_i`.
    pub ink: f64,
    /// Its derivatives by `a`, `s`, `k` and the blur.
    pub gradient: Vector4<f64>,
}

/// The ink of the pixels `first..=last` of a layer (EDGE-2).
//= reference/SPEC.md#edge
//# - **EDGE-2** The ink of a pixel MUST be the sum of `c` over all edges of a layer from white to black less that over
//# all edges from black to white.
#[must_use]
pub fn inks(imaging: &Imaging, camera: &Camera, format: Format, stripes: &[bool], pixels: (usize, usize)) -> Vec<Ink> {
    let mut inks = vec![Ink::default(); pixels.1 - pixels.0 + 1];
    let h = &imaging.homography;
    let mut left = false;
    for (edge, &right) in (0..).zip(stripes.iter().chain(&[false])) {
        if left != right {
            let sign = if right { 1.0 } else { -1.0 };
            let t = coordinate(format, edge - i32::try_from(stripes.len() / 2).unwrap_or(0));
            let column = h.column(t);
            let depth = 1.0 / (1.0 + h.k * t);
            let by_h = Vector3::new(depth, t * depth, -t * column * depth);
            edge::responses(camera.principal_column + column, imaging.blur, pixels, |pixel, response| {
                let ink = &mut inks[pixel - pixels.0];
                ink.ink += sign * response.ink;
                ink.gradient += (by_h * (-sign * response.by_distance)).push(sign * response.by_blur);
            });
        }
        left = right;
    }
    inks
}

/// A fit under way.
struct Problem<'a> {
    camera: &'a Camera,
    format: Format,
    layers: &'a [FitLayer<'a>],
    windows: &'a [Window],
    plan: Plan,
    /// The light that each layer started with (FIT-7).
    starts: Vec<LayerLight>,
}

/// The normal equations at one point, a layer's own parameters eliminated (FIT-8).
struct Reduced {
    matrix: Matrix4<f64>,
    right: Vector4<f64>,
    /// For each layer `A_oo⁻¹ A_os` and `A_oo⁻¹ b_o`: its own step is the second less the first times the common step.
    back: Vec<(Matrix4<f64>, Vector4<f64>)>,
    /// SSE, that of the pixels alone.
    squares: f64,
    /// What is added to the diagonal for the blur (FIT-8).
    damping: f64,
    /// By how much the layers' own parameters alone lower FIT-6's sum.
    own_decrease: f64,
    pixels: usize,
}

/// A step of the parameters that the layers have in common.
struct Step {
    common: Vector4<f64>,
    /// By how much, before it is shortened, it lowers the sum of squares of the linearised model.
    decrease: f64,
}

impl Problem<'_> {
    /// The normal equations of all layers; `None` if a layer's own block is not positive definite.
    fn reduced(&self, imaging: &Imaging, lights: &[LayerLight]) -> Option<Reduced> {
        let mut sum = Reduced {
            matrix: Matrix4::zeros(),
            right: Vector4::zeros(),
            back: Vec::new(),
            squares: 0.0,
            damping: self.starts.iter().map(|start| BLUR_DAMPING * start.gain * start.gain).sum(),
            own_decrease: 0.0,
            pixels: 0,
        };
        for (((layer, window), light), start) in self.layers.iter().zip(self.windows).zip(lights).zip(&self.starts) {
            self.add((layer, window), (light, start), imaging, &mut sum)?;
        }
        Some(sum)
    }

    fn add(
        &self,
        (layer, window): (&FitLayer<'_>, &Window),
        (light, start): (&LayerLight, &LayerLight),
        imaging: &Imaging,
        sum: &mut Reduced,
    ) -> Option<()> {
        let mut normal = SMatrix::<f64, 8, 8>::zeros();
        let mut right = SVector::<f64, 8>::zeros();
        let inks = inks(imaging, self.camera, self.format, layer.stripes, (window.first, window.last));
        for (pixel, ink) in (window.first..).zip(&inks) {
            let value = layer.line[pixel];
            if !window.counts(pixel, value, light) {
                continue;
            }
            let lambda = if self.plan.own_parameters() == 4 { window.lambda(pixel, light) } else { 0.0 };
            let own = Vector4::new(1.0, ink.ink, lambda, lambda * ink.ink);
            let residual = f64::from(value) - own.dot(&light.own());
            let common = ink.gradient * (light.gain + lambda * light.gain_slope);
            let mut row = SVector::<f64, 8>::zeros();
            row.fixed_rows_mut::<4>(0).copy_from(&common);
            row.fixed_rows_mut::<4>(4).copy_from(&own);
            normal += row * row.transpose();
            right += row * residual;
            sum.squares += residual * residual;
            sum.pixels += 1;
        }
        //= reference/SPEC.md#fit
        //# - **FIT-8** A step `(Δa, Δs, Δk, Δσ)` MUST be the solution of FIT-6's normal equations from which each
        //# layer's own parameters have been eliminated, with a 64th of the square of FIT-7's `g` of each layer added to
        //# the diagonal for σ.
        let prior = Matrix4::from_diagonal(&Vector4::new(PRIOR, 0.0, PRIOR, PRIOR));
        let damping = Matrix4::from_diagonal(&Vector4::new(0.0, self.plan.damping(), 0.0, 0.0));
        let own = (normal.fixed_view::<4, 4>(4, 4) + prior + damping).cholesky()?;
        let coupling: Matrix4<f64> = normal.fixed_view::<4, 4>(4, 0).into_owned();
        let own_right: Vector4<f64> = right.fixed_rows::<4>(4) - prior * (light.own() - start.own());
        let (by_common, alone) = (own.solve(&coupling), own.solve(&own_right));
        sum.matrix += normal.fixed_view::<4, 4>(0, 0) - coupling.transpose() * by_common;
        sum.right += right.fixed_rows::<4>(0) - coupling.transpose() * alone;
        sum.own_decrease += own_right.dot(&alone);
        sum.back.push((by_common, alone));
        Some(())
    }

    /// Whether the pixels of every layer differ enough to be fitted (FIT-12).
    fn has_contrast(&self, lights: &[LayerLight]) -> bool {
        self.layers.iter().zip(self.windows).zip(lights).all(|((layer, window), light)| {
            let values = (window.first..=window.last).map(|pixel| (pixel, layer.line[pixel]));
            let values = values.filter(|&(pixel, value)| window.counts(pixel, value, light)).map(|(_, value)| value);
            let (least, most) = values.fold((u8::MAX, 0), |(least, most), value| (least.min(value), most.max(value)));
            most >= least.saturating_add(MIN_SPREAD)
        })
    }

    /// `n - p` if there are enough pixels (FIT-11, FIT-12).
    //= reference/SPEC.md#fit
    //# - **FIT-12** A fit MUST be refused (`TooFewPixels`) if `n < 3 p`, or if the values of a layer's pixels that are
    //# not left out all lie within less than 12 grey levels.
    fn degrees_of_freedom(&self, pixels: usize) -> Result<usize, FitRefusal> {
        let parameters = 4 + self.plan.own_parameters() * self.layers.len();
        if pixels < self.plan.least_pixels(parameters) {
            Err(FitRefusal::TooFewPixels)
        } else {
            Ok(pixels - parameters)
        }
    }
}

/// The Gauss-Newton step, shortened (FIT-8 to FIT-11); `None` if the equations are not positive definite.
//= reference/SPEC.md#fit
//# - **FIT-9** A step MUST be shortened as a whole until `|Δa|` and `|Δs|` are at most 1 px, `|Δk|` at most 0.1 and
//# `|Δσ|` at most 0.2 px, before the layers' own steps follow from it.
//= reference/SPEC.md#fit
//# - **FIT-10** A step that would take σ out of 0.2 to 1.2 px MUST, before FIT-9, be the one that takes it to that
//# limit and solves the equations for `a`, `s` and `k` there.
fn step(reduced: &Reduced, blur: f64) -> Option<Step> {
    let root = reduced.matrix.cholesky()?;
    // What the equations know of the blur when all others are free.
    let weight = 1.0 / root.inverse()[(3, 3)];
    let damped = root.solve(&reduced.right)[3] * weight / (weight + reduced.damping);
    let change = (blur + damped).clamp(*BLURS.start(), *BLURS.end()) - blur;
    let block: Matrix3<f64> = reduced.matrix.fixed_view::<3, 3>(0, 0).into_owned();
    let right = reduced.right.fixed_rows::<3>(0) - reduced.matrix.fixed_view::<3, 1>(0, 3) * change;
    let common = block.cholesky()?.solve(&right).push(change);
    let decrease = common.dot(&(2.0 * reduced.right - reduced.matrix * common));
    let limits = [1.0, 1.0, 0.1, 0.2];
    let shortened =
        common.iter().zip(limits).fold(1.0_f64, |share, (part, limit)| share.min(limit / part.abs().max(limit)));
    Some(Step { common: common * shortened, decrease })
}

/// FIT-13
//= reference/SPEC.md#fit
//# - **FIT-13** A fit MUST be refused (`NotConverged`) if it has not converged with its 9th step, if its equations are
//# not positive definite, or if a step leads to `|k| > 3/4`, to `s < N/4`, to columns that do not grow, `s <= a k`, or
//# to a light of `|o| + |o'|` or `|g| + |g'|` above 511 grey levels.
fn is_possible(homography: &Homography, format: Format) -> bool {
    let Homography { a, s, k } = *homography;
    k.abs() <= 0.75 && s >= format.stripes() as f64 / 4.0 && s > a * k
}

/// The light at the start (FIT-7).
//= reference/SPEC.md#fit
//# - **FIT-7** The start MUST be the given `(a, s, k)`, σ = 1/2, and for each layer the largest value of its window as
//# `o`, the smallest less the largest as `g`, and 0 as `o'` and `g'`.
fn first_light(layer: &FitLayer<'_>, window: &Window) -> LayerLight {
    let values = &layer.line[window.first..=window.last];
    let (darkest, brightest) =
        values.iter().fold((f64::INFINITY, 0.0_f64), |(d, b), &v| (d.min(f64::from(v)), b.max(f64::from(v))));
    LayerLight { offset: brightest, gain: darkest - brightest, offset_slope: 0.0, gain_slope: 0.0, step: None }
}

/// The fit of one or both layers of a landmark from `start` (FIT-1 to FIT-15).
//= reference/SPEC.md#fit
//# - **FIT-6** The estimate MUST be the minimum, over all parameters, that Gauss-Newton steps lead to, of the sum of
//# the squared differences between the pixels of all layers and their model, and of `(o - o_0)²/256`, `o'²/256` and
//# `g'²/256` for each layer, `o_0` being FIT-7's `o`.
//= reference/SPEC.md#fit
//# - **FIT-14** The covariance of `(a, s, k)` MUST be `s²` times that block of the inverse of the reduced normal
//# equations' matrix, at the last step.
pub fn fit(
    layers: &[FitLayer<'_>],
    start: &Imaging,
    illumination: Illumination,
    camera: &Camera,
    format: Format,
) -> Result<Fitted, FitRefusal> {
    let window = |layer: &FitLayer<'_>| Window::of(layer.first_pixel, layer.last_pixel, format, layer.line.len());
    let windows: Vec<Window> = layers.iter().map(window).collect();
    fit_windows(layers, &windows, start, illumination, Plan::Converge, camera, format)
}

/// The fit of the stated windows by a plan.
pub fn fit_windows(
    layers: &[FitLayer<'_>],
    windows: &[Window],
    start: &Imaging,
    illumination: Illumination,
    plan: Plan,
    camera: &Camera,
    format: Format,
) -> Result<Fitted, FitRefusal> {
    let mut step_slack = f64::INFINITY;
    let light = |(layer, window): (&FitLayer<'_>, &Window)| {
        let light = first_light(layer, window);
        if illumination == Illumination::Even {
            return light;
        }
        let (step, slack) = step_of_light(layer, window, &light, start, camera, format);
        step_slack = step_slack.min(slack);
        LayerLight { step: Some(step), ..light }
    };
    let mut lights: Vec<LayerLight> = layers.iter().zip(windows).map(light).collect();
    let problem = Problem { camera, format, layers, windows, plan, starts: lights.clone() };
    if !problem.has_contrast(&lights) {
        return Err(FitRefusal::TooFewPixels);
    }
    let mut imaging = *start;
    let mut last_decrease = f64::INFINITY;
    for steps in 1..=plan.most_steps() {
        let reduced = problem.reduced(&imaging, &lights).ok_or(FitRefusal::NotConverged)?;
        let degrees_of_freedom = problem.degrees_of_freedom(reduced.pixels)?;
        let variance = (reduced.squares / degrees_of_freedom as f64).max(ROUNDING_VARIANCE);
        if plan != Plan::Converge && !promises(steps, variance, &lights) {
            return Err(FitRefusal::NotConverged);
        }
        let step = step(&reduced, imaging.blur).ok_or(FitRefusal::NotConverged)?;
        imaging = moved(&imaging, &step.common);
        for (light, (by_common, alone)) in lights.iter_mut().zip(&reduced.back) {
            *light = light.with(&(light.own() + alone - by_common * step.common));
        }
        if !is_possible(&imaging.homography, format) || !lights.iter().all(LayerLight::is_possible) {
            return Err(FitRefusal::NotConverged);
        }
        last_decrease = share_of_limit(reduced.own_decrease + step.decrease, variance);
        let ends = last_decrease <= 1.0 || plan == Plan::Guards && steps == plan.most_steps();
        if ends {
            let inverse = reduced.matrix.try_inverse().ok_or(FitRefusal::NotConverged)?;
            let covariance = inverse.fixed_view::<3, 3>(0, 0) * variance;
            let blur_variance = inverse[(3, 3)] * variance;
            return Ok(Fitted {
                imaging,
                covariance,
                blur_variance,
                variance,
                degrees_of_freedom,
                steps,
                last_decrease,
                lights,
                step_slack,
            });
        }
    }
    Err(FitRefusal::Unfinished(last_decrease))
}

/// What a step lowers FIT-6's sum by, as a share of what FIT-11 allows.
//= reference/SPEC.md#fit
//# - **FIT-11** With `s² = max(SSE/(n - p), 1/4)`, SSE the sum over the pixels alone, n pixels, `p = 4 + 4` per layer,
//# the fit MUST have converged when a step, before it is shortened, lowers FIT-6's sum of the linearised model by at
//# most `s²/225`; that step is the last one.
fn share_of_limit(decrease: f64, variance: f64) -> f64 {
    decrease / (CONVERGED * variance)
}

/// Whether the guards have so far been explained as well as true ones are (TRELLIS-10).
//= reference/SPEC.md#trellis
//# - **TRELLIS-10** The guard fit MUST be refused if in the equations of its second, third or fifth step `s²` is more
//# than `9 + ḡ²/9`, `9 + ḡ²/16` or `9 + ḡ²/64`, `ḡ` being the mean of the gains that these equations start from, or if
//# in one of its steps `ḡ` is above -12.
fn promises(step: usize, variance: f64, lights: &[LayerLight]) -> bool {
    let gain = mean_gain(lights);
    let share = match step {
        2 => 9.0,
        3 => 16.0,
        5 => 64.0,
        _ => return gain <= -12.0,
    };
    gain <= -12.0 && variance <= gain * gain / share + 9.0
}

/// The mean gain of both layers, `ḡ`, grey levels.
#[must_use]
pub fn mean_gain(lights: &[LayerLight]) -> f64 {
    lights.iter().map(|light| light.gain).sum::<f64>() / lights.len() as f64
}

fn moved(imaging: &Imaging, step: &Vector4<f64>) -> Imaging {
    let Homography { a, s, k } = imaging.homography;
    let homography = Homography { a: a + step[0], s: s + step[1], k: k + step[2] };
    // The sum may exceed a limit by its own rounding.
    Imaging { homography, blur: (imaging.blur + step[3]).clamp(*BLURS.start(), *BLURS.end()) }
}

/// Sums over pixels of a straight line's least squares, value against ink.
#[derive(Clone, Copy, Default)]
struct Sums {
    n: f64,
    c: f64,
    cc: f64,
    v: f64,
    cv: f64,
    vv: f64,
}

impl Sums {
    fn add(&mut self, c: f64, v: f64, sign: f64) {
        self.n += sign;
        self.c += sign * c;
        self.cc += sign * c * c;
        self.v += sign * v;
        self.cv += sign * c * v;
        self.vv += sign * v * v;
    }

    /// The smallest sum of squares of `o + g c`, `g` drawn towards `gain` by a sixteenth of the squared difference.
    fn least_squares(&self, gain: f64) -> f64 {
        if self.n < 0.5 {
            return 0.0;
        }
        let centred = |product: f64, one: f64, other: f64| product - one * other / self.n;
        let cc = centred(self.cc, self.c, self.c) + 1.0 / 16.0;
        let cv = centred(self.cv, self.c, self.v) + gain / 16.0;
        let vv = centred(self.vv, self.v, self.v) + gain * gain / 16.0;
        vv - cv * cv / cc
    }
}

/// The pixel at which the light of a layer steps (FIT-15), and its slack in grey levels.
///
/// Between two places that leave about the same sum of squares, two residuals trade places. An error `ε` of the model changes
/// the difference of the sums by `2 sqrt(2) r ε`, `r` being the size of the residuals there: the slack is the `ε` that it takes.
//= reference/SPEC.md#fit
//# - **FIT-15** The pixel `m` of a layer's step of light MUST be the one for which the model without λ, fitted to
//# either side of it alone, leaves the smallest sum of squares, `c_i` being those of the start, `g` of either side
//# being drawn towards its start by adding `(g - g_0)²/16` to the sum; the left-most of equals, among those with at
//# least one pixel of the window on either side.
#[must_use]
pub fn step_of_light(
    layer: &FitLayer<'_>,
    window: &Window,
    light: &LayerLight,
    start: &Imaging,
    camera: &Camera,
    format: Format,
) -> (usize, f64) {
    let inks = inks(start, camera, format, layer.stripes, (window.first, window.last));
    let used = |pixel: usize| !is_limited(layer.line[pixel]);
    let mut right = Sums::default();
    let mut left = Sums::default();
    let pixels = || (window.first..).zip(&inks).map(|(pixel, ink)| (pixel, ink.ink, f64::from(layer.line[pixel])));
    for (_, ink, value) in pixels().filter(|&(pixel, ..)| used(pixel)) {
        right.add(ink, value, 1.0);
    }
    let (mut best, mut second) = ((f64::INFINITY, window.first), f64::INFINITY);
    for (pixel, ink, value) in pixels() {
        let counts = used(pixel);
        if counts {
            right.add(ink, value, -1.0);
        }
        let sum = left.least_squares(light.gain) + right.least_squares(light.gain);
        if pixel > window.first && pixel < window.last {
            second = second.min(sum.max(best.0));
            if sum < best.0 {
                best = (sum, pixel);
            }
        }
        if counts {
            left.add(ink, value, 1.0);
        }
    }
    let residual = (best.0 / inks.len() as f64).sqrt();
    (best.1, (second - best.0) / (8.0_f64.sqrt() * residual).max(f64::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bound::homography_of;
    use crate::codeword;
    use crate::frame::{self, Pose};
    use crate::landmark::Landmark;
    use crate::render::{Light, Patch, Posted, Scene, Sensor, render};
    use core::f64::consts::PI;
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const PAYLOAD: u32 = 0xcc0d;

    /// What was rendered, and its truth.
    struct Sight {
        lines: [Vec<u8>; 2],
        stripes: [Vec<bool>; 2],
        truth: Homography,
        ends: (usize, usize),
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "columns of the image")]
    fn sight(pose: (f64, f64, f64), light: Light, sensor: Sensor) -> Sight {
        let camera = Camera::epuck();
        let landmark = Landmark { stripe_height: 0.1, ..Landmark::new(Format::Paper) };
        let (x, y, theta) = pose;
        let camera_in_landmark: Pose<frame::Landmark, frame::Camera> = Pose::new(x, y, theta);
        let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload: PAYLOAD };
        let camera_in_world = Pose::new(x, y, theta);
        let scene = Scene { camera_in_world, landmarks: vec![posted], clutter: vec![], light, sensor };
        let lines = render(&camera, &scene, &mut ChaCha8Rng::seed_from_u64(7)).unwrap();
        let truth = homography_of(&camera, &landmark, &camera_in_landmark).unwrap();
        let end = |t: f64| (truth.column(t) + camera.principal_column + 0.5).floor() as usize;
        Sight { lines, stripes: codeword::layers(Format::Paper, PAYLOAD).unwrap(), truth, ends: (end(-1.0), end(1.0)) }
    }

    const CLEAR: Sensor = Sensor { blur: 0.6, noise: 0.5 };

    impl Sight {
        fn layers(&self) -> [FitLayer<'_>; 2] {
            [0, 1].map(|i| FitLayer {
                line: &self.lines[i],
                first_pixel: self.ends.0,
                last_pixel: self.ends.1,
                stripes: &self.stripes[i],
            })
        }

        fn fit(&self, start: Homography, illumination: Illumination) -> Result<Fitted, FitRefusal> {
            let start = Imaging { homography: start, blur: START_BLUR };
            fit(&self.layers(), &start, illumination, &Camera::epuck(), Format::Paper)
        }

        /// Largest error of an edge by a fit, pixels.
        fn error(&self, fitted: &Fitted) -> f64 {
            let found = &fitted.imaging.homography;
            (-10..=10)
                .map(|v| f64::from(v) / 10.0)
                .fold(0.0, |most, t| f64::max(most, (found.column(t) - self.truth.column(t)).abs()))
        }
    }

    proptest! {
        /// The stated basin: every edge of the guards within 0.4 stripes.
        //= reference/SPEC.md#edge
        //= type=test
        //# - **EDGE-2** The ink of a pixel MUST be the sum of `c` over all edges of a layer from white to black less
        //# that over all edges from black to white.
        #[test]
        fn the_minimum_is_found_from_within_two_fifths_of_a_stripe(
            distance in 0.12..0.5f64, polar in -1.0..1.0f64, left in -0.28..0.28f64, right in -0.28..0.28f64, bend in -0.1..0.1f64,
        ) {
            let sight = sight((distance * polar.cos(), distance * polar.sin(), PI + polar), Light::default(), CLEAR);
            let Homography { a, s, k } = sight.truth;
            // Moving the ends by parts of a stripe and the middle by a part of it moves a, s and k like this, about.
            let stripe = s / 10.0;
            let (shift, widen, bend) = (f64::midpoint(left, right) * stripe, (right - left) / 2.0 * stripe, bend * stripe);
            let start = Homography { a: a + shift + bend, s: s + widen, k: k + bend / s };
            let moved = |t: f64| (start.column(t) - sight.truth.column(t)).abs() / stripe;
            prop_assume!([-1.0, -0.7, 0.7, 1.0].into_iter().all(|t| moved(t) < 0.4));
            let fitted = sight.fit(start, Illumination::Even).unwrap();
            prop_assert!(sight.error(&fitted) < 0.02, "{}", sight.error(&fitted));
            prop_assert!((fitted.imaging.blur - 0.6).abs() < 0.02);
        }
    }

    /// From black to white: before anything is fitted a layer is taken to be evenly lit and its gain to be all of its contrast.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-7** The start MUST be the given `(a, s, k)`, σ = 1/2, and for each layer the largest value of its window
    //# as `o`, the smallest less the largest as `g`, and 0 as `o'` and `g'`.
    #[test]
    fn a_layer_s_light_starts_at_its_extremes() {
        let mut sight = sight((0.25, 0.05, PI + 0.3), Light::default(), CLEAR);
        let middle = usize::midpoint(sight.ends.0, sight.ends.1);
        (sight.lines[0][middle], sight.lines[0][middle + 1]) = (7, 251);
        // Outside of the window.
        (sight.lines[0][0], sight.lines[0][479]) = (0, 255);
        let layer = sight.layers()[0];
        let light = first_light(&layer, &Window::of(layer.first_pixel, layer.last_pixel, Format::Paper, 480));
        let even = LayerLight { offset: 251.0, gain: -244.0, offset_slope: 0.0, gain_slope: 0.0, step: None };
        assert_eq!((light, START_BLUR.to_bits()), (even, 0.5_f64.to_bits()));
    }

    /// Sharper and more blurred images than a fit may have: it stays at the limit, and the edges are where they are.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-10** A step that would take σ out of 0.2 to 1.2 px MUST, before FIT-9, be the one that takes it to that
    //# limit and solves the equations for `a`, `s` and `k` there.
    #[test]
    fn the_blur_stays_within_its_limits() {
        for (blur, limit) in [(0.05, 0.2), (1.6, 1.2)] {
            let sight = sight((0.2, 0.02, PI + 0.2), Light::default(), Sensor { blur, noise: 0.5 });
            let fitted = sight.fit(sight.truth, Illumination::Even).unwrap();
            assert!((fitted.imaging.blur - limit).abs() < 1e-12, "{blur}: {}", fitted.imaging.blur);
            assert!(sight.error(&fitted) < 0.05, "{blur}: {}", sight.error(&fitted));
        }
    }

    /// TRELLIS-10: gains of -60 allow 9 squared grey levels and 3600/9, 3600/16 and 3600/64 of them in the second, the third and
    /// the fifth step; a mean gain above -12 gives up in every step.
    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-10** The guard fit MUST be refused if in the equations of its second, third or fifth step `s²` is
    //# more than `9 + ḡ²/9`, `9 + ḡ²/16` or `9 + ḡ²/64`, `ḡ` being the mean of the gains that these equations start
    //# from, or if in one of its steps `ḡ` is above -12.
    #[test]
    fn guard_fits_are_given_up_early() {
        let go_on = |step: usize, variance: f64, gains: [f64; 2]| {
            let lights =
                gains.map(|gain| LayerLight { offset: 200.0, gain, offset_slope: 0.0, gain_slope: 0.0, step: None });
            promises(step, variance, &lights)
        };
        for (step, limit) in [(2, 409.0), (3, 234.0), (5, 65.25)] {
            assert!(go_on(step, limit, [-50.0, -70.0]) && !go_on(step, limit + 0.001, [-50.0, -70.0]), "{step}");
        }
        assert!(go_on(1, 1e6, [-60.0; 2]) && go_on(4, 1e6, [-60.0; 2]));
        for step in 1..=5 {
            assert!(go_on(step, 0.0, [-4.0, -20.0]) && !go_on(step, 0.0, [-3.9, -20.0]), "{step}");
        }
    }

    /// FIT-9: of equations whose solution is their right side, which is shortened as a whole by what is too far first.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-9** A step MUST be shortened as a whole until `|Δa|` and `|Δs|` are at most 1 px, `|Δk|` at most 0.1 and
    //# `|Δσ|` at most 0.2 px, before the layers' own steps follow from it.
    #[test]
    fn steps_are_shortened_as_a_whole() {
        let taken = |right: [f64; 4]| {
            let (back, right) = (Vec::new(), Vector4::from(right));
            let matrix = Matrix4::identity();
            step(&Reduced { matrix, right, back, squares: 0.0, damping: 0.0, own_decrease: 0.0, pixels: 0 }, 0.6)
                .unwrap()
                .common
        };
        let near = |right: [f64; 4], expected: [f64; 4]| (taken(right) - Vector4::from(expected)).amax() < 1e-12;
        assert!(near([0.9, -0.9, 0.09, 0.19], [0.9, -0.9, 0.09, 0.19]));
        assert!(near([-4.0, 2.0, 0.2, 0.4], [-1.0, 0.5, 0.05, 0.1]));
        assert!(near([1.0, -2.0, 0.0, 0.0], [0.5, -1.0, 0.0, 0.0]));
        assert!(near([1.0, 0.0, -0.4, 0.0], [0.25, 0.0, -0.1, 0.0]));
        assert!(near([1.0, 0.0, 0.0, -0.4], [0.5, 0.0, 0.0, -0.2]));
    }

    /// FIT-8: of equations in which `a` and the blur share half of what they know, 3/4 is left for the blur alone; as much is
    /// added, which halves its step, and `a` is what solves its own equation there.
    #[test]
    fn steps_of_the_blur_are_damped() {
        let mut matrix = Matrix4::identity();
        (matrix[(0, 3)], matrix[(3, 0)]) = (0.5, 0.5);
        let right = Vector4::new(0.1, 0.0, 0.0, 0.11);
        let reduced = |damping: f64| Reduced {
            matrix,
            right,
            back: Vec::new(),
            squares: 0.0,
            damping,
            own_decrease: 0.0,
            pixels: 0,
        };
        let free = step(&reduced(0.0), 0.6).unwrap();
        let damped = step(&reduced(0.75), 0.6).unwrap();
        // (0.11 - 0.1/2)/(3/4) is 0.08.
        assert!((free.common - Vector4::new(0.06, 0.0, 0.0, 0.08)).amax() < 1e-12, "{}", free.common);
        assert!((damped.common - Vector4::new(0.08, 0.0, 0.0, 0.04)).amax() < 1e-12, "{}", damped.common);
        // Half of the way leaves a quarter of the blur's 3/4 0.08².
        assert!((free.decrease - damped.decrease - 0.75 * 0.04 * 0.04).abs() < 1e-12);
    }

    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-11** With `s² = max(SSE/(n - p), 1/4)`, SSE the sum over the pixels alone, n pixels, `p = 4 + 4` per
    //# layer, the fit MUST have converged when a step, before it is shortened, lowers FIT-6's sum of the linearised
    //# model by at most `s²/225`; that step is the last one.
    #[test]
    fn a_fit_has_converged_when_little_is_left_to_gain() {
        assert!(share_of_limit(3.999 / 225.0, 4.0) < 1.0 && share_of_limit(4.001 / 225.0, 4.0) > 1.0);
    }

    /// FIT-6's sum for parameters that are moved: a, s, k, blur, and each layer's o, g, o' and g'.
    fn sum_of_squares(sight: &Sight, fitted: &Fitted, moved: &[f64]) -> f64 {
        let Homography { a, s, k } = fitted.imaging.homography;
        let homography = Homography { a: a + moved[0], s: s + moved[1], k: k + moved[2] };
        let imaging = Imaging { homography, blur: fitted.imaging.blur + moved[3] };
        let of_layer = |(i, layer): (usize, &FitLayer<'_>)| {
            let window = Window::of(layer.first_pixel, layer.last_pixel, Format::Paper, 480);
            let by = Vector4::from_column_slice(&moved[4 + 4 * i..8 + 4 * i]);
            let light = fitted.lights[i].with(&(fitted.lights[i].own() + by));
            let inks = inks(&imaging, &Camera::epuck(), Format::Paper, layer.stripes, (window.first, window.last));
            let square = |(pixel, ink): (usize, &Ink)| {
                let value = layer.line[pixel];
                let difference = f64::from(value) - light.model_at(&window, pixel, ink.ink);
                if window.counts(pixel, value, &light) { difference.powi(2) } else { 0.0 }
            };
            let pixels: f64 = (window.first..).zip(&inks).map(square).sum();
            let start = first_light(layer, &window);
            let prior = (light.offset - start.offset).powi(2) + light.offset_slope.powi(2) + light.gain_slope.powi(2);
            pixels + prior / 256.0
        };
        sight.layers().iter().enumerate().map(of_layer).sum()
    }

    /// How far each parameter is from the sum's minimum along it, in the standard deviations that it has if the others are known.
    fn still_to_go(sight: &Sight, fitted: &Fitted) -> Vec<f64> {
        let scale = |i: usize| if i == 2 { 1e-5 } else { 1e-3 };
        let along = |i: usize| {
            let mut moved = vec![0.0; 12];
            let mut at = |by: f64| {
                moved[i] = by * scale(i);
                sum_of_squares(sight, fitted, &moved)
            };
            let (before, here, after) = (at(-1.0), at(0.0), at(1.0));
            // By the sum's slope and bend: `(J'/J'') / sqrt(2 s²/J'')`.
            (after - before) / 2.0 / (2.0 * (after + before - 2.0 * here) * fitted.variance).sqrt()
        };
        (0..12).map(along).collect()
    }

    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-6** The estimate MUST be the minimum, over all parameters, that Gauss-Newton steps lead to, of the sum
    //# of the squared differences between the pixels of all layers and their model, and of `(o - o_0)²/256`, `o'²/256`
    //# and `g'²/256` for each layer, `o_0` being FIT-7's `o`.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-8** A step `(Δa, Δs, Δk, Δσ)` MUST be the solution of FIT-6's normal equations from which each layer's
    //# own parameters have been eliminated, with a 64th of the square of FIT-7's `g` of each layer added to the
    //# diagonal for σ.
    #[test]
    fn nothing_lowers_the_sum_any_more() {
        let right_end = sight((0.3, 0.0, PI), Light::default(), CLEAR).truth.column(1.0) + 239.5;
        // Beside the barcode's right end, and with only the quiet zone and a part of an edge beyond it.
        for (place, illumination) in [
            (0.0, Illumination::Even),
            (-30.3, Illumination::Step),
            (-0.3, Illumination::Step),
            (1.3, Illumination::Step),
        ] {
            let patch = Patch { left: f64::NEG_INFINITY, right: right_end + place, factor: 1.0 / 3.0 };
            let patch = (illumination == Illumination::Step).then_some(patch);
            let sight = sight((0.3, 0.0, PI), Light { patch, ..Light::default() }, CLEAR);
            let fitted = sight.fit(sight.truth, illumination).unwrap();
            let steps = still_to_go(&sight, &fitted);
            assert!(steps.iter().all(|step| step.abs() < 1.0 / 15.0), "{place}: {steps:?} {fitted:?}");
        }
    }

    #[test]
    fn one_layer_is_enough() {
        let sight = sight((0.25, 0.05, PI + 0.3), Light::default(), CLEAR);
        let start = Imaging { homography: sight.truth, blur: START_BLUR };
        let both = sight.fit(sight.truth, Illumination::Even).unwrap();
        for layer in sight.layers() {
            let alone = fit(&[layer], &start, Illumination::Even, &Camera::epuck(), Format::Paper).unwrap();
            assert!(sight.error(&alone) < 0.03 && alone.lights.len() == 1);
            // Half of the pixels know about half as much.
            let ratio = alone.covariance[(0, 0)] / both.covariance[(0, 0)];
            assert!((1.3..3.5).contains(&ratio), "{ratio}");
        }
    }

    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-2** The model of pixel `i` MUST be `o + g c_i + λ_i (o' + g' c_i)` with its ink `c_i` (EDGE-2).
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-3** Under even light `λ_i` MUST be `(2 i - l - r)/(r - l)`, with `l` and `r` the window's first and last
    //# pixel.
    #[test]
    fn a_gradient_of_the_light_does_not_move_the_estimate() {
        let light = Light { gradient: 0.8, exposure: 0.8, ..Light::default() };
        let sight = sight((0.2, 0.0, PI + 0.1), light, CLEAR);
        let fitted = sight.fit(sight.truth, Illumination::Even).unwrap();
        assert!(sight.error(&fitted) < 0.02);
        // 0.8 over 480 px of a light of about 1: the share over half a window of about 104 px.
        let light = fitted.lights[0];
        assert!((light.offset_slope / light.offset - 0.8 * 52.0 / 480.0).abs() < 0.01, "{light:?}");
        assert!((light.gain_slope / light.gain - 0.8 * 52.0 / 480.0).abs() < 0.01, "{light:?}");
    }

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
    fn a_step_of_the_light_is_found_and_explained() {
        let patch = Some(Patch { left: f64::NEG_INFINITY, right: 228.3, factor: 1.0 / 3.0 });
        let sight = sight((0.3, 0.0, PI), Light { patch, ..Light::default() }, CLEAR);
        let even = sight.fit(sight.truth, Illumination::Even);
        assert!(even.is_err() || even.unwrap().variance > 100.0);
        let fitted = sight.fit(sight.truth, Illumination::Step).unwrap();
        assert!(sight.error(&fitted) < 0.05 && fitted.variance < 4.0, "{fitted:?}");
        // The patch ends within pixel 228.
        assert!(fitted.lights.iter().all(|light| light.step == Some(228)));
    }

    #[test]
    fn the_noise_is_estimated() {
        let sight = sight((0.15, 0.0, PI), Light::default(), Sensor { blur: 0.5, noise: 3.0 });
        let fitted = sight.fit(sight.truth, Illumination::Even).unwrap();
        // 9 and a twelfth; 260 degrees of freedom leave 9 %, of which 3.5 are allowed.
        assert!((fitted.variance / 9.083 - 1.0).abs() < 0.3, "{}", fitted.variance);
        assert_eq!(fitted.degrees_of_freedom + 12, 2 * (sight.ends.1 - sight.ends.0 + 1 + 8));
    }

    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-5** Pixels of the value 0 or 255 MUST be left out, since RENDER-5 limits them.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-12** A fit MUST be refused (`TooFewPixels`) if `n < 3 p`, or if the values of a layer's pixels that are
    //# not left out all lie within less than 12 grey levels.
    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-13** A fit MUST be refused (`NotConverged`) if it has not converged with its 9th step, if its equations
    //# are not positive definite, or if a step leads to `|k| > 3/4`, to `s < N/4`, to columns that do not grow, `s <= a
    //# k`, or to a light of `|o| + |o'|` or `|g| + |g'|` above 511 grey levels.
    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let mut sight = sight((0.3, 0.0, PI), Light::default(), CLEAR);
        let truth = sight.truth;
        // Three times 8 parameters: 24 pixels count, 20 and a margin of 2; one that is limited is one less.
        let mut line: Vec<u8> = (0..480_u32).map(|pixel| u8::try_from(100 + pixel * 37 % 50).unwrap()).collect();
        let few = |line: &[u8]| {
            let layer = FitLayer { line, first_pixel: 229, last_pixel: 248, stripes: &sight.stripes[0] };
            let start = Imaging { homography: Homography { a: 0.0, s: 10.0, k: 0.0 }, blur: START_BLUR };
            fit(&[layer], &start, Illumination::Even, &Camera::epuck(), Format::Paper) == Err(FitRefusal::TooFewPixels)
        };
        assert!(!few(&line));
        line[240] = 255;
        assert!(few(&line));
        let off = Homography { a: truth.a + 40.0, ..truth };
        assert_eq!(sight.fit(off, Illumination::Even), Err(FitRefusal::NotConverged));
        for line in &mut sight.lines {
            for value in line.iter_mut() {
                *value = if *value < 120 { 0 } else { 255 };
            }
        }
        assert_eq!(sight.fit(truth, Illumination::Even), Err(FitRefusal::TooFewPixels));
    }

    //= reference/SPEC.md#fit
    //= type=test
    //# - **FIT-1** The window of a layer MUST be the pixels from `first - P` to `last + P` within the line, with `P =
    //# min(4, floor(2 e/N))` and `e` the ROI's extent.
    #[test]
    fn windows_reach_two_stripes_and_at_most_four_pixels_beyond() {
        let window = |first, last| {
            let Window { first, last, .. } = Window::of(first, last, Format::Paper, 480);
            (first, last)
        };
        assert_eq!(window(100, 124), (98, 126));
        assert_eq!(window(100, 199), (96, 203));
        assert_eq!(window(2, 478), (0, 479));
    }
}
