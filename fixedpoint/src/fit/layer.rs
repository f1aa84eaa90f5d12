//! The model of one layer: its window, its light, its share of the normal equations.

use super::light;
use super::step::Shortened;
use super::{FitLayer, Illumination, LayerLight, Plan};
use crate::binary;
use crate::edge::Blur;
use crate::elimination::{Equations, SOLUTION_BITS};
use crate::landmark::Format;
use crate::projection::Projection;
use crate::ratio;
use crate::sweep::{InkedPixel, Sweep};
use core::ops::RangeInclusive;

/// Fraction bits that the derivatives by a layer's own parameters have at least; those by the others have about as many.
const OWN_BITS: i32 = 10;

/// The bits that derivatives have beyond [`OWN_BITS`] where they meet the residuals.
const FINER_BITS: i32 = 4;

/// Fraction bits of the derivatives by a layer's own parameters there.
const FINE_BITS: i32 = OWN_BITS + FINER_BITS;

/// What a squared grey level weighs by which a light changes, or white differs from its start (`FIT-6`), and by which a
/// guard fit's step changes a gain (`TRELLIS-3`): 2^-8.
const PRIOR_BITS: i32 = 8;

/// Fraction bits of the light while it is fitted: what rounding it costs must be less than `FIT-11` allows to be left.
const LIGHT_BITS: u32 = 12;

/// The largest value of a gain or an offset along the window: 511 grey levels (`FIT-13`).
const BRIGHTEST: i64 = 511 << LIGHT_BITS;

/// A layer while it is fitted.
#[derive(Clone, Debug)]
pub(super) struct LayerModel<'a> {
    line: &'a [u8],
    stripes: u32,
    /// First and last pixel of the window (`FIT-1`).
    first: u16,
    last: u16,
    /// Pixels that a guard fit leaves out (`TRELLIS-2`).
    hidden: Option<RangeInclusive<u16>>,
    /// Whether the light may change along the window.
    sloped: bool,
    /// `o`, `g`, `o'` and `g'` in 2^-12 grey levels.
    levels: [i32; 4],
    /// The grey values that `o` and `o + g` started with (`FIT-7`).
    brightest: u8,
    darkest: u8,
    /// The pixel of a step of light.
    step: Option<u16>,
    /// Bits that the normal equations' derivatives have beyond [`OWN_BITS`].
    further: i32,
}

impl<'a> LayerModel<'a> {
    /// The window and the start of a layer (`FIT-1`, `FIT-7`).
    //= reference/SPEC.md#fit
    //# - **FIT-1** The window of a layer MUST be the pixels from `first - P` to `last + P` within the line, with `P =
    //# min(4, floor(2 e/N))` and `e` the ROI's extent.
    #[inline(never)] // likewise
    pub(super) fn new(
        layer: &FitLayer<'a>,
        format: Format,
        origin: i32,
        projection: &Projection,
        blur: &Blur,
        plan: Plan,
    ) -> Self {
        let extent = layer.last_pixel.saturating_sub(layer.first_pixel).saturating_add(1);
        let margin = (extent / u16::from(format.stripes() / 2)).min(4);
        let end = u16::try_from(layer.line.len()).unwrap_or(u16::MAX).saturating_sub(1);
        let (first, last) =
            (layer.first_pixel.saturating_sub(margin), layer.last_pixel.saturating_add(margin).min(end));
        let window = layer.line.get(usize::from(first)..=usize::from(last)).unwrap_or(&[]);
        let brightest = window.iter().copied().max().unwrap_or(0);
        let darkest = window.iter().copied().min().unwrap_or(0);
        let gain = i32::from(darkest) - i32::from(brightest);
        let mut model = Self {
            line: layer.line,
            stripes: layer.stripes,
            first,
            last,
            hidden: None,
            sloped: plan != Plan::Guards,
            levels: [i32::from(brightest) << LIGHT_BITS, gain << LIGHT_BITS, 0, 0],
            brightest,
            darkest,
            step: None,
            further: 0,
        };
        match plan {
            Plan::Code(Illumination::Even) => {}
            Plan::Code(Illumination::Step) => {
                let sweep = || Sweep::new(projection, layer.stripes, format, blur, i32::from(first) - origin);
                model.step = light::step(window, sweep, gain).and_then(|place| first.checked_add(place));
            }
            Plan::Guards => model.hidden = code_pixels(format, origin, projection),
        }
        model.further = further_bits(model.pixels());
        model
    }

