//! When an image's rows were exposed (EXPOSE).

use core::fmt;

/// Longest capture, microseconds (EXPOSE-2).
const LONGEST_CAPTURE: u64 = 1_000_000;

/// A time of the robot's clock, whole microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time(u64);

impl Time {
    /// So many microseconds after the clock's zero.
    #[must_use]
    pub const fn from_micros(micros: u64) -> Self {
        Self(micros)
    }

    /// Microseconds since the clock's zero.
    #[must_use]
    pub const fn as_micros(self) -> u64 {
        self.0
    }

    /// Microseconds since another time, 0 if that is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }

    /// The time between two, rounded down.
    #[must_use]
    pub const fn midpoint(self, other: Self) -> Self {
        Self(u64::midpoint(self.0, other.0))
    }
}

/// When an image was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capture {
    /// The first row's exposure begins.
    pub start: Time,
    /// The last row's exposure ends.
    pub end: Time,
    /// What is in the image is known.
    pub processed: Time,
}

/// Why an image's times make no sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptureRefusal {
    /// EXPOSE-2
    Capture,
}

impl fmt::Display for CaptureRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an image is captured within a second before it is processed, its start before its end")
    }
}

impl core::error::Error for CaptureRefusal {}

/// Which time an observation is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stamp {
    /// That of its row's exposure (EXPOSE-1).
    #[default]
    MidExposure,
    /// The middle of the image's processing, as in the paper (EXPOSE-3).
    Processing,
}

impl Capture {
    /// EXPOSE-2
    //= reference/SPEC.md#expose
    //# - **EXPOSE-2** An image MUST be refused (`Capture`) unless `t_0 < t_1 <= t_p`, `t_p` the end of its processing,
    //# and `t_1 - t_0` is at most 1 s.
    pub fn check(&self) -> Result<(), CaptureRefusal> {
        let length = self.end.since(self.start);
        let is_possible = (1..=LONGEST_CAPTURE).contains(&length) && self.end <= self.processed;
        if is_possible { Ok(()) } else { Err(CaptureRefusal::Capture) }
    }

    /// The middle of a row's exposure, of an image of `height` rows (EXPOSE-1).
    //= reference/SPEC.md#expose
    //# - **EXPOSE-1** A row `r` of an image that was captured from `t_0` to `t_1` MUST count as exposed at `t_0 +
    //# floor((2 r + 1)(t_1 - t_0)/(2 Q_y))`, the middle of its share of the capture.
    #[must_use]
    pub fn row_time(&self, row: usize, height: usize) -> Time {
        let length = self.end.since(self.start);
        Time(self.start.0 + (2 * row as u64 + 1) * length / (2 * height as u64))
    }

    /// The time by which an observation of a row is taken (EXPOSE-1, EXPOSE-3).
    //= reference/SPEC.md#expose
    //# - **EXPOSE-3** By the paper's stamp all of an image MUST count as seen at `floor((t_1 + t_p)/2)`, the middle of
    //# its processing (ERRATA-11); where the rows lie to each other (SKEW) stays as it is.
    #[must_use]
    pub fn seen(&self, row: usize, height: usize, stamp: Stamp) -> Time {
        match stamp {
            Stamp::MidExposure => self.row_time(row, height),
            Stamp::Processing => self.end.midpoint(self.processed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAPTURE: Capture = Capture { start: Time(1_000_000), end: Time(1_300_000), processed: Time(1_400_000) };

    //= reference/SPEC.md#expose
    //= type=test
    //# - **EXPOSE-1** A row `r` of an image that was captured from `t_0` to `t_1` MUST count as exposed at `t_0 +
    //# floor((2 r + 1)(t_1 - t_0)/(2 Q_y))`, the middle of its share of the capture.
    #[test]
    fn the_scan_lines_of_an_e_puck_are_a_quarter_of_a_second_apart() {
        // 300 ms in 8 rows of 37.5 ms.
        assert_eq!(CAPTURE.row_time(0, 8), Time(1_018_750));
        assert_eq!(CAPTURE.row_time(7, 8), Time(1_281_250));
        assert_eq!(CAPTURE.seen(7, 8, Stamp::MidExposure), Time(1_281_250));
    }

    //= reference/SPEC.md#expose
    //= type=test
    //# - **EXPOSE-3** By the paper's stamp all of an image MUST count as seen at `floor((t_1 + t_p)/2)`, the middle of
    //# its processing (ERRATA-11); where the rows lie to each other (SKEW) stays as it is.
    #[test]
    fn the_paper_stamps_the_middle_of_the_processing() {
        assert_eq!(CAPTURE.seen(0, 8, Stamp::Processing), Time(1_350_000));
        assert_eq!(CAPTURE.seen(7, 8, Stamp::Processing), Time(1_350_000));
    }

    //= reference/SPEC.md#expose
    //= type=test
    //# - **EXPOSE-2** An image MUST be refused (`Capture`) unless `t_0 < t_1 <= t_p`, `t_p` the end of its processing,
    //# and `t_1 - t_0` is at most 1 s.
    #[test]
    fn captures_end_after_they_begin_and_before_they_are_processed() {
        assert_eq!(CAPTURE.check(), Ok(()));
        let refused = |capture: Capture| capture.check() == Err(CaptureRefusal::Capture);
        assert!(refused(Capture { end: CAPTURE.start, ..CAPTURE }));
        assert!(refused(Capture { processed: Time(1_299_999), ..CAPTURE }));
        assert!(refused(Capture { start: Time(299_999), ..CAPTURE }));
        assert!(Capture { start: Time(300_000), ..CAPTURE }.check().is_ok());
    }
}
