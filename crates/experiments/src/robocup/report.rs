//! From records to a report.

use serde_json::{Value, json};
use visloc_world::{Map, field::Field};

use super::{
    RobocupExperiment, pictures,
    record::RobocupRecord,
    reliability::NEAR_M,
    sets::RobocupSet,
    summary::{Summary, quantile, share},
    tables::{self, Row, seconds_in_band},
    timing::AlgorithmTiming,
};
use crate::{Experiment, ExperimentError, Report, Results, Table, mean, ratio};

impl RobocupExperiment {
    /// Tables; without `timings` that of the times has the published ones only.
    pub fn tables(&self, results: &Results<RobocupRecord>, timings: &[AlgorithmTiming]) -> Vec<Table> {
        let of_set = |(cell, set): (usize, &RobocupSet)| {
            let table = if set.has_kidnaps() { tables::kidnaps } else { tables::walks };
            table(*set, &self.rows(*set, results, &[cell]))
        };
        let mut tables: Vec<Table> = self.settings().sets.iter().enumerate().map(of_set).collect();
        let rows = self.all_rows(results);
        tables.extend([tables::calibration(&rows), tables::consistency(&rows), tables::timing(timings)]);
        tables
    }

    /// Tables and pictures.
    ///
    /// # Errors
    /// If a map cannot be loaded for a picture.
    pub fn report(
        &self,
        results: &Results<RobocupRecord>,
        seed: u64,
        timings: &[AlgorithmTiming],
    ) -> Result<Report, ExperimentError> {
        let mut report = Report { heading: self.heading(results, seed), ..Report::default() };
        let mut sets = Vec::new();
        for (cell, set) in self.settings().sets.iter().enumerate() {
            let rows = self.rows(*set, results, &[cell]);
            sets.push(
                json!({ "set": set, "contenders": rows.iter().map(contender_json).collect::<Vec<_>>() }),
            );
            if let Some(record) = results.cell(cell).next() {
                let field = field_of(*set, self)?;
                report.pictures.extend(pictures::first_run(*set, &field, record));
            }
        }
        let rows = self.all_rows(results);
        report.tables = self.tables(results, timings);
        report.pictures.push(("calibration".to_owned(), pictures::calibration(&rows)));
        report.pictures.push(("consistency".to_owned(), pictures::consistency(&rows)));
        report.pictures.push(("consistency-over-time".to_owned(), pictures::consistency_over_time(&rows)));
        report.notes = notes();
        report.json = json!({
            "experiment": self.name(),
            "seed": seed,
            "runs": results.num_runs() - results.num_missing(),
            "runs_missing": results.num_missing(),
            "sets": sets,
            "all_sets": rows.iter().map(contender_json).collect::<Vec<_>>(),
            "timing": timings.iter().map(timing_json).collect::<Vec<_>>(),
        });
        Ok(report)
    }

    fn heading(&self, results: &Results<RobocupRecord>, seed: u64) -> String {
        let num_done = results.num_runs() - results.num_missing();
        let frames: usize =
            (0..self.cells().len()).flat_map(|cell| results.cell(cell)).map(|record| record.frames).sum();
        format!("RoboCup experiment: {num_done} of {} runs, seed {seed}, {frames} images", results.num_runs())
    }

    /// The contenders of a set with their runs in some cells.
    fn rows<'a>(
        &self,
        set: RobocupSet,
        results: &'a Results<RobocupRecord>,
        cells: &[usize],
    ) -> Vec<Row<'a>> {
        let labels = self.contenders(set).into_iter().map(|contender| contender.label);
        let records = |label: &str| {
            let runs = cells.iter().flat_map(|cell| results.cell(*cell));
            runs.flat_map(|run| &run.contenders).filter(|record| record.contender == label).collect()
        };
        labels.map(|label| (label.clone(), Summary { records: records(&label) })).collect()
    }

    /// Every contender that has played, with its runs in all sets.
    fn all_rows<'a>(&self, results: &'a Results<RobocupRecord>) -> Vec<Row<'a>> {
        let cells: Vec<usize> = (0..self.cells().len()).collect();
        // The set with the most contenders names them all.
        let sets = &self.settings().sets;
        let fullest = sets.iter().copied().max_by_key(|set| self.contenders(*set).len());
        let mut rows = fullest.map_or_else(Vec::new, |set| self.rows(set, results, &cells));
        rows.retain(|(_, summary)| !summary.records.is_empty());
        rows
    }
}

fn field_of(set: RobocupSet, experiment: &RobocupExperiment) -> Result<Field, ExperimentError> {
    let failed = |reason: String| ExperimentError::Run { cell: set.name().to_owned(), run: 0, reason };
    let scenario = set.scenario(experiment.settings().length).map_err(|error| failed(error.to_string()))?;
    match Map::load(&scenario.map).map_err(|error| failed(error.to_string()))? {
        Map::Field(field) => Ok(field),
        other => Err(failed(format!("expected a RoboCup field, found {}", other.name()))),
    }
}

fn notes() -> Vec<String> {
    vec![
        "Right: within 0.5 m and 20 degrees; found: right and localized for at least a second. Position and heading of kidnaps: \
         from then on. What is never found counts as slower than everything."
            .to_owned(),
        "Frames that track the robot: localized and right. Band: in which the mean of as many independent runs lies with \
         probability 0.95 (chi-square); the frames of one run are not independent, so each run counts once."
            .to_owned(),
    ]
}

fn contender_json((label, summary): &Row<'_>) -> Value {
    let (position, heading) = (summary.position_m(), summary.heading_deg());
    let calibration = summary.calibration();
    let runs = summary.nees_of_runs();
    let kidnaps = summary.num_kidnaps();
    let recovery = |p| quantile(summary.kidnaps().map(|kidnap| kidnap.recovery_s), p);
    let all: Vec<_> = summary.records.iter().map(|record| &record.consistency).collect();
    let frames: u64 = all.iter().map(|c| c.frames).sum();
    json!({
        "algorithm": label,
        "runs": summary.records.len(),
        "position_error_m": { "mean": position.mean, "worst_run": position.worst },
        "heading_error_deg": { "mean": heading.mean, "worst_run": heading.worst },
        "kidnaps": {
            "count": kidnaps,
            "right_at_end": share(summary.count(|kidnap| kidnap.is_right_at_end), kidnaps),
            "found": share(summary.count(|kidnap| kidnap.recovery_s.is_some()), kidnaps),
            "recovery_s": { "median": recovery(0.5), "p90": recovery(0.9) },
            "reliable_s": { "median": quantile(summary.kidnaps().map(|kidnap| kidnap.reliable_s), 0.5) },
            "both_among_hypotheses": share(summary.count(|kidnap| kidnap.has_both), kidnaps),
        },
        "calibration": {
            "near_m": NEAR_M,
            "frames": calibration.frames,
            "near": calibration.near,
            "claimed": calibration.claimed,
            "claimed_near": ratio(calibration.claimed_near, calibration.claimed),
        },
        "nees": {
            "mean_of_runs": mean(&runs),
            "runs": runs,
            "seconds_in_band": seconds_in_band(summary),
            "in_ellipsoid": ratio(all.iter().map(|c| c.in_ellipsoid).sum(), frames),
            "position_in_ellipse": ratio(all.iter().map(|c| c.in_position_ellipse).sum(), frames),
        },
    })
}

fn timing_json(timing: &AlgorithmTiming) -> Value {
    json!({ "algorithm": timing.algorithm, "iteration_ms": timing.iteration_ms })
}
