//! Where the edges of a barcode lie in the image, and how they move with its homography.

use crate::formats::Column;
use crate::homography::Homography;
use crate::landmark::Format;
use crate::reciprocal::Reciprocal;

/// Edges of the format with the most stripes.
pub const EDGES: usize = 25;

/// An edge in the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProjectedEdge {
    /// Its column in 2^-16 px.
    pub column: i32,
    /// Its derivatives by `a`, `s` and `k`, in 2^-12 and the last one in 2^-12 of [`Projection::reach_bits`].
    pub motion: [i16; 3],
}

/// All edges of a layer, from the left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Projection {
    edges: [ProjectedEdge; EDGES],
    count: usize,
    /// `2^reach_bits` px are farther than any edge from the columns' origin.
    pub reach_bits: u8,
    /// `2^growth_bits` is at least the largest derivative by `a`, 1 to 4, or 6 % less.
    pub growth_bits: u8,
}

impl Projection {
    /// The edges of a homography `x (1 + k t) = a + s t`, `t = v/(N/2)`; `None` unless they go from left to right within
    /// ±2048 px, which asks for `|k| <= 3/4`.
    ///
    /// Rounding errors: of a column, 2^-17 px, 2^-17 px/(N/2) of the numerator and 2^-28 of it in the reciprocal, and
    /// 2^-28/(N/2) · 4 of it in the denominator: less than 2^-15 px within 640 px. Of a derivative 2^-12.
    #[must_use]
    pub fn new(homography: &Homography, format: Format) -> Option<Self> {
        let half = i64::from(format.stripes() / 2);
        let (a, s) = (i64::from(homography.a.to_bits()), i64::from(homography.s.to_bits()));
        let k = i64::from(homography.k.to_bits());
        let mut projection = Self { edges: [ProjectedEdge::default(); EDGES], count: 0, reach_bits: 0, growth_bits: 0 };
        projection.growth_bits = match k.unsigned_abs() {
            0..=0x0400_0000 => 0,           // 1/16
            0x0400_0001..=0x2000_0000 => 1, // 1/2
            _ => 2,
        };
        let mut before = i32::MIN;
        for (edge, v) in projection.edges.iter_mut().zip(-half..=half) {
            let numerator = (a * half + s * v + 8) >> 4; // 16 fraction bits, below 2^32
            let denominator = (half << 27) + ((k * v + 4) >> 3); // 27, below 2^32
            let reciprocal = Reciprocal::of(u32::try_from(denominator).ok()?)?;
            let mantissa = i64::from(reciprocal.mantissa); // 1/(N/2 + k v) is mantissa 2^(zeros - 35)
            let surplus = 35_u32.checked_sub(u32::from(reciprocal.shift))?;
            let column = (numerator * mantissa + (1 << surplus >> 1)) >> surplus;
            edge.column = i32::try_from(column).ok().filter(|column| column.unsigned_abs() < 1 << 27)?;
            if edge.column <= before {
                return None;
            }
            before = edge.column;
            let growth = (half * mantissa) >> surplus.checked_sub(12)?;
            let along = (v * mantissa) >> (surplus - 12);
            edge.motion = [i16::try_from(growth).ok()?, i16::try_from(along).ok()?, 0];
            projection.count += 1;
        }
        projection.add_obliquity();
        Some(projection)
    }

    /// The derivatives by `k`, `-x t/(1 + k t)`.
    fn add_obliquity(&mut self) {
        let farthest = self.edges().iter().map(|edge| edge.column.unsigned_abs()).max().unwrap_or(0);
        let bits = 32 - (farthest >> 16).leading_zeros();
        self.reach_bits = u8::try_from(bits).unwrap_or(0);
        for edge in self.edges.iter_mut().take(self.count) {
            let [_, along, obliquity] = &mut edge.motion;
            let column = (edge.column >> 4) >> bits; // 12 fraction bits of the reach, at most 1
            *obliquity = i16::try_from((-column * i32::from(*along)) >> 12).unwrap_or(0);
        }
    }

    /// The edges.
    #[must_use]
    pub fn edges(&self) -> &[ProjectedEdge] {
        self.edges.get(..self.count).unwrap_or(&[])
    }

    /// The column of an edge from the left in 2^-16 px.
    #[must_use]
    pub fn column(&self, edge: usize) -> Option<i32> {
        self.edges().get(edge).map(|edge| edge.column)
    }
}

/// A homography whose columns count from another one: of `z`, that of `z - origin`, or back with `-origin`.
///
/// `a' = a - origin`, `s' = s - origin k`; rounding error 2^-21 px. `None` outside of the formats.
#[must_use]
pub fn shifted(homography: &Homography, origin: Column) -> Option<Homography> {
    let turned = (i64::from(origin.to_bits()) * i64::from(homography.k.to_bits()) + (1 << 29)) >> 30;
    let s = i64::from(homography.s.to_bits()) - turned;
    Some(Homography {
        a: homography.a.checked_sub(origin)?,
        s: Column::from_bits(i32::try_from(s).ok()?),
        k: homography.k,
    })
}

#[cfg(test)]
mod tests;
