//! Thresholds of a scan line, one for the whole line and one for every pixel (THRESH).

use crate::refusal::LineRefusal;

/// Smallest range in grey levels that is looked at (THRESH-4, THRESH-7).
pub const MIN_RANGE: i32 = 24;

/// Pixels of a block; the windows of the local threshold end where blocks do (THRESH-5).
pub const BLOCK: usize = 16;

/// Whole blocks that a window reaches beyond the pixel's own (THRESH-5).
pub const REACH: usize = 8;

/// Which of a line's two thresholds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Thresholding {
    /// From the extremes of the line (THRESH-1).
    Global,
    /// From the extremes to either side of each pixel (THRESH-6).
    Local,
}

/// A threshold, as the two values whose mean it is (THRESH-1, THRESH-6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threshold {
    /// What counts as dark: the smallest value of the line, or `low(i)`.
    pub darkest: u8,
    /// What counts as bright: the largest value of the line, or `high(i)`.
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
}

/// The global threshold of a scan line, refused where its contrast is low (THRESH-1, THRESH-4).
//= reference/SPEC.md#thresh
//# - **THRESH-1** The global threshold MUST be the mean of the scan line's largest and smallest value, kept as their
//# sum `T2`.
//= reference/SPEC.md#thresh
//# - **THRESH-4** A scan line whose range is below 24 grey levels MUST be refused (`LowContrast`).
pub fn threshold(line: &[u8]) -> Result<Threshold, LineRefusal> {
    let darkest = line.iter().copied().min().ok_or(LineRefusal::Width)?;
    let brightest = line.iter().copied().max().ok_or(LineRefusal::Width)?;
    let threshold = Threshold { darkest, brightest };
    if threshold.range() < MIN_RANGE { Err(LineRefusal::LowContrast) } else { Ok(threshold) }
}

/// A scan line and its threshold at each of its pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thresholded<'a> {
    line: &'a [u8],
    thresholding: Thresholding,
    thresholds: Vec<Threshold>,
}

impl<'a> Thresholded<'a> {
    /// A line by its global threshold, which [`threshold`] found.
    #[must_use]
    pub fn global(line: &'a [u8], threshold: Threshold) -> Self {
        Self { line, thresholding: Thresholding::Global, thresholds: vec![threshold; line.len()] }
    }

    /// A line by its local threshold.
    #[must_use]
    pub fn local(line: &'a [u8]) -> Self {
        let thresholds = (0..line.len()).map(|i| local_threshold(line, i)).collect();
        Self { line, thresholding: Thresholding::Local, thresholds }
    }

    /// Which threshold it is.
    #[must_use]
    pub fn thresholding(&self) -> Thresholding {
        self.thresholding
    }

    /// Pixels of the line.
    #[must_use]
    pub fn width(&self) -> usize {
        self.line.len()
    }

    /// Twice the threshold at pixel `i`, `T2(i)`, in grey levels.
    #[must_use]
    pub fn twice(&self, i: usize) -> i32 {
        self.thresholds[i].twice()
    }

    /// Twice the distance of pixel `i` from its threshold, in grey levels; negative where it is black.
    #[must_use]
    pub fn contrast(&self, i: usize) -> i32 {
        2 * i32::from(self.line[i]) - self.twice(i)
    }

    /// THRESH-2, THRESH-7; the global range is never below [`MIN_RANGE`] (THRESH-4).
    //= reference/SPEC.md#thresh
    //# - **THRESH-2** By the global threshold a pixel of value `I` MUST be black where `2 I < T2`, and white otherwise.
    //= reference/SPEC.md#thresh
    //# - **THRESH-7** By the local threshold a pixel MUST be black where `R(i) >= 24` and `2 I < T2(i)`, and white
    //# otherwise.
    #[must_use]
    pub fn is_black(&self, i: usize) -> bool {
        self.has_range(i) && self.contrast(i) < 0
    }

    /// THRESH-3, THRESH-8
    //= reference/SPEC.md#thresh
    //# - **THRESH-3** By the global threshold a pixel MUST be *distinct* where `8 |2 I - T2| >= R`, that is where it is
    //# at least 1/16 of the range from the threshold.
    //= reference/SPEC.md#thresh
    //# - **THRESH-8** By the local threshold a pixel MUST be distinct where `R(i) < 24` or `8 |2 I - T2(i)| >= R(i)`.
    #[must_use]
    pub fn is_distinct(&self, i: usize) -> bool {
        !self.has_range(i) || 8 * self.contrast(i).abs() >= self.thresholds[i].range()
    }

