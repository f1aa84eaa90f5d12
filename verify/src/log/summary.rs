//! How much of a log was used, and what was not (LOG-14).

use super::fault::{Fault, Reason};
use core::fmt;
use serde::Serialize;
use std::collections::BTreeMap;

/// How many places of a fault are shown.
const EXAMPLES: usize = 3;

/// What a reader made of a log's rows.
//= reference/SPEC.md#log
//# - **LOG-14** Reading MUST end with a summary of how many rows of each file were used and, by reason, left out and
//# warned, with the first three places of each.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Summary {
    /// By the file's name.
    pub files: BTreeMap<String, Rows>,
    /// By the kind of fault.
    pub faults: BTreeMap<Reason, Cases>,
}

/// Rows of one file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Rows {
    /// Used, those that were warned among them.
    pub used: u64,
    /// Left out.
    pub left_out: u64,
    /// Warned.
    pub warned: u64,
}

/// Rows with the same kind of fault.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cases {
    /// How many.
    pub count: u64,
    /// The first few, as sentences.
    pub examples: Vec<String>,
}

impl Summary {
    /// The file is there, with or without rows.
    pub(super) fn begin(&mut self, file: &str) {
        self.files.entry(file.to_owned()).or_default();
    }

    fn rows(&mut self, file: &str) -> &mut Rows {
        if !self.files.contains_key(file) {
            self.begin(file);
        }
        self.files.get_mut(file).expect("it has just been entered")
    }

    pub(super) fn used(&mut self, file: &str) {
        self.rows(file).used += 1;
    }

    pub(super) fn fault(&mut self, fault: &Fault) {
        let name = fault.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let rows = self.rows(&name);
        *(if fault.reason.is_warning() { &mut rows.warned } else { &mut rows.left_out }) += 1;
        let cases = self.faults.entry(fault.reason).or_default();
        cases.count += 1;
        if cases.examples.len() < EXAMPLES {
            cases.examples.push(fault.to_string());
        }
    }

    /// Rows of all files.
    #[must_use]
    pub fn total(&self) -> Rows {
        self.files.values().fold(Rows::default(), |sum, rows| Rows {
            used: sum.used + rows.used,
            left_out: sum.left_out + rows.left_out,
            warned: sum.warned + rows.warned,
        })
    }
}

impl fmt::Display for Summary {
    /// A line for each file, and one for each kind of fault with the first few places below it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (file, rows) in &self.files {
            writeln!(f, "{file}: {} rows used, {} left out, {} warned", rows.used, rows.left_out, rows.warned)?;
        }
        for (reason, cases) in &self.faults {
            let kind = if reason.is_warning() { "warned" } else { "left out" };
            writeln!(f, "{kind}, {reason}: {}", cases.count)?;
            for example in &cases.examples {
                writeln!(f, "  {example}")?;
            }
            if cases.count > cases.examples.len() as u64 {
                writeln!(f, "  ...")?;
            }
        }
        Ok(())
    }
}
