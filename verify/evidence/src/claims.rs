//! CLAIMS.md holds together: every claim says what it assumes, what speaks for it, and by which command that is repeated; the
//! commands exist.

use crate::parts::PARTS;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A claim's heading and text.
fn claims(text: &str) -> Vec<(&str, &str)> {
    let (_, claimed) = text.split_once("\n## What is claimed\n").expect("a section of claims");
    claimed.split("\n### ").skip(1).filter_map(|claim| claim.split_once('\n')).collect()
}

/// What stands between backticks in the paragraph that begins with a label.
fn commands<'a>(claim: &'a str, label: &str) -> Vec<&'a str> {
    let Some((_, rest)) = claim.split_once(label) else { return Vec::new() };
    let paragraph = rest.split("\n\n").next().unwrap_or_default();
    paragraph.split('`').skip(1).step_by(2).collect()
}

/// Why a command cannot be repeated, if it cannot.
fn fault(command: &str) -> Option<String> {
    let words: Vec<&str> = command.split_whitespace().skip_while(|word| word.starts_with("BARLOC_")).collect();
    let after = |flag: &'static str| words.iter().zip(words.iter().skip(1)).filter(move |(word, _)| **word == flag);
    match words.as_slice() {
        ["cargo", "evidence", ..] => {
            let missing = after("--part").find(|(_, name)| PARTS.iter().all(|part| part.name != **name));
            missing.map(|(_, name)| format!("no part {name}"))
        }
        ["cargo", "test", ..] => {
            let tests = fs::read_to_string(root().join("verify/Cargo.toml")).unwrap();
            let missing = after("--test").find(|(_, name)| !tests.contains(&format!("[[test]]\nname = \"{name}\"\n")));
            missing.map(|(_, name)| format!("no test {name}"))
        }
        ["cargo", "run", "--release", "--", subcommand, ..] => {
            let file = root().join("verify/src/command").join(subcommand).with_extension("rs");
            (!file.exists()).then(|| format!("no command {subcommand}"))
        }
        [program, ..] if program.contains('/') => {
            let targets =
                words.iter().skip(1).filter(|word| word.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_'));
            let missing = |target: &&&str| !root().join(format!("fuzz/fuzz_targets/{target}.rs")).exists();
            if root().join(program).exists() {
                targets.clone().find(missing).map(|target| format!("no target {target}"))
            } else {
                Some(format!("no {program}"))
            }
        }
        _ => Some("neither cargo's nor a script's".to_owned()),
    }
}

fn text() -> String {
    fs::read_to_string(root().join("verify/CLAIMS.md")).unwrap()
}

#[test]
fn it_opens_with_what_is_not_verified() {
    let text = text();
    let first = text.lines().find(|line| line.starts_with("## ")).unwrap();
    assert_eq!(first, "## What is not verified");
}

#[test]
fn every_claim_is_whole_and_can_be_repeated() {
    let text = text();
    let claims = claims(&text);
    assert!(claims.len() >= 10, "only {} claims", claims.len());
    for (number, (heading, claim)) in (1..).zip(claims) {
        assert!(heading.starts_with(&format!("C{number}. ")), "{heading}");
        for label in ["- **Assumes**: ", "- **Evidence**: ", "- **Repeat**: "] {
            assert_eq!(claim.matches(label).count(), 1, "{heading}: {label}");
        }
        let commands = commands(claim, "- **Repeat**: ");
        assert!(!commands.is_empty(), "{heading}: no command");
        let faults: Vec<_> = commands.iter().filter_map(|command| Some((command, fault(command)?))).collect();
        assert!(faults.is_empty(), "{heading}: {faults:?}");
    }
}

/// The check of commands can fail.
#[test]
fn a_command_that_does_not_exist_is_a_fault() {
    for command in
        ["cargo evidence --part nothing", "cargo test --test bounds --test nothing", "cargo run --release -- nothing"]
    {
        assert!(fault(command).is_some_and(|fault| fault.contains("nothing")), "{command}");
    }
    assert!(fault("verify/nothing --out DIR").is_some() && fault("make").is_some());
    assert!(fault("BARLOC_RUNS=100 cargo test --test bounds").is_none());
}
