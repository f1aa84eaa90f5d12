//! What a candidate must be like to be a detection (ACCEPT).

use crate::camera::Camera;
use crate::covariance::{UncertainPose, paper, transform};
use crate::crossing::CrossingRule;
use crate::decode::DecodedLayer;
use crate::fit::{FitLayer, Fitted, Illumination, Imaging, START_BLUR, Window, difference, fit, inks, mean_gain};
use crate::homography::Homography;
use crate::landmark::{Format, GUARD_PAIRS, Landmark, stripes};
use crate::merge::Decoder;
use crate::observer::Observer;
use crate::pose::pose;
use crate::quiet_zone::obstruction;
use crate::refusal::CandidateRefusal;
use crate::skew::{Ends, Skew};
use crate::threshold::Thresholding;
use crate::trellis::weights;
use crate::whiteness::correlations;
use nalgebra::Matrix3;

/// Largest `f |k|/s`, the tangent of the inclination (ACCEPT-3).
pub const MAX_TANGENT: f64 = 3.0;

/// Smallest contrast, grey levels (ACCEPT-4).
pub const MIN_CONTRAST: f64 = 12.0;

/// Largest ratio of the gains of both layers (ACCEPT-4).
pub const MAX_GAIN_RATIO: f64 = 2.0;

/// Standard deviation of a pixel about its model that is always allowed, grey levels (ACCEPT-6).
pub const ALLOWED_NOISE: f64 = 3.0;

/// How far below 0 the grey level of black may be, by the contrast (ACCEPT-14).
pub const BELOW_BLACK: f64 = 1.0 / 8.0;

/// Largest mean product of residuals one or two pixels apart, by what ACCEPT-6 allows for their squares (ACCEPT-15).
pub const MAX_CORRELATION: f64 = 1.0 / 6.0;

/// What is asked of a fit, by the decoder that led to it: TRELLIS finds a word in anything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest blur, pixels (ACCEPT-5).
    pub blur: f64,
    /// Standard deviation of a pixel about its model, besides [`ALLOWED_NOISE`], by the contrast (ACCEPT-6).
    pub share: f64,
    /// Smallest decision margin by the squared contrast (ACCEPT-7).
    pub margin: f64,
}

impl Limits {
    /// Those of a decoder.
    #[must_use]
    pub fn of(decoder: Decoder) -> Self {
        match decoder {
            Decoder::Threshold => Self { blur: 1.0, share: 1.0 / 16.0, margin: 1.0 / 8.0 },
            Decoder::Trellis => Self { blur: 0.9, share: 1.0 / 32.0, margin: 1.0 / 4.0 },
        }
    }

    /// `v`, what ACCEPT-6 allows for the fit's mean gain, squared grey levels.
    //= reference/SPEC.md#accept
    //# - **ACCEPT-6** The noise MUST be explained, `s² <= v` with `v = (ḡ/16)² + 9`, and `v = (ḡ/32)² + 9` for TRELLIS
    //# (`Misfit`).
    #[must_use]
    pub fn variance(&self, fitted: &Fitted) -> f64 {
        let share = self.share * mean_gain(&fitted.lights);
        share * share + ALLOWED_NOISE * ALLOWED_NOISE
    }

    /// ACCEPT-6
    fn explain(&self, fitted: &Fitted) -> bool {
        fitted.variance <= self.variance(fitted)
    }
}

/// What ACCEPT asks of a quantity: that it is at most its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Test {
    /// Why a candidate is refused that fails it.
    pub refusal: CandidateRefusal,
    /// The quantity, at least 0.
    pub value: f64,
    /// Its limit.
    pub limit: f64,
}

impl Test {
    pub(crate) fn holds(&self) -> bool {
        self.value <= self.limit
    }

    /// How far the quantity is below its limit, as a share of the larger of both; negative if the test fails.
    #[must_use]
    pub fn slack(&self) -> f64 {
        (self.limit - self.value) / self.limit.abs().max(self.value.abs()).max(f64::MIN_POSITIVE)
    }
}

/// The refusal of the first test that fails (ACCEPT-9).
fn first_failure<O: Observer>(tests: &[Test], observer: &mut O) -> Result<(), CandidateRefusal> {
    observer.tested(tests);
    tests.iter().find(|test| !test.holds()).map_or(Ok(()), |test| Err(test.refusal))
}

/// A fit that explains the pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct AcceptedFit {
    /// The fit.
    pub fitted: Fitted,
    /// The decision margin, squared grey levels (ACCEPT-8).
    pub margin: f64,
}

/// What is known about an accepted candidate.
#[derive(Clone, Debug, PartialEq)]
pub struct Accepted {
    /// The fitted homography, or the merged one (ACCEPT-10).
    pub homography: Homography,
    /// The fit, `None` for the paper's estimate.
    pub fit: Option<AcceptedFit>,
    /// The lower layer's own fit where the camera moved; the other one is the upper layer's then (SKEW-7).
    pub lower: Option<Fitted>,
    /// The merged homography of the transitions (MERGE-4), `None` where no threshold decoded them.
    pub transitions: Option<Homography>,
    /// The pose and its covariance.
    pub pose: UncertainPose,
}

