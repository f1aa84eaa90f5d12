//! Extents: where in both lines a barcode may be whose stripes the threshold merges.

use crate::landmark::Format;
use crate::threshold::Threshold;

/// The first and the last pixel of an extent.
pub type Extent = (u16, u16);

/// A scan line, as far as its pixels are dark or not (`EXTENT-1`).
#[derive(Clone, Copy, Debug)]
pub struct Shade<'a> {
    line: &'a [u8],
    /// Four times the value from which on a pixel is not dark, 0 to 1020.
    limit: u16,
}

impl<'a> Shade<'a> {
    /// A line, with its global threshold.
    //= reference/SPEC.md#extent
    //# - **EXTENT-1** A pixel MUST be dark where `4 I < 3 brightest + darkest`, with the line's extreme values.
    #[must_use]
    pub fn new(line: &'a [u8], threshold: &Threshold) -> Self {
        Self { line, limit: 3 * u16::from(threshold.brightest) + u16::from(threshold.darkest) }
    }

    /// Whether a pixel is dark; `None` outside of the line.
    #[must_use]
    pub fn is_dark(&self, pixel: u16) -> Option<bool> {
        self.line.get(usize::from(pixel)).map(|&value| 4 * u16::from(value) < self.limit)
    }

    fn is_white(&self, pixel: u16) -> bool {
        self.is_dark(pixel) == Some(false)
    }

    /// Whether these pixels are an extent of the format (`EXTENT-2`, `EXTENT-3`).
    //= reference/SPEC.md#extent
    //# - **EXTENT-2** An extent MUST reach from the first pixel of a maximal run of dark pixels to the last pixel of
    //# the same or a later one, with `e >= N` and `4 e <= 9 N`.
    //= reference/SPEC.md#extent
    //# - **EXTENT-3** On either side of an extent there MUST be `q` pixels of the line that are not dark with `N (q +
    //# 1) >= 2 e`.
    #[must_use]
    pub fn is_extent(&self, format: Format, extent: Extent) -> bool {
        let (first, last) = extent;
        let Some(beyond) = last.checked_sub(first) else { return false };
        let pixels = u32::from(beyond) + 1;
        let stripes = u32::from(format.stripes());
        if pixels < stripes || 4 * pixels > 9 * stripes {
            return false;
        }
        if self.is_dark(first) != Some(true) || self.is_dark(last) != Some(true) {
            return false;
        }
        // The least q with N (q + 1) >= 2 e, 1 to 4: what ends the runs of dark pixels is part of the quiet zone.
        let quiet = (1..=4_u16).find(|&q| stripes * (u32::from(q) + 1) >= 2 * pixels).unwrap_or(4);
        (1..=quiet).all(|distance| {
            let left = first.checked_sub(distance).is_some_and(|pixel| self.is_white(pixel));
            left && last.checked_add(distance).is_some_and(|pixel| self.is_white(pixel))
        })
    }

    /// The line's extents, in the order of their first and then of their last pixels.
    fn extents(&self, format: Format) -> impl Iterator<Item = Extent> + use<'a> {
        let (shortest, longest) = lengths(format);
        let shade = *self;
        let width = u16::try_from(self.line.len()).unwrap_or(u16::MAX);
        (1..width)
            .filter(move |&first| shade.is_white(first - 1) && shade.is_dark(first) == Some(true))
            .flat_map(move |first| (shortest..=longest).map(move |length| (first, first.saturating_add(length - 1))))
            .filter(move |&extent| shade.is_extent(format, extent))
    }
}

/// How many pixels an extent has at least and at most: `N` to `9 N/4` (`EXTENT-2`).
const fn lengths(format: Format) -> (u16, u16) {
    let stripes = format.stripes() as u16;
    (stripes, 9 * stripes / 4)
}

/// The pairs of extents of both lines, upper and lower (`EXTENT-4`), in the order of `EXTENT-6`.
//= reference/SPEC.md#extent
//# - **EXTENT-4** An upper and a lower extent MUST be paired where their first pixels differ by at most 2 px and their
//# last pixels by at most 2 px.
//= reference/SPEC.md#extent
//# - **EXTENT-6** Pairs MUST be tried in the order of the upper extent's first pixel, its last pixel, the lower
//# extent's first pixel and its last pixel.
pub fn extents<'a>(
    upper: Shade<'a>,
    lower: Shade<'a>,
    format: Format,
) -> impl Iterator<Item = (Extent, Extent)> + use<'a> {
    upper.extents(format).flat_map(move |(first, last)| {
        about(first)
            .flat_map(move |first| about(last).map(move |last| (first, last)))
            .filter(move |&extent| lower.is_extent(format, extent))
            .map(move |extent| ((first, last), extent))
    })
}

