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
