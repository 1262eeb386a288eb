//! From records to a report.

use visloc_base::{PlanarTrajectory, RngTree};
use visloc_locate::LOCALIZED_RELIABILITY;
use visloc_plot::{
    Color, FieldPath, FieldPicture, Panel, PathPoint, Picture, Series, TimeSeriesPicture, ValueAxis,
    field_picture, time_series,
};

use super::{
    OfficeExperiment, OfficeRecord, likelihood, place,
    walk::{Followed, follow},
};
use crate::{Experiment, ExperimentError, Report, Results, Table};

/// Published mean error, meters, and recovery, seconds; by scenario and algorithm. Source: 2017 sections 5.3.3 and 5.3.4.
const PUBLISHED: [(&str, &str, &str, &str); 4] = [
    ("office-walk", "mce", "0.150", "-"),
    ("office-walk", "evolutionary", "0.118", "-"),
    ("office", "mce", "wrong doors", "never"),
    ("office", "evolutionary", "0.225", "21"),
];

impl OfficeExperiment {
    /// Table and pictures.
    ///
    /// # Errors
    /// If a run for a picture is impossible.
    pub fn report(&self, results: &Results<OfficeRecord>, seed: u64) -> Result<Report, ExperimentError> {
        let title = "Office corridor: published (real robot) beside measured (simulated)";
        let header = [
            "walk, algorithm",
            "published [m]",
            "mean [m]",
            "worst [m]",
            "heading [deg]",
            "localized [s]",
            "published recovery [s]",
            "recovery [s]",
            "recovered",
            "told apart [s]",
            "recovery from then [s]",
            "worst [s]",
            "recovered of these",
        ];
        let mut table = Table::new("office", title, &header);
        let mut json = Vec::new();
        for (cell, conditions) in self.cells().iter().enumerate() {
            let walk = self.walk(cell);
            let published = PUBLISHED.iter().find(|row| (row.0, row.1) == (walk.scenario, walk.algorithm));
            let records: Vec<&OfficeRecord> = results.cell(cell).collect();
            let errors: Vec<f64> = records.iter().filter_map(|record| record.error_m).collect();
            let turns: Vec<f64> = records.iter().filter_map(|record| record.error_deg).collect();
            let firsts: Vec<f64> = records.iter().filter_map(|record| record.first_localized_secs).collect();
            let kidnaps: Vec<Option<f64>> = records.iter().flat_map(|r| r.recovery_secs.clone()).collect();
            let recovered: Vec<f64> = kidnaps.iter().copied().flatten().collect();
            let told: Vec<(f64, Option<f64>)> =
                records.iter().flat_map(|record| told_apart(record)).collect();
            let from_then: Vec<f64> = told.iter().filter_map(|(_, from_then)| *from_then).collect();
            let worst = errors.iter().copied().fold(f64::NAN, f64::max);
            table.push([
                conditions.label.clone(),
                published.map_or("-", |row| row.2).to_owned(),
                text(mean(&errors), 3),
                text((!errors.is_empty()).then_some(worst), 3),
                text(mean(&turns), 1),
                text(mean(&firsts), 1),
                published.map_or("-", |row| row.3).to_owned(),
                text(mean(&recovered), 1),
                format!("{} of {}", recovered.len(), kidnaps.len()),
                text(mean(&told.iter().map(|told| told.0).collect::<Vec<_>>()), 1),
                text(mean(&from_then), 1),
                text(from_then.iter().copied().reduce(f64::max), 1),
                format!("{} of {}", from_then.len(), told.len()),
            ]);
            json.push(serde_json::json!({ "cell": conditions.label, "records": records }));
        }
        let num_done = results.num_runs() - results.num_missing();
        Ok(Report {
            heading: format!("Office experiment: {num_done} of {} runs, seed {seed}", results.num_runs()),
            tables: vec![table],
            notes: vec![
                "Errors count from the first localization on, with all phases in which the answer was wrong."
                    .to_owned(),
                "Recovery counts from the putting down until the pose is right and relied on, for a second at least. Told apart: \
                 from the putting down until no other place explains the lines that were seen since, by the truth."
                    .to_owned(),
            ],
            json: serde_json::json!({ "experiment": self.name(), "seed": seed, "runs": num_done, "cells": json }),
            pictures: self.pictures(seed)?,
        })
    }

    /// Paths and errors of the first runs, and likelihood maps.
    fn pictures(&self, seed: u64) -> Result<Vec<(String, Picture)>, ExperimentError> {
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

fn text(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

#[allow(clippy::cast_precision_loss)]
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
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
        let value = |frame: &visloc_eval::FrameError| match frame.is_carried {
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
