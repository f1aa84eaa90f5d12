//! What a candidate must be like to be a detection.

pub mod margin;

use crate::camera::Camera;
use crate::covariance::{self, PoseCovariance};
use crate::crossing::CrossingRule;
use crate::edge::Blur;
use crate::fit::{self, FitLayer, Fitted, Illumination, LayerLight, Start};
use crate::formats::Column;
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::ink::Edges;
use crate::landmark::Landmark;
use crate::light::{Limited, LitLayer};
use crate::merge::{Decoder, Detection, FitSummary, LayerFit, Reading, merged};
use crate::observer::Observer;
use crate::pose::pose;
use crate::quiet_zone;
use crate::refusal::CandidateRefusal;
use crate::skew::{Shift, Skew};
use crate::whiteness::{self, Correlations};
use margin::Squares;

/// What a fit has to keep to, which depends on what decoded it.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// The largest blur (`ACCEPT-5`).
    blur: Column,
    /// What share of the contrast noise may be: `v = (ḡ/contrast)² + 9` (`ACCEPT-6`).
    contrast: u64,
    /// What share of `ḡ²` the margin has at least (`ACCEPT-7`).
    margin: u64,
}

impl Limits {
    const THRESHOLD: Self = Self { blur: Column::ONE, contrast: 16, margin: 8 };
    /// 0.9 px is rounded down.
    const TRELLIS: Self = Self { blur: Column::from_bits(943_718), contrast: 32, margin: 4 };

    const fn of(decoder: Decoder) -> Self {
        match decoder {
            Decoder::Threshold => Self::THRESHOLD,
            Decoder::Trellis => Self::TRELLIS,
        }
    }

    /// `4 contrast² v` in 2^-16 squared grey levels, `(2 ḡ)² + 36 contrast²`, below 2^38.
    fn noise(&self, fitted: &Fitted) -> u64 {
        twice_gain_squared(fitted) + ((36 * self.contrast * self.contrast) << 16)
    }

    /// Whether the noise is explained (`ACCEPT-6`), exactly.
    //= reference/SPEC.md#accept
    //# - **ACCEPT-6** The noise MUST be explained, `s² <= v` with `v = (ḡ/16)² + 9`, and `v = (ḡ/32)² + 9` for TRELLIS
    //# (`Misfit`).
    fn explain(&self, fitted: &Fitted) -> bool {
        4 * self.contrast * self.contrast * u64::from(fitted.variance) <= self.noise(fitted)
    }

    /// Whether a pixel may be this much beyond the value that limits it, in 2^-8 grey level: `distance² <= 4 v`
    /// (`ACCEPT-13`), exactly.
    fn allow(&self, distance: u32, fitted: &Fitted) -> bool {
        self.contrast * self.contrast * u64::from(distance).pow(2) <= self.noise(fitted)
    }

    /// Whether what is left looks like noise (`ACCEPT-15`), `6 Σ <= n v` times `4 contrast²`, exactly.
    ///
    /// Either side has 16 fraction bits. With [`Correlations`] below 2^48 the left one is below 2^62.6; the right one is below
    /// 2^48.4, `n` being at most 1280.
    //= reference/SPEC.md#accept
    //# - **ACCEPT-15** What a barcode leaves unexplained MUST look like noise: of the `n` pixels that were fitted, less
    //# their model, the products of neighbours and those of pixels with one pixel between them, each summed over both
    //# layers, come to at most `n v/6` (`Correlated`).
    fn take_for_noise(&self, left: &Correlations, fitted: &Fitted) -> bool {
        let limit = u64::from(left.pixels) * self.noise(fitted);
        let beyond = |sum: i64| u64::try_from(sum).is_ok_and(|sum| 24 * self.contrast * self.contrast * sum > limit);
        !beyond(left.neighbours) && !beyond(left.one_between)
    }

