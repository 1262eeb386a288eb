//! The pictures: the first run of every set, and both proofs.

use visloc_core::geom::PlanarPose;
use visloc_locate::LOCALIZED_RELIABILITY;
use visloc_plot::{
    Bar, BarChart, BarSeries, Color, FieldPath, FieldPicture, Group, Kidnap, Mark, Panel, PathPoint, Picture,
    ReferenceLine, Series, SeriesStyle, Span, TimeSeriesPicture, ValueAxis, bar_chart, field_picture,
    time_series,
};
use visloc_world::field::Field;

use super::{
    chi_square::mean_band_95,
    record::{ContenderRecord, RobocupRecord, TracePoint, TruthPoint},
    reliability::NEAR_M,
    sets::RobocupSet,
    summary::quantile,
    tables::Row,
};
use crate::{mean, ratio};

type Pictures = Vec<(String, Picture)>;

/// Paths and errors of every contender in the first run of a set.
pub(super) fn first_run(set: RobocupSet, field: &Field, record: &RobocupRecord) -> Pictures {
    let Some(truth) = &record.truth else { return Vec::new() };
    let mut pictures = Vec::new();
    for contender in &record.contenders {
        let Some(trace) = &contender.trace else { continue };
        let name = format!("{}-{}", set.name(), file_part(&contender.contender));
        let title = format!("{}: {}", set.title(), contender.contender);
        pictures.push((format!("{name}-path"), path(&title, field, truth, contender, trace)));
        pictures.push((format!("{name}-errors"), errors(&title, truth, trace)));
    }
    pictures
}

/// A label as part of a file's name.
fn file_part(label: &str) -> String {
    let words = label.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-")
}

fn path(
    title: &str,
    field: &Field,
    truth: &[TruthPoint],
    contender: &ContenderRecord,
    trace: &[TracePoint],
) -> Picture {
    let pose = |t: &TruthPoint| PlanarPose::new(f64::from(t.1), f64::from(t.2), f64::from(t.3));
    let truth_point = |t: &TruthPoint| if t.4 { PathPoint::gap() } else { PathPoint::localized(&pose(t)) };
    let point = |t: &TracePoint| PathPoint {
        x_m: f64::from(t.1),
        y_m: f64::from(t.2),
        is_localized: f64::from(t.4) > LOCALIZED_RELIABILITY,
    };
    let landings = carried(truth).into_iter().filter_map(|(first, last)| {
        Some(Kidnap { from: pose(truth.get(first)?), to: pose(truth.get(last + 1)?) })
    });
    let mean_m = contender.position_error_m.mean;
    field_picture(
        field,
        &FieldPicture {
            title: title.to_owned(),
            subtitle: mean_m.map_or_else(String::new, |m| format!("first run; mean position error {m:.3} m")),
            truth: Some(FieldPath {
                label: "truth".to_owned(),
                color: Color::BLACK,
                points: truth.iter().map(truth_point).collect(),
            }),
            estimates: vec![FieldPath {
                label: contender.contender.clone(),
                color: Color::VERMILION,
                points: trace.iter().map(point).collect(),
            }],
            kidnaps: landings.collect(),
            start: truth.first().map(pose),
            ..FieldPicture::default()
        },
    )
}

/// First and last index of every time in which the robot is carried.
fn carried(truth: &[TruthPoint]) -> Vec<(usize, usize)> {
    let mut spans: Vec<(usize, usize)> = Vec::new();
    for (i, _) in truth.iter().enumerate().filter(|(_, point)| point.4) {
        match spans.last_mut() {
            Some((_, last)) if *last + 1 == i => *last = i,
            _ => spans.push((i, i)),
        }
    }
    spans
}

fn errors(title: &str, truth: &[TruthPoint], trace: &[TracePoint]) -> Picture {
    let value = |value: &dyn Fn(&TruthPoint, &TracePoint) -> f64| -> Vec<(f64, f64)> {
        let pairs = truth.iter().zip(trace);
        let at =
            |(t, p): (&TruthPoint, &TracePoint)| (f64::from(t.0), if t.4 { f64::NAN } else { value(t, p) });
        pairs.map(at).collect()
    };
    let position = value(&|t, p| f64::from((t.1 - p.1).hypot(t.2 - p.2)).max(0.01));
    let heading = value(&|t, p| {
        let error = visloc_core::geom::angle::difference(f64::from(p.3), f64::from(t.3));
        error.abs().to_degrees().max(0.1)
    });
    let reliability = trace.iter().map(|p| (f64::from(p.0), f64::from(p.4))).collect();
    let panel = |label: &str, axis, color, points| Panel {
        label: label.to_owned(),
        axis,
        series: vec![Series::new("", color, points)],
        ..Panel::default()
    };
    let mut last = panel("reliability", ValueAxis::Linear { min: 0.0, max: 1.0 }, Color::BLUE, reliability);
    last.references.push(ReferenceLine {
        value: LOCALIZED_RELIABILITY,
        label: "localized above".to_owned(),
        color: Color::GRAY,
    });
    let secs = |i: usize| truth.get(i).map_or(f64::NAN, |point| f64::from(point.0));
    let spans = carried(truth).into_iter().map(|(first, end)| Span {
        start_secs: secs(first),
        end_secs: secs(end),
        label: "carried".to_owned(),
    });
    time_series(&TimeSeriesPicture {
        title: title.to_owned(),
        subtitle: "first run".to_owned(),
        panels: vec![
            panel("position error [m]", ValueAxis::Log { min: 0.01, max: 10.0 }, Color::VERMILION, position),
            panel("heading error [deg]", ValueAxis::Log { min: 0.1, max: 180.0 }, Color::VERMILION, heading),
            last,
        ],
        spans: spans.collect(),
        ..TimeSeriesPicture::default()
    })
}

