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

/// The most layers of one format in one line (`DECODE-2`).
pub const MAX_LAYERS: usize = 8;

/// A layer that was decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodedLayer {
    /// Where it is.
    pub hypothesis: Hypothesis,
    /// Its half of the code word, 12 or 16 bits.
    pub half_word: u16,
    /// Its last homography.
    pub homography: Homography,
}

/// Checks and decodes an ROI.
///
/// # Errors
/// As [`hypotheses::check`] and [`sampling::sample`].
pub fn decode<O: Observer>(
    scan: &Scan<'_>,
    hypothesis: &Hypothesis,
    format: Format,
    camera: &Camera,
    rule: CrossingRule,
    observer: &mut O,
) -> Result<DecodedLayer, HypothesisRefusal> {
    hypotheses::check(hypothesis, scan.regions, format)?;
    let (stripes, solution) = sampling::sample(scan, hypothesis, format, rule, observer)?;
    // Both exist for a plausible solution of an ROI on a camera's line.
    let homography = Grid::new(hypothesis)
        .and_then(|grid| solution.reported(format, &grid, camera))
        .ok_or(HypothesisRefusal::Implausible)?;
    Ok(DecodedLayer { hypothesis: *hypothesis, half_word: half_word(&stripes, format), homography })
}

/// The colours of the code stripes, black as 1, the left-most as the most significant bit (`DECODE-1`).
#[must_use]
pub fn half_word(stripes: &Stripes, format: Format) -> u16 {
    let guard = 2 * GUARD_PAIRS;
    (guard..guard + format.code_stripes())
        .fold(0, |word, stripe| word << 1 | u16::from(stripes.colour(stripe) == Colour::Black))
}
