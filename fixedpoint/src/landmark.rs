//! The landmark: formats and dimensions.

use crate::formats::StripeWidth;
use crate::refusal::LandmarkRefusal;

/// Bars of one guard, each followed by a space (`N_guard`).
pub const GUARD_PAIRS: u8 = 2;

/// How many stripes a layer has and how many bits a landmark carries (`LAND-1`); `Paper` comes first (`TIME-2`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// 12 code stripes per layer, 16 bits.
    Paper,
    /// 16 code stripes per layer, 24 bits.
    Wide,
}

impl Format {
    /// Code stripes of one layer, `N_code`.
    #[must_use]
    pub const fn code_stripes(self) -> u8 {
        match self {
            Self::Paper => 12,
            Self::Wide => 16,
        }
    }

    /// Stripes of one layer, `N`: 20 or 24, always even.
    //= reference/SPEC.md#land
    //# - **LAND-1** A layer MUST have `N = N_code + 4 N_guard` stripes of equal width `X_dim`.
    #[must_use]
    pub const fn stripes(self) -> u8 {
        self.code_stripes() + 4 * GUARD_PAIRS
    }

    /// Bits of the payload; with the check byte they fill the code stripes of both layers.
    #[must_use]
    pub const fn payload_bits(self) -> u8 {
        2 * self.code_stripes() - 8
    }
}

/// A landmark: its format and its stripes' width in metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Landmark {
    /// The format.
    pub format: Format,
    stripe_width: StripeWidth,
}

impl Landmark {
    /// `LAND-6`: 1.5 mm, rounded to 2^-32 m.
    //= reference/SPEC.md#land
    //# - **LAND-6** Default dimensions MUST be `X_dim` = 1.5 mm and a stripe height of 25 mm (ERRATA-3).
    const DEFAULT_WIDTH: StripeWidth = StripeWidth::from_bits(6_442_451);
    /// 0.5 mm, rounded up.
    const SMALLEST_WIDTH: StripeWidth = StripeWidth::from_bits(2_147_484);
    /// 20 mm, rounded up.
    const LARGEST_WIDTH: StripeWidth = StripeWidth::from_bits(85_899_346);

    /// A landmark whose stripes are `stripe_width` metres wide.
    ///
    /// # Errors
    /// Unless the width is in 0.5 to 20 mm.
    //= reference/SPEC.md#land
    //# - **LAND-7** A landmark whose `X_dim` is outside 0.5 to 20 mm MUST be refused.
    pub fn new(format: Format, stripe_width: StripeWidth) -> Result<Self, LandmarkRefusal> {
        if (Self::SMALLEST_WIDTH..=Self::LARGEST_WIDTH).contains(&stripe_width) {
            Ok(Self { format, stripe_width })
        } else {
            Err(LandmarkRefusal::StripeWidth)
        }
    }

    /// Format `paper` with the default stripe width of 1.5 mm (`LAND-6`).
    #[must_use]
    pub const fn paper() -> Self {
        Self { format: Format::Paper, stripe_width: Self::DEFAULT_WIDTH }
    }

    /// Format `wide` with the default stripe width of 1.5 mm (`LAND-6`).
    #[must_use]
    pub const fn wide() -> Self {
        Self { format: Format::Wide, stripe_width: Self::DEFAULT_WIDTH }
    }

    /// The stripes' width `X_dim` in metres.
    #[must_use]
    pub const fn stripe_width(&self) -> StripeWidth {
        self.stripe_width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-1** A layer MUST have `N = N_code + 4 N_guard` stripes of equal width `X_dim`.
    #[test]
    fn formats_have_the_numbers_of_the_specification() {
        let numbers = |format: Format| (format.code_stripes(), format.stripes(), format.payload_bits());
        assert_eq!(numbers(Format::Paper), (12, 20, 16));
        assert_eq!(numbers(Format::Wide), (16, 24, 24));
    }

    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-6** Default dimensions MUST be `X_dim` = 1.5 mm and a stripe height of 25 mm (ERRATA-3).
    //= reference/SPEC.md#land
    //= type=test
    //# - **LAND-7** A landmark whose `X_dim` is outside 0.5 to 20 mm MUST be refused.
    #[test]
    fn stripe_widths_have_a_domain() {
        let landmark = |width: f64| Landmark::new(Format::Paper, StripeWidth::from_num(width));
        // `from_num` of a float rounds to nearest.
        assert_eq!(landmark(0.0015), Ok(Landmark::paper()));
        assert!(landmark(0.0005).is_ok() && landmark(0.02).is_ok());
        assert_eq!(landmark(0.000_499), Err(LandmarkRefusal::StripeWidth));
        assert_eq!(landmark(0.020_001), Err(LandmarkRefusal::StripeWidth));
    }
}