    fn has_range(&self, i: usize) -> bool {
        self.thresholds[i].range() >= MIN_RANGE
    }
}

/// THRESH-5, THRESH-6
//= reference/SPEC.md#thresh
//# - **THRESH-5** The left window of pixel `i` MUST be the pixels from `max(0, 16 (b - 8))` to `i`, and its right
//# window those from `i` to `min(Q_x - 1, 16 (b + 8) + 15)`, with `b = floor(i/16)`.
//= reference/SPEC.md#thresh
//# - **THRESH-6** With `high(i)` the smaller of both windows' largest values and `low(i)` the larger of the smallest
//# values of the left window with pixel `i + 1` and of the right window with pixel `i - 1`, as far as the line has
//# them, the local threshold MUST have `T2(i) = high(i) + low(i)` and `R(i) = high(i) - low(i)`.
fn local_threshold(line: &[u8], i: usize) -> Threshold {
    let block = i / BLOCK;
    let (first, end) = (BLOCK * block.saturating_sub(REACH), line.len().min(BLOCK * (block + REACH + 1)));
    let (left, right) = (&line[first..=i], &line[i..end]);
    let (left_and_next, right_and_before) = (&line[first..line.len().min(i + 2)], &line[i.saturating_sub(1)..end]);
    // Folds over bytes, which the compiler vectorises.
    let largest = |window: &[u8]| window.iter().fold(0, |largest: u8, &pixel| largest.max(pixel));
    let smallest = |window: &[u8]| window.iter().fold(u8::MAX, |smallest, &pixel| smallest.min(pixel));
    let high = largest(left).min(largest(right));
    let low = smallest(left_and_next).max(smallest(right_and_before));
    Threshold { darkest: low, brightest: high }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn global(line: &[u8]) -> Thresholded<'_> {
        Thresholded::global(line, threshold(line).unwrap())
    }

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-1** The global threshold MUST be the mean of the scan line's largest and smallest value, kept as
    //# their sum `T2`.
    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-2** By the global threshold a pixel of value `I` MUST be black where `2 I < T2`, and white otherwise.
    #[test]
    fn a_pixel_on_the_threshold_is_white() {
        let line = [40, 200, 120, 119, 121];
        assert_eq!(threshold(&line), Ok(Threshold { darkest: 40, brightest: 200 }));
        let found = global(&line);
        assert_eq!([0, 1, 2, 3, 4].map(|i| found.is_black(i)), [true, false, false, true, false]);
        assert_eq!([0, 1, 2, 3, 4].map(|i| found.contrast(i)), [-160, 160, 0, -2, 2]);
    }

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-3** By the global threshold a pixel MUST be *distinct* where `8 |2 I - T2| >= R`, that is where it is
    //# at least 1/16 of the range from the threshold.
    #[test]
    fn distinct_begins_at_a_sixteenth_of_the_range() {
        // Range 160: the distance is 10 grey levels.
        let line = [40, 200, 110, 111, 130, 129];
        let found = global(&line);
        assert_eq!([2, 3, 4, 5].map(|i| found.is_distinct(i)), [true, false, true, false]);
    }

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-4** A scan line whose range is below 24 grey levels MUST be refused (`LowContrast`).
    #[test]
    fn contrast_below_24_is_refused() {
        assert_eq!(threshold(&[100, 123]), Err(LineRefusal::LowContrast));
        assert!(threshold(&[100, 124]).is_ok());
    }

    /// A line of 480 grey pixels of 100 with some others.
    fn grey_with(others: &[(usize, u8)]) -> Vec<u8> {
        let mut line = vec![100; 480];
        for &(i, value) in others {
            line[i] = value;
        }
        line
    }

    /// The pixels where the local threshold is not that of an even grey.
    fn affected(others: &[(usize, u8)]) -> Vec<usize> {
        let line = grey_with(others);
        let found = Thresholded::local(&line);
        (0..480).filter(|&i| found.twice(i) != 200).collect()
    }

    /// One bright pixel far left and one far right: both are needed, so the reach of one window is seen beside the other.
    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-5** The left window of pixel `i` MUST be the pixels from `max(0, 16 (b - 8))` to `i`, and its right
    //# window those from `i` to `min(Q_x - 1, 16 (b + 8) + 15)`, with `b = floor(i/16)`.
    #[test]
    fn windows_are_one_sided_and_end_with_blocks() {
        // Pixel 16 is in the left window of the pixels up to block 1 + 8, which ends with 159; pixel 191 in the right
        // window of those from block 11 - 8 on, which begins with 48.
        assert_eq!(affected(&[(16, 200), (191, 200)]), [vec![16], (48..160).collect(), vec![191]].concat());
        // What is dark also counts for its neighbours.
        let darkened = [(30..33).collect::<Vec<_>>(), (48..160).collect(), (175..178).collect()].concat();
        assert_eq!(affected(&[(31, 20), (176, 20)]), darkened);
        // Farther apart than both windows reach, only the pixels themselves see either.
        assert_eq!(affected(&[(15, 200), (352, 200)]), [15, 352]);
        // One pixel of 200 is bright to both of its own sides and to one side of the others.
        assert_eq!(affected(&[(240, 200)]), [240]);
        // The ends of the line cut the windows off.
        assert_eq!(affected(&[(0, 200), (20, 200)]), (0..=20).collect::<Vec<_>>());
        assert_eq!(affected(&[(470, 200), (479, 200)]), (470..480).collect::<Vec<_>>());
    }

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-6** With `high(i)` the smaller of both windows' largest values and `low(i)` the larger of the
    //# smallest values of the left window with pixel `i + 1` and of the right window with pixel `i - 1`, as far as the
    //# line has them, the local threshold MUST have `T2(i) = high(i) + low(i)` and `R(i) = high(i) - low(i)`.
    #[test]
    fn what_is_bright_on_both_sides_counts() {
        // Of 200 and 180 the smaller is bright to both sides, of 40 and 20 the larger is dark to both.
        let line = grey_with(&[(230, 200), (231, 40), (250, 20), (251, 180)]);
        let found = Thresholded::local(&line);
        assert_eq!(found.twice(240), 180 + 40);
        assert_eq!(found.contrast(240), 200 - 220);
        assert!(found.is_black(240) && found.is_distinct(240));
    }

    /// A shadow edge between 245 and 246 that divides the light by 3, with bars of 4 px on either side.
    #[test]
    fn a_bar_is_black_on_either_side_of_a_shadow_edge() {
        let line: Vec<u8> = (0..480)
            .map(|i| match (i < 246, (220..260).contains(&i) && i / 4 % 2 == 1) {
                (true, false) => 210,
                (true, true) => 30,
                (false, false) => 70,
                (false, true) => 10,
            })
            .collect();
        let (by_local, by_global) = (Thresholded::local(&line), global(&line));
        for i in 0..480 {
            let bar = (220..260).contains(&i) && i / 4 % 2 == 1;
            assert_eq!(by_local.is_black(i), bar, "pixel {i}");
            assert!(by_local.is_distinct(i), "pixel {i}");
        }
        // The global one takes the shadow's white for black.
        assert!(by_global.is_black(300));
    }

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-7** By the local threshold a pixel MUST be black where `R(i) >= 24` and `2 I < T2(i)`, and white
    //# otherwise.
    #[test]
    fn without_a_local_range_of_24_a_pixel_is_white_and_distinct() {
        // Bright to both sides 123 or 124, dark 100; 111 is below the mean of both, by less than a sixteenth.
        for (bright, black) in [(123, false), (124, true)] {
            let line = grey_with(&[(235, bright), (240, 111), (245, bright)]);
            let found = Thresholded::local(&line);
            assert!(found.contrast(240) < 0);
            assert_eq!((found.is_black(240), found.is_distinct(240)), (black, !black));
        }
    }

    //= reference/SPEC.md#thresh
    //= type=test
    //# - **THRESH-8** By the local threshold a pixel MUST be distinct where `R(i) < 24` or `8 |2 I - T2(i)| >= R(i)`.
    #[test]
    fn local_distinct_begins_at_a_sixteenth_of_the_local_range() {
        // Range 160 about 120 between 230 and 250.
        for (value, distinct) in [(110, true), (111, false), (129, false), (130, true)] {
            let line = grey_with(&[(230, 40), (231, 200), (240, value), (249, 200), (250, 40)]);
            assert_eq!(Thresholded::local(&line).is_distinct(240), distinct, "{value}");
        }
    }
}
