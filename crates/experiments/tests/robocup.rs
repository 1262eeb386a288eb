//! The RoboCup experiment on short runs.

// Clippy knows test functions, but not their helpers.
#![allow(clippy::unwrap_used)]

use visloc_core::RngTree;
use visloc_experiments::{
    Experiment, RunOptions, RunTarget, Shard,
    robocup::{RobocupExperiment, RobocupSet, RobocupSettings, RunLength, TruthPoint},
    run,
};

fn experiment(set: RobocupSet, length: RunLength) -> RobocupExperiment {
    let algorithms = vec!["mce".to_owned()];
    let settings = RobocupSettings { sets: vec![set], algorithms, length, ..RobocupSettings::default() };
    RobocupExperiment::new(settings, 2).unwrap()
}

const SHORT: RunLength = RunLength { walk_secs: 5.0, num_kidnaps: 0 };

#[test]
fn runs_differ_repeat_and_have_a_report() {
    let experiment = experiment(RobocupSet::Tours, SHORT);
    let seeds = RngTree::new(1);
    let records = [0, 1].map(|run| experiment.run(0, run, &seeds).unwrap());
    assert_eq!(experiment.run(0, 1, &seeds).unwrap(), records[1]);
    assert_ne!(records[0].simulation_seed, records[1].simulation_seed);
    assert!(records[0].truth.is_some() && records[1].truth.is_none(), "only the first run is drawn");
    let tour = &records[0].contenders[0];
    assert_eq!((records[0].frames, tour.kidnaps.len()), (150, 0));
    assert_eq!(tour.calibration.frames.iter().sum::<u64>(), 150);
    let options = RunOptions { seed: 1, shard: Shard::WHOLE, target: RunTarget::Memory };
    let results = run(&experiment, &options, &mut |_| ()).unwrap();
    let report = experiment.report(&results, 1, &[]).unwrap();
    assert_eq!(report.tables.len(), 4, "the set, calibration, consistency, times");
    assert!(report.pictures.iter().any(|(name, _)| name == "tours-mce-path"));
}

#[test]
fn a_kidnap_is_scored_once_for_each_contender() {
    let length = RunLength { walk_secs: 0.0, num_kidnaps: 1 };
    let experiment = experiment(RobocupSet::White, length);
    let record = experiment.run(0, 0, &RngTree::new(2)).unwrap();
    let labels: Vec<&str> = record.contenders.iter().map(|contender| contender.contender.as_str()).collect();
    assert_eq!(labels, ["mce", "mce, half given"]);
    assert!(record.contenders.iter().all(|contender| contender.kidnaps.len() == 1));
    let carried = |TruthPoint(.., is_carried): &TruthPoint| *is_carried;
    assert!(record.truth.unwrap().iter().any(carried));
}

#[test]
fn unknown_algorithms_are_refused() {
    let settings = RobocupSettings { algorithms: vec!["kalman".to_owned()], ..RobocupSettings::default() };
    assert!(RobocupExperiment::new(settings, 1).unwrap_err().to_string().contains("kalman"));
}
