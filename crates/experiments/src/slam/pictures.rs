//! Paths, errors and times over time, and bars.

use visloc_plot::{
    Bar, BarChart, BarSeries, Color, Group, Panel, Picture, Series, SpacePath, SpaceViews, TimeSeriesPicture,
    ValueAxis, bar_chart, space_views, time_series,
};

use super::{SlamExperiment, SlamRunRecord, SlamStudy, sequence::short_name};
use crate::{Experiment, Results, quantile, sorted};

/// Errors below this are drawn at it, meters.
const LEAST_ERROR_M: f64 = 1e-4;

/// Pictures of a sequence are called so, and by what they show.
pub(super) fn file_name(short_name: &str) -> String {
    short_name.replace([':', '/', ' '], "-")
}

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
        let file = file_name(&name);
        let firsts: Vec<(&str, &SlamRunRecord)> = (0..n)
            .filter_map(|j| Some((settings.configurations[j].as_str(), results.cell(i * n + j).next()?)))
            .collect();
        match settings.study {
            SlamStudy::Configs => pictures.push((format!("{file}-times"), times(&name, &firsts))),
            SlamStudy::LostPoints => {
                pictures.push((format!("{file}-thresholds"), thresholds(experiment, results, i)));
            }
            SlamStudy::Dynamic => pictures.push((format!("{file}-x"), along_x(&name, &firsts))),
            SlamStudy::Kidnap | SlamStudy::Compare => {}
        }
        let [above, side] = space_views(&paths(&name, &firsts));
        pictures.push((format!("{file}-paths"), above));
        pictures.push((format!("{file}-paths-side"), side));
        pictures.push((format!("{file}-errors"), errors(&name, &firsts)));
    }
    pictures.push(("errors".to_owned(), bars(experiment, results)));
    pictures
}

/// Panels above each other, of the first runs.
fn over_time(title: String, panels: Vec<Panel>) -> Picture {
    let subtitle = "the first run of each".to_owned();
    time_series(&TimeSeriesPicture { title, subtitle, panels, ..TimeSeriesPicture::default() })
}

/// A line for each wanted configuration.
fn lines(
    firsts: &[(&str, &SlamRunRecord)],
    is_wanted: impl Fn(&str) -> bool,
    points: impl Fn(&SlamRunRecord) -> Vec<(f64, f64)>,
) -> Vec<Series> {
    let wanted = firsts.iter().enumerate().filter(|(_, (name, _))| is_wanted(name));
    wanted.map(|(i, (name, record))| Series::new(name, Color::series(i), points(record))).collect()
}

/// Time of each image: tracking without bundle adjustment, mapping without rejection. Source: 2017 figure 7.2.
fn times(name: &str, firsts: &[(&str, &SlamRunRecord)]) -> Picture {
    // As many as there are colors.
    let is_shown = |name: &str| !matches!(name, "config4" | "config8");
    let firsts: Vec<_> = firsts.iter().filter(|(name, _)| is_shown(name)).copied().collect();
    let panel = |label: &str, wanted: [&str; 4], column: usize| Panel {
        label: label.to_owned(),
        series: lines(
            &firsts,
            |name| wanted.contains(&name),
            |r| r.image_ms.iter().map(|image| (image[0], image[column])).collect(),
        ),
        ..Panel::default()
    };
    let panels = vec![
        panel("tracking [ms]", ["config1", "config2", "config5", "config6"], 1),
        panel("mapping [ms]", ["config1", "config3", "config5", "config7"], 2),
    ];
    over_time(
        format!("{name}: time of an image; tracking without adjustment, mapping without rejection"),
        panels,
    )
}

/// Where the camera is along x. Source: 2017 figure 7.6.
fn along_x(name: &str, firsts: &[(&str, &SlamRunRecord)]) -> Picture {
    let points = |r: &SlamRunRecord| r.path.iter().map(|point| (point[0], point[1])).collect();
    let all = sorted(firsts.iter().flat_map(|(_, record)| &record.path).map(|point| point[1]));
    let axis = match (all.first(), all.last()) {
        (Some(low), Some(high)) => {
            let border = (0.1 * (high - low)).max(0.005);
            ValueAxis::Linear { min: low - border, max: high + border }
        }
        _ => ValueAxis::default(),
    };
    let series = lines(firsts, |_| true, points);
    let panel = Panel { label: "x [m]".to_owned(), axis, series, ..Panel::default() };
    over_time(format!("{name}: the camera along x"), vec![panel])
}

/// Times and error by the threshold, medians of the runs. Source: 2017 figure 7.3.
fn thresholds(experiment: &SlamExperiment, results: &Results<SlamRunRecord>, sequence: usize) -> Picture {
    let names = &experiment.settings().configurations;
    let series = |label: &str, i: usize, value: &dyn Fn(&SlamRunRecord) -> Option<f64>| {
        let median = |j: usize| {
            let cell = results.cell(sequence * names.len() + j);
            quantile(&sorted(cell.filter_map(value)), 0.5).unwrap_or(f64::NAN)
        };
        let points = names.iter().enumerate().map(|(j, name)| (name.parse().unwrap_or(f64::NAN), median(j)));
        Series::new(label, Color::series(i), points.collect())
    };
    let panel =
        |label: &str, series: Vec<Series>| Panel { label: label.to_owned(), series, ..Panel::default() };
    time_series(&TimeSeriesPicture {
        title: format!(
            "{}: share of lost points that asks for a keyframe",
            short_name(&experiment.settings().sequences[sequence])
        ),
        subtitle: "config8, medians of the runs".to_owned(),
        x_label: "threshold".to_owned(),
        panels: vec![
            panel(
                "time [ms]",
                vec![series("tracking", 0, &|r| r.tracking_ms), series("mapping", 1, &|r| r.mapping_ms)],
            ),
            panel("RMSE [m]", vec![series("error", 2, &|r| r.ate_rmse_m)]),
            panel("coverage [%]", vec![series("images with a pose", 3, &|r| Some(100.0 * r.coverage))]),
        ],
        ..TimeSeriesPicture::default()
    })
}

fn paths(name: &str, firsts: &[(&str, &SlamRunRecord)]) -> SpaceViews {
    let truth =
        firsts.first().map(|(_, record)| SpacePath::line("truth", Color::BLACK, record.true_path.clone()));
    let estimates = firsts.iter().enumerate().map(|(i, (configuration, record))| {
        let points = record.path.iter().map(|[_, x, y, z, _]| [*x, *y, *z]).collect();
        SpacePath::line(*configuration, Color::series(i), points)
    });
    SpaceViews {
        title: name.to_owned(),
        subtitle: "the first run of each".to_owned(),
        paths: truth.into_iter().chain(estimates).collect(),
        ..SpaceViews::default()
    }
}

fn errors(name: &str, firsts: &[(&str, &SlamRunRecord)]) -> Picture {
    let points = |r: &SlamRunRecord| r.path.iter().map(|p| (p[0], p[4].max(LEAST_ERROR_M))).collect();
    let largest = firsts.iter().flat_map(|(_, r)| &r.path).map(|p| p[4]).fold(0.1, f64::max);
    let panel = Panel {
        label: "position error [m]".to_owned(),
        axis: ValueAxis::Log { min: LEAST_ERROR_M, max: 2.0 * largest },
        series: lines(firsts, |_| true, points),
        ..Panel::default()
    };
    over_time(format!("{name}: position error after alignment"), vec![panel])
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
    let group = |(i, sequence): (usize, &String)| Group {
        label: short_name(sequence),
        values: (0..n).map(|j| bar(i * n + j)).collect(),
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
