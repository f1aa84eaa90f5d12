//! What the camera has in front of it (WORLD-10 to WORLD-12).

use super::Place;
use crate::frame::{self, Point, Pose, World};
use crate::range::blind_range;
use crate::render::Posted;

/// Where lines of sight end in front of a landmark's plane, metres: its own wall may be that far out of place.
const STAND_OFF: f64 = 2e-3;

/// A wall, as a segment without thickness that hides what is behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// One end.
    pub from: Point<World>,
    /// The other one.
    pub to: Point<World>,
}

impl Wall {
    /// Whether the wall comes into a triangle, that of the camera and a barcode's ends, or touches it.
    ///
    /// Two convex figures have no point in common just where a side of one of them parts them: a side of the triangle
    /// has all of the wall beyond it, or the wall's line all of the triangle on one side.
    #[must_use]
    pub fn hides(&self, [a, b, c]: [Point<World>; 3]) -> bool {
        let beyond = |from: Point<World>, to: Point<World>, corner: Point<World>| {
            let inside = area(from, to, corner);
            [self.from, self.to].iter().all(|&end| area(from, to, end) * inside < 0.0)
        };
        let corners = [a, b, c].map(|corner| area(self.from, self.to, corner));
        let on_one_side = corners.iter().all(|&s| s > 0.0) || corners.iter().all(|&s| s < 0.0);
        !(on_one_side || beyond(a, b, c) || beyond(b, c, a) || beyond(c, a, b))
    }
}

/// Twice the area of a triangle, m², positive where it is counter-clockwise.
fn area(a: Point<World>, b: Point<World>, c: Point<World>) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Columns of a barcode's ends, left and right, in the image of a camera that has it in front of it.
pub(super) type Ends = [f64; 2];

/// The barcode's ends as a camera sees them, if it is in sight (WORLD-11): in front, with ink in the rows' reach, on the
/// image or so near to it that its blur is, and behind no wall.
//= reference/SPEC.md#world
//# - **WORLD-11** Only landmarks that are not hidden MUST be given to the renderer (RENDER-8), whole.
pub(super) fn ends(place: &Place, camera: &Pose<World, frame::Camera>, posted: &Posted) -> Option<Ends> {
    let camera_in_landmark = posted.landmark_in_world.inverse() * *camera;
    let half = posted.landmark.half_width();
    let [left, right] = [-half, half].map(|b| place.camera.project_stripe(&camera_in_landmark, b));
    let near = left.depth.min(right.depth);
    // As far as the renderer draws an edge, and a pixel.
    let margin = 6.0 * place.sensor.blur + 2.0;
    let on_image = right.column > -margin && left.column < place.camera.width as f64 - 1.0 + margin;
    let in_front = camera_in_landmark.x() > 0.0 && near > 0.0 && near < blind_range(&place.camera, &posted.landmark);
    (in_front && on_image && !hidden(place, camera, posted)).then_some([left.column, right.column])
}

/// Whether a wall comes between the camera and any part of a barcode (WORLD-10).
//= reference/SPEC.md#world
//# - **WORLD-10** A landmark MUST be hidden where a wall comes into the triangle between the camera and the ends of the
//# barcode, but for the last 2 mm before it.
fn hidden(place: &Place, camera: &Pose<World, frame::Camera>, posted: &Posted) -> bool {
    let half = posted.landmark.half_width();
    let [left, right] = [-half, half].map(|b| posted.landmark_in_world.place(&Point::new(STAND_OFF, b)));
    place.walls.iter().any(|wall| wall.hides([Point::new(camera.x(), camera.y()), left, right]))
}

