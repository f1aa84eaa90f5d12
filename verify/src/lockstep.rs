//! Both pipelines on one frame, compared stage by stage (SAME).

use crate::bounds::{self, DECLARED_ERROR, Stage};
use crate::port::{Cameras, Landmarks, port_rule};
use crate::record_fixedpoint::RecordFixedpoint;
use crate::record_reference::RecordReference;
use crate::tally::{Frame, Tally};
use crate::trace::{DetectionTrace, HomographyTrace, HypothesisTrace, Outcome, SampleTrace, Trace};
use fixedpoint::detect::Workspace;
use reference::crossing::CrossingRule;
use reference::frame::wrap;
use reference::landmark::{Format, Landmark};

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
        debug_assert_eq!(returned.len(), record.trace.detections.len());
        record.trace
    }

    /// The port's trace.
    #[must_use]
    pub fn run_fixedpoint(&self, upper: &[u8], lower: &[u8]) -> Trace {
        let mut record = RecordFixedpoint::default();
        let (camera, landmarks) = (&self.cameras.port, &self.landmarks.port);
        let mut workspace = Workspace::new();
        let rule = port_rule(self.rule);
        let returned = fixedpoint::detect::detect(upper, lower, camera, landmarks, rule, &mut workspace, &mut record);
        debug_assert_eq!(returned.len(), record.trace.detections.len());
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

    /// Bounds on a detection's pose. The shift of either layer is at most half the line.
    #[must_use]
    pub fn pose_bounds(&self, detection: &DetectionTrace) -> Option<crate::trace::PoseTrace> {
        let landmark = self.landmark(detection.format)?;
        // The barcode's centre is imaged at most half an extent from the ROI's middle.
        let h = &detection.homography;
        let layer = bounds::homography(&self.cameras, h.a.abs() + h.s.abs() / 2.0, h.k);
        Some(bounds::pose(&self.cameras, landmark, h, &bounds::merged(&layer, &layer)))
    }
}

/// Compares the traces of one frame and adds what was seen to the tally.
pub fn compare(setting: &Setting, frame: Frame, reference: &Trace, port: &Trace, tally: &mut Tally) {
    let mut comparison = Comparison { setting, frame, tally, marginal: false, differs: false };
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
            self.exact(Stage::Regions, r.regions == p.regions && r.refusal == p.refusal);
        }
    }

    fn hypotheses(&mut self, reference: &Trace, port: &Trace) {
        for (r, p) in reference.hypotheses.iter().zip(&port.hypotheses) {
            let place = |h: &HypothesisTrace| (h.layer, h.format, h.regions, h.pixels);
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
        self.exact(Stage::Merge, reference.pairs == port.pairs);
        self.exact(Stage::Merge, reference.ambiguous == port.ambiguous);
        let found = |d: &DetectionTrace| (d.format, d.payload, d.half_words);
        let same = reference.detections.iter().map(found).eq(port.detections.iter().map(found));
        self.exact(Stage::Merge, same);
        for (r, p) in reference.detections.iter().zip(&port.detections) {
            let Some(bound) = self.setting.pose_bounds(r) else { continue };
            self.bounded(Stage::PoseX, r.pose.x - p.pose.x, bound.x);
            self.bounded(Stage::PoseY, r.pose.y - p.pose.y, bound.y);
            self.bounded(Stage::PoseTheta, wrap(r.pose.theta - p.pose.theta), bound.theta);
        }
    }
}

/// Whether two ROIs ended in the same way; the bounded part of it, the homography, is compared elsewhere.
fn same_end(one: &Outcome, other: &Outcome) -> bool {
    match (one, other) {
        (Outcome::Refused(one), Outcome::Refused(other)) => one == other,
        (Outcome::Open, Outcome::Open) | (Outcome::Decoded { .. }, Outcome::Decoded { .. }) => true,
        _ => false,
    }
}
