//! What is wrong with a log, and where: one line with file, line and reason (LOG-8).

use core::fmt;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A row that was left out or warned, or a file that cannot be read at all.
#[derive(Clone, Debug)]
pub struct Fault {
    /// The file, as it was opened.
    pub file: Arc<Path>,
    /// The line, counted from 1; none where the file as a whole is wrong.
    pub line: Option<u64>,
    /// The kind of fault.
    pub reason: Reason,
    /// What exactly: column and value.
    pub what: String,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// A file is missing, or two that exclude each other are there (LOG-1).
    Folder,
    /// A file cannot be read, or no further.
    Unreadable,
    /// A table has nothing in it.
    Empty,
    /// A table has none of its headers (LOG-2).
    Header,
    /// A row has too few or too many fields (LOG-10).
    Fields,
    /// Text stands where a number belongs.
    NotANumber,
    /// NaN or infinity (LOG-7).
    NotFinite,
    /// Steps that are no whole number, or more than a reading holds (LOG-4).
    Steps,
    /// A time below 0, or too large (LOG-3).
    Time,
    /// A number beyond what is allowed (LOG-4, LOG-6, LOG-7).
    OutOfRange,
    /// A covariance that is not positive definite (LOG-6).
    Covariance,
    /// An image's times are not in order, or too far apart (LOG-5).
    Capture,
    /// An image that is named is not there (LOG-5).
    ImageMissing,
    /// An image that is there cannot be used (LOG-5).
    Image,
    /// A line that is not UTF-8, too long, or has a quote that is not closed (LOG-10).
    Line,
    /// The last line has no line end (LOG-10).
    CutOff,
    /// Warned: a step back in time (LOG-12).
    StepBack,
    /// Warned: the time of the row before again (LOG-12).
    Repeated,
    /// Warned: a gap in time (LOG-12).
    Gap,
}

impl Reason {
    /// Whether a row with this fault is used all the same.
    #[must_use]
    pub fn is_warning(self) -> bool {
        matches!(self, Self::StepBack | Self::Repeated | Self::Gap)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Folder => "files missing or too many",
            Self::Unreadable => "unreadable",
            Self::Empty => "empty",
            Self::Header => "no header",
            Self::Fields => "too few or too many fields",
            Self::NotANumber => "text where a number belongs",
            Self::NotFinite => "NaN or infinity",
            Self::Steps => "steps that no reading holds",
            Self::Time => "a time that is none",
            Self::OutOfRange => "out of range",
            Self::Covariance => "covariance not positive definite",
            Self::Capture => "image times out of order",
            Self::ImageMissing => "image missing",
            Self::Image => "image that cannot be used",
            Self::Line => "broken line",
            Self::CutOff => "line cut off",
            Self::StepBack => "step back in time",
            Self::Repeated => "time repeated",
            Self::Gap => "gap in time",
        })
    }
}

impl Fault {
    /// Of a file as a whole.
    pub(super) fn of_file(file: impl Into<PathBuf>, reason: Reason, what: impl Into<String>) -> Self {
        Self { file: file.into().into(), line: None, reason, what: what.into() }
    }

    /// File and line.
    #[must_use]
    pub fn place(&self) -> String {
        let line = self.line.map_or(String::new(), |line| format!(":{line}"));
        one_line(&format!("{}{line}", self.file.display()))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place(), one_line(&self.what))
    }
}

impl core::error::Error for Fault {}

/// Names and fields may have any character in them.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Why a row is refused; where it stands is known to whoever reads the rows.
#[derive(Debug)]
pub(super) struct Refusal {
    pub(super) reason: Reason,
    pub(super) what: String,
}

impl Refusal {
    pub(super) fn new(reason: Reason, what: impl Into<String>) -> Self {
        Self { reason, what: what.into() }
    }
}
