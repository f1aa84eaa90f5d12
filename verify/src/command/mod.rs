//! The command `barloc`.

mod certify;
mod detect;

use clap::{Parser, Subcommand};
use std::ffi::OsString;
use std::io::{self, Write};

/// How the command ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything went well, and what was compared is the same.
    Success,
    /// Not the same.
    Different,
    /// Bad usage or input.
    BadInput,
}

impl Exit {
    /// The exit code.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Success => 0,
            Self::Different => 1,
            Self::BadInput => 2,
        }
    }
}

/// Why the command gave up.
#[derive(Debug)]
enum Failure {
    /// Something is wrong with what it was given, in one sentence.
    Input(String),
    /// Its output cannot be written.
    Output(io::Error),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

#[derive(Parser)]
#[command(
    name = "barloc",
    version,
    about = "Pose of a camera from dual-layer barcodes, in float64 and in fixed point, and the evidence that both are the same",
    after_help = "Examples:
  barloc                                      certify with the default campaign
  barloc certify --frames 200000 --seed 7     a larger campaign
  barloc detect tests/data/renders/000.png    what is on an image, by both pipelines

Exit codes: 0 success, 1 the pipelines are not the same, 2 bad usage or input."
)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Run both pipelines in lockstep and write a certificate
    Certify(certify::Arguments),
    /// Find the landmarks in images
    Detect(detect::Arguments),
}

/// Runs the command with the given arguments, the program's name first.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> Exit {
    let mut out = io::stdout().lock();
    let outcome = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => match arguments.command {
            None => certify::run(&certify::Arguments::default(), &mut out),
            Some(Command::Certify(arguments)) => certify::run(&arguments, &mut out),
            Some(Command::Detect(arguments)) => detect::run(&arguments, &mut out),
        },
        Err(error) => usage(&error, &mut out),
    };
    match outcome.and_then(|exit| out.flush().map(|()| exit).map_err(Failure::Output)) {
        Ok(exit) => exit,
        Err(Failure::Input(sentence)) => {
            complain(&sentence);
            Exit::BadInput
        }
        // Whoever reads the output has seen enough.
        Err(Failure::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => Exit::Success,
        Err(Failure::Output(error)) => {
            complain(&format!("the output cannot be written: {error}"));
            Exit::BadInput
        }
    }
}

/// Help and version go to the output; everything else is one line.
fn usage(error: &clap::Error, out: &mut impl Write) -> Result<Exit, Failure> {
    if error.use_stderr() {
        return Err(Failure::Input(first_paragraph(&error.to_string())));
    }
    write!(out, "{error}")?;
    Ok(Exit::Success)
}

/// The first paragraph of clap's message, without its prefix, on one line.
fn first_paragraph(message: &str) -> String {
    let lines = message.lines().take_while(|line| !line.is_empty());
    let words: Vec<&str> = lines.flat_map(str::split_whitespace).collect();
    let sentence = words.join(" ");
    let sentence = sentence.strip_prefix("error: ").unwrap_or(&sentence).to_owned();
    format!("{sentence} (see barloc --help)")
}

/// One line on standard error; that it cannot be written has no one to be told to.
fn complain(sentence: &str) {
    let _ = writeln!(io::stderr(), "barloc: {sentence}");
}
