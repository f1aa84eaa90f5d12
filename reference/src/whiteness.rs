//! Whether what a fit leaves of the pixels is white noise (ACCEPT-15).

use crate::camera::Camera;
use crate::fit::{FitLayer, Fitted, Window, inks, is_limited};
use crate::landmark::Format;

/// The residuals' correlations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Correlations {
    /// Sum of the products of neighbours, and of pixels with one pixel between them, squared grey levels.
    pub sums: [f64; 2],
    /// Pixels that were fitted.
    pub pixels: usize,
}

impl Correlations {
    /// The larger one's mean over all pixels, squared grey levels; 0 where both are negative.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.sums.iter().fold(0.0_f64, |largest, sum| largest.max(*sum)) / self.pixels.max(1) as f64
    }
}

/// The correlations of the pixels that a fit used, less their model, grey levels.
#[must_use]
pub fn correlations(layers: &[FitLayer<'_>], fitted: &Fitted, camera: &Camera, format: Format) -> Correlations {
    let mut found = Correlations::default();
    for (layer, light) in layers.iter().zip(&fitted.lights) {
        let window = Window::of(layer.first_pixel, layer.last_pixel, format, layer.line.len());
        let inks = inks(&fitted.imaging, camera, format, layer.stripes, (window.first, window.last));
        let residuals: Vec<Option<f64>> = (window.first..)
            .zip(&inks)
            .map(|(pixel, ink)| {
                let value = layer.line[pixel];
                let fitted = !is_limited(value) && light.step != Some(pixel);
                fitted.then(|| f64::from(value) - light.model_at(&window, pixel, ink.ink))
            })
            .collect();
        found.pixels += residuals.iter().flatten().count();
        for (sum, apart) in found.sums.iter_mut().zip(1..) {
            let products = residuals.iter().zip(residuals.iter().skip(apart)).filter_map(|(&r, &q)| Some(r? * q?));
            *sum += products.sum::<f64>();
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accept::tests::Found;
    use crate::fit::Ink;

    /// A landmark's lines as its fit has them, to half a grey level, and 10 more wherever `marked` says.
    fn correlations_of(marked: impl Fn(usize) -> bool) -> Correlations {
        let mut seen = Found::at_30_cm();
        let (camera, format) = (Camera::epuck(), Format::Paper);
        let layers = seen.layers();
        let lines: Vec<Vec<u8>> = (layers.iter().zip(&seen.fitted.lights))
            .map(|(layer, light)| {
                let window = Window::of(layer.first_pixel, layer.last_pixel, format, layer.line.len());
                let inks = inks(&seen.fitted.imaging, &camera, format, layer.stripes, (0, layer.line.len() - 1));
                let model = |(pixel, ink): (usize, &Ink)| light.model_at(&window, pixel, ink.ink);
                let more = |pixel: usize| if marked(pixel) { 10.0 } else { 0.0 };
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "about 40 to 210")]
                let grey = |pixel: (usize, &Ink)| (model(pixel) + more(pixel.0)).round() as u8;
                inks.iter().enumerate().map(grey).collect()
            })
            .collect();
        seen.lines = [lines[0].clone(), lines[1].clone()];
        correlations(&seen.layers(), &seen.fitted, &camera, format)
    }

    /// Windows of 64 and four more pixels on either side; half a grey level of rounding is 1/12 squared ones, and over 70
    /// pixels and two layers 12 at random, and 60 in products with 10.
    #[test]
    fn neighbours_and_those_apart_are_told() {
        let at = |pixels: &'static [usize]| correlations_of(|pixel| pixels.contains(&pixel));
        let near = |found: Correlations, expected: [f64; 2]| {
            found.pixels == 144 && found.sums.iter().zip(expected).all(|(sum, expected)| (sum - expected).abs() < 60.0)
        };
        assert!(near(at(&[]), [0.0, 0.0]));
        assert!(near(at(&[230, 231]), [200.0, 0.0]));
        assert!(near(at(&[230, 232, 250]), [0.0, 200.0]));
        assert!(near(at(&[230, 231, 232]), [400.0, 200.0]));
        // What is outside of the window is not looked at.
        assert!(near(at(&[100, 101, 300, 301]), [0.0, 0.0]));
        let largest = |sums| Correlations { sums, pixels: 10 }.largest();
        assert!((largest([30.0, -50.0]) - 3.0).abs() < 1e-12 && (largest([-30.0, 50.0]) - 5.0).abs() < 1e-12);
        assert!(largest([-30.0, -50.0]).abs() < 1e-12);
    }

    #[test]
    fn a_limited_pixel_and_that_of_a_step_are_left_out() {
        let mut seen = Found::at_30_cm();
        let count = |seen: &Found| correlations(&seen.layers(), &seen.fitted, &Camera::epuck(), Format::Paper).pixels;
        assert_eq!(count(&seen), 144);
        seen.lines[0][240] = 255;
        assert_eq!(count(&seen), 143);
        seen.fitted.lights[1].step = Some(230);
        assert_eq!(count(&seen), 142);
    }
}
