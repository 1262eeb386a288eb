//! Carpet, lines and goals, and the view onto them and onto other grounds.

use visloc_core::geom::PlanarPose;
use visloc_world::{
    field::{Field, Goal, GoalColor},
    office::Office,
};

use crate::{
    Color,
    axis::Axis,
    chart::{HorizontalLabels, LABEL_PX, PlotArea},
    font::{self, Weight},
    svg::{Anchor, Canvas, Paint, Point, Rect, TextStyle},
};

const CARPET: Color = Color::rgb(0x7d, 0xb4, 0x83);
const POST_OUTLINE: Color = Color::rgb(0x3a, 0x3a, 0x3a);

/// Depth of the net behind the goal line, meters: the files of the fields do not say it and only pictures need it.
const NET_DEPTH_M: f64 = 0.35;

/// Between a pose and its name, pixels.
const LABEL_GAP_PX: f64 = 12.0;
/// From one row of names to the next, in heights of letters.
const LABEL_ROW: f64 = 1.2;

/// What lies below a picture.
#[derive(Debug, Clone, Copy)]
pub enum Ground<'a> {
    /// A RoboCup field.
    Field(&'a Field),
    /// A building.
    Office(&'a Office),
}

impl<'a> From<&'a Field> for Ground<'a> {
    fn from(field: &'a Field) -> Self {
        Self::Field(field)
    }
}

impl<'a> From<&'a Office> for Ground<'a> {
    fn from(office: &'a Office) -> Self {
        Self::Office(office)
    }
}

/// Around the walls of a building, meters.
const OFFICE_BORDER_M: f64 = 0.5;

/// Meters of the ground to pixels: +x to the right, +y up, the same scale along both.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroundView {
    area: PlotArea,
    px_per_m: f64,
}

impl GroundView {
    /// Room for ticks and labels at the left of and below the ground, pixels.
    pub(crate) const LEFT_PX: f64 = 62.0;
    pub(crate) const BELOW_PX: f64 = 56.0;

    /// Largest size of a ground, pixels.
    const MAX_PX: (f64, f64) = (920.0, 720.0);

    /// The whole ground.
    pub(crate) fn of(ground: &Ground<'_>, top_px: f64) -> Self {
        match ground {
            Ground::Field(field) => Self::of_field(field, top_px),
            Ground::Office(office) => {
                let [min, max] = office.free_space().bounds_m();
                let border = |min: f64, max: f64| (min - OFFICE_BORDER_M, max + OFFICE_BORDER_M);
                Self::new(border(min.x, max.x), border(min.y, max.y), top_px)
            }
        }
    }

    pub(crate) fn draw_ground(&self, canvas: &mut Canvas, ground: &Ground<'_>) {
        match ground {
            Ground::Field(field) => {
                self.draw_carpet(canvas);
                self.draw_lines(canvas, field, 1.0);
                self.draw_goals(canvas, field);
            }
            Ground::Office(office) => self.draw_office(canvas, office),
        }
    }

    /// The carpet of a field.
    fn of_field(field: &Field, top_px: f64) -> Self {
        let (half_x_m, half_y_m) = field.half_carpet_m();
        Self::new((-half_x_m, half_x_m), (-half_y_m, half_y_m), top_px)
    }

    /// The given ranges of x and y, as large as possible.
    pub(crate) fn new(x_m: (f64, f64), y_m: (f64, f64), top_px: f64) -> Self {
        let range = |range| Axis::linear(range, (0.0, 1.0)).range();
        let (x_m, y_m) = (range(x_m), range(y_m));
        let (width_m, height_m) = (x_m.1 - x_m.0, y_m.1 - y_m.0);
        let px_per_m = (Self::MAX_PX.0 / width_m).min(Self::MAX_PX.1 / height_m);
        let left = Self::LEFT_PX;
        let rect = Rect {
            left,
            top: top_px,
            right: left + width_m * px_per_m,
            bottom: top_px + height_m * px_per_m,
        };
        let (x, y) = (Axis::linear(x_m, (rect.left, rect.right)), Axis::linear(y_m, (rect.bottom, rect.top)));
        Self { area: PlotArea { rect, x, y }, px_per_m }
    }

    pub(crate) fn rect(&self) -> Rect {
        self.area.rect
    }

    pub(crate) fn px_per_m(&self) -> f64 {
        self.px_per_m
    }

    pub(crate) fn px(&self, x_m: f64, y_m: f64) -> Point {
        (self.area.x.px(x_m), self.area.y.px(y_m))
    }

    /// Border and ticks in meters.
    pub(crate) fn draw_frame(&self, canvas: &mut Canvas) {
        self.draw_frame_with(canvas, ["x [m]", "y [m]"]);
    }

    /// The frame with what stands at its axes.
    pub(crate) fn draw_frame_with(&self, canvas: &mut Canvas, [right, up]: [&str; 2]) {
        self.area.draw_frame(canvas, HorizontalLabels::Shown);
        self.area.draw_x_label(canvas, right);
        self.area.draw_y_label(canvas, up, 42.0);
    }

