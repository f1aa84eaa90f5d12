//! Both pipelines on one frame, compared stage by stage (SAME).

use crate::bounds::{self, DECLARED_ERROR, FitBounds, Stage};
use crate::port::{Cameras, Landmarks, port_rule};
use crate::record_fixedpoint::{self, RecordFixedpoint};
use crate::record_reference::{self, RecordReference};
use crate::sensitivity::sensitivity;
use crate::tally::{Frame, Tally};
use crate::trace::{
    DetectionFit, DetectionTrace, FitTrace, HomographyTrace, HypothesisTrace, Outcome, PairTrace, PoseTrace,
    SampleTrace, Trace, TrialTrace,
};
use fixedpoint::detect::Workspace;
use nalgebra::Matrix3;
use reference::accept::View;
use reference::crossing::CrossingRule;
use reference::decode::DecodedLayer;
use reference::extents::{Extent, Pair};
use reference::fit::Imaging;
use reference::frame::wrap;
use reference::homography::Homography;
use reference::hypotheses::Hypothesis;
use reference::landmark::{Format, Landmark};
use reference::merge::{Decoder, conclude_settled, merge};
use reference::observer::{Layer, Silent};
use reference::refusal::CandidateRefusal;
use reference::skew::Skew;
use reference::trellis;

/// What both pipelines are given besides the scan lines.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The camera.
    pub cameras: Cameras,
    /// The landmarks that are searched.
    pub landmarks: Landmarks,
    /// Where transitions lie.
    pub rule: CrossingRule,
}

impl Setting {
    /// Traces of the reference and of the port for two scan lines.
    #[must_use]
    pub fn run(&self, upper: &[u8], lower: &[u8]) -> [Trace; 2] {
        [self.run_reference(upper, lower), self.run_fixedpoint(upper, lower)]
    }

    /// The reference's trace.
    #[must_use]
    pub fn run_reference(&self, upper: &[u8], lower: &[u8]) -> Trace {
        let mut record = RecordReference::default();
        let (camera, landmarks) = (&self.cameras.reference, &self.landmarks.reference);
        let returned = reference::detect::detect(upper, lower, camera, landmarks, self.rule, &mut record);
        // What counts is what the caller is given; the observer must have heard the same.
        let heard = std::mem::replace(
            &mut record.trace.detections,
            returned.iter().map(record_reference::detection_trace).collect(),
        );
        record.trace.heard_is_returned = heard == record.trace.detections;
        record.trace.keep_lines(upper, lower);
        self.add_sensitivity(&mut record.trace);
        record.trace
    }

    /// Notes how sensitive the fits are that ACCEPT has asked about.
    fn add_sensitivity(&self, trace: &mut Trace) {
        let asked = |trial: &&mut TrialTrace| trial.tests.iter().any(|test| test.refusal == CandidateRefusal::Margin);
        let lines = trace.lines.each_ref().map(|line| &line.values[..]);
        for trial in trace.trials.iter_mut().filter(asked) {
            let found = sensitivity(trial, lines, &self.cameras.reference);
            if let (Some(found), Some(fit)) = (found, trial.fits.iter_mut().flatten().last()) {
                fit.sensitivity = found;
            }
        }
        for detection in &mut trace.detections {
            let (homography, trials) = (detection.homography, &trace.trials);
            let mut fits = trials.iter().flat_map(|trial| trial.fits.iter().flatten());
            if let Some(fit) = &mut detection.fit
                && let Some(same) = fits.find(|other| (other.homography, other.blur) == (homography, fit.blur))
            {
                fit.sensitivity = same.sensitivity;
            }
        }
    }

    /// The port's trace.
    #[must_use]
    pub fn run_fixedpoint(&self, upper: &[u8], lower: &[u8]) -> Trace {
        let mut record = RecordFixedpoint::default();
        let (camera, landmarks) = (&self.cameras.port, &self.landmarks.port);
        let mut workspace = Workspace::new();
        let rule = port_rule(self.rule);
        let returned = fixedpoint::detect::detect(upper, lower, camera, landmarks, rule, &mut workspace, &mut record);
        let returned = returned.iter().map(|found| record_fixedpoint::detection_trace(found, &record.trace)).collect();
        let heard = std::mem::replace(&mut record.trace.detections, returned);
        record.trace.heard_is_returned = heard == record.trace.detections;
        record.trace.keep_lines(upper, lower);
        record.trace
    }

