//! Seeded random numbers.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// The generator that all algorithms draw from. Its stream is the same on every platform and in every release.
pub type Rng = ChaCha8Rng;

/// Derives independent generators from one seed. A stream depends on its label and index only, not on the order in
/// which streams are made, so work can be split over threads without changing any number.
///
/// ```
/// use visloc_core::RngTree;
/// use rand::Rng;
/// let tree = RngTree::new(7);
/// assert_eq!(tree.stream("noise", 3).next_u64(), RngTree::new(7).stream("noise", 3).next_u64());
/// assert_ne!(tree.stream("noise", 3).next_u64(), tree.stream("noise", 4).next_u64());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RngTree {
    seed: u64,
}

impl RngTree {
    /// The tree of a seed.
    pub fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The generator of one purpose (`label`) and one member of a series (`index`, for instance the frame number).
    pub fn stream(&self, label: &str, index: u64) -> Rng {
        Rng::seed_from_u64(self.stream_seed(label, index))
    }

    /// The seed behind [`RngTree::stream`], for generators of another kind.
    pub fn stream_seed(&self, label: &str, index: u64) -> u64 {
        // FNV-1a over the label, then splitmix64 finalizers between the parts.
        let label_hash = label.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        mix(mix(mix(self.seed) ^ label_hash) ^ index)
    }

    /// A tree below this one, for a part that has streams of its own.
    #[must_use]
    pub fn subtree(&self, label: &str, index: u64) -> Self {
        Self { seed: self.stream_seed(label, index) }
    }
}

/// The finalizer of splitmix64 (Steele, Lea, Flood 2014).
fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// One draw from the normal distribution with mean 0 and the given standard deviation.
#[inline]
pub fn gaussian(rng: &mut Rng, standard_deviation: f64) -> f64 {
    let unit: f64 = StandardNormal.sample(rng);
    unit * standard_deviation
}

#[cfg(test)]
mod tests {
    use rand::Rng as _;

    use super::*;

    #[test]
    fn labels_seeds_and_subtrees_separate_streams() {
        let tree = RngTree::new(1);
        let first = |tree: RngTree, label, index| tree.stream(label, index).next_u64();
        assert_ne!(first(tree, "a", 0), first(tree, "b", 0));
        assert_ne!(first(tree, "a", 0), first(RngTree::new(2), "a", 0));
        assert_ne!(first(tree, "a", 0), first(tree.subtree("a", 0), "a", 0));
    }

    #[test]
    fn gaussian_has_its_moments() {
        let mut rng = RngTree::new(5).stream("test", 0);
        let draws: Vec<f64> = (0..20_000).map(|_| gaussian(&mut rng, 2.0)).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let variance = draws.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.06 && (variance - 4.0).abs() < 0.2, "mean {mean}, variance {variance}");
    }
}
