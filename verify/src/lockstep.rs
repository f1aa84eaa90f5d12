//! Both pipelines on one frame, compared stage by stage (SAME).

use crate::bounds::{self, DECLARED_ERROR, Stage};
use crate::port::{Cameras, Landmarks, port_rule};
use crate::record_fixedpoint::{self, RecordFixedpoint};
use crate::record_reference::{self, RecordReference};
use crate::tally::{Frame, Tally};
use crate::trace::{DetectionTrace, HomographyTrace, HypothesisTrace, Outcome, PoseTrace, SampleTrace, Trace};
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
        // What counts is what the caller is given; the observer must have heard the same.
        let heard = std::mem::replace(
            &mut record.trace.detections,
            returned.iter().map(record_reference::detection_trace).collect(),
        );
        record.trace.heard_is_returned = heard == record.trace.detections;
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
        let heard = std::mem::replace(
            &mut record.trace.detections,
            returned.iter().map(record_fixedpoint::detection_trace).collect(),
        );
        record.trace.heard_is_returned = heard == record.trace.detections;
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

    /// Bounds on a detection's pose.
    #[must_use]
    pub fn pose_bounds(&self, detection: &DetectionTrace) -> Option<PoseTrace> {
        let landmark = self.landmark(detection.format)?;
        Some(bounds::pose_of_detection(&self.cameras, landmark, &detection.homography))
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
        self.exact(Stage::Merge, reference.pairs == port.pairs);
        self.exact(Stage::Merge, reference.ambiguous == port.ambiguous);
        let found = |d: &DetectionTrace| (d.format, d.payload, d.half_words);
        let same = reference.detections.iter().map(found).eq(port.detections.iter().map(found));
        self.exact(Stage::Merge, same);
        self.exact(Stage::Merge, reference.heard_is_returned && port.heard_is_returned);
        for (r, p) in reference.detections.iter().zip(&port.detections) {
            let Some(bound) = self.setting.pose_bounds(r) else {
                self.exact(Stage::Merge, false);
                continue;
            };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disturb::Disturbance;
    use crate::tally::Part;
    use crate::trace::{PairTrace, ResidualTrace};
    use reference::camera::Camera;
    use reference::observer::Layer;
    use reference::refusal::{HypothesisRefusal, LineRefusal, PairRefusal};

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

    #[test]
    fn equal_traces_pass_every_stage() {
        let tally = tally_of(|_, _| ());
        assert!(tally.passes());
        assert_eq!((tally.frames, tally.marginal_frames, tally.differing_frames), (1, 0, 0));
    }

    #[test]
    fn every_disturbance_is_named() {
        for disturbance in Disturbance::ALL {
            let tally = tally_of(|reference, port| {
                assert!(disturbance.apply(&setting(), 1.02, reference, port), "{disturbance:?} had nothing to change");
            });
            assert_eq!(tally.failing(), [disturbance.stage()], "{disturbance:?}");
        }
    }

    #[test]
    fn what_one_side_leaves_out_is_not_the_same() {
        assert_eq!(failing(|port| port.lines[0].refusal = Some(LineRefusal::LowContrast)), [Stage::Regions]);
        assert_eq!(failing(|port| drop(port.hypotheses.pop())), [Stage::Hypotheses]);
        assert_eq!(failing(|port| port.hypotheses[0].regions.1 += 2), [Stage::Hypotheses]);
        assert_eq!(failing(|port| decoded(port).samples.truncate(19)), [Stage::Sampling]);
        assert_eq!(failing(|port| decoded(port).residual = None), [Stage::Sampling]);
        assert_eq!(failing(|port| decoded(port).crossings.truncate(8)), [Stage::Crossings]);
        assert_eq!(failing(|port| port.crowded.push((Layer::Upper, LineRefusal::TooManyLayers))), [Stage::Merge]);
        assert_eq!(failing(|port| port.ambiguous.push((Format::Wide, 1))), [Stage::Merge]);
        assert_eq!(failing(|port| port.heard_is_returned = false), [Stage::Merge]);
        let pair = PairTrace { format: Format::Paper, first_pixels: (1, 1), result: Err(PairRefusal::Crc) };
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
