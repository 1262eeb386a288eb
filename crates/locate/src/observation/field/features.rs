//! Border pixels of lines and goals matched to the borders of a field.
//!
//! A border of a line is matched only to borders that have their white on the same side in the image, so the two borders
//! of one line are not mistaken for each other. Residuals are distances in the image between the pixel and the straight
//! image of the border.

use std::sync::Arc;

use nalgebra::{Matrix3, Point2, Point3, Vector2, Vector3};
use rand::RngExt;
use visloc_core::{Rng, geom::PlanarPose};
use visloc_world::field::Field;

use super::{
    composites::CompositePlaces,
    model::{FieldObservationModel, FieldTables},
    outline::Outline,
    suggest::{self, GroundBorder, Nets},
};
use crate::{
    observation::{
        edge::{Edge, Eye, Offset, Ray},
        features::{CameraState, FeatureMatch, FeatureModel, OnBar, Residual},
    },
    vision::{FeatureKind, FieldFeatures, Percept, blur_px, border_noise, px_scale, px_tolerance},
};

/// How far beyond the end of a line or post a pixel may lie and still belong to it, meters.
const END_TOLERANCE_M: f64 = 0.06;
/// Behind a goal are a net and the bars that hold it: this far to the sides of the posts and this far behind, meters.
const NET_WIDTH_M: f64 = 0.3;
const NET_DEPTH_M: f64 = 1.0;
/// Agreement of a line pixel that matches nothing and lies behind a goal.
const NET_AGREEMENT: f64 = 0.9;
/// Agreement of a pixel that matches nothing where not everything is on the map: a line pixel outside of the lines, and the border of a white
/// post, since legs, tubes of the net and other white things stand upright as well.
const UNKNOWN_AGREEMENT: f64 = 0.5;
/// Share of the suggestions that come from composite features, if there are any.
const COMPOSITE_SHARE: f64 = 0.6;
/// Group of the goals; lines are 0.
const GOALS: usize = 1;

/// A border pixel as it is needed for matching.
#[derive(Debug, Clone, Copy)]
struct Border {
    /// Direction in the camera frame with z = 1.
    ray: Vector3<f64>,
    /// Towards the object, pixels.
    inward: Vector2<f64>,
    kind: FeatureKind,
}

/// Matches border pixels to a field.
#[derive(Debug, Clone)]
pub struct FieldFeatureModel {
    tables: Arc<FieldTables>,
    places: CompositePlaces,
    composites: FieldFeatures,
    is_point_symmetric: bool,
    /// To the outer borders of the outer lines, meters.
    half_field_m: (f64, f64),
    half_goal_m: f64,
    line_width_m: f64,
    borders: Vec<Border>,
    /// Line pixels on the ground, seen from the robot.
    ground_borders: Vec<GroundBorder>,
    /// Where nothing but carpet is seen, as directions in the camera frame with z = 1, and the side of a patch as [`Residual::error_px`].
    bare: Vec<Vector3<f64>>,
    patch_px: f64,
    /// In what distances in the image are counted in.
    focal_px: (f64, f64),
    /// As [`FeatureModel::noise`].
    noise: f64,
    /// The first corner of the image and the last one, as directions in the camera frame with z = 1.
    corners: [Vector2<f64>; 2],
    width_px: u32,
    robot_from_camera: Matrix3<f64>,
    eye_in_robot: Vector3<f64>,
}

impl FieldFeatureModel {
    /// A model of a field; builds its tables.
    pub fn new(field: &Field) -> Self {
        Self::with_tables(field, Arc::new(FieldTables::new(field)))
    }

    /// A model of the field of another model, which shares its tables.
    pub fn beside(field: &Field, model: &FieldObservationModel) -> Self {
        Self::with_tables(field, model.tables().clone())
    }