    /// The pixels of the window and their values, `None` for those that are left out (`FIT-4`, `FIT-5`, `TRELLIS-2`).
    //= reference/SPEC.md#fit
    //# - **FIT-5** Pixels of the value 0 or 255 MUST be left out, since RENDER-5 limits them.
    fn values(&self) -> impl Iterator<Item = (u16, Option<u8>)> {
        let window = self.line.get(usize::from(self.first)..=usize::from(self.last)).unwrap_or(&[]);
        (self.first..).zip(window).map(|(pixel, &value)| {
            let hidden = self.hidden.as_ref().is_some_and(|hidden| hidden.contains(&pixel));
            let left_out = value == 0 || value == u8::MAX || hidden || self.step == Some(pixel);
            (pixel, (!left_out).then_some(value))
        })
    }

    /// The number of pixels that count.
    pub(super) fn pixels(&self) -> u16 {
        self.values().map(|(_, value)| u16::from(value.is_some())).sum()
    }

    /// The square of the gain at the start (`FIT-7`), squared grey levels.
    pub(super) fn squared_contrast(&self) -> u32 {
        let contrast = u32::from(self.brightest.saturating_sub(self.darkest));
        contrast * contrast
    }

    /// Whether their values differ by 12 grey levels or more (`FIT-12`).
    //= reference/SPEC.md#fit
    //# - **FIT-12** A fit MUST be refused (`TooFewPixels`) if `n < 3 p`, or if the values of a layer's pixels that are
    //# not left out all lie within less than 12 grey levels.
    pub(super) fn has_contrast(&self) -> bool {
        let values = || self.values().filter_map(|(_, value)| value);
        let (darkest, brightest) = (values().min().unwrap_or(0), values().max().unwrap_or(0));
        brightest.saturating_sub(darkest) >= 12
    }

    /// The layer's normal equations, its own parameters eliminated (`FIT-8`); `None` if they are not positive definite.
    //= reference/SPEC.md#fit
    //# - **FIT-8** A step `(Δa, Δs, Δk, Δσ)` MUST be the solution of FIT-6's normal equations from which each layer's
    //# own parameters have been eliminated, with a 64th of the square of FIT-7's `g` of each layer added to the
    //# diagonal for σ.
    #[inline(never)] // its stack is not the others'
    pub(super) fn equations(
        &self,
        projection: &Projection,
        format: Format,
        blur: &Blur,
        origin: i32,
        into: &mut LayerEquations,
    ) -> Option<()> {
        let units = Units::of(&self.light(), projection);
        let mut sweep = Sweep::new(projection, self.stripes, format, blur, i32::from(self.first) - origin);
        let mut sums = Sums::of(self.further);
        let places = self.places();
        for (pixel, value) in self.values() {
            let inked = sweep.pixel();
            if let Some(value) = value {
                sums.add(value, self.lambda(pixel, places), &self.levels, &inked, &units);
            }
        }
        let [offset, _, offset_slope, gain_slope] = self.levels;
        let brighter = offset - (i32::from(self.brightest) << LIGHT_BITS);
        sums.add_prior([brighter, offset_slope, gain_slope], !self.sloped);
        let equations = &mut into.equations;
        equations.scale(|i, j| sums.entry(i, j));
        for own in 0..4 {
            equations.eliminate(own)?;
        }
        for (exponent, bits) in equations.exponents.iter_mut().zip(units.bits(self.further)) {
            *exponent -= bits;
        }
        into.squares = sums.squares;
        into.prior = sums.prior;
        Some(())
    }

    /// `2^22/(r - l)`, rounded down, of the window's ends (`FIT-3`).
    fn places(&self) -> i32 {
        (1_i32 << 22).checked_div(i32::from(self.last) - i32::from(self.first)).unwrap_or(0)
    }

