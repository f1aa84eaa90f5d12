//! SPEC.md and the code cite each other: requirements are well formed, citations exist, and nothing is left uncited.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Requirements by name, from the lines that begin with `- **NAME-1**`, and their text up to the line's end.
fn requirements() -> BTreeMap<String, String> {
    let text = fs::read_to_string(root().join("reference/SPEC.md")).unwrap();
    let mut found = BTreeMap::new();
    for line in text.lines() {
        if let Some((name, sentence)) = line.strip_prefix("- **").and_then(|rest| rest.split_once("** ")) {
            let before = found.insert(name.to_owned(), sentence.to_owned());
            assert!(before.is_none(), "{name} stands twice");
        }
    }
    found
}

/// Names such as `THRESH-2` in a text, with ranges such as `SAMPLE-1 to SAMPLE-11` filled in.
fn citations(text: &str, sections: &BTreeSet<String>) -> Vec<String> {
    let words: Vec<&str> =
        text.split(|c: char| !c.is_ascii_alphanumeric() && c != '-').filter(|word| !word.is_empty()).collect();
    let parse = |word: &str| {
        let (section, number) = word.rsplit_once('-')?;
        sections.contains(section).then(|| Some((section.to_owned(), number.parse::<u32>().ok()?))).flatten()
    };
    let mut found = Vec::new();
    for (i, word) in words.iter().enumerate() {
        let Some((section, number)) = parse(word) else { continue };
        found.push(format!("{section}-{number}"));
        if words.get(i + 1) == Some(&"to")
            && let Some((to_section, last)) = words.get(i + 2).and_then(|word| parse(word))
            && to_section == section
        {
            found.extend((number + 1..last).map(|n| format!("{section}-{n}")));
        }
    }
    found
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") && !path.ends_with("tests.rs") {
            found.push(path);
        }
    }
    found
}

/// Everything cited under a folder; a citation of nothing fails.
fn cited(folder: &str, requirements: &BTreeMap<String, String>) -> BTreeSet<String> {
    let sections = requirements.keys().map(|name| name.rsplit_once('-').unwrap().0.to_owned()).collect();
    let mut all = BTreeSet::new();
    for path in sources(&root().join(folder)) {
        let text = fs::read_to_string(&path).unwrap();
        // What only a test cites is not implemented by it.
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        for name in citations(code, &sections) {
            assert!(requirements.contains_key(&name), "{} cites {name}, which SPEC.md does not have", path.display());
            all.insert(name);
        }
    }
    all
}

#[test]
fn every_requirement_is_one_sentence_with_one_must() {
    let requirements = requirements();
    assert!(requirements.len() >= 80, "only {} requirements were found", requirements.len());
    for (name, sentence) in &requirements {
        assert_eq!(sentence.matches("MUST").count(), 1, "{name}: {sentence}");
    }
}

#[test]
fn numbers_of_a_section_have_no_gaps() {
    let mut last: BTreeMap<String, BTreeSet<u32>> = BTreeMap::new();
    for name in requirements().keys() {
        let (section, number) = name.rsplit_once('-').unwrap();
        last.entry(section.to_owned()).or_default().insert(number.parse().unwrap());
    }
    for (section, numbers) in last {
        let count = u32::try_from(numbers.len()).unwrap();
        assert_eq!(numbers.into_iter().collect::<Vec<_>>(), (1..=count).collect::<Vec<_>>(), "{section}");
    }
}

/// Every requirement on a stage is cited by both pipelines, every other one by the code that is bound by it.
#[test]
fn every_requirement_is_cited_where_it_is_implemented() {
    let requirements = requirements();
    let [reference, port, verify] =
        ["reference/src", "fixedpoint/src", "verify/src"].map(|folder| cited(folder, &requirements));
    let stages = [
        "LINE", "THRESH", "REGION", "HYPO", "CROSS", "HOMOG", "SAMPLE", "DECODE", "MERGE", "EDGE", "FIT", "EXTENT",
        "TRELLIS", "ACCEPT", "POSE", "COV", "CODE", "EXPOSE", "SKEW", "LAYER", "MOTION", "OBSERVE", "FILTER", "TIME",
        "LOCATE",
    ];
    let mut uncited = Vec::new();
    for name in requirements.keys() {
        let section = name.rsplit_once('-').unwrap().0;
        let places: &[(&str, bool)] = if stages.contains(&section) {
            &[("reference/src", reference.contains(name)), ("fixedpoint/src", port.contains(name))]
        } else {
            match section {
                "SAME" => &[("verify/src", verify.contains(name))],
                // Readings of the paper, carried out by the requirements that cite them.
                "ERRATA" => &[],
                _ => &[("reference/src or verify/src", reference.contains(name) || verify.contains(name))],
            }
        };
        uncited.extend(places.iter().filter(|(_, cited)| !cited).map(|(place, _)| format!("{name} in {place}")));
    }
    assert!(uncited.is_empty(), "not cited: {uncited:#?}");
}

