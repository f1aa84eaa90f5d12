//! Sine and cosine of an angle, and of an arc its chord.

use crate::formats::Angle;

/// Fraction bits of sines, cosines and chords.
pub const TRIGONOMETRIC_BITS: u8 = 30;

/// The sine and the cosine of an angle, both with [`TRIGONOMETRIC_BITS`].
///
/// From the nearest right angle the rest `z` of a quarter turn, `|z| <= 1/2`, goes through the Taylor series of
/// `sin(π z/2)` and `cos(π z/2)`, which then change places and signs. The error is below 2^-30: 2^-33 from the end of the
/// series, 2^-32 from the coefficients and the products, 2^-31 from the last rounding.
#[must_use]
pub fn sin_cos(angle: Angle) -> [i32; 2] {
    /// `(-1)^n (π/2)^(2n+1)/(2n+1)!` with 32 fraction bits, from the highest power.
    const SINE: [i64; 6] = [-15_457, 689_090, -20_107_981, 342_277_223, -2_774_394_673, 6_746_518_852];
    /// `(-1)^n (π/2)^(2n)/(2n)!` likewise.
    const COSINE: [i64; 7] = [2_023, -108_242, 3_948_193, -89_607_968, 1_089_502_240, -5_298_703_516, 4_294_967_296];
    let quarters = (i64::from(angle.to_bits()) + (1 << 29)) >> 30; // -2 to 2
    let z = i64::from(angle.to_bits()) - (quarters << 30); // 30 fraction bits, within ±2^29
    let square = (z * z + (1 << 27)) >> 28; // 32
    let sine = narrow((series(&SINE, square) * z + (1 << 31)) >> 32);
    let cosine = narrow((series(&COSINE, square) + 2) >> 2);
    match quarters & 3 {
        0 => [sine, cosine],
        1 => [cosine, -sine],
        2 => [-sine, -cosine],
        _ => [-cosine, sine],
    }
}

/// By how much the chord of an arc is shorter, `sin(φ/2)/(φ/2)`, and the derivative of this by `φ`, both with
/// [`TRIGONOMETRIC_BITS`]; `half` is `φ/2` in radians with 30 fraction bits, within ±1.25.
///
/// The errors are below 2^-30 within ±0.6, and 2^-27 up to ±1.25: the coefficients' rounding, 2^-33, times the powers of
/// `half`, and the series' ends.
#[must_use]
pub fn chord(half: i64) -> [i32; 2] {
    /// `(-1)^n/(2n+1)!` with 32 fraction bits, from the highest power.
    const CHORD: [i64; 7] = [1, -108, 11_836, -852_176, 35_791_394, -715_827_883, 4_294_967_296];
    /// `(-1)^(n+1) n/(2n+1)!`, n from 6 to 1, likewise.
    const DERIVATIVE: [i64; 6] = [-4, 538, -47_343, 2_556_528, -71_582_788, 715_827_883];
    let half = half.clamp(-(5 << 28), 5 << 28);
    let square = (half * half + (1 << 29)) >> 30; // 30 fraction bits, below 2^30.7, so that products stay below 2^62.7
    let by_square = |coefficients: &[i64]| {
        coefficients.iter().fold(0_i64, |sum, coefficient| ((sum * square + (1 << 29)) >> 30) + coefficient)
    };
    let derivative = (-by_square(&DERIVATIVE) * half + (1 << 31)) >> 32;
    [narrow((by_square(&CHORD) + 2) >> 2), narrow(derivative)]
}

/// A series in a square of 32 fraction bits, at most 1/4: products stay below 2^62.7.
fn series(coefficients: &[i64], square: i64) -> i64 {
    coefficients.iter().fold(0, |sum, coefficient| ((sum * square + (1 << 31)) >> 32) + coefficient)
}

/// A number within ±1 with 30 fraction bits.
fn narrow(value: i64) -> i32 {
    i32::try_from(value.clamp(-(1 << 30), 1 << 30)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::cast_possible_truncation)] // of numbers in range

    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    const UNIT: f64 = 1_073_741_824.0;

    #[test]
    fn right_angles_are_exact() {
        let one = 1 << 30;
        assert_eq!(sin_cos(Angle::ZERO), [0, one]);
        assert_eq!(sin_cos(Angle::from_bits(1 << 30)), [one, 0]);
        assert_eq!(sin_cos(Angle::PI), [0, -one]);
        assert_eq!(sin_cos(Angle::from_bits(-(1 << 30))), [-one, 0]);
        assert_eq!(chord(0), [one, 0]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn sines_and_cosines_keep_to_the_stated_error(bits in any::<i32>()) {
            let (sin, cos) = (f64::from(bits) * PI / 2_f64.powi(31)).sin_cos();
            let found = sin_cos(Angle::from_bits(bits));
            prop_assert!((f64::from(found[0]) - sin * UNIT).abs() < 1.0, "{} {}", found[0], sin * UNIT);
            prop_assert!((f64::from(found[1]) - cos * UNIT).abs() < 1.0, "{} {}", found[1], cos * UNIT);
        }

        #[test]
        fn chords_keep_to_the_stated_error(half in -1.25..1.25_f64) {
            let bits = (half * UNIT).round() as i64;
            let half = bits as f64 / UNIT;
            prop_assume!(half.abs() > 1e-3);
            let exact = [half.sin() / half, (half * half.cos() - half.sin()) / (2.0 * half * half)];
            let bound = if half.abs() < 0.6 { 1.0 } else { 8.0 };
            for (found, exact) in chord(bits).into_iter().zip(exact) {
                prop_assert!((f64::from(found) - exact * UNIT).abs() < bound + 1e-2, "{} {}", found, exact * UNIT);
            }
        }
    }
}
