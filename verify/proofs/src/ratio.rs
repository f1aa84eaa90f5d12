//! Rounding to nearest, halves up.

use fixedpoint::ratio::dropped;

/// Surplus bits are rounded to nearest, halves up.
///
/// - Domain: 1 to 62 bits of all numbers within ±(2^63 - 2^62).
/// - Fault: `ratio.rs`: `saturating_sub(1)).unwrap_or(0);` → `saturating_sub(1)).unwrap_or(0) - 1;`: halves are
///   rounded down.
#[kani::proof]
fn surplus_bits_are_rounded() {
    let (value, bits): (i64, u8) = (kani::any(), kani::any());
    kani::assume((1..=62).contains(&bits) && value.unsigned_abs() < (1 << 63) - (1 << 62));
    let twice_error = 2 * ((i128::from(dropped(value, bits)) << bits) - i128::from(value));
    kani::cover!(twice_error == 1 << bits);
    assert!(-(1_i128 << bits) < twice_error && twice_error <= 1_i128 << bits);
}
