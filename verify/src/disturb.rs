//! Disturbances of the port's results, each slightly beyond a bound, to show that the comparison notices.

use crate::bounds::{DECLARED_ERROR, Stage};
use crate::lockstep::Setting;
use crate::trace::{Outcome, Trace, TrialTrace};
use reference::merge::Decoder;
use reference::refusal::{CandidateRefusal, HypothesisRefusal};

/// A change to the port's trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// The darkest value is one grey level off.
    Threshold,
    /// A region begins one pixel later.
    Regions,
    /// An ROI ends one pixel later.
    Hypotheses,
    /// A crossing is one unit off.
    Crossings,
    /// A stripe's middle is off by more than the reference's declared error.
    Middle,
    /// A stripe falls in another region although the reference's margin is not small.
    Decision,
    /// An ROI is refused that the reference decodes.
    Refusal,
    /// The largest difference of residuals is off by more than the reference's declared error.
    Residual,
    /// `a` is off by more than its bound.
    Centre,
    /// `s` is off by more than its bound.
    HalfWidth,
    /// `k` is off by more than its bound.
    Obliquity,
    /// A code bit is wrong.
    Decode,
    /// A detection's payload is wrong.
    Payload,
    /// A detection is missing.
    Missing,
    /// x is off by more than its bound.
    PoseX,
    /// y is off by more than its bound.
    PoseY,
    /// The heading is off by more than its bound.
    PoseTheta,
    /// A pair of extents ends one pixel later.
    Extents,
    /// A fit has one degree of freedom more.
    FitPixels,
    /// `a` of a fit is off by more than its bound.
    FitCentre,
    /// `s` of a fit is off by more than its bound.
    FitHalfWidth,
    /// `k` of a fit is off by more than its bound.
    FitObliquity,
    /// The blur is off by more than its bound.
    FitBlur,
    /// An offset is off by more than its bound.
    FitLight,
    /// `s²` is off by more than its bound.
    FitVariance,
    /// The covariance of `(a, s, k)` is off by more than its bound.
    FitCovariance,
    /// The decision margin is off by more than its bound.
    Margin,
    /// A detection has no fit.
    Estimator,
    /// The covariance of a pose is off by more than its bound.
    PoseCovariance,
    /// What this decoder read is refused although the reference accepts it.
    Rejected(Decoder),
    /// What this decoder read is accepted although the reference refuses it.
    Extra(Decoder),
}

impl Disturbance {
    /// All of them.
    pub const ALL: [Self; 33] = [
        Self::Threshold,
        Self::Regions,
        Self::Hypotheses,
        Self::Crossings,
        Self::Middle,
        Self::Decision,
        Self::Refusal,
        Self::Residual,
        Self::Centre,
        Self::HalfWidth,
        Self::Obliquity,
        Self::Decode,
        Self::Payload,
        Self::Missing,
        Self::PoseX,
        Self::PoseY,
        Self::PoseTheta,
        Self::Extents,
        Self::FitPixels,
        Self::FitCentre,
        Self::FitHalfWidth,
        Self::FitObliquity,
        Self::FitBlur,
        Self::FitLight,
        Self::FitVariance,
        Self::FitCovariance,
        Self::Margin,
        Self::Rejected(Decoder::Threshold),
        Self::Rejected(Decoder::Trellis),
        Self::Extra(Decoder::Threshold),
        Self::Extra(Decoder::Trellis),
        Self::Estimator,
        Self::PoseCovariance,
    ];

    /// The stage whose result it changes.
    #[must_use]
    pub fn stage(self) -> Stage {
        match self {
            Self::Threshold => Stage::Threshold,
            Self::Regions => Stage::Regions,
            Self::Hypotheses => Stage::Hypotheses,
            Self::Crossings => Stage::Crossings,
            Self::Middle | Self::Decision | Self::Refusal | Self::Residual => Stage::Sampling,
            Self::Centre => Stage::Centre,
            Self::HalfWidth => Stage::HalfWidth,
            Self::Obliquity => Stage::Obliquity,
            Self::Decode => Stage::Decode,
            Self::Payload | Self::Missing => Stage::Merge,
            Self::PoseX => Stage::PoseX,
            Self::PoseY => Stage::PoseY,
            Self::PoseTheta => Stage::PoseTheta,
            Self::Extents => Stage::Extents,
            Self::FitPixels => Stage::FitPixels,
            Self::FitCentre => Stage::FitCentre,
            Self::FitHalfWidth => Stage::FitHalfWidth,
            Self::FitObliquity => Stage::FitObliquity,
            Self::FitBlur => Stage::FitBlur,
            Self::FitLight => Stage::FitLight,
            Self::FitVariance => Stage::FitVariance,
            Self::FitCovariance => Stage::FitCovariance,
            Self::Margin => Stage::Margin,
            Self::PoseCovariance => Stage::PoseCovariance,
            Self::Rejected(_) | Self::Extra(_) | Self::Estimator => Stage::Accept,
        }
    }