    /// `λ_i` in 2^-12 (`FIT-3`, `FIT-4`), rounded towards -∞ of a value less than 640 · 2^-22 off; 0 if the light does not
    /// change.
    //= reference/SPEC.md#fit
    //# - **FIT-3** Under even light `λ_i` MUST be `(2 i - l - r)/(r - l)`, with `l` and `r` the window's first and last
    //# pixel.
    //= reference/SPEC.md#fit
    //# - **FIT-4** Under a step of light `λ_i` MUST be -1 to the left and 1 to the right of the pixel `m` of the
    //# layer's step, which is left out.
    fn lambda(&self, pixel: u16, places: i32) -> i32 {
        let (first, last, pixel) = (i32::from(self.first), i32::from(self.last), i32::from(pixel));
        match self.step {
            _ if !self.sloped => 0,
            Some(step) if pixel < i32::from(step) => -(1 << 12),
            Some(_) => 1 << 12,
            None => ((2 * pixel - first - last) * places) >> 10,
        }
    }

    /// The layer's own step, which follows from the common one (`FIT-8`, `FIT-9`); `None` where it leads out of `FIT-13`'s
    /// bounds.
    #[inline(never)] // likewise
    pub(super) fn follow(&mut self, equations: &LayerEquations, step: &Shortened) -> Option<()> {
        let own = equations.own_step(step);
        for (parameter, change) in self.levels.iter_mut().zip(own) {
            let value = i64::from(*parameter).saturating_add(change);
            *parameter = i32::try_from(value).ok().filter(|value| i64::from(value.unsigned_abs()) <= BRIGHTEST)?;
        }
        let [offset, gain, offset_slope, gain_slope] = self.levels.map(|level| i64::from(level.unsigned_abs()));
        (offset + offset_slope <= BRIGHTEST && gain + gain_slope <= BRIGHTEST).then_some(())
    }

    /// The light, rounded to 8 fraction bits.
    pub(super) fn light(&self) -> LayerLight {
        let [offset, gain, offset_slope, gain_slope] = self.levels.map(|level| rounded(level, LIGHT_BITS - 8));
        LayerLight { offset, gain, offset_slope, gain_slope, step: self.step }
    }
}

/// The bits beyond [`OWN_BITS`] with which products of two derivatives of so many pixels add up to less than 2^31, and at least
/// one less than where they meet the residuals.
fn further_bits(pixels: u16) -> i32 {
    ((30 - binary::size(i64::from(pixels))) / 2 - OWN_BITS).clamp(0, FINER_BITS - 1)
}

/// The pixels whose middle lies between the outer edges of the code, widened by 3/2 px (`TRELLIS-2`).
///
/// An edge's rounding, 2^-16 px, counts as between.
//= reference/SPEC.md#trellis
//# - **TRELLIS-2** The guard fit MUST leave out the pixels whose middle lies between the outer edges of the code by
//# that start, or on one of them, after they are widened by 3/2 px on either side.
fn code_pixels(format: Format, origin: i32, projection: &Projection) -> Option<RangeInclusive<u16>> {
    const WIDENED: i32 = (3 << 15) + 2;
    let guard = usize::from((format.stripes() - format.code_stripes()) / 2);
    let left = projection.column(guard)? - WIDENED;
    let right = projection.column(usize::from(format.stripes()) - guard)? + WIDENED;
    let first = origin + ((left + 0xFFFF) >> 16);
    let last = origin + (right >> 16);
    Some(u16::try_from(first.max(0)).ok()?..=u16::try_from(last).ok()?)
}

/// The powers of two that a layer's derivatives are in units of.
#[derive(Clone, Copy, Debug)]
struct Units {
    /// Fraction bits of the gain, of which the largest along the window then has 10 bits.
    gain: i32,
    /// Those of [`Projection::growth_bits`] and [`Projection::reach_bits`].
    growth: i32,
    reach: i32,
}

impl Units {
    fn of(light: &LayerLight, projection: &Projection) -> Self {
        let largest = i64::from(light.gain.abs()) + i64::from(light.gain_slope.abs());
        Self {
            gain: 8 + OWN_BITS - binary::size(largest),
            growth: i32::from(projection.growth_bits),
            reach: i32::from(projection.reach_bits),
        }
    }

    /// Fraction bits of all columns: own derivatives, common ones, residuals.
    fn bits(&self, further: i32) -> [i32; 9] {
        let (own, gain) = (OWN_BITS + further, self.gain + further);
        let motion = gain - self.growth;
        [own, own, own, own, motion, motion, motion - self.reach, gain, 8]
    }
}

