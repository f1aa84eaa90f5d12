//! Angles that wrap.

use fixedpoint::formats::Angle;

fn any_angle() -> Angle {
    Angle::from_bits(kani::any())
}

/// Angles are a group under addition: they wrap, and nothing overflows.
///
/// - Domain: all three angles.
/// - Fault: `formats.rs`: `Self(self.0.wrapping_neg())` → `Self(!self.0)`: a unit less.
#[kani::proof]
fn angles_wrap() {
    let (a, b, c) = (any_angle(), any_angle(), any_angle());
    kani::cover!(a.to_bits() > 0 && b.to_bits() > 0 && (a + b).to_bits() < 0);
    assert!(a + (b + c) == (a + b) + c && a + b == b + a && a + Angle::ZERO == a);
    assert!(a - b == a + -b && a + -a == Angle::ZERO && -(-a) == a && -Angle::PI == Angle::PI);
}

/// The difference of two angles is the short way round: what their numbers differ by, less whole turns.
///
/// - Domain: all pairs of angles.
/// - Fault: `formats.rs`: `Self(self.0.wrapping_sub(other.0))` → `Self(self.0.saturating_sub(other.0))`: the long way
///   is cut off.
#[kani::proof]
fn differences_are_the_short_way_round() {
    let (a, b) = (any_angle(), any_angle());
    let difference = i64::from((a - b).to_bits());
    let turns = i64::from(a.to_bits()) - i64::from(b.to_bits()) - difference;
    kani::cover!(turns < 0);
    assert!(turns == 0 || turns == 1 << 32 || turns == -(1 << 32));
}