/// The two scan lines and who looks at them.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Scan lines, upper first.
    pub lines: [&'a [u8]; 2],
    /// The camera.
    pub camera: &'a Camera,
    /// The landmark that is looked for.
    pub landmark: &'a Landmark,
    /// Where transitions lie.
    pub rule: CrossingRule,
    /// How the camera moved from the upper line to the lower one.
    pub skew: Skew,
}

impl View<'_> {
    /// What the lower line's `(a, s, k)` are more than these (SKEW-2); `None` where SKEW-3 pairs nothing.
    #[must_use]
    pub fn shift(&self, homography: &Homography) -> Option<Homography> {
        self.skew.shift(homography, self.camera, self.landmark)
    }

    /// How far the lower line's ends of a barcode are from the upper one's (SKEW-4); `None` where SKEW-3 pairs nothing.
    #[must_use]
    pub fn ends(&self, homography: &Homography) -> Option<Ends> {
        self.shift(homography).map(|shift| Ends::of(homography, &homography.plus(&shift)))
    }
}

/// Decides on two decoded layers that make a code word (ACCEPT-1 to ACCEPT-12, SKEW-6 to SKEW-8).
//= reference/SPEC.md#accept
//# - **ACCEPT-11** A pair of extents of which a fit is refused MUST be refused (`NoFit`).
pub fn accept<O: Observer>(
    layers: [&DecodedLayer; 2],
    view: &View<'_>,
    observer: &mut O,
) -> Result<Accepted, CandidateRefusal> {
    let [upper, lower] = layers.map(|layer| layer.homography);
    // Paired layers are carried (SKEW-3).
    let lower = lower.minus(&view.shift(&upper).unwrap_or(Homography::NONE));
    let merged = view.skew.merged(&upper, &lower);
    let play = f64::from(view.skew.play());
    first_failure(&agreement(&upper, &lower, &merged, pixels_apart(layers, view.rule), play), observer)?;
    let colours = layers.map(|layer| stripes(view.landmark.format, layer.half_word));
    let fitted_layers = [0, 1].map(|i| FitLayer {
        line: view.lines[i],
        first_pixel: layers[i].hypothesis.first_pixel,
        last_pixel: layers[i].hypothesis.last_pixel,
        stripes: &colours[i],
    });
    let accepted = if view.skew.moves() {
        moving_fits(&fitted_layers, layers, view, observer)
            .map(|fits| accept_moving(&fitted_layers, fits, view, observer))
    } else {
        best_fit(&fitted_layers, &merged, view, observer)
            .map(|fitted| accept_fit(&fitted_layers, fitted, Decoder::Threshold, view, observer))
    };
    match accepted {
        Some(accepted) => accepted.map(|accepted| Accepted { transitions: Some(merged), ..accepted }),
        None if is_local(layers) => Err(CandidateRefusal::NoFit),
        None => first_failure(&[visibility(&merged, view.camera)], observer).map(|()| unfitted(&merged, view)),
    }
}

/// Whether the local threshold found at least one of the layers.
fn is_local(layers: [&DecodedLayer; 2]) -> bool {
    layers.iter().any(|layer| layer.thresholding == Thresholding::Local)
}

/// How far two layers may be apart (ACCEPT-2), pixels.
fn pixels_apart(layers: [&DecodedLayer; 2], rule: CrossingRule) -> f64 {
    let whole = rule == CrossingRule::WholePixel;
    [whole, is_local(layers)].iter().fold(1.0, |pixels, &more| if more { pixels + 1.0 } else { pixels })
}

/// ACCEPT-2, with the play of a moving camera (SKEW-6).
//= reference/SPEC.md#accept
//# - **ACCEPT-2** Of a candidate of the threshold, both layers' homographies MUST agree within 1 px in `a` and in `s`
//# and within `1/20 + 1/s` in `k`, to which the whole-pixel rule adds 1 px, 1 px and 1/s, and a layer of the local
//# threshold as much (`Disagree`).
fn agreement(upper: &Homography, lower: &Homography, merged: &Homography, pixels: f64, play: f64) -> [Test; 3] {
    let test = |value: f64, limit| Test { refusal: CandidateRefusal::Disagree, value: value.abs(), limit };
    [
        test(upper.a - lower.a, pixels + play),
        test(upper.s - lower.s, pixels),
        test((upper.k - lower.k) * merged.s, merged.s / 20.0 + pixels),
    ]
}

