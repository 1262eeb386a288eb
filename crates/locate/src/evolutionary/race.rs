//! One race: a population of exploiters around a hypothesis.

use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use visloc_core::{
    Rng, gaussian,
    geom::{PlanarPose, angle, weighted_pose_statistics},
};

use super::EvolutionaryConfig;
use crate::{ObservationModel, PlanarMotion, monte_carlo::share};

/// A pose with its health.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Exploiter {
    pub pose: PlanarPose,
    pub health: f64,
}

/// A population around one hypothesis.
#[derive(Debug, Clone)]
pub(super) struct Race {
    /// Names the race for as long as it lives.
    pub id: u64,
    /// Weighted mean of the elite.
    pub pose: PlanarPose,
    /// Spread of the population about the pose.
    pub covariance: Matrix3<f64>,
    /// How well the elite explains the images of late, 0 to 1.
    pub health: f64,
    /// How well the elite explains the last image, 0 to 1.
    pub last_health: f64,
    /// Evidence over many images against the best race: logarithm of odds, at most 0.
    pub evidence: f64,
    /// How often it was the best of late.
    pub victories: u32,
    /// Iterations in which it cannot be deleted.
    pub life: u32,
    pub exploiters: Vec<Exploiter>,
}

impl Race {
    /// A race of `size` around an explorer: its exploiters are the explorer with thermal noise.
    pub fn new(
        id: u64,
        explorer: Exploiter,
        size: usize,
        config: &EvolutionaryConfig,
        rng: &mut Rng,
    ) -> Self {
        let mut exploiters = Vec::with_capacity(size);
        exploiters.push(explorer);
        while exploiters.len() < size {
            let pose = disturbed(&explorer.pose, config.birth_noise_m, config.birth_noise_rad, rng);
            exploiters.push(Exploiter { pose, health: 0.0 });
        }
        Self {
            id,
            pose: explorer.pose,
            covariance: Matrix3::identity(),
            health: explorer.health,
            last_health: explorer.health,
            evidence: 0.0,
            victories: 0,
            life: config.birth_life,
            exploiters,
        }
    }

    /// Moves the race with the robot. The elite, which comes first, moves without noise.
    pub fn apply_motion(&mut self, motion: &PlanarMotion, config: &EvolutionaryConfig, rng: &mut Rng) {
        self.pose = motion.apply(&self.pose);
        let num_elite = share(config.elite_share, self.exploiters.len());
        for (i, exploiter) in self.exploiters.iter_mut().enumerate() {
            exploiter.pose = if i < num_elite {
                motion.apply(&exploiter.pose)
            } else {
                motion.sample(&exploiter.pose, rng)
            };
        }
    }

    /// Weighs all exploiters against the last image, sorts them, and takes pose and health from the elite.
    pub fn weigh(&mut self, model: &dyn ObservationModel, config: &EvolutionaryConfig) {
        let region = model.region();
        for exploiter in &mut self.exploiters {
            let is_possible = region.contains(&exploiter.pose);
            exploiter.health = if is_possible { model.likelihood(&exploiter.pose) } else { 0.0 };
        }
        // Stable, so that equals keep their order and a run can be repeated.
        self.exploiters.sort_by(|a, b| b.health.total_cmp(&a.health));
        let num_elite = share(config.elite_share, self.exploiters.len()).max(1);
        let elite = &self.exploiters[..num_elite];
        let health = elite.iter().map(|e| e.health).sum::<f64>() / num_elite as f64;
        self.last_health = health;
        self.health += config.health_follow * (health - self.health);
        let weighted = |e: &Exploiter| (e.pose, config.weight(e.health));
        if let Some(statistics) = weighted_pose_statistics(elite.iter().map(weighted)) {
            self.pose = statistics.mean;
        }
        if let Some(covariance) = covariance_about(&self.pose, self.exploiters.iter().map(weighted)) {
            self.covariance = covariance;
        }
    }

