//! The detector: all stages from two scan lines to camera poses (LINE).

use crate::camera::Camera;
use crate::crossing::CrossingRule;
use crate::decode::{DecodedLayer, MAX_LAYERS, decode};
use crate::hypotheses::{Hypothesis, check, hypotheses};
use crate::landmark::{Format, Landmark};
use crate::merge::{Detection, contradict, merge, pairs};
use crate::observer::{Layer, Observer};
use crate::pose::pose;
use crate::refusal::{HypothesisRefusal, LineRefusal};
use crate::regions::{Region, regions};
use crate::sampling::{Roi, sample};
use crate::threshold::{Threshold, threshold};

/// A line whose first two stages succeeded.
struct Segmented<'a> {
    layer: Layer,
    line: &'a [u8],
    threshold: Threshold,
    regions: Vec<Region>,
}

/// What does not change within a call.
struct Search<'a> {
    camera: &'a Camera,
    rule: CrossingRule,
}

/// The landmarks in two scan lines, looked for in the formats of `landmarks` (LINE-1 to LINE-4, MERGE-8). A format that
/// is asked for again is ignored.
pub fn detect<O: Observer>(
    upper: &[u8],
    lower: &[u8],
    camera: &Camera,
    landmarks: &[Landmark],
    rule: CrossingRule,
    observer: &mut O,
) -> Vec<Detection> {
    let search = Search { camera, rule };
    let upper = segment(Layer::Upper, upper, camera, observer);
    let lower = segment(Layer::Lower, lower, camera, observer);
    let mut found = Vec::new();
    let mut asked: Vec<Format> = Vec::new();
    for landmark in landmarks {
        if !asked.contains(&landmark.format) {
            asked.push(landmark.format);
            let layers = [&upper, &lower].map(|line| search.layers(line.as_ref(), landmark.format, observer));
            search.merge(&layers, landmark, &mut found, observer);
        }
    }
    without_ambiguous(&found, observer)
}

fn segment<'a, O: Observer>(layer: Layer, line: &'a [u8], camera: &Camera, observer: &mut O) -> Option<Segmented<'a>> {
    let found = try_segment(layer, line, camera, observer);
    found.map_err(|refusal| observer.line_refused(layer, refusal)).ok()
}

fn try_segment<'a, O: Observer>(
    layer: Layer,
    line: &'a [u8],
    camera: &Camera,
    observer: &mut O,
) -> Result<Segmented<'a>, LineRefusal> {
    if line.len() != camera.width {
        return Err(LineRefusal::Width);
    }
    let threshold = threshold(line)?;
    observer.threshold(layer, &threshold);
    let regions = regions(line, &threshold)?;
    observer.regions(layer, &regions);
    Ok(Segmented { layer, line, threshold, regions })
}

impl Search<'_> {
    /// All decoded ROIs of a line in one format (DECODE-2, MERGE-6).
    fn layers<O: Observer>(&self, line: Option<&Segmented<'_>>, format: Format, observer: &mut O) -> Vec<DecodedLayer> {
        let Some(line) = line else { return Vec::new() };
        let mut layers = Vec::new();
        for hypothesis in hypotheses(&line.regions, format) {
            observer.hypothesis(line.layer, format, &hypothesis);
            match self.layer(line, &hypothesis, format, observer) {
                Err(refusal) => observer.refused(refusal),
                Ok(_) if layers.len() == MAX_LAYERS => {
                    observer.line_refused(line.layer, LineRefusal::TooManyLayers);
                    return Vec::new();
                }
                Ok(layer) => {
                    observer.decoded(&layer);
                    layers.push(layer);
                }
            }
        }
        layers
    }

    fn layer<O: Observer>(
        &self,
        line: &Segmented<'_>,
        hypothesis: &Hypothesis,
        format: Format,
        observer: &mut O,
    ) -> Result<DecodedLayer, HypothesisRefusal> {
        check(hypothesis, &line.regions, format)?;
        let Segmented { line, threshold, regions, .. } = line;
        let roi = Roi { line, threshold, regions, hypothesis, format, rule: self.rule };
        let stripes = sample(&roi, observer)?;
        let homography = stripes.homography.shifted(hypothesis.middle() - self.camera.principal_column);
        Ok(DecodedLayer { hypothesis: *hypothesis, half_word: decode(format, &stripes.colours), homography })
    }

    /// Detections of all pairs of layers (MERGE-1, MERGE-5).
    fn merge<O: Observer>(
        &self,
        [upper_layers, lower_layers]: &[Vec<DecodedLayer>; 2],
        landmark: &Landmark,
        found: &mut Vec<Detection>,
        observer: &mut O,
    ) {
        let format = landmark.format;
        for upper in upper_layers {
            for lower in lower_layers.iter().filter(|lower| pairs(upper, lower)) {
                let merged = merge(format, upper, lower);
                observer.pair(format, upper, lower, merged.map(|(payload, _)| payload));
                if let Ok((payload, homography)) = merged {
                    let camera_in_landmark = pose(&homography, self.camera, landmark);
                    let (upper, lower) = (*upper, *lower);
                    found.push(Detection { format, payload, upper, lower, homography, camera_in_landmark });
                }
            }
        }
    }
}

/// MERGE-7
fn without_ambiguous<O: Observer>(found: &[Detection], observer: &mut O) -> Vec<Detection> {
    let mut kept = Vec::new();
    for detection in found {
        if found.iter().any(|other| contradict(detection, other)) {
            observer.ambiguous(detection);
        } else {
            observer.detection(detection);
            kept.push(*detection);
        }
    }
    kept
}
