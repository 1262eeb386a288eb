//! Values in groups side by side: the frame of charts of bars and of dots.

use crate::{
    Color, Picture, ReferenceLine, ValueAxis,
    axis::Axis,
    chart::{LABEL_PX, PlotArea, reference_margin_px},
    font::{self, Weight},
    header::{Header, LegendEntry, Symbol},
    svg::{Anchor, Canvas, Rect, TextStyle},
};

const LEFT_PX: f64 = 84.0;
const PLOT_PX: (f64, f64) = (820.0, 340.0);
const GROUP_LABEL_PX: f64 = 12.0;
const GROUP_LINE_PX: f64 = 15.0;

/// Share of a group's width that its values fill.
pub(crate) const FILLED: f64 = 0.74;

/// Groups of values, one place in each group for each series.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GroupChart<T> {
    /// Large, at the top.
    pub title: String,
    /// Below the title, for instance what the error bars mean.
    pub subtitle: String,
    /// Quantity and unit.
    pub value_label: String,
    /// Range of the values.
    pub axis: ValueAxis,
    /// Name and color of what is at the same place of every group.
    pub series: Vec<BarSeries>,
    /// From left to right.
    pub groups: Vec<Group<T>>,
    /// Horizontal lines.
    pub references: Vec<ReferenceLine>,
}

/// Name and color of what is at the same place of every group.
#[derive(Debug, Clone, PartialEq)]
pub struct BarSeries {
    /// In the legend.
    pub label: String,
    /// Of bars or dots.
    pub color: Color,
}

/// Values side by side, for instance the algorithms on one scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Group<T> {
    /// Below them.
    pub label: String,
    /// One for each series, in their order.
    pub values: Vec<T>,
}

/// A chart with all that is around its data: `values` decide the range, `draw` draws data and reference lines.
pub(crate) fn framed<T>(
    chart: &GroupChart<T>,
    symbol: impl Fn(Color) -> Symbol,
    values: impl Iterator<Item = f64>,
    draw: impl FnOnce(&mut Canvas, &PlotArea),
) -> Picture {
    let right = LEFT_PX + PLOT_PX.0;
    let entries = chart.series.iter().map(|series| LegendEntry::new(&series.label, symbol(series.color)));
    let header = Header::new((LEFT_PX, right), &chart.title, &chart.subtitle, entries.collect());
    let top = header.height_px() + 14.0;
    let rect = Rect { left: LEFT_PX, top, right, bottom: top + PLOT_PX.1 };
    let values = values.chain(chart.references.iter().map(|line| line.value));
    let y = Axis::of_values(chart.axis, values, (rect.bottom, rect.top));
    let x = Axis::linear((0.0, chart.groups.len().max(1) as f64), (rect.left, rect.right));
    let area = PlotArea { rect, x, y };
    // Labels below the groups are in lines as long as the groups are wide.
    let group_px = area.x.px(1.0) - area.x.px(0.0);
    let label = |group: &Group<T>| font::wrap(&group.label, GROUP_LABEL_PX, Weight::Regular, group_px - 8.0);
    let labels: Vec<Vec<String>> = chart.groups.iter().map(label).collect();
    let labels_px = labels.iter().map(Vec::len).max().unwrap_or(0) as f64 * GROUP_LINE_PX;
    let width = right + reference_margin_px(chart.references.iter());
    let mut canvas = Canvas::new(width, rect.bottom + labels_px + 24.0);
    header.draw(&mut canvas);
    area.draw_horizontal_grid(&mut canvas);
    draw(&mut canvas, &area);
    area.draw_border(&mut canvas);
    area.draw_vertical_ticks(&mut canvas);
    area.draw_y_label(&mut canvas, &chart.value_label, 58.0);
    draw_labels(&mut canvas, &area, &labels);
    canvas.finish()
}

fn draw_labels(canvas: &mut Canvas, area: &PlotArea, labels: &[Vec<String>]) {
    let style = TextStyle::new(GROUP_LABEL_PX, Color::BLACK).anchor(Anchor::Middle);
    for (i, lines) in labels.iter().enumerate() {
        let middle = area.x.px(i as f64 + 0.5);
        for (j, line) in lines.iter().enumerate() {
            let y = area.rect.bottom + 7.0 + LABEL_PX + j as f64 * GROUP_LINE_PX;
            canvas.text((middle, y), line, &style);
        }
    }
}
