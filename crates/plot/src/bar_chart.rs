//! Bars with error bars, in groups.

use crate::{
    Color, Picture,
    chart::PlotArea,
    group_chart::{FILLED, GroupChart, framed},
    header::Symbol,
    svg::{Canvas, Paint, Point, Rect},
};

/// Groups of bars, one bar for each series.
pub type BarChart = GroupChart<Bar>;

/// A value and its interval. Not a number leaves the place empty.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bar {
    /// Height of the bar.
    pub value: f64,
    /// Lower and upper end of the error bar.
    pub interval: Option<(f64, f64)>,
}

/// Bars in groups with error bars. An error bar that leaves the range ends at the border without its crossbar.
pub fn bar_chart(input: &BarChart) -> Picture {
    let values = input.groups.iter().flat_map(|group| &group.values).flat_map(|bar| {
        let (low, high) = bar.interval.unwrap_or((bar.value, bar.value));
        [bar.value, low, high]
    });
    framed(
        input,
        |color| Symbol::Patch(color, 1.0),
        values,
        |canvas, area| {
            draw_groups(canvas, area, input);
            area.draw_references(canvas, &input.references);
        },
    )
}

fn draw_groups(canvas: &mut Canvas, area: &PlotArea, input: &BarChart) {
    let slot = FILLED / input.series.len().max(1) as f64;
    canvas.begin_clip(&area.rect);
    for (i, group) in input.groups.iter().enumerate() {
        for (j, (bar, series)) in group.values.iter().zip(&input.series).enumerate() {
            let left = i as f64 + (1.0 - FILLED) / 2.0 + j as f64 * slot;
            let (left, right) = (area.x.px(left), area.x.px(left + slot));
            draw_bar(canvas, area, bar, (left + 1.0, right - 1.0), series.color);
        }
    }
    canvas.end_group();
}

fn draw_bar(canvas: &mut Canvas, area: &PlotArea, bar: &Bar, (left, right): Point, color: Color) {
    if !bar.value.is_finite() {
        return;
    }
    let rect = area.rect;
    let inside = |value: f64| area.y.px(value).clamp(rect.top - 50.0, rect.bottom + 50.0);
    let (zero, end) = (inside(0.0).min(rect.bottom), inside(bar.value));
    canvas.rect(&Rect { left, right, top: zero.min(end), bottom: zero.max(end) }, &Paint::fill(color));
    if let Some((low, high)) = bar.interval.filter(|(low, high)| low.is_finite() && high.is_finite()) {
        let (middle, half) = (f64::midpoint(left, right), (0.18 * (right - left)).min(7.0));
        let (low, high) = (inside(low), inside(high));
        for paint in [Paint::stroke(Color::WHITE, 3.6), Paint::stroke(Color::BLACK, 1.5)] {
            canvas.line((middle, low), (middle, high), &paint);
            canvas.line((middle - half, low), (middle + half, low), &paint);
            canvas.line((middle - half, high), (middle + half, high), &paint);
        }
    }
}
