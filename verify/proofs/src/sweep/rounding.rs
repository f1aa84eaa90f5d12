//! Functions of one number, on all numbers that there are, and ratios.

use fixedpoint::cordic::atan2;
use fixedpoint::covariance::exponential;
use fixedpoint::filter::root::square_root;
use fixedpoint::formats::Angle;
use fixedpoint::ratio::rounded;
use fixedpoint::reciprocal::Reciprocal;
use fixedpoint::rotation::{self, sin_cos};
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use std::thread;

/// A ratio is rounded to nearest, halves up.
///
/// - Domain: numerators of 12 bits, denominators of 8, up to 6 fraction bits.
/// - Fault: `ratio.rs`: `if remainder >= divisor - remainder {` → `if remainder > divisor - remainder {`: halves are
///   rounded down.
pub(crate) fn ratios_are_rounded() {
    for numerator in -2048..2048_i64 {
        for denominator in 1..256_i64 {
            for bits in 0..=6 {
                let exact = ((numerator << (bits + 1)) + denominator).div_euclid(2 * denominator);
                assert_eq!(
                    rounded(numerator, denominator, bits),
                    Some(exact),
                    "{numerator}/{denominator}, {bits} bits"
                );
            }
        }
    }
}

/// Tries numbers on all cores.
fn on_all_cores(numbers: RangeInclusive<i64>, check: impl Fn(i64) + Sync) {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let (first, last) = numbers.into_inner();
    thread::scope(|scope| {
        for core in 0..cores {
            let check = &check;
            scope.spawn(move || (first..=last).skip(core).step_by(cores).for_each(check));
        }
    });
}

/// What a number with so many fraction bits stands for.
fn real(value: impl Into<i64>, bits: i32) -> f64 {
    value.into() as f64 * 2_f64.powi(-bits)
}

/// Reciprocals keep to a relative error of 2^-28, and no product on the way overflows.
///
/// - Domain: all numbers of 32 bits whose highest bit is set, 2^31 of them; others are shifted to one of these.
/// - Fault: `reciprocal.rs`: `guess + ((guess * (error >> 16)) >> 46)` → `guess + ((guess * (error >> 16)) >> 47)`:
///   half of Newton's step.
/// - Seconds: 300
pub(crate) fn reciprocals_keep_to_their_error() {
    on_all_cores(1 << 31..=u32::MAX.into(), |value| {
        let found = Reciprocal::of(u32::try_from(value).expect("32 bits")).expect("it is not 0");
        // mantissa · value is 2^62, and 2^34 is the 2^28th part of it.
        let error = i128::from(found.mantissa) * i128::from(value) - (1 << 62);
        assert!(found.shift == 0 && error.abs() <= 1 << 34, "{value}");
        assert!((1 << 30..=1 << 31).contains(&found.mantissa), "{value}");
    });
}

/// Sines and cosines keep to an error of 2^-30, and no product on the way overflows.
///
/// - Domain: the 2^30 angles within an eighth of a turn of 0; that they repeat carries it to all angles.
/// - Fault: `rotation.rs`: `342_277_223` → `342_276_223`: a coefficient is wrong in its sixth digit.
/// - Seconds: 300
pub(crate) fn sines_keep_to_their_error() {
    on_all_cores(-(1 << 29)..=1 << 29, |bits| {
        let found = sin_cos(Angle::from_bits(i32::try_from(bits).expect("it is small")));
        let (sine, cosine) = (real(bits, 31) * PI).sin_cos();
        for (found, exact) in found.into_iter().zip([sine, cosine]) {
            assert!((real(found, 30) - exact).abs() < 2_f64.powi(-30), "{bits}");
        }
    });
}

/// A quarter of a turn more takes a sine to the cosine, and a cosine to the sine of the other sign.
///
/// - Domain: all 2^32 angles.
/// - Fault: `rotation.rs`: `2 => [-sine, -cosine],` → `2 => [-sine, cosine],`: a wrong sign.
/// - Seconds: 300
pub(crate) fn sines_repeat_by_quarters() {
    on_all_cores(i32::MIN.into()..=i32::MAX.into(), |bits| {
        let angle = Angle::from_bits(i32::try_from(bits).expect("32 bits"));
        let [sine, cosine] = sin_cos(angle);
        assert_eq!(sin_cos(angle + Angle::from_bits(1 << 30)), [cosine, -sine], "{bits}");
    });
}

