//! The tables of a log: their headers, and what a row means (LOG-2, LOG-4 to LOG-8).

use super::fault::{Fault, Reason, Refusal};
use super::lines::{Line, TextLines};
use super::row::{Row, Splitter};
use super::{Capture, Event, Image, LARGEST_ANGLE, LARGEST_COORDINATE, Motion, Observation, Reading, Truth};
use crate::input;
use nalgebra::{Cholesky, Matrix3};
use reference::camera::Camera;
use reference::frame::Pose;
use std::io::{BufReader, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Largest velocities, m/s and rad/s (LOG-4).
const FASTEST: [f64; 2] = [10.0, 100.0];

/// Largest variance, m² or rad² (LOG-6).
const LARGEST_VARIANCE: f64 = 1e4;

/// Longest capture of an image, microseconds (EXPOSE-2).
const LONGEST_CAPTURE: u64 = 1_000_000;

/// What a table's rows are.
#[derive(Clone, Debug)]
pub(super) enum Content {
    Steps,
    Velocity,
    /// Images below a folder.
    Frames {
        folder: PathBuf,
        camera: Camera,
    },
    Observations,
    Truth,
}

impl Content {
    pub(super) fn columns(&self) -> &'static [&'static str] {
        match self {
            Self::Steps => &["t_s", "left_steps", "right_steps"],
            Self::Velocity => &["t_s", "forward_m_s", "turn_rad_s"],
            Self::Frames { .. } => &["t_start_s", "t_end_s", "t_processed_s", "file"],
            Self::Observations => &[
                "t_s",
                "landmark_x_m",
                "landmark_y_m",
                "landmark_theta_rad",
                "x_m",
                "y_m",
                "theta_rad",
                "c_xx",
                "c_xy",
                "c_xt",
                "c_yy",
                "c_yt",
                "c_tt",
            ],
            Self::Truth => &["t_s", "x_m", "y_m", "theta_rad"],
        }
    }

    fn is(&self, names: &[&str]) -> bool {
        self.columns() == names
    }

    fn event(&self, row: &Row<'_>, line: u64) -> Result<Event, Refusal> {
        match self {
            Self::Steps => steps(row),
            Self::Velocity => velocity(row),
            Self::Frames { folder, camera } => image(row, line, folder, camera),
            Self::Observations => observation(row),
            Self::Truth => truth(row),
        }
    }
}

fn steps(row: &Row<'_>) -> Result<Event, Refusal> {
    let motion = Motion::Steps { left: row.steps(1)?, right: row.steps(2)? };
    Ok(Event::Reading(Reading { time: row.time(0)?, motion }))
}

fn velocity(row: &Row<'_>) -> Result<Event, Refusal> {
    let motion = Motion::Velocity { forward: row.number(1, FASTEST[0])?, turn: row.number(2, FASTEST[1])? };
    Ok(Event::Reading(Reading { time: row.time(0)?, motion }))
}

/// Coordinates and heading in three columns from `first` on (LOG-7).
fn pose(row: &Row<'_>, first: usize) -> Result<[f64; 3], Refusal> {
    Ok([
        row.number(first, LARGEST_COORDINATE)?,
        row.number(first + 1, LARGEST_COORDINATE)?,
        row.number(first + 2, LARGEST_ANGLE)?,
    ])
}

fn truth(row: &Row<'_>) -> Result<Event, Refusal> {
    let [x, y, theta] = pose(row, 1)?;
    Ok(Event::Truth(Truth { time: row.time(0)?, x, y, theta }))
}

fn observation(row: &Row<'_>) -> Result<Event, Refusal> {
    let [landmark, robot] = [pose(row, 1)?, pose(row, 4)?];
    Ok(Event::Observation(Observation {
        time: row.time(0)?,
        landmark_in_world: Pose::new(landmark[0], landmark[1], landmark[2]),
        robot_in_landmark: Pose::new(robot[0], robot[1], robot[2]),
        covariance: covariance(row, 7)?,
    }))
}

/// A covariance's upper triangle, row by row, from a column on (LOG-6).
//= reference/SPEC.md#log
//# - **LOG-6** A covariance MUST be positive definite, with variances of at most 10,000 m² and 10,000 rad².
fn covariance(row: &Row<'_>, first: usize) -> Result<Matrix3<f64>, Refusal> {
    let mut entries = [0.0; 6];
    for (i, entry) in entries.iter_mut().enumerate() {
        *entry = row.number(first + i, LARGEST_VARIANCE)?;
    }
    let [xx, xy, xt, yy, yt, tt] = entries;
    let covariance = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
    if is_positive_definite(&covariance) {
        return Ok(covariance);
    }
    Err(Refusal::new(Reason::Covariance, "c_xx to c_tt: the covariance is not positive definite"))
}

/// Of the correlations, since metres and radians may be of very different sizes.
fn is_positive_definite(covariance: &Matrix3<f64>) -> bool {
    let deviations = covariance.diagonal().map(f64::sqrt);
    if !deviations.iter().all(|&deviation| deviation > 0.0) {
        return false;
    }
    let correlations =
        Matrix3::from_fn(|i, j| if i == j { 1.0 } else { covariance[(i, j)] / deviations[i] / deviations[j] });
    Cholesky::new(correlations).is_some()
}

