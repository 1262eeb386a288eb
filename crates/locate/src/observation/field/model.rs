//! The fast observation model: nearest points in space, compared in the image.
//!
//! Source: 2010 section 4.3.1, 2017 section 5.2.2. Deviations: goals are cylinders instead of drawings on a plane (see
//! `goal.rs`), and a pixel's distance is capped at `max_distance_px`
//! before the mean is taken, so that one wrong pixel cannot outvote all others.

use nalgebra::{Matrix3, Matrix3x4, Point2, Point3, Vector3};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use visloc_base::Rng;
use visloc_geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot, angle};
use visloc_vision::{FeatureKind, Percept};
use visloc_world::field::Field;

use super::{goal::GoalSilhouette, outline::ground_outlines, table::NearestTable};
use crate::{ConfigError, ObservationModel, Region, require};

/// Parameters of the observation model of a field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FieldModelConfig {
    /// Distance in the image at which a pixel agrees with nothing (`D`), pixels. Source: 2010 equation 4.1, 50.
    pub max_distance_px: f64,
}

impl Default for FieldModelConfig {
    fn default() -> Self {
        Self { max_distance_px: 50.0 }
    }
}

impl FieldModelConfig {
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let d = self.max_distance_px;
        require(d > 0.0 && d.is_finite(), "observation.max_distance_px", "above 0", d)
    }
}

/// A line pixel with the ground point that it shows, seen from the robot.
#[derive(Debug, Clone, Copy)]
struct LinePixel {
    ground_in_robot: Point2<f64>,
    ideal_px: Point2<f64>,
}

/// A goal pixel with its ray, seen from the robot.
#[derive(Debug, Clone, Copy)]
struct GoalPixel {
    direction_in_robot: Vector3<f64>,
    ideal_px: Point2<f64>,
    kind: FeatureKind,
}

/// The geometry that both models share.
#[derive(Debug, Clone)]
pub(super) struct FieldTables {
    pub ground: NearestTable,
    pub goals: [GoalSilhouette; 2],
    pub half_carpet_m: (f64, f64),
}

impl FieldTables {
    pub fn new(field: &Field) -> Self {
        let (half_x, half_y) = field.half_carpet_m();
        let corner = Point2::new(half_x, half_y);
        Self {
            ground: NearestTable::new(ground_outlines(field), -corner, corner),
            goals: [0, 1].map(|i| GoalSilhouette::new(&field.goals()[i])),
            half_carpet_m: (half_x, half_y),
        }
    }

    pub fn region(&self) -> Region {
        let (x, y) = self.half_carpet_m;
        Region { min_x_m: -x, max_x_m: x, min_y_m: -y, max_y_m: y }
    }
}

/// Likelihood of poses on a RoboCup field.
#[derive(Debug, Clone)]
pub struct FieldObservationModel {
    max_distance_px: f64,
    tables: FieldTables,
    lines: Vec<LinePixel>,
    goals: Vec<GoalPixel>,
    eye_in_robot: Point3<f64>,
    ideal_from_ground: Matrix3<f64>,
    ideal_from_robot: Matrix3x4<f64>,
}

