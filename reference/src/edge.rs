//! The image of one edge: how much of a pixel is ink (EDGE).

use core::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Standard deviations beyond which an edge is complete: what is left, φ(6.5)/6.5², is 6e-12.
const REACH: f64 = 6.5;

/// What an edge does to one pixel, and how that changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// Ink, from 0 for white to 1 for black.
    pub ink: f64,
    /// Its derivative by the pixel's distance from the edge, per pixel.
    pub by_distance: f64,
    /// Its derivative by the blur, per pixel.
    pub by_blur: f64,
}

/// The ink of a pixel whose middle lies `distance` px to the right of an edge from white to black, blurred by a
/// Gaussian of the standard deviation `blur` > 0 in pixels (EDGE-1).
//= reference/SPEC.md#edge
//# - **EDGE-1** The ink that an edge from white at its left to black at its right brings to a pixel whose middle is `u`
//# px to the right of it MUST be `c(u) = ρ(u + 1/2) - ρ(u - 1/2)` with `ρ(t) = t Φ(t/σ) + σ φ(t/σ)`, σ the blur, Φ the
//# normal distribution and φ its density (RENDER-1, RENDER-2).
#[must_use]
pub fn ink(distance: f64, blur: f64) -> f64 {
    response(distance, blur).ink
}

/// The ink of EDGE-1 and its derivatives.
#[must_use]
pub fn response(distance: f64, blur: f64) -> Response {
    if distance.abs() > reach(blur) {
        return Response { ink: if distance > 0.0 { 1.0 } else { 0.0 }, ..Response::default() };
    }
    between(&Boundary::at(distance - 0.5, blur), &Boundary::at(distance + 0.5, blur))
}

/// Tells `hear` of every pixel of `first..=last` in which an edge at `column` brings ink, and of its response there.
pub fn responses(column: f64, blur: f64, (first, last): (usize, usize), mut hear: impl FnMut(usize, Response)) {
    let reach = reach(blur);
    let near = (first..=last).filter(|&pixel| (pixel as f64 - column).abs() <= reach);
    let mut left: Option<Boundary> = None;
    for pixel in near {
        let distance = pixel as f64 - column;
        // A pixel ends where the next one begins.
        let before = left.unwrap_or_else(|| Boundary::at(distance - 0.5, blur));
        let after = Boundary::at(distance + 0.5, blur);
        hear(pixel, between(&before, &after));
        left = Some(after);
    }
    let beyond = Response { ink: 1.0, ..Response::default() };
    (first..=last).filter(|&pixel| pixel as f64 - column > reach).for_each(|pixel| hear(pixel, beyond));
}

/// Pixels from an edge beyond which a pixel is all or nothing.
fn reach(blur: f64) -> f64 {
    REACH * blur + 0.5
}

/// A pixel's end at a distance from the edge.
#[derive(Clone, Copy)]
struct Boundary {
    /// ρ of EDGE-1.
    ramp: f64,
    /// Φ
    share: f64,
    /// φ
    density: f64,
}

impl Boundary {
    fn at(t: f64, blur: f64) -> Self {
        let z = t / blur;
        let (share, density) = (distribution(z), density(z));
        Self { ramp: t * share + blur * density, share, density }
    }
}

fn between(left: &Boundary, right: &Boundary) -> Response {
    Response {
        ink: right.ramp - left.ramp,
        by_distance: right.share - left.share,
        by_blur: right.density - left.density,
    }
}

/// The standard normal distribution Φ.
fn distribution(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// The density φ of the standard normal distribution.
fn density(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / TAU.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The integral of Φ over the pixel by Simpson's rule, from the error function's own power series.
    fn integrated(distance: f64, blur: f64) -> f64 {
        let share = |t: f64| {
            let z = t / blur;
            let series = (0..80).scan(z, |term, n| {
                let value = *term;
                *term *= z * z / f64::from(2 * n + 3);
                Some(value)
            });
            // Φ(z) = 1/2 + φ(z) (z + z³/3 + z⁵/15 + …)
            0.5 + (-0.5 * z * z).exp() / TAU.sqrt() * series.sum::<f64>()
        };
        let steps: i32 = 200;
        let at = |i: i32| share(distance - 0.5 + f64::from(i) / f64::from(steps));
        let weight = |i: i32| {
            if i == 0 || i == steps {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=steps).map(|i| weight(i) * at(i)).sum::<f64>() / f64::from(3 * steps)
    }

    proptest! {
        //= reference/SPEC.md#edge
        //= type=test
        //# - **EDGE-1** The ink that an edge from white at its left to black at its right brings to a pixel whose
        //# middle is `u` px to the right of it MUST be `c(u) = ρ(u + 1/2) - ρ(u - 1/2)` with `ρ(t) = t Φ(t/σ) + σ
        //# φ(t/σ)`, σ the blur, Φ the normal distribution and φ its density (RENDER-1, RENDER-2).
        #[test]
        fn the_ink_is_the_blurred_step_integrated_over_the_pixel(distance in -1.5..1.5f64, blur in 0.3..1.2f64) {
            prop_assert!((ink(distance, blur) - integrated(distance, blur)).abs() < 1e-8);
        }

        #[test]
        fn derivatives_are_those_of_the_ink(distance in -3.0..3.0f64, blur in 0.2..1.2f64) {
            let h = 1e-5;
            let found = response(distance, blur);
            let by_distance = (ink(distance + h, blur) - ink(distance - h, blur)) / (2.0 * h);
            let by_blur = (ink(distance, blur + h) - ink(distance, blur - h)) / (2.0 * h);
            prop_assert!((found.by_distance - by_distance).abs() < 1e-7 && (found.by_blur - by_blur).abs() < 1e-7);
        }
    }

    #[test]
    fn an_edge_far_away_is_all_or_nothing() {
        assert!(ink(-8.0, 1.0).abs() < 1e-10 && (ink(8.0, 1.0) - 1.0).abs() < 1e-10);
        assert!(ink(-6.9, 1.0).abs() < 1e-10 && (ink(6.9, 1.0) - 1.0).abs() < 1e-10);
        assert!((ink(0.0, 0.5) - 0.5).abs() < 1e-15);
    }
}
