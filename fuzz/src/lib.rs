//! What barloc is fuzzed with: a module for each target, whose `run` takes the fuzzer's bytes and panics where a claim
//! does not hold.
//!
//! Nothing here only looks for crashes. [`lines`], [`scene`], [`code_word`] and [`filter`] run both pipelines side by side
//! and compare what they do as `SAME` asks; [`png`], [`pgm`], [`csv`] and [`toml`] read a file in several ways that must
//! come to the same, within a bound on memory.
//!
//! The bytes go through [`draw`], so that each input of a target means something, and what a check sum would refuse is
//! repaired: a bug behind a CRC is otherwise found by nobody.

pub mod code_word;
pub mod csv;
pub mod draw;
mod fault;
pub mod filter;
pub mod lines;
pub mod lockstep;
pub mod memory;
pub mod pgm;
pub mod png;
pub mod replay;
pub mod scene;
pub mod toml;

/// A target's name and its body.
pub type Target = (&'static str, fn(&[u8]));

/// All targets, by name.
pub const TARGETS: [Target; 8] = [
    ("code_word", code_word::run),
    ("csv", csv::run),
    ("filter", filter::run),
    ("lines", lines::run),
    ("pgm", pgm::run),
    ("png", png::run),
    ("scene", scene::run),
    ("toml", toml::run),
];
