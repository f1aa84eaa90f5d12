//! Where the camera stands, and how well it sees.

use reference::landmark::{Format, Landmark, STRIPE_HEIGHT};

/// Distances from the landmark, centimetres.
const CENTIMETRES: [u32; 5] = [10, 20, 30, 40, 50];

/// Inclinations, degrees.
const DEGREES: [u32; 5] = [0, 15, 30, 45, 60];

/// Distance beyond which the default landmark may leave a row uncovered, centimetres (RANGE-3).
const COVERED_UP_TO: u32 = 45;

/// Stripe height of the tall landmark, metres: RANGE-2 gives 1 m for it.
const TALL: f64 = 2.0 * STRIPE_HEIGHT;

/// Noise in grey levels and blur in pixels (RENDER-2, RENDER-5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Standard deviation of the noise, grey levels.
    pub noise: f64,
    /// Standard deviation of the blur, pixels.
    pub blur: f64,
}

impl Conditions {
    /// The defaults of [`reference::render::Sensor`].
    pub const NOMINAL: Self = Self { noise: 2.0, blur: 0.5 };

    /// Every noise at the nominal blur and every blur at the nominal noise, each once.
    #[must_use]
    pub fn crossed(noises: &[f64], blurs: &[f64]) -> Vec<Self> {
        let mut all: Vec<Self> = noises.iter().map(|&noise| Self { noise, ..Self::NOMINAL }).collect();
        for &blur in blurs {
            let one = Self { blur, ..Self::NOMINAL };
            if !all.contains(&one) {
                all.push(one);
            }
        }
        all
    }
}

/// Whether both rows see nothing but stripes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// They do.
    Inside,
    /// They may not: the default landmark beyond [`RANGE-3`](crate)'s 45 cm.
    PartlyOff,
}

/// A place of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Distance from the barcode's centre, centimetres.
    pub centimetres: u32,
    /// Inclination, degrees.
    pub degrees: u32,
    /// What the rows see.
    pub rows: Rows,
    /// Noise and blur.
    pub conditions: Conditions,
}

impl Point {
    /// The landmark that is looked at.
    #[must_use]
    pub fn landmark(&self) -> Landmark {
        let tall = self.rows == Rows::Inside && self.centimetres > COVERED_UP_TO;
        let stripe_height = if tall { TALL } else { STRIPE_HEIGHT };
        Landmark { stripe_height, ..Landmark::new(Format::Paper) }
    }
}

/// All points of the stated conditions.
#[must_use]
pub fn grid(conditions: &[Conditions]) -> Vec<Point> {
    let mut points = Vec::new();
    for &conditions in conditions {
        for centimetres in CENTIMETRES {
            for degrees in DEGREES {
                points.push(Point { centimetres, degrees, rows: Rows::Inside, conditions });
                if centimetres > COVERED_UP_TO {
                    points.push(Point { centimetres, degrees, rows: Rows::PartlyOff, conditions });
                }
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_crossed_at_the_nominal_ones() {
        let all = Conditions::crossed(&[1.0, 2.0], &[0.3, 0.5]);
        let pairs: Vec<(f64, f64)> = all.iter().map(|c| (c.noise, c.blur)).collect();
        assert_eq!(pairs, [(1.0, 0.5), (2.0, 0.5), (2.0, 0.3)]);
    }

    #[test]
    fn only_beyond_45_cm_a_landmark_is_tall_or_a_row_partly_off() {
        let points = grid(&[Conditions::NOMINAL]);
        assert_eq!(points.len(), 30);
        for point in points {
            let tall = point.landmark().stripe_height > STRIPE_HEIGHT;
            assert_eq!(tall, point.centimetres == 50 && point.rows == Rows::Inside);
            assert!(point.rows == Rows::Inside || point.centimetres == 50);
        }
    }
}
