//! Lines for the tests, drawn by hand, and images of barcodes in float64.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of numbers that are small and positive

use crate::formats::{Column, Obliquity};
use crate::homography::Homography;
use crate::landmark::{Format, GUARD_PAIRS};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
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

/// A barcode as a camera sees it: `z (1 + k t) = a + s t` in pixels from the column 239.5, blurred, in even light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) format: Format,
    pub(crate) a: f64,
    pub(crate) s: f64,
    pub(crate) k: f64,
    pub(crate) blur: f64,
    pub(crate) white: f64,
    pub(crate) gain: f64,
    pub(crate) noise: f64,
}

impl View {
    /// A view of a barcode at the column 239.5, of `pixels` per stripe at its centre and turned by `angle` (radians),
    /// by a camera of `f` = 640 px: white paper of 200 and ink of 40 grey levels, a blur of 0.5 px and a noise of 2 grey
    /// levels.
    pub(crate) fn turned(format: Format, pixels: f64, angle: f64) -> Self {
        let s = pixels * f64::from(format.stripes()) / 2.0;
        // At a = 0, s = f (W/d) cos(angle) and k = (W/d) sin(angle).
        let k = s / 640.0 * angle.tan();
        Self { format, a: 0.0, s, k, blur: 0.5, white: 200.0, gain: -160.0, noise: 2.0 }
    }

    /// The same view, `a` pixels to the right: `z` becomes `z + a`.
    pub(crate) fn at(&self, a: f64) -> Self {
        Self { a: self.a + a, s: self.s + a * self.k, ..*self }
    }

    /// The view of the same barcode, of default dimensions, from where the camera, of `f` = 640 px, has moved by `x` ahead and `y`
    /// to the left, in m, and turned by `turn`: from the places of the barcode's ends and centre, projected (`CAM-2`).
    pub(crate) fn moved(&self, [x, y, turn]: [f64; 3]) -> Self {
        let f = 640.0;
        let half_width = 0.0015 * f64::from(self.format.stripes()) / 2.0;
        // The half of the barcode to the right is (k, -s/f) depths long, the centre (1, -a/f).
        let depth = half_width / self.k.hypot(self.s / f);
        let column = |t: f64| {
            let ahead = depth * (1.0 + t * self.k) - x;
            let left = -depth * (self.a + t * self.s) / f - y;
            let (sin, cos) = turn.sin_cos();
            -f * (left * cos - ahead * sin) / (ahead * cos + left * sin)
        };
        let [first, a, last] = [-1.0, 0.0, 1.0].map(column);
        // Both ends by z (1 + k t) = a + s t.
        let k = (2.0 * a - first - last) / (last - first);
        Self { a, s: (last * (1.0 + k) - first * (1.0 - k)) / 2.0, k, ..*self }
    }

    /// The homography, rounded to its formats.
    pub(crate) fn homography(&self) -> Homography {
        Homography { a: Column::from_num(self.a), s: Column::from_num(self.s), k: Obliquity::from_num(self.k) }
    }

    /// The column of an edge, from -1 at the left to 1.
    pub(crate) fn column(&self, t: f64) -> f64 {
        239.5 + (self.a + self.s * t) / (1.0 + self.k * t)
    }

    /// The ink of a stripe in a pixel, if it is a bar (`TRELLIS-4`).
    pub(crate) fn stripe_ink(&self, stripe: usize, pixel: usize) -> f64 {
        let half = f64::from(self.format.stripes()) / 2.0;
        let share = |edge: usize| covered(pixel as f64 - self.column(edge as f64 / half - 1.0), self.blur);
        share(stripe) - share(stripe + 1)
    }

    /// The ink of every pixel, without light and noise (`EDGE-2`).
    pub(crate) fn ink(&self, width: usize, half_word: u16) -> Vec<f64> {
        let bars: Vec<usize> =
            (0_usize..).zip(stripes(self.format, half_word)).filter(|bar| bar.1).map(|bar| bar.0).collect();
        (0..width).map(|pixel| bars.iter().map(|&stripe| self.stripe_ink(stripe, pixel)).sum()).collect()
    }

    /// The line of a layer.
    pub(crate) fn line(&self, width: usize, half_word: u16, random: &mut ChaCha8Rng) -> Vec<u8> {
        let noise = Normal::new(0.0, self.noise).unwrap();
        let value = |ink: f64, noise: f64| (self.white + self.gain * ink + noise).round().clamp(0.0, 255.0) as u8;
        self.ink(width, half_word).into_iter().map(|ink| value(ink, noise.sample(random))).collect()
    }
}

/// How much of a pixel, whose middle is `u` px to the right of an edge, is black if all at the right of the edge is
/// (`EDGE-1`).
pub(crate) fn covered(u: f64, blur: f64) -> f64 {
    // Beyond 8 standard deviations there is less than a float64 holds beside 1.
    if u.abs() > 0.5 + 8.0 * blur {
        return if u > 0.0 { 1.0 } else { 0.0 };
    }
    let density = |x: f64| (-x * x / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let distribution = |x: f64| libm::erfc(-x / std::f64::consts::SQRT_2) / 2.0;
    let ramp = |t: f64| t * distribution(t / blur) + blur * density(t / blur);
    ramp(u + 0.5) - ramp(u - 0.5)
}
