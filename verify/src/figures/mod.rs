//! The paper's Fig. 9 a), 9 b) and 10 with (11) and (12), made anew under its conditions and set beside what it says.
//!
//! [`studies`] runs both pipelines over the views, [`sightings`] keeps what was found, [`limits`], [`spread`] and
//! [`regressions`] are the statistics, [`report`] has all numbers, [`statements`] says where we agree, [`tables`] and
//! [`drawing`] show it.

pub mod drawing;
pub mod limits;
pub mod line;
pub mod panel;
pub mod regressions;
pub mod report;
pub mod sightings;
pub mod spread;
pub mod statements;
pub mod studies;
pub mod tables;