    /// Whether the margin is wide enough (`ACCEPT-7`), exactly.
    //= reference/SPEC.md#accept
    //# - **ACCEPT-7** The decision margin MUST be at least `ḡ²/8`, and `ḡ²/4` for TRELLIS (`Margin`).
    fn decide(&self, margin: Squares, fitted: &Fitted) -> bool {
        u64::try_from(margin).is_ok_and(|margin| (4 * self.margin * margin) << 8 >= twice_gain_squared(fitted))
    }
}

/// The gain nearest to 0, -12 grey levels in 2^-8 (`ACCEPT-4`).
const LEAST_CONTRAST: i32 = -12 << 8;

/// What all candidates of an image have in common.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// Both scan lines, the upper one first.
    pub lines: [&'a [u8]; 2],
    /// The camera.
    pub camera: &'a Camera,
    /// The format and its dimensions.
    pub landmark: &'a Landmark,
    /// How transitions were placed.
    pub rule: CrossingRule,
    /// How the camera moved between the lines.
    pub skew: &'a Skew,
}

/// A pair with a payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// Its payload.
    pub payload: u32,
    /// The upper and the lower reading.
    pub readings: [Reading; 2],
}

/// What a candidate's decoder has found out about where it is.
#[derive(Clone, Copy, Debug)]
pub enum Evidence<'a> {
    /// The threshold: both layers' homographies.
    Threshold {
        /// These as their own rows saw them, the upper one first.
        layers: [Homography; 2],
        /// The shift of the upper one (`SKEW-2`), none at rest.
        shift: Shift,
        /// Whether at least one was found by the local threshold.
        local: bool,
    },
    /// The trellis: the last fit.
    Trellis(&'a Fitted),
}

impl Evidence<'_> {
    /// Whose it is.
    #[must_use]
    pub fn decoder(&self) -> Decoder {
        match self {
            Self::Threshold { .. } => Decoder::Threshold,
            Self::Trellis(_) => Decoder::Trellis,
        }
    }
}

/// Where a camera is, and how well that is known.
type Located = (Pose<frame::Landmark, frame::Camera>, PoseCovariance);

/// Decides a candidate (`ACCEPT`); `ACCEPT-2` is asked before it is fitted.
///
/// # Errors
/// The first of `ACCEPT`'s reasons that holds.
pub fn accept<O: Observer>(
    candidate: &Candidate,
    evidence: Evidence<'_>,
    setting: &Setting<'_>,
    observer: &mut O,
) -> Result<Detection, CandidateRefusal> {
    match evidence {
        Evidence::Trellis(fitted) => accept_joint(candidate, Decoder::Trellis, fitted, setting),
        Evidence::Threshold { layers: [upper, lower], shift, local } => {
            let (pixels, moved_back) = (pixels_apart(setting.rule, local), shift.taken_off(&lower));
            let transitions = merged(&upper, &moved_back, setting.skew);
            if !agree(&upper, &moved_back, &transitions, pixels, setting.skew.play) {
                return Err(CandidateRefusal::Disagree);
            }
            let fits = if setting.skew.is_at_rest() {
                fit_threshold(&layers(candidate, setting), &transitions, setting, observer).map(Fits::Joint)
            } else {
                fit_each(candidate, [&upper, &lower], setting, observer).map(Fits::Each)
            };
            let found = match fits {
                Some(Fits::Joint(fitted)) => accept_joint(candidate, Decoder::Threshold, &fitted, setting),
                Some(Fits::Each(fits)) => accept_each(candidate, &fits, setting),
                None if local => Err(CandidateRefusal::NoFit),
                None => accept_merged(candidate, &transitions, setting),
            };
            found.map(|found| Detection { transitions: Some(transitions), ..found })
        }
    }
}

/// How many pixels the transitions of two layers may be apart (`ACCEPT-2`).
fn pixels_apart(rule: CrossingRule, local: bool) -> u8 {
    1 + u8::from(rule == CrossingRule::WholePixel) + u8::from(local)
}

