//! The field from above in dots.

use visloc_core::geom::PlanarPose;
use visloc_locate::Individual;
use visloc_world::field::{Field, GoalColor};

use super::{
    dots::{DotCanvas, Layer, Rgb, mix},
    panel::algorithm_color,
};
use crate::run::{FrameView, Runner};

/// The carpet.
pub const CARPET: Rgb = [22, 84, 44];
const LINE: Rgb = [215, 225, 215];
const TRUTH: Rgb = [255, 255, 255];
const CARRIED: Rgb = [255, 90, 160];

/// The robot is drawn this large, meters, but never smaller than a few dots.
const ROBOT_RADIUS_M: f64 = 0.14;

/// Draws the field and who is where.
pub struct FieldMap {
    ground: DotCanvas,
    dots_per_m: f64,
    half_carpet_m: (f64, f64),
    rows: usize,
}

impl FieldMap {
    /// The field in as many columns as fit into a number of rows.
    pub fn new(field: &Field, max_columns: usize, max_rows: usize) -> Self {
        let (half_x_m, half_y_m) = field.half_carpet_m();
        let by_columns = 2.0 * max_columns as f64 / (2.0 * half_x_m);
        let by_rows = 4.0 * max_rows as f64 / (2.0 * half_y_m);
        let dots_per_m = by_columns.min(by_rows);
        let columns = ((2.0 * half_x_m * dots_per_m / 2.0).round() as usize).max(1);
        let rows = ((2.0 * half_y_m * dots_per_m / 4.0).round() as usize).max(1);
        let half_carpet_m = (half_x_m, half_y_m);
        let mut map = Self { ground: DotCanvas::new(columns, rows), dots_per_m, half_carpet_m, rows };
        map.ground = map.draw_ground(field, map.ground.clone());
        map
    }

    /// Rows of characters.
    pub fn num_rows(&self) -> usize {
        self.rows
    }

    /// The field after a frame.
    pub fn draw(&self, view: &FrameView<'_>) -> Vec<String> {
        let mut canvas = self.ground.clone();
        for (i, runner) in view.runners.iter().enumerate() {
            self.draw_cloud(&mut canvas, runner, algorithm_color(i));
        }
        for (i, runner) in view.runners.iter().enumerate() {
            let Some(record) = runner.records().latest() else { continue };
            let color = algorithm_color(i);
            let color = if record.is_localized() { color } else { mix(color, CARPET, 0.45) };
            let radius = self.robot_radius() + 2.4 + 3.4 * i as f64;
            self.draw_robot(&mut canvas, &record.world_from_robot, radius, (Layer::Estimate, color));
        }
        if let Some(truth) = view.truth {
            let color = if truth.height_m > 0.02 { CARRIED } else { TRUTH };
            let center = self.place(truth.world_from_robot.x_m, truth.world_from_robot.y_m);
            let mut radius = self.robot_radius();
            self.draw_robot(&mut canvas, &truth.world_from_robot, radius, (Layer::Truth, color));
            while radius > 0.5 {
                radius -= 0.7;
                canvas.ring(center, radius.max(0.0), Layer::Truth, color);
            }
        }
        (0..self.rows).map(|row| canvas.row(row, CARPET)).collect()
    }

    fn robot_radius(&self) -> f64 {
        (ROBOT_RADIUS_M * self.dots_per_m).max(1.6)
    }

    /// A ring with a line to where the robot looks.
    fn draw_robot(
        &self,
        canvas: &mut DotCanvas,
        pose: &PlanarPose,
        radius: f64,
        (layer, color): (Layer, Rgb),
    ) {
        let (x, y) = self.place(pose.x_m, pose.y_m);
        let (sin, cos) = pose.yaw_rad.sin_cos();
        canvas.ring((x, y), radius, layer, color);
        let tip = radius + 1.4 * self.robot_radius() + 1.0;
        canvas.line((x + radius * cos, y - radius * sin), (x + tip * cos, y - tip * sin), layer, color);
    }

    fn draw_cloud(&self, canvas: &mut DotCanvas, runner: &Runner, color: Rgb) {
        let mut individuals: Vec<Individual> = Vec::new();
        runner.pipeline().localizer().individuals(&mut individuals);
        let color = mix(color, CARPET, 0.3);
        for individual in &individuals {
            let PlanarPose { x_m, y_m, .. } = individual.world_from_robot;
            canvas.dot(self.place(x_m, y_m), Layer::Cloud, color);
        }
    }

    fn draw_ground(&self, field: &Field, mut canvas: DotCanvas) -> DotCanvas {
        for segment in field.lines().iter().chain(field.marks()) {
            let (start, end) = (segment.start, segment.end);
            canvas.line(self.place(start.x, start.y), self.place(end.x, end.y), Layer::Ground, LINE);
        }
        canvas.ring(self.place(0.0, 0.0), field.circle_radius_m() * self.dots_per_m, Layer::Ground, LINE);
        for goal in field.goals() {
            let color = match goal.color {
                GoalColor::Yellow => [255, 215, 0],
                GoalColor::Blue => [70, 130, 255],
                GoalColor::White => [255, 255, 255],
            };
            // Behind the goal line, three dots deep, and above the line's own color.
            for depth in 0..4 {
                let x_m = goal.x_m + goal.x_m.signum() * f64::from(depth) / self.dots_per_m;
                let ends = [-goal.post_y_m, goal.post_y_m].map(|y_m| self.place(x_m, y_m));
                canvas.line(ends[0], ends[1], Layer::Cloud, color);
            }
        }
        canvas
    }

    /// From meters on the field to dots.
    fn place(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        let (half_x_m, half_y_m) = self.half_carpet_m;
        ((x_m + half_x_m) * self.dots_per_m, (half_y_m - y_m) * self.dots_per_m)
    }
}
