//! From records to a report.

use super::{KidnapExperiment, KidnapRecord, pictures};
use crate::{Experiment, ExperimentError, Report, Results, Table, quantile};

/// What the best known programs reach, from their own code in the same world with 500 particles: recovered of 100, median
/// iterations.
const PEERS: [(&str, &str, &str); 4] = [
    ("nav2_amcl, defaults", "0", "-"),
    ("nav2_amcl, averages 0.001 and 0.1, KLD", "76 to 83", "21 to 23"),
    ("beluga Amcl, averages 0.001 and 0.1", "0", "-"),
    ("beluga Amcl, the same with KLD", "23", "93"),
];

impl KidnapExperiment {
    /// Table and pictures.
    ///
    /// # Errors
    /// If a run for a picture is impossible.
    pub fn report(&self, results: &Results<KidnapRecord>, seed: u64) -> Result<Report, ExperimentError> {
        let title = "Iterations from the kidnap until more than half of all individuals are at the new place";
        let header =
            ["algorithm", "individuals", "runs", "recovered", "median", "90 %", "answer right", "median"];
        let mut table = Table::new("kidnap", title, &header);
        let mut cells = Vec::new();
        for (cell, contender) in self.settings().contenders.iter().enumerate() {
            let records: Vec<&KidnapRecord> = results.cell(cell).filter(|r| r.had_converged).collect();
            let num_not_converged = results.cell(cell).filter(|r| !r.had_converged).count();
            let recovered = sorted(records.iter().filter_map(|record| record.recovered_after));
            let right = sorted(records.iter().filter_map(|record| record.answer_right_after));
            let text = |value: Option<u32>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
            table.push([
                contender.label.clone(),
                contender.num_individuals.to_string(),
                records.len().to_string(),
                recovered.len().to_string(),
                text(quantile(&recovered, 0.5)),
                text(quantile(&recovered, 0.9)),
                right.len().to_string(),
                text(quantile(&right, 0.5)),
            ]);
            cells.push(serde_json::json!({
                "algorithm": contender.label,
                "individuals": contender.num_individuals,
                "runs": records.len(),
                "runs_not_converged_before": num_not_converged,
                "recovered": recovered.len(),
                "median_iterations": quantile(&recovered, 0.5),
                "p90_iterations": quantile(&recovered, 0.9),
                "answer_right": right.len(),
                "answer_right_median_iterations": quantile(&right, 0.5),
            }));
        }
        for (label, recovered, median) in PEERS {
            table.push([label, "500", "100", recovered, median, "-", "-", "-"]);
        }
        let num_done = results.num_runs() - results.num_missing();
        Ok(Report {
            heading: format!("Kidnap experiment: {num_done} of {} runs, seed {seed}", results.num_runs()),
            tables: vec![table],
            notes: vec![
                "Runs: those that had converged before. Answer right: the localizer's answer is within 2 m of the new place \
                 until the end. Rows without that column: other programs, measured in the same world."
                    .to_owned(),
            ],
            json: serde_json::json!({
                "experiment": self.name(),
                "seed": seed,
                "runs": num_done,
                "runs_missing": results.num_missing(),
                "cells": cells,
            }),
            pictures: pictures::all(self, seed)?,
        })
    }
}

fn sorted(values: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut values: Vec<u32> = values.collect();
    values.sort_unstable();
    values
}
