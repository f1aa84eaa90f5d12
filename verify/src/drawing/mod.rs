//! Drawings for people and paper, as SVG: text that is the same for the same input.

pub mod accuracy;
pub mod area;
pub mod route;

use core::fmt;
use plotters::drawing::DrawingAreaErrorKind;

/// The drawing library gave up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DrawingError {
    /// What it says.
    reason: String,
}

impl<E: core::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for DrawingError {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Self { reason: error.to_string().split_whitespace().collect::<Vec<_>>().join(" ") }
    }
}

impl fmt::Display for DrawingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the drawing failed: {}", self.reason)
    }
}

impl core::error::Error for DrawingError {}
