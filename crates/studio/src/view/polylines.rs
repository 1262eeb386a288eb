//! Lines in space, seen by a camera.

use nalgebra::Point3;
use visloc_core::geom::{Camera, CameraFrame, Rigid3, World};

/// What is nearer to the camera than this is cut off, meters.
const NEAR_M: f64 = 0.05;
/// Pieces into which lines are cut, so that a lens may bend them, meters.
const STEP_M: f64 = 0.15;
/// Lines go on so far beyond the image, pixels.
const MARGIN_PX: f64 = 40.0;

/// Draws lines of the world into an image.
pub(super) struct Projector<'a> {
    camera: &'a Camera,
    camera_from_world: Rigid3<CameraFrame, World>,
    /// x and y of all points; a pair of NaN ends a line.
    out: Vec<f64>,
}

impl<'a> Projector<'a> {
    pub fn new(camera: &'a Camera, world_from_camera: &Rigid3<World, CameraFrame>) -> Self {
        Self { camera, camera_from_world: world_from_camera.inverse(), out: Vec::new() }
    }

    /// Draws a straight line.
    pub fn line(&mut self, from: Point3<f64>, to: Point3<f64>) {
        let [mut a, mut b] = [from, to].map(|point| self.camera_from_world.transform(&point));
        if a.z < NEAR_M && b.z < NEAR_M {
            return;
        }
        let cut = |behind: Point3<f64>, ahead: Point3<f64>| {
            behind + (ahead - behind) * ((NEAR_M - behind.z) / (ahead.z - behind.z))
        };
        if a.z < NEAR_M {
            a = cut(a, b);
        } else if b.z < NEAR_M {
            b = cut(b, a);
        }
        let num_pieces = ((b - a).norm() / STEP_M).ceil().clamp(1.0, 200.0);
        let mut i = 0.0;
        while i <= num_pieces {
            self.point(&(a + (b - a) * (i / num_pieces)));
            i += 1.0;
        }
        self.end();
    }

    /// Draws lines from each point to the next one.
    pub fn path(&mut self, points: &[Point3<f64>]) {
        for pair in points.windows(2) {
            self.line(pair[0], pair[1]);
        }
    }

    fn point(&mut self, point_in_camera: &Point3<f64>) {
        let (width, height) = self.camera.size_px();
        let is_near = |value: f64, size: u32| (-MARGIN_PX..=f64::from(size) + MARGIN_PX).contains(&value);
        match self.camera.project(point_in_camera) {
            Ok(px) if is_near(px.x, width) && is_near(px.y, height) => self.out.extend([px.x, px.y]),
            _ => self.end(),
        }
    }

    fn end(&mut self) {
        if self.out.last().is_some_and(|last| !last.is_nan()) {
            self.out.extend([f64::NAN, f64::NAN]);
        }
    }

    pub fn finish(self) -> Vec<f64> {
        self.out
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::{
        PlanarPose,
        nao::{HeadAngles, NaoCamera, Torso, robot_from_camera},
    };

    use super::*;

    #[test]
    fn lines_ahead_are_seen_and_lines_behind_are_not() {
        let camera = Camera::pinhole((320, 240), (373.3, 373.3), (159.5, 119.5)).unwrap();
        let world_from_camera = PlanarPose::default().to_rigid3()
            * robot_from_camera(&Torso::upright(), &HeadAngles::default(), NaoCamera::TopV4);
        let draw = |x: f64| {
            let mut projector = Projector::new(&camera, &world_from_camera);
            projector.line(Point3::new(x, -1.0, 0.0), Point3::new(x, 1.0, 0.0));
            projector.finish()
        };
        let ahead = draw(3.0);
        assert!(ahead.len() > 6 && draw(-3.0).is_empty());
        // The line is level, below the middle.
        let rows = ahead.chunks(2).map(|px| px[1]).filter(|y| !y.is_nan());
        assert!(rows.clone().all(|y| y > 120.0 && y < 240.0));
    }
}
