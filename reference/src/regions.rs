//! Regions of one colour, after the contrast filter (REGION).

use crate::refusal::LineRefusal;
use crate::threshold::Thresholded;

/// Most regions of a line by one threshold (REGION-5).
pub const MAX_REGIONS: usize = 255;

/// The colour of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Below the threshold: a bar.
    Black,
    /// At or above the threshold: a space.
    White,
}

/// A maximal run of pixels of one colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Its colour.
    pub colour: Colour,
    /// First pixel.
    pub first: usize,
    /// Last pixel.
    pub last: usize,
}

impl Region {
    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.last + 1 - self.first
    }
}

/// The regions of a line by one of its thresholds, from left to right; they alternate in colour and cover it (REGION-2 to
/// REGION-5).
//= reference/SPEC.md#region
//# - **REGION-2** A raw region without a distinct pixel MUST take the colour of the nearest raw region to its left that
//# has one.
//= reference/SPEC.md#region
//# - **REGION-3** Raw regions without a distinct pixel at the left end of the line MUST take the colour of the first
//# raw region that has one.
//= reference/SPEC.md#region
//# - **REGION-4** The regions MUST be the maximal runs of one colour after REGION-2 and REGION-3.
//= reference/SPEC.md#region
//# - **REGION-5** A scan line with more than 255 regions by one of its thresholds MUST give no ROIs by that threshold
//# (`TooManyRegions`).
pub fn regions(line: &Thresholded<'_>) -> Result<Vec<Region>, LineRefusal> {
    let raw = raw_regions(line);
    let distinct = |region: &Region| (region.first..=region.last).any(|i| line.is_distinct(i));
    // The line's brightest pixel is distinct by either threshold, so this finds one.
    let mut colour = raw.iter().find(|region| distinct(region)).map_or(Colour::White, |region| region.colour);
    let mut regions: Vec<Region> = Vec::new();
    for region in raw {
        if distinct(&region) {
            colour = region.colour;
        }
        match regions.last_mut() {
            Some(last) if last.colour == colour => last.last = region.last,
            _ => regions.push(Region { colour, ..region }),
        }
    }
    if regions.len() > MAX_REGIONS { Err(LineRefusal::TooManyRegions) } else { Ok(regions) }
}

/// REGION-1
//= reference/SPEC.md#region
//# - **REGION-1** A raw region MUST be a maximal run of pixels of one colour.
fn raw_regions(line: &Thresholded<'_>) -> Vec<Region> {
    let mut raw: Vec<Region> = Vec::new();
    for i in 0..line.width() {
        let colour = if line.is_black(i) { Colour::Black } else { Colour::White };
        match raw.last_mut() {
            Some(last) if last.colour == colour => last.last = i,
            _ => raw.push(Region { colour, first: i, last: i }),
        }
    }
    raw
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threshold::threshold;

    fn global(line: &[u8]) -> Thresholded<'_> {
        Thresholded::global(line, threshold(line).unwrap())
    }

    fn places(regions: &[Region]) -> Vec<(Colour, usize, usize)> {
        regions.iter().map(|r| (r.colour, r.first, r.last)).collect()
    }

    fn found(line: &[u8]) -> Vec<(Colour, usize, usize)> {
        places(&regions(&global(line)).unwrap())
    }

    use Colour::{Black, White};

    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-1** A raw region MUST be a maximal run of pixels of one colour.
    #[test]
    fn regions_alternate_and_cover_the_line() {
        assert_eq!(
            found(&[200, 200, 40, 40, 40, 200, 40]),
            [(White, 0, 1), (Black, 2, 4), (White, 5, 5), (Black, 6, 6)]
        );
    }

    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-2** A raw region without a distinct pixel MUST take the colour of the nearest raw region to its left
    //# that has one.
    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-4** The regions MUST be the maximal runs of one colour after REGION-2 and REGION-3.
    #[test]
    fn a_weak_region_joins_the_distinct_one_at_its_left() {
        // T = 120, distinct from 110 down and 130 up: 115 and 125 are weak.
        assert_eq!(found(&[200, 115, 200, 40]), [(White, 0, 2), (Black, 3, 3)]);
        assert_eq!(found(&[200, 115, 125, 40]), [(White, 0, 2), (Black, 3, 3)]);
        assert_eq!(found(&[200, 40, 125, 115]), [(White, 0, 0), (Black, 1, 3)]);
    }

    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-3** Raw regions without a distinct pixel at the left end of the line MUST take the colour of the
    //# first raw region that has one.
    #[test]
    fn weak_regions_at_the_left_end_take_the_first_distinct_colour() {
        assert_eq!(found(&[115, 125, 200, 40]), [(White, 0, 2), (Black, 3, 3)]);
        assert_eq!(found(&[125, 115, 40, 200]), [(Black, 0, 2), (White, 3, 3)]);
    }

    //= reference/SPEC.md#region
    //= type=test
    //# - **REGION-5** A scan line with more than 255 regions by one of its thresholds MUST give no ROIs by that
    //# threshold (`TooManyRegions`).
    #[test]
    fn more_than_255_regions_are_refused() {
        let line = |n: usize| (0..n).map(|i| if i % 2 == 0 { 200 } else { 40 }).collect::<Vec<u8>>();
        assert_eq!(found(&line(255)).len(), 255);
        assert_eq!(regions(&Thresholded::local(&line(255))).unwrap().len(), 255);
        assert_eq!(regions(&global(&line(256))), Err(LineRefusal::TooManyRegions));
        // By the local threshold a bar at the end of the line has no white to its right: 257 regions end with a space.
        let long = line(257);
        assert_eq!(regions(&Thresholded::local(&long)), Err(LineRefusal::TooManyRegions));
    }

    /// A step from 200 down to 90: at its right nothing is bright, at its left nothing dark, to both sides.
    #[test]
    fn by_the_local_threshold_a_line_may_be_all_white() {
        let step = [[200; 240], [90; 240]].concat();
        assert_eq!(found(&step), [(White, 0, 239), (Black, 240, 479)]);
        assert_eq!(places(&regions(&Thresholded::local(&step)).unwrap()), [(White, 0, 479)]);
    }

    /// Range 160 about 120 between the bars: 115 is weak and joins what is at its left.
    #[test]
    fn the_filter_takes_the_local_range() {
        let mut line = [[200; 240], [67; 240]].concat();
        line[200..204].fill(40);
        line[208..212].fill(40);
        line[206] = 115;
        line[300..304].fill(13);
        let local = places(&regions(&Thresholded::local(&line)).unwrap());
        let expected = [(200, 203), (208, 211), (300, 303)];
        assert_eq!(local.iter().filter(|r| r.0 == Black).map(|r| (r.1, r.2)).collect::<Vec<_>>(), expected);
    }
}
