//! Whether a barcode ends where it was read: the white beside a layer, by the light that was fitted to it.

use crate::fit::{FitLayer, LayerLight};
use crate::ink::Edges;
use crate::landmark::Format;
use crate::light::LitLayer;

/// What a pixel beside a layer counts as (`ACCEPT-17`); neither outside of the line, and both at the step of light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Shade {
    white: bool,
    dark: bool,
}

/// The pixels beside a layer.
struct Surroundings<'a> {
    format: Format,
    edges: &'a Edges,
    layer: &'a FitLayer<'a>,
    lit: LitLayer<'a>,
    /// `2 |ḡ|` in 2^-8 grey levels, below 2^18.
    contrast: u32,
}

impl Surroundings<'_> {
    /// The shade of a pixel; of no pixel where there is none to the left of the line.
    ///
    /// Four times a residual, in 2^-8 grey levels within ±1788 grey levels, is below 2^21.
    //= reference/SPEC.md#accept
    //# - **ACCEPT-17** A pixel beside an ROI MUST count as white if it is in the line and at most `|ḡ|/2` darker than
    //# its model (TRELLIS-11), as dark if it is in the line and at least `|ḡ|/2` darker, and as both if it is the pixel
    //# of a step of light, λ beyond the window being that of the window's nearest end.
    fn shade(&self, pixel: Option<u16>) -> Shade {
        let Some((pixel, seen)) = pixel.and_then(|pixel| Some((pixel, self.lit.anywhere(pixel)?))) else {
            return Shade::default();
        };
        if self.lit.is_step(pixel) {
            return Shade { white: true, dark: true };
        }
        let (least, greatest) = seen.limited.range();
        let residual = seen.residual(self.edges.layer(self.format, self.layer.stripes, pixel)).clamp(least, greatest);
        let darker = if residual < 0 { residual.unsigned_abs() } else { 0 };
        Shade { white: 4 * darker <= self.contrast, dark: 4 * darker >= self.contrast }
    }

    /// Whether one side, its pixels by their distance, is clear.
    ///
    /// The more pixels are taken for white, the fewer have to be dark: so as many as can be are.
    fn is_side_clear(&self, quiet: u16, pixel: impl Fn(u16) -> Option<u16>) -> bool {
        let shade = |distance: u16| self.shade(pixel(distance));
        match (1..=quiet).find(|&distance| !shade(distance).white) {
            None => true,
            Some(first) => (first..=4 * quiet).all(|distance| shade(distance).dark),
        }
    }
}

/// The least `q` with `N (q + 1) >= 2 e`, at most 63 for the 640 px of a line.
fn quiet_pixels(format: Format, layer: &FitLayer<'_>) -> u16 {
    let extent = layer.last_pixel.saturating_sub(layer.first_pixel).saturating_add(1);
    extent.div_ceil(u16::from(format.stripes() / 2)).saturating_sub(1)
}

