//! The two landmark formats and a landmark's stripes (LAND).

use core::fmt;

/// Bar-space pairs of one guard.
pub const GUARD_PAIRS: usize = 2;

/// Default stripe width `X_dim` in metres (LAND-6).
pub const STRIPE_WIDTH: f64 = 1.5e-3;

/// Stripe widths that LAND-7 allows, metres.
pub const STRIPE_WIDTHS: core::ops::RangeInclusive<f64> = 0.5e-3..=20e-3;

/// Default height of one layer in metres (LAND-6).
pub const STRIPE_HEIGHT: f64 = 25e-3;

/// White on either side of a barcode, in stripe widths (LAND-5).
//= reference/SPEC.md#land
//# - **LAND-5** The quiet zone MUST be white for at least 2.5 `X_dim` on either side of a barcode.
pub const QUIET_ZONE_STRIPES: f64 = 2.5;

/// A layout of code word and stripes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    /// 12 code stripes per layer: 16 bits of payload, as the paper's stripes.
    Paper,
    /// 16 code stripes per layer: 24 bits of payload, as the paper's bits.
    Wide,
}

impl Format {
    /// Both formats.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Wide];

    /// Code stripes per layer, `N_code`.
    #[must_use]
    pub fn code_stripes(self) -> usize {
        match self {
            Self::Paper => 12,
            Self::Wide => 16,
        }
    }

    /// Stripes per layer, `N` (LAND-1).
    //= reference/SPEC.md#land
    //# - **LAND-1** A layer MUST have `N = N_code + 4 N_guard` stripes of equal width `X_dim`.
    #[must_use]
    pub fn stripes(self) -> usize {
        self.code_stripes() + 4 * GUARD_PAIRS
    }

    /// Bits of payload; the rest of the code word is its check byte.
    #[must_use]
    pub fn payload_bits(self) -> usize {
        2 * self.code_stripes() - 8
    }
}

/// Why dimensions are no landmark's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LandmarkRefusal {
    /// LAND-7
    StripeWidth,
}

impl fmt::Display for LandmarkRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the stripe width must be from 0.5 to 20 mm")
    }
}

impl core::error::Error for LandmarkRefusal {}

/// A barcode's format and its dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landmark {
    /// Layout of its code word.
    pub format: Format,
    /// `X_dim`, metres.
    pub stripe_width: f64,
    /// Height of one layer, metres; the upper one begins at the camera's height (LAND-4).
    //= reference/SPEC.md#land
    //# - **LAND-4** The upper layer MUST fill the height from 0 to the stripe height above the camera's height, and the
    //# lower layer the same below it.
    pub stripe_height: f64,
}

impl Landmark {
    /// A landmark of the default dimensions (LAND-6).
    //= reference/SPEC.md#land
    //# - **LAND-6** Default dimensions MUST be `X_dim` = 1.5 mm and a stripe height of 25 mm (ERRATA-3).
    #[must_use]
    pub fn new(format: Format) -> Self {
        Self { format, stripe_width: STRIPE_WIDTH, stripe_height: STRIPE_HEIGHT }
    }

    /// The landmark itself if LAND-7 allows it.
    //= reference/SPEC.md#land
    //# - **LAND-7** A landmark whose `X_dim` is outside 0.5 to 20 mm MUST be refused.
    pub fn checked(self) -> Result<Self, LandmarkRefusal> {
        // Written so that NaN is refused.
        if STRIPE_WIDTHS.contains(&self.stripe_width) { Ok(self) } else { Err(LandmarkRefusal::StripeWidth) }
    }

    /// Half the barcode's width, `W = N X_dim / 2`, metres.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        self.format.stripes() as f64 * self.stripe_width / 2.0
    }

    /// Stripe edges `b_k`, k = 0..N, metres on the y axis of L, the right-most first (LAND-2).
    //= reference/SPEC.md#land
    //# - **LAND-2** Stripe edges MUST lie at `b_k = (N/2 - k) X_dim` on the y axis of L, k = 0..N, so that `b_0` is the
    //# right-most edge as seen.
    #[must_use]
    pub fn edges(&self) -> Vec<f64> {
        let half = self.format.stripes() as f64 / 2.0;
        (0..=self.format.stripes()).map(|k| (half - k as f64) * self.stripe_width).collect()
    }
}

/// The colours of one layer from left to right, true for a bar: guard, code, mirrored guard (LAND-3, CODE-3).
//= reference/SPEC.md#land
//# - **LAND-3** The left guard MUST be the stripes bar, space repeated `N_guard` times, and the right guard its mirror
//# image.
//= reference/SPEC.md#code
//# - **CODE-3** Bits MUST become stripes by NRZ: 1 is a bar (black), 0 a space (white).
#[must_use]
pub fn stripes(format: Format, half_word: u32) -> Vec<bool> {
    let guard = [true, false].repeat(GUARD_PAIRS);
    let code = (0..format.code_stripes()).rev().map(|bit| half_word >> bit & 1 == 1);
    guard.iter().copied().chain(code).chain(guard.iter().rev().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-1** A layer MUST have `N = N_code + 4 N_guard` stripes of equal width `X_dim`.
    #[test]
    fn formats_are_those_of_the_table() {
        let table = Format::ALL.map(|f| (f.code_stripes(), f.stripes(), f.payload_bits()));
        assert_eq!(table, [(12, 20, 16), (16, 24, 24)]);
    }

    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-7** A landmark whose `X_dim` is outside 0.5 to 20 mm MUST be refused.
    #[test]
    fn stripe_widths_outside_the_range_are_refused() {
        let paper = Landmark::new(Format::Paper);
        let checked = |stripe_width| Landmark { stripe_width, ..paper }.checked().is_ok();
        assert!(checked(0.5e-3) && checked(1.5e-3) && checked(20e-3));
        assert!(!checked(0.49e-3) && !checked(20.1e-3) && !checked(f64::NAN));
    }

    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-2** Stripe edges MUST lie at `b_k = (N/2 - k) X_dim` on the y axis of L, k = 0..N, so that `b_0` is the
    //# right-most edge as seen.
    #[test]
    fn edges_run_from_right_to_left() {
        let edges = Landmark::new(Format::Paper).edges();
        assert_eq!(edges.len(), 21);
        assert!((edges[0] - 15e-3).abs() < 1e-15 && (edges[20] + 15e-3).abs() < 1e-15);
    }

    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-3** The left guard MUST be the stripes bar, space repeated `N_guard` times, and the right guard its
    //# mirror image.
    //= reference/SPEC.md#code
    //= type=test
    //# - **CODE-3** Bits MUST become stripes by NRZ: 1 is a bar (black), 0 a space (white).
    #[test]
    fn both_outermost_stripes_are_bars() {
        let written: String =
            stripes(Format::Paper, 0b1100_1100_0000).iter().map(|&bar| if bar { '1' } else { '0' }).collect();
        assert_eq!(written, "1010".to_owned() + "110011000000" + "0101");
    }
}
