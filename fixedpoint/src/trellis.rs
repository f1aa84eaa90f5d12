//! The most likely code word of a pair of extents: maximum-likelihood sequence detection.
//!
//! The guards say where the barcode is, well enough to know how much of a pixel each stripe of the code covers; the
//! half words that explain the pixels best are found for that, and the fit with these half words says it better.

pub mod half_words;
pub mod viterbi;

use crate::camera::Camera;
use crate::edge::Blur;
use crate::extents::Extent;
use crate::fit::{self, FitLayer, Fitted, Illumination, Start};
use crate::formats::{Column, Obliquity};
use crate::homography::Homography;
use crate::ink::Edges;
use crate::landmark::Format;
use crate::light::LitLayer;
use crate::merge::Reading;
use crate::observer::Observer;
use crate::refusal::CandidateRefusal;

/// How often the half words may be fitted (`TRELLIS-7`).
const FITS: u8 = 3;

/// A pair of extents whose half words have settled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settled {
    /// Upper and lower.
    pub half_words: [u16; 2],
    /// The fit with these.
    pub fitted: Fitted,
}

/// Finds the half words of a pair of extents, upper and lower (`TRELLIS-1` to `TRELLIS-7`).
///
/// # Errors
/// `NoFit` if a fit is refused, the guard fit included (`ACCEPT-11`), and `Unsettled`.
//= reference/SPEC.md#accept
//# - **ACCEPT-11** A pair of extents of which a fit is refused MUST be refused (`NoFit`).
pub fn decode<O: Observer>(
    lines: [&[u8]; 2],
    extents: [Extent; 2],
    format: Format,
    camera: &Camera,
    observer: &mut O,
) -> Result<Settled, CandidateRefusal> {
    let [upper, lower] = lines;
    let [above, below] = extents;
    let pair = Pair { layers: [layer(upper, above), layer(lower, below)], format, camera };
    let start = guard_start(above, below, camera);
    let layers = pair.with([0; 2]);
    let guards = fit::fit_guards(&layers, &start, camera, format).map_err(|_| CandidateRefusal::NoFit)?;
    let half_words = pair.half_words(&guards).ok_or(CandidateRefusal::NoFit)?;
    let start = Start { homography: guards.homography, blur: guards.blur };
    pair.settle(half_words, &start, Illumination::Even, observer)
}

/// Finds the half words of a pair of layers again under a step of light, from those that were read there, upper and lower,
/// and the merged homography (`TRELLIS-9`).
///
/// # Errors
/// `NoFit` if a fit is refused (`ACCEPT-11`), and `Unsettled`.
//= reference/SPEC.md#trellis
//# - **TRELLIS-9** A pair of layers of which at least one was found by the local threshold and whose code word CODE-8
//# refuses MUST be decided again as one of EXTENT-7's pairs: fitted under a step of light from the merged homography,
//# with the half words as they were read and a blur of 1/2, and then as TRELLIS-6 to TRELLIS-8 say, each fit from the
//# one before it, under a step of light.
pub fn decode_again<O: Observer>(
    lines: [&[u8]; 2],
    readings: [Reading; 2],
    merged: &Homography,
    format: Format,
    camera: &Camera,
    observer: &mut O,
) -> Result<Settled, CandidateRefusal> {
    let [upper, lower] = lines;
    let [above, below] = readings.map(|reading| (reading.first_pixel, reading.last_pixel));
    let pair = Pair { layers: [layer(upper, above), layer(lower, below)], format, camera };
    let half_words = readings.map(|reading| reading.half_word);
    pair.settle(half_words, &Start::at(merged), Illumination::Step, observer)
}

/// A layer of an extent, without stripes yet.
fn layer(line: &[u8], (first_pixel, last_pixel): Extent) -> FitLayer<'_> {
    FitLayer { line, first_pixel, last_pixel, stripes: 0 }
}

/// Where the guard fit starts, exactly: between the means of both extents' outer edges (`TRELLIS-1`).
//= reference/SPEC.md#trellis
//# - **TRELLIS-1** The *guard fit* MUST be FIT with all stripes of the code as spaces, without λ (`o' = g' = 0`, p = 4
//# + 2 per layer), over both layers, with a `k` of 0 and the means of both extents' outer edges `first - 1/2` and `last
//# + 1/2` as start.
fn guard_start(upper: Extent, lower: Extent, camera: &Camera) -> Start {
    let first = i32::from(upper.0) + i32::from(lower.0);
    let last = i32::from(upper.1) + i32::from(lower.1);
    // Quarters of a pixel, in 2^-20; the halves of the outer edges cancel in the middle and add up in the width.
    let a = Column::from_bits((first + last) << 18).saturating_sub(camera.principal_column());
    let s = Column::from_bits((last - first + 2) << 18);
    Start::at(&Homography { a, s, k: Obliquity::ZERO })
}

/// A pair of extents.
struct Pair<'a> {
    layers: [FitLayer<'a>; 2],
    format: Format,
    camera: &'a Camera,
}

impl<'a> Pair<'a> {
    /// The layers with these half words.
    fn with(&self, half_words: [u16; 2]) -> [FitLayer<'a>; 2] {
        let mut layers = self.layers;
        for (layer, half_word) in layers.iter_mut().zip(half_words) {
            layer.stripes = fit::stripes(self.format, half_word);
        }
        layers
    }

    /// Fits the half words and finds them again until they stay the same (`TRELLIS-6`, `TRELLIS-7`).
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-6** Both layers MUST then be fitted with these half words (FIT) from the guard fit's `(a, s, k, σ)`,
    //# and the half words be found again by the fit's model, and fitted from its `(a, s, k, σ)`, until they are the
    //# same as before.
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-7** A pair MUST be refused (`Unsettled`) whose half words have changed after the third fit.
    fn settle<O: Observer>(
        &self,
        mut half_words: [u16; 2],
        start: &Start,
        illumination: Illumination,
        observer: &mut O,
    ) -> Result<Settled, CandidateRefusal> {
        let mut start = *start;
        for _ in 0..FITS {
            let layers = self.with(half_words);
            let fitted = fit::fit(&layers, &start, self.camera, self.format, illumination);
            observer.fitted(fitted.as_ref().map_err(|refusal| *refusal));
            let fitted = fitted.map_err(|_| CandidateRefusal::NoFit)?;
            let before = half_words;
            half_words = self.half_words(&fitted).ok_or(CandidateRefusal::NoFit)?;
            if half_words == before {
                return Ok(Settled { half_words, fitted });
            }
            start = Start { homography: fitted.homography, blur: fitted.blur };
        }
        Err(CandidateRefusal::Unsettled)
    }

    /// The half words by the model of a fit (`TRELLIS-5`); there are always both layers' lights.
    #[inline(never)] // what it keeps on the stack is not there during the fits
    fn half_words(&self, fitted: &Fitted) -> Option<[u16; 2]> {
        let edges = Edges::new(self.format, &fitted.homography, Blur::new(fitted.blur), self.camera);
        let ([upper, lower], [above, below]) = (&self.layers, fitted.lights.as_slice()) else { return None };
        let lit = [LitLayer::new(upper, self.format, above), LitLayer::new(lower, self.format, below)];
        Some(half_words::half_words(self.format, &edges, &lit))
    }
}

#[cfg(test)]
mod tests;
