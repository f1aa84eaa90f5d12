//! Merging the layers of both lines to detections, and their extents.

use crate::accept::margin::Squares;
use crate::accept::{Candidate, Evidence, Setting, accept};
use crate::codeword;
use crate::covariance::{Covariance, PoseCovariance};
use crate::decode::DecodedLayer;
use crate::extents::{Extent, Shade, extents};
use crate::fit::{self, FitLayer, Illumination};
use crate::formats::{Column, Obliquity};
use crate::frame::{self, Pose};
use crate::homography::Homography;
use crate::hypotheses::Hypothesis;
use crate::landmark::Format;
use crate::observer::Observer;
use crate::refusal::{CandidateRefusal, PairRefusal};
use crate::skew::{EndShifts, Shift, Skew};
use crate::threshold::Thresholding;
use crate::trellis::{self, Settled};
use heapless::Vec;

/// What decoded a barcode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decoder {
    /// Thresholds and regions, stripe after stripe.
    Threshold,
    /// The trellis, for barcodes too small for that.
    Trellis,
}

/// What gave a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// The fit (`COV-2`).
    Fit,
    /// The paper's estimate, from the merged homography (`ACCEPT-10`).
    Paper,
}

/// Where a layer was read, and what it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// The first pixel of the ROI or of the extent.
    pub first_pixel: u16,
    /// The last pixel.
    pub last_pixel: u16,
    /// Its half of the code word, 12 or 16 bits.
    pub half_word: u16,
}

impl Reading {
    fn of(layer: &DecodedLayer) -> Self {
        let Hypothesis { first_pixel, last_pixel, .. } = layer.hypothesis;
        Self { first_pixel, last_pixel, half_word: layer.half_word }
    }

    fn of_extent((first_pixel, last_pixel): Extent, half_word: u16) -> Self {
        Self { first_pixel, last_pixel, half_word }
    }

    /// It as a layer of its line, to be fitted.
    #[must_use]
    pub fn layer<'a>(&self, line: &'a [u8], format: Format) -> FitLayer<'a> {
        let Self { first_pixel, last_pixel, half_word } = *self;
        FitLayer { line, first_pixel, last_pixel, stripes: fit::stripes(format, half_word) }
    }

    /// Whether these pixels of the same line and the reading's have one in common.
    #[must_use]
    pub fn shares_a_pixel_with(&self, first_pixel: u16, last_pixel: u16) -> bool {
        self.first_pixel <= last_pixel && first_pixel <= self.last_pixel
    }
}

/// What a detection keeps of its fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FitSummary {
    /// The covariance of `(a, s, k)` (`FIT-14`).
    pub covariance: Covariance,
    /// The blur σ in px.
    pub blur: Column,
    /// `s²` in 2^-16 squared grey levels.
    pub variance: u32,
    /// The decision margin (`ACCEPT-8`).
    pub margin: Squares,
    /// The light that the fit was made under.
    pub illumination: Illumination,
}

/// The fit of a layer alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayerFit {
    /// What the layer's own row saw.
    pub homography: Homography,
    /// What the fit says besides.
    pub fit: FitSummary,
}

/// A landmark that was found, as it is seen at the upper row's time (`SKEW-8`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detection {
    /// Its format.
    pub format: Format,
    /// What it says, 16 or 24 bits.
    pub payload: u32,
    /// What decoded it.
    pub decoder: Decoder,
    /// The upper layer.
    pub upper: Reading,
    /// The lower layer.
    pub lower: Reading,
    /// The fitted homography, of a moving camera the upper layer's, or the merged one if there is no fit.
    pub homography: Homography,
    /// What the fit says besides; none by `ACCEPT-10`.
    pub fit: Option<FitSummary>,
    /// The lower layer's own fit where the camera moved (`SKEW-7`).
    pub lower_fit: Option<LayerFit>,
    /// The merged homography of the transitions (`MERGE-4`, `SKEW-8`), if a threshold decoded it.
    pub transitions: Option<Homography>,
    /// The camera's pose: the mean of `COV-2`, or `POSE` of the merged homography.
    pub camera_in_landmark: Pose<frame::Landmark, frame::Camera>,
    /// The covariance of this pose (`COV-3`, `COV-5`).
    pub covariance: PoseCovariance,
}