/// Fewer frames in an interval say nothing.
const LEAST_FRAMES: u64 = 100;

/// Share of the frames near the truth against the reported reliability, one panel for each contender.
pub(super) fn calibration(rows: &[Row<'_>]) -> Picture {
    let panel = |(label, summary): &Row<'_>| {
        let sum = summary.calibration();
        let points = (0..10).filter(|bin| sum.frames[*bin] >= LEAST_FRAMES).filter_map(|bin| {
            let near = ratio(sum.near[bin], sum.frames[bin])?;
            Some((sum.reliability[bin] / sum.frames[bin] as f64, near))
        });
        let points: Vec<(f64, f64)> = points.collect();
        let dots = Series { style: SeriesStyle::Points, ..Series::new("", Color::BLUE, points.clone()) };
        let claimed = ratio(sum.claimed_near, sum.claimed).map_or_else(String::new, |share| {
            format!(": {:.2} % of the {} frames above {LOCALIZED_RELIABILITY}", 100.0 * share, sum.claimed)
        });
        Panel {
            label: format!("{label}{claimed}"),
            axis: ValueAxis::Linear { min: 0.0, max: 1.0 },
            series: vec![
                Series::new("share equal to the reliability", Color::GRAY, vec![(0.0, 0.0), (1.0, 1.0)]),
                Series::new("share of the frames near the truth", Color::BLUE, points),
                dots,
            ],
            references: vec![ReferenceLine { value: 0.99, label: "99 %".to_owned(), color: Color::GRAY }],
        }
    };
    time_series(&TimeSeriesPicture {
        title: "Does the reliability mean something?".to_owned(),
        subtitle: format!(
            "Share of the frames within {NEAR_M:.2} m of the truth by reported reliability, in ten intervals with at least \
             {LEAST_FRAMES} frames each; all runs"
        ),
        x_label: "reported reliability".to_owned(),
        panels: rows.iter().map(panel).collect(),
        marks: vec![Mark { at_secs: LOCALIZED_RELIABILITY, label: "localized".to_owned() }],
        range_secs: Some((0.0, 1.02)),
        panel_px: Some(if rows.len() > 3 { 150.0 } else { 320.0 }),
        ..TimeSeriesPicture::default()
    })
}

/// Mean normalized error of all contenders with the spread of their runs.
pub(super) fn consistency(rows: &[Row<'_>]) -> Picture {
    let groups = rows.iter().map(|(label, summary)| {
        let runs = summary.nees_of_runs();
        let at = |p| quantile(runs.iter().map(|value| Some(*value)), p);
        let interval = at(0.025).zip(at(0.975));
        let bar = Bar { value: mean(&runs).unwrap_or(f64::NAN), interval };
        Group { label: label.clone(), values: vec![bar] }
    });
    let num_runs = rows.iter().map(|(_, summary)| summary.nees_of_runs().len()).max().unwrap_or(0);
    let (low, high) = mean_band_95(3, u32::try_from(num_runs).unwrap_or(u32::MAX));
    let reference = |value, label: &str| ReferenceLine { value, label: label.to_owned(), color: Color::GRAY };
    bar_chart(&BarChart {
        title: "Is the covariance honest?".to_owned(),
        subtitle: format!(
            "Normalized error squared over (x, y, heading) while tracking, mean of {num_runs} runs; 95 % of the runs lie in the error \
             bars; an honest covariance gives 3"
        ),
        value_label: "normalized error squared".to_owned(),
        axis: ValueAxis::Log { min: 0.1, max: 100.0 },
        series: vec![BarSeries { label: "mean of the runs".to_owned(), color: Color::BLUE }],
        groups: groups.collect(),
        references: vec![reference(low, &format!("{low:.2}")), reference(high, &format!("{high:.2}: band"))],
    })
}

/// Mean normalized error over the runs in every second, one panel for each contender.
pub(super) fn consistency_over_time(rows: &[Row<'_>]) -> Picture {
    let panel = |(i, (label, summary)): (usize, &Row<'_>)| {
        let points = summary.nees_over_time().into_iter().enumerate();
        let points = points.map(|(second, (nees, _))| (second as f64, nees)).collect();
        let num_runs = u32::try_from(summary.nees_of_runs().len()).unwrap_or(u32::MAX);
        let (low, high) = mean_band_95(3, num_runs);
        let line = |value, label: &str| ReferenceLine { value, label: label.to_owned(), color: Color::GRAY };
        Panel {
            label: format!("{label}: mean of {num_runs} runs"),
            axis: ValueAxis::Log { min: 0.1, max: 100.0 },
            series: vec![Series::new("", Color::series(i), points)],
            references: vec![line(low, "95 % band"), line(high, "95 % band")],
        }
    };
    time_series(&TimeSeriesPicture {
        title: "Normalized error squared over time".to_owned(),
        subtitle: "Mean over the runs that track the robot in that second, all sets; band for as many independent runs"
            .to_owned(),
        panels: rows.iter().enumerate().map(panel).collect(),
        ..TimeSeriesPicture::default()
    })
}