    fn landmark(&self, format: Format) -> Option<&Landmark> {
        self.landmarks.reference.iter().find(|landmark| landmark.format == format)
    }

    /// Bounds on the homography of a decoded ROI.
    #[must_use]
    pub fn homography_bounds(&self, roi: &HypothesisTrace, h: &HomographyTrace) -> HomographyTrace {
        let middle = (roi.pixels.0 + roi.pixels.1) as f64 / 2.0;
        bounds::homography(&self.cameras, middle - self.cameras.reference.principal_column, h.k)
    }

    /// Bounds on a detection's fit.
    #[must_use]
    pub fn fit_bounds(&self, detection: &DetectionTrace) -> Option<FitBounds> {
        detection.fit.as_ref().map(|fit| bounds::fit(&self.cameras, detection.format, fit, &detection.homography))
    }

    /// Whether the light of one of a trial's fits might as well have stepped elsewhere (FIT-15). A fit under a step of light
    /// starts from the one before it if that was one too (TRELLIS-9), and else from a merged homography.
    fn is_tied(&self, trial: &TrialTrace) -> bool {
        let stepped = |fit: &&FitTrace| fit.lights.iter().any(|light| light.step.is_some());
        let fits: Vec<Option<&FitTrace>> = trial.fits.iter().map(|fit| fit.as_ref().ok()).collect();
        let before = std::iter::once(None).chain(fits.iter().copied());
        before.zip(&fits).any(|(before, fit)| {
            let start = before.filter(stepped).map_or(0.0, |before| {
                let bounds = bounds::fit(&self.cameras, trial.format, &before.with_margin(0.0), &before.homography);
                bounds::of_a_pixel(before, &bounds)
            });
            fit.is_some_and(|fit| bounds::is_tied(fit, start))
        })
    }

    /// Bounds on a detection's pose.
    #[must_use]
    pub fn pose_bounds(&self, detection: &DetectionTrace) -> Option<PoseTrace> {
        let landmark = self.landmark(detection.format)?;
        Some(match self.fit_bounds(detection) {
            Some(bounds) => bounds::pose_of_fit(&self.cameras, landmark, detection, &bounds),
            None => bounds::pose_of_detection(&self.cameras, landmark, &detection.homography),
        })
    }

    /// Bound on the covariance of a detection's pose, relative to the standard deviations.
    #[must_use]
    pub fn pose_covariance_bound(&self, detection: &DetectionTrace) -> Option<f64> {
        let pose = self.pose_bounds(detection)?;
        Some(bounds::pose_covariance(detection, self.fit_bounds(detection).as_ref(), &pose))
    }
}

/// Compares the traces of one frame and adds what was seen to the tally.
pub fn compare(setting: &Setting, frame: Frame, reference: &Trace, port: &Trace, tally: &mut Tally) {
    let mut comparison = Comparison { setting, frame, tally, marginal: false, differs: false, apart: false };
    comparison.lines(reference, port);
    comparison.hypotheses(reference, port);
    // What follows from a decision that was allowed to differ is no evidence either way.
    if !comparison.differs {
        comparison.results(reference, port);
    }
    let (marginal, differs) = (comparison.marginal, comparison.differs);
    tally.frames += 1;
    tally.marginal_frames += u64::from(marginal);
    tally.differing_frames += u64::from(differs);
}

struct Comparison<'a> {
    setting: &'a Setting,
    frame: Frame,
    tally: &'a mut Tally,
    /// A decision's margin was below the reference's declared error.
    marginal: bool,
    /// Such a decision differed.
    differs: bool,
    /// A pair became a detection in one pipeline only: what follows from that need not be named again.
    apart: bool,
}

