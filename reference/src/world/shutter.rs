//! Images whose rows are exposed one after another while the robot moves (WORLD-13 to WORLD-17, EXPOSE-1).

use super::sight::{ends, whole};
use super::track::Track;
use super::{Place, TICK};
use crate::codeword;
use crate::exposure::{Capture, Time};
use crate::frame::{self, Pose, World};
use crate::render::{Posted, Scene, digitise, radiance, row_ink};
use rand::{Rng, RngExt};

/// The most that an edge moves between two poses of one exposure, pixels (WORLD-14).
const BETWEEN_POSES: f64 = 0.25;

/// When images are taken. All times are microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shutter {
    /// From the beginning of an image to the next; at least capture and processing.
    pub period: u64,
    /// From the beginning to the end of the capture, above 0, at most 1 s (EXPOSE-2).
    pub capture: u64,
    /// From the end of the capture to that of the processing.
    pub processing: u64,
    /// For how long each row collects light, above 0; at most its share of the capture.
    pub exposure: u64,
}

impl Default for Shutter {
    /// The paper's: an image every 400 ms, 300 ms capture, 100 ms processing; a row's whole share of 8.
    fn default() -> Self {
        Self { period: 400_000, capture: 300_000, processing: 100_000, exposure: 37_500 }
    }
}

/// When a row of a camera with so many rows is exposed, by the middle of its exposure, if the image was captured from
/// `start` to `end`; microseconds (EXPOSE-1).
fn exposed(rows: usize, row: usize, start: u64, end: u64) -> u64 {
    let [start, end] = [start, end].map(Time::from_micros);
    Capture { start, end, processed: end }.row_time(row, rows).as_micros()
}

/// A thing that stands in front of both lines (WORLD-16).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Column at which it begins.
    pub left: f64,
    /// Column at which it ends.
    pub right: f64,
    /// From 0 for white to 1 for black.
    pub ink: f64,
}

impl Obstacle {
    /// An obstacle somewhere before a line; three uniform deviates.
    //= reference/SPEC.md#world
    //# - **WORLD-16** With a stated probability an image MUST have an obstacle in front of both lines, from 1/16 to 1/2
    //# of the line wide, anywhere before it, of one ink from 0 to 1.
    fn draw<R: Rng + ?Sized>(width: usize, rng: &mut R) -> Self {
        let width = width as f64;
        let extent = width * rng.random_range(1.0 / 16.0..0.5);
        let left = rng.random_range(-extent..width);
        Self { left, right: left + extent, ink: rng.random() }
    }

    fn cover(&self, line: &mut [f64]) {
        for (i, ink) in line.iter_mut().enumerate() {
            let middle = i as f64;
            let share = (self.right.min(middle + 0.5) - self.left.max(middle - 0.5)).max(0.0);
            *ink += share * (self.ink - *ink);
        }
    }
}

/// A landmark of which all is on both lines of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// Its number at the place.
    pub landmark: usize,
    /// What it was drawn with: its own payload, or a false one (WORLD-17).
    pub payload: u32,
}

/// How images are disturbed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Probability of an obstacle in an image, 0 to 1 (WORLD-16).
    pub occlusion: f64,
    /// Probability that a landmark of which all is seen is drawn with another payload, 0 to 1 (WORLD-17).
    pub false_decodes: f64,
}

/// What is in the way in one image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Disturbed {
    pub(super) obstacle: Option<Obstacle>,
    pub(super) seen: Vec<Seen>,
}

/// The place, and where the robot was.
pub(super) struct View<'a> {
    pub(super) place: &'a Place,
    pub(super) track: &'a Track,
}

