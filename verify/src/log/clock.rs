//! Times and captures of a log as both pipelines have them.

use super::{Capture, Time};
use reference::exposure;

impl From<Time> for exposure::Time {
    fn from(time: Time) -> Self {
        Self::from_micros(time.micros())
    }
}

impl From<exposure::Time> for Time {
    /// A time of 2^63 µs or more is the last one that a log can have.
    fn from(time: exposure::Time) -> Self {
        Self::from_micros(time.as_micros()).or_else(|| Self::from_micros(i64::MAX.unsigned_abs())).unwrap_or_default()
    }
}

impl From<Capture> for exposure::Capture {
    fn from(capture: Capture) -> Self {
        Self { start: capture.start.into(), end: capture.end.into(), processed: capture.processed.into() }
    }
}
