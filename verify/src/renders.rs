//! Camera images that this project did not draw, and what is on them.

use crate::input::{InputError, scan_lines};
use crate::scenes::Lines;
use core::fmt;
use reference::camera::Camera;
use reference::landmark::Format;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// One image and its truth.
#[derive(Clone, Debug)]
pub struct Render {
    /// Its file's name.
    pub file: String,
    /// What is on it; `None` for a blank wall.
    pub landmark: Option<(Format, u32)>,
    /// The camera in the landmark's frame: metres, metres, radians.
    pub pose: [f64; 3],
    /// Its scan lines.
    pub lines: Lines,
}

/// Why a folder of images cannot be used.
#[derive(Debug)]
pub enum RendersError {
    /// Its table of truth is missing or malformed.
    Truth(PathBuf, String),
    /// An image is wrong.
    Image(PathBuf, InputError),
}

impl fmt::Display for RendersError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truth(path, what) => write!(f, "{}: {what}", path.display()),
            Self::Image(path, error) => write!(f, "{}: {error}", path.display()),
        }
    }
}

impl core::error::Error for RendersError {}

/// The columns of truth.csv that are used.
#[derive(Debug, Deserialize)]
struct Truth {
    file: String,
    case: String,
    payload_bits: usize,
    payload_hex: String,
    camera_x_m: f64,
    camera_y_m: f64,
    camera_theta_rad: f64,
}

impl Truth {
    fn landmark(&self) -> Result<Option<(Format, u32)>, String> {
        if self.case == "blank" {
            return Ok(None);
        }
        let format = Format::ALL.into_iter().find(|format| format.payload_bits() == self.payload_bits);
        let format = format.ok_or_else(|| format!("{} has payload_bits {}", self.file, self.payload_bits))?;
        let payload = u32::from_str_radix(&self.payload_hex, 16)
            .ok()
            .filter(|payload| u64::from(*payload) >> format.payload_bits() == 0)
            .ok_or_else(|| format!("{} has payload_hex {:?}", self.file, self.payload_hex))?;
        Ok(Some((format, payload)))
    }
}

/// All images of a folder that has a `truth.csv`.
pub fn load(folder: &Path, camera: &Camera) -> Result<Vec<Render>, RendersError> {
    let table = folder.join("truth.csv");
    let wrong = |what: String| RendersError::Truth(table.clone(), what);
    let mut reader = csv::Reader::from_path(&table).map_err(|error| wrong(error.to_string()))?;
    let mut renders = Vec::new();
    for truth in reader.deserialize() {
        let truth: Truth = truth.map_err(|error| wrong(error.to_string()))?;
        let landmark = truth.landmark().map_err(wrong)?;
        let path = folder.join(&truth.file);
        let lines = scan_lines(&path, camera).map_err(|error| RendersError::Image(path, error))?;
        let pose = [truth.camera_x_m, truth.camera_y_m, truth.camera_theta_rad];
        if pose.iter().any(|value| !value.is_finite()) {
            return Err(wrong(format!("{} has a pose that is not a number", truth.file)));
        }
        renders.push(Render { file: truth.file, landmark, pose, lines });
    }
    if renders.is_empty() { Err(wrong("lists no images".to_owned())) } else { Ok(renders) }
}
