//! The fast observation model: nearest points in space, compared in the image.
//!
//! Source: 2010 section 4.3.1, 2017 section 5.2.2. Deviations: goals are cylinders instead of drawings on a plane (see
//! `goal.rs`), and a pixel's distance is capped at `max_distance_px`
//! before the mean is taken, so that one wrong pixel cannot outvote all others.

use std::sync::Arc;

use nalgebra::{Matrix3x4, Point2, Point3, Vector2};
use rand::RngExt;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::{
    Rng,
    geom::{PlanarPose, angle},
    settings::check_ranges,
};
use visloc_world::field::Field;

use super::{goal::GoalSilhouette, outline::ground_outlines, table::NearestTable};
use crate::{
    ConfigError, ObservationModel, Region,
    observation::{
        Landmark,
        projection::{combine, ideal_from_world_at, projection},
    },
    vision::{FeatureKind, Percept, px_tolerance},
};

visloc_core::with_defaults! {
    /// Parameters of the observation model of a field.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct FieldModelConfig {
        /// Distance in the image at which a pixel agrees with nothing (`D`), pixels of an image 320 to 640 px wide; in smaller and larger ones
        /// in proportion. Source: 2010 equation 4.1, 50.
        #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
        pub max_distance_px: f64 = 50.0,
    }
}

/// So many look-ups in the table wait for the memory at once: those of all line pixels of an ordinary image.
const LOOKUPS_AT_ONCE: usize = 12;

/// A line pixel with the ground point that it shows, seen from the robot.
#[derive(Debug, Clone, Copy)]
struct LinePixel {
    ground_in_robot: Point2<f64>,
    ideal_px: Point2<f64>,
}

/// A goal pixel with its ray, seen from the robot: a unit vector along the ground, and the rise per meter.
#[derive(Debug, Clone, Copy)]
struct GoalPixel {
    ahead_in_robot: Vector2<f64>,
    rise: f64,
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
            ground: NearestTable::new(&ground_outlines(field), -corner, corner),
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
    config: FieldModelConfig,
    /// In pixels of the image.
    max_distance_px: f64,
    /// Shared by all models of a pipeline: the less memory they look up, the more of it is in the caches.
    tables: Arc<FieldTables>,
    lines: Vec<LinePixel>,
    goals: Vec<GoalPixel>,
    eye_in_robot: Point3<f64>,
    ideal_from_robot: Matrix3x4<f64>,
}

