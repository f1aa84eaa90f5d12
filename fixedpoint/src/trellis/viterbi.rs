//! The Viterbi algorithm over the code stripes of one layer.

use crate::light::Limited;

/// How many stripes a pixel depends on: the one that it is counted with and the 4 before it (`TRELLIS-5`).
pub const REACH: usize = 5;

/// The most code stripes of a layer.
const MAX_STRIPES: usize = 16;

/// Fraction bits of what a pixel and the model are apart.
pub const RESIDUAL_BITS: u8 = 8;

/// Fraction bits of the residuals that are squared, and of their squares.
const SQUARED_BITS: u8 = 4;

/// How many pixels' squares add up with 4 fraction bits.
const FINE_PIXELS: u16 = 62;

/// The search for the colours of code stripes that explain a layer's pixels best.
///
/// A state is the colours of the last 4 stripes, black as 1, the last one in bit 0. Stripes before the first are spaces.
#[derive(Clone, Debug)]
pub struct Viterbi {
    /// The least sum of squares, in 2^-4 squared grey levels or in whole ones, on any way to a state; the largest value for no way.
    states: [u32; 16],
    /// The sum over the pixels of the current stripe for a state (bits 4 to 1) and the stripe's colour (bit 0).
    branches: [u32; 32],
    /// For each stripe that is done, and each state after it, whether the best way to it came from a bar 4 stripes ago.
    survivors: [u16; MAX_STRIPES],
    /// The current stripe.
    stripe: u8,
    /// What is dropped of the fraction bits of squares.
    dropped: u8,
}

impl Viterbi {
    /// The search in a window of so many pixels, 992 at most, before its first stripe.
    ///
    /// Of a window that is wider than `EXTENT-2` and `FIT-1` leave them (`TRELLIS-9`) squares are in whole squared grey levels.
    #[must_use]
    pub fn new(pixels: u16) -> Self {
        let dropped = if pixels <= FINE_PIXELS { SQUARED_BITS } else { 2 * SQUARED_BITS };
        let mut states = [u32::MAX; 16];
        if let Some(spaces) = states.first_mut() {
            *spaces = 0;
        }
        Self { states, branches: [0; 32], survivors: [0; MAX_STRIPES], stripe: 0, dropped }
    }

    /// The current stripe, 0 for the first code stripe.
    #[must_use]
    pub fn stripe(&self) -> u8 {
        self.stripe
    }

    /// Counts a pixel with the current stripe. `residual` is its value less that of the model with spaces only, and
    /// `steps` how much less the model has if the stripe 4, 3, 2, 1, 0 before the current one is a bar; all in units of
    /// 2^-8 grey level. What is left with any bars is at most 1788 grey levels: that of [`crate::light::Seen`]'s excess and
    /// gain. What a limited pixel is beyond its model counts as 0 (`TRELLIS-11`), so that nothing grows by it.
    ///
    /// Rounding errors: of each residual 2^-5 grey levels, of each square 2^-4 squared grey levels, downwards, or 1 of a wide
    /// window. Squares are below 2^25.7, so that those of 62 pixels, all those of a window of `EXTENT-2` and `FIT-1`, add up
    /// to less than 2^32, and those of 992 in whole squared grey levels.
    pub fn count(&mut self, residual: i32, steps: [i32; REACH], limited: Limited) {
        let [fourth, third, second, first, current] = steps;
        let low = [0, current, first, first + current];
        let high = [0, second, third, third + second];
        let (least, greatest) = limited.range();
        let half = 1 << (RESIDUAL_BITS - SQUARED_BITS - 1);
        let bases = [0, fourth].into_iter().flat_map(|fourth| high.map(|high| residual + half + fourth + high));
        for (branches, base) in self.branches.chunks_exact_mut(4).zip(bases) {
            for (branch, step) in branches.iter_mut().zip(low) {
                let rounded = ((base + step) >> (RESIDUAL_BITS - SQUARED_BITS)).clamp(least, greatest);
                *branch = branch.wrapping_add(rounded.wrapping_mul(rounded).unsigned_abs() >> self.dropped);
            }
        }
    }

    /// Goes on to the next stripe. Of two ways that are equally good the one over a space stays.
    pub fn advance(&mut self) {
        let mut survivors = 0_u16;
        let before = self.states;
        let (over_space, over_bar) = before.split_at(8);
        let (from_space, from_bar) = self.branches.split_at(16);
        for (state, after) in (0_u8..).zip(self.states.iter_mut()) {
            let (index, previous) = (usize::from(state), usize::from(state / 2));
            let way = |states: &[u32], branches: &[u32]| match (states.get(previous), branches.get(index)) {
                (Some(&sum), Some(&branch)) => sum.saturating_add(branch),
                _ => u32::MAX,
            };
            let (space, bar) = (way(over_space, from_space), way(over_bar, from_bar));
            *after = space.min(bar);
            if bar < space {
                survivors |= 1 << state;
            }
        }
        if let Some(place) = self.survivors.get_mut(usize::from(self.stripe)) {
            *place = survivors;
        }
        self.branches = [0; 32];
        self.stripe = self.stripe.saturating_add(1);
    }

