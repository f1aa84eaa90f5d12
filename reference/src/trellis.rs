//! The most likely code word of a pair of extents: maximum-likelihood sequence detection over the blur's reach (TRELLIS).

use crate::accept::View;
use crate::camera::Camera;
use crate::edge;
use crate::extents::{Extent, Pair};
use crate::fit::{
    FitLayer, Fitted, Illumination, Imaging, LayerLight, Plan, START_BLUR, Window, difference, fit, fit_windows,
};
use crate::homography::{Homography, coordinate};
use crate::landmark::{Format, GUARD_PAIRS, stripes};
use crate::observer::Observer;
use crate::refusal::CandidateRefusal;

/// Fits after which the half words must have settled (TRELLIS-7).
const MAX_FITS: usize = 3;

/// Code stripes before the last one on which a pixel depends: the trellis has `2^MEMORY` states (TRELLIS-5).
const MEMORY: usize = 4;

/// Ink above which a pixel depends on a stripe (TRELLIS-5).
const LEAST_INK: f64 = 1.0 / 256.0;

/// What a pair of extents says.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// The half words, upper first.
    pub half_words: [u32; 2],
    /// The fit with these.
    pub fitted: Fitted,
}

/// Decodes a pair of extents (TRELLIS-1 to TRELLIS-7).
pub fn decode<O: Observer>(pair: &Pair, view: &View<'_>, observer: &mut O) -> Result<Settled, CandidateRefusal> {
    let guards = guard_fit(pair, &guard_start(pair, view.camera), view)?;
    decode_after(pair, &guards.imaging, &guards.lights, view, observer)
}

/// Where the guard fit of a pair of extents starts (TRELLIS-1).
//= reference/SPEC.md#trellis
//# - **TRELLIS-1** The *guard fit* MUST be FIT with all stripes of the code as spaces, without λ (`o' = g' = 0`, p = 4
//# + 2 per layer), over both layers, with a `k` of 0 and the means of both extents' outer edges `first - 1/2` and `last
//# + 1/2` as start.
#[must_use]
pub fn guard_start(pair: &Pair, camera: &Camera) -> Homography {
    let [upper, lower] = pair;
    // Twice the outer edges' means.
    let (left, right) = (upper.first + lower.first, upper.last + lower.last + 2);
    let (left, right) = (left as f64 - 1.0, right as f64 - 1.0);
    Homography { a: (left + right) / 4.0 - camera.principal_column, s: (right - left) / 4.0, k: 0.0 }
}

/// The guard fit of a pair of extents from a homography (TRELLIS-1 to TRELLIS-3, TRELLIS-10).
pub fn guard_fit(pair: &Pair, start: &Homography, view: &View<'_>) -> Result<Fitted, CandidateRefusal> {
    Trial::new(pair, view, Illumination::Even).guard_fit(start)
}

/// Decodes a pair of extents of which the guards are known (TRELLIS-5 to TRELLIS-7).
pub fn decode_after<O: Observer>(
    pair: &Pair,
    imaging: &Imaging,
    lights: &[LayerLight],
    view: &View<'_>,
    observer: &mut O,
) -> Result<Settled, CandidateRefusal> {
    let trial = Trial::new(pair, view, Illumination::Even);
    trial.settle(trial.half_words(imaging, lights), imaging, observer)
}

/// Decodes a pair of ROIs again whose half words, read by a threshold in a shadow, make no code word (TRELLIS-9).
//= reference/SPEC.md#trellis
//# - **TRELLIS-9** A pair of layers of which at least one was found by the local threshold and whose code word CODE-8
//# refuses MUST be decided again as one of EXTENT-7's pairs: fitted under a step of light from the merged homography,
//# with the half words as they were read and a blur of 1/2, and then as TRELLIS-6 to TRELLIS-8 say, each fit from the
//# one before it, under a step of light.
pub fn decode_again<O: Observer>(
    pair: &Pair,
    half_words: [u32; 2],
    start: &Homography,
    view: &View<'_>,
    observer: &mut O,
) -> Result<Settled, CandidateRefusal> {
    let trial = Trial::new(pair, view, Illumination::Step);
    trial.settle(half_words, &Imaging { homography: *start, blur: START_BLUR }, observer)
}

