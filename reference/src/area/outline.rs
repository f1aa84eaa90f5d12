//! The boundary of a detection area, and its content.
//!
//! In the coordinates [`Place`] the area is the part of a triangle that a parabola leaves: (3) and (4) are two lines
//! through an apex, (6) is a line of constant depth, and (5) is a parabola whose axis lies along a constant depth as well.

use super::{Area, Place};

/// No point of the boundary is farther than this from the outline, metres.
const TOLERANCE: f64 = 1e-6;

/// A piece of the boundary from one place to the next.
#[derive(Clone, Copy, Debug)]
enum Piece {
    /// Straight, along (3), (4) or (6).
    Line,
    /// Along the parabola (5), which at the share `τ` of its depths lies `τ (1 - τ)` times this beside its chord, in `v`.
    Parabola(f64),
}

/// A corner of the boundary and the piece that begins there.
#[derive(Clone, Copy, Debug)]
struct Corner {
    place: Place,
    piece: Piece,
}

impl Place {
    /// The place at the share `share` of the way to `other`.
    fn towards(&self, other: &Self, share: f64) -> Self {
        let between = |a: f64, b: f64| a + share * (b - a);
        Self { depth: between(self.depth, other.depth), lateral: between(self.lateral, other.lateral) }
    }

    /// Twice the area of the triangle with the origin and `other`, positive if that lies counter-clockwise, m².
    fn cross(&self, other: &Self) -> f64 {
        self.depth * other.lateral - self.lateral * other.depth
    }
}

