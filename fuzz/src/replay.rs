//! Inputs from files: what `cargo test` and the targets do that no fuzzer drives.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The folder with a folder for each target of inputs that are to be replayed.
#[must_use]
pub fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus")
}

/// The folder with a folder for each target of inputs that once failed.
#[must_use]
pub fn regressions() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("regressions")
}

/// The files of a folder by name, none where there is no folder.
pub fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// What a refusal says.
///
/// # Panics
/// If it is not one line, or none at all.
pub(crate) fn is_a_sentence(text: &str) {
    assert!(!text.is_empty() && !text.chars().any(char::is_control), "not a line: {text:?}");
}

/// Runs a target on the files and on those of the folders that the command line names.
#[must_use]
pub fn main(run: fn(&[u8])) -> ExitCode {
    let mut count = 0;
    for argument in std::env::args_os().skip(1) {
        let path = PathBuf::from(argument);
        let inputs = if path.is_dir() { files(&path) } else { Ok(vec![path.clone()]) };
        let read = inputs.and_then(|inputs| {
            for input in inputs {
                println!("{}", input.display());
                run(&fs::read(&input)?);
                count += 1;
            }
            Ok(())
        });
        if let Err(error) = read {
            eprintln!("{}: {error}", path.display());
            return ExitCode::from(2);
        }
    }
    println!("{count} inputs replayed");
    if count == 0 { ExitCode::from(2) } else { ExitCode::SUCCESS }
}
