//! How many particles the next image gets.

use std::{collections::HashSet, f64::consts::TAU};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::geom::PlanarPose;

use super::weights::to_f64;

/// Rule for the number of particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SampleSizeRule {
    /// Always `num_particles`.
    Fixed,
    /// As many as the spread of the particles calls for, at most `num_particles`. Source: Fox 2001; 2017 equation 2.12.
    Kld,
}

visloc_core::with_defaults! {
    /// Parameters of the number of particles.
    ///
    /// Particles fall into bins of the map; with `k` bins occupied, the given number of particles keeps the distance between
    /// the belief and its samples below `max_error` with probability `1 - delta`.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct SampleSizeConfig {
        /// The rule.
        pub rule: SampleSizeRule = SampleSizeRule::Fixed,
        /// Largest Kullback-Leibler distance (epsilon). Source: Thrun, Burgard, Fox 2005, section 8.3.7, 0.05.
        #[schemars(extend("x-only-if" = "rule = kld"))]
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
        pub max_error: f64 = 0.05,
        /// Probability of a larger distance; the formula takes the normal quantile of `1 - delta`. Source: same, 0.01.
        #[schemars(extend("x-only-if" = "rule = kld"))]
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
        pub delta: f64 = 0.01,
        /// Size of a bin, meters.
        #[schemars(extend("x-only-if" = "rule = kld"))]
        #[schemars(range(min = 0.001, max = 1000.0))]
        pub bin_m: f64 = 0.5,
        /// Size of a bin, radians. Bins wrap at +-pi.
        #[schemars(extend("x-only-if" = "rule = kld"))]
        #[schemars(range(min = 0.001, max = 1000.0))]
        pub bin_rad: f64 = 0.26,
        /// Never fewer particles than this.
        #[schemars(extend("x-only-if" = "rule = kld"))]
        #[schemars(range(min = 2, max = 10_000_000))]
        pub min_particles: usize = 50,
        /// Particles that each hypothesis keeps, under either rule; 0 leaves it to chance. A hypothesis that gets more
        /// particles than its probability has them with smaller weights, so that the belief does not change.
        pub min_per_hypothesis: usize = 0,
        /// Hypotheses below this probability keep nothing.
        #[schemars(extend("x-only-if" = "min_per_hypothesis > 0"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub min_probability: f64 = 0.02,
    }
}

/// Particles that keep the error below `max_error` when so many bins are occupied. Source: 2017 equation 2.12.
///
/// ```
/// use visloc_locate::monte_carlo::{kld_sample_size, normal_quantile};
/// let particles = kld_sample_size(10, 0.05, normal_quantile(0.99));
/// assert!((particles - 216.0).abs() < 1.0);
/// ```
pub fn kld_sample_size(occupied_bins: usize, max_error: f64, quantile: f64) -> f64 {
    if occupied_bins < 2 {
        return 1.0;
    }
    let free = to_f64(occupied_bins - 1);
    let ninth = 2.0 / (9.0 * free);
    free / (2.0 * max_error) * (1.0 - ninth + ninth.sqrt() * quantile).powi(3)
}

/// Quantile of the normal distribution: a normal number is below it with the given probability, above 0 and below 1. To
/// seven digits. Source: Wichura 1988, algorithm AS 241, routine PPND7.
pub fn normal_quantile(probability: f64) -> f64 {
    let center = probability - 0.5;
    if center.abs() <= 0.425 {
        let r = 0.180_625 - center * center;
        let top = polynomial(&[3.387_132_717_9, 50.434_271_938, 159.291_132_02, 59.109_374_72], r);
        return center * top / polynomial(&[1.0, 17.895_169_469, 78.757_757_664, 67.187_563_6], r);
    }
    let tail = if center < 0.0 { probability } else { 1.0 - probability };
    let r = (-tail.ln()).sqrt();
    let value = if r <= 5.0 {
        let r = r - 1.6;
        let top = polynomial(&[1.423_437_277_7, 2.756_815_39, 1.306_728_481_6, 0.170_238_211_03], r);
        top / polynomial(&[1.0, 0.737_001_642_5, 0.120_211_329_75], r)
    } else {
        let r = r - 5.0;
        let top = polynomial(&[6.657_905_115, 3.081_226_386, 0.428_682_943_37, 0.017_337_203_997], r);
        top / polynomial(&[1.0, 0.241_978_942_25, 0.012_258_202_635], r)
    };
    value.copysign(center)
}

/// Value of a polynomial, the constant first.
fn polynomial(coefficients: &[f64], at: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * at + coefficient)
}

/// Counts occupied bins.
#[derive(Debug, Clone, Default)]
pub(super) struct Bins {
    occupied: HashSet<[i32; 3]>,
}

impl Bins {
    /// The number of particles that a sample of poses calls for, at most the whole sample. The sample must be in random
    /// order.
    pub fn sample_size(
        &mut self,
        config: &SampleSizeConfig,
        sample: impl Iterator<Item = PlanarPose>,
    ) -> usize {
        let quantile = normal_quantile(1.0 - config.delta);
        self.occupied.clear();
        let mut needed = 0.0;
        let mut seen = 0;
        for pose in sample {
            seen += 1;
            if self.occupied.insert(bin(config, &pose)) {
                needed = kld_sample_size(self.occupied.len(), config.max_error, quantile);
            }
            if seen >= config.min_particles && to_f64(seen) >= needed {
                break;
            }
        }
        seen
    }
}

