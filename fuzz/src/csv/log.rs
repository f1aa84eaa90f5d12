//! A log.

use super::parts::Parts;
use super::{MARK, with_carriage_returns};
use crate::fault;
use crate::memory;
use crate::replay::is_a_sentence;
use reference::camera::Camera;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use verify::log::{
    Event, FRAMES, Knowledge, LogReader, LogWriter, Motion, OBSERVATIONS, ODOMETRY, Sources, Summary, TRUTH,
};

/// What parts a log's tables in an input.
pub(super) const BETWEEN: char = '\x1E';

/// What reading a log may take however long it is: three buffers, the splitters, the summary, an image.
const MOST: usize = 2 << 20;

/// Texts of `odometry.csv`, of what was seen, and of `truth.csv`.
#[derive(Clone, Debug)]
struct Log(Vec<Vec<u8>>);

/// What a reader made of a log. Lines of images are left out where rows may have moved.
#[derive(Debug, PartialEq)]
struct Read {
    events: Vec<Event>,
    /// File and line of the rows that were left out.
    left_out: BTreeSet<(PathBuf, u64)>,
    summary: Summary,
}

pub(super) fn run(text: &[u8]) {
    let log = Log(text.split(|&byte| char::from(byte) == BETWEEN).take(3).map(<[u8]>::to_vec).collect());
    let Some(read) = log.read(usize::MAX) else { return };
    in_bounded_memory(&log);
    for size in [1, 2, 61] {
        assert_eq!(log.read(size).as_ref(), Some(&read), "pieces of {size} bytes");
    }
    if let Some(other) = log.with_other_line_ends() {
        assert_eq!(other.read(usize::MAX).as_ref(), Some(&read), "line ends of CR LF");
    }
    if let Some(other) = log.with_marks() {
        assert_eq!(other.read(usize::MAX).as_ref(), Some(&read), "byte order marks");
    }
    rows_stand_alone(&log, &read);
    what_is_written_is_read(&read);
}

/// LOG-8, LOG-9: blank lines among them, and rows that are left out away, everything else stays.
fn rows_stand_alone(log: &Log, read: &Read) {
    let spaced = log.with_blank_lines().read(usize::MAX).expect("a header behind a blank line is one");
    assert_eq!(moved(&spaced.events), moved(&read.events), "blank lines");
    let without = log.without(&read.left_out).read(usize::MAX).expect("the headers are there");
    assert_eq!(moved(&without.events), moved(&read.events), "without what is left out");
    assert!(without.left_out.is_empty(), "{:?} after all others are away", without.left_out);
}

/// Events without the line of images.
fn moved(events: &[Event]) -> Vec<Event> {
    let mut events = events.to_vec();
    for event in &mut events {
        if let Event::Image(image) = event {
            image.line = 0;
        }
    }
    events
}

/// LOG-13
fn in_bounded_memory(log: &Log) {
    let sources = log.sources(usize::MAX);
    let rows =
        memory::at_most(MOST, || LogReader::from_sources(&folder(), &Camera::epuck(), sources).map(Iterator::count));
    assert!(rows.is_ok(), "it has just been read");
}

/// LOG-18, LOG-19: of a log of steps and images.
fn what_is_written_is_read(read: &Read) {
    let is_written = |event: &Event| match event {
        Event::Reading(reading) => matches!(reading.motion, Motion::Steps { .. }),
        Event::Image(_) | Event::Truth(_) => true,
        Event::Observation(_) => false,
    };
    if read.events.is_empty() || !read.events.iter().all(is_written) {
        return;
    }
    let folder = std::env::temp_dir().join(format!("barloc-fuzz-{}", std::process::id()));
    let knowledge = Knowledge::default();
    let mut writer = LogWriter::create(&folder, &knowledge).expect("a folder for temporary files");
    read.events.iter().for_each(|event| writer.event(event).expect("a file that can be written"));
    writer.finish().expect("files that can be written");
    assert_eq!(Knowledge::of_log(&folder).expect("what was written"), knowledge, "LOG-19");
    let again = LogReader::open(&folder, &knowledge.camera).expect("what was written");
    let events: Vec<Event> = again.map(|event| event.expect("what was written")).collect();
    assert_eq!(moved(&events), moved(&read.events), "LOG-19");
    fs::remove_dir_all(&folder).expect("our own folder");
}

