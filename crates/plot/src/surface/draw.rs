//! Puts the picture of a surface together.

use std::{collections::BTreeMap, f64::consts::TAU};

use visloc_world::field::Field;

use super::view::{Mesh, ObliqueView};
use crate::{
    Color, HeatMap, Picture, PoseMark,
    axis::{Axis, Tick, finite_range},
    chart::{LABEL_PX, TICK_LABEL_PX},
    header::Header,
    svg::{Anchor, Canvas, Paint, Point, TextStyle},
};

/// How far the viewer has walked around the ground counter-clockwise, from the side of negative y, 0 to 90 degrees.
const AZIMUTH_DEG: f64 = 25.0;
/// How steeply the viewer looks down, 0 to 90 degrees.
const ELEVATION_DEG: f64 = 40.0;
const LEFT_PX: f64 = 74.0;
const WIDTH_PX: f64 = 860.0;
const RIGHT_PX: f64 = 60.0;
const BELOW_PX: f64 = 44.0;
/// How far the first pin rises above the surface, in parts of the vertical axis, and how much farther each next one, so
/// that labels of near places stay apart.
const PIN: f64 = 0.2;
const NEXT_PIN: f64 = 0.12;
/// Step along the lines of a field that lie on the surface, meters.
const LINE_STEP_M: f64 = 0.05;

const WALL: Color = Color::rgb(0xc9, 0xc9, 0xce);
const GRID: Color = Color::rgb(0xdc, 0xdc, 0xdc);

/// Pieces of lines that lie on a cell of the surface.
type LinePieces = BTreeMap<(usize, usize), Vec<(Point, Point)>>;

/// The values of a grid as a surface, seen obliquely, with the lines of a field lying on it if one is given. A large grid is
/// drawn with fewer, larger cells, each as high as the highest value in it; places without a value are holes. Marks are pins
/// that stand on the surface.
pub fn surface_picture(input: &HeatMap, field: Option<&Field>) -> Picture {
    let header = Header::new((24.0, LEFT_PX + WIDTH_PX), &input.title, &input.subtitle, Vec::new());
    let top = header.height_px() + 34.0;
    let range = input.range.or_else(|| finite_range(input.grid.values.iter().copied()));
    let (low, high) = Axis::linear(range.unwrap_or((0.0, 1.0)), (0.0, 1.0)).range();
    let Some(mesh) = Mesh::new(&input.grid, |value| ((value - low) / (high - low)).clamp(0.0, 1.0)) else {
        let mut canvas = Canvas::new(LEFT_PX + WIDTH_PX + RIGHT_PX, top + BELOW_PX);
        header.draw(&mut canvas);
        return canvas.finish();
    };
    let view = ObliqueView::new((AZIMUTH_DEG, ELEVATION_DEG), &mesh, WIDTH_PX, (LEFT_PX, top));
    let space = Space {
        view,
        near: mesh.corner_m(0, 0),
        far: mesh.corner_m(mesh.num_rows() - 1, mesh.num_columns - 1),
    };
    let (_, _, _, bottom) = view.bounds(&[space.near, space.far]);
    let mut canvas = Canvas::new(LEFT_PX + WIDTH_PX + RIGHT_PX, bottom + BELOW_PX);
    header.draw(&mut canvas);
    space.draw_back(&mut canvas, (low, high));
    let lines = field.map(|field| line_pieces(field, &mesh, &view)).unwrap_or_default();
    draw_surface(&mut canvas, &mesh, &view, &lines);
    space.draw_walls(&mut canvas, &mesh);
    space.draw_axes(&mut canvas, (low, high), &input.value_label);
    let mut pin = PIN;
    for mark in input.marks.iter().filter(|mark| mark.pose.is_finite()) {
        draw_pin(&mut canvas, mark, &mesh, &view, pin);
        pin += NEXT_PIN;
    }
    canvas.finish()
}

fn draw_surface(canvas: &mut Canvas, mesh: &Mesh, view: &ObliqueView, lines: &LinePieces) {
    for (row, column) in view.cells_from_far(mesh) {
        let corners = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(r, c)| mesh.corner_m(row + r, column + c));
        if corners.iter().any(|corner| !corner[2].is_finite()) {
            continue;
        }
        let height = corners.iter().map(|corner| corner[2]).sum::<f64>() / 4.0;
        let color = Color::scale(height);
        let paint = Paint::fill(color).outlined(color.mix(Color::BLACK, 0.16), 0.5);
        canvas.polygon(&corners.map(|corner| view.px(corner)), &paint);
        for (start, end) in lines.get(&(row, column)).into_iter().flatten() {
            canvas.line(*start, *end, &Paint::stroke(Color::WHITE, 1.6).opacity(0.75));
        }
    }
}

