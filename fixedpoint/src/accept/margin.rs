//! The decision margin: how much worse the nearest other code words explain a layer's pixels.
//!
//! Changing stripe `j` changes the model of a pixel by `d_j = ±g w_j`, `+` where it was a space. With the residual `r` the
//! sum of squares then changes by `Σ (d² - 2 r d)`, `d` being the sum over the stripes that change; so the sums of `r d_j`
//! and of `d_i d_j` for stripes that are at most two apart say it for all changes of `ACCEPT-8`.
//!
//! The model of a pixel that the camera limits counts as limited, too (`TRELLIS-11`), which is no polynomial: with `f(d)` for
//! what a change does to its square, `f(d_j)`, `f(d_i + d_j) - f(d_i) - f(d_j)` and, with a stripe `h` before them,
//! `f(d_h + d_i + d_j) - f(d_h + d_i) - f(d_i + d_j) + f(d_i)` stand for `d² - 2 r d`, `2 d_i d_j` and `2 d_h d_j`.

use crate::ink::{Edges, WHOLE};
use crate::landmark::{Format, GUARD_PAIRS};
use crate::light::{Limited, LitLayer};
use crate::trellis::half_words::guards;

/// A sum of squares in 2^-8 squared grey levels, limited to ±2^23 squared grey levels.
pub type Squares = i32;

/// Residuals and changes have 6 fraction bits and are limited to ±2^9 grey levels.
const LIMIT: i32 = (1 << 15) - 1;

/// The least change of a layer's sum of squares (`ACCEPT-8`), `half_word` being its code stripes.
///
/// Rounding errors: each pixel's residual and each change 2^-7 grey levels besides [`crate::light::Seen`]'s, and each
/// product 2^-9 squared grey levels, of which 9 at most make up a change.
#[must_use]
pub fn least_change(format: Format, edges: &Edges, layer: &LitLayer<'_>, half_word: u16) -> Squares {
    let mut sums = Sums::default();
    let mut first = 0;
    for pixel in layer.first_pixel()..=layer.last_pixel() {
        // Edges to the left of where all of the pixel is beyond them change nothing.
        while first < format.code_stripes() && edges.ink(2 * GUARD_PAIRS + first + 1, pixel) == WHOLE {
            first += 1;
        }
        if let Some(seen) = layer.at(pixel) {
            let seen_inks = PixelInks { format, edges, pixel, first };
            let residual = seen.residual(guards(format, edges, pixel) + seen_inks.bars(half_word));
            let seen_pixel = SeenPixel { residual: limited(residual), limited: seen.limited };
            sums.add(&seen_inks, seen_pixel, |ink| limited(seen.change(ink)), half_word);
        }
    }
    sums.least(format, half_word)
}

/// From 8 to 6 fraction bits, within ±[`LIMIT`].
fn limited(grey: i32) -> i32 {
    ((grey + 2) >> 2).clamp(-LIMIT, LIMIT)
}

/// Whether a code stripe, counted from the left, is a bar.
fn is_bar(format: Format, half_word: u16, stripe: u8) -> bool {
    let place = format.code_stripes().saturating_sub(stripe.saturating_add(1));
    half_word >> place & 1 == 1
}

/// The inks of the code stripes in a pixel, of those from `first` on; those before have none.
struct PixelInks<'a> {
    format: Format,
    edges: &'a Edges,
    pixel: u16,
    first: u8,
}

impl PixelInks<'_> {
    /// The code stripes within reach, from the left, and their inks in units of 2^-16.
    fn stripes(&self) -> impl Iterator<Item = (u8, i32)> {
        let ink = |stripe: u8| self.edges.ink(2 * GUARD_PAIRS + stripe, self.pixel);
        let mut left = ink(self.first);
        (self.first..self.format.code_stripes()).map_while(move |stripe| {
            let right = ink(stripe + 1);
            let own = left - right;
            let within = left > 0;
            left = right;
            within.then_some((stripe, own))
        })
    }

    /// The ink of the code's bars.
    fn bars(&self, half_word: u16) -> i32 {
        self.stripes().filter(|&(stripe, _)| is_bar(self.format, half_word, stripe)).map(|(_, ink)| ink).sum()
    }
}

/// A pixel less its model.
#[derive(Clone, Copy, Debug)]
struct SeenPixel {
    /// With 6 fraction bits, within ±[`LIMIT`]; the model is not limited.
    residual: i32,
    limited: Limited,
}

impl SeenPixel {
    /// What a change of the model alone does to the square, and besides what the last two of the changes, and all three,
    /// do alone; the last change is the first of them.
    fn squares(self, [last, before, first]: [i32; 3]) -> [Squares; 3] {
        if self.limited == Limited::Not {
            let alone = product(last, last) - twice(self.residual, last);
            return [alone, twice(last, before), twice(last, first)];
        }
        let [alone, other, two, two_before, three] =
            [last, before, last + before, before + first, last + before + first].map(|change| self.after(change));
        let none = self.after(0);
        [alone - none, two - alone - other + none, three - two_before - two + other]
    }

