//! The table of what "the same" means, stage by stage (SAME).
//!
//! Bounds are derived from the port's rounding errors, one term per operation, as its documentation lists them; none is
//! fitted to what was seen. `tests/bounds.rs` fails where one is more than four times looser than anything seen in a
//! campaign, or more than 5 % of the standard deviation of what it bounds. The reference's declared error is no bound of
//! that kind: it is how near to a boundary its decisions are not trusted, a worst case of float64 that is not met.

use crate::port::{Cameras, stripe_width_error};
use crate::sensitivity::Sensitivity;
use crate::trace::{DetectionFit, DetectionTrace, FitTrace, HomographyTrace, LightTrace, PoseTrace};
use core::f64::consts::PI;
use reference::accept::{ALLOWED_NOISE, Limits, Test};
use reference::fit::MAX_STEPS;
use reference::frame::wrap;
use reference::homography::Homography;
use reference::landmark::{Format, Landmark};
use reference::merge::Decoder;
use reference::refusal::{CandidateRefusal, FitRefusal};
pub use reference::sampling::DECLARED_ERROR;
use serde::Serialize;

/// How a stage's results are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Identical (SAME-1).
    //= reference/SPEC.md#same
    //# - **SAME-1** Threshold, regions, hypotheses, crossings, refusals, decoded bits, pairs and payloads MUST be
    //# identical in both pipelines, except after a marginal decision.
    Exact,
    /// Differ by no more than the bound (SAME-2).
    //= reference/SPEC.md#same
    //# - **SAME-2** Homographies, fits, covariances and poses MUST differ by no more than the bound that the error
    //# budget derives.
    Bounded,
    /// Decisions: identical unless the reference's own margin is below the bound (SAME-3).
    //= reference/SPEC.md#same
    //# - **SAME-3** The decisions of HOMOG-3, SAMPLE-2 and SAMPLE-10 MUST be identical unless the reference's own
    //# margin is below the reference's declared error.
    Marginal,
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Darkest and brightest value.
    Threshold,
    /// Regions, and refused lines.
    Regions,
    /// ROIs and their checks.
    Hypotheses,
    /// Edges and columns of all transitions used.
    Crossings,
    /// Stripe middles, the regions they fall in, and the refusals that follow.
    Sampling,
    /// `a` of a layer.
    Centre,
    /// `s` of a layer.
    HalfWidth,
    /// `k` of a layer.
    Obliquity,
    /// Half words.
    Decode,
    /// Pairs of layers, payloads, refusals, detections and their order.
    Merge,
    /// Pairs of extents that are tried.
    Extents,
    /// Whether a pair becomes a detection, by which decoder and estimator.
    Accept,
    /// Pixels that a detection's fit used, and where its light steps.
    FitPixels,
    /// `a` of a detection's fit.
    FitCentre,
    /// `s` of a detection's fit.
    FitHalfWidth,
    /// `k` of a detection's fit.
    FitObliquity,
    /// Blur of a detection's fit.
    FitBlur,
    /// Offsets, gains and their changes of a detection's fit.
    FitLight,
    /// `s²` of a detection's fit, relative.
    FitVariance,
    /// Covariance of `(a, s, k)` of a detection's fit, relative to the standard deviations.
    FitCovariance,
    /// Decision margin of a detection's fit, relative.
    Margin,
    /// x of the camera in the landmark's frame.
    PoseX,
    /// y of the camera in the landmark's frame.
    PoseY,
    /// Heading of the camera in the landmark's frame.
    PoseTheta,
    /// Covariance of a pose, relative to the standard deviations.
    PoseCovariance,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// What is compared.
    pub stage: Stage,
    /// Its name in tables and certificates.
    pub name: &'static str,
    /// How it is compared.
    pub class: Class,
    /// Unit of difference and bound.
    pub unit: &'static str,
    /// Where the bound comes from.
    pub origin: &'static str,
}

const fn row(stage: Stage, name: &'static str, class: Class, unit: &'static str, origin: &'static str) -> Row {
    Row { stage, name, class, unit, origin }
}