/// Lines and circle of a field, cut at the borders of the cells.
fn line_pieces(field: &Field, mesh: &Mesh, view: &ObliqueView) -> LinePieces {
    let mut pieces = LinePieces::new();
    let mut add = |from: Point, to: Point| {
        // A piece on the border of two cells belongs to the nearer one, which is drawn later.
        let (nearer_x, nearer_y) = view.toward_viewer(0.3 * mesh.step_m);
        let (x, y) = (f64::midpoint(from.0, to.0) + nearer_x, f64::midpoint(from.1, to.1) + nearer_y);
        let (start, end) = (mesh.cell_at(from.0, from.1), mesh.cell_at(to.0, to.1));
        let (Some((cell, _)), Some((_, start)), Some((_, end))) = (mesh.cell_at(x, y), start, end) else {
            return;
        };
        if start.is_finite() && end.is_finite() {
            let piece = (view.px([from.0, from.1, start]), view.px([to.0, to.1, end]));
            pieces.entry(cell).or_default().push(piece);
        }
    };
    for line in field.lines() {
        let along = line.end - line.start;
        let num_steps = steps(along.norm());
        for step in 0..num_steps {
            let at = |step: u32| {
                let point = line.start + along * (f64::from(step) / f64::from(num_steps));
                (point.x, point.y)
            };
            add(at(step), at(step + 1));
        }
    }
    let radius_m = field.circle_radius_m();
    let num_steps = steps(TAU * radius_m);
    for step in 0..num_steps {
        let at = |step: u32| {
            let (sin, cos) = (TAU * f64::from(step) / f64::from(num_steps)).sin_cos();
            (radius_m * cos, radius_m * sin)
        };
        add(at(step), at(step + 1));
    }
    pieces
}

fn steps(length_m: f64) -> u32 {
    (length_m / LINE_STEP_M).ceil().clamp(1.0, 2000.0) as u32
}

fn draw_pin(canvas: &mut Canvas, mark: &PoseMark, mesh: &Mesh, view: &ObliqueView, pin: f64) {
    let pose = &mark.pose;
    let Some((_, height)) = mesh.cell_at(pose.x_m, pose.y_m) else { return };
    let height = if height.is_finite() { height } else { 0.0 };
    let (foot, head) = (view.px([pose.x_m, pose.y_m, height]), view.px([pose.x_m, pose.y_m, height + pin]));
    canvas.line(foot, head, &Paint::stroke(Color::WHITE, 4.0));
    canvas.line(foot, head, &Paint::stroke(mark.color, 2.0));
    canvas.circle(foot, 2.6, &Paint::fill(mark.color).outlined(Color::WHITE, 1.0));
    canvas.circle(head, 5.0, &Paint::fill(mark.color).outlined(Color::WHITE, 1.2));
    let style = TextStyle::new(LABEL_PX, mark.color).bold().anchor(Anchor::Middle);
    let at = (head.0, head.1 - 9.0);
    for (dx, dy) in [(-1.2, 0.0), (1.2, 0.0), (0.0, -1.2), (0.0, 1.2)] {
        canvas.text((at.0 + dx, at.1 + dy), &mark.label, &TextStyle { color: Color::WHITE, ..style });
    }
    canvas.text(at, &mark.label, &style);
}

/// The box around the surface. The viewer sees its sides at the least y and at the largest x from outside.
struct Space {
    view: ObliqueView,
    near: [f64; 3],
    far: [f64; 3],
}

impl Space {
    /// A corner of the box: whether at the large x, at the large y, and its height.
    fn corner(&self, at_large_x: bool, at_large_y: bool, height: f64) -> Point {
        let x = if at_large_x { self.far[0] } else { self.near[0] };
        let y = if at_large_y { self.far[1] } else { self.near[1] };
        self.view.px([x, y, height])
    }

    fn heights((low, high): (f64, f64)) -> Vec<(f64, String)> {
        let axis = Axis::linear((low, high), (0.0, 260.0));
        let labelled = |tick: Tick| tick.label.map(|label| ((tick.value - low) / (high - low), label));
        axis.ticks(40.0).into_iter().filter_map(labelled).collect()
    }

    /// The two sides behind the surface with their grid.
    fn draw_back(&self, canvas: &mut Canvas, range: (f64, f64)) {
        let line = |canvas: &mut Canvas, height: f64| {
            let points = [(false, false), (false, true), (true, true)];
            let points = points.map(|(x, y)| self.corner(x, y, height));
            canvas.polyline(&points, &Paint::stroke(GRID, 1.0));
        };
        for (height, _) in Self::heights(range) {
            line(canvas, height);
        }
        for (x, y) in [(false, false), (false, true), (true, true)] {
            let (low, high) = (self.corner(x, y, 0.0), self.corner(x, y, 1.0));
            canvas.line(low, high, &Paint::stroke(GRID, 1.0));
        }
    }