    /// The best colours of all stripes that are done, black as 1, the first stripe as the most significant bit.
    #[must_use]
    pub fn half_word(&self) -> u16 {
        let best = (0_u16..).zip(self.states).min_by_key(|&(_, sum)| sum); // the first of equals
        let mut state = best.map_or(0, |(state, _)| state);
        let mut word = 0_u16;
        let done = self.survivors.iter().take(usize::from(self.stripe)).enumerate();
        for (stripe, &survivors) in done.rev() {
            let place = usize::from(self.stripe) - 1 - stripe;
            word |= (state & 1) << place;
            state = state >> 1 | (survivors >> state & 1) << 3;
        }
        word
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // of pixels and stripes

    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// The stripe that a pixel is counted with, its residual, its steps and whether it is limited.
    type Pixel = (u8, i32, [i32; REACH], Limited);

    fn found(window: u16, stripes: u8, pixels: &[Pixel]) -> u16 {
        let mut viterbi = Viterbi::new(window);
        for stripe in 0..stripes {
            for &(_, residual, steps, limited) in pixels.iter().filter(|pixel| pixel.0 == stripe) {
                viterbi.count(residual, steps, limited);
            }
            viterbi.advance();
        }
        viterbi.half_word()
    }

    /// 15 units of 2^-4 and five eighths, and three sixteenths.
    #[test]
    fn residuals_are_rounded_to_nearest() {
        for (residual, rounded) in [(15 * 16 + 10, 16_i32), (15 * 16 + 3, 15), (-15 * 16 - 10, -16)] {
            let mut viterbi = Viterbi::new(1);
            viterbi.count(residual, [0; REACH], Limited::Not);
            assert_eq!(viterbi.branches, [(rounded * rounded).unsigned_abs() >> 4; 32], "{residual}");
        }
    }

    /// The sum of squares of a half word in 2^-16 squared grey levels, without any rounding.
    fn sum(stripes: u8, pixels: &[Pixel], word: u16) -> i64 {
        let square = |&(stripe, residual, steps, limited): &Pixel| {
            let bar = |index: usize| {
                let place = i32::from(stripes) - 1 - (i32::from(stripe) - 4 + index as i32);
                place < i32::from(stripes) && word >> place & 1 == 1
            };
            let steps: i32 = steps.iter().enumerate().filter(|&(index, _)| bar(index)).map(|(_, step)| step).sum();
            let beyond = match limited {
                Limited::Not => false,
                Limited::Bright => residual + steps < 0,
                Limited::Dark => residual + steps > 0,
            };
            if beyond { 0 } else { i64::from(residual + steps).pow(2) }
        };
        pixels.iter().map(square).sum()
    }

    /// Pixels in whole quarters of a grey level, which are squared exactly.
    fn pixel(stripes: u8) -> impl Strategy<Value = Pixel> {
        let step = (0..600_i32).prop_map(|step| 64 * step);
        let residual = (-1020..25_i32).prop_map(|residual| 64 * residual);
        let limited = prop_oneof![3 => Just(Limited::Not), 1 => Just(Limited::Bright), 1 => Just(Limited::Dark)];
        (0..stripes, residual, [step.clone(), step.clone(), step.clone(), step.clone(), step], limited)
    }

    /// Where no pixel says anything all stripes are spaces, and so the way over a space is the one that stays.
    #[test]
    fn of_equals_the_space_stays() {
        let mut search = Viterbi::new(40);
        (0..12).for_each(|_| search.advance());
        assert_eq!(search.half_word(), 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn no_other_half_word_is_better(
            (stripes, pixels) in (1_u8..=9).prop_flat_map(|n| (Just(n), prop::collection::vec(pixel(n), 0..30)))
        ) {
            let word = found(62, stripes, &pixels);
            prop_assert!(word < 1 << stripes);
            let least = (0..1_u16 << stripes).map(|word| sum(stripes, &pixels, word)).min();
            prop_assert_eq!(Some(sum(stripes, &pixels, word)), least);
        }
    }

    /// 62 pixels of 1788 grey levels, in one stripe and in several, with what would be better at the limit.
    #[test]
    fn no_sum_overflows() {
        for residual in [-1788 << 8, (1788 - 510) << 8] {
            let pixel = |stripe: u8| (stripe, residual, [102 << 8; REACH], Limited::Not);
            for window in [62_u16, 992] {
                let spread = (0..window).map(|i| pixel((16 * u32::from(i) / u32::from(window)) as u8));
                for pixels in [std::vec![pixel(15); usize::from(window)], spread.collect::<Vec<_>>()] {
                    let expected = if residual < 0 { 0xFFFF } else { 0 };
                    let seen = pixels.iter().fold(0_u32, |seen, pixel| seen | 0x1F << (15 - pixel.0)) as u16;
                    assert_eq!(found(window, 16, &pixels) & seen, expected & seen);
                }
            }
        }
    }

    #[test]
    fn the_first_stripe_is_the_most_significant_bit() {
        // Each pixel is 100 grey levels darker than white, or as bright, and depends on its own stripe alone.
        for word in [0xA5C3_u16, 0xFFFF, 0x8000, 1, 0] {
            let black = |stripe: u8| word >> (15 - stripe) & 1 == 1;
            let value = |stripe: u8| if black(stripe) { -100 << 8 } else { 0 };
            let pixels: Vec<Pixel> =
                (0..16).map(|stripe| (stripe, value(stripe), [0, 0, 0, 0, 100 << 8], Limited::Not)).collect();
            assert_eq!(found(62, 16, &pixels), word);
        }
    }
}
