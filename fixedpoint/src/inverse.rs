//! Division by a number of any size, by its reciprocal.

use crate::binary::{scaled, size, times};
use crate::reciprocal::Reciprocal;

/// `1/value` as `mantissa 2^-(30 + bits)`.
#[derive(Clone, Copy, Debug)]
pub struct Inverse {
    /// 2^30 to 2^31.
    mantissa: i32,
    /// `2^(bits - 1) <= value < 2^bits`.
    bits: i32,
}

impl Inverse {
    /// The reciprocal of a positive number, with a relative error of at most 2^-27.5; `None` of any other.
    #[must_use]
    pub fn of(value: i64) -> Option<Self> {
        if value <= 0 {
            return None;
        }
        let bits = size(value);
        let normal = u32::try_from(scaled(value, 32 - bits)).unwrap_or(u32::MAX);
        let mantissa = Reciprocal::of(normal)?.mantissa.min(0x7FFF_FFFF);
        Some(Self { mantissa: i32::try_from(mantissa).ok()?, bits })
    }

    /// `numerator 2^exponent` over the value, rounded to nearest and limited to ±(2^63 - 1).
    ///
    /// Errors: half a unit, and 2^-27.4 of the result.
    #[must_use]
    pub fn times(&self, numerator: i64, exponent: i32) -> i64 {
        let up = 61 - size(numerator);
        scaled(times(scaled(numerator, up), self.mantissa, 30), exponent - self.bits - up)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_not_positive_has_no_inverse() {
        assert!(Inverse::of(0).is_none() && Inverse::of(-1).is_none());
    }

    proptest! {
        #[test]
        fn quotients_are_near(
            value in 1..i64::MAX, fewer in 0_u32..63, numerator in any::<i64>(), less in 0_u32..64, exponent in -60..60_i32,
        ) {
            let (value, numerator) = ((value >> fewer).max(1), numerator >> less.min(63));
            let exact = numerator as f64 / value as f64 * 2_f64.powi(exponent);
            prop_assume!(exact.abs() < 2_f64.powi(62));
            let found = Inverse::of(value).unwrap().times(numerator, exponent) as f64;
            prop_assert!((found - exact).abs() <= 0.51 + exact.abs() * 2_f64.powf(-27.3), "{} {}", found, exact);
        }
    }
}