/// A pair of extents under trial.
struct Trial<'a> {
    pair: &'a Pair,
    lines: [&'a [u8]; 2],
    camera: &'a Camera,
    format: Format,
    illumination: Illumination,
}

impl<'a> Trial<'a> {
    fn new(pair: &'a Pair, view: &View<'a>, illumination: Illumination) -> Self {
        Self { pair, lines: view.lines, camera: view.camera, format: view.landmark.format, illumination }
    }

    /// TRELLIS-6, TRELLIS-7
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-6** Both layers MUST then be fitted with these half words (FIT) from the guard fit's `(a, s, k, σ)`,
    //# and the half words be found again by the fit's model, and fitted from its `(a, s, k, σ)`, until they are the
    //# same as before.
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-7** A pair MUST be refused (`Unsettled`) whose half words have changed after the third fit.
    fn settle<O: Observer>(
        &self,
        mut half_words: [u32; 2],
        start: &Imaging,
        observer: &mut O,
    ) -> Result<Settled, CandidateRefusal> {
        let mut imaging = *start;
        for _ in 0..MAX_FITS {
            let fitted = self.fit(half_words, &imaging);
            observer.fitted(fitted.as_ref().map_err(|refusal| *refusal));
            let fitted = fitted.map_err(|_| CandidateRefusal::NoFit)?;
            let again = self.half_words(&fitted.imaging, &fitted.lights);
            if again == half_words {
                return Ok(Settled { half_words, fitted });
            }
            (half_words, imaging) = (again, fitted.imaging);
        }
        Err(CandidateRefusal::Unsettled)
    }

    fn window(&self, extent: &Extent) -> Window {
        Window::of(extent.first, extent.last, self.format, self.camera.width)
    }

    fn layers<'s>(&'s self, stripes: &'s [Vec<bool>; 2]) -> [FitLayer<'s>; 2] {
        [0, 1].map(|layer| FitLayer {
            line: self.lines[layer],
            first_pixel: self.pair[layer].first,
            last_pixel: self.pair[layer].last,
            stripes: &stripes[layer],
        })
    }

    /// TRELLIS-1 to TRELLIS-3
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-3** The guard fit MUST end as FIT-11 says or with its 12th step, with 2^-8 added to the diagonal for
    //# each layer's `g`, which counts as if FIT-6 had added it, and be refused as FIT-12, with `n < p + 8`, and FIT-13
    //# otherwise say.
    fn guard_fit(&self, start: &Homography) -> Result<Fitted, CandidateRefusal> {
        let gap = self.code_pixels();
        let windows = self.pair.map(|extent| Window { gap: gap.clone(), ..self.window(&extent) });
        let spaces = [stripes(self.format, 0), stripes(self.format, 0)];
        fit_windows(
            &self.layers(&spaces),
            &windows,
            &Imaging { homography: *start, blur: START_BLUR },
            Illumination::Even,
            Plan::Guards,
            self.camera,
            self.format,
        )
        .map_err(|_| CandidateRefusal::NoFit)
    }

    /// The pixels that may show a code stripe (TRELLIS-2), in integers: `2 N` times a column.
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-2** The guard fit MUST leave out the pixels whose middle lies between the outer edges of the code by
    //# that start, or on one of them, after they are widened by 3/2 px on either side.
    fn code_pixels(&self) -> core::ops::Range<usize> {
        let [upper, lower] = self.pair;
        let (n, guard) = (self.format.stripes(), 2 * GUARD_PAIRS);
        let left = upper.first + lower.first - 1;
        let width = upper.last + lower.last + 1 - left;
        let first = n * left + guard * width - 3 * n;
        let last = n * left + (n - guard) * width + 3 * n;
        first.div_ceil(2 * n)..last / (2 * n) + 1
    }

    fn fit(&self, half_words: [u32; 2], start: &Imaging) -> Result<Fitted, crate::refusal::FitRefusal> {
        let stripes = half_words.map(|word| stripes(self.format, word));
        fit(&self.layers(&stripes), start, self.illumination, self.camera, self.format)
    }

    /// TRELLIS-5
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-5** The half word of a layer MUST be the one with the smallest sum of squared differences between
    //# the pixels and their model (TRELLIS-11) over the layer's window but for the pixel of a step of light, found by
    //# the Viterbi algorithm over states of 4 code stripes, a pixel being counted with the last code stripe of `w_ij >
    //# 2^-8` as one that depends on this and the 4 code stripes before it.
    fn half_words(&self, imaging: &Imaging, lights: &[LayerLight]) -> [u32; 2] {
        [0, 1].map(|layer| {
            let window = self.window(&self.pair[layer]);
            let weights = weights(imaging, self.camera, self.format, (window.first, window.last));
            most_likely(&weights, &window, self.lines[layer], &lights[layer], self.format)
        })
    }
}

