//! The threshold of a scan line.

use crate::refusal::LineRefusal;

/// A scan line's darkest and brightest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Threshold {
    /// The smallest value of the line.
    pub darkest: u8,
    /// The largest value of the line.
    pub brightest: u8,
}

impl Threshold {
    /// Twice the threshold, `T2`, 0 to 510 (`THRESH-1`).
    #[must_use]
    pub fn twice(&self) -> u16 {
        u16::from(self.darkest) + u16::from(self.brightest)
    }

    /// The range `R` in grey levels.
    #[must_use]
    pub fn range(&self) -> u8 {
        self.brightest.saturating_sub(self.darkest)
    }

    /// Whether a pixel is black (`THRESH-2`).
    #[must_use]
    pub fn is_black(&self, pixel: u8) -> bool {
        2 * u16::from(pixel) < self.twice()
    }

    /// Whether a pixel is at least 1/16 of the range from the threshold (`THRESH-3`).
    #[must_use]
    pub fn is_distinct(&self, pixel: u8) -> bool {
        // At most 8 * 510.
        8 * self.distance(pixel) >= u16::from(self.range())
    }

    /// Twice a pixel's distance from the threshold, `|2 I - T2|`, 0 to 510 grey levels.
    #[must_use]
    pub fn distance(&self, pixel: u8) -> u16 {
        (2 * u16::from(pixel)).abs_diff(self.twice())
    }
}

/// The smallest range of a line, in grey levels (`THRESH-4`).
const LEAST_RANGE: u8 = 24;

/// The threshold of a scan line (`THRESH-1`, `THRESH-4`).
///
/// # Errors
/// `LowContrast` below 24 grey levels, and for a line without pixels.
pub fn threshold(line: &[u8]) -> Result<Threshold, LineRefusal> {
    let darkest = line.iter().copied().min().unwrap_or(0);
    let brightest = line.iter().copied().max().unwrap_or(0);
    let threshold = Threshold { darkest, brightest };
    if threshold.range() < LEAST_RANGE {
        return Err(LineRefusal::LowContrast);
    }
    Ok(threshold)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_24_is_the_least() {
        assert_eq!(threshold(&[100, 123, 110]), Err(LineRefusal::LowContrast));
        assert_eq!(threshold(&[110, 100, 124]), Ok(Threshold { darkest: 100, brightest: 124 }));
    }

    #[test]
    fn a_pixel_on_the_threshold_is_white() {
        let even = Threshold { darkest: 100, brightest: 140 };
        assert!(even.is_black(119) && !even.is_black(120));
        let odd = Threshold { darkest: 100, brightest: 141 };
        assert!(odd.is_black(120) && !odd.is_black(121));
    }

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
