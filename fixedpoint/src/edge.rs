//! The image of an edge: how much of a pixel is ink.
//!
//! With `z = t/σ` and the tail `T(z) = φ(z) - z Q(z)`, `Q = 1 - Φ`, `EDGE-1`'s `ρ(t)` is `max(t, 0) + σ T(|z|)`. Tables
//! hold `T`, `Q` and `φ` at multiples of 1/16. Since `T' = -Q`, `Q' = -φ` and `φ' = -z φ`, an entry and its neighbours in
//! the same row are a Taylor series: three terms for the ink, two for its derivatives.

mod tails;

use crate::formats::Column;
use crate::reciprocal::Reciprocal;
use tails::{FARTHEST, TAILS};

/// What an edge has brought to the left of a boundary `t` px to its right, and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Boundary {
    /// `ρ(t)` in 2^-16 px.
    pub ink: i32,
    /// `Φ(t/σ)` in 2^-16, 0 to 2^16: the derivative by `t`.
    pub distribution: i32,
    /// `φ(t/σ)` in 2^-16: the derivative by `σ`.
    pub density: i32,
}

/// A blur of the image, with its reciprocal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blur {
    /// σ in 2^-15 px, 0.2 to 1.2 px.
    sigma: i32,
    /// 1/σ in 2^-14 per px.
    reciprocal: i32,
    /// The distance in 2^-16 px beyond which an edge is all or nothing.
    reach: i32,
}

impl Blur {
    /// The smallest blur of `FIT-10`, 0.2 px.
    pub const SMALLEST: Column = Column::from_bits(209_715);
    /// The largest, 1.2 px.
    pub const LARGEST: Column = Column::from_bits(1_258_291);
    /// The one that a fit starts from, 1/2 px (`FIT-7`).
    pub const START: Column = Column::from_bits(1 << 19);

    /// A blur of `sigma` px, limited to 0.2 to 1.2 px.
    ///
    /// Rounding errors: σ 2^-16 px, 1/σ 2^-15 per px.
    #[must_use]
    pub fn new(sigma: Column) -> Self {
        let bits = sigma.clamp(Self::SMALLEST, Self::LARGEST).to_bits();
        let reciprocal = Reciprocal::of(bits.unsigned_abs()).map_or(0, |found| {
            // 2^34/σ of 20 fraction bits.
            let surplus = 62 - 34 - u32::from(found.shift);
            (i64::from(found.mantissa) + (1 << surplus >> 1)) >> surplus
        });
        let sigma = (bits + 16) >> 5;
        Self { sigma, reciprocal: i32::try_from(reciprocal).unwrap_or(i32::MAX), reach: (sigma * FARTHEST) >> 1 }
    }

    /// How far the edge reaches, in 2^-16 px: 15/4 σ, where `T` is 2.1e-5 and `Q` 8.8e-5.
    #[must_use]
    pub fn reach(&self) -> i32 {
        self.reach
    }

    /// The edge at a boundary `t` to its right, in 2^-16 px.
    ///
    /// Errors of the ink, in px: 2.1e-5 σ from the end of the table; 1.3e-6 σ from the Taylor series, `z φ δ³/6` with
    /// `δ <= 1/32`; `Q |z|` times the relative error of 1/σ, at most 3.7e-5 · 0.17 σ, and `T` times that of σ;
    /// `2^-15 Q` from `t`; and 2.5 · 2^-16 from rounding. Together less than 7e-5. Of the derivatives: 1.3e-4 and 2.1e-4
    /// from the series, 8.8e-5 and 3.6e-4 from the end of the table.
    #[must_use]
    pub fn boundary(&self, t: i32) -> Boundary {
        let far = if t > 0 { Boundary { ink: t, distribution: 1 << 16, density: 0 } } else { Boundary::default() };
        let distance = i32::try_from(t.unsigned_abs()).unwrap_or(i32::MAX);
        if distance >= self.reach {
            return far;
        }
        let z = ((distance + 2) >> 2) * self.reciprocal; // 28 fraction bits, below 2^30
        let place = (z + (1 << 23)) >> 24;
        let delta = (z - (place << 24)) >> 12; // 16, at most 2^11
        let entry = usize::try_from(place).ok().and_then(|place| TAILS.get(place));
        let Some(&[tail, share, density]) = entry else { return far };
        let (tail, share, density) = (i32::from(tail), i32::from(share), i32::from(density));
        let square = (delta * delta) >> 6; // 26, at most 2^16
        let tail = tail - ((share * delta + (1 << 15)) >> 16) + ((density * square) >> 27);
        let share = share - ((density * delta) >> 16);
        let density = density - ((((density * place) >> 4) * delta) >> 16);
        let blurred = (tail * self.sigma + (1 << 14)) >> 15;
        if t > 0 {
            Boundary { ink: t + blurred, distribution: (1 << 16) - share, density }
        } else {
            Boundary { ink: blurred, distribution: share, density }
        }
    }
}

/// The ink `c(u)` that an edge from white to black brings to a pixel whose middle is `u` to its right (`EDGE-1`).
///
/// `u` and the ink, 0 to 1, in 2^-16. The error is that of two of [`Blur::boundary`]'s, less than 1.4e-4.
//= reference/SPEC.md#edge
//# - **EDGE-1** The ink that an edge from white at its left to black at its right brings to a pixel whose middle is `u`
//# px to the right of it MUST be `c(u) = ρ(u + 1/2) - ρ(u - 1/2)` with `ρ(t) = t Φ(t/σ) + σ φ(t/σ)`, σ the blur, Φ the
//# normal distribution and φ its density (RENDER-1, RENDER-2).
#[must_use]
pub fn ink(u: i32, blur: &Blur) -> i32 {
    blur.boundary(u.saturating_add(1 << 15)).ink - blur.boundary(u.saturating_sub(1 << 15)).ink
}

#[cfg(test)]
mod tests;