    fn with_tables(field: &Field, tables: Arc<FieldTables>) -> Self {
        let d = field.dimensions();
        Self {
            tables,
            places: CompositePlaces::new(field),
            composites: FieldFeatures::default(),
            is_point_symmetric: field.is_point_symmetric(),
            half_field_m: (
                (d.length_m + d.line_width_m) / 2.0 + END_TOLERANCE_M,
                (d.width_m + d.line_width_m) / 2.0 + END_TOLERANCE_M,
            ),
            half_goal_m: field.goals()[0].post_y_m,
            line_width_m: d.line_width_m,
            borders: Vec::new(),
            ground_borders: Vec::new(),
            bare: Vec::new(),
            patch_px: 0.0,
            focal_px: (1.0, 1.0),
            noise: 1.0,
            corners: [Vector2::zeros(); 2],
            width_px: 0,
            robot_from_camera: Matrix3::identity(),
            eye_in_robot: Vector3::zeros(),
        }
    }

    /// Where a ray meets the ground.
    fn ground_in_robot(&self, ray_in_camera: &Vector3<f64>) -> Option<Point2<f64>> {
        let ray = self.robot_from_camera * ray_in_camera;
        (ray.z < 0.0).then(|| Point2::from((self.eye_in_robot + ray * (-self.eye_in_robot.z / ray.z)).xy()))
    }

    fn eye(&self, state: &CameraState) -> Eye {
        Eye::new(state, &self.robot_from_camera, &self.eye_in_robot)
    }

    /// Square of the distance from the eye, meters, at which a line across the view is so many pixels thick.
    fn max_slant2(&self, eye: &Eye, thickness_px: f64) -> f64 {
        let px = thickness_px * f64::from(blur_px(self.width_px)) / px_tolerance(self.width_px);
        self.focal_px.1 * self.line_width_m * eye.at.z / px
    }

    /// The nearest border with its white on the same side, and what the pixel may be of if there is none.
    fn match_line(&self, border: &Border, eye: &Eye, gate_px: f64) -> FeatureMatch {
        let ray = eye.ray(&border.ray);
        let Some(ground) = eye.ground(&ray) else {
            return FeatureMatch { group: 0, residual: None, unmatched_agreement: 0.0, on_bar: None };
        };
        let mut nearest = Nearest::within(gate_px);
        for index in self.tables.ground.nearest_indices(&ground) {
            for outline in self.tables.ground.both_borders(index) {
                let Some((edge, inward)) = outline.edge_near(&ground) else { continue };
                let image = eye.image_of(&edge, self.focal_px);
                // The side of the white in the image, from the plane's value a little inside of the border.
                let is_same_side = image.plane.xy().dot(&inward) * image.line.dot(&border.inward) > 0.0;
                if is_same_side && let Some(offset) = image.offset(&ray) {
                    nearest.take(offset);
                }
            }
        }
        let residual = nearest.residual(eye, &ray);
        let (half_x, half_y) = self.half_field_m;
        let (unmatched_agreement, on_bar) = if ground.x.abs() < half_x && ground.y.abs() < half_y {
            (0.0, None)
        } else if let Some(depth_m) = self.depth_in_net_m(&ground) {
            (NET_AGREEMENT, self.on_bar((border, &ray), (&ground, depth_m), eye))
        } else {
            (UNKNOWN_AGREEMENT, None)
        };
        FeatureMatch { group: 0, residual, unmatched_agreement, on_bar }
    }

    /// How far a point of the ground is behind a goal line, where the net and what holds it may be.
    fn depth_in_net_m(&self, ground: &Point2<f64>) -> Option<f64> {
        let depth_m = ground.x.abs() - self.half_field_m.0;
        let is_net = (0.0..NET_DEPTH_M).contains(&depth_m) && ground.y.abs() < self.half_goal_m + NET_WIDTH_M;
        is_net.then_some(depth_m)
    }

    /// Where a pixel lies in the range of the bar at the foot of a net: the bar is parallel to the goal line.
    fn on_bar(
        &self,
        (border, ray): (&Border, &Ray),
        (ground, depth_m): (&Point2<f64>, f64),
        eye: &Eye,
    ) -> Option<OnBar> {
        const STEP_M: f64 = 0.01;
        let inward = Vector3::new(border.inward.x / self.focal_px.0, border.inward.y / self.focal_px.1, 0.0);
        let inside = eye.ground(&eye.ray(&(border.ray + inward)))?;
        let point = Point3::new(ground.x + STEP_M, ground.y, 0.0);
        let step = eye.image_of(&Edge { point, along: Vector3::y() }, self.focal_px).offset(ray)?;
        Some(OnBar {
            side: usize::from(inside.x.abs() > ground.x.abs()),
            at: depth_m / NET_DEPTH_M,
            range_px: step.error_px.abs() * NET_DEPTH_M / STEP_M,
        })
    }