impl Comparison<'_> {
    fn exact(&mut self, stage: Stage, same: bool) {
        self.tally.exact(stage, self.frame, same);
    }

    fn bounded(&mut self, stage: Stage, difference: f64, bound: f64) {
        self.tally.bounded(stage, self.frame, difference.abs(), bound);
    }

    fn lines(&mut self, reference: &Trace, port: &Trace) {
        for (r, p) in reference.lines.iter().zip(&port.lines) {
            self.exact(Stage::Threshold, r.threshold == p.threshold);
            self.exact(Stage::Regions, r.regions == p.regions && r.refusals == p.refusals);
        }
    }

    fn hypotheses(&mut self, reference: &Trace, port: &Trace) {
        for (r, p) in reference.hypotheses.iter().zip(&port.hypotheses) {
            let place = |h: &HypothesisTrace| (h.layer, h.thresholding, h.format, h.regions, h.pixels);
            self.exact(Stage::Hypotheses, place(r) == place(p));
            self.hypothesis(r, p);
            if self.differs {
                return;
            }
        }
        self.exact(Stage::Hypotheses, reference.hypotheses.len() == port.hypotheses.len());
        self.exact(Stage::Merge, reference.crowded == port.crowded);
    }

    fn hypothesis(&mut self, r: &HypothesisTrace, p: &HypothesisTrace) {
        let undecided = |margin: f64| margin < DECLARED_ERROR;
        for (r, p) in r.samples.iter().zip(&p.samples) {
            self.sample(r, p);
            if self.differs {
                return;
            }
        }
        let residual_margin = r.residual.map_or(f64::INFINITY, |residual| residual.margin);
        if undecided(r.plausibility_margin) || undecided(residual_margin) {
            self.tally.marginal(Stage::Sampling);
            self.marginal = true;
            if !same_end(&r.outcome, &p.outcome) {
                self.differs = true;
                return;
            }
        }
        // What one side does not report cannot be compared, and is not the same.
        self.exact(Stage::Sampling, r.samples.len() == p.samples.len());
        self.exact(Stage::Sampling, r.residual.is_some() == p.residual.is_some());
        if let (Some(r), Some(p)) = (r.residual, p.residual) {
            self.bounded(Stage::Sampling, r.difference - p.difference, DECLARED_ERROR);
        }
        self.exact(Stage::Crossings, r.crossings == p.crossings);
        self.outcome(r, p);
    }

    fn sample(&mut self, r: &SampleTrace, p: &SampleTrace) {
        self.bounded(Stage::Sampling, r.middle - p.middle, DECLARED_ERROR);
        let marginal = r.margin < DECLARED_ERROR;
        let same = (r.stripe, r.region) == (p.stripe, p.region);
        if marginal {
            self.tally.marginal(Stage::Sampling);
            self.marginal = true;
            self.differs |= !same;
        } else {
            self.exact(Stage::Sampling, same);
        }
    }

    fn outcome(&mut self, r: &HypothesisTrace, p: &HypothesisTrace) {
        if let (Outcome::Decoded { half_word, homography }, Outcome::Decoded { half_word: q, homography: g }) =
            (&r.outcome, &p.outcome)
        {
            let bound = self.setting.homography_bounds(r, homography);
            self.exact(Stage::Decode, half_word == q);
            self.bounded(Stage::Centre, homography.a - g.a, bound.a);
            self.bounded(Stage::HalfWidth, homography.s - g.s, bound.s);
            self.bounded(Stage::Obliquity, homography.k - g.k, bound.k);
        } else {
            let stage =
                if r.samples.is_empty() && r.crossings.is_empty() { Stage::Hypotheses } else { Stage::Sampling };
            self.exact(stage, same_end(&r.outcome, &p.outcome));
        }
    }

    fn results(&mut self, reference: &Trace, port: &Trace) {
        let of_layers = |pair: &&PairTrace| pair.decoder == Decoder::Threshold;
        let pairs = [reference, port].map(|trace| trace.pairs.iter().filter(of_layers));
        let [r, p] = pairs;
        self.exact(Stage::Merge, r.eq(p));
        self.exact(Stage::Merge, reference.heard_is_returned && port.heard_is_returned);
        self.trials(reference, port);
        for r in &reference.detections {
            // What is missing was noticed as a trial.
            if let Some(p) = port.detections.iter().find(|p| place(p) == place(r)) {
                self.detection(reference, r, p);
            }
        }
        if !self.apart {
            self.exact(Stage::Merge, reference.ambiguous == port.ambiguous);
            self.exact(Stage::Merge, reference.detections.iter().map(place).eq(port.detections.iter().map(place)));
        }
    }

    /// What became of each pair of layers or extents (SAME-5), why it was refused aside (SAME-6). Where a decision differs
    /// that may, the later pairs of extents may be others (EXTENT-5); those that both have tried are compared all the same.
    //= reference/SPEC.md#same
    //# - **SAME-6** Why a candidate was refused by FIT, TRELLIS or ACCEPT MUST be reported, and is compared only where
    //# no fit came before it.
    fn trials(&mut self, reference: &Trace, port: &Trace) {
        for r in &reference.trials {
            let Some(p) = port.trials.iter().find(|p| place_of_trial(p) == place_of_trial(r)) else { continue };
            let same = r.accepted() == p.accepted();
            self.apart |= !same;
            let hangs = || {
                self.setting.is_tied(r)
                    || r.fits.iter().any(bounds::is_unfinished)
                    || depends_on_start(self.setting, reference, r, p.accepted())
            };
            if is_marginal(self.setting, r) || !same && hangs() {
                self.tally.marginal(Stage::Accept);
                self.marginal = true;
                self.differs |= !same;
            } else {
                let compared = r.fits.is_empty() && p.fits.is_empty();
                self.exact(Stage::Accept, same && (!compared || r.refusal == p.refusal));
            }
        }
        if !self.apart {
            let places = [reference, port].map(|trace| trace.trials.iter().map(place_of_trial));
            let [r, p] = places;
            self.exact(Stage::Extents, r.eq(p));
        }
    }

    fn detection(&mut self, reference: &Trace, r: &DetectionTrace, p: &DetectionTrace) {
        self.exact(Stage::Merge, (r.payload, r.half_words) == (p.payload, p.half_words));
        self.exact(Stage::Accept, r.estimator() == p.estimator());
        if r.estimator() != p.estimator() {
            return;
        }
        if let (Some(fit), Some(other), Some(bounds)) = (&r.fit, &p.fit, self.setting.fit_bounds(r)) {
            if steps(fit) != steps(other) {
                // FIT-15 ties, or even light that only just explains the pixels (ACCEPT-1): fits of different pixels.
                let explained = |fit| bounds::is_barely_explained(fit, &bounds);
                let here = |trial: &&TrialTrace| (trial.format, trial.pixels) == (r.format, r.pixels);
                let trials = || reference.trials.iter().filter(here);
                let tie = trials().any(|trial| self.setting.is_tied(trial))
                    || trials().any(|trial| trial.fits.iter().any(bounds::is_unfinished))
                    || trials().any(|trial| trial.fits.iter().flatten().any(explained));
                self.differs |= tie;
                return self.exact(Stage::FitPixels, tie);
            }
            self.fit((&r.homography, fit), (&p.homography, other), &bounds);
        }
        let (Some(pose), Some(covariance)) = (self.setting.pose_bounds(r), self.setting.pose_covariance_bound(r))
        else {
            return self.exact(Stage::Merge, false);
        };
        self.bounded(Stage::PoseX, r.pose.x - p.pose.x, pose.x);
        self.bounded(Stage::PoseY, r.pose.y - p.pose.y, pose.y);
        self.bounded(Stage::PoseTheta, wrap(r.pose.theta - p.pose.theta), pose.theta);
        self.bounded(Stage::PoseCovariance, relative(&r.covariance, &p.covariance), covariance);
    }

    fn fit(
        &mut self,
        (h, r): (&HomographyTrace, &DetectionFit),
        (g, p): (&HomographyTrace, &DetectionFit),
        bounds: &FitBounds,
    ) {
        self.exact(Stage::FitPixels, r.degrees_of_freedom.to_bits() == p.degrees_of_freedom.to_bits());
        self.bounded(Stage::FitCentre, h.a - g.a, bounds.homography.a);
        self.bounded(Stage::FitHalfWidth, h.s - g.s, bounds.homography.s);
        self.bounded(Stage::FitObliquity, h.k - g.k, bounds.homography.k);
        self.bounded(Stage::FitBlur, r.blur - p.blur, bounds.blur);
        for (one, other) in r.lights.iter().zip(&p.lights) {
            let differences = one.levels.iter().zip(other.levels).map(|(one, other)| (one - other).abs());
            self.bounded(Stage::FitLight, differences.fold(0.0, f64::max), bounds.light);
        }
        let further = if r.steps == p.steps { 0.0 } else { bounds.further_step };
        self.bounded(Stage::FitVariance, (r.variance - p.variance) / r.variance, bounds.variance);
        self.bounded(Stage::FitCovariance, relative(&r.covariance, &p.covariance), bounds.covariance + further);
        self.bounded(Stage::Margin, (r.margin - p.margin) / r.margin, bounds.margin);
    }
}

