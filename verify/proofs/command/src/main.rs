//! Proves what is claimed of the port, and that each proof could fail.
//!
//! For each proof in the tree there are three runs of the model checker: the proof itself with its loops' bounds asserted; its
//! end and its covers, which must be reachable; and the proof of a port with the seeded fault that its documentation
//! names, which must fail. For each sweep there are two: the sweep itself, and that of the faulty port.

mod checker;
mod library;
mod report;
mod shell;
mod tree;

use checker::Checked;
use clap::Parser;
use library::{Builder, Tools};
use report::{Outcome, Report};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use tree::{Claim, Kind};

/// Proves what is claimed of the port, and that each proof could fail.
#[derive(Parser)]
struct Arguments {
    /// Where `proofs.json` and the checker's own words are written.
    #[arg(long, default_value = "target/proofs/results")]
    out: PathBuf,
    /// How many proofs at a time.
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Only those with one of these words in their name; all if there is none.
    words: Vec<String>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("proofs: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Whether everything held.
fn run(arguments: &Arguments) -> Result<bool, String> {
    let wanted =
        |claim: &Claim| arguments.words.is_empty() || arguments.words.iter().any(|word| claim.name.contains(word));
    let mut claims: Vec<Claim> = tree::claims()?.into_iter().filter(wanted).collect();
    if claims.is_empty() {
        return Err("no proof has such a name".to_owned());
    }
    // The longest first, so that nobody waits for a last one.
    claims.sort_by_key(|claim| std::cmp::Reverse(claim.seconds));
    let tools = Tools::find()?;
    std::fs::create_dir_all(&arguments.out).map_err(|why| format!("{}: {why}", arguments.out.display()))?;
    let out = arguments.out.canonicalize().map_err(|why| why.to_string())?;
    println!("building");
    let builder = Builder::new()?;
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..arguments.jobs.max(1) {
            let (claims, tools, builder, next, outcomes, out) = (&claims, &tools, &builder, &next, &outcomes, &out);
            scope.spawn(move || {
                while let Some(claim) = claims.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let outcome = decide(claim, tools, builder, out);
                    println!("{}", outcome.line());
                    outcomes.lock().expect("no worker panics").push(outcome);
                }
            });
        }
    });
    let outcomes = outcomes.into_inner().expect("no worker panics");
    let report = Report::new(outcomes, &tools, arguments.words.is_empty());
    report.write(&out.join("proofs.json"))?;
    println!("{}", report.summary());
    Ok(report.holds())
}

fn decide(claim: &Claim, tools: &Tools, builder: &Builder, out: &Path) -> Outcome {
    let runs = match claim.kind {
        Kind::Proof => prove(claim, tools, builder, out),
        Kind::Sweep => sweep(claim, builder, out),
        Kind::Rounding => round(claim, tools, out),
    };
    Outcome::new(claim, runs)
}

/// The three runs of a proof.
fn prove(claim: &Claim, tools: &Tools, builder: &Builder, out: &Path) -> Result<[Checked; 3], String> {
    let words = |run: &str| out.join(format!("{}.{run}txt", claim.name));
    let work = library::folder("work")?;
    let program = tools.program(&builder.library, claim, &work.join(&claim.name))?;
    let proved = checker::prove(tools, claim, &program, &words(""))?;
    let reached = checker::reach(tools, claim, &program, &words("reach."))?;
    let program = tools.program(&builder.faulty(claim)?, claim, &work.join(format!("{}.fault", claim.name)))?;
    let fault = checker::prove(tools, claim, &program, &words("fault."))?;
    Ok([proved, reached, fault])
}

/// The two runs of a sweep; that it reaches its end it says by its exit code.
fn sweep(claim: &Claim, builder: &Builder, out: &Path) -> Result<[Checked; 3], String> {
    let words = |run: &str| out.join(format!("{}.{run}txt", claim.name));
    let swept = checker::sweep(claim, &builder.sweeps, &words(""))?;
    let reached = Checked { seconds: 0.0, ..swept.clone() };
    let fault = checker::sweep(claim, &builder.faulty(claim)?, &words("fault."))?;
    Ok([swept, reached, fault])
}

/// The three runs of a script; hypotheses that nothing fulfils would prove what is not so.
fn round(claim: &Claim, tools: &Tools, out: &Path) -> Result<[Checked; 3], String> {
    let path = library::root().join("verify/proofs/src").join(&claim.file);
    let script = std::fs::read_to_string(&path).map_err(|why| format!("{}: {why}", path.display()))?;
    let (_, right, faulty) = tree::with_fault(&library::root().join("fixedpoint"), &claim.fault)?;
    let run =
        |script: &str, run: &str| checker::round(tools, claim, script, &out.join(format!("{}.{run}txt", claim.name)));
    let with = |port: &str| tree::with_numbers(&script, port);
    let rounded = run(&with(&right)?, "")?;
    let absurd = with(&right)?.replace("|chord - exact0| <=", "1 <=");
    let reached = run(&absurd, "reach.")?.turned("what is not so is proved");
    Ok([rounded, reached, run(&with(&faulty)?, "fault.")?])
}