/// Whether all of a barcode is in sight and on the image (WORLD-12).
//= reference/SPEC.md#world
//# - **WORLD-12** A landmark MUST count as *seen* in an image if in the middle of the exposures of both scan lines it
//# is not hidden, nearer than RANGE-4's distance, and has all of its barcode in the image.
pub(super) fn whole(place: &Place, camera: &Pose<World, frame::Camera>, posted: &Posted) -> bool {
    let on_image = |column: &f64| (-0.5..=place.camera.width as f64 - 0.5).contains(column);
    ends(place, camera, posted).is_some_and(|ends| ends.iter().all(on_image))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark::{Format, Landmark};
    use core::f64::consts::PI;
    use proptest::prelude::*;

    fn wall(from: [f64; 2], to: [f64; 2]) -> Wall {
        Wall { from: Point::new(from[0], from[1]), to: Point::new(to[0], to[1]) }
    }

    /// A landmark at the origin that looks along x, on a wall along y, and other walls.
    fn place(walls: &[Wall]) -> (Place, Posted) {
        let landmark = Landmark::new(Format::Paper);
        let posted = Posted { landmark_in_world: Pose::new(0.0, 0.0, 0.0), landmark, payload: 0xcc0d };
        let walls = [&[wall([0.0, -1.0], [0.0, 1.0])], walls].concat();
        (Place { walls, landmarks: vec![posted], ..Place::default() }, posted)
    }

    fn in_sight(walls: &[Wall], camera: [f64; 3]) -> bool {
        let (place, posted) = place(walls);
        ends(&place, &Pose::new(camera[0], camera[1], camera[2]), &posted).is_some()
    }

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-10** A landmark MUST be hidden where a wall comes into the triangle between the camera and the ends of
    //# the barcode, but for the last 2 mm before it.
    #[test]
    fn walls_hide_what_is_behind_them() {
        let ahead = [0.3, 0.0, PI];
        assert!(in_sight(&[], ahead), "its own wall does not hide it");
        assert!(!in_sight(&[wall([0.1, -1.0], [0.1, 1.0])], ahead));
        // Up to the middle, which leaves one end free; a post between the lines of sight; one in line with the eye.
        assert!(!in_sight(&[wall([0.1, 0.0], [0.1, 1.0])], ahead));
        assert!(!in_sight(&[wall([0.1, -0.001], [0.1, 0.001])], ahead));
        assert!(!in_sight(&[wall([0.1, 0.0], [0.2, 0.0])], ahead));
        // Behind the camera, behind the landmark, beside the lines of sight.
        assert!(in_sight(&[wall([0.4, -1.0], [0.4, 1.0]), wall([-0.1, -1.0], [-0.1, 1.0])], ahead));
        assert!(in_sight(&[wall([0.15, 0.02], [0.15, 1.0]), wall([0.0, 0.05], [1.0, 0.05])], ahead));
    }

    //= reference/SPEC.md#world
    //= type=test
    //# - **WORLD-12** A landmark MUST count as *seen* in an image if in the middle of the exposures of both scan lines
    //# it is not hidden, nearer than RANGE-4's distance, and has all of its barcode in the image.
    #[test]
    fn what_is_seen_from_behind_or_beside_the_image_is_not_in_sight() {
        assert!(!in_sight(&[], [-0.3, 0.0, 0.0]) && !in_sight(&[], [0.3, 0.0, 0.0]));
        // RANGE-4: from 66.7 cm on neither row sees anything.
        assert!(in_sight(&[], [0.66, 0.0, PI]) && !in_sight(&[], [0.67, 0.0, PI]));
        // Half the image is atan(240/640) = 0.359 rad wide, half the barcode 0.05 rad.
        assert!(in_sight(&[], [0.3, 0.0, PI + 0.40]) && !in_sight(&[], [0.3, 0.0, PI + 0.42]));
        let (place, posted) = place(&[]);
        let all = |turned: f64| whole(&place, &Pose::new(0.3, 0.0, PI + turned), &posted);
        assert!(all(0.0) && all(0.30) && all(-0.30) && !all(0.32) && !all(-0.32));
    }

    proptest! {
        /// A wall hides a triangle just where one of many points along it lies inside, but for walls that barely touch it.
        #[test]
        fn a_wall_hides_where_it_comes_into_the_triangle(
            x in prop::array::uniform5(-1.0..1.0f64), y in prop::array::uniform5(-1.0..1.0f64),
        ) {
            let corners = [0, 1, 2].map(|i| Point::new(x[i], y[i]));
            let wall = wall([x[3], y[3]], [x[4], y[4]]);
            let [a, b, c] = corners;
            let depth = |part: f64| {
                let p = Point::new(x[3] + part * (x[4] - x[3]), y[3] + part * (y[4] - y[3]));
                let turns = [area(a, b, p), area(b, c, p), area(c, a, p)].map(|turn| turn * area(a, b, c).signum());
                turns.into_iter().fold(f64::INFINITY, f64::min)
            };
            let deepest = (0..=1000).map(|i| depth(f64::from(i) / 1000.0)).fold(f64::NEG_INFINITY, f64::max);
            if deepest > 1e-9 {
                prop_assert!(wall.hides(corners));
            } else if deepest < -0.02 {
                prop_assert!(!wall.hides(corners));
            }
        }
    }
}