/// The table, in the order of the stages.
pub const TABLE: [Row; 25] = [
    row(Stage::Threshold, "threshold", Class::Exact, "", "integers in both pipelines"),
    row(Stage::Regions, "regions", Class::Exact, "", "integers in both pipelines"),
    row(Stage::Hypotheses, "hypotheses", Class::Exact, "", "integers in both pipelines"),
    row(Stage::Crossings, "crossings", Class::Exact, "", "integers in both pipelines (CROSS-1)"),
    row(Stage::Sampling, "sampling", Class::Marginal, "px", "float64 rounding in the reference; the port is exact"),
    row(Stage::Centre, "homography.centre", Class::Bounded, "px", "rounding of A/D; camera"),
    row(
        Stage::HalfWidth,
        "homography.half_width",
        Class::Bounded,
        "px",
        "rounding of S/D, of k times the shift; camera",
    ),
    row(Stage::Obliquity, "homography.obliquity", Class::Bounded, "1", "rounding of K/D"),
    row(Stage::Decode, "decode", Class::Exact, "", "follows from sampling"),
    row(Stage::Merge, "merge", Class::Exact, "", "follows from decode"),
    row(Stage::Extents, "extents", Class::Exact, "", "integers in both pipelines; follows from the detections before"),
    row(Stage::Accept, "acceptance", Class::Marginal, "", "bounds of what is tested, beside its limit (SAME-5)"),
    row(Stage::FitPixels, "fit.pixels", Class::Marginal, "", "integers; a step of light may tie (FIT-15)"),
    row(Stage::FitCentre, "fit.centre", Class::Bounded, "px", FIT),
    row(Stage::FitHalfWidth, "fit.half_width", Class::Bounded, "px", FIT),
    row(Stage::FitObliquity, "fit.obliquity", Class::Bounded, "1", FIT),
    row(Stage::FitBlur, "fit.blur", Class::Bounded, "px", FIT),
    row(
        Stage::FitLight,
        "fit.light",
        Class::Bounded,
        "grey level",
        "rounding of a step, and the model's at either end",
    ),
    row(Stage::FitVariance, "fit.variance", Class::Bounded, "share", "rounding of residuals, six standard deviations"),
    row(Stage::FitCovariance, "fit.covariance", Class::Bounded, "share", "rounding of derivatives; that of s²"),
    row(Stage::Margin, "margin", Class::Bounded, "share", "rounding of residuals and changes; the blur's bound"),
    row(Stage::PoseX, "pose.x", Class::Bounded, "m", POSE),
    row(Stage::PoseY, "pose.y", Class::Bounded, "m", POSE),
    row(Stage::PoseTheta, "pose.theta", Class::Bounded, "rad", POSE),
    row(Stage::PoseCovariance, "pose.covariance", Class::Bounded, "share", "those of (a, s, k) and of its covariance"),
];

/// Origin of the bounds on a fit: six standard deviations, since roundings of tens of pixels add up like noise.
const FIT: &str = "rounding of residuals and derivatives, six standard deviations; FIT-11's stop; formats";

/// Origin of the bounds on a pose.
const POSE: &str = "those of the fit and its covariance, or of the homography through (9); formats";

impl Stage {
    /// Its row of the table.
    ///
    /// # Panics
    /// Never: a test looks up every stage.
    #[must_use]
    pub fn row(self) -> &'static Row {
        TABLE.iter().find(|row| row.stage == self).expect("the table has a row for every stage")
    }
}

/// Rounding errors of many pixels add up like noise; a campaign compares millions of quantities, and six standard deviations
/// are met once in 500 million.
const DEVIATIONS: f64 = 6.0;

/// The last step of a fit, in standard deviations, at the most (FIT-11).
const LAST_STEP: f64 = 1.0 / 15.0;

/// The standard deviation of an edge's derivatives as the port has them, by the gain: they are Taylor series of two terms
/// around multiples of 1/16, which leave `δ² φ''/2` of `δ` up to 1/32, and end at 15/4 standard deviations of the blur. On
/// average over that range these are 3.7e-5 for either boundary of a pixel, and 4.6e-5.
const TABULATED: f64 = 7e-5;

/// Beyond this share of Gauss-Newton's matrix the residuals' curvature leaves hardly a minimum, and fits do not converge.
const LARGEST_RATE: f64 = 0.9;

