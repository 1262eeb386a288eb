//! From records to tables.

use super::{
    SlamExperiment, SlamRunRecord, SlamStudy,
    follow::{max, mean},
    pictures::pictures,
    published,
    sequence::short_name,
};
use crate::{Experiment, ExperimentError, Report, Results, Table};

/// What the runs of a cell have in common.
struct Summary<'a> {
    sequence: String,
    published_name: Option<&'static str>,
    configuration: &'a str,
    records: Vec<&'a SlamRunRecord>,
}

impl Summary<'_> {
    fn values(&self, value: impl Fn(&SlamRunRecord) -> Option<f64>) -> Vec<f64> {
        let mut values: Vec<f64> = self.records.iter().filter_map(|record| value(record)).collect();
        values.sort_by(f64::total_cmp);
        values
    }

    fn median(&self, value: impl Fn(&SlamRunRecord) -> Option<f64>) -> Option<f64> {
        let values = self.values(value);
        values.get(values.len() / 2).copied()
    }

    fn mean(&self, value: impl Fn(&SlamRunRecord) -> Option<f64>) -> Option<f64> {
        mean(&self.values(value))
    }

    /// Median RMSE, with a star if less than 70 % and X if less than 30 % of the images have a pose, as in the documents.
    fn rmse(&self) -> String {
        match self.mean(|record| Some(record.coverage)) {
            Some(share) if share < 0.3 => "X".to_owned(),
            Some(share) if share < 0.7 => text(self.median(|r| r.ate_rmse_m), 3) + "*",
            _ => text(self.median(|r| r.ate_rmse_m), 3),
        }
    }

    fn coverage(&self) -> String {
        self.mean(|r| Some(r.coverage))
            .map_or_else(|| "-".to_owned(), |share| format!("{:.0} %", share * 100.0))
    }

    fn label(&self) -> String {
        let name = self.published_name.map_or_else(String::new, |name| format!(" ({name})"));
        format!("{}{name}, {}", self.sequence, self.configuration)
    }
}

impl SlamExperiment {
    /// Tables and pictures.
    ///
    /// # Errors
    /// Never at present; reports of other experiments may fail.
    pub fn report(&self, results: &Results<SlamRunRecord>, seed: u64) -> Result<Report, ExperimentError> {
        let summaries: Vec<Summary<'_>> = (0..self.cells().len())
            .map(|cell| {
                let (sequence, configuration) = self.parts(cell);
                let sequence = short_name(sequence);
                let published_name = published::sequence_name(&sequence);
                Summary { sequence, published_name, configuration, records: results.cell(cell).collect() }
            })
            .collect();
        let tables = match self.settings().study {
            SlamStudy::Configs => vec![configs(&summaries), stages(&summaries)],
            SlamStudy::Dynamic => vec![dynamic(&summaries)],
            SlamStudy::Kidnap => vec![kidnap(&summaries)],
            SlamStudy::Compare => vec![compare(&summaries), times(&summaries)],
        };
        let num_done = results.num_runs() - results.num_missing();
        let json = self.cells().iter().enumerate().map(|(cell, conditions)| {
            serde_json::json!({ "cell": conditions.label, "records": results.cell(cell).collect::<Vec<_>>() })
        });
        Ok(Report {
            heading: format!("Experiment {}: {num_done} of {} runs, seed {seed}", self.name(), results.num_runs()),
            tables,
            notes: vec![
                "Medians over the runs; the published errors are the best of three. Published times: Intel i5-3330; here: \
                 processor time of one thread."
                    .to_owned(),
            ],
            json: serde_json::json!({
                "experiment": self.name(), "seed": seed, "runs": num_done, "cells": json.collect::<Vec<_>>()
            }),
            pictures: pictures(self, results),
        })
    }
}

