//! Bars with error bars, in groups.

use crate::{
    Color, Picture, ReferenceLine, ValueAxis,
    axis::Axis,
    chart::{LABEL_PX, PlotArea, reference_margin_px},
    font::{self, Weight},
    header::{Header, LegendEntry, Symbol},
    svg::{Anchor, Canvas, Paint, Point, Rect, TextStyle},
};

pub(crate) const LEFT_PX: f64 = 84.0;
pub(crate) const PLOT_PX: (f64, f64) = (820.0, 340.0);
const GROUP_LABEL_PX: f64 = 12.0;
pub(crate) const GROUP_LINE_PX: f64 = 15.0;

/// Share of a group's width that its bars fill.
pub(crate) const FILLED: f64 = 0.74;

/// Groups of bars, one bar for each series.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BarChart {
    /// Large, at the top.
    pub title: String,
    /// Below the title, for instance what the error bars mean.
    pub subtitle: String,
    /// Quantity and unit.
    pub value_label: String,
    /// Range of the values.
    pub axis: ValueAxis,
    /// Name and color of the bars of every group.
    pub series: Vec<BarSeries>,
    /// From left to right.
    pub groups: Vec<BarGroup>,
    /// Horizontal lines.
    pub references: Vec<ReferenceLine>,
}

/// Name and color of the bars at the same place of every group.
#[derive(Debug, Clone, PartialEq)]
pub struct BarSeries {
    /// In the legend.
    pub label: String,
    /// Of the bars.
    pub color: Color,
}

/// Bars side by side, for instance the algorithms on one scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct BarGroup {
    /// Below the bars.
    pub label: String,
    /// One for each series, in their order.
    pub bars: Vec<Bar>,
}

/// A value and its interval. Not a number leaves the place empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Height of the bar.
    pub value: f64,
    /// Lower and upper end of the error bar.
    pub interval: Option<(f64, f64)>,
}

/// Bars in groups with error bars. An error bar that leaves the range ends at the border without its crossbar.
#[must_use]
pub fn bar_chart(input: &BarChart) -> Picture {
    let right = LEFT_PX + PLOT_PX.0;
    let entries = input.series.iter().map(|s| LegendEntry::new(&s.label, Symbol::Patch(s.color, 1.0)));
    let header = Header::new((LEFT_PX, right), &input.title, &input.subtitle, entries.collect());
    let top = header.height_px() + 14.0;
    let rect = Rect { left: LEFT_PX, top, right, bottom: top + PLOT_PX.1 };
    let bars = input.groups.iter().flat_map(|group| &group.bars);
    let values = bars.flat_map(|bar| {
        let (low, high) = bar.interval.unwrap_or((bar.value, bar.value));
        [bar.value, low, high]
    });
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
    draw_groups(&mut canvas, &area, input);
    area.draw_references(&mut canvas, &input.references);
    area.draw_border(&mut canvas);
    area.draw_vertical_ticks(&mut canvas);
    area.draw_y_label(&mut canvas, &input.value_label, 58.0);
    draw_group_labels(&mut canvas, &area, &labels);
    canvas.finish()
}

#[allow(clippy::cast_precision_loss)]
fn draw_groups(canvas: &mut Canvas, area: &PlotArea, input: &BarChart) {
    let slot = FILLED / input.series.len().max(1) as f64;
    canvas.begin_clip(&area.rect);
    for (i, group) in input.groups.iter().enumerate() {
        for (j, (bar, series)) in group.bars.iter().zip(&input.series).enumerate() {
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

/// The labels below the groups, in lines as long as the groups are wide.
pub(crate) fn group_labels<'a>(labels: impl Iterator<Item = &'a str>, area: &PlotArea) -> Vec<Vec<String>> {
    let group_px = area.x.px(1.0) - area.x.px(0.0);
    labels.map(|label| font::wrap(label, GROUP_LABEL_PX, Weight::Regular, group_px - 8.0)).collect()
}

#[allow(clippy::cast_precision_loss)]
pub(crate) fn draw_group_labels(canvas: &mut Canvas, area: &PlotArea, labels: &[Vec<String>]) {
    let style = TextStyle::new(GROUP_LABEL_PX, Color::BLACK).anchor(Anchor::Middle);
    for (i, lines) in labels.iter().enumerate() {
        let middle = area.x.px(i as f64 + 0.5);
        for (j, line) in lines.iter().enumerate() {
            let y = area.rect.bottom + 7.0 + LABEL_PX + j as f64 * GROUP_LINE_PX;
            canvas.text((middle, y), line, &style);
        }
    }
}