/// Chords and their derivatives keep to the errors that they state, and no product on the way overflows.
///
/// - Domain: all 2^31.3 halves within ±1.25 rad.
/// - Fault: `rotation.rs`: `-852_176` → `-852_076`: a coefficient is wrong in its fourth digit.
/// - Seconds: 300
pub(crate) fn chords_keep_to_their_error() {
    on_all_cores(-(5 << 28)..=5 << 28, |bits| {
        let half = real(bits, 30);
        let [chord, derivative] = rotation::chord(bits);
        // Close to 0 by the first terms of their series, where differences of sines say nothing.
        let square = half * half;
        let exact = if half.abs() < 1e-2 {
            let slope = -half / 6.0 * (1.0 - square / 10.0 * (1.0 - square / 28.0));
            [1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)), slope]
        } else {
            [half.sin() / half, (half * half.cos() - half.sin()) / (2.0 * square)]
        };
        let bound = if half.abs() <= 0.6 { 2_f64.powi(-30) } else { 2_f64.powi(-27) };
        assert!((real(chord, 30) - exact[0]).abs() < bound, "chord of {bits}");
        assert!((real(derivative, 30) - exact[1]).abs() < bound, "derivative at {bits}");
    });
}

/// Exponentials keep to a relative error of 2^-13, or half a unit of the result, and no product on the way overflows.
///
/// - Domain: all 2^29 arguments from -24 to 10.3.
/// - Fault: `covariance/exponential.rs`: `257_941_248` → `257_441_248`: a coefficient is wrong in its third digit.
/// - Seconds: 300
pub(crate) fn exponentials_keep_to_their_error() {
    on_all_cores(-(24 << 24)..=(103 << 24) / 10, |value| {
        let exact = real(value, 24).exp();
        let error = (real(exponential::exp(value), 48) - exact).abs();
        assert!(error <= exact * 2_f64.powi(-13) + 2_f64.powi(-49), "{value}");
    });
}

/// The quick sine keeps to an error of 2^-23, and no product on the way overflows.
///
/// - Domain: all 2^32 angles.
/// - Fault: `covariance/exponential.rs`: `171_138_612` → `171_138_012`: a coefficient is wrong in its sixth digit.
/// - Seconds: 300
pub(crate) fn quick_sines_keep_to_their_error() {
    on_all_cores(i32::MIN.into()..=i32::MAX.into(), |bits| {
        let found = exponential::sin(i32::try_from(bits).expect("32 bits"));
        assert!((real(found, 30) - (real(bits, 31) * PI).sin()).abs() < 2_f64.powi(-23), "{bits}");
    });
}

/// The angle of a vector is the nearest there is, but where two are as near to 0.05 of their distance, and no vector
/// overflows on the way.
///
/// - Domain: every 31st of the 2^32 angles, the directions 0.449 of an angle's unit to either side of it, vectors of 2^52.
/// - Fault: `cordic.rs`: `174_991_820_497` → `174_991_720_497`: a rotation is wrong in its seventh digit.
/// - Seconds: 300
pub(crate) fn vectors_have_their_angle() {
    #[expect(clippy::cast_possible_truncation, reason = "within 2^52")]
    let coordinate = |part: f64| (part * 2_f64.powi(52)).round() as i64;
    on_all_cores(-(1 << 31) / 31..=(1 << 31) / 31, |number| {
        let bits = 31 * number;
        for beside in [-0.449, 0.449] {
            let (sine, cosine) = ((bits as f64 + beside) * 2_f64.powi(-31) * PI).sin_cos();
            let [y, x] = [sine, cosine].map(coordinate);
            assert_eq!(i64::from(atan2(y, x).to_bits()), bits, "{beside}");
        }
    });
}

/// Square roots of variances keep to an error of 2^-48.9, and nothing overflows on the way.
///
/// - Domain: the squares of every 31st whole number up to 2^31.5, what is in the middle before the next square, and what
///   is last.
/// - Fault: `filter/root.rs`: `(rest << 28)` → `(rest << 27)`: half of Newton's step.
/// - Seconds: 300
pub(crate) fn square_roots_keep_to_their_error() {
    const LARGEST: i64 = 3_037_000_498; // the next one's square has 64 bits
    on_all_cores(0..=LARGEST / 31, |number| {
        let whole = 31 * number;
        for variance in [whole * whole, whole * whole + whole, whole * whole + 2 * whole] {
            // The root's unit is 2^-48 and the variance's 2^-56; 2^-48.9 is 0.536 of the root's unit.
            let thousandths = 1000 * i128::from(square_root(variance));
            let squares = 1_000_000 * (i128::from(variance) << 40);
            assert!((thousandths - 536).max(0).pow(2) <= squares, "{variance}");
            assert!((thousandths + 536).pow(2) >= squares, "{variance}");
        }
    });
}
