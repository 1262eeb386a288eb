//! From records to a report.

use visloc_core::{PlanarTrajectory, RngTree};
use visloc_locate::LOCALIZED_RELIABILITY;
use visloc_plot::{
    Color, FieldPath, FieldPicture, Panel, PathPoint, Picture, Series, TimeSeriesPicture, ValueAxis,
    field_picture, time_series,
};

use super::{
    OfficeExperiment, OfficeRecord, likelihood, place,
    walk::{Followed, follow},
};
use crate::{Experiment, ExperimentError, Report, Results, Table, mean, number, published};

impl OfficeExperiment {
    /// The table.
    pub fn tables(&self, results: &Results<OfficeRecord>) -> Vec<Table> {
        let title = "Office corridor: published, on the real robot | here";
        let header = [
            "walk, algorithm",
            "mean [m]",
            "worst [m]",
            "heading [deg]",
            "localized [s]",
            "changed [s]",
            "recovery [s]",
            "recovered",
            "told apart [s]",
            "recovery from then [s]",
            "worst [s]",
            "recovered of these",
        ];
        let mut table = Table::new("office", title, &header);
        for (cell, conditions) in self.cells().iter().enumerate() {
            let records: Vec<&OfficeRecord> = results.cell(cell).collect();
            let errors: Vec<f64> = records.iter().filter_map(|record| record.error_m).collect();
            let turns: Vec<f64> = records.iter().filter_map(|record| record.error_deg).collect();
            let firsts: Vec<f64> = records.iter().filter_map(|record| record.first_localized_secs).collect();
            let kidnaps: Vec<Option<f64>> = records.iter().flat_map(|r| r.recovery_secs.clone()).collect();
            let changed: Vec<f64> =
                records.iter().flat_map(|record| record.changed_secs.iter().copied().flatten()).collect();
            let recovered: Vec<f64> = kidnaps.iter().copied().flatten().collect();
            let told: Vec<(f64, Option<f64>)> =
                records.iter().flat_map(|record| told_apart(record)).collect();
            let from_then: Vec<f64> = told.iter().filter_map(|(_, from_then)| *from_then).collect();
            let worst = errors.iter().copied().fold(f64::NAN, f64::max);
            table.push([
                conditions.label.clone(),
                number(mean(&errors), 3),
                number((!errors.is_empty()).then_some(worst), 3),
                number(mean(&turns), 1),
                number(mean(&firsts), 1),
                number(mean(&changed), 1),
                number(mean(&recovered), 1),
                format!("{} of {}", recovered.len(), kidnaps.len()),
                number(mean(&told.iter().map(|told| told.0).collect::<Vec<_>>()), 1),
                number(mean(&from_then), 1),
                number(from_then.iter().copied().reduce(f64::max), 1),
                format!("{} of {}", from_then.len(), told.len()),
            ]);
        }
        vec![published::beside(table, "office")]
    }

    /// The table; there are pictures of runs only.
    pub fn report(&self, results: &Results<OfficeRecord>, seed: u64) -> Report {
        let json: Vec<_> = self.cells().iter().enumerate().map(|(cell, conditions)| {
            serde_json::json!({ "cell": conditions.label, "records": results.cell(cell).collect::<Vec<_>>() })
        }).collect();
        let num_done = results.num_runs() - results.num_missing();
        Report {
            heading: format!("Office experiment: {num_done} of {} runs, seed {seed}", results.num_runs()),
            tables: self.tables(results),
            notes: vec![
                "Errors count from the first localization on, with all phases in which the answer was wrong."
                    .to_owned(),
                "Changed: from the putting down until the answer, right or wrong, is relied on more than a meter from where \
                 the robot would be had nobody carried it."
                    .to_owned(),
                "Recovery counts from the putting down until the pose is right and relied on, for a second at least. Told apart: \
                 from the putting down until no other place explains the lines that were seen since, by the truth."
                    .to_owned(),
            ],
            json: serde_json::json!({ "experiment": self.name(), "seed": seed, "runs": num_done, "cells": json }),
            pictures: Vec::new(),
        }
    }

