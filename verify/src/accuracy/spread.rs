//! Sums over views: how far estimates lie from the truth, and from the bound.

/// Mean and standard deviation of a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Spread {
    /// Adds a value.
    pub fn add(&mut self, value: f64) {
        self.count += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    /// The mean, NaN of nothing.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum / self.count
    }

    /// The standard deviation about the mean, NaN of fewer than two values.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        ((self.squares - self.sum * self.sum / self.count).max(0.0) / (self.count - 1.0)).sqrt()
    }

    /// The root of the mean square.
    #[must_use]
    pub fn root_mean_square(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Where the mean of normalised squared errors in `(a, s, k)` has to lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Its expectation.
    pub nominal: f64,
    /// Standard deviation of the mean.
    pub deviation: f64,
}

impl Band {
    /// For `views` views whose noise variance was estimated with `freedom` degrees of freedom.
    ///
    /// The squared error is 3 times an F-distributed quantity with 3 and v degrees of freedom: mean `3 v/(v - 2)`, variance
    /// `6 v² (v + 1)/((v - 2)² (v - 4))`.
    #[must_use]
    pub fn of(freedom: f64, views: u64) -> Self {
        let v = freedom;
        let variance = 6.0 * v * v * (v + 1.0) / ((v - 2.0) * (v - 2.0) * (v - 4.0));
        Self { nominal: 3.0 * v / (v - 2.0), deviation: (variance / views as f64).sqrt() }
    }

    /// Its ends, `width` standard deviations from the middle.
    #[must_use]
    pub fn ends(&self, width: f64) -> (f64, f64) {
        (self.nominal - width * self.deviation, self.nominal + width * self.deviation)
    }

    /// Whether a mean lies within `width` standard deviations.
    #[must_use]
    pub fn holds(&self, mean: f64, width: f64) -> bool {
        (mean - self.nominal).abs() <= width * self.deviation
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_values() {
        let mut spread = Spread::default();
        for value in [1.0, 2.0, 6.0] {
            spread.add(value);
        }
        assert!((spread.mean() - 3.0).abs() < 1e-12 && (spread.deviation() - 7.0_f64.sqrt()).abs() < 1e-12);
        assert!((spread.root_mean_square() - (41.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    /// Infinitely many degrees of freedom leave a chi-square with three: mean 3, variance 6.
    #[test]
    fn with_known_noise_the_band_is_that_of_the_chi_square() {
        let band = Band::of(1e9, 600);
        assert!((band.nominal - 3.0).abs() < 1e-8 && (band.deviation - 0.1).abs() < 1e-8);
        assert!(band.holds(3.19, 1.96) && !band.holds(3.2, 1.96));
    }
}