/// Bounds on a detection's fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitBounds {
    /// On `a`, `s`, `k`.
    pub homography: HomographyTrace,
    /// The part of them that is in standard deviations.
    pub share: f64,
    /// On the blur, pixels.
    pub blur: f64,
    /// On offsets, gains and their changes, grey levels.
    pub light: f64,
    /// On `s²`, relative.
    pub variance: f64,
    /// On the covariance, relative to the standard deviations.
    pub covariance: f64,
    /// The same besides, where the pipelines took different numbers of steps.
    pub further_step: f64,
    /// On the decision margin, relative.
    pub margin: f64,
    /// On the columns of the barcode's ends, pixels.
    pub ends: f64,
    /// On the mean product of two residuals (ACCEPT-15), squared grey levels.
    pub correlation: f64,
}

/// What the rounding of a fit depends on.
struct Rounding {
    /// Standard deviation of a pixel about its model, grey levels.
    noise: f64,
    /// Pixels.
    pixels: f64,
    /// Those whose derivatives are not 0, at the most.
    beside_edges: f64,
    /// The largest gain, grey levels.
    gain: f64,
    /// The curvature of the residuals.
    sensitivity: Sensitivity,
    /// Standard deviation of a residual's rounding, grey levels.
    residual: f64,
    /// That of a derivative's rounding to 10 bits or more, as a share of what decides on a parameter.
    derivative: f64,
    /// The same where it meets the residuals.
    fine_derivative: f64,
}

/// The standard deviation of what rounding to a multiple of `unit` does.
fn rounded(unit: f64) -> f64 {
    unit / 12.0_f64.sqrt()
}

impl Rounding {
    fn of(format: Format, fit: &DetectionFit, h: &HomographyTrace) -> Self {
        let pixels = fit.degrees_of_freedom + 12.0;
        let noise = fit.variance.sqrt();
        let most = |of: fn(&LightTrace) -> f64| fit.lights.iter().map(of).fold(0.0, f64::max);
        let gain = most(|light| light.levels[1].abs() + light.levels[3].abs());
        let slope = most(|light| light.levels[2].abs() + light.levels[3].abs());
        // A residual has 8 fraction bits; the light, both changes with λ, λ itself and the product with the ink have 12; the
        // ink goes into it with 16, from boundaries with 14, by twelve roundings to 16.
        let terms = [
            rounded(ulp(8)),
            3.0_f64.sqrt() * rounded(ulp(12)),
            slope * rounded(ulp(12)),
            2.0_f64.sqrt() * gain * rounded(ulp(16)),
            12.0_f64.sqrt() * gain * rounded(ulp(16)),
        ];
        let residual = terms.iter().map(|term| term * term).sum::<f64>().sqrt();
        let unit = 2.0_f64.powf(gain.log2().floor() + 1.0 - 10.0);
        // Products over all pixels of a layer add up in 30 bits; all that were fitted are of one layer at the most.
        let further = ((29.0 - pixels.log2().floor()) / 2.0 - 10.0).floor().clamp(0.0, 3.0);
        let [bits, edges] = weights(fit, h).map(|weight| weight / noise);
        Self {
            noise,
            pixels,
            // An edge reaches 15/4 standard deviations of the blur to either side.
            beside_edges: pixels.min(2.0 * format.stripes() as f64 * (1.0 + 7.5 * fit.blur)),
            gain,
            residual,
            derivative: rounded(unit * 2.0_f64.powf(-further)) * bits,
            fine_derivative: (rounded(unit * ulp(4)) * bits).hypot(TABULATED * gain * edges),
            sensitivity: fit.sensitivity,
        }
    }

    /// How far the minimum moves, in standard deviations: an error of `ε` in every pixel, independent of each other, moves it
    /// by `ε/s`, and one of `δ` in the derivatives that meet the residuals by `δ` times these; where the residuals bend the sum of squares, by as much more as it is softer than Gauss-Newton's.
    ///
    /// The last step, at most [`LAST_STEP`], leaves what Gauss-Newton's linear rate says, and of its own square what derivatives
    /// change in a standard deviation: at most themselves, as edges are known to less than the blur's width.
    fn share(&self) -> f64 {
        let moved = DEVIATIONS * (self.residual / self.noise + self.fine_derivative * self.beside_edges.sqrt());
        let Sensitivity { softening, rate, .. } = self.sensitivity;
        let [softening, rate] = [softening, rate].map(|share| share.min(LARGEST_RATE));
        moved / (1.0 - softening) + LAST_STEP * (rate / (1.0 - rate) + LAST_STEP)
    }

