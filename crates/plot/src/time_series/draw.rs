//! Puts the panels together.

use super::{Mark, Panel, SeriesStyle, TimeSeriesPicture, lines};
use crate::{
    Color, Picture,
    axis::{Axis, finite_range, round_step},
    chart::{HorizontalLabels, LABEL_PX, PlotArea, TICK_LABEL_PX, reference_margin_px},
    font::{self, Weight},
    header::{Header, LegendEntry, Symbol},
    svg::{Anchor, Canvas, Paint, Rect, TextStyle},
};

const WIDTH_PX: f64 = 1000.0;
const LEFT_PX: f64 = 68.0;
const PANEL_PX: f64 = 140.0;
const PANEL_LABEL_PX: f64 = 26.0;
const BELOW_PX: f64 = 58.0;
const MARK_ROW_PX: f64 = 16.0;
const MAX_MARK_ROWS: usize = 3;

const SPAN: Color = Color::rgb(0x9a, 0x9a, 0x9a);
const SPAN_OPACITY: f64 = 0.28;
const MARK: Color = Color::rgb(0x6a, 0x1b, 0x7a);

/// Panels above each other with a common axis of time in seconds. Values outside the range of a panel are shown as
/// small triangles at its border.
pub fn time_series(input: &TimeSeriesPicture) -> Picture {
    let references = input.panels.iter().flat_map(|panel| &panel.references);
    let right = WIDTH_PX - reference_margin_px(references).min(WIDTH_PX / 3.0);
    let time = Axis::linear(time_range(input), (LEFT_PX, right));
    let header = Header::new((LEFT_PX, right), &input.title, &input.subtitle, legend(input));
    let marks = place_marks(&input.marks, &time, right);
    let num_rows = marks.iter().map(|mark| mark.row + 1).max().unwrap_or(0);
    let (marks_px, num_panels) = (num_rows as f64 * MARK_ROW_PX, input.panels.len().max(1) as f64);
    let first_top = header.height_px() + marks_px + PANEL_LABEL_PX;
    let panel_px = input.panel_px.filter(|px| px.is_finite()).map_or(PANEL_PX, |px| px.clamp(40.0, 1000.0));
    let height = header.height_px() + marks_px + num_panels * (panel_px + PANEL_LABEL_PX) + BELOW_PX;
    let mut canvas = Canvas::new(WIDTH_PX, height);
    header.draw(&mut canvas);

    let empty = [Panel::default()];
    let panels = if input.panels.is_empty() { &empty[..] } else { &input.panels };
    let mut top = first_top;
    for (i, panel) in panels.iter().enumerate() {
        let rect = Rect { left: LEFT_PX, top, right, bottom: top + panel_px };
        let values = panel.series.iter().flat_map(|series| &series.points).map(|point| point.1);
        let values = values.chain(panel.references.iter().map(|line| line.value));
        let y = Axis::of_values(panel.axis, values, (rect.bottom, rect.top));
        let area = PlotArea { rect, x: time, y };
        let is_last = i + 1 == panels.len();
        draw_panel(&mut canvas, &area, panel, input, &marks);
        area.draw_frame(
            &mut canvas,
            if is_last { HorizontalLabels::Shown } else { HorizontalLabels::Hidden },
        );
        if is_last {
            let label = if input.x_label.is_empty() { "time [s]" } else { &input.x_label };
            area.draw_x_label(&mut canvas, label);
        }
        top += panel_px + PANEL_LABEL_PX;
    }
    draw_mark_labels(&mut canvas, &marks, header.height_px() + MARK_ROW_PX);
    canvas.finish()
}

fn time_range(input: &TimeSeriesPicture) -> (f64, f64) {
    let series = input.panels.iter().flat_map(|panel| &panel.series);
    let times = series.flat_map(|series| &series.points).map(|point| point.0);
    let spans = input.spans.iter().flat_map(|span| [span.start_secs, span.end_secs]);
    let all = times.chain(spans).chain(input.marks.iter().map(|mark| mark.at_secs));
    input.range_secs.or_else(|| finite_range(all).map(with_near_ticks)).unwrap_or((0.0, 1.0))
}

