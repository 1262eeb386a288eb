//! Every algorithm finds and follows a robot, over lists of seeds.

use visloc_data::bag::{BagReader, BagTopics};
use visloc_locate::ALGORITHMS;
use visloc_scenarios::{Run, run};
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

fn simulate(scenario: &str, num_frames: usize, algorithm: &str, seed: u64) -> Run {
    let scenario = Scenario::load(scenario).unwrap();
    let mut simulation =
        Simulation::new(&scenario, seed).unwrap().with_threads(2).with_num_frames(num_frames);
    let map = simulation.map().clone();
    run(&mut simulation, &map, algorithm, None, seed).unwrap()
}

fn replay(bag: &str, algorithm: &str, seed: u64) -> Run {
    let path = format!("{}/../../testdata/{bag}", env!("CARGO_MANIFEST_DIR"));
    let mut reader = BagReader::open(path, BagTopics::default()).unwrap();
    run(&mut reader, &Map::load("robocup-spl-2010").unwrap(), algorithm, None, seed).unwrap()
}

/// Twelve seconds of the simulated tour, each algorithm on three seeds: the robot is found within 8 s and then followed
/// to a few centimeters, or on its grid to a tile of half a meter. One run in all may fail: a start from which no goal
/// is seen for long.
#[test]
fn every_algorithm_finds_the_robot_on_a_tour() {
    let mut failures = Vec::new();
    for algorithm in ALGORITHMS {
        let limit_m = if algorithm.name == "markov" { 0.5 } else { 0.2 };
        for seed in [1, 2, 3] {
            let evaluation = simulate("tour", 360, algorithm.name, seed).evaluation;
            let found = evaluation.time_to_localize_s.is_some_and(|secs| secs < 8.0);
            let followed = evaluation.position_error_m.median.is_some_and(|median| median < limit_m);
            if !(found && followed) {
                let (time, error) = (evaluation.time_to_localize_s, evaluation.position_error_m.median);
                failures.push(format!(
                    "{} with seed {seed}: found at {time:?} s, median {error:?} m",
                    algorithm.name
                ));
            }
        }
    }
    assert!(failures.len() <= 1, "{failures:#?}");
}

/// The excerpt of a recorded tour: 9 s at 10 Hz.
#[test]
fn recorded_tour_is_followed() {
    for (algorithm, limit_m) in
        [("evolutionary", 0.25), ("evolutionary-grid", 0.25), ("mce", 0.3), ("mc", 0.3)]
    {
        let mut good = 0;
        for seed in 1..=5 {
            let evaluation = replay("R1-excerpt.mcap", algorithm, seed).evaluation;
            let median = evaluation.position_error_m.median;
            good += u32::from(median.is_some_and(|median| median < limit_m));
        }
        assert!(good >= 4, "{algorithm}: {good} of 5 seeds below {limit_m} m");
    }
}

/// The excerpt of a recorded kidnap: lifted after 4 s, put down 2 s later, 7.5 s follow.
#[test]
fn recorded_kidnap_is_recovered() {
    for algorithm in ALGORITHMS {
        let mut recovered = 0;
        for seed in 1..=5 {
            let kidnaps = replay("R2-excerpt.mcap", algorithm.name, seed).evaluation.kidnaps;
            assert_eq!(kidnaps.len(), 1);
            recovered += u32::from(kidnaps[0].recovered);
        }
        assert!(recovered >= 4, "{}: {recovered} of 5 seeds", algorithm.name);
    }
}

/// Without odometry the motion model has nothing to say, and the images alone have to do. Four of five seeds, since a
/// robot that turns away from all goals for long is lost without odometry.
#[test]
fn localization_works_without_odometry() {
    let scenario = Scenario::load("tour").unwrap();
    for (algorithm, limit_m) in [("evolutionary", 0.45), ("mce", 0.3)] {
        let medians: Vec<_> = (1..=5)
            .map(|seed| {
                let simulation = Simulation::new(&scenario, seed).unwrap();
                let mut simulation = simulation.with_threads(2).with_num_frames(300);
                let map = simulation.map().clone();
                let mut source = WithoutOdometry(&mut simulation);
                run(&mut source, &map, algorithm, None, seed).unwrap().evaluation.position_error_m.median
            })
            .collect();
        let good = medians.iter().filter(|median| median.is_some_and(|median| median < limit_m)).count();
        assert!(good >= 4, "{algorithm}: medians {medians:?} m, expected at most {limit_m}");
    }
}

struct WithoutOdometry<'a>(&'a mut Simulation);

impl visloc_base::FrameSource for WithoutOdometry<'_> {
    fn next_frame(&mut self) -> Option<Result<visloc_base::SourceFrame, visloc_base::SourceError>> {
        let mut frame = self.0.next_frame()?;
        if let Ok(frame) = &mut frame {
            frame.frame.odometry = None;
        }
        Some(frame)
    }
}
