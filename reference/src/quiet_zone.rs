//! Whether the paper beside a barcode is white, or in the shadow (ACCEPT-16, ACCEPT-17).

use crate::camera::Camera;
use crate::fit::{FitLayer, Fitted, Window, difference, inks, mean_gain};
use crate::landmark::Format;

/// What is not in the line is neither white nor dark: more grey levels than any model is off.
const BEYOND: f64 = 1024.0;

/// How far a shadow reaches at least, in quiet zones (ACCEPT-16).
const SHADOW: usize = 4;

/// The least number `q` of pixels with `N (q + 1) >= 2 e` (ACCEPT-16).
#[must_use]
pub fn width(extent: usize, format: Format) -> usize {
    (2 * extent).div_ceil(format.stripes()) - 1
}

/// How much the worst pixel is darker than its model that should be white, or less than `|ḡ|` darker that should be dark,
/// grey levels, by the reading of each side that needs the least (ACCEPT-16): at most `|ḡ|/2` where the quiet zones are clear.
//= reference/SPEC.md#accept
//# - **ACCEPT-16** Of the nearest `4 q` pixels on either side of each layer's ROI or extent, with `q` the least number
//# for which `N (q + 1) >= 2 e`, the nearest `q` MUST be white, or else those before one of them white, and it and all
//# others dark (`QuietZone`).
#[must_use]
pub fn obstruction(layers: &[FitLayer<'_>], fitted: &Fitted, camera: &Camera, format: Format) -> f64 {
    let mut worst = 0.0_f64;
    for (index, layer) in layers.iter().enumerate() {
        let beside = Beside { layer, fitted, index, camera, format };
        for side in [Side::Left, Side::Right] {
            worst = worst.max(beside.obstruction(side));
        }
    }
    worst
}

/// A side of an ROI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

/// What is beside a layer.
struct Beside<'a> {
    layer: &'a FitLayer<'a>,
    fitted: &'a Fitted,
    index: usize,
    camera: &'a Camera,
    format: Format,
}

