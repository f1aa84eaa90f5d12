//! `cargo evidence`: runs what speaks for the port and writes one folder with `index.html`.
//!
//! Each part is a command that can be run by itself ([`parts`]); it writes JSON and a log into its own folder. What could not
//! run on this machine, what failed and what was run at another commit is said so on the page, never left out.

#[cfg(test)]
mod claims;
mod page;
mod parts;
mod record;
mod table;
mod tools;

use clap::Parser;
use parts::{PARTS, Part};
use record::{Outcome, Record};
use std::path::PathBuf;
use std::process::ExitCode;
use std::{fs, io};

#[derive(Parser)]
#[command(
    name = "cargo evidence",
    about = "Runs what speaks for the port and writes it down as a folder to hand over",
    after_help = "Examples:
  cargo evidence                         everything, in one to two hours
  cargo evidence --full                  with the campaigns and fuzzing that claims are made of: a night
  cargo evidence --part proofs           one part again; what the others found at this commit stays
  cargo evidence --page                  only the page, from what is there

Exit code 0: every part that ran holds. 1: one does not. 2: the folder cannot be written, or there is no such part."
)]
struct Arguments {
    /// Folder for index.html and all it refers to
    #[arg(long, value_name = "DIR", default_value = "target/evidence")]
    out: PathBuf,
    /// Only this part; may be repeated
    #[arg(long, value_name = "PART", value_parser = parts::names())]
    part: Vec<String>,
    /// With the numbers of frames, runs and minutes that CLAIMS.md names
    #[arg(long)]
    full: bool,
    /// Run nothing, write the page
    #[arg(long, conflicts_with = "part")]
    page: bool,
}

impl Arguments {
    fn chosen(&self) -> impl Iterator<Item = &'static Part> + '_ {
        let asked =
            |part: &&Part| !self.page && (self.part.is_empty() || self.part.iter().any(|name| name == part.name));
        PARTS.iter().filter(asked)
    }
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cargo evidence: {error}");
            ExitCode::from(2)
        }
    }
}

/// Whether everything that ran holds.
fn run(arguments: &Arguments) -> io::Result<bool> {
    fs::create_dir_all(&arguments.out)?;
    let mut record = Record::read(&arguments.out, tools::versions())?;
    for part in arguments.chosen() {
        eprint!("{:<12} ", part.name);
        let taken = part.run(&arguments.out, arguments.full)?;
        eprintln!("{}", taken.sentence());
        if taken.outcome == Outcome::Failed {
            eprintln!("{}", part.last_words(&arguments.out)?);
        }
        record.keep(part.name, taken);
        record.versions = tools::versions(); // a part installs what it needs
        // After each part: what was measured is not lost with what is interrupted.
        record.write(&arguments.out)?;
        page::write(&arguments.out, &record)?;
    }
    record.write(&arguments.out)?;
    page::write(&arguments.out, &record)?;
    eprintln!("{}", arguments.out.join("index.html").display());
    Ok(record.taken().all(|taken| taken.outcome != Outcome::Failed))
}
