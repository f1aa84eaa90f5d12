#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // of numbers that are small and positive

use super::*;
use crate::codeword::encode;
use crate::drawing::{View, stripes};
use crate::formats::Obliquity;
use crate::landmark::Format;
use crate::observer::Silent;
use crate::refusal::FitRefusal;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::vec::Vec;

/// Both lines of a view with the readings that are right for it.
struct Drawn {
    view: View,
    landmark: Landmark,
    lines: [Vec<u8>; 2],
    candidate: Candidate,
}

impl Drawn {
    /// A payload, drawn with its half words on both layers.
    fn new(view: View, payload: u32, random: &mut ChaCha8Rng) -> Self {
        let landmark = if view.format == Format::Paper { Landmark::paper() } else { Landmark::wide() };
        let (upper, lower) = encode(view.format, payload).unwrap();
        let lines = [upper, lower].map(|half_word| view.line(480, half_word, random));
        let ends = [view.column(-1.0), view.column(1.0)];
        let [first_pixel, last_pixel] = [ends[0] + 0.5, ends[1] - 0.5].map(|column| column.round() as u16);
        let readings = [upper, lower].map(|half_word| Reading { first_pixel, last_pixel, half_word });
        Self { view, landmark, lines, candidate: Candidate { payload, readings } }
    }

    fn homography(&self) -> Homography {
        let View { a, s, k, .. } = self.view;
        Homography { a: Column::from_num(a), s: Column::from_num(s), k: Obliquity::from_num(k) }
    }

    fn setting<'a>(&'a self, camera: &'a Camera) -> Setting<'a> {
        let lines = [self.lines[0].as_slice(), self.lines[1].as_slice()];
        Setting { lines, camera, landmark: &self.landmark, rule: CrossingRule::Interpolated, skew: &Skew::AT_REST }
    }

    fn fitted(&self) -> Result<Fitted, FitRefusal> {
        let camera = Camera::epuck();
        let layers = layers(&self.candidate, &self.setting(&camera));
        fit::fit(&layers, &Start::at(&self.homography()), &camera, self.view.format, Illumination::Even)
    }

    /// The decision for the layers' homographies as they were drawn, the lower one moved by these.
    fn decided(&self, a: f64, s: f64, k: f64, rule: CrossingRule) -> Result<Detection, CandidateRefusal> {
        let camera = Camera::epuck();
        let upper = self.homography();
        let moved = View { a: self.view.a + a, s: self.view.s + s, k: self.view.k + k, ..self.view };
        let lower = Drawn { view: moved, lines: [Vec::new(), Vec::new()], ..*self }.homography();
        let setting = Setting { rule, ..self.setting(&camera) };
        let evidence = Evidence::Threshold { layers: [upper, lower], shift: Shift::NONE, local: false };
        accept(&self.candidate, evidence, &setting, &mut Silent)
    }

    /// The decision of the trellis' fit.
    fn accepted_by_trellis(&self) -> Result<Detection, CandidateRefusal> {
        let (camera, fitted) = (Camera::epuck(), self.fitted().unwrap());
        accept(&self.candidate, Evidence::Trellis(&fitted), &self.setting(&camera), &mut Silent)
    }

    fn accepted(&self) -> Result<Detection, CandidateRefusal> {
        self.decided(0.0, 0.0, 0.0, CrossingRule::Interpolated)
    }
}

fn view(pixels: f64, degrees: f64) -> View {
    View::turned(Format::Paper, pixels, f64::to_radians(degrees))
}

fn drawn(view: View) -> Drawn {
    Drawn::new(view, 0xBEEF, &mut ChaCha8Rng::seed_from_u64(7))
}

#[test]
fn a_good_view_is_a_detection() {
    for (pixels, degrees) in [(1.5, 0.0), (3.0, 40.0), (8.0, -60.0)] {
        let drawn = drawn(view(pixels, degrees));
        let found = drawn.accepted().unwrap();
        assert_eq!((found.payload, found.decoder), (0xBEEF, Decoder::Threshold));
        assert_eq!([found.upper, found.lower], drawn.candidate.readings);
        let fit = found.fit.unwrap();
        // Noise 2 and rounding: 4 + 1/12 squared grey levels, known to within a half from at least 40 pixels.
        assert!((2.0..6.2).contains(&(f64::from(fit.variance) / 65536.0)), "{fit:?}");
        assert!((fit.blur.to_num::<f64>() - 0.5).abs() < 0.1, "{fit:?}");
    }
}

