//! How far a landmark is found, simulated and predicted by (5) and (6).

use reference::camera::Camera;
use reference::landmark::{Format, Landmark};
use reference::range::stripe_width_range;
use reference::render::Light;
use reference::threshold::MIN_RANGE;
use serde::Serialize;

/// Which part of a row must see stripes: readings of (6).
///
/// The upper row of `Q_y` lies between `Q_y/2 - 1` and `Q_y/2` rows above the axis. At the depth `D` a row `q` rows above
/// the axis sees the height `q D/f_y` and leaves a layer, `h/2` high, at `D = h f_y/(2 q)`. A pixel integrates over the
/// row: of its height the share `σ = h f_y/(2 D) - (Q_y/2 - 1)` sees stripes, so that the share is σ at
/// `D = h f_y/(Q_y - 2 + 2 σ)`: 1 at the outermost part's depth, 1/2 at the middle's and 0 at the innermost part's. The far end of the barcode is `N X_dim |sin θ|/2` deeper than its centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RowReading {
    /// (6) as it is printed (RANGE-2): the whole row sees stripes, `h f_y/Q_y`.
    WholeRow,
    /// Half of it does, `h f_y/(Q_y - 1)`.
    HalfRow,
    /// As much of it as THRESH-4's 24 grey levels are of the 160 between white and black in the default light.
    Contrast,
    /// Some of it does, `h f_y/(Q_y - 2)` (RANGE-4).
    AnyRow,
}

impl RowReading {
    /// All of them, the paper's first.
    pub const ALL: [Self; 4] = [Self::WholeRow, Self::HalfRow, Self::Contrast, Self::AnyRow];

    /// In a table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WholeRow => "as printed: all of the row",
            Self::HalfRow => "the row's middle: half of it",
            Self::Contrast => "THRESH-4: 0.15 of the row",
            Self::AnyRow => "the row's inner edge: none of it",
        }
    }

    /// The share σ of the row's height that must see stripes.
    #[must_use]
    pub fn share(self) -> f64 {
        match self {
            Self::WholeRow => 1.0,
            Self::HalfRow => 0.5,
            Self::Contrast => {
                let light = Light::default();
                f64::from(MIN_RANGE) / (light.white - light.black)
            }
            Self::AnyRow => 0.0,
        }
    }

    /// The distance, in metres, for an image whose first and last row are the scan lines and an inclination in radians.
    #[must_use]
    pub fn range(self, camera: &Camera, landmark: &Landmark, inclination: f64) -> f64 {
        let both_layers = 2.0 * landmark.stripe_height;
        let rows = camera.height as f64 - 2.0 + 2.0 * self.share();
        both_layers * camera.focal_length_vertical / rows - landmark.half_width() * inclination.sin().abs()
    }
}

/// The share of a row's height that sees stripes frontally at `distance` in metres, from 0 to 1.
#[must_use]
pub fn row_share(camera: &Camera, landmark: &Landmark, distance: f64) -> f64 {
    let reach = landmark.stripe_height * camera.focal_length_vertical / distance;
    (reach - (camera.height as f64 / 2.0 - 1.0)).clamp(0.0, 1.0)
}

/// The distance at which half of the views find the landmark.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HalfRange {
    /// Where the rate falls below one half for the last time, metres, interpolated between two distances.
    pub metres: f64,
    /// Where it does so for the first time; the same unless the rate rises again.
    pub first_metres: f64,
}

impl HalfRange {
    /// Of rates by distance in metres, nearest first. None unless the rate begins at one half or above and ends below.
    #[must_use]
    pub fn of(rates: &[(f64, f64)]) -> Option<Self> {
        let begins_above = rates.first().is_some_and(|&(_, rate)| rate >= 0.5);
        let ends_below = rates.last().is_some_and(|&(_, rate)| rate < 0.5);
        let falls: Vec<f64> = rates
            .windows(2)
            .filter(|pair| pair[0].1 >= 0.5 && pair[1].1 < 0.5)
            .map(|pair| pair[0].0 + (pair[1].0 - pair[0].0) * (pair[0].1 - 0.5) / (pair[0].1 - pair[1].1))
            .collect();
        let (first, last) = (*falls.first()?, *falls.last()?);
        (begins_above && ends_below).then_some(Self { metres: last, first_metres: first })
    }
}

/// Predictions with the `L_min` that fits best.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Which part of a row must see stripes.
    pub reading: RowReading,
    /// `L_min`, pixels.
    pub min_stripe_pixels: f64,
    /// min((5), (6)) by inclination, metres.
    pub predicted_m: Vec<f64>,
    /// Found over predicted, less 1, by inclination.
    pub deviations: Vec<f64>,
    /// The largest of them in size.
    pub worst: f64,
}