    /// On `s²`, relative: `Σ 2 r ε` of `Σ r²`, the errors' own squares, and what the last step lowers the sum by, since it is
    /// that of the equations before it (FIT-11) and one pipeline may stop a step before the other. FIT-6's minimum is not that
    /// of the pixels alone: as far as the prior has drawn it, their sum goes with the way itself, twelve parameters'.
    fn variance(&self, share: f64) -> f64 {
        let own = (self.residual * self.residual + ulp(16)) / (self.noise * self.noise);
        let way = 12.0_f64.sqrt() * share + LAST_STEP;
        let last = (LAST_STEP * LAST_STEP + 2.0 * way * self.sensitivity.pull / self.noise) / self.pixels;
        2.0 * DEVIATIONS * self.residual / (self.noise * self.pixels.sqrt()) + own + last
    }

    /// On the mean product of two residuals. With twelve parameters `share` of a standard deviation off, the residuals `r`
    /// move by `d` with `|d|²` of so many squared shares of `s²`, and their roundings `ε`; `Σ r r'` changes by
    /// `2 |r| |d| + |d|²` at the most, and by `2 r ε` like noise.
    fn correlation(&self, share: f64) -> f64 {
        let moved = (12.0 * share * share).sqrt() * self.noise;
        let rounded = 2.0 * DEVIATIONS * self.noise * self.residual / self.pixels.sqrt();
        (2.0 * self.noise * self.pixels.sqrt() * moved + moved * moved) / self.pixels + rounded
    }

    /// On the covariance, relative, of a fit that is `share` of the standard deviations elsewhere. Squared derivatives go with
    /// the square of the gain, with up to the cube of the blur, and where an edge moves across the border of two pixels
    /// between 1 and 1/2 in half a pixel.
    fn displaced(&self, fit: &DetectionFit, share: f64) -> f64 {
        let light = self.noise * self.sensitivity.light;
        share * (3.0 * fit.blur_deviation / fit.blur + 2.0 * light / self.gain + 2.0 * fit.covariance[(0, 0)].sqrt())
    }
}

/// What errors of the derivatives are carried to the covariance of `(a, s, k)` and the blur with, per grey level of noise:
/// one of all pixels alike, as far as bits go, and one that goes with how far an edge moves. With the column `j` of a
/// parameter, of which `s/σ` is left when it is freed of the others, a change `δ` of it changes the inverse by `2 δ σ/s` of
/// itself. Columns count from the window's middle, which is about the barcode's image.
fn weights(fit: &DetectionFit, h: &HomographyTrace) -> [f64; 2] {
    // Derivatives by `a` are up to `1/(1 - |k|)`, and have as many bits fewer; those by `k` as the half width is wide.
    let growth = match h.k.abs() {
        k if k <= 1.0 / 16.0 => 1.0,
        k if k <= 0.5 => 2.0,
        _ => 4.0,
    };
    let origin = (h.a - h.s * h.k) / (1.0 - h.k * h.k);
    let c = &fit.covariance;
    let half_width = (c[(1, 1)] - 2.0 * origin * c[(1, 2)] + origin * origin * c[(2, 2)]).max(0.0);
    let farthest = h.s / (1.0 - h.k.abs());
    let reach = 2.0_f64.powf(farthest.log2().floor() + 1.0);
    let bits = growth * growth * (c[(0, 0)] + half_width + reach * reach * c[(2, 2)]);
    // Over the edges `t` the squares of 1, t and t² are 1, 1/3 and 1/5 on average.
    let moved = c[(0, 0)] + half_width / 3.0 + farthest * farthest * c[(2, 2)] / 5.0;
    let edges = moved / (1.0 - h.k.abs()).powi(2);
    [bits, edges].map(|squares| (squares + fit.blur_deviation.powi(2)).sqrt())
}