/// Sums of products of derivatives and residuals.
///
/// Derivatives are at most 2^10, so the sums over 640 px are at most 640 · 2^20 < 2^29.4, and with [`further_bits`] less than
/// 2^30. Residuals are less than 2^16.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Bits that the derivatives have beyond [`OWN_BITS`], and those that they have not.
    further: i32,
    dropped: u8,
    /// Own by own, then common by common: the upper triangles by rows.
    own: [i32; 10],
    common: [i32; 10],
    /// A row for each own parameter.
    mixed: [[i32; 4]; 4],
    /// By the residual.
    right: [i64; 8],
    /// Residual by residual, 16 fraction bits.
    squares: i64,
    /// What `FIT-6` adds to them for the light, 16 fraction bits.
    prior: i64,
}

impl Sums {
    /// Nothing yet.
    fn of(further: i32) -> Self {
        let dropped = u8::try_from(FINER_BITS - further).unwrap_or_default();
        Self { further, dropped, ..Self::default() }
    }

    /// Adds a pixel.
    ///
    /// Rounding errors of the residual, in grey levels: 2^-9 its own, and 2^-13 each from the offset and the product, and the
    /// gain's 2^-13 times the ink.
    fn add(&mut self, value: u8, lambda: i32, levels: &[i32; 4], inked: &InkedPixel, units: &Units) {
        let [offset, gain, offset_slope, gain_slope] = levels.map(i64::from);
        let changed = |level: i64, slope: i64| level + ((slope * i64::from(lambda) + (1 << 11)) >> 12);
        let gain = changed(gain, gain_slope);
        let ink = (inked.ink + 2) >> 2; // 14 fraction bits
        // All bits of the ink: what is dropped differs from step to step, and FIT-11 would take that for a way still to go.
        let model = changed(offset, offset_slope) + ((gain * i64::from(inked.ink) + (1 << 15)) >> 16);
        let residual = (i64::from(value) << LIGHT_BITS) - model;
        let residual = ((residual + (1 << LIGHT_BITS >> 9)) >> (LIGHT_BITS - 8)).clamp(-0xFFFF, 0xFFFF);
        let residual = i32::try_from(residual).unwrap_or_default();
        let gain = rounded(i32::try_from(gain).unwrap_or_default(), LIGHT_BITS - 8);

        let fine = [1 << FINE_BITS, ink, lambda << 2, (lambda * ink + (1 << 11)) >> 12];
        let coarse = |derivative: i32| rounded(derivative, u32::from(self.dropped));
        let own = fine.map(coarse);
        add(&mut self.own, triangle(own));
        let [for_own @ .., a, s, k, blur] = &mut self.right;
        for (sum, derivative) in for_own.iter_mut().zip(fine) {
            *sum += i64::from(derivative * residual);
        }
        self.squares += i64::from(residual.unsigned_abs() * residual.unsigned_abs());
        if !inked.active {
            return;
        }
        let fine = common(inked, units.scaled_gain(gain), units);
        let common = fine.map(coarse);
        add(&mut self.common, triangle(common));
        for (row, derivative) in self.mixed.iter_mut().zip(own) {
            add(row, common.map(|other| derivative * other));
        }
        for (sum, derivative) in [a, s, k, blur].into_iter().zip(fine) {
            *sum += i64::from(derivative * residual);
        }
    }
}

impl Sums {
    /// Adds what `FIT-6` asks for beside the pixels, by `o - o_0`, `o'` and `g'` in 2^-12 grey levels, and a guard fit's
    /// damping: exactly, but for half a unit of the squares.
    fn add_prior(&mut self, away: [i32; 3], damped: bool) {
        let prior = 1 << (2 * (OWN_BITS + self.further) - PRIOR_BITS);
        let [offset, _, _, _, gain, _, _, offset_slope, _, gain_slope] = &mut self.own;
        for diagonal in [offset, offset_slope, gain_slope] {
            *diagonal += prior;
        }
        if damped {
            *gain += prior;
        }
        let [for_offset, _, for_offset_slope, for_gain_slope, _, _, _, _] = &mut self.right;
        let mut squares = 0_i64;
        for (sum, level) in [for_offset, for_offset_slope, for_gain_slope].into_iter().zip(away.map(i64::from)) {
            *sum -= level << (FINE_BITS + 8 - LIGHT_BITS.cast_signed() - PRIOR_BITS);
            squares += level * level;
        }
        self.prior = binary::scaled(squares, 16 - 2 * LIGHT_BITS.cast_signed() - PRIOR_BITS);
    }
}

