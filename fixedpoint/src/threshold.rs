//! The thresholds of a scan line: the global one, and the local one of each pixel.

use crate::refusal::LineRefusal;

pub mod local;

use local::Blocks;

/// By which of its thresholds a line is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thresholding {
    /// By one threshold for all pixels (`THRESH-1`).
    Global,
    /// By each pixel's own (`THRESH-6`).
    Local,
}

/// The thresholds of a line's pixels.
#[derive(Clone, Copy, Debug)]
pub enum Thresholds<'a> {
    /// One for all.
    Global(Threshold),
    /// Each pixel's own, from the blocks of the line.
    Local(&'a Blocks),
}

impl Thresholds<'_> {
    /// Which ones they are.
    #[must_use]
    pub const fn thresholding(&self) -> Thresholding {
        match self {
            Self::Global(_) => Thresholding::Global,
            Self::Local(_) => Thresholding::Local,
        }
    }

    /// The threshold of one pixel of the line; `None` outside of it.
    #[must_use]
    pub fn at(&self, line: &[u8], pixel: u16) -> Option<Threshold> {
        match self {
            Self::Global(threshold) => line.get(usize::from(pixel)).map(|_| *threshold),
            Self::Local(blocks) => blocks.at(line, pixel),
        }
    }
}

/// What counts as dark and as bright at a pixel: the extremes of the line, or those to either side (`THRESH-6`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Threshold {
    /// The smallest value of the line; `low(i)` of a local threshold.
    pub darkest: u8,
    /// The largest value of the line; `high(i)` of a local threshold.
    pub brightest: u8,
}

impl Threshold {
    /// Twice the threshold, `T2`, 0 to 510 (`THRESH-1`, `THRESH-6`).
    #[must_use]
    pub fn twice(&self) -> u16 {
        u16::from(self.darkest) + u16::from(self.brightest)
    }

    /// The range `R` in grey levels.
    #[must_use]
    pub fn range(&self) -> u8 {
        self.brightest.saturating_sub(self.darkest)
    }

    /// Whether there is something to tell apart: always by the global threshold of a line that was not refused
    /// (`THRESH-4`), so that one rule serves both thresholds.
    //= reference/SPEC.md#thresh
    //# - **THRESH-4** A scan line whose range is below 24 grey levels MUST be refused (`LowContrast`).
    fn has_contrast(&self) -> bool {
        self.range() >= LEAST_RANGE
    }

    /// Whether a pixel is black (`THRESH-2`, `THRESH-7`).
    //= reference/SPEC.md#thresh
    //# - **THRESH-2** By the global threshold a pixel of value `I` MUST be black where `2 I < T2`, and white otherwise.
    //= reference/SPEC.md#thresh
    //# - **THRESH-7** By the local threshold a pixel MUST be black where `R(i) >= 24` and `2 I < T2(i)`, and white
    //# otherwise.
    #[must_use]
    pub fn is_black(&self, pixel: u8) -> bool {
        self.has_contrast() && 2 * u16::from(pixel) < self.twice()
    }

    /// Whether a pixel is at least 1/16 of the range from the threshold (`THRESH-3`), or the range too small to ask
    /// (`THRESH-8`).
    //= reference/SPEC.md#thresh
    //# - **THRESH-3** By the global threshold a pixel MUST be *distinct* where `8 |2 I - T2| >= R`, that is where it is
    //# at least 1/16 of the range from the threshold.
    //= reference/SPEC.md#thresh
    //# - **THRESH-8** By the local threshold a pixel MUST be distinct where `R(i) < 24` or `8 |2 I - T2(i)| >= R(i)`.
    #[must_use]
    pub fn is_distinct(&self, pixel: u8) -> bool {
        // At most 8 * 510.
        !self.has_contrast() || 8 * self.distance(pixel) >= u16::from(self.range())
    }

    /// Twice a pixel's distance from the threshold, `|2 I - T2|`, 0 to 510 grey levels.
    #[must_use]
    pub fn distance(&self, pixel: u8) -> u16 {
        (2 * u16::from(pixel)).abs_diff(self.twice())
    }
}

/// The smallest range of a line, or of a local threshold by which anything is black, in grey levels (`THRESH-4`,
/// `THRESH-7`).
const LEAST_RANGE: u8 = 24;

/// The global threshold of a scan line (`THRESH-1`, `THRESH-4`).
///
/// # Errors
/// `LowContrast` below 24 grey levels, and for a line without pixels.
//= reference/SPEC.md#thresh
//# - **THRESH-1** The global threshold MUST be the mean of the scan line's largest and smallest value, kept as their
//# sum `T2`.
pub fn threshold(line: &[u8]) -> Result<Threshold, LineRefusal> {
    let darkest = line.iter().copied().min().unwrap_or(0);
    let brightest = line.iter().copied().max().unwrap_or(0);
    let threshold = Threshold { darkest, brightest };
    if threshold.has_contrast() { Ok(threshold) } else { Err(LineRefusal::LowContrast) }
}

#[cfg(test)]
mod tests {
    use super::*;

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-4** A scan line whose range is below 24 grey levels MUST be refused (`LowContrast`).
    #[test]
    fn a_range_of_24_is_the_least() {
        assert_eq!(threshold(&[100, 123, 110]), Err(LineRefusal::LowContrast));
        assert_eq!(threshold(&[110, 100, 124]), Ok(Threshold { darkest: 100, brightest: 124 }));
    }

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-1** The global threshold MUST be the mean of the scan line's largest and smallest value, kept as
    //# their sum `T2`.
    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-2** By the global threshold a pixel of value `I` MUST be black where `2 I < T2`, and white otherwise.
    #[test]
    fn a_pixel_on_the_threshold_is_white() {
        let even = Threshold { darkest: 100, brightest: 140 };
        assert!(even.is_black(119) && !even.is_black(120));
        let odd = Threshold { darkest: 100, brightest: 141 };
        assert!(odd.is_black(120) && !odd.is_black(121));
    }

    #[test]
    fn below_a_range_of_24_all_is_white_and_distinct() {
        let (flat, least) = (Threshold { darkest: 100, brightest: 123 }, Threshold { darkest: 100, brightest: 124 });
        assert!(least.is_black(111) && !least.is_distinct(111));
        for pixel in 100..=123 {
            assert!(!flat.is_black(pixel) && flat.is_distinct(pixel));
        }
    }

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-3** By the global threshold a pixel MUST be *distinct* where `8 |2 I - T2| >= R`, that is where it is
    //# at least 1/16 of the range from the threshold.
    #[test]
    fn a_sixteenth_of_the_range_is_distinct() {
        // T = 140 and R = 80: distinct from 5 grey levels on.
        let threshold = Threshold { darkest: 100, brightest: 180 };
        assert!(threshold.is_distinct(135) && threshold.is_distinct(145));
        assert!(!threshold.is_distinct(136) && !threshold.is_distinct(144));
        // T = 140.5 and R = 81: distinct from 5.0625 on.
        let threshold = Threshold { darkest: 100, brightest: 181 };
        assert!(threshold.is_distinct(135) && !threshold.is_distinct(136));
        assert!(!threshold.is_distinct(145) && threshold.is_distinct(146));
    }
}
