//! Tells the certificate what it was built from.

use std::path::Path;
use std::process::Command;

/// What the command is built from and what it reads by itself.
const SOURCES: [&str; 7] = [
    "../verify",
    "../reference",
    "../fixedpoint",
    "../Cargo.toml",
    "../Cargo.lock",
    "../rust-toolchain.toml",
    "../tests/data/renders",
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for source in SOURCES.iter().chain(&["../.git/HEAD", "../.git/logs/HEAD"]) {
        if Path::new(source).exists() {
            println!("cargo::rerun-if-changed={source}");
        }
    }
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let toolchain = output(&rustc, &["--version"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=BARLOC_COMMIT={}", commit());
    println!("cargo::rustc-env=BARLOC_TOOLCHAIN={toolchain}");
}

/// The commit, marked where a pipeline or the comparison has changed since.
fn commit() -> String {
    let Some(commit) = output("git", &["rev-parse", "HEAD"]) else { return "unknown".to_owned() };
    match output("git", &[&["status", "--porcelain", "--"], &SOURCES[..]].concat()) {
        Some(changes) if changes.is_empty() => commit,
        _ => format!("{commit}-modified"),
    }
}

fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