/// `ACCEPT-2`: 1 px in `a` and `s`, `1/20 + 1/s` in `k`, here with `s` = 20 px: a tenth. The merged `s` changes by half of
/// what the lower one does.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-2** Of a candidate of the threshold, both layers' homographies MUST agree within 1 px in `a` and in `s`
//# and within `1/20 + 1/s` in `k`, to which the whole-pixel rule adds 1 px, 1 px and 1/s, and a layer of the local
//# threshold as much (`Disagree`).
#[test]
fn layers_that_disagree_are_refused() {
    let drawn = drawn(view(2.0, 0.0));
    let agreed = |a, s, k, rule| drawn.decided(a, s, k, rule) != Err(CandidateRefusal::Disagree);
    let (rule, whole) = (CrossingRule::Interpolated, CrossingRule::WholePixel);
    assert!(agreed(1.0, 0.0, 0.0, rule) && agreed(-1.0, 0.0, 0.0, rule) && !agreed(1.001, 0.0, 0.0, rule));
    assert!(agreed(0.0, 1.0, 0.0, rule) && agreed(0.0, -1.0, 0.0, rule) && !agreed(0.0, -1.001, 0.0, rule));
    assert!(agreed(0.0, 0.0, 0.099_999, rule) && !agreed(0.0, 0.0, 0.100_001, rule));
    assert!(agreed(2.0, 2.0, 0.05, whole) && !agreed(2.001, 0.0, 0.0, whole) && !agreed(0.0, 2.001, 0.0, whole));
    assert!(agreed(0.0, 0.0, -0.149_999, whole) && !agreed(0.0, 0.0, -0.150_001, whole));
}

/// `ACCEPT-2`: the local threshold adds as much as the whole-pixel rule.
#[test]
fn the_local_threshold_gives_a_pixel_more() {
    for (rule, global) in [(CrossingRule::Interpolated, 1), (CrossingRule::WholePixel, 2)] {
        assert_eq!((pixels_apart(rule, false), pixels_apart(rule, true)), (global, global + 1));
    }
}

/// `ACCEPT-3`: `f |k| <= 3 s`.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-3** The obliquity MUST be one that a camera can see, `f |k| <= 3 s` (`Oblique`).
#[test]
fn what_no_camera_sees_is_too_oblique() {
    let camera = Camera::epuck();
    let visible = |s: f64, k: f64| {
        let (s, k) = (Column::from_num(s), Obliquity::from_num(k));
        is_visible(&Homography { a: Column::ZERO, s, k }, &camera)
    };
    // 640/64 = 10 = 3 * 3.3333
    assert!(visible(3.334, 1.0 / 64.0) && visible(3.334, -1.0 / 64.0) && !visible(3.333, 1.0 / 64.0));
    assert!(visible(160.0, 0.75) && !visible(159.999, -0.75));
    let oblique = Drawn { view: View { k: 0.1, ..view(2.0, 0.0) }, ..drawn(view(2.0, 0.0)) };
    let oblique = Drawn::new(oblique.view, 0xBEEF, &mut ChaCha8Rng::seed_from_u64(7));
    assert_eq!(oblique.accepted(), Err(CandidateRefusal::Oblique));
}

//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-4** Both gains MUST be at most -12 grey levels, and neither more than twice the other (`Contrast`).
#[test]
fn contrast_is_asked_of_both_layers() {
    let accepted = |gains: [f64; 2]| {
        let gains = gains.map(|gain| LayerLight { gain: (gain * 256.0) as i32, ..LayerLight::default() });
        has_contrast(&gains)
    };
    assert!(accepted([-12.0, -12.0]) && !accepted([-11.996, -12.0]) && !accepted([-12.0, -11.996]));
    assert!(accepted([-40.0, -80.0]) && accepted([-80.0, -40.0]));
    assert!(!accepted([-40.0, -80.01]) && !accepted([-80.01, -40.0]) && !accepted([60.0, 60.0]));
    let dim = View { gain: -10.0, noise: 0.5, ..view(4.0, 0.0) };
    assert_eq!(drawn(dim).accepted(), Err(CandidateRefusal::Contrast));
}

//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-5** The blur MUST be at most 1 px, and 0.9 px for TRELLIS (`Blur`).
#[test]
fn what_is_too_blurred_is_refused() {
    let blurred = |blur| drawn(View { blur, noise: 1.0, ..view(4.0, 0.0) });
    assert!(blurred(0.95).accepted().is_ok() && blurred(0.85).accepted_by_trellis().is_ok());
    assert_eq!(blurred(1.05).accepted(), Err(CandidateRefusal::Blur));
    assert_eq!(blurred(0.95).accepted_by_trellis(), Err(CandidateRefusal::Blur));
}

/// `ACCEPT-14`: mean gains of -160 and -150 allow a black of -20 and -18.75 grey levels, in either layer.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-14** Under even light `8 (o + g)` MUST be at least `ḡ` in both layers (`Contrast`).
#[test]
fn black_is_hardly_below_zero() {
    let possible = |blacks: [f64; 2], gains: [f64; 2], step| {
        let light = |black: f64, gain: f64| {
            let [offset, gain] = [black - gain, gain].map(|grey| (grey * 256.0).round() as i32);
            LayerLight { offset, gain, step, ..LayerLight::default() }
        };
        black_is_possible(&[light(blacks[0], gains[0]), light(blacks[1], gains[1])])
    };
    let least = 1.0 / 256.0;
    assert!(possible([-20.0, -20.0], [-160.0; 2], None));
    assert!(!possible([-20.0 - least, 0.0], [-160.0; 2], None) && !possible([0.0, -20.0 - least], [-160.0; 2], None));
    assert!(possible([-18.75, -18.75], [-100.0, -200.0], None));
    assert!(!possible([0.0, -18.75 - least], [-100.0, -200.0], None));
    assert!(possible([-300.0, -300.0], [-160.0; 2], Some(240)));
    // Black of -10 and of -40 grey levels in the light, seen as 0.
    assert!(drawn(View { white: 150.0, ..view(4.0, 0.0) }).accepted().is_ok());
    assert_eq!(drawn(View { white: 120.0, ..view(4.0, 0.0) }).accepted(), Err(CandidateRefusal::Contrast));
}

