//! Which tree and which tools.

use std::collections::BTreeMap;
use std::process::Command;

/// Tools whose versions a reader may want to know: name and how to ask.
const TOOLS: [(&str, &[&str]); 11] = [
    ("rustc", &["rustc", "--version"]),
    ("cargo", &["cargo", "--version"]),
    ("rustc nightly", &["rustc", "+nightly", "--version"]),
    ("cbmc", &["target/proofs/tools/cbmc", "--version"]),
    ("kani", &["cargo", "kani", "--version"]),
    ("duvet", &["duvet", "--version"]),
    ("cargo-fuzz", &["cargo", "fuzz", "--version"]),
    ("cargo-mutants", &["cargo", "mutants", "--version"]),
    ("cargo-llvm-cov", &["cargo", "llvm-cov", "--version"]),
    ("miri", &["cargo", "+nightly", "miri", "--version"]),
    ("machine", &["uname", "-srm"]),
];

/// The first line that a command prints, if it runs.
fn first_line(words: &[&str]) -> Option<String> {
    let (program, arguments) = words.split_first()?;
    let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success())?;
    String::from_utf8_lossy(&output.stdout).lines().next().map(str::to_owned)
}

/// Each tool's own word on its version, or that it is not installed.
pub(crate) fn versions() -> BTreeMap<String, String> {
    let version = |words| first_line(words).unwrap_or_else(|| "not installed".to_owned());
    TOOLS.into_iter().map(|(name, words)| (name.to_owned(), version(words))).collect()
}

/// The commit, with `-modified` if the tree differs from it; `unknown` outside of a repository.
pub(crate) fn commit() -> String {
    first_line(&["git", "describe", "--always", "--abbrev=40", "--dirty=-modified", "--exclude=*"])
        .unwrap_or_else(|| "unknown".to_owned())
}
