//! Reciprocals of 32-bit numbers without a 64-bit division.

/// `1/value` as `mantissa · 2^-(62 - shift)`, where `value · 2^shift` lies in [2^31, 2^32).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reciprocal {
    /// 2^30 to 2^31.
    pub mantissa: u32,
    /// Leading zeros of the value.
    pub shift: u8,
}

impl Reciprocal {
    /// The reciprocal of a positive number, with a relative error of at most 2^-28; `None` of 0.
    ///
    /// A 16-bit quotient has a relative error of 2^-14.4 at most (2^-15 from the divisor's dropped bits, 2^-16 from its
    /// own); one step of Newton's method squares it, and drops 2^-30 in its two shifts.
    #[must_use]
    pub fn of(value: u32) -> Option<Self> {
        let shift = value.leading_zeros();
        let normal = value.checked_shl(shift)?; // none for 0, whose shift is 32
        let seed = u32::MAX.checked_div(normal >> 16)?; // 2^16 to 2^17
        let guess = i64::from(seed) << 14;
        let error = (1 << 62) - i64::from(normal) * guess; // within ±2^47.7
        let mantissa = guess + ((guess * (error >> 16)) >> 46);
        Some(Self { mantissa: u32::try_from(mantissa.min(1 << 31)).ok()?, shift: u8::try_from(shift).ok()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nothing_has_no_reciprocal() {
        assert_eq!(Reciprocal::of(0), None);
    }

    proptest! {
        #[test]
        fn reciprocals_are_near(value in 1..=u32::MAX, fewer in 0_u32..31) {
            let value = (value >> fewer).max(1);
            let found = Reciprocal::of(value).unwrap();
            let power = 2_f64.powi(i32::from(found.shift) - 62);
            let error = f64::from(found.mantissa) * power * f64::from(value) - 1.0;
            prop_assert!(error.abs() <= 2_f64.powi(-28), "{} {}", value, error);
        }
    }
}
