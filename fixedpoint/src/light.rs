//! The grey levels that a fit expects of a layer.

use crate::fit::{FitLayer, LayerLight};
use crate::landmark::Format;

/// A layer in the light that was fitted to it.
#[derive(Clone, Copy, Debug)]
pub struct LitLayer<'a> {
    line: &'a [u8],
    first_pixel: u16,
    last_pixel: u16,
    /// `1/(r - l)` of the window in 2^-24, rounded down.
    inverse: i32,
    light: LayerLight,
}

/// How the camera limits a pixel's value (`RENDER-5`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limited {
    /// It does not: 1 to 254.
    Not,
    /// 255, which may have been brighter.
    Bright,
    /// 0, which may have been darker.
    Dark,
}

impl Limited {
    fn of(value: u8) -> Self {
        match value {
            0 => Self::Dark,
            u8::MAX => Self::Bright,
            _ => Self::Not,
        }
    }

    /// The least and the greatest that a pixel can be apart from a model that counts as limited like it (`TRELLIS-11`):
    /// what a value of 255 is less than its model, and a value of 0 more, counts as 0. In any unit.
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-11** In TRELLIS-5 and ACCEPT-8 the model of a pixel of the value 255 MUST count as at most 255, and
    //# that of one of the value 0 as at least 0, since RENDER-5 limits what is brighter or darker.
    #[must_use]
    pub fn range(self) -> (i32, i32) {
        match self {
            Self::Not => (i32::MIN, i32::MAX),
            Self::Bright => (0, i32::MAX),
            Self::Dark => (i32::MIN, 0),
        }
    }
}

/// What a pixel is expected to be, less the ink in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// The pixel's value less that of a white one, in 2^-8 grey level, within ±1277 grey levels.
    pub excess: i32,
    /// What ink does to it, in 2^-8 grey level, within ±511 grey levels.
    pub gain: i32,
    /// Whether its value says only that it is at least as bright or as dark.
    pub limited: Limited,
}

impl Seen {
    /// The change of the model by some ink (0 to 2^16 in units of 2^-16), in 2^-8 grey level.
    ///
    /// Rounding errors, in grey levels: 2^-8 times the ink, 2^-15 times the gain, and 2^-9.
    #[must_use]
    pub fn change(&self, ink: i32) -> i32 {
        // 7 and 14 fraction bits: below 2^30.
        (((self.gain + 1) >> 1) * ((ink + 2) >> 2) + (1 << 12)) >> 13
    }

    /// The pixel less its model, which is not limited, in 2^-8 grey level.
    #[must_use]
    pub fn residual(&self, ink: i32) -> i32 {
        self.excess - self.change(ink)
    }
}

impl<'a> LitLayer<'a> {
    /// A layer in its light.
    #[must_use]
    pub fn new(layer: &FitLayer<'a>, format: Format, light: &LayerLight) -> Self {
        // FIT-1: floor(2 e/N) on either side, at most 4.
        let extent = layer.last_pixel.saturating_sub(layer.first_pixel).saturating_add(1);
        let beside = (extent / u16::from(format.stripes() / 2)).min(4);
        let end = u16::try_from(layer.line.len()).unwrap_or(u16::MAX).saturating_sub(1);
        let first_pixel = layer.first_pixel.saturating_sub(beside);
        let last_pixel = layer.last_pixel.saturating_add(beside).min(end);
        let inverse = (1 << 24) / i32::from(last_pixel.saturating_sub(first_pixel).max(1));
        Self { line: layer.line, first_pixel, last_pixel, inverse, light: *light }
    }

    /// The first pixel of the window.
    #[must_use]
    pub fn first_pixel(&self) -> u16 {
        self.first_pixel
    }

    /// The last pixel of the window.
    #[must_use]
    pub fn last_pixel(&self) -> u16 {
        self.last_pixel
    }

