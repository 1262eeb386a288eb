//! Cost of a particle: motion, weight and drawing of survivors, on a world that is a formula.
#![allow(missing_docs, clippy::expect_used)]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use visloc_core::{Rng, RngTree, geom::PlanarPose};
use visloc_locate::{
    Localizer, ObservationModel, PlanarMotion, Region, StepInput,
    monte_carlo::{
        ClusterConfig, MonteCarlo, MonteCarloConfig, NoiseConfig, Particles, PoseNoise, Resampling,
        RestartConfig,
    },
    vision::Percept,
};

const COUNTS: [usize; 5] = [200, 1_000, 10_000, 100_000, 1_000_000];

/// Two places in 20 x 20 m that look alike; likelihood by the distance from the nearest.
struct TwoPlaces;

impl ObservationModel for TwoPlaces {
    fn condition_on(&mut self, _: &Percept) {}
    fn has_evidence(&self) -> bool {
        true
    }
    fn likelihood(&self, pose: &PlanarPose) -> f64 {
        self.log_likelihood(pose).exp()
    }
    fn log_likelihood(&self, pose: &PlanarPose) -> f64 {
        let square = |x: f64, y: f64| (pose.x_m - x) * (pose.x_m - x) + (pose.y_m - y) * (pose.y_m - y);
        -0.5 * square(5.0, 5.0).min(square(15.0, 12.0))
    }
    fn region(&self) -> Region {
        Region { min_x_m: 0.0, max_x_m: 20.0, min_y_m: 0.0, max_y_m: 20.0 }
    }
    fn max_jump_m(&self) -> f64 {
        2.0
    }
    fn propose(&self, rng: &mut Rng) -> PlanarPose {
        self.region().sample(rng)
    }
    fn propose_heading(&self, _: f64, _: f64, rng: &mut Rng) -> f64 {
        self.region().sample(rng).yaw_rad
    }
}

fn percept() -> Percept {
    Percept { quality: 1.0, is_informative: true, ..Percept::default() }
}

/// Odometry with noise on position and heading, a weight of the likelihood, and survivors after every image, all on one
/// core.
fn parts(c: &mut Criterion) {
    let mut group = c.benchmark_group("motion, weight, systematic resampling");
    let motion = PlanarMotion {
        old_from_new: PlanarPose::new(0.01, 0.0, 0.002),
        position_noise_m: 0.01,
        heading_noise_rad: 0.01,
        is_blind: false,
    };
    let noise = PoseNoise { position_m: 0.05, heading_rad: 0.01 };
    for count in COUNTS {
        let mut rng = RngTree::new(1).stream("bench", 0);
        let mut particles = Particles::default();
        particles.start((0..count).map(|_| TwoPlaces.region().sample(&mut rng)));
        let mut sources = Vec::new();
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| {
                particles.propagate(Some(&motion), &noise, &mut rng);
                particles.weigh(&TwoPlaces, 1.0, usize::MAX);
                sources.clear();
                Resampling::Systematic.draw(particles.weights(), count, &mut rng, &mut sources);
                particles.replace(&sources, &[], 0, []);
                black_box(particles.poses()[0])
            });
        });
    }
    group.finish();
}

/// A whole step with its estimate, on one core and on all.
fn steps(c: &mut Criterion) {
    for (name, parallel_from) in [("step, one core", usize::MAX), ("step, all cores", 1)] {
        let mut group = c.benchmark_group(name);
        for count in COUNTS {
            let config = MonteCarloConfig {
                num_particles: count,
                weight_exponent: 1.0,
                parallel_from,
                noise: NoiseConfig { position_m: 0.05, growth: 0.0, ..NoiseConfig::default() },
                restart: RestartConfig { min_likelihood: 0.0, ..RestartConfig::default() },
                clusters: ClusterConfig { max_clusters: 0, ..ClusterConfig::default() },
                ..MonteCarloConfig::systematic()
            };
            let mut filter = MonteCarlo::new(config, Box::new(TwoPlaces)).expect("a configuration");
            let percept = percept();
            let mut rng = RngTree::new(1).stream("bench", 0);
            let mut odometry = PlanarPose::default();
            group.throughput(Throughput::Elements(count as u64));
            group.bench_function(BenchmarkId::from_parameter(count), |b| {
                b.iter(|| {
                    odometry = odometry.compose(&PlanarPose::new(0.01, 0.0, 0.002));
                    let input = StepInput { percept: &percept, odometry: Some(odometry), is_lifted: false };
                    black_box(filter.step(&input, &mut rng).likelihood)
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, parts, steps);
criterion_main!(benches);
