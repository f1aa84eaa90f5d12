//! Every place that names targets names the same ones.

use fuzz::TARGETS;
use fuzz::replay::{corpus, files};
use std::fs;
use std::path::{Path, PathBuf};

fn here(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn names() -> Vec<String> {
    TARGETS.iter().map(|(name, _)| (*name).to_owned()).collect()
}

/// A file that is not built, or a target without one, is fuzzed by nobody.
#[test]
fn every_file_is_a_target_of_the_manifest() {
    let of_file = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
    let sources: Vec<String> = files(&here("fuzz_targets")).unwrap().into_iter().map(of_file).collect();
    assert_eq!(sources, names());
    let manifest: toml::Table = fs::read_to_string(here("Cargo.toml")).unwrap().parse().unwrap();
    let bins = manifest["bin"].as_array().unwrap().iter().map(|bin| {
        let name = bin["name"].as_str().unwrap();
        assert_eq!(bin["path"].as_str(), Some(format!("fuzz_targets/{name}.rs").as_str()));
        name.to_owned()
    });
    assert_eq!(bins.collect::<Vec<_>>(), names());
}

/// Each file runs the body of its own name.
#[test]
fn every_file_runs_its_own_target() {
    for name in names() {
        let source = fs::read_to_string(here("fuzz_targets").join(format!("{name}.rs"))).unwrap();
        let calls = source.matches("fuzz::").count();
        // In the sentence on top, for the engine, and twice without it.
        assert_eq!((source.matches(&format!("fuzz::{name}")).count(), calls), (3, 4), "{name}");
    }
}

/// What `fuzz/run` runs, and with it `.ci/run`.
#[test]
fn every_target_is_run() {
    let list = fs::read_to_string(here("targets.txt")).unwrap();
    let lines = list.lines().filter(|line| !line.starts_with('#'));
    let listed: Vec<(String, usize)> = lines
        .map(|line| {
            let (name, length) = line.split_once(' ').unwrap();
            (name.to_owned(), length.parse().unwrap())
        })
        .collect();
    assert_eq!(listed.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>(), names());
    for (name, length) in listed {
        let longest = files(&corpus().join(&name)).unwrap().iter().map(|file| file.metadata().unwrap().len()).max();
        assert!(longest.is_some_and(|longest| longest <= length as u64), "the corpus of {name} has longer inputs");
    }
    // CI runs the commands of the README, and one of them this part of the evidence.
    let readme = fs::read_to_string(here("../README.md")).unwrap();
    let command = readme.lines().find(|line| line.starts_with("cargo evidence ")).expect("the README makes evidence");
    assert!(command.contains(" --part fuzz "), "{command}");
    let parts = fs::read_to_string(here("../verify/evidence/src/parts.rs")).unwrap();
    let runs: Vec<&str> = parts.lines().filter(|line| line.contains("\"fuzz/run ")).collect();
    assert_eq!(runs.len(), 2, "in short and in full: {runs:?}");
    for run in runs {
        assert!(!names().iter().any(|name| run.contains(name.as_str())), "it runs all of them: {run}");
    }
}

/// A dictionary of no target is used by none.
#[test]
fn dictionaries_are_those_of_targets() {
    for file in files(&here("dictionaries")).unwrap() {
        let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
        assert!(names().contains(&name), "{}", file.display());
    }
}