    /// What is expected of a pixel (`FIT-2`); `None` outside of the window and for the pixel of a step of light, which has no
    /// model (`FIT-4`).
    ///
    /// Rounding errors of the excess and of the gain, in grey levels: 2^-12 times the change along the window, and 2^-9.
    //= reference/SPEC.md#fit
    //# - **FIT-2** The model of pixel `i` MUST be `o + g c_i + λ_i (o' + g' c_i)` with its ink `c_i` (EDGE-2).
    #[must_use]
    pub fn at(&self, pixel: u16) -> Option<Seen> {
        if !(self.first_pixel..=self.last_pixel).contains(&pixel) || self.is_step(pixel) {
            return None;
        }
        self.anywhere(pixel)
    }

    /// What is expected of any pixel of the line, `λ` beyond the window being that of its nearest end (`ACCEPT-17`); `None`
    /// outside of the line. Of the pixel of a step of light it means nothing.
    ///
    /// The errors are those of [`Self::at`].
    #[must_use]
    pub fn anywhere(&self, pixel: u16) -> Option<Seen> {
        self.line.get(usize::from(pixel)).map(|&value| self.seen(pixel, value))
    }

    /// Whether it is the pixel of the layer's step of light (`FIT-4`).
    #[must_use]
    pub fn is_step(&self, pixel: u16) -> bool {
        self.light.step == Some(pixel)
    }

    fn seen(&self, pixel: u16, value: u8) -> Seen {
        let LayerLight { offset, gain, offset_slope, gain_slope, .. } = self.light;
        let lambda = if offset_slope == 0 && gain_slope == 0 { 0 } else { self.lambda(pixel) };
        // Slopes are limited to 2^17: the products are below 2^30.
        let along = |slope: i32| (slope * lambda + (1 << 11)) >> 12;
        let limit = 511 << 8;
        Seen {
            excess: (i32::from(value) << 8) - offset - along(offset_slope),
            gain: (gain + along(gain_slope)).clamp(-limit, limit),
            limited: Limited::of(value),
        }
    }