/// Bounds on the fit of a detection of the reference.
///
/// Without noise a standard deviation is none: but `σ/s` is what the geometry makes of a grey level, so that `σ` times
/// `ε/s` is an absolute bound, whatever the noise. Formats: half units of 2^-20 px, of 2^-30 and, for the blur, of the
/// edge's 2^-15 px; the camera's principal column.
#[must_use]
pub fn fit(cameras: &Cameras, format: Format, fit: &DetectionFit, h: &HomographyTrace) -> FitBounds {
    let rounding = Rounding::of(format, fit, h);
    let share = rounding.share();
    let deviation = |i: usize| fit.covariance[(i, i)].sqrt();
    let column = cameras.configuration_error().principal_column;
    let variance = rounding.variance(share);
    let blur = share * fit.blur_deviation + ulp(15);
    // A pixel's change `d`, of up to three stripes, and its residual `r` have 6 fraction bits each, and `Σ (d² - 2 r d)`, about `Σ d²`, changes with
    // them by `Σ 2 (d - r) δd - 2 d δr`. Stripes of `w` px, alternately changed, lose `exp(-π² σ²/w²)` of their square to blur.
    let change = (3.0_f64.sqrt() * rounded(ulp(6))).hypot(rounding.residual);
    let width = 2.0 * h.s / format.stripes() as f64;
    let by_blur = 2.0 * PI * PI * fit.blur / (width * width);
    let margin = 8.0_f64.sqrt() * DEVIATIONS * change / fit.margin.max(1.0).sqrt() + by_blur * blur;
    let homography = HomographyTrace {
        a: share * deviation(0) + ulp(20) + column,
        s: share * deviation(1) + ulp(19) + h.k.abs() * column,
        k: share * deviation(2) + ulp(30),
    };
    let far = (h.a.abs() + h.s) / (1.0 - h.k.abs());
    FitBounds {
        homography,
        ends: (homography.a + homography.s + far * homography.k) / (1.0 - h.k.abs()),
        correlation: rounding.correlation(share),
        share,
        blur,
        // Fitted with 12 fraction bits and reported with 8.
        light: share * rounding.noise * fit.sensitivity.light + ulp(12) + ulp(9),
        variance,
        // The elimination has 30 bits, for matrices of a condition of up to 2^20. What a pixel has of an edge is cut to 12 bits,
        // half a unit of what adds up to 1 along the edge and to 0.3 or more when squared, and so is what moves the edge.
        covariance: 2.0 * DEVIATIONS * rounding.derivative
            + variance
            + rounding.displaced(fit, share)
            + ulp(10)
            + 2.0 * (ulp(13) / 0.3 + ulp(13)),
        further_step: rounding.displaced(fit, LAST_STEP),
        margin,
    }
}

/// How far the ink of a pixel in the model of a fit may be off, grey levels. Four parameters that are `share` of a standard
/// deviation off move a pixel by that of the noise, times the square root of the pixel's leverage. Leverages add up to 4; near
/// edges, where a half or a quarter of the pixels are, they are taken as four times their mean.
#[must_use]
pub fn of_a_pixel(fit: &FitTrace, bounds: &FitBounds) -> f64 {
    bounds.share * fit.variance.sqrt() * (4.0 * 4.0 / fit.degrees_of_freedom).sqrt()
}

/// Whether the light of a fit might as well have stepped elsewhere (FIT-15): whether the model of a pixel may be off by its
/// slack, grey levels. The port's inks have 13 fraction bits there, after twelve roundings to 16, and its start leaves a pixel
/// off by `start`.
#[must_use]
pub fn is_tied(fit: &FitTrace, start: f64) -> bool {
    let gain = fit.lights.iter().map(|light| light.levels[1].abs()).fold(0.0, f64::max);
    let ink = rounded(ulp(13)).hypot(12.0_f64.sqrt() * rounded(ulp(16)));
    fit.step_slack <= DEVIATIONS * gain * ink + start
}

/// Whether the port's fit might end otherwise at FIT-13's last step: a port that is a twentieth of a standard deviation off
/// (`tests/bounds.rs`) has a step that is longer by that.
#[must_use]
pub fn is_unfinished(fit: &Result<FitTrace, FitRefusal>) -> bool {
    let most = (1.0 + 1.0 / (20.0 * LAST_STEP)).powi(2);
    match fit {
        Ok(fit) => fit.steps == MAX_STEPS && fit.last_decrease * most >= 1.0,
        Err(FitRefusal::Unfinished(decrease)) => *decrease <= most,
        Err(_) => false,
    }
}

/// Whether a fit under even light is so near to ACCEPT-6's limit that the other pipeline may try a step of light (ACCEPT-1).
#[must_use]
pub fn is_barely_explained(fit: &FitTrace, bounds: &FitBounds) -> bool {
    let gain = fit.lights.iter().map(|light| light.levels[1]).sum::<f64>() / fit.lights.len() as f64;
    let Limits { share, .. } = Limits::of(Decoder::Threshold);
    let limit = (share * gain).powi(2) + ALLOWED_NOISE * ALLOWED_NOISE;
    let even = fit.lights.iter().all(|light| light.step.is_none());
    even && (fit.variance / limit - 1.0).abs() <= bounds.variance
}

