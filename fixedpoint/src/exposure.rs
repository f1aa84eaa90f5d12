//! When an image's rows were exposed.

use crate::refusal::ImageRefusal;

/// A time of the robot's clock in whole microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time(u64);

impl Time {
    /// The time so many microseconds after the clock's zero.
    #[must_use]
    pub const fn from_micros(micros: u64) -> Self {
        Self(micros)
    }

    /// Microseconds after the clock's zero.
    #[must_use]
    pub const fn as_micros(self) -> u64 {
        self.0
    }

    /// Microseconds from an earlier time to this one; 0 from a later one.
    #[must_use]
    pub const fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }

    /// So many microseconds later; the clock's last time if there is none.
    #[must_use]
    pub const fn after(self, micros: u64) -> Self {
        Self(self.0.saturating_add(micros))
    }

    /// Half-way between two times, whole microseconds rounded down.
    #[must_use]
    pub const fn midpoint(self, other: Self) -> Self {
        Self(self.0.midpoint(other.0))
    }
}

/// From when to when an image was captured, and until when it was processed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capture {
    start: Time,
    end: Time,
    processed: Time,
}

/// The longest capture, 1 s, in microseconds (`EXPOSE-2`).
pub const LONGEST_CAPTURE: u64 = 1_000_000;

impl Capture {
    /// A capture from `start` to `end`, `t_0` and `t_1`, processed by `processed`, `t_p` (`EXPOSE-2`).
    ///
    /// # Errors
    /// `Capture` unless `start < end <= processed` and `end - start` is at most 1 s.
    //= reference/SPEC.md#expose
    //# - **EXPOSE-2** An image MUST be refused (`Capture`) unless `t_0 < t_1 <= t_p`, `t_p` the end of its processing,
    //# and `t_1 - t_0` is at most 1 s.
    pub fn new(start: Time, end: Time, processed: Time) -> Result<Self, ImageRefusal> {
        if start < end && end <= processed && end.since(start) <= LONGEST_CAPTURE {
            Ok(Self { start, end, processed })
        } else {
            Err(ImageRefusal::Capture)
        }
    }

    /// When it began, `t_0`.
    #[must_use]
    pub const fn start(&self) -> Time {
        self.start
    }

    /// When it ended, `t_1`.
    #[must_use]
    pub const fn end(&self) -> Time {
        self.end
    }

    /// When its processing ended, `t_p`.
    #[must_use]
    pub const fn processed(&self) -> Time {
        self.processed
    }

    /// When a row was exposed, of an image of so many (`EXPOSE-1`): `t_0 + floor((2 r + 1)(t_1 - t_0)/(2 Q_y))`, exactly.
    ///
    /// The row is below `rows`; the product is below 2^37.
    //= reference/SPEC.md#expose
    //# - **EXPOSE-1** A row `r` of an image that was captured from `t_0` to `t_1` MUST count as exposed at `t_0 +
    //# floor((2 r + 1)(t_1 - t_0)/(2 Q_y))`, the middle of its share of the capture.
    #[must_use]
    pub fn row_time(&self, row: u16, rows: u16) -> Time {
        let halves = 2 * u64::from(row) + 1;
        let share = (halves * self.end.since(self.start)).checked_div(2 * u64::from(rows));
        self.start.after(share.unwrap_or(0))
    }

    /// When a row counts as seen by a stamp (`EXPOSE-1`, `EXPOSE-3`).
    //= reference/SPEC.md#expose
    //# - **EXPOSE-3** By the paper's stamp all of an image MUST count as seen at `floor((t_1 + t_p)/2)`, the middle of
    //# its processing (ERRATA-11); where the rows lie to each other (SKEW) stays as it is.
    #[must_use]
    pub fn seen(&self, stamp: Stamp, row: u16, rows: u16) -> Time {
        match stamp {
            Stamp::MidExposure => self.row_time(row, rows),
            Stamp::Processing => self.end.midpoint(self.processed),
        }
    }
}

