//! A dot for every run, in groups.

use crate::{
    Color, Picture,
    chart::PlotArea,
    group_chart::{FILLED, GroupChart, framed},
    header::Symbol,
    svg::{Canvas, Paint},
};

const DOT_PX: f64 = 4.0;
/// Farthest that the dots of a run and of the next are apart.
const STEP_PX: f64 = 12.0;

/// Repeated runs of some algorithms on some recordings: values of each series, in the order of the runs. Not a number is left
/// out.
pub type RunChart = GroupChart<Vec<f64>>;

/// A dot for every value, and a bar at the median of each series in each group.
pub fn run_chart(input: &RunChart) -> Picture {
    let values = input.groups.iter().flat_map(|group| group.values.iter().flatten().copied());
    framed(input, Symbol::Dot, values, |canvas, area| {
        area.draw_references(canvas, &input.references);
        draw_groups(canvas, area, input);
    })
}

fn draw_groups(canvas: &mut Canvas, area: &PlotArea, input: &RunChart) {
    let slot = FILLED / input.series.len().max(1) as f64;
    let slot_px = area.x.px(slot) - area.x.px(0.0);
    canvas.begin_clip(&area.rect);
    for (i, group) in input.groups.iter().enumerate() {
        for (j, (values, series)) in group.values.iter().zip(&input.series).enumerate() {
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
    use crate::{BarSeries, Group, ValueAxis};

    #[test]
    fn every_run_has_a_dot_and_one_without_a_value_none() {
        let series = ["a", "b"].map(|label| BarSeries { label: label.to_owned(), color: Color::BLUE });
        let picture = run_chart(&RunChart {
            series: series.to_vec(),
            groups: vec![
                Group { label: "first".to_owned(), values: vec![vec![0.1, 0.2, f64::NAN], vec![0.3]] },
                Group { label: "second".to_owned(), values: vec![vec![], vec![0.4]] },
            ],
            axis: ValueAxis::Log { min: 0.01, max: 1.0 },
            ..RunChart::default()
        });
        let in_legend = 2;
        assert_eq!(picture.svg().matches("<circle").count() - in_legend, 4);
    }
}
