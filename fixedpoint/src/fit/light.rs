//! Where a step of light lies (`FIT-15`).
//!
//! With `y = I - g_0 c`, the least squares of one side with `g` drawn towards `g_0` leave
//! `S_yy - S_cy²/(S_cc + 1/16)`, `S` being sums of products of deviations from the side's means.

use crate::binary;
use crate::sweep::Sweep;

/// The place in the window of the pixel that parts both sides best; `None` in a window of less than 3 px.
///
/// `gain` is `g_0` in grey levels; the sweep starts at the window's first pixel. Rounding errors of a sum of squares, in
/// squared grey levels: that of the ink, 2^-14 of the gain per pixel, and less than 2^-10 from two divisions.
//= reference/SPEC.md#fit
//# - **FIT-15** The pixel `m` of a layer's step of light MUST be the one for which the model without λ, fitted to
//# either side of it alone, leaves the smallest sum of squares, `c_i` being those of the start, `g` of either side
//# being drawn towards its start by adding `(g - g_0)²/16` to the sum; the left-most of equals, among those with at
//# least one pixel of the window on either side.
pub(super) fn step(window: &[u8], sweep: impl Fn() -> Sweep, gain: i32) -> Option<u16> {
    let pixels = || {
        let mut sweep = sweep();
        window.iter().map(move |&value| Sums::of(value, sweep.pixel().ink, gain))
    };
    let all = pixels().fold(Sums::default(), |sum, pixel| sum.plus(&pixel, 1));
    let last = window.len().checked_sub(1)?;
    let mut left = Sums::default();
    let mut best: Option<(i64, u16)> = None;
    for (place, pixel) in (0_u16..).zip(pixels()) {
        if place > 0 && usize::from(place) < last {
            let right = all.plus(&left, -1).plus(&pixel, -1);
            let squares = left.squares().saturating_add(right.squares());
            if best.is_none_or(|(least, _)| squares < least) {
                best = Some((squares, place));
            }
        }
        left = left.plus(&pixel, 1);
    }
    best.map(|(_, place)| place)
}

/// Sums over pixels: of ink and `y` in 2^-13, of products in 2^-26.
///
/// `|y| <= 510 · 2^13`, so over 640 px `Σ y²` is below 2^53.4 and `n Σ y²` below 2^62.7.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: i64,
    c: i64,
    y: i64,
    cc: i64,
    cy: i64,
    yy: i64,
}

impl Sums {
    /// Those of one pixel; 0 of one that is left out (`FIT-5`).
    fn of(value: u8, ink: i32, gain: i32) -> Self {
        if value == 0 || value == u8::MAX {
            return Self::default();
        }
        let c = i64::from((ink + (1 << 2)) >> 3);
        let y = (i64::from(value) << 13) - i64::from(gain) * c;
        Self { count: 1, c, y, cc: c * c, cy: c * y, yy: y * y }
    }

    fn plus(&self, other: &Self, sign: i64) -> Self {
        Self {
            count: self.count + sign * other.count,
            c: self.c + sign * other.c,
            y: self.y + sign * other.y,
            cc: self.cc + sign * other.cc,
            cy: self.cy + sign * other.cy,
            yy: self.yy + sign * other.yy,
        }
    }

    /// The least sum of squares in 2^-26. At the least, an error of the gain's change, 2^-9, counts squared. `n Σ c y` is
    /// below 2^53.7.
    fn squares(&self) -> i64 {
        let n = self.count;
        let yy = n * self.yy - self.y * self.y;
        let cy = n * self.cy - self.c * self.y;
        let cc = n * self.cc - self.c * self.c + (n << 22);
        let change = (cy << 9).checked_div(cc).unwrap_or(0);
        let slack = 2 * cy - binary::product(change, cc, 9);
        (yy - binary::product(change, slack, 9)).checked_div(n).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge::Blur;
    use crate::formats::{Column, Obliquity};
    use crate::homography::Homography;
    use crate::landmark::Format;
    use crate::projection::Projection;
    use proptest::prelude::*;

    /// The place of the step in a window without ink.
    fn parted(window: &[u8]) -> Option<u16> {
        let homography = Homography { a: Column::ZERO, s: Column::from_num(40), k: Obliquity::ZERO };
        let projection = Projection::new(&homography, Format::Paper).unwrap();
        let blur = Blur::new(Blur::START);
        step(window, || Sweep::new(&projection, 0, Format::Paper, &blur, 0), -100)
    }

    /// `FIT-15`: the left-most of equals, a pixel on either side; what the camera limits does not count (`FIT-5`).
    #[test]
    fn the_left_most_of_equals_parts_the_window() {
        assert_eq!(parted(&[100; 9]), Some(1));
        assert_eq!(parted(&[160, 100, 100, 100, 100]), Some(1));
        assert_eq!(parted(&[100, 100, 100, 100, 160]), Some(3));
        assert_eq!((parted(&[100; 3]), parted(&[100; 2]), parted(&[])), (Some(1), None, None));
        // Either the last pixel of 100 or the first of 160 is left out.
        for limited in [0, 255] {
            assert_eq!(parted(&[100, limited, 100, 100, 100, 100, 160, 160, limited, 160]), Some(5));
        }
    }

    #[test]
    fn ink_is_rounded_to_its_unit() {
        // In 2^-13 from 2^-16.
        assert_eq!([3, 4, 11, 12].map(|ink| Sums::of(100, ink, -1).c), [0, 1, 1, 2]);
    }

    proptest! {
        /// The module's equation in floating point, of ink that need not be rounded.
        #[test]
        fn the_least_squares_draw_the_gain_to_its_start(
            pixels in prop::collection::vec((1..=254_u8, 0..=1_i32 << 13), 2..20),
            gain in -200..-12_i32,
        ) {
            let sums = pixels.iter().fold(Sums::default(), |sum, &(value, ink)| sum.plus(&Sums::of(value, ink << 3, gain), 1));
            let points: std::vec::Vec<(f64, f64)> = pixels
                .iter()
                .map(|&(value, ink)| (f64::from(ink) / 8192.0, f64::from(value)))
                .map(|(c, value)| (c, value - f64::from(gain) * c))
                .collect();
            let n = points.len() as f64;
            let mean = [points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n];
            let sum = |term: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| term(p.0 - mean[0], p.1 - mean[1])).sum::<f64>();
            let (cc, cy, yy) = (sum(&|c, _| c * c), sum(&|c, y| c * y), sum(&|_, y| y * y));
            let exact = yy - cy * cy / (cc + 1.0 / 16.0);
            let found = sums.squares() as f64 / 2_f64.powi(26);
            prop_assert!((found - exact).abs() <= 2_f64.powi(-10), "{} {}", found, exact);
        }
    }
}
