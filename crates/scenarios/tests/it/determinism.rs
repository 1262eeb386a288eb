//! Same seed, same bits, on any number of threads.

use visloc_core::SourceFrame;
use visloc_locate::{ALGORITHMS, FeatureChoice};
use visloc_scenarios::{Replay, collect, run};
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

/// A short run with a kidnap in it.
fn frames(seed: u64, num_threads: usize) -> Vec<SourceFrame> {
    let text = "summary = \"test\"\nmap = \"robocup-spl-2010\"\nduration_secs = 6.0\nframes_per_sec = 15.0\n\
        [start]\nx_m = 1.0\ny_m = 0.5\nyaw_deg = 10.0\n\
        [[motion]]\nwalk = { through_m = [[1.3, 0.6]] }\n\
        [[motion]]\ncarry = { secs = 0.6, lift_m = 0.3, has_foot_signal = true }\n\
        [[motion]]\nturn.angle_deg = 60.0\n";
    let scenario = Scenario::parse("test.toml", text).unwrap();
    collect(&mut Simulation::new(&scenario, seed).unwrap().with_threads(num_threads)).unwrap()
}

/// Bits of every estimate.
fn bits(frames: &[SourceFrame], algorithm: &str, features: FeatureChoice, seed: u64) -> Vec<[u64; 4]> {
    let map = Map::load("robocup-spl-2010").unwrap();
    let estimates = run(&mut Replay::new(frames), &map, algorithm, features, seed).unwrap().estimates;
    let bits = |e: &visloc_core::eval::EstimateSample| {
        let pose = e.world_from_robot;
        [pose.x_m, pose.y_m, pose.yaw_rad, e.reliability.unwrap_or(-1.0)].map(f64::to_bits)
    };
    estimates.iter().map(bits).collect()
}

#[test]
fn same_seed_same_bits_and_another_seed_other_bits() {
    let [frames, again] = [3, 3].map(|seed| frames(seed, 1));
    for algorithm in ALGORITHMS {
        for features in [FeatureChoice::Pixels, FeatureChoice::Rich] {
            let bits = |frames: &[SourceFrame], seed: u64| bits(frames, algorithm.name, features, seed);
            let first = bits(&frames, 3);
            assert_eq!(first.len(), 90);
            assert_eq!(first, bits(&again, 3), "{} {features:?}", algorithm.name);
            // The grid alone draws no random numbers.
            let is_random = algorithm.name != "markov" || features == FeatureChoice::Rich;
            assert_eq!(first != bits(&frames, 4), is_random, "{} {features:?}", algorithm.name);
        }
    }
}

/// The number of threads decides who draws which frame; what follows sees only the frames.
#[test]
fn another_number_of_threads_same_bits() {
    let one = frames(5, 1);
    for num_threads in [2, 4, 7] {
        let many = frames(5, num_threads);
        assert_eq!(one.len(), many.len());
        for (a, b) in one.iter().zip(&many) {
            assert!(a.frame.image == b.frame.image, "on {num_threads} threads: the image at {}", a.frame.at);
            let rest = |of: &SourceFrame| {
                let frame = &of.frame;
                (
                    frame.at,
                    frame.camera_index,
                    frame.robot_from_camera,
                    frame.odometry,
                    frame.ground_contact,
                    of.truth,
                )
            };
            assert_eq!(rest(a), rest(b), "on {num_threads} threads");
        }
    }
}
