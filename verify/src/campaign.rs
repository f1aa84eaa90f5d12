//! A campaign: both pipelines over images, the paper's data set, frontal views and random scenes.

use crate::disturb::Disturbance;
use crate::findings::{Findings, view, view_of_nothing};
use crate::lockstep::{Setting, compare};
use crate::port::{Cameras, Landmarks};
use crate::renders::Render;
use crate::scenes::{self, Cell, Kind, Scenes, Staged};
use crate::tally::{Frame, Part};
use crate::trace::{DetectionTrace, Trace};
use core::sync::atomic::{AtomicU64, Ordering};
use rayon::prelude::*;
use reference::camera::Camera;
use reference::crossing::CrossingRule;

/// What to run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Random scenes.
    pub frames: u64,
    /// Seed of everything random.
    pub seed: u64,
    /// Images.
    pub renders: Vec<Render>,
}

/// A deliberate fault and its size as a share of the bound.
pub type Fault = Option<(Disturbance, f64)>;

/// What was found on one image.
#[derive(Clone, Debug)]
pub struct RenderResult {
    /// The image and its truth.
    pub render: Render,
    /// Detections of the reference and of the port.
    pub detections: [Vec<DetectionTrace>; 2],
}

impl RenderResult {
    /// Whether a pipeline (0 or 1) found just what is on the image.
    #[must_use]
    pub fn is_right(&self, pipeline: usize) -> bool {
        let found = self.detections[pipeline].iter().map(|detection| (detection.format, detection.payload));
        found.eq(self.render.landmark)
    }
}

/// Runs both pipelines over whatever it is given.
pub struct Campaign<'a> {
    plan: &'a Plan,
    interpolated: Setting,
    whole_pixel: Setting,
    scenes: Scenes,
    fault: Fault,
    /// Called with the number of frames that have just been run.
    progress: &'a (dyn Fn(u64) + Sync),
    disturbed: AtomicU64,
}

impl<'a> Campaign<'a> {
    /// A campaign with the e-puck's camera, both formats searched.
    ///
    /// # Panics
    /// Never: the port holds the e-puck's camera.
    #[must_use]
    pub fn new(plan: &'a Plan, fault: Fault, progress: &'a (dyn Fn(u64) + Sync)) -> Self {
        let cameras = Cameras::new(Camera::epuck()).expect("the port holds the e-puck's camera");
        let setting = |rule| Setting { cameras, landmarks: Landmarks::both(), rule };
        Self {
            plan,
            interpolated: setting(CrossingRule::Interpolated),
            whole_pixel: setting(CrossingRule::WholePixel),
            scenes: Scenes::new(plan.seed),
            fault,
            progress,
            disturbed: AtomicU64::new(0),
        }
    }

    /// Frames of a whole campaign.
    #[must_use]
    pub fn frames(plan: &Plan) -> u64 {
        let views = plan.renders.len() as u64 + scenes::paper_frames() + 2 * scenes::frontal_frames();
        views.saturating_add(plan.frames)
    }

    /// Frames in which the fault found something to change.
    #[must_use]
    pub fn disturbed(&self) -> u64 {
        self.disturbed.load(Ordering::Relaxed)
    }

    /// Runs all parts. The result does not depend on the number of threads.
    #[must_use]
    pub fn run(&self) -> (Findings, Vec<RenderResult>) {
        let (findings, renders) = self.run_renders();
        let findings = findings.merged(&self.run_views(
            Part::Paper,
            &self.interpolated,
            scenes::paper_frames(),
            scenes::paper_view,
        ));
        let frontal = scenes::frontal_frames();
        let findings =
            findings.merged(&self.run_views(Part::Frontal, &self.interpolated, frontal, scenes::frontal_view));
        let findings =
            findings.merged(&self.run_views(Part::WholePixel, &self.whole_pixel, frontal, scenes::frontal_view));
        (findings.merged(&self.run_scenes(0..self.plan.frames)), renders)
    }

    /// The images.
    #[must_use]
    pub fn run_renders(&self) -> (Findings, Vec<RenderResult>) {
        let mut findings = Findings::default();
        let mut results = Vec::new();
        for (index, render) in self.plan.renders.iter().enumerate() {
            let frame = Frame { part: Part::Renders, index: index as u64 };
            let traces = self.frame(&self.interpolated, frame, &render.lines, &mut findings);
            findings.add_frame(Part::Renders, render.landmark.as_slice(), &traces);
            let detections = traces.map(|trace| trace.detections);
            results.push(RenderResult { render: render.clone(), detections });
        }
        (findings, results)
    }

    fn run_views(
        &self,
        part: Part,
        setting: &Setting,
        frames: u64,
        stage: impl Fn(u64, u64) -> (Cell, Staged) + Sync,
    ) -> Findings {
        in_parallel(0..frames, |index, findings| {
            let (cell, mut staged) = stage(self.plan.seed, index);
            let lines = staged.render(&setting.cameras.reference);
            let traces = self.frame(setting, Frame { part, index }, &lines, findings);
            let truth = staged.truth();
            findings.add_frame(part, &truth, &traces);
            if let Some(&landmark) = truth.first() {
                findings.rates.entry((part, cell)).or_default().add(view(landmark, &traces));
            }
        })
    }

    /// A range of the random scenes.
    #[must_use]
    pub fn run_scenes(&self, range: core::ops::Range<u64>) -> Findings {
        let setting = &self.interpolated;
        in_parallel(range, |index, findings| {
            let mut scene = self.scenes.scene(&setting.cameras.reference, index);
            let lines = scene.staged.render(&setting.cameras.reference);
            let traces = self.frame(setting, Frame { part: Part::Scenes, index }, &lines, findings);
            let truth = scene.staged.truth();
            findings.add_frame(Part::Scenes, &truth, &traces);
            *findings.boxes.entry(scene.cell).or_default() += 1;
            let rates = &mut findings.scenes;
            match (scene.kind, truth.first()) {
                (Kind::Bars, _) => rates.without_landmark.bars.add(view_of_nothing(&traces)),
                (_, None) => rates.without_landmark.blank.add(view_of_nothing(&traces)),
                (_, Some(&landmark)) if scene.in_range => rates.in_range.add(view(landmark, &traces)),
                (_, Some(&landmark)) => rates.out_of_range.add(view(landmark, &traces)),
            }
        })
    }

    /// One frame in lockstep.
    fn frame(&self, setting: &Setting, frame: Frame, lines: &scenes::Lines, findings: &mut Findings) -> [Trace; 2] {
        let [upper, lower] = lines;
        let [reference, mut port] = setting.run(upper, lower);
        if let Some((disturbance, share)) = self.fault {
            let applied = disturbance.apply(setting, share, &reference, &mut port);
            self.disturbed.fetch_add(u64::from(applied), Ordering::Relaxed);
        }
        compare(setting, frame, &reference, &port, &mut findings.tally);
        (self.progress)(1);
        [reference, port]
    }
}

/// Findings of all frames of a range, whatever the order in which they are run.
fn in_parallel(range: core::ops::Range<u64>, run: impl Fn(u64, &mut Findings) + Sync) -> Findings {
    range
        .into_par_iter()
        .fold(Findings::default, |mut findings, index| {
            run(index, &mut findings);
            findings
        })
        .reduce(Findings::default, |one, other| one.merged(&other))
}
