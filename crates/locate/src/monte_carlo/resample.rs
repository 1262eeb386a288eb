//! Drawing survivors by weight.

use rand::RngExt;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::Rng;

/// When survivors are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ResamplingTrigger {
    /// After every image, as in the documents.
    Always,
    /// When the weights have become so uneven that few particles count. Until then particles keep their weights.
    /// Source: Liu 1996; Doucet 1998.
    EffectiveSampleSize,
}

visloc_core::with_defaults! {
    /// Parameters of the drawing of survivors.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct ResamplingConfig {
        /// How survivors are drawn.
        pub scheme: Resampling = Resampling::Roulette,
        /// When.
        pub trigger: ResamplingTrigger = ResamplingTrigger::Always,
        /// Survivors are drawn when the effective sample size is below this share of the particles. Source: the same, 0.5.
        #[schemars(extend("x-only-if" = "trigger = effective-sample-size"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub min_effective_share: f64 = 0.5,
    }
}

impl ResamplingConfig {
    /// Whether it is time to draw.
    pub(super) fn is_due(&self, effective_share: f64) -> bool {
        match self.trigger {
            ResamplingTrigger::Always => true,
            ResamplingTrigger::EffectiveSampleSize => {
                effective_share.is_nan() || effective_share < self.min_effective_share
            }
        }
    }
}

/// How survivors are drawn. All have the same expected counts; they differ in the spread around them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Resampling {
    /// Independent draws (multinomial). Source: 2010 section 5.1.2.
    Roulette,
    /// One draw, then equal steps: the least spread. Source: Thrun, Burgard, Fox 2005, table 4.4.
    Systematic,
    /// One draw in each of `count` equal intervals. Source: Kitagawa 1996.
    Stratified,
    /// The whole parts of the expected counts for certain, the rest by roulette. Source: Liu and Chen 1998.
    Residual,
}

impl Resampling {
    /// Draws `count` indices into `weights` and appends them to `out`. Weights need not sum to 1; if they sum to
    /// nothing, every index is equally likely.
    pub fn draw(self, weights: &[f64], count: usize, rng: &mut Rng, out: &mut Vec<usize>) {
        let total: f64 = weights.iter().sum();
        if weights.is_empty() || count == 0 {
            return;
        }
        if !(total > 0.0 && total.is_finite()) {
            out.extend((0..count).map(|_| rng.random_range(0..weights.len())));
            return;
        }
        match self {
            Self::Roulette => roulette(weights, total, count, rng, out),
            Self::Systematic => {
                systematic(weights, total, (count, rng.random()), out);
            }
            Self::Stratified => comb(weights, total, count, out, |_| rng.random()),
            Self::Residual => residual(weights, total, count, rng, out),
        }
    }
}

/// Independent draws in one pass: the largest of n uniform numbers is u^(1/n), so they can be made in order.
fn roulette(weights: &[f64], total: f64, count: usize, rng: &mut Rng, out: &mut Vec<usize>) {
    let mut below = 1.0;
    let (mut index, mut rest) = (weights.len() - 1, total - weights[weights.len() - 1]);
    for left in (1..=count).rev() {
        let uniform: f64 = rng.random();
        let step = uniform.powf(1.0 / left as f64);
        below *= step;
        while rest > below * total && index > 0 {
            index -= 1;
            rest -= weights[index];
        }
        out.push(index);
    }
}

/// `count` marks at equal distances, the first `lead` (at least 0, below 1) before the end of the first step: a particle is
/// drawn once for each mark in its share of the total. Without a branch that depends on the weights, since no processor could foretell it: each particle
/// writes itself to its first place, and a second pass fills the gaps.
fn systematic(weights: &[f64], total: f64, (count, lead): (usize, f64), out: &mut Vec<usize>) {
    let first = out.len();
    // One place more, where particles that are not drawn write.
    out.resize(first + count + 1, 0);
    let places = &mut out[first..];
    let per_weight = count as f64 / total;
    let (mut cumulative, mut begin) = (0.0, 0);
    for (i, weight) in weights.iter().enumerate() {
        cumulative += weight;
        let end = ((cumulative * per_weight + lead) as usize).min(count);
        places[if end > begin { begin } else { count }] = i;
        begin = end;
    }
    out.truncate(first + count);
    let mut drawn = 0;
    for place in &mut out[first..] {
        drawn = drawn.max(*place);
        *place = drawn;
    }
}