impl Units {
    /// A gain of 8 fraction bits in units of the derivatives, at most 2^10.
    fn scaled_gain(&self, gain: i32) -> i32 {
        let surplus = 8 - self.gain;
        let scaled = match u32::try_from(surplus) {
            Ok(surplus) => gain.saturating_add((1 << surplus) >> 1) >> surplus,
            Err(_) => gain << surplus.unsigned_abs(),
        };
        scaled.clamp(-(1 << OWN_BITS), 1 << OWN_BITS)
    }
}

/// The derivatives of a pixel by `a`, `s`, `k` and σ, fine, limited to 2^14: only edges that are nearer to each other than
/// any that were decoded reach that.
fn common(inked: &InkedPixel, gain: i32, units: &Units) -> [i32; 4] {
    let limited = |value: i32| value.clamp(-(1 << 14), 1 << 14);
    let dropped = 15 - FINER_BITS + units.growth;
    let [a, s, k] = inked.motion.map(|motion| limited(((motion >> 9) * gain + (1 << dropped >> 1)) >> dropped));
    [a, s, k, limited((inked.spread * gain + (1 << 11)) >> (16 - FINER_BITS))]
}

/// `value` without its last `bits`, rounded to nearest, halves up.
fn rounded(value: i32, bits: u32) -> i32 {
    (value + (1 << bits >> 1)) >> bits
}

/// The upper triangle of the products of four numbers, by rows.
fn triangle([a, b, c, d]: [i32; 4]) -> [i32; 10] {
    [a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d]
}

fn add<const M: usize>(sums: &mut [i32; M], terms: [i32; M]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}

impl Sums {
    /// The entry `(i, j)`, `i <= j`, of the normal equations in the columns own, common, residual.
    fn entry(&self, i: usize, j: usize) -> i64 {
        let sum = match (i < 4, j < 4) {
            _ if i == 8 => return self.squares + self.prior,
            _ if j == 8 => return ratio::dropped(self.right.get(i).copied().unwrap_or_default(), self.dropped),
            (true, true) => self.own.get(in_triangle(i, j)),
            (true, false) => self.mixed.get(i).and_then(|row| row.get(j.saturating_sub(4))),
            _ => self.common.get(in_triangle(i.saturating_sub(4), j.saturating_sub(4))),
        };
        i64::from(sum.copied().unwrap_or_default())
    }
}

/// The place of `(i, j)`, `i <= j < 4`, in an upper triangle by rows.
fn in_triangle(i: usize, j: usize) -> usize {
    (i * (7_usize.saturating_sub(i))) / 2 + j
}

/// A layer's share of the normal equations.
#[derive(Clone, Debug)]
pub(super) struct LayerEquations {
    /// In the order own parameters (eliminated), `a`, `s`, `k`, σ, residuals; exponents for grey levels and px.
    pub(super) equations: Equations<9>,
    /// The sum of the squared residuals, 16 fraction bits.
    pub(super) squares: i64,
    /// What `FIT-6` adds to it for the light, 16 fraction bits.
    pub(super) prior: i64,
}

impl LayerEquations {
    /// A place for a layer's equations.
    pub(super) fn empty() -> Self {
        Self { equations: Equations::empty(), squares: 0, prior: 0 }
    }