    /// `λ` of a pixel in 2^-12 (`FIT-3`, `FIT-4`), off by at most 2^-13 from rounding and 640 times 2^-24; beyond the window
    /// that of its nearest end (`ACCEPT-17`).
    fn lambda(&self, pixel: u16) -> i32 {
        let (first, last) = (i32::from(self.first_pixel), i32::from(self.last_pixel));
        let place = i32::from(pixel).min(last).max(first);
        match self.light.step {
            Some(step) if pixel < step => -(1 << 12),
            Some(_) => 1 << 12,
            // Within ±2^24, since the first factor is at most r - l.
            None => ((2 * place - first - last) * self.inverse + (1 << 11)) >> 12,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels 10 to 29, so that the window of `paper` is from 8 to 31.
    fn layer(line: &[u8], light: LayerLight) -> LitLayer<'_> {
        LitLayer::new(&FitLayer { line, first_pixel: 10, last_pixel: 29, stripes: 0 }, Format::Paper, &light)
    }

    #[test]
    fn the_window_is_two_pixels_wider_and_leaves_out_the_step() {
        let line = [100_u8; 40];
        let even = layer(&line, LayerLight::default());
        let counted = |layer: &LitLayer<'_>| (0..50).filter(|&pixel| layer.at(pixel).is_some()).count();
        assert_eq!((even.first_pixel(), even.last_pixel()), (8, 31));
        assert_eq!((even.at(7), even.at(32), counted(&even)), (None, None, 24));
        let step = layer(&line, LayerLight { step: Some(20), ..LayerLight::default() });
        assert_eq!((counted(&step), step.at(20)), (23, None));
        // At the line's end the window ends, too.
        assert_eq!(layer(&line[..30], LayerLight::default()).last_pixel(), 29);
    }

    #[test]
    fn limited_values_are_told() {
        let mut line = [100_u8; 40];
        (line[12], line[13], line[14], line[15]) = (0, 255, 1, 254);
        let seen = |pixel| layer(&line, LayerLight::default()).at(pixel).unwrap();
        let expected = [Limited::Dark, Limited::Bright, Limited::Not, Limited::Not];
        assert_eq!([12, 13, 14, 15].map(|pixel| seen(pixel).limited), expected);
        assert_eq!([12, 13, 14, 15].map(|pixel| seen(pixel).excess), [0, 255 << 8, 1 << 8, 254 << 8]);
        let stepped = layer(&line, LayerLight { step: Some(13), ..LayerLight::default() });
        assert_eq!(stepped.at(13), None);
    }

    #[test]
    fn light_changes_along_the_window() {
        let line = [100_u8; 40];
        let light =
            LayerLight { offset: 90 << 8, gain: -50 << 8, offset_slope: 8 << 8, gain_slope: -4 << 8, step: None };
        let ends = layer(&line, light);
        let seen = |excess: i32, gain: i32| Some(Seen { excess: excess << 8, gain: gain << 8, limited: Limited::Not });
        assert_eq!((ends.at(8), ends.at(31)), (seen(18, -46), seen(2, -54)));
        let step = layer(&line, LayerLight { step: Some(20), ..light });
        assert_eq!((step.at(19), step.at(21)), (seen(18, -46), seen(2, -54)));
    }

    /// `ACCEPT-17`: `λ` beyond the window is that of its nearest end.
    #[test]
    fn light_goes_on_beyond_the_window_as_at_its_ends() {
        let line = [100_u8; 40];
        let light =
            LayerLight { offset: 90 << 8, gain: -50 << 8, offset_slope: 8 << 8, gain_slope: -4 << 8, step: None };
        for step in [None, Some(20)] {
            let layer = layer(&line, LayerLight { step, ..light });
            assert!((0..=8).all(|pixel| layer.anywhere(pixel) == layer.at(8)));
            assert!((31..40).all(|pixel| layer.anywhere(pixel) == layer.at(31)));
            assert!((9..31).all(|pixel| layer.is_step(pixel) || layer.anywhere(pixel) == layer.at(pixel)));
            assert_eq!((layer.anywhere(40), (0..50).find(|&pixel| layer.is_step(pixel))), (None, step));
        }
    }

    /// `FIT-3`: half a unit, and 640 times 2^-12 of one.
    #[test]
    fn places_along_the_window_are_rounded_to_nearest() {
        let line = [100_u8; 40];
        let layer = layer(&line, LayerLight::default());
        for pixel in 8..=31_u16 {
            let exact = (2.0 * f64::from(pixel) - 39.0) / 23.0 * 4096.0;
            assert!((f64::from(layer.lambda(pixel)) - exact).abs() <= 0.5 + 640.0 / 4096.0, "{pixel}");
        }
    }

    #[test]
    fn light_is_rounded_to_nearest() {
        let line = [100_u8; 40];
        let seen = layer(&line, LayerLight { offset_slope: 1, ..LayerLight::default() }).at(30).unwrap();
        assert_eq!(seen.excess, (100 << 8) - 1); // 21/23 of a unit
        assert_eq!(Seen { gain: 2, ..seen }.change(5 << 12), 1); // five eighths
    }

    /// `FIT-3` with one of the slopes only.
    #[test]
    fn either_slope_is_enough() {
        let line = [100_u8; 40];
        let light = LayerLight { offset: 90 << 8, gain: -50 << 8, ..LayerLight::default() };
        let end = |light| layer(&line, light).at(31).map(|seen| (seen.excess >> 8, seen.gain >> 8));
        assert_eq!(end(LayerLight { offset_slope: 8 << 8, ..light }), Some((2, -50)));
        assert_eq!(end(LayerLight { gain_slope: 4 << 8, ..light }), Some((10, -46)));
    }

    #[test]
    fn ink_is_subtracted() {
        let seen = Seen { excess: -60 << 8, gain: -80 << 8, limited: Limited::Not };
        assert_eq!((seen.change(1 << 16), seen.residual(1 << 16)), (-80 << 8, 20 << 8));
        assert_eq!((seen.change(1 << 15), seen.residual(0)), (-40 << 8, -60 << 8));
    }
}
