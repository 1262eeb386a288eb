//! Precision and recall of the composite features against the true pose.
//!
//! A detection is right if in the image it is within a stated distance of a thing of its kind that the map has there, seen
//! from the true place. The direction of the camera, which kinematics reports with an error of up to two degrees, is first
//! fitted to the borders of the lines at the true place. Visible is what lies in the image and within 4 m; whether another
//! robot stands before it is not asked.

use std::{collections::BTreeMap, f64::consts::TAU};

use nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use visloc_geom::{CameraFrame, PlanarPose, Plane, Rigid3, Robot, angle};
use visloc_locate::observation::{
    features::{CameraState, FeatureModel},
    field::FieldFeatureModel,
};
use visloc_vision::{GoalPost, JunctionKind, Percept, PostColor, PostSide};
use visloc_world::field::{Field, Goal, GoalColor, Segment};

/// Largest distance of a right detection in the image, pixels.
const TOLERANCE_PX: f64 = 6.0;
/// Gates of the fit of the camera's direction, pixels, and its standard deviation before, radians.
const FIT_GATES_PX: [f64; 6] = [25.0, 25.0, 15.0, 10.0, 8.0, 8.0];
const TILT_RAD: f64 = 0.03;
/// A line ends at the outer border of the line that it meets, and blur adds to that, meters.
const BEYOND_END_M: f64 = 0.15;
/// Largest error of a right junction's direction, radians.
const TOLERANCE_RAD: f64 = 0.35;
/// What is farther away is not asked for, meters.
const RANGE_M: f64 = 4.0;
/// And for penalty marks, which are small.
const MARK_RANGE_M: f64 = 2.5;
/// What is nearer to the border of the image is not asked for, pixels: a part of it is cut off.
const MARGIN_PX: f64 = 16.0;
/// Visible length of a line that must be found, meters.
const MIN_LINE_M: f64 = 0.5;
/// Share of the circle in the image from which it must be found.
const MIN_CIRCLE_SHARE: f64 = 0.3;

/// Counts of one detector.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DetectionScore {
    /// Detections.
    pub num_found: usize,
    /// Of these right.
    pub num_right: usize,
    /// Things in view.
    pub num_visible: usize,
    /// Of these found.
    pub num_recalled: usize,
    /// Distances on the ground of right detections from the truth, meters.
    pub errors_m: Vec<f64>,
}

impl DetectionScore {
    /// Share of the detections that are right.
    #[must_use]
    pub fn precision(&self) -> f64 {
        share(self.num_right, self.num_found)
    }

    /// Share of the things in view that are found.
    #[must_use]
    pub fn recall(&self) -> f64 {
        share(self.num_recalled, self.num_visible)
    }

    /// Median error on the ground of the right detections, meters; it contains that of the reported camera.
    #[must_use]
    pub fn median_error_m(&self) -> Option<f64> {
        let mut errors_m = self.errors_m.clone();
        errors_m.sort_by(f64::total_cmp);
        errors_m.get(errors_m.len() / 2).copied()
    }
}

#[allow(clippy::cast_precision_loss)]
fn share(part: usize, all: usize) -> f64 {
    if all == 0 { 1.0 } else { part as f64 / all as f64 }
}

/// Counts of all detectors, by name.
#[derive(Debug, Clone, Default)]
pub struct DetectionScores(pub BTreeMap<&'static str, DetectionScore>);

/// The true direction of the camera, as the borders tell it at the true place.
fn fitted_camera(percept: &Percept, field: &Field, truth: &PlanarPose) -> Rigid3<Robot, CameraFrame> {
    let mut model = FieldFeatureModel::new(field);
    model.condition_on(percept);
    let mut state = CameraState { world_from_robot: *truth, tilt_rad: Vector3::zeros() };
    for gate_px in FIT_GATES_PX {
        let mut information = Matrix3::identity() / (TILT_RAD * TILT_RAD);
        let mut gradient = -state.tilt_rad / (TILT_RAD * TILT_RAD);
        model.visit_matches(&state, gate_px, &mut |matched| {
            if let Some(residual) = matched.residual {
                let by_tilt = residual.jacobian.fixed_rows::<3>(3).into_owned();
                information += by_tilt * by_tilt.transpose();
                gradient -= by_tilt * residual.error_px;
            }
        });
        state.tilt_rad += information.try_inverse().unwrap_or_default() * gradient;
    }
    percept.robot_from_camera * Rigid3::new(Rotation3::new(state.tilt_rad), Vector3::zeros())
}

/// The percept with the truth.
struct Scene<'a> {
    percept: &'a Percept,
    field: &'a Field,
    truth: PlanarPose,
    robot_from_camera: Rigid3<Robot, CameraFrame>,
}