    /// What it does, in words.
    #[must_use]
    pub fn describe(self) -> &'static str {
        match self {
            Self::Threshold => "darkest value + 1",
            Self::Regions => "a region begins 1 px later",
            Self::Hypotheses => "an ROI ends 1 px later",
            Self::Crossings => "a crossing + 1 unit",
            Self::Middle => "a stripe's middle beyond the bound",
            Self::Decision => "a stripe in another region, outside the margin",
            Self::Refusal => "a decoded ROI refused",
            Self::Residual => "a difference of residuals beyond the bound",
            Self::Centre => "centre beyond the bound",
            Self::HalfWidth => "half width beyond the bound",
            Self::Obliquity => "obliquity beyond the bound",
            Self::Decode => "a code bit flipped",
            Self::Payload => "a payload bit flipped",
            Self::Missing => "a detection left out",
            Self::PoseX => "x beyond the bound",
            Self::PoseY => "y beyond the bound",
            Self::PoseTheta => "heading beyond the bound",
            Self::Extents => "a pair of extents 1 px wider",
            Self::FitPixels => "a fit of one pixel more",
            Self::FitCentre => "a fit's centre beyond the bound",
            Self::FitHalfWidth => "a fit's half width beyond the bound",
            Self::FitObliquity => "a fit's obliquity beyond the bound",
            Self::FitBlur => "a fit's blur beyond the bound",
            Self::FitLight => "a fit's offset beyond the bound",
            Self::FitVariance => "a fit's variance beyond the bound",
            Self::FitCovariance => "a fit's covariance beyond the bound",
            Self::Margin => "a decision margin beyond the bound",
            Self::Rejected(Decoder::Threshold) => "a candidate of the threshold refused",
            Self::Rejected(Decoder::Trellis) => "a candidate of the trellis refused",
            Self::Extra(Decoder::Threshold) => "a candidate of the threshold accepted",
            Self::Extra(Decoder::Trellis) => "a candidate of the trellis accepted",
            Self::Estimator => "the paper's estimate instead of a fit",
            Self::PoseCovariance => "a pose's covariance beyond the bound",
        }
    }

    /// Whether the disturbance is a multiple of a bound, so that one within the bound must pass.
    #[must_use]
    pub fn is_scaled(self) -> bool {
        use Disturbance as D;
        let before = matches!(
            self,
            D::Middle | D::Residual | D::Centre | D::HalfWidth | D::Obliquity | D::PoseX | D::PoseY | D::PoseTheta
        );
        let fitted = matches!(self, D::FitCentre | D::FitHalfWidth | D::FitObliquity | D::FitBlur | D::FitLight);
        before || fitted || matches!(self, D::FitVariance | D::FitCovariance | D::Margin | D::PoseCovariance)
    }

    /// Changes the port's trace where it can; a scaled disturbance puts the result at `share` times the bound from the
    /// reference's. False if the frame has nothing to change.
    pub fn apply(self, setting: &Setting, share: f64, reference: &Trace, port: &mut Trace) -> bool {
        match self {
            Self::Threshold => change(port.lines.iter_mut().find_map(|line| line.threshold.as_mut()), |threshold| {
                threshold.0 = threshold.0.wrapping_add(1);
            }),
            Self::Regions => {
                let mut regions = port.lines.iter_mut().flat_map(|line| &mut line.regions);
                change(regions.find_map(|regions| regions.firsts.get_mut(1)), |first| *first += 1)
            }
            Self::Hypotheses => change(port.hypotheses.first_mut(), |roi| roi.pixels.1 += 1),
            Self::Crossings => {
                let roi = port.hypotheses.iter_mut().find(|roi| !roi.crossings.is_empty());
                change(roi, |roi| roi.crossings[0].1 += 1)
            }
            Self::Middle | Self::Decision | Self::Refusal | Self::Residual => {
                self.apply_to_sampling(share, reference, port)
            }
            Self::Centre | Self::HalfWidth | Self::Obliquity | Self::Decode => {
                self.apply_to_layer(setting, share, reference, port)
            }
            Self::Payload => change(port.detections.first_mut(), |found| found.payload ^= 1),
            Self::Missing => port.detections.pop().is_some(),
            Self::PoseX | Self::PoseY | Self::PoseTheta | Self::PoseCovariance => {
                self.apply_to_pose(setting, share, reference, port)
            }
            Self::Extents => {
                let tried = |trial: &&mut TrialTrace| trial.decoder == Decoder::Trellis && trial.accepted().is_none();
                change(port.trials.iter_mut().find(tried), |trial| trial.pixels[1].1 += 1)
            }
            Self::Rejected(decoder) => {
                let accepted = |trial: &&mut TrialTrace| trial.accepted().is_some_and(|(by, _)| by == decoder);
                change(port.trials.iter_mut().find(accepted), |trial| {
                    trial.refusal = Some((decoder, CandidateRefusal::Margin));
                })
            }
            Self::Extra(decoder) => {
                let refused = |trial: &&mut TrialTrace| trial.decoder == decoder && trial.accepted().is_none();
                change(port.trials.iter_mut().find(refused), |trial| {
                    trial.refusal = None;
                    trial.readings.push((decoder, Ok(0)));
                })
            }
            Self::Estimator => change(port.detections.iter_mut().find(|found| found.fit.is_some()), |found| {
                found.fit = None;
            }),
            _ => self.apply_to_fit(setting, share, reference, port),
        }
    }

    fn apply_to_sampling(self, share: f64, reference: &Trace, port: &mut Trace) -> bool {
        let mut both = reference.hypotheses.iter().zip(&mut port.hypotheses);
        match self {
            Self::Refusal => change(both.find(|(_, p)| matches!(p.outcome, Outcome::Decoded { .. })), |(_, p)| {
                p.outcome = Outcome::Refused(HypothesisRefusal::Residual);
            }),
            Self::Residual => {
                let residuals = both.find_map(|(r, p)| Some((r.residual?, p.residual.as_mut()?)));
                change(residuals, |(r, p)| p.difference = r.difference + share * DECLARED_ERROR)
            }
            Self::Decision => {
                change(both.find(|(r, _)| r.samples.iter().any(|sample| sample.margin > DECLARED_ERROR)), |(r, p)| {
                    let sample = r.samples.iter().zip(&mut p.samples).find(|(r, _)| r.margin > DECLARED_ERROR);
                    change(sample, |(_, p)| p.region = p.region.map_or(Some(0), |region| Some(region + 1)));
                })
            }
            _ => change(both.find(|(r, _)| !r.samples.is_empty()), |(r, p)| {
                p.samples[0].middle = r.samples[0].middle + share * DECLARED_ERROR;
            }),
        }
    }

    fn apply_to_layer(self, setting: &Setting, share: f64, reference: &Trace, port: &mut Trace) -> bool {
        for (r, p) in reference.hypotheses.iter().zip(&mut port.hypotheses) {
            let (
                Outcome::Decoded { homography, .. },
                Outcome::Decoded { half_word: port_word, homography: port_homography },
            ) = (&r.outcome, &mut p.outcome)
            else {
                continue;
            };
            let bound = setting.homography_bounds(r, homography);
            match self {
                Self::Centre => port_homography.a = homography.a + share * bound.a,
                Self::HalfWidth => port_homography.s = homography.s + share * bound.s,
                Self::Obliquity => port_homography.k = homography.k + share * bound.k,
                _ => *port_word ^= 1,
            }
            return true;
        }
        false
    }

    fn apply_to_fit(self, setting: &Setting, share: f64, reference: &Trace, port: &mut Trace) -> bool {
        let both = reference.detections.iter().zip(&mut port.detections);
        let fitted = both.into_iter().find_map(|(r, p)| {
            let bounds = setting.fit_bounds(r)?;
            Some((r.homography, r.fit?, bounds, &mut p.homography, p.fit.as_mut()?))
        });
        change(fitted, |(h, fit, bounds, homography, p)| match self {
            Self::FitPixels => p.degrees_of_freedom += 1.0,
            Self::FitCentre => homography.a = h.a + share * bounds.homography.a,
            Self::FitHalfWidth => homography.s = h.s + share * bounds.homography.s,
            Self::FitObliquity => homography.k = h.k + share * bounds.homography.k,
            Self::FitBlur => p.blur = fit.blur + share * bounds.blur,
            Self::FitLight => p.lights[0].levels[0] = fit.lights[0].levels[0] + share * bounds.light,
            Self::FitVariance => p.variance = fit.variance * (1.0 + share * bounds.variance),
            Self::FitCovariance => p.covariance[(0, 0)] = fit.covariance[(0, 0)] * (1.0 + share * bounds.covariance),
            _ => p.margin = fit.margin * (1.0 + share * bounds.margin),
        })
    }

    fn apply_to_pose(self, setting: &Setting, share: f64, reference: &Trace, port: &mut Trace) -> bool {
        let (Some(r), Some(p)) = (reference.detections.first(), port.detections.first_mut()) else { return false };
        if self == Self::PoseCovariance {
            return change(setting.pose_covariance_bound(r), |bound| {
                p.covariance[(1, 1)] = r.covariance[(1, 1)] * (1.0 + share * bound);
            });
        }
        change(setting.pose_bounds(r), |bound| match self {
            Self::PoseX => p.pose.x = r.pose.x + share * bound.x,
            Self::PoseY => p.pose.y = r.pose.y + share * bound.y,
            _ => p.pose.theta = r.pose.theta + share * bound.theta,
        })
    }
}

/// Changes what is there; false if there is nothing.
fn change<T>(target: Option<T>, how: impl FnOnce(T)) -> bool {
    target.map(how).is_some()
}
