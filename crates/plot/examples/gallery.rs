//! Draws every kind of picture with made-up data of a run of 70 s with two kidnaps:
//! `cargo run --release -p visloc-plot --example gallery -- <folder>`.

use std::{env, path::Path};

use visloc_core::geom::PlanarPose;
use visloc_plot::{
    Bar, BarChart, BarSeries, Color, FieldPath, FieldPicture, Grid, Group, HeatMap, Histogram,
    HistogramSeries, Kidnap, Mark, Panel, PathPoint, PlotError, PoseMark, ReferenceLine, Series, Span,
    TimeSeriesPicture, ValueAxis, bar_chart, field_picture, heat_map, histogram, surface_picture,
    time_series,
};
use visloc_world::{Map, field::Field};

const CARRIED_SECS: [(f64, f64); 2] = [(22.0, 25.0), (47.0, 50.0)];

struct Sample {
    secs: f64,
    truth: PlanarPose,
    estimates: [PlanarPose; 2],
    reliabilities: [f64; 2],
}

fn main() -> Result<(), PlotError> {
    let folder = env::args().nth(1).unwrap_or_else(|| "gallery".to_owned());
    let folder = Path::new(&folder);
    let field = built_in_field("robocup-spl-2010");
    let run = run();
    field_picture(&field, &field_input(&run)).save(folder, "field")?;
    time_series(&series_input(&run)).save(folder, "time_series")?;
    time_series(&TimeSeriesPicture::default()).save(folder, "empty")?;
    heat_map(&heat_input(), Some((&field).into())).save(folder, "heat_map")?;
    surface_picture(&heat_input(), Some(&field)).save(folder, "surface")?;
    bar_chart(&bar_input()).save(folder, "bars")?;
    histogram(&histogram_input(&run)).save(folder, "histogram")
}

fn built_in_field(name: &str) -> Field {
    match Map::load(name) {
        Ok(Map::Field(field)) => field,
        other => panic!("{name} is a built-in field, found {other:?}"),
    }
}