/// Whether two layers see one barcode (`ACCEPT-2`), exactly, the lower one less the shift and with a play in `a` (`SKEW-6`); `s` is
/// that of the merged homography.
//= reference/SPEC.md#accept
//# - **ACCEPT-2** Of a candidate of the threshold, both layers' homographies MUST agree within 1 px in `a` and in `s`
//# and within `1/20 + 1/s` in `k`, to which the whole-pixel rule adds 1 px, 1 px and 1/s, and a layer of the local
//# threshold as much (`Disagree`).
fn agree(upper: &Homography, lower: &Homography, merged: &Homography, pixels: u8, play: u32) -> bool {
    let pixels = i128::from(pixels);
    let apart = |one: i32, other: i32| i128::from(one.abs_diff(other));
    let pixel = i128::from(Column::ONE.to_bits());
    let (s, s_apart) = (i128::from(merged.s.to_bits()), apart(upper.s.to_bits(), lower.s.to_bits()));
    let a_apart = apart(upper.a.to_bits(), lower.a.to_bits());
    // |Δk| <= 1/20 + n/s, times 20 s: 30 and 20 fraction bits.
    let k_apart = apart(upper.k.to_bits(), lower.k.to_bits()) * 20 * s;
    let k_limit = (s + 20 * pixels * pixel) << 30;
    a_apart <= (pixels + i128::from(play)) * pixel && s_apart <= pixels * pixel && k_apart <= k_limit
}

/// The fits of a threshold's candidate.
enum Fits {
    /// At rest: of both layers.
    Joint(Fitted),
    /// Of a moving camera: of each layer alone (`SKEW-7`).
    Each([Fitted; 2]),
}

/// The fit of one layer or both, under even light or under a step of light (`ACCEPT-1`); none if both are refused.
//= reference/SPEC.md#accept
//# - **ACCEPT-1** A candidate of the threshold MUST be fitted (FIT) from its merged homography, under even light, and
//# if that is refused or ACCEPT-6 would refuse it, under a step of light.
#[inline(never)] // what it keeps on the stack is gone before the candidate is decided
fn fit_threshold<O: Observer>(
    layers: &[FitLayer<'_>],
    start: &Homography,
    setting: &Setting<'_>,
    observer: &mut O,
) -> Option<Fitted> {
    let format = setting.landmark.format;
    let mut fit = |illumination| {
        let fitted = fit::fit(layers, &Start::at(start), setting.camera, format, illumination);
        observer.fitted(fitted.as_ref().map_err(|refusal| *refusal));
        fitted.ok()
    };
    let even = fit(Illumination::Even);
    match even {
        Some(even) if Limits::THRESHOLD.explain(&even) => Some(even),
        even => fit(Illumination::Step).or(even),
    }
}

/// The fits of both layers, each from its own homography (`SKEW-7`); none if one of them has none.
//= reference/SPEC.md#skew
//# - **SKEW-7** The layers of a moving camera MUST each be fitted alone from their own homography as ACCEPT-1 says, the
//# fit of each be asked ACCEPT-3 to ACCEPT-9 and ACCEPT-12 to ACCEPT-17 alone, the upper one first, and both together
//# ACCEPT-4's ratio of the gains before that; where either has no fit, ACCEPT-10 decides.
fn fit_each<O: Observer>(
    candidate: &Candidate,
    homographies: [&Homography; 2],
    setting: &Setting<'_>,
    observer: &mut O,
) -> Option<[Fitted; 2]> {
    let [above, below] = layers(candidate, setting);
    let [upper, lower] = homographies;
    let upper = fit_threshold(&[above], upper, setting, observer);
    let lower = fit_threshold(&[below], lower, setting, observer);
    Some([upper?, lower?])
}

/// The candidate's layers, for the fit.
fn layers<'a>(candidate: &Candidate, setting: &Setting<'a>) -> [FitLayer<'a>; 2] {
    let [upper, lower] = setting.lines;
    let [above, below] = candidate.readings;
    let format = setting.landmark.format;
    [above.layer(upper, format), below.layer(lower, format)]
}

/// Decides by one fit of both layers.
fn accept_joint(
    candidate: &Candidate,
    decoder: Decoder,
    fitted: &Fitted,
    setting: &Setting<'_>,
) -> Result<Detection, CandidateRefusal> {
    let (LayerFit { homography, fit }, located) = accept_fitted(&layers(candidate, setting), decoder, fitted, setting)?;
    Ok(detection(candidate, decoder, setting, homography, Some(fit), located))
}

