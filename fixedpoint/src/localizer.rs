//! From two scan lines and the wheels' steps to the robot's pose.
//!
//! Images and readings go in as they come, in whatever order; the [`crate::timeline`] puts them in order. What a camera that
//! moves does to an image follows from the readings that the timeline holds.

mod sightings;

use crate::covariance::PoseCovariance;
use crate::crossing::CrossingRule;
use crate::detect::{self, Workspace};
use crate::exposure::{Capture, Stamp, Time};
use crate::filter::{Build, Filter, Outcome};
use crate::frame::{self, Pose, Robot, World};
use crate::landmark::Landmark;
use crate::layers::MeasuredLayer;
use crate::motion::State;
use crate::observation;
use crate::observer::Observer;
use crate::places::Places;
use crate::refusal::Untimely;
use crate::skew::Skew;
use crate::timeline::{self, Observation, Reading, Timeline};
use sightings::{Sightings, Turn};

/// Which rows of an image are its scan lines (`CAM-5`); the upper one has the smaller number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rows {
    /// How many rows an image has, `Q_y`.
    pub height: u16,
    /// The row of the upper scan line.
    pub upper: u16,
    /// The row of the lower one.
    pub lower: u16,
}

impl Rows {
    /// The first and the last of the e-puck's 8.
    #[must_use]
    pub const fn epuck() -> Self {
        Self { height: 8, upper: 0, lower: 7 }
    }

    /// Both rows' times by a clock of rows.
    fn times(&self, of: impl Fn(u16, u16) -> Time) -> [Time; 2] {
        [self.upper, self.lower].map(|row| of(row, self.height))
    }
}

/// What an image tells the filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimation {
    /// What is seen of each layer (`OBSERVE-3`).
    #[default]
    Image,
    /// The robot's pose by each layer (`LOCATE-4`).
    Pose,
    /// The robot's pose by the paper's estimate (`LOCATE-5`).
    Paper,
}

/// What a localizer knows of its robot and of its site.
#[derive(Clone, Copy, Debug)]
pub struct Config<'a> {
    /// The robot.
    pub build: Build,
    /// The scan lines.
    pub rows: Rows,
    /// The formats that are searched, with their dimensions; of one format the first counts.
    pub landmarks: &'a [Landmark],
    /// Where landmarks stand.
    pub places: Places<'a>,
    /// When images count as seen.
    pub stamp: Stamp,
    /// What the filter is told.
    pub estimation: Estimation,
    /// How transitions are placed; by [`Estimation::Paper`] it is the whole-pixel rule (`LOCATE-5`).
    pub rule: CrossingRule,
}

impl Config<'_> {
    fn rule(&self) -> CrossingRule {
        match self.estimation {
            Estimation::Paper => CrossingRule::WholePixel,
            Estimation::Image | Estimation::Pose => self.rule,
        }
    }
}

/// What became of everything that a localizer was given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// By the timeline.
    pub timeline: timeline::Counts,
    /// Detections of which the site knows no pose (`LOCATE-2`).
    pub unknown: u32,
}

/// What an image has shown, and what became of it so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Detections.
    pub detections: u8,
    /// Those of which the site knows no pose (`LOCATE-2`).
    pub unknown: u8,
    /// Observations that the estimate used, be it by recovering.
    pub used: u8,
    /// Observations that it did not.
    pub gated: u8,
    /// Observations that wait for their reading (`TIME-4`).
    pub waiting: u8,
    /// Observations that the timeline refused.
    pub refused: u8,
}

impl Seen {
    fn add(&mut self, outcome: Result<Option<Outcome>, Untimely>) {
        let count = match outcome {
            Ok(Some(Outcome::Used | Outcome::Recovered)) => &mut self.used,
            Ok(Some(Outcome::Gated)) => &mut self.gated,
            Ok(None) => &mut self.waiting,
            Err(_) => &mut self.refused,
        };
        *count = count.saturating_add(1);
    }
}

/// Where the robot is.
///
/// Memory on a 32-bit target: 2.5 KB, of which the [`Timeline`] is 2.4 KB. While an image is processed, also what
/// [`detect::detect_moving`] takes, and its detections.
#[derive(Clone, Debug)]
pub struct Localizer<'a> {
    config: Config<'a>,
    timeline: Timeline,
    /// How many images there were.
    images: u32,
    /// The last pose that came from elsewhere: of what time and what image it was (`LOCATE-7`).
    elsewhere: Option<(Time, u32)>,
    unknown: u32,
}

impl<'a> Localizer<'a> {
    /// A localizer that knows at a time where the robot is.
    #[must_use]
    pub fn new(config: Config<'a>, start: State, begin: Time) -> Self {
        let timeline = Timeline::new(Filter::new(config.build, start), begin);
        Self { config, timeline, images: 0, elsewhere: None, unknown: 0 }
    }

    /// Takes a reading of the wheels.
    ///
    /// # Errors
    /// As [`Timeline::read`].
    pub fn read(&mut self, reading: &Reading) -> Result<(), Untimely> {
        self.timeline.read(reading)
    }

