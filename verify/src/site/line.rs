//! Walls as segments, and what a segment crosses.

/// A wall: a segment without thickness that hides what is behind it from either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// World coordinates of its beginning, metres.
    pub from: [f64; 2],
    /// World coordinates of its end, metres, at least 1 mm from its beginning.
    pub to: [f64; 2],
    /// Whether landmarks can hang on, and be seen on, the side at the left of its direction.
    pub left: bool,
    /// The same for the right side.
    pub right: bool,
}

impl Wall {
    /// Length, metres.
    #[must_use]
    pub fn length(&self) -> f64 {
        (self.to[0] - self.from[0]).hypot(self.to[1] - self.from[1])
    }

    /// Unit vector along it.
    #[must_use]
    pub fn direction(&self) -> [f64; 2] {
        let length = self.length();
        [(self.to[0] - self.from[0]) / length, (self.to[1] - self.from[1]) / length]
    }

    /// Headings out of its visible faces, in world, radians.
    pub fn normals(&self) -> impl Iterator<Item = f64> {
        let [x, y] = self.direction();
        let left = self.left.then(|| x.atan2(-y));
        let right = self.right.then(|| (-x).atan2(y));
        left.into_iter().chain(right)
    }

    /// How far a point (metres) is along the wall from its beginning, and how far to the left of it.
    #[must_use]
    pub fn coordinates(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([dx, dy], x, y) = (self.direction(), x - self.from[0], y - self.from[1]);
        [x * dx + y * dy, y * dx - x * dy]
    }

    /// Whether the wall hides a part of the segment from `eye` to the segment from `left` to `right`, that is: comes into
    /// their triangle.
    #[must_use]
    pub fn hides(&self, eye: [f64; 2], left: [f64; 2], right: [f64; 2]) -> bool {
        let wall = [self.from, self.to];
        // A segment comes into a triangle by two of its sides, one of them from the eye, or ends in it.
        crosses([eye, left], wall)
            || crosses([eye, right], wall)
            || wall.iter().any(|&end| inside(end, [eye, left, right]))
    }
}

/// Twice the area of the triangle, positive where it is counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two segments have a point in common; collinear ones that touch end to end are left to [`inside`].
fn crosses([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let sides = |p, q, r, s| turn(p, q, r) * turn(p, q, s) <= 0.0;
    let degenerate = turn(a, b, c) == 0.0 && turn(a, b, d) == 0.0;
    !degenerate && sides(a, b, c, d) && sides(c, d, a, b)
}

/// Whether a triangle has the point in it or on its border.
fn inside(point: [f64; 2], [a, b, c]: [[f64; 2]; 3]) -> bool {
    let turns = [turn(a, b, point), turn(b, c, point), turn(c, a, point)];
    turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0)
}

/// The sides of a ring of points.
pub(crate) fn sides(ring: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPRIGHT: Wall = Wall { from: [1.0, -1.0], to: [1.0, 1.0], left: true, right: false };

    #[test]
    fn the_left_of_an_upright_wall_is_west() {
        // It runs north, so its left face looks west (π) and a point at x = 0 is 1 m to the left, 1 m along.
        assert!((UPRIGHT.normals().next().unwrap() - core::f64::consts::PI).abs() < 1e-12);
        let [along, left] = UPRIGHT.coordinates([0.0, 0.0]);
        assert!((along - 1.0).abs() < 1e-12 && (left - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_wall_hides_what_is_behind_all_of_it_or_a_part() {
        let eye = [0.0, 0.0];
        assert!(UPRIGHT.hides(eye, [2.0, 0.1], [2.0, -0.1]));
        assert!(!UPRIGHT.hides(eye, [0.5, 0.1], [0.5, -0.1]));
        // A post between the two lines of sight, and one that ends between them.
        let post = Wall { from: [1.0, -0.01], to: [1.0, 0.01], ..UPRIGHT };
        assert!(post.hides(eye, [2.0, 0.1], [2.0, -0.1]));
        let half = Wall { from: [1.0, 0.0], to: [1.0, 3.0], ..UPRIGHT };
        assert!(half.hides(eye, [2.0, 0.1], [2.0, -0.1]) && !half.hides(eye, [2.0, -0.1], [2.0, -0.3]));
        // In line with the sight.
        let along = Wall { from: [0.5, 0.0], to: [1.5, 0.0], ..UPRIGHT };
        assert!(along.hides(eye, [2.0, 0.0], [2.0, -0.1]));
        assert!(!along.hides(eye, [2.0, 0.2], [2.0, 0.1]));
    }
}
