//! A value for each place of the ground.

use visloc_core::geom::PlanarPose;

use crate::{
    Color, Picture,
    axis::{Axis, finite_range},
    chart::{LABEL_PX, PlotArea},
    field::{Ground, GroundView, draw_pose_arrow},
    header::Header,
    svg::{Anchor, Canvas, Paint, Rect, TextStyle},
};

const BAR_GAP_PX: f64 = 64.0;
const BAR_PX: f64 = 20.0;
const RIGHT_PX: f64 = 40.0;

/// Steps of color: more cannot be told apart and equal neighbors are drawn as one.
const NUM_COLORS: u32 = 64;

const MISSING: Color = Color::rgb(0xcc, 0xcc, 0xcc);

/// A map of values, as colors or as heights.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HeatMap {
    /// Large, at the top.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// Quantity and unit, beside the color bar or the vertical axis.
    pub value_label: String,
    /// The values.
    pub grid: Grid,
    /// Values of the ends of the color bar or the vertical axis; without it the smallest and the largest.
    pub range: Option<(f64, f64)>,
    /// Poses with a name, for instance truth and estimate.
    pub marks: Vec<PoseMark>,
}

/// Values in square cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Grid {
    /// Lower left corner of the first cell, meters.
    pub origin_m: [f64; 2],
    /// Side of a cell, meters.
    pub cell_m: f64,
    /// Cells along x.
    pub num_columns: usize,
    /// Rows along x, the first at the lowest y. Not a number is gray; an incomplete last row is left out.
    pub values: Vec<f64>,
}

impl Grid {
    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.num_columns.max(1))
    }

    /// Ranges of x and y that the cells cover, meters.
    fn ranges_m(&self) -> ((f64, f64), (f64, f64)) {
        let [x_m, y_m] = self.origin_m;
        let (columns, rows) = (self.num_columns as f64, self.rows().count() as f64);
        ((x_m, x_m + columns * self.cell_m), (y_m, y_m + rows * self.cell_m))
    }
}

/// A pose with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseMark {
    /// Beside the arrow.
    pub label: String,
    /// Of the arrow.
    pub color: Color,
    /// Where.
    pub pose: PlanarPose,
}

/// The values of a grid as colors, over the lines of a field or the walls of a building if one is given, with a color bar.
pub fn heat_map(input: &HeatMap, ground: Option<Ground<'_>>) -> Picture {
    let view_below = |top| match &ground {
        Some(ground) => GroundView::of(ground, top),
        None => {
            let (x_m, y_m) = input.grid.ranges_m();
            GroundView::new(x_m, y_m, top)
        }
    };
    let ground_right = view_below(0.0).rect().right;
    let header = Header::new((GroundView::LEFT_PX, ground_right), &input.title, &input.subtitle, Vec::new());
    let view = view_below(header.height_px() + 8.0);
    let rect = view.rect();
    let width = rect.right + BAR_GAP_PX + BAR_PX + RIGHT_PX;
    let mut canvas = Canvas::new(width, rect.bottom + GroundView::BELOW_PX);
    header.draw(&mut canvas);
    let range = input.range.or_else(|| finite_range(input.grid.values.iter().copied()));
    let bar = Axis::linear(range.unwrap_or((0.0, 1.0)), (rect.bottom, rect.top));
    canvas.begin_clip(&rect);
    canvas.rect(&rect, &Paint::fill(MISSING));
    draw_cells(&mut canvas, &view, &input.grid, &bar);
    match &ground {
        Some(Ground::Field(field)) => {
            view.draw_lines(&mut canvas, field, 0.55);
            view.draw_goals(&mut canvas, field);
        }
        Some(Ground::Office(office)) => view.draw_walls(&mut canvas, office, 0.8),
        None => {}
    }
    for (i, mark) in input.marks.iter().enumerate().filter(|(_, mark)| mark.pose.is_finite()) {
        let paint = Paint::fill(mark.color).outlined(Color::WHITE, 1.5);
        draw_pose_arrow(&mut canvas, &view, &mark.pose, 28.0, &paint);
        let near =
            input.marks[..i].iter().filter(|other| view.labels_touch(&mark.pose, &other.pose, &mark.label));
        view.draw_pose_label(&mut canvas, &mark.pose, (&mark.label, near.count()), mark.color);
    }
    canvas.end_group();
    view.draw_frame(&mut canvas);
    draw_color_bar(&mut canvas, &rect, bar, &input.value_label);
    canvas.finish()
}

