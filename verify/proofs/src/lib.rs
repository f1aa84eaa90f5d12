//! Bounded proofs of the port, in Kani's syntax.
//!
//! Each is a function that draws symbolic numbers, assumes what its domain says and asserts its claim. `cargo kani` proves
//! them where Kani is installed; `verify/proofs/prove` proves the same functions, compiled to wasm32, by CBMC; and plain
//! `cargo test` samples them. The first paragraph of a proof's documentation is its claim; two list items follow, its
//! *domain* and the *fault* which, put into the port, must make the proof fail. `verify/proofs/README.md` says more.
#![cfg_attr(target_arch = "wasm32", no_std)]
// What is public here is so for the checker's sake; the proofs are their documentation.
#![cfg(any(kani, test, target_arch = "wasm32"))]

mod angle;
mod binary;
mod code_word;
mod covariance;
mod crc;
mod crossing;
mod errors;
mod extents;
mod filter;
mod in_order;
mod local_threshold;
mod merge;
mod queue;
mod ratio;
mod regions;
mod threshold;
