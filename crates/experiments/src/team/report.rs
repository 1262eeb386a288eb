//! From records to a report.

use super::{ConditionRecord, TeamExperiment, TeamRecord, carried, experiment::conditions};
use crate::{Experiment, ExperimentError, Report, Results, Table, mean, number};

impl TeamExperiment {
    /// The table: all games together, a row for each of the conditions.
    pub fn tables(&self, results: &Results<TeamRecord>) -> Vec<Table> {
        let header = [
            "conditions",
            "games",
            "right after, median [s]",
            "90 % [s]",
            "never right",
            "untied",
            "dragged",
            "in games",
            "right [%]",
            "wrong claims [%]",
            "sent [B/s]",
        ];
        let mut table = Table::new("team", "Teams: one robot knows its half, the others are judged", &header);
        for name in conditions().into_iter().map(|(name, ..)| name).chain(carried::CONDITIONS) {
            let games = (0..self.cells().len()).flat_map(|cell| results.cell(cell)).flatten();
            let games: Vec<&ConditionRecord> = games.filter(|game| game.name == name).collect();
            if !games.is_empty() {
                table.push(row(name, &games));
            }
        }
        vec![table]
    }

    /// The table and what its words mean.
    ///
    /// # Errors
    /// Never; as reports of other experiments.
    pub fn report(&self, results: &Results<TeamRecord>, seed: u64) -> Result<Report, ExperimentError> {
        let json: Vec<_> = self.cells().iter().enumerate().map(|(cell, conditions)| {
            serde_json::json!({ "cell": conditions.label, "records": results.cell(cell).collect::<Vec<_>>() })
        }).collect();
        let num_done = results.num_runs() - results.num_missing();
        Ok(Report {
            heading: format!("Team experiment: {num_done} of {} games, seed {seed}", results.num_runs()),
            tables: self.tables(results),
            notes: vec![
                "Right after: from the moment when a chain of sightings first joined a robot to the one that knows until it was localized \
                 within 0.5 m and 29 degrees; never right and untied: of all robots that neither lie nor know."
                    .to_owned(),
                "Dragged: robots that claimed a wrong place for more than a second with the team, and not by themselves.".to_owned(),
                "Carried off: the last robot, at half time, which feels it; right after it stands again, alone and up to the mirrored place by \
                 what its localizer says; dragged: it claimed another place for more than a second."
                    .to_owned(),
            ],
            json: serde_json::json!({ "experiment": self.name(), "seed": seed, "runs": num_done, "cells": json }),
            pictures: Vec::new(),
        })
    }
}

fn row(name: &str, games: &[&ConditionRecord]) -> [String; 11] {
    let scores = || games.iter().map(|game| &game.score);
    let all: Vec<Option<f64>> = scores().flat_map(|score| score.right_after_secs.clone()).collect();
    // Who never was right is behind all others.
    let mut secs: Vec<f64> = all.iter().map(|secs| secs.unwrap_or(f64::INFINITY)).collect();
    secs.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        let index = (share * secs.len() as f64).ceil() as usize;
        number(secs.get(index.saturating_sub(1)).copied().filter(|secs| secs.is_finite()), 1)
    };
    let percent = |values: Vec<f64>| number(mean(&values).map(|share| 100.0 * share), 1);
    let num_never = all.iter().filter(|secs| secs.is_none()).count();
    [
        name.to_owned(),
        games.len().to_string(),
        quantile(0.5),
        quantile(0.9),
        format!("{num_never} of {}", all.len()),
        scores().map(|score| score.num_untied).sum::<usize>().to_string(),
        scores().map(|score| score.num_dragged).sum::<usize>().to_string(),
        scores().filter(|score| score.num_dragged > 0).count().to_string(),
        percent(scores().map(|score| score.right_share).collect()),
        percent(scores().map(|score| score.wrong_share).collect()),
        number(mean(&games.iter().map(|game| game.bytes_per_sec).collect::<Vec<_>>()), 0),
    ]
}
