//! One pass over the pixels of a layer: the ink of each, and how it changes.
//!
//! Edges enter from the right and leave to the left as the sweep goes on, so a pixel is worked on with the few edges
//! within reach of it, and a boundary between two pixels is looked up once for both.

use crate::edge::{Blur, Boundary};
use crate::landmark::Format;
use crate::projection::{EDGES, Projection};

/// The ink of a pixel and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InkedPixel {
    /// `c_i` in 2^-16.
    pub ink: i32,
    /// Whether an edge is within reach; without one the derivatives are 0.
    pub active: bool,
    /// The derivatives by `a`, `s` and `k` in 2^-24, the last as [`crate::projection::ProjectedEdge::motion`]'s.
    pub motion: [i32; 3],
    /// The derivative by σ in 2^-16.
    pub spread: i32,
}

/// An edge between stripes of different colours, while it is within reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Passing {
    column: i32,
    motion: [i16; 3],
    left: Boundary,
}

/// The pixels of a layer from left to right.
#[derive(Clone, Debug)]
pub struct Sweep {
    edges: [Passing; EDGES],
    count: usize,
    /// Edges that have been passed, and those that have come within reach.
    passed: usize,
    reached: usize,
    blur: Blur,
    /// The right boundary of the last pixel in 2^-16 px.
    boundary: i32,
}

impl Sweep {
    /// The pixels from `first` on, counted from the projection's origin, of a layer with the given stripes: bit
    /// `N - 1 - j` is 1 where stripe `j` is a bar.
    #[must_use]
    pub fn new(projection: &Projection, stripes: u32, format: Format, blur: &Blur, first: i32) -> Self {
        let start = (first << 16) - (1 << 15);
        let mut edges = [Passing::default(); EDGES];
        let mut count = 0;
        // Bit N - j of the changes is edge j: white surrounds the layer.
        let changes = stripes ^ (stripes << 1);
        for (j, edge) in (0..=u32::from(format.stripes())).zip(projection.edges()) {
            if changes >> (u32::from(format.stripes()) - j) & 1 == 1
                && let Some(place) = edges.get_mut(count)
            {
                // The first pixel may lie within reach.
                let left = blur.boundary(start - edge.column);
                *place = Passing { column: edge.column, motion: edge.motion, left };
                count += 1;
            }
        }
        Self { edges, count, passed: 0, reached: 0, blur: *blur, boundary: start }
    }

    /// The next pixel. Edges alternate, from white to black first, and an edge's sign is that of its place.
    ///
    /// Errors: of the ink, two of [`Blur::boundary`]'s for each edge within reach; of the derivatives, besides theirs,
    /// 2^-12 from the derivatives' dropped bits.
    #[must_use]
    pub fn pixel(&mut self) -> InkedPixel {
        self.boundary += 1 << 16;
        let reach = self.blur.reach();
        let coming = self.edges.get(self.reached..self.count).unwrap_or(&[]);
        self.reached += coming.iter().take_while(|edge| self.boundary - edge.column > -reach).count();
        let mut pixel = InkedPixel { ink: i32::from(self.passed % 2 == 1) << 16, ..InkedPixel::default() };
        let start = self.passed;
        let within = self.edges.get_mut(start..self.reached).unwrap_or(&mut []);
        for (place, edge) in (start..).zip(within) {
            let t = self.boundary - edge.column;
            let right = self.blur.boundary(t);
            let sign = if place % 2 == 0 { 1 } else { -1 };
            pixel.active = true;
            pixel.ink += sign * (right.ink - edge.left.ink);
            // To the right of the edge is to the left of the pixel: columns count with the opposite sign.
            let weight = sign * ((edge.left.distribution - right.distribution) >> 4);
            for (sum, motion) in pixel.motion.iter_mut().zip(edge.motion) {
                *sum += weight * i32::from(motion);
            }
            pixel.spread += sign * (right.density - edge.left.density);
            edge.left = right;
            if t >= reach {
                self.passed += 1;
            }
        }
        pixel
    }
}
