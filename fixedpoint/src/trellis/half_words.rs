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
//= reference/SPEC.md#trellis
//# - **TRELLIS-5** The half word of a layer MUST be the one with the smallest sum of squared differences between the
//# pixels and their model (TRELLIS-11) over the layer's window but for the pixel of a step of light, found by the
//# Viterbi algorithm over states of 4 code stripes, a pixel being counted with the last code stripe of `w_ij > 2^-8` as
//# one that depends on this and the 4 code stripes before it.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::edge::Blur;
    use crate::formats::{Column, Obliquity};
    use crate::homography::Homography;

    /// `TRELLIS-4` and `TRELLIS-5` for every pixel of barcodes that are seen from the left and from the right.
    #[test]
    fn a_pixel_counts_with_the_last_stripe_that_it_depends_on() {
        let views = [(Format::Paper, 13.0, 0.0), (Format::Paper, 20.0, 0.3), (Format::Wide, 16.0, -0.3)];
        // Sharp, and as blurred as can be in 15 places: an edge's ink may be more than 2^-8 where its stripe's is not.
        let seen = |shift: u8| (Column::from_num(shift) / 16, if shift == 0 { Blur::START } else { Blur::LARGEST });
        for ((format, s, k), shift) in views.into_iter().flat_map(|view| (0..16).map(move |shift| (view, shift))) {
            let (a, blur) = seen(shift);
            let homography = Homography { a, s: Column::from_num(s), k: Obliquity::from_num(k) };
            let edges = Edges::new(format, &homography, Blur::new(blur), &Camera::epuck());
            let least = (1 << 16) / 256; // 2^-8
            let depends = |stripe: u8, pixel: u16| edges.stripe(4 + stripe, pixel) > least; // after four of the guard
            let (mut last, mut reached) = (0, 0);
            for pixel in 200..280 {
                let expected = (0..format.code_stripes()).rev().find(|&stripe| depends(stripe, pixel)).unwrap_or(last);
                last = last_stripe(format, &edges, pixel, last);
                assert_eq!(last, expected, "{pixel}");
                let inks = code_inks(&edges, pixel, last);
                let within = last.saturating_sub(4)..=last;
                assert_eq!(inks.is_some(), within.clone().any(|stripe| depends(stripe, pixel)), "{pixel}");
                for (place, stripe) in within.rev().enumerate().filter(|_| inks.is_some()) {
                    assert_eq!(inks.unwrap()[4 - place], edges.stripe(4 + stripe, pixel), "{pixel} {stripe}");
                }
                reached += u32::from(inks.is_some());
            }
            assert!((reached..80).contains(&(reached + 10)) && last + 1 == format.code_stripes());
        }
    }
}
