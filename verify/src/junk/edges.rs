//! Ink of blurred edges, integrated over pixels (RENDER-1, RENDER-2).

use super::{Ink, MAX_WIDTH};
use core::f64::consts::{FRAC_1_SQRT_2, TAU};
use rand::{Rng, RngExt};
use std::sync::LazyLock;

/// Pixels in which an edge is felt: from 3 before its own to 4 behind it, 3.75 standard deviations of the widest blur.
const TAPS: usize = 8;

/// Pixels before an edge's own that it changes.
const BEFORE: usize = 3;

/// Places within a pixel where an edge can lie.
const PHASES: usize = 256;

/// Room beside the line for edges that are only partly in it.
const MARGIN: usize = 8;

/// Standard deviations of blur, pixels.
const BLURS: [f64; 6] = [0.3, 0.4, 0.5, 0.6, 0.7, 0.8];

/// How much the ink of each pixel changes from that of the pixel to its left, by the phase of an edge of ink 1.
type Kernel = [[f32; TAPS]; PHASES];

static KERNELS: LazyLock<Vec<Kernel>> = LazyLock::new(|| BLURS.iter().map(|&blur| kernel(blur)).collect());

/// The integral of a blurred step at 0 up to `u`.
fn integral(u: f64, blur: f64) -> f64 {
    let z = u / blur;
    u * 0.5 * libm::erfc(-z * FRAC_1_SQRT_2) + blur * libm::exp(-0.5 * z * z) / TAU.sqrt()
}

fn kernel(blur: f64) -> Kernel {
    let mut kernel = [[0.0; TAPS]; PHASES];
    for (phase, taps) in kernel.iter_mut().enumerate() {
        let mut before = 0.0;
        for (tap, change) in taps.iter_mut().enumerate() {
            // From the edge to the pixel's middle; the edge lies in the middle of its phase.
            let u = tap as f64 - BEFORE as f64 - (phase as f64 + 0.5) / PHASES as f64;
            let ink = if tap + 1 == TAPS { 1.0 } else { integral(u + 0.5, blur) - integral(u - 0.5, blur) };
            #[expect(clippy::cast_possible_truncation, reason = "24 bits of ink are enough for 8 bits of grey")]
            let rounded = (ink - before) as f32;
            *change = rounded;
            before = ink;
        }
    }
    kernel
}

/// A blur of 0.3 to 0.8 px.
#[derive(Clone, Copy)]
pub(super) struct Blur(&'static Kernel);

impl Blur {
    pub(super) fn draw<R: Rng>(rng: &mut R) -> Self {
        Self(&KERNELS[rng.random_range(0..BLURS.len())])
    }
}

/// Edges of both rows.
pub(super) struct Edges {
    blur: Blur,
    width: usize,
    changes: [[f32; MAX_WIDTH + 2 * MARGIN]; 2],
}

impl Edges {
    pub(super) fn new(width: usize, blur: Blur) -> Self {
        Self { blur, width, changes: [[0.0; MAX_WIDTH + 2 * MARGIN]; 2] }
    }

    /// From `column` (CAM-1) on to the right there is `change` more ink.
    pub(super) fn step(&mut self, row: usize, column: f32, change: f32) {
        let place = column + MARGIN as f32;
        if place < BEFORE as f32 {
            self.changes[row][0] += change;
        } else if column < (self.width + BEFORE) as f32 {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "place is not negative")]
            let (pixel, phase) = (place as usize, (place.fract() * PHASES as f32) as usize);
            let touched = &mut self.changes[row][pixel - BEFORE..][..TAPS];
            touched.iter_mut().zip(&self.blur.0[phase]).for_each(|(sum, tap)| *sum += change * tap);
        }
    }

    /// A bar of the given ink from one column to another.
    pub(super) fn bar(&mut self, row: usize, left: f32, right: f32, ink: f32) {
        self.step(row, left, ink);
        self.step(row, right, -ink);
    }

    /// The ink of all pixels.
    pub(super) fn into_ink(self) -> Ink {
        let mut ink = [[0.0; MAX_WIDTH]; 2];
        for (ink, changes) in ink.iter_mut().zip(&self.changes) {
            let mut sum: f32 = changes[..MARGIN].iter().sum();
            for (ink, change) in ink.iter_mut().zip(&changes[MARGIN..]) {
                sum += change;
                *ink = sum;
            }
        }
        ink
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reference::camera::Camera;
    use reference::frame::{Point, Pose};
    use reference::render::{Clutter, Light, Scene, Sensor, render_radiance};

    /// A strip 1 m away of the forward model, whose ends lie between two phases.
    #[test]
    fn a_bar_is_that_of_the_forward_model() {
        for (kernel, blur) in KERNELS.iter().zip(BLURS) {
            for (left, right) in [(100.25_f32, 107.75_f32), (200.5, 201.5), (-2.5, 3.25), (476.0, 482.25)] {
                let place = |column: f32| Point::new(1.0, (239.5 - f64::from(column)) / 640.0);
                let scene = Scene {
                    camera_in_world: Pose::new(0.0, 0.0, 0.0),
                    landmarks: vec![],
                    clutter: vec![Clutter { left: place(left), right: place(right), ink: 0.8 }],
                    light: Light { white: 1.0, black: 0.0, ..Light::default() },
                    sensor: Sensor { blur, noise: 0.0 },
                };
                let expected = render_radiance(&Camera::epuck(), &scene).unwrap();
                let mut edges = Edges::new(480, Blur(kernel));
                edges.bar(0, left, right, 0.8);
                edges.bar(1, left, right, 0.8);
                for (ink, expected) in edges.into_ink().iter().zip(&expected) {
                    for (i, (ink, grey)) in ink.iter().zip(expected).enumerate() {
                        // Half a phase of 1/256 px on a slope of 1 per pixel, and the tail beyond the taps.
                        let error = (f64::from(*ink) - (1.0 - grey)).abs();
                        assert!(error < 0.003, "blur {blur}, bar from {left}, pixel {i}: off by {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn edges_beside_the_line_count_for_all_of_it_or_none() {
        let mut edges = Edges::new(480, Blur(&KERNELS[5]));
        edges.step(0, -1e6, 1.0);
        edges.step(1, 1e6, 1.0);
        let ink = edges.into_ink();
        assert!(ink[0][..480].iter().all(|&ink| (ink - 1.0).abs() < 1e-6));
        assert!(ink[1][..480].iter().all(|&ink| ink == 0.0));
    }
}