impl Detection {
    /// What gave the pose.
    #[must_use]
    pub fn estimator(&self) -> Estimator {
        if self.fit.is_some() { Estimator::Fit } else { Estimator::Paper }
    }
}

/// The most detections of a line pair (`MERGE-10`).
pub const MAX_DETECTIONS: usize = 8;

/// Detections in the order of `MERGE-8`.
pub type Detections = Vec<Detection, MAX_DETECTIONS>;

/// The most pairs of one format that the trellis tries (`EXTENT-7`).
const MAX_EXTENTS: u8 = 4;

/// The search for the detections of one format.
pub struct Merger<'a, O> {
    /// What its candidates have in common.
    pub setting: Setting<'a>,
    /// Where detections are added, in the order of `MERGE-8`.
    pub detections: &'a mut Detections,
    /// Who hears of it.
    pub observer: &'a mut O,
    /// How many pairs the trellis has tried (`EXTENT-7`).
    tried: u8,
}

impl<'a, O: Observer> Merger<'a, O> {
    /// The search before it begins.
    pub fn new(setting: Setting<'a>, detections: &'a mut Detections, observer: &'a mut O) -> Self {
        Self { setting, detections, observer, tried: 0 }
    }

    /// Pairs the layers of the format, in the order of `MERGE-6` (`MERGE-1` to `MERGE-5`), and decides the candidates.
    //= reference/SPEC.md#merge
    //# - **MERGE-5** Pairs MUST be formed in the order of the upper layers, and for one upper layer in the order of the
    //# lower ones.
    //= reference/SPEC.md#merge
    //# - **MERGE-6** Layers MUST be ordered as their seeds were taken, those of the global threshold before those of
    //# the local one.
    pub fn merge(&mut self, upper: &[DecodedLayer], lower: &[DecodedLayer]) {
        for upper in upper {
            let Some((shift, ends)) = self.shifts(&upper.homography) else { continue };
            let (play, may_try_again) = (self.setting.skew.play, self.setting.skew.is_at_rest());
            for lower in lower.iter().filter(|lower| belong_together(upper, lower, &ends, play)) {
                let readings = [Reading::of(upper), Reading::of(lower)];
                let layers = [upper.homography, lower.homography];
                let local = [upper, lower].iter().any(|layer| layer.thresholding == Thresholding::Local);
                match self.candidate(Decoder::Threshold, readings) {
                    Ok(candidate) => self.decide(&candidate, Evidence::Threshold { layers, shift, local }),
                    Err(PairRefusal::Crc) if local && may_try_again => self.try_again(readings, &layers), // SKEW-9
                    Err(_) => {}
                }
            }
        }
    }

    /// What the camera's motion does to an upper homography and its ends (`SKEW-2`, `SKEW-4`); `None` where it is paired with
    /// nothing (`SKEW-3`).
    fn shifts(&self, homography: &Homography) -> Option<(Shift, EndShifts)> {
        let Setting { skew, camera, landmark, .. } = self.setting;
        let shift = skew.shift(homography, camera, landmark)?;
        Some((shift, shift.of_ends(homography)?))
    }

    /// Decides a pair of layers again under a step of light (`TRELLIS-9`), unless the format's pairs are used up
    /// (`EXTENT-7`).
    fn try_again(&mut self, readings: [Reading; 2], [upper, lower]: &[Homography; 2]) {
        if self.tried < MAX_EXTENTS {
            self.tried += 1;
            let Setting { lines, camera, landmark, .. } = self.setting;
            let merged = mean(upper, lower);
            let settled = trellis::decode_again(lines, readings, &merged, landmark.format, camera, self.observer);
            self.settled(settled, readings);
        }
    }

