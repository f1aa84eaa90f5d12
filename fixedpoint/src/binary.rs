//! Numbers of many sizes: a power of two times an integer.

/// `value · 2^exponent`, rounded to nearest, halves up, and limited to ±(2^63 - 1).
#[must_use]
pub fn scaled(value: i64, exponent: i32) -> i64 {
    const LIMIT: i64 = i64::MAX;
    let Ok(up) = u32::try_from(exponent) else {
        let down = exponent.unsigned_abs();
        // The bit below the last one rounds, so that nothing is added before the shift.
        let [whole, half] = [down, down - 1].map(|bits| value >> bits.min(63));
        return (whole + (half & 1)).clamp(-LIMIT, LIMIT);
    };
    if value == 0 {
        return 0;
    }
    if value.unsigned_abs().leading_zeros() <= up {
        return if value < 0 { -LIMIT } else { LIMIT };
    }
    value.checked_shl(up).unwrap_or(0)
}

/// The product of two numbers, `2^-bits` of it, rounded to nearest, halves up, and limited to ±2^63.
#[must_use]
pub fn product(one: i64, other: i64, bits: u8) -> i64 {
    let half = (1_i128 << bits) >> 1;
    let product = (i128::from(one) * i128::from(other) + half) >> bits.min(126);
    i64::try_from(product).unwrap_or(if product < 0 { i64::MIN } else { i64::MAX })
}

/// The product of a 64-bit number and a 32-bit one, `2^-bits` of it, rounded to nearest, halves up; `bits` up to 32.
///
/// By halves of the first number, without a 128-bit product. Exact but for the rounding where the result is within ±2^62.
#[must_use]
pub fn times(value: i64, factor: i32, bits: u8) -> i64 {
    let (high, low) = (value >> 32, value & 0xFFFF_FFFF);
    let factor = i64::from(factor);
    let bits = u32::from(bits.min(32));
    let half = (1_i64 << bits) >> 1;
    // `low · factor` is below 2^63 less 2^31.
    ((high * factor) << (32 - bits)).saturating_add((low * factor).saturating_add(half) >> bits)
}

/// The position of the highest bit of a number: `2^(n - 1) <= |value| < 2^n`, 0 of 0.
#[must_use]
pub fn size(value: i64) -> i32 {
    64_i32.saturating_sub_unsigned(value.unsigned_abs().leading_zeros())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sizes_are_those_of_binary_numbers() {
        assert_eq!([0, 1, 2, 3, 4, -4].map(size), [0, 1, 2, 2, 3, 3]);
    }

    #[test]
    fn products_out_of_range_keep_their_signs() {
        assert_eq!((product(i64::MAX, 2, 0), product(i64::MIN, -1, 0)), (i64::MAX, i64::MAX));
        assert_eq!((product(i64::MIN, 2, 0), product(i64::MAX, -3, 1)), (i64::MIN, i64::MIN));
    }

    proptest! {
        #[test]
        fn scaling_rounds_and_saturates(value in any::<i64>(), fewer in 0_u32..63, exponent in -70_i32..70) {
            let value = value >> fewer;
            let limit = 2_f64.powi(63);
            let exact = (value as f64 * 2_f64.powi(exponent)).clamp(-limit, limit);
            // Of large values `value as f64` itself is rounded.
            let error = (scaled(value, exponent) as f64 - exact).abs();
            prop_assert!(error <= 0.5 + exact.abs() * 2_f64.powi(-52), "{}", scaled(value, exponent));
        }

        #[test]
        fn products_of_halves_are_exact(value in any::<i64>(), fewer in 0_u32..63, factor in any::<i32>(), bits in 0_u8..=32) {
            let value = value >> fewer;
            let exact = (i128::from(value) * i128::from(factor) + ((1_i128 << bits) >> 1)) >> bits;
            prop_assume!(exact.unsigned_abs() < 1 << 62);
            prop_assert_eq!(i128::from(times(value, factor, bits)), exact);
        }

        #[test]
        fn products_are_rounded(one in -(1_i64 << 40)..1 << 40, other in -(1_i64 << 40)..1 << 40, bits in 20_u8..60) {
            let exact = one as f64 * other as f64 / 2_f64.powi(i32::from(bits));
            prop_assert!((product(one, other, bits) as f64 - exact).abs() <= 0.5 + exact.abs() * 1e-15);
        }
    }
}
