//! Who survives into the next image: elite, drawn copies, newcomers.

use visloc_core::Rng;

use super::{
    Clusters, MonteCarloConfig, Particles, Resampling, SampleSizeRule,
    sample_size::{Bins, quotas},
    share,
    weights::to_f64,
};

/// How the next set of particles is made up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Makeup {
    pub num_elite: usize,
    pub num_drawn: usize,
    pub num_newcomers: usize,
}

/// The particles that are weighed, how they lie together, and their indices with the best one first.
#[derive(Clone, Copy)]
pub(super) struct Weighed<'a> {
    pub particles: &'a Particles,
    pub clusters: &'a Clusters,
    pub best: &'a [usize],
}

/// Chooses survivors; keeps its buffers.
#[derive(Debug, Clone, Default)]
pub(super) struct Survivors {
    bins: Bins,
    /// Indices of the survivors, the elite first.
    pub sources: Vec<usize>,
    /// Logarithms of their weights; empty if all are equal.
    pub logs: Vec<f64>,
    drawn: Vec<usize>,
    counts: Vec<usize>,
    strata: Vec<Stratum>,
    /// The stratum of each particle.
    stratum_of: Vec<usize>,
}

/// Particles that are drawn among themselves.
#[derive(Debug, Clone, Default)]
struct Stratum {
    members: Vec<usize>,
    weights: Vec<f64>,
    total: f64,
    num_elite: usize,
}

impl Survivors {
    /// How many particles of which kind are next.
    pub fn makeup(
        &mut self,
        config: &MonteCarloConfig,
        weighed: Weighed<'_>,
        newcomer_share: f64,
        rng: &mut Rng,
    ) -> Makeup {
        let count = match config.sample_size.rule {
            SampleSizeRule::Fixed => config.num_particles,
            SampleSizeRule::Kld => self.kld_count(config, weighed, rng),
        };
        let num_elite = share(config.elite_share, count).min(weighed.particles.len());
        let num_newcomers = share(newcomer_share, count).min(count - num_elite);
        Makeup { num_elite, num_newcomers, num_drawn: count - num_elite - num_newcomers }
    }

    /// Draws a sample of the largest size and looks at it in scattered order until it is large enough. The survivors are
    /// then drawn anew, in that number, so that any scheme can be combined with the rule.
    fn kld_count(&mut self, config: &MonteCarloConfig, weighed: Weighed<'_>, rng: &mut Rng) -> usize {
        let (rule, most) = (&config.sample_size, config.num_particles);
        self.drawn.clear();
        config.resampling.scheme.draw(weighed.particles.weights(), most, rng, &mut self.drawn);
        let (drawn, poses) = (&self.drawn, weighed.particles.poses());
        let stride = scattering_stride(drawn.len());
        let sample = (0..drawn.len()).map(|i| poses[drawn[i * stride % drawn.len()]]);
        let needed = self.bins.sample_size(rule, sample);
        self.collect_strata(weighed, rule.min_probability);
        let num_hypotheses = self.strata.len().saturating_sub(1);
        needed.max(num_hypotheses * rule.min_per_hypothesis).max(rule.min_particles).min(most)
    }

    /// The elite unchanged, the rest drawn by weight, by chance or with a minimum for each hypothesis.
    pub fn draw(&mut self, config: &MonteCarloConfig, weighed: Weighed<'_>, makeup: &Makeup, rng: &mut Rng) {
        self.sources.clear();
        self.logs.clear();
        self.sources.extend_from_slice(&weighed.best[..makeup.num_elite]);
        let min = config.sample_size.min_per_hypothesis;
        if min == 0 || makeup.num_drawn == 0 {
            config.resampling.scheme.draw(
                weighed.particles.weights(),
                makeup.num_drawn,
                rng,
                &mut self.sources,
            );
            return;
        }
        self.collect_strata(weighed, config.sample_size.min_probability);
        self.draw_strata(config.resampling.scheme, makeup, min, rng);
    }