//= reference/SPEC.md#log
//# - **LOG-5** An image MUST be an 8-bit PNG or PNM file of the camera's size in or below the folder, whose times
//# fulfil EXPOSE-2.
fn image(row: &Row<'_>, line: u64, folder: &Path, camera: &Camera) -> Result<Event, Refusal> {
    let capture = Capture { start: row.time(0)?, end: row.time(1)?, processed: row.time(2)? };
    // EXPOSE-2
    if capture.start >= capture.end {
        return Err(row.refusal(1, Reason::Capture, &format!("is not after t_start_s, {}", capture.start)));
    }
    if capture.processed < capture.end {
        return Err(row.refusal(2, Reason::Capture, &format!("is before t_end_s, {}", capture.end)));
    }
    if capture.end.micros() - capture.start.micros() > LONGEST_CAPTURE {
        return Err(row.refusal(1, Reason::Capture, &format!("is more than 1 s after t_start_s, {}", capture.start)));
    }
    let name = Path::new(row.text(3));
    let below = name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !below || name.file_name().is_none() {
        return Err(row.refusal(3, Reason::Image, "is not the name of a file in or below the log's folder"));
    }
    let path = folder.join(name);
    match path.metadata() {
        Ok(entry) if entry.is_file() => {}
        // What is no file may never end.
        Ok(_) => return Err(row.refusal(3, Reason::Image, "is not a file")),
        Err(error) => return Err(row.refusal(3, Reason::ImageMissing, &format!("is missing: {error}"))),
    }
    let lines = input::scan_lines(&path, camera).map_err(|error| row.refusal(3, Reason::Image, &error.to_string()))?;
    Ok(Event::Image(Image { capture, lines, line }))
}

/// Where a table's text comes from.
pub(super) type Source = Box<dyn Read>;

/// A table that is being read.
pub(super) struct Table {
    path: Arc<Path>,
    content: Content,
    lines: TextLines<BufReader<Source>>,
    splitter: Splitter,
    ended: bool,
}

impl Table {
    /// The table with the one of some contents that its header names (LOG-2).
    //= reference/SPEC.md#log
    //# - **LOG-2** A table whose first line that is not blank is none of its headers, name for name, MUST be refused as
    //# a whole.
    pub(super) fn open(path: PathBuf, source: Source, contents: Vec<Content>) -> Result<Self, Fault> {
        let path: Arc<Path> = path.into();
        let mut lines = TextLines::new(BufReader::new(source));
        let mut splitter = Splitter::new();
        let fault = |line, reason, what: String| Fault { file: Arc::clone(&path), line, reason, what };
        let (number, text) = match lines.next() {
            Err(error) => return Err(fault(None, Reason::Unreadable, format!("cannot be read: {error}"))),
            Ok(None) => return Err(fault(None, Reason::Empty, "is empty".to_owned())),
            Ok(Some((number, Line::Whole(text) | Line::CutOff(text)))) => (number, text),
            Ok(Some((number, Line::TooLong))) => (number, &b""[..]),
        };
        let names: Vec<&str> = splitter.split(text).map(|fields| fields.iter().collect()).unwrap_or_default();
        let expected: Vec<String> = contents.iter().map(|content| content.columns().join(",")).collect();
        match contents.into_iter().find(|content| content.is(&names)) {
            Some(content) => Ok(Self { path, content, lines, splitter, ended: false }),
            None => Err(fault(Some(number), Reason::Header, format!("is not the header {}", expected.join(" or ")))),
        }
    }

    /// The next row: its line and what it means, or why it is left out (LOG-8); none at the end.
    //= reference/SPEC.md#log
    //# - **LOG-8** A row that cannot be used MUST be left out alone, with file, line and reason in one line, and the
    //# rows after it be read.
    pub(super) fn next(&mut self) -> Option<Result<(u64, Event), Fault>> {
        if self.ended {
            return None;
        }
        let (line, text) = match self.lines.next() {
            Ok(None) => {
                self.ended = true;
                return None;
            }
            Err(error) => {
                self.ended = true;
                let refusal = Refusal::new(Reason::Unreadable, format!("cannot be read on: {error}"));
                return Some(Err(fault(&self.path, None, refusal)));
            }
            Ok(Some((line, text))) => (line, text),
        };
        let event = meaning(&text, line, &self.content, &mut self.splitter);
        Some(event.map(|event| (line, event)).map_err(|refusal| fault(&self.path, Some(line), refusal)))
    }

    /// A fault of a row of this table.
    pub(super) fn fault(&self, line: u64, reason: Reason, what: String) -> Fault {
        fault(&self.path, Some(line), Refusal { reason, what })
    }
}

fn fault(path: &Arc<Path>, line: Option<u64>, Refusal { reason, what }: Refusal) -> Fault {
    Fault { file: Arc::clone(path), line, reason, what }
}

//= reference/SPEC.md#log
//# - **LOG-9** A byte order mark, blank lines, lines that end in CR LF, and blanks around a field MUST be read over.
//= reference/SPEC.md#log
//# - **LOG-10** A last line without a line end, a line of more than 8192 bytes, one that is not UTF-8, one with a quote
//# that is not closed and one with too few or too many fields MUST be left out.
fn meaning(text: &Line<'_>, line: u64, content: &Content, splitter: &mut Splitter) -> Result<Event, Refusal> {
    let text = match text {
        Line::Whole(text) => text,
        Line::CutOff(_) => {
            return Err(Refusal::new(
                Reason::CutOff,
                "the file ends in this line: it is cut off, or lacks its line end",
            ));
        }
        Line::TooLong => return Err(Refusal::new(Reason::Line, "is longer than 8192 bytes")),
    };
    content.event(&Row::new(content.columns(), splitter.split(text)?)?, line)
}