impl Beside<'_> {
    fn obstruction(&self, side: Side) -> f64 {
        let (first, last) = (self.layer.first_pixel, self.layer.last_pixel);
        let zone = width(last - first + 1, self.format);
        let contrast = -mean_gain(&self.fitted.lights);
        let pixels = (1..=SHADOW * zone).map(|away| match side {
            Side::Left => first.checked_sub(away),
            Side::Right => Some(last + away).filter(|&pixel| pixel < self.layer.line.len()),
        });
        // How far each is from being white, and from being dark.
        let from: Vec<(f64, f64)> = pixels
            .map(|pixel| match pixel {
                None => (BEYOND, BEYOND),
                Some(pixel) if self.fitted.lights[self.index].step == Some(pixel) => (0.0, 0.0),
                Some(pixel) => {
                    let darker = self.darker(pixel);
                    (darker, contrast - darker)
                }
            })
            .collect();
        let white = |count: usize| from[..count].iter().fold(0.0_f64, |worst, pixel| worst.max(pixel.0));
        let dark = |count: usize| from[count..].iter().fold(0.0_f64, |worst, pixel| worst.max(pixel.1));
        (0..zone).map(|before| white(before).max(dark(before))).fold(white(zone), f64::min)
    }

    /// How much darker than its model a pixel is, grey levels (ACCEPT-17).
    //= reference/SPEC.md#accept
    //# - **ACCEPT-17** A pixel beside an ROI MUST count as white if it is in the line and at most `|ḡ|/2` darker than
    //# its model (TRELLIS-11), as dark if it is in the line and at least `|ḡ|/2` darker, and as both if it is the pixel
    //# of a step of light, λ beyond the window being that of the window's nearest end.
    fn darker(&self, pixel: usize) -> f64 {
        let Self { layer, fitted, camera, format, .. } = *self;
        let window = Window::of(layer.first_pixel, layer.last_pixel, format, layer.line.len());
        let ink = inks(&fitted.imaging, camera, format, layer.stripes, (pixel, pixel))[0].ink;
        let nearest = pixel.clamp(window.first, window.last);
        -difference(layer.line[pixel], fitted.lights[self.index].model_at(&window, nearest, ink))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accept::tests::Found;

    /// `N (q + 1) >= 2 e` and `N q < 2 e`.
    #[test]
    fn the_width_is_the_least_that_is_enough() {
        for format in [Format::Paper, Format::Wide] {
            let stripes = format.stripes();
            for extent in stripes..600 {
                let q = width(extent, format);
                assert!(stripes * (q + 1) >= 2 * extent && stripes * q < 2 * extent, "{format:?} {extent} {q}");
            }
        }
    }

    /// By how much of the contrast what `change` makes of the lines is from a clear quiet zone: 1/2 is allowed. The barcode is
    /// 64 px wide, its quiet zone 6 px, its shadow 24.
    fn share(change: impl FnOnce(&mut Found, usize)) -> f64 {
        let mut seen = Found::at_30_cm();
        let after = seen.pixels[0].1 + 1;
        assert_eq!(width(seen.pixels[0].1 - seen.pixels[0].0 + 1, Format::Paper), 6);
        change(&mut seen, after);
        obstruction(&seen.layers(), &seen.fitted, &Camera::epuck(), Format::Paper) / -mean_gain(&seen.fitted.lights)
    }

    /// White paper has about 200 grey levels and ink 40; noise is a hundredth of it.
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-16** Of the nearest `4 q` pixels on either side of each layer's ROI or extent, with `q` the least
    //# number for which `N (q + 1) >= 2 e`, the nearest `q` MUST be white, or else those before one of them white, and
    //# it and all others dark (`QuietZone`).
    #[test]
    fn bars_are_told_from_shadows() {
        assert!(share(|_, _| ()) < 0.1);
        let fill = |from: usize, to: usize, value: u8| {
            share(|seen, after| seen.lines[0][after + from..after + to].fill(value))
        };
        assert!(fill(5, 8, 40) > 0.9, "a bar that begins in the quiet zone");
        assert!(fill(6, 9, 40) < 0.1, "one beside it");
        assert!(fill(3, 24, 66) < 0.3, "a shadow's edge");
        assert!(fill(3, 23, 66) > 0.7, "what ends before the shadow has been as long as four quiet zones");
        assert!((fill(3, 24, 130) - 0.5).abs() < 0.1, "half as dark is as far from white as from dark");
        assert!(fill(3, 4, 255) < 0.1, "brighter is no bar");
        let left = share(|seen, _| {
            let first = seen.pixels[1].0;
            seen.lines[1][first - 6..first - 3].fill(40);
        });
        assert!(left > 0.9, "on the left of the lower layer");
    }

    #[test]
    fn what_is_not_in_the_line_is_neither() {
        let cut = |beside: usize| share(|seen, after| seen.lines[0].truncate(after + beside));
        assert!(cut(6) < 0.1 && cut(5) > 1.0);
        let dark = share(|seen, after| {
            seen.lines[0].truncate(after + 23);
            seen.lines[0][after + 3..].fill(66);
        });
        assert!(dark > 0.7, "a bar that the line cuts off is no shadow");
    }

    #[test]
    fn the_pixel_of_a_step_counts_as_both() {
        let step = |to: usize| {
            share(|seen, after| {
                seen.fitted.lights[0].step = Some(after + 2);
                seen.lines[0][after + 2] = 20;
                seen.lines[0][after + 3..after + to].fill(66);
            })
        };
        assert!(step(3) < 0.1 && step(24) < 0.3 && step(23) > 0.7);
    }

    /// The model is brighter than what a pixel can be (TRELLIS-11), and beyond the window as at its end.
    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-11** In TRELLIS-5 and ACCEPT-8 the model of a pixel of the value 255 MUST count as at most 255, and
    //# that of one of the value 0 as at least 0, since RENDER-5 limits what is brighter or darker.
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-17** A pixel beside an ROI MUST count as white if it is in the line and at most `|ḡ|/2` darker than
    //# its model (TRELLIS-11), as dark if it is in the line and at least `|ḡ|/2` darker, and as both if it is the pixel
    //# of a step of light, λ beyond the window being that of the window's nearest end.
    #[test]
    fn limits_and_the_windows_end_are_kept() {
        let bright = share(|seen, after| {
            seen.fitted.lights[0].offset += 120.0;
            seen.lines[0][after - 80..after + 30].fill(255);
        });
        assert!(bright < 0.1, "{bright}");
        // 40 grey levels more at the window's right end, a quarter of the contrast, and 40 less at its left.
        let sloped = share(|seen, _| seen.fitted.lights[0].offset_slope += 40.0);
        assert!((sloped - 0.25).abs() < 0.05, "{sloped}");
    }
}
