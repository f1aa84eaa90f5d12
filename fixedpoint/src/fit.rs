//! Least squares of the grey levels themselves: Gauss-Newton in integers.
//!
//! Columns count from the middle of the layers' windows while they are fitted. `a' = a - δ`, `s' = s - δ k` and `k` are as
//! good a set of parameters as `a`, `s` and `k`: the model, its minimum and the steps that lead to it are the same, and
//! `k` moves edges by `x t/(1 + k t)` of a small `x`.
//!
//! What decides where the minimum lies are the residuals, which are kept with 8 fraction bits of a grey level, of a light
//! of 12. The model's derivatives have 10 significant bits, in block floating point: the same in a whole layer, so that
//! products of two of them over a window of 640 px add up in 32 bits, and up to 13 where fewer pixels count. Their
//! rounding, at most half a unit where the largest are a few hundred, is independent of the residuals and moves the
//! minimum by less than 0.5 % of its standard deviation.

mod layer;
mod light;
mod step;

use crate::camera::Camera;
use crate::covariance::Covariance;
use crate::edge::Blur;
use crate::formats::Column;
use crate::homography::Homography;
use crate::landmark::Format;
use crate::projection::{self, Projection};
use crate::refusal::FitRefusal;
use heapless::Vec;
use layer::{LayerEquations, LayerModel};
use step::Step;

/// A layer to be fitted.
#[derive(Clone, Copy, Debug)]
pub struct FitLayer<'a> {
    /// The scan line.
    pub line: &'a [u8],
    /// First pixel of the ROI.
    pub first_pixel: u16,
    /// Last pixel of the ROI.
    pub last_pixel: u16,
    /// The colours of the `N` stripes: bit `N - 1 - j` is 1 where stripe `j` is a bar.
    pub stripes: u32,
}

/// How light is modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Illumination {
    /// A gradient along the line (`FIT-3`).
    Even,
    /// A step at a pixel of each layer (`FIT-4`, `FIT-15`).
    Step,
}

/// Where a fit starts (`FIT-7`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Start {
    /// Relative to the principal column, `|k| <= 3/4`.
    pub homography: Homography,
    /// The blur σ in px, 0.2 to 1.2 px.
    pub blur: Column,
}

impl Start {
    /// The start at a homography, with a blur of 1/2 px.
    #[must_use]
    pub fn at(homography: &Homography) -> Self {
        Self { homography: *homography, blur: Blur::START }
    }
}

/// The light of a layer: pixel `i` is `offset + gain c_i + λ_i (offset_slope + gain_slope c_i)` (`FIT-2`).
///
/// Grey levels with 8 fraction bits, limited to ±511.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerLight {
    /// `o`.
    pub offset: i32,
    /// `g`, negative where ink is dark.
    pub gain: i32,
    /// `o'`.
    pub offset_slope: i32,
    /// `g'`.
    pub gain_slope: i32,
    /// The pixel of a step of light.
    pub step: Option<u16>,
}

/// A fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fitted {
    /// `a`, `s` and `k` relative to the principal column.
    pub homography: Homography,
    /// The blur σ in px, 0.2 to 1.2 px.
    pub blur: Column,
    /// The covariance of `(a, s, k)` (`FIT-14`).
    pub covariance: Covariance,
    /// `s²` in squared grey levels with 16 fraction bits.
    pub variance: u32,
    /// `n - p`.
    pub degrees_of_freedom: u16,
    /// The number of steps, 1 to 9, or 12 of a guard fit.
    pub steps: u8,
    /// The light of each layer.
    pub lights: Vec<LayerLight, 2>,
}

impl Fitted {
    /// The light that the fit was made under.
    #[must_use]
    pub fn illumination(&self) -> Illumination {
        let step = self.lights.iter().any(|light| light.step.is_some());
        if step { Illumination::Step } else { Illumination::Even }
    }
}

/// Which of the two fits it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plan {
    /// Of all stripes, until it converges (`FIT-11`).
    Code(Illumination),
    /// Of the guards (`TRELLIS-1` to `TRELLIS-3`).
    Guards,
}

