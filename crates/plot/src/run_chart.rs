//! A dot for every run, in groups.

use crate::{
    BarSeries, Color, Picture, ReferenceLine, ValueAxis,
    axis::Axis,
    bar_chart::{FILLED, GROUP_LINE_PX, LEFT_PX, PLOT_PX, draw_group_labels, group_labels},
    chart::{PlotArea, reference_margin_px},
    header::{Header, LegendEntry, Symbol},
    svg::{Canvas, Paint, Rect},
};

const DOT_PX: f64 = 4.0;
/// Farthest that the dots of a run and of the next are apart.
const STEP_PX: f64 = 12.0;

/// Single values in groups, each series at its place in every group: repeated runs of some algorithms on some recordings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RunChart {
    /// Large, at the top.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// Quantity and unit.
    pub value_label: String,
    /// Range of the values.
    pub axis: ValueAxis,
    /// Name and color of the dots at the same place of every group.
    pub series: Vec<BarSeries>,
    /// From left to right.
    pub groups: Vec<RunGroup>,
    /// Horizontal lines.
    pub references: Vec<ReferenceLine>,
}

/// Runs side by side, for instance the algorithms on one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RunGroup {
    /// Below the dots.
    pub label: String,
    /// Values of each series, in the order of the runs; not a number is left out.
    pub runs: Vec<Vec<f64>>,
}

/// A dot for every value, and a bar at the median of each series in each group.
#[must_use]
pub fn run_chart(input: &RunChart) -> Picture {
    let right = LEFT_PX + PLOT_PX.0;
    let entries =
        input.series.iter().map(|series| LegendEntry::new(&series.label, Symbol::Dot(series.color)));
    let header = Header::new((LEFT_PX, right), &input.title, &input.subtitle, entries.collect());
    let top = header.height_px() + 14.0;
    let rect = Rect { left: LEFT_PX, top, right, bottom: top + PLOT_PX.1 };
    let values = input.groups.iter().flat_map(|group| group.runs.iter().flatten().copied());
    let values = values.chain(input.references.iter().map(|line| line.value));
    let y = Axis::of_values(input.axis, values, (rect.bottom, rect.top));
    #[allow(clippy::cast_precision_loss)]
    let x = Axis::linear((0.0, input.groups.len().max(1) as f64), (rect.left, rect.right));
    let area = PlotArea { rect, x, y };
    let labels = group_labels(input.groups.iter().map(|group| group.label.as_str()), &area);
    #[allow(clippy::cast_precision_loss)]
    let labels_px = labels.iter().map(Vec::len).max().unwrap_or(0) as f64 * GROUP_LINE_PX;
    let width = right + reference_margin_px(input.references.iter());
    let mut canvas = Canvas::new(width, rect.bottom + labels_px + 24.0);
    header.draw(&mut canvas);
    area.draw_horizontal_grid(&mut canvas);
    area.draw_references(&mut canvas, &input.references);
    draw_groups(&mut canvas, &area, input);
    area.draw_border(&mut canvas);
    area.draw_vertical_ticks(&mut canvas);
    area.draw_y_label(&mut canvas, &input.value_label, 58.0);
    draw_group_labels(&mut canvas, &area, &labels);
    canvas.finish()
}

#[allow(clippy::cast_precision_loss)]
fn draw_groups(canvas: &mut Canvas, area: &PlotArea, input: &RunChart) {
    let slot = FILLED / input.series.len().max(1) as f64;
    let slot_px = area.x.px(slot) - area.x.px(0.0);
    canvas.begin_clip(&area.rect);
    for (i, group) in input.groups.iter().enumerate() {
        for (j, (values, series)) in group.runs.iter().zip(&input.series).enumerate() {
            let mut values: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
            let middle = area.x.px(i as f64 + (1.0 - FILLED) / 2.0 + (j as f64 + 0.5) * slot);
            let step = (0.7 * slot_px / values.len().max(1) as f64).min(STEP_PX);
            let left = middle - 0.5 * step * values.len().saturating_sub(1) as f64;
            for (k, value) in values.iter().enumerate() {
                let paint = Paint::fill(series.color).opacity(0.75);
                canvas.circle((left + k as f64 * step, area.y.px(*value)), DOT_PX, &paint);
            }
            values.sort_by(f64::total_cmp);
            let Some(median) = values.get(values.len() / 2) else { continue };
            let (half, at) = ((0.35 * slot_px).min(3.0 * STEP_PX), area.y.px(*median));
            canvas.line((middle - half, at), (middle + half, at), &Paint::stroke(Color::BLACK, 1.5));
        }
    }
    canvas.end_group();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_has_a_dot_and_one_without_a_value_none() {
        let series = ["a", "b"].map(|label| BarSeries { label: label.to_owned(), color: Color::BLUE });
        let picture = run_chart(&RunChart {
            series: series.to_vec(),
            groups: vec![
                RunGroup { label: "first".to_owned(), runs: vec![vec![0.1, 0.2, f64::NAN], vec![0.3]] },
                RunGroup { label: "second".to_owned(), runs: vec![vec![], vec![0.4]] },
            ],
            axis: ValueAxis::Log { min: 0.01, max: 1.0 },
            ..RunChart::default()
        });
        let in_legend = 2;
        assert_eq!(picture.svg().matches("<circle").count() - in_legend, 4);
    }
}