    fn match_goal(&self, border: &Border, eye: &Eye, gate_px: f64) -> Option<Residual> {
        let ray = eye.ray(&border.ray);
        let mut nearest = Nearest::within(gate_px);
        for goal in self.tables.goals.iter().filter(|goal| goal.matches(border.kind)) {
            goal.visit_edges(&eye.at, &ray.in_world, &border.inward, END_TOLERANCE_M, |point, along| {
                if let Some(offset) = eye.image_of(&Edge { point, along }, self.focal_px).offset(&ray) {
                    nearest.take(offset);
                }
            });
        }
        nearest.residual(eye, &ray)
    }
}

/// The border nearest to a pixel in the image; only for this one derivatives are computed.
struct Nearest {
    /// Only nearer ones are taken, pixels.
    within_px: f64,
    offset: Option<Offset>,
}

impl Nearest {
    fn within(gate_px: f64) -> Self {
        Self { within_px: gate_px, offset: None }
    }

    #[inline]
    fn take(&mut self, offset: Offset) {
        if offset.error_px.abs() < self.within_px {
            self.within_px = offset.error_px.abs();
            self.offset = Some(offset);
        }
    }

    fn residual(&self, eye: &Eye, ray: &Ray) -> Option<Residual> {
        self.offset.as_ref().map(|offset| eye.residual(ray, offset))
    }
}

impl FeatureModel for FieldFeatureModel {
    fn condition_on(&mut self, percept: &Percept) {
        let ((fx, fy), (cx, cy)) = (percept.camera.focal_px(), percept.camera.center_px());
        let (width_px, height_px) = percept.camera.size_px();
        let corner = |x: u32, y: u32| Vector2::new((f64::from(x) - cx) / fx, (f64::from(y) - cy) / fy);
        (self.corners, self.width_px) = ([corner(0, 0), corner(width_px, height_px)], width_px);
        let unit_px = px_tolerance(width_px);
        self.noise = border_noise(width_px);
        self.focal_px = (fx / unit_px, fy / unit_px);
        self.robot_from_camera = *percept.robot_from_camera.rotation();
        self.eye_in_robot = *percept.robot_from_camera.translation();
        self.composites.copy_from(&percept.features);
        self.borders.clear();
        self.borders.extend(percept.borders.iter().map(|border| Border {
            ray: Vector3::new((border.ideal_px.x - cx) / fx, (border.ideal_px.y - cy) / fy, 1.0),
            inward: border.inward,
            kind: border.kind,
        }));
        self.bare.clear();
        let bearing = |px: &Point2<f64>| Vector3::new((px.x - cx) / fx, (px.y - cy) / fy, 1.0);
        self.bare.extend(percept.bare_ground.middles.iter().map(bearing));
        self.patch_px = percept.bare_ground.patch_px / unit_px;
        self.ground_borders.clear();
        for border in self.borders.iter().filter(|border| !border.kind.is_goal()) {
            let inward = Vector3::new(border.inward.x / fx, border.inward.y / fy, 0.0);
            let at = self.ground_in_robot(&border.ray);
            let inside = self.ground_in_robot(&(border.ray + inward));
            self.ground_borders
                .extend(at.zip(inside).map(|(at, inside)| GroundBorder { at, inward: inside - at }));
        }
    }

    fn num_features(&self) -> usize {
        self.borders.len()
    }

    fn noise(&self) -> f64 {
        self.noise
    }

