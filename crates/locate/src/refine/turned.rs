//! What an image shows if the camera's direction is not the reported one.

use nalgebra::{Matrix3, Point2, Rotation3, Vector3};
use visloc_core::geom::{CameraFrame, Rigid3};

use crate::vision::Percept;

/// A percept whose camera is turned, in memory that is used again.
#[derive(Debug, Clone, Default)]
pub(super) struct Turned {
    percept: Percept,
}

/// Moves what lies on the ground to where it is if the camera is turned.
struct Ground {
    /// Of directions, in the robot's axes.
    turn: Matrix3<f64>,
    eye: Vector3<f64>,
}

impl Turned {
    /// The percept as it is if the camera is turned by a rotation vector in its frame, radians.
    pub fn turn<'a>(&'a mut self, percept: &'a Percept, tilt_rad: &Vector3<f64>) -> &'a Percept {
        if *tilt_rad == Vector3::zeros() {
            return percept;
        }
        let reported = &percept.robot_from_camera;
        let rotation = Rotation3::from_scaled_axis(*tilt_rad);
        let turned = &mut self.percept;
        turned.at = percept.at;
        copy(&mut turned.pixels, &percept.pixels);
        copy(&mut turned.borders, &percept.borders);
        copy(&mut turned.blobs, &percept.blobs);
        turned.features.copy_from(&percept.features);
        turned.camera_index = percept.camera_index;
        turned.camera.clone_from(&percept.camera);
        turned.robot_from_camera =
            *reported * Rigid3::<CameraFrame, CameraFrame>::new(rotation, Vector3::zeros());
        (turned.quality, turned.is_informative) = (percept.quality, percept.is_informative);
        let axes = reported.rotation();
        let ground =
            Ground { turn: axes * rotation.matrix() * axes.transpose(), eye: *reported.translation() };
        ground.turn_features(turned);
        turned
    }
}

impl Ground {
    /// Features that are beyond the horizon then are left out.
    fn turn_features(&self, percept: &mut Percept) {
        let features = &mut percept.features;
        features.lines.retain_mut(|line| {
            let ends = line.ends_in_robot.map(|end| self.point(&end));
            let [Some(a), Some(b)] = ends else { return false };
            line.ends_in_robot = [a, b];
            true
        });
        features.junctions.retain_mut(|junction| {
            let moved = self.direction(&junction.at_in_robot, junction.direction_rad);
            let Some((at, direction_rad)) = moved else { return false };
            (junction.at_in_robot, junction.direction_rad) = (at, direction_rad);
            true
        });
        features.circle = features.circle.and_then(|mut circle| {
            let halfway =
                circle.halfway_rad.and_then(|halfway| self.direction(&circle.center_in_robot, halfway));
            circle.center_in_robot = self.point(&circle.center_in_robot)?;
            circle.halfway_rad = halfway.map(|(_, halfway_rad)| halfway_rad);
            Some(circle)
        });
        features.marks.retain_mut(|mark| match self.point(&mark.at_in_robot) {
            Some(at) => {
                mark.at_in_robot = at;
                true
            }
            None => false,
        });
        for post in &mut features.posts {
            post.base_in_robot = post.base_in_robot.and_then(|base| self.point(&base));
        }
    }

    fn point(&self, at: &Point2<f64>) -> Option<Point2<f64>> {
        let ray = self.turn * (at.coords.push(0.0) - self.eye);
        (ray.z < 0.0).then(|| Point2::from((self.eye + ray * (-self.eye.z / ray.z)).xy()))
    }

    /// A place with a direction there, radians.
    fn direction(&self, at: &Point2<f64>, direction_rad: f64) -> Option<(Point2<f64>, f64)> {
        const STEP_M: f64 = 0.1;
        let (sin, cos) = direction_rad.sin_cos();
        let start = self.point(at)?;
        let along = self.point(&Point2::new(at.x + STEP_M * cos, at.y + STEP_M * sin))? - start;
        Some((start, along.y.atan2(along.x)))
    }
}

fn copy<T: Copy>(to: &mut Vec<T>, from: &[T]) {
    to.clear();
    to.extend_from_slice(from);
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::Mount;

    use super::*;
    use crate::vision::{Junction, JunctionKind};

    /// A camera that looks farther down than reported sees things nearer than it seems.
    #[test]
    fn things_on_the_ground_come_nearer() {
        let mount =
            |tilt_deg: f64| Mount { height_m: 0.5, tilt_rad: f64::to_radians(tilt_deg), ..Mount::default() };
        let at = |tilt_deg: f64| Point2::new(0.5 / f64::to_radians(tilt_deg).tan(), 0.0);
        let mut percept =
            Percept { robot_from_camera: mount(10.0).robot_from_camera(), ..Percept::default() };
        percept.features.junctions.push(Junction {
            kind: JunctionKind::T,
            at_in_robot: at(10.0),
            at_px: Point2::origin(),
            direction_rad: 0.0,
        });
        let mut turned = Turned::default();
        let tilt_rad = Vector3::new(-2.0_f64.to_radians(), 0.0, 0.0);
        let found = turned.turn(&percept, &tilt_rad);
        assert!((found.features.junctions[0].at_in_robot - at(12.0)).norm() < 1e-9);
        assert!(found.features.junctions[0].direction_rad.abs() < 1e-9);
        let off = found.robot_from_camera.rotation() - mount(12.0).robot_from_camera().rotation();
        assert!(off.norm() < 1e-9);
    }
}
