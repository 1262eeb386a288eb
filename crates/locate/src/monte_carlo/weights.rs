//! Weights of particles, kept as logarithms.

/// Weights of a set of particles.
///
/// They are kept as logarithms and only become numbers relative to the largest one, so that products over thousands
/// of pixels do not underflow. Defined results for what a model should not give: a log likelihood that is not a number
/// counts as a weight of zero and is counted; an infinite weight takes all, several of them share; if no particle has
/// any weight, all have the same.
#[derive(Debug, Clone, Default)]
pub(super) struct Weights {
    /// Logarithms of the weights over the largest one; empty if all weights are equal.
    log: Vec<f64>,
    /// Weights over the largest weight.
    relative: Vec<f64>,
    total: f64,
}

impl Weights {
    /// Equal weights for so many particles.
    pub fn reset(&mut self, count: usize) {
        self.log.clear();
        self.relative.clear();
        self.relative.resize(count, 1.0);
        self.total = to_f64(count);
    }

    /// Weights by their logarithms.
    pub fn set_logs(&mut self, logs: &[f64]) {
        self.log.clear();
        self.log.extend_from_slice(logs);
        self.relative.resize(logs.len(), 0.0);
        self.normalize(logs.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    }

    /// Multiplies the weights by likelihoods to a power. Replaces the log likelihoods by the likelihoods.
    pub fn multiply(&mut self, log_likelihoods: &mut [f64], exponent: f64) {
        debug_assert_eq!(self.relative.len(), log_likelihoods.len());
        let (is_equal, mut largest) = (self.log.is_empty(), f64::NEG_INFINITY);
        self.log.resize(log_likelihoods.len(), 0.0);
        for (log, likelihood) in self.log.iter_mut().zip(log_likelihoods) {
            if likelihood.is_nan() {
                *likelihood = f64::NEG_INFINITY;
            }
            // A weight of zero stays zero, whatever comes: minus infinity plus infinity is not a number.
            if is_equal || *log != f64::NEG_INFINITY {
                *log += exponent * *likelihood;
            }
            *likelihood = likelihood.exp();
            largest = largest.max(*log);
        }
        self.normalize(largest);
    }

    /// Works out the weights over the largest one, whose logarithm is given. One pass: many particles do not fit into
    /// the processor's memory, and each pass over them costs as much as the arithmetic.
    fn normalize(&mut self, largest: f64) {
        if largest == f64::NEG_INFINITY {
            self.reset(self.relative.len());
            return;
        }
        self.total = 0.0;
        for (relative, log) in self.relative.iter_mut().zip(&mut self.log) {
            *log = match largest {
                f64::INFINITY if *log == f64::INFINITY => 0.0,
                f64::INFINITY => f64::NEG_INFINITY,
                _ => *log - largest,
            };
            *relative = log.exp();
            self.total += *relative;
        }
    }

    /// The weights over the largest one, 0 to 1.
    pub fn relative(&self) -> &[f64] {
        &self.relative
    }

    /// The logarithms of the same; empty if all are equal.
    pub fn logs(&self) -> &[f64] {
        &self.log
    }

    /// How many equally weighted particles would say as much. Source: Liu 1996, `1 / sum w^2` of normalized weights.
    pub fn effective_sample_size(&self) -> f64 {
        let squares: f64 = self.relative.iter().map(|w| w * w).sum();
        self.total * self.total / squares
    }
}

pub(super) fn to_f64(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights(mut log_likelihoods: Vec<f64>, exponent: f64) -> Weights {
        let mut weights = Weights::default();
        weights.reset(log_likelihoods.len());
        weights.multiply(&mut log_likelihoods, exponent);
        weights
    }

    fn normalized(weights: &Weights) -> Vec<f64> {
        weights.relative().iter().map(|w| w / weights.total).collect()
    }

    #[test]
    fn powers_of_likelihoods() {
        let mut likelihoods = vec![0.5_f64.ln(), 0.25_f64.ln()];
        let mut w = Weights::default();
        w.reset(2);
        w.multiply(&mut likelihoods, 2.0);
        assert!((normalized(&w)[0] - 0.8).abs() < 1e-12, "0.25 : 0.0625");
        assert!((likelihoods[0] - 0.5).abs() < 1e-12 && (likelihoods[1] - 0.25).abs() < 1e-12);
        w.multiply(&mut [0.5_f64.ln(), 0.5_f64.ln()], 2.0);
        assert!((normalized(&w)[0] - 0.8).abs() < 1e-12, "weights last until they are reset");
    }

    #[test]
    fn ten_thousand_pixels_do_not_underflow() {
        let pixels = 10_000.0;
        let w = weights(vec![pixels * 0.5_f64.ln(), pixels * 0.5_f64.ln() + 3.0_f64.ln()], 1.0);
        assert!((normalized(&w)[1] - 0.75).abs() < 1e-9);
    }

    #[test]
    fn no_weight_at_all_is_equal_weight() {
        let w = weights(vec![f64::NEG_INFINITY; 4], 20.0);
        assert_eq!(normalized(&w), [0.25; 4]);
        assert!((w.effective_sample_size() - 4.0).abs() < 1e-12);
    }

    #[test]
    fn not_a_number_is_no_weight() {
        let w = weights(vec![f64::NAN, 0.0, f64::NAN, 0.0], 1.0);
        assert_eq!(normalized(&w), [0.0, 0.5, 0.0, 0.5]);
        assert_eq!(normalized(&weights(vec![f64::NAN; 2], 1.0)), [0.5; 2]);
    }

    #[test]
    fn infinite_weights_take_all() {
        let w = weights(vec![0.0, f64::INFINITY, -5.0, f64::INFINITY], 1.0);
        assert_eq!(normalized(&w), [0.0, 0.5, 0.0, 0.5]);
        let mut w = weights(vec![f64::NEG_INFINITY, 0.0], 1.0);
        w.multiply(&mut [f64::INFINITY, 0.0], 1.0);
        assert_eq!(normalized(&w), [0.0, 1.0], "what has no weight stays without");
    }

    #[test]
    fn effective_sample_size_by_hand() {
        assert!((weights(vec![0.0; 8], 1.0).effective_sample_size() - 8.0).abs() < 1e-12);
        // weights 3 : 1, normalized 0.75 and 0.25: 1 / (0.5625 + 0.0625)
        assert!((weights(vec![3.0_f64.ln(), 0.0], 1.0).effective_sample_size() - 1.6).abs() < 1e-12);
    }
}