    fn expected_px(&self, state: &CameraState, margin_px: f64) -> f64 {
        let eye = self.eye(state);
        // Per radian, in pixels of an image 320 px wide.
        let unit = px_tolerance(self.width_px) / px_scale(self.width_px);
        let focal = Vector2::new(self.focal_px.0, self.focal_px.1) * unit;
        // A line is as thick as a pixel.
        let max_slant2 = self.max_slant2(&eye, 1.0);
        let margin = Vector2::new(margin_px / focal.x, margin_px / focal.y);
        let [first, last] = [self.corners[0] + margin, self.corners[1] - margin];
        let image_of = |point: &Point2<f64>| {
            let to_point = Point3::new(point.x, point.y, 0.0) - eye.at;
            let distance2 = to_point.xy().norm_squared();
            if distance2 < eye.at.z.powi(2) || to_point.norm_squared() > max_slant2 {
                return None;
            }
            let ray = eye.world_from_camera.tr_mul(&to_point);
            let at = ray.xy() / ray.z;
            let is_inside = at >= first && at <= last;
            (ray.z > 0.0 && is_inside).then(|| at.component_mul(&focal))
        };
        let mut sum_px = 0.0;
        for outline in self.tables.ground.outlines() {
            let mut before: Option<Vector2<f64>> = None;
            outline.sample(2.0 * self.line_width_m, |point| {
                // A line is known by the carpet on both sides.
                let other = point + outline.inward(&point) * self.line_width_m;
                let here = image_of(&point).filter(|_| image_of(&other).is_some());
                sum_px += before.zip(here).map_or(0.0, |(before, here)| (here - before).norm());
                before = here;
            });
        }
        sum_px
    }

    fn missed_px(&self, state: &CameraState) -> f64 {
        let eye = self.eye(state);
        // A line that covers half of a pixel is seen.
        let max_slant2 = self.max_slant2(&eye, 0.5);
        let (mut num, half_px) = (0, 0.5 * self.patch_px);
        for bearing in &self.bare {
            let ray = eye.ray(bearing);
            let Some(ground) = eye.ground(&ray) else { continue };
            if (ground - eye.at.xy()).norm_squared() > max_slant2 - eye.at.z.powi(2) {
                continue;
            }
            let [nearest, _] = self.tables.ground.nearest_indices(&ground);
            for outline in self.tables.ground.both_borders(nearest) {
                let Some((edge, _)) = outline.edge_near(&ground) else { continue };
                let offset = eye.image_of(&edge, self.focal_px).offset(&ray);
                num += usize::from(offset.is_some_and(|offset| offset.error_px.abs() < half_px));
            }
        }
        f64::from(num as u32) * self.patch_px * px_tolerance(self.width_px) / px_scale(self.width_px)
    }

    fn visit_matches(
        &self,
        state: &CameraState,
        gate_px: f64,
        stride: usize,
        visit: &mut dyn FnMut(FeatureMatch),
    ) {
        let eye = self.eye(state);
        for border in self.borders.iter().step_by(stride) {
            visit(if border.kind.is_goal() {
                let residual = self.match_goal(border, &eye, gate_px);
                let is_white = border.kind == FeatureKind::WhiteGoal;
                let unmatched_agreement = if is_white { UNKNOWN_AGREEMENT } else { 0.0 };
                FeatureMatch { group: GOALS, residual, unmatched_agreement, on_bar: None }
            } else {
                self.match_line(border, &eye, gate_px)
            });
        }
    }

    fn suggest(&self, rng: &mut Rng) -> Option<PlanarPose> {
        let from_composite = rng.random_bool(COMPOSITE_SHARE);
        if from_composite && let Some(pose) = self.places.suggest(&self.composites, rng) {
            return Some(pose);
        }
        let nets = Nets {
            goal_line_m: self.half_field_m.0 - END_TOLERANCE_M,
            half_goal_m: self.half_goal_m,
            depth_m: NET_DEPTH_M,
        };
        suggest::pose_from_line(&self.ground_borders, self.tables.ground.outlines(), &nets, rng)
    }

    fn has_landmarks(&self) -> bool {
        !self.is_point_symmetric
    }

    fn twin(&self, pose: &PlanarPose) -> Option<PlanarPose> {
        (!self.is_point_symmetric).then(|| half_turned(pose))
    }

    fn mirrored(&self, pose: &PlanarPose) -> Option<PlanarPose> {
        self.is_point_symmetric.then(|| half_turned(pose))
    }
}