impl FieldObservationModel {
    /// The model of a field; builds its tables.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(field: &Field, config: &FieldModelConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            max_distance_px: config.max_distance_px,
            tables: FieldTables::new(field),
            lines: Vec::new(),
            goals: Vec::new(),
            eye_in_robot: Point3::origin(),
            ideal_from_ground: Matrix3::identity(),
            ideal_from_robot: Matrix3x4::identity(),
        })
    }

    #[inline]
    fn line_distance_px(&self, pixel: &LinePixel, pose: &Trigonometry) -> f64 {
        let point = pose.world_from_robot(&pixel.ground_in_robot);
        let nearest = pose.robot_from_world(&self.tables.ground.nearest_point(&point));
        let h = &self.ideal_from_ground;
        let w = h[(2, 0)] * nearest.x + h[(2, 1)] * nearest.y + h[(2, 2)];
        if w <= 0.0 {
            return self.max_distance_px;
        }
        let u = (h[(0, 0)] * nearest.x + h[(0, 1)] * nearest.y + h[(0, 2)]) / w;
        let v = (h[(1, 0)] * nearest.x + h[(1, 1)] * nearest.y + h[(1, 2)]) / w;
        self.distance_px(u, v, &pixel.ideal_px)
    }

    #[inline]
    fn goal_distance_px(&self, pixel: &GoalPixel, pose: &Trigonometry) -> f64 {
        let position = pose.world_from_robot(&Point2::new(self.eye_in_robot.x, self.eye_in_robot.y));
        let eye = Point3::new(position.x, position.y, self.eye_in_robot.z);
        let d = &pixel.direction_in_robot;
        let direction = Vector3::new(pose.cos * d.x - pose.sin * d.y, pose.sin * d.x + pose.cos * d.y, d.z);
        let p = &self.ideal_from_robot;
        let mut smallest = self.max_distance_px;
        for goal in self.tables.goals.iter().filter(|goal| goal.matches(pixel.kind)) {
            goal.nearest_points(&eye, &direction, |nearest| {
                let ground = pose.robot_from_world(&Point2::new(nearest.x, nearest.y));
                let row = |r: usize| {
                    p[(r, 0)] * ground.x + p[(r, 1)] * ground.y + p[(r, 2)] * nearest.z + p[(r, 3)]
                };
                let w = row(2);
                if w > 0.0 {
                    smallest = smallest.min(self.distance_px(row(0) / w, row(1) / w, &pixel.ideal_px));
                }
            });
        }
        smallest
    }

    #[inline]
    fn distance_px(&self, u: f64, v: f64, px: &Point2<f64>) -> f64 {
        let (du, dv) = (u - px.x, v - px.y);
        (du * du + dv * dv).sqrt().min(self.max_distance_px)
    }
}

impl ObservationModel for FieldObservationModel {
    fn condition_on(&mut self, percept: &Percept) {
        let (ideal_from_robot, ideal_from_ground) = projections(&percept.camera, &percept.robot_from_camera);
        self.ideal_from_robot = ideal_from_robot;
        self.ideal_from_ground = ideal_from_ground;
        self.eye_in_robot = Point3::from(*percept.robot_from_camera.translation());
        self.lines.clear();
        self.goals.clear();
        for pixel in &percept.pixels {
            let bearing = percept.camera.without_distortion().bearing(&pixel.ideal_px);
            let direction_in_robot = percept.robot_from_camera.rotate(&bearing);
            if pixel.kind.is_goal() {
                self.goals.push(GoalPixel { direction_in_robot, ideal_px: pixel.ideal_px, kind: pixel.kind });
            } else if direction_in_robot.z < 0.0 {
                let s = -self.eye_in_robot.z / direction_in_robot.z;
                let ground = self.eye_in_robot + direction_in_robot * s;
                self.lines.push(LinePixel {
                    ground_in_robot: Point2::new(ground.x, ground.y),
                    ideal_px: pixel.ideal_px,
                });
            }
        }
    }

    fn has_evidence(&self) -> bool {
        !(self.lines.is_empty() && self.goals.is_empty())
    }

    fn likelihood(&self, world_from_robot: &PlanarPose) -> f64 {
        let pose = Trigonometry::new(world_from_robot);
        let line_sum: f64 = self.lines.iter().map(|pixel| self.line_distance_px(pixel, &pose)).sum();
        let goal_sum: f64 = self.goals.iter().map(|pixel| self.goal_distance_px(pixel, &pose)).sum();
        combine(self.max_distance_px, (line_sum, self.lines.len()), (goal_sum, self.goals.len()))
    }

    fn region(&self) -> Region {
        self.tables.region()
    }

