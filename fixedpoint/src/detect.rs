//! The detector: all stages, from two scan lines to landmarks.

use crate::camera::Camera;
use crate::crossing::{CrossingRule, Scan};
use crate::decode::{self, DecodedLayer, MAX_LAYERS};
use crate::hypotheses::{Taken, hypotheses};
use crate::landmark::{Format, Landmark};
use crate::merge::{merge, withdraw_ambiguous};
use crate::observer::{Layer, Observer};
use crate::refusal::LineRefusal;
use crate::regions::{Regions, regions};
use crate::threshold::{Threshold, threshold};
use heapless::Vec;

pub use crate::merge::Detections;

/// The detector's working memory, about 1.5 KB. What it holds between two calls does not matter.
#[derive(Clone, Debug)]
pub struct Workspace {
    upper: Line,
    lower: Line,
    taken: Taken,
}

impl Workspace {
    /// Working memory, ready for use.
    #[must_use]
    pub const fn new() -> Self {
        Self { upper: Line::new(), lower: Line::new(), taken: Taken::new() }
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

/// What is known of one scan line; a line that was refused has no regions.
#[derive(Clone, Debug)]
struct Line {
    threshold: Threshold,
    regions: Regions,
    layers: Vec<DecodedLayer, MAX_LAYERS, u8>,
}

/// Finds the landmarks in two scan lines (`LINE-1`): see the crate's documentation.
///
/// Formats are searched in the order of `landmarks`, each as if it were the only one (`LINE-4`); of several landmarks
/// of one format the first counts. A line that is refused has no layers and does not change what the other one has
/// (`LINE-3`); why, the observer hears.
pub fn detect<O: Observer>(
    upper: &[u8],
    lower: &[u8],
    camera: &Camera,
    landmarks: &[Landmark],
    rule: CrossingRule,
    workspace: &mut Workspace,
    observer: &mut O,
) -> Detections {
    let Workspace { upper: above, lower: below, taken } = workspace;
    above.read(upper, Layer::Upper, camera, observer);
    below.read(lower, Layer::Lower, camera, observer);
    let mut detections = Detections::new();
    for (index, landmark) in landmarks.iter().enumerate() {
        let repeats = |before: &Landmark| before.format == landmark.format;
        if landmarks.iter().take(index).any(repeats) {
            continue;
        }
        let search = Search { camera, format: landmark.format, rule };
        search.run(upper, above, Layer::Upper, taken, observer);
        search.run(lower, below, Layer::Lower, taken, observer);
        merge(&above.layers, &below.layers, camera, landmark, &mut detections, observer);
    }
    withdraw_ambiguous(&mut detections, observer);
    detections
}

impl Line {
    const fn new() -> Self {
        let threshold = Threshold { darkest: 0, brightest: 0 };
        Self { threshold, regions: Regions::new(), layers: Vec::new() }
    }

    /// Finds threshold and regions of a line, or reports why there are none.
    fn read<O: Observer>(&mut self, line: &[u8], layer: Layer, camera: &Camera, observer: &mut O) {
        self.regions.clear();
        if let Err(refusal) = self.try_read(line, layer, camera, observer) {
            observer.line_refused(layer, refusal);
        }
    }

    fn try_read<O: Observer>(
        &mut self,
        line: &[u8],
        layer: Layer,
        camera: &Camera,
        observer: &mut O,
    ) -> Result<(), LineRefusal> {
        // LINE-2
        if line.len() != usize::from(camera.width()) {
            return Err(LineRefusal::Width);
        }
        self.threshold = threshold(line)?;
        observer.threshold(layer, &self.threshold);
        regions(line, &self.threshold, &mut self.regions)?;
        observer.regions(layer, &self.regions);
        Ok(())
    }
}

/// What a line is searched for.
struct Search<'a> {
    camera: &'a Camera,
    format: Format,
    rule: CrossingRule,
}

impl Search<'_> {
    /// Decodes the layers of a line, in the order of their seeds (`MERGE-6`); none if they are too many (`DECODE-2`).
    fn run<O: Observer>(&self, pixels: &[u8], line: &mut Line, layer: Layer, taken: &mut Taken, observer: &mut O) {
        line.layers.clear();
        let scan = Scan { line: pixels, threshold: &line.threshold, regions: &line.regions };
        for hypothesis in hypotheses(&line.regions, self.format, taken) {
            observer.hypothesis(layer, self.format, &hypothesis);
            let decoded = decode::decode(&scan, &hypothesis, self.format, self.camera, self.rule, observer);
            match decoded {
                Err(refusal) => observer.refused(refusal),
                Ok(decoded) => {
                    if line.layers.push(decoded).is_err() {
                        observer.line_refused(layer, LineRefusal::TooManyLayers);
                        line.layers.clear();
                        return;
                    }
                    observer.decoded(&decoded);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