/// The pose from which the lines look the same.
fn half_turned(pose: &PlanarPose) -> PlanarPose {
    PlanarPose::new(-pose.x_m, -pose.y_m, pose.yaw_rad + std::f64::consts::PI)
}

impl Outline {
    /// The outline near a point on the ground as an edge, with the direction towards its white; `None` beyond its ends.
    #[inline]
    fn edge_near(&self, ground: &Point2<f64>) -> Option<(Edge, Vector2<f64>)> {
        let (point, along) = self.nearest_point(ground);
        let along = match self {
            Self::Segment { unit, .. } => {
                let is_beyond = along == Vector2::zeros();
                if is_beyond && (ground - point).dot(unit).abs() > END_TOLERANCE_M {
                    return None;
                }
                *unit
            }
            Self::Circle { .. } => along.normalize(),
        };
        let edge = Edge { point: Point3::new(point.x, point.y, 0.0), along: along.push(0.0) };
        Some((edge, self.inward(&point)))
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use visloc_core::{
        RngTree,
        geom::{Camera, nao},
    };
    use visloc_world::Map;

    use super::*;
    use crate::{
        observation::features::CameraVector,
        vision::{BareGround, BorderPixel},
    };

    const STATES: u64 = 40;

    fn field() -> Field {
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2010") else { panic!("built-in map") };
        field
    }

    fn percept(head: &nao::HeadAngles) -> Percept {
        let camera = Camera::pinhole((320, 240), (370.0, 360.0), (160.0, 118.0)).unwrap();
        let robot_from_camera = nao::robot_from_camera(&nao::Torso::upright(), head, nao::NaoCamera::TopV3);
        Percept { camera, robot_from_camera, ..Percept::default() }
    }

    /// Border pixels as they are seen from a pose: the outlines of the field and the posts, projected.
    fn seen_from(pose: &PlanarPose, percept: &Percept, model: &FieldFeatureModel) -> Vec<BorderPixel> {
        let camera_from_world = (pose.to_rigid3() * percept.robot_from_camera).inverse();
        let project = |p: Point3<f64>| {
            let px = percept.camera.project(&camera_from_world.transform(&p)).ok()?;
            percept.camera.contains(&px).then_some(px)
        };
        let mut borders = Vec::new();
        for outline in model.tables.ground.outlines() {
            outline.sample(0.11, |p| {
                let inside = p + outline.inward(&p) * 0.01;
                let lift = |q: Point2<f64>| Point3::new(q.x, q.y, 0.0);
                let Some((px, inside)) = project(lift(p)).zip(project(lift(inside))) else { return };
                let inward = inside - px;
                let inward = if inward.x.abs() > inward.y.abs() {
                    Vector2::new(inward.x.signum(), 0.0)
                } else {
                    Vector2::new(0.0, inward.y.signum())
                };
                borders.push(BorderPixel { ideal_px: px, inward, kind: FeatureKind::FieldLine });
            });
        }
        borders
    }

    fn random_state(i: u64) -> (PlanarPose, nao::HeadAngles, Rng) {
        let mut rng = RngTree::new(21).stream("state", i);
        let pose = PlanarPose::new(
            rng.random_range(-2.5..2.5),
            rng.random_range(-1.7..1.7),
            rng.random_range(-3.1..3.1),
        );
        let head =
            nao::HeadAngles { yaw_rad: rng.random_range(-0.9..0.9), pitch_rad: rng.random_range(0.1..0.35) };
        (pose, head, rng)
    }

    fn residuals(model: &FieldFeatureModel, state: &CameraState) -> Vec<Option<Residual>> {
        let mut all = Vec::new();
        model.visit_matches(state, 8.0, 1, &mut |feature| all.push(feature.residual));
        all
    }

    #[test]
    fn borders_match_themselves_and_jacobians_agree_with_differences() {
        let (mut compared, mut total, mut total_matched) = (0, 0, 0);
        for i in 0..STATES {
            let (pose, head, _) = random_state(i);
            let mut percept = percept(&head);
            let mut model = FieldFeatureModel::new(&field());
            percept.borders = seen_from(&pose, &percept, &model);
            model.condition_on(&percept);
            let pose = CameraVector::from([pose.x_m, pose.y_m, pose.yaw_rad, 0.0, 0.0, 0.0, 0.0]);
            let at = |step: CameraVector| CameraState::from(&(pose + step));
            let here = residuals(&model, &at(CameraVector::zeros()));
            let matched = here.iter().flatten().filter(|r| r.error_px.abs() < 0.1).count();
            (total, total_matched) = (total + here.len(), total_matched + matched);
            for axis in 0..pose.len() {
                let mut step = CameraVector::zeros();
                step[axis] = 1e-6;
                let (after, before) = (residuals(&model, &at(step)), residuals(&model, &at(-step)));
                for ((here, after), before) in here.iter().zip(after).zip(before) {
                    let (Some(here), Some(after), Some(before)) = (here, after, before) else { continue };
                    // The Jacobian is that at the border itself. In a corner a pixel may change to the other border.
                    let is_same = (after.error_px - before.error_px).abs() < 0.01
                        && (after.jacobian - before.jacobian).norm() < 0.1 * here.jacobian.norm()
                        && (after.jacobian - here.jacobian).norm() < 0.1 * here.jacobian.norm();
                    if here.error_px.abs() > 1e-6 || !is_same {
                        continue;
                    }
                    let numeric = (after.error_px - before.error_px) / 2e-6;
                    let analytic = here.jacobian[axis];
                    assert!(
                        (numeric - analytic).abs() < 0.02 * (1.0 + analytic.abs()),
                        "axis {axis}: {numeric} {analytic}"
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared > 2000, "{compared}");
        // Pieces inside of a crossing line may match that line's other border instead.
        assert!(total_matched * 100 >= total * 93, "{total_matched} of {total}");
    }

    #[test]
    fn suggestions_come_near_the_truth() {
        let mut near = 0;
        for i in 0..STATES {
            let (pose, head, mut rng) = random_state(i);
            let mut percept = percept(&head);
            let mut model = FieldFeatureModel::new(&field());
            percept.borders = seen_from(&pose, &percept, &model);
            model.condition_on(&percept);
            let is_near = |suggested: &PlanarPose| {
                suggested.distance_m(&pose) < 0.25 && suggested.heading_difference_rad(&pose) < 0.1
            };
            let hits = (0..1000).filter_map(|_| model.suggest(&mut rng)).filter(is_near).count();
            near += usize::from(percept.borders.len() < 10 || hits >= 3);
        }
        assert!(near >= 36, "{near} of {STATES} views");
    }

    /// Lines are expected where they are seen; none where the camera looks away from the field, or too far up.
    #[test]
    fn borders_are_expected_where_the_map_has_them() {
        let mut num = [0, 0];
        let mut model = FieldFeatureModel::new(&field());
        for i in 0..STATES {
            let (pose, head, _) = random_state(i);
            let mut percept = percept(&head);
            model.condition_on(&percept);
            let state = CameraState::reported(pose);
            let (expected_px, inner_px) = (model.expected_px(&state, 0.0), model.expected_px(&state, 30.0));
            let num_seen = seen_from(&pose, &percept, &model).len();
            assert!(
                inner_px <= expected_px && (expected_px == 0.0 || num_seen > 0),
                "{expected_px} {num_seen}"
            );
            num[0] += usize::from(num_seen > 20);
            num[1] += usize::from(expected_px > 200.0);
            percept.robot_from_camera = nao::robot_from_camera(
                &nao::Torso::upright(),
                &nao::HeadAngles { pitch_rad: -0.5, ..head },
                nao::NaoCamera::TopV3,
            );
            model.condition_on(&percept);
            assert!(model.expected_px(&state, 0.0).abs() < 1e-9);
        }
        assert!(num[0] > 20 && num[1] * 10 > num[0] * 7, "{num:?}");
        model.condition_on(&percept(&nao::HeadAngles { pitch_rad: 0.2, ..nao::HeadAngles::default() }));
        let out = CameraState::reported(PlanarPose::new(2.8, 0.5, 0.0));
        let into = CameraState::reported(PlanarPose::new(1.0, 0.0, 0.0));
        assert!(model.expected_px(&out, 0.0).abs() < 1e-9 && model.expected_px(&into, 0.0) > 200.0);
    }

    /// Bare ground contradicts no true place, and most of those from which lines should be seen on it.
    #[test]
    fn lines_are_missed_where_the_ground_is_bare() {
        let (mut num, mut num_missed, mut num_expected) = (0, 0, 0);
        let mut model = FieldFeatureModel::new(&field());
        for i in 0..STATES {
            let (pose, head, mut rng) = random_state(i);
            let mut percept = percept(&head);
            let seen = seen_from(&pose, &percept, &model);
            let grid = (1..39)
                .flat_map(|x| (1..59).map(move |y| Point2::new(f64::from(x) * 8.0, f64::from(y) * 4.0)));
            let is_bare = |px: &Point2<f64>| seen.iter().all(|border| (border.ideal_px - px).norm() > 25.0);
            percept.bare_ground = BareGround { patch_px: 4.0, middles: grid.filter(is_bare).collect() };
            model.condition_on(&percept);
            if percept.bare_ground.middles.len() < 100 {
                continue;
            }
            num += 1;
            let missed_px = model.missed_px(&CameraState::reported(pose));
            assert!(missed_px < 9.0, "{missed_px} px from {pose:?}");
            let other = PlanarPose::new(pose.x_m, pose.y_m, pose.yaw_rad + rng.random_range(0.4..1.2));
            let other = CameraState::reported(other);
            num_expected += usize::from(model.expected_px(&other, 0.0) > 400.0);
            num_missed += usize::from(model.missed_px(&other) > 40.0);
        }
        assert!(num > 25 && num_missed * 3 > num_expected * 2, "{num_missed} of {num_expected}, {num}");
    }

    /// Pixels of points on the ground, as a robot sees them that stands before the goal at -x.
    fn seen_on_ground(points: impl Iterator<Item = (f64, f64)>) -> Vec<FeatureMatch> {
        let pose = PlanarPose::new(-1.6, 0.1, 3.0);
        let mut percept = percept(&nao::HeadAngles { pitch_rad: 0.1, ..nao::HeadAngles::default() });
        let camera_from_world = (pose.to_rigid3() * percept.robot_from_camera).inverse();
        percept.borders.extend(points.map(|(x, y)| {
            let ideal_px =
                percept.camera.project(&camera_from_world.transform(&Point3::new(x, y, 0.0))).unwrap();
            BorderPixel { ideal_px, inward: Vector2::y(), kind: FeatureKind::FieldLine }
        }));
        let mut model = FieldFeatureModel::new(&field());
        model.condition_on(&percept);
        let mut seen = Vec::new();
        model.visit_matches(&CameraState::reported(pose), 0.01, 1, &mut |feature| seen.push(feature));
        seen
    }

    #[test]
    fn behind_a_goal_unmatched_pixels_prove_nothing() {
        let seen = seen_on_ground([(-2.0, 0.3), (-3.5, 0.2), (-3.5, 1.5)].into_iter());
        let agreements: Vec<f64> = seen.iter().map(|feature| feature.unmatched_agreement).collect();
        assert_eq!(agreements, [0.0, NET_AGREEMENT, UNKNOWN_AGREEMENT]);
        let loose: Vec<bool> = seen.iter().map(|feature| feature.on_bar.is_some()).collect();
        assert_eq!(loose, [false, true, false], "only behind the goal stands a net");
    }

    #[test]
    fn a_bar_behind_the_goal_is_one_place_of_its_range() {
        let seen = seen_on_ground((0..9).map(|i| (-3.45, 0.1 * f64::from(i) - 0.4)));
        let bars: Vec<OnBar> = seen.iter().filter_map(|feature| feature.on_bar).collect();
        assert_eq!(bars.len(), 9);
        for bar in &bars {
            assert!((bar.at - bars[0].at).abs() < 1e-9 && bar.side == bars[0].side, "{bar:?}");
            assert!((30.0..200.0).contains(&bar.range_px), "{bar:?}");
        }
        let depth_m = 3.45 - 3.0 - 0.025 - END_TOLERANCE_M;
        assert!((bars[0].at - depth_m / NET_DEPTH_M).abs() < 1e-9, "{:?}", bars[0]);
    }
}