/// Fits one or both layers by Gauss-Newton steps to the minimum that they lead to (`FIT-6`).
///
/// # Errors
/// `TooFewPixels` by `FIT-12`, and without a layer; `NotConverged` by `FIT-13`, and where edges do not lie from left to right
/// within ±2048 px.
//= reference/SPEC.md#fit
//# - **FIT-6** The estimate MUST be the minimum, over all parameters, that Gauss-Newton steps lead to, of the sum of
//# the squared differences between the pixels of all layers and their model, and of `(o - o_0)²/256`, `o'²/256` and
//# `g'²/256` for each layer, `o_0` being FIT-7's `o`.
//= reference/SPEC.md#fit
//# - **FIT-13** A fit MUST be refused (`NotConverged`) if it has not converged with its 9th step, if its equations are
//# not positive definite, or if a step leads to `|k| > 3/4`, to `s < N/4`, to columns that do not grow, `s <= a k`, or
//# to a light of `|o| + |o'|` or `|g| + |g'|` above 511 grey levels.
pub fn fit(
    layers: &[FitLayer<'_>],
    start: &Start,
    camera: &Camera,
    format: Format,
    illumination: Illumination,
) -> Result<Fitted, FitRefusal> {
    run(layers, start, camera, format, Plan::Code(illumination))
}

/// Fits the guards of both layers, whose code stripes are spaces (`TRELLIS-1` to `TRELLIS-3`, `TRELLIS-10`).
///
/// # Errors
/// As [`fit`], with up to 12 steps; `NotConverged` also where it is given up early.
//= reference/SPEC.md#trellis
//# - **TRELLIS-3** The guard fit MUST end as FIT-11 says or with its 12th step, with 2^-8 added to the diagonal for
//# each layer's `g`, which counts as if FIT-6 had added it, and be refused as FIT-12, with `n < p + 8`, and FIT-13
//# otherwise say.
pub fn fit_guards(
    layers: &[FitLayer<'_>],
    start: &Start,
    camera: &Camera,
    format: Format,
) -> Result<Fitted, FitRefusal> {
    run(layers, start, camera, format, Plan::Guards)
}

/// The stripes of a layer: its guards and a half word, for [`FitLayer::stripes`] (`LAND-3`, `DECODE-1`).
//= reference/SPEC.md#land
//# - **LAND-3** The left guard MUST be the stripes bar, space repeated `N_guard` times, and the right guard its mirror
//# image.
#[must_use]
pub fn stripes(format: Format, half_word: u16) -> u32 {
    0b1010 << (format.code_stripes() + 4) | u32::from(half_word) << 4 | 0b0101
}

impl FitLayer<'_> {
    /// The half word of its [`stripes`].
    #[must_use]
    pub fn half_word(&self, format: Format) -> u16 {
        let code = (1 << format.code_stripes()) - 1;
        u16::try_from((self.stripes >> 4) & code).unwrap_or(u16::MAX)
    }
}

fn run(
    layers: &[FitLayer<'_>],
    start: &Start,
    camera: &Camera,
    format: Format,
    plan: Plan,
) -> Result<Fitted, FitRefusal> {
    let mut state = State::start(layers, start, camera, format, plan)?;
    let limit = if plan == Plan::Guards { 12 } else { 9 };
    let mut equations: Vec<_, 2> = state.layers.iter().map(|_| LayerEquations::empty()).collect();
    for steps in 1..=limit {
        state.equations(&mut equations).ok_or(FitRefusal::NotConverged)?;
        let step = Step::solve(&equations, state.contrast, state.blur).ok_or(FitRefusal::NotConverged)?;
        let sum = |of: fn(&LayerEquations) -> i64| equations.iter().map(of).fold(0, i64::saturating_add);
        let (squares, prior) = (sum(|layer| layer.squares), sum(|layer| layer.prior));
        if plan == Plan::Guards && state.is_hopeless(steps, squares) {
            return Err(FitRefusal::NotConverged);
        }
        let last = step.is_last(squares, prior, state.degrees_of_freedom) || plan == Plan::Guards && steps == limit;
        state.advance(&step, &equations).ok_or(FitRefusal::NotConverged)?;
        if last {
            return state.fitted(&step, squares, steps).ok_or(FitRefusal::NotConverged);
        }
    }
    Err(FitRefusal::NotConverged)
}

/// Whether what is left in the equations of a guard fit's step says that there are no guards (`TRELLIS-10`), exactly.
///
/// `squares` has 16 fraction bits, and the sum of both gains, `2 ḡ`, 8.
//= reference/SPEC.md#trellis
//# - **TRELLIS-10** The guard fit MUST be refused if in the equations of its second, third or fifth step `s²` is more
//# than `9 + ḡ²/9`, `9 + ḡ²/16` or `9 + ḡ²/64`, `ḡ` being the mean of the gains that these equations start from, or if
//# in one of its steps `ḡ` is above -12.
fn no_guards(step: u8, squares: i64, degrees_of_freedom: u16, gains: i64) -> bool {
    let share = match step {
        2 => Some(9),
        3 => Some(16),
        5 => Some(64),
        _ => None,
    };
    // s² > 9 + ḡ²/share, times 4 share (n - p): below 2^51 and 2^50.
    let too_noisy = share.is_some_and(|share| {
        let limit = i64::from(degrees_of_freedom) * (gains * gains + ((36 * share) << 16));
        squares.saturating_mul(4 * share) > limit
    });
    gains > -24 << 8 || too_noisy
}

/// `FIT-13`, exactly: `|k| <= 3/4`, `s >= N/4` and `s > a k`.
fn is_possible(homography: &Homography, format: Format) -> bool {
    let Homography { a, s, k } = *homography;
    let grows = i64::from(s.to_bits()) << 30 > i64::from(a.to_bits()) * i64::from(k.to_bits());
    k.to_bits().unsigned_abs() <= 3 << 28 && s >= Column::from_num(format.stripes()) / 4 && grows
}

/// A fit under way.
struct State<'a> {
    format: Format,
    layers: Vec<LayerModel<'a>, 2>,
    /// The column that columns count from, as a pixel and relative to the principal column.
    origin_pixel: i32,
    origin: Column,
    homography: Homography,
    blur: Column,
    degrees_of_freedom: u16,
    /// The sum of the layers' squared gains at the start, squared grey levels (`FIT-8`).
    contrast: u32,
}

impl<'a> State<'a> {
    /// `FIT-1`, `FIT-5`, `FIT-7` and `FIT-12`.
    //= reference/SPEC.md#fit
    //# - **FIT-7** The start MUST be the given `(a, s, k)`, σ = 1/2, and for each layer the largest value of its window
    //# as `o`, the smallest less the largest as `g`, and 0 as `o'` and `g'`.
    #[inline(never)] // its stack is not the others'
    fn start(
        layers: &[FitLayer<'a>],
        start: &Start,
        camera: &Camera,
        format: Format,
        plan: Plan,
    ) -> Result<Self, FitRefusal> {
        let first = layers.first().ok_or(FitRefusal::TooFewPixels)?;
        let origin_pixel = i32::from(first.first_pixel.midpoint(first.last_pixel));
        let origin = Column::from_num(origin_pixel) - camera.principal_column();
        let homography = projection::shifted(&start.homography, origin).ok_or(FitRefusal::NotConverged)?;
        let projection = Projection::new(&homography, format).ok_or(FitRefusal::NotConverged)?;
        let blur = Blur::new(start.blur);
        let mut models = Vec::new();
        for layer in layers {
            let model = LayerModel::new(layer, format, origin_pixel, &projection, &blur, plan);
            models.push(model).ok();
        }
        let pixels = models.iter().map(LayerModel::pixels).fold(0, u16::saturating_add);
        let own = if plan == Plan::Guards { 2 } else { 4 };
        let parameters = 4 + models.iter().map(|_| own).sum::<u16>();
        let contrast = models.iter().all(LayerModel::has_contrast);
        let least = if plan == Plan::Guards { 8 } else { 2 * parameters };
        let degrees_of_freedom = pixels.checked_sub(parameters).filter(|&surplus| surplus >= least && contrast);
        Ok(Self {
            format,
            contrast: models.iter().map(LayerModel::squared_contrast).sum(),
            layers: models,
            origin_pixel,
            origin,
            homography,
            blur: start.blur.clamp(Blur::SMALLEST, Blur::LARGEST),
            degrees_of_freedom: degrees_of_freedom.ok_or(FitRefusal::TooFewPixels)?,
        })
    }

    /// The normal equations of every layer at the current parameters.
    #[inline(never)] // its stack is not the others'
    fn equations(&self, into: &mut [LayerEquations]) -> Option<()> {
        let projection = Projection::new(&self.homography, self.format)?;
        let blur = Blur::new(self.blur);
        for (layer, into) in self.layers.iter().zip(into) {
            layer.equations(&projection, self.format, &blur, self.origin_pixel, into)?;
        }
        Some(())
    }

    /// Takes a step (`FIT-9`, `FIT-10`); `None` where it leads out of `FIT-13`'s bounds.
    #[inline(never)] // its stack is not the others'
    fn advance(&mut self, step: &Step, equations: &[LayerEquations]) -> Option<()> {
        let shortened = step.shortened(self.origin);
        self.homography = shortened.applied(&self.homography)?;
        self.blur = self.blur.saturating_add(shortened.spread()).clamp(Blur::SMALLEST, Blur::LARGEST);
        for (layer, equations) in self.layers.iter_mut().zip(equations) {
            layer.follow(equations, &shortened)?;
        }
        is_possible(&self.reported()?, self.format).then_some(())
    }

    /// Whether a guard fit is given up in the equations of this step (`TRELLIS-10`); `squares` has 16 fraction bits.
    fn is_hopeless(&self, step: u8, squares: i64) -> bool {
        let gains: i64 = self.layers.iter().map(|layer| i64::from(layer.light().gain)).sum();
        no_guards(step, squares, self.degrees_of_freedom, gains)
    }

    /// The homography relative to the principal column.
    fn reported(&self) -> Option<Homography> {
        projection::shifted(&self.homography, self.origin.checked_neg()?)
    }

    /// The result (`FIT-14`), `squares` being those before the last step, with 16 fraction bits.
    //= reference/SPEC.md#fit
    //# - **FIT-14** The covariance of `(a, s, k)` MUST be `s²` times that block of the inverse of the reduced normal
    //# equations' matrix, at the last step.
    #[inline(never)] // its stack is not the others'
    fn fitted(&self, step: &Step, squares: i64, steps: u8) -> Option<Fitted> {
        let degrees_of_freedom = i64::from(self.degrees_of_freedom);
        let variance = squares.max(step::least_squares(degrees_of_freedom)).checked_div(degrees_of_freedom)?;
        let variance = u32::try_from(variance).ok()?;
        Some(Fitted {
            homography: self.reported()?,
            blur: self.blur,
            covariance: step.covariance(variance).shifted(self.origin),
            variance,
            degrees_of_freedom: self.degrees_of_freedom,
            steps,
            lights: self.layers.iter().map(LayerModel::light).collect(),
        })
    }
}

#[cfg(test)]
mod tests;