    /// The change of the own parameters in 2^-12 grey levels.
    fn own_step(&self, step: &Shortened) -> [i64; 4] {
        let mut solution = [0; 9];
        let exponents = self.equations.exponents;
        let [own @ .., _, _, _, _, right] = exponents;
        let [_, _, _, _, common @ .., _] = exponents;
        let [_, _, _, _, known @ .., _] = &mut solution;
        for ((place, change), exponent) in known.iter_mut().zip(step.changes).zip(common) {
            // Units of this layer's columns.
            *place = change.scaled(exponent - right + i32::from(SOLUTION_BITS)).clamp(-(1 << 32), 1 << 32);
        }
        for pivot in (0..4).rev() {
            self.equations.substitute(pivot, &mut solution);
        }
        let [change @ .., _, _, _, _, _] = solution;
        let mut changes = [0; 4];
        for ((place, value), exponent) in changes.iter_mut().zip(change).zip(own) {
            *place = binary::scaled(value, right - exponent - i32::from(SOLUTION_BITS) + LIGHT_BITS.cast_signed());
        }
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::super::step::Change;
    use super::*;
    use crate::formats::{Column, Obliquity};
    use crate::homography::Homography;

    /// A pixel's residual, 8 fraction bits, and its right sides by `g`, `o'` and `g'` for a residual of 1, 14 fraction bits.
    fn of_pixel(value: u8, lambda: i32, levels: [i32; 4], ink: i32) -> (i64, [i64; 3]) {
        let mut sums = Sums::of(0);
        let units = Units { gain: OWN_BITS, growth: 0, reach: 0 };
        sums.add(value, lambda, &levels, &InkedPixel { ink, ..InkedPixel::default() }, &units);
        let [by_offset, others @ .., _, _, _, _] = sums.right; // the derivative by the offset is 1
        (by_offset >> 14, others.map(|right| right >> 8))
    }

    /// Five eighths of a unit are more than half of it: in `FIT-2` of the offset, 8 units of 2^-12, and what is added to it.
    #[test]
    fn what_a_residual_is_made_of_is_rounded_to_nearest() {
        let five_eighths = 5 << 9; // of 12 fraction bits
        // 8.625 and 9 units of 2^-12 are 0.54 and 0.56 of 2^-8, 8 are just the half, which goes up.
        assert_eq!(of_pixel(0, 0, [8, 0, 0, 0], 0).0, 0);
        assert_eq!(of_pixel(0, five_eighths, [8, 0, 1, 0], 0).0, -1);
        assert_eq!(of_pixel(0, 0, [8, 5, 0, 0], 1 << 13).0, -1);
        assert_eq!(of_pixel(0, 0, [-9, 0, 0, 0], 0).0, 1);
        // Of the ink three of 16 fraction bits; then `λ c`.
        assert_eq!(of_pixel(1, 0, [0; 4], 3), (1 << 8, [1, 0, 0]));
        assert_eq!(of_pixel(1, five_eighths, [0; 4], 4), (1 << 8, [1, i64::from(five_eighths) << 2, 1]));
    }

    /// As above, of 2^-11 and 2^-12 of a gain of 2^8.
    #[test]
    fn derivatives_are_rounded_to_nearest() {
        let units = Units { gain: OWN_BITS, growth: 0, reach: 0 };
        let inked = InkedPixel { motion: [5 << 9, -3 << 9, 3 << 9], spread: 10, ..InkedPixel::default() };
        assert_eq!(common(&inked, 1 << 8, &units), [1, 0, 0, 1]);
    }

    /// The most pixels for each number of bits, and one more.
    #[test]
    fn few_pixels_have_finer_derivatives() {
        let pixels = [0, 15, 16, 63, 64, 255, 256, 640];
        assert_eq!(pixels.map(further_bits), [3, 3, 2, 2, 1, 1, 0, 0]);
        for pixels in 1..=640_u16 {
            let largest = 1_i64 << (OWN_BITS + further_bits(pixels));
            assert!(i64::from(pixels) * largest * largest + ((largest * largest) >> PRIOR_BITS) < 1 << 31);
        }
    }

    /// The same pixel and the same light with finer derivatives: the same equations in finer units.
    #[test]
    fn finer_derivatives_are_in_finer_units() {
        let units = Units { gain: OWN_BITS, growth: 0, reach: 0 };
        let inked = InkedPixel { ink: 3 << 14, motion: [1 << 22, -3 << 20, 3 << 18], spread: 1 << 12, active: true };
        let of = |further: i32| {
            let mut sums = Sums::of(further);
            sums.add(100, 1 << 11, &[200 << LIGHT_BITS, -120 << LIGHT_BITS, 0, 0], &inked, &units);
            sums.add_prior([1 << LIGHT_BITS; 3], true);
            sums
        };
        let (coarse, fine) = (of(0), of(3));
        for (i, j) in (0..8).flat_map(|i| (i..9).map(move |j| (i, j))) {
            let bits = if j == 8 { 3 } else { 6 };
            assert_eq!(fine.entry(i, j), coarse.entry(i, j) << bits, "{i} {j}");
        }
        assert_eq!(fine.entry(8, 8), coarse.entry(8, 8));
        assert!(units.bits(3).iter().zip(units.bits(0)).take(8).all(|(fine, coarse)| fine - coarse == 3));
    }

    /// `FIT-6` and `TRELLIS-3`: `(o - o_0)²/256`, `o'²/256` and `g'²/256`, which meet no pixel.
    #[test]
    fn changes_of_light_weigh_a_256th_of_a_pixel() {
        let added = |damped: bool| {
            let mut sums = Sums::of(0);
            sums.add_prior([7 << LIGHT_BITS, 3 << LIGHT_BITS, -5 << LIGHT_BITS], damped);
            sums
        };
        let (one, sums) = (1_i64 << (2 * OWN_BITS), added(false));
        assert_eq!([0, 1, 2, 3].map(|i| 256 * sums.entry(i, i)), [one, 0, one, one]);
        assert_eq!([0, 1, 2, 3].map(|i| 256 * added(true).entry(i, i)), [one, one, one, one]);
        // Right sides have 18 fraction bits, squares 16.
        assert_eq!([0, 1, 2, 3, 4].map(|i| 256 * sums.entry(i, 8)), [-7 << 18, 0, -3 << 18, 5 << 18, 0]);
        assert_eq!(sums.right, added(true).right);
        assert_eq!((256 * sums.prior, sums.squares), ((49 + 9 + 25) << 16, 0));
        let both = Sums { squares: 7, ..sums };
        assert_eq!(both.entry(8, 8), 7 + sums.prior);
    }

    /// A layer of this light that began with values from 50 to 200.
    fn lit(levels: [i32; 4]) -> LayerModel<'static> {
        LayerModel {
            line: &[],
            stripes: 0,
            first: 0,
            last: 0,
            hidden: None,
            sloped: true,
            levels: levels.map(|grey| grey << LIGHT_BITS),
            brightest: 200,
            darkest: 50,
            step: None,
            further: 0,
        }
    }