/// A repeatable number in [-1, 1].
fn noise(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

fn is_carried(secs: f64) -> bool {
    CARRIED_SECS.iter().any(|(start, end)| (*start..*end).contains(&secs))
}

fn truth_at(secs: f64) -> PlanarPose {
    let (cx, cy, phase) = match secs {
        s if s < 23.5 => (-1.4, 0.0, 0.0),
        s if s < 48.5 => (1.3, -0.4, 2.0),
        _ => (-0.6, 0.7, 4.5),
    };
    let a = 0.28 * secs + phase;
    PlanarPose::new(cx + 1.25 * a.cos(), cy + 0.95 * (1.3 * a).sin(), a + 1.6)
}

fn run() -> Vec<Sample> {
    let mut samples = Vec::new();
    for i in 0..2100usize {
        let secs = i as f64 / 30.0;
        if is_carried(secs) {
            continue;
        }
        let truth = truth_at(secs);
        let since = secs - CARRIED_SECS.iter().map(|c| c.1).filter(|end| *end <= secs).fold(0.0, f64::max);
        let estimate = |k: usize, recovery_secs: f64, jitter_m: f64| {
            let wobble = |j: usize| {
                jitter_m * ((secs * (0.9 + 0.3 * j as f64) + k as f64).sin() + 0.3 * noise(i * 7 + k * 3 + j))
            };
            let is_lost = since < recovery_secs && secs > 1.5 || secs < 0.6 * recovery_secs.min(2.0);
            let lost = if is_lost { 1.9 - 0.2 * since.min(3.0) } else { 0.0 };
            let pose = PlanarPose::new(
                truth.x_m + wobble(0) - lost,
                truth.y_m + wobble(1) + 0.4 * lost,
                truth.yaw_rad + 0.4 * wobble(2) + lost,
            );
            let reliability = if is_lost {
                0.25 + 0.1 * noise(i)
            } else {
                0.88 + 0.06 * noise(i + k) - 0.1 * (secs * 0.3).sin().powi(8)
            };
            (pose, reliability)
        };
        let (a, b) = (estimate(0, 2.2, 0.06), estimate(1, 6.5, 0.11));
        samples.push(Sample { secs, truth, estimates: [a.0, b.0], reliabilities: [a.1, b.1] });
    }
    samples
}

const NAMES: [&str; 2] = ["particle filter, 200 particles", "evolutionary, 50 + 50 individuals"];

fn field_input(run: &[Sample]) -> FieldPicture {
    let estimate = |k: usize| {
        let point = |s: &Sample| match s.reliabilities[k] > 0.6 {
            true => PathPoint::localized(&s.estimates[k]),
            false => PathPoint::not_localized(&s.estimates[k]),
        };
        FieldPath {
            label: NAMES[k].to_owned(),
            color: [Color::BLUE, Color::VERMILION][k],
            points: run.iter().map(point).collect(),
        }
    };
    FieldPicture {
        title: "Colored goals, two kidnaps, 70 s".to_owned(),
        subtitle: "Mean error while localized: particle filter 0.07 m / 1.6°, evolutionary 0.12 m / 2.9°. Recovery after 2.2 s and 6.5 s.".to_owned(),
        truth: Some(FieldPath::new("truth", Color::BLACK, run.iter().map(|s| s.truth))),
        estimates: vec![estimate(0), estimate(1)],
        kidnaps: CARRIED_SECS.iter().map(|&(from, to)| Kidnap { from: truth_at(from), to: truth_at(to) }).collect(),
        start: Some(truth_at(0.0)),
        ..FieldPicture::default()
    }
}

fn series_input(run: &[Sample]) -> TimeSeriesPicture {
    let colors = [Color::BLUE, Color::VERMILION];
    let series = |k: usize, value: &dyn Fn(&Sample, usize) -> f64| {
        let mut points: Vec<(f64, f64)> = run.iter().map(|s| (s.secs, value(s, k))).collect();
        points.extend(CARRIED_SECS.iter().map(|c| (c.0, f64::NAN)));
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Series::new(NAMES[k], colors[k], points)
    };
    let both = |value: &dyn Fn(&Sample, usize) -> f64| vec![series(0, value), series(1, value)];
    let line = |value: f64, label: &str| ReferenceLine { value, label: label.to_owned(), color: Color::GRAY };
    let panel =
        |label: &str, axis, series, references| Panel { label: label.to_owned(), axis, series, references };
    TimeSeriesPicture {
        title: "Colored goals, two kidnaps, 70 s".to_owned(),
        subtitle: "Errors against the simulated truth; both algorithms see the same frames".to_owned(),
        x_label: String::new(),
        panels: vec![
            panel(
                "position error [m]",
                ValueAxis::Linear { min: 0.0, max: 0.6 },
                both(&|s, k| s.truth.distance_m(&s.estimates[k])),
                vec![line(0.15, "published 0.15 m"), line(0.12, "goal 0.12 m")],
            ),
            panel(
                "heading error [deg]",
                ValueAxis::Log { min: 0.01, max: 180.0 },
                both(&|s, k| s.truth.heading_difference_rad(&s.estimates[k]).to_degrees()),
                vec![],
            ),
            panel(
                "reliability",
                ValueAxis::Linear { min: 0.0, max: 1.0 },
                both(&|s, k| s.reliabilities[k]),
                vec![line(0.6, "localized")],
            ),
            panel(
                "time per frame [ms]",
                ValueAxis::Auto,
                both(&|s, k| 2.0 + 2.5 * k as f64 + 0.3 * noise((s.secs * 30.0) as usize)),
                vec![],
            ),
        ],
        spans: CARRIED_SECS
            .iter()
            .map(|c| Span { start_secs: c.0, end_secs: c.1, label: "carried".to_owned() })
            .collect(),
        marks: CARRIED_SECS
            .iter()
            .enumerate()
            .map(|(i, c)| Mark { at_secs: c.0, label: format!("kidnap {}", i + 1) })
            .collect(),
        range_secs: None,
        panel_px: None,
    }
}

fn heat_input() -> HeatMap {
    let (num_columns, rows, cell_m) = (148usize, 108usize, 0.05);
    let mut values = Vec::new();
    for row in 0..rows {
        for column in 0..num_columns {
            let (x, y) = (-3.7 + (column as f64 + 0.5) * cell_m, -2.7 + (row as f64 + 0.5) * cell_m);
            let peak = |cx: f64, cy: f64, s: f64| ((x - cx).powi(2) + (y - cy).powi(2)) / (2.0 * s * s);
            values.push(-(peak(1.2, 0.6, 0.5).min(8.0 + peak(-1.2, -0.6, 0.5)).min(40.0)));
        }
    }
    let mark = |label: &str, color, x, y| PoseMark {
        label: label.to_owned(),
        color,
        pose: PlanarPose::new(x, y, 0.4),
    };
    HeatMap {
        title: "Likelihood of one image over the field".to_owned(),
        subtitle: "Heading fixed to the true one".to_owned(),
        value_label: "log-likelihood".to_owned(),
        grid: Grid { origin_m: [-3.7, -2.7], cell_m, num_columns, values },
        range: None,
        marks: vec![mark("truth", Color::BLACK, 1.15, 0.5), mark("estimate", Color::VERMILION, 1.6, 0.9)],
    }
}

fn bar_input() -> BarChart {
    let bar = |value: f64, spread: f64| Bar { value, interval: Some((value - spread, value + 1.4 * spread)) };
    let group = |label: &str, values: Vec<Bar>| Group { label: label.to_owned(), values };
    let series = |label: &str, color| BarSeries { label: label.to_owned(), color };
    BarChart {
        title: "Mean position error by scenario".to_owned(),
        subtitle: "20 seeds; error bars from the 10th to the 90th percentile".to_owned(),
        value_label: "position error [m]".to_owned(),
        axis: ValueAxis::Auto,
        series: vec![
            series(NAMES[0], Color::BLUE),
            series(NAMES[1], Color::VERMILION),
            series("both, racing", Color::PURPLE),
        ],
        groups: vec![
            group("no kidnaps", vec![bar(0.07, 0.01), bar(0.11, 0.02), bar(0.06, 0.01)]),
            group("two kidnaps", vec![bar(0.14, 0.03), bar(0.21, 0.05), bar(0.12, 0.02)]),
            group("white goals, strong noise", vec![bar(0.19, 0.05), bar(f64::NAN, 0.1), bar(0.17, 0.04)]),
            group("half of the field unlit", vec![bar(0.24, 0.06), bar(0.27, 0.03), bar(0.2, 0.05)]),
        ],
        references: vec![ReferenceLine { value: 0.15, label: "published".to_owned(), color: Color::GRAY }],
    }
}

fn histogram_input(run: &[Sample]) -> Histogram {
    let series = |k: usize| HistogramSeries {
        label: NAMES[k].to_owned(),
        color: [Color::BLUE, Color::VERMILION][k],
        values: run.iter().map(|s| s.truth.distance_m(&s.estimates[k])).collect(),
    };
    Histogram {
        title: "Position errors of the run".to_owned(),
        subtitle: "Errors above 0.4 m count in the last interval".to_owned(),
        value_label: "position error [m]".to_owned(),
        num_bins: 40,
        range: Some((0.0, 0.4)),
        series: vec![series(0), series(1)],
    }
}
