#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_possible_wrap)] // of numbers in range

use super::*;
use proptest::prelude::*;
use std::f64::consts::PI;

fn upper_tail(z: f64) -> f64 {
    libm::erfc(z / 2_f64.sqrt()) / 2.0
}

fn density(z: f64) -> f64 {
    (-z * z / 2.0).exp() / (2.0 * PI).sqrt()
}

/// `ρ(t)` of EDGE-1.
fn blurred(t: f64, sigma: f64) -> f64 {
    t * upper_tail(-t / sigma) + sigma * density(t / sigma)
}

#[test]
fn the_table_holds_the_tails() {
    for (place, entry) in (0_u8..).zip(TAILS) {
        let z = f64::from(place) / 16.0;
        let exact = [density(z) - z * upper_tail(z), upper_tail(z), density(z)];
        assert_eq!(entry, exact.map(|value| (value * 65_536.0).round() as u16), "at {z}");
    }
}

proptest! {
    //= reference/SPEC.md#edge
    //= type=test
    //# - **EDGE-1** The ink that an edge from white at its left to black at its right brings to a pixel whose middle is
    //# `u` px to the right of it MUST be `c(u) = ρ(u + 1/2) - ρ(u - 1/2)` with `ρ(t) = t Φ(t/σ) + σ φ(t/σ)`, σ the
    //# blur, Φ the normal distribution and φ its density (RENDER-1, RENDER-2).
    #[test]
    fn an_edge_is_that_of_the_specification(t in -7.0..7.0_f64, sigma in 0.2..1.2_f64) {
        let blur = Blur::new(Column::from_num(sigma));
        let found = blur.boundary((t * 65_536.0).round() as i32);
        let unit = |value: i32| f64::from(value) / 65_536.0;
        prop_assert!((unit(found.ink) - blurred(t, sigma)).abs() < 7e-5, "{:?}", found);
        prop_assert!((unit(found.distribution) - upper_tail(-t / sigma)).abs() < 2.5e-4, "{:?}", found);
        prop_assert!((unit(found.density) - density(t / sigma)).abs() < 4e-4, "{:?}", found);
    }

    //= reference/SPEC.md#edge
    //= type=test
    //# - **EDGE-2** The ink of a pixel MUST be the sum of `c` over all edges of a layer from white to black less that
    //# over all edges from black to white.
    #[test]
    fn ink_is_that_of_the_specification(u in -7.0..7.0_f64, sigma in 0.2..1.2_f64) {
        let found = ink((u * 65_536.0).round() as i32, &Blur::new(Column::from_num(sigma)));
        let exact = blurred(u + 0.5, sigma) - blurred(u - 0.5, sigma);
        prop_assert!((f64::from(found) / 65_536.0 - exact).abs() < 1.4e-4);
    }
}