/// The sample in the README has a row for every stage, and they pass.
#[test]
fn the_readme_shows_the_table_as_it_is() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let sample = readme.split("```text").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let rows: Vec<Vec<&str>> = sample.lines().map(|line| line.split_whitespace().collect()).collect();
    for row in verify::bounds::TABLE {
        let shown = rows.iter().find(|words| words.first() == Some(&row.name)).expect(row.name);
        assert_eq!(shown[1], format!("{:?}", row.class).to_lowercase());
        assert_eq!(shown.last(), Some(&"pass"));
    }
}

/// A file's text before its tests.
fn code(path: &str) -> String {
    let text = fs::read_to_string(root().join(path)).unwrap();
    text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default().to_owned()
}

/// The functions and methods that a module offers, those of its parts included.
fn offered(path: &str) -> BTreeSet<String> {
    let code = code(path);
    let name = |line: &str| {
        let line = line.trim_start();
        let function = line.strip_prefix("pub fn ").and_then(|rest| rest.split(['(', '<']).next());
        let passed_on = line.strip_prefix("pub use ").and_then(|rest| rest.trim_end_matches(';').rsplit("::").next());
        function.or(passed_on).map(str::to_owned)
    };
    code.lines().filter_map(name).collect()
}

/// The methods of a module's trait.
fn methods(path: &str) -> BTreeSet<String> {
    let code = code(path);
    let names = code.lines().filter_map(|line| line.strip_prefix("    fn ")?.split(['(', '<']).next());
    names.map(str::to_owned).collect()
}

/// A stage is the same function of the same module on either side, and reports by the same method of the observer.
#[test]
fn both_pipelines_have_the_same_stages() {
    let stages = [
        ("threshold", "threshold"),
        ("regions", "regions"),
        ("hypotheses", "hypotheses"),
        ("hypotheses", "check"),
        ("sampling", "sample"),
        ("decode", "decode"),
        ("decode", "half_word"),
        ("codeword", "encode"),
        ("codeword", "decode"),
        ("merge", "merge"),
        ("merge", "merge_extents"),
        ("edge", "ink"),
        ("fit", "fit"),
        ("extents", "extents"),
        ("trellis", "decode"),
        ("trellis", "decode_again"),
        ("accept", "accept"),
        ("accept", "margin"),
        ("whiteness", "correlations"),
        ("covariance", "transform"),
        ("covariance", "paper"),
        ("merge", "withdraw_ambiguous"),
        ("pose", "pose"),
        ("detect", "detect"),
        ("motion", "predict"),
        ("motion", "step_noise"),
        ("observation", "linearised"),
        ("observation", "robot_in_world"),
        ("filter", "predict"),
        ("filter", "observe"),
        ("exposure", "row_time"),
        ("exposure", "seen"),
        ("skew", "shift"),
        ("detect", "detect_moving"),
        ("layers", "layers"),
        ("grid", "landmark_in_world"),
        ("places", "landmark_in_world"),
        ("timeline", "read"),
        ("timeline", "observe"),
        ("timeline", "restart"),
        ("timeline", "ways_between"),
        ("localizer", "read"),
        ("localizer", "image"),
        ("localizer", "observe_pose"),
    ];
    for (module, function) in stages {
        for pipeline in ["reference", "fixedpoint"] {
            let found = offered(&format!("{pipeline}/src/{module}.rs"));
            assert!(found.contains(function), "{pipeline} has no {module}::{function}, but {found:?}");
        }
    }
    let mut reference = methods("reference/src/observer.rs");
    let port = methods("fixedpoint/src/observer.rs");
    // The port decides HOMOG-3 exactly; the reference reports its margin, and those of ACCEPT.
    assert!(reference.remove("homography") && reference.remove("tested") && port.len() >= 12);
    assert_eq!(reference, port);
}

/// Both pipelines have the same modules; what only one of them has is listed with its reason.
#[test]
fn both_pipelines_have_the_same_modules() {
    let modules = |folder: &str| -> BTreeSet<String> {
        let text = fs::read_to_string(root().join(folder).join("src/lib.rs")).unwrap();
        let names = text.lines().filter_map(|line| line.strip_prefix("pub mod "));
        names.map(|name| name.trim_end_matches(';').to_owned()).collect()
    };
    let (reference, port) = (modules("reference"), modules("fixedpoint"));
    let only_in_reference: Vec<_> = reference.difference(&port).cloned().collect();
    let only_in_port: Vec<_> = port.difference(&reference).cloned().collect();
    // Design framework, bound, forward model, simulated robot and the paper's regressions are no pipeline; number formats, their arithmetic
    // and the sums of a fit are what float64 and a matrix library bring along.
    assert_eq!(only_in_reference, ["area", "bound", "range", "regression", "render", "world"]);
    let arithmetic = [
        "binary",
        "cordic",
        "elimination",
        "formats",
        "ink",
        "inverse",
        "light",
        "projection",
        "ratio",
        "reciprocal",
        "rotation",
        "sweep",
    ];
    assert_eq!(only_in_port, arithmetic);
}
