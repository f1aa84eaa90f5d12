//! Regions of interest (ROI): where in a line a layer may be.

use crate::landmark::{Format, GUARD_PAIRS};
use crate::refusal::HypothesisRefusal;
use crate::regions::{Colour, Regions};

/// An ROI, from a first to a last black region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hypothesis {
    /// The first black region.
    pub first_region: u8,
    /// The last black region.
    pub last_region: u8,
    /// The first region's first pixel.
    pub first_pixel: u16,
    /// The last region's last pixel.
    pub last_pixel: u16,
}

impl Hypothesis {
    /// The extent `e` in px.
    #[must_use]
    pub fn extent(&self) -> u32 {
        u32::from(self.last_pixel.saturating_sub(self.first_pixel)) + 1
    }

    /// Whether it has a pixel in common with another ROI, of the same line or across.
    #[must_use]
    pub fn shares_a_pixel_with(&self, other: &Self) -> bool {
        self.first_pixel <= other.last_pixel && other.first_pixel <= self.last_pixel
    }

    /// The number of black regions, 1 to 128.
    #[must_use]
    pub fn bars(&self) -> u8 {
        self.last_region.saturating_sub(self.first_region) / 2 + 1
    }
}

/// Which regions ROIs have taken, at half their number: between two black regions there is one white.
#[derive(Clone, Debug)]
pub struct Taken([bool; 128]);

impl Taken {
    /// None taken.
    #[must_use]
    pub const fn new() -> Self {
        Self([false; 128])
    }

    fn contains(&self, region: u8) -> bool {
        self.0.get(usize::from(region / 2)).copied().unwrap_or(true)
    }

    fn insert(&mut self, region: u8) {
        if let Some(taken) = self.0.get_mut(usize::from(region / 2)) {
            *taken = true;
        }
    }
}

impl Default for Taken {
    fn default() -> Self {
        Self::new()
    }
}

/// The ROIs of a line, seed after seed (`HYPO-1` to `HYPO-5`); [`check`] says which may be decoded.
//= reference/SPEC.md#hypo
//# - **HYPO-5** ROIs MUST be formed, seed after seed, until every black region is taken.
#[derive(Debug)]
pub struct Hypotheses<'a> {
    regions: &'a Regions,
    stripes: u8,
    taken: &'a mut Taken,
}

/// The ROIs of a line for a format. `taken` is working memory, what it holds does not matter.
pub fn hypotheses<'a>(regions: &'a Regions, format: Format, taken: &'a mut Taken) -> Hypotheses<'a> {
    *taken = Taken::new();
    Hypotheses { regions, stripes: format.stripes(), taken }
}

impl Iterator for Hypotheses<'_> {
    type Item = Hypothesis;

    /// The next ROI; it takes all of its black regions (`HYPO-4`).
    //= reference/SPEC.md#hypo
    //# - **HYPO-4** An ROI MUST take all of its black regions, whether it is decoded or refused.
    fn next(&mut self) -> Option<Hypothesis> {
        let seed = self.seed()?;
        let seed_width = seed.extent();
        self.taken.insert(seed.first_region);
        let mut roi = seed;
        while let Some((grown, region)) = self.grown(&roi, seed_width) {
            self.taken.insert(region);
            roi = grown;
        }
        Some(roi)
    }
}

