//! Which tree and which tools.

use std::collections::BTreeMap;
use std::process::Command;

/// Tools whose versions a reader may want to know: name and how to ask.
const TOOLS: [(&str, &[&str]); 9] = [
    ("rustc", &["rustc", "--version"]),
    ("cargo", &["cargo", "--version"]),
    ("rustc nightly", &["rustc", "+nightly", "--version"]),
    ("kani", &["cargo", "kani", "--version"]),
    ("cargo-fuzz", &["cargo", "fuzz", "--version"]),
    ("cargo-mutants", &["cargo", "mutants", "--version"]),
    ("cargo-llvm-cov", &["cargo", "llvm-cov", "--version"]),
    ("miri", &["cargo", "+nightly", "miri", "--version"]),
    ("machine", &["uname", "-srm"]),
];

/// What a command prints, if it runs.
fn output(words: &[&str]) -> Option<String> {
    let (program, arguments) = words.split_first()?;
    let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The first line of it.
fn first_line(words: &[&str]) -> Option<String> {
    output(words)?.lines().next().map(str::to_owned)
}

/// Each tool's own word on its version, or cargo's on one that does not say it, or that it is not installed.
pub(crate) fn versions() -> BTreeMap<String, String> {
    let said = TOOLS.into_iter().map(|(name, words)| (name, first_line(words)));
    let target = std::env::var("CARGO_TARGET_DIR").unwrap_or_else(|_| "target".to_owned());
    let known = said.chain([
        ("cbmc", first_line(&[&checker(&target), "--version"])),
        ("duvet", installed(&output(&["cargo", "install", "--list"]).unwrap_or_default(), "duvet")),
    ]);
    known.map(|(name, version)| (name.to_owned(), version.unwrap_or_else(|| "not installed".to_owned()))).collect()
}

/// Where the proofs' setup puts the model checker.
fn checker(target: &str) -> String {
    format!("{target}/proofs/tools/bin/cbmc")
}

/// A crate and its version in what `cargo install --list` prints: `name v1.2.3:`, and from elsewhere `name v1.2.3 (where):`.
fn installed(list: &str, name: &str) -> Option<String> {
    let line = list.lines().find(|line| line.strip_prefix(name).is_some_and(|rest| rest.starts_with(" v")))?;
    Some(line.trim_end_matches(':').to_owned())
}

/// The commit, with `-modified` if the tree differs from it; `unknown` outside of a repository.
pub(crate) fn commit() -> String {
    first_line(&["git", "describe", "--always", "--abbrev=40", "--dirty=-modified", "--exclude=*"])
        .unwrap_or_else(|| "unknown".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crate_s_version_is_its_own() {
        let list = "duvet-core v0.1.0:\n    core\nduvet v0.4.3 (/somewhere):\n    duvet\ncargo-fuzz v0.13.2:\n    cargo-fuzz\n";
        assert_eq!(installed(list, "duvet").as_deref(), Some("duvet v0.4.3 (/somewhere)"));
        assert_eq!(installed(list, "cargo-fuzz").as_deref(), Some("cargo-fuzz v0.13.2"));
        assert_eq!((installed(list, "cargo"), installed("", "duvet")), (None, None));
    }

    /// The checker is asked where the proofs' setup puts it.
    #[test]
    fn the_proofs_tools_are_where_they_are_put() {
        let setup = include_str!("../../proofs/setup");
        let folder =
            setup.lines().find_map(|line| line.strip_prefix("tools=${CARGO_TARGET_DIR:-$here/../../target}")).unwrap();
        let program = setup.lines().find_map(|line| line.strip_prefix("  cat >\"")?.strip_suffix("\" <<RUN")).unwrap();
        assert_eq!(checker("there"), format!("there{folder}/{}", program.replace("$program", "cbmc")));
    }
}
