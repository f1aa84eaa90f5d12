//! The parts: what each shows, its command, and which of its numbers the page repeats.

use crate::record::{Outcome, Taken};
use crate::table::{NAME, Table};
use crate::tools;
use clap::builder::PossibleValuesParser;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;
use std::{fs, io};

/// The exit code of a command that cannot do its work on this machine.
const CANNOT_RUN_HERE: i32 = 3;

/// One part of the evidence.
pub(crate) struct Part {
    /// Name on the command line and of its folder.
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    /// What it shows, in a sentence or two.
    pub(crate) shows: &'static str,
    /// The command; `{out}` is the part's folder.
    command: &'static str,
    /// The command of `--full`, where it is another.
    full: Option<&'static str>,
    /// Tables made of what it writes.
    pub(crate) tables: &'static [Table],
    /// Files of its folder to look at: path and what it is.
    pub(crate) files: &'static [(&'static str, &'static str)],
}

/// The names, for the command line.
pub(crate) fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(PARTS.iter().map(|part| part.name))
}

impl Part {
    /// Runs its command with its output in `log.txt`.
    pub(crate) fn run(&self, out: &Path, full: bool) -> io::Result<Taken> {
        let folder = out.join(self.name);
        fs::create_dir_all(&folder)?;
        let command = self.full.filter(|_| full).unwrap_or(self.command).replace("{out}", &folder.to_string_lossy());
        let log = folder.join("log.txt");
        let file = fs::File::create(&log)?;
        let begun = Instant::now();
        let status = Command::new("bash")
            .args(["-euo", "pipefail", "-c", &command])
            .env("NO_COLOR", "1")
            .stdin(Stdio::null())
            .stdout(file.try_clone()?)
            .stderr(file)
            .status()?;
        let outcome = match status.code() {
            Some(0) => Outcome::Held,
            Some(CANNOT_RUN_HERE) => Outcome::NotRun,
            _ => Outcome::Failed,
        };
        let seconds = begun.elapsed().as_secs();
        Ok(Taken { outcome, command, commit: tools::commit(), seconds, last_line: last_line(&log)? })
    }

    /// The end of its log, for whoever sees no more than what the command prints.
    pub(crate) fn last_words(&self, out: &Path) -> io::Result<String> {
        let text = String::from_utf8_lossy(&fs::read(out.join(self.name).join("log.txt"))?).into_owned();
        let lines: Vec<&str> = text.lines().collect();
        Ok(lines.get(lines.len().saturating_sub(LAST_WORDS)..).unwrap_or_default().join("\n"))
    }
}

/// Lines of a log that say why a command failed.
const LAST_WORDS: usize = 60;

/// The last line that is not empty.
fn last_line(log: &Path) -> io::Result<String> {
    let text = String::from_utf8_lossy(&fs::read(log)?).into_owned();
    Ok(text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default().trim().to_owned())
}