    fn draw_carpet(&self, canvas: &mut Canvas) {
        canvas.rect(&self.area.rect, &Paint::fill(CARPET));
    }

    /// Lines, circle and marks, as wide as they are.
    pub(crate) fn draw_lines(&self, canvas: &mut Canvas, field: &Field, opacity: f64) {
        // thinner than 1 px is invisible on large fields
        let width_px = (field.dimensions().line_width_m * self.px_per_m).max(1.2);
        let paint = Paint::stroke(Color::WHITE, width_px);
        canvas.begin_faded(opacity);
        let half_m = field.dimensions().line_width_m / 2.0;
        for line in field.lines() {
            let along = line.end - line.start;
            let end = along * (half_m / along.norm());
            let (start, end) = (line.start - end, line.end + end);
            canvas.line(self.px(start.x, start.y), self.px(end.x, end.y), &paint);
        }
        for mark in field.marks() {
            canvas.line(self.px(mark.start.x, mark.start.y), self.px(mark.end.x, mark.end.y), &paint);
        }
        canvas.circle(self.px(0.0, 0.0), field.circle_radius_m() * self.px_per_m, &paint);
        canvas.end_group();
    }

    pub(crate) fn draw_goals(&self, canvas: &mut Canvas, field: &Field) {
        for goal in field.goals() {
            self.draw_goal(canvas, goal, field.dimensions().border_m);
        }
    }

    fn draw_goal(&self, canvas: &mut Canvas, goal: &Goal, border_m: f64) {
        let color = goal_color(goal.color);
        let depth_m = NET_DEPTH_M.min(0.8 * border_m) * goal.x_m.signum();
        let (x0, y0) = self.px(goal.x_m, goal.post_y_m);
        let (x1, y1) = self.px(goal.x_m + depth_m, -goal.post_y_m);
        let net = Rect { left: x0.min(x1), top: y0.min(y1), right: x0.max(x1), bottom: y0.max(y1) };
        canvas.rect(&net, &Paint::fill(color).outlined(color, 2.0).opacity(0.55));
        let radius_px = (goal.post_radius_m * self.px_per_m).max(3.0);
        canvas.line((x0, y0), (x0, y1), &Paint::stroke(POST_OUTLINE, 2.0 * radius_px + 1.6));
        canvas.line((x0, y0), (x0, y1), &Paint::stroke(color, 2.0 * radius_px - 0.6));
        for y in [y0, y1] {
            canvas.circle((x0, y), radius_px + 1.5, &Paint::fill(color).outlined(POST_OUTLINE, 1.2));
        }
    }

    /// Whether labels at two poses would cover each other if they were in the same row.
    pub(crate) fn labels_touch(&self, a: &PlanarPose, b: &PlanarPose, label: &str) -> bool {
        let ((ax, ay), (bx, by)) = (self.px(a.x_m, a.y_m), self.px(b.x_m, b.y_m));
        let width_px = font::width_px(label, LABEL_PX, Weight::Bold) + LABEL_GAP_PX;
        (ax - bx).abs() < width_px && (ay - by).abs() < LABEL_ROW * LABEL_PX
    }

    /// The name of a pose behind its arrow, with a white shadow, where the ground leaves room for it; so many rows lower.
    pub(crate) fn draw_pose_label(
        &self,
        canvas: &mut Canvas,
        pose: &PlanarPose,
        (label, row): (&str, usize),
        color: Color,
    ) {
        let (x, y) = self.px(pose.x_m, pose.y_m);
        let y = y + row as f64 * LABEL_ROW * LABEL_PX;
        let room_px = font::width_px(label, LABEL_PX, Weight::Bold) + 2.0 * LABEL_GAP_PX;
        let fits_left = x - room_px > self.area.rect.left;
        let fits_right = x + room_px < self.area.rect.right;
        let is_left = fits_left && (pose.yaw_rad.cos() > 0.0 || !fits_right);
        let (x, anchor) =
            if is_left { (x - LABEL_GAP_PX, Anchor::End) } else { (x + LABEL_GAP_PX, Anchor::Start) };
        let y = (y + 0.36 * LABEL_PX).clamp(self.area.rect.top + LABEL_PX, self.area.rect.bottom - 4.0);
        let style = TextStyle::new(LABEL_PX, color).bold().anchor(anchor);
        let shadow = TextStyle { color: Color::WHITE, ..style };
        for (dx, dy) in [(-1.2, 0.0), (1.2, 0.0), (0.0, -1.2), (0.0, 1.2)] {
            canvas.text((x + dx, y + dy), label, &shadow);
        }
        canvas.text((x, y), label, &style);
    }
}

fn goal_color(color: GoalColor) -> Color {
    match color {
        GoalColor::Yellow => Color::rgb(0xf7, 0xd5, 0x1d),
        GoalColor::Blue => Color::rgb(0x2b, 0x6c, 0xd4),
        GoalColor::White => Color::WHITE,
    }
}
