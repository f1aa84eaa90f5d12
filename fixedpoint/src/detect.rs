//! The detector: all stages, from two scan lines to landmarks.

use crate::accept::Setting;
use crate::camera::Camera;
use crate::crossing::{CrossingRule, Scan};
use crate::decode::{self, DecodedLayer, MAX_LAYERS};
use crate::extents::Shade;
use crate::hypotheses::{Taken, hypotheses};
use crate::landmark::{Format, Landmark};
use crate::merge::{Merger, withdraw_ambiguous};
use crate::observer::{Layer, Observer};
use crate::refusal::LineRefusal;
use crate::regions::{Regions, regions};
use crate::skew::Skew;
use crate::threshold::local::Blocks;
use crate::threshold::{Threshold, Thresholding, Thresholds, threshold};
use heapless::Vec;

pub use crate::merge::Detections;

/// The detector's working memory, about 1.5 KB. What it holds between two calls does not matter.
#[derive(Clone, Debug)]
pub struct Workspace {
    upper: LineLayers,
    lower: LineLayers,
    scratch: Scratch,
}

impl Workspace {
    /// Working memory, ready for use.
    #[must_use]
    pub const fn new() -> Self {
        let scratch = Scratch { regions: Regions::new(), blocks: Blocks::new(), taken: Taken::new() };
        Self { upper: LineLayers::new(), lower: LineLayers::new(), scratch }
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

/// What is needed of a line only while it is searched, by one threshold after the other (`LINE-5`).
#[derive(Clone, Debug)]
struct Scratch {
    regions: Regions,
    blocks: Blocks,
    taken: Taken,
}

/// The layers of a line, and its global threshold if it was not refused.
#[derive(Clone, Debug)]
struct LineLayers {
    threshold: Option<Threshold>,
    paper: FormatLayers,
    wide: FormatLayers,
}

impl LineLayers {
    const fn new() -> Self {
        Self { threshold: None, paper: FormatLayers::new(), wide: FormatLayers::new() }
    }

    fn clear(&mut self) {
        self.threshold = None;
        self.paper.clear();
        self.wide.clear();
    }

    fn of(&self, format: Format) -> &FormatLayers {
        match format {
            Format::Paper => &self.paper,
            Format::Wide => &self.wide,
        }
    }

    fn of_mut(&mut self, format: Format) -> &mut FormatLayers {
        match format {
            Format::Paper => &mut self.paper,
            Format::Wide => &mut self.wide,
        }
    }
}

/// The layers of one format in a line, in the order of `MERGE-6`: none if they were too many (`DECODE-2`).
#[derive(Clone, Debug)]
struct FormatLayers {
    layers: Vec<DecodedLayer, MAX_LAYERS, u8>,
    too_many: bool,
}

impl FormatLayers {
    const fn new() -> Self {
        Self { layers: Vec::new(), too_many: false }
    }

    fn clear(&mut self) {
        self.layers.clear();
        self.too_many = false;
    }

    fn push(&mut self, layer: DecodedLayer) -> Result<(), LineRefusal> {
        self.layers.push(layer).map_err(|_| {
            self.layers.clear();
            self.too_many = true;
            LineRefusal::TooManyLayers
        })
    }
}

/// Finds the landmarks in two scan lines (`LINE-1`): see the crate's documentation.
///
/// Formats are searched in the order of `landmarks`, each as if it were the only one (`LINE-4`, `LINE-5`); of several
/// landmarks of one format the first counts. A line that is refused has no layers and does not change what the other one
/// has (`LINE-3`); why, the observer hears.
///
/// Both lines are taken to be exposed at the same time, or the camera to be at rest.
//= reference/SPEC.md#line
//# - **LINE-1** A scan line MUST be a slice of 8-bit grey values, one for each column of the camera.
//= reference/SPEC.md#line
//# - **LINE-3** A refusal on one scan line MUST NOT change the results of the other.
//= reference/SPEC.md#line
//# - **LINE-4** Several formats MUST be searched one after the other, each as if it were the only one but for EXTENT-5,
//# before MERGE-7 compares them.
//= reference/SPEC.md#line
//# - **LINE-5** The upper line MUST be searched before the lower one, each in all formats by its global threshold
//# (THRESH-1) and then in all formats by its local one (THRESH-6).
pub fn detect<O: Observer>(
    upper: &[u8],
    lower: &[u8],
    camera: &Camera,
    landmarks: &[Landmark],
    rule: CrossingRule,
    workspace: &mut Workspace,
    observer: &mut O,
) -> Detections {
    detect_moving(upper, lower, camera, landmarks, rule, &Skew::AT_REST, workspace, observer)
}

/// Finds the landmarks in two scan lines between which the camera has moved (`SKEW-5` to `SKEW-9`), as [`detect`] does at
/// rest; what detections say is what is seen at the upper line's time (`SKEW-8`).
#[expect(clippy::too_many_arguments, reason = "those of `detect`, and the skew")]
pub fn detect_moving<O: Observer>(
    upper: &[u8],
    lower: &[u8],
    camera: &Camera,
    landmarks: &[Landmark],
    rule: CrossingRule,
    skew: &Skew,
    workspace: &mut Workspace,
    observer: &mut O,
) -> Detections {
    let Workspace { upper: above, lower: below, scratch } = workspace;
    Search { layer: Layer::Upper, line: upper, camera, landmarks, rule, layers: above, observer }.run(scratch);
    Search { layer: Layer::Lower, line: lower, camera, landmarks, rule, layers: below, observer }.run(scratch);
    let mut detections = Detections::new();
    for landmark in distinct(landmarks) {
        let setting = Setting { lines: [upper, lower], camera, landmark, rule, skew };
        let mut merger = Merger::new(setting, &mut detections, observer);
        merger.merge(&above.of(landmark.format).layers, &below.of(landmark.format).layers);
        if let (Some(one), Some(other)) = (&above.threshold, &below.threshold) {
            merger.merge_extents(Shade::new(upper, one), Shade::new(lower, other));
        }
    }
    withdraw_ambiguous(&mut detections, observer);
    detections
}

/// The first landmark of each format.
fn distinct(landmarks: &[Landmark]) -> impl Iterator<Item = &Landmark> {
    landmarks.iter().enumerate().filter_map(|(index, landmark)| {
        let repeats = |before: &Landmark| before.format == landmark.format;
        if landmarks.iter().take(index).any(repeats) { None } else { Some(landmark) }
    })
}

/// The search of one line.
struct Search<'a, O> {
    layer: Layer,
    line: &'a [u8],
    camera: &'a Camera,
    landmarks: &'a [Landmark],
    rule: CrossingRule,
    layers: &'a mut LineLayers,
    observer: &'a mut O,
}

impl<O: Observer> Search<'_, O> {
    /// Decodes the layers of the line by both of its thresholds, or reports why there are none.
    fn run(mut self, scratch: &mut Scratch) {
        self.layers.clear();
        let Scratch { regions, blocks, taken } = scratch;
        match self.read(blocks) {
            Err(refusal) => self.observer.line_refused(self.layer, Thresholding::Global, refusal),
            Ok(threshold) => {
                self.layers.threshold = Some(threshold);
                self.observer.threshold(self.layer, &threshold);
                self.by(Thresholds::Global(threshold), regions, taken);
                self.by(Thresholds::Local(blocks), regions, taken);
            }
        }
    }