impl FieldObservationModel {
    /// The model of a field; builds its tables.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(field: &Field, config: &FieldModelConfig) -> Result<Self, ConfigError> {
        check_ranges(config)?;
        Ok(Self {
            config: *config,
            max_distance_px: config.max_distance_px,
            tables: Arc::new(FieldTables::new(field)),
            lines: Vec::new(),
            goals: Vec::new(),
            eye_in_robot: Point3::origin(),
            ideal_from_robot: Matrix3x4::identity(),
        })
    }

    pub(super) fn tables(&self) -> &Arc<FieldTables> {
        &self.tables
    }

    /// The likelihood of a pose; `None` as soon as `is_too_low` says so of what it is at most: more pixels make it no higher.
    #[inline]
    fn likelihood_unless(
        &self,
        world_from_robot: &PlanarPose,
        is_too_low: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        let view = View::new(world_from_robot, &self.ideal_from_robot);
        let at_most = |line_sum, goal_sum| {
            combine(self.max_distance_px, (line_sum, self.lines.len()), (goal_sum, self.goals.len()))
        };
        let (mut line_sum, mut goal_sum) = (0.0, 0.0);
        for pixels in self.lines.chunks(LOOKUPS_AT_ONCE) {
            let mut nearest = [(Point2::origin(), [0; 2]); LOOKUPS_AT_ONCE];
            for (pixel, nearest) in pixels.iter().zip(&mut nearest) {
                let point = view.world_from_robot(&pixel.ground_in_robot);
                *nearest = (point, self.tables.ground.nearest_indices(&point));
            }
            for (pixel, (point, indices)) in pixels.iter().zip(&nearest) {
                line_sum += self.line_distance_px(pixel, &view, point, *indices);
                if is_too_low(at_most(line_sum, goal_sum)) {
                    return None;
                }
            }
        }
        let eye = view.world_from_robot(&Point2::new(self.eye_in_robot.x, self.eye_in_robot.y));
        let eye = Point3::new(eye.x, eye.y, self.eye_in_robot.z);
        for pixel in &self.goals {
            goal_sum += self.goal_distance_px(pixel, &view, &eye);
            if is_too_low(at_most(line_sum, goal_sum)) {
                return None;
            }
        }
        Some(at_most(line_sum, goal_sum))
    }

    #[inline]
    fn line_distance_px(&self, pixel: &LinePixel, view: &View, point: &Point2<f64>, indices: [u8; 2]) -> f64 {
        let [first, second] = self.tables.ground.nearest_points(point, indices);
        let first = outline_distance2(pixel, view, first);
        let second = outline_distance2(pixel, view, second);
        first.min(second).sqrt().min(self.max_distance_px)
    }

    #[inline]
    fn goal_distance_px(&self, pixel: &GoalPixel, view: &View, eye: &Point3<f64>) -> f64 {
        let ahead = view.rotate_to_world(&pixel.ahead_in_robot);
        let mut smallest2 = f64::INFINITY;
        for goal in self.tables.goals.iter().filter(|goal| goal.matches(pixel.kind)) {
            goal.nearest_points(eye, &ahead, pixel.rise, |nearest| {
                let p = &view.ideal_from_world;
                let row = |r: usize| {
                    p[(r, 0)] * nearest.x + p[(r, 1)] * nearest.y + p[(r, 2)] * nearest.z + p[(r, 3)]
                };
                let w = row(2);
                if w > 0.0 {
                    let inverse_w = 1.0 / w;
                    let off_u = row(0) * inverse_w - pixel.ideal_px.x;
                    let off_v = row(1) * inverse_w - pixel.ideal_px.y;
                    smallest2 = smallest2.min(off_u * off_u + off_v * off_v);
                }
            });
        }
        smallest2.sqrt().min(self.max_distance_px)
    }
}

/// Squared distance in the image from a pixel to an outline, of which the point that is nearest on the ground and the
/// direction there are known: the image of the outline is taken for straight.
#[inline]
fn outline_distance2(pixel: &LinePixel, view: &View, (nearest, along): (Point2<f64>, Vector2<f64>)) -> f64 {
    let p = &view.ideal_from_world;
    let row = |r: usize| p[(r, 0)] * nearest.x + p[(r, 1)] * nearest.y + p[(r, 3)];
    let w = row(2);
    if w <= 0.0 {
        return f64::INFINITY;
    }
    let inverse_w = 1.0 / w;
    let (u, v) = (row(0) * inverse_w, row(1) * inverse_w);
    // Direction of the outline in the image, up to a factor.
    let turn = |r: usize| p[(r, 0)] * along.x + p[(r, 1)] * along.y;
    let scale = turn(2);
    let (du, dv) = (turn(0) - u * scale, turn(1) - v * scale);
    let (off_u, off_v) = (pixel.ideal_px.x - u, pixel.ideal_px.y - v);
    let length2 = du * du + dv * dv;
    if length2 > 0.0 {
        let across = off_u * dv - off_v * du;
        across * across / length2
    } else {
        off_u * off_u + off_v * off_v
    }
}

