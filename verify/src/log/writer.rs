//! Logs and estimates as files (LOG-18 to LOG-21).

use super::unfinished::Unfinished;
use super::{Capture, Event, FRAMES, Knowledge, Motion, OBSERVATIONS, ODOMETRY, ROBOT, Reading, TRUTH, Time, Truth};
use crate::print::files::{Unwritten, write_whole};
use crate::scenes::Lines;
use image::{GrayImage, ImageFormat};
use nalgebra::Matrix3;
use reference::camera::Camera;
use std::fs;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};

/// Folder of a log's images, below the log's.
const IMAGES: &str = "frames";

/// Writes a log as a robot would.
///
/// Its tables are put in their places by [`Self::finish`], and never if that is not reached; images before that, of
/// which nothing is known without their table.
#[derive(Debug)]
pub struct LogWriter {
    folder: PathBuf,
    camera: Camera,
    knowledge: String,
    odometry: Unfinished,
    frames: Unfinished,
    truth: Unfinished,
    images: u64,
}

impl LogWriter {
    /// A log in a folder, which is made where it is missing. A log that is there already is replaced; one with
    /// observations instead of images is refused (LOG-1).
    pub fn create(folder: &Path, knowledge: &Knowledge) -> Result<Self, Unwritten> {
        let images = folder.join(IMAGES);
        fs::create_dir_all(&images).map_err(|error| unwritten(&images, error))?;
        let observations = folder.join(OBSERVATIONS);
        if observations.exists() {
            let why = format!("the folder has {OBSERVATIONS} of another log");
            return Err(unwritten(&folder.join(FRAMES), io::Error::other(why)));
        }
        let mut odometry = Unfinished::create(folder.join(ODOMETRY))?;
        let mut frames = Unfinished::create(folder.join(FRAMES))?;
        let mut truth = Unfinished::create(folder.join(TRUTH))?;
        odometry.write(format_args!("t_s,left_steps,right_steps\n"))?;
        frames.write(format_args!("t_start_s,t_end_s,t_processed_s,file\n"))?;
        truth.write(format_args!("t_s,x_m,y_m,theta_rad\n"))?;
        remove_former(folder)?;
        let (folder, knowledge, camera) = (folder.to_owned(), knowledge.to_toml(), knowledge.camera);
        Ok(Self { folder, camera, knowledge, odometry, frames, truth, images: 0 })
    }

    /// What has happened, in the order of arrival.
    ///
    /// # Panics
    /// If it is none of a simulated robot's: velocities, or an observation without an image.
    pub fn event(&mut self, event: &Event) -> Result<(), Unwritten> {
        match event {
            Event::Reading(Reading { time, motion: Motion::Steps { left, right } }) => {
                self.reading(*time, *left, *right)
            }
            Event::Image(image) => self.image(&image.capture, &image.lines),
            Event::Truth(truth) => self.truth(truth),
            Event::Reading(_) | Event::Observation(_) => panic!("{event:?} is in no log that is written"),
        }
    }

    /// The wheels' steps since the reading before.
    pub fn reading(&mut self, time: Time, left: i16, right: i16) -> Result<(), Unwritten> {
        self.odometry.write(format_args!("{time},{left},{right}\n"))
    }

    /// An image of the camera's scan lines.
    ///
    /// # Panics
    /// If the lines are not as long as the camera's.
    pub fn image(&mut self, capture: &Capture, lines: &Lines) -> Result<(), Unwritten> {
        let name = image_name(self.images);
        let path = self.folder.join(&name);
        let bytes = png(&self.camera, lines).map_err(|error| unwritten(&path, error))?;
        write_whole(&[(path, bytes)])?;
        self.images += 1;
        let Capture { start, end, processed } = capture;
        self.frames.write(format_args!("{start},{end},{processed},{name}\n"))
    }

    /// Where the robot is.
    pub fn truth(&mut self, truth: &Truth) -> Result<(), Unwritten> {
        let Truth { time, x, y, theta } = truth;
        self.truth.write(format_args!("{time},{x},{y},{theta}\n"))
    }

