//! Groups of particles that stand for one place.

use serde::{Deserialize, Serialize};
use visloc_geom::{PlanarPose, weighted_pose_statistics};

use crate::{ConfigError, Hypothesis, require};

/// When two particles stand for the same place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClusterConfig {
    /// Largest distance from the group's best particle, meters.
    pub max_distance_m: f64,
    /// Largest difference of the heading, radians; wraps at +-pi.
    pub max_turn_rad: f64,
    /// At most so many groups; what is left joins none.
    pub max_clusters: usize,
}

impl Default for ClusterConfig {
    fn default() -> Self {
        Self { max_distance_m: 0.6, max_turn_rad: 0.5, max_clusters: 12 }
    }
}

impl ClusterConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        require(self.max_distance_m > 0.0, "clusters.max_distance_m", "above 0", self.max_distance_m)?;
        require(self.max_turn_rad > 0.0, "clusters.max_turn_rad", "above 0", self.max_turn_rad)?;
        require(
            (1..=1000).contains(&self.max_clusters),
            "clusters.max_clusters",
            "1 to 1000",
            self.max_clusters,
        )
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
        self.order.clear();
        self.order.extend(0..poses.len());
        self.order.sort_unstable_by(|a, b| weights[*b].total_cmp(&weights[*a]).then(a.cmp(b)));
        self.leaders.clear();
        self.cluster_of.clear();
        self.cluster_of.resize(poses.len(), NONE);
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
        let total: f64 = weights.iter().sum();
        for cluster in 0..self.leaders.len() {
            let members = || (0..poses.len()).filter(|i| self.cluster_of[*i] == cluster);
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

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
}