    /// Reads what both thresholds are found from.
    fn read(&self, blocks: &mut Blocks) -> Result<Threshold, LineRefusal> {
        //= reference/SPEC.md#line
        //# - **LINE-2** A scan line whose length is not the camera's width MUST be refused (`Width`).
        // LINE-2
        if self.line.len() != usize::from(self.camera.width()) {
            return Err(LineRefusal::Width);
        }
        blocks.read(self.line)?;
        threshold(self.line)
    }

    /// Searches the line in all formats by one of its thresholds.
    fn by(&mut self, thresholds: Thresholds<'_>, buffer: &mut Regions, taken: &mut Taken) {
        let thresholding = thresholds.thresholding();
        if let Err(refusal) = regions(self.line, &thresholds, buffer) {
            self.observer.line_refused(self.layer, thresholding, refusal);
            return;
        }
        self.observer.regions(self.layer, thresholding, buffer);
        let scan = Scan { line: self.line, thresholds, regions: buffer };
        for landmark in distinct(self.landmarks) {
            if let Err(refusal) = self.decode(&scan, landmark.format, taken) {
                self.observer.line_refused(self.layer, thresholding, refusal);
            }
        }
    }

    /// Decodes the layers of one format, in the order of their seeds, until they are too many (`DECODE-2`).
    //= reference/SPEC.md#decode
    //# - **DECODE-2** A line MUST give no layers of a format of which it has more than 8 by both thresholds together,
    //# and the search in that format end with the ninth (`TooManyLayers`).
    fn decode(&mut self, scan: &Scan<'_>, format: Format, taken: &mut Taken) -> Result<(), LineRefusal> {
        let found = self.layers.of_mut(format);
        if found.too_many {
            return Ok(()); // by the other threshold, as was reported then
        }
        for hypothesis in hypotheses(scan.regions, format, taken) {
            self.observer.hypothesis(self.layer, scan.thresholds.thresholding(), format, &hypothesis);
            let before = &found.layers;
            match decode::decode(scan, &hypothesis, format, self.camera, self.rule, before, self.observer) {
                Err(refusal) => self.observer.refused(refusal),
                Ok(decoded) => {
                    found.push(decoded)?;
                    self.observer.decoded(&decoded);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
