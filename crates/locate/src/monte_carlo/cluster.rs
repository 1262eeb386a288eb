//! Groups of particles that stand for one place.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::geom::{PlanarPose, weighted_pose_statistics};

use crate::Hypothesis;

visloc_core::with_defaults! {
    /// When two particles stand for the same place.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct ClusterConfig {
        /// Largest distance from the group's best particle, meters.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_distance_m: f64 = 0.6,
        /// Largest difference of the heading, radians; wraps at +-pi.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_turn_rad: f64 = 0.5,
        /// At most so many groups; what is left joins none. With 0 nothing is grouped and there are no hypotheses, which saves
        /// time; the estimate's covariance is then that of the particles it is the mean of.
        #[schemars(range(min = 0, max = 1000))]
        pub max_clusters: usize = 12,
    }
}

/// Finds groups; keeps its buffers.
#[derive(Debug, Clone, Default)]
pub struct Clusters {
    order: Vec<usize>,
    leaders: Vec<usize>,
    cluster_of: Vec<usize>,
}

const NONE: usize = usize::MAX;

impl Clusters {
    /// Groups poses around the heaviest ones and appends a hypothesis for each group: mean and covariance normalized
    /// by the group's own weight, probability its share of the weight.
    pub fn find(
        &mut self,
        config: &ClusterConfig,
        poses: &[PlanarPose],
        weights: &[f64],
        out: &mut Vec<Hypothesis>,
    ) {
        self.group(config, poses, weights);
        let total: f64 = weights.iter().sum();
        for cluster in 0..self.leaders.len() {
            let members = || self.members(cluster);
            let Some(statistics) = weighted_pose_statistics(members().map(|i| (poses[i], weights[i]))) else {
                continue;
            };
            out.push(Hypothesis {
                world_from_robot: statistics.mean,
                covariance: statistics.covariance,
                probability: members().map(|i| weights[i]).sum::<f64>() / total,
            });
        }
    }

    /// Groups poses around the heaviest ones. The group of the heaviest pose is the first.
    pub fn group(&mut self, config: &ClusterConfig, poses: &[PlanarPose], weights: &[f64]) {
        self.leaders.clear();
        self.cluster_of.clear();
        self.cluster_of.resize(poses.len(), NONE);
        if config.max_clusters == 0 {
            return;
        }
        self.order.clear();
        self.order.extend(0..poses.len());
        self.order.sort_unstable_by(|a, b| weights[*b].total_cmp(&weights[*a]).then(a.cmp(b)));
        for &i in &self.order {
            let near = |leader: &usize| {
                poses[i].distance_m(&poses[*leader]) <= config.max_distance_m
                    && poses[i].heading_difference_rad(&poses[*leader]) <= config.max_turn_rad
            };
            if let Some(cluster) = self.leaders.iter().position(near) {
                self.cluster_of[i] = cluster;
            } else if self.leaders.len() < config.max_clusters {
                self.cluster_of[i] = self.leaders.len();
                self.leaders.push(i);
            }
        }
    }

    /// How many groups the last call found.
    pub fn len(&self) -> usize {
        self.leaders.len()
    }

    /// Whether the last call found no group.
    pub fn is_empty(&self) -> bool {
        self.leaders.is_empty()
    }

    /// Indices of the poses of a group, in order.
    pub fn members(&self, cluster: usize) -> impl Iterator<Item = usize> + Clone {
        self.cluster_of.iter().enumerate().filter(move |(_, of)| **of == cluster).map(|(i, _)| i)
    }

    /// The group with most poses, of equals the one around the heaviest pose.
    pub fn largest(&self) -> Option<usize> {
        let mut counts = vec![0_usize; self.leaders.len()];
        self.cluster_of.iter().filter(|of| **of != NONE).for_each(|of| counts[*of] += 1);
        (0..counts.len()).max_by_key(|cluster| (counts[*cluster], usize::MAX - *cluster))
    }

    /// Indices of the poses that joined no group, in order.
    pub fn outsiders(&self) -> impl Iterator<Item = usize> {
        self.members(NONE)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn two_places_one_of_them_across_pi() {
        let poses = [
            PlanarPose::new(0.0, 0.0, PI - 0.1),
            PlanarPose::new(0.2, 0.0, -PI + 0.1),
            PlanarPose::new(2.0, 1.0, 0.5),
        ];
        let mut found = Vec::new();
        Clusters::default().find(&ClusterConfig::default(), &poses, &[1.0, 1.0, 2.0], &mut found);
        assert_eq!(found.len(), 2);
        assert!((found[0].probability - 0.5).abs() < 1e-12);
        let west = found[1];
        assert!(west.world_from_robot.distance_m(&PlanarPose::new(0.1, 0.0, PI)) < 1e-9);
        assert!(west.world_from_robot.heading_difference_rad(&PlanarPose::new(0.0, 0.0, PI)) < 1e-9);
        // normalized by the group's own weight, not by the weight of all
        assert!((west.covariance[(0, 0)] - 0.01).abs() < 1e-9);
        assert!((west.covariance[(2, 2)] - 0.01).abs() < 1e-9);
    }

    #[test]
    fn largest_group_and_outsiders() {
        let at = |x| PlanarPose::new(x, 0.0, 0.0);
        let poses = [at(0.0), at(5.0), at(5.1), at(9.0), at(0.1), at(-7.0)];
        let config = ClusterConfig { max_clusters: 3, ..ClusterConfig::default() };
        let mut clusters = Clusters::default();
        clusters.group(&config, &poses, &[0.9, 0.3, 0.8, 0.1, 0.1, 0.01]);
        assert_eq!((clusters.len(), clusters.largest()), (3, Some(0)));
        assert_eq!(clusters.members(1).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(clusters.outsiders().collect::<Vec<_>>(), [5]);
        clusters.group(&ClusterConfig { max_clusters: 0, ..config }, &poses, &[1.0; 6]);
        assert!(clusters.is_empty() && clusters.largest().is_none());
    }
}