/// How far a trial's start is moved to see whether it decides, pixels (SAME-5). The port's derivatives have 10 bits, and
/// where stripes are not explained to 30 to 50 grey levels a first step is uncertain by 10 px: 1 in 200 of it.
pub const START: f64 = 1.0 / 20.0;

/// How far a trial's guard fit is moved to see whether it decides, in its standard deviations (SAME-5): what fits may be off at
/// the most by `tests/bounds.rs`.
pub const GUARDS: f64 = 1.0 / 20.0;

/// Bounds on the pose of a fitted detection: its displacement in standard deviations, the covariance's share of what the
/// bend moves the mean by (COV-2), and formats of 2^-24 m and 2^-31 π; focal length and stripe width.
#[must_use]
pub fn pose_of_fit(
    cameras: &Cameras,
    landmark: &Landmark,
    detection: &DetectionTrace,
    bounds: &FitBounds,
) -> PoseTrace {
    let DetectionTrace { homography: HomographyTrace { a, s, k }, pose: mean, .. } = *detection;
    let middle = reference::pose::pose(&Homography { a, s, k }, &cameras.reference, landmark);
    let moved = [mean.x - middle.x(), mean.y - middle.y(), wrap(mean.theta - middle.theta())];
    let deviation = |i: usize| (bounds.share * detection.covariance[(i, i)].sqrt()).hypot(bounds.covariance * moved[i]);
    let f = cameras.configuration_error().focal_length / cameras.reference.focal_length;
    let scale = 2.0 * f + stripe_width_error(landmark) / landmark.stripe_width;
    PoseTrace {
        x: deviation(0) + scale * detection.pose.x.abs() + ulp(24),
        y: deviation(1) + scale * detection.pose.y.abs() + f * detection.pose.x.abs() + ulp(24),
        theta: deviation(2) + f + 0.55 * PI * ulp(31) + PI * ulp(31),
    }
}

/// Bound on the covariance of a pose, relative to the standard deviations.
///
/// That of (11) has variances that are exact to 2^-12 and change by 25.7 times the distance's error, and the same in the
/// square of the heading's share.
#[must_use]
pub fn pose_covariance(detection: &DetectionTrace, fit: Option<&FitBounds>, pose: &PoseTrace) -> f64 {
    if let Some(fit) = fit {
        // Two products and a square at each of five nodes, weighted, have 48 fraction bits: 15 half units at the most.
        let least = detection.covariance.diagonal().min();
        fit.covariance + fit.share + 15.0 * ulp(49) / least
    } else {
        let distance = detection.pose.x.hypot(detection.pose.y);
        let error = pose.x + pose.y;
        ulp(12) + 25.7 * error + 2.0 * error / distance + pose.theta
    }
}

/// By how much a test of ACCEPT may come nearer to its limit or beyond, as a share of the larger of both.
#[must_use]
pub fn test(test: &Test, fit: Option<&FitBounds>) -> f64 {
    let Some(fit) = fit else { return ulp(18) };
    match test.refusal {
        CandidateRefusal::Blur => fit.blur / test.limit,
        CandidateRefusal::Misfit => fit.variance + fit.light / test.limit.sqrt(),
        CandidateRefusal::Correlated => fit.correlation / test.limit + fit.variance,
        // White and gain, and beside the barcode's end what its edge moves; the limit is half the contrast.
        CandidateRefusal::QuietZone => 3.0 * fit.light / test.limit + 4.0 * (fit.ends + fit.blur),
        CandidateRefusal::Margin => fit.margin,
        // Of a gain that is compared with twice another, or with an offset and an eighth of the mean gain.
        CandidateRefusal::Contrast => 3.0 * fit.light / test.limit.abs().min(test.value.abs()),
        CandidateRefusal::Undetermined => fit.covariance,
        // The obliquity is as uncertain as a quarter of its limit at the most (COV-4).
        CandidateRefusal::Oblique => fit.share,
        _ => ulp(18),
    }
}

/// 2 to the power of `-bits`.
fn ulp(bits: i32) -> f64 {
    2.0_f64.powi(-bits)
}

