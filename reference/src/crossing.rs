//! Crossings: where in an ROI the line passes the threshold (CROSS).

use crate::hypotheses::Hypothesis;
use crate::threshold::Thresholded;

/// Where a transition lies between its two pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CrossingRule {
    /// Where the straight line between both grey values crosses the threshold (CROSS-2).
    #[default]
    Interpolated,
    /// Half way, the paper's rule (CROSS-3).
    WholePixel,
}

/// A transition that has been given the barcode edge it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// `v`: the edge, counted from the barcode's middle, left negative.
    pub edge: i32,
    /// `z`: the column relative to the ROI's middle, in units of `2^-Q` px.
    pub column: i32,
}

/// Fraction bits `Q` of the crossings of an ROI (CROSS-1).
//= reference/SPEC.md#cross
//# - **CROSS-1** `Q` MUST be the largest integer for which `(e + 1) 2^Q <= 4096`, e being the ROI's extent.
#[must_use]
pub fn subpixel_bits(hypothesis: &Hypothesis) -> u32 {
    (4096 / (hypothesis.extent() + 1)).max(2).ilog2()
}

/// Column `z` of the transition between the pixels `i` and `i + 1` of an ROI, in units of `2^-Q` px.
#[must_use]
pub fn crossing(line: &Thresholded<'_>, rule: CrossingRule, roi: &Hypothesis, i: usize) -> i32 {
    let unit = 1 << subpixel_bits(roi);
    let fraction = match rule {
        //= reference/SPEC.md#cross
        //# - **CROSS-2** By the `interpolated` rule, the default, the transition between the pixels `i` and `i + 1`
        //# MUST lie at `i + e_0/(e_0 + e_1)`, with `e_0 = |2 I_i - T2(i)|` and `e_1 = |2 I_{i+1} - T2(i+1)|`, rounded
        //# to the nearest unit, halves up.
        CrossingRule::Interpolated => {
            let before = line.contrast(i).abs();
            let after = line.contrast(i + 1).abs();
            // Rounded half up; both contrasts cannot be 0, since a black pixel's is below.
            (2 * unit * before + before + after) / (2 * (before + after))
        }
        //= reference/SPEC.md#cross
        //# - **CROSS-3** By the `whole-pixel` rule, the paper's, the transition MUST lie at `i + 1/2`.
        CrossingRule::WholePixel => unit / 2,
    };
    let twice_from_middle = 2 * signed(i) - signed(roi.first_pixel + roi.last_pixel);
    unit / 2 * twice_from_middle + fraction
}

/// A pixel number as a signed integer: lines are at most 640 px long.
fn signed(pixel: usize) -> i32 {
    i32::try_from(pixel).unwrap_or(i32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threshold::Threshold;

    fn roi(first_pixel: usize, last_pixel: usize) -> Hypothesis {
        Hypothesis { first_region: 1, last_region: 1, first_pixel, last_pixel }
    }

    //= reference/SPEC.md#cross
    //= type=test
    //# - **CROSS-1** `Q` MUST be the largest integer for which `(e + 1) 2^Q <= 4096`, e being the ROI's extent.
    #[test]
    fn resolution_follows_the_extent() {
        let bits = |extent: usize| subpixel_bits(&roi(0, extent - 1));
        assert_eq!(
            [15, 16, 31, 32, 63, 64, 127, 128, 255, 256, 511, 512, 640].map(bits),
            [8, 7, 7, 6, 6, 5, 5, 4, 4, 3, 3, 2, 2]
        );
    }

    //= reference/SPEC.md#cross
    //= type=test
    //# - **CROSS-2** By the `interpolated` rule, the default, the transition between the pixels `i` and `i + 1` MUST
    //# lie at `i + e_0/(e_0 + e_1)`, with `e_0 = |2 I_i - T2(i)|` and `e_1 = |2 I_{i+1} - T2(i+1)|`, rounded to the
    //# nearest unit, halves up.
    //= reference/SPEC.md#cross
    //= type=test
    //# - **CROSS-3** By the `whole-pixel` rule, the paper's, the transition MUST lie at `i + 1/2`.
    #[test]
    fn crossings_are_interpolated_and_rounded_half_up() {
        let threshold = Threshold { darkest: 0, brightest: 200 };
        let z = |line: &[u8], rule, roi: &Hypothesis| crossing(&Thresholded::global(line, threshold), rule, roi, 3);
        // Extent 63: Q = 6. From 200 (contrast 200) to 50 (contrast -100): 2/3 of the way is 42.67 units.
        let line = [&[200; 4][..], &[50; 70][..]].concat();
        assert_eq!(z(&line, CrossingRule::Interpolated, &roi(4, 66)), 64 * (3 - 35) + 43);
        assert_eq!(z(&line, CrossingRule::WholePixel, &roi(4, 66)), 64 * (3 - 35) + 32);
        // Extent 64: Q = 5 and a middle on a half pixel. 1/64 of a pixel is half a unit and rounds up.
        let line = [[101; 4], [37; 4]].concat();
        assert_eq!(z(&line, CrossingRule::Interpolated, &roi(4, 67)), 16 * (6 - 71) + 1);
    }

    /// The bar's first pixel has its own threshold: white to its right is 100, to its left also 200.
    #[test]
    fn each_pixel_has_its_own_threshold() {
        // Pixels 0..4 of 200, then black of 20 to 66, then 100.
        let line = [&[200; 4][..], &[20; 63], &[100; 13]].concat();
        let local = Thresholded::local(&line);
        // Pixel 3: high 200, low 20, since the pixel to its right counts for either window: T2 = 220 and a contrast of 180.
        // Pixel 4: high 100, low 20, so T2 = 120 and a contrast of -80: the transition lies 9/13 of the way.
        assert_eq!((local.contrast(3), local.contrast(4)), (180, -80));
        assert_eq!(crossing(&local, CrossingRule::Interpolated, &roi(4, 66), 3), 64 * (3 - 35) + 44);
    }
}