/// Whether a layer has a quiet zone on either side (`ACCEPT-16`, `ACCEPT-17`), `contrast` being `2 |ḡ|` in 2^-8 grey levels,
/// below 2^18: `2 d <= |ḡ|` is `4 d <= 2 |ḡ|`, exactly.
///
/// The errors of a model are those of [`crate::light::Seen`] and of the ink.
#[must_use]
pub fn is_clear(format: Format, edges: &Edges, layer: &FitLayer<'_>, light: &LayerLight, contrast: u32) -> bool {
    let lit = LitLayer::new(layer, format, light);
    let surroundings = Surroundings { format, edges, layer, lit, contrast };
    let quiet = quiet_pixels(format, layer);
    surroundings.is_side_clear(quiet, |distance| layer.first_pixel.checked_sub(distance))
        && surroundings.is_side_clear(quiet, |distance| layer.last_pixel.checked_add(distance))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of numbers that are small and positive

    use super::*;
    use crate::camera::Camera;
    use crate::drawing::View;
    use crate::edge::Blur;
    use crate::fit;
    use crate::formats::{Column, Obliquity};
    use crate::homography::Homography;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use std::vec::Vec;

    const HALF_WORD: u16 = 0b1011_0011_0101;
    /// White 200 and black 40, so that half of the contrast is 80 grey levels.
    const LIGHT: LayerLight =
        LayerLight { offset: 200 << 8, gain: -160 << 8, offset_slope: 0, gain_slope: 0, step: None };

    /// A layer of 20 stripes of 4 px, from the pixel `first` to `first + 79`: `q` is 7, and 4 q is 28.
    struct Drawn {
        view: View,
        line: Vec<u8>,
        first: u16,
    }

    impl Drawn {
        fn at(first: u16) -> Self {
            let view = View { noise: 0.0, ..View::turned(Format::Paper, 4.0, 0.0) }.at(f64::from(first) - 200.0);
            let line = view.line(480, HALF_WORD, &mut ChaCha8Rng::seed_from_u64(1));
            Self { view, line, first }
        }

        /// Pixels on the right, by their distance from the layer.
        fn right(mut self, changes: impl IntoIterator<Item = (u16, u8)>) -> Self {
            for (distance, value) in changes {
                self.line[usize::from(self.first + 79 + distance)] = value;
            }
            self
        }

        fn is_clear_in(&self, light: &LayerLight) -> bool {
            let View { a, s, k, .. } = self.view;
            let homography = Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) };
            let edges = Edges::new(Format::Paper, &homography, Blur::new(Column::ONE / 2), &Camera::epuck());
            let (first_pixel, last_pixel) = (self.first, self.first + 79);
            let stripes = fit::stripes(Format::Paper, HALF_WORD);
            let layer = FitLayer { line: &self.line, first_pixel, last_pixel, stripes };
            is_clear(Format::Paper, &edges, &layer, light, 2 * light.gain.unsigned_abs())
        }

        fn is_clear(&self) -> bool {
            self.is_clear_in(&LIGHT)
        }
    }

    /// Whether it is clear with these pixels on the right and, the same, with these on the left.
    fn clear(changes: &[(u16, u8)]) -> bool {
        let right = Drawn::at(200).right(changes.iter().copied());
        let mut left = Drawn::at(200);
        for &(distance, value) in changes {
            left.line[usize::from(200 - distance)] = value;
        }
        assert_eq!(left.is_clear(), right.is_clear(), "{changes:?}");
        right.is_clear()
    }

    /// These distances, of this value.
    fn run(distances: core::ops::RangeInclusive<u16>, value: u8) -> Vec<(u16, u8)> {
        distances.map(|distance| (distance, value)).collect()
    }

    /// `ACCEPT-16`: the least `q` with `N (q + 1) >= 2 e`, searched for.
    #[test]
    fn the_quiet_zone_is_a_tenth_or_a_twelfth_of_the_extent_less_a_pixel() {
        for format in [Format::Paper, Format::Wide] {
            let n = u16::from(format.stripes());
            for e in 1..=640_u16 {
                let layer = FitLayer { line: &[], first_pixel: 0, last_pixel: e - 1, stripes: 0 };
                let least = (0..640).find(|q| n * (q + 1) >= 2 * e).unwrap();
                assert_eq!(quiet_pixels(format, &layer), least, "{format:?} {e}");
                assert!(least <= 63);
            }
        }
    }

    #[test]
    fn a_bar_may_begin_beyond_the_quiet_zone_only() {
        assert!(clear(&[]) && clear(&run(8..=11, 40)));
        for first in 1..=7 {
            assert!(!clear(&run(first..=first + 3, 40)), "{first}");
        }
    }

    #[test]
    fn a_shadow_is_dark_for_eight_stripes() {
        for first in 1..=7 {
            assert!(clear(&run(first..=28, 40)), "{first}");
            assert!(!clear(&run(first..=27, 40)), "{first}");
        }
        let with = |other: (u16, u8)| [run(3..=28, 40), std::vec![other]].concat();
        assert!((3..=28).all(|distance| clear(&with((distance, 40)))));
        // One that gets bright again on its way is none, unless its first pixel is what is bright.
        assert!(clear(&with((3, 200))) && (4..=28).all(|distance| !clear(&with((distance, 200)))));
    }

    /// `ACCEPT-17`: 200 less 80 is white and dark, a grey level more is white, one less is dark.
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-17** A pixel beside an ROI MUST count as white if it is in the line and at most `|ḡ|/2` darker than
    //# its model (TRELLIS-11), as dark if it is in the line and at least `|ḡ|/2` darker, and as both if it is the pixel
    //# of a step of light, λ beyond the window being that of the window's nearest end.
    #[test]
    fn half_of_the_contrast_parts_white_and_dark() {
        assert!(clear(&[(4, 121)]) && clear(&[(4, 120)]) && !clear(&[(4, 119)]));
        let shadow = |value| [run(4..=28, 40), std::vec![(20, value)]].concat();
        assert!(clear(&shadow(119)) && clear(&shadow(120)) && !clear(&shadow(121)));
    }

    #[test]
    fn what_is_beyond_the_line_is_neither_white_nor_dark() {
        let cut = |pixels: usize, changes: Vec<(u16, u8)>| {
            let mut drawn = Drawn::at(200).right(changes);
            drawn.line.truncate(280 + pixels);
            drawn.is_clear()
        };
        assert!(cut(7, Vec::new()) && !cut(6, Vec::new()));
        assert!(cut(28, run(3..=28, 40)) && !cut(27, run(3..=28, 40)));
        let left = |first: u16, shadow: usize| {
            let mut drawn = Drawn::at(first);
            drawn.line[..shadow].fill(40);
            drawn.is_clear()
        };
        assert!(left(7, 0) && !left(6, 0));
        assert!(left(28, 26) && !left(27, 25));
    }

    /// `TRELLIS-11` in `ACCEPT-17`: 255 is not darker than a model of 300, 254 is by 46, more than half of a contrast of 80.
    #[test]
    fn a_limited_white_is_white() {
        let light = LayerLight { offset: 300 << 8, gain: -80 << 8, ..LIGHT };
        let seen = |value| {
            let mut drawn = Drawn::at(200).right([(5, value)]);
            drawn.line[..200].fill(255);
            let beside = (1..=28).filter(|&distance| distance != 5).map(|distance| (distance, 255));
            drawn.right(beside).is_clear_in(&light)
        };
        assert!(seen(255) && !seen(254));
    }

    #[test]
    fn the_pixel_of_a_step_of_light_is_white_and_dark() {
        let step = LayerLight { step: Some(282), ..LIGHT };
        // Distance 3: dark in the white, and bright in a shadow from 2 on.
        let spot = Drawn::at(200).right([(3, 0)]);
        assert!(spot.is_clear_in(&step) && !spot.is_clear());
        let shadow = Drawn::at(200).right(run(2..=28, 40)).right([(3, 200)]);
        assert!(shadow.is_clear_in(&step) && !shadow.is_clear());
    }

    /// The light falls from 260 at the window's first pixel to 140 at its last, 283, and not any further: 59 is 81 grey levels
    /// darker, and would be 77 at a distance of 7 if the light went on falling. At a step it does not change beside it.
    #[test]
    fn light_beside_the_window_is_that_of_its_end() {
        let shadow = |value| Drawn::at(200).right(run(4..=28, value));
        let even = LayerLight { offset_slope: -60 << 8, ..LIGHT };
        let step = LayerLight { step: Some(240), ..even };
        for light in [even, step] {
            let left_is_260 = |mut drawn: Drawn| {
                drawn.line[..200].fill(250);
                drawn.is_clear_in(&light)
            };
            assert!(left_is_260(shadow(61)) && left_is_260(shadow(59)));
            assert!(!left_is_260(shadow(59).right([(27, 61)])) && !left_is_260(shadow(59).right([(5, 61)])));
        }
    }
}