/// Any fit, with these gains.
fn fitted_with(gains: [i32; 2]) -> Fitted {
    let mut fitted = drawn(view(4.0, 0.0)).fitted().unwrap();
    for (light, gain) in fitted.lights.iter_mut().zip(gains) {
        light.gain = gain << 8;
    }
    fitted
}

/// `ACCEPT-6`: gains of -160 and -64 allow 100 + 9 and 16 + 9 squared grey levels, and by the trellis 25 + 9 and 4 + 9.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-6** The noise MUST be explained, `s² <= v` with `v = (ḡ/16)² + 9`, and `v = (ḡ/32)² + 9` for TRELLIS
//# (`Misfit`).
#[test]
fn noise_that_is_not_explained_is_refused() {
    let explained_by = |limits: Limits, variance: f64, gains: [i32; 2]| {
        limits.explain(&Fitted { variance: (variance * 65536.0) as u32, ..fitted_with(gains) })
    };
    let explained = |variance, gains| explained_by(Limits::of(Decoder::Threshold), variance, gains);
    let by_trellis = |variance, gains| explained_by(Limits::of(Decoder::Trellis), variance, gains);
    assert!(by_trellis(34.0, [-160, -160]) && !by_trellis(34.001, [-150, -170]));
    assert!(by_trellis(13.0, [-48, -80]) && !by_trellis(13.001, [-64, -64]));
    assert!(explained(25.0, [-64, -64]) && !explained(25.001, [-64, -64]));
    assert!(explained(25.0, [-48, -80]) && explained(109.0, [-160, -160]) && !explained(109.001, [-150, -170]));
    // Read as another code word, the pixels are not explained.
    let mut wrong = drawn(view(4.0, 0.0));
    wrong.candidate.readings[0].half_word ^= 0x0F0;
    assert_eq!(wrong.accepted(), Err(CandidateRefusal::Misfit));
}

/// `ACCEPT-7`: gains of -80 ask for 6400/8 and 6400/4 squared grey levels.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-7** The decision margin MUST be at least `ḡ²/8`, and `ḡ²/4` for TRELLIS (`Margin`).
#[test]
fn margins_depend_on_the_decoder() {
    let fitted = fitted_with([-70, -90]);
    let decided = |decoder, margin| Limits::of(decoder).decide(margin, &fitted);
    assert!(decided(Decoder::Threshold, 800 << 8) && !decided(Decoder::Threshold, (800 << 8) - 1));
    assert!(decided(Decoder::Trellis, 1600 << 8) && !decided(Decoder::Trellis, (1600 << 8) - 1));
    assert!(!decided(Decoder::Threshold, -1));
}

/// `ACCEPT-13`: gains of -160 allow 2 sqrt(109) and 2 sqrt(34) grey levels, 5345.4 and 2985.5 in 2^-8.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-13** The model of a pixel of the value 255 that FIT-5 left out of a window MUST be at least `255 - 2
//# sqrt(v)`, and that of one of the value 0 at most `2 sqrt(v)`, but for the pixel of a step of light (`Misfit`).
#[test]
fn limited_pixels_may_be_twice_the_noise_away() {
    let fitted = fitted_with([-160, -160]);
    let allowed = |decoder, distance| Limits::of(decoder).allow(distance, &fitted);
    assert!(allowed(Decoder::Threshold, 5345) && !allowed(Decoder::Threshold, 5346));
    assert!(allowed(Decoder::Trellis, 2985) && !allowed(Decoder::Trellis, 2986));
}

/// White is 240 grey levels, which is 255 less 15, between both limits above, and 247, which is nearer than both; in black,
/// 15 and 8 grey levels. A limited pixel is not fitted, so that nothing else changes.
#[test]
fn limited_pixels_are_those_of_the_model() {
    // 4 px per stripe: the first bar is from 200 to 203, and 197 is in the window.
    let outcome = |white: f64, pixel: usize, value: u8, trellis: bool| {
        let mut drawn = drawn(View { white, ..view(4.0, 0.0) });
        assert_eq!(drawn.candidate.readings[1].first_pixel, 200);
        drawn.lines[1][pixel] = value;
        let decided = if trellis { drawn.accepted_by_trellis() } else { drawn.accepted() };
        decided.map(|_| ())
    };
    let misfit = Err(CandidateRefusal::Misfit);
    for (near, far, pixel, value) in [(247.0, 240.0, 197, 255), (168.0, 175.0, 201, 0)] {
        assert_eq!((outcome(near, pixel, value, false), outcome(near, pixel, value, true)), (Ok(()), Ok(())));
        assert_eq!((outcome(far, pixel, value, false), outcome(far, pixel, value, true)), (Ok(()), misfit));
    }
    // Pixels that are white by the model and black in the line, or the other way round, and one out of the window
    // and of the quiet zone, of 7 px.
    assert_eq!((outcome(200.0, 197, 0, false), outcome(200.0, 201, 255, false)), (misfit, misfit));
    assert_eq!(outcome(200.0, 192, 0, false), Ok(()));
}

