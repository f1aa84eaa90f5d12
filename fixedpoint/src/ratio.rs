//! Rounding: of a ratio of integers, and of a product's surplus fraction bits. To nearest, halves up.

/// The ratio `numerator / denominator` with `fraction_bits` fraction bits, rounded to nearest, halves up.
///
/// The error is at most half a unit of the last bit. `None` if the denominator is not positive, if there are more than
/// 62 fraction bits, or if the result does not fit.
///
/// One division finds the whole part, and restoring division one fraction bit at a time: the remainder stays below the
/// denominator, below 2^63, so that doubling it stays below 2^64.
#[must_use]
pub fn rounded(numerator: i64, denominator: i64, fraction_bits: u8) -> Option<i64> {
    if denominator <= 0 || fraction_bits > 62 {
        return None;
    }
    let divisor = denominator.unsigned_abs();
    let mut quotient = numerator.checked_div_euclid(denominator)?;
    let mut remainder = numerator.checked_rem_euclid(denominator)?.unsigned_abs();
    for _ in 0..fraction_bits {
        quotient = quotient.checked_mul(2)?;
        remainder *= 2;
        if remainder >= divisor {
            remainder -= divisor;
            quotient += 1; // it was even
        }
    }
    if remainder >= divisor - remainder {
        return quotient.checked_add(1);
    }
    Some(quotient)
}

/// `value / 2^bits`, rounded to nearest, halves up; `bits` from 1 to 62 and `|value|` below 2^63 - 2^62.
#[must_use]
pub fn dropped(value: i64, bits: u8) -> i64 {
    let half = 1_i64.checked_shl(u32::from(bits).saturating_sub(1)).unwrap_or(0);
    value.saturating_add(half).checked_shr(u32::from(bits)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Half-up rounding in wide arithmetic: floor((2 n 2^f + d) / (2 d)).
    fn wide(numerator: i64, denominator: i64, fraction_bits: u8) -> i128 {
        let (n, d) = (i128::from(numerator), i128::from(denominator));
        ((n << (fraction_bits + 1)) + d).div_euclid(2 * d)
    }

    #[test]
    fn halves_are_rounded_up() {
        assert_eq!(rounded(1, 2, 0), Some(1));
        assert_eq!(rounded(-1, 2, 0), Some(0));
        assert_eq!(rounded(-3, 2, 0), Some(-1));
        assert_eq!(rounded(3, 16, 3), Some(2));
        assert_eq!((dropped(3, 1), dropped(-3, 1), dropped(-4, 3)), (2, -1, 0));
    }

    #[test]
    fn what_has_no_answer_gets_none() {
        assert_eq!(rounded(1, 0, 4), None);
        assert_eq!(rounded(1, -1, 4), None);
        assert_eq!(rounded(i64::MAX, 1, 1), None);
        assert_eq!(rounded(i64::MIN, 1, 1), None);
        assert_eq!(rounded(1, 1, 63), None);
        assert_eq!(rounded(i64::MAX, i64::MAX, 62), Some(1 << 62));
    }

    proptest! {
        #[test]
        fn a_ratio_is_exact_up_to_its_rounding(
            numerator in any::<i64>(),
            denominator in 1..i64::MAX,
            shift in 0_u32..62,
            fraction_bits in 0_u8..=62,
        ) {
            let denominator = (denominator >> shift).max(1);
            let expected = i64::try_from(wide(numerator, denominator, fraction_bits)).ok();
            prop_assert_eq!(rounded(numerator, denominator, fraction_bits), expected);
        }

        #[test]
        fn surplus_bits_are_rounded(value in -(1_i64 << 61)..1 << 61, bits in 1_u8..=62) {
            prop_assert_eq!(i128::from(dropped(value, bits)), wide(value, 1 << bits, 0));
        }
    }
}
