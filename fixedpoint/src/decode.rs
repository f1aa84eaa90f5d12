//! Decoding one layer.

use crate::camera::Camera;
use crate::crossing::{CrossingRule, Grid, Scan};
use crate::homography::Homography;
use crate::hypotheses::{self, Hypothesis};
use crate::landmark::{Format, GUARD_PAIRS};
use crate::observer::Observer;
use crate::refusal::HypothesisRefusal;
use crate::regions::Colour;
use crate::sampling::{self, Stripes};
use crate::threshold::Thresholding;

/// The most layers of one format in one line, by both thresholds together (`DECODE-2`).
pub const MAX_LAYERS: usize = 8;

/// A layer that was decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodedLayer {
    /// By which threshold it was found.
    pub thresholding: Thresholding,
    /// Where it is.
    pub hypothesis: Hypothesis,
    /// Its half of the code word, 12 or 16 bits.
    pub half_word: u16,
    /// Its last homography.
    pub homography: Homography,
}

/// Checks and decodes an ROI (`HYPO-10`). `before` are the layers of the same format that the line has given so far.
///
/// # Errors
/// `Repeated`, and as [`hypotheses::check`] and [`sampling::sample`].
//= reference/SPEC.md#hypo
//# - **HYPO-10** HYPO-12, HYPO-6 to HYPO-9 and then HYPO-11 MUST be applied in this order and the first that holds be
//# reported.
pub fn decode<O: Observer>(
    scan: &Scan<'_>,
    hypothesis: &Hypothesis,
    format: Format,
    camera: &Camera,
    rule: CrossingRule,
    before: &[DecodedLayer],
    observer: &mut O,
) -> Result<DecodedLayer, HypothesisRefusal> {
    let thresholding = scan.thresholds.thresholding();
    if thresholding == Thresholding::Local && repeats(hypothesis, before) {
        return Err(HypothesisRefusal::Repeated);
    }
    hypotheses::check(hypothesis, scan.regions, format)?;
    let (stripes, solution) = sampling::sample(scan, hypothesis, format, rule, observer)?;
    // Both exist for a plausible solution of an ROI on a camera's line.
    let homography = Grid::new(hypothesis)
        .and_then(|grid| solution.reported(format, &grid, camera))
        .ok_or(HypothesisRefusal::Implausible)?;
    let half_word = half_word(&stripes, format);
    Ok(DecodedLayer { thresholding, hypothesis: *hypothesis, half_word, homography })
}

/// Whether an ROI of the local threshold shows what the global one has decoded (`HYPO-12`).
//= reference/SPEC.md#hypo
//# - **HYPO-12** An ROI of the local threshold that shares a pixel with an ROI of the same line which was decoded in
//# the same format by the global threshold MUST be refused (`Repeated`).
fn repeats(hypothesis: &Hypothesis, before: &[DecodedLayer]) -> bool {
    before
        .iter()
        .filter(|layer| layer.thresholding == Thresholding::Global)
        .any(|layer| hypothesis.shares_a_pixel_with(&layer.hypothesis))
}

/// The colours of the code stripes, black as 1, the left-most as the most significant bit (`DECODE-1`).
//= reference/SPEC.md#decode
//# - **DECODE-1** The half word MUST be the colours of the `N_code` stripes between the guards, black as 1, the
//# left-most stripe as the most significant bit.
#[must_use]
pub fn half_word(stripes: &Stripes, format: Format) -> u16 {
    let guard = 2 * GUARD_PAIRS;
    (guard..guard + format.code_stripes())
        .fold(0, |word, stripe| word << 1 | u16::from(stripes.colour(stripe) == Colour::Black))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{draw, stripes};
    use crate::observer::Silent;
    use crate::regions::{Regions, regions};
    use crate::threshold::local::Blocks;
    use crate::threshold::{Thresholds, threshold};

    /// A layer of a half word in stripes of 4 px, from pixel 200 to 279, decoded after another one of the line, from
    /// pixel `first` to `last`.
    fn decoded(
        by: Thresholding,
        half_word: u16,
        before: (Thresholding, u16, u16),
    ) -> Result<DecodedLayer, HypothesisRefusal> {
        let mut line = [255; 480];
        draw(&mut line, 200, 4, &stripes(Format::Paper, half_word));
        let (mut blocks, mut found) = (Blocks::new(), Regions::new());
        blocks.read(&line).unwrap();
        let thresholds = match by {
            Thresholding::Global => Thresholds::Global(threshold(&line).unwrap()),
            Thresholding::Local => Thresholds::Local(&blocks),
        };
        regions(&line, &thresholds, &mut found).unwrap();
        let scan = Scan { line: &line, thresholds, regions: &found };
        let last_region = found.len() - 2;
        let hypothesis = Hypothesis { first_region: 1, last_region, first_pixel: 200, last_pixel: 279 };
        let decode = |before: &[DecodedLayer]| {
            decode(&scan, &hypothesis, Format::Paper, &Camera::epuck(), CrossingRule::default(), before, &mut Silent)
        };
        let mut other = decode(&[]).unwrap();
        other.thresholding = before.0;
        (other.hypothesis.first_pixel, other.hypothesis.last_pixel) = (before.1, before.2);
        decode(&[other])
    }

    #[test]
    fn a_layer_says_by_which_threshold_it_was_found() {
        for by in [Thresholding::Global, Thresholding::Local] {
            let layer = decoded(by, 0x5A5, (Thresholding::Global, 100, 199)).unwrap();
            assert_eq!((layer.thresholding, layer.half_word), (by, 0x5A5));
        }
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-12** An ROI of the local threshold that shares a pixel with an ROI of the same line which was decoded
    //# in the same format by the global threshold MUST be refused (`Repeated`).
    #[test]
    fn only_a_local_roi_repeats_and_only_a_global_layer() {
        use Thresholding::{Global, Local};
        let repeated = |by, before| decoded(by, 0x5A5, before) == Err(HypothesisRefusal::Repeated);
        // One pixel is enough, from either side or within.
        for (first, last) in [(100, 200), (279, 300), (100, 300), (240, 240)] {
            assert!(repeated(Local, (Global, first, last)));
            assert!(!repeated(Local, (Local, first, last)));
            assert!(!repeated(Global, (Global, first, last)));
        }
        assert!(!repeated(Local, (Global, 100, 199)) && !repeated(Local, (Global, 280, 300)));
    }
}
