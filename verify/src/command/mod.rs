//! The command `barloc`.

mod accuracy;
mod certify;
mod coverage;
mod design;
mod detect;
mod paper;
mod place;
mod print;
mod replay;
mod route;

use crate::input;
use clap::{Parser, Subcommand, ValueEnum};
use reference::camera::Camera;
use reference::landmark::Format;
use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;

/// How the command ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything went well, and what was compared is the same.
    Success,
    /// The verdict is fail: not the same, or a check of the certificate does not hold.
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
  barloc route --runs 10                      robots on a route, by both pipelines

Exit codes: 0 success; 1 the verdict is fail: the pipelines are not the same, or a check of the certificate does not hold;
2 bad usage or input."
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
    /// Tell from where a landmark can be read
    Design(design::Arguments),
    /// Print landmarks in true size
    Print(print::Arguments),
    /// Show from which part of a site a landmark can be read
    Coverage(coverage::Arguments),
    /// Choose where to put the landmarks of a site
    Place(place::Arguments),
    /// Set the paper's figures beside ours
    Paper(paper::Arguments),
    /// Measure how accurate both pipelines are, beside the Cramer-Rao bound
    Accuracy(accuracy::Arguments),
    /// Drive simulated robots along a route and see how well they know where they are
    Route(route::Arguments),
    /// Tell from a robot's log where it was
    Replay(replay::Arguments),
}

/// Runs the command with the given arguments, the program's name first.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> Exit {
    let mut out = Listener { out: io::stdout().lock(), gone: false };
    let outcome = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments.run(&mut out),
        Err(error) => usage(&error, &mut out),
    };
    match outcome.and_then(|exit| out.flush().map(|()| exit).map_err(Failure::Output)) {
        Ok(exit) => exit,
        Err(Failure::Input(sentence)) => {
            complain(&sentence);
            Exit::BadInput
        }
        Err(Failure::Output(error)) => {
            complain(&format!("the output cannot be written: {error}"));
            Exit::BadInput
        }
    }
}

impl Arguments {
    fn run(&self, out: &mut impl Write) -> Result<Exit, Failure> {
        match &self.command {
            None => certify::run(&certify::Arguments::default(), out),
            Some(Command::Certify(arguments)) => certify::run(arguments, out),
            Some(Command::Detect(arguments)) => detect::run(arguments, out),
            Some(Command::Design(arguments)) => design::run(arguments, out),
            Some(Command::Print(arguments)) => print::run(arguments, out),
            Some(Command::Coverage(arguments)) => coverage::run(arguments, out),
            Some(Command::Place(arguments)) => place::run(arguments, out),
            Some(Command::Paper(arguments)) => paper::run(arguments, out),
            Some(Command::Accuracy(arguments)) => accuracy::run(arguments, out),
            Some(Command::Route(arguments)) => route::run(arguments, out),
            Some(Command::Replay(arguments)) => replay::run(arguments, out),
        }
    }
}

/// An output whose reader may leave, as `head` does: the rest is not written, and the verdict and exit code stand.
struct Listener<W> {
    out: W,
    gone: bool,
}

impl<W: Write> Listener<W> {
    fn unless_gone<T>(&mut self, otherwise: T, act: impl FnOnce(&mut W) -> io::Result<T>) -> io::Result<T> {
        if self.gone {
            return Ok(otherwise);
        }
        match act(&mut self.out) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                self.gone = true;
                Ok(otherwise)
            }
            result => result,
        }
    }
}

impl<W: Write> Write for Listener<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.unless_gone(bytes.len(), |out| out.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.unless_gone((), W::flush)
    }
}

/// A landmark format by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LandmarkFormat {
    Paper,
    Wide,
}

impl From<LandmarkFormat> for Format {
    fn from(format: LandmarkFormat) -> Self {
        match format {
            LandmarkFormat::Paper => Self::Paper,
            LandmarkFormat::Wide => Self::Wide,
        }
    }
}

/// The camera that a file describes, the e-puck's without one.
fn camera(file: Option<&Path>) -> Result<Camera, Failure> {
    file.map_or(Ok(Camera::epuck()), |path| {
        input::camera(path).map_err(|error| Failure::Input(format!("{}: {error}", path.display())))
    })
}

/// Help and version go to the output; everything else is one line.
fn usage(error: &clap::Error, out: &mut impl Write) -> Result<Exit, Failure> {
    if error.use_stderr() {
        return Err(Failure::Input(sentence_of(&error.to_string())));
    }
    write!(out, "{error}")?;
    Ok(Exit::Success)
}

/// What clap's message says is wrong, without its prefix and its advice, which begins after a blank line.
fn sentence_of(message: &str) -> String {
    let end =
        ["\n\n  tip:", "\n\nUsage:", "\n\nFor more information"].iter().filter_map(|mark| message.find(mark)).min();
    let sentence = &message[..end.unwrap_or(message.len())];
    let words: Vec<&str> = sentence.lines().map(str::trim).collect();
    let sentence = words.join(" ");
    format!("{} (see barloc --help)", sentence.strip_prefix("error: ").unwrap_or(&sentence).trim_end())
}

/// Text in which what would move a cursor or break a line is escaped: names of files may hold anything.
fn printable(text: &str) -> String {
    let escaped = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(escaped).collect()
}

/// One line on standard error; that it cannot be written has no one to be told to.
fn complain(sentence: &str) {
    let _ = writeln!(io::stderr(), "barloc: {}", printable(sentence));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usage_errors_are_one_sentence() {
        let sentence = |arguments: &[&str]| {
            let error = Arguments::try_parse_from(arguments).err().expect("a usage error");
            sentence_of(&error.to_string())
        };
        assert_eq!(
            sentence(&["barloc", "certify", "--frames", "many"]),
            "invalid value 'many' for '--frames <N>': invalid digit found in string (see barloc --help)"
        );
        assert_eq!(
            sentence(&["barloc", "detect"]),
            "the following required arguments were not provided: <IMAGE>... (see barloc --help)"
        );
        let odd = sentence(&["barloc", "detect", "--landmark", "a\n\nb", "x.png"]);
        assert!(odd.contains("a  b") && odd.contains("[possible values: paper, wide]"), "{odd}");
    }

    #[test]
    fn control_characters_are_escaped() {
        assert_eq!(printable("new\nline \u{1b}[31m ° é"), "new\\nline \\u{1b}[31m ° é");
    }

    /// A reader that leaves after two bytes.
    struct Leaving(usize);

    impl Write for Leaving {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0 == 0 {
                return Err(io::ErrorKind::BrokenPipe.into());
            }
            let taken = bytes.len().min(self.0);
            self.0 -= taken;
            Ok(taken)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_leaves_does_not_end_the_work() {
        let mut out = Listener { out: Leaving(2), gone: false };
        assert!(out.write_all(b"four").is_ok() && out.gone && out.write_all(b"more").is_ok() && out.flush().is_ok());
    }
}
