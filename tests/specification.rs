//! SPEC.md and the code cite each other: requirements are well formed, each is quoted where it is implemented and above the
//! test that fails without it, and nothing is left unquoted. [duvet] reads the same quotes for its report
//! (`verify/evidence/trace`); here nothing but the tree is needed.
//!
//! `BARLOC_MATRIX=file` writes what is cited where as JSON.
//!
//! [duvet]: https://github.com/awslabs/duvet

use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Sections on what both pipelines compute.
const STAGES: [&str; 25] = [
    "LINE", "THRESH", "REGION", "HYPO", "CROSS", "HOMOG", "SAMPLE", "DECODE", "MERGE", "EDGE", "FIT", "EXTENT",
    "TRELLIS", "ACCEPT", "POSE", "COV", "CODE", "EXPOSE", "SKEW", "LAYER", "MOTION", "OBSERVE", "FILTER", "TIME",
    "LOCATE",
];

/// What else the port has to do itself.
const ALSO_IN_THE_PORT: [&str; 10] =
    ["FRAME-5", "LAND-1", "LAND-3", "LAND-6", "LAND-7", "CAM-7", "GRID-1", "GRID-2", "GRID-3", "GRID-6"];

/// Tests that show the port to be as the reference, whatever that does: the one of both that they stand for is the one that no
/// test of its own holds to the text.
const DIFFERENTIAL: [&str; 2] = ["tests/differential.rs", "tests/filters.rs"];

fn section(name: &str) -> &str {
    name.rsplit_once('-').unwrap().0
}

fn binds_both(name: &str) -> bool {
    STAGES.contains(&section(name)) || ALSO_IN_THE_PORT.contains(&name)
}

/// The lines that begin with `- **NAME-1**`, by name.
fn lines_of_requirements() -> BTreeMap<String, String> {
    let text = fs::read_to_string(root().join("reference/SPEC.md")).unwrap();
    let mut found = BTreeMap::new();
    for line in text.lines() {
        if let Some((name, _)) = line.strip_prefix("- **").and_then(|rest| rest.split_once("** ")) {
            let before = found.insert(name.to_owned(), line.to_owned());
            assert!(before.is_none(), "{name} stands twice");
        }
    }
    found
}

/// Requirements by name, up to the end of the sentence: what is quoted.
fn requirements() -> BTreeMap<String, String> {
    // Two points are a range, as in 0 .. 2.
    let end = |line: &str| line.match_indices(". ").map(|(at, _)| at).find(|&at| !line[..at].ends_with('.'));
    let sentence = |line: &str| end(line).map_or(line, |end| &line[..=end]).to_owned();
    lines_of_requirements().into_iter().map(|(name, line)| (name, sentence(&line))).collect()
}

/// Names such as `THRESH-2` in a text, with ranges such as `SAMPLE-1 to SAMPLE-11` filled in.
fn mentions(text: &str, sections: &BTreeSet<String>) -> Vec<String> {
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

/// Whether a line begins a module of tests.
fn begins_tests([attribute, module]: [&str; 2]) -> bool {
    attribute == "#[cfg(test)]" && module.ends_with("mod tests {")
}

/// The number of lines before a file's tests.
fn lines_of_code(path: &Path, text: &str) -> usize {
    if path.ends_with("tests.rs") || path.starts_with("tests") {
        return 0;
    }
    let lines: Vec<&str> = text.lines().collect();
    lines.windows(2).position(|two| begins_tests([two[0], two[1]])).unwrap_or(lines.len())
}

/// All source files, from the tree's root.
fn sources() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> = ["reference/src", "fixedpoint/src", "verify", "tests"].map(PathBuf::from).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let path = folder.join(entry.file_name());
            if entry.path().is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// A requirement quoted beside what implements it or tests it.
#[derive(Clone, Debug)]
struct Citation {
    path: PathBuf,
    line: usize,
    target: String,
    is_test: bool,
    quote: String,
    /// The first line below it and those that follow it.
    below: String,
}

impl Citation {
    fn name(&self) -> &str {
        self.quote.strip_prefix("- **").and_then(|rest| rest.split_once("**")).map_or("", |(name, _)| name)
    }

    fn place(&self) -> String {
        format!("{}:{}", self.path.display(), self.line)
    }

    /// The file, and of a test its name.
    fn item(&self) -> String {
        let function = self.below.lines().find_map(|line| line.trim_start().strip_prefix("fn ")?.split('(').next());
        match function {
            Some(function) if self.is_test => format!("{}: {function}", self.path.display()),
            _ => self.path.display().to_string(),
        }
    }
}

/// The blocks of `//=` and `//#` lines of a file.
fn citations_of(path: &Path, text: &str) -> Vec<Citation> {
    let mut found: Vec<Citation> = Vec::new();
    let mut open = 0;
    let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
    for (i, line) in lines.iter().enumerate() {
        if let Some(meta) = line.strip_prefix("//=") {
            match meta.trim().split_once('=') {
                None => found.push(Citation {
                    path: path.to_owned(),
                    line: i + 1,
                    target: meta.trim().to_owned(),
                    is_test: false,
                    quote: String::new(),
                    below: String::new(),
                }),
                Some(("type", "test")) => found.last_mut().expect("a citation").is_test = true,
                Some(other) => panic!("{}:{}: {other:?}", path.display(), i + 1),
            }
        } else if let Some(part) = line.strip_prefix("//#") {
            let quote = &mut found.last_mut().expect("a citation").quote;
            quote.push_str(if quote.is_empty() { "" } else { " " });
            quote.push_str(part.trim());
        } else if open < found.len() {
            let below = lines[i..lines.len().min(i + 3)].join("\n");
            found[open..].iter_mut().for_each(|citation| citation.below.clone_from(&below));
            open = found.len();
        }
    }
    found
}

fn citations() -> Vec<Citation> {
    let read = |path: &PathBuf| citations_of(path, &fs::read_to_string(root().join(path)).unwrap());
    sources().iter().flat_map(read).collect()
}

/// A requirement without a test, as duvet has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Exception {
    target: String,
    quote: String,
    reason: String,
}

