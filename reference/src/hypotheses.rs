//! Hypotheses: regions of interest (ROI) grown from the smallest black region (HYPO).

use crate::landmark::{Format, GUARD_PAIRS};
use crate::refusal::HypothesisRefusal;
use crate::regions::{Colour, Region};

/// An ROI: the regions from one black region to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hypothesis {
    /// Index of its first region, a black one.
    pub first_region: usize,
    /// Index of its last region, a black one.
    pub last_region: usize,
    /// First black pixel.
    pub first_pixel: usize,
    /// Last black pixel.
    pub last_pixel: usize,
}

impl Hypothesis {
    fn new(regions: &[Region], first_region: usize, last_region: usize) -> Self {
        let (first_pixel, last_pixel) = (regions[first_region].first, regions[last_region].last);
        Self { first_region, last_region, first_pixel, last_pixel }
    }

    /// Its extent `e` in pixels.
    #[must_use]
    pub fn extent(&self) -> usize {
        self.last_pixel + 1 - self.first_pixel
    }

    /// Whether it shares a pixel with another ROI of the same line.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.first_pixel <= other.last_pixel && other.first_pixel <= self.last_pixel
    }

    /// Its middle, pixels, a multiple of one half.
    #[must_use]
    pub fn middle(&self) -> f64 {
        (self.first_pixel + self.last_pixel) as f64 / 2.0
    }
}

/// All ROIs of a line, in the order of their seeds (HYPO-1 to HYPO-5), before their checks.
//= reference/SPEC.md#hypo
//# - **HYPO-4** An ROI MUST take all of its black regions, whether it is decoded or refused.
//= reference/SPEC.md#hypo
//# - **HYPO-5** ROIs MUST be formed, seed after seed, until every black region is taken.
//= reference/SPEC.md#errata
//# - **ERRATA-10** The ROI rule, which ignores perspective and leaves open how far the growth reaches, MUST be read as
//# HYPO-1 to HYPO-5.
#[must_use]
pub fn hypotheses(regions: &[Region], format: Format) -> Vec<Hypothesis> {
    let mut free: Vec<bool> = regions.iter().map(|region| region.colour == Colour::Black).collect();
    let mut found = Vec::new();
    while let Some(seed) = seed(regions, &free) {
        let hypothesis = grow(regions, &free, seed, format);
        free[hypothesis.first_region..=hypothesis.last_region].fill(false);
        found.push(hypothesis);
    }
    found
}

/// HYPO-1: `min_by_key` returns the first of equals.
//= reference/SPEC.md#hypo
//# - **HYPO-1** The seed MUST be the narrowest black region that no ROI has taken yet, the left-most of equals.
fn seed(regions: &[Region], free: &[bool]) -> Option<usize> {
    (0..regions.len()).filter(|&i| free[i]).min_by_key(|&i| regions[i].width())
}

/// HYPO-2, HYPO-3
//= reference/SPEC.md#hypo
//# - **HYPO-2** A neighbour of the ROI MUST be the next black region to its left or right, if no ROI has taken it and
//# if with it the ROI's extent `e` keeps to `2 e <= 5 N w`, with `w` the seed's width in pixels.
//= reference/SPEC.md#hypo
//# - **HYPO-3** The ROI MUST grow, as long as it has a neighbour, by the one across the smaller white gap, the left one
//# of equals.
fn grow(regions: &[Region], free: &[bool], seed: usize, format: Format) -> Hypothesis {
    let limit = 5 * format.stripes() * regions[seed].width();
    let mut roi = Hypothesis::new(regions, seed, seed);
    loop {
        let left = roi.first_region.checked_sub(2).map(|i| Hypothesis::new(regions, i, roi.last_region));
        let right = (roi.last_region + 2 < regions.len())
            .then(|| Hypothesis::new(regions, roi.first_region, roi.last_region + 2));
        let left = left.filter(|grown| free[grown.first_region] && 2 * grown.extent() <= limit);
        let right = right.filter(|grown| free[grown.last_region] && 2 * grown.extent() <= limit);
        roi = match (left, right) {
            (None, None) => return roi,
            (Some(grown), None) | (None, Some(grown)) => grown,
            (Some(left), Some(right)) => {
                let (gap_left, gap_right) = (regions[roi.first_region - 1], regions[roi.last_region + 1]);
                if gap_left.width() <= gap_right.width() { left } else { right }
            }
        };
    }
}

