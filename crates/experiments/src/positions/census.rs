//! How many individuals hold each position.

use visloc_locate::Individual;

/// An individual this near a position holds it, meters. Source: 2017 section 5.1.1.
pub const NEAR_M: f64 = 2.0;
/// By the strict criterion a position must be held by this part of its fair share of the individuals.
const STRICT_SHARE: f64 = 0.25;

/// Individuals near each position.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Census {
    counts: Vec<u32>,
}

impl Census {
    /// From counts near each position.
    pub fn of(counts: Vec<u32>) -> Self {
        Self { counts }
    }

    /// Counts the individuals near each position. It keeps its buffer.
    pub fn count(&mut self, positions: &[[f64; 2]], individuals: &[Individual]) {
        self.counts.clear();
        for position in positions {
            let is_near = |individual: &&Individual| {
                let pose = individual.world_from_robot;
                (position[0] - pose.x_m).powi(2) + (position[1] - pose.y_m).powi(2) <= NEAR_M * NEAR_M
            };
            self.counts.push(u32::try_from(individuals.iter().filter(is_near).count()).unwrap_or(u32::MAX));
        }
    }

    /// How many individuals are near each position.
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// The published criterion: somebody is near every position.
    pub fn holds_all(&self) -> bool {
        self.counts.iter().all(|count| *count > 0)
    }

    /// The strict criterion: near every position is at least a quarter of the individuals that it would have if all
    /// `num_individuals` were shared equally. Particles that know nothing pass the published criterion, but not this one.
    pub fn holds_all_strictly(&self, num_individuals: usize) -> bool {
        let fair = num_individuals as f64 / self.counts.len() as f64;
        self.counts.iter().all(|count| f64::from(*count) >= STRICT_SHARE * fair)
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::PlanarPose;

    use super::*;

    #[test]
    fn criteria_by_hand() {
        let at = |x: f64| Individual {
            world_from_robot: PlanarPose::new(x, 0.0, 0.0),
            likelihood: 1.0,
            population: 0,
        };
        // 7 near the first position, 1 near the second: its fair share is 4, a quarter of that is 1
        let mut individuals: Vec<_> = (0..7).map(|i| at(-5.0 + 0.2 * f64::from(i))).collect();
        individuals.push(at(6.9));
        let positions = [[-5.0, 0.0], [5.0, 0.0]];
        let mut census = Census::default();
        census.count(&positions, &individuals);
        assert_eq!(census.counts(), [7, 1]);
        assert!(census.holds_all() && census.holds_all_strictly(8));
        assert!(!census.holds_all_strictly(9), "1 is less than a quarter of 4.5");
        individuals.pop();
        census.count(&positions, &individuals);
        assert!(!census.holds_all());
    }
}