impl View<'_> {
    /// Draws what disturbs an image that was captured from `start` to `end`, microseconds.
    pub(super) fn disturb<R: Rng + ?Sized>(&self, by: &Disturbance, start: u64, end: u64, rng: &mut R) -> Disturbed {
        // As many deviates for every image, so that its obstacle is the same whatever the probability.
        let obstacle = Obstacle::draw(self.place.camera.width, rng);
        let obstacle = (rng.random::<f64>() < by.occlusion).then_some(obstacle);
        let seen = self.seen(start, end).into_iter().map(|landmark| {
            let posted = &self.place.landmarks[landmark];
            let payload = if rng.random::<f64>() < by.false_decodes {
                false_payload(self.place, posted, rng)
            } else {
                posted.payload
            };
            Seen { landmark, payload }
        });
        let seen = seen.collect();
        Disturbed { obstacle, seen }
    }

    /// The landmarks of which all is on both lines in the middle of their exposure (WORLD-12).
    fn seen(&self, start: u64, end: u64) -> Vec<usize> {
        let camera = &self.place.camera;
        let middles = [camera.upper_row, camera.lower_row].map(|row| exposed(camera.height, row, start, end));
        let [Some(upper), Some(lower)] = middles.map(|time| self.camera_at(time as f64)) else { return Vec::new() };
        let on_both = |posted: &Posted| whole(self.place, &upper, posted) && whole(self.place, &lower, posted);
        (0..self.place.landmarks.len()).filter(|&i| on_both(&self.place.landmarks[i])).collect()
    }

    fn camera_at(&self, time: f64) -> Option<Pose<World, frame::Camera>> {
        self.track.at(time).map(|robot| robot * self.place.camera_in_robot)
    }

    /// Both scan lines of an image (WORLD-13 to WORLD-17).
    ///
    /// `rng` gives the deviates of [`crate::render::render`].
    //= reference/SPEC.md#world
    //# - **WORLD-13** A row's exposure MUST be centred on EXPOSE-1's time and last as long as is stated, at most the
    //# row's share of the capture, which is the default.
    pub(super) fn expose<R: Rng + ?Sized>(
        &self,
        shutter: &Shutter,
        start: u64,
        disturbed: &Disturbed,
        rng: &mut R,
    ) -> [Vec<u8>; 2] {
        let mut scene = self.scene(disturbed);
        let camera = &self.place.camera;
        [camera.upper_row, camera.lower_row].map(|row| {
            let middle = exposed(camera.height, row, start, start + shutter.capture) as f64;
            let half = shutter.exposure as f64 / 2.0;
            let mut line = self.mean_ink(&mut scene, row, middle - half, middle + half);
            if let Some(obstacle) = &disturbed.obstacle {
                obstacle.cover(&mut line);
            }
            digitise(&radiance(&line, &self.place.light), self.place.sensor.noise, rng)
        })
    }

    /// The place with the payloads of an image.
    fn scene(&self, disturbed: &Disturbed) -> Scene {
        let mut landmarks = self.place.landmarks.clone();
        for seen in &disturbed.seen {
            landmarks[seen.landmark].payload = seen.payload;
        }
        let camera_in_world = Pose::new(0.0, 0.0, 0.0);
        Scene { camera_in_world, landmarks, clutter: vec![], light: self.place.light, sensor: self.place.sensor }
    }

    /// The mean of a row's ink over the poses of its exposure (WORLD-14). While the robot is lifted all is white (WORLD-15).
    //= reference/SPEC.md#world
    //# - **WORLD-14** A row's ink MUST be the mean of RENDER's over poses at the middles of equal parts of the
    //# exposure, as many that no end of a barcode moves by more than 1/4 px from one to the next.
    //= reference/SPEC.md#world
    //# - **WORLD-15** A robot off the ground MUST see a white wall.
    fn mean_ink(&self, all: &mut Scene, row: usize, begin: f64, end: f64) -> Vec<f64> {
        let poses = self.poses(begin, end);
        let mut sum = vec![0.0; self.place.camera.width];
        let mut scene = Scene { landmarks: Vec::new(), ..all.clone() };
        for i in 0..poses {
            let time = begin + (end - begin) * (i as f64 + 0.5) / poses as f64;
            let Some(camera_in_world) = self.camera_at(time) else { continue };
            let in_sight = |posted: &&Posted| ends(self.place, &camera_in_world, posted).is_some();
            scene.landmarks = all.landmarks.iter().filter(in_sight).copied().collect();
            if scene.landmarks.is_empty() {
                continue;
            }
            scene.camera_in_world = camera_in_world;
            let ink =
                row_ink(&self.place.camera, &scene, row).expect("payloads were checked and false ones have code words");
            sum.iter_mut().zip(ink).for_each(|(sum, ink)| *sum += ink);
        }
        sum.iter().map(|ink| ink / poses as f64).collect()
    }

    /// How many poses stand for an exposure so that no end of a barcode moves by more than [`BETWEEN_POSES`] from one
    /// to the next, as fast as it moves at most; where a lift comes into it, at least one for every tick.
    fn poses(&self, begin: f64, end: f64) -> usize {
        let tick = TICK as f64;
        let mut knots = vec![begin];
        let mut next = (begin / tick).floor() * tick + tick;
        while next < end {
            knots.push(next);
            next += tick;
        }
        knots.push(end);
        let columns: Vec<_> = knots.iter().map(|&time| self.columns(time)).collect();
        let rate =
            knots.windows(2).zip(columns.windows(2)).map(|(time, at)| farthest(&at[0], &at[1]) / (time[1] - time[0]));
        let most = rate.fold(0.0, f64::max);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "columns are limited: below 10^6")]
        let poses = (most * (end - begin) / BETWEEN_POSES).ceil() as usize;
        let lifted = knots.iter().any(|&time| self.track.at(time).is_none());
        poses.max(if lifted { knots.len() - 1 } else { 1 })
    }

    /// The columns of every barcode's ends, limited to three times the image, where they are in sight.
    fn columns(&self, time: f64) -> Vec<Option<[f64; 2]>> {
        let width = self.place.camera.width as f64;
        let camera = self.camera_at(time);
        let limited = |posted: &Posted| {
            ends(self.place, &camera?, posted).map(|ends| ends.map(|column| column.clamp(-width, 2.0 * width)))
        };
        self.place.landmarks.iter().map(limited).collect()
    }
}

