//! Files written whole or not at all (PRINT-13).

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A file that could not be written, and why.
#[derive(Debug)]
pub struct Unwritten {
    /// The file.
    pub path: PathBuf,
    /// What the system says.
    pub error: io::Error,
}

impl core::fmt::Display for Unwritten {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: cannot be written: {}", self.path.display(), self.error)
    }
}

impl core::error::Error for Unwritten {}

/// Writes every file beside its place first, and puts them there when all are complete; on an error what was written
/// beside them is taken away again.
//= reference/SPEC.md#print
//# - **PRINT-13** Files MUST be written whole or not at all.
pub fn write_whole(files: &[(PathBuf, Vec<u8>)]) -> Result<(), Unwritten> {
    let outcome = put(files);
    if outcome.is_err() {
        for (path, _) in files {
            // There may be none, and nothing else can be done about one that stays.
            let _ = fs::remove_file(beside(path));
        }
    }
    outcome
}

fn put(files: &[(PathBuf, Vec<u8>)]) -> Result<(), Unwritten> {
    let failed = |path: &Path, error| Unwritten { path: path.to_owned(), error };
    for (path, bytes) in files {
        if path.is_dir() {
            return Err(failed(path, io::ErrorKind::IsADirectory.into()));
        }
        fs::write(beside(path), bytes).map_err(|error| failed(path, error))?;
    }
    for (path, _) in files {
        fs::rename(beside(path), path).map_err(|error| failed(path, error))?;
    }
    Ok(())
}

/// The same name with `.part` behind it.
pub(crate) fn beside(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".part");
    name.into()
}