/// Index of the color of a value; none for not a number.
fn color_index(value: f64, bar: &Axis) -> Option<u32> {
    let (min, max) = bar.range();
    let fraction = ((value - min) / (max - min)).clamp(0.0, 1.0);
    (!fraction.is_nan()).then(|| ((fraction * f64::from(NUM_COLORS)) as u32).min(NUM_COLORS - 1))
}

fn index_color(index: u32) -> Color {
    Color::scale((f64::from(index) + 0.5) / f64::from(NUM_COLORS))
}

fn draw_cells(canvas: &mut Canvas, view: &GroundView, grid: &Grid, bar: &Axis) {
    let [x_m, y_m] = grid.origin_m;
    for (row, values) in grid.rows().enumerate() {
        let colors: Vec<Option<u32>> = values.iter().map(|&value| color_index(value, bar)).collect();
        let mut column = 0;
        for run in colors.chunk_by(|a, b| a == b) {
            let (first, end) = (column as f64, (column + run.len()) as f64);
            column += run.len();
            let Some(index) = run[0] else { continue };
            let (left, bottom) = view.px(x_m + first * grid.cell_m, y_m + row as f64 * grid.cell_m);
            let (right, top) = view.px(x_m + end * grid.cell_m, y_m + (row as f64 + 1.0) * grid.cell_m);
            // a little overlap hides the seams between neighbors
            let cell = Rect { left, top: top - 0.4, right: right + 0.4, bottom };
            canvas.rect(&cell, &Paint::fill(index_color(index)));
        }
    }
}

fn draw_color_bar(canvas: &mut Canvas, ground: &Rect, bar: Axis, label: &str) {
    let left = ground.right + BAR_GAP_PX;
    let rect = Rect { left, right: left + BAR_PX, ..*ground };
    let step = rect.height() / f64::from(NUM_COLORS);
    for index in 0..NUM_COLORS {
        let bottom = rect.bottom - f64::from(index) * step;
        let part = Rect { top: bottom - step - 0.4, bottom, ..rect };
        canvas.rect(&part, &Paint::fill(index_color(index)));
    }
    let area = PlotArea { rect, x: bar, y: bar };
    area.draw_border(canvas);
    area.draw_vertical_ticks(canvas);
    let middle = f64::midpoint(rect.top, rect.bottom);
    let style = TextStyle::new(LABEL_PX, Color::BLACK).anchor(Anchor::Middle);
    canvas.vertical_text((rect.right + 20.0, middle), label, &style);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_outside_the_range_take_the_end_colors() {
        let bar = Axis::linear((0.0, 10.0), (100.0, 0.0));
        assert_eq!(color_index(-5.0, &bar), Some(0));
        assert_eq!(color_index(f64::INFINITY, &bar), Some(NUM_COLORS - 1));
        assert_eq!(color_index(5.0, &bar), Some(NUM_COLORS / 2));
        assert_eq!(color_index(f64::NAN, &bar), None);
    }

    #[test]
    fn equal_neighbors_are_one_rectangle() {
        let grid = |values| Grid { origin_m: [0.0, 0.0], cell_m: 1.0, num_columns: 4, values };
        let count = |values| {
            let input = HeatMap { grid: grid(values), ..HeatMap::default() };
            heat_map(&input, None).svg().matches("<rect").count()
        };
        assert_eq!(count(vec![0.0, 0.0, 1.0, 1.0]) + 2, count(vec![0.0, 1.0, 0.0, 1.0]));
    }

    #[test]
    fn empty_and_senseless_grids_do_not_panic() {
        for (num_columns, values) in [(0, vec![1.0]), (3, vec![]), (2, vec![f64::NAN; 3])] {
            let grid = Grid { origin_m: [f64::NAN, 0.0], cell_m: 0.0, num_columns, values };
            assert!(heat_map(&HeatMap { grid, ..HeatMap::default() }, None).is_valid_svg());
        }
    }
}