    /// The next generation, of `size` exploiters: elite unchanged, crossover, mutation. Expects sorted exploiters.
    /// Deviation: the parent is the healthier of two random exploiters, not any one, so that a race keeps up with a
    /// robot whose motion is not known.
    pub fn evolve(
        &mut self,
        size: usize,
        config: &EvolutionaryConfig,
        rng: &mut Rng,
        parents: &mut Vec<Exploiter>,
    ) {
        let count = self.exploiters.len();
        parents.clear();
        parents.extend_from_slice(&self.exploiters);
        let num_elite = share(config.elite_share, size).clamp(1, count);
        let num_crossed = share(config.crossover_share, size).min(size.saturating_sub(num_elite));
        self.exploiters.resize(size, parents[0]);
        let misfit = (config.fit_health - self.last_health).max(0.0);
        let growth = 1.0 + config.noise_growth * misfit * 10.0;
        for (i, child) in self.exploiters.iter_mut().enumerate().skip(num_elite) {
            // Sorted by health: the smaller of two draws is the healthier of two exploiters.
            let mother = parents[rng.random_range(0..count).min(rng.random_range(0..count))].pose;
            child.pose = if i < num_elite + num_crossed {
                let father = parents[rng.random_range(0..count)].pose;
                midpoint(&mother, &father)
            } else {
                let (noise_m, noise_rad) = (config.mutation_noise_m, config.mutation_noise_rad);
                disturbed(&mother, noise_m * growth, noise_rad * growth, rng)
            };
        }
    }

    /// Whether another pose stands for the same place.
    pub fn is_near(&self, pose: &PlanarPose, config: &EvolutionaryConfig) -> bool {
        self.pose.distance_m(pose) < config.merge_distance_m
            && self.pose.heading_difference_rad(pose) < config.merge_turn_rad
    }

    /// Whether the race may be deleted or replaced.
    pub fn is_expendable(&self) -> bool {
        self.life == 0 && self.victories == 0
    }
}

/// A pose with thermal noise.
fn disturbed(pose: &PlanarPose, noise_m: f64, noise_rad: f64, rng: &mut Rng) -> PlanarPose {
    let turn_rad = if noise_rad > 0.0 { gaussian(rng, noise_rad) } else { 0.0 };
    PlanarPose::new(
        pose.x_m + gaussian(rng, noise_m),
        pose.y_m + gaussian(rng, noise_m),
        pose.yaw_rad + turn_rad,
    )
}

/// Weighted second moments of poses about a given pose. `None` if the weights do not sum to a positive number.
fn covariance_about(
    center: &PlanarPose,
    weighted_poses: impl Iterator<Item = (PlanarPose, f64)>,
) -> Option<Matrix3<f64>> {
    let (mut total, mut covariance) = (0.0, Matrix3::zeros());
    for (pose, weight) in weighted_poses {
        let turn_rad = angle::difference(pose.yaw_rad, center.yaw_rad);
        let d = Vector3::new(pose.x_m - center.x_m, pose.y_m - center.y_m, turn_rad);
        covariance += d * d.transpose() * weight;
        total += weight;
    }
    (total > 0.0 && f64::is_finite(total)).then(|| covariance / total)
}