/// `ACCEPT-15`: gains of -160 have `v` = 109 and by the trellis 34, of which 60 pixels allow ten times as much.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-15** What a barcode leaves unexplained MUST look like noise: of the `n` pixels that were fitted, less
//# their model, the products of neighbours and those of pixels with one pixel between them, each summed over both
//# layers, come to at most `n v/6` (`Correlated`).
#[test]
fn sums_of_products_are_a_sixth_of_the_noise_at_most() {
    let fitted = fitted_with([-150, -170]);
    for (decoder, limit) in [(Decoder::Threshold, 1090_i64 << 16), (Decoder::Trellis, 340 << 16)] {
        let passed = |neighbours, one_between| {
            Limits::of(decoder).take_for_noise(&Correlations { neighbours, one_between, pixels: 60 }, &fitted)
        };
        assert!(passed(limit, limit) && passed(-limit - 1, -limit - 1));
        assert!(!passed(limit + 1, 0) && !passed(0, limit + 1));
    }
    let most = Correlations { neighbours: 1 << 48, one_between: -(1 << 48), pixels: 1280 };
    assert!(!Limits::TRELLIS.take_for_noise(&most, &fitted_with([-511, -511])));
}

#[test]
fn noise_is_taken_for_noise() {
    for seed in 0..30 {
        let view = View { noise: 3.0, ..view(3.0, 30.0) };
        let drawn = Drawn::new(view, 0xBEEF, &mut ChaCha8Rng::seed_from_u64(seed));
        assert!(drawn.accepted().is_ok() && drawn.accepted_by_trellis().is_ok(), "{seed}");
    }
}

/// Adds a wave of 16 px to both lines.
fn waved(view: View, amplitude: f64) -> Drawn {
    let mut drawn = drawn(view);
    for (place, pixel) in drawn.lines.iter_mut().flat_map(|line| (0_u16..).zip(line)) {
        let wave = amplitude * (f64::from(place) * std::f64::consts::TAU / 16.0).sin();
        *pixel = (f64::from(*pixel) + wave).round().clamp(1.0, 254.0) as u8;
    }
    drawn
}

/// A wave of amplitude `A` leaves squares of `A²/2` and products that are nearly as large: 50 of an allowed 109 and 109/6,
/// and 4.5. By the trellis 18 of 34 and 34/6.
#[test]
fn a_wave_is_no_noise() {
    let correlated = Err(CandidateRefusal::Correlated);
    assert!(waved(view(4.0, 0.0), 3.0).accepted().is_ok());
    assert_eq!(waved(view(4.0, 0.0), 10.0).accepted(), correlated);
    assert!(waved(view(4.0, 0.0), 2.0).accepted_by_trellis().is_ok());
    assert_eq!(waved(view(4.0, 0.0), 6.0).accepted_by_trellis(), correlated);
}

/// A model 0.1 px beside the barcode leaves residuals of one sign at each edge, here of the width of two pixels or three.
/// 160 grey levels times 0.1 px are 16; half the square of that for each of about 13 edges in 88 px is 19 of an allowed 34.
#[test]
fn a_displaced_model_is_no_noise() {
    let drawn = drawn(View { noise: 1.0, ..view(4.0, 0.0) });
    let decided = |displaced: f64| {
        let model = drawn.view.at(displaced);
        let squares: f64 = drawn
            .candidate
            .readings
            .iter()
            .map(|reading| {
                let [found, true_ink] = [&model, &drawn.view].map(|view| view.ink(480, reading.half_word));
                found.iter().zip(true_ink).map(|(found, ink)| (160.0 * (found - ink)).powi(2)).sum::<f64>()
            })
            .sum();
        // Of twice 88 pixels less 12 parameters, and a noise of 1.
        let variance = ((squares / 164.0 + 1.1) * 65536.0) as u32;
        let homography = Drawn { view: model, lines: [Vec::new(), Vec::new()], ..drawn }.homography();
        let fitted = Fitted { homography, variance, ..true_fit(&drawn) };
        assert!(Limits::TRELLIS.explain(&fitted));
        let camera = Camera::epuck();
        accept(&drawn.candidate, Evidence::Trellis(&fitted), &drawn.setting(&camera), &mut Silent).map(|_| ())
    };
    assert_eq!((decided(0.0), decided(0.03)), (Ok(()), Ok(())));
    assert_eq!((decided(0.1), decided(-0.1)), (Err(CandidateRefusal::Correlated), Err(CandidateRefusal::Correlated)));
}

