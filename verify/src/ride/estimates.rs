//! What both pipelines believed, as files (ROUTE-9).

use super::Row;
use crate::log::{Estimate, EstimateWriter};
use crate::print::files::Unwritten;
use std::path::{Path, PathBuf};

/// Names of the files, in the order of the robots of a row.
pub const FILES: [&str; 2] = ["estimate_reference.csv", "estimate_fixedpoint.csv"];

/// Writes a row of each pipeline's file for every row of a ride.
#[derive(Debug)]
pub struct Estimates {
    writers: Vec<EstimateWriter>,
    paths: Vec<PathBuf>,
}

impl Estimates {
    /// Files in a folder that exists; they are put in their places by [`Self::finish`].
    pub fn create(folder: &Path) -> Result<Self, Unwritten> {
        let paths = FILES.map(|file| folder.join(file));
        let writers = paths.iter().map(|path| EstimateWriter::create(path.clone())).collect::<Result<_, _>>()?;
        Ok(Self { writers, paths: paths.to_vec() })
    }

    /// What was believed at a reading, and what had led to it.
    //= reference/SPEC.md#route
    //# - **ROUTE-9** A log that is written of a run and replayed MUST give the same estimates, byte for byte.
    pub fn row(&mut self, row: &Row) -> Result<(), Unwritten> {
        for ((writer, known), taken) in self.writers.iter_mut().zip(&row.known).zip(&row.taken) {
            let pose = [known.pose.x(), known.pose.y(), known.pose.theta()];
            writer.row(&Estimate { time: row.time.into(), pose, covariance: known.covariance }, &taken.words())?;
        }
        Ok(())
    }

    /// Puts the files in their places: their paths.
    pub fn finish(self) -> Result<Vec<PathBuf>, Unwritten> {
        self.writers.into_iter().try_for_each(EstimateWriter::finish)?;
        Ok(self.paths)
    }
}
