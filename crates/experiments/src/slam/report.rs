//! From records to tables.

use std::collections::BTreeSet;

use visloc_core::{
    CameraPose, CameraTrajectory, Timestamp,
    eval::camera::{Alignment, Statistics, absolute_error, associate},
    geom::Rigid3,
};

use super::{
    SlamExperiment, SlamRunRecord, SlamStudy,
    follow::max,
    pictures::pictures,
    sequence::{how_to_get, table_name},
};
use crate::{Experiment, Report, Results, Table, mean, number, published, quantile, sorted};

/// What the runs of a cell have in common.
struct Summary<'a> {
    sequence: String,
    configuration: &'a str,
    records: Vec<&'a SlamRunRecord>,
}

impl Summary<'_> {
    fn values(&self, value: impl Fn(&SlamRunRecord) -> Option<f64>) -> Vec<f64> {
        sorted(self.records.iter().filter_map(|record| value(record)))
    }

    fn median(&self, value: impl Fn(&SlamRunRecord) -> Option<f64>) -> Option<f64> {
        quantile(&self.values(value), 0.5)
    }

    fn mean(&self, value: impl Fn(&SlamRunRecord) -> Option<f64>) -> Option<f64> {
        mean(&self.values(value))
    }

    /// Mean, median and standard deviation, each the mean of the runs, with so many decimals.
    fn three(&self, of: impl Fn(&SlamRunRecord) -> Option<Statistics>, decimals: usize) -> [String; 3] {
        [|s: Statistics| s.mean, |s: Statistics| s.median, |s: Statistics| s.std]
            .map(|value| number(self.mean(|record| of(record).map(value)), decimals))
    }

    /// Median RMSE, with a star if less than 70 % and X if less than 30 % of the images have a pose, as in the documents.
    fn rmse(&self) -> String {
        match self.mean(|record| Some(record.coverage)) {
            Some(share) if share < 0.3 => "X".to_owned(),
            Some(share) if share < 0.7 => number(self.median(|r| r.ate_rmse_m), 3) + "*",
            _ => number(self.median(|r| r.ate_rmse_m), 3),
        }
    }

    /// RMSE of a run in the middle, and the other statistics of the errors.
    fn errors(&self) -> [String; 4] {
        let [mean, median, sigma] = self.three(|r| r.ate, 3);
        [self.rmse(), mean, median, sigma]
    }

    fn coverage(&self) -> String {
        self.mean(|r| Some(r.coverage))
            .map_or_else(|| "-".to_owned(), |share| format!("{:.0} %", share * 100.0))
    }

    fn label(&self) -> String {
        format!("{}, {}", self.sequence, self.configuration)
    }

    fn tracking_ms(&self) -> String {
        number(self.mean(|r| r.tracking_ms), 2)
    }
}

impl SlamExperiment {
    /// The tables.
    pub fn tables(&self, results: &Results<SlamRunRecord>) -> Vec<Table> {
        let summaries: Vec<Summary<'_>> = (0..self.cells().len())
            .map(|cell| {
                let (sequence, configuration) = self.parts(cell);
                Summary {
                    sequence: table_name(sequence),
                    configuration,
                    records: results.cell(cell).collect(),
                }
            })
            .collect();
        let tables = match self.settings().study {
            SlamStudy::Configs => vec![errors(&summaries), times(&summaries), stages(&summaries)],
            SlamStudy::LostPoints => vec![lost_points(&summaries)],
            SlamStudy::Dynamic => vec![dynamic(&summaries)],
            SlamStudy::Kidnap => vec![kidnap(&summaries)],
            SlamStudy::Compare => {
                let title = "RMSE [m], published | here. X: less than 30 % of the images have a pose, *: less than 70 %";
                let times = "Tracking [ms an image], published | here";
                vec![
                    self.compare(("comparison", title), &summaries, |s| s.rmse()),
                    self.compare(("times", times), &summaries, |s| s.tracking_ms()),
                ]
            }
        };
        tables.into_iter().map(|table| published::beside(table, self.name())).collect()
    }