/// Where a detection is, and how it was read.
fn place(found: &DetectionTrace) -> (Format, Decoder, [(usize, usize); 2]) {
    (found.format, found.decoder, found.pixels)
}

/// Where a fit's light steps.
fn steps(fit: &DetectionFit) -> [Option<usize>; 2] {
    fit.lights.map(|light| light.step)
}

fn place_of_trial(trial: &TrialTrace) -> (Format, Decoder, [(usize, usize); 2]) {
    (trial.format, trial.decoder, trial.pixels)
}

/// The largest difference of two covariances, relative to the standard deviations of the first.
#[must_use]
pub fn relative(one: &Matrix3<f64>, other: &Matrix3<f64>) -> f64 {
    let scale = |i: usize, j: usize| (one[(i, i)] * one[(j, j)]).sqrt();
    let entries = (0..3).flat_map(|i| (0..=i).map(move |j| (i, j)));
    entries.map(|(i, j)| (one[(i, j)] - other[(i, j)]).abs() / scale(i, j)).fold(0.0, f64::max)
}

/// Whether the reference itself decides on a pair as the port did when its first fit starts a little elsewhere (SAME-5): a fit
/// that is far from its end after some steps, as those of what is no barcode mostly are, is led either way by less than it
/// knows.
fn depends_on_start(setting: &Setting, trace: &Trace, trial: &TrialTrace, other: Option<(Decoder, u32)>) -> bool {
    let Some(landmark) = setting.landmark(trial.format) else { return false };
    let lines = [&trace.lines[0].values[..], &trace.lines[1].values[..]];
    let view = View { lines, camera: &setting.cameras.reference, landmark, rule: setting.rule, skew: Skew::at_rest() };
    let pair = trial.pixels.map(|(first, last)| Extent { first, last });
    let layers = [Layer::Upper, Layer::Lower].map(|layer| layer_at(trace, trial, layer));
    let decides = |moves: [f64; 3]| match (trial.decoder, layers) {
        (Decoder::Trellis, _) => {
            let start = moved(&trellis::guard_start(&pair, view.camera), moves);
            depends_on_guards(&pair, &start, &view, other)
        }
        (Decoder::Threshold, [Some(upper), Some(lower)]) => {
            let [upper, lower] =
                [upper, lower].map(|layer| DecodedLayer { homography: moved(&layer.homography, moves), ..layer });
            let mut detections = Vec::new();
            merge(&[upper], &[lower], &view, &mut detections, &mut Silent);
            detections.first().map(|found| (found.decoder, found.payload)) == other
        }
        _ => trial.accepted() == other,
    };
    let ways = (0..27).map(|i: i32| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]);
    let mut moves = ways.map(|ways| ways.map(|way| f64::from(way) * bounds::START));
    moves.any(decides)
}