impl DetectionScores {
    /// Counts the features of one image.
    pub fn add(&mut self, percept: &Percept, field: &Field, truth: &PlanarPose) {
        let robot_from_camera = fitted_camera(percept, field, truth);
        let scene = Scene { percept, field, truth: *truth, robot_from_camera };
        scene.score_lines(self.of("line"));
        for kind in JunctionKind::ALL {
            let name = match kind {
                JunctionKind::L => "junction L",
                JunctionKind::T => "junction T",
                JunctionKind::X => "junction X",
            };
            scene.score_junctions(kind, self.of(name));
        }
        scene.score_circle(self.of("center circle"));
        scene.score_halfway(self.of("halfway line"));
        scene.score_marks(self.of("penalty mark"));
        scene.score_posts(self.of("post"));
        scene.score_sides(self.of("post side"));
    }

    fn of(&mut self, name: &'static str) -> &mut DetectionScore {
        self.0.entry(name).or_default()
    }
}

impl Scene<'_> {
    /// Pixel of a place in the world, free of distortion.
    fn px(&self, at: &Point2<f64>) -> Option<Point2<f64>> {
        let in_robot = self.truth.inverse().transform(at);
        let in_robot = Point3::new(in_robot.x, in_robot.y, 0.0);
        let camera = self.percept.camera.without_distortion();
        camera.project(&self.robot_from_camera.inverse().transform(&in_robot)).ok()
    }

    /// Pixel of a place seen from the robot, by the camera that it reports.
    fn reported_px(&self, in_robot: &Point2<f64>) -> Option<Point2<f64>> {
        let in_robot = Point3::new(in_robot.x, in_robot.y, 0.0);
        let camera = self.percept.camera.without_distortion();
        camera.project(&self.percept.robot_from_camera.inverse().transform(&in_robot)).ok()
    }

    /// Place in the world seen at a pixel that is free of distortion.
    fn ground(&self, px: &Point2<f64>) -> Option<Point2<f64>> {
        let ray = self.percept.camera.without_distortion().bearing(px);
        let eye = Point3::from(*self.robot_from_camera.translation());
        let at = Plane::ground().intersect_ray(&eye, &self.robot_from_camera.rotate(&ray))?;
        Some(self.truth.transform(&at.xy()))
    }

    /// Distance on the ground of what is seen at a pixel, meters.
    fn error_m(&self, px: &Point2<f64>, at: &Point2<f64>) -> Option<f64> {
        self.ground(px).map(|found| (found - at).norm())
    }

    fn off_px(&self, found_px: &Point2<f64>, at: &Point2<f64>) -> f64 {
        self.px(at).map_or(f64::INFINITY, |px| (px - found_px).norm())
    }

    fn distance_m(&self, at: &Point2<f64>) -> f64 {
        (at - self.truth.position()).norm()
    }

    fn is_in_image(&self, at: &Point2<f64>, margin_px: f64) -> bool {
        let (width, height) = self.percept.camera.size_px();
        self.px(at).is_some_and(|px| {
            (margin_px..f64::from(width) - margin_px).contains(&px.x)
                && (margin_px..f64::from(height) - margin_px).contains(&px.y)
        })
    }

    fn is_visible(&self, at: &Point2<f64>) -> bool {
        self.distance_m(at) < RANGE_M && self.is_in_image(at, MARGIN_PX)
    }

    /// Ends and middle of a line lie on one line of the map.
    fn line_of(&self, ends_px: &[Point2<f64>; 2]) -> Option<usize> {
        let is_on = |line: &Segment| {
            let beyond = (line.end - line.start).normalize() * BEYOND_END_M;
            let line = Segment { start: line.start - beyond, end: line.end + beyond };
            ends_px.iter().all(|px| {
                let at = self.ground(px);
                at.is_some_and(|at| self.off_px(px, &line.nearest_point(&at)) < TOLERANCE_PX)
            })
        };
        self.field.lines().iter().position(is_on)
    }

    fn score_lines(&self, score: &mut DetectionScore) {
        let mut found = vec![false; self.field.lines().len()];
        for line in &self.percept.features.lines {
            score.num_found += 1;
            if let Some(i) = self.line_of(&line.ends_px) {
                found[i] = true;
                score.num_right += 1;
                let middle_px = nalgebra::center(&line.ends_px[0], &line.ends_px[1]);
                let nearest =
                    self.ground(&middle_px).map(|at| (self.field.lines()[i].nearest_point(&at) - at).norm());
                score.errors_m.extend(nearest);
            }
        }
        for (line, found) in self.field.lines().iter().zip(found) {
            let along = line.end - line.start;
            let count = (along.norm() / 0.05).ceil();
            let mut visible_m = 0.0;
            let mut i = 0.0;
            while i <= count {
                visible_m += if self.is_visible(&(line.start + along * (i / count))) { 0.05 } else { 0.0 };
                i += 1.0;
            }
            if visible_m >= MIN_LINE_M {
                score.num_visible += 1;
                score.num_recalled += usize::from(found);
            }
        }
    }

    fn score_junctions(&self, kind: JunctionKind, score: &mut DetectionScore) {
        let on_map = self.field.junctions();
        let on_map: Vec<_> = on_map.iter().filter(|j| j.arms.len() == kind.num_arms()).collect();
        let mut found = vec![false; on_map.len()];
        for junction in self.percept.features.junctions.iter().filter(|j| j.kind == kind) {
            score.num_found += 1;
            let quarter = if kind == JunctionKind::X { TAU / 4.0 } else { TAU };
            let is_it = |j: &&visloc_world::field::FieldJunction| {
                let expected = j.direction().y.atan2(j.direction().x);
                let turn = angle::difference(junction.direction_rad + self.truth.yaw_rad, expected);
                let turn = turn - (turn / quarter).round() * quarter;
                self.off_px(&junction.at_px, &j.at) < TOLERANCE_PX && turn.abs() < TOLERANCE_RAD
            };
            if let Some(i) = on_map.iter().position(is_it) {
                found[i] = true;
                score.num_right += 1;
                score.errors_m.extend(self.error_m(&junction.at_px, &on_map[i].at));
            }
        }
        for (junction, found) in on_map.iter().zip(found) {
            if self.is_visible(&junction.at) && !junction.is_on_circle {
                score.num_visible += 1;
                score.num_recalled += usize::from(found);
            }
        }
    }

    fn score_circle(&self, score: &mut DetectionScore) {
        let center = Point2::origin();
        let mut is_right = false;
        if let Some(circle) = &self.percept.features.circle {
            // The center itself may be out of the image: it is taken there as the robot saw it.
            let px = self.reported_px(&circle.center_in_robot);
            let error_m = px.and_then(|px| self.error_m(&px, &center));
            is_right = px.is_some_and(|px| self.off_px(&px, &center) < TOLERANCE_PX)
                || error_m.is_some_and(|m| m < 0.1);
            score.num_found += 1;
            score.num_right += usize::from(is_right);
            if is_right {
                score.errors_m.extend(error_m);
            }
        }
        let radius_m = self.field.circle_radius_m();
        let visible = (0..36).filter(|i| {
            let (sin, cos) = (f64::from(*i) / 36.0 * TAU).sin_cos();
            self.is_in_image(&Point2::new(radius_m * cos, radius_m * sin), 4.0)
        });
        if share(visible.count(), 36) >= MIN_CIRCLE_SHARE && self.distance_m(&center) < RANGE_M {
            score.num_visible += 1;
            score.num_recalled += usize::from(is_right);
        }
    }

    fn score_halfway(&self, score: &mut DetectionScore) {
        let Some(halfway_rad) = self.percept.features.circle.and_then(|circle| circle.halfway_rad) else {
            return;
        };
        let turn = angle::difference(2.0 * (halfway_rad + self.truth.yaw_rad), TAU / 2.0).abs() / 2.0;
        score.num_found += 1;
        score.num_right += usize::from(turn < TOLERANCE_RAD);
    }

    fn score_marks(&self, score: &mut DetectionScore) {
        let d = self.field.dimensions();
        let x = d.length_m / 2.0 - d.penalty_mark_from_goal_line_m;
        let on_map = [Point2::new(x, 0.0), Point2::new(-x, 0.0)];
        let mut found = [false; 2];
        for mark in &self.percept.features.marks {
            score.num_found += 1;
            if let Some(i) = on_map.iter().position(|at| self.off_px(&mark.at_px, at) < TOLERANCE_PX) {
                found[i] = true;
                score.num_right += 1;
                score.errors_m.extend(self.error_m(&mark.at_px, &on_map[i]));
            }
        }
        for (at, found) in on_map.iter().zip(found) {
            if self.is_visible(at) && self.distance_m(at) < MARK_RANGE_M {
                score.num_visible += 1;
                score.num_recalled += usize::from(found);
            }
        }
    }

    fn posts(&self) -> impl Iterator<Item = (Goal, Point2<f64>)> + '_ {
        let goals = self.field.goals().iter().copied();
        goals.flat_map(|goal| [1.0, -1.0].map(|side| (goal, Point2::new(goal.x_m, side * goal.post_y_m))))
    }

    fn is_post(&self, post: &GoalPost, goal: &Goal, at: &Point2<f64>) -> bool {
        let color = match goal.color {
            GoalColor::Yellow => PostColor::Yellow,
            GoalColor::Blue => PostColor::Blue,
            GoalColor::White => PostColor::White,
        };
        let in_robot = self.truth.inverse().transform(at);
        let bearing_rad = in_robot.y.atan2(in_robot.x);
        let is_near = |base: &Point2<f64>| {
            let px = self.reported_px(base);
            px.is_some_and(|px| self.off_px(&px, at) < TOLERANCE_PX)
        };
        color == post.color
            && angle::difference(post.bearing_rad, bearing_rad).abs() < 0.05
            && post.base_in_robot.as_ref().is_none_or(is_near)
    }

    fn score_posts(&self, score: &mut DetectionScore) {
        for post in &self.percept.features.posts {
            score.num_found += 1;
            if let Some((_, at)) = self.posts().find(|(goal, at)| self.is_post(post, goal, at)) {
                score.num_right += 1;
                let px = post.base_in_robot.and_then(|base| self.reported_px(&base));
                score.errors_m.extend(px.and_then(|px| self.error_m(&px, &at)));
            }
        }
        for (goal, at) in self.posts() {
            if self.is_visible(&at) {
                score.num_visible += 1;
                let found = self.percept.features.posts.iter().any(|post| self.is_post(post, &goal, &at));
                score.num_recalled += usize::from(found);
            }
        }
    }

    /// Of the right posts with a side.
    fn score_sides(&self, score: &mut DetectionScore) {
        for post in &self.percept.features.posts {
            let Some((goal, at)) = self.posts().find(|(goal, at)| self.is_post(post, goal, at)) else {
                continue;
            };
            let Some(side) = post.side else { continue };
            // From the field the left post of the goal at +x is the one at +y.
            let is_left = (at.y * goal.x_m > 0.0) == (goal.x_m.abs() > (self.truth.x_m * goal.x_m.signum()));
            score.num_found += 1;
            score.num_right += usize::from(is_left == (side == PostSide::Left));
        }
    }
}