impl Hypotheses<'_> {
    /// The narrowest black region that is not taken, the left-most of equals (`HYPO-1`).
    //= reference/SPEC.md#hypo
    //# - **HYPO-1** The seed MUST be the narrowest black region that no ROI has taken yet, the left-most of equals.
    fn seed(&self) -> Option<Hypothesis> {
        (0..self.regions.len())
            .filter(|&region| self.is_free(region))
            .filter_map(|region| self.alone(region))
            .min_by_key(Hypothesis::extent) // the first of equals
    }

    fn is_free(&self, region: u8) -> bool {
        self.regions.colour(region) == Colour::Black && !self.taken.contains(region)
    }

    fn alone(&self, region: u8) -> Option<Hypothesis> {
        Some(Hypothesis {
            first_region: region,
            last_region: region,
            first_pixel: self.regions.first(region)?,
            last_pixel: self.regions.last(region)?,
        })
    }

    /// The ROI with the neighbour across the smaller gap, the left one of equals (`HYPO-3`), and that neighbour.
    //= reference/SPEC.md#hypo
    //# - **HYPO-3** The ROI MUST grow, as long as it has a neighbour, by the one across the smaller white gap, the left
    //# one of equals.
    fn grown(&self, roi: &Hypothesis, seed_width: u32) -> Option<(Hypothesis, u8)> {
        let left = self.with_left(roi).filter(|grown| self.keeps(grown, seed_width));
        let right = self.with_right(roi).filter(|grown| self.keeps(grown, seed_width));
        let to_left = |grown: Hypothesis| (grown, grown.first_region);
        let to_right = |grown: Hypothesis| (grown, grown.last_region);
        match (left, right) {
            (Some(left), Some(right)) => {
                if self.gap(right.last_region) < self.gap(roi.first_region) {
                    Some(to_right(right))
                } else {
                    Some(to_left(left))
                }
            }
            (left, right) => left.map(to_left).or(right.map(to_right)),
        }
    }

    fn with_left(&self, roi: &Hypothesis) -> Option<Hypothesis> {
        let region = roi.first_region.checked_sub(2).filter(|&region| self.is_free(region))?;
        let first_pixel = self.regions.first(region)?;
        Some(Hypothesis { first_region: region, first_pixel, ..*roi })
    }

    fn with_right(&self, roi: &Hypothesis) -> Option<Hypothesis> {
        let region = roi.last_region.checked_add(2).filter(|&region| self.is_free(region))?;
        let last_pixel = self.regions.last(region)?;
        Some(Hypothesis { last_region: region, last_pixel, ..*roi })
    }

    /// Whether the extent keeps to 2.5 predicted widths (`HYPO-2`). Both sides are below 2^24.
    //= reference/SPEC.md#hypo
    //# - **HYPO-2** A neighbour of the ROI MUST be the next black region to its left or right, if no ROI has taken it
    //# and if with it the ROI's extent `e` keeps to `2 e <= 5 N w`, with `w` the seed's width in pixels.
    fn keeps(&self, roi: &Hypothesis, seed_width: u32) -> bool {
        2 * roi.extent() <= 5 * u32::from(self.stripes) * seed_width
    }

    /// The pixels of the white region at the left of a black one.
    fn gap(&self, region: u8) -> u16 {
        region.checked_sub(1).map_or(0, |white| pixels(self.regions, white))
    }
}

/// The width of a region in pixels.
fn pixels(regions: &Regions, region: u8) -> u16 {
    match (regions.first(region), regions.last(region)) {
        (Some(first), Some(last)) => last.saturating_sub(first).saturating_add(1),
        _ => 0,
    }
}

