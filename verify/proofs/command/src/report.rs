//! What was shown, for people and for other tools, and the table of what there is to be shown.

use crate::checker::{Checked, Verdict};
use crate::library::Tools;
use crate::tree::{Claim, Kind};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What became of a claim.
#[derive(Serialize)]
pub(crate) struct Outcome {
    proof: String,
    file: String,
    kind: &'static str,
    claim: String,
    domain: String,
    solver: String,
    unwinding: Option<u32>,
    /// CPU time of the proof, of its reachability and of its fault.
    seconds: [f64; 3],
    /// The most memory of these.
    megabytes: u64,
    reach: String,
    fault: String,
    twin: String,
    verdict: &'static str,
    /// Why it does not hold.
    why: Option<String>,
    #[serde(skip)]
    covered: Vec<usize>,
    #[serde(skip)]
    covers: Vec<usize>,
}

impl Outcome {
    pub(crate) fn new(claim: &Claim, runs: Result<[Checked; 3], String>) -> Self {
        let mut outcome = Self {
            proof: claim.name.clone(),
            file: claim.file.clone(),
            kind: match claim.kind {
                Kind::Proof => "bounded proof",
                Kind::Sweep => "exhaustive sweep",
                Kind::Rounding => "rounding errors",
            },
            claim: claim.says.clone(),
            domain: claim.domain.clone(),
            solver: claim.solver.clone(),
            unwinding: (claim.kind == Kind::Proof).then_some(claim.unwind),
            seconds: [0.0; 3],
            megabytes: 0,
            reach: String::new(),
            fault: claim.fault.what.clone(),
            twin: String::new(),
            verdict: "fails",
            why: None,
            covered: Vec::new(),
            covers: claim.covers.clone(),
        };
        match runs {
            Ok(runs) => outcome.take(&runs),
            Err(why) => outcome.why = Some(why),
        }
        outcome
    }

    fn take(&mut self, runs: &[Checked; 3]) {
        let [proved, reached, fault] = runs;
        self.seconds = [proved.seconds, reached.seconds, fault.seconds];
        self.megabytes = runs.iter().map(|run| run.megabytes).max().unwrap_or(0);
        self.covered.clone_from(&reached.covered);
        let say = |verdict: &Verdict| match verdict {
            Verdict::Holds => "holds".to_owned(),
            Verdict::Fails(what) => format!("fails: {what}"),
            Verdict::Undecided(what) => format!("undecided: {what}"),
        };
        self.reach = say(&reached.verdict);
        self.twin = say(&fault.verdict);
        let complaints = [
            (proved.verdict != Verdict::Holds).then(|| format!("the claim {}", say(&proved.verdict))),
            (reached.verdict != Verdict::Holds).then(|| self.reach.clone()),
            (!matches!(fault.verdict, Verdict::Fails(_))).then(|| format!("with the fault it {}", self.twin)),
        ];
        self.why = complaints.into_iter().flatten().next();
        if self.why.is_none() {
            self.verdict = "holds";
        }
    }

    /// A line for whoever waits.
    pub(crate) fn line(&self) -> String {
        let [proved, reached, fault] = self.seconds;
        let Self { proof, verdict, megabytes, .. } = self;
        let numbers = format!("{verdict:5}  {proof:52} {proved:6.1} s {reached:6.1} s {fault:6.1} s {megabytes:5} MB");
        match &self.why {
            Some(why) => format!("{numbers}  {why}"),
            None => format!("{numbers}  faulty: {}", self.twin),
        }
    }
}

/// What became of all.
#[derive(Serialize)]
pub(crate) struct Report {
    tools: Vec<String>,
    claims: usize,
    hold: usize,
    /// CPU time of all runs.
    seconds: f64,
    /// Covers that no proof meets.
    unmet: Vec<String>,
    proofs: Vec<Outcome>,
}

impl Report {
    /// Of all claims every cover has to be met by one; of some this is not asked.
    pub(crate) fn new(mut proofs: Vec<Outcome>, tools: &Tools, all: bool) -> Self {
        proofs.sort_by(|one, other| (&one.file, &one.proof).cmp(&(&other.file, &other.proof)));
        let mut met = BTreeMap::new();
        for proof in &proofs {
            for line in &proof.covers {
                *met.entry((proof.file.clone(), *line)).or_insert(false) |= proof.covered.contains(line);
            }
        }
        let unmet = met.into_iter().filter(|(_, met)| all && !met).map(|((file, line), _)| format!("{file}:{line}"));
        Self {
            tools: tools.versions(),
            claims: proofs.len(),
            hold: proofs.iter().filter(|proof| proof.why.is_none()).count(),
            seconds: proofs.iter().flat_map(|proof| proof.seconds).sum(),
            unmet: unmet.collect(),
            proofs,
        }
    }

    pub(crate) fn holds(&self) -> bool {
        self.hold == self.claims && self.unmet.is_empty()
    }

    pub(crate) fn write(&self, path: &Path) -> Result<(), String> {
        let text = serde_json::to_string_pretty(self).map_err(|why| why.to_string())?;
        fs::write(path, text + "\n").map_err(|why| format!("{}: {why}", path.display()))
    }

    pub(crate) fn summary(&self) -> String {
        let unmet =
            if self.unmet.is_empty() { String::new() } else { format!("; no proof meets {}", self.unmet.join(", ")) };
        format!("{} of {} hold, {:.0} s of CPU time{unmet}", self.hold, self.claims, self.seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::claims;
    use std::fmt::Write;

    /// How many claims there are at least: it only grows.
    const LEAST: usize = 58;

    fn table(claims: &[Claim]) -> String {
        let [proofs, sweeps, scripts] = [Kind::Proof, Kind::Sweep, Kind::Rounding]
            .map(|kind| claims.iter().filter(|claim| claim.kind == kind).count());
        let mut text = format!(
            "# What is proved of the port\n\n\
             {proofs} bounded proofs, {sweeps} exhaustive sweeps and {scripts} of rounding errors, each with a fault that makes it fail. Written by\n\
             `BARLOC_REGENERATE=1 cargo test -p barloc-prove table`; times and memory are in the `proofs.json` of a run.\n\n\
             | claim | domain | decided by | loops | fault that makes it fail | function |\n|---|---|---|---|---|---|\n"
        );
        for claim in claims {
            let Claim { name, file, domain, fault, .. } = claim;
            let cell = |text: &str| text.replace('|', "\\|");
            let loops = if claim.kind == Kind::Proof { claim.unwind.to_string() } else { String::new() };
            let (what, method) = (cell(&claim.says), &claim.solver);
            let fault = format!("`{}`: {}", fault.file, cell(&fault.what));
            writeln!(text, "| {what} | {} | {method} | {loops} | {fault} | `{file}` `{name}` |", cell(domain)).unwrap();
        }
        text
    }

    #[test]
    fn the_table_lists_the_proofs_in_the_tree() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../PROOFS.md");
        let claims = claims().unwrap();
        if std::env::var_os("BARLOC_REGENERATE").is_some() {
            fs::write(&path, table(&claims)).unwrap();
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), table(&claims), "PROOFS.md is stale");
    }

    #[test]
    fn no_proof_gets_lost() {
        let count = claims().unwrap().len();
        assert!(count >= LEAST, "{count} proofs and sweeps are left of {LEAST}");
    }
}