/// Moves the ends to round times that are very near: 70 s of frames end a little before 70 s.
fn with_near_ticks((start, end): (f64, f64)) -> (f64, f64) {
    let near = 0.01 * (end - start);
    let step = round_step((end - start) / 14.0);
    let (before, after) = ((start / step).floor() * step, (end / step).ceil() * step);
    (if start - before <= near { before } else { start }, if after - end <= near { after } else { end })
}

fn legend(input: &TimeSeriesPicture) -> Vec<LegendEntry> {
    let series = input.panels.iter().flat_map(|panel| &panel.series);
    let spans = input.spans.iter();
    series
        .map(|series| {
            let symbol = match series.style {
                SeriesStyle::Line => Symbol::Line(series.color),
                SeriesStyle::Points => Symbol::Dot(series.color),
            };
            LegendEntry::new(&series.label, symbol)
        })
        .chain(spans.map(|span| LegendEntry::new(&span.label, Symbol::Patch(SPAN, SPAN_OPACITY))))
        .collect()
}

fn draw_panel(
    canvas: &mut Canvas,
    area: &PlotArea,
    panel: &Panel,
    input: &TimeSeriesPicture,
    marks: &[PlacedMark<'_>],
) {
    let rect = area.rect;
    let style = TextStyle::new(LABEL_PX, Color::BLACK).bold();
    canvas.text((rect.left, rect.top - 7.0), &panel.label, &style);
    for span in &input.spans {
        let left = area.x.px(span.start_secs).max(rect.left);
        let right = area.x.px(span.end_secs).min(rect.right);
        if left < right {
            let shade = Rect { left, right, ..rect };
            canvas.rect(&shade, &Paint::fill(SPAN).opacity(SPAN_OPACITY));
        }
    }
    area.draw_grid(canvas);
    for mark in marks {
        canvas.line((mark.x, rect.top), (mark.x, rect.bottom), &Paint::stroke(MARK, 1.3).dashed());
    }
    area.draw_references(canvas, &panel.references);
    for (i, series) in panel.series.iter().enumerate() {
        lines::draw_series(canvas, area, series, i);
    }
}

/// A mark and where its label goes; row 0 is the lowest.
#[derive(Debug)]
struct PlacedMark<'a> {
    x: f64,
    label_x: f64,
    row: usize,
    label: &'a str,
}

/// Labels that would overlap go into different rows.
fn place_marks<'a>(marks: &'a [Mark], time: &Axis, right: f64) -> Vec<PlacedMark<'a>> {
    let (start, end) = time.range();
    let mut shown: Vec<&Mark> =
        marks.iter().filter(|mark| mark.at_secs >= start && mark.at_secs <= end).collect();
    shown.sort_by(|a, b| a.at_secs.total_cmp(&b.at_secs));
    let mut row_ends = [f64::NEG_INFINITY; MAX_MARK_ROWS];
    let mut placed = Vec::new();
    for mark in shown {
        let x = time.px(mark.at_secs);
        let half = font::width_px(&mark.label, TICK_LABEL_PX, Weight::Bold) / 2.0;
        let label_x = x.min(right - half).max(LEFT_PX + half);
        let free = row_ends.iter().position(|row_end| label_x - half > row_end + 8.0);
        let row = free.unwrap_or(0);
        // without a free row the label is left out: the line stays
        let label = if free.is_some() { mark.label.as_str() } else { "" };
        if free.is_some() {
            row_ends[row] = label_x + half;
        }
        placed.push(PlacedMark { x, label_x, row, label });
    }
    placed
}

fn draw_mark_labels(canvas: &mut Canvas, marks: &[PlacedMark<'_>], top: f64) {
    let num_rows = marks.iter().map(|mark| mark.row + 1).max().unwrap_or(0);
    for mark in marks {
        let y = top + (num_rows - 1 - mark.row) as f64 * MARK_ROW_PX;
        let style = TextStyle::new(TICK_LABEL_PX, MARK).bold().anchor(Anchor::Middle);
        canvas.text((mark.label_x, y), mark.label, &style);
    }
}
