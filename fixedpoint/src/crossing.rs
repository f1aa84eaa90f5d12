//! Crossings: where a transition lies, between two pixels that straddle the threshold.

use crate::hypotheses::Hypothesis;
use crate::regions::Regions;
use crate::threshold::Thresholds;

/// How a transition is placed between its two pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CrossingRule {
    /// Where the straight line between both values meets the threshold (`CROSS-2`).
    #[default]
    Interpolated,
    /// Half-way, the paper's rule (`CROSS-3`).
    WholePixel,
}

/// A transition that enters a homography.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Which edge it is: `v = j - N/2`, from -12 at the left to 12.
    pub edge: i8,
    /// Its column `z` from the ROI's middle in units of `2^-Q` px, -2048 to 2048.
    pub column: i16,
}

/// The largest distance of a column from the ROI's middle, in units of `2^-Q` px.
pub const FARTHEST: i16 = 2048;

/// A scan line as the later stages see it.
#[derive(Clone, Copy, Debug)]
pub struct Scan<'a> {
    /// The pixels.
    pub line: &'a [u8],
    /// The line's thresholds, by which its regions were found.
    pub thresholds: Thresholds<'a>,
    /// The line's regions.
    pub regions: &'a Regions,
}

/// An ROI's own columns: from its middle, in units of `2^-Q` px, so that all of them keep within ±2048.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// First plus last pixel: twice the middle.
    twice_middle: i32,
    subpixel_bits: u8,
}

impl Grid {
    /// The grid of an ROI; `None` if it is wider than 2047 px, which no camera is (`CROSS-1`).
    ///
    /// `(e + 1) 2^Q <= 4096` bounds the outermost transitions, `(e + 1)/2` px from the middle, to ±2048.
    //= reference/SPEC.md#cross
    //# - **CROSS-1** `Q` MUST be the largest integer for which `(e + 1) 2^Q <= 4096`, e being the ROI's extent.
    #[must_use]
    pub fn new(hypothesis: &Hypothesis) -> Option<Self> {
        let subpixel_bits = (1..=8_u8).rev().find(|&bits| (hypothesis.extent() + 1) << bits <= 4096)?;
        let twice_middle = i32::from(hypothesis.first_pixel) + i32::from(hypothesis.last_pixel);
        Some(Self { twice_middle, subpixel_bits })
    }

    /// `Q`: 2 to 7 for the cameras of `CAM-7` and the ROIs that `HYPO-11` leaves.
    #[must_use]
    pub fn subpixel_bits(&self) -> u8 {
        self.subpixel_bits
    }

    /// Twice the ROI's middle in px.
    #[must_use]
    pub fn twice_middle(&self) -> i32 {
        self.twice_middle
    }

    /// The column of a pixel's left boundary, exactly; `None` outside ±2048.
    #[must_use]
    pub fn left_boundary(&self, pixel: u16) -> Option<i16> {
        self.on_grid(2 * i32::from(pixel) - 1, 0)
    }

    /// The transition at the left end of a region (`CROSS-2`, `CROSS-3`), rounded to the nearest unit, halves up.
    ///
    /// `None` if the region has no pixel at its left, or outside ±2048: never for the transitions of this ROI.
    //= reference/SPEC.md#cross
    //# - **CROSS-2** By the `interpolated` rule, the default, the transition between the pixels `i` and `i + 1` MUST
    //# lie at `i + e_0/(e_0 + e_1)`, with `e_0 = |2 I_i - T2(i)|` and `e_1 = |2 I_{i+1} - T2(i+1)|`, rounded to the
    //# nearest unit, halves up.
    //= reference/SPEC.md#cross
    //# - **CROSS-3** By the `whole-pixel` rule, the paper's, the transition MUST lie at `i + 1/2`.
    #[must_use]
    pub fn transition(&self, rule: CrossingRule, scan: &Scan<'_>, region: u8) -> Option<i16> {
        let right = scan.regions.first(region)?;
        let left = right.checked_sub(1)?;
        match rule {
            CrossingRule::WholePixel => self.left_boundary(right),
            CrossingRule::Interpolated => {
                let distance = |pixel: u16| {
                    let value = *scan.line.get(usize::from(pixel))?;
                    Some(u32::from(scan.thresholds.at(scan.line, pixel)?.distance(value)))
                };
                let (e0, e1) = (distance(left)?, distance(right)?);
                // Half-up rounding of 2^Q e0 / (e0 + e1); the numerator is below 2^18.
                let share = ((e0 << (self.subpixel_bits + 1)) + e0 + e1).checked_div(2 * (e0 + e1))?;
                self.on_grid(2 * i32::from(left), i32::try_from(share).ok()?)
            }
        }
    }

