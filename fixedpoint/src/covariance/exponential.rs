//! Powers of e, and sines.

/// `exp(value)`: `value` in 2^-24, at most 10.3; the result with 48 fraction bits.
///
/// The relative error is below 2^-13: `2^-24 · ln 2` from the exponent, 1.6e-6 from the series `2^f = Σ (f ln 2)^n/n!` to the
/// seventh power, and the rest from the result's last bit.
#[must_use]
pub fn exp(value: i64) -> i64 {
    const BY_LN_2: i64 = 1_549_082_005; // 30 fraction bits
    /// `(ln 2)^n/n!` with 30 fraction bits, from the highest power.
    const POWERS: [i64; 8] = [16_377, 165_394, 1_431_680, 10_327_387, 59_597_083, 257_941_248, 744_261_118, 1 << 30];
    let binary = (value.clamp(-(64 << 24), (103 << 24) / 10) * BY_LN_2) >> 24; // 30 fraction bits
    let (whole, part) = (binary >> 30, binary & ((1 << 30) - 1));
    let mut sum = 0;
    for power in POWERS {
        sum = ((sum * part) >> 30) + power; // below 2^31
    }
    crate::binary::scaled(sum, i32::try_from(whole).unwrap_or(-64) + 18)
}

/// `sin(π value/2^31)` with 30 fraction bits.
///
/// The error is below 2^-23: 5e-8 from the series to the eleventh power at a right angle, and 6 roundings of 2^-26.
#[must_use]
pub fn sin(value: i32) -> i64 {
    /// `(-1)^n π^(2n+1)/(2n+1)!` with 26 fraction bits, from the highest power.
    const POWERS: [i64; 6] = [-494_621, 5_512_717, -40_215_962, 171_138_612, -346_799_334, 210_828_714];
    // sin(π - x) = sin x: beyond a right angle, the rest to π.
    let folded = if value.unsigned_abs() > 1 << 30 { i32::MIN.wrapping_sub(value) } else { value };
    let z = i64::from(folded); // 31 fraction bits
    let square = (z * z) >> 32; // 30
    let mut sum = 0;
    for power in POWERS {
        sum = ((sum * square) >> 30) + power; // below 2^29
    }
    (sum * z) >> 27
}

#[cfg(test)]
mod tests {
    #![allow(clippy::cast_possible_truncation)] // of numbers in range

    use super::*;
    use proptest::prelude::*;

    #[test]
    fn exponentials_are_limited() {
        assert_eq!(exp(1 << 40), exp((103 << 24) / 10));
        assert_eq!(exp(-(1 << 40)), 0);
    }

    proptest! {
        #[test]
        fn exponentials_are_near(value in -20.0..10.3_f64) {
            let found = exp((value * 2_f64.powi(24)).round() as i64) as f64 / 2_f64.powi(48);
            prop_assert!((found / value.exp() - 1.0).abs() < 2_f64.powi(-13), "{}", found / value.exp() - 1.0);
        }

        #[test]
        fn sines_are_near(value in any::<i32>()) {
            let exact = (f64::from(value) * std::f64::consts::PI / 2_f64.powi(31)).sin();
            let found = sin(value) as f64 / 2_f64.powi(30);
            prop_assert!((found - exact).abs() < 2_f64.powi(-23), "{} {}", found, exact);
        }
    }
}
