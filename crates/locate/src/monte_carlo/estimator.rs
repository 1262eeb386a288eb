//! From particles to one answer.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::geom::weighted_pose_statistics;

use super::{ClusterConfig, Clusters, Particles, share, weights::to_f64};
use crate::Estimate;

/// What the answer is the mean of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EstimateKind {
    /// The best particles. Source: 2017 section 4.1.4, classic Monte Carlo.
    EliteMean,
    /// The group with most of the best particles, so that the answer is not halfway between two places, and does not jump
    /// with every image. Source: 2017 section 4.1.4, augmented Monte Carlo.
    LargestCluster,
}

visloc_core::with_defaults! {
    /// Parameters of the answer.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct EstimateConfig {
        /// What it is the mean of.
        pub kind: EstimateKind = EstimateKind::EliteMean,
        /// Share of the particles that count as the best, at least one particle.
        #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
        pub share: f64 = 0.1,
    }
}

impl EstimateConfig {
    /// How many of so many particles are the best.
    pub(super) fn num_best(&self, count: usize) -> usize {
        share(self.share, count).max(1).min(count)
    }
}

/// Works out the answer; keeps its buffers.
#[derive(Debug, Clone, Default)]
pub(super) struct Estimator {
    /// Groups of all particles.
    pub clusters: Clusters,
    elite_clusters: Clusters,
    chosen: Vec<usize>,
    poses: Vec<visloc_core::geom::PlanarPose>,
    weights: Vec<f64>,
}

impl Estimator {
    /// Weighted mean of the best particles, and hypotheses from all of them. `best` begins with the best ones in order.
    pub fn update(
        &mut self,
        (config, groups): (&EstimateConfig, &ClusterConfig),
        particles: &Particles,
        best: &[usize],
        estimate: &mut Estimate,
    ) {
        let (poses, weights) = (particles.poses(), particles.weights());
        estimate.hypotheses.clear();
        self.clusters.find(groups, poses, weights, &mut estimate.hypotheses);
        self.choose(config, groups, particles, &best[..config.num_best(particles.len()).min(best.len())]);
        let members = self.chosen.iter().map(|i| (poses[*i], weights[*i]));
        let Some(statistics) = weighted_pose_statistics(members) else { return };
        let likelihoods = self.chosen.iter().map(|i| particles.likelihoods()[*i]);
        estimate.world_from_robot = statistics.mean;
        estimate.covariance = statistics.covariance;
        estimate.likelihood = likelihoods.sum::<f64>() / to_f64(self.chosen.len());
        if groups.max_clusters == 0 {
            return;
        }
        estimate.normalize_hypotheses();
        let all = poses.iter().copied().zip(weights.iter().copied());
        if let Some(all) = weighted_pose_statistics(all) {
            estimate.covariance = all.covariance;
        }
    }

    /// The particles that the answer is the mean of.
    fn choose(
        &mut self,
        config: &EstimateConfig,
        groups: &ClusterConfig,
        particles: &Particles,
        best: &[usize],
    ) {
        self.chosen.clear();
        if config.kind == EstimateKind::EliteMean {
            self.chosen.extend_from_slice(best);
            return;
        }
        self.poses.clear();
        self.poses.extend(best.iter().map(|i| particles.poses()[*i]));
        self.weights.clear();
        self.weights.extend(best.iter().map(|i| particles.weights()[*i]));
        let groups = ClusterConfig { max_clusters: groups.max_clusters.max(1), ..*groups };
        self.elite_clusters.group(&groups, &self.poses, &self.weights);
        if let Some(largest) = self.elite_clusters.largest() {
            self.chosen.extend(self.elite_clusters.members(largest).map(|i| best[i]));
        }
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::{Rng, geom::PlanarPose};

    use super::*;
    use crate::{ObservationModel, Region, vision::Percept};

    /// Likelihood by place: 1 at x = 0, 0.9 at x = 5, less elsewhere.
    struct TwoPlaces;

    impl ObservationModel for TwoPlaces {
        fn condition_on(&mut self, _: &Percept) {}
        fn has_evidence(&self) -> bool {
            true
        }
        fn likelihood(&self, pose: &PlanarPose) -> f64 {
            if pose.x_m.abs() < 0.5 { 1.0 } else { 0.9 }
        }
        fn region(&self) -> Region {
            Region { min_x_m: -9.0, max_x_m: 9.0, min_y_m: -9.0, max_y_m: 9.0 }
        }
        fn max_jump_m(&self) -> f64 {
            2.0
        }
        fn propose(&self, _: &mut Rng) -> PlanarPose {
            PlanarPose::default()
        }
        fn propose_heading(&self, _: f64, _: f64, _: &mut Rng) -> f64 {
            0.0
        }
    }

    fn estimate(kind: EstimateKind) -> Estimate {
        let mut particles = Particles::default();
        let at = |x: f64| PlanarPose::new(x, 0.0, 0.0);
        particles.start([at(5.0), at(5.1), at(0.0), at(4.9), at(0.0)]);
        particles.weigh(&TwoPlaces, 1.0, usize::MAX);
        let config = EstimateConfig { kind, share: 1.0 };
        let mut best = Vec::new();
        particles.rank(5, &mut best);
        assert_eq!(best, [2, 4, 0, 1, 3]);
        let mut estimate = Estimate::unknown();
        Estimator::default().update((&config, &ClusterConfig::default()), &particles, &best, &mut estimate);
        estimate
    }

    #[test]
    fn mean_of_the_best() {
        let estimate = estimate(EstimateKind::EliteMean);
        // (2 * 1 * 0 + 0.9 * 15) / (2 + 2.7)
        assert!((estimate.world_from_robot.x_m - 13.5 / 4.7).abs() < 1e-9);
        assert!((estimate.likelihood - 4.7 / 5.0).abs() < 1e-9);
        assert_eq!(estimate.hypotheses.len(), 2);
    }

    #[test]
    fn largest_cluster_is_not_halfway() {
        let estimate = estimate(EstimateKind::LargestCluster);
        assert!((estimate.world_from_robot.x_m - 5.0).abs() < 1e-9);
        assert!((estimate.likelihood - 0.9).abs() < 1e-9);
        assert!((estimate.hypotheses[0].probability - 2.7 / 4.7).abs() < 1e-9);
    }
}
