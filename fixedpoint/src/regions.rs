//! The regions of a scan line: maximal runs of one colour, after the contrast filter.

use crate::refusal::LineRefusal;
use crate::threshold::{Threshold, Thresholds};
use heapless::Vec;

/// What a pixel or a stripe is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colour {
    /// A bar.
    #[default]
    Black,
    /// A space.
    White,
}

/// The most regions a line may have (`REGION-5`).
pub const MAX_REGIONS: usize = 255;

/// The regions of a line, numbered from 0 at the left; colours alternate, so the first pixels say it all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Regions {
    firsts: Vec<u16, MAX_REGIONS, u8>,
    first_colour: Colour,
    width: u16,
}

impl Regions {
    /// No regions, as after a refusal.
    #[must_use]
    pub const fn new() -> Self {
        Self { firsts: Vec::new(), first_colour: Colour::Black, width: 0 }
    }

    /// The number of regions, 0 to 255.
    #[must_use]
    pub fn len(&self) -> u8 {
        // The vector holds no more than 255.
        u8::try_from(self.firsts.len()).unwrap_or(u8::MAX)
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.firsts.is_empty()
    }

    /// The number of pixels of the line.
    #[must_use]
    pub fn width(&self) -> u16 {
        self.width
    }

    /// The colour of a region.
    #[must_use]
    pub fn colour(&self, region: u8) -> Colour {
        if region.is_multiple_of(2) { self.first_colour } else { opposite(self.first_colour) }
    }

    /// The first pixel of a region, if there is that region.
    #[must_use]
    pub fn first(&self, region: u8) -> Option<u16> {
        self.firsts.get(usize::from(region)).copied()
    }

    /// The last pixel of a region, if there is that region.
    #[must_use]
    pub fn last(&self, region: u8) -> Option<u16> {
        self.first(region)?;
        let next = region.checked_add(1).and_then(|next| self.first(next)).unwrap_or(self.width);
        next.checked_sub(1)
    }

    /// Leaves no regions.
    pub fn clear(&mut self) {
        *self = Self::new();
    }

    /// Takes each pixel with its threshold, from left to right.
    fn fill(&mut self, mut pixels: impl Iterator<Item = (u8, Threshold)>) -> Result<(), LineRefusal> {
        let (mut run_first, mut run_colour) = (0, None);
        let mut region_colour = None;
        pixels.try_for_each(|(pixel, threshold)| {
            let index = self.width;
            self.width = index.checked_add(1).ok_or(LineRefusal::Width)?;
            let colour = colour_of(pixel, &threshold);
            if run_colour != Some(colour) {
                (run_first, run_colour) = (index, Some(colour));
            }
            if region_colour != Some(colour) && threshold.is_distinct(pixel) {
                // The raw region has a distinct pixel and another colour than what is at its left: a region begins
                //= reference/SPEC.md#region
                //# - **REGION-2** A raw region without a distinct pixel MUST take the colour of the nearest raw region
                //# to its left that has one.
                //= reference/SPEC.md#region
                //# - **REGION-3** Raw regions without a distinct pixel at the left end of the line MUST take the colour
                //# of the first raw region that has one.
                // where the raw region began (REGION-2), the first one at the line's end (REGION-3).
                let first = if region_colour.is_none() { 0 } else { run_first };
                self.firsts.push(first).map_err(|_| LineRefusal::TooManyRegions)?;
                if region_colour.is_none() {
                    self.first_colour = colour;
                }
                region_colour = Some(colour);
            }
            Ok(())
        })
    }
}

/// Finds the regions of a line by one of its thresholds, in the caller's buffer, which holds none after a refusal
/// (`REGION-1` to `REGION-5`).
///
/// # Errors
/// `TooManyRegions` if there are more than 255, `Width` if the line has more than 65,535 pixels.
//= reference/SPEC.md#region
//# - **REGION-1** A raw region MUST be a maximal run of pixels of one colour.
//= reference/SPEC.md#region
//# - **REGION-4** The regions MUST be the maximal runs of one colour after REGION-2 and REGION-3.
//= reference/SPEC.md#region
//# - **REGION-5** A scan line with more than 255 regions by one of its thresholds MUST give no ROIs by that threshold
//# (`TooManyRegions`).
pub fn regions(line: &[u8], thresholds: &Thresholds<'_>, regions: &mut Regions) -> Result<(), LineRefusal> {
    regions.clear();
    let filled = match thresholds {
        Thresholds::Global(threshold) => regions.fill(line.iter().map(|&pixel| (pixel, *threshold))),
        Thresholds::Local(blocks) => regions.fill(blocks.thresholds(line)),
    };
    if filled.is_err() {
        regions.clear();
    }
    filled
}

