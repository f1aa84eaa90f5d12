#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of numbers that are small and positive

use super::*;
use crate::codeword::encode;
use crate::drawing::View;
use crate::extents::{Shade, extents};
use crate::fit::LayerLight;
use crate::observer::Silent;
use crate::refusal::FitRefusal;
use crate::threshold::threshold;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::vec::Vec;

/// What became of a random payload in a random place, drawn with this view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Right,
    Wrong,
    Refused,
    NoExtents,
}

fn tried(view: &View, random: &mut ChaCha8Rng) -> End {
    let halves = loop {
        let payload = rand::RngExt::random::<u32>(random) >> (32 - view.format.payload_bits());
        if let Ok(halves) = encode(view.format, payload) {
            break halves;
        }
    };
    let view = view.at(rand::RngExt::random_range(random, -100.0..100.0));
    let (upper, lower) = (view.line(480, halves.0, random), view.line(480, halves.1, random));
    let (one, other) = (threshold(&upper).unwrap(), threshold(&lower).unwrap());
    let found = extents(Shade::new(&upper, &one), Shade::new(&lower, &other), view.format).take(4);
    let camera = Camera::epuck();
    let mut end = End::NoExtents;
    for (above, below) in found {
        end = match decode([&upper, &lower], [above, below], view.format, &camera, &mut Silent) {
            Ok(settled) if settled.half_words == [halves.0, halves.1] => return End::Right,
            Ok(_) => End::Wrong,
            Err(_) => End::Refused,
        };
    }
    end
}

/// The share of 50 random payloads for each blur and angle that are read right, in per mille.
fn right(format: Format, pixels: f64, blurs: &[f64], degrees: &[f64]) -> u32 {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (mut right, mut all) = (0, 0);
    for &blur in blurs {
        for angle in degrees {
            let view = View { blur, ..View::turned(format, pixels, angle.to_radians()) };
            for _ in 0..50 {
                right += u32::from(tried(&view, &mut random) == End::Right);
                all += 1;
            }
        }
    }
    1000 * right / all
}

/// At least 99 of 100 from 1.25 px per stripe on, and not many less below.
#[test]
fn small_barcodes_are_read_at_any_angle() {
    for format in [Format::Paper, Format::Wide] {
        for pixels in [1.25, 1.5, 1.75, 1.9] {
            let share = right(format, pixels, &[0.3, 0.5, 0.7], &[0.0, 30.0, -45.0, 60.0, -60.0]);
            assert!(share >= 990, "{format:?} {pixels} {share}");
        }
        let share = right(format, 1.1, &[0.3, 0.5, 0.7], &[0.0, 30.0, -45.0]);
        assert!(share >= 980, "{format:?} {share}");
    }
}

/// At a blur of 0.8 px what a stripe of 1.25 px may bring to a pixel beyond its guard takes the guard fit longer than its 5
/// steps where the barcode is very oblique.
#[test]
fn blurred_small_barcodes_are_read_up_to_45_degrees() {
    for format in [Format::Paper, Format::Wide] {
        for (pixels, degrees) in [(1.25, &[0.0, 30.0, -45.0][..]), (1.5, &[0.0, 45.0, -60.0][..])] {
            let share = right(format, pixels, &[0.8], degrees);
            assert!(share >= 980, "{format:?} {pixels} {share}");
        }
    }
}

//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-1** The *guard fit* MUST be FIT with all stripes of the code as spaces, without λ (`o' = g' = 0`, p = 4
//# + 2 per layer), over both layers, with a `k` of 0 and the means of both extents' outer edges `first - 1/2` and `last
//# + 1/2` as start.
#[test]
fn the_guard_fit_starts_between_the_means() {
    let start = guard_start((100, 129), (101, 131), &Camera::epuck()).homography;
    // Outer edges at 100 and 130.5.
    assert_eq!((start.a, start.s), (Column::from_num(115.25 - 239.5), Column::from_num(15.25)));
    assert_eq!(start.k, Obliquity::ZERO);
}

/// Hears how often both layers were fitted.
#[derive(Default)]
struct Fits(u32);

impl Observer for Fits {
    fn fitted(&mut self, _: Result<&Fitted, FitRefusal>) {
        self.0 += 1;
    }
}

