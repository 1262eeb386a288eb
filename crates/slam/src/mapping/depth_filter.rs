//! What is known of a candidate's depth.

/// Inverse depth as a Gaussian, and the share of good measurements as a Beta distribution.
///
/// Source: Vogiatzis and Hernandez, "Video-based, real-time multi-view stereo", 2011, section 4 (the moments after a
/// measurement); over inverse depth as Forster et al., "SVO", 2014. Deviation: outliers are spread evenly over the range
/// of inverse depths that the filter started with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthFilter {
    mean: f64,
    variance: f64,
    good: f64,
    bad: f64,
    range: f64,
}

impl DepthFilter {
    /// A filter that starts with a mean and a standard deviation, both in 1 / map unit and above 0.
    #[must_use]
    pub fn new(inverse_depth: f64, standard_deviation: f64) -> Self {
        Self {
            mean: inverse_depth,
            variance: standard_deviation * standard_deviation,
            good: 10.0,
            bad: 10.0,
            range: 6.0 * standard_deviation,
        }
    }

    /// Mean, 1 / map unit; above 0.
    #[inline]
    #[must_use]
    pub fn inverse_depth(&self) -> f64 {
        self.mean
    }

    /// Standard deviation, 1 / map unit.
    #[inline]
    #[must_use]
    pub fn standard_deviation(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Expected share of good measurements.
    #[must_use]
    pub fn inlier_ratio(&self) -> f64 {
        self.good / (self.good + self.bad)
    }

    /// The same in another unit of length: all depths times a factor.
    #[must_use]
    pub fn with_depths_times(&self, factor: f64) -> Self {
        let Self { mean, variance, good, bad, range } = *self;
        Self { mean: mean / factor, variance: variance / (factor * factor), good, bad, range: range / factor }
    }

    /// Inverse depths two standard deviations to both sides, the lower one above 0.
    #[must_use]
    pub fn interval(&self) -> (f64, f64) {
        let reach = 2.0 * self.standard_deviation();
        ((self.mean - reach).max(1e-6), self.mean + reach)
    }

    /// A search that found nothing.
    pub fn add_miss(&mut self) {
        self.bad += 1.0;
    }

    /// A measurement of the inverse depth with its standard deviation.
    pub fn add(&mut self, measured: f64, standard_deviation: f64) {
        let tau2 = standard_deviation * standard_deviation;
        let spread = self.variance + tau2;
        let distance2 = (measured - self.mean).powi(2);
        let s2 = 1.0 / (1.0 / self.variance + 1.0 / tau2);
        let m = s2 * (self.mean / self.variance + measured / tau2);
        let (a, b) = (self.good, self.bad);
        let density = (-0.5 * distance2 / spread).exp() / (2.0 * std::f64::consts::PI * spread).sqrt();
        let c1 = a / (a + b) * density;
        let c2 = b / (a + b) / self.range;
        let total = c1 + c2;
        if !(total.is_finite() && total > 0.0) {
            self.add_miss();
            return;
        }
        let (c1, c2) = (c1 / total, c2 / total);
        let f = c1 * (a + 1.0) / (a + b + 1.0) + c2 * a / (a + b + 1.0);
        let e = c1 * (a + 1.0) * (a + 2.0) / ((a + b + 1.0) * (a + b + 2.0))
            + c2 * a * (a + 1.0) / ((a + b + 1.0) * (a + b + 2.0));
        let mean = c1 * m + c2 * self.mean;
        let variance = c1 * (s2 + m * m) + c2 * (self.variance + self.mean * self.mean) - mean * mean;
        self.mean = mean.max(1e-6);
        self.variance = variance.max(1e-14);
        let good = (e - f) / (f - e / f);
        if good.is_finite() && good > 0.0 {
            self.good = good;
            self.bad = good * (1.0 - f) / f;
        }
    }

    /// The linearity index: how far the depth is from being Gaussian, seen from a camera at `distance` map units whose ray
    /// meets the host's ray at the angle of `cos_parallax`. Below 0.1 the depth has converged.
    ///
    /// Source: Civera, Davison and Montiel, "Inverse depth parametrization for monocular SLAM", 2008, equation 37.
    #[must_use]
    pub fn linearity_index(&self, distance: f64, cos_parallax: f64) -> f64 {
        let depth_deviation = self.standard_deviation() / (self.mean * self.mean);
        4.0 * depth_deviation / distance * cos_parallax.abs()
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::{RngTree, gaussian};

    use super::*;

    #[test]
    fn finds_the_depth_among_outliers() {
        let mut hits = 0;
        for seed in 0..50 {
            let mut rng = RngTree::new(seed).stream("filter", 0);
            let mut filter = DepthFilter::new(1.0, 0.5);
            for i in 0..40 {
                let measured = if i % 3 == 2 {
                    0.2 + 1.6 * (gaussian(&mut rng, 1.0).abs() % 1.0)
                } else {
                    0.6 + gaussian(&mut rng, 0.02)
                };
                filter.add(measured, 0.02);
            }
            let error = (filter.inverse_depth() - 0.6).abs();
            if error < 4.0 * filter.standard_deviation() + 0.01 && filter.inlier_ratio() > 0.5 {
                hits += 1;
            }
        }
        assert!(hits >= 47, "{hits} of 50");
    }

    #[test]
    fn moments_agree_with_a_simulated_posterior() {
        // Posterior over a grid of inverse depths and inlier shares, one measurement.
        let mut filter = DepthFilter::new(1.0, 0.3);
        let range = 6.0 * 0.3;
        let (measured, tau) = (1.4, 0.1);
        let (mut mass, mut mean) = (0.0, 0.0);
        for i in 0..400 {
            let z = -0.5 + 3.0 * (f64::from(i) + 0.5) / 400.0;
            for j in 0..200 {
                let share: f64 = (f64::from(j) + 0.5) / 200.0;
                let prior = (-0.5 * ((z - 1.0) / 0.3_f64).powi(2)).exp() * (share * (1.0 - share)).powi(9);
                let good = (-0.5 * ((measured - z) / tau).powi(2)).exp()
                    / (tau * (2.0 * std::f64::consts::PI).sqrt());
                let weight = prior * (share * good + (1.0 - share) / range);
                mass += weight;
                mean += weight * z;
            }
        }
        filter.add(measured, tau);
        assert!(
            (filter.inverse_depth() - mean / mass).abs() < 2e-3,
            "{} {}",
            filter.inverse_depth(),
            mean / mass
        );
    }

    #[test]
    fn misses_lower_the_inlier_ratio_and_nothing_turns_nan() {
        let mut filter = DepthFilter::new(1.0, 0.5);
        filter.add_miss();
        assert!(filter.inlier_ratio() < 0.5);
        filter.add(f64::NAN, 0.1);
        filter.add(1e9, 1e-9);
        assert!(filter.inverse_depth().is_finite() && filter.standard_deviation().is_finite());
    }
}