/// All of them, in the page's order.
pub(crate) const PARTS: &[Part] = &[
    Part {
        name: "certificate",
        title: "Certificate",
        shows: "Both pipelines in lockstep over camera images, rendered scenes, distances and routes: every stage's result \
                identical, or within its derived bound, or a decision that was marginal in the reference itself.",
        command: "cargo run --release --locked --quiet -- certify --frames 100000 --seed 4 --out {out}",
        full: Some("cargo run --release --locked --quiet -- certify --frames 1000000 --seed 4 --routes 10 --out {out}"),
        tables: &[
            Table {
                caption: "Stage by stage",
                file: "certificate.json",
                rows: "/stages",
                columns: &[
                    ("stage", "stage"),
                    ("class", "class"),
                    ("cases", "cases"),
                    ("largest difference", "max"),
                    ("bound", "bound"),
                    ("unit", "unit"),
                    ("used", "share"),
                    ("marginal", "marginal"),
                    ("failures", "failures"),
                    ("verdict", "verdict"),
                ],
            },
            Table {
                caption: "What the specification asks besides",
                file: "certificate.json",
                rows: "/checks",
                columns: &[("check", "check"), ("found", "found"), ("verdict", "verdict")],
            },
        ],
        files: &[("certificate.json", "the whole certificate")],
    },
    Part {
        name: "self-test",
        title: "The comparison fails when it should",
        shows: "Every stage of the port disturbed by slightly more than its bound fails the run, and is named; by slightly \
                less, it passes.",
        command: "cargo run --release --locked --quiet -- certify --self-test",
        full: None,
        tables: &[],
        files: &[],
    },
    Part {
        name: "tests",
        title: "Tests",
        shows: "Unit, property, differential and command-line tests, the paper's tables, the replay of all fuzzing corpora, \
                the source check of the port, and proofs' harnesses on samples.",
        command: "cargo test --locked",
        full: Some("BARLOC_RUNS=100 BARLOC_FRAMES=10000000 BARLOC_VIEWS=1000 cargo test --locked -- --nocapture"),
        tables: &[],
        files: &[],
    },
    Part {
        name: "proofs",
        title: "Proofs",
        shows: "Kani's harnesses, compiled to wasm32, translated to C and decided by CBMC: each reaches its end, each fails once \
                a fault is seeded, and its loops are unwound far enough.",
        command: "verify/proofs/setup && verify/proofs/prove --out {out}",
        full: None,
        tables: &[
            Table {
                caption: "In all",
                file: "proofs.json",
                rows: "",
                columns: &[
                    ("claims", "claims"),
                    ("hold", "hold"),
                    ("CPU seconds", "seconds"),
                    ("covers not met", "unmet"),
                    ("tools", "tools"),
                ],
            },
            Table {
                caption: "Claim by claim; CPU seconds of the proof, of its reachability and of its fault",
                file: "proofs.json",
                rows: "/proofs",
                columns: &[
                    ("proof", "proof"),
                    ("kind", "kind"),
                    ("claim", "claim"),
                    ("domain", "domain"),
                    ("solver", "solver"),
                    ("loops", "unwinding"),
                    ("CPU seconds", "seconds"),
                    ("MB", "megabytes"),
                    ("reachable", "reach"),
                    ("seeded fault", "fault"),
                    ("with it", "twin"),
                    ("verdict", "verdict"),
                ],
            },
        ],
        files: &[("proofs.json", "all of it as JSON")],
    },
    Part {
        name: "kani",
        title: "The same proofs by Kani",
        shows: "The harnesses as Kani's own front end sees them, where it is installed.",
        command: "cargo kani --version || { echo 'Kani is not installed; its proofs are those that CBMC decided' >&2; exit 3; }; \
                  cargo kani --package barloc-proofs",
        full: None,
        tables: &[],
        files: &[],
    },
    Part {
        name: "trace",
        title: "Requirements",
        shows: "Every requirement of SPEC.md, where each pipeline implements it and where it is tested, by duvet.",
        command: "verify/evidence/trace --out {out}",
        full: None,
        tables: &[Table {
            caption: "Requirement by requirement",
            file: "matrix.json",
            rows: "",
            columns: &[
                ("requirement", "requirement"),
                ("section", "section"),
                ("reference", "reference"),
                ("fixedpoint", "fixedpoint"),
                ("verify", "verify"),
                ("tests", "tests"),
                ("exception", "exception"),
            ],
        }],
        files: &[("report.html", "duvet's report"), ("matrix.json", "the matrix as JSON")],
    },
    Part {
        name: "fuzz",
        title: "Fuzzing",
        shows: "Both pipelines on what a fuzzer makes up, compared as in the certificate, and the readers of files.",
        command: "fuzz/run --seconds 20 --jobs 2 --out {out}",
        full: Some("fuzz/run --seconds 1800 --cpu --jobs 2 --out {out}"),
        tables: &[Table {
            caption: "Target by target",
            file: "targets.json",
            rows: "",
            columns: &[
                ("target", "target"),
                ("executions", "executions"),
                ("CPU seconds", "cpu_seconds"),
                ("a second", "executions_per_cpu_second"),
                ("edges", "coverage/edges"),
                ("inputs", "corpus_files"),
                ("MiB", "peak_rss_mib"),
                ("findings", "findings"),
                ("commit", "commit"),
            ],
        }],
        files: &[("targets.json", "the same as JSON")],
    },
    Part {
        name: "fuzz-coverage",
        title: "What fuzzing reaches",
        shows: "Lines, regions and functions of the port that each target's inputs run.",
        command: "fuzz/cover --out {out} --corpus {out}/../fuzz/corpus",
        full: None,
        tables: &[Table {
            caption: "Per cent of the port",
            file: "targets.json",
            rows: "",
            columns: &[
                ("target", "target"),
                ("lines", "port/lines/percent"),
                ("regions", "port/regions/percent"),
                ("functions", "port/functions/percent"),
            ],
        }],
        files: &[("targets.json", "file by file, as JSON")],
    },
    Part {
        name: "fuzz-faults",
        title: "Fuzzing finds what is wrong",
        shows: "Each target, with a fault seeded behind its check: how long it takes to find it, within 5 minutes.",
        command: "fuzz/faults --out {out}",
        full: None,
        tables: &[Table {
            caption: "Target by target",
            file: "targets.json",
            rows: "",
            columns: &[
                ("target", "target"),
                ("found", "found"),
                ("seconds", "seconds"),
                ("executions", "executions"),
                ("what it said", "said"),
            ],
        }],
        files: &[("targets.json", "the same as JSON")],
    },
    Part {
        name: "mutants",
        title: "Mutants",
        shows: "How many changes of the port make a test fail; each that does not, with its reason.",
        command: "verify/evidence/mutants --out {out}",
        full: None,
        tables: &[
            Table {
                caption: "In all",
                file: "mutants.json",
                rows: "",
                columns: &[
                    ("score", "score"),
                    ("viable", "viable"),
                    ("found", "caught"),
                    ("stopped by time", "timeout"),
                    ("not found", "missed"),
                    ("do not compile", "unviable"),
                    ("holds", "holds"),
                ],
            },
            Table {
                caption: "File by file",
                file: "mutants.json",
                rows: "/files",
                columns: &[
                    ("file", NAME),
                    ("found", "caught"),
                    ("stopped by time", "timeout"),
                    ("not found", "missed"),
                    ("do not compile", "unviable"),
                ],
            },
            Table {
                caption: "What no test finds, and why",
                file: "mutants.json",
                rows: "/survivors",
                columns: &[("mutant", "mutant"), ("where", "at"), ("reason", "reason")],
            },
        ],
        files: &[("mutants.json", "every mutant and the test that finds it")],
    },
    Part {
        name: "coverage",
        title: "Coverage",
        shows: "Lines and regions of the port that its tests reach.",
        command: "verify/evidence/coverage --out {out}",
        full: None,
        tables: &[
            Table {
                caption: "In all",
                file: "coverage.json",
                rows: "",
                columns: &[("regions", "regions"), ("lines", "lines"), ("at least", "least"), ("holds", "holds")],
            },
            Table {
                caption: "File by file",
                file: "coverage.json",
                rows: "/files",
                columns: &[
                    ("file", NAME),
                    ("regions", "regions"),
                    ("covered", "regions_covered"),
                    ("lines", "lines"),
                    ("covered", "lines_covered"),
                    ("places not reached", "not_covered"),
                ],
            },
        ],
        files: &[("coverage.json", "with the places that no test reaches")],
    },
    Part {
        name: "miri",
        title: "Miri",
        shows: "The port's tests in an interpreter that notices undefined behaviour.",
        command: "verify/evidence/miri --out {out}",
        full: None,
        tables: &[Table {
            caption: "In all",
            file: "miri.json",
            rows: "",
            columns: &[
                ("passed", "passed"),
                ("failed", "failed"),
                ("seconds", "seconds"),
                ("tool", "tool"),
                ("holds", "holds"),
            ],
        }],
        files: &[("miri.log", "what it said"), ("miri.json", "the same as JSON")],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    fn part(command: &'static str) -> Part {
        Part { name: "part", title: "", shows: "", command, full: None, tables: &[], files: &[] }
    }

    #[test]
    fn a_part_holds_fails_or_cannot_run() {
        let folder = std::env::temp_dir().join(format!("barloc-parts-{}", std::process::id()));
        let outcome = |command| {
            let taken = part(command).run(&folder, false).unwrap();
            (taken.outcome, taken.last_line)
        };
        assert_eq!(outcome("echo well >{out}/a; cat {out}/a"), (Outcome::Held, "well".to_owned()));
        assert_eq!(part("").last_words(&folder).unwrap(), "well");
        assert_eq!(outcome("echo no kani >&2; exit 3"), (Outcome::NotRun, "no kani".to_owned()));
        assert_eq!(outcome("false; echo never").0, Outcome::Failed);
        assert_eq!(outcome("no-such-command-at-all").0, Outcome::Failed);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn names_are_folders_of_their_own() {
        let mut names: Vec<_> = PARTS.iter().map(|part| part.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), PARTS.len());
        assert!(names.iter().all(|name| name.chars().all(|c| c.is_ascii_lowercase() || c == '-')));
    }
}