    /// The cut through what lies below the surface at the two near sides.
    fn draw_walls(&self, canvas: &mut Canvas, mesh: &Mesh) {
        let last = mesh.num_columns - 1;
        let front: Vec<_> = (0..mesh.num_columns).map(|column| mesh.corner_m(0, column)).collect();
        let right: Vec<_> = (0..mesh.num_rows()).map(|row| mesh.corner_m(row, last)).collect();
        for (edge, share) in [(front, 0.0), (right, 0.12)] {
            let height = |height: f64| if height.is_finite() { height } else { 0.0 };
            let upper = edge.iter().map(|&[x, y, h]| self.view.px([x, y, height(h)]));
            let lower = edge.iter().rev().map(|&[x, y, _]| self.view.px([x, y, 0.0]));
            let outline: Vec<Point> = upper.chain(lower).collect();
            let color = WALL.mix(Color::BLACK, share);
            canvas.polygon(&outline, &Paint::fill(color).outlined(Color::GRAY, 0.8));
        }
    }

    fn draw_axes(&self, canvas: &mut Canvas, range: (f64, f64), value_label: &str) {
        let tick_style = TextStyle::new(TICK_LABEL_PX, Color::GRAY);
        let label_style = TextStyle::new(LABEL_PX, Color::BLACK);
        let ticks = |from: f64, to: f64| Axis::linear((from, to), (0.0, 400.0)).ticks(60.0);
        let labelled = |tick: Tick| tick.label.map(|label| (tick.value, label));
        for (x, label) in ticks(self.near[0], self.far[0]).into_iter().filter_map(labelled) {
            let (px, py) = self.view.px([x, self.near[1], 0.0]);
            canvas.line((px, py), (px - 1.5, py + 4.0), &Paint::stroke(Color::GRAY, 1.0));
            canvas.text((px - 4.0, py + 17.0), &label, &tick_style.anchor(Anchor::Middle));
        }
        for (y, label) in ticks(self.near[1], self.far[1]).into_iter().filter_map(labelled) {
            let (px, py) = self.view.px([self.far[0], y, 0.0]);
            canvas.line((px, py), (px + 4.0, py + 1.5), &Paint::stroke(Color::GRAY, 1.0));
            canvas.text((px + 9.0, py + 7.0), &label, &tick_style);
        }
        let middle = |a: f64, b: f64| f64::midpoint(a, b);
        let (px, py) = self.view.px([middle(self.near[0], self.far[0]), self.near[1], 0.0]);
        canvas.text((px - 22.0, py + 36.0), "x [m]", &label_style.anchor(Anchor::Middle));
        let (px, py) = self.view.px([self.far[0], middle(self.near[1], self.far[1]), 0.0]);
        canvas.text((px + 34.0, py + 22.0), "y [m]", &label_style);
        let (low, high) = (self.corner(false, false, 0.0), self.corner(false, false, 1.0));
        canvas.line(low, high, &Paint::stroke(Color::GRAY, 1.0));
        for (height, label) in Self::heights(range) {
            let (px, py) = self.corner(false, false, height);
            canvas.line((px - 4.0, py), (px, py), &Paint::stroke(Color::GRAY, 1.0));
            canvas.text((px - 8.0, py + 0.36 * TICK_LABEL_PX), &label, &tick_style.anchor(Anchor::End));
        }
        let at = (low.0 - 44.0, middle(low.1, high.1));
        canvas.vertical_text(at, value_label, &label_style.anchor(Anchor::Middle));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Grid;

    fn input(num_columns: usize, values: Vec<f64>) -> HeatMap {
        let grid = Grid { origin_m: [-1.0, -1.0], cell_m: 0.5, num_columns, values };
        HeatMap { grid, ..HeatMap::default() }
    }

    #[test]
    fn every_cell_is_drawn_and_holes_are_not() {
        let count = |values: Vec<f64>| surface_picture(&input(4, values), None).svg().matches("Z\"").count();
        let mut values = vec![0.5; 16];
        let whole = count(values.clone());
        assert_eq!(whole, 9 + 2, "nine cells and two walls");
        values[5] = f64::NAN;
        assert_eq!(count(values), whole - 4, "a corner belongs to four cells");
    }

    #[test]
    fn senseless_input_does_not_panic() {
        for (num_columns, values) in [(0, vec![]), (1, vec![1.0; 4]), (3, vec![f64::NAN; 9])] {
            let picture = surface_picture(&input(num_columns, values), None);
            assert!(picture.is_valid_svg());
        }
    }
}
