//! Runs of the model checker, and what they say.

use crate::library::{Program, Tools};
use crate::shell::{self, Ended};
use crate::tree::Claim;
use std::fs;
use std::path::Path;
use std::process::Command;

/// What a run has shown.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// Nothing that must not happen does, or everything that must be reachable is.
    Holds,
    /// What happens, or is not reachable.
    Fails(String),
    /// It was not decided: too long, or not understood.
    Undecided(String),
}

/// A run.
#[derive(Clone, Debug)]
pub(crate) struct Checked {
    pub(crate) verdict: Verdict,
    pub(crate) seconds: f64,
    pub(crate) megabytes: u64,
    /// The lines of the covers that were met.
    pub(crate) covered: Vec<usize>,
}

impl Checked {
    fn new(ended: &Ended, verdict: Verdict) -> Self {
        Self { verdict, seconds: ended.seconds, megabytes: ended.megabytes, covered: Vec::new() }
    }

    /// The same of a run that had to fail; `why` is said if it did not.
    pub(crate) fn turned(self, why: &str) -> Self {
        let verdict = match self.verdict {
            Verdict::Holds => Verdict::Fails(why.to_owned()),
            Verdict::Fails(_) => Verdict::Holds,
            undecided @ Verdict::Undecided(_) => undecided,
        };
        Self { verdict, ..self }
    }
}

/// Whether nothing that must not happen does, loops beyond their bounds among it.
pub(crate) fn prove(tools: &Tools, claim: &Claim, program: &Program, output: &Path) -> Result<Checked, String> {
    let mut command = command(tools, claim, program)?;
    command.args(["--unwinding-assertions", "--stop-on-fail"]);
    let ended = shell::measured(&command, claim.seconds, output)?;
    let verdict = match ended.code {
        Some(0) if ended.output.contains("\nVERIFICATION SUCCESSFUL") => Verdict::Holds,
        Some(10) if ended.output.contains("\nVERIFICATION FAILED") => Verdict::Fails(violated(&ended.output)),
        _ => Verdict::Undecided(last_words(&ended.output)),
    };
    Ok(Checked::new(&ended, verdict))
}

/// Whether the end of the proof and every cover that it meets are reachable.
pub(crate) fn reach(tools: &Tools, claim: &Claim, program: &Program, output: &Path) -> Result<Checked, String> {
    let mut command = command(tools, claim, program)?;
    command.args(["--no-unwinding-assertions", "-DREACH"]);
    let ended = shell::measured(&command, claim.seconds, output)?;
    // An assertion that fails is what was to be reached.
    let reached = |what: &str| ended.output.lines().any(|line| line.ends_with(&format!(" {what}: FAILURE")));
    let met: Vec<usize> = claim.covers.iter().copied().filter(|line| reached(&format!("met {line}"))).collect();
    let missing: Vec<String> = met
        .iter()
        .filter(|line| !reached(&format!("cover {line}")))
        .map(|line| format!("the cover in line {line}"))
        .collect();
    let verdict = if ended.code != Some(10) && ended.code != Some(0) {
        Verdict::Undecided(last_words(&ended.output))
    } else if !reached("the end") {
        Verdict::Fails("its end is not reachable".to_owned())
    } else if met.is_empty() {
        Verdict::Fails("it meets no cover".to_owned())
    } else if let [missing, ..] = missing.as_slice() {
        Verdict::Fails(format!("{missing} is not reachable"))
    } else {
        Verdict::Holds
    };
    Ok(Checked { covered: met, ..Checked::new(&ended, verdict) })
}

/// Runs one sweep of a program of all.
pub(crate) fn sweep(claim: &Claim, program: &Path, output: &Path) -> Result<Checked, String> {
    let mut command = Command::new(program);
    command.arg(&claim.name);
    let ended = shell::measured(&command, claim.seconds, output)?;
    let verdict = match ended.code {
        Some(0) => Verdict::Holds,
        Some(1 | 101) => Verdict::Fails(panicked(&ended.output)),
        _ => Verdict::Undecided(last_words(&ended.output)),
    };
    Ok(Checked::new(&ended, verdict))
}

