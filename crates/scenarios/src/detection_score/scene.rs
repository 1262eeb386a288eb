//! The percept with the truth: where things of the map are in the image.

use nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use visloc_core::geom::{CameraFrame, PlanarPose, Plane, Rigid3, Robot};
use visloc_locate::{
    observation::{
        features::{CameraState, FeatureModel},
        field::FieldFeatureModel,
    },
    vision::Percept,
};
use visloc_world::field::Field;

/// Gates of the fit of the camera's direction, pixels, and its standard deviation before, radians.
const FIT_GATES_PX: [f64; 6] = [25.0, 25.0, 15.0, 10.0, 8.0, 8.0];
const TILT_RAD: f64 = 0.03;
/// What is farther away is not asked for, meters.
pub(super) const RANGE_M: f64 = 4.0;
/// What is nearer to the border of the image is not asked for, pixels: a part of it is cut off.
const MARGIN_PX: f64 = 16.0;

/// The percept with the truth.
pub(super) struct Scene<'a> {
    pub percept: &'a Percept,
    pub field: &'a Field,
    pub truth: PlanarPose,
    robot_from_camera: Rigid3<Robot, CameraFrame>,
}

impl<'a> Scene<'a> {
    pub fn new(percept: &'a Percept, field: &'a Field, truth: &PlanarPose) -> Self {
        let robot_from_camera = fitted_camera(percept, field, truth);
        Self { percept, field, truth: *truth, robot_from_camera }
    }

    /// Pixel of a place in the world, free of distortion.
    pub fn px(&self, at: &Point2<f64>) -> Option<Point2<f64>> {
        let in_robot = self.truth.inverse().transform(at);
        let in_robot = Point3::new(in_robot.x, in_robot.y, 0.0);
        let camera = self.percept.camera.without_distortion();
        camera.project(&self.robot_from_camera.inverse().transform(&in_robot)).ok()
    }

    /// Pixel of a place seen from the robot, by the camera that it reports.
    pub fn reported_px(&self, in_robot: &Point2<f64>) -> Option<Point2<f64>> {
        let in_robot = Point3::new(in_robot.x, in_robot.y, 0.0);
        let camera = self.percept.camera.without_distortion();
        camera.project(&self.percept.robot_from_camera.inverse().transform(&in_robot)).ok()
    }

    /// Place in the world seen at a pixel that is free of distortion.
    pub fn ground(&self, px: &Point2<f64>) -> Option<Point2<f64>> {
        let ray = self.percept.camera.without_distortion().bearing(px);
        let eye = Point3::from(*self.robot_from_camera.translation());
        let at = Plane::ground().intersect_ray(&eye, &self.robot_from_camera.rotate(&ray))?;
        Some(self.truth.transform(&at.xy()))
    }

    /// Distance on the ground of what is seen at a pixel, meters.
    pub fn error_m(&self, px: &Point2<f64>, at: &Point2<f64>) -> Option<f64> {
        self.ground(px).map(|found| (found - at).norm())
    }

    pub fn off_px(&self, found_px: &Point2<f64>, at: &Point2<f64>) -> f64 {
        self.px(at).map_or(f64::INFINITY, |px| (px - found_px).norm())
    }

    pub fn distance_m(&self, at: &Point2<f64>) -> f64 {
        (at - self.truth.position()).norm()
    }

    pub fn is_in_image(&self, at: &Point2<f64>, margin_px: f64) -> bool {
        let (width, height) = self.percept.camera.size_px();
        self.px(at).is_some_and(|px| {
            (margin_px..f64::from(width) - margin_px).contains(&px.x)
                && (margin_px..f64::from(height) - margin_px).contains(&px.y)
        })
    }

    pub fn is_visible(&self, at: &Point2<f64>) -> bool {
        self.distance_m(at) < RANGE_M && self.is_in_image(at, MARGIN_PX)
    }
}

/// The true direction of the camera, as the borders tell it at the true place.
fn fitted_camera(percept: &Percept, field: &Field, truth: &PlanarPose) -> Rigid3<Robot, CameraFrame> {
    let mut model = FieldFeatureModel::new(field);
    model.condition_on(percept);
    let mut state = CameraState::reported(*truth);
    for gate_px in FIT_GATES_PX {
        let mut information = Matrix3::identity() / (TILT_RAD * TILT_RAD);
        let mut gradient = -state.tilt_rad / (TILT_RAD * TILT_RAD);
        model.visit_matches(&state, gate_px, 1, &mut |matched| {
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