    /// Paths and errors of the first runs, and likelihood maps.
    pub(super) fn pictures(&self, seed: u64) -> Result<Vec<(String, Picture)>, ExperimentError> {
        let seeds = RngTree::new(seed);
        let mut pictures = Vec::new();
        let num_algorithms = self.settings().algorithms.len();
        for (i, scenario) in self.settings().scenarios.iter().enumerate() {
            let runs: Result<Vec<_>, _> =
                (0..num_algorithms).map(|j| follow(&self.walk(i * num_algorithms + j), 0, &seeds)).collect();
            let runs = runs?;
            let name = place::short_name(scenario);
            pictures.push((format!("{name}-errors"), errors(&name, &self.settings().algorithms, &runs)));
            let input = paths(&name, &self.settings().algorithms, &runs);
            pictures.push((format!("{name}-paths"), field_picture(&place::building(scenario)?, &input)));
        }
        pictures.extend(likelihood::pictures(&seeds)?);
        Ok(pictures)
    }
}

/// Of each kidnap after which the place could be told from all others: when that was, and how long it took from then
/// until the robot had found it.
fn told_apart(record: &OfficeRecord) -> impl Iterator<Item = (f64, Option<f64>)> {
    let both = record.told_secs.iter().zip(&record.recovery_secs);
    both.filter_map(|(told, recovery)| told.map(|told| (told, recovery.map(|secs| (secs - told).max(0.0)))))
}

fn paths(scenario: &str, algorithms: &[String], runs: &[Followed]) -> FieldPicture {
    let estimate = |(i, (algorithm, run)): (usize, (&String, &Followed))| FieldPath {
        label: algorithm.clone(),
        color: Color::series(i),
        points: run
            .estimates
            .iter()
            .map(|sample| PathPoint {
                is_localized: sample.reliability.is_some_and(|r| r > LOCALIZED_RELIABILITY),
                ..PathPoint::localized(&sample.world_from_robot)
            })
            .collect(),
    };
    let truth = |truth: &PlanarTrajectory| FieldPath {
        label: "truth".to_owned(),
        color: Color::BLACK,
        points: truth
            .poses()
            .iter()
            .map(|pose| match pose.height_m > 0.02 {
                true => PathPoint::gap(),
                false => PathPoint::localized(&pose.world_from_robot),
            })
            .collect(),
    };
    FieldPicture {
        title: format!("Scenario {scenario}"),
        subtitle: "The first run of each algorithm".to_owned(),
        truth: runs.first().map(|run| truth(&run.truth)),
        estimates: algorithms.iter().zip(runs).enumerate().map(estimate).collect(),
        ..FieldPicture::default()
    }
}

fn errors(scenario: &str, algorithms: &[String], runs: &[Followed]) -> Picture {
    let series = |(i, (algorithm, run)): (usize, (&String, &Followed))| {
        let frames = &run.evaluation.frame_errors;
        let start = frames.first().map(|frame| frame.at).unwrap_or_default();
        let value = |frame: &visloc_core::eval::FrameError| match frame.is_carried {
            true => f64::NAN,
            false => frame.position_error_m.max(0.01),
        };
        let points = frames.iter().map(|frame| (frame.at.secs_since(start), value(frame))).collect();
        Series::new(algorithm, Color::series(i), points)
    };
    time_series(&TimeSeriesPicture {
        title: format!("Scenario {scenario}: position error"),
        subtitle: "The first run of each algorithm".to_owned(),
        panels: vec![Panel {
            label: "position error [m]".to_owned(),
            axis: ValueAxis::Log { min: 0.01, max: 20.0 },
            series: algorithms.iter().zip(runs).enumerate().map(series).collect(),
            ..Panel::default()
        }],
        ..TimeSeriesPicture::default()
    })
}
