//! Normal noise for many particles.

use rand::{Rng as _, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use visloc_core::Rng;

/// Draws one block of normal noise. Its generator is seeded from the localizer's, and is several times cheaper; its
/// stream is the same on every platform.
#[derive(Debug, Clone)]
pub(super) struct NoiseBlock {
    rng: Xoshiro256PlusPlus,
}

impl NoiseBlock {
    pub fn new(rng: &mut Rng) -> Self {
        Self { rng: Xoshiro256PlusPlus::seed_from_u64(rng.next_u64()) }
    }

    /// One draw with mean 0 and standard deviation 1.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;

    use super::*;

    #[test]
    fn moments_and_repetition() {
        let draws = |seed| -> Vec<f64> {
            let mut noise = NoiseBlock::new(&mut RngTree::new(seed).stream("noise", 0));
            (0..40_000).map(|_| noise.unit()).collect()
        };
        let first = draws(3);
        let mean = first.iter().sum::<f64>() / 40_000.0;
        let variance = first.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 40_000.0;
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.03, "mean {mean}, variance {variance}");
        assert_eq!(first, draws(3));
        assert_ne!(first, draws(4));
    }
}
