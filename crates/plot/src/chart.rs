//! The frame of a chart: grid, ticks, labels and reference lines.

use crate::{
    Color,
    axis::Axis,
    font::{self, Weight},
    svg::{Anchor, Canvas, Paint, Rect, TextStyle},
};

pub(crate) const TICK_LABEL_PX: f64 = 11.5;
pub(crate) const LABEL_PX: f64 = 12.5;

const GRID: Color = Color::rgb(0xe3, 0xe3, 0xe3);
const MINOR_GRID: Color = Color::rgb(0xf1, 0xf1, 0xf1);
const FRAME: Color = Color::rgb(0x8a, 0x8a, 0x8a);

/// A horizontal line at a value that matters, with its label right of the panel.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceLine {
    /// Where on the vertical axis.
    pub value: f64,
    /// What it means.
    pub label: String,
    /// Color of line and label.
    pub color: Color,
}

/// The rectangle of a chart and its axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlotArea {
    pub(crate) rect: Rect,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
}

/// Where the tick labels of the horizontal axis go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HorizontalLabels {
    Shown,
    Hidden,
}

impl PlotArea {
    /// Grid lines of both axes, behind the data.
    pub(crate) fn draw_grid(&self, canvas: &mut Canvas) {
        let rect = &self.rect;
        let paint =
            |label: &Option<String>| Paint::stroke(if label.is_some() { GRID } else { MINOR_GRID }, 1.0);
        for tick in self.x.ticks(70.0) {
            let x = self.x.px(tick.value);
            canvas.line((x, rect.top), (x, rect.bottom), &paint(&tick.label));
        }
        self.draw_horizontal_grid(canvas);
    }

    /// Grid lines of the vertical axis only.
    pub(crate) fn draw_horizontal_grid(&self, canvas: &mut Canvas) {
        for tick in self.y.ticks(self.vertical_spacing_px()) {
            let y = self.y.px(tick.value);
            let color = if tick.label.is_some() { GRID } else { MINOR_GRID };
            canvas.line((self.rect.left, y), (self.rect.right, y), &Paint::stroke(color, 1.0));
        }
    }

    /// Border, ticks and their labels, in front of the data.
    pub(crate) fn draw_frame(&self, canvas: &mut Canvas, horizontal: HorizontalLabels) {
        self.draw_border(canvas);
        self.draw_vertical_ticks(canvas);
        for tick in self.x.ticks(70.0) {
            let x = self.x.px(tick.value);
            let bottom = self.rect.bottom;
            canvas.line((x, bottom), (x, bottom + 4.0), &Paint::stroke(FRAME, 1.0));
            if let (Some(label), HorizontalLabels::Shown) = (&tick.label, horizontal) {
                let style = TextStyle::new(TICK_LABEL_PX, Color::GRAY).anchor(Anchor::Middle);
                canvas.text((x, bottom + 7.0 + TICK_LABEL_PX), label, &style);
            }
        }
    }

    /// Least distance of the labels of the vertical axis: fewer of them in a tall chart than would fit.
    fn vertical_spacing_px(&self) -> f64 {
        (self.rect.height() / 9.0).max(26.0)
    }

    pub(crate) fn draw_border(&self, canvas: &mut Canvas) {
        canvas.rect(&self.rect, &Paint::stroke(FRAME, 1.0));
    }

    pub(crate) fn draw_vertical_ticks(&self, canvas: &mut Canvas) {
        let left = self.rect.left;
        for tick in self.y.ticks(self.vertical_spacing_px()) {
            let y = self.y.px(tick.value);
            if let Some(label) = &tick.label {
                canvas.line((left - 4.0, y), (left, y), &Paint::stroke(FRAME, 1.0));
                let style = TextStyle::new(TICK_LABEL_PX, Color::GRAY).anchor(Anchor::End);
                canvas.text((left - 8.0, y + 0.36 * TICK_LABEL_PX), label, &style);
            }
        }
    }

    /// Label of the horizontal axis below its tick labels.
    pub(crate) fn draw_x_label(&self, canvas: &mut Canvas, label: &str) {
        let middle = f64::midpoint(self.rect.left, self.rect.right);
        let style = TextStyle::new(LABEL_PX, Color::BLACK).anchor(Anchor::Middle);
        canvas.text((middle, self.rect.bottom + 42.0), label, &style);
    }

    /// Label of the vertical axis, running upwards, `distance_px` left of the chart.
    pub(crate) fn draw_y_label(&self, canvas: &mut Canvas, label: &str, distance_px: f64) {
        let middle = f64::midpoint(self.rect.top, self.rect.bottom);
        let style = TextStyle::new(LABEL_PX, Color::BLACK).anchor(Anchor::Middle);
        canvas.vertical_text((self.rect.left - distance_px, middle), label, &style);
    }

    /// Reference lines inside the range, labels at the right, moved apart where they would overlap.
    pub(crate) fn draw_references(&self, canvas: &mut Canvas, references: &[ReferenceLine]) {
        let (min, max) = self.y.range();
        let mut shown: Vec<&ReferenceLine> =
            references.iter().filter(|line| line.value >= min && line.value <= max).collect();
        shown.sort_by(|a, b| b.value.total_cmp(&a.value));
        let places: Vec<f64> = shown.iter().map(|line| self.y.px(line.value)).collect();
        let labels = spread(&places, TICK_LABEL_PX * 1.25);
        let right = self.rect.right;
        for ((line, y), label_y) in shown.iter().zip(places).zip(labels) {
            canvas.line((self.rect.left, y), (right, y), &Paint::stroke(line.color, 1.4).dashed());
            let style = TextStyle::new(TICK_LABEL_PX, line.color);
            canvas.text((right + 8.0, label_y + 0.36 * TICK_LABEL_PX), &line.label, &style);
        }
    }
}

/// Space right of a chart that the labels of its reference lines need, pixels.
pub(crate) fn reference_margin_px<'a>(references: impl Iterator<Item = &'a ReferenceLine>) -> f64 {
    references
        .map(|line| font::width_px(&line.label, TICK_LABEL_PX, Weight::Regular) + 18.0)
        .fold(24.0, f64::max)
}

/// Moves sorted places apart until they are at least `distance` from each other.
fn spread(places: &[f64], distance: f64) -> Vec<f64> {
    let mut moved = places.to_vec();
    for _ in 0..places.len() {
        for i in 1..moved.len() {
            let missing = distance - (moved[i] - moved[i - 1]);
            if missing > 0.0 {
                moved[i - 1] -= missing / 2.0;
                moved[i] += missing / 2.0;
            }
        }
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_moved_apart_evenly() {
        assert_eq!(spread(&[10.0, 40.0], 14.0), [10.0, 40.0]);
        assert_eq!(spread(&[10.0, 12.0], 14.0), [4.0, 18.0]);
        let moved = spread(&[10.0, 10.0, 10.0], 14.0);
        assert!(moved.windows(2).all(|pair| pair[1] - pair[0] > 10.0), "{moved:?}");
    }
}
