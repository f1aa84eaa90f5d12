//! What both pipelines make of the views of one cell of a figure, by both rules.

use crate::findings::{Both, Rate};
use crate::lockstep::{Setting, compare};
use crate::paper_estimate::{PaperEstimate, paper_estimates};
use crate::port::{Cameras, Landmarks};
use crate::scenes::Staged;
use crate::tally::{Frame, Part, Tally};
use crate::trace::Trace;
use reference::camera::Camera;
use reference::crossing::CrossingRule;
use reference::frame::wrap;
use reference::landmark::Format;
use serde::Serialize;

/// One of each for the two crossing rules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PerRule<T> {
    /// By the paper's estimator (CROSS-3).
    pub whole_pixel: T,
    /// By the default (CROSS-2).
    pub interpolated: T,
}

impl<T> PerRule<T> {
    /// The same made of each.
    pub fn map<U>(&self, make: impl Fn(&T) -> U) -> PerRule<U> {
        PerRule { whole_pixel: make(&self.whole_pixel), interpolated: make(&self.interpolated) }
    }

    /// Both with their names, the paper's first.
    #[must_use]
    pub fn named(&self) -> [(&'static str, &T); 2] {
        [("whole-pixel", &self.whole_pixel), ("interpolated", &self.interpolated)]
    }
}

/// Found minus true, in L; for views from the left of the landmark mirrored to the right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseError {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub theta: f64,
}

/// What was found in the views of a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sightings {
    /// Views, and those in which the landmark was found.
    pub rate: Rate,
    /// What was read that is not in the scene.
    pub wrong: Both,
    /// Errors of the reference's poses, in the order of the views.
    pub errors: Vec<PoseError>,
}

/// From which side a cell's views are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Frontal: there is nothing to mirror.
    Frontal,
    /// From either side of the landmark's normal.
    Either,
}

impl Sides {
    /// Those of an inclination in degrees.
    #[must_use]
    pub fn of(degrees: u32) -> Self {
        if degrees == 0 { Self::Frontal } else { Self::Either }
    }
}

/// Runs the pipelines over views with the e-puck's camera, searching the format `paper` as the paper did.
#[derive(Clone, Debug)]
pub struct Spectator {
    settings: PerRule<Setting>,
}

impl Default for Spectator {
    fn default() -> Self {
        Self::new()
    }
}

impl Spectator {
    /// A spectator for both rules.
    ///
    /// # Panics
    /// Never: the port holds the e-puck's camera and the default landmark.
    #[must_use]
    pub fn new() -> Self {
        let cameras = Cameras::new(Camera::epuck()).expect("the port holds the e-puck's camera");
        let landmarks = Landmarks::new(&[Format::Paper]).expect("the port holds the default stripe width");
        let setting = |rule| Setting { cameras, landmarks: landmarks.clone(), rule };
        Self {
            settings: PerRule {
                whole_pixel: setting(CrossingRule::WholePixel),
                interpolated: setting(CrossingRule::Interpolated),
            },
        }
    }

    fn camera(&self) -> &Camera {
        &self.settings.whole_pixel.cameras.reference
    }

    /// Both pipelines by both rules over the views of a cell, and how far the pipelines differ. Views are numbered by
    /// their frame.
    pub fn watch(&self, sides: Sides, views: impl Iterator<Item = (u64, Staged)>) -> (PerRule<Sightings>, Tally) {
        let mut seen = PerRule::<Sightings>::default();
        let mut tally = Tally::default();
        for (index, mut staged) in views {
            let [upper, lower] = staged.render(self.camera());
            let rules = [
                (&self.settings.whole_pixel, &mut seen.whole_pixel, Part::WholePixel),
                (&self.settings.interpolated, &mut seen.interpolated, Part::Paper),
            ];
            for (setting, sightings, part) in rules {
                let traces = setting.run(&upper, &lower);
                compare(setting, Frame { part, index }, &traces[0], &traces[1], &mut tally);
                let found = traces.each_ref().map(|trace| read(setting, trace));
                sightings.add(sides, &staged, &found);
            }
        }
        (seen, tally)
    }

    /// The reference alone by the paper's rule: the errors of its poses, in the order of the views.
    pub fn watch_by_reference(&self, sides: Sides, views: impl Iterator<Item = Staged>) -> Vec<PoseError> {
        let errors = views.filter_map(|mut staged| {
            let [upper, lower] = staged.render(self.camera());
            let setting = &self.settings.whole_pixel;
            error(sides, &staged, &read(setting, &setting.run_reference(&upper, &lower)))
        });
        errors.collect()
    }
}

impl Sightings {
    fn add(&mut self, sides: Sides, staged: &Staged, found: &[Vec<PaperEstimate>; 2]) {
        let truth = staged.truth();
        let is_true = |it: &&PaperEstimate| truth.contains(&(it.format, it.payload));
        let [reference, fixedpoint] = found.each_ref().map(|found| found.iter().filter(is_true).count());
        let [all_reference, all_fixedpoint] = found.each_ref().map(Vec::len);
        if !truth.is_empty() {
            let found = Both { reference: u64::from(reference > 0), fixedpoint: u64::from(fixedpoint > 0) };
            self.rate.add(Rate { views: 1, found });
        }
        self.wrong.reference += (all_reference - reference) as u64;
        self.wrong.fixedpoint += (all_fixedpoint - fixedpoint) as u64;
        self.errors.extend(error(sides, staged, &found[0]));
    }
}

/// What the paper's decoder and estimator make of a trace: pairs of layers, before any fit and acceptance.
fn read(setting: &Setting, trace: &Trace) -> Vec<PaperEstimate> {
    paper_estimates(trace, &setting.cameras.reference, &setting.landmarks.reference)
}

/// The error of the pose of the scene's first landmark, if it was found.
fn error(sides: Sides, staged: &Staged, found: &[PaperEstimate]) -> Option<PoseError> {
    let posted = staged.scene.landmarks.first()?;
    let truth = posted.landmark_in_world.inverse() * staged.scene.camera_in_world;
    let found = found.iter().find(|found| found.payload == posted.payload)?.camera_in_landmark;
    let error =
        PoseError { x: found.x() - truth.x(), y: found.y() - truth.y(), theta: wrap(found.theta() - truth.theta()) };
    let mirror = if sides == Sides::Either && truth.y() < 0.0 { -1.0 } else { 1.0 };
    Some(PoseError { x: error.x, y: mirror * error.y, theta: mirror * error.theta })
}