/// `ACCEPT-16` of either layer and decoder: at 4 px per stripe `q` is 7, so that a bar may begin at 279 + 8.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-16** Of the nearest `4 q` pixels on either side of each layer's ROI or extent, with `q` the least number
//# for which `N (q + 1) >= 2 e`, the nearest `q` MUST be white, or else those before one of them white, and it and all
//# others dark (`QuietZone`).
#[test]
fn a_quiet_zone_is_asked_of_both_layers() {
    let quiet_zone = Err(CandidateRefusal::QuietZone);
    for layer in [0, 1] {
        let outcomes = |changed: &dyn Fn(&mut Vec<u8>)| {
            let mut drawn = drawn(view(4.0, 0.0));
            changed(&mut drawn.lines[layer]);
            [drawn.accepted().map(|_| ()), drawn.accepted_by_trellis().map(|_| ())]
        };
        assert_eq!(outcomes(&|line| line[287..291].fill(40)), [Ok(()); 2]);
        assert_eq!(outcomes(&|line| line[286..290].fill(40)), [quiet_zone; 2]);
        assert_eq!(outcomes(&|line| line[190..193].fill(40)), [Ok(()); 2]);
        assert_eq!(outcomes(&|line| line[190..194].fill(40)), [quiet_zone; 2]);
        assert_eq!(outcomes(&|line| line[286..308].fill(40)), [Ok(()); 2]);
        assert_eq!(outcomes(&|line| line.truncate(287)), [Ok(()); 2]);
        assert_eq!(outcomes(&|line| line.truncate(286)), [quiet_zone; 2]);
    }
}

/// `ACCEPT-9`: of two reasons the first is reported.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-9** ACCEPT-2 to ACCEPT-4, ACCEPT-14, ACCEPT-5, ACCEPT-6, ACCEPT-13, ACCEPT-15, ACCEPT-16 and ACCEPT-7
//# MUST be asked in this order, and the first that fails be reported.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-12** A candidate MUST be refused (`Undetermined`) by COV-4 last.
#[test]
fn the_first_reason_is_reported() {
    let refused = |drawn: &Drawn| drawn.accepted().unwrap_err();
    // A black that is impossible, and a blur that is too large.
    let mut dark = drawn(View { white: 120.0, blur: 1.05, noise: 1.0, ..view(4.0, 0.0) });
    assert_eq!(refused(&dark), CandidateRefusal::Contrast);
    dark = drawn(View { blur: 1.05, noise: 1.0, ..view(4.0, 0.0) });
    assert_eq!(refused(&dark), CandidateRefusal::Blur);
    // A large wave is no noise, but it is not explained, either; a smaller one, and a bar in the quiet zone.
    assert_eq!(refused(&waved(view(4.0, 0.0), 30.0)), CandidateRefusal::Misfit);
    let mut wave = waved(view(4.0, 0.0), 10.0);
    wave.lines[0][286..290].fill(40);
    assert_eq!(refused(&wave), CandidateRefusal::Correlated);
    // Stripes that the blur merges, and a line that ends with the last of them.
    let mut merged = drawn(View { blur: 0.95, noise: 0.5, ..view(1.0, 0.0) });
    assert_eq!(refused(&merged), CandidateRefusal::Margin);
    let last_pixel = usize::from(merged.candidate.readings[0].last_pixel);
    merged.lines[0].truncate(last_pixel + 1);
    assert_eq!(refused(&merged), CandidateRefusal::QuietZone);
}

//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-10** A candidate of the threshold whose fits both are refused MUST be accepted by ACCEPT-2 and ACCEPT-3
//# alone, on its merged homography, with the paper's estimate and covariance (COV-5), and say so, if the global
//# threshold found both layers, and otherwise be refused (`NoFit`).
#[test]
fn a_threshold_s_candidate_without_a_fit_is_the_paper_s() {
    // All pixels at their limits: there are none to fit.
    let mut limited = drawn(view(4.0, 0.0));
    for pixel in limited.lines.iter_mut().flatten() {
        *pixel = if *pixel > 100 { 255 } else { 0 };
    }
    let found = limited.accepted().unwrap();
    assert_eq!((found.estimator(), found.homography), (crate::merge::Estimator::Paper, limited.homography()));
    let camera = Camera::epuck();
    assert_eq!(found.camera_in_landmark, pose(&found.homography, &camera, &limited.landmark));
    assert!(found.covariance.xx > 0);
    // Found by the local threshold it is none.
    let (setting, layers, shift) = (limited.setting(&camera), [limited.homography(); 2], Shift::NONE);
    let decided =
        |local| accept(&limited.candidate, Evidence::Threshold { layers, shift, local }, &setting, &mut Silent);
    assert!(decided(false).is_ok());
    assert_eq!(decided(true), Err(CandidateRefusal::NoFit));
    // A pair of extents is refused instead, which `trellis` decides.
    assert_eq!(limited.decided(0.0, 0.0, 0.3, CrossingRule::Interpolated), Err(CandidateRefusal::Disagree));
}

/// A step of light inside the barcode misfits under even light and is explained by the second fit.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-1** A candidate of the threshold MUST be fitted (FIT) from its merged homography, under even light, and
//# if that is refused or ACCEPT-6 would refuse it, under a step of light.
#[test]
fn a_step_of_light_is_fitted_second() {
    let mut shadowed = drawn(view(5.0, 0.0));
    for line in &mut shadowed.lines {
        line[250..].iter_mut().for_each(|pixel| *pixel /= 2);
    }
    let even = shadowed.fitted();
    assert!(even.is_err() || !Limits::THRESHOLD.explain(&even.unwrap()));
    assert!(shadowed.accepted().unwrap().fit.is_some());
}

