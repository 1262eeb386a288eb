//! Pictures of a class: the error of every run beside the figures of others, and a way.

use visloc_plot::{
    BarSeries, Color, Group, Picture, ReferenceLine, RunChart, SpacePath, SpaceViews, ValueAxis, run_chart,
    space_views,
};

use super::{Row, store::Cell};

/// Errors below this are drawn at it, in the quantity's unit.
const LEAST_ERROR: f64 = 1e-4;

/// The error of every run; `rows` are those of a class that show its first error.
pub fn errors(rows: &[&Row<'_>]) -> Option<Picture> {
    let first = rows.first()?;
    let mut recordings: Vec<&str> = rows.iter().flat_map(|row| row.recordings()).collect();
    recordings.sort_unstable();
    recordings.dedup();
    let values = |row: &Row<'_>, recording: &str| {
        row.values_on(recording).into_iter().map(|value| value.max(LEAST_ERROR)).collect()
    };
    let group = |recording: &&str| Group {
        label: (*recording).to_owned(),
        values: rows.iter().map(|row| values(row, recording)).collect(),
    };
    let groups: Vec<Group<Vec<f64>>> = recordings.iter().map(group).collect();
    let mut references: Vec<ReferenceLine> = Vec::new();
    for figure in rows.iter().flat_map(|row| [row.published, row.peer]).flatten() {
        if references.iter().all(|known| (known.value - figure.value).abs() > 1e-12) {
            let label = format!("{}: {}", figure.from.word(), figure.by);
            references.push(ReferenceLine { value: figure.value, label, color: Color::GRAY });
        }
    }
    let drawn = groups.iter().flat_map(|group| group.values.iter().flatten().copied());
    let drawn: Vec<f64> = drawn.chain(references.iter().map(|line| line.value)).collect();
    let (min, max) = drawn.iter().fold((f64::INFINITY, 0.0_f64), |(min, max), v| (min.min(*v), max.max(*v)));
    if !min.is_finite() {
        return None;
    }
    let series = rows.iter().enumerate();
    Some(run_chart(&RunChart {
        title: first.class.to_owned(),
        subtitle: "a dot for each run, a bar at their median".to_owned(),
        value_label: first.quantity.title().to_owned(),
        axis: ValueAxis::Log { min: 0.5 * min, max: 2.0 * max },
        series: series
            .map(|(i, row)| BarSeries { label: row.contender.to_owned(), color: Color::series(i) })
            .collect(),
        groups,
        references,
    }))
}

/// The way of a run, seen from above, over the truth.
pub fn way(cell: &Cell) -> Option<Picture> {
    let points = |way: &[Option<[f64; 3]>]| way.iter().map(|point| point.unwrap_or([f64::NAN; 3])).collect();
    let path = |label, color, way| SpacePath::line(label, color, points(way));
    let has_points = cell.estimate.iter().any(Option::is_some);
    let [above, _] = space_views(&SpaceViews {
        title: cell.key.recording.clone(),
        subtitle: format!("{}, seed {}", cell.key.contender, cell.key.seed),
        paths: vec![path("truth", Color::BLACK, &cell.truth), path("estimate", Color::BLUE, &cell.estimate)],
        ..SpaceViews::default()
    });
    has_points.then_some(above)
}
