//! Outlines of stripes: black that touches becomes one polygon, so that no edge runs through it (PRINT-4).

use super::page::{Outline, Point};

/// An upright rectangle; millimetres, y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// x of the left edge.
    pub left: f64,
    /// x of the right edge.
    pub right: f64,
    /// y of the upper edge.
    pub top: f64,
    /// y of the lower edge, larger than `top`.
    pub bottom: f64,
}

impl Column {
    /// Whether `next` begins where this one ends and shares a piece of edge with it.
    #[expect(clippy::float_cmp, reason = "neighbours are made of the same edge")]
    fn touches(&self, next: &Self) -> bool {
        self.right == next.left && self.top.max(next.top) < self.bottom.min(next.bottom)
    }
}

/// The outlines of columns that do not overlap, from left to right: one for every part that holds together.
//= reference/SPEC.md#print
//# - **PRINT-4** Bars that touch along an edge, in one layer or across both, MUST be one outline, so that no light line
//# runs through them whatever the resolution.
#[must_use]
pub fn outlines(columns: &[Column]) -> Vec<Outline> {
    columns.chunk_by(Column::touches).map(around).collect()
}

/// Along the upper edges to the right and along the lower ones back.
fn around(columns: &[Column]) -> Outline {
    let upper = stairs(columns.iter().map(|column| ([column.left, column.top], [column.right, column.top])));
    let lower =
        stairs(columns.iter().rev().map(|column| ([column.right, column.bottom], [column.left, column.bottom])));
    [upper, lower].concat()
}

/// Level edges as one line, those of the same height that follow each other as one edge.
fn stairs(edges: impl Iterator<Item = (Point, Point)>) -> Vec<Point> {
    let mut line: Vec<Point> = Vec::new();
    for (from, to) in edges {
        match line.last_mut() {
            Some(last) if last[1].to_bits() == from[1].to_bits() => *last = to,
            _ => line.extend([from, to]),
        }
    }
    line
}

/// The columns of a landmark's black, one for each stripe that has any, from left to right.
///
/// `edges` are the stripes' edges from left to right, one more than stripes; `layers` their colours, true for a bar, the
/// upper layer first; `middle` is the line between the layers, `height` the height of one layer (LAND-4).
#[must_use]
pub fn bars(edges: &[f64], layers: &[Vec<bool>; 2], middle: f64, height: f64) -> Vec<Column> {
    let stripes = edges.windows(2).zip(layers[0].iter().zip(&layers[1]));
    stripes
        .filter(|(_, (upper, lower))| **upper || **lower)
        .map(|(edges, (&upper, &lower))| Column {
            left: edges[0],
            right: edges[1],
            top: if upper { middle - height } else { middle },
            bottom: if lower { middle + height } else { middle },
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(upper: &[u8], lower: &[u8]) -> Vec<Outline> {
        let layer = |bits: &[u8]| bits.iter().map(|&bit| bit == 1).collect();
        let edges: Vec<f64> = (0..=upper.len()).map(|k| k as f64).collect();
        outlines(&bars(&edges, &[layer(upper), layer(lower)], 0.0, 2.0))
    }

    #[test]
    fn bars_of_both_layers_that_touch_are_one_outline() {
        assert_eq!(drawn(&[1], &[1]), [vec![[0.0, -2.0], [1.0, -2.0], [1.0, 2.0], [0.0, 2.0]]]);
        assert_eq!(drawn(&[1, 1, 0], &[0, 0, 0]), [vec![[0.0, -2.0], [2.0, -2.0], [2.0, 0.0], [0.0, 0.0]]]);
        // An upper bar over a lower one that is shifted by a stripe.
        let shifted =
            vec![[0.0, -2.0], [2.0, -2.0], [2.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.0, 2.0], [1.0, 0.0], [0.0, 0.0]];
        assert_eq!(drawn(&[1, 1, 0], &[0, 1, 1]), [shifted]);
    }

    #[test]
    fn what_touches_in_a_corner_or_not_at_all_stays_apart() {
        assert_eq!(drawn(&[1, 0], &[0, 1]).len(), 2);
        assert_eq!(drawn(&[1, 0, 1], &[1, 0, 1]).len(), 2);
        assert_eq!(drawn(&[0, 0], &[0, 0]).len(), 0);
    }

    /// Shoelace: the outlines' area is that of the bars.
    #[test]
    fn no_ink_is_lost() {
        for bits in 0..256_u32 {
            let [upper, lower] = [bits, bits >> 4].map(|word| [0, 1, 2, 3].map(|bit| u8::from(word >> bit & 1 == 1)));
            let area: f64 = drawn(&upper, &lower).iter().map(|outline| shoelace(outline)).sum();
            assert!((area - 2.0 * f64::from(bits.count_ones())).abs() < 1e-12, "{upper:?} {lower:?}");
        }
    }

    fn shoelace(outline: &[Point]) -> f64 {
        let next = outline.iter().cycle().skip(1);
        outline.iter().zip(next).map(|(a, b)| (a[0] * b[1] - b[0] * a[1]) / 2.0).sum()
    }
}