/// The margin in float64, from the changes as `ACCEPT-8` lists them, with the fit's own light and edges.
fn exact_margin(drawn: &Drawn, fitted: &Fitted) -> f64 {
    let view = View {
        a: fitted.homography.a.to_num(),
        s: fitted.homography.s.to_num(),
        k: fitted.homography.k.to_num(),
        blur: fitted.blur.to_num(),
        ..drawn.view
    };
    let code = usize::from(view.format.code_stripes());
    let camera = Camera::epuck();
    let layers = layers(&drawn.candidate, &drawn.setting(&camera));
    let mut least = f64::INFINITY;
    for (layer, light) in layers.iter().zip(&fitted.lights) {
        let lit = LitLayer::new(layer, view.format, light);
        let (first, last) = (lit.first_pixel(), lit.last_pixel());
        let [o, g, os, gs] =
            [light.offset, light.gain, light.offset_slope, light.gain_slope].map(|x| f64::from(x) / 256.0);
        let squares = |half_word: u16| -> f64 {
            let inks = view.ink(480, half_word);
            (first..=last)
                .map(|pixel| {
                    let lambda = (2.0 * f64::from(pixel) - f64::from(first + last)) / f64::from(last - first);
                    let ink = inks[usize::from(pixel)];
                    let model = o + g * ink + lambda * (os + gs * ink);
                    let value = layer.line[usize::from(pixel)];
                    let counted = match value {
                        255 => model.min(255.0),
                        0 => model.max(0.0),
                        _ => model,
                    };
                    (f64::from(value) - counted).powi(2)
                })
                .sum()
        };
        let half_word = (layer.stripes >> 4 & ((1 << code) - 1)) as u16;
        let before = squares(half_word);
        let colours = &stripes(view.format, half_word)[4..4 + code];
        for start in 0..code {
            for length in 1..=3.min(code - start) {
                if colours[start..start + length].windows(2).all(|pair| pair[0] != pair[1]) {
                    let mask = (start..start + length).fold(0, |mask, stripe| mask | 1 << (code - 1 - stripe));
                    least = least.min(squares(half_word ^ mask) - before);
                }
            }
        }
    }
    least
}

/// A fit that knows what was drawn, whatever the pixels' limits have taken from it.
fn true_fit(drawn: &Drawn) -> Fitted {
    let View { white, gain, blur, .. } = drawn.view;
    let [offset, gain] = [white, gain].map(|grey| (grey * 256.0) as i32);
    let light = LayerLight { offset, gain, ..LayerLight::default() };
    let blur = Column::from_num(blur);
    Fitted { homography: drawn.homography(), blur, lights: [light; 2].into_iter().collect(), ..fitted_with([0; 2]) }
}

/// `TRELLIS-11` in `ACCEPT-8`: white of 300 grey levels is seen as 255, black of -45 as 0. What is left
/// of the contrast, 195 of 240, still decides. The errors of the next test, of 240 grey levels in up to 8 pixels.
//= reference/SPEC.md#trellis
//= type=test
//# - **TRELLIS-11** In TRELLIS-5 and ACCEPT-8 the model of a pixel of the value 255 MUST count as at most 255, and that
//# of one of the value 0 as at least 0, since RENDER-5 limits what is brighter or darker.
#[test]
fn limited_pixels_count_in_the_margin() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for (white, gain) in [(300.0, -240.0), (195.0, -240.0)] {
        for pixels in [1.5, 3.0, 4.0] {
            let drawn = Drawn::new(View { white, gain, ..view(pixels, 20.0) }, 0xBEEF, &mut random);
            let Reading { first_pixel, last_pixel, .. } = drawn.candidate.readings[0];
            let seen = &drawn.lines[0][usize::from(first_pixel)..=usize::from(last_pixel)];
            assert!(seen.iter().filter(|&&value| matches!(value, 0 | 255)).count() >= 2, "{seen:?}");
            let (fitted, camera) = (true_fit(&drawn), Camera::epuck());
            let found =
                f64::from(margin(&layers(&drawn.candidate, &drawn.setting(&camera)), &fitted, &drawn.setting(&camera)))
                    / 256.0;
            let exact = exact_margin(&drawn, &fitted);
            assert!((found - exact).abs() <= 2.0 * 0.1 * 240.0 * 8.0, "{found} {exact} {:?}", drawn.view);
            assert!(Limits::TRELLIS.decide((found * 256.0) as i32, &fitted));
        }
    }
}

