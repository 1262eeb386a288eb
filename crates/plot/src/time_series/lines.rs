//! One series inside its panel.

use super::{Series, SeriesStyle};
use crate::{
    chart::PlotArea,
    line_style,
    svg::{Canvas, Paint, Point},
};

const LINE_PX: f64 = 1.7;
const DOT_PX: f64 = 1.6;

/// Size and least distance of the marks of values outside the range, pixels.
const OUTSIDE_PX: f64 = 7.0;
const OUTSIDE_GAP_PX: f64 = 10.0;
const MAX_OUTSIDE_ROWS: usize = 4;

pub(super) fn draw_series(canvas: &mut Canvas, area: &PlotArea, series: &Series, index: usize) {
    let rect = &area.rect;
    canvas.begin_clip(rect);
    let place = |&(secs, value): &(f64, f64)| {
        // far values stay near, for a line that leaves the panel at the right angle yet has small numbers
        let y = area.y.px(value).clamp(rect.top - 10.0 * rect.height(), rect.bottom + 10.0 * rect.height());
        (area.x.px(secs), y)
    };
    for run in series.points.split(|(secs, value)| !(secs.is_finite() && value.is_finite())) {
        let points: Vec<Point> = run.iter().map(place).collect();
        if series.style == SeriesStyle::Line && points.len() > 1 {
            canvas.polyline(&points, &line_style::stroke(series.color, LINE_PX));
            line_style::draw_marks(canvas, series.color, &points);
        } else {
            for point in points {
                canvas.circle(point, DOT_PX, &Paint::fill(series.color).opacity(0.75));
            }
        }
    }
    canvas.end_group();
    draw_outside(canvas, area, series, index % MAX_OUTSIDE_ROWS);
}

/// Small triangles at the border that point to values outside the range, each series in its own row.
fn draw_outside(canvas: &mut Canvas, area: &PlotArea, series: &Series, row: usize) {
    let depth = 1.0 + row as f64 * (OUTSIDE_PX + 1.0);
    let (min, max) = area.y.range();
    let rect = &area.rect;
    for (border, down) in [(rect.top + depth, 1.0), (rect.bottom - depth, -1.0)] {
        let mut last = f64::NEG_INFINITY;
        for &(secs, value) in &series.points {
            let x = area.x.px(secs);
            let is_outside = if down > 0.0 { value > max } else { value < min };
            let is_visible = x >= rect.left && x <= rect.right;
            if !is_visible || !is_outside || x - last < OUTSIDE_GAP_PX {
                continue;
            }
            last = x;
            let base = border + down * OUTSIDE_PX;
            let corners = [(x, border), (x - OUTSIDE_PX / 2.0, base), (x + OUTSIDE_PX / 2.0, base)];
            canvas.polygon(&corners, &Paint::fill(series.color));
        }
    }
}