impl Area {
    /// The boundary as a polygon, counter-clockwise seen from above, in L and metres, not repeating its first point;
    /// empty where the area is. Straight pieces have their ends alone, the parabola so many points that the polygon
    /// departs from it by at most 1 µm.
    #[must_use]
    pub fn outline(&self) -> Vec<(f64, f64)> {
        let corners = self.corners();
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).flat_map(|(corner, next)| self.points(corner, &next.place)).collect()
    }

    /// The content, m².
    ///
    /// That of the corners' polygon, and for every arc of (5) between two depths `Δu` apart the segment
    /// `|Δu|³/(6 |sin θ| f X_dim/L_min)` beyond its chord, which is Archimedes' two thirds of base times height.
    #[must_use]
    pub fn area(&self) -> f64 {
        let corners = self.corners();
        let next = corners.iter().cycle().skip(1);
        let pieces = corners.iter().zip(next).map(|(corner, next)| {
            let segment = match corner.piece {
                Piece::Line => 0.0,
                Piece::Parabola(bulge) => (bulge * (next.place.depth - corner.place.depth)).abs() / 6.0,
            };
            corner.place.cross(&next.place) / 2.0 + segment
        });
        // Not `sum`, which makes -0 of nothing.
        pieces.fold(0.0, |whole, piece| whole + piece)
    }

    /// The points of one piece in L, its end not among them.
    fn points(&self, from: &Corner, to: &Place) -> Vec<(f64, f64)> {
        let bulge = match from.piece {
            Piece::Line => 0.0,
            Piece::Parabola(bulge) => bulge,
        };
        // An n-th of a parabola departs from its chord by 1/n² of what the whole one does: a quarter of `bulge`.
        let count = (bulge.abs() / 4.0 / TOLERANCE).sqrt().ceil().max(1.0);
        let shares = (0..).map(|i| f64::from(i) / count).take_while(|&share| share < 1.0);
        let place = |share: f64| {
            let chord = from.place.towards(to, share);
            Place { lateral: chord.lateral + bulge * share * (1.0 - share), ..chord }
        };
        shares.map(|share| self.in_landmark(&place(share))).collect()
    }

    /// A place in L.
    fn in_landmark(&self, place: &Place) -> (f64, f64) {
        let Place { depth, lateral } = *place;
        (depth * self.cosine - lateral * self.sine, depth * self.sine + lateral * self.cosine)
    }

    /// The corners of the boundary, counter-clockwise: what the parabola leaves of the polygon's edges, joined by arcs.
    fn corners(&self) -> Vec<Corner> {
        let polygon = self.polygon();
        let next = polygon.iter().cycle().skip(1);
        let mut corners: Vec<Corner> = Vec::new();
        for (from, to) in polygon.iter().zip(next) {
            let Some((enter, leave)) = self.wide_enough(from, to) else { continue };
            corners.push(Corner { place: from.towards(to, enter), piece: Piece::Line });
            if leave < 1.0 {
                // Whatever edge comes next begins on the parabola as well; the arc is known when that is.
                corners.push(Corner { place: from.towards(to, leave), piece: Piece::Parabola(0.0) });
            }
        }
        self.bend(&mut corners);
        corners
    }

    /// Gives every arc its bulge.
    ///
    /// On (5) `v sin θ = u cos θ - (u + α)(u + β)/k`, so between two depths `Δu` apart it bulges by
    /// `τ (1 - τ) Δu²/(k sin θ)` in `v`. At 0° it is the line `u = k`.
    fn bend(&self, corners: &mut [Corner]) {
        for i in 0..corners.len() {
            let across = corners[(i + 1) % corners.len()].place.depth - corners[i].place.depth;
            if let Piece::Parabola(bulge) = &mut corners[i].piece
                && across.abs() > 0.0
                && self.sine.abs() > 0.0
            {
                *bulge = across * across / (self.magnification() * self.sine);
            }
        }
    }

    /// What (3), (4), (6) and the depths leave: a triangle, or a quadrangle where the edges' depths bound it; counter-
    /// clockwise, empty if nothing is left.
    fn polygon(&self) -> Vec<Place> {
        let (begin, end) = (self.apex().max(self.far_end()), self.greatest_depth());
        if begin >= end {
            return Vec::new();
        }
        let corner = |depth: f64, lateral: f64| Place { depth, lateral };
        let ((near_right, near_left), (far_right, far_left)) = (self.lateral_bounds(begin), self.lateral_bounds(end));
        let mut polygon = vec![corner(begin, near_right), corner(end, far_right), corner(end, far_left)];
        if begin > self.apex() {
            polygon.push(corner(begin, near_left));
        }
        polygon
    }

    /// The depth from which on there are places with the whole barcode in view: where the lines (3) and (4) meet.
    fn apex(&self) -> f64 {
        let (left, right) = self.field_of_view();
        self.landmark.half_width() * (2.0 * self.cosine + self.sine * (left + right)) / (right - left)
    }

    /// Between which shares of the way from one place to another no stripe is narrower than `L_min`, if there are any.
    fn wide_enough(&self, from: &Place, to: &Place) -> Option<(f64, f64)> {
        // `narrowness` is quadratic in the depth and linear in the lateral place: a convex parabola along the way.
        let at = |share: f64| self.narrowness(&from.towards(to, share));
        let curvature = (to.depth - from.depth).powi(2);
        let (start, slope) = (at(0.0), at(1.0) - at(0.0) - curvature);
        let (enter, leave) = roots(curvature, slope, start)?;
        let (enter, leave) = (enter.max(0.0), leave.min(1.0));
        (enter < leave).then_some((enter, leave))
    }
}

/// Between which arguments `a t² + b t + c` is at most 0, for `a >= 0`, if anywhere.
fn roots(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    // The sum of two numbers of one sign loses nothing; with a = 0 one of the quotients is infinite.
    let sum = -f64::midpoint(b, discriminant.sqrt().copysign(b));
    let (one, other) = (sum / a, c / sum);
    if a > 0.0 && sum.abs() > 0.0 {
        Some((one.min(other), one.max(other)))
    } else if b.abs() > 0.0 {
        let root = -c / b;
        Some(if b > 0.0 { (f64::NEG_INFINITY, root) } else { (root, f64::INFINITY) })
    } else {
        (c <= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY))
    }
}