/// Which time is taken for that of what an image shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stamp {
    /// The middle of each row's own exposure (`EXPOSE-1`).
    #[default]
    MidExposure,
    /// The paper's: the middle of the image's processing, for all rows (`EXPOSE-3`).
    Processing,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn capture(start: u64, end: u64, processed: u64) -> Result<Capture, ImageRefusal> {
        let [start, end, processed] = [start, end, processed].map(Time::from_micros);
        Capture::new(start, end, processed)
    }

    //= reference/SPEC.md#expose
    //= type=test
    //# - **EXPOSE-2** An image MUST be refused (`Capture`) unless `t_0 < t_1 <= t_p`, `t_p` the end of its processing,
    //# and `t_1 - t_0` is at most 1 s.
    #[test]
    fn captures_have_a_domain() {
        assert!(capture(5, 6, 6).is_ok() && capture(5, 1_000_005, 2_000_000).is_ok());
        for (start, end, processed) in [(5, 5, 6), (6, 5, 7), (5, 7, 6), (5, 1_000_006, 2_000_000)] {
            assert_eq!(capture(start, end, processed), Err(ImageRefusal::Capture), "{start} {end} {processed}");
        }
    }

    /// `EXPOSE-2`: `t_0`, `t_1` and `t_p`.
    #[test]
    fn a_capture_keeps_its_times() {
        let capture = capture(5, 7, 11).unwrap();
        assert_eq!([capture.start(), capture.end(), capture.processed()], [5, 7, 11].map(Time::from_micros));
    }

    /// 300 ms for 8 rows are 37.5 ms a row: the first one's middle is at 18.75 ms, the last one's at 281.25 ms.
    #[test]
    fn scan_lines_of_the_epuck_are_exposed_262_milliseconds_apart() {
        let capture = capture(1_000_000, 1_300_000, 1_381_000).unwrap();
        let [first, last] = [0, 7].map(|row| capture.row_time(row, 8).as_micros());
        assert_eq!((first, last, last - first), (1_018_750, 1_281_250, 262_500));
    }

    /// (1.3 s + 1.381001 s)/2, half a microsecond down.
    //= reference/SPEC.md#expose
    //= type=test
    //# - **EXPOSE-3** By the paper's stamp all of an image MUST count as seen at `floor((t_1 + t_p)/2)`, the middle of
    //# its processing (ERRATA-11); where the rows lie to each other (SKEW) stays as it is.
    #[test]
    fn the_paper_s_stamp_is_the_middle_of_processing() {
        let capture = capture(1_000_000, 1_300_000, 1_381_001).unwrap();
        for row in [0, 7] {
            assert_eq!(capture.seen(Stamp::Processing, row, 8), Time::from_micros(1_340_500));
            assert_eq!(capture.seen(Stamp::default(), row, 8), capture.row_time(row, 8));
        }
    }

    #[test]
    fn times_are_at_the_clock_s_end_what_they_are_before() {
        let [late, last] = [u64::MAX - 1, u64::MAX].map(Time::from_micros);
        assert_eq!((late.midpoint(last), last.since(late), late.since(last)), (late, 1, 0));
        assert_eq!(late.after(7), last);
    }

    proptest! {
        /// A row's time is in its share of the capture, and the shares are equal: `EXPOSE-1` in rational numbers.
        //= reference/SPEC.md#expose
        //= type=test
        //# - **EXPOSE-1** A row `r` of an image that was captured from `t_0` to `t_1` MUST count as exposed at `t_0 +
        //# floor((2 r + 1)(t_1 - t_0)/(2 Q_y))`, the middle of its share of the capture.
        #[test]
        fn a_row_s_time_is_the_middle_of_its_share(
            start in 0..u64::MAX / 2,
            length in 1..=LONGEST_CAPTURE,
            (row, rows) in (2_u16..=4096).prop_flat_map(|rows| (0..rows, Just(rows))),
        ) {
            let capture = capture(start, start + length, start + length).unwrap();
            let since = u128::from(capture.row_time(row, rows).since(capture.start()));
            let exact = (2 * u128::from(row) + 1) * u128::from(length); // times 2 Q_y
            prop_assert!(since * 2 * u128::from(rows) <= exact && exact < (since + 1) * 2 * u128::from(rows));
        }
    }
}
