//! Regions of one colour, after the contrast filter (REGION).

use crate::refusal::LineRefusal;
use crate::threshold::Threshold;

/// Most regions of a line (REGION-5).
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

/// The regions of a line from left to right; they alternate in colour and cover it (REGION-2 to REGION-5).
pub fn regions(line: &[u8], threshold: &Threshold) -> Result<Vec<Region>, LineRefusal> {
    let raw = raw_regions(line, threshold);
    let distinct = |region: &Region| line[region.first..=region.last].iter().any(|&p| threshold.is_distinct(p));
    // The brightest and the darkest pixel are distinct, so this finds one.
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
fn raw_regions(line: &[u8], threshold: &Threshold) -> Vec<Region> {
    let mut raw: Vec<Region> = Vec::new();
    for (i, &pixel) in line.iter().enumerate() {
        let colour = if threshold.is_black(pixel) { Colour::Black } else { Colour::White };
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

    fn found(line: &[u8]) -> Vec<(Colour, usize, usize)> {
        let threshold = threshold(line).unwrap();
        regions(line, &threshold).unwrap().iter().map(|r| (r.colour, r.first, r.last)).collect()
    }

    use Colour::{Black, White};

    #[test]
    fn regions_alternate_and_cover_the_line() {
        assert_eq!(
            found(&[200, 200, 40, 40, 40, 200, 40]),
            [(White, 0, 1), (Black, 2, 4), (White, 5, 5), (Black, 6, 6)]
        );
    }

    #[test]
    fn a_weak_region_joins_the_distinct_one_at_its_left() {
        // T = 120, distinct from 110 down and 130 up: 115 and 125 are weak.
        assert_eq!(found(&[200, 115, 200, 40]), [(White, 0, 2), (Black, 3, 3)]);
        assert_eq!(found(&[200, 115, 125, 40]), [(White, 0, 2), (Black, 3, 3)]);
        assert_eq!(found(&[200, 40, 125, 115]), [(White, 0, 0), (Black, 1, 3)]);
    }

    #[test]
    fn weak_regions_at_the_left_end_take_the_first_distinct_colour() {
        assert_eq!(found(&[115, 125, 200, 40]), [(White, 0, 2), (Black, 3, 3)]);
        assert_eq!(found(&[125, 115, 40, 200]), [(Black, 0, 2), (White, 3, 3)]);
    }

    #[test]
    fn more_than_255_regions_are_refused() {
        let line = |n: usize| (0..n).map(|i| if i % 2 == 0 { 200 } else { 40 }).collect::<Vec<u8>>();
        assert_eq!(found(&line(255)).len(), 255);
        let long = line(256);
        assert_eq!(regions(&long, &threshold(&long).unwrap()), Err(LineRefusal::TooManyRegions));
    }
}