    fn max_jump_m(&self) -> f64 {
        2.0 // 2010 equation 5.9
    }

    fn propose(&self, rng: &mut Rng) -> PlanarPose {
        let mut pose = self.region().sample(rng);
        pose.yaw_rad = self.propose_heading(pose.x_m, pose.y_m, rng);
        pose
    }

    /// Turns the robot so that a pixel of a goal, taken at random, falls on one of the goal's posts or between them.
    fn propose_heading(&self, x_m: f64, y_m: f64, rng: &mut Rng) -> f64 {
        let uniform = rng.random_range(-std::f64::consts::PI..std::f64::consts::PI);
        if self.goals.is_empty() {
            return uniform;
        }
        let pixel = self.goals[rng.random_range(0..self.goals.len())];
        let Some(goal) = self.tables.goals.iter().find(|goal| goal.matches(pixel.kind)) else {
            return uniform;
        };
        let [left, right] = goal.posts();
        // Mostly the posts: that is where most of a goal's border is.
        let share: f64 = rng.random_range(-0.5..1.5);
        let target = left + (right - left) * share.clamp(0.0, 1.0);
        let d = &pixel.direction_in_robot;
        angle::wrap((target.y - y_m).atan2(target.x - x_m) - d.y.atan2(d.x))
    }
}

/// Likelihood from the sums of pixel distances of lines and of goals (2010 equations 4.1 and 4.2).
#[allow(clippy::cast_precision_loss)]
pub(super) fn combine(max_distance_px: f64, lines: (f64, usize), goals: (f64, usize)) -> f64 {
    let of = |(sum, count): (f64, usize)| (1.0 - sum / (count as f64 * max_distance_px)).max(0.0);
    match (lines.1, goals.1) {
        (0, 0) => 0.0,
        (_, 0) => of(lines),
        (0, _) => of(goals),
        _ => 0.5 * (of(lines) + of(goals)),
    }
}

/// Projection of points of the robot frame, and of ground points (x, y, 1), to homogeneous undistorted pixels.
pub(super) fn projections(
    camera: &Camera,
    robot_from_camera: &Rigid3<Robot, CameraFrame>,
) -> (Matrix3x4<f64>, Matrix3<f64>) {
    let camera_from_robot = robot_from_camera.inverse();
    let ((fx, fy), (cx, cy)) = (camera.focal_px(), camera.center_px());
    let intrinsics = Matrix3::new(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0);
    let mut pose = Matrix3x4::zeros();
    pose.fixed_view_mut::<3, 3>(0, 0).copy_from(camera_from_robot.rotation());
    pose.set_column(3, camera_from_robot.translation());
    let ideal_from_robot = intrinsics * pose;
    let columns = [ideal_from_robot.column(0), ideal_from_robot.column(1), ideal_from_robot.column(3)];
    (ideal_from_robot, Matrix3::from_columns(&columns.map(|c| c.into_owned())))
}

/// A pose with the sine and cosine of its heading.
#[derive(Debug, Clone, Copy)]
struct Trigonometry {
    x: f64,
    y: f64,
    sin: f64,
    cos: f64,
}

impl Trigonometry {
    #[inline]
    fn new(pose: &PlanarPose) -> Self {
        let (sin, cos) = pose.yaw_rad.sin_cos();
        Self { x: pose.x_m, y: pose.y_m, sin, cos }
    }

    #[inline]
    fn world_from_robot(&self, p: &Point2<f64>) -> Point2<f64> {
        Point2::new(self.x + self.cos * p.x - self.sin * p.y, self.y + self.sin * p.x + self.cos * p.y)
    }

    #[inline]
    fn robot_from_world(&self, p: &Point2<f64>) -> Point2<f64> {
        let (dx, dy) = (p.x - self.x, p.y - self.y);
        Point2::new(self.cos * dx + self.sin * dy, self.cos * dy - self.sin * dx)
    }
}