fn colour_of(pixel: u8, threshold: &Threshold) -> Colour {
    if threshold.is_black(pixel) { Colour::Black } else { Colour::White }
}

fn opposite(colour: Colour) -> Colour {
    match colour {
        Colour::Black => Colour::White,
        Colour::White => Colour::Black,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Colour::{Black, White};
    use std::vec::Vec as List;

    /// First pixel and colour of each region; T = 100 and R = 160, distinct from 10 grey levels on.
    fn found(line: &[u8]) -> List<(u16, Colour)> {
        let thresholds = Thresholds::Global(Threshold { darkest: 20, brightest: 180 });
        let mut found = Regions::new();
        regions(line, &thresholds, &mut found).unwrap();
        (0..found.len()).map(|i| (found.first(i).unwrap(), found.colour(i))).collect()
    }

    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-1** A raw region MUST be a maximal run of pixels of one colour.
    #[test]
    fn regions_are_runs_of_one_colour() {
        assert_eq!(found(&[20, 20, 180, 20]), [(0, Black), (2, White), (3, Black)]);
    }

    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-2** A raw region without a distinct pixel MUST take the colour of the nearest raw region to its left
    //# that has one.
    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-4** The regions MUST be the maximal runs of one colour after REGION-2 and REGION-3.
    #[test]
    fn a_faint_raw_region_takes_the_colour_at_its_left() {
        assert_eq!(found(&[180, 91, 99, 180, 20]), [(0, White), (4, Black)]);
        assert_eq!(found(&[20, 109, 100, 20, 180]), [(0, Black), (4, White)]);
        // One distinct pixel is enough, and the region begins where the raw region does.
        assert_eq!(found(&[180, 91, 90, 91, 180]), [(0, White), (1, Black), (4, White)]);
        // Two faint raw regions in a row: both take the colour of the left; the black one begins after them.
        assert_eq!(found(&[180, 95, 105, 20, 180]), [(0, White), (3, Black), (4, White)]);
        // Faint black beside black through faint white.
        assert_eq!(found(&[180, 20, 105, 95, 180]), [(0, White), (1, Black), (4, White)]);
    }

    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-3** Raw regions without a distinct pixel at the left end of the line MUST take the colour of the
    //# first raw region that has one.
    #[test]
    fn faint_raw_regions_at_the_left_end_join_the_first_distinct_one() {
        assert_eq!(found(&[105, 95, 105, 20, 180]), [(0, Black), (4, White)]);
        assert_eq!(found(&[95, 180, 20]), [(0, White), (2, Black)]);
    }

    #[test]
    fn faint_raw_regions_at_the_right_end_join_the_last() {
        assert_eq!(found(&[20, 180, 95, 105]), [(0, Black), (1, White)]);
    }

    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-5** A scan line with more than 255 regions by one of its thresholds MUST give no ROIs by that
    //# threshold (`TooManyRegions`).
    #[test]
    fn more_than_255_regions_are_refused() {
        let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
        let line: List<u8> = (0..256).map(|i| if i % 2 == 0 { 0 } else { 255 }).collect();
        let mut found = Regions::new();
        assert_eq!(regions(&line[..255], &thresholds, &mut found), Ok(()));
        assert_eq!((found.len(), found.last(254), found.is_empty()), (255, Some(254), false));
        assert_eq!(regions(&line, &thresholds, &mut found), Err(LineRefusal::TooManyRegions));
        assert!(found.is_empty());
    }

    #[test]
    fn a_region_ends_before_the_next_or_with_the_line() {
        let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
        let mut found = Regions::new();
        regions(&[0, 0, 255, 255, 255], &thresholds, &mut found).unwrap();
        assert_eq!((found.last(0), found.last(1), found.last(2)), (Some(1), Some(4), None));
        assert_eq!(found.first(2), None);
    }
}
