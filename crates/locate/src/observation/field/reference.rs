//! The slow reference model: draws the theoretical image of a pose and looks for the nearest drawn pixel.
//!
//! Source: 2010 section 4.3, before the tables of section 4.3.1. It shows what the fast model stands for and is what
//! tests compare it with.

use nalgebra::{Matrix3x4, Point2, Vector4};
use visloc_core::{geom::PlanarPose, settings::check_ranges};
use visloc_world::field::Field;

use super::model::{FieldModelConfig, FieldTables};
use crate::{
    ConfigError,
    observation::projection::{combine, projection},
    vision::{FeatureKind, Percept, px_tolerance},
};

/// Draws theoretical images of a field and compares percepts with them.
#[derive(Debug, Clone)]
pub struct DrawnFieldModel {
    max_distance_px: f64,
    tables: FieldTables,
}

/// Distance between drawn points on an outline, meters.
const STEP_M: f64 = 0.01;

impl DrawnFieldModel {
    /// The model of a field.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(field: &Field, config: &FieldModelConfig) -> Result<Self, ConfigError> {
        check_ranges(config)?;
        Ok(Self { max_distance_px: config.max_distance_px, tables: FieldTables::new(field) })
    }

    /// The theoretical image at a pose: every outline point in view with its undistorted pixel. Points up to
    /// `max_distance_px` outside the image are included.
    pub fn draw(&self, percept: &Percept, world_from_robot: &PlanarPose) -> Vec<(FeatureKind, Point2<f64>)> {
        let ideal_from_robot = projection(&percept.camera, &percept.robot_from_camera);
        let robot_from_world = world_from_robot.to_rigid3().inverse();
        let margin = self.max_distance_in(percept);
        let (width, height) = percept.camera.size_px();
        let mut drawn = Vec::new();
        let mut put = |kind, x: f64, y: f64, z: f64| {
            let in_robot = robot_from_world.transform(&nalgebra::Point3::new(x, y, z));
            if let Some(px) = project(&ideal_from_robot, &in_robot) {
                let inside = |v: f64, size: u32| v >= -margin && v <= f64::from(size) - 1.0 + margin;
                if inside(px.x, width) && inside(px.y, height) {
                    drawn.push((kind, px));
                }
            }
        };
        for outline in self.tables.ground.outlines() {
            outline.sample(STEP_M, |p| put(FeatureKind::FieldLine, p.x, p.y, 0.0));
        }
        let world_from_camera = world_from_robot.to_rigid3() * percept.robot_from_camera;
        let eye = nalgebra::Point3::from(*world_from_camera.translation());
        for goal in &self.tables.goals {
            for kind in [FeatureKind::YellowGoal, FeatureKind::BlueGoal] {
                if goal.matches(kind) {
                    goal.sample(&eye, STEP_M, |p| put(kind, p.x, p.y, p.z));
                }
            }
        }
        drawn
    }

    /// Likelihood of the percept at a pose, 0 to 1, as [`crate::ObservationModel::likelihood`].
    pub fn likelihood(&self, percept: &Percept, world_from_robot: &PlanarPose) -> f64 {
        let drawn = self.draw(percept, world_from_robot);
        let max_distance_px = self.max_distance_in(percept);
        let (mut lines, mut goals) = ((0.0, 0), (0.0, 0));
        for pixel in &percept.pixels {
            let distance = drawn
                .iter()
                .filter(|(kind, _)| *kind == pixel.kind)
                .map(|(_, px)| (px - pixel.ideal_px).norm())
                .fold(max_distance_px, f64::min);
            let sum = if pixel.kind.is_goal() { &mut goals } else { &mut lines };
            sum.0 += distance;
            sum.1 += 1;
        }
        combine(max_distance_px, lines, goals)
    }

    /// In pixels of the image.
    fn max_distance_in(&self, percept: &Percept) -> f64 {
        self.max_distance_px * px_tolerance(percept.camera.size_px().0)
    }
}

fn project(ideal_from_robot: &Matrix3x4<f64>, in_robot: &nalgebra::Point3<f64>) -> Option<Point2<f64>> {
    let h = ideal_from_robot * Vector4::new(in_robot.x, in_robot.y, in_robot.z, 1.0);
    (h.z > 0.05).then(|| Point2::new(h.x / h.z, h.y / h.z))
}