    /// Puts the tables in their places.
    //= reference/SPEC.md#log
    //# - **LOG-18** A log's files MUST be written whole or not at all, and the same log give the same bytes.
    pub fn finish(self) -> Result<(), Unwritten> {
        write_whole(&[(self.folder.join(ROBOT), self.knowledge.into_bytes())])?;
        self.truth.finish()?;
        self.frames.finish()?;
        self.odometry.finish()
    }
}

fn unwritten(path: &Path, error: io::Error) -> Unwritten {
    Unwritten { path: path.to_owned(), error }
}

/// An image's name in `frames.csv`; by default sorted as they come.
fn image_name(number: u64) -> String {
    format!("{IMAGES}/{number:06}.png")
}

/// Takes away a former log's tables, which would name images that are no longer theirs, and its images; nothing else.
fn remove_former(folder: &Path) -> Result<(), Unwritten> {
    let remove = |path: PathBuf| match fs::remove_file(&path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(unwritten(&path, error)),
        _ => Ok(()),
    };
    for name in [FRAMES, ODOMETRY, TRUTH, ROBOT] {
        remove(folder.join(name))?;
    }
    for number in 0.. {
        let path = folder.join(image_name(number));
        if !path.is_file() {
            break;
        }
        remove(path)?;
    }
    Ok(())
}

/// An image of the camera's height (LOG-20).
//= reference/SPEC.md#log
//# - **LOG-20** Of a written image the rows MUST be those of the nearer scan line, of two equally near ones the upper,
//# so that first and last row are the scan lines of a camera that reads these.
fn png(camera: &Camera, [upper, lower]: &Lines) -> io::Result<Vec<u8>> {
    let nearer = |row: usize| {
        let upper_is_nearer = row.abs_diff(camera.upper_row) <= row.abs_diff(camera.lower_row);
        if upper_is_nearer { upper } else { lower }
    };
    let pixels: Vec<u8> = (0..camera.height).flat_map(nearer).copied().collect();
    let side = |pixels: usize| u32::try_from(pixels).expect("CAM-7");
    let image = GrayImage::from_raw(side(camera.width), side(camera.height), pixels);
    let mut bytes = Cursor::new(Vec::new());
    let image = image.filter(|_| upper.len() == camera.width && lower.len() == camera.width);
    image.expect("lines of the camera's width").write_to(&mut bytes, ImageFormat::Png).map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}

/// What a filter knew at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// When.
    pub time: Time,
    /// World coordinates in metres and heading in radians.
    pub pose: [f64; 3],
    /// m², m rad, rad².
    pub covariance: Matrix3<f64>,
}

/// Writes estimates, a row each (LOG-21).
#[derive(Debug)]
pub struct EstimateWriter(Unfinished);

impl EstimateWriter {
    /// Begins a table of estimates.
    pub fn create(path: PathBuf) -> Result<Self, Unwritten> {
        let mut table = Unfinished::create(path)?;
        table.write(format_args!("t_s,x_m,y_m,theta_rad,c_xx,c_xy,c_xt,c_yy,c_yt,c_tt,event\n"))?;
        Ok(Self(table))
    }

    /// An estimate, and what led to it: a word or a few without comma, quote or line end.
    ///
    /// # Panics
    /// If the event has one of these.
    //= reference/SPEC.md#log
    //# - **LOG-21** An estimate MUST be written as `t_s,x_m,y_m,theta_rad,c_xx,c_xy,c_xt,c_yy,c_yt,c_tt,event`, its
    //# numbers as the shortest decimals that are read as the same.
    pub fn row(&mut self, estimate: &Estimate, event: &str) -> Result<(), Unwritten> {
        assert!(!event.contains([',', '"', '\n', '\r']), "{event:?} would need quotes");
        let Estimate { time, pose: [x, y, theta], covariance: c } = estimate;
        let [xx, xy, xt, yy, yt, tt] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| c[place]);
        self.0.write(format_args!("{time},{x},{y},{theta},{xx:e},{xy:e},{xt:e},{yy:e},{yt:e},{tt:e},{event}\n"))
    }

    /// Puts the table in its place.
    pub fn finish(self) -> Result<(), Unwritten> {
        self.0.finish()
    }
}
