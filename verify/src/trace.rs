//! What a pipeline did with one frame, stage by stage, in numbers that can be compared.
//!
//! Both recorders fill this form from the observers of their pipeline. Enumerations are the reference's.

use reference::landmark::Format;
use reference::observer::Layer;
use reference::refusal::{HypothesisRefusal, LineRefusal, PairRefusal};

/// Everything that a pipeline reported about one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Upper and lower scan line.
    pub lines: [LineTrace; 2],
    /// All ROIs in the order in which they were looked at.
    pub hypotheses: Vec<HypothesisTrace>,
    /// Lines refused during the search in a format (DECODE-2).
    pub crowded: Vec<(Layer, LineRefusal)>,
    /// All pairs of layers.
    pub pairs: Vec<PairTrace>,
    /// Results.
    pub detections: Vec<DetectionTrace>,
    /// Detections withdrawn by MERGE-7.
    pub ambiguous: Vec<(Format, u32)>,
    /// Whether the observer heard of just the detections that the detector returned.
    pub heard_is_returned: bool,
}

impl Default for Trace {
    fn default() -> Self {
        Self {
            lines: Default::default(),
            hypotheses: Vec::new(),
            crowded: Vec::new(),
            pairs: Vec::new(),
            detections: Vec::new(),
            ambiguous: Vec::new(),
            heard_is_returned: true,
        }
    }
}

/// The first two stages on one line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineTrace {
    /// Darkest and brightest value.
    pub threshold: Option<(u8, u8)>,
    /// Whether the first region is black, and the first pixel of every region.
    pub regions: Option<(bool, Vec<u16>)>,
    /// Why there are none.
    pub refusal: Option<LineRefusal>,
}

/// One ROI.
#[derive(Clone, Debug, PartialEq)]
pub struct HypothesisTrace {
    /// Its line.
    pub layer: Layer,
    /// The format that was looked for.
    pub format: Format,
    /// Its first and last region.
    pub regions: (usize, usize),
    /// Its first and last pixel.
    pub pixels: (usize, usize),
    /// Edges `v` and columns `z` of the transitions used, ordered by edge.
    pub crossings: Vec<(i32, i32)>,
    /// Smallest margin of HOMOG-3; infinite where none is known (the port decides exactly).
    pub plausibility_margin: f64,
    /// Sampled stripes in order.
    pub samples: Vec<SampleTrace>,
    /// How the transitions fit the format, if it came to that.
    pub residual: Option<ResidualTrace>,
    /// How it ended.
    pub outcome: Outcome,
}

/// The test of SAMPLE-10.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualTrace {
    /// Largest difference between two like transitions, pixels.
    pub difference: f64,
    /// Distance from the limit, pixels; infinite where none is known.
    pub margin: f64,
}

/// One sampled stripe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleTrace {
    /// Which stripe, from the left.
    pub stripe: usize,
    /// The region it fell in.
    pub region: Option<usize>,
    /// Column of its middle relative to the ROI's middle, pixels.
    pub middle: f64,
    /// Distance from the nearest boundary that decides, pixels; infinite where none is known.
    pub margin: f64,
}

/// How an ROI ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Still open: the search in the line ended with it (DECODE-2).
    Open,
    /// Refused.
    Refused(HypothesisRefusal),
    /// Decoded.
    Decoded {
        /// The code bits.
        half_word: u32,
        /// The homography relative to the principal column.
        homography: HomographyTrace,
    },
}

/// A homography: pixels, pixels, dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomographyTrace {
    /// Centre.
    pub a: f64,
    /// Half width.
    pub s: f64,
    /// Obliquity.
    pub k: f64,
}

/// A pair of layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairTrace {
    /// Its format.
    pub format: Format,
    /// First pixels of both ROIs.
    pub first_pixels: (usize, usize),
    /// Payload or refusal.
    pub result: Result<u32, PairRefusal>,
}

/// A detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionTrace {
    /// Its format.
    pub format: Format,
    /// Its payload.
    pub payload: u32,
    /// Half words of both layers.
    pub half_words: (u32, u32),
    /// The merged homography.
    pub homography: HomographyTrace,
    /// The camera in the landmark's frame.
    pub pose: PoseTrace,
}

/// A pose: metres, metres, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseTrace {
    /// x in metres.
    pub x: f64,
    /// y in metres.
    pub y: f64,
    /// Heading in radians.
    pub theta: f64,
}

impl Trace {
    /// The line of a layer.
    pub fn line(&mut self, layer: Layer) -> &mut LineTrace {
        match layer {
            Layer::Upper => &mut self.lines[0],
            Layer::Lower => &mut self.lines[1],
        }
    }

    /// A line was refused: before its regions were known by THRESH or REGION, afterwards by DECODE-2.
    pub fn refuse_line(&mut self, layer: Layer, refusal: LineRefusal) {
        if refusal == LineRefusal::TooManyLayers {
            self.crowded.push((layer, refusal));
        } else {
            self.line(layer).refusal = Some(refusal);
        }
    }

    /// Begins an ROI.
    pub fn begin(&mut self, layer: Layer, format: Format, regions: (usize, usize), pixels: (usize, usize)) {
        self.hypotheses.push(HypothesisTrace {
            layer,
            format,
            regions,
            pixels,
            crossings: Vec::new(),
            plausibility_margin: f64::INFINITY,
            samples: Vec::new(),
            residual: None,
            outcome: Outcome::Open,
        });
    }

    /// Notes something about the ROI that was begun last.
    pub fn current(&mut self, note: impl FnOnce(&mut HypothesisTrace)) {
        if let Some(hypothesis) = self.hypotheses.last_mut() {
            note(hypothesis);
        }
    }

    /// A transition of the ROI that was begun last. The order in which a pipeline adds them is its own affair.
    pub fn cross(&mut self, edge: i32, column: i32) {
        self.current(|hypothesis| {
            let place = hypothesis.crossings.partition_point(|before| *before < (edge, column));
            hypothesis.crossings.insert(place, (edge, column));
        });
    }

    /// Ends the ROI that was begun last.
    pub fn end(&mut self, outcome: Outcome) {
        self.current(|hypothesis| hypothesis.outcome = outcome);
    }
}
