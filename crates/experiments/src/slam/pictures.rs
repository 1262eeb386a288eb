//! Paths, errors over time and bars.

use visloc_plot::{
    Bar, BarChart, BarGroup, BarSeries, Color, Panel, Picture, Series, SpacePath, SpaceViews,
    TimeSeriesPicture, ValueAxis, bar_chart, space_views, time_series,
};

use super::{SlamExperiment, SlamRunRecord, sequence::short_name};
use crate::{Experiment, Results};

/// Errors below this are drawn at it, meters.
const LEAST_ERROR_M: f64 = 1e-4;

/// For each sequence the first run of each configuration, and the errors of all.
pub(super) fn pictures(
    experiment: &SlamExperiment,
    results: &Results<SlamRunRecord>,
) -> Vec<(String, Picture)> {
    let settings = experiment.settings();
    let n = settings.configurations.len();
    let mut pictures = Vec::new();
    for (i, sequence) in settings.sequences.iter().enumerate() {
        let name = short_name(sequence);
        let file = name.replace([':', '/', ' '], "-");
        let firsts: Vec<(&str, &SlamRunRecord)> = (0..n)
            .filter_map(|j| Some((settings.configurations[j].as_str(), results.cell(i * n + j).next()?)))
            .collect();
        let [above, side] = space_views(&paths(&name, &firsts));
        pictures.push((format!("{file}-paths"), above));
        pictures.push((format!("{file}-paths-side"), side));
        pictures.push((format!("{file}-errors"), errors(&name, &firsts)));
    }
    pictures.push(("errors".to_owned(), bars(experiment, results)));
    pictures
}

fn paths(name: &str, firsts: &[(&str, &SlamRunRecord)]) -> SpaceViews {
    let truth = firsts.first().map(|(_, record)| SpacePath {
        label: "truth".to_owned(),
        color: Color::BLACK,
        points: record.true_path.clone(),
        ..SpacePath::default()
    });
    let estimates = firsts.iter().enumerate().map(|(i, (configuration, record))| SpacePath {
        label: (*configuration).to_owned(),
        color: Color::series(i),
        points: record.path.iter().map(|[_, x, y, z, _]| [*x, *y, *z]).collect(),
        ..SpacePath::default()
    });
    SpaceViews {
        title: name.to_owned(),
        subtitle: "the first run of each".to_owned(),
        paths: truth.into_iter().chain(estimates).collect(),
        ..SpaceViews::default()
    }
}

fn errors(name: &str, firsts: &[(&str, &SlamRunRecord)]) -> Picture {
    let series = |(i, (configuration, record)): (usize, &(&str, &SlamRunRecord))| {
        let points = record.path.iter().map(|[t, _, _, _, error]| (*t, error.max(LEAST_ERROR_M))).collect();
        Series::new(configuration, Color::series(i), points)
    };
    let largest = firsts.iter().flat_map(|(_, r)| &r.path).map(|p| p[4]).fold(0.1, f64::max);
    time_series(&TimeSeriesPicture {
        title: format!("{name}: position error after alignment"),
        subtitle: "the first run of each".to_owned(),
        panels: vec![Panel {
            label: "position error [m]".to_owned(),
            axis: ValueAxis::Log { min: LEAST_ERROR_M, max: 2.0 * largest },
            series: firsts.iter().enumerate().map(series).collect(),
            ..Panel::default()
        }],
        ..TimeSeriesPicture::default()
    })
}

fn bars(experiment: &SlamExperiment, results: &Results<SlamRunRecord>) -> Picture {
    let settings = experiment.settings();
    let n = settings.configurations.len();
    let bar = |cell: usize| {
        let mut values: Vec<f64> = results.cell(cell).filter_map(|record| record.ate_rmse_m).collect();
        values.sort_by(f64::total_cmp);
        let interval = values.first().copied().zip(values.last().copied());
        Bar { value: values.get(values.len() / 2).copied().unwrap_or(f64::NAN), interval }
    };
    let group = |(i, sequence): (usize, &String)| BarGroup {
        label: short_name(sequence),
        bars: (0..n).map(|j| bar(i * n + j)).collect(),
    };
    let series = settings.configurations.iter().enumerate();
    bar_chart(&BarChart {
        title: "Error of the trajectory".to_owned(),
        subtitle: "median of the runs, lines from the best to the worst".to_owned(),
        value_label: "RMSE [m]".to_owned(),
        series: series.map(|(j, name)| BarSeries { label: name.clone(), color: Color::series(j) }).collect(),
        groups: settings.sequences.iter().enumerate().map(group).collect(),
        ..BarChart::default()
    })
}
