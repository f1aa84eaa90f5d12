//! A log's tables as one sequence of events (LOG-1, LOG-11 to LOG-13).

use super::fault::{Fault, Reason};
use super::pace::Pace;
use super::summary::Summary;
use super::table::{Content, Source, Table};
use super::{Event, FRAMES, OBSERVATIONS, ODOMETRY, TRUTH, Time};
use reference::camera::Camera;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

/// Reads a log.
///
/// An item is an event, or a row that is left out and why; the iterator goes on after such a row. No more than one row
/// of each file is held at a time.
pub struct LogReader {
    /// In the order in which rows of one time are delivered.
    tracks: Vec<Track>,
    summary: Summary,
}

/// Texts of a log's tables that need not be files; images are still files below the folder.
#[derive(Default)]
pub struct Sources {
    /// `odometry.csv`
    pub odometry: Option<Box<dyn Read>>,
    /// `frames.csv`
    pub frames: Option<Box<dyn Read>>,
    /// `observations.csv`
    pub observations: Option<Box<dyn Read>>,
    /// `truth.csv`
    pub truth: Option<Box<dyn Read>>,
}

impl Sources {
    /// The files of a folder.
    fn of_folder(folder: &Path) -> Result<Self, Fault> {
        Ok(Self {
            odometry: open(folder.join(ODOMETRY))?,
            frames: open(folder.join(FRAMES))?,
            observations: open(folder.join(OBSERVATIONS))?,
            truth: open(folder.join(TRUTH))?,
        })
    }
}

/// A file if it is there.
fn open(path: PathBuf) -> Result<Option<Source>, Fault> {
    match File::open(&path) {
        Ok(file) => Ok(Some(Box::new(file))),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Fault::of_file(path, Reason::Unreadable, format!("cannot be read: {error}"))),
    }
}

impl LogReader {
    /// The log in a folder, whose images are of this camera. What is wrong with a file as a whole is an error.
    pub fn open(folder: &Path, camera: &Camera) -> Result<Self, Fault> {
        Self::from_sources(folder, camera, Sources::of_folder(folder)?)
    }

    /// A log whose tables come from somewhere else (LOG-1).
    //= reference/SPEC.md#log
    //# - **LOG-1** A log MUST be a folder with `odometry.csv`, at most one of `frames.csv` and `observations.csv`, and,
    //# where they exist, `truth.csv` and `robot.toml`; both of the two are refused.
    pub fn from_sources(folder: &Path, camera: &Camera, sources: Sources) -> Result<Self, Fault> {
        if sources.frames.is_some() && sources.observations.is_some() {
            let what = format!("has both {FRAMES} and {OBSERVATIONS}; one of them has to go");
            return Err(Fault::of_file(folder, Reason::Folder, what));
        }
        let Some(odometry) = sources.odometry else {
            return Err(Fault::of_file(folder.join(ODOMETRY), Reason::Folder, "is missing"));
        };
        let frames = Content::Frames { folder: folder.to_owned(), camera: *camera };
        let others = [
            (FRAMES, sources.frames, frames),
            (OBSERVATIONS, sources.observations, Content::Observations),
            (TRUTH, sources.truth, Content::Truth),
        ];
        let mut reader = Self { tracks: Vec::new(), summary: Summary::default() };
        reader.add(folder, ODOMETRY, odometry, vec![Content::Steps, Content::Velocity])?;
        for (name, source, content) in others {
            if let Some(source) = source {
                reader.add(folder, name, source, vec![content])?;
            }
        }
        Ok(reader)
    }

    fn add(&mut self, folder: &Path, name: &'static str, source: Source, as_: Vec<Content>) -> Result<(), Fault> {
        let table = Table::open(folder.join(name), source, as_)?;
        self.summary.begin(name);
        self.tracks.push(Track { name, table, pace: Pace::default(), head: None });
        Ok(())
    }

    /// What became of the rows so far; at the end, of all.
    #[must_use]
    pub fn summary(&self) -> &Summary {
        &self.summary
    }
}

impl Iterator for LogReader {
    type Item = Result<Event, Fault>;

    //= reference/SPEC.md#log
    //# - **LOG-11** Rows MUST be delivered in the order of their arrival, which is `t_s` and of an image
    //# `t_processed_s`, at one time readings first, then what was seen, then the truth; within a file its own order
    //# stands.
    fn next(&mut self) -> Option<Self::Item> {
        for track in &mut self.tracks {
            if let Err(fault) = track.fill(&mut self.summary) {
                self.summary.fault(&fault);
                return Some(Err(fault));
            }
        }
        let arrival = |track: &&mut Track| track.arrival();
        // The first of several with one time.
        let next = self.tracks.iter_mut().filter(|track| track.head.is_some()).min_by_key(arrival)?;
        self.summary.used(next.name);
        next.head.take().map(Ok)
    }
}

/// A table and its next row.
struct Track {
    name: &'static str,
    table: Table,
    pace: Pace,
    head: Option<Event>,
}

impl Track {
    /// Reads the next row if there is none yet.
    fn fill(&mut self, summary: &mut Summary) -> Result<(), Fault> {
        if self.head.is_none()
            && let Some((line, event)) = self.table.next().transpose()?
        {
            let is_reading = matches!(event, Event::Reading(_));
            if let Some((reason, what)) = self.pace.next(event.arrival(), is_reading) {
                summary.fault(&self.table.fault(line, reason, what));
            }
            self.head = Some(event);
        }
        Ok(())
    }

    fn arrival(&self) -> Option<Time> {
        self.head.as_ref().map(Event::arrival)
    }
}