/// The ink `w_ij` of every stripe in every pixel of a window (TRELLIS-4), stripes first.
//= reference/SPEC.md#trellis
//# - **TRELLIS-4** The ink of stripe j in pixel i MUST be `w_ij = c(u_left) - c(u_right)`, of its two edges.
#[must_use]
pub fn weights(imaging: &Imaging, camera: &Camera, format: Format, pixels: (usize, usize)) -> Vec<Vec<f64>> {
    let middle = i32::try_from(format.stripes() / 2).unwrap_or(0);
    let columns: Vec<f64> = (0..)
        .take(format.stripes() + 1)
        .map(|edge| camera.principal_column + imaging.homography.column(coordinate(format, edge - middle)))
        .collect();
    let ink = |column: &f64| {
        let mut ink = vec![0.0; pixels.1 - pixels.0 + 1];
        edge::responses(*column, imaging.blur, pixels, |pixel, response| ink[pixel - pixels.0] = response.ink);
        ink
    };
    let inks: Vec<Vec<f64>> = columns.iter().map(ink).collect();
    let stripe = |sides: &[Vec<f64>]| sides[0].iter().zip(&sides[1]).map(|(left, right)| left - right).collect();
    inks.windows(2).map(stripe).collect()
}

/// A pixel of the trellis: its value, what it would be without the code's bars, and what each of them would change.
struct Pixel {
    value: u8,
    model: f64,
    /// Of the code stripe with which it is counted, and of those before it.
    change: [f64; MEMORY + 1],
}

/// The half word with the smallest sum of squares (TRELLIS-5).
fn most_likely(weights: &[Vec<f64>], window: &Window, line: &[u8], light: &LayerLight, format: Format) -> u32 {
    let stages = stages(weights, window, line, light, format);
    let states = 1_usize << MEMORY;
    let mut paths: Vec<Option<(f64, u32)>> = vec![None; states];
    paths[0] = Some((0.0, 0));
    for pixels in &stages {
        let mut next: Vec<Option<(f64, u32)>> = vec![None; states];
        for (before, path) in paths.iter().enumerate() {
            let Some((cost, word)) = path else { continue };
            for bit in [0, 1] {
                let state = before << 1 | bit;
                let cost = cost + pixels.iter().map(|pixel| squared_difference(pixel, state)).sum::<f64>();
                let slot = &mut next[state % states];
                if slot.is_none_or(|(least, _)| cost < least) {
                    *slot = Some((cost, word << 1 | u32::from(bit == 1)));
                }
            }
        }
        paths = next;
    }
    paths.into_iter().flatten().min_by(|one, other| one.0.total_cmp(&other.0)).map_or(0, |(_, word)| word)
}

/// The squared difference of a pixel from its model, bit q of `state` being the q-th code stripe before the current one.
fn squared_difference(pixel: &Pixel, state: usize) -> f64 {
    let changes = pixel.change.iter().enumerate().filter(|(q, _)| state >> q & 1 == 1).map(|(_, change)| change);
    let difference = difference(pixel.value, pixel.model + changes.sum::<f64>());
    difference * difference
}