/// The pixels that are at most 2 px away.
fn about(pixel: u16) -> impl Iterator<Item = u16> + Clone {
    pixel.saturating_sub(2)..=pixel.saturating_add(2)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)] // of pixels and stripes

    use super::*;
    use crate::drawing::runs;
    use proptest::prelude::*;
    use std::vec::Vec;

    const BLACK_AND_WHITE: Threshold = Threshold { darkest: 0, brightest: 255 };

    fn shade(line: &[u8]) -> Shade<'_> {
        Shade::new(line, &BLACK_AND_WHITE)
    }

    fn of(widths: &[usize], format: Format) -> Vec<Extent> {
        shade(&runs(widths)).extents(format).collect()
    }

    //= reference/SPEC.md#extent
    //= type=test
    //# - **EXTENT-1** A pixel MUST be dark where `4 I < 3 brightest + darkest`, with the line's extreme values.
    #[test]
    fn a_quarter_of_the_range_below_the_brightest_is_dark() {
        // 3 * 201 + 101 = 704 = 4 * 176
        let threshold = Threshold { darkest: 101, brightest: 201 };
        let line = [175, 176, 177];
        let shade = Shade::new(&line, &threshold);
        assert_eq!([0, 1, 2, 3].map(|pixel| shade.is_dark(pixel)), [Some(true), Some(false), Some(false), None]);
    }

    /// `N` to `9 N/4` pixels: 20 to 45 and 24 to 54.
    //= reference/SPEC.md#extent
    //= type=test
    //# - **EXTENT-2** An extent MUST reach from the first pixel of a maximal run of dark pixels to the last pixel of
    //# the same or a later one, with `e >= N` and `4 e <= 9 N`.
    #[test]
    fn extents_have_one_to_two_and_a_quarter_pixels_per_stripe() {
        for (format, shortest, longest) in [(Format::Paper, 20, 45), (Format::Wide, 24, 54)] {
            let lengths: Vec<usize> = (1..70).filter(|&length| of(&[10, length, 10], format).len() == 1).collect();
            assert_eq!(lengths, (shortest..=longest).collect::<Vec<_>>());
            // Longer ones would be tried in vain.
            assert_eq!(super::lengths(format), (shortest as u16, longest as u16));
        }
    }

    #[test]
    fn an_extent_may_span_several_runs() {
        // Runs from 10 to 29, 35 to 39 and 45 to 54.
        let found = of(&[10, 20, 5, 5, 5, 10, 10], Format::Paper);
        assert_eq!(found, [(10, 29), (10, 39), (10, 54), (35, 54)]);
    }

    /// Of `paper`, 20 px ask for 1 px beside them, 21 px for 2 px, 30 px for 2 px, 31 px for 3 px, 45 px for 4 px.
    //= reference/SPEC.md#extent
    //= type=test
    //# - **EXTENT-3** On either side of an extent there MUST be `q` pixels of the line that are not dark with `N (q +
    //# 1) >= 2 e`.
    #[test]
    fn the_quiet_zone_is_white_and_in_the_line() {
        for (length, quiet) in [(20, 1), (21, 2), (30, 2), (31, 3), (40, 3), (41, 4), (45, 4)] {
            // Beside dark pixels that are too many, or at the line's end.
            for end in [100, 0] {
                let lines = |gap| [std::vec![0, end, gap, length, 10], std::vec![10, length, gap, end]];
                for widths in lines(quiet) {
                    assert_eq!(of(&widths, Format::Paper).len(), 1, "{widths:?}");
                }
                for widths in lines(quiet - 1) {
                    let alone = of(&widths, Format::Paper);
                    assert!(alone.is_empty(), "{widths:?} {alone:?}");
                }
            }
        }
    }

    //= reference/SPEC.md#extent
    //= type=test
    //# - **EXTENT-4** An upper and a lower extent MUST be paired where their first pixels differ by at most 2 px and
    //# their last pixels by at most 2 px.
    #[test]
    fn ends_may_differ_by_two_pixels() {
        let paired = |first: usize, length: usize| {
            let (upper, lower) = (runs(&[20, 30, 20]), runs(&[first, length, 20]));
            extents(shade(&upper), shade(&lower), Format::Paper).count() == 1
        };
        assert!(paired(18, 34) && paired(22, 26) && paired(18, 30) && paired(22, 30));
        assert!(!paired(17, 33) && !paired(23, 27) && !paired(20, 33) && !paired(20, 27));
    }

    /// Black and white pixels in runs of up to 9.
    fn line() -> impl Strategy<Value = Vec<u8>> {
        prop::collection::vec(1_usize..10, 1..40).prop_map(|widths| runs(&widths))
    }

    proptest! {
        /// Against EXTENT-2 to EXTENT-6 as they stand, tried on all pairs of pixels.
        //= reference/SPEC.md#extent
        //= type=test
        //# - **EXTENT-6** Pairs MUST be tried in the order of the upper extent's first pixel, its last pixel, the lower
        //# extent's first pixel and its last pixel.
        #[test]
        fn pairs_are_complete_and_in_order(upper in line(), lower in line(), wide in any::<bool>()) {
            let format = if wide { Format::Wide } else { Format::Paper };
            let n = i32::from(format.stripes());
            let all = |line: &[u8]| -> Vec<(i32, i32)> {
                let length = line.len() as i32;
                let value = |pixel: i32| if (0..length).contains(&pixel) { Some(line[pixel as usize]) } else { None };
                let quiet = |from: i32, step: i32| {
                    (1..length).take_while(|&i| value(from + i * step) == Some(255)).count() as i32
                };
                let mut found = Vec::new();
                for first in 0..length {
                    for last in first..length {
                        let e = last - first + 1;
                        let starts = value(first) == Some(0) && value(first - 1) != Some(0);
                        let ends = value(last) == Some(0) && value(last + 1) != Some(0);
                        let (left, right) = (quiet(first, -1), quiet(last, 1));
                        let zones = n * (left + 1) >= 2 * e && n * (right + 1) >= 2 * e;
                        if starts && ends && e >= n && 4 * e <= 9 * n && zones {
                            found.push((first, last));
                        }
                    }
                }
                found
            };
            let mut expected = Vec::new();
            for one in all(&upper) {
                for other in all(&lower) {
                    if (one.0 - other.0).abs() <= 2 && (one.1 - other.1).abs() <= 2 {
                        expected.push((one, other));
                    }
                }
            }
            expected.sort_unstable();
            let signed = |(first, last): Extent| (i32::from(first), i32::from(last));
            let found: Vec<_> = extents(shade(&upper), shade(&lower), format)
                .map(|(one, other)| (signed(one), signed(other)))
                .collect();
            prop_assert_eq!(found, expected);
        }
    }
}