/// HYPO-6 to HYPO-12. `decoded_before` are, for an ROI of the local threshold, those of the same line that the global one
/// decoded in the same format; for one of the global threshold there are none.
//= reference/SPEC.md#hypo
//# - **HYPO-6** An ROI of fewer than `2 N_guard` black regions MUST be refused (`TooFewBars`).
//= reference/SPEC.md#hypo
//# - **HYPO-7** An ROI of more than `N/2` black regions MUST be refused (`TooManyBars`).
//= reference/SPEC.md#hypo
//# - **HYPO-8** An ROI that begins with the first pixel of the line or ends with the last MUST be refused (`CutOff`).
//= reference/SPEC.md#hypo
//# - **HYPO-10** HYPO-12, HYPO-6 to HYPO-9 and then HYPO-11 MUST be applied in this order and the first that holds be
//# reported.
//= reference/SPEC.md#hypo
//# - **HYPO-11** An ROI whose extent is below 5/4 of a pixel per stripe, `4 e < 5 N`, MUST be refused (`TooNarrow`).
//= reference/SPEC.md#hypo
//# - **HYPO-12** An ROI of the local threshold that shares a pixel with an ROI of the same line which was decoded in
//# the same format by the global threshold MUST be refused (`Repeated`).
pub fn check(
    hypothesis: &Hypothesis,
    regions: &[Region],
    format: Format,
    decoded_before: &[Hypothesis],
) -> Result<(), HypothesisRefusal> {
    let bars = (hypothesis.last_region - hypothesis.first_region) / 2 + 1;
    let checks = [
        (decoded_before.iter().any(|before| hypothesis.overlaps(before)), HypothesisRefusal::Repeated),
        (bars < 2 * GUARD_PAIRS, HypothesisRefusal::TooFewBars),
        (bars > format.stripes() / 2, HypothesisRefusal::TooManyBars),
        (hypothesis.first_region == 0 || hypothesis.last_region + 1 == regions.len(), HypothesisRefusal::CutOff),
        (!has_quiet_zones(hypothesis, regions, format), HypothesisRefusal::QuietZone),
        (4 * hypothesis.extent() < 5 * format.stripes(), HypothesisRefusal::TooNarrow),
    ];
    match checks.iter().find(|(refused, _)| *refused) {
        Some((_, refusal)) => Err(*refusal),
        None => Ok(()),
    }
}

