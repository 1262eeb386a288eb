//! Same seed, same bits, on any number of threads.

use visloc_locate::ALGORITHMS;
use visloc_scenarios::run;
use visloc_sim::{Scenario, Simulation};

/// Bits of every estimate of a short run with a kidnap in it.
fn bits(algorithm: &str, seed: u64, num_threads: usize) -> Vec<[u64; 4]> {
    let text = "summary = \"test\"\nmap = \"robocup-spl-2010\"\nduration_secs = 6.0\nframes_per_sec = 15.0\n\
        [start]\nx_m = 1.0\ny_m = 0.5\nyaw_deg = 10.0\n\
        [[motion]]\nwalk = { through_m = [[1.3, 0.6]] }\n\
        [[motion]]\ncarry = { secs = 0.6, lift_m = 0.3, has_foot_signal = true }\n\
        [[motion]]\nturn.angle_deg = 60.0\n";
    let scenario = Scenario::parse("test.toml", text).unwrap();
    let mut simulation = Simulation::new(&scenario, seed).unwrap().with_threads(num_threads);
    let map = simulation.map().clone();
    let estimates = run(&mut simulation, &map, algorithm, None, seed).unwrap().estimates;
    let bits = |e: &visloc_eval::EstimateSample| {
        let pose = e.world_from_robot;
        [pose.x_m, pose.y_m, pose.yaw_rad, e.reliability.unwrap_or(-1.0)].map(f64::to_bits)
    };
    estimates.iter().map(bits).collect()
}

#[test]
fn same_seed_same_bits_and_another_seed_other_bits() {
    for algorithm in ALGORITHMS {
        let first = bits(algorithm.name, 3, 1);
        assert_eq!(first.len(), 90);
        assert_eq!(first, bits(algorithm.name, 3, 1), "{}", algorithm.name);
        assert_ne!(first, bits(algorithm.name, 4, 1), "{}", algorithm.name);
    }
}

#[test]
fn another_number_of_threads_same_bits() {
    for algorithm in ALGORITHMS {
        let one = bits(algorithm.name, 5, 1);
        for num_threads in [2, 4, 7] {
            assert_eq!(one, bits(algorithm.name, 5, num_threads), "{} on {num_threads}", algorithm.name);
        }
    }
}