/// Whether the reference decides on a pair of extents as the port did when its guard fit from here is a little off (SAME-5): by a
/// share of its standard deviations, as fits are.
fn depends_on_guards(pair: &Pair, start: &Homography, view: &View<'_>, other: Option<(Decoder, u32)>) -> bool {
    let Ok(guards) = trellis::guard_fit(pair, start, view) else { return other.is_none() };
    let deviation = |i: usize| guards.covariance[(i, i)].sqrt() * bounds::GUARDS;
    let Imaging { homography: h, blur } = guards.imaging;
    let ways = (0..81).map(|i: i32| [i % 3 - 1, i / 3 % 3 - 1, i / 9 % 3 - 1, i / 27 - 1].map(f64::from));
    let mut moved = ways.map(|[a, s, k, b]| Imaging {
        homography: Homography { a: h.a + a * deviation(0), s: h.s + s * deviation(1), k: h.k + k * deviation(2) },
        blur: blur + b * guards.blur_variance.sqrt() * bounds::GUARDS,
    });
    moved.any(|imaging| {
        let mut detections = Vec::new();
        let settled = trellis::decode_after(pair, &imaging, &guards.lights, view, &mut Silent);
        conclude_settled(pair, settled, view, &mut detections, &mut Silent);
        detections.first().map(|found| (found.decoder, found.payload)) == other
    })
}

