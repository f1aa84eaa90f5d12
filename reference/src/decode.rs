//! From the stripes of a layer to its half of the code word (DECODE).

use crate::camera::Camera;
use crate::homography::Homography;
use crate::hypotheses::{Hypothesis, check};
use crate::landmark::{Format, GUARD_PAIRS};
use crate::observer::Observer;
use crate::refusal::HypothesisRefusal;
use crate::regions::Colour;
use crate::sampling::{Roi, sample};
use crate::threshold::Thresholding;

/// Most decoded ROIs of one format in one line, by both thresholds together (DECODE-2).
pub const MAX_LAYERS: usize = 8;

/// A decoded ROI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecodedLayer {
    /// The threshold by which it was found.
    pub thresholding: Thresholding,
    /// The ROI.
    pub hypothesis: Hypothesis,
    /// `N_code` bits, the left-most stripe as the most significant.
    pub half_word: u32,
    /// Its homography, relative to the principal column (HOMOG-4).
    pub homography: Homography,
}

/// Checks, samples and decodes an ROI; its homography is reported relative to the principal column (HOMOG-4).
pub fn decode<O: Observer>(
    roi: &Roi<'_>,
    camera: &Camera,
    observer: &mut O,
) -> Result<DecodedLayer, HypothesisRefusal> {
    check(roi.hypothesis, roi.regions, roi.format, roi.decoded_before)?;
    let stripes = sample(roi, observer)?;
    Ok(DecodedLayer {
        thresholding: roi.line.thresholding(),
        hypothesis: *roi.hypothesis,
        half_word: half_word(roi.format, &stripes.colours),
        homography: stripes.homography.shifted(roi.hypothesis.middle() - camera.principal_column),
    })
}

/// The half word of N stripes given from left to right (DECODE-1).
//= reference/SPEC.md#decode
//# - **DECODE-1** The half word MUST be the colours of the `N_code` stripes between the guards, black as 1, the
//# left-most stripe as the most significant bit.
#[must_use]
pub fn half_word(format: Format, colours: &[Colour]) -> u32 {
    let code = colours.iter().skip(2 * GUARD_PAIRS).take(format.code_stripes());
    code.fold(0, |word, &colour| word << 1 | u32::from(colour == Colour::Black))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark::stripes;

    //= reference/SPEC.md#decode
    //= type=test
    //# - **DECODE-1** The half word MUST be the colours of the `N_code` stripes between the guards, black as 1, the
    //# left-most stripe as the most significant bit.
    #[test]
    fn decoding_undoes_nrz() {
        for (format, half_word) in [(Format::Paper, 0b1100_1100_0001), (Format::Wide, 0b0011_0000_0101_1110)] {
            let colours: Vec<Colour> =
                stripes(format, half_word).iter().map(|&bar| if bar { Colour::Black } else { Colour::White }).collect();
            assert_eq!(super::half_word(format, &colours), half_word);
        }
    }
}
