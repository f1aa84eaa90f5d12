//! How accurate both pipelines' poses are, beside the Cramer-Rao bound (BOUND).
//!
//! Views of one `paper` landmark from a grid of distances and inclinations, with as much noise and blur as stated while
//! the fit starts from a blur of 0.5 px. Where the default landmark would not fill both rows, beyond 45 cm, a tall one is
//! looked at, and the default one apart from it.

mod point;
mod spread;
mod views;

pub use point::{Conditions, Point, Rows, grid};
pub use spread::{Band, Spread};
pub use views::{Estimator, Measured, Pipeline, measure};
