//! A robot's way through a site and how well it knew where it was, as in the paper's Figs. 11, 12 and 13.
//!
//! [`map`] shows the site from above with the paths, [`errors`] shows how far the estimate was from the truth over time.
//! Lengths are metres, angles radians and times seconds in what is passed in; pixels are those of a page 2000 wide.

pub mod errors;
mod frame;
pub mod map;
mod sign;

use core::ops::Range;
use plotters::coord::Shift;
use plotters::prelude::*;

/// `[x, y, heading]` in the world, metres and radians.
pub type Pose = [f64; 3];

/// A moment of a run. What is not finite is left out of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Since the run began, seconds, rising.
    pub time: f64,
    /// Where the robot is.
    pub truth: Pose,
    /// Where the reference believes it is.
    pub estimate: Pose,
    /// Where the port believes it is.
    pub port: Option<Pose>,
    /// Where it would be by the movement of its wheels alone.
    pub odometry: Option<Pose>,
    /// Standard deviation of the estimate's position by its own covariance, along its worst direction, metres.
    pub deviation: Option<f64>,
    /// Whether the robot is off the floor: what is true then is shown by the drawings as a gap.
    pub lifted: bool,
    /// What became of observations that came in since the sample before.
    pub seen: Seen,
}

/// What became of the observations of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// At least one corrected the estimate.
    pub used: bool,
    /// At least one was refused by the gate.
    pub gated: bool,
    /// The filter took the pose of one for its own and began anew.
    pub recovered: bool,
}

/// A rectangle of the page, in pixels.
type Page<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Width of every page, pixels.
const WIDTH: i32 = 2000;
/// White around everything, pixels.
const MARGIN: i32 = 24;
/// Text, pixels: 14 of a drawing that is shown 1000 wide.
const TEXT: i32 = 28;
/// From one line of text to the next, pixels.
const LINE: i32 = 44;

// Colours that can be told apart by people who do not tell red from green (Okabe and Ito); black is the truth.
const BLUE: RGBColor = RGBColor(0, 114, 178);
const VERMILLION: RGBColor = RGBColor(213, 94, 0);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
const SKY: RGBColor = RGBColor(86, 180, 233);
/// Their reddish purple, darker: crosses are thin.
const PURPLE: RGBColor = RGBColor(160, 50, 120);

/// The style of all text but titles; the library draws it at 1/1.24 of the size it is given.
fn text_style() -> TextStyle<'static> {
    ("sans-serif", 1.24 * f64::from(TEXT)).into_font().color(&BLACK)
}

/// A title's lines, the first one bold, at the top of a page.
fn draw_title(page: &Page<'_>, left: i32, title: &str) -> Result<(), super::DrawingError> {
    let heading = ("sans-serif", 1.24 * f64::from(TEXT + 4), FontStyle::Bold).into_font().color(&BLACK);
    for (line, number) in title.lines().zip(0..) {
        let style = if number == 0 { heading.clone() } else { text_style() };
        page.draw_text(line, &style, (left, MARGIN + number * LINE))?;
    }
    Ok(())
}

/// Height of a title with the white around it, pixels.
fn title_height(title: &str) -> i32 {
    MARGIN + LINE * i32::try_from(title.lines().count()).unwrap_or(1) + MARGIN / 2
}

/// The samples of each time the robot was off the floor.
fn lifts(samples: &[Sample]) -> Vec<Range<usize>> {
    let mut lifts: Vec<Range<usize>> = vec![];
    for (i, _) in samples.iter().enumerate().filter(|(_, sample)| sample.lifted) {
        match lifts.last_mut() {
            Some(last) if last.end == i => last.end += 1,
            _ => lifts.push(i..i + 1),
        }
    }
    lifts
}

/// Whether something is there or happened at a sample.
type Has = fn(&Sample) -> bool;

/// How many samples have something, for a legend.
fn count(samples: &[Sample], has: Has) -> usize {
    samples.iter().filter(|sample| has(sample)).count()
}

#[cfg(test)]
mod tests;
