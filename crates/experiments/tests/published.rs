//! Every figure that the documents publish stands in the table of its experiment, in its row and column.

// Clippy knows test functions, but not their helpers.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use visloc_core::Clock;
use visloc_experiments::{
    Experiment, Results, RunOptions, RunTarget, Table,
    markov::{MarkovExperiment, MarkovSettings},
    office::{OfficeExperiment, OfficeSettings},
    published_tables,
    robocup::{RobocupExperiment, RobocupSettings},
    run,
    slam::{SlamExperiment, SlamSettings, SlamStudy},
    symmetry::{SymmetryExperiment, SymmetryPart},
};

/// No run is done: all are another part's.
fn nothing<E: Experiment>(experiment: &E) -> Results<E::Record> {
    let shard = format!("{0}/{0}", u64::MAX).parse().unwrap();
    run(experiment, &RunOptions { seed: 1, shard, target: RunTarget::Memory }, &mut |_| ()).unwrap()
}

fn slam(study: SlamStudy) -> SlamExperiment {
    SlamExperiment::new(SlamSettings::new(study, &[]), 1, Clock::still()).unwrap()
}

const SLAM_STUDIES: [SlamStudy; 5] =
    [SlamStudy::Configs, SlamStudy::LostPoints, SlamStudy::Dynamic, SlamStudy::Kidnap, SlamStudy::Compare];

/// What an experiment prints before any run is done.
fn tables(experiment: &str) -> Vec<Table> {
    match experiment {
        "symmetry" => {
            let experiment = SymmetryExperiment::new(SymmetryPart::Published, 1);
            experiment.tables(&nothing(&experiment), &[])
        }
        "robocup" => {
            let experiment = RobocupExperiment::new(RobocupSettings::default(), 1).unwrap();
            experiment.tables(&nothing(&experiment), &[])
        }
        "office" => {
            let experiment = OfficeExperiment::new(OfficeSettings::default(), 1).unwrap();
            experiment.tables(&nothing(&experiment))
        }
        "markov" => {
            let experiment = MarkovExperiment::new(MarkovSettings::default(), 1).unwrap();
            experiment.tables(&nothing(&experiment))
        }
        name => {
            let experiment = slam(SLAM_STUDIES.into_iter().find(|study| study.name() == name).unwrap());
            experiment.tables(&nothing(&experiment))
        }
    }
}

#[test]
fn every_published_figure_stands_in_its_table() {
    let mut num_figures = 0;
    let mut printed: BTreeMap<&str, Vec<Table>> = BTreeMap::new();
    for published in published_tables().iter().filter(|table| !table.id.starts_with("list/")) {
        let (experiment, name) = published.id.split_once('/').unwrap();
        let tables = printed.entry(experiment).or_insert_with(|| tables(experiment));
        let table = tables.iter().find(|table| table.name == name).expect(published.id);
        for (row, column, value) in published.figures() {
            num_figures += 1;
            let place = format!("{}: {row:?}, {column:?}", published.id);
            let column = table.header.iter().position(|header| header == column).expect(&place);
            let rows: Vec<&Vec<String>> = table.rows.iter().filter(|cells| cells[0] == row).collect();
            assert_eq!(rows.len(), 1, "{place}");
            assert!(rows[0][column].starts_with(&format!("{value} | ")), "{place}: {:?}", rows[0]);
        }
    }
    assert_eq!(num_figures, 541, "as many as the documents have");
}

/// Beside our own contenders, and in rows of their own only what nobody here plays.
#[test]
fn figures_stand_beside_the_contender_that_plays_the_published_algorithm() {
    let tables = tables("robocup");
    for name in ["tours", "kidnaps"] {
        let table = tables.iter().find(|table| table.name == name).unwrap();
        let num_runs =
            |row: &str| table.rows.iter().find(|cells| cells[0] == row).map(|cells| cells[1].as_str());
        assert_eq!([num_runs("mcae"), num_runs("evolutionary")], [Some("0"); 2], "no runs are done");
        assert_eq!(
            table.rows.iter().filter(|cells| cells[0].contains("real Nao") && cells[1] == "-").count(),
            2
        );
    }
}

#[test]
fn a_sequence_that_is_not_here_says_how_to_get_it() {
    for study in SLAM_STUDIES {
        let notes = slam(study).notes().join("\n");
        for table in published_tables().iter().filter(|t| t.id.starts_with(&format!("{}/", study.name()))) {
            for row in &table.rows {
                let sequence = row[0].split(", ").next().unwrap();
                assert!(notes.contains(&format!("{sequence} is not here (")), "{}: {sequence}", table.id);
            }
        }
        assert!(notes.contains(&format!("visloc experiment {} ", study.name())), "{notes}");
    }
}
