//! Numbers of many sizes.

use fixedpoint::binary::{product, scaled, size, times};

/// The size of a number is the position of its highest bit.
///
/// - Domain: all 64-bit numbers.
/// - Fault: `binary.rs`: `64_i32.saturating_sub_unsigned` → `63_i32.saturating_sub_unsigned`: one too small.
#[kani::proof]
fn sizes_are_those_of_binary_numbers() {
    let value: i64 = kani::any();
    let found = size(value);
    kani::cover!(found == 64);
    assert!((0..=64).contains(&found));
    let magnitude = u128::from(value.unsigned_abs());
    assert!(magnitude < 1 << found && (found == 0 || magnitude >= 1 << (found - 1)));
}

/// A number times a power of two is rounded to nearest, halves up, and limited where it does not fit.
///
/// - Domain: all 64-bit numbers, exponents from -70 to 62.
/// - Fault: `binary.rs`: `[down, down - 1].map(|bits| value >> bits.min(63))` →
///   `[down, down].map(|bits| value >> bits.min(63))`: the wrong bit rounds.
#[kani::proof]
#[kani::unwind(4)]
fn scaling_rounds_and_limits() {
    let (value, exponent): (i64, i32) = (kani::any(), kani::any());
    kani::assume((-70..=62).contains(&exponent));
    let found = i128::from(scaled(value, exponent));
    let limit = i128::from(i64::MAX);
    let exact = i128::from(value);
    kani::cover!(exponent < 0 && found == -limit / 2);
    kani::cover!(exponent > 0 && found == limit);
    if exponent >= 0 {
        assert_eq!(found, (exact << exponent).clamp(-limit, limit));
    } else {
        let twice_error = 2 * ((found << -exponent) - exact);
        assert!(-(1_i128 << -exponent) < twice_error && twice_error <= 1_i128 << -exponent);
    }
}

/// No scaling overflows on the way.
///
/// - Domain: all 64-bit numbers, all 32-bit exponents.
/// - Fault: `binary.rs`: `if value.unsigned_abs().leading_zeros() <= up {` →
///   `if value.unsigned_abs().leading_zeros() < up {`: the sign bit is shifted into.
#[kani::proof]
#[kani::unwind(4)]
fn scaling_keeps_signs() {
    let (value, exponent): (i64, i32) = (kani::any(), kani::any());
    let found = scaled(value, exponent);
    kani::cover!(exponent == i32::MIN);
    assert!(found == 0 || found.signum() == value.signum());
    assert!(found != i64::MIN);
}

/// A product without surplus bits is exact, and limited where it does not fit.
///
/// - Domain: all pairs of a 64-bit and a 4-bit number, up to 16 surplus bits.
/// - Fault: `binary.rs`: `let half = (1_i128 << bits) >> 1;` → `let half = 1_i128 << bits;`: rounded up by half a
///   unit.
#[kani::proof]
#[kani::solver(z3)]
fn products_are_rounded() {
    let (one, other, bits): (i64, i8, u8) = (kani::any(), kani::any(), kani::any());
    kani::assume((-8..8).contains(&other) && bits <= 16);
    let exact = i128::from(one) * i128::from(other);
    let found = product(one, i64::from(other), bits);
    kani::cover!(found == i64::MAX);
    let twice_error = 2 * ((i128::from(found) << bits) - exact);
    let fits = -(1_i128 << bits) < twice_error && twice_error <= 1_i128 << bits;
    assert!(fits || (found == i64::MAX && exact > 0) || (found == i64::MIN && exact < 0));
}

/// No product by halves overflows on the way.
///
/// - Domain: all 64-bit numbers, all 32-bit factors, all surplus bits.
/// - Fault: `binary.rs`: `.saturating_add((low * factor).saturating_add(half) >> bits)` →
///   ` + ((low * factor).saturating_add(half) >> bits)`: beyond 64 bits.
#[kani::proof]
fn no_product_by_halves_overflows() {
    let (value, factor, bits): (i64, i32, u8) = (kani::any(), kani::any(), kani::any());
    let found = times(value, factor, bits);
    kani::cover!(found == i64::MAX);
}