fn bin(config: &SampleSizeConfig, pose: &PlanarPose) -> [i32; 3] {
    let turns = (TAU / config.bin_rad).round().max(1.0);
    let turn = (pose.yaw_rad / TAU * turns).floor().rem_euclid(turns);
    [(pose.x_m / config.bin_m).floor() as i32, (pose.y_m / config.bin_m).floor() as i32, turn as i32]
}

/// Splits `count` particles over groups. Each group has a share (the sum may be anything) and a minimum; the minima
/// together must not exceed `count`.
pub(super) fn quotas(groups: &[(f64, usize)], count: usize, out: &mut Vec<usize>) {
    out.clear();
    let total: f64 = groups.iter().map(|(share, _)| share).sum();
    out.extend(groups.iter().map(|(share, min)| ((share / total * to_f64(count)) as usize).max(*min)));
    let mut given: usize = out.iter().sum();
    let most_to_spare = |out: &[usize]| {
        (0..out.len()).max_by_key(|i| (out[*i].saturating_sub(groups[*i].1), usize::MAX - *i)).unwrap_or(0)
    };
    if given < count && !out.is_empty() {
        let largest = (0..out.len()).max_by(|a, b| groups[*a].0.total_cmp(&groups[*b].0)).unwrap_or(0);
        out[largest] += count - given;
    }
    while given > count {
        let group = most_to_spare(out);
        let taken = out[group].saturating_sub(groups[group].1).min(given - count);
        if taken == 0 {
            return;
        }
        out[group] -= taken;
        given -= taken;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn quantiles_from_tables() {
        for (probability, expected) in [
            (0.5, 0.0),
            (0.9, 1.281_551_6),
            (0.975, 1.959_964_0),
            (0.99, 2.326_347_9),
            (0.999, 3.090_232_3),
            (0.01, -2.326_347_9),
            (1e-9, -5.997_807_0),
            (1e-12, -7.034_483_8),
        ] {
            let found = normal_quantile(probability);
            assert!((found - expected).abs() < 1e-6, "{probability}: {found}, expected {expected}");
        }
    }

    /// Equation 2.12 worked out by hand for k = 3, epsilon = 0.1, z = 2: 2 / 0.2 = 10;
    /// 1 - 2/18 + 2 sqrt(2/18) = 0.8889 + 0.6667 = 1.5556; 10 * 1.5556^3 = 37.64.
    #[test]
    fn sample_size_by_hand() {
        assert!((kld_sample_size(3, 0.1, 2.0) - 37.641).abs() < 0.01);
        assert!((kld_sample_size(1, 0.1, 2.0) - 1.0).abs() < 1e-12, "one bin needs one particle");
    }

    #[test]
    fn a_spread_sample_calls_for_more_than_a_cloud() {
        let config = SampleSizeConfig { min_particles: 20, ..SampleSizeConfig::default() };
        let spread = |i: i32| PlanarPose::new(f64::from(i % 40), f64::from(i * 7 % 30), 0.1 * f64::from(i));
        let cloud = |i: i32| PlanarPose::new(0.1 + 0.001 * f64::from(i % 5), 0.2, 0.1);
        let mut bins = Bins::default();
        assert_eq!(bins.sample_size(&config, (0..1000).map(cloud)), 20);
        assert_eq!(bins.sample_size(&config, (0..1000).map(spread)), 1000);
    }

    #[test]
    fn bins_wrap() {
        let config = SampleSizeConfig { bin_rad: TAU / 8.0, ..SampleSizeConfig::default() };
        let at = |yaw| bin(&config, &PlanarPose { x_m: -0.1, y_m: 0.0, yaw_rad: yaw });
        assert_eq!(at(PI), at(-PI));
        assert_eq!(at(-PI + 0.01), at(PI + 0.01));
        assert_ne!(at(0.01), at(-0.01));
        assert_eq!(at(0.0)[0], -1);
    }

    #[test]
    fn quotas_keep_a_minimum_and_the_sum() {
        let mut out = Vec::new();
        quotas(&[(0.97, 10), (0.02, 10), (0.01, 10)], 100, &mut out);
        assert_eq!(out, [80, 10, 10]);
        quotas(&[(6.0, 0), (4.0, 0)], 10, &mut out);
        assert_eq!(out, [6, 4]);
        quotas(&[(0.9, 2), (0.05, 2), (0.05, 4)], 8, &mut out);
        assert_eq!(out, [2, 2, 4]);
        quotas(&[(1.0, 0), (1.0, 0), (1.0, 0)], 1, &mut out);
        assert_eq!(out.iter().sum::<usize>(), 1);
        quotas(&[(0.0, 3), (1.0, 0)], 5, &mut out);
        assert_eq!(out, [3, 2]);
    }
}
