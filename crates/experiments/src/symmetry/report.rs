//! From records to a report.

use serde::Serialize;

use super::{
    IterationTime, SymmetryExperiment, SymmetryPart, SymmetryRecord, contenders, notes, pictures, tables,
};
use crate::{Experiment, ExperimentError, Report, Results, Table, mean, positions::Movement};

/// What came of the runs of a cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Outcome {
    pub algorithm: String,
    pub individuals: usize,
    pub movement: Movement,
    pub positions: usize,
    pub num_runs: usize,
    /// Runs that held all positions at the end by the published criterion.
    pub num_published: usize,
    /// The same by the strict criterion.
    pub num_strict: usize,
    /// Runs that held all positions by the strict criterion in every iteration after the published 300.
    pub num_never_lost: usize,
    /// Of the runs that found all positions.
    pub mean_found_after: Option<f64>,
}

impl Outcome {
    /// Share of the runs.
    pub fn percent(&self, num: usize) -> f64 {
        100.0 * num as f64 / self.num_runs as f64
    }
}

/// What came of all runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Summary {
    outcomes: Vec<Outcome>,
}

impl Summary {
    fn new(experiment: &SymmetryExperiment, results: &Results<SymmetryRecord>) -> Self {
        let conditions = experiment.conditions().iter().enumerate();
        let outcomes = conditions.map(|(cell, condition)| {
            let records: Vec<&SymmetryRecord> = results.cell(cell).collect();
            let contender = &condition.contender;
            let holds = |record: &SymmetryRecord| record.counts.iter().all(|count| *count > 0);
            let num_strict = |record: &SymmetryRecord| record.holds_strictly(contender.num_individuals);
            let found_after: Vec<f64> =
                records.iter().filter_map(|record| record.found_after.map(f64::from)).collect();
            Outcome {
                algorithm: contender.label.clone(),
                individuals: contender.num_individuals,
                movement: condition.shape.movement,
                positions: condition.shape.num_positions,
                num_runs: records.len(),
                num_published: records.iter().filter(|record| holds(record)).count(),
                num_strict: records.iter().filter(|record| num_strict(record)).count(),
                num_never_lost: records.iter().filter(|r| r.num_lost == 0 && num_strict(r)).count(),
                mean_found_after: mean(&found_after),
            }
        });
        Self { outcomes: outcomes.collect() }
    }

    /// The cell with these conditions, if any of its runs is there.
    pub fn find(
        &self,
        algorithm: &str,
        individuals: usize,
        movement: Movement,
        positions: usize,
    ) -> Option<&Outcome> {
        self.outcomes.iter().find(|o| {
            o.algorithm == algorithm
                && o.individuals == individuals
                && o.movement == movement
                && o.positions == positions
                && o.num_runs > 0
        })
    }

    /// The evolutionary algorithm with so many explorers and static positions.
    pub fn evolutionary(&self, num_explorers: usize, num_positions: usize) -> Option<&Outcome> {
        let contender = contenders::evolutionary(num_explorers);
        self.find(&contender.label, contender.num_individuals, Movement::Static, num_positions)
    }

    pub fn iter(&self) -> impl Iterator<Item = &Outcome> {
        self.outcomes.iter().filter(|outcome| outcome.num_runs > 0)
    }
}

impl SymmetryExperiment {
    /// Tables; without `times` those of the times have the published ones only.
    pub fn tables(&self, results: &Results<SymmetryRecord>, times: &[IterationTime]) -> Vec<Table> {
        let summary = Summary::new(self, results);
        match self.settings().part {
            SymmetryPart::Long => vec![tables::long(&summary)],
            SymmetryPart::Published => tables::published(&summary, times),
        }
    }

    /// Tables and pictures.
    ///
    /// # Errors
    /// If a run for a picture is impossible.
    pub fn report(
        &self,
        results: &Results<SymmetryRecord>,
        seed: u64,
        times: &[IterationTime],
    ) -> Result<Report, ExperimentError> {
        let summary = Summary::new(self, results);
        let (notes, pictures) = match self.settings().part {
            SymmetryPart::Long => (notes::long(), pictures::long(seed)?),
            SymmetryPart::Published => (notes::published(&summary), pictures::published(seed)?),
        };
        let num_done = results.num_runs() - results.num_missing();
        let heading = format!(
            "Symmetry experiment: positions that look the same in 20 m x 20 m; {num_done} of {} runs, seed {seed}",
            results.num_runs()
        );
        let json = serde_json::json!({
            "experiment": self.name(),
            "seed": seed,
            "runs": num_done,
            "runs_missing": results.num_missing(),
            "cells": summary.iter().collect::<Vec<_>>(),
            "times": times,
        });
        Ok(Report { heading, tables: self.tables(results, times), notes, json, pictures })
    }
}