    /// The square after a change, where the model counts as limited; at most 2^26.
    fn after(self, change: i32) -> Squares {
        let (least, greatest) = self.limited.range();
        let left = (self.residual - change).clamp(least, greatest).clamp(-LIMIT, LIMIT);
        product(left, left)
    }
}

/// Sums over a layer's pixels, for each code stripe, in 2^-8 squared grey levels, saturating.
#[derive(Clone, Debug, Default)]
struct Sums {
    stripes: [StripeSums; 16],
}

/// The sums of one stripe.
#[derive(Clone, Copy, Debug, Default)]
struct StripeSums {
    /// `Σ (d² - 2 r d)`, or `Σ f(d)`: what its change alone does.
    alone: Squares,
    /// `Σ 2 d d'`, or what stands for it, with the change of the stripe before it and of the one before that.
    with_before: [Squares; 2],
}

impl Sums {
    /// Adds a pixel.
    fn add(&mut self, inks: &PixelInks<'_>, seen: SeenPixel, change: impl Fn(i32) -> i32, half_word: u16) {
        let mut before = [0; 2];
        let places = self.stripes.iter_mut().skip(usize::from(inks.first));
        for (sums, (stripe, ink)) in places.zip(inks.stripes()) {
            let size = change(ink);
            let changed = if is_bar(inks.format, half_word, stripe) { -size } else { size };
            let [alone, with_before @ ..] = seen.squares([changed, before[0], before[1]]);
            sums.alone = sums.alone.saturating_add(alone);
            for (sum, with) in sums.with_before.iter_mut().zip(with_before) {
                *sum = sum.saturating_add(with);
            }
            before = [changed, before[0]];
        }
    }

    /// The least change: of one stripe, of two neighbours that differ, of three of which each differs from the next.
    fn least(&self, format: Format, half_word: u16) -> Squares {
        let mut least = Squares::MAX;
        // The stripe before and the one before that, each with the sum of a change that ends with it.
        let (mut one_before, mut two_before) = (None, None);
        for (stripe, sums) in (0..format.code_stripes()).zip(&self.stripes) {
            let [with_first, with_second] = sums.with_before;
            let alone = sums.alone;
            least = least.min(alone);
            let differs = stripe > 0 && is_bar(format, half_word, stripe) != is_bar(format, half_word, stripe - 1);
            let with = |before: Option<Squares>, cross: Squares| {
                before.filter(|_| differs).map(|before| before.saturating_add(alone).saturating_add(cross))
            };
            let two = with(one_before, with_first);
            let three = with(two_before, with_first.saturating_add(with_second));
            least = [two, three].into_iter().flatten().fold(least, Squares::min);
            (one_before, two_before) = (Some(alone), two);
        }
        least
    }
}

/// A product of two values of 6 fraction bits, with 8, rounded; below 2^30 before it is.
fn product(x: i32, y: i32) -> Squares {
    (x * y + (1 << 3)) >> 4
}

/// Twice a product.
fn twice(x: i32, y: i32) -> Squares {
    (x * y + (1 << 2)) >> 3
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// `f` of the module's equations, in floating point, where nothing is limited to [`LIMIT`].
        #[test]
        fn squares_are_those_of_the_changed_model(
            residual in -250..250_i32,
            changes in prop::array::uniform3(-80 << 6..80_i32 << 6),
            limited in prop_oneof![Just(Limited::Not), Just(Limited::Bright), Just(Limited::Dark)],
        ) {
            let residual = residual << 6;
            let after = |change: i32| {
                let left = f64::from(residual - change) / 64.0;
                let counted = match limited {
                    Limited::Not => left,
                    Limited::Bright => left.max(0.0),
                    Limited::Dark => left.min(0.0),
                };
                counted * counted
            };
            let [j, i, h] = changes;
            let exact = [
                after(j) - after(0),
                after(i + j) - after(i) - after(j) + after(0),
                after(h + i + j) - after(h + i) - after(i + j) + after(i),
            ];
            let found = SeenPixel { residual, limited }.squares(changes);
            for (found, exact) in found.into_iter().zip(exact) {
                // Four products, each rounded to half of 2^-8.
                prop_assert!((f64::from(found) / 256.0 - exact).abs() <= 2.0 / 256.0, "{} {}", found, exact);
            }
        }
    }

    #[test]
    fn products_are_rounded_to_nearest() {
        // Products of 12 fraction bits, to 8.
        assert_eq!([7, 8, 9, -8, -9].map(|x| product(x, 1)), [0, 1, 1, 0, -1]);
        assert_eq!([3, 4, 5, -4, -5].map(|x| twice(x, 1)), [0, 1, 1, 0, -1]);
        assert_eq!([1, 2, 3, -2, -3].map(limited), [0, 1, 1, 0, -1]);
    }

    /// Of 2^9 grey levels the last value of 6 fraction bits of which a product is below 2^30.
    #[test]
    fn what_is_limited_has_products_below_30_bits() {
        for (grey, sign) in [(i32::MAX - 2, 1), (i32::MIN, -1)] {
            let size = limited(grey) * sign;
            assert!(size * size < 1 << 30 && (size + 1) * (size + 1) >= 1 << 30, "{size}");
        }
    }
}
