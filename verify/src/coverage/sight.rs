//! Which landmarks a camera can read (SITE-10, SITE-11).

use crate::site::{Site, Wall};
use reference::camera::Camera;
use reference::frame::{self, Point, Pose, Robot, World};
use reference::range::{MIN_STRIPE_PIXELS, blind_range, narrowest_stripe, scan_line_range};
use reference::render::Posted;

/// Where lines of sight end in front of a landmark's plane, metres: twice what it may be off its wall.
const STAND_OFF: f64 = 2.0 * crate::site::OFF_WALL;

/// Widths of the narrower barcode in the image that HYPO needs between two of them (SITE-11).
const APPARENT_GAP: f64 = 1.5;

/// A camera among walls.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The camera on the robot.
    pub camera_in_robot: Pose<Robot, frame::Camera>,
    /// What hides landmarks.
    pub walls: &'a [Wall],
}

impl<'a> View<'a> {
    /// The view of the site's robot.
    #[must_use]
    pub fn of(site: &'a Site, camera: &'a Camera) -> Self {
        Self { camera, camera_in_robot: site.camera_in_robot, walls: &site.walls }
    }

    /// Whether the robot at a pose could read a landmark if it were the only one (SITE-10).
    //= reference/SPEC.md#site
    //# - **SITE-10** A landmark MUST count as readable from a pose of the robot where the camera is in front of its
    //# wall, all of its edges are in the image at a positive depth of at most RANGE-2's distance at 0°, its narrowest
    //# stripe is at least `L_min` (RANGE-1) wide, and no wall comes between the camera and any part of the barcode, but
    //# for the last 2 mm before it.
    #[must_use]
    pub fn shows(&self, robot_in_world: &Pose<World, Robot>, posted: &Posted) -> bool {
        let camera_in_world = *robot_in_world * self.camera_in_robot;
        let camera_in_landmark = posted.landmark_in_world.inverse() * camera_in_world;
        let landmark = &posted.landmark;
        let half = landmark.half_width();
        let [left, right] = [-half, half].map(|b| self.camera.project_stripe(&camera_in_landmark, b));
        let far = scan_line_range(self.camera, landmark, 0.0);
        let in_image = |column: f64| (-0.5..=self.camera.width as f64 - 0.5).contains(&column);
        // Both ends decide for all edges: depth and column are monotonic along the barcode.
        camera_in_landmark.x() > 0.0
            && [left, right].iter().all(|end| end.depth > 0.0 && end.depth <= far && in_image(end.column))
            && narrowest_stripe(self.camera, landmark, &camera_in_landmark) >= MIN_STRIPE_PIXELS
            && !self.walls.iter().any(|wall| {
                let [left, right] = ends(posted);
                wall.hides([camera_in_world.x(), camera_in_world.y()], left, right)
            })
    }

    /// The numbers of the landmarks that the robot at a pose can read, with regard to each other (SITE-11).
    #[must_use]
    pub fn readable(&self, robot_in_world: &Pose<World, Robot>, landmarks: &[Posted]) -> Vec<usize> {
        let shown = self.shown(robot_in_world, landmarks);
        let alone = |&i: &usize| {
            !landmarks.iter().enumerate().any(|(k, other)| k != i && self.crowds(robot_in_world, other, &landmarks[i]))
        };
        shown.into_iter().filter(alone).collect()
    }

    /// The numbers of the landmarks that could be read alone (SITE-10).
    pub(crate) fn shown(&self, robot_in_world: &Pose<World, Robot>, landmarks: &[Posted]) -> Vec<usize> {
        (0..landmarks.len()).filter(|&i| self.shows(robot_in_world, &landmarks[i])).collect()
    }

    /// Whether `other` stands too near to `posted` in the image for the detector to tell them apart (SITE-11).
    //= reference/SPEC.md#site
    //# - **SITE-11** A landmark MUST NOT count as readable where another one that darkens the image is nearer to it
    //# there than 1.5 times the narrower of both barcodes.
    #[must_use]
    pub(crate) fn crowds(&self, robot_in_world: &Pose<World, Robot>, other: &Posted, posted: &Posted) -> bool {
        let [Some([a_left, a_right]), Some([b_left, b_right])] =
            [posted, other].map(|one| self.ink(robot_in_world, one))
        else {
            return false;
        };
        let gap = (b_left - a_right).max(a_left - b_right);
        gap < APPARENT_GAP * (a_right - a_left).min(b_right - b_left)
    }

    /// First and last column of a landmark that darkens the image, wholly or in part.
    fn ink(&self, robot_in_world: &Pose<World, Robot>, posted: &Posted) -> Option<[f64; 2]> {
        let camera_in_world = *robot_in_world * self.camera_in_robot;
        let camera_in_landmark = posted.landmark_in_world.inverse() * camera_in_world;
        let half = posted.landmark.half_width();
        let [left, right] = [-half, half].map(|b| self.camera.project_stripe(&camera_in_landmark, b));
        let near = left.depth.min(right.depth);
        let eye = [camera_in_world.x(), camera_in_world.y()];
        let [left_end, right_end] = ends(posted);
        let drawn = camera_in_landmark.x() > 0.0
            && near > 0.0
            && near < blind_range(self.camera, &posted.landmark)
            && right.column > -0.5
            && left.column < self.camera.width as f64 - 0.5
            // Hidden from end to end by one wall; one that is partly hidden still darkens the line.
            && !self.walls.iter().any(|w| w.hides(eye, left_end, left_end) && w.hides(eye, right_end, right_end));
        drawn.then_some([left.column, right.column])
    }
}

/// Where the lines of sight to a barcode's left and right end stop, in world.
fn ends(posted: &Posted) -> [[f64; 2]; 2] {
    let half = posted.landmark.half_width();
    [-half, half].map(|b| {
        let point = posted.landmark_in_world.place(&Point::new(STAND_OFF, b));
        [point.x, point.y]
    })
}