/// HYPO-9; a white region that reaches an end of the line may be any part of a quiet zone.
//= reference/SPEC.md#hypo
//# - **HYPO-9** An ROI beside which a white region of `q` pixels that does not reach an end of the line has `N (q + 1)
//# < 2 e` MUST be refused (`QuietZone`), since LAND-5 asks for 2.5 stripes.
fn has_quiet_zones(hypothesis: &Hypothesis, regions: &[Region], format: Format) -> bool {
    let wide_enough = |i: usize| (regions[i].width() + 1) * format.stripes() >= 2 * hypothesis.extent();
    let left = hypothesis.first_region <= 1 || wide_enough(hypothesis.first_region - 1);
    let right = hypothesis.last_region + 2 >= regions.len() || wide_enough(hypothesis.last_region + 1);
    left && right
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regions of the given widths, the first one white.
    fn alternating(widths: &[usize]) -> Vec<Region> {
        let mut next = 0;
        let mut regions = Vec::new();
        for (i, width) in widths.iter().enumerate() {
            let colour = if i % 2 == 0 { Colour::White } else { Colour::Black };
            regions.push(Region { colour, first: next, last: next + width - 1 });
            next += width;
        }
        regions
    }

    fn rois(widths: &[usize]) -> Vec<(usize, usize)> {
        hypotheses(&alternating(widths), Format::Paper).iter().map(|h| (h.first_region, h.last_region)).collect()
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-1** The seed MUST be the narrowest black region that no ROI has taken yet, the left-most of equals.
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-5** ROIs MUST be formed, seed after seed, until every black region is taken.
    #[test]
    fn the_left_most_of_equally_narrow_regions_is_the_seed() {
        // Seeds of 1 px reach 50 px; these are 60 px apart.
        assert_eq!(rois(&[9, 2, 60, 1, 60, 1, 9]), [(3, 3), (5, 5), (1, 1)]);
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-2** A neighbour of the ROI MUST be the next black region to its left or right, if no ROI has taken it
    //# and if with it the ROI's extent `e` keeps to `2 e <= 5 N w`, with `w` the seed's width in pixels.
    //= reference/SPEC.md#errata
    //= type=test
    //# - **ERRATA-10** The ROI rule, which ignores perspective and leaves open how far the growth reaches, MUST be read
    //# as HYPO-1 to HYPO-5.
    #[test]
    fn growth_stops_at_two_and_a_half_predicted_widths() {
        // Seed 1 px, N = 20: the extent may reach 50 px, and does with a gap of 47.
        assert_eq!(rois(&[9, 1, 47, 2, 9]), [(1, 3)]);
        assert_eq!(rois(&[9, 1, 48, 2, 9]), [(1, 1), (3, 3)]);
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-3** The ROI MUST grow, as long as it has a neighbour, by the one across the smaller white gap, the left
    //# one of equals.
    #[test]
    fn growth_takes_the_smaller_gap_first_and_the_left_one_of_equals() {
        // From the seed (region 3) the extent may reach 50 px: only one neighbour fits.
        assert_eq!(rois(&[9, 10, 20, 1, 19, 10, 9])[0], (3, 5));
        assert_eq!(rois(&[9, 10, 19, 1, 19, 10, 9])[0], (1, 3));
        // A neighbour too far away does not hide the other one.
        assert_eq!(rois(&[9, 40, 10, 1, 19, 10, 9])[0], (3, 5));
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-4** An ROI MUST take all of its black regions, whether it is decoded or refused.
    #[test]
    fn growth_does_not_take_what_another_roi_has() {
        // The seed at region 1 (1 px) takes region 3; region 5 (2 px wide) finds it taken.
        assert_eq!(rois(&[9, 1, 10, 30, 30, 2, 9]), [(1, 3), (5, 5)]);
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-6** An ROI of fewer than `2 N_guard` black regions MUST be refused (`TooFewBars`).
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-7** An ROI of more than `N/2` black regions MUST be refused (`TooManyBars`).
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-8** An ROI that begins with the first pixel of the line or ends with the last MUST be refused
    //# (`CutOff`).
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-9** An ROI beside which a white region of `q` pixels that does not reach an end of the line has `N (q +
    //# 1) < 2 e` MUST be refused (`QuietZone`), since LAND-5 asks for 2.5 stripes.
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-10** HYPO-12, HYPO-6 to HYPO-9 and then HYPO-11 MUST be applied in this order and the first that holds
    //# be reported.
    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-11** An ROI whose extent is below 5/4 of a pixel per stripe, `4 e < 5 N`, MUST be refused
    //# (`TooNarrow`).
    #[test]
    fn checks_are_applied_in_order() {
        let outcome = |widths: &[usize], first, last| {
            let regions = alternating(widths);
            check(&Hypothesis::new(&regions, first, last), &regions, Format::Paper, &[])
        };
        let bars = |n: usize, margin: usize| {
            let mut widths = vec![margin];
            widths.extend(vec![4; 2 * n - 1]);
            widths.push(margin);
            widths
        };
        assert_eq!(outcome(&bars(3, 9), 1, 5), Err(HypothesisRefusal::TooFewBars));
        assert_eq!(outcome(&bars(4, 9), 1, 7), Ok(()));
        assert_eq!(outcome(&bars(10, 9), 1, 19), Ok(()));
        assert_eq!(outcome(&bars(11, 9), 1, 21), Err(HypothesisRefusal::TooManyBars));
        // Without its last white region the ROI ends the line.
        assert_eq!(outcome(&bars(4, 9)[..8], 1, 7), Err(HypothesisRefusal::CutOff));
        // Extent 28 px: a quiet zone between bars must have 28/20, so 2 px; one at the end of the line any.
        let neighbour = |gap: usize| [&[9, 5, gap][..], &[4; 7][..], &[1][..]].concat();
        assert_eq!(outcome(&neighbour(2), 3, 9), Ok(()));
        assert_eq!(outcome(&neighbour(1), 3, 9), Err(HypothesisRefusal::QuietZone));
        // N = 20: 25 px are enough.
        assert_eq!(outcome(&[9, 4, 4, 4, 4, 4, 2, 3, 9], 1, 7), Ok(()));
        assert_eq!(outcome(&[9, 4, 4, 4, 4, 4, 2, 2, 9], 1, 7), Err(HypothesisRefusal::TooNarrow));
        // Of two reasons the first: 3 bars of which the last ends the line, 4 that do beside a space of 1 px, 21 px beside one.
        assert_eq!(outcome(&bars(3, 9)[..6], 1, 5), Err(HypothesisRefusal::TooFewBars));
        assert_eq!(outcome(&neighbour(1)[..10], 3, 9), Err(HypothesisRefusal::CutOff));
        assert_eq!(outcome(&[9, 5, 1, 3, 3, 3, 3, 3, 3, 3, 9], 3, 9), Err(HypothesisRefusal::QuietZone));
    }

    //= reference/SPEC.md#hypo
    //= type=test
    //# - **HYPO-12** An ROI of the local threshold that shares a pixel with an ROI of the same line which was decoded
    //# in the same format by the global threshold MUST be refused (`Repeated`).
    #[test]
    fn what_shares_a_pixel_with_a_decoded_roi_is_repeated() {
        // Bars of 4 px from 20 to 47; with the third bar as its last one the ROI is also too small.
        let regions = alternating(&[20, 4, 4, 4, 4, 4, 4, 4, 20]);
        let before = |first_pixel, last_pixel| Hypothesis { first_region: 1, last_region: 1, first_pixel, last_pixel };
        let outcome =
            |last, decoded: &[Hypothesis]| check(&Hypothesis::new(&regions, 1, last), &regions, Format::Paper, decoded);
        assert_eq!(outcome(7, &[before(0, 19), before(48, 60)]), Ok(()));
        assert_eq!(outcome(7, &[before(48, 60), before(0, 20)]), Err(HypothesisRefusal::Repeated));
        assert_eq!(outcome(7, &[before(47, 60)]), Err(HypothesisRefusal::Repeated));
        assert_eq!(outcome(7, &[before(30, 31)]), Err(HypothesisRefusal::Repeated));
        assert_eq!(outcome(7, &[before(0, 479)]), Err(HypothesisRefusal::Repeated));
        // The first of all checks.
        assert_eq!(outcome(5, &[]), Err(HypothesisRefusal::TooFewBars));
        assert_eq!(outcome(5, &[before(30, 31)]), Err(HypothesisRefusal::Repeated));
    }
}
