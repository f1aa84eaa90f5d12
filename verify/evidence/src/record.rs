//! What became of each part, at which commit: `evidence.json`.

use crate::tools;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::{fs, io};

/// What became of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Outcome {
    /// Its command ended with 0.
    Held,
    /// Its command ended otherwise.
    Failed,
    /// Its command could not do its work here (exit code 3), or could not be started.
    NotRun,
}

/// A part's run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Taken {
    pub(crate) outcome: Outcome,
    /// The command, as one would type it.
    pub(crate) command: String,
    /// The commit, with `-modified` if the tree was not clean.
    pub(crate) commit: String,
    /// Wall clock.
    pub(crate) seconds: u64,
    /// The last line that it printed.
    pub(crate) last_line: String,
}

impl Taken {
    /// One line about it.
    pub(crate) fn sentence(&self) -> String {
        let Self { seconds, last_line, .. } = self;
        match self.outcome {
            Outcome::Held => format!("holds ({seconds} s)"),
            Outcome::Failed => format!("FAILED ({seconds} s): {last_line}"),
            Outcome::NotRun => format!("could not run here: {last_line}"),
        }
    }
}

/// Everything that is known.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    /// The tree that the page is about.
    pub(crate) commit: String,
    /// Tools by name.
    pub(crate) versions: BTreeMap<String, String>,
    parts: BTreeMap<String, Taken>,
}

const FILE: &str = "evidence.json";

impl Record {
    /// What earlier runs left in a folder, if anything; about the tree as it is now.
    pub(crate) fn read(folder: &Path, versions: BTreeMap<String, String>) -> io::Result<Self> {
        let parts = match fs::read(folder.join(FILE)) {
            Ok(bytes) => serde_json::from_slice::<Self>(&bytes)?.parts,
            Err(error) if error.kind() == io::ErrorKind::NotFound => BTreeMap::new(),
            Err(error) => return Err(error),
        };
        Ok(Self { commit: tools::commit(), versions, parts })
    }

    pub(crate) fn keep(&mut self, part: &str, taken: Taken) {
        self.parts.insert(part.to_owned(), taken);
    }

    /// What is known of a part, at whatever commit.
    pub(crate) fn of(&self, part: &str) -> Option<&Taken> {
        self.parts.get(part)
    }

    /// The parts that were run at this commit.
    pub(crate) fn taken(&self) -> impl Iterator<Item = &Taken> {
        self.parts.values().filter(|taken| taken.commit == self.commit)
    }

    pub(crate) fn write(&self, folder: &Path) -> io::Result<()> {
        fs::write(folder.join(FILE), serde_json::to_string_pretty(self)? + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_found_at_another_commit_is_kept_and_told_apart() {
        let folder = std::env::temp_dir().join(format!("barloc-evidence-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let taken = |commit: &str| Taken {
            outcome: Outcome::Held,
            command: "true".to_owned(),
            commit: commit.to_owned(),
            seconds: 1,
            last_line: String::new(),
        };
        let mut record = Record::read(&folder, BTreeMap::new()).unwrap();
        let now = record.commit.clone();
        record.keep("proofs", taken(&now));
        record.keep("miri", taken("another"));
        record.write(&folder).unwrap();
        let read = Record::read(&folder, BTreeMap::new()).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(read, record);
        assert_eq!(read.taken().count(), 1);
        assert_eq!(read.of("miri").unwrap().commit, "another");
    }
}
