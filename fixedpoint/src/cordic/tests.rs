use super::*;
use proptest::prelude::*;
use std::f64::consts::PI;

/// The difference to `f64::atan2` in units of π/2^31, the short way round.
fn error(y: i64, x: i64) -> f64 {
    let expected = (y as f64).atan2(x as f64) / PI * 2_f64.powi(31);
    let difference = f64::from(atan2(y, x).to_bits()) - expected;
    difference - (difference / 2_f64.powi(32)).round() * 2_f64.powi(32)
}

#[test]
fn the_table_holds_arc_tangents() {
    for (i, angle) in (0..).zip(ANGLES) {
        let expected = 2_f64.powi(-i).atan() / PI * 2_f64.powi(47);
        assert!((angle as f64 - expected).abs() <= 0.51, "{i}");
    }
}

#[test]
fn the_axes_and_diagonals_are_exact() {
    for scale in [1, 3, 1 << 20, 1 << 56, i64::MAX] {
        let bits = |y: i64, x: i64| atan2(y, x).to_bits();
        assert_eq!(bits(0, scale), 0);
        assert_eq!(bits(scale, 0), 1 << 30);
        assert_eq!(bits(0, -scale), i32::MIN);
        assert_eq!(bits(-scale, 0), -1 << 30);
        assert_eq!(bits(scale, scale), 1 << 29);
        assert_eq!(bits(-scale, -scale), -3 << 29);
    }
    assert_eq!(atan2(0, 0), Angle::ZERO);
    assert_eq!(atan2(0, i64::MIN), Angle::PI);
    assert_eq!(atan2(i64::MIN, i64::MIN).to_bits(), -3 << 29);
}

#[test]
fn a_sweep_keeps_to_the_stated_error() {
    let steps = 200_000;
    for step in 0..=steps {
        let angle = (2.0 * f64::from(step) / f64::from(steps) - 1.0) * PI;
        // Integers below 2^52 are exact in floating point.
        let (sin, cos) = angle.sin_cos();
        #[expect(clippy::cast_possible_truncation, reason = "what is cut off does not matter")]
        let (y, x) = ((sin * 2_f64.powi(51)) as i64, (cos * 2_f64.powi(51)) as i64);
        assert!(error(y, x).abs() <= 0.55, "{angle}");
    }
}

proptest! {
    #[test]
    fn any_vector_keeps_to_the_stated_error(
        y in -(1_i64 << 52)..1 << 52,
        x in -(1_i64 << 52)..1 << 52,
        (fewer_y, fewer_x, more) in (0_u32..52, 0_u32..52, 0_u32..11),
    ) {
        let (y, x) = ((y >> fewer_y) << more, (x >> fewer_x) << more);
        prop_assume!((y, x) != (0, 0));
        prop_assert!(error(y, x).abs() <= 0.55);
    }
}
