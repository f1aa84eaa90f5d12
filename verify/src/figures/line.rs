//! Straight lines by least squares, the paper's "mean squares".

use serde::Serialize;

/// `y = slope x + intercept`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Units of y per unit of x.
    pub slope: f64,
    /// y at x = 0.
    pub intercept: f64,
    /// Share of the variance of y that the line explains; 1 where y does not vary.
    pub r_squared: f64,
}

impl Line {
    /// The line through at least three points with at least two different x, all of the same weight.
    #[must_use]
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / count;
        let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / count;
        let sum =
            |product: fn(f64, f64) -> f64| points.iter().map(|(x, y)| product(x - mean_x, y - mean_y)).sum::<f64>();
        let (xx, xy, yy) = (sum(|x, _| x * x), sum(|x, y| x * y), sum(|_, y| y * y));
        // NaN is not greater than 0 and gives none.
        if points.len() < 3 || xx.partial_cmp(&0.0) != Some(core::cmp::Ordering::Greater) {
            return None;
        }
        let slope = xy / xx;
        let r_squared = if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 };
        Some(Self { slope, intercept: mean_y - slope * mean_x, r_squared })
    }

    /// y at `x`.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        self.slope * x + self.intercept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: means 1 and 2, sums 2, 3 and 14/3 of squares.
    #[test]
    fn three_points_have_their_line() {
        let line = Line::through(&[(0.0, 1.0), (1.0, 1.0), (2.0, 4.0)]).unwrap();
        assert!((line.slope - 1.5).abs() < 1e-12 && (line.intercept - 0.5).abs() < 1e-12);
        assert!((line.r_squared - 9.0 / 12.0).abs() < 1e-12 && (line.at(3.0) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_determine_a_line_has_none() {
        assert_eq!(Line::through(&[]), None);
        assert_eq!(Line::through(&[(0.0, 1.0), (1.0, 1.0)]), None);
        assert_eq!(Line::through(&[(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(Line::through(&[(1.0, 1.0), (f64::NAN, 2.0), (1.0, 3.0)]), None);
    }
}
