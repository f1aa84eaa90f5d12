//! Runs barloc's two pipelines in lockstep, compares them stage by stage, and certifies that they are the same.
//!
//! A frame runs through both pipelines, whose observers fill the same form ([`trace`]); [`lockstep`] compares the two
//! forms by the table in [`bounds`], [`tally`] counts, [`campaign`] runs many frames, [`certificate`] says what was seen.
//!
//! Whole robots [`ride`] side by side too: on the [`route`] of a [`scenario`], or by a robot's [`log`].

pub mod accuracy;
pub mod bounds;
pub mod campaign;
pub mod certificate;
pub mod command;
pub mod coverage;
pub mod disturb;
pub mod drawing;
pub mod false_accepts;
pub mod figures;
pub mod filters;
pub mod findings;
pub mod input;
pub mod junk;
pub mod lockstep;
pub mod log;
pub mod paper_estimate;
pub mod place;
pub mod port;
pub mod print;
pub mod record_fixedpoint;
pub mod record_reference;
pub mod renders;
pub mod ride;
pub mod route;
pub mod scenario;
pub mod scenes;
pub mod sensitivity;
pub mod sequence;
pub mod site;
pub mod summary;
pub mod tally;
pub mod trace;