    /// Tries the pairs of extents of the format (`EXTENT-4` to `EXTENT-7`, `TRELLIS`) and decides the candidates; of a moving camera
    /// there are none (`SKEW-9`).
    //= reference/SPEC.md#extent
    //# - **EXTENT-7** Of each format at most 4 pairs MUST be tried, those of TRELLIS-9 first.
    //= reference/SPEC.md#skew
    //# - **SKEW-9** Of a moving camera TRELLIS MUST NOT be asked.
    pub fn merge_extents(&mut self, upper: Shade<'_>, lower: Shade<'_>) {
        if !self.setting.skew.is_at_rest() {
            return;
        }
        let format = self.setting.landmark.format;
        for (upper, lower) in extents(upper, lower, format) {
            if self.tried == MAX_EXTENTS {
                return;
            }
            if !self.is_found(upper, lower) {
                self.tried += 1;
                self.try_extents(upper, lower);
            }
        }
    }

    /// Whether one of the extents shares a pixel with a detection of any format (`EXTENT-5`).
    //= reference/SPEC.md#extent
    //# - **EXTENT-5** A pair of which an extent shares a pixel with the same line's ROI or extent of a detection of any
    //# format MUST be left out.
    fn is_found(&self, upper: Extent, lower: Extent) -> bool {
        self.detections.iter().any(|found| {
            found.upper.shares_a_pixel_with(upper.0, upper.1) || found.lower.shares_a_pixel_with(lower.0, lower.1)
        })
    }

    fn try_extents(&mut self, upper: Extent, lower: Extent) {
        let Setting { lines, camera, landmark, .. } = self.setting;
        self.observer.extents(landmark.format, upper, lower);
        let settled = trellis::decode(lines, [upper, lower], landmark.format, camera, self.observer);
        self.settled(settled, [upper, lower].map(|extent| Reading::of_extent(extent, 0)));
    }

    /// Decides what the trellis has found, in these readings' places.
    fn settled(&mut self, settled: Result<Settled, CandidateRefusal>, mut readings: [Reading; 2]) {
        match settled {
            Err(refusal) => self.refuse(Decoder::Trellis, refusal),
            Ok(Settled { half_words, fitted }) => {
                for (reading, half_word) in readings.iter_mut().zip(half_words) {
                    reading.half_word = half_word;
                }
                if let Ok(candidate) = self.candidate(Decoder::Trellis, readings) {
                    self.decide(&candidate, Evidence::Trellis(&fitted));
                }
            }
        }
    }

    /// The candidate of two readings, if they have a payload (`MERGE-2`, `MERGE-3`, `TRELLIS-8`).
    //= reference/SPEC.md#merge
    //# - **MERGE-2** A pair MUST give the code word of CODE-4.
    //= reference/SPEC.md#merge
    //# - **MERGE-3** A pair MUST be refused by CODE-7 before CODE-8 is asked.
    //= reference/SPEC.md#trellis
    //# - **TRELLIS-8** The half words MUST be checked as those of two decoded layers (MERGE-2, MERGE-3) when they have
    //# settled.
    fn candidate(&mut self, decoder: Decoder, readings: [Reading; 2]) -> Result<Candidate, PairRefusal> {
        let format = self.setting.landmark.format;
        let [upper, lower] = &readings;
        let payload = codeword::decode(format, upper.half_word, lower.half_word);
        self.observer.pair(format, decoder, upper, lower, payload);
        Ok(Candidate { payload: payload?, readings })
    }

    /// Makes a candidate a detection, or reports why not (`MERGE-9`, `MERGE-10`).
    //= reference/SPEC.md#merge
    //# - **MERGE-9** A candidate MUST become a detection if ACCEPT accepts it, and otherwise be refused by the first of
    //# ACCEPT's reasons.
    //= reference/SPEC.md#merge
    //# - **MERGE-10** A line pair MUST give at most 8 detections before MERGE-7, and what comes after them be refused
    //# (`TooMany`).
    fn decide(&mut self, candidate: &Candidate, evidence: Evidence<'_>) {
        let decoder = evidence.decoder();
        let decided = accept(candidate, evidence, &self.setting, self.observer);
        let decided = decided.and_then(|found| self.detections.push(found).map_err(|_| CandidateRefusal::TooMany));
        if let Err(refusal) = decided {
            self.refuse(decoder, refusal);
        }
    }