/// The pose halfway between two poses, the short way around for the heading.
fn midpoint(a: &PlanarPose, b: &PlanarPose) -> PlanarPose {
    let turn = angle::difference(b.yaw_rad, a.yaw_rad);
    PlanarPose::new(f64::midpoint(a.x_m, b.x_m), f64::midpoint(a.y_m, b.y_m), a.yaw_rad + turn / 2.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use visloc_core::RngTree;

    use super::*;

    #[test]
    fn midpoint_takes_the_short_way_around() {
        let middle = midpoint(&PlanarPose::new(0.0, 2.0, PI - 0.2), &PlanarPose::new(2.0, 0.0, -PI + 0.4));
        assert!(middle.distance_m(&PlanarPose::new(1.0, 1.0, 0.0)) < 1e-12);
        assert!(middle.heading_difference_rad(&PlanarPose::new(0.0, 0.0, -PI + 0.1)) < 1e-9);
    }

    #[test]
    fn evolution_keeps_the_elite_and_the_size() {
        let config = EvolutionaryConfig::default();
        let mut rng = RngTree::new(9).stream("race", 0);
        let explorer = Exploiter { pose: PlanarPose::new(1.0, -1.0, 0.5), health: 0.9 };
        let mut race = Race::new(0, explorer, 30, &config, &mut rng);
        assert_eq!((race.life, race.victories, race.exploiters.len()), (3, 0, 30));
        let elite: Vec<_> = race.exploiters[..6].to_vec();
        let crossed_bounds = race.exploiters.clone();
        race.evolve(30, &config, &mut rng, &mut Vec::new());
        assert_eq!(race.exploiters.len(), 30);
        assert_eq!(race.exploiters[..6], elite);
        // a child of two parents lies inside the parents' bounds
        let max_x = crossed_bounds.iter().map(|e| e.pose.x_m).fold(f64::MIN, f64::max);
        let min_x = crossed_bounds.iter().map(|e| e.pose.x_m).fold(f64::MAX, f64::min);
        assert!(race.exploiters[6..12].iter().all(|e| (min_x..=max_x).contains(&e.pose.x_m)));
    }

    /// A race whose exploiters are at x = 0, 1, 2 ... and ever less healthy.
    fn row(count: usize, config: &EvolutionaryConfig, rng: &mut Rng) -> Race {
        let at =
            |i: usize| Exploiter { pose: PlanarPose::new(i as f64, 0.0, 0.0), health: 1.0 / (i + 1) as f64 };
        let mut race = Race::new(0, at(0), count, config, rng);
        race.exploiters = (0..count).map(at).collect();
        race
    }

    #[test]
    fn healthy_exploiters_have_more_children() {
        let config = EvolutionaryConfig {
            crossover_share: 0.0,
            mutation_noise_m: 0.0,
            mutation_noise_rad: 0.0,
            ..EvolutionaryConfig::default()
        };
        let mut rng = RngTree::new(3).stream("race", 0);
        let mut of_healthy_half = 0;
        for _ in 0..50 {
            let mut race = row(100, &config, &mut rng);
            race.evolve(100, &config, &mut rng, &mut Vec::new());
            of_healthy_half += race.exploiters[20..].iter().filter(|e| e.pose.x_m < 49.5).count();
        }
        // the healthier of two at random is in the healthier half three times of four
        let share = f64::from(u32::try_from(of_healthy_half).unwrap()) / 4000.0;
        assert!((share - 0.75).abs() < 0.03, "{share}");
    }

    #[test]
    fn thermal_noise_has_its_size_and_grows_with_the_misfit() {
        let config = EvolutionaryConfig { crossover_share: 0.0, ..EvolutionaryConfig::default() };
        let mut rng = RngTree::new(4).stream("race", 0);
        let spread = |members: &[Exploiter], value: fn(&PlanarPose) -> f64| {
            let squares: f64 = members.iter().map(|e| value(&e.pose).powi(2)).sum();
            (squares / members.len() as f64).sqrt()
        };
        let (x, yaw) = (|p: &PlanarPose| p.x_m, |p: &PlanarPose| p.yaw_rad);
        let explorer = Exploiter { pose: PlanarPose::default(), health: 0.95 };
        let born = Race::new(0, explorer, 4000, &config, &mut rng);
        assert!((spread(&born.exploiters[1..], x) / config.birth_noise_m - 1.0).abs() < 0.05);
        assert!((spread(&born.exploiters[1..], yaw) / config.birth_noise_rad - 1.0).abs() < 0.05);
        // 0.2 below a good fit: 1 + 1.5 * 2 times as much noise
        for (health, growth) in [(0.95, 1.0), (config.fit_health - 0.2, 4.0)] {
            let mut race = born.clone();
            race.exploiters.fill(explorer);
            race.last_health = health;
            race.evolve(4000, &config, &mut rng, &mut Vec::new());
            let mutated = &race.exploiters[800..];
            assert!((spread(mutated, x) / (growth * config.mutation_noise_m) - 1.0).abs() < 0.05);
            assert!((spread(mutated, yaw) / (growth * config.mutation_noise_rad) - 1.0).abs() < 0.05);
        }
    }
}
