//! Threshold of a scan line (THRESH).

use crate::refusal::LineRefusal;

/// Smallest range in grey levels that is looked at (THRESH-4).
pub const MIN_RANGE: i32 = 24;

/// The threshold, as the two values whose mean it is (THRESH-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threshold {
    /// Smallest value of the line.
    pub darkest: u8,
    /// Largest value of the line.
    pub brightest: u8,
}

impl Threshold {
    /// Twice the threshold, `T2`, in grey levels.
    #[must_use]
    pub fn twice(&self) -> i32 {
        i32::from(self.darkest) + i32::from(self.brightest)
    }

    /// The range `R`, in grey levels.
    #[must_use]
    pub fn range(&self) -> i32 {
        i32::from(self.brightest) - i32::from(self.darkest)
    }

    /// Twice a pixel's distance from the threshold, in grey levels; negative where it is black.
    #[must_use]
    pub fn contrast(&self, pixel: u8) -> i32 {
        2 * i32::from(pixel) - self.twice()
    }

    /// THRESH-2
    #[must_use]
    pub fn is_black(&self, pixel: u8) -> bool {
        self.contrast(pixel) < 0
    }

    /// THRESH-3
    #[must_use]
    pub fn is_distinct(&self, pixel: u8) -> bool {
        8 * self.contrast(pixel).abs() >= self.range()
    }
}

/// The threshold of a scan line, refused where its contrast is low (THRESH-1, THRESH-4).
pub fn threshold(line: &[u8]) -> Result<Threshold, LineRefusal> {
    let darkest = line.iter().copied().min().ok_or(LineRefusal::Width)?;
    let brightest = line.iter().copied().max().ok_or(LineRefusal::Width)?;
    let threshold = Threshold { darkest, brightest };
    if threshold.range() < MIN_RANGE { Err(LineRefusal::LowContrast) } else { Ok(threshold) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_on_the_threshold_is_white() {
        let found = threshold(&[40, 200, 120, 119, 121]).unwrap();
        assert_eq!(found, Threshold { darkest: 40, brightest: 200 });
        assert!(!found.is_black(120) && found.is_black(119) && !found.is_black(121));
    }

    #[test]
    fn distinct_begins_at_a_sixteenth_of_the_range() {
        // Range 160: the distance is 10 grey levels.
        let found = threshold(&[40, 200]).unwrap();
        assert!(found.is_distinct(110) && !found.is_distinct(111));
        assert!(found.is_distinct(130) && !found.is_distinct(129));
    }

    #[test]
    fn contrast_below_24_is_refused() {
        assert_eq!(threshold(&[100, 123]), Err(LineRefusal::LowContrast));
        assert!(threshold(&[100, 124]).is_ok());
    }
}