impl ObservationModel for FieldObservationModel {
    fn condition_on(&mut self, percept: &Percept) {
        self.ideal_from_robot = projection(&percept.camera, &percept.robot_from_camera);
        self.eye_in_robot = Point3::from(*percept.robot_from_camera.translation());
        self.max_distance_px = self.config.max_distance_px * px_tolerance(percept.camera.size_px().0);
        self.lines.clear();
        self.goals.clear();
        for pixel in &percept.pixels {
            let bearing = percept.camera.without_distortion().bearing(&pixel.ideal_px);
            let direction_in_robot = percept.robot_from_camera.rotate(&bearing);
            if pixel.kind.is_goal() {
                let ground = Vector2::new(direction_in_robot.x, direction_in_robot.y);
                let length = ground.norm().max(1e-9);
                self.goals.push(GoalPixel {
                    ahead_in_robot: ground / length,
                    rise: direction_in_robot.z / length,
                    ideal_px: pixel.ideal_px,
                    kind: pixel.kind,
                });
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
        self.likelihood_unless(world_from_robot, |_| false).unwrap_or(0.0)
    }

    fn likelihood_above(&self, world_from_robot: &PlanarPose, least: f64) -> Option<f64> {
        let likelihood = self.likelihood_unless(world_from_robot, |at_most| at_most <= least);
        likelihood.filter(|likelihood| *likelihood > least)
    }

    fn region(&self) -> Region {
        self.tables.region()
    }

    fn landmarks(&self) -> Vec<Landmark> {
        let goals: Vec<Landmark> = self.tables.goals.iter().filter_map(GoalSilhouette::landmark).collect();
        // Two goals of one color are no landmarks.
        if goals.windows(2).any(|pair| pair[0].kind == pair[1].kind) { Vec::new() } else { goals }
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
        let d = &pixel.ahead_in_robot;
        angle::wrap((target.y - y_m).atan2(target.x - x_m) - d.y.atan2(d.x))
    }
}

/// What is seen from a pose: worked out once for each pose, used for each pixel.
#[derive(Debug, Clone, Copy)]
struct View {
    x: f64,
    y: f64,
    sin: f64,
    cos: f64,
    /// Projection of points of the world to homogeneous undistorted pixels.
    ideal_from_world: Matrix3x4<f64>,
}

impl View {
    #[inline]
    fn new(pose: &PlanarPose, ideal_from_robot: &Matrix3x4<f64>) -> Self {
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let (x, y) = (pose.x_m, pose.y_m);
        Self { x, y, sin, cos, ideal_from_world: ideal_from_world_at(pose, (sin, cos), ideal_from_robot) }
    }

    #[inline]
    fn world_from_robot(&self, p: &Point2<f64>) -> Point2<f64> {
        Point2::new(self.x + self.cos * p.x - self.sin * p.y, self.y + self.sin * p.x + self.cos * p.y)
    }

    /// Direction of the robot in the world's axes.
    #[inline]
    fn rotate_to_world(&self, d: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(self.cos * d.x - self.sin * d.y, self.sin * d.x + self.cos * d.y)
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::{
        RngTree,
        geom::{Camera, nao},
    };
    use visloc_world::Map;

    use super::*;
    use crate::vision::FeaturePixel;

    #[test]
    fn a_likelihood_above_another_one_is_the_likelihood_itself() {
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2010") else { panic!("built-in map") };
        let mut model = FieldObservationModel::new(&field, &FieldModelConfig::default()).unwrap();
        let mut rng = RngTree::new(1).stream("likelihood", 0);
        let mut percept = Percept {
            camera: Camera::pinhole((320, 240), (370.0, 370.0), (160.0, 120.0)).unwrap(),
            robot_from_camera: nao::robot_from_camera(
                &nao::Torso::upright(),
                &nao::HeadAngles { pitch_rad: 0.2, ..nao::HeadAngles::default() },
                nao::NaoCamera::TopV3,
            ),
            ..Percept::default()
        };
        let mut num = [0, 0];
        // More line pixels than are looked up at once.
        for kinds in [[20, 0], [5, 0], [0, 4], [12, 8]] {
            percept.pixels.clear();
            for (kind, num) in [FeatureKind::FieldLine, FeatureKind::YellowGoal].into_iter().zip(kinds) {
                percept.pixels.extend((0..num).map(|_| {
                    let px = Point2::new(rng.random_range(0.0..320.0), rng.random_range(0.0..240.0));
                    FeaturePixel { px, ideal_px: px, kind }
                }));
            }
            model.condition_on(&percept);
            for _ in 0..200 {
                let pose = model.sample(&mut rng);
                let likelihood = model.likelihood(&pose);
                for least in [f64::NEG_INFINITY, 0.0, 0.3, 0.6, likelihood, likelihood - 1e-12] {
                    let above = model.likelihood_above(&pose, least);
                    assert_eq!(above, (likelihood > least).then_some(likelihood), "{kinds:?} {least}");
                    num[usize::from(above.is_some())] += 1;
                }
            }
        }
        assert!(num.iter().all(|num| *num > 500), "{num:?}");
    }
}