    /// A column from twice its value in px (below 2^18) and units to add to it.
    fn on_grid(&self, twice_column: i32, units: i32) -> Option<i16> {
        let half_pixels = twice_column - self.twice_middle;
        // Q is at least 1, so half a pixel is a whole number of units; 2^18 half pixels of 2^7 units are below 2^26.
        let column = (half_pixels << (self.subpixel_bits - 1)) + units;
        i16::try_from(column).ok().filter(|column| column.unsigned_abs() <= FARTHEST.unsigned_abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regions::regions;
    use crate::threshold::Threshold;

    fn hypothesis(first_pixel: u16, last_pixel: u16) -> Hypothesis {
        Hypothesis { first_region: 1, last_region: 7, first_pixel, last_pixel }
    }

    //= reference/SPEC.md#cross
    //= type=test
    //# - **CROSS-1** `Q` MUST be the largest integer for which `(e + 1) 2^Q <= 4096`, e being the ROI's extent.
    #[test]
    fn the_unit_is_as_fine_as_the_extent_allows() {
        let bits = |extent: u16| Grid::new(&hypothesis(1, extent)).map(|grid| grid.subpixel_bits);
        assert_eq!((bits(7), bits(15), bits(16)), (Some(8), Some(8), Some(7)));
        assert_eq!((bits(31), bits(32)), (Some(7), Some(6)));
        assert_eq!((bits(638), bits(1023), bits(1024)), (Some(2), Some(2), Some(1)));
        assert_eq!((bits(2047), bits(2048)), (Some(1), None));
    }

    #[test]
    fn boundaries_are_exact() {
        // Extent 15: Q = 8, and the ROI's outermost boundaries at ±7.5 px are ±1920 units.
        let grid = Grid::new(&hypothesis(10, 24)).unwrap();
        assert_eq!(grid.left_boundary(10), Some(-1920));
        assert_eq!(grid.left_boundary(25), Some(1920));
        assert_eq!(grid.left_boundary(17), Some(-128));
        // 8.5 px are out of reach.
        assert_eq!((grid.left_boundary(9), grid.left_boundary(26)), (None, None));
        // Extent 16: Q = 7, the middle between two pixels.
        let grid = Grid::new(&hypothesis(10, 25)).unwrap();
        assert_eq!(grid.left_boundary(18), Some(0));
    }

    /// The transition between two pixels at 17 and 18 of an ROI from 10 to 24, from the column 17 in units of 1/256 px.
    fn share(rule: CrossingRule, left: u8, right: u8) -> i16 {
        let mut line = [left; 36];
        line[18..].fill(right);
        let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
        let mut found = Regions::new();
        regions(&line, &thresholds, &mut found).unwrap();
        let scan = Scan { line: &line, thresholds, regions: &found };
        // The middle is the column 17.
        Grid::new(&hypothesis(10, 24)).unwrap().transition(rule, &scan, 1).unwrap()
    }

    //= reference/SPEC.md#cross
    //= type=test
    //# - **CROSS-2** By the `interpolated` rule, the default, the transition between the pixels `i` and `i + 1` MUST
    //# lie at `i + e_0/(e_0 + e_1)`, with `e_0 = |2 I_i - T2(i)|` and `e_1 = |2 I_{i+1} - T2(i+1)|`, rounded to the
    //# nearest unit, halves up.
    #[test]
    fn interpolated_transitions_lie_where_the_threshold_is_met() {
        // T = 127.5.
        assert_eq!(share(CrossingRule::Interpolated, 0, 255), 128);
        assert_eq!(share(CrossingRule::Interpolated, 255, 0), 128);
        // 127.5 / (127.5 + 22.5) of 256 is 217.6.
        assert_eq!(share(CrossingRule::Interpolated, 0, 150), 218);
        assert_eq!(share(CrossingRule::Interpolated, 150, 0), 38);
        // 27.5 / (27.5 + 22.5) of 256 is 140.8.
        assert_eq!(share(CrossingRule::Interpolated, 100, 150), 141);
        // 42.5 / (42.5 + 127.5) is a quarter.
        assert_eq!(share(CrossingRule::Interpolated, 85, 255), 64);
    }

    #[test]
    fn halves_of_a_unit_are_rounded_up() {
        // Extent 32 gives Q = 6; e0 = 1 and e1 = 127 lie at 64/128 = 0.5 units.
        let thresholds = Thresholds::Global(Threshold { darkest: 100, brightest: 227 });
        let mut line = [163_u8; 64];
        line[20] = 100;
        line[25..].fill(227);
        let mut found = Regions::new();
        regions(&line, &thresholds, &mut found).unwrap();
        let scan = Scan { line: &line, thresholds, regions: &found };
        let grid = Grid::new(&hypothesis(9, 40)).unwrap();
        assert_eq!(grid.subpixel_bits(), 6);
        // From the pixel 24 to the middle 24.5 are 32 units.
        assert_eq!(grid.transition(CrossingRule::Interpolated, &scan, 1), Some(-32 + 1));
    }

    /// A white pixel on the threshold beside the ROI: half the extent and half a pixel from the middle, 8 px.
    #[test]
    fn the_farthest_transition_is_in_reach() {
        let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 254 });
        let mut line = [254_u8; 36];
        line[10..25].fill(0);
        (line[9], line[25]) = (127, 127);
        let mut found = Regions::new();
        regions(&line, &thresholds, &mut found).unwrap();
        let scan = Scan { line: &line, thresholds, regions: &found };
        let grid = Grid::new(&hypothesis(10, 24)).unwrap();
        assert_eq!(grid.transition(CrossingRule::Interpolated, &scan, 1), Some(-2048));
        assert_eq!(grid.transition(CrossingRule::Interpolated, &scan, 2), Some(2048));
    }

    //= reference/SPEC.md#cross
    //= type=test
    //# - **CROSS-3** By the `whole-pixel` rule, the paper's, the transition MUST lie at `i + 1/2`.
    #[test]
    fn whole_pixel_transitions_lie_half_way() {
        assert_eq!(share(CrossingRule::WholePixel, 0, 150), 128);
        assert_eq!(share(CrossingRule::WholePixel, 255, 0), 128);
    }

    #[test]
    fn nothing_lies_at_the_left_of_the_line() {
        let line = [0_u8, 255];
        let thresholds = Thresholds::Global(Threshold { darkest: 0, brightest: 255 });
        let mut found = Regions::new();
        regions(&line, &thresholds, &mut found).unwrap();
        let scan = Scan { line: &line, thresholds, regions: &found };
        let grid = Grid::new(&hypothesis(0, 1)).unwrap();
        for rule in [CrossingRule::Interpolated, CrossingRule::WholePixel] {
            assert_eq!(grid.transition(rule, &scan, 0), None);
            assert_eq!(grid.transition(rule, &scan, 2), None);
        }
    }
}
