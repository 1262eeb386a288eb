//! Border pixels of doors and of the floor matched to the borders of a building.
//!
//! A pixel has a counterpart of its kind only: the left edge of a door is never taken for a right one, and the floor below
//! a door is not the floor below a wall. Which borders are seen from a pose is worked out once for all pixels.

use std::sync::Arc;

use nalgebra::{Matrix3, Point2, Point3, Vector3};

use super::{
    OfficeObservationModel,
    lines::TheoreticalLine,
    sights::{Sights, Window},
    view::View,
};
use crate::{
    observation::{
        edge::{Edge, Eye},
        features::{CameraState, FeatureMatch, FeatureModel, Residual},
    },
    vision::{FeatureKind, Percept, px_tolerance},
};

/// Borders that are looked at from one pose at most: those that come first in the building.
const MAX_SEEN: usize = 96;
/// Group of the doors; borders of the floor are 0.
const DOORS: usize = 1;
/// Shares of the pixels of floor and doors that are as good as all: the rest is what stands around.
const FULL_SHARES: [f64; 2] = [0.95, 0.9];

/// A border pixel as it is needed for matching.
#[derive(Debug, Clone, Copy)]
struct Border {
    px: Point2<f64>,
    /// Direction in the camera frame with z = 1.
    ray: Vector3<f64>,
    kind: FeatureKind,
}

/// A border of the building in the image.
#[derive(Debug, Clone, Copy)]
struct Seen {
    kind: FeatureKind,
    start: Point2<f64>,
    /// To its other end, pixels.
    along: nalgebra::Vector2<f64>,
    inverse_length2: f64,
    edge: Edge,
}

/// Matches border pixels to a building.
#[derive(Debug, Clone)]
pub struct OfficeFeatureModel {
    sights: Arc<Sights>,
    borders: Vec<Border>,
    intrinsics: Matrix3<f64>,
    /// Pixels of the image in what distances are counted in, and the focal lengths in it.
    unit_px: f64,
    focal_px: (f64, f64),
    size_px: (f64, f64),
    robot_from_camera: Matrix3<f64>,
    eye_in_robot: Vector3<f64>,
}

impl OfficeFeatureModel {
    /// The borders of the building that `pixels` knows.
    pub fn new(pixels: &OfficeObservationModel) -> Self {
        Self {
            sights: Arc::clone(pixels.sights()),
            borders: Vec::new(),
            intrinsics: Matrix3::identity(),
            unit_px: 1.0,
            focal_px: (1.0, 1.0),
            size_px: (320.0, 240.0),
            robot_from_camera: Matrix3::identity(),
            eye_in_robot: Vector3::zeros(),
        }
    }

    /// The borders that are seen from a state, as many as there is room for.
    fn look<'a>(
        &self,
        state: &CameraState,
        eye: &Eye,
        margin_px: f64,
        seen: &'a mut [Seen; MAX_SEEN],
    ) -> &'a [Seen] {
        let view = View::tilted(eye, &self.intrinsics);
        let window = Window { size_px: self.size_px, margin_px };
        let mut count = 0;
        let place = state.world_from_robot.position();
        let any = |_: &TheoreticalLine| true;
        self.sights.visit_seen(&place, &view, &window, any, |line, [a, b]| {
            if count < MAX_SEEN {
                seen[count] = Seen::new(line, a, b);
                count += 1;
            }
        });
        &seen[..count]
    }

    /// The nearest border of the pixel's kind.
    fn matched(&self, border: &Border, eye: &Eye, seen: &[Seen], gate_px: f64) -> Option<Residual> {
        let mut nearest2 = gate_px * gate_px;
        let mut best = None;
        for candidate in seen.iter().filter(|candidate| candidate.kind == border.kind) {
            let distance2 = candidate.distance2_px(&border.px);
            if distance2 < nearest2 {
                nearest2 = distance2;
                best = Some(&candidate.edge);
            }
        }
        let ray = eye.ray(&border.ray);
        let offset = eye.image_of(best?, self.focal_px).offset(&ray)?;
        Some(eye.residual(&ray, &offset))
    }
}

impl Seen {
    const NOTHING: Self = Self {
        kind: FeatureKind::UnknownLine,
        start: Point2::new(0.0, 0.0),
        along: nalgebra::Vector2::new(0.0, 0.0),
        inverse_length2: 0.0,
        edge: Edge { point: Point3::new(0.0, 0.0, 0.0), along: Vector3::new(0.0, 0.0, 1.0) },
    };

    fn new(line: &TheoreticalLine, start: &Point2<f64>, end: &Point2<f64>) -> Self {
        let along = end - start;
        let on_floor = line.end - line.start;
        let edge_along = if line.kind.is_door_edge() { Vector3::z() } else { on_floor.normalize().push(0.0) };
        Self {
            kind: line.kind,
            start: *start,
            along,
            inverse_length2: 1.0 / along.norm_squared().max(1e-6),
            edge: Edge { point: Point3::new(line.start.x, line.start.y, 0.0), along: edge_along },
        }
    }

    /// Squared distance of a pixel from the border, ends included.
    fn distance2_px(&self, px: &Point2<f64>) -> f64 {
        let offset = px - self.start;
        let t = (offset.dot(&self.along) * self.inverse_length2).clamp(0.0, 1.0);
        (offset - self.along * t).norm_squared()
    }
}

/// It suggests nothing, since the pixels' model proposes poses at all doors and walls that fit, and has no landmarks: doors look alike, none says by itself
/// where the robot is.
impl FeatureModel for OfficeFeatureModel {
    fn condition_on(&mut self, percept: &Percept) {
        let ((fx, fy), (cx, cy)) = (percept.camera.focal_px(), percept.camera.center_px());
        let (width, height) = percept.camera.size_px();
        self.unit_px = px_tolerance(width);
        self.focal_px = (fx / self.unit_px, fy / self.unit_px);
        self.size_px = (f64::from(width), f64::from(height));
        self.intrinsics = Matrix3::new(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0);
        self.robot_from_camera = *percept.robot_from_camera.rotation();
        self.eye_in_robot = *percept.robot_from_camera.translation();
        self.borders.clear();
        self.borders.extend(percept.borders.iter().map(|border| Border {
            px: border.ideal_px,
            ray: Vector3::new((border.ideal_px.x - cx) / fx, (border.ideal_px.y - cy) / fy, 1.0),
            kind: border.kind,
        }));
    }

    fn num_features(&self) -> usize {
        self.borders.len()
    }

    fn visit_matches(
        &self,
        state: &CameraState,
        gate_px: f64,
        stride: usize,
        visit: &mut dyn FnMut(FeatureMatch),
    ) {
        let eye = Eye::new(state, &self.robot_from_camera, &self.eye_in_robot);
        let gate_px = gate_px * self.unit_px;
        let mut seen = [Seen::NOTHING; MAX_SEEN];
        let seen = self.look(state, &eye, gate_px, &mut seen);
        for border in self.borders.iter().step_by(stride) {
            visit(FeatureMatch {
                group: if border.kind.is_door_edge() { DOORS } else { 0 },
                residual: self.matched(border, &eye, seen, gate_px),
                unmatched_agreement: 0.0,
                on_bar: None,
            });
        }
    }

    fn full_shares(&self) -> [f64; 2] {
        FULL_SHARES
    }
}
