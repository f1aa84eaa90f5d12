//! Whether what a barcode leaves unexplained looks like noise: how the residuals of near pixels go together.

use crate::fit::{FitLayer, LayerLight};
use crate::ink::Edges;
use crate::landmark::Format;
use crate::light::{Limited, LitLayer};

/// Sums of products of two residuals, over one layer or both, in 2^-16 squared grey levels.
///
/// A residual is within ±1788 grey levels, that of [`crate::light::Seen`]'s excess and gain, so that a sum over twice 640 px
/// is within ±2^48.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Correlations {
    /// Over the pairs of neighbours.
    pub neighbours: i64,
    /// Over the pairs with one pixel between them, whether that was fitted or not.
    pub one_between: i64,
    /// `n`, how many pixels were fitted in these, at most 1280.
    pub pixels: u16,
}

impl Correlations {
    /// Adds the products of a pixel's residual with those of the last pixel and of the one before.
    fn add(&mut self, residual: i32, [last, before]: [Option<i32>; 2]) {
        let product = |other: Option<i32>| other.map_or(0, |other| i64::from(residual) * i64::from(other));
        self.neighbours += product(last);
        self.one_between += product(before);
        self.pixels = self.pixels.saturating_add(1);
    }
}

/// The correlations of what one layer or both leave unexplained (`ACCEPT-15`), over the pixels that were fitted: those of the
/// window (`FIT-1`) that are neither limited (`FIT-5`) nor that of the step of light (`FIT-4`).
///
/// The sums are exact in the residuals; the errors of these are those of [`crate::light::Seen`] and of the ink.
#[must_use]
pub fn correlations(format: Format, edges: &Edges, layers: &[FitLayer<'_>], lights: &[LayerLight]) -> Correlations {
    let mut sums = Correlations::default();
    for (layer, light) in layers.iter().zip(lights) {
        let lit = LitLayer::new(layer, format, light);
        let mut before = [None; 2];
        for pixel in lit.first_pixel()..=lit.last_pixel() {
            let seen = lit.at(pixel).filter(|seen| seen.limited == Limited::Not);
            let residual = seen.map(|seen| seen.residual(edges.layer(format, layer.stripes, pixel)));
            if let Some(residual) = residual {
                sums.add(residual, before);
            }
            let [last, _] = before;
            before = [residual, last];
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    #![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of numbers that are small and positive

    use super::*;
    use crate::camera::Camera;
    use crate::codeword::encode;
    use crate::drawing::View;
    use crate::edge::Blur;
    use crate::fit;
    use crate::formats::{Column, Obliquity};
    use crate::homography::Homography;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use std::vec::Vec;

    fn edges(view: &View) -> Edges {
        let homography =
            Homography { a: Column::from_num(view.a), s: Column::from_num(view.s), k: Obliquity::from_num(view.k) };
        Edges::new(view.format, &homography, Blur::new(Column::from_num(view.blur)), &Camera::epuck())
    }

    /// The residuals of a layer's window, none where a pixel is not fitted: `FIT-1` to `FIT-5` as they stand.
    fn residuals(view: &View, layer: &FitLayer<'_>, half_word: u16, light: &LayerLight) -> Vec<Option<f64>> {
        let (first, last) = (usize::from(layer.first_pixel), usize::from(layer.last_pixel));
        let beside = 4.min(2 * (last - first + 1) / usize::from(view.format.stripes()));
        let (l, r) = (first - beside, last + beside);
        let ink = view.ink(480, half_word);
        let [o, g, o_slope, g_slope] =
            [light.offset, light.gain, light.offset_slope, light.gain_slope].map(|grey| f64::from(grey) / 256.0);
        let residual = |i: usize| {
            let lambda = match light.step.map(usize::from) {
                Some(step) if i == step => return None,
                Some(step) => {
                    if i < step {
                        -1.0
                    } else {
                        1.0
                    }
                }
                None => (2.0 * i as f64 - (l + r) as f64) / (r - l) as f64,
            };
            let model = o + g * ink[i] + lambda * (o_slope + g_slope * ink[i]);
            (1..255).contains(&layer.line[i]).then(|| f64::from(layer.line[i]) - model)
        };
        (l..=r).map(residual).collect()
    }

    /// `ACCEPT-15` against the equations. A residual is off by less than 0.1 grey levels, see `accept`'s test of the margin,
    /// and so a product by 0.1 times both residuals and 0.01. Some pixels are limited, one is a step's.
    #[test]
    fn sums_are_those_of_the_equations() {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        for (format, pixels, angle) in [(Format::Paper, 1.5, 0.2), (Format::Wide, 3.0, -0.6), (Format::Paper, 6.0, 0.0)]
        {
            let view = View { white: 250.0, noise: 4.0, ..View::turned(format, pixels, angle) };
            let (upper, lower) = encode(format, 0xBEEF).unwrap();
            let mut lines = [upper, lower].map(|half_word| view.line(480, half_word, &mut random));
            let [first_pixel, last_pixel] =
                [view.column(-1.0) + 0.5, view.column(1.0) - 0.5].map(|column| column.round() as u16);
            // In the step's shadow a pixel is 0, and beside it there is one whose only fitted neighbour is two pixels off.
            (lines[0][235], lines[1][240]) = (0, 0);
            for step in [None, Some(238)] {
                let light =
                    LayerLight { offset: 245 << 8, gain: -155 << 8, offset_slope: 9 << 8, gain_slope: -7 << 8, step };
                let layer = |line, half_word| FitLayer {
                    line,
                    first_pixel,
                    last_pixel,
                    stripes: fit::stripes(format, half_word),
                };
                let layers = [layer(&lines[0], upper), layer(&lines[1], lower)];
                let found = correlations(format, &edges(&view), &layers, &[light; 2]);
                let (mut count, mut sums, mut bounds) = (0, [0.0; 2], [0.0; 2]);
                for (layer, half_word) in layers.iter().zip([upper, lower]) {
                    let left = residuals(&view, layer, half_word, &light);
                    count += left.iter().flatten().count();
                    for distance in [1, 2] {
                        let pairs = left.iter().zip(&left[distance..]).filter_map(|(one, other)| one.zip(*other));
                        for (one, other) in pairs {
                            sums[distance - 1] += one * other;
                            bounds[distance - 1] += 0.1 * (one.abs() + other.abs()) + 0.01;
                        }
                    }
                }
                assert_eq!(usize::from(found.pixels), count, "{view:?}");
                let found = [found.neighbours, found.one_between].map(|sum| sum as f64 / 65536.0);
                for ((found, exact), bound) in found.into_iter().zip(sums).zip(bounds) {
                    assert!((found - exact).abs() <= bound, "{found} {exact} {bound} {view:?} {step:?}");
                }
            }
        }
    }

    /// The sums do not overflow where all of a line of 640 px is as far from its model as can be.
    #[test]
    fn no_sum_overflows() {
        let line = [254_u8; 640];
        let light = LayerLight { offset: -511 << 8, gain: -511 << 8, ..LayerLight::default() };
        let light = LayerLight { offset_slope: -511 << 8, step: Some(0), ..light };
        let view = View::turned(Format::Wide, 26.0, 0.0);
        let layer = FitLayer { line: &line, first_pixel: 4, last_pixel: 635, stripes: u32::MAX >> 8 };
        let found = correlations(Format::Wide, &edges(&view), &[layer; 2], &[light; 2]);
        // 640 px but for the step's; 254 + 1022 grey levels at least, of white, and 511 more of black.
        assert_eq!(found.pixels, 1278);
        assert!(found.neighbours >= (1276 * 638 * 2) << 16 && found.neighbours < 1 << 48);
        assert!(found.one_between <= found.neighbours);
    }
}