/// `L_min` in steps of 1/1000 px between which the best one is sought.
const THOUSANDTHS: core::ops::RangeInclusive<u32> = 1000..=3000;

impl Prediction {
    /// Of a given `L_min`, for ranges in metres found by inclinations in radians.
    #[must_use]
    pub fn with(reading: RowReading, min_stripe_pixels: f64, found: &[(f64, f64)]) -> Self {
        let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
        let predict = |&(inclination, _): &(f64, f64)| {
            let by_width = stripe_width_range(&camera, &landmark, inclination, min_stripe_pixels);
            by_width.min(reading.range(&camera, &landmark, inclination))
        };
        let predicted_m: Vec<f64> = found.iter().map(predict).collect();
        let deviations: Vec<f64> = found.iter().zip(&predicted_m).map(|((_, range), p)| range / p - 1.0).collect();
        let worst = deviations.iter().fold(0.0, |worst: f64, deviation| worst.max(deviation.abs()));
        Self { reading, min_stripe_pixels, predicted_m, deviations, worst }
    }

    fn order(&self, other: &Self) -> core::cmp::Ordering {
        let squares = |it: &Self| it.deviations.iter().map(|deviation| deviation * deviation).sum::<f64>();
        self.worst.total_cmp(&other.worst).then(squares(self).total_cmp(&squares(other)))
    }

    /// Of the `L_min` with the smallest worst deviation, of equals the one with the smallest sum of squared deviations:
    /// where (6) ends the worst one, `L_min` leaves it as it is.
    #[must_use]
    pub fn best(reading: RowReading, found: &[(f64, f64)]) -> Self {
        let first = Self::with(reading, f64::from(*THOUSANDTHS.start()) / 1000.0, found);
        THOUSANDTHS.skip(1).fold(first, |best, thousandths| {
            let next = Self::with(reading, f64::from(thousandths) / 1000.0, found);
            if next.order(&best).is_lt() { next } else { best }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reference::range::{blind_range, scan_line_range};

    /// 50 mm * 80 / 8, / 7, / 6.3 and / 6 rows.
    #[test]
    fn readings_are_distances_at_which_a_row_sees_its_share() {
        let (camera, landmark) = (Camera::epuck(), Landmark::new(Format::Paper));
        for (reading, metres) in RowReading::ALL.into_iter().zip([0.5, 4.0 / 7.0, 4.0 / 6.3, 4.0 / 6.0]) {
            let range = reading.range(&camera, &landmark, 0.0);
            assert!((range - metres).abs() < 1e-12);
            assert!((row_share(&camera, &landmark, range) - reading.share()).abs() < 1e-12);
        }
        let inclination = 0.7;
        let printed = RowReading::WholeRow.range(&camera, &landmark, inclination);
        assert!((printed - scan_line_range(&camera, &landmark, inclination)).abs() < 1e-12);
        assert!((RowReading::AnyRow.range(&camera, &landmark, 0.0) - blind_range(&camera, &landmark)).abs() < 1e-12);
    }

    #[test]
    fn half_of_the_views_are_found_where_the_line_between_two_rates_says() {
        let half = HalfRange::of(&[(0.4, 1.0), (0.5, 0.9), (0.6, 0.1), (0.7, 0.0)]).unwrap();
        assert!((half.metres - 0.55).abs() < 1e-12 && (half.first_metres - 0.55).abs() < 1e-12);
        let twice = HalfRange::of(&[(0.1, 1.0), (0.2, 0.0), (0.3, 1.0), (0.4, 0.0)]).unwrap();
        assert!((twice.first_metres - 0.15).abs() < 1e-12 && (twice.metres - 0.35).abs() < 1e-12);
        assert_eq!(HalfRange::of(&[(0.1, 1.0), (0.2, 0.8)]), None);
        assert_eq!(HalfRange::of(&[(0.1, 0.2), (0.2, 0.8), (0.3, 0.1)]), None);
        assert_eq!(HalfRange::of(&[]), None);
    }

    /// Ranges made with 1.4 px are explained by it.
    #[test]
    fn the_best_minimum_is_the_one_the_ranges_were_made_with() {
        let angles = [0.0, 0.5, 0.8, 1.0];
        let made = Prediction::with(RowReading::HalfRow, 1.4, &angles.map(|angle| (angle, 1.0)));
        let found: Vec<(f64, f64)> = angles.into_iter().zip(made.predicted_m).collect();
        let best = Prediction::best(RowReading::HalfRow, &found);
        assert!((best.min_stripe_pixels - 1.4).abs() < 1e-9 && best.worst < 1e-9);
    }
}
