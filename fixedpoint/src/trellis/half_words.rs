//! The most likely half words of both layers, for a given model of their pixels.

use super::viterbi::{REACH, Viterbi};
use crate::ink::{Edges, WHOLE};
use crate::landmark::{Format, GUARD_PAIRS};
use crate::light::LitLayer;

/// A stripe's ink in a pixel above which the pixel counts as one that depends on it (`TRELLIS-5`), 2^-8 in units of 2^-16.
const LEAST_INK: i32 = WHOLE >> 8;

/// The half words with the smallest sums of squares over the layers' windows (`TRELLIS-5`), upper and lower.
///
/// Both layers have the same edges, so that a pixel's inks are found once.
#[must_use]
pub fn half_words(format: Format, edges: &Edges, layers: &[LitLayer<'_>; 2]) -> [u16; 2] {
    let [upper, lower] = layers;
    let mut searches = [upper, lower].map(|layer| Viterbi::new(layer.last_pixel() - layer.first_pixel() + 1));
    let mut last = 0;
    let pixels = upper.first_pixel().min(lower.first_pixel())..=upper.last_pixel().max(lower.last_pixel());
    for pixel in pixels {
        last = last_stripe(format, edges, pixel, last);
        let Some(inks) = code_inks(edges, pixel, last) else { continue };
        let guards = guards(format, edges, pixel);
        for (search, layer) in searches.iter_mut().zip(layers) {
            if let Some(seen) = layer.at(pixel) {
                while search.stripe() < last {
                    search.advance();
                }
                search.count(seen.residual(guards), inks.map(|ink| -seen.change(ink)), seen.limited);
            }
        }
    }
    searches.map(|mut search| {
        while search.stripe() < format.code_stripes() {
            search.advance();
        }
        search.half_word()
    })
}

/// The last code stripe that a pixel depends on, or the one of the pixel before it, `last`, if it depends on none.
///
/// The ink of an edge falls from the left to the right, so the search ends at the first edge without.
fn last_stripe(format: Format, edges: &Edges, pixel: u16, mut last: u8) -> u8 {
    let mut left = edges.ink(2 * GUARD_PAIRS + last + 1, pixel);
    for stripe in last + 1..format.code_stripes() {
        if left <= LEAST_INK {
            break;
        }
        let right = edges.ink(2 * GUARD_PAIRS + stripe + 1, pixel);
        if left - right > LEAST_INK {
            last = stripe;
        }
        left = right;
    }
    last
}

/// The inks of the code stripe `last` and the 4 before it, the last one at the end, in units of 2^-16; 0 for those before
/// the first. `None` if the pixel depends on none of them.
///
/// Left of an edge beyond which all of the pixel lies there is no ink.
fn code_inks(edges: &Edges, pixel: u16, last: u8) -> Option<[i32; REACH]> {
    let mut inks = [0; REACH];
    let mut right = edges.ink(2 * GUARD_PAIRS + last + 1, pixel);
    for (ink, stripe) in inks.iter_mut().rev().zip((0..=last).rev()) {
        if right == WHOLE {
            break;
        }
        let left = edges.ink(2 * GUARD_PAIRS + stripe, pixel);
        *ink = left - right;
        right = left;
    }
    inks.iter().any(|&ink| ink > LEAST_INK).then_some(inks)
}

/// The ink of the guards' bars in a pixel, 0 to 2^16 in units of 2^-16 (`LAND-3`).
#[must_use]
pub fn guards(format: Format, edges: &Edges, pixel: u16) -> i32 {
    let inwards = 2 * GUARD_PAIRS - 1;
    let mut sum = 0;
    // Most pixels lie between the innermost edges of both guards.
    if edges.ink(inwards, pixel) != WHOLE {
        sum += (0..inwards).step_by(2).map(|bar| edges.stripe(bar, pixel)).sum::<i32>();
    }
    if edges.ink(format.stripes() - inwards, pixel) != 0 {
        sum += (0..inwards).step_by(2).map(|bar| edges.stripe(format.stripes() - 1 - bar, pixel)).sum::<i32>();
    }
    sum
}
