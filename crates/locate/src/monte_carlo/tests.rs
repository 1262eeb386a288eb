//! The filter as a whole, on a world that is a formula.

use std::sync::{Arc, Mutex};

use rayon::prelude::*;
use visloc_core::{Rng, RngTree, geom::PlanarPose};

use super::*;
use crate::{
    Localizer, MotionConfig, ObservationModel, PosePrior, Region, StartPrior, StepInput, vision::Percept,
};

/// A square map of 20 m with places that look alike; the robot is at one of them, and knows it from nothing else.
#[derive(Clone)]
struct Places {
    /// Shared with the model inside of the filter, which looks at them once for each image.
    truth: Arc<Mutex<Vec<(f64, f64)>>>,
    places: Vec<(f64, f64)>,
    floor: f64,
}

impl Places {
    fn new(places: &[(f64, f64)]) -> Self {
        Self { truth: Arc::new(Mutex::new(places.to_vec())), places: Vec::new(), floor: 0.01 }
    }

    fn set(&self, places: &[(f64, f64)]) {
        *self.truth.lock().unwrap() = places.to_vec();
    }
}

impl ObservationModel for Places {
    fn condition_on(&mut self, _: &Percept) {
        self.places.clone_from(&self.truth.lock().unwrap());
    }
    fn has_evidence(&self) -> bool {
        true
    }
    fn likelihood(&self, pose: &PlanarPose) -> f64 {
        let squares = self.places.iter().map(|(x, y)| (pose.x_m - x).powi(2) + (pose.y_m - y).powi(2));
        let nearest = squares.fold(f64::INFINITY, f64::min);
        self.floor + (1.0 - self.floor) * (-0.5 * nearest).exp()
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

/// A filter on a formula: constant noise of 0.05 m on positions, weights are likelihoods, no new start.
fn plain(config: MonteCarloConfig, num_particles: usize) -> MonteCarloConfig {
    MonteCarloConfig {
        num_particles,
        weight_exponent: 1.0,
        noise: NoiseConfig { position_m: 0.05, heading_rad: 0.0, growth: 0.0, ..NoiseConfig::default() },
        initialization: InitializationConfig { aimed_share: 0.0, ..InitializationConfig::default() },
        restart: RestartConfig { min_likelihood: 0.0, ..RestartConfig::default() },
        clusters: ClusterConfig {
            max_distance_m: 2.0,
            max_turn_rad: std::f64::consts::PI,
            max_clusters: config.clusters.max_clusters,
        },
        motion: MotionConfig { blind_noise_m: 0.0, blind_noise_rad: 0.0, ..MotionConfig::default() },
        ..config
    }
}

struct Run {
    filter: MonteCarlo,
    places: Places,
    percept: Percept,
    rng: Rng,
}

impl Run {
    fn new(config: MonteCarloConfig, places: &[(f64, f64)], seed: u64) -> Self {
        let places = Places::new(places);
        let filter = MonteCarlo::new(config, Box::new(places.clone())).unwrap();
        Self { filter, places, percept: percept(), rng: RngTree::new(seed).stream("filter", 0) }
    }

    fn step(&mut self) {
        self.step_with(None, false);
    }

    fn step_with(&mut self, odometry: Option<PlanarPose>, is_lifted: bool) {
        let input = StepInput { percept: &self.percept, odometry, is_lifted };
        self.filter.step(&input, &mut self.rng);
    }

    /// Share of the particles within 2 m.
    fn share_near(&self, (x, y): (f64, f64)) -> f64 {
        let poses = self.filter.particles().poses();
        let near = poses.iter().filter(|pose| (pose.x_m - x).hypot(pose.y_m - y) <= 2.0).count();
        near as f64 / poses.len() as f64
    }
}

fn all_presets() -> [(&'static str, MonteCarloConfig); 6] {
    [
        ("mc", MonteCarloConfig::classic()),
        ("mce", MonteCarloConfig::default()),
        ("mca", MonteCarloConfig::augmented()),
        ("mcae", MonteCarloConfig::augmented_elite()),
        ("kld", MonteCarloConfig::kld()),
        ("mc-systematic", MonteCarloConfig::systematic()),
    ]
}

#[test]
fn every_composition_finds_the_place_and_repeats_itself() {
    for (name, config) in all_presets() {
        config.check().unwrap();
        for scheme in
            [Resampling::Roulette, Resampling::Systematic, Resampling::Stratified, Resampling::Residual]
        {
            for trigger in [ResamplingTrigger::Always, ResamplingTrigger::EffectiveSampleSize] {
                let resampling = ResamplingConfig { scheme, trigger, ..config.resampling };
                let config = plain(MonteCarloConfig { resampling, ..config }, 400);
                let mut twins = [0, 1].map(|_| Run::new(config, &[(14.0, 6.0)], 7));
                for _ in 0..60 {
                    twins.iter_mut().for_each(Run::step);
                }
                assert_eq!(twins[0].filter.particles().poses(), twins[1].filter.particles().poses());
                let near = twins[0].share_near((14.0, 6.0));
                let estimate = twins[0].filter.estimate();
                let error = estimate.world_from_robot.distance_m(&PlanarPose::new(14.0, 6.0, 0.0));
                assert!(near > 0.6 && error < 0.5, "{name} {scheme:?} {trigger:?}: {near} {error}");
                assert!(estimate.is_localized(), "{name} {scheme:?} {trigger:?}");
                let total: f64 = estimate.hypotheses.iter().map(|h| h.probability).sum();
                assert!((total - 1.0).abs() < 1e-9);
            }
        }
    }
}

/// The robot is carried at least 8 m away after 200 images; found again when more than half of the particles are within
/// 2 m. 100 fixed seeds, all of which must succeed, half of them within 15 images.
#[test]
fn augmented_filters_find_a_kidnapped_robot_every_time() {
    for (name, config) in
        [("mca", MonteCarloConfig::augmented()), ("mcae", MonteCarloConfig::augmented_elite())]
    {
        let runs = (0..100).into_par_iter().filter_map(|seed| kidnap(plain(config, 500), seed));
        let mut iterations: Vec<u32> = runs.collect();
        iterations.sort_unstable();
        assert_eq!(iterations.len(), 100, "{name}");
        assert!(iterations[50] <= 15, "{name}: median {}", iterations[50]);
        println!("{name}: median {}, longest {}", iterations[50], iterations[99]);
    }
}

fn kidnap(mut config: MonteCarloConfig, seed: u64) -> Option<u32> {
    if config.sample_size.min_per_hypothesis == 0 {
        config.clusters.max_clusters = 0; // hypotheses are not asked for, and cost most of the time
    }
    let mut scenario = RngTree::new(seed).stream("scenario", 0);
    let region = Places::new(&[]).region();
    let from = region.sample(&mut scenario);
    let to = loop {
        let to = region.sample(&mut scenario);
        if to.distance_m(&from) >= 8.0 {
            break to;
        }
    };
    let mut run = Run::new(config, &[(from.x_m, from.y_m)], seed);
    for _ in 0..200 {
        run.step();
    }
    assert!(run.share_near((from.x_m, from.y_m)) > 0.5, "had converged before");
    run.places.set(&[(to.x_m, to.y_m)]);
    (1..=200).find(|_| {
        run.step();
        run.share_near((to.x_m, to.y_m)) > 0.5
    })
}

#[test]
fn without_injection_a_kidnapped_robot_stays_lost() {
    let found =
        (0..10).filter(|seed| kidnap(plain(MonteCarloConfig::classic(), 500), *seed).is_some()).count();
    assert_eq!(found, 0);
}

/// Three places that look alike, moved to by chance alone in other filters: a minimum for each hypothesis keeps all of
/// them with few particles. 20 fixed seeds, all of which must keep a quarter of the fair share of every place.
#[test]
fn a_minimum_for_each_hypothesis_keeps_ambiguity() {
    let places = [(3.0, 3.0), (10.0, 16.0), (17.0, 5.0)];
    let survivors = |min_per_hypothesis| {
        let mut config = plain(kld(), 2000);
        config.sample_size.min_per_hypothesis = min_per_hypothesis;
        let keeps_all = |seed: u64| {
            let mut run = Run::new(config, &places, seed);
            for _ in 0..300 {
                run.step();
            }
            places.iter().all(|place| run.share_near(*place) >= 0.25 / 3.0)
        };
        (0..20).into_par_iter().filter(|seed| keeps_all(*seed)).count()
    };
    assert_eq!(survivors(40), 20);
    assert!(survivors(0) < 20, "and by chance some are lost");
}

/// KLD-sampling with the parameters of the literature.
fn kld() -> MonteCarloConfig {
    let sample_size =
        SampleSizeConfig { rule: SampleSizeRule::Kld, min_per_hypothesis: 20, ..SampleSizeConfig::default() };
    MonteCarloConfig { sample_size, ..MonteCarloConfig::kld() }
}

#[test]
fn kld_uses_a_tenth_of_the_particles_once_it_knows() {
    for seed in 0..5 {
        let mut run = Run::new(plain(kld(), 2000), &[(5.0, 5.0)], seed);
        run.step();
        let at_start = run.filter.particles().len();
        for _ in 0..80 {
            run.step();
        }
        let after = run.filter.particles().len();
        assert!(after >= 50 && at_start >= 10 * after.min(200), "{at_start} then {after}");
        assert!(run.share_near((5.0, 5.0)) > 0.9);
    }
}

#[test]
fn the_elite_is_exempt_from_noise() {
    let config = MonteCarloConfig { elite_share: 0.2, ..MonteCarloConfig::default() };
    let mut run = Run::new(plain(config, 50), &[(10.0, 10.0)], 1);
    run.step();
    let elite = run.filter.particles().poses()[..10].to_vec();
    let others = run.filter.particles().poses()[10..].to_vec();
    let distance = |pose: &PlanarPose| (pose.x_m - 10.0).hypot(pose.y_m - 10.0);
    assert!(elite.windows(2).all(|pair| distance(&pair[0]) <= distance(&pair[1])), "the best first");
    run.filter.propagate_for_test(None, &mut run.rng);
    assert_eq!(run.filter.particles().poses()[..10], elite);
    assert!(run.filter.particles().poses()[10..].iter().zip(&others).all(|(new, old)| new != old));
    // and moves with the robot without noise
    run.filter.propagate_for_test(Some(PlanarPose::default()), &mut run.rng);
    run.filter.propagate_for_test(Some(PlanarPose::new(0.5, 0.0, 0.0)), &mut run.rng);
    let step = PlanarPose::new(0.5, 0.0, 0.0);
    let moved = &run.filter.particles().poses()[..10];
    assert!(moved.iter().zip(&elite).all(|(new, old)| new.distance_m(&old.compose(&step)) < 1e-12));
}

#[test]
fn weights_last_until_survivors_are_drawn() {
    let resampling = ResamplingConfig {
        trigger: ResamplingTrigger::EffectiveSampleSize,
        min_effective_share: 0.0,
        ..ResamplingConfig::default()
    };
    let config = plain(MonteCarloConfig { resampling, elite_share: 0.0, ..MonteCarloConfig::default() }, 100);
    let config = MonteCarloConfig { noise: NoiseConfig { position_m: 0.0, ..config.noise }, ..config };
    let mut run = Run::new(config, &[(10.0, 10.0)], 3);
    run.step();
    let (poses, once) = (run.filter.particles().poses().to_vec(), run.filter.particles().weights().to_vec());
    run.step();
    assert_eq!(run.filter.particles().poses(), poses, "nobody is drawn");
    let twice = run.filter.particles().weights();
    assert!(twice.iter().zip(&once).all(|(twice, once)| (twice - once * once).abs() < 1e-9));
}

#[test]
fn newcomers_by_hand() {
    let injection = InjectionConfig { max_share: 1.0, min_share: 0.25, ..InjectionConfig::default() };
    let config = MonteCarloConfig { injection, elite_share: 0.1, ..MonteCarloConfig::default() };
    let mut run = Run::new(plain(config, 40), &[(10.0, 10.0)], 3);
    for _ in 0..40 {
        run.step();
    }
    let particles = run.filter.particles();
    assert_eq!(particles.len(), 40);
    // 4 elite, 26 drawn, 10 newcomers at the end, which have not been weighed
    assert!(particles.likelihoods()[..30].iter().all(|likelihood| *likelihood > 0.0));
    assert_eq!(particles.likelihoods()[30..], [0.0; 10]);
    let mean: f64 = particles.likelihoods()[..30].iter().sum::<f64>() / 30.0;
    assert!((particles.mean_likelihood(false) - mean).abs() < 1e-12);
    assert!((particles.mean_likelihood(true) - mean * 0.75).abs() < 1e-12);
}

#[test]
fn starts_from_a_prior() {
    let at = |x, y| PosePrior {
        world_from_robot: PlanarPose::new(x, y, 1.0),
        position_spread_m: 0.1,
        heading_spread_rad: 0.1,
        weight: 1.0,
    };
    let mut run = Run::new(plain(MonteCarloConfig::default(), 200), &[(4.0, 4.0), (16.0, 16.0)], 5);
    run.filter.reset_to(&StartPrior::Poses(vec![at(4.0, 4.0), at(4.0, 12.0)]));
    run.percept.is_informative = false;
    for _ in 0..30 {
        run.step();
    }
    assert!(run.share_near((4.0, 4.0)) > 0.95, "the other place was never in question");
    let estimate = run.filter.estimate().world_from_robot;
    assert!(estimate.heading_difference_rad(&PlanarPose::new(0.0, 0.0, 1.0)) < 0.2);
    run.filter.reset();
    assert!(run.filter.particles().is_empty() && run.filter.estimate().reliability == 0.0);
}

/// Two places look alike. A robot that is lifted at one of them and set back is found there at once if the old pose is
/// kept, and either place remains possible.
#[test]
fn the_old_pose_is_one_more_hypothesis() {
    let places = [(4.0, 4.0), (16.0, 16.0)];
    let mut config = plain(MonteCarloConfig::kld(), 400);
    config.initialization.keep_old_pose_share = 0.25;
    let mut run = Run::new(config, &places[..1], 11);
    for _ in 0..60 {
        run.step();
    }
    assert!(run.filter.estimate().is_localized());
    run.places.set(&places);
    run.step_with(None, true);
    run.step_with(None, true);
    assert!(run.filter.particles().is_empty() && run.filter.estimate().reliability == 0.0);
    run.step();
    let (near, far) = (run.share_near(places[0]), run.share_near(places[1]));
    assert!(near > 0.5 && far > 0.02, "{near} {far}");
}

#[test]
fn one_two_and_eight_threads_give_equal_bits() {
    let run = |num_threads: usize, parallel_from: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(num_threads).build().unwrap();
        let config = MonteCarloConfig { parallel_from, ..MonteCarloConfig::augmented_elite() };
        let mut run = Run::new(plain(config, 3000), &[(6.0, 15.0)], 2);
        pool.install(|| (0..20).for_each(|_| run.step()));
        let bits = |pose: &PlanarPose| [pose.x_m, pose.y_m, pose.yaw_rad].map(f64::to_bits);
        run.filter.particles().poses().iter().map(bits).collect::<Vec<_>>()
    };
    let sequential = run(1, usize::MAX);
    for num_threads in [1, 2, 8] {
        assert_eq!(run(num_threads, 1), sequential, "{num_threads} threads");
    }
}

#[test]
fn broken_likelihoods_are_survived() {
    let mut run = Run::new(plain(MonteCarloConfig::default(), 60), &[(10.0, 10.0)], 2);
    run.step();
    run.places.floor = f64::NAN;
    let mut filter =
        MonteCarlo::new(plain(MonteCarloConfig::default(), 60), Box::new(run.places.clone())).unwrap();
    let input = StepInput { percept: &run.percept, odometry: None, is_lifted: false };
    for _ in 0..5 {
        let estimate = filter.step(&input, &mut run.rng);
        assert!(estimate.world_from_robot.is_finite() && estimate.reliability == 0.0);
    }
    assert!(filter.particles().poses().iter().all(PlanarPose::is_finite));
}

#[test]
fn values_out_of_range_are_refused() {
    for (text, key) in [
        ("num_particles = 1", "num_particles"),
        ("elite_share = 1.0", "elite_share"),
        ("weight_exponent = 0.0", "weight_exponent"),
        ("[injection]\nalpha_slow = 0.5", "injection.alpha_slow"),
        ("[sample_size]\ndelta = 0.0", "sample_size.delta"),
        ("[resampling]\nmin_effective_share = 2.0", "resampling.min_effective_share"),
        ("[estimate]\nshare = 0.0", "estimate.share"),
        ("[restart]\nafter = 0", "restart.after"),
        ("[noise]\nposition_m = -1.0", "noise.position_m"),
        (
            "[clusters]\nmax_clusters = 0\n[sample_size]\nmin_per_hypothesis = 5",
            "sample_size.min_per_hypothesis",
        ),
    ] {
        let config: MonteCarloConfig = toml::from_str(text).unwrap();
        let error = config.check().unwrap_err().to_string();
        assert!(error.starts_with(&format!("{key}:")), "{text}: {error}");
    }
    for (_, config) in all_presets() {
        let text = toml::to_string(&config).unwrap();
        assert_eq!(toml::from_str::<MonteCarloConfig>(&text).unwrap(), config);
    }
}
