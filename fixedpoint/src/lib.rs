//! Barcode landmarks on a microcontroller.
//!
//! Two scan lines of a camera go in; the landmarks they show come out, each with its payload, its homography and the
//! camera's pose. The behaviour is specified in `reference/SPEC.md`; its requirements are cited by name (`THRESH-2`)
//! where they are implemented. The stages run in this order:
//!
//! [`threshold`] → [`regions`] → [`hypotheses`] → [`homography`] (from [`crossing`]s) → [`sampling`] → [`decode`] →
//! [`merge`], beside it [`extents`] → [`trellis`] for barcodes too small to be thresholded; then [`fit`] (from [`edge`]s) →
//! [`accept`] → [`pose`] and [`covariance`] → [`layers`]
//!
//! and [`detect`] runs them all, those before merging for each line by its global and then by its local threshold. Each
//! reports its result to an [`observer`].
//!
//! A camera that reads its rows one after the other sees both lines at different times ([`exposure`]) and, while it moves, from
//! different places ([`skew`]).
//!
//! Where the robot is follows from its wheels' steps, by [`motion`], and from landmarks whose place is known ([`places`],
//! [`grid`]), by [`observation`], which [`filter`] puts together, in the order that [`timeline`] finds; [`localizer`] is all of
//! it.
//!
//! # Arithmetic
//! There is no floating-point number in this crate. Crossings are integers, so the normal equations of a homography
//! are integers too, and their solution is a ratio of two 64-bit integers that is compared, never rounded, while
//! stripes are sampled. What is rounded in the end is rounded to nearest, halves up. [`formats`] lists every format.
//!
//! # Memory
//! No allocator: everything lives in a [`detect::Workspace`] of about 1.5 KB, in the returned list of about 2 KB,
//! and on the stack. A buffer that fills up ends in a refusal that says so.
//!
//! # Rules
//! No function panics, indexes, divides by a number that can be zero, or recurses.
//!
//! # Example
//! ```
//! use fixedpoint::{camera::Camera, crossing::CrossingRule, detect, landmark::Landmark, observer::Silent};
//!
//! let (upper, lower) = ([255_u8; 480], [255_u8; 480]); // a white wall
//! let mut workspace = detect::Workspace::new();
//! let detections = detect::detect(
//!     &upper,
//!     &lower,
//!     &Camera::epuck(),
//!     &[Landmark::paper()],
//!     CrossingRule::Interpolated,
//!     &mut workspace,
//!     &mut Silent,
//! );
//! assert!(detections.is_empty());
//! ```
#![no_std]
#![forbid(unsafe_code)]
// The interface takes references throughout, also to what is small.
#![allow(clippy::trivially_copy_pass_by_ref)]
#![cfg_attr(
    not(test),
    deny(
        clippy::indexing_slicing,
        clippy::string_slice,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::float_arithmetic,
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_possible_wrap
    )
)]

#[cfg(test)]
extern crate std;

pub mod accept;
pub mod binary;
pub mod camera;
pub mod codeword;
pub mod cordic;
pub mod covariance;
pub mod crossing;
pub mod decode;
pub mod detect;
pub mod edge;
pub mod elimination;
pub mod exposure;
pub mod extents;
pub mod filter;
pub mod fit;
pub mod formats;
pub mod frame;
pub mod grid;
pub mod homography;
pub mod hypotheses;
pub mod in_order;
pub mod ink;
pub mod inverse;
pub mod landmark;
pub mod layers;
pub mod light;
pub mod localizer;
pub mod merge;
pub mod motion;
pub mod observation;
pub mod observer;
pub mod places;
pub mod pose;
pub mod projection;
pub mod quiet_zone;
pub mod ratio;
pub mod reciprocal;
pub mod refusal;
pub mod regions;
pub mod rotation;
pub mod sampling;
pub mod skew;
pub mod sweep;
pub mod threshold;
pub mod timeline;
pub mod trellis;
pub mod whiteness;

#[cfg(test)]
mod drawing;