/// Half words that settle have been fitted once more than they changed, and at most three times.
//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-6** Both layers MUST then be fitted with these half words (FIT) from the guard fit's `(a, s, k, σ)`, and
//# the half words be found again by the fit's model, and fitted from its `(a, s, k, σ)`, until they are the same as
//# before.
//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-7** A pair MUST be refused (`Unsettled`) whose half words have changed after the third fit.
#[test]
fn settled_half_words_have_been_fitted() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let camera = Camera::epuck();
    let (upper, lower) = encode(Format::Wide, 0x00F2_0183).unwrap();
    let (mut settled, mut unsettled) = (0, 0);
    for _ in 0..1500 {
        let view = View { blur: 1.1, noise: 30.0, ..View::turned(Format::Wide, 1.2, 0.5) };
        let lines = [upper, lower].map(|half_word| view.line(480, half_word, &mut random));
        let ends = [view.column(-1.0) + 0.5, view.column(1.0) - 0.5].map(|column| column.round() as u16);
        let (extent, mut fits) = ((ends[0], ends[1]), Fits::default());
        match decode([&lines[0], &lines[1]], [extent; 2], Format::Wide, &camera, &mut fits) {
            Ok(found) => {
                settled += 1;
                assert!((1..=3).contains(&fits.0));
                let layers = [layer(&lines[0], extent), layer(&lines[1], extent)];
                let pair = Pair { layers, format: Format::Wide, camera: &camera };
                assert_eq!(pair.half_words(&found.fitted), Some(found.half_words));
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

/// Against all half words of `paper`, in float64 over the whole window, with noise that makes others as good: the trellis
/// leaves out inks of at most 2^-8 and rounds residuals to 2^-5 grey levels.
//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-5** The half word of a layer MUST be the one with the smallest sum of squared differences between the
//# pixels and their model (TRELLIS-11) over the layer's window but for the pixel of a step of light, found by the
//# Viterbi algorithm over states of 4 code stripes, a pixel being counted with the last code stripe of `w_ij > 2^-8` as
//# one that depends on this and the 4 code stripes before it.
#[test]
fn no_other_half_word_of_a_layer_is_better() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut different = 0;
    // Even, white beyond 255 (`TRELLIS-11`), black beyond 0.
    for (white, gain) in [(150.0, -100.0), (300.0, -200.0), (60.0, -120.0)].into_iter().cycle().take(30) {
        let truth = rand::RngExt::random::<u16>(&mut random) >> 4;
        let angle = rand::RngExt::random_range(&mut random, -1.0..1.0);
        let view = View { blur: 0.45, noise: 40.0, white, gain, ..View::turned(Format::Paper, 1.25, angle) };
        let line = view.line(480, truth, &mut random);
        let extent = ((view.column(-1.0) + 0.5).round() as u16, (view.column(1.0) - 0.5).round() as u16);
        let homography =
            Homography { a: Column::from_num(view.a), s: Column::from_num(view.s), k: Obliquity::from_num(view.k) };
        let edges = Edges::new(view.format, &homography, Blur::new(Column::from_num(view.blur)), &Camera::epuck());
        let light = LayerLight { offset: (white * 256.0) as i32, gain: (gain * 256.0) as i32, ..LayerLight::default() };
        let lit = LitLayer::new(&layer(&line, extent), view.format, &light);
        let [found, again] = half_words::half_words(view.format, &edges, &[lit, lit]);
        assert_eq!(found, again);
        // For each pixel what is left without a bar in the code, and what every code stripe adds to that as a bar.
        let spaces = view.ink(480, 0);
        let pixels: Vec<(u8, f64, Vec<f64>)> = (lit.first_pixel()..=lit.last_pixel())
            .map(usize::from)
            .map(|pixel| {
                let rest = f64::from(line[pixel]) - white - gain * spaces[pixel];
                (line[pixel], rest, (4..16).map(|stripe| -gain * view.stripe_ink(stripe, pixel)).collect())
            })
            .collect();
        let squares = |half_word: u16| -> f64 {
            let bars =
                |steps: &Vec<f64>| (0..12).filter(|j| half_word >> (11 - j) & 1 == 1).map(|j| steps[j]).sum::<f64>();
            let left = |value: u8, residual: f64| match value {
                255 => residual.max(0.0),
                0 => residual.min(0.0),
                _ => residual,
            };
            pixels.iter().map(|(value, rest, steps)| left(*value, rest + bars(steps)).powi(2)).sum()
        };
        let least = (0..1 << 12).map(squares).fold(f64::INFINITY, f64::min);
        assert!(squares(found) <= 1.005 * least, "{} {least} {view:?}", squares(found));
        different += u32::from(found != truth);
    }
    assert!(different > 0);
}

/// Exposed so that white paper would be 300 grey levels and is limited to 255: most pixels that are white say that alone.
#[test]
fn overexposed_barcodes_are_read() {
    let mut random = ChaCha8Rng::seed_from_u64(23);
    for format in [Format::Paper, Format::Wide] {
        let (mut right, mut wrong) = (0, 0);
        for _ in 0..100 {
            let view = View { white: 300.0, gain: -240.0, ..View::turned(format, 1.5, 0.0) };
            match tried(&view, &mut random) {
                End::Right => right += 1,
                End::Wrong => wrong += 1,
                End::Refused | End::NoExtents => {}
            }
        }
        assert!(right >= 95, "{format:?} {right} {wrong}");
    }
}

/// Bars of 3 to 7 px are no guards of 2.25 px per stripe: most guard fits are given up (`TRELLIS-10`), and no half words
/// fitted.
#[test]
fn what_has_no_guards_is_given_up() {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let mut fitted = 0;
    for _ in 0..100 {
        let mut line = std::vec![200_u8; 480];
        let mut pixel = 200;
        while pixel < 245 {
            let [bar, space] = [3..8, 1..8].map(|widths| rand::RngExt::random_range(&mut random, widths));
            line[pixel..245.min(pixel + bar)].fill(40);
            pixel += bar + space;
        }
        line[242..245].fill(40);
        let mut fits = Fits::default();
        decode([&line, &line], [(200, 244); 2], Format::Paper, &Camera::epuck(), &mut fits).ok();
        fitted += u32::from(fits.0 > 0);
    }
    assert!(fitted < 25, "{fitted}");
}

/// Pixels whose middle lies between the outer edges of the code, widened by 3/2 px, or on one of them, do not count
/// (`TRELLIS-2`): of an extent of 40 px from 100 the code is from 107.5 to 131.5, so that 106 to 133 are left out; the
/// window is from 96 to 143.
//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-2** The guard fit MUST leave out the pixels whose middle lies between the outer edges of the code by
//# that start, or on one of them, after they are widened by 3/2 px on either side.
#[test]
fn the_guard_fit_leaves_out_the_ends_of_the_code() {
    let camera = Camera::epuck();
    let pixels = |value_at_ends: u8| {
        let mut line: Vec<u8> = (0..480).map(|pixel| if (100..140).contains(&pixel) { 90 } else { 200 }).collect();
        line[102..104].fill(200);
        line[136..138].fill(200);
        (line[106], line[133]) = (value_at_ends, value_at_ends);
        let layers = [layer(&line, (100, 139)); 2];
        let start = guard_start((100, 139), (100, 139), &camera);
        fit::fit_guards(&layers, &start, &camera, Format::Paper)
    };
    assert_eq!(pixels(90), pixels(130));
}

/// A step of light, and half words of which one has a wrong stripe: they are corrected, also where the windows are wide.
#[test]
fn half_words_are_found_again_under_a_step_of_light() {
    let camera = Camera::epuck();
    for pixels in [3.0, 12.0] {
        let view = View::turned(Format::Paper, pixels, 0.3);
        let mut random = ChaCha8Rng::seed_from_u64(21);
        let (upper, lower) = encode(view.format, 0xBEEF).unwrap();
        let mut lines = [upper, lower].map(|half_word| view.line(480, half_word, &mut random));
        lines.iter_mut().flat_map(|line| &mut line[245..]).for_each(|pixel| *pixel /= 2);
        let ends = [view.column(-1.0) + 0.5, view.column(1.0) - 0.5].map(|column| column.round() as u16);
        let reading = |half_word| Reading { first_pixel: ends[0], last_pixel: ends[1], half_word };
        let merged =
            Homography { a: Column::from_num(view.a), s: Column::from_num(view.s), k: Obliquity::from_num(view.k) };
        let again = |readings, fits: &mut Fits| {
            decode_again([&lines[0], &lines[1]], readings, &merged, view.format, &camera, fits)
        };
        for (wrong, expected) in [(1 << 5, 2), (0, 1)] {
            let mut fits = Fits::default();
            let found = again([reading(upper ^ wrong), reading(lower)], &mut fits).unwrap();
            assert_eq!((found.half_words, fits.0), ([upper, lower], expected), "{pixels}");
            assert!(found.fitted.lights.iter().all(|light| light.step.is_some()));
        }
    }
}

/// A line of runs of any width and value.
fn line() -> impl Strategy<Value = Vec<u8>> {
    let run = (prop_oneof![Just(20_u8), Just(230_u8), any::<u8>()], 1_usize..6);
    prop::collection::vec(run, 1..60).prop_map(|runs| {
        let mut line: Vec<u8> = runs.iter().flat_map(|&(value, width)| std::iter::repeat_n(value, width)).collect();
        line.resize(120, 230);
        line
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_pair_of_extents_gives_a_word_or_a_refusal(
        lines in (line(), line()),
        firsts in (0_u16..90, 0_u16..90),
        lengths in (1_u16..60, 1_u16..60),
        wide in any::<bool>(),
    ) {
        let format = if wide { Format::Wide } else { Format::Paper };
        let extent = |first: u16, length: u16| (first, (first + length).min(119));
        let extents = [extent(firsts.0, lengths.0), extent(firsts.1, lengths.1)];
        // Whatever comes out is a word of the format.
        if let Ok(settled) = decode([&lines.0, &lines.1], extents, format, &Camera::epuck(), &mut Silent) {
            let bits = u32::from(format.code_stripes());
            prop_assert!(settled.half_words.iter().all(|&word| u32::from(word) >> bits == 0));
        }
    }
}