/// Each pixel's residual and change are rounded to 2^-7, besides 2^-8 and 2^-15 of 160 grey levels of a product, 2^-9 and
/// 2^-9 of the light and 1.5e-4 of 160 grey levels for the ink of each edge: together below 0.1 grey levels. A change of
/// at most 160 in at most 12 pixels a few of which it fills is off by at most 2 * 0.1 * 160 * 5.
//= reference/SPEC.md#accept
//= type=test
//# - **ACCEPT-8** The decision margin MUST be the least change of the sum of squares over both layers and over the
//# changes of one code stripe, of two neighbours that differ and of three neighbours of which each differs from the
//# next, all other parameters kept and the pixel of a step of light left out.
#[test]
fn the_margin_is_the_least_of_all_changes() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut compared = 0;
    for round in 0..60 {
        let format = if round % 2 == 0 { Format::Paper } else { Format::Wide };
        let payload = random.random::<u32>() >> (32 - format.payload_bits());
        if encode(format, payload).is_err() {
            continue;
        }
        let angle: f64 = random.random_range(-1.0..1.0);
        let view = View::turned(format, [1.2, 1.5, 2.0, 4.0][round % 4], angle).at(random.random_range(-60.0..60.0));
        let drawn = Drawn::new(View { blur: random.random_range(0.3..0.9), ..view }, payload, &mut random);
        let Ok(fitted) = drawn.fitted() else { continue };
        let camera = Camera::epuck();
        let found =
            f64::from(margin(&layers(&drawn.candidate, &drawn.setting(&camera)), &fitted, &drawn.setting(&camera)))
                / 256.0;
        let exact = exact_margin(&drawn, &fitted);
        assert!((found - exact).abs() <= 160.0, "{found} {exact} {:?}", drawn.view);
        compared += 1;
    }
    assert!(compared > 40);
}

/// A camera that hardly moved: nothing is shifted.
const HARDLY: Skew = Skew { play: 4, ..Skew::AT_REST };

impl Drawn {
    /// The same barcode with the lower line of another one.
    fn below(self, lower: Self) -> Self {
        let [upper, _] = self.lines;
        let [_, lower] = lower.lines;
        Self { lines: [upper, lower], ..self }
    }

    /// The decision of a camera that hardly moved, for homographies as the layers were drawn and the lower one moved by so many
    /// pixels.
    fn decided_moving(&self, a: f64, local: bool) -> Result<Detection, CandidateRefusal> {
        let (camera, upper) = (Camera::epuck(), self.homography());
        let layers = [upper, Homography { a: upper.a + Column::from_num(a), ..upper }];
        let evidence = Evidence::Threshold { layers, shift: Shift::NONE, local };
        let setting = Setting { skew: &HARDLY, ..self.setting(&camera) };
        accept(&self.candidate, evidence, &setting, &mut Silent)
    }
}

/// `SKEW-6`: in `ACCEPT-2` the play is added to the limit of `a`, 1 px, and the shift of the upper layer taken off.
#[test]
fn layers_of_a_moving_camera_agree_within_the_play() {
    let drawn = drawn(view(2.0, 0.0));
    let agreed = |a| drawn.decided_moving(a, false) != Err(CandidateRefusal::Disagree);
    assert!(agreed(5.0) && agreed(-5.0) && !agreed(5.001) && !agreed(-5.001));
    let (camera, upper) = (Camera::epuck(), drawn.homography());
    let (one, tenth) = (Column::ONE, Obliquity::from_num(0.1));
    let shift = Shift { a: 10 * one, s: 3 * one, k: -tenth };
    let seen = |shift, a: f64, s: f64, k: Obliquity| {
        let lower = Homography { a: upper.a + Column::from_num(a), s: upper.s + Column::from_num(s), k: upper.k + k };
        let evidence = Evidence::Threshold { layers: [upper, lower], shift, local: false };
        let setting = Setting { skew: &HARDLY, ..drawn.setting(&camera) };
        accept(&drawn.candidate, evidence, &setting, &mut Silent) != Err(CandidateRefusal::Disagree)
    };
    assert!(seen(shift, 10.0, 3.0, -tenth) && seen(shift, 15.0, 4.0, -tenth) && seen(shift, 5.0, 2.0, -tenth));
    assert!(!seen(shift, 15.001, 3.0, -tenth) && !seen(shift, 10.0, 4.001, -tenth));
    assert!(!seen(Shift::NONE, 10.0, 3.0, -tenth) && !seen(shift, 10.0, 3.0, tenth));
}

/// `SKEW-7`: each layer from its own homography; `SKEW-8`: the detection is the upper one's. 8 px apart no fit of both would be.
#[test]
fn each_layer_of_a_moving_camera_is_fitted_alone() {
    let (upper, lower) = (drawn(view(4.0, 20.0)), drawn(view(4.0, 20.0).at(4.0)));
    let mut both = upper.below(lower);
    for (reading, pixels) in both.candidate.readings.iter_mut().zip([0, 4]) {
        (reading.first_pixel, reading.last_pixel) = (reading.first_pixel + pixels, reading.last_pixel + pixels);
    }
    let found = both.decided_moving(4.0, false).unwrap();
    let (fit, lower) = (found.fit.unwrap(), found.lower_fit.unwrap());
    let off = |found: Column, a: f64| (found.to_num::<f64>() - both.view.a - a).abs();
    assert!(off(found.homography.a, 0.0) < 0.1 && off(lower.homography.a, 4.0) < 0.1);
    let camera = Camera::epuck();
    let located = covariance::transform(&found.homography, &fit.covariance, &camera, &both.landmark);
    assert_eq!(located, Ok((found.camera_in_landmark, found.covariance)));
    // `SKEW-8`: the upper layer's `a`.
    assert_eq!(found.transitions.map(|merged| merged.a), Some(both.homography().a));
    // At rest they are fitted together, and refused.
    assert!(both.accepted().is_err());
}