/// What has no test, by name.
fn exceptions() -> BTreeMap<String, Exception> {
    #[derive(Deserialize)]
    struct File {
        exception: Vec<Exception>,
    }
    let text = fs::read_to_string(root().join(".duvet/exceptions/untested.toml")).unwrap();
    let file: File = toml::from_str(&text).unwrap();
    let name = |exception: &Exception| exception.quote.split("**").nth(1).unwrap_or_default().to_owned();
    file.exception.into_iter().map(|exception| (name(&exception), exception)).collect()
}

/// Where a citation stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Room {
    Reference,
    Port,
    /// What compares both.
    Differential,
    /// What is about both, or about neither.
    Verify,
}

impl Room {
    fn of(path: &Path) -> Self {
        if path.starts_with("reference") {
            Self::Reference
        } else if path.starts_with("fixedpoint") {
            Self::Port
        } else if DIFFERENTIAL.iter().any(|file| path == Path::new(file)) {
            Self::Differential
        } else {
            Self::Verify
        }
    }
}

#[test]
fn every_requirement_is_one_sentence_with_one_must() {
    let lines = lines_of_requirements();
    assert!(lines.len() >= 80, "only {} requirements were found", lines.len());
    for (name, line) in &lines {
        assert_eq!(line.matches("MUST").count(), 1, "{name}: {line}");
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

/// What is quoted is what SPEC.md says, and stands where it says something: above a test, or in the code.
#[test]
fn every_citation_is_of_a_sentence_that_stands_in_the_specification() {
    let requirements = requirements();
    let mut wrong = Vec::new();
    for citation in citations() {
        let text = fs::read_to_string(root().join(&citation.path)).unwrap();
        let name = citation.name();
        if requirements.get(name) != Some(&citation.quote) {
            wrong.push(format!("{}: not a sentence of SPEC.md: {}", citation.place(), citation.quote));
        } else if citation.target != format!("reference/SPEC.md#{}", section(name).to_lowercase()) {
            wrong.push(format!("{}: {name} is not in {}", citation.place(), citation.target));
        }
        if citation.is_test {
            if !citation.below.starts_with("#[test]\n") {
                wrong.push(format!("{}: {name} is cited as a test above no test", citation.place()));
            }
        } else if citation.line > lines_of_code(&citation.path, &text) {
            wrong.push(format!("{}: {name} is cited by a test as if by code", citation.place()));
        }
    }
    for (name, Exception { target, quote, reason }) in exceptions() {
        let says = requirements.get(&name).is_some_and(|sentence| sentence == quote.trim());
        if !says || target != format!("reference/SPEC.md#{}", section(&name).to_lowercase()) || reason.len() < 20 {
            wrong.push(format!("exception of {name}: {quote}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Every requirement on both pipelines is cited once in each, every other one by the code that is bound by it: one citation
/// is enough, and so none can be left out unnoticed.
#[test]
fn every_requirement_is_cited_where_it_is_implemented() {
    let citations = citations();
    let mut wrong = Vec::new();
    for name in requirements().keys() {
        let mut rooms: Vec<Room> =
            citations.iter().filter(|one| !one.is_test && one.name() == name).map(|one| Room::of(&one.path)).collect();
        rooms.sort_unstable();
        let right = match rooms[..] {
            [Room::Reference, Room::Port] => binds_both(name),
            [Room::Reference | Room::Verify] => !binds_both(name),
            _ => false,
        };
        if !right {
            wrong.push(format!("{name} in {rooms:?}"));
        }
    }
    assert!(wrong.is_empty(), "not cited, or more than once: {wrong:#?}");
}

/// Every requirement is cited above a test that fails where it is not kept, unless that has a reason. Of what binds both
/// pipelines it is a test of either, one of one of them and a comparison of both, or one that holds both to the text.
#[test]
fn every_requirement_is_tested() {
    let (citations, exceptions) = (citations(), exceptions());
    let mut wrong = Vec::new();
    for name in requirements().keys() {
        let mut rooms: Vec<Room> =
            citations.iter().filter(|one| one.is_test && one.name() == name).map(|one| Room::of(&one.path)).collect();
        rooms.sort_unstable();
        let right = match rooms[..] {
            [] => exceptions.contains_key(name),
            _ if exceptions.contains_key(name) => false,
            [Room::Verify] => true,
            [Room::Reference] => !binds_both(name),
            // What "the same" means is all that a comparison can hold to the text.
            [Room::Differential] => section(name) == "SAME",
            [Room::Reference, Room::Port | Room::Differential] | [Room::Port, Room::Differential] => binds_both(name),
            _ => false,
        };
        if !right {
            wrong.push(format!("{name} by {rooms:?}"));
        }
    }
    assert!(wrong.is_empty(), "not tested, or by more than is needed: {wrong:#?}");
}

/// What the text of a file names without quoting it is there, too.
#[test]
fn every_name_that_is_mentioned_is_one_of_the_specification() {
    let requirements = requirements();
    let sections = requirements.keys().map(|name| section(name).to_owned()).collect();
    for path in sources() {
        for name in mentions(&fs::read_to_string(root().join(&path)).unwrap(), &sections) {
            assert!(
                requirements.contains_key(&name),
                "{} mentions {name}, which SPEC.md does not have",
                path.display()
            );
        }
    }
}

/// A row of the matrix: where a requirement is implemented and tested.
#[derive(Serialize)]
struct Row<'a> {
    requirement: &'a str,
    section: &'a str,
    reference: Option<String>,
    fixedpoint: Option<String>,
    verify: Option<String>,
    tests: Vec<String>,
    exception: Option<String>,
}

/// What is cited where, for whoever signs: written where `BARLOC_MATRIX` says.
#[test]
fn the_matrix_has_a_row_for_every_requirement() {
    let (requirements, citations, exceptions) = (requirements(), citations(), exceptions());
    let cited = |name: &str, is_test: bool| {
        citations.iter().filter(move |one| one.is_test == is_test && one.name() == name).collect::<Vec<_>>()
    };
    let row = |name: &'_ String| {
        let by = |room| cited(name, false).iter().find(|one| Room::of(&one.path) == room).map(|one| one.place());
        (by(Room::Reference), by(Room::Port), by(Room::Verify))
    };
    // In the order of the text.
    let text = fs::read_to_string(root().join("reference/SPEC.md")).unwrap();
    let mut names: Vec<&String> = requirements.keys().collect();
    names.sort_by_key(|name| text.find(&format!("- **{name}**")));
    let rows: Vec<Row<'_>> = names
        .into_iter()
        .map(|name| {
            let (reference, fixedpoint, verify) = row(name);
            let tests = cited(name, true).iter().map(|one| one.item()).collect();
            let exception = exceptions.get(name).map(|exception| exception.reason.clone());
            Row { requirement: name, section: section(name), reference, fixedpoint, verify, tests, exception }
        })
        .collect();
    assert_eq!(rows.len(), requirements.len());
    if let Some(path) = std::env::var_os("BARLOC_MATRIX") {
        fs::write(path, serde_json::to_string_pretty(&rows).unwrap() + "\n").unwrap();
    }
}

/// The parser itself: several in a row, what wraps, what is indented, and what stands below.
#[test]
fn citations_are_read_as_they_are_written() {
    let lines = [
        "    /// Some text (LINE-1).",
        "    //= reference/SPEC.md#line",
        "    //# - **LINE-1** First",
        "    //# part.",
        "    //= reference/SPEC.md#fit",
        "    //= type=test",
        "    //# - **FIT-2** Whole.",
        "    #[test]",
        "    fn it() {",
        "    // no citation",
    ];
    let found = citations_of(Path::new("some.rs"), &lines.join("\n"));
    let read: Vec<_> = found.iter().map(|one| (one.line, one.name(), &one.quote[..], one.is_test)).collect();
    assert_eq!(read, [(2, "LINE-1", "- **LINE-1** First part.", false), (5, "FIT-2", "- **FIT-2** Whole.", true)]);
    assert!(found.iter().all(|one| one.below.starts_with("#[test]\n") && one.target.starts_with("reference/SPEC.md#")));
    assert_eq!(found[1].item(), "some.rs: it");
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
    // and the sums of a fit are what float64 and a matrix library bring along; and a bounded list in order is what a growing one that is
    // sorted brings along.
    assert_eq!(only_in_reference, ["area", "bound", "range", "regression", "render", "world"]);
    let arithmetic = [
        "binary",
        "cordic",
        "elimination",
        "formats",
        "in_order",
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