/// A homography with its `a` and `s` moved, and its `k` by as many pixels at the barcode's ends.
fn moved(h: &Homography, [a, s, k]: [f64; 3]) -> Homography {
    Homography { a: h.a + a, s: h.s + s, k: h.k + k / h.s }
}

/// The layer of a trial as the reference has decoded it.
fn layer_at(trace: &Trace, trial: &TrialTrace, layer: Layer) -> Option<DecodedLayer> {
    let pixels = trial.pixels[usize::from(layer == Layer::Lower)];
    let here = |roi: &&HypothesisTrace| (roi.layer, roi.format, roi.pixels) == (layer, trial.format, pixels);
    trace.hypotheses.iter().filter(here).find_map(|roi| {
        let Outcome::Decoded { half_word, homography: HomographyTrace { a, s, k } } = roi.outcome else { return None };
        let hypothesis = Hypothesis {
            first_region: roi.regions.0,
            last_region: roi.regions.1,
            first_pixel: pixels.0,
            last_pixel: pixels.1,
        };
        Some(DecodedLayer { thresholding: roi.thresholding, hypothesis, half_word, homography: Homography { a, s, k } })
    })
}

/// Whether the decision on a pair might have been another one by the bounds of what it was decided on (SAME-5): whether
/// something that was asked is that near to its limit, and nothing fails by more.
//= reference/SPEC.md#same
//# - **SAME-5** The decisions of FIT, TRELLIS and ACCEPT MUST lead to the same detections unless the reference's own
//# margin is below the bound of what it decides on, or the reference itself decides otherwise when its first fit begins
//# up to 1/20 px away and its guard fit ends up to 1/20 of its standard deviations away.
fn is_marginal(setting: &Setting, trial: &TrialTrace) -> bool {
    let margin = trial.tests.iter().find(|test| test.refusal == CandidateRefusal::Margin);
    // The tests after the fits are of the last one that was not refused.
    let fit = margin.and_then(|margin| {
        let fit = trial.fits.iter().flatten().last()?;
        Some(bounds::fit(&setting.cameras, trial.format, &fit.with_margin(margin.limit), &fit.homography))
    });
    let tests = || trial.tests.iter().map(|test| (test.slack(), bounds::test(test, fit.as_ref())));
    let tie = trial.accepted().is_some() && setting.is_tied(trial);
    let near = tie || tests().any(|(slack, bound)| slack.abs() <= bound);
    let fails = tests().any(|(slack, bound)| slack < -bound);
    near && !fails
}
/// Whether two ROIs ended in the same way; the bounded part of it, the homography, is compared elsewhere.
fn same_end(one: &Outcome, other: &Outcome) -> bool {
    match (one, other) {
        (Outcome::Refused(one), Outcome::Refused(other)) => one == other,
        (Outcome::Open, Outcome::Open) | (Outcome::Decoded { .. }, Outcome::Decoded { .. }) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disturb::Disturbance;
    use crate::scenes::Scenes;
    use crate::tally::Part;
    use crate::trace::ResidualTrace;
    use reference::camera::Camera;
    use reference::observer::Layer;
    use reference::refusal::{HypothesisRefusal, LineRefusal, PairRefusal};
    use reference::threshold::Thresholding;

    const FRAME: Frame = Frame { part: Part::Lines, index: 0 };

    fn setting() -> Setting {
        let cameras = Cameras::new(Camera::epuck()).unwrap();
        Setting { cameras, landmarks: Landmarks::both(), rule: CrossingRule::Interpolated }
    }

    /// Both traces of an ideal landmark with stripes of 4 px at pixel 100, beside a bar that is too few.
    fn traces() -> [Trace; 2] {
        let lines = reference::codeword::layers(Format::Paper, 0xcc0d).unwrap().map(|stripes| {
            let mut line = vec![255_u8; 480];
            for (j, _) in stripes.iter().enumerate().filter(|(_, bar)| **bar) {
                line[100 + 4 * j..104 + 4 * j].fill(0);
            }
            line[400..403].fill(0);
            line
        });
        setting().run(&lines[0], &lines[1])
    }

    fn tally_of(change: impl FnOnce(&mut Trace, &mut Trace)) -> Tally {
        let [mut reference, mut port] = traces();
        change(&mut reference, &mut port);
        let mut tally = Tally::default();
        compare(&setting(), FRAME, &reference, &port, &mut tally);
        tally
    }

    fn failing(change: impl FnOnce(&mut Trace)) -> Vec<Stage> {
        tally_of(|_, port| change(port)).failing()
    }

    /// The decoded ROI of the upper line.
    fn decoded(trace: &mut Trace) -> &mut HypothesisTrace {
        trace.hypotheses.iter_mut().find(|roi| matches!(roi.outcome, Outcome::Decoded { .. })).unwrap()
    }

    /// Random scenes: every stage has something in one of them.
    fn scenes() -> Vec<[Trace; 2]> {
        let (setting, scenes) = (setting(), Scenes::new(1));
        let camera = &setting.cameras.reference;
        let traces = |index| {
            let [upper, lower] = scenes.scene(camera, index).staged.render(camera);
            setting.run(&upper, &lower)
        };
        (0..60).map(traces).collect()
    }

    #[test]
    fn what_both_do_passes_every_stage() {
        let mut tally = Tally::default();
        for [reference, port] in scenes() {
            compare(&setting(), FRAME, &reference, &port, &mut tally);
        }
        assert!(tally.passes());
        assert_eq!((tally.frames, tally.differing_frames), (60, 0));
    }

    #[test]
    fn every_disturbance_is_named() {
        let scenes = scenes();
        for disturbance in Disturbance::ALL {
            let mut tally = Tally::default();
            let disturbed = scenes.iter().any(|[reference, port]| {
                let mut port = port.clone();
                let applied = disturbance.apply(&setting(), 1.02, reference, &mut port);
                compare(&setting(), FRAME, reference, &port, &mut tally);
                applied
            });
            assert!(disturbed, "{disturbance:?} had nothing to change");
            assert_eq!(tally.failing(), [disturbance.stage()], "{disturbance:?}");
        }
    }

    #[test]
    fn what_one_side_leaves_out_is_not_the_same() {
        let refusal =
            |thresholding| failing(|port| port.lines[0].refusals.push((thresholding, LineRefusal::TooManyRegions)));
        assert_eq!(refusal(Thresholding::Global), [Stage::Regions]);
        assert_eq!(refusal(Thresholding::Local), [Stage::Regions]);
        assert_eq!(failing(|port| drop(port.lines[1].regions.pop())), [Stage::Regions]);
        assert_eq!(failing(|port| port.lines[1].regions.reverse()), [Stage::Regions]);
        assert_eq!(failing(|port| decoded(port).thresholding = Thresholding::Local), [Stage::Hypotheses]);
        assert_eq!(failing(|port| port.detections[0].decoder = Decoder::Trellis), [Stage::Merge]);
        assert_eq!(failing(|port| drop(port.hypotheses.pop())), [Stage::Hypotheses]);
        assert_eq!(failing(|port| port.hypotheses[0].regions.1 += 2), [Stage::Hypotheses]);
        assert_eq!(failing(|port| decoded(port).samples.truncate(19)), [Stage::Sampling]);
        assert_eq!(failing(|port| decoded(port).residual = None), [Stage::Sampling]);
        assert_eq!(failing(|port| decoded(port).crossings.truncate(8)), [Stage::Crossings]);
        let crowded = (Layer::Upper, Thresholding::Local, LineRefusal::TooManyLayers);
        assert_eq!(failing(|port| port.crowded.push(crowded)), [Stage::Merge]);
        assert_eq!(failing(|port| port.ambiguous.push((Format::Wide, 1))), [Stage::Merge]);
        assert_eq!(failing(|port| port.heard_is_returned = false), [Stage::Merge]);
        let pair = PairTrace {
            format: Format::Paper,
            decoder: Decoder::Threshold,
            first_pixels: (1, 1),
            result: Err(PairRefusal::Crc),
        };
        assert_eq!(failing(|port| port.pairs.push(pair)), [Stage::Merge]);
    }

    #[test]
    fn a_residual_is_compared() {
        let shift = |by: f64| {
            failing(|port| {
                let residual = decoded(port).residual.as_mut().unwrap();
                residual.difference += by;
            })
        };
        assert_eq!(shift(0.9 * DECLARED_ERROR), []);
        assert_eq!(shift(1.1 * DECLARED_ERROR), [Stage::Sampling]);
    }

    #[test]
    fn another_reason_is_another_result() {
        let checked = |port: &mut Trace| {
            let roi = port.hypotheses.iter_mut().find(|roi| roi.samples.is_empty()).unwrap();
            assert_eq!(roi.outcome, Outcome::Refused(HypothesisRefusal::TooFewBars));
            roi.outcome = Outcome::Refused(HypothesisRefusal::CutOff);
        };
        assert_eq!(failing(checked), [Stage::Hypotheses]);
    }

    /// SAME-6: after a fit either pipeline may say another reason, before it neither.
    //= reference/SPEC.md#same
    //= type=test
    //# - **SAME-6** Why a candidate was refused by FIT, TRELLIS or ACCEPT MUST be reported, and is compared only where
    //# no fit came before it.
    #[test]
    fn why_a_candidate_was_refused_is_compared_where_no_fit_came_before() {
        let (mut before, mut after) = (0, 0);
        for [reference, mut port] in scenes() {
            for i in 0..port.trials.len() {
                let trial = port.trials[i].clone();
                let Some((decoder, refusal)) = trial.refusal else { continue };
                let other = [CandidateRefusal::Oblique, CandidateRefusal::Blur].into_iter().find(|one| *one != refusal);
                port.trials[i].refusal = other.map(|other| (decoder, other));
                let mut tally = Tally::default();
                compare(&setting(), FRAME, &reference, &port, &mut tally);
                let compared = trial.fits.is_empty();
                let (expected, count) =
                    if compared { (vec![Stage::Accept], &mut before) } else { (vec![], &mut after) };
                assert_eq!(tally.failing(), expected, "{trial:?}");
                *count += 1;
                port.trials[i] = trial;
            }
        }
        assert!(before > 0 && after > 0, "{before} {after}");
    }

    /// A decision may differ where the reference's margin is below its declared error, and is counted there.
    #[test]
    fn only_a_marginal_decision_may_differ() {
        let end = |margin: f64, note: fn(&mut HypothesisTrace, f64)| {
            tally_of(|reference, port| {
                note(decoded(reference), margin);
                decoded(port).outcome = Outcome::Refused(HypothesisRefusal::Residual);
            })
        };
        let notes: [fn(&mut HypothesisTrace, f64); 2] = [
            |roi, margin| roi.plausibility_margin = margin,
            |roi, margin| {
                let difference = roi.residual.unwrap().difference;
                roi.residual = Some(ResidualTrace { difference, margin });
            },
        ];
        for note in notes {
            let marginal = end(0.0, note);
            assert_eq!(marginal.failing(), []);
            assert_eq!((marginal.marginal_frames, marginal.differing_frames), (1, 1));
            assert_eq!(marginal.stage(Stage::Sampling).marginal, 1);
            let clear = end(2.0 * DECLARED_ERROR, note);
            assert_eq!(clear.failing(), [Stage::Sampling]);
            assert_eq!((clear.marginal_frames, clear.differing_frames), (0, 0));
        }
    }

    //= reference/SPEC.md#same
    //= type=test
    //# - **SAME-4** A frame with a margin below that error MUST be counted as marginal, whether the pipelines differ or
    //# not.
    #[test]
    fn a_marginal_sample_is_counted_whether_it_differs_or_not() {
        for (differs, region) in [(0, Some(1)), (1, None)] {
            let tally = tally_of(|reference, port| {
                decoded(reference).samples[0].margin = 0.0;
                decoded(port).samples[0].region = region;
            });
            assert_eq!(tally.failing(), []);
            assert_eq!((tally.marginal_frames, tally.differing_frames), (1, differs));
        }
    }
}