/// Bounds on a layer's reported homography, whose ROI's middle is `shift` px from the principal column.
///
/// The port has `a`, `s` and `k` as exact ratios of integers and rounds each once: `a` to 2^-20 px; `k` to 2^-30; `s` to
/// 2^-30 px, to which `shift k` is added before it is rounded to 2^-20 px. Half a unit each. The camera's principal
/// column is off by what its conversion lost. The reference's own rounding is its declared error.
#[must_use]
pub fn homography(cameras: &Cameras, shift: f64, k: f64) -> HomographyTrace {
    let column = cameras.configuration_error().principal_column;
    let obliquity = ulp(31);
    HomographyTrace {
        a: ulp(21) + column + DECLARED_ERROR,
        s: ulp(21) + ulp(31) + shift.abs() * obliquity + k.abs() * column + DECLARED_ERROR,
        k: obliquity + DECLARED_ERROR * 2.0 / cameras.reference.width as f64,
    }
}

/// Bounds on a merged homography from those of its layers: the port rounds the mean once, to the next integer up.
#[must_use]
pub fn merged(upper: &HomographyTrace, lower: &HomographyTrace) -> HomographyTrace {
    HomographyTrace {
        a: f64::midpoint(upper.a, lower.a) + ulp(21),
        s: f64::midpoint(upper.s, lower.s) + ulp(21),
        k: f64::midpoint(upper.k, lower.k) + ulp(31),
    }
}

/// Bounds on the pose of a homography known to within `error`.
///
/// With `m = f k`, `g = s - a k` and `ρ² = s² + m²`, in half widths `X = f g/ρ²` and `Y = -(f m + a s)/ρ²`, and
/// `θ = atan2(m, -s)`. First-order propagation, each term by its absolute value; what is left out is smaller by the
/// relative error of s, below 2^-16. The port rounds `m` and `g` to 2^-20 px, `X` and `Y` to 2^-24 and the products with
/// the half width to 2^-24 m; its arctangent is good to 0.55 · 2^-31 π.
#[must_use]
pub fn pose(cameras: &Cameras, landmark: &Landmark, h: &HomographyTrace, error: &HomographyTrace) -> PoseTrace {
    let f = cameras.reference.focal_length;
    let f_error = cameras.configuration_error().focal_length;
    let w = landmark.half_width();
    let w_error = stripe_width_error(landmark) * landmark.format.stripes() as f64 / 2.0;
    let (m, g) = (f * h.k, h.s - h.a * h.k);
    let rho2 = h.s * h.s + m * m;
    let m_propagated = f * error.k + h.k.abs() * f_error;
    let m_error = m_propagated + ulp(21);
    let g_error = error.s + h.a.abs() * error.k + h.k.abs() * error.a + ulp(21);
    let rho2_error = 2.0 * h.s.abs() * error.s + 2.0 * m.abs() * m_error;
    let x = f * g / rho2;
    let y = (f * m + h.a * h.s) / rho2;
    let x_error = (f * g_error + g.abs() * f_error + x.abs() * rho2_error) / rho2 + ulp(25);
    let y_error = (f * m_error + m.abs() * f_error + h.a.abs() * error.s + h.s.abs() * error.a + y.abs() * rho2_error)
        / rho2
        + ulp(25);
    PoseTrace {
        x: w * x_error + w_error * x.abs() + ulp(25),
        y: w * y_error + w_error * y.abs() + ulp(25),
        theta: (h.s.abs() * m_propagated + m.abs() * error.s) / rho2 + 0.55 * PI * ulp(31),
    }
}

/// Bounds on the pose of a detection, whose layers have about its own homography.
///
/// A layer's shift, the ROI's middle less the principal column, follows from it: the barcode's ends are imaged at the ROI's
/// ends `m ± e/2`, `(a ± s)/(1 ± k)`, so `m = (a - s k)/(1 - k²)`. The transitions' residuals move it by less than a pixel.
#[must_use]
pub fn pose_of_detection(cameras: &Cameras, landmark: &Landmark, h: &HomographyTrace) -> PoseTrace {
    let shift = (h.a - h.s * h.k).abs() / (1.0 - h.k * h.k) + 1.0;
    let layer = homography(cameras, shift, h.k);
    pose(cameras, landmark, h, &merged(&layer, &layer))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_has_one_row() {
        for row in &TABLE {
            assert_eq!(TABLE.iter().filter(|other| other.stage == row.stage).count(), 1, "{}", row.name);
            assert_eq!(row.stage.row().name, row.name);
        }
    }
}