/// The pixels by the last code stripe on which they depend.
fn stages(weights: &[Vec<f64>], window: &Window, line: &[u8], light: &LayerLight, format: Format) -> Vec<Vec<Pixel>> {
    let guard = 2 * GUARD_PAIRS;
    let spaces = stripes(format, 0);
    let mut stages: Vec<Vec<Pixel>> = (0..format.code_stripes()).map(|_| Vec::new()).collect();
    for (i, pixel) in (window.first..=window.last).enumerate() {
        let of_code = |code: usize| weights[guard + code][i];
        let last = (0..format.code_stripes()).rev().find(|&code| of_code(code) > LEAST_INK);
        let Some(last) = last.filter(|_| light.step != Some(pixel)) else { continue };
        let guards: f64 = spaces.iter().zip(weights).filter(|(bar, _)| **bar).map(|(_, ink)| ink[i]).sum();
        let gain = light.gain_at(window, pixel);
        let change = core::array::from_fn(|q| last.checked_sub(q).map_or(0.0, |code| gain * of_code(code)));
        let model = light.white_at(window, pixel) + gain * guards;
        stages[last].push(Pixel { value: line[pixel], model, change });
    }
    stages
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codeword;
    use crate::crossing::CrossingRule;
    use crate::extents::{extents, of_line};
    use crate::frame::Pose;
    use crate::landmark::Landmark;
    use crate::observer::Silent;
    use crate::render::{Light, Posted, Scene, Sensor, render};
    use crate::skew::Skew;
    use crate::threshold::threshold;
    use core::f64::consts::PI;
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn lines(format: Format, payload: u32, pose: (f64, f64, f64), sensor: Sensor, seed: u64) -> [Vec<u8>; 2] {
        let landmark = Landmark { stripe_height: 0.2, ..Landmark::new(format) };
        let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload };
        let (camera_in_world, light) = (Pose::new(pose.0, pose.1, pose.2), Light::default());
        let scene = Scene { camera_in_world, landmarks: vec![posted], clutter: vec![], light, sensor };
        render(&Camera::epuck(), &scene, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap()
    }

    /// Outer edges at 99.5 and 100.5 at the left, and at 129.5 and 131.5 at the right: 100 and 130.5 in the mean.
    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-1** The *guard fit* MUST be FIT with all stripes of the code as spaces, without λ (`o' = g' = 0`, p
    //# = 4 + 2 per layer), over both layers, with a `k` of 0 and the means of both extents' outer edges `first - 1/2`
    //# and `last + 1/2` as start.
    #[test]
    fn the_guard_fit_starts_between_the_means() {
        let pair = [Extent { first: 100, last: 129 }, Extent { first: 101, last: 131 }];
        let Homography { a, s, k } = guard_start(&pair, &Camera::epuck());
        assert!((a - (115.25 - 239.5)).abs() < 1e-12 && (s - 15.25).abs() < 1e-12 && k.abs() < 1e-15);
    }

    /// Of these 30.5 px the code is from 106.1 to 124.4, and with 3/2 px from 104.6 to 125.9. Of 40 px from 99.5 on it is from 107.5
    /// to 131.5, and with 3/2 px from 106 to 133, which are the middles of pixels.
    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-2** The guard fit MUST leave out the pixels whose middle lies between the outer edges of the code by
    //# that start, or on one of them, after they are widened by 3/2 px on either side.
    #[test]
    fn the_guard_fit_leaves_out_the_code() {
        let left_out = |pair: Pair| {
            let view = View {
                lines: [&[], &[]],
                camera: &Camera::epuck(),
                landmark: &Landmark::new(Format::Paper),
                rule: CrossingRule::Interpolated,
                skew: Skew::at_rest(),
            };
            Trial::new(&pair, &view, Illumination::Even).code_pixels()
        };
        assert_eq!(left_out([Extent { first: 100, last: 129 }, Extent { first: 101, last: 131 }]), 105..126);
        assert_eq!(left_out([Extent { first: 100, last: 139 }; 2]), 106..134);
    }

    /// A barcode of 22.1 px, 1.1 px per stripe, in the middle of the image.
    const SMALL: (f64, Pair) = (0.87, [Extent { first: 229, last: 250 }; 2]);

    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-3** The guard fit MUST end as FIT-11 says or with its 12th step, with 2^-8 added to the diagonal for
    //# each layer's `g`, which counts as if FIT-6 had added it, and be refused as FIT-12, with `n < p + 8`, and FIT-13
    //# otherwise say.
    #[test]
    fn the_guard_fit_converges_without_a_slope() {
        let (distance, pair) = SMALL;
        let mut converged = 0;
        for seed in 0..20 {
            let lines = lines(Format::Paper, 0xcc0d, (distance, 0.0, PI), Sensor { blur: 0.5, noise: 1.0 }, seed);
            let (camera, landmark) = (&Camera::epuck(), &Landmark::new(Format::Paper));
            let lines = lines.each_ref().map(Vec::as_slice);
            let view = View { lines, camera, landmark, rule: CrossingRule::Interpolated, skew: Skew::at_rest() };
            let fitted = guard_fit(&pair, &guard_start(&pair, camera), &view).unwrap();
            assert!((fitted.last_decrease <= 1.0 || fitted.steps == 12) && fitted.lights.len() == 2);
            converged += u32::from(fitted.steps < 12);
            let slopes = fitted.lights.iter().map(|light| light.offset_slope.abs() + light.gain_slope.abs());
            assert!(slopes.sum::<f64>() < 1e-9, "{:?}", fitted.lights);
            // 26 px of which 16 are left out, from 231.4 to 247.6, in two layers; 4 parameters and 2 of each layer.
            assert_eq!(fitted.degrees_of_freedom, 2 * (26 - 16) - 8);
        }
        assert!(converged >= 15, "{converged}");
    }

    /// Half words that settle are those of their last fit, the third at the latest.
    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-6** Both layers MUST then be fitted with these half words (FIT) from the guard fit's `(a, s, k, σ)`,
    //# and the half words be found again by the fit's model, and fitted from its `(a, s, k, σ)`, until they are the
    //# same as before.
    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-7** A pair MUST be refused (`Unsettled`) whose half words have changed after the third fit.
    #[test]
    fn settled_half_words_have_been_fitted() {
        #[derive(Default)]
        struct Fits(u32);
        impl Observer for Fits {
            fn fitted(&mut self, _: Result<&Fitted, crate::refusal::FitRefusal>) {
                self.0 += 1;
            }
        }
        let (distance, pair) = SMALL;
        let (mut settled, mut unsettled) = (0, 0);
        for seed in 0..300 {
            let lines = lines(Format::Paper, 0xcc0d, (distance, 0.0, PI), Sensor { blur: 1.0, noise: 25.0 }, seed);
            let (camera, landmark) = (&Camera::epuck(), &Landmark::new(Format::Paper));
            let lines = lines.each_ref().map(Vec::as_slice);
            let view = View { lines, camera, landmark, rule: CrossingRule::Interpolated, skew: Skew::at_rest() };
            let mut fits = Fits::default();
            match decode(&pair, &view, &mut fits) {
                Ok(found) => {
                    settled += 1;
                    assert!((1..=3).contains(&fits.0));
                    let trial = Trial::new(&pair, &view, Illumination::Even);
                    assert_eq!(trial.half_words(&found.fitted.imaging, &found.fitted.lights), found.half_words);
                }
                Err(CandidateRefusal::Unsettled) => {
                    unsettled += 1;
                    assert_eq!(fits.0, 3);
                }
                Err(refusal) => assert_eq!(refusal, CandidateRefusal::NoFit),
            }
        }
        assert!(settled > 0 && unsettled > 0, "{settled} {unsettled}");
    }

    /// 1.5 mm at 640 px are 1.25 px wide at 76.8 cm: 98 % of them.
    #[test]
    fn stripes_of_five_quarters_of_a_pixel_are_read() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let views = (0..400).filter_map(|seed| {
            let format = if random.random() { Format::Wide } else { Format::Paper };
            let payload = random.random_range(0..0x1_0000);
            let (heading, blur) = (random.random_range(-0.1..0.1), random.random_range(0.3..0.8));
            let half_words = codeword::encode(format, payload).ok()?;
            let lines = lines(format, payload, (0.768, 0.0, PI + heading), Sensor { blur, noise: 2.0 }, seed);
            Some((format, half_words, lines))
        });
        let read: Vec<bool> = views.map(|(format, half_words, lines)| is_read(format, half_words, &lines)).collect();
        let count = read.iter().filter(|&&read| read).count();
        assert!(read.len() > 350 && 100 * count >= 98 * read.len(), "{count} of {}", read.len());
    }

    /// SKEW-9: what the trellis alone can read is found at rest, and not by a camera that hardly moves.
    //= reference/SPEC.md#skew
    //= type=test
    //# - **SKEW-9** Of a moving camera TRELLIS MUST NOT be asked.
    #[test]
    fn a_moving_camera_does_not_ask_the_trellis() {
        let (camera, rule) = (Camera::epuck(), CrossingRule::Interpolated);
        let landmark = Landmark { stripe_height: 0.2, ..Landmark::new(Format::Paper) };
        // 1.2 px per stripe: too narrow for HYPO-11.
        let [upper, lower] = lines(Format::Paper, 0xcc0d, (0.8, 0.0, PI), Sensor { blur: 0.5, noise: 1.0 }, 3);
        let found = |skew: &Skew| {
            let found = crate::detect::detect_moving(&upper, &lower, &camera, &[landmark], rule, skew, &mut Silent);
            found.iter().map(|one| (one.payload, one.decoder)).collect::<Vec<_>>()
        };
        assert_eq!(found(&Skew::at_rest()), [(0xcc0d, crate::merge::Decoder::Trellis)]);
        assert_eq!(found(&Skew::of(Pose::new(0.0, 0.0, 0.0), 4)), []);
    }

    fn is_read(format: Format, (upper, lower): (u32, u32), lines: &[Vec<u8>; 2]) -> bool {
        let found = lines.each_ref().map(|line| of_line(line, &threshold(line).unwrap(), format));
        let (camera, landmark) = (&Camera::epuck(), &Landmark::new(format));
        let lines = lines.each_ref().map(Vec::as_slice);
        let view = View { lines, camera, landmark, rule: CrossingRule::Interpolated, skew: Skew::at_rest() };
        extents(&found[0], &found[1])
            .any(|pair| decode(&pair, &view, &mut Silent).is_ok_and(|settled| settled.half_words == [upper, lower]))
    }

    proptest! {
        /// The sum of squares of the word found is the least of all 4,096, up to the ink that a pixel is not counted with.
        //= reference/SPEC.md#trellis
        //= type=test
        //# - **TRELLIS-5** The half word of a layer MUST be the one with the smallest sum of squared differences
        //# between the pixels and their model (TRELLIS-11) over the layer's window but for the pixel of a step of
        //# light, found by the Viterbi algorithm over states of 4 code stripes, a pixel being counted with the last
        //# code stripe of `w_ij > 2^-8` as one that depends on this and the 4 code stripes before it.
        #[test]
        fn no_other_word_is_more_likely(values in proptest::collection::vec(20..220u8, 64), s in 11.0..16.0f64) {
            let (camera, format) = (Camera::epuck(), Format::Paper);
            let mut line = vec![200; 480];
            line[208..272].copy_from_slice(&values);
            let imaging = Imaging { homography: Homography { a: 0.3, s, k: 0.01 }, blur: 0.5 };
            let light =
                LayerLight { offset: 200.0, gain: -150.0, offset_slope: 0.0, gain_slope: 0.0, step: None };
            let window = Window::of(227, 252, format, 480);
            let weights = weights(&imaging, &camera, format, (window.first, window.last));
            let squares = |word: u32| -> f64 {
                let colours = stripes(format, word);
                (window.first..=window.last)
                    .enumerate()
                    .map(|(i, pixel)| {
                        let ink: f64 = weights.iter().zip(&colours).filter(|(_, bar)| **bar).map(|(w, _)| w[i]).sum();
                        (f64::from(line[pixel]) - 200.0 + 150.0 * ink).powi(2)
                    })
                    .sum()
            };
            let found = squares(most_likely(&weights, &window, &line, &light, format));
            let least = (0..4096).map(squares).fold(f64::INFINITY, f64::min);
            // Each of about 30 pixels misses up to two tails of 2^-8 ink, 1.2 grey levels of at most 200.
            prop_assert!(found <= least + 30.0 * 2.0 * 200.0 * 1.2);
            prop_assert!(found <= 1.02 * least + 500.0, "{found} {least}");
        }
    }

    //= reference/SPEC.md#trellis
    //= type=test
    //# - **TRELLIS-4** The ink of stripe j in pixel i MUST be `w_ij = c(u_left) - c(u_right)`, of its two edges.
    #[test]
    fn the_ink_of_all_stripes_is_that_of_a_bar() {
        let imaging = Imaging { homography: Homography { a: 5.0, s: 14.0, k: 0.05 }, blur: 0.5 };
        let weights = weights(&imaging, &Camera::epuck(), Format::Paper, (200, 280));
        let total = |pixel: usize| weights.iter().map(|stripe| stripe[pixel - 200]).sum::<f64>();
        assert!(total(210).abs() < 1e-12 && (total(244) - 1.0).abs() < 1e-12 && total(270).abs() < 1e-12);
    }
}
