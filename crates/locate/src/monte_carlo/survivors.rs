//! Who survives into the next image: elite, drawn copies, newcomers.

use visloc_base::Rng;

use super::{
    Clusters, MonteCarloConfig, Particles, SampleSizeRule,
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
}

/// Particles that are drawn among themselves.
#[derive(Debug, Clone, Default)]
struct Stratum {
    members: Vec<usize>,
    weights: Vec<f64>,
    total: f64,
}

impl Survivors {
    /// How many particles of which kind are next. `clusters` are those of the present particles.
    pub fn makeup(
        &mut self,
        config: &MonteCarloConfig,
        particles: &Particles,
        clusters: &Clusters,
        newcomer_share: f64,
        rng: &mut Rng,
    ) -> Makeup {
        let count = match config.sample_size.rule {
            SampleSizeRule::Fixed => config.num_particles,
            SampleSizeRule::Kld => self.kld_count(config, particles, clusters, rng),
        };
        let num_elite = share(config.elite_share, count).min(particles.len());
        let num_newcomers = share(newcomer_share, count).min(count - num_elite);
        Makeup { num_elite, num_newcomers, num_drawn: count - num_elite - num_newcomers }
    }

    /// Draws a sample of the largest size and looks at it in scattered order until it is large enough. The survivors are
    /// then drawn anew, in that number, so that any scheme can be combined with the rule.
    fn kld_count(
        &mut self,
        config: &MonteCarloConfig,
        particles: &Particles,
        clusters: &Clusters,
        rng: &mut Rng,
    ) -> usize {
        let (rule, most) = (&config.sample_size, config.num_particles);
        self.drawn.clear();
        config.resampling.scheme.draw(particles.weights(), most, rng, &mut self.drawn);
        let (drawn, poses) = (&self.drawn, particles.poses());
        let stride = scattering_stride(drawn.len());
        let sample = (0..drawn.len()).map(|i| poses[drawn[i * stride % drawn.len()]]);
        let needed = self.bins.sample_size(rule, sample);
        self.collect_strata(particles, clusters, rule.min_probability);
        let num_hypotheses = self.strata.len().saturating_sub(1);
        needed.max(num_hypotheses * rule.min_per_hypothesis).max(rule.min_particles).min(most)
    }

    /// The elite unchanged, the rest drawn by weight, by chance or with a minimum for each hypothesis.
    pub fn draw(
        &mut self,
        config: &MonteCarloConfig,
        particles: &Particles,
        (clusters, best): (&Clusters, &[usize]),
        makeup: &Makeup,
        rng: &mut Rng,
    ) {
        self.sources.clear();
        self.logs.clear();
        self.sources.extend_from_slice(&best[..makeup.num_elite]);
        let min = config.sample_size.min_per_hypothesis;
        if min == 0 || makeup.num_drawn == 0 {
            config.resampling.scheme.draw(particles.weights(), makeup.num_drawn, rng, &mut self.sources);
            return;
        }
        self.collect_strata(particles, clusters, config.sample_size.min_probability);
        self.logs.resize(makeup.num_elite, 0.0);
        // The last stratum, which is no hypothesis, gets what its weight is worth.
        let (rest, hypotheses) = self.strata.split_last().map_or((0.0, &[][..]), |(rest, h)| (rest.total, h));
        let total = rest + hypotheses.iter().map(|stratum| stratum.total).sum::<f64>();
        let mut shares: Vec<f64> = hypotheses.iter().map(|stratum| stratum.total).collect();
        let is_rest_alone = shares.is_empty();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let num_rest = match is_rest_alone {
            true => makeup.num_drawn,
            false => (rest / total * to_f64(makeup.num_drawn)) as usize,
        };
        quotas(&shares, makeup.num_drawn - num_rest, min, &mut self.counts);
        self.counts.push(num_rest);
        shares.push(rest);
        for ((stratum, count), share) in self.strata.iter().zip(&self.counts).zip(shares) {
            self.drawn.clear();
            config.resampling.scheme.draw(&stratum.weights, *count, rng, &mut self.drawn);
            self.sources.extend(self.drawn.iter().map(|i| stratum.members[*i]));
            let weight = share / total * to_f64(makeup.num_drawn) / to_f64((*count).max(1));
            self.logs.resize(self.sources.len(), weight.ln());
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
        self.logs.extend(self.sources.iter().map(|i| particles.log_weights()[*i]));
    }

    /// One stratum for each hypothesis that is probable enough, and a last one for everything else.
    fn collect_strata(&mut self, particles: &Particles, clusters: &Clusters, min_probability: f64) {
        let weights = particles.weights();
        let total: f64 = weights.iter().sum();
        self.strata.clear();
        let mut rest = Stratum::default();
        for cluster in 0..clusters.len() {
            let mut stratum = Stratum::default();
            stratum.extend(clusters.members(cluster), weights);
            if stratum.total >= min_probability * total {
                self.strata.push(stratum);
            } else {
                rest.extend(stratum.members.into_iter(), weights);
            }
        }
        rest.extend(clusters.outsiders(), weights);
        self.strata.push(rest);
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
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
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