fn text(value: Option<f64>, digits: usize) -> String {
    value.filter(|v| v.is_finite()).map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

fn configs(summaries: &[Summary<'_>]) -> Table {
    let title =
        "Configurations: published | here. BA: config3, 4, 7, 8; rejection: even ones; ORB: config5 to 8";
    let header = [
        "sequence, configuration",
        "published RMSE [m]",
        "RMSE [m]",
        "best [m]",
        "coverage",
        "published tracking [ms]",
        "tracking [ms]",
        "published mapping [ms]",
        "mapping [ms]",
    ];
    let mut table = Table::new("configurations", title, &header);
    for s in summaries {
        let published = s.published_name.and_then(|name| published::configuration(name, s.configuration));
        table.push([
            s.label(),
            text(published.map(|p| p[0]), 3),
            s.rmse(),
            text(s.values(|r| r.ate_rmse_m).first().copied(), 3),
            s.coverage(),
            text(published.map(|p| p[1]), 2),
            text(s.mean(|r| r.tracking_ms), 2),
            text(published.map(|p| p[2]), 2),
            text(s.mean(|r| r.mapping_ms), 2),
        ]);
    }
    table
}

fn stages(summaries: &[Summary<'_>]) -> Table {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in summaries.iter().flat_map(|s| &s.records).flat_map(|record| &record.stages_ms) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let header: Vec<&str> =
        std::iter::once("stage, ms where it happens").chain(names.iter().copied()).collect();
    let mut table =
        Table::new("stages", "Where the time goes, mean of the images in which the stage happens", &header);
    for s in summaries {
        let value = |name: &&str| {
            let of =
                |r: &SlamRunRecord| r.stages_ms.iter().find(|stage| stage.0 == *name).map(|stage| stage.1);
            text(s.mean(of), 2)
        };
        table.push(std::iter::once(s.label()).chain(names.iter().map(value)));
    }
    table
}

fn dynamic(summaries: &[Summary<'_>]) -> Table {
    let title =
        "Moving things: config4 rejects outliers by random samples, config3 does not; both weigh robustly";
    let header = [
        "sequence, configuration",
        "published RMSE [m]",
        "RMSE [m]",
        "largest error [m]",
        "largest jump [m]",
        "coverage",
        "published tracking [ms]",
        "tracking [ms]",
    ];
    let mut table = Table::new("dynamic", title, &header);
    for s in summaries {
        let published = s.published_name.and_then(|name| published::dynamic(name, s.configuration));
        table.push([
            s.label(),
            published.map_or_else(
                || "-".to_owned(),
                |p| if p[0].is_nan() { "jumps".to_owned() } else { text(Some(p[0]), 3) },
            ),
            s.rmse(),
            text(s.median(|r| r.ate_max_m), 3),
            text(s.median(|r| r.jump_m), 3),
            s.coverage(),
            text(published.map(|p| p[1]), 2),
            text(s.mean(|r| r.tracking_ms), 2),
        ]);
    }
    table
}

fn kidnap(summaries: &[Summary<'_>]) -> Table {
    let title = "Kidnap: covered, carried away, put down where the map reaches";
    let header = [
        "sequence, configuration",
        "published RMSE [m]",
        "RMSE [m]",
        "coverage",
        "found",
        "after, median [s]",
        "after, longest [s]",
        "published attempt [ms]",
        "attempt, mean [ms]",
        "attempt, longest [ms]",
        "tracking [ms]",
    ];
    let mut table = Table::new("kidnap", title, &header);
    for s in summaries {
        let published = s.published_name.and_then(|name| published::kidnap(name, s.configuration));
        let spells: Vec<Option<f64>> = s.records.iter().flat_map(|r| r.found_after_secs.clone()).collect();
        let mut found: Vec<f64> = spells.iter().copied().flatten().collect();
        found.sort_by(f64::total_cmp);
        table.push([
            s.label(),
            text(published.map(|p| p[0]), 3),
            s.rmse(),
            s.coverage(),
            format!("{} of {}", found.len(), spells.len()),
            text(found.get(found.len() / 2).copied(), 2),
            text(found.last().copied(), 2),
            text(published.map(|p| p[2]), 1),
            text(s.mean(|r| r.relocalization_ms.map(|ms| ms.0)), 1),
            text(max(&s.values(|r| r.relocalization_ms.map(|ms| ms.1))), 1),
            text(s.mean(|r| r.tracking_ms), 2),
        ]);
    }
    table
}

fn compare(summaries: &[Summary<'_>]) -> Table {
    let title =
        "RMSE [m], published beside ours. X: less than 30 % of the images have a pose, *: less than 70 %";
    comparison("comparison", title, summaries, &published::COMPARISON, &|s| s.rmse())
}

fn times(summaries: &[Summary<'_>]) -> Table {
    let title = "Tracking [ms an image], published beside ours";
    let own = |s: &Summary<'_>| text(s.mean(|r| r.tracking_ms), 2);
    comparison("comparison-times", title, summaries, &published::COMPARISON_MS, &own)
}

fn comparison(
    name: &str,
    title: &str,
    summaries: &[Summary<'_>],
    figures: &[(&str, [&str; 6])],
    own: &dyn Fn(&Summary<'_>) -> String,
) -> Table {
    let header: Vec<String> = std::iter::once("sequence, configuration".to_owned())
        .chain(published::PROGRAMS.map(|program| format!("{program} (published)")))
        .chain(["here".to_owned(), "coverage".to_owned()])
        .collect();
    let mut table = Table::new(name, title, &header.iter().map(String::as_str).collect::<Vec<_>>());
    for s in summaries {
        let known = figures.iter().find(|(sequence, _)| Some(*sequence) == s.published_name);
        let others = known.map_or(["-"; 6], |(_, figures)| *figures).map(str::to_owned);
        table.push(std::iter::once(s.label()).chain(others).chain([own(s), s.coverage()]));
    }
    table
}