    /// Tables and pictures.
    pub fn report(&self, results: &Results<SlamRunRecord>, seed: u64) -> Report {
        let num_done = results.num_runs() - results.num_missing();
        let json = self.cells().iter().enumerate().map(|(cell, conditions)| {
            serde_json::json!({ "cell": conditions.label, "records": results.cell(cell).collect::<Vec<_>>() })
        });
        Report {
            heading: format!(
                "Experiment {}: {num_done} of {} runs, seed {seed}",
                self.name(),
                results.num_runs()
            ),
            tables: self.tables(results),
            notes: self.notes(),
            json: serde_json::json!({
                "experiment": self.name(), "seed": seed, "runs": num_done, "cells": json.collect::<Vec<_>>()
            }),
            pictures: pictures(self, results),
        }
    }

    /// What the tables mean, and a line for each sequence of the documents that was not given.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = vec![
            "RMSE: median over the runs; the published one is the best of three. Published times: Intel i5-3330; here: \
             processor time of one thread."
                .to_owned(),
        ];
        let given: BTreeSet<String> = self.settings().sequences.iter().map(|name| table_name(name)).collect();
        let prefix = format!("{}/", self.name());
        let tables = crate::published_tables().iter().filter(|table| table.id.starts_with(&prefix));
        let rows = tables.flat_map(|table| &table.rows).filter_map(|row| row[0].split(", ").next());
        let missing: BTreeSet<&str> = rows.filter(|name| !given.contains(*name)).collect();
        notes.extend(missing.into_iter().filter_map(|name| how_to_get(name, self.name())));
        notes
    }

    /// A row for each sequence: published programs, and both configurations of this one.
    fn compare(
        &self,
        (name, title): (&str, &str),
        summaries: &[Summary<'_>],
        own: impl Fn(&Summary<'_>) -> String,
    ) -> Table {
        let programs = published::table(&format!("{}/{name}", self.name()));
        let programs = programs.map_or(&[][..], |table| &table.header[1..]);
        let mut header = vec!["sequence"];
        header.extend(programs);
        let configurations = &self.settings().configurations;
        header.extend(configurations.iter().map(String::as_str).filter(|c| !programs.contains(c)));
        let covered: Vec<String> = configurations.iter().map(|name| format!("coverage, {name}")).collect();
        header.extend(covered.iter().map(String::as_str));
        let mut table = Table::new(name, title, &header);
        for of_sequence in summaries.chunks(configurations.len().max(1)) {
            let cell = |column: &&str| {
                let of = |name: &str| of_sequence.iter().find(|s| s.configuration == name);
                match column.strip_prefix("coverage, ") {
                    Some(name) => of(name).map(Summary::coverage),
                    None => of(column).map(&own),
                }
                .unwrap_or_else(|| "-".to_owned())
            };
            table.push(std::iter::once(of_sequence[0].sequence.clone()).chain(header[1..].iter().map(cell)));
        }
        table
    }
}

fn errors(summaries: &[Summary<'_>]) -> Table {
    let title = "Errors: published | here. Bundle adjustment: config3, 4, 7, 8; rejection: even ones; ORB: config5 to 8";
    let header = [
        "sequence, configuration",
        "RMSE [m]",
        "mean [m]",
        "median [m]",
        "sigma [m]",
        "best RMSE [m]",
        "coverage",
    ];
    let mut table = Table::new("errors", title, &header);
    for s in summaries {
        let best = number(s.values(|r| r.ate_rmse_m).first().copied(), 3);
        table.push(std::iter::once(s.label()).chain(s.errors()).chain([best, s.coverage()]));
    }
    table
}

fn times(summaries: &[Summary<'_>]) -> Table {
    let header = [
        "sequence, configuration",
        "tracking",
        "median",
        "sigma",
        "mapping",
        "mapping median",
        "mapping sigma",
    ];
    let mut table = Table::new("times", "Time of an image [ms]: published | here", &header);
    for s in summaries {
        let times = s.three(|r| r.tracking, 2).into_iter().chain(s.three(|r| r.mapping, 2));
        table.push(std::iter::once(s.label()).chain(times));
    }
    table
}

fn stages(summaries: &[Summary<'_>]) -> Table {
    let title = "Where the time goes, mapping in images that become keyframes [ms]: published | here";
    let header = ["sequence, configuration, stage", "mean", "median", "sigma"];
    let mut table = Table::new("stages", title, &header);
    for s in summaries {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in s.records.iter().flat_map(|record| &record.stages) {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        for name in names {
            let of = |r: &SlamRunRecord| r.stages.iter().find(|stage| stage.0 == name).map(|stage| stage.1);
            table.push(std::iter::once(format!("{}, {name}", s.label())).chain(s.three(of, 2)));
        }
    }
    table
}

fn lost_points(summaries: &[Summary<'_>]) -> Table {
    let title = "Share of lost points from which on a keyframe is made, config8: published | here";
    let header = ["sequence, threshold", "RMSE [m]", "coverage", "lost", "tracking [ms]", "mapping [ms]"];
    let mut table = Table::new("errors", title, &header);
    for s in summaries {
        table.push([
            s.label(),
            s.rmse(),
            s.coverage(),
            number(s.mean(|r| Some(f64::from(u32::try_from(r.num_lost).unwrap_or(u32::MAX)))), 1),
            s.tracking_ms(),
            number(s.mean(|r| r.mapping_ms), 2),
        ]);
    }
    table
}

fn dynamic(summaries: &[Summary<'_>]) -> Table {
    let title = "Moving things: published | here. config2 rejects outliers by random samples, config1 does not; the robust weights are \
         this program's own";
    let header = [
        "sequence, configuration",
        "RMSE [m]",
        "mean [m]",
        "largest error [m]",
        "largest jump [m]",
        "from the one without [m]",
        "coverage",
        "tracking",
        "median",
        "sigma",
    ];
    let mut table = Table::new("dynamic", title, &header);
    for s in summaries {
        let without = s.configuration.replace("config2", "config1");
        let other = summaries.iter().find(|o| o.sequence == s.sequence && o.configuration == without);
        let other = other.filter(|_| without != s.configuration);
        let [rmse, mean, ..] = s.errors();
        let columns = [
            s.label(),
            rmse,
            mean,
            number(s.median(|r| r.ate_max_m), 3),
            number(s.median(|r| r.jump_m), 3),
            number(other.and_then(|other| distance_m(s, other)), 3),
            s.coverage(),
        ];
        table.push(columns.into_iter().chain(s.three(|r| r.tracking, 2)));
    }
    table
}

/// Mean distance between the paths of the first runs, one aligned to the other.
fn distance_m(one: &Summary<'_>, other: &Summary<'_>) -> Option<f64> {
    let path = |summary: &Summary<'_>| {
        let mut trajectory = CameraTrajectory::new();
        for [secs, x, y, z, _] in &summary.records.first()?.path {
            let pose = Rigid3::new(nalgebra::Rotation3::identity(), nalgebra::Vector3::new(*x, *y, *z));
            // A path is in order of time.
            let _ = trajectory.push(CameraPose { at: Timestamp::from_secs(*secs), world_from_camera: pose });
        }
        Some(trajectory)
    };
    let pairs = associate(&path(one)?, &path(other)?, 1e-3);
    absolute_error(&pairs, Alignment::Similarity).map(|error| error.statistics.mean)
}

fn kidnap(summaries: &[Summary<'_>]) -> Table {
    let title = "Covered, carried away, put down where the map reaches; times in ms: published | here";
    let header = [
        "sequence, configuration",
        "RMSE [m]",
        "mean [m]",
        "median [m]",
        "sigma [m]",
        "coverage",
        "found",
        "after, median [s]",
        "after, longest [s]",
        "attempt",
        "longest attempt",
        "tracking",
    ];
    let mut table = Table::new("kidnap", title, &header);
    for s in summaries {
        let spells: Vec<Option<f64>> = s.records.iter().flat_map(|r| r.found_after_secs.clone()).collect();
        let found = sorted(spells.iter().copied().flatten());
        let columns = [
            s.coverage(),
            format!("{} of {}", found.len(), spells.len()),
            number(quantile(&found, 0.5), 2),
            number(found.last().copied(), 2),
            number(s.mean(|r| r.relocalization_ms.map(|ms| ms.0)), 1),
            number(max(&s.values(|r| r.relocalization_ms.map(|ms| ms.1))), 1),
            s.tracking_ms(),
        ];
        table.push(std::iter::once(s.label()).chain(s.errors()).chain(columns));
    }
    table
}