/// One draw per interval; `offset` gives its place in the interval, 0 to 1.
fn comb(
    weights: &[f64],
    total: f64,
    count: usize,
    out: &mut Vec<usize>,
    mut offset: impl FnMut(usize) -> f64,
) {
    let step = total / count as f64;
    let (mut index, mut cumulative) = (0, weights[0]);
    for i in 0..count {
        let mark = (i as f64 + offset(i)) * step;
        while cumulative <= mark && index + 1 < weights.len() {
            index += 1;
            cumulative += weights[index];
        }
        out.push(index);
    }
}

fn residual(weights: &[f64], total: f64, count: usize, rng: &mut Rng, out: &mut Vec<usize>) {
    let first = out.len();
    let expected = |weight: f64| weight / total * count as f64;
    for (index, weight) in weights.iter().enumerate() {
        out.extend(std::iter::repeat_n(index, expected(*weight) as usize));
    }
    let left = count - (out.len() - first).min(count);
    let rests: Vec<f64> = weights.iter().map(|weight| expected(*weight).fract()).collect();
    let rest_total: f64 = rests.iter().sum();
    if left > 0 && rest_total > 0.0 {
        roulette(&rests, rest_total, left, rng, out);
    }
    out.truncate(first + count);
}

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;

    use super::*;

    const SCHEMES: [Resampling; 4] =
        [Resampling::Roulette, Resampling::Systematic, Resampling::Stratified, Resampling::Residual];

    fn counts(scheme: Resampling, weights: &[f64], count: usize, rng: &mut Rng) -> Vec<f64> {
        let mut drawn = Vec::new();
        scheme.draw(weights, count, rng, &mut drawn);
        assert_eq!(drawn.len(), count, "{scheme:?}");
        let mut counts = vec![0.0; weights.len()];
        drawn.iter().for_each(|i| counts[*i] += 1.0);
        counts
    }

    #[test]
    fn all_schemes_draw_in_proportion() {
        let weights = [0.5, 0.0, 2.0, 1.5, 0.25, 0.75];
        for scheme in SCHEMES {
            let mut rng = RngTree::new(4).stream("resample", 0);
            let mut mean = vec![0.0; weights.len()];
            for _ in 0..2000 {
                let counts = counts(scheme, &weights, 10, &mut rng);
                mean.iter_mut().zip(counts).for_each(|(m, c)| *m += c / 2000.0);
            }
            for (mean, weight) in mean.iter().zip(weights) {
                assert!((mean - weight * 2.0).abs() < 0.12, "{scheme:?}: {mean} for {weight}");
            }
            assert!(mean[1] < 1e-12, "{scheme:?} drew a particle without weight");
        }
    }

    #[test]
    fn systematic_is_within_one_of_the_expected_count() {
        let weights = [0.21, 0.33, 0.06, 0.4];
        let mut rng = RngTree::new(1).stream("resample", 0);
        for _ in 0..200 {
            for (count, weight) in counts(Resampling::Systematic, &weights, 50, &mut rng).iter().zip(weights)
            {
                assert!((count - 50.0 * weight).abs() < 1.0);
            }
        }
    }

    #[test]
    fn systematic_by_hand() {
        let draw = |weights: &[f64], count, lead| {
            let mut out = vec![77];
            systematic(weights, weights.iter().sum(), (count, lead), &mut out);
            out
        };
        // marks at 0.2, 0.7, 1.2, 1.7 of a total of 2 in shares that end at 0.5, 0.5, 1.5, 1.75, 2
        assert_eq!(draw(&[0.5, 0.0, 1.0, 0.25, 0.25], 4, 0.6), [77, 0, 2, 2, 3]);
        assert_eq!(draw(&[0.0, 3.0, 0.0], 3, 0.0), [77, 1, 1, 1]);
        assert_eq!(draw(&[0.0, 3.0, 0.0], 3, 0.999_999), [77, 1, 1, 1]);
    }

    #[test]
    fn effective_sample_size_triggers() {
        let always = ResamplingConfig::default();
        assert!(always.is_due(1.0));
        let selective = ResamplingConfig {
            trigger: ResamplingTrigger::EffectiveSampleSize,
            ..ResamplingConfig::default()
        };
        assert!(!selective.is_due(0.5) && selective.is_due(0.49) && selective.is_due(f64::NAN));
    }

    #[test]
    fn no_weight_at_all_is_uniform() {
        let mut rng = RngTree::new(1).stream("resample", 0);
        for scheme in SCHEMES {
            let counts = counts(scheme, &[0.0; 4], 4000, &mut rng);
            assert!(counts.iter().all(|c| (c - 1000.0).abs() < 120.0), "{scheme:?}: {counts:?}");
        }
    }
}
