//! A file that is written bit by bit and is there whole or not at all (LOG-18).

use crate::print::files::{Unwritten, beside};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file beside its place until it is finished; taken away again if it never is.
#[derive(Debug)]
pub struct Unfinished {
    path: PathBuf,
    part: PathBuf,
    file: BufWriter<File>,
}

impl Unfinished {
    /// Begins a file; what stands in its place stays until the end.
    pub fn create(path: PathBuf) -> Result<Self, Unwritten> {
        let part = beside(&path);
        let opened = if path.is_dir() { Err(io::ErrorKind::IsADirectory.into()) } else { File::create(&part) };
        match opened {
            Ok(file) => Ok(Self { path, part, file: BufWriter::new(file) }),
            Err(error) => Err(Unwritten { path, error }),
        }
    }

    /// The file's place.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes text behind what there is.
    pub fn write(&mut self, text: core::fmt::Arguments<'_>) -> Result<(), Unwritten> {
        self.file.write_fmt(text).map_err(|error| self.failed(error))
    }

    /// Puts the file in its place.
    pub fn finish(mut self) -> Result<(), Unwritten> {
        self.file.flush().and_then(|()| fs::rename(&self.part, &self.path)).map_err(|error| self.failed(error))
    }

    fn failed(&self, error: io::Error) -> Unwritten {
        Unwritten { path: self.path.clone(), error }
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        // Gone already if it was finished; nothing else can be done about one that stays.
        let _ = fs::remove_file(&self.part);
    }
}