/// The fit under even light, or under a step of light if that does not explain the pixels (ACCEPT-1).
//= reference/SPEC.md#accept
//# - **ACCEPT-1** A candidate of the threshold MUST be fitted (FIT) from its merged homography, under even light, and
//# if that is refused or ACCEPT-6 would refuse it, under a step of light.
fn best_fit<O: Observer>(
    layers: &[FitLayer<'_>],
    start: &Homography,
    view: &View<'_>,
    observer: &mut O,
) -> Option<Fitted> {
    let start = Imaging { homography: *start, blur: START_BLUR };
    let mut under = |illumination: Illumination| {
        let fitted = fit(layers, &start, illumination, view.camera, view.landmark.format);
        observer.fitted(fitted.as_ref().map_err(|refusal| *refusal));
        fitted.ok()
    };
    let even = under(Illumination::Even);
    let explain = |fitted: &Fitted| Limits::of(Decoder::Threshold).explain(fitted);
    if even.as_ref().is_some_and(explain) { even } else { under(Illumination::Step).or(even) }
}

/// ACCEPT-3
//= reference/SPEC.md#accept
//# - **ACCEPT-3** The obliquity MUST be one that a camera can see, `f |k| <= 3 s` (`Oblique`).
fn visibility(homography: &Homography, camera: &Camera) -> Test {
    let (value, limit) = (camera.focal_length * homography.k.abs(), MAX_TANGENT * homography.s);
    Test { refusal: CandidateRefusal::Oblique, value, limit }
}

/// ACCEPT-4
//= reference/SPEC.md#accept
//# - **ACCEPT-4** Both gains MUST be at most -12 grey levels, and neither more than twice the other (`Contrast`).
fn contrast(fitted: &Fitted) -> [Test; 2] {
    let least = fitted.lights.iter().map(|light| -light.gain).fold(f64::INFINITY, f64::min);
    let most = fitted.lights.iter().map(|light| -light.gain).fold(f64::NEG_INFINITY, f64::max);
    let test = |value, limit| Test { refusal: CandidateRefusal::Contrast, value, limit };
    [test(MIN_CONTRAST, least), test(most, MAX_GAIN_RATIO * least)]
}

/// ACCEPT-14: black is `o + g`.
//= reference/SPEC.md#accept
//# - **ACCEPT-14** Under even light `8 (o + g)` MUST be at least `ḡ` in both layers (`Contrast`).
fn blackness(fitted: &Fitted) -> Vec<Test> {
    let below = -BELOW_BLACK * mean_gain(&fitted.lights);
    let even = fitted.lights.iter().filter(|light| light.step.is_none());
    let test = |value, limit| Test { refusal: CandidateRefusal::Contrast, value, limit };
    even.map(|light| test(-light.gain, light.offset + below)).collect()
}

/// By how much the model of a limited pixel is within 0 to 255 at the most, grey levels (ACCEPT-13).
//= reference/SPEC.md#accept
//# - **ACCEPT-13** The model of a pixel of the value 255 that FIT-5 left out of a window MUST be at least `255 - 2
//# sqrt(v)`, and that of one of the value 0 at most `2 sqrt(v)`, but for the pixel of a step of light (`Misfit`).
fn limited_excess(layers: &[FitLayer<'_>], fitted: &Fitted, view: &View<'_>) -> f64 {
    let format = view.landmark.format;
    let excesses = layers.iter().zip(&fitted.lights).flat_map(|(layer, light)| {
        let window = Window::of(layer.first_pixel, layer.last_pixel, format, layer.line.len());
        let inks = inks(&fitted.imaging, view.camera, format, layer.stripes, (window.first, window.last));
        (window.first..).zip(inks).filter(|&(pixel, _)| light.step != Some(pixel)).map(move |(pixel, ink)| {
            let model = light.model_at(&window, pixel, ink.ink);
            match layer.line[pixel] {
                255 => 255.0 - model,
                0 => model,
                _ => 0.0,
            }
        })
    });
    excesses.fold(0.0, f64::max)
}

/// Decides on a fit (ACCEPT-3 to ACCEPT-9, ACCEPT-12 to ACCEPT-17).
pub fn accept_fit<O: Observer>(
    layers: &[FitLayer<'_>; 2],
    fitted: Fitted,
    decoder: Decoder,
    view: &View<'_>,
    observer: &mut O,
) -> Result<Accepted, CandidateRefusal> {
    let margin = asked(layers, &fitted, decoder, view, observer)?;
    let homography = fitted.imaging.homography;
    let pose = transform(&homography, &fitted.covariance, view.camera, view.landmark);
    Ok(Accepted { homography, fit: Some(AcceptedFit { fitted, margin }), lower: None, transitions: None, pose })
}

/// The fits of both layers of a moving camera, each alone (SKEW-7).
//= reference/SPEC.md#skew
//# - **SKEW-7** The layers of a moving camera MUST each be fitted alone from their own homography as ACCEPT-1 says, the
//# fit of each be asked ACCEPT-3 to ACCEPT-9 and ACCEPT-12 to ACCEPT-17 alone, the upper one first, and both together
//# ACCEPT-4's ratio of the gains before that; where either has no fit, ACCEPT-10 decides.
fn moving_fits<O: Observer>(
    layers: &[FitLayer<'_>; 2],
    decoded: [&DecodedLayer; 2],
    view: &View<'_>,
    observer: &mut O,
) -> Option<[Fitted; 2]> {
    let [upper, lower] = [0, 1].map(|i| best_fit(&layers[i..=i], &decoded[i].homography, view, observer));
    Some([upper?, lower?])
}

/// Decides on the fits of both layers of a moving camera (SKEW-7, SKEW-8).
//= reference/SPEC.md#skew
//# - **SKEW-8** What a detection of a moving camera says MUST be what is seen at the upper row's time: by the upper
//# layer's fit, or without a fit by MERGE-4's mean of `s` and `k`, the lower layer's less the shift, and the upper
//# layer's `a`.
fn accept_moving<O: Observer>(
    layers: &[FitLayer<'_>; 2],
    [upper, lower]: [Fitted; 2],
    view: &View<'_>,
    observer: &mut O,
) -> Result<Accepted, CandidateRefusal> {
    let gains = [&upper, &lower].map(|fitted| -mean_gain(&fitted.lights));
    let (least, most) = (gains[0].min(gains[1]), gains[0].max(gains[1]));
    let ratio = Test { refusal: CandidateRefusal::Contrast, value: most, limit: MAX_GAIN_RATIO * least };
    first_failure(&[ratio], observer)?;
    let above = asked(&layers[..1], &upper, Decoder::Threshold, view, observer)?;
    let below = asked(&layers[1..], &lower, Decoder::Threshold, view, observer)?;
    let homography = upper.imaging.homography;
    let pose = transform(&homography, &upper.covariance, view.camera, view.landmark);
    let fit = AcceptedFit { fitted: upper, margin: above.min(below) };
    Ok(Accepted { homography, fit: Some(fit), lower: Some(lower), transitions: None, pose })
}

/// The decision margin of a fit that passes all tests (ACCEPT-3 to ACCEPT-9, ACCEPT-12 to ACCEPT-17).
//= reference/SPEC.md#accept
//# - **ACCEPT-5** The blur MUST be at most 1 px, and 0.9 px for TRELLIS (`Blur`).
//= reference/SPEC.md#accept
//# - **ACCEPT-7** The decision margin MUST be at least `ḡ²/8`, and `ḡ²/4` for TRELLIS (`Margin`).
//= reference/SPEC.md#accept
//# - **ACCEPT-15** What a barcode leaves unexplained MUST look like noise: of the `n` pixels that were fitted, less
//# their model, the products of neighbours and those of pixels with one pixel between them, each summed over both
//# layers, come to at most `n v/6` (`Correlated`).
//= reference/SPEC.md#accept
//# - **ACCEPT-9** ACCEPT-2 to ACCEPT-4, ACCEPT-14, ACCEPT-5, ACCEPT-6, ACCEPT-13, ACCEPT-15, ACCEPT-16 and ACCEPT-7
//# MUST be asked in this order, and the first that fails be reported.
fn asked<O: Observer>(
    layers: &[FitLayer<'_>],
    fitted: &Fitted,
    decoder: Decoder,
    view: &View<'_>,
    observer: &mut O,
) -> Result<f64, CandidateRefusal> {
    let limits = Limits::of(decoder);
    let format = view.landmark.format;
    let margin = margin(layers, fitted, view.camera, format);
    let correlation = correlations(layers, fitted, view.camera, format).largest();
    let obstruction = obstruction(layers, fitted, view.camera, format);
    let homography = fitted.imaging.homography;
    let gain = mean_gain(&fitted.lights);
    let variance = limits.variance(fitted);
    let test = |refusal, value, limit| Test { refusal, value, limit };
    let mut tests = vec![visibility(&homography, view.camera)];
    tests.extend(contrast(fitted));
    tests.extend(blackness(fitted));
    tests.extend([
        test(CandidateRefusal::Blur, fitted.imaging.blur, limits.blur),
        test(CandidateRefusal::Misfit, fitted.variance, variance),
        test(CandidateRefusal::Misfit, limited_excess(layers, fitted, view), 2.0 * variance.sqrt()),
        test(CandidateRefusal::Correlated, correlation, MAX_CORRELATION * variance),
        test(CandidateRefusal::QuietZone, obstruction, gain.abs() / 2.0),
        test(CandidateRefusal::Margin, limits.margin * gain * gain, margin),
        determination(&homography, &fitted.covariance, view.camera),
    ]);
    first_failure(&tests, observer).map(|()| margin)
}

/// Whether a Gaussian can say how uncertain the heading is (COV-4).
//= reference/SPEC.md#accept
//# - **ACCEPT-12** A candidate MUST be refused (`Undetermined`) by COV-4 last.
//= reference/SPEC.md#cov
//# - **COV-4** The pose and the covariance that a detection reports MUST be these, and a fit count as undetermined if
//# `f sqrt(Σ_kk) > s/4`, where the heading is so uncertain that no Gaussian can say it.
pub(crate) fn determination(homography: &Homography, covariance: &Matrix3<f64>, camera: &Camera) -> Test {
    let value = camera.focal_length * covariance[(2, 2)].sqrt();
    Test { refusal: CandidateRefusal::Undetermined, value, limit: homography.s / 4.0 }
}

/// The paper's estimate (ACCEPT-10).
//= reference/SPEC.md#accept
//# - **ACCEPT-10** A candidate of the threshold whose fits both are refused MUST be accepted by ACCEPT-2 and ACCEPT-3
//# alone, on its merged homography, with the paper's estimate and covariance (COV-5), and say so, if the global
//# threshold found both layers, and otherwise be refused (`NoFit`).
fn unfitted(merged: &Homography, view: &View<'_>) -> Accepted {
    let camera_in_landmark = pose(merged, view.camera, view.landmark);
    let covariance = paper(&camera_in_landmark, view.camera);
    let pose = UncertainPose { camera_in_landmark, covariance };
    Accepted { homography: *merged, fit: None, lower: None, transitions: Some(*merged), pose }
}

/// The decision margin of a fit, squared grey levels (ACCEPT-8).
//= reference/SPEC.md#accept
//# - **ACCEPT-8** The decision margin MUST be the least change of the sum of squares over both layers and over the
//# changes of one code stripe, of two neighbours that differ and of three neighbours of which each differs from the
//# next, all other parameters kept and the pixel of a step of light left out.
#[must_use]
pub fn margin(layers: &[FitLayer<'_>], fitted: &Fitted, camera: &Camera, format: Format) -> f64 {
    let mut least = f64::INFINITY;
    for (layer, light) in layers.iter().zip(&fitted.lights) {
        let window = Window::of(layer.first_pixel, layer.last_pixel, format, layer.line.len());
        let pixels = (window.first, window.last);
        let weights = weights(&fitted.imaging, camera, format, pixels);
        let inks = inks(&fitted.imaging, camera, format, layer.stripes, pixels);
        // Of each pixel that counts: its place, its value, its gain and its model.
        let modelled: Vec<(usize, u8, f64, f64)> = (window.first..)
            .zip(&inks)
            .filter(|&(pixel, _)| light.step != Some(pixel))
            .map(|(pixel, ink)| {
                let gain = light.gain_at(&window, pixel);
                (pixel - window.first, layer.line[pixel], gain, light.white_at(&window, pixel) + gain * ink.ink)
            })
            .collect();
        for changed in alternating(layer.stripes, format) {
            let change = |i: usize| {
                let turn = |j: usize| if layer.stripes[j] { -weights[j][i] } else { weights[j][i] };
                changed.clone().map(turn).sum::<f64>()
            };
            let grows = modelled.iter().map(|&(i, value, gain, model)| {
                let (now, then) = (difference(value, model), difference(value, model + gain * change(i)));
                then * then - now * now
            });
            least = least.min(grows.sum());
        }
    }
    least
}

/// Runs of one to three code stripes of which each differs from the next.
fn alternating(stripes: &[bool], format: Format) -> Vec<core::ops::Range<usize>> {
    let guard = 2 * GUARD_PAIRS;
    let code = guard..guard + format.code_stripes();
    let starts = code.clone().flat_map(|first| (1..=3).map(move |length| first..first + length));
    starts.filter(|run| run.end <= code.end && stripes[run.clone()].windows(2).all(|pair| pair[0] != pair[1])).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::codeword;
    use crate::detect::detect;
    use crate::frame::Pose;
    use crate::hypotheses::Hypothesis;
    use crate::merge::Detection;
    use crate::observer::Silent;
    use crate::render::{Light, Posted, Scene, Sensor, render};
    use core::f64::consts::{FRAC_1_SQRT_2, PI};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const PAYLOAD: u32 = 0xcc0d;

    #[expect(clippy::cast_possible_truncation, reason = "a few grey levels")]
    fn rounded(levels: f64) -> i8 {
        levels.round() as i8
    }

    fn lines(pose: (f64, f64, f64)) -> [Vec<u8>; 2] {
        let landmark = Landmark::new(Format::Paper);
        let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload: PAYLOAD };
        let camera_in_world = Pose::new(pose.0, pose.1, pose.2);
        let (light, sensor) = (Light::default(), Sensor::default());
        let scene = Scene { camera_in_world, landmarks: vec![posted], clutter: vec![], light, sensor };
        render(&Camera::epuck(), &scene, &mut ChaCha8Rng::seed_from_u64(3)).unwrap()
    }

    fn found(lines: &[Vec<u8>; 2]) -> Detection {
        let landmarks = [Landmark::new(Format::Paper)];
        let rule = CrossingRule::Interpolated;
        detect(&lines[0], &lines[1], &Camera::epuck(), &landmarks, rule, &mut Silent).remove(0)
    }

    /// A landmark that was found, and its fit.
    pub(crate) struct Found {
        pub(crate) lines: [Vec<u8>; 2],
        pub(crate) colours: [Vec<bool>; 2],
        pub(crate) pixels: [(usize, usize); 2],
        pub(crate) fitted: Fitted,
    }

    impl Found {
        /// A landmark at 30 cm, stripes of 3.2 px.
        pub(crate) fn at_30_cm() -> Self {
            let lines = lines((0.3, 0.0, PI));
            let detection = found(&lines);
            let colours = codeword::layers(Format::Paper, PAYLOAD).unwrap();
            let pixels = [detection.upper, detection.lower].map(|layer| (layer.first_pixel, layer.last_pixel));
            Self { lines, colours, pixels, fitted: detection.fit.unwrap().fitted }
        }

        pub(crate) fn layers(&self) -> [FitLayer<'_>; 2] {
            [0, 1].map(|i| FitLayer {
                line: &self.lines[i],
                first_pixel: self.pixels[i].0,
                last_pixel: self.pixels[i].1,
                stripes: &self.colours[i],
            })
        }
    }

    /// A landmark at 30 cm, and what `change` makes of its lines, stripes and fit.
    fn judged(
        decoder: Decoder,
        change: impl FnOnce(&mut [Vec<u8>; 2], &mut [Vec<bool>; 2], &mut Fitted),
    ) -> Result<(), CandidateRefusal> {
        let mut seen = Found::at_30_cm();
        change(&mut seen.lines, &mut seen.colours, &mut seen.fitted);
        let (camera, landmark) = (&Camera::epuck(), &Landmark::new(Format::Paper));
        let lines = [&seen.lines[0][..], &seen.lines[1][..]];
        let view = View { lines, camera, landmark, rule: CrossingRule::Interpolated, skew: Skew::at_rest() };
        accept_fit(&seen.layers(), seen.fitted.clone(), decoder, &view, &mut Silent).map(|_| ())
    }

    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-3** The obliquity MUST be one that a camera can see, `f |k| <= 3 s` (`Oblique`).
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-4** Both gains MUST be at most -12 grey levels, and neither more than twice the other (`Contrast`).
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-5** The blur MUST be at most 1 px, and 0.9 px for TRELLIS (`Blur`).
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-6** The noise MUST be explained, `s² <= v` with `v = (ḡ/16)² + 9`, and `v = (ḡ/32)² + 9` for TRELLIS
    //# (`Misfit`).
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-14** Under even light `8 (o + g)` MUST be at least `ḡ` in both layers (`Contrast`).
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-15** What a barcode leaves unexplained MUST look like noise: of the `n` pixels that were fitted, less
    //# their model, the products of neighbours and those of pixels with one pixel between them, each summed over both
    //# layers, come to at most `n v/6` (`Correlated`).
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-12** A candidate MUST be refused (`Undetermined`) by COV-4 last.
    //= reference/SPEC.md#cov
    //= type=test
    //# - **COV-4** The pose and the covariance that a detection reports MUST be these, and a fit count as undetermined
    //# if `f sqrt(Σ_kk) > s/4`, where the heading is so uncertain that no Gaussian can say it.
    #[test]
    fn each_limit_refuses_by_its_name() {
        use CandidateRefusal as Why;
        use Decoder::{Threshold, Trellis};
        assert_eq!(judged(Threshold, |_, _, _| ()), Ok(()));
        assert_eq!(judged(Trellis, |_, _, _| ()), Ok(()));
        let oblique = |k: f64| {
            judged(Threshold, |_, _, fitted| {
                let h = &mut fitted.imaging.homography;
                h.k = k * h.s / 640.0;
            })
        };
        assert_eq!(oblique(3.01), Err(Why::Oblique));
        assert_ne!(oblique(2.99), Err(Why::Oblique));
        let gains = |upper, lower| {
            judged(Threshold, |_, _, fitted| {
                (fitted.lights[0].gain, fitted.lights[1].gain) = (upper, lower);
            })
        };
        assert_eq!(gains(-11.9, -20.0), Err(Why::Contrast));
        assert_eq!(gains(-70.0, -150.0), Err(Why::Contrast));
        assert_ne!(gains(-80.0, -150.0), Err(Why::Contrast));
        let blurred = |decoder, blur| judged(decoder, |_, _, fitted| fitted.imaging.blur = blur);
        assert_eq!(blurred(Threshold, 1.01), Err(Why::Blur));
        assert_ne!(blurred(Threshold, 0.99), Err(Why::Blur));
        assert_eq!(blurred(Trellis, 0.91), Err(Why::Blur));
        // (160/16)² + 9 and (160/32)² + 9, about.
        let noisy = |decoder, variance| judged(decoder, |_, _, fitted| fitted.variance = variance);
        assert_eq!((noisy(Threshold, 100.0), noisy(Threshold, 115.0)), (Ok(()), Err(Why::Misfit)));
        assert_eq!((noisy(Trellis, 32.0), noisy(Trellis, 36.0)), (Ok(()), Err(Why::Misfit)));
        // White is about 200 and black 40: a gain of -229 makes black 29 darker than nothing, one of -228 28, an eighth of it.
        let black = |gain: f64| {
            judged(Threshold, |_, _, fitted| {
                for light in &mut fitted.lights {
                    (light.offset, light.gain) = (200.0, gain);
                }
            })
        };
        assert_eq!(black(-229.0), Err(Why::Contrast));
        assert_ne!(black(-228.0), Err(Why::Contrast));
        // A wave of 10 grey levels and a period of 8 px is 50 squared ones, and 35 from pixel to pixel.
        let wave = |height: f64| {
            judged(Threshold, |lines, _, _| {
                for (i, value) in lines.iter_mut().flat_map(|line| line.iter_mut().enumerate()) {
                    let turn = [0.0, FRAC_1_SQRT_2, 1.0, FRAC_1_SQRT_2][i % 4] * height;
                    let wave = if i % 8 < 4 { turn } else { -turn };
                    *value = value.saturating_add_signed(rounded(wave));
                }
            })
        };
        assert_eq!((wave(2.0), wave(10.0)), (Ok(()), Err(Why::Correlated)));
        let barred = judged(Threshold, |lines, _, _| lines[1][276..279].fill(40));
        assert_eq!(barred, Err(Why::QuietZone));
        // s is 32 px: a heading known to a quarter of a radian has a k known to 1/80.
        let uncertain =
            |deviation: f64| judged(Threshold, |_, _, fitted| fitted.covariance[(2, 2)] = deviation * deviation);
        assert_eq!((uncertain(0.0120), uncertain(0.0130)), (Ok(()), Err(Why::Undetermined)));
    }

    /// ACCEPT-9: of two reasons the first. What is wrong comes from the end of the list to its beginning.
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-9** ACCEPT-2 to ACCEPT-4, ACCEPT-14, ACCEPT-5, ACCEPT-6, ACCEPT-13, ACCEPT-15, ACCEPT-16 and ACCEPT-7
    //# MUST be asked in this order, and the first that fails be reported.
    #[test]
    fn the_first_reason_is_reported() {
        use CandidateRefusal as Why;
        type Wrong = fn(&mut [Vec<u8>; 2], &mut Fitted);
        let wrongs: [(Why, Wrong); 8] = [
            (Why::Undetermined, |_, fitted| fitted.covariance[(2, 2)] = 1.0),
            (Why::QuietZone, |lines, _| lines[1][276..279].fill(40)),
            // A wave of a period of 8 px, as in the test above.
            (Why::Correlated, |lines, _| {
                for (i, value) in lines.iter_mut().flat_map(|line| line.iter_mut().enumerate()) {
                    let height = [0, 7, 10, 7][i % 4];
                    *value = value.saturating_add_signed(if i % 8 < 4 { height } else { -height });
                }
            }),
            // A black pixel that is said to be limited to white.
            (Why::Misfit, |lines, _| {
                let (pixel, _) = lines[0].iter().enumerate().min_by_key(|(_, grey)| **grey).unwrap();
                lines[0][pixel] = 255;
            }),
            (Why::Misfit, |_, fitted| fitted.variance = 1e4),
            (Why::Blur, |_, fitted| fitted.imaging.blur = 1.1),
            (Why::Contrast, |_, fitted| fitted.lights[0].gain = -11.0),
            (Why::Oblique, |_, fitted| fitted.imaging.homography.k = 0.4),
        ];
        for count in 1..=wrongs.len() {
            let outcome = judged(Decoder::Threshold, |lines, _, fitted| {
                wrongs[..count].iter().for_each(|(_, wrong)| wrong(lines, fitted));
            });
            assert_eq!(outcome, Err(wrongs[count - 1].0), "{count}");
        }
    }

    /// Stripes that alternate, `w` = 1.02 px wide, keep `exp(-π² σ²/(2 w²))` of their contrast under a blur of 0.8 px: 1/20.
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-7** The decision margin MUST be at least `ḡ²/8`, and `ḡ²/4` for TRELLIS (`Margin`).
    #[test]
    fn stripes_that_blur_hides_have_no_margin() {
        let landmark = Landmark { stripe_height: 0.2, ..Landmark::new(Format::Paper) };
        let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload: PAYLOAD };
        let sensor = Sensor { blur: 0.8, noise: 1.0 };
        let camera_in_world = Pose::new(0.94, 0.0, PI);
        let scene =
            Scene { camera_in_world, landmarks: vec![posted], clutter: vec![], light: Light::default(), sensor };
        let camera = Camera::epuck();
        let lines = render(&camera, &scene, &mut ChaCha8Rng::seed_from_u64(3)).unwrap();
        let colours = codeword::layers(Format::Paper, PAYLOAD).unwrap();
        let layers =
            [0, 1].map(|i| FitLayer { line: &lines[i], first_pixel: 229, last_pixel: 250, stripes: &colours[i] });
        let homography = Homography { a: 0.0, s: 640.0 * landmark.half_width() / 0.94, k: 0.0 };
        let start = Imaging { homography, blur: 0.8 };
        let fitted = fit(&layers, &start, Illumination::Even, &camera, Format::Paper).unwrap();
        let rule = CrossingRule::Interpolated;
        let view =
            View { lines: [&lines[0], &lines[1]], camera: &camera, landmark: &landmark, rule, skew: Skew::at_rest() };
        let judged = accept_fit(&layers, fitted, Decoder::Trellis, &view, &mut Silent).map(|_| ());
        assert_eq!(judged, Err(CandidateRefusal::Margin));
    }

    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-13** The model of a pixel of the value 255 that FIT-5 left out of a window MUST be at least `255 - 2
    //# sqrt(v)`, and that of one of the value 0 at most `2 sqrt(v)`, but for the pixel of a step of light (`Misfit`).
    #[test]
    fn a_limited_pixel_must_be_what_the_model_says() {
        let limited = |value: u8, where_black: bool| {
            judged(Decoder::Threshold, |lines, _, _| {
                // The darkest pixel is in the middle of a bar.
                let (pixel, _) = lines[0].iter().enumerate().min_by_key(|(_, grey)| **grey).unwrap();
                let pixel = if where_black { pixel } else { 200 };
                lines[0][pixel] = value;
            })
        };
        assert_eq!(limited(255, true), Err(CandidateRefusal::Misfit));
        // 40 is more than two tolerances of 10.4 above 0.
        assert_eq!(limited(0, true), Err(CandidateRefusal::Misfit));
        // Pixel 200 is outside the window.
        assert_eq!(limited(0, false), Ok(()));
    }

    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-2** Of a candidate of the threshold, both layers' homographies MUST agree within 1 px in `a` and in
    //# `s` and within `1/20 + 1/s` in `k`, to which the whole-pixel rule adds 1 px, 1 px and 1/s, and a layer of the
    //# local threshold as much (`Disagree`).
    #[test]
    fn layers_that_are_not_seen_from_one_place_disagree() {
        let h = Homography { a: 10.0, s: 30.0, k: 0.1 };
        let agree = |da: f64, ds: f64, dk: f64, pixels: f64| {
            let other = Homography { a: h.a + da, s: h.s + ds, k: h.k + dk };
            first_failure(&agreement(&h, &other, &h, pixels, 0.0), &mut Silent).is_ok()
        };
        let (fine, paper) = (1.0, 2.0);
        assert!(agree(0.99, -0.99, 0.08, fine) && !agree(1.01, 0.0, 0.0, fine) && !agree(0.0, 1.01, 0.0, fine));
        // 1/20 + 1/30 and 1/20 + 2/30.
        assert!(!agree(0.0, 0.0, 0.084, fine) && agree(0.0, 0.0, 0.084, paper) && !agree(0.0, 0.0, 0.117, paper));
        assert!(agree(1.99, 1.99, 0.0, paper) && !agree(2.01, 0.0, 0.0, paper));
        // The play of a moving camera counts for `a` alone.
        let moving = |da: f64, ds: f64| {
            let other = Homography { a: h.a + da, s: h.s + ds, k: h.k };
            first_failure(&agreement(&h, &other, &h, fine, 4.0), &mut Silent).is_ok()
        };
        assert!(moving(4.99, 0.99) && !moving(5.01, 0.0) && !moving(0.0, 1.01));
    }

    /// All pixels at their limits: there are none to fit (ACCEPT-10).
    //= reference/SPEC.md#accept
    //= type=test
    //# - **ACCEPT-10** A candidate of the threshold whose fits both are refused MUST be accepted by ACCEPT-2 and
    //# ACCEPT-3 alone, on its merged homography, with the paper's estimate and covariance (COV-5), and say so, if the
    //# global threshold found both layers, and otherwise be refused (`NoFit`).
    #[test]
    fn without_a_fit_the_global_threshold_s_estimate_is_the_paper_s() {
        let seen = Found::at_30_cm();
        let lines =
            seen.lines.clone().map(|line| line.iter().map(|&value| if value > 120 { 255 } else { 0 }).collect());
        let [upper, lower]: [Vec<u8>; 2] = lines;
        let (camera, landmark) = (&Camera::epuck(), &Landmark::new(Format::Paper));
        let view =
            View { lines: [&upper, &lower], camera, landmark, rule: CrossingRule::Interpolated, skew: Skew::at_rest() };
        let homography = Homography { a: 0.0, s: 32.0, k: 0.01 };
        let decided = |thresholding| {
            let layer = |i: usize| DecodedLayer {
                thresholding,
                hypothesis: Hypothesis {
                    first_region: 1,
                    last_region: 9,
                    first_pixel: seen.pixels[i].0,
                    last_pixel: seen.pixels[i].1,
                },
                half_word: 0x5A5,
                homography,
            };
            accept([&layer(0), &layer(1)], &view, &mut Silent)
        };
        let found = decided(Thresholding::Global).unwrap();
        assert!(found.fit.is_none() && found.homography == homography);
        assert_eq!(found.pose.camera_in_landmark, pose(&homography, camera, landmark));
        assert_eq!(decided(Thresholding::Local), Err(CandidateRefusal::NoFit));
    }

    #[test]
    fn the_rule_and_the_local_threshold_add_a_pixel_each() {
        let homography = Homography { a: 10.0, s: 30.0, k: 0.1 };
        let hypothesis = Hypothesis { first_region: 1, last_region: 9, first_pixel: 10, last_pixel: 70 };
        let layer = |thresholding| DecodedLayer { thresholding, hypothesis, half_word: 0, homography };
        let (global, local) = (layer(Thresholding::Global), layer(Thresholding::Local));
        let apart = |layers, rule| pixels_apart(layers, rule).to_bits();
        let (fine, paper) = (CrossingRule::Interpolated, CrossingRule::WholePixel);
        assert_eq!(apart([&global, &global], fine), 1.0_f64.to_bits());
        assert_eq!(apart([&global, &local], fine), 2.0_f64.to_bits());
        assert_eq!(apart([&global, &global], paper), 2.0_f64.to_bits());
        assert_eq!(apart([&local, &global], paper), 3.0_f64.to_bits());
    }

    /// The margin counts the changes of one stripe: of a frontal landmark with stripes of 3.2 px a stripe's ink is about
    /// 3.2 px, less what the blur smears, times the squared contrast.
    #[test]
    fn the_margin_is_what_the_nearest_change_costs() {
        let detection = found(&lines((0.3, 0.0, PI)));
        let accepted = detection.fit.unwrap();
        let gain = mean_gain(&accepted.fitted.lights);
        assert!((2.0..3.2).contains(&(accepted.margin / (gain * gain))), "{}", accepted.margin / (gain * gain));
    }
}