    /// Takes an image: its two scan lines and when it was captured.
    ///
    /// The observer hears the skew, what [`detect::detect_moving`] reports, and what becomes of each detection. Observations come
    /// to the timeline in the order of their times, of one time in the order of the detections, the upper layer first (`LOCATE-3`).
    //= reference/SPEC.md#locate
    //# - **LOCATE-3** The measurements of an image (LAYER) MUST be given to the timeline in the order of their times,
    //# the image's number being that of its arrival.
    pub fn image<O: Observer>(
        &mut self,
        upper: &[u8],
        lower: &[u8],
        capture: &Capture,
        workspace: &mut Workspace,
        observer: &mut O,
    ) -> Seen {
        let skew = self.skew(capture);
        observer.skew(&skew);
        let image = self.next_image();
        let Self { config, timeline, unknown, .. } = self;
        let config = &*config;
        let Config { build: Build { camera, .. }, rows, landmarks, stamp, .. } = config;
        let detections =
            detect::detect_moving(upper, lower, camera, landmarks, config.rule(), &skew, workspace, observer);
        let times = rows.times(|row, height| capture.seen(*stamp, row, height));
        let sightings = Sightings { config, lines: [upper, lower], times, image };
        let mut given = Given { timeline, observer, seen: Seen::default() };
        for detection in &detections {
            given.seen.detections = given.seen.detections.saturating_add(1);
            let Some(observations) = sightings.of(detection, Turn::Upper) else {
                given.seen.unknown = given.seen.unknown.saturating_add(1);
                *unknown = unknown.saturating_add(1);
                given.observer.unknown(detection);
                continue;
            };
            observations.iter().for_each(|observation| given.give(observation));
        }
        let lower = detections.iter().filter_map(|detection| sightings.of(detection, Turn::Lower));
        lower.flatten().for_each(|observation| given.give(&observation));
        given.seen
    }

    /// Takes a pose that the robot had in a landmark's frame at a time, from whoever knows it, with its covariance (`LOCATE-7`): of a
    /// new image if the last one was of another time, and of the landmark that `number` tells apart.
    ///
    /// The position within ±64 m. Errors: 2^-24 m, of the covariance 2^-46 and 2^-28 of its largest entry.
    ///
    /// # Errors
    /// As [`Timeline::observe`].
    //= reference/SPEC.md#locate
    //# - **LOCATE-7** An observation of the robot's pose in a landmark's frame that comes from elsewhere MUST be taken
    //# as a pose (OBSERVE-2) of a camera in the robot's own place, of a new image if the last one that came from
    //# elsewhere was of another time, its landmark told apart by a number that it comes with.
    pub fn observe_pose(
        &mut self,
        time: Time,
        landmark_in_world: &Pose<World, frame::Landmark>,
        robot_in_landmark: &Pose<frame::Landmark, Robot>,
        covariance: &PoseCovariance,
        number: u32,
    ) -> Result<Option<Outcome>, Untimely> {
        let mounting = &self.config.build.mounting;
        let sighting = observation::of_robot(landmark_in_world, robot_in_landmark, covariance, mounting);
        let image = self.image_elsewhere(time);
        self.timeline.observe(&Observation { time, image, payload: number, layer: MeasuredLayer::Both, sighting })
    }

    /// Begins anew at a time, with the estimate that there is (`TIME-11`).
    pub fn restart(&mut self, time: Time) {
        self.timeline.restart(time);
    }

    /// The state at [`Localizer::time`].
    #[must_use]
    pub fn estimate(&self) -> &State {
        self.timeline.estimate()
    }

    /// The newest reading's time (`TIME-4`).
    #[must_use]
    pub fn time(&self) -> Time {
        self.timeline.time()
    }

    /// What became of everything so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts { timeline: self.timeline.counts(), unknown: self.unknown }
    }

    /// How the camera moved between both rows' times (`LOCATE-6`).
    //= reference/SPEC.md#locate
    //# - **LOCATE-6** The skew MUST be that of the readings the timeline holds; where they do not reach back to the
    //# upper row's time or on to the lower row's, it counts as at rest for what is missing.
    fn skew(&self, capture: &Capture) -> Skew {
        let Config { build: Build { camera, drive, mounting, .. }, rows, .. } = &self.config;
        let [upper, lower] = rows.times(|row, height| capture.row_time(row, height));
        Skew::of_ways(self.timeline.ways_between(upper, lower), drive, mounting, camera)
    }

    /// The number of the image of a pose from elsewhere (`LOCATE-7`).
    fn image_elsewhere(&mut self, time: Time) -> u32 {
        match self.elsewhere {
            Some((last, image)) if last == time => image,
            _ => {
                let image = self.next_image();
                self.elsewhere = Some((time, image));
                image
            }
        }
    }

    /// The number of an image, that of its arrival (`LOCATE-3`).
    fn next_image(&mut self) -> u32 {
        let image = self.images;
        self.images = image.wrapping_add(1);
        image
    }
}

/// Where observations are given to.
struct Given<'a, O> {
    timeline: &'a mut Timeline,
    observer: &'a mut O,
    seen: Seen,
}

impl<O: Observer> Given<'_, O> {
    fn give(&mut self, observation: &Observation) {
        let outcome = self.timeline.observe(observation);
        self.observer.observed(observation, outcome);
        self.seen.add(outcome);
    }
}

#[cfg(test)]
mod tests;