/// `SKEW-7`: what is asked of a fit is asked of each, the upper one first.
//= reference/SPEC.md#skew
//= type=test
//# - **SKEW-7** The layers of a moving camera MUST each be fitted alone from their own homography as ACCEPT-1 says, the
//# fit of each be asked ACCEPT-3 to ACCEPT-9 and ACCEPT-12 to ACCEPT-17 alone, the upper one first, and both together
//# ACCEPT-4's ratio of the gains before that; where either has no fit, ACCEPT-10 decides.
#[test]
fn each_layer_of_a_moving_camera_is_asked() {
    let good = || drawn(view(4.0, 0.0));
    let wave = |amplitude| waved(view(4.0, 0.0), amplitude);
    let blurred = || drawn(View { blur: 1.05, noise: 1.0, ..view(4.0, 0.0) });
    let decided = |upper: Drawn, lower: Drawn| upper.below(lower).decided_moving(0.0, false).map(|_| ());
    assert_eq!(decided(good(), good()), Ok(()));
    assert_eq!(decided(good(), blurred()), Err(CandidateRefusal::Blur));
    assert_eq!(decided(blurred(), good()), Err(CandidateRefusal::Blur));
    assert_eq!(decided(good(), wave(30.0)), Err(CandidateRefusal::Misfit));
    assert_eq!(decided(good(), wave(10.0)), Err(CandidateRefusal::Correlated));
    assert_eq!(decided(wave(10.0), good()), Err(CandidateRefusal::Correlated));
    // The blur would come before the correlation in one layer.
    assert_eq!(decided(wave(10.0), blurred()), Err(CandidateRefusal::Correlated));
    let mut beside = good();
    beside.lines[1][286..290].fill(40);
    assert_eq!(beside.decided_moving(0.0, false).map(|_| ()), Err(CandidateRefusal::QuietZone));
    // Either has contrast enough, but one more than twice that of the other, which is asked before the blur.
    let gain = |gain, blur| drawn(View { gain, blur, noise: 1.0, ..view(4.0, 0.0) });
    assert_eq!(decided(gain(-150.0, 0.5), gain(-80.0, 0.5)), Ok(()));
    assert_eq!(decided(gain(-150.0, 1.05), gain(-70.0, 0.5)), Err(CandidateRefusal::Contrast));
    assert_eq!(decided(gain(-70.0, 0.5), gain(-150.0, 1.05)), Err(CandidateRefusal::Contrast));
    assert_eq!(decided(gain(-11.0, 0.5), gain(-13.0, 0.5)), Err(CandidateRefusal::Contrast));
}

/// `SKEW-7`: where one of the layers has no fit, `ACCEPT-10` decides.
#[test]
fn a_moving_layer_without_a_fit_leaves_the_paper_s_estimate() {
    for layer in 0..2 {
        let mut limited = drawn(view(4.0, 0.0));
        for pixel in &mut limited.lines[layer] {
            *pixel = if *pixel > 100 { 255 } else { 0 };
        }
        let found = limited.decided_moving(3.0, false).unwrap();
        assert_eq!((found.estimator(), found.lower_fit), (crate::merge::Estimator::Paper, None));
        // The upper layer's `a`, of which the lower one's is 3 px away.
        assert_eq!((found.homography, found.transitions), (limited.homography(), Some(limited.homography())));
        assert_eq!(limited.decided_moving(3.0, true), Err(CandidateRefusal::NoFit));
    }
}

/// `SKEW-8`: the upper layer's `a`, the mean of `s` and `k`, the lower layer's less the shift.
//= reference/SPEC.md#skew
//= type=test
//# - **SKEW-8** What a detection of a moving camera says MUST be what is seen at the upper row's time: by the upper
//# layer's fit, or without a fit by MERGE-4's mean of `s` and `k`, the lower layer's less the shift, and the upper
//# layer's `a`.
#[test]
fn the_merged_homography_of_a_moving_camera_is_seen_from_the_upper_row() {
    let mut limited = drawn(view(4.0, 0.0));
    limited.lines.iter_mut().flatten().for_each(|pixel| *pixel = if *pixel > 100 { 255 } else { 0 });
    let (camera, upper) = (Camera::epuck(), limited.homography());
    let [a, s] = [12, 4].map(Column::from_num);
    let lower = Homography { a: upper.a + a, s: upper.s + s, k: upper.k + Obliquity::from_num(0.125) };
    let shift = Shift { a: Column::from_num(10), s: Column::from_num(3), k: Obliquity::from_num(0.0625) };
    let evidence = Evidence::Threshold { layers: [upper, lower], shift, local: false };
    let setting = Setting { skew: &HARDLY, ..limited.setting(&camera) };
    let found = accept(&limited.candidate, evidence, &setting, &mut Silent).unwrap();
    let half_off = Homography { s: upper.s + Column::ONE / 2, k: upper.k + Obliquity::from_num(0.03125), ..upper };
    assert_eq!((found.homography, found.transitions), (half_off, Some(half_off)));
}
