//! From the stripes of a layer to its half of the code word (DECODE).

use crate::homography::Homography;
use crate::hypotheses::Hypothesis;
use crate::landmark::{Format, GUARD_PAIRS};
use crate::regions::Colour;

/// Most decoded ROIs of one format in one line (DECODE-2).
pub const MAX_LAYERS: usize = 8;

/// A decoded ROI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecodedLayer {
    /// The ROI.
    pub hypothesis: Hypothesis,
    /// `N_code` bits, the left-most stripe as the most significant.
    pub half_word: u32,
    /// Its homography, relative to the principal column (HOMOG-4).
    pub homography: Homography,
}

/// The half word of N stripes given from left to right (DECODE-1).
#[must_use]
pub fn decode(format: Format, colours: &[Colour]) -> u32 {
    let code = colours.iter().skip(2 * GUARD_PAIRS).take(format.code_stripes());
    code.fold(0, |word, &colour| word << 1 | u32::from(colour == Colour::Black))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark::stripes;

    #[test]
    fn decoding_undoes_nrz() {
        for (format, half_word) in [(Format::Paper, 0b1100_1100_0001), (Format::Wide, 0b0011_0000_0101_1110)] {
            let colours: Vec<Colour> =
                stripes(format, half_word).iter().map(|&bar| if bar { Colour::Black } else { Colour::White }).collect();
            assert_eq!(decode(format, &colours), half_word);
        }
    }
}