/// Where images are.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/renders")
}

impl Log {
    /// Its tables in pieces of so many bytes.
    fn sources(&self, size: usize) -> Sources {
        let source = |i: usize| {
            let text: Option<&Vec<u8>> = self.0.get(i);
            text.map(|text| -> Box<dyn std::io::Read> { Box::new(Parts::new(text, size)) })
        };
        let [frames, observations] = if self.has_images() { [source(1), None] } else { [None, source(1)] };
        Sources { odometry: source(0), frames, observations, truth: source(2) }
    }

    /// Whether its second table is `frames.csv`.
    fn has_images(&self) -> bool {
        self.0.get(1).is_some_and(|text| names_images(text))
    }

    /// `None` if it is refused as a whole.
    fn read(&self, size: usize) -> Option<Read> {
        let mut reader = match LogReader::from_sources(&folder(), &Camera::epuck(), self.sources(size)) {
            Ok(reader) => reader,
            Err(refusal) => {
                is_a_sentence(&refusal.to_string());
                return None;
            }
        };
        let mut read = Read { events: Vec::new(), left_out: BTreeSet::new(), summary: Summary::default() };
        for row in reader.by_ref() {
            match row {
                Ok(event) => read.events.push(fault::event(event, size)),
                Err(refusal) => {
                    is_a_sentence(&refusal.to_string());
                    let line = refusal.line.expect("a row that is left out has a line");
                    assert!(read.left_out.insert((refusal.file.to_path_buf(), line)), "{refusal} twice");
                }
            }
        }
        read.summary = reader.summary().clone();
        counted(&read);
        Some(read)
    }

    fn with_other_line_ends(&self) -> Option<Self> {
        Some(Self(self.0.iter().map(|text| with_carriage_returns(text)).collect::<Option<_>>()?))
    }

    fn with_marks(&self) -> Option<Self> {
        let marked = |text: &Vec<u8>| (!text.starts_with(MARK)).then(|| [MARK, text].concat());
        Some(Self(self.0.iter().map(marked).collect::<Option<_>>()?))
    }

    /// A blank line before every line, behind the mark if there is one.
    fn with_blank_lines(&self) -> Self {
        let spaced = |text: &Vec<u8>| {
            let (mark, text) = if text.starts_with(MARK) { text.split_at(MARK.len()) } else { (&[][..], &text[..]) };
            let lines = text.split_inclusive(|&byte| byte == b'\n').flat_map(|line| [b" \t\r\n", line].concat());
            mark.iter().copied().chain(lines).collect()
        };
        Self(self.0.iter().map(spaced).collect())
    }

    fn without(&self, rows: &BTreeSet<(PathBuf, u64)>) -> Self {
        let second = if self.has_images() { FRAMES } else { OBSERVATIONS };
        let names = [ODOMETRY, second, TRUTH];
        let kept = |(text, name): (&Vec<u8>, &str)| {
            let path = folder().join(name);
            let lines = text.split_inclusive(|&byte| byte == b'\n').zip(1..);
            lines
                .filter(|(_, line)| !rows.contains(&(path.clone(), *line)))
                .flat_map(|(line, _)| line)
                .copied()
                .collect()
        };
        Self(self.0.iter().zip(names).map(kept).collect())
    }
}

/// Whether a table is `frames.csv` by what it begins with.
fn names_images(text: &[u8]) -> bool {
    text.strip_prefix(MARK).unwrap_or(text).trim_ascii_start().starts_with(b"t_start_s")
}

/// LOG-14: every row is counted once, as used or as left out.
fn counted(read: &Read) {
    let (used, left_out) =
        read.summary.files.values().fold((0, 0), |(used, left_out), rows| (used + rows.used, left_out + rows.left_out));
    assert_eq!((used, left_out), (read.events.len() as u64, read.left_out.len() as u64), "LOG-14");
}