    /// Draws within each hypothesis. Its particles together weigh as much as before, however many they are.
    fn draw_strata(&mut self, scheme: Resampling, makeup: &Makeup, min: usize, rng: &mut Rng) {
        let count = makeup.num_elite + makeup.num_drawn;
        let num_hypotheses = self.strata.len().saturating_sub(1);
        let min = min.min(makeup.num_drawn / num_hypotheses.max(1));
        for stratum in &mut self.strata {
            stratum.num_elite = 0;
        }
        for i in &self.sources {
            self.strata[self.stratum_of[*i]].num_elite += 1;
        }
        // The last stratum is no hypothesis and has no minimum.
        let needs =
            |(i, s): (usize, &Stratum)| (s.total, s.num_elite.max(if i < num_hypotheses { min } else { 0 }));
        let shares: Vec<(f64, usize)> = self.strata.iter().enumerate().map(needs).collect();
        quotas(&shares, count, &mut self.counts);
        let total: f64 = self.strata.iter().map(|stratum| stratum.total).sum();
        let log_weight = |stratum: &Stratum, count_here: usize| {
            (stratum.total / total * to_f64(count) / to_f64(count_here.max(1))).ln()
        };
        for i in &self.sources {
            let stratum = self.stratum_of[*i];
            self.logs.push(log_weight(&self.strata[stratum], self.counts[stratum]));
        }
        for (stratum, count_here) in self.strata.iter().zip(&self.counts) {
            self.drawn.clear();
            scheme.draw(&stratum.weights, count_here - stratum.num_elite, rng, &mut self.drawn);
            self.sources.extend(self.drawn.iter().map(|i| stratum.members[*i]));
            self.logs.resize(self.sources.len(), log_weight(stratum, *count_here));
        }
    }

    /// All particles stay and keep their weights; only the elite moves to the front.
    pub fn keep(&mut self, particles: &Particles, best: &[usize], num_elite: usize) {
        self.sources.clear();
        self.sources.extend_from_slice(&best[..num_elite]);
        let elite = &best[..num_elite];
        self.counts.clear();
        self.counts.resize(particles.len(), 1);
        elite.iter().for_each(|i| self.counts[*i] = 0);
        self.sources.extend((0..particles.len()).filter(|i| self.counts[*i] == 1));
        self.logs.clear();
        if let logs @ [_, ..] = particles.log_weights() {
            self.logs.extend(self.sources.iter().map(|i| logs[*i]));
        }
    }

    /// One stratum for each hypothesis that is probable enough, and a last one for everything else.
    fn collect_strata(&mut self, Weighed { particles, clusters, .. }: Weighed<'_>, min_probability: f64) {
        let weights = particles.weights();
        let total: f64 = weights.iter().sum();
        self.strata.clear();
        let mut rest = Stratum::default();
        for cluster in 0..clusters.len() {
            let mut stratum = Stratum::default();
            stratum.extend(clusters.members(cluster), weights);
            if stratum.total > 0.0 && stratum.total >= min_probability * total {
                self.strata.push(stratum);
            } else {
                rest.extend(stratum.members.into_iter(), weights);
            }
        }
        rest.extend(clusters.outsiders(), weights);
        self.strata.push(rest);
        self.stratum_of.clear();
        self.stratum_of.resize(particles.len(), 0);
        for (place, stratum) in self.strata.iter().enumerate() {
            stratum.members.iter().for_each(|i| self.stratum_of[*i] = place);
        }
    }
}

impl Stratum {
    fn extend(&mut self, members: impl Iterator<Item = usize>, weights: &[f64]) {
        for i in members {
            self.members.push(i);
            self.weights.push(weights[i]);
            self.total += weights[i];
        }
    }
}

/// A stride that visits every place of a ring once and jumps far: near the golden section, without a common divisor.
fn scattering_stride(count: usize) -> usize {
    let common = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let mut stride = (0.618_034 * to_f64(count)) as usize;
    while stride > 1 && common(stride, count) != 1 {
        stride -= 1;
    }
    stride.max(1)
}