/// Whether Gappa proves a script.
pub(crate) fn round(tools: &Tools, claim: &Claim, script: &str, output: &Path) -> Result<Checked, String> {
    let path = output.with_extension("g");
    fs::write(&path, script).map_err(|why| format!("{}: {why}", path.display()))?;
    let mut command = Command::new(tools.folder.join("gappa"));
    // What is not so is said at once; else it would look for ever smaller parts of the domain in which it is.
    command.arg("-Eno-auto-dichotomy").arg(&path);
    let ended = shell::measured(&command, claim.seconds, output)?;
    let verdict = match ended.code {
        Some(0) => Verdict::Holds,
        Some(1)
            if ["were not satisfied", "no contradiction was found"].iter().any(|why| ended.output.contains(why)) =>
        {
            Verdict::Fails(last_words(&ended.output))
        }
        _ => Verdict::Undecided(last_words(&ended.output)),
    };
    Ok(Checked::new(&ended, verdict))
}

fn command(tools: &Tools, claim: &Claim, program: &Program) -> Result<Command, String> {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../checker");
    let mut command = Command::new(tools.folder.join("cbmc"));
    command.arg(sources.join("main.c")).arg("-I").arg(&sources).arg("-I").arg(tools.folder.join("../root/usr/include"));
    command.arg(format!("-DPROGRAM=\"{}\"", program.path.display()));
    command.arg(format!("-DPROOF=Z_pZ_proof_{}", claim.name)).arg(format!("-DMEMORY={}", program.memory));
    // C's own pitfalls are none of the program's: wasm2c has asked for everything that can happen.
    command.args(["--no-standard-checks", "--drop-unused-functions", "--slice-formula"]);
    if claim.cells {
        command.args(["--max-field-sensitivity-array-size", "8192"]);
    }
    command.args(["--unwind", &claim.unwind.to_string(), "--unwindset", &copies()]);
    match claim.solver.as_str() {
        "minisat" => {}
        "cadical" | "kissat" => {
            command.arg("--external-sat-solver").arg(tools.folder.join(&claim.solver));
        }
        "z3" => {
            command.arg("--z3");
        }
        other => return Err(format!("there is no solver {other}")),
    }
    let path = std::env::var("PATH").unwrap_or_default();
    command.env("PATH", format!("{}:{path}", tools.folder.display()));
    Ok(command)
}

/// The bounds of the loops that copy and fill memory, of which the lengths are constants.
fn copies() -> String {
    let functions = ["w2c_memset", "w2c_memcpy", "w2c_memmove"].map(str::to_owned).into_iter();
    let builtin = ["memset", "memcpy", "memmove"].map(|name| format!("w2c_compiler_builtins__mem__{name}"));
    let loops = functions.chain(builtin).flat_map(|name| (0..6).map(move |number| format!("{name}.{number}:1100")));
    std::iter::once("place.0:8192".to_owned()).chain(loops).collect::<Vec<_>>().join(",")
}

/// What a run that stopped at a failure says of it.
fn violated(output: &str) -> String {
    let after = output.split("Violated property:").nth(1).unwrap_or_default();
    let what = after.lines().map(str::trim).filter(|line| !line.is_empty()).nth(1);
    what.unwrap_or("not said").to_owned()
}

/// What the first panic says.
fn panicked(output: &str) -> String {
    let mut after = output.lines().skip_while(|line| !line.contains("panicked at"));
    after.nth(1).map_or_else(|| last_words(output), |line| line.trim().to_owned())
}

fn last_words(output: &str) -> String {
    output.lines().rev().map(str::trim).find(|line| !line.is_empty()).unwrap_or("no words").to_owned()
}
