//! Where barcodes may be whose stripes the threshold merges (EXTENT).

use crate::landmark::Format;
use crate::threshold::Threshold;

/// Largest difference in pixels between the ends of two extents of one barcode (EXTENT-4).
const PAIR_DISTANCE: usize = 2;

/// Most pairs of a format that are tried (EXTENT-7).
pub const MAX_PAIRS: usize = 4;

/// From the first to the last dark pixel of what may be a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// First dark pixel.
    pub first: usize,
    /// Last dark pixel.
    pub last: usize,
}

impl Extent {
    /// Its width `e` in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.last + 1 - self.first
    }
}

/// An upper and a lower extent.
pub type Pair = [Extent; 2];

/// The extents of a line, by their first and then by their last pixel (EXTENT-1 to EXTENT-3).
//= reference/SPEC.md#extent
//# - **EXTENT-2** An extent MUST reach from the first pixel of a maximal run of dark pixels to the last pixel of the
//# same or a later one, with `e >= N` and `4 e <= 9 N`.
//= reference/SPEC.md#extent
//# - **EXTENT-3** On either side of an extent there MUST be `q` pixels of the line that are not dark with `N (q + 1) >=
//# 2 e`.
#[must_use]
pub fn of_line(line: &[u8], threshold: &Threshold, format: Format) -> Vec<Extent> {
    let runs = dark_runs(line, threshold);
    let n = format.stripes();
    let mut extents = Vec::new();
    for (i, from) in runs.iter().enumerate() {
        let light_before = from.first - i.checked_sub(1).map_or(0, |before| runs[before].last + 1);
        for (j, to) in runs.iter().enumerate().skip(i) {
            let extent = Extent { first: from.first, last: to.last };
            let light_after = runs.get(j + 1).map_or(line.len(), |after| after.first) - to.last - 1;
            let e = extent.width();
            let has_quiet_zones = n * (light_before.min(light_after) + 1) >= 2 * e;
            if e >= n && 4 * e <= 9 * n && has_quiet_zones {
                extents.push(extent);
            }
        }
    }
    extents
}

/// The maximal runs of dark pixels (EXTENT-1).
//= reference/SPEC.md#extent
//# - **EXTENT-1** A pixel MUST be dark where `4 I < 3 brightest + darkest`, with the line's extreme values.
fn dark_runs(line: &[u8], threshold: &Threshold) -> Vec<Extent> {
    let limit = 3 * i32::from(threshold.brightest) + i32::from(threshold.darkest);
    let mut runs: Vec<Extent> = Vec::new();
    for (pixel, _) in line.iter().enumerate().filter(|(_, value)| 4 * i32::from(**value) < limit) {
        match runs.last_mut() {
            Some(run) if run.last + 1 == pixel => run.last = pixel,
            _ => runs.push(Extent { first: pixel, last: pixel }),
        }
    }
    runs
}

/// All pairs of the extents of two lines, in the order of EXTENT-6 (EXTENT-4).
//= reference/SPEC.md#extent
//# - **EXTENT-4** An upper and a lower extent MUST be paired where their first pixels differ by at most 2 px and their
//# last pixels by at most 2 px.
//= reference/SPEC.md#extent
//# - **EXTENT-6** Pairs MUST be tried in the order of the upper extent's first pixel, its last pixel, the lower
//# extent's first pixel and its last pixel.
pub fn extents(upper: &[Extent], lower: &[Extent]) -> impl Iterator<Item = Pair> {
    let near = |one: usize, other: usize| one.abs_diff(other) <= PAIR_DISTANCE;
    upper.iter().flat_map(move |u| {
        lower.iter().filter(move |l| near(u.first, l.first) && near(u.last, l.last)).map(move |l| [*u, *l])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK_AND_WHITE: Threshold = Threshold { darkest: 0, brightest: 200 };

    /// A line of 200 with 0 at the given runs of pixels.
    fn line(runs: &[(usize, usize)]) -> Vec<u8> {
        let mut line = vec![200; 120];
        for &(first, last) in runs {
            line[first..=last].fill(0);
        }
        line
    }

    fn found(runs: &[(usize, usize)], format: Format) -> Vec<(usize, usize)> {
        of_line(&line(runs), &BLACK_AND_WHITE, format).iter().map(|extent| (extent.first, extent.last)).collect()
    }

    //= reference/SPEC.md#extent
    //= type=test
    //# - **EXTENT-1** A pixel MUST be dark where `4 I < 3 brightest + darkest`, with the line's extreme values.
    #[test]
    fn a_quarter_of_the_range_below_white_is_dark() {
        let mut grey = line(&[]);
        grey[50..=75].fill(149);
        assert_eq!(of_line(&grey, &BLACK_AND_WHITE, Format::Paper).len(), 1);
        grey[50..=75].fill(150);
        assert_eq!(of_line(&grey, &BLACK_AND_WHITE, Format::Paper).len(), 0);
    }

    //= reference/SPEC.md#extent
    //= type=test
    //# - **EXTENT-2** An extent MUST reach from the first pixel of a maximal run of dark pixels to the last pixel of
    //# the same or a later one, with `e >= N` and `4 e <= 9 N`.
    #[test]
    fn extents_have_one_to_two_and_a_quarter_pixels_per_stripe() {
        assert_eq!(found(&[(40, 58)], Format::Paper), []);
        assert_eq!(found(&[(40, 59)], Format::Paper), [(40, 59)]);
        assert_eq!(found(&[(40, 84)], Format::Paper), [(40, 84)]);
        assert_eq!(found(&[(40, 85)], Format::Paper), []);
        assert_eq!(found(&[(40, 93)], Format::Wide), [(40, 93)]);
    }

    //= reference/SPEC.md#extent
    //= type=test
    //# - **EXTENT-3** On either side of an extent there MUST be `q` pixels of the line that are not dark with `N (q +
    //# 1) >= 2 e`.
    #[test]
    fn quiet_zones_are_two_stripes_less_a_pixel() {
        // 30 px: 20 (q + 1) >= 60, so two light pixels are enough and one is not.
        assert_eq!(found(&[(2, 31)], Format::Paper), [(2, 31)]);
        assert_eq!(found(&[(1, 30)], Format::Paper), []);
        assert_eq!(found(&[(5, 34), (37, 39)], Format::Paper), [(5, 34), (5, 39)]);
        assert_eq!(found(&[(5, 34), (36, 39)], Format::Paper), [(5, 39)]);
    }

    //= reference/SPEC.md#extent
    //= type=test
    //# - **EXTENT-4** An upper and a lower extent MUST be paired where their first pixels differ by at most 2 px and
    //# their last pixels by at most 2 px.
    #[test]
    fn extents_are_paired_where_both_ends_are_near() {
        let at = |first, last| Extent { first, last };
        let upper = [at(40, 70), at(40, 75)];
        let lower = [at(38, 72), at(42, 77), at(43, 70)];
        let pairs: Vec<Pair> = extents(&upper, &lower).collect();
        assert_eq!(pairs, [[upper[0], lower[0]], [upper[1], lower[1]]]);
    }
}
