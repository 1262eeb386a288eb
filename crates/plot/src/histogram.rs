//! How often values occur.

use crate::{
    Color, Picture, ValueAxis,
    axis::{Axis, finite_range},
    chart::{HorizontalLabels, PlotArea},
    header::{Header, LegendEntry, Symbol},
    svg::{Canvas, Paint, Point, Rect},
};

const LEFT_PX: f64 = 84.0;
const PLOT_PX: (f64, f64) = (760.0, 320.0);

/// How often the values of one or more series occur.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Histogram {
    /// Large, at the top.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// Quantity and unit.
    pub value_label: String,
    /// Number of equal intervals; at least 1 is used.
    pub num_bins: usize,
    /// Counted range; without it from the smallest to the largest value. Values above it count in the last interval,
    /// values below it in the first.
    pub range: Option<(f64, f64)>,
    /// The values.
    pub series: Vec<HistogramSeries>,
}

/// Values with their name and color.
#[derive(Debug, Clone, PartialEq)]
pub struct HistogramSeries {
    /// In the legend.
    pub label: String,
    /// Of outline and filling.
    pub color: Color,
    /// In any order. Not a number is not counted.
    pub values: Vec<f64>,
}

/// The share of the values in each interval, in percent of its series.
pub fn histogram(input: &Histogram) -> Picture {
    let right = LEFT_PX + PLOT_PX.0;
    let entries = input.series.iter().map(|s| LegendEntry::new(&s.label, Symbol::Patch(s.color, 0.5)));
    let header = Header::new((LEFT_PX, right), &input.title, &input.subtitle, entries.collect());
    let top = header.height_px() + 14.0;
    let rect = Rect { left: LEFT_PX, top, right, bottom: top + PLOT_PX.1 };
    let all = input.series.iter().flat_map(|series| series.values.iter().copied());
    let range = input.range.or_else(|| finite_range(all)).unwrap_or((0.0, 1.0));
    let x = Axis::linear(range, (rect.left, rect.right));
    let shares: Vec<Vec<f64>> = input
        .series
        .iter()
        .map(|series| shares_percent(&series.values, x.range(), input.num_bins.max(1)))
        .collect();
    let values = shares.iter().flatten().copied();
    let y = Axis::of_values(ValueAxis::Auto, values, (rect.bottom, rect.top));
    let area = PlotArea { rect, x, y };
    let mut canvas = Canvas::new(right + 28.0, rect.bottom + 58.0);
    header.draw(&mut canvas);
    area.draw_grid(&mut canvas);
    for (series, shares) in input.series.iter().zip(&shares) {
        let outline = outline(&area, shares);
        canvas.polygon(&outline, &Paint::fill(series.color).opacity(0.25));
        canvas.polyline(&outline, &Paint::stroke(series.color, 1.8));
    }
    area.draw_frame(&mut canvas, HorizontalLabels::Shown);
    area.draw_x_label(&mut canvas, &input.value_label);
    area.draw_y_label(&mut canvas, "share of values [%]", 58.0);
    canvas.finish()
}

fn shares_percent(values: &[f64], (min, max): (f64, f64), num_bins: usize) -> Vec<f64> {
    let mut counts = vec![0usize; num_bins];
    for value in values.iter().filter(|value| !value.is_nan()) {
        let fraction = ((value - min) / (max - min)).clamp(0.0, 1.0);
        counts[((fraction * num_bins as f64) as usize).min(num_bins - 1)] += 1;
    }
    let total = counts.iter().sum::<usize>().max(1) as f64;
    counts.into_iter().map(|count| 100.0 * count as f64 / total).collect()
}

fn outline(area: &PlotArea, shares: &[f64]) -> Vec<Point> {
    let rect = area.rect;
    let bin_px = rect.width() / shares.len() as f64;
    let mut points = vec![(rect.left, rect.bottom)];
    for (i, &share) in shares.iter().enumerate() {
        let left = rect.left + i as f64 * bin_px;
        points.push((left, area.y.px(share)));
        points.push((left + bin_px, area.y.px(share)));
    }
    points.push((rect.right, rect.bottom));
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_and_outer_values_count_at_the_ends() {
        let values = [-1.0, 0.1, 0.3, 0.9, 7.0, f64::INFINITY, f64::NAN, 0.35];
        let shares = shares_percent(&values, (0.0, 1.0), 4);
        assert!((shares.iter().sum::<f64>() - 100.0).abs() < 1e-9);
        let sevenths: Vec<f64> = shares.iter().map(|share| (share * 0.07).round()).collect();
        assert_eq!(sevenths, [2.0, 2.0, 0.0, 3.0]);
    }

    #[test]
    fn nothing_to_count_gives_an_empty_picture() {
        let series = vec![HistogramSeries { label: "x".into(), color: Color::BLUE, values: vec![f64::NAN] }];
        assert!(histogram(&Histogram { series, ..Histogram::default() }).is_valid_svg());
        assert!(histogram(&Histogram::default()).is_valid_svg());
    }
}