/// Decides by the fits of each layer alone, the upper one first (`SKEW-7`); the detection is the upper one's (`SKEW-8`).
//= reference/SPEC.md#skew
//# - **SKEW-8** What a detection of a moving camera says MUST be what is seen at the upper row's time: by the upper
//# layer's fit, or without a fit by MERGE-4's mean of `s` and `k`, the lower layer's less the shift, and the upper
//# layer's `a`.
fn accept_each(
    candidate: &Candidate,
    fits: &[Fitted; 2],
    setting: &Setting<'_>,
) -> Result<Detection, CandidateRefusal> {
    let decoder = Decoder::Threshold;
    let ([upper, lower], [above, below]) = (fits, layers(candidate, setting));
    if !gains_match(gain(upper), gain(lower)) {
        return Err(CandidateRefusal::Contrast);
    }
    let (LayerFit { homography, fit }, located) = accept_fitted(&[above], decoder, upper, setting)?;
    let (lower, _) = accept_fitted(&[below], decoder, lower, setting)?;
    let found = detection(candidate, decoder, setting, homography, Some(fit), located);
    Ok(Detection { lower_fit: Some(lower), ..found })
}

/// Decides by the fit of one layer or both (`ACCEPT-3` to `ACCEPT-9`, `ACCEPT-12` to `ACCEPT-17`), `ḡ` being the gain where there
/// is one layer.
//= reference/SPEC.md#accept
//# - **ACCEPT-5** The blur MUST be at most 1 px, and 0.9 px for TRELLIS (`Blur`).
//= reference/SPEC.md#accept
//# - **ACCEPT-9** ACCEPT-2 to ACCEPT-4, ACCEPT-14, ACCEPT-5, ACCEPT-6, ACCEPT-13, ACCEPT-15, ACCEPT-16 and ACCEPT-7
//# MUST be asked in this order, and the first that fails be reported.
//= reference/SPEC.md#accept
//# - **ACCEPT-12** A candidate MUST be refused (`Undetermined`) by COV-4 last.
#[inline(never)] // what it keeps on the stack is not there during the fits
fn accept_fitted(
    layers: &[FitLayer<'_>],
    decoder: Decoder,
    fitted: &Fitted,
    setting: &Setting<'_>,
) -> Result<(LayerFit, Located), CandidateRefusal> {
    let (camera, landmark, limits) = (setting.camera, setting.landmark, Limits::of(decoder));
    if !is_visible(&fitted.homography, camera) {
        return Err(CandidateRefusal::Oblique);
    }
    if !has_contrast(&fitted.lights) || !black_is_possible(&fitted.lights) {
        return Err(CandidateRefusal::Contrast);
    }
    if fitted.blur > limits.blur {
        return Err(CandidateRefusal::Blur);
    }
    if !limits.explain(fitted) || !limited_pixels_fit(layers, &limits, fitted, setting) {
        return Err(CandidateRefusal::Misfit);
    }
    if !limits.take_for_noise(&correlations(layers, fitted, setting), fitted) {
        return Err(CandidateRefusal::Correlated);
    }
    if !has_quiet_zones(layers, fitted, setting) {
        return Err(CandidateRefusal::QuietZone);
    }
    let margin = margin(layers, fitted, setting);
    if !limits.decide(margin, fitted) {
        return Err(CandidateRefusal::Margin);
    }
    let Fitted { homography, blur, covariance, variance, .. } = *fitted;
    let located = covariance::transform(&homography, &covariance, camera, landmark);
    let located = located.map_err(|_| CandidateRefusal::Undetermined)?;
    let fit = FitSummary { covariance, blur, variance, margin, illumination: fitted.illumination() };
    Ok((LayerFit { homography, fit }, located))
}

/// Decides without a fit (`ACCEPT-10`).
//= reference/SPEC.md#accept
//# - **ACCEPT-10** A candidate of the threshold whose fits both are refused MUST be accepted by ACCEPT-2 and ACCEPT-3
//# alone, on its merged homography, with the paper's estimate and covariance (COV-5), and say so, if the global
//# threshold found both layers, and otherwise be refused (`NoFit`).
#[inline(never)] // likewise
fn accept_merged(
    candidate: &Candidate,
    merged: &Homography,
    setting: &Setting<'_>,
) -> Result<Detection, CandidateRefusal> {
    if !is_visible(merged, setting.camera) {
        return Err(CandidateRefusal::Oblique);
    }
    let camera_in_landmark = pose(merged, setting.camera, setting.landmark);
    let covariance = covariance::paper(&camera_in_landmark, setting.camera);
    let located = (camera_in_landmark, covariance);
    Ok(detection(candidate, Decoder::Threshold, setting, *merged, None, located))
}

/// Whether a camera can see it (`ACCEPT-3`), exactly. Both sides have 46 fraction bits and are below 2^60.
//= reference/SPEC.md#accept
//# - **ACCEPT-3** The obliquity MUST be one that a camera can see, `f |k| <= 3 s` (`Oblique`).
fn is_visible(homography: &Homography, camera: &Camera) -> bool {
    let k = u64::from(homography.k.to_bits().unsigned_abs());
    let s = u64::try_from(homography.s.to_bits()).unwrap_or(0);
    u64::from(camera.focal_length().to_bits()) * k <= (3 * s) << 26
}

/// Whether the noise of a fit is explained by ACCEPT-6's `v` of a decoder, `ḡ` being the gain where there is one layer alone
/// (`LAYER-2`), exactly.
#[must_use]
pub fn is_explained(fitted: &Fitted, decoder: Decoder) -> bool {
    Limits::of(decoder).explain(fitted)
}

/// The gain of a layer that was fitted alone, in 2^-8 grey level.
fn gain(alone: &Fitted) -> i32 {
    alone.lights.first().map_or(0, |light| light.gain)
}

/// Whether one layer or both have contrast, and neither more than twice that of the other (`ACCEPT-4`), exactly.
//= reference/SPEC.md#accept
//# - **ACCEPT-4** Both gains MUST be at most -12 grey levels, and neither more than twice the other (`Contrast`).
fn has_contrast(lights: &[LayerLight]) -> bool {
    let matched = match lights {
        [upper, lower] => gains_match(upper.gain, lower.gain),
        _ => true,
    };
    matched && lights.iter().all(|light| light.gain <= LEAST_CONTRAST)
}

/// Whether neither of two gains below 0 is more than twice the other (`ACCEPT-4`), exactly.
fn gains_match(upper: i32, lower: i32) -> bool {
    upper >= 2 * lower && lower >= 2 * upper
}

/// `2 ḡ` in 2^-8 grey levels, within ±2^18; of one layer twice its own gain.
fn twice_gain(lights: &[LayerLight]) -> i32 {
    match lights {
        [alone] => 2 * alone.gain,
        _ => lights.iter().map(|light| light.gain).sum(),
    }
}

/// `(2 ḡ)²` in 2^-16 squared grey levels, below 2^37.
fn twice_gain_squared(fitted: &Fitted) -> u64 {
    u64::from(twice_gain(&fitted.lights).unsigned_abs()).pow(2)
}

/// Whether the layers' black is one that a camera can see (`ACCEPT-14`), `16 (o + g) >= 2 ḡ` unless there is a step of
/// light, exactly.
///
/// `o + g` is within ±2^18.
//= reference/SPEC.md#accept
//# - **ACCEPT-14** Under even light `8 (o + g)` MUST be at least `ḡ` in both layers (`Contrast`).
fn black_is_possible(lights: &[LayerLight]) -> bool {
    lights.iter().all(|light| light.step.is_some() || 16 * (light.offset + light.gain) >= twice_gain(lights))
}

/// The edges of a fit.
fn edges(fitted: &Fitted, setting: &Setting<'_>) -> Edges {
    Edges::new(setting.landmark.format, &fitted.homography, Blur::new(fitted.blur), setting.camera)
}

/// Whether the pixels that the camera limited are about as dark or as bright by the model (`ACCEPT-13`).
///
/// The errors of a model are those of [`crate::light::Seen::change`] and of the ink.
//= reference/SPEC.md#accept
//# - **ACCEPT-13** The model of a pixel of the value 255 that FIT-5 left out of a window MUST be at least `255 - 2
//# sqrt(v)`, and that of one of the value 0 at most `2 sqrt(v)`, but for the pixel of a step of light (`Misfit`).
fn limited_pixels_fit(layers: &[FitLayer<'_>], limits: &Limits, fitted: &Fitted, setting: &Setting<'_>) -> bool {
    let (format, edges) = (setting.landmark.format, edges(fitted, setting));
    layers.iter().zip(&fitted.lights).all(|(layer, light)| {
        let lit = LitLayer::new(layer, format, light);
        (lit.first_pixel()..=lit.last_pixel()).all(|pixel| {
            let Some(seen) = lit.at(pixel).filter(|seen| seen.limited != Limited::Not) else { return true };
            let residual = seen.residual(edges.layer(format, layer.stripes, pixel));
            let (least, greatest) = seen.limited.range();
            limits.allow(residual.clamp(least, greatest).unsigned_abs(), fitted)
        })
    })
}

/// What layers leave unexplained (`ACCEPT-15`); see [`whiteness::correlations`].
fn correlations(layers: &[FitLayer<'_>], fitted: &Fitted, setting: &Setting<'_>) -> Correlations {
    whiteness::correlations(setting.landmark.format, &edges(fitted, setting), layers, &fitted.lights)
}

/// Whether there is a quiet zone on either side of every layer (`ACCEPT-16`); see [`quiet_zone::is_clear`].
//= reference/SPEC.md#accept
//# - **ACCEPT-16** Of the nearest `4 q` pixels on either side of each layer's ROI or extent, with `q` the least number
//# for which `N (q + 1) >= 2 e`, the nearest `q` MUST be white, or else those before one of them white, and it and all
//# others dark (`QuietZone`).
fn has_quiet_zones(layers: &[FitLayer<'_>], fitted: &Fitted, setting: &Setting<'_>) -> bool {
    let (format, edges) = (setting.landmark.format, edges(fitted, setting));
    let contrast = twice_gain(&fitted.lights).unsigned_abs();
    layers.iter().zip(&fitted.lights).all(|(layer, light)| quiet_zone::is_clear(format, &edges, layer, light, contrast))
}

/// The decision margin of layers (`ACCEPT-8`), the least of each one's; see [`margin::least_change`].
//= reference/SPEC.md#accept
//# - **ACCEPT-8** The decision margin MUST be the least change of the sum of squares over both layers and over the
//# changes of one code stripe, of two neighbours that differ and of three neighbours of which each differs from the
//# next, all other parameters kept and the pixel of a step of light left out.
#[must_use]
pub fn margin(layers: &[FitLayer<'_>], fitted: &Fitted, setting: &Setting<'_>) -> Squares {
    let (format, edges) = (setting.landmark.format, edges(fitted, setting));
    let read = layers.iter().zip(&fitted.lights);
    read.map(|(layer, light)| {
        let lit = LitLayer::new(layer, format, light);
        margin::least_change(format, &edges, &lit, layer.half_word(format))
    })
    .fold(Squares::MAX, Squares::min)
}

fn detection(
    candidate: &Candidate,
    decoder: Decoder,
    setting: &Setting<'_>,
    homography: Homography,
    fit: Option<FitSummary>,
    (camera_in_landmark, covariance): Located,
) -> Detection {
    let Candidate { payload, readings: [upper, lower] } = *candidate;
    let format = setting.landmark.format;
    Detection {
        format,
        payload,
        decoder,
        upper,
        lower,
        homography,
        fit,
        lower_fit: None,
        transitions: None,
        camera_in_landmark,
        covariance,
    }
}

#[cfg(test)]
mod tests;