/// Whether an ROI may be decoded, as far as its regions say (`HYPO-6` to `HYPO-11`).
///
/// # Errors
/// The first of `TooFewBars`, `TooManyBars`, `CutOff`, `QuietZone` and `TooNarrow` that holds.
//= reference/SPEC.md#hypo
//# - **HYPO-6** An ROI of fewer than `2 N_guard` black regions MUST be refused (`TooFewBars`).
//= reference/SPEC.md#hypo
//# - **HYPO-7** An ROI of more than `N/2` black regions MUST be refused (`TooManyBars`).
//= reference/SPEC.md#hypo
//# - **HYPO-8** An ROI that begins with the first pixel of the line or ends with the last MUST be refused (`CutOff`).
//= reference/SPEC.md#hypo
//# - **HYPO-11** An ROI whose extent is below 5/4 of a pixel per stripe, `4 e < 5 N`, MUST be refused (`TooNarrow`).
pub fn check(hypothesis: &Hypothesis, regions: &Regions, format: Format) -> Result<(), HypothesisRefusal> {
    if hypothesis.bars() < 2 * GUARD_PAIRS {
        return Err(HypothesisRefusal::TooFewBars);
    }
    if hypothesis.bars() > format.stripes() / 2 {
        return Err(HypothesisRefusal::TooManyBars);
    }
    let end = regions.width().saturating_sub(1);
    if hypothesis.first_pixel == 0 || hypothesis.last_pixel >= end {
        return Err(HypothesisRefusal::CutOff);
    }
    let left = hypothesis.first_region.checked_sub(1);
    let right = hypothesis.last_region.checked_add(1);
    for region in [left, right].into_iter().flatten() {
        let reaches_an_end = regions.first(region) == Some(0) || regions.last(region) == Some(end);
        //= reference/SPEC.md#hypo
        //# - **HYPO-9** An ROI beside which a white region of `q` pixels that does not reach an end of the line has `N
        //# (q + 1) < 2 e` MUST be refused (`QuietZone`), since LAND-5 asks for 2.5 stripes.
        // HYPO-9
        let stripes_wide = u32::from(format.stripes()) * (u32::from(pixels(regions, region)) + 1);
        if !reaches_an_end && stripes_wide < 2 * hypothesis.extent() {
            return Err(HypothesisRefusal::QuietZone);
        }
    }
    if 4 * hypothesis.extent() < 5 * u32::from(format.stripes()) {
        return Err(HypothesisRefusal::TooNarrow);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::runs;
    use crate::regions::regions;
    use crate::threshold::{Threshold, Thresholds};
    use std::vec::Vec;

    fn regions_of(line: &[u8]) -> Regions {
        let mut found = Regions::new();
        regions(line, &Thresholds::Global(Threshold { darkest: 0, brightest: 255 }), &mut found).unwrap();
        found
    }

    /// First and last pixels of the ROIs of a line that begins white with runs of these widths, format `paper`.
    fn rois(widths: &[usize]) -> Vec<(u16, u16)> {
        let found = regions_of(&runs(widths));
        let mut taken = Taken::new();
        hypotheses(&found, Format::Paper, &mut taken).map(|roi| (roi.first_pixel, roi.last_pixel)).collect()
    }

    fn checked(widths: &[usize]) -> Vec<Result<(), HypothesisRefusal>> {
        let found = regions_of(&runs(widths));
        let mut taken = Taken::new();
        hypotheses(&found, Format::Paper, &mut taken).map(|roi| check(&roi, &found, Format::Paper)).collect()
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-1** The seed MUST be the narrowest black region that no ROI has taken yet, the left-most of equals.
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-5** ROIs MUST be formed, seed after seed, until every black region is taken.
    #[test]
    fn the_seed_is_the_narrowest_the_left_most_of_equals() {
        // Too far apart to grow: ROIs come in the order of their seeds.
        assert_eq!(rois(&[10, 3, 200, 2, 150, 2, 10]), [(213, 214), (365, 366), (10, 12)]);
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-2** A neighbour of the ROI MUST be the next black region to its left or right, if no ROI has taken it
    //# and if with it the ROI's extent `e` keeps to `2 e <= 5 N w`, with `w` the seed's width in pixels.
    #[test]
    fn an_extent_of_two_and_a_half_barcodes_is_kept() {
        // The seed is 1 px: the extent may be 50 px and not 51.
        assert_eq!(rois(&[10, 1, 48, 1, 10]), [(10, 59)]);
        assert_eq!(rois(&[10, 1, 49, 1, 10]), [(10, 10), (60, 60)]);
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-3** The ROI MUST grow, as long as it has a neighbour, by the one across the smaller white gap, the left
    //# one of equals.
    #[test]
    fn the_roi_grows_across_the_smaller_gap() {
        // Seed in the middle, extent up to 50: only one of both neighbours fits after the other.
        assert_eq!(rois(&[60, 2, 30, 1, 29, 2, 60])[0], (92, 123));
        assert_eq!(rois(&[60, 2, 29, 1, 30, 2, 60])[0], (60, 91));
        // Equal gaps: the left one.
        assert_eq!(rois(&[60, 2, 30, 1, 30, 2, 60])[0], (60, 92));
    }

    #[test]
    fn a_neighbour_that_does_not_fit_leaves_the_other() {
        // The left neighbour is nearer, but so wide that the extent would be 51.
        assert_eq!(rois(&[60, 40, 10, 1, 20, 2, 60])[0], (110, 132));
        assert_eq!(rois(&[60, 39, 10, 1, 20, 2, 60])[0], (60, 109));
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-4** An ROI MUST take all of its black regions, whether it is decoded or refused.
    #[test]
    fn a_refused_roi_keeps_its_regions() {
        // Both bars belong to one ROI of too few bars; no other ROI follows.
        assert_eq!(checked(&[10, 1, 1, 1, 10]), [Err(HypothesisRefusal::TooFewBars)]);
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-6** An ROI of fewer than `2 N_guard` black regions MUST be refused (`TooFewBars`).
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-7** An ROI of more than `N/2` black regions MUST be refused (`TooManyBars`).
    #[test]
    fn the_number_of_bars_is_checked() {
        let bars = |count: usize| {
            let mut widths = std::vec![4; 2 * count + 1];
            (widths[0], widths[2 * count]) = (20, 20);
            checked(&widths)
        };
        assert_eq!(bars(3), [Err(HypothesisRefusal::TooFewBars)]);
        assert_eq!(bars(4), [Ok(())]);
        assert_eq!(bars(10), [Ok(())]);
        assert_eq!(bars(11), [Err(HypothesisRefusal::TooManyBars)]);
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-8** An ROI that begins with the first pixel of the line or ends with the last MUST be refused
    //# (`CutOff`).
    #[test]
    fn a_roi_at_an_end_of_the_line_is_cut_off() {
        assert_eq!(checked(&[0, 1, 1, 1, 1, 1, 1, 1, 20]), [Err(HypothesisRefusal::CutOff)]);
        assert_eq!(checked(&[20, 1, 1, 1, 1, 1, 1, 1]), [Err(HypothesisRefusal::CutOff)]);
        assert_eq!(checked(&[1, 4, 4, 4, 4, 4, 4, 4, 1]), [Ok(())]);
    }

    /// 20 stripes ask for 25 px.
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-11** An ROI whose extent is below 5/4 of a pixel per stripe, `4 e < 5 N`, MUST be refused
    //# (`TooNarrow`).
    #[test]
    fn a_roi_below_five_quarters_of_a_pixel_per_stripe_is_too_narrow() {
        assert_eq!(checked(&[20, 4, 4, 4, 4, 4, 2, 3, 20]), [Ok(())]);
        assert_eq!(checked(&[20, 4, 4, 4, 4, 4, 2, 2, 20]), [Err(HypothesisRefusal::TooNarrow)]);
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-9** An ROI beside which a white region of `q` pixels that does not reach an end of the line has `N (q +
    //# 1) < 2 e` MUST be refused (`QuietZone`), since LAND-5 asks for 2.5 stripes.
    #[test]
    fn the_quiet_zone_is_a_tenth_of_the_extent_less_a_pixel() {
        // Extent 40 px asks for 3 px of white before the wide bar, which is too wide to be a neighbour.
        let beside = |gap: usize, extra: usize| checked(&[9, 200, gap, 4, 4, 4, 4, 4, 4, 16 + extra, 30])[0];
        assert_eq!(beside(3, 0), Ok(()));
        assert_eq!(beside(2, 0), Err(HypothesisRefusal::QuietZone));
        assert_eq!(beside(3, 1), Err(HypothesisRefusal::QuietZone));
        // A white region that reaches the line's end may be narrower.
        assert_eq!(checked(&[1, 4, 4, 4, 4, 4, 4, 16, 30])[0], Ok(()));
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-10** HYPO-12, HYPO-6 to HYPO-9 and then HYPO-11 MUST be applied in this order and the first that holds
    //# be reported.
    #[test]
    fn the_first_reason_is_reported() {
        // Too few bars, cut off and without a quiet zone.
        assert_eq!(checked(&[0, 4, 4, 4])[0], Err(HypothesisRefusal::TooFewBars));
        // Cut off and without a quiet zone at the other side.
        let both = checked(&[0, 4, 4, 4, 4, 4, 4, 17, 1, 200, 9]);
        assert_eq!(both[0], Err(HypothesisRefusal::CutOff));
    }
}