    /// `FIT-8`: of the start, whatever the light is now.
    #[test]
    fn contrast_is_that_of_the_start() {
        assert_eq!(lit([300, -20, 0, 0]).squared_contrast(), 150 * 150);
    }

    /// Whether a layer of this light may stay as it is.
    fn stays(levels: [i32; 4]) -> bool {
        lit(levels).follow(&LayerEquations::empty(), &Shortened { changes: [Change::default(); 4] }).is_some()
    }

    /// `FIT-13`: `|o| + |o'|` and `|g| + |g'|` are at most 511.
    #[test]
    fn light_is_bounded_at_the_window_s_ends() {
        assert!(stays([500, 0, 11, 0]) && stays([-500, 0, 11, 0]) && stays([0, -500, 0, -11]) && stays([0; 4]));
        assert!(!stays([500, 0, 12, 0]) && !stays([-500, 0, 12, 0]) && !stays([12, 0, -500, 0]));
        assert!(!stays([0, 500, 0, 12]) && !stays([0, -500, 0, -12]) && !stays([0, 12, 0, -500]));
    }

    /// `TRELLIS-2`: the code's edges are 0.6 · 42.5 px = 25.5 px from the middle, and 1.5 px more are hidden.
    #[test]
    fn pixels_at_the_bound_are_hidden() {
        let homography = Homography { a: Column::ZERO, s: Column::from_num(42.5), k: Obliquity::ZERO };
        let projection = Projection::new(&homography, Format::Paper).unwrap();
        assert_eq!(code_pixels(Format::Paper, 100, &projection), Some(73..=127));
    }

    /// The largest gain along the window has 10 bits, and smaller ones the same unit.
    #[test]
    fn gains_are_scaled_to_their_unit() {
        let homography = Homography { a: Column::ZERO, s: Column::from_num(40), k: Obliquity::ZERO };
        let projection = Projection::new(&homography, Format::Paper).unwrap();
        let scaled = |largest: i32, gain: i32| {
            let light = LayerLight { gain: largest, ..LayerLight::default() };
            Units::of(&light, &projection).scaled_gain(gain)
        };
        // 100 has 7 bits, 4661 13: 4661/8 is 582.6.
        assert_eq!((scaled(100, 100), scaled(-100, -100), scaled(100, -3)), (800, -800, -24));
        assert_eq!((scaled(-4661, -4661), scaled(4661, 4661), scaled(-4661, 12)), (-583, 583, 2));
    }

    #[test]
    fn halves_are_rounded_up() {
        assert_eq!((rounded(3, 1), rounded(-3, 1), rounded(8, 4), rounded(7, 4)), (2, -1, 1, 0));
    }
}
