//! Lines for the tests, drawn by hand.

use crate::landmark::{Format, GUARD_PAIRS};
use std::vec::Vec;

/// A line of runs of these widths, white (255) and black (0) by turns, white first.
pub(crate) fn runs(widths: &[usize]) -> Vec<u8> {
    let values = [255_u8, 0].into_iter().cycle();
    widths.iter().zip(values).flat_map(|(&width, value)| std::iter::repeat_n(value, width)).collect()
}

/// A layer's stripes from left to right, true for black (`LAND-3`, `CODE-3`).
pub(crate) fn stripes(format: Format, half_word: u16) -> Vec<bool> {
    let guard = [true, false].repeat(usize::from(GUARD_PAIRS));
    let code = (0..format.code_stripes()).rev().map(|bit| half_word >> bit & 1 == 1);
    guard.iter().copied().chain(code).chain(guard.iter().rev().copied()).collect()
}

/// Draws stripes of `width` pixels each, the left one from the pixel `first` on.
pub(crate) fn draw(line: &mut [u8], first: usize, width: usize, stripes: &[bool]) {
    for (stripe, &black) in stripes.iter().enumerate() {
        let start = first + stripe * width;
        line[start..start + width].fill(if black { 0 } else { 255 });
    }
}

/// Draws stripes of one and a half pixels each, the left one from the pixel `first` on; half a pixel of black is 128, white.
pub(crate) fn draw_halves(line: &mut [u8], first: usize, stripes: &[bool]) {
    for (stripe, _) in stripes.iter().enumerate().filter(|(_, black)| **black) {
        for half in 3 * stripe..3 * stripe + 3 {
            let pixel = &mut line[first + half / 2];
            *pixel = if *pixel == 255 { 128 } else { 0 };
        }
    }
}
