//! Landmarks on paper in true size (PRINT).
//!
//! [`layout`] puts landmarks on pages, which are plain data in millimetres ([`page`]); [`svg`] and [`pdf`] write pages;
//! [`nearest`] names what can be printed instead of what cannot; [`sheet`] reads lists of landmarks; [`files`] writes
//! files whole or not at all.

pub mod files;
pub mod layout;
pub mod nearest;
pub mod outline;
pub mod page;
pub mod pdf;
pub mod sheet;
pub mod svg;