/// The farthest that an end moved which both poses have in sight, pixels.
fn farthest(before: &[Option<[f64; 2]>], after: &[Option<[f64; 2]>]) -> f64 {
    let moved = before.iter().zip(after).filter_map(|(before, after)| {
        let ([a, b], [c, d]) = ((*before)?, (*after)?);
        Some((a - c).abs().max((b - d).abs()))
    });
    moved.fold(0.0, f64::max)
}

/// Another payload that has a code word and stands for a pose of the grid (WORLD-17).
//= reference/SPEC.md#world
//# - **WORLD-17** With a stated probability a landmark that is seen in an image MUST be drawn there with another
//# payload that has a code word and stands for a pose of the site's grid (GRID-6).
fn false_payload<R: Rng + ?Sized>(place: &Place, posted: &Posted, rng: &mut R) -> u32 {
    let format = posted.landmark.format;
    loop {
        let payload = rng.random_range(0..1_u32 << format.payload_bits());
        let stands_for_a_pose = place.grid.landmark_in_world(format, payload).is_ok();
        if payload != posted.payload && stands_for_a_pose && codeword::encode(format, payload).is_ok() {
            return payload;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crossing::CrossingRule;
    use crate::detect::detect;
    use crate::landmark::{Format, Landmark};
    use crate::observer::Silent;
    use crate::render::{Sensor, render};
    use core::f64::consts::PI;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const QUIET: Disturbed = Disturbed { obstacle: None, seen: Vec::new() };

    /// A landmark at the origin that looks along x.
    fn place(noise: f64) -> Place {
        let landmark = Landmark::new(Format::Paper);
        let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload: 0xcc0d };
        let camera_in_robot = Pose::new(0.0, 0.0, 0.0);
        Place { camera_in_robot, landmarks: vec![posted], sensor: Sensor { blur: 0.5, noise }, ..Place::default() }
    }

    /// A robot that moves by so much in a second, for 0.3 s, from a pose.
    fn moving(from: [f64; 3], per_second: [f64; 3]) -> Track {
        let at = |seconds: f64| {
            let [x, y, theta] = [0, 1, 2].map(|i| from[i] + seconds * per_second[i]);
            Pose::new(x, y, theta)
        };
        let mut track = Track::new(at(0.0));
        (1..=48).for_each(|tick| track.push(at(f64::from(tick) * 0.00625), false));
        track
    }

    fn image(place: &Place, track: &Track, shutter: &Shutter, disturbed: &Disturbed) -> [Vec<u8>; 2] {
        View { place, track }.expose(shutter, 0, disturbed, &mut ChaCha8Rng::seed_from_u64(5))
    }

    fn payloads(place: &Place, [upper, lower]: &[Vec<u8>; 2]) -> Vec<u32> {
        let landmark = [place.landmarks[0].landmark];
        let found = detect(upper, lower, &place.camera, &landmark, CrossingRule::default(), &mut Silent);
        found.iter().map(|detection| detection.payload).collect()
    }

    fn standing(place: &Place, pose: Pose<World, frame::Camera>) -> [Vec<u8>; 2] {
        let landmarks = place.landmarks.clone();
        let Place { light, sensor, .. } = *place;
        let scene = Scene { camera_in_world: pose, landmarks, clutter: vec![], light, sensor };
        render(&place.camera, &scene, &mut ChaCha8Rng::seed_from_u64(5)).unwrap()
    }

    /// Where a line's ink is on average: what a shift moves by as much, whatever the bars.
    fn middle_of_ink(line: &[u8]) -> f64 {
        let ink = |&pixel: &u8| 200.0 - f64::from(pixel);
        let total: f64 = line.iter().map(ink).sum();
        line.iter().enumerate().map(|(i, pixel)| i as f64 * ink(pixel)).sum::<f64>() / total
    }

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-13** A row's exposure MUST be centred on EXPOSE-1's time and last as long as is stated, at most the
    //# row's share of the capture, which is the default.
    #[test]
    fn rows_are_exposed_one_after_another() {
        // 18.75 ms and 281.25 ms after the beginning; the middle of a row's share is rounded down.
        assert_eq!([0, 7].map(|row| exposed(8, row, 1_000_000, 1_300_000)), [1_018_750, 1_281_250]);
        assert_eq!(exposed(3, 1, 10, 13), 11);
    }

    #[test]
    fn a_standing_robots_image_is_the_renderers() {
        let place = place(2.0);
        for pose in [[0.3, 0.0, PI], [0.41, 0.05, PI + 0.3], [0.9, 0.0, PI], [0.3, 0.0, PI + 0.41]] {
            let image = image(&place, &moving(pose, [0.0; 3]), &Shutter::default(), &QUIET);
            assert_eq!(image, standing(&place, Pose::new(pose[0], pose[1], pose[2])));
        }
    }

    /// A wall that hides a part of the landmark hides all of it, and one that hides nothing changes nothing.
    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-11** Only landmarks that are not hidden MUST be given to the renderer (RENDER-8), whole.
    #[test]
    fn what_is_hidden_is_not_drawn() {
        let pose = [0.3, 0.0, PI];
        let with = |wall: Option<[[f64; 2]; 2]>| {
            let point = |[x, y]: [f64; 2]| crate::frame::Point::new(x, y);
            let walls = wall.map(|[from, to]| crate::world::Wall { from: point(from), to: point(to) });
            let place = Place { walls: walls.into_iter().collect(), ..place(2.0) };
            image(&place, &moving(pose, [0.0; 3]), &Shutter::default(), &QUIET)
        };
        let nothing = standing(&Place { landmarks: vec![], ..place(2.0) }, Pose::new(pose[0], pose[1], pose[2]));
        assert_eq!(with(Some([[0.1, 0.005], [0.1, 0.1]])), nothing);
        assert_eq!(with(Some([[0.1, 0.05], [0.1, 0.1]])), with(None));
        assert_ne!(with(None), nothing);
    }

    /// At 0.05 rad/s to the left the barcode moves to the right, and in the lower row is 8.4 px farther.
    #[test]
    fn each_row_shows_the_pose_of_its_own_time() {
        let place = place(0.0);
        let image = image(&place, &moving([0.3, 0.0, PI], [-0.02, 0.0, 0.05]), &Shutter::default(), &QUIET);
        for (row, seconds) in [(0, 0.01875), (1, 0.28125)] {
            let at = standing(&place, Pose::new(0.3 - 0.02 * seconds, 0.0, PI + 0.05 * seconds));
            let apart = middle_of_ink(&image[row]) - middle_of_ink(&at[row]);
            // The barcode is 64 px wide and moves by 1.2 px within an exposure.
            assert!(apart.abs() < 0.05, "row {row}: {apart}");
        }
        assert!(middle_of_ink(&image[1]) - middle_of_ink(&image[0]) > 7.0);
    }

    /// 24 px in 37.5 ms: six times the width of a stripe.
    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-14** A row's ink MUST be the mean of RENDER's over poses at the middles of equal parts of the
    //# exposure, as many that no end of a barcode moves by more than 1/4 px from one to the next.
    #[test]
    fn a_fast_turn_smears_what_a_short_exposure_keeps() {
        let place = place(2.0);
        let turning = moving([0.25, 0.0, PI - 0.15], [0.0, 0.0, 1.0]);
        let view = View { place: &place, track: &turning };
        assert!(
            (96..130).contains(&view.poses(0.0, 37_500.0)),
            "a quarter of a pixel at 640 px/s and more off the axis"
        );
        let shutter = Shutter::default();
        assert_eq!(payloads(&place, &image(&place, &turning, &shutter, &QUIET)), [0; 0]);
        // Standing it is read at either row's time, and a short exposure leaves the bars of both rows as they are.
        for seconds in [0.01875, 0.28125] {
            assert_eq!(payloads(&place, &standing(&place, Pose::new(0.25, 0.0, PI - 0.15 + seconds))), [0xcc0d]);
        }
        let short = image(&place, &turning, &Shutter { exposure: 1_000, ..shutter }, &QUIET);
        let darkest = |line: &[u8]| *line.iter().min().unwrap();
        assert!(short.iter().all(|line| darkest(line) < 60));
        assert!(image(&place, &turning, &shutter, &QUIET).iter().all(|line| darkest(line) > 60));
    }

    /// In somebody's hands from the middle of the upper row's exposure on: half of its light is that of a white wall.
    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-15** A robot off the ground MUST see a white wall.
    #[test]
    fn a_lifted_robot_sees_white() {
        let place = place(0.0);
        let mut track = Track::new(Pose::new(0.3, 0.0, PI));
        (1..=48).for_each(|tick| track.push(Pose::new(0.3, 0.0, PI), tick > 3));
        let image = image(&place, &track, &Shutter::default(), &QUIET);
        assert!(image[1].iter().all(|&pixel| pixel == 200));
        // Stripes 4 and 5 of the upper layer, from 220.3 to 226.7 and a pixel of blur.
        assert!(image[0][222..=225].iter().all(|&pixel| pixel == 120), "{:?}", &image[0][218..230]);
        assert!(View { place: &place, track: &track }.seen(0, 300_000).is_empty());
    }

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-16** With a stated probability an image MUST have an obstacle in front of both lines, from 1/16 to 1/2
    //# of the line wide, anywhere before it, of one ink from 0 to 1.
    #[test]
    fn obstacles_stand_before_a_part_of_both_lines_as_often_as_stated() {
        let (place, track) = (place(0.0), moving([0.3, 0.0, PI], [0.0; 3]));
        let view = View { place: &place, track: &track };
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let by = Disturbance { occlusion: 0.3, false_decodes: 0.0 };
        let all: Vec<_> = (0..20_000).filter_map(|_| view.disturb(&by, 0, 300_000, &mut rng).obstacle).collect();
        // Four standard deviations of a binomial of 20,000 at 0.3: 259.
        assert!(all.len().abs_diff(6000) < 259, "{}", all.len());
        assert!(all.iter().all(|thing| thing.right > 0.0 && thing.left < 480.0 && (0.0..=1.0).contains(&thing.ink)));
        assert!(all.iter().all(|thing| (30.0..=240.0).contains(&(thing.right - thing.left))));
        assert!(all.iter().any(|thing| thing.ink < 0.1) && all.iter().any(|thing| thing.ink > 0.9));
        let clear = image(&place, &track, &Shutter::default(), &QUIET);
        let obstacle = Some(Obstacle { left: 220.0, right: 300.25, ink: 0.25 });
        let covered = image(&place, &track, &Shutter::default(), &Disturbed { obstacle, ..QUIET });
        for (clear, covered) in clear.iter().zip(&covered) {
            assert_eq!((&clear[..220], &clear[301..]), (&covered[..220], &covered[301..]));
            // A quarter of 160 below 200; three quarters of the pixel 300 are covered.
            assert!(covered[221..300].iter().all(|&pixel| pixel == 160) && covered[300] == 170);
        }
        assert_eq!(payloads(&place, &covered), [0; 0]);
    }

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-17** With a stated probability a landmark that is seen in an image MUST be drawn there with another
    //# payload that has a code word and stands for a pose of the site's grid (GRID-6).
    #[test]
    fn false_payloads_are_drawn_as_often_as_stated_and_can_be_read() {
        let (mut place, track) = (place(2.0), moving([0.3, 0.0, PI], [0.0; 3]));
        place.grid.theta_steps = Some(12);
        let view = View { place: &place, track: &track };
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let by = Disturbance { occlusion: 0.0, false_decodes: 0.1 };
        let all: Vec<_> = (0..3000).map(|_| view.disturb(&by, 0, 300_000, &mut rng)).collect();
        assert!(all.iter().all(|one| one.obstacle.is_none() && one.seen.len() == 1 && one.seen[0].landmark == 0));
        let wrong: Vec<_> = all.iter().filter(|one| one.seen[0].payload != 0xcc0d).collect();
        // Four standard deviations of a binomial of 3000 at 0.1: 66.
        assert!(wrong.len().abs_diff(300) < 66, "{}", wrong.len());
        for one in wrong.iter().take(40) {
            let payload = one.seen[0].payload;
            assert!(payload & 0xF < 12, "a heading of twelve");
            assert_eq!(payloads(&place, &image(&place, &track, &Shutter::default(), one)), [payload]);
        }
        // What is not all on both lines has its own payload.
        let aside = moving([0.3, 0.0, PI + 0.35], [0.0; 3]);
        let view = View { place: &place, track: &aside };
        let by = Disturbance { occlusion: 0.0, false_decodes: 1.0 };
        assert!(view.disturb(&by, 0, 300_000, &mut rng).seen.is_empty());
    }
}