    fn refuse(&mut self, decoder: Decoder, refusal: CandidateRefusal) {
        self.observer.candidate_refused(self.setting.landmark.format, decoder, refusal);
    }
}

/// Whether both ends of the ROIs differ by at most 3 px (`MERGE-1`), and a play, the upper one's being shifted (`SKEW-6`).
//= reference/SPEC.md#merge
//# - **MERGE-1** An upper and a lower layer MUST be paired where their ROIs' first pixels differ by at most 3 px and
//# their last pixels by at most 3 px.
//= reference/SPEC.md#skew
//# - **SKEW-6** In MERGE-1 the lower layer's ends MUST be compared with the upper one's ends plus the shifts of the
//# upper layer's homography, `T` px added to the 3 px, and in ACCEPT-2 the lower layer's `(a, s, k)` count less the
//# shift of the upper layer's, `T` px added to the limit of `a`.
fn belong_together(upper: &DecodedLayer, lower: &DecodedLayer, ends: &EndShifts, play: u32) -> bool {
    let pixels = |layer: &DecodedLayer| [layer.hypothesis.first_pixel, layer.hypothesis.last_pixel].map(i32::from);
    let [upper, lower] = [upper, lower].map(pixels);
    let limit = play.saturating_add(3);
    ends.added(upper).into_iter().zip(lower).all(|(upper, lower)| upper.abs_diff(lower) <= limit)
}

/// The merged homography: the mean of both layers' (`MERGE-4`), of a moving camera with the upper one's `a`, the lower one being given
/// less the shift (`SKEW-8`).
#[must_use]
pub fn merged(upper: &Homography, lower: &Homography, skew: &Skew) -> Homography {
    let mean = mean(upper, lower);
    if skew.is_at_rest() { mean } else { Homography { a: upper.a, ..mean } }
}

/// The mean of two homographies (`MERGE-4`). Rounding errors: 2^-21 px for `a` and `s`, 2^-31 for `k`.
//= reference/SPEC.md#merge
//# - **MERGE-4** The merged homography MUST be the mean of the two layers' `a`, `s` and `k`.
#[must_use]
pub fn mean(upper: &Homography, lower: &Homography) -> Homography {
    let column = |upper: Column, lower: Column| Column::from_bits(halfway(upper.to_bits(), lower.to_bits()));
    Homography {
        a: column(upper.a, lower.a),
        s: column(upper.s, lower.s),
        k: Obliquity::from_bits(halfway(upper.k.to_bits(), lower.k.to_bits())),
    }
}

/// The mean of two integers, halves up, which always fits: `x + y = (x ^ y) + 2 (x & y)`.
fn halfway(x: i32, y: i32) -> i32 {
    let (odd, whole) = (x ^ y, x & y);
    whole + (odd >> 1) + (odd & 1)
}

/// Removes the detections of different formats whose upper ROIs share a pixel, all of them, and reports what was
/// removed and what is left (`MERGE-7`, `MERGE-8`).
//= reference/SPEC.md#merge
//# - **MERGE-7** Detections of different formats whose upper ROIs share a pixel MUST be refused, all of them
//# (`Ambiguous`).
//= reference/SPEC.md#merge
//# - **MERGE-8** Each format MUST report its detections in the order of MERGE-5, those of TRELLIS after them, and the
//# formats in the order in which they were asked for.
pub fn withdraw_ambiguous<O: Observer>(detections: &mut Detections, observer: &mut O) {
    let mut ambiguous = [false; MAX_DETECTIONS];
    for (flag, detection) in ambiguous.iter_mut().zip(detections.iter()) {
        *flag = detections.iter().any(|other| contradict(detection, other));
    }
    let mut flags = ambiguous.into_iter();
    detections.retain(|detection| {
        let withdrawn = flags.next().unwrap_or(false);
        if withdrawn {
            observer.ambiguous(detection);
        } else {
            observer.detection(detection);
        }
        !withdrawn
    });
}

fn contradict(one: &Detection, other: &Detection) -> bool {
    one.format != other.format && one.upper.shares_a_pixel_with(other.upper.first_pixel, other.upper.last_pixel)
}

#[cfg(test)]
mod tests;
