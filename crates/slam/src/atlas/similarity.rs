//! Similarity transforms between maps.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use crate::lie::CameraFromWorld;

/// Takes points of one map to another: turned, enlarged, moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Factor on lengths; above 0.
    pub scale: f64,
    /// Rotation.
    pub rotation: Matrix3<f64>,
    /// Where the origin goes to.
    pub translation: Vector3<f64>,
}

impl Similarity {
    /// From the pose of one camera in both maps, and the factor on lengths from the first map to the second.
    #[must_use]
    pub fn between(first: &CameraFromWorld, second: &CameraFromWorld, scale: f64) -> Self {
        let rotation = second.rotation().transpose() * first.rotation();
        let translation =
            second.rotation().transpose() * (first.translation() * scale - second.translation());
        Self { scale, rotation, translation }
    }

    /// A point in the other map.
    #[must_use]
    pub fn point(&self, point: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * point.coords * self.scale + self.translation)
    }

    /// The pose of a camera in the other map.
    #[must_use]
    pub fn pose(&self, camera_from_world: &CameraFromWorld) -> CameraFromWorld {
        let mut rotation =
            Rotation3::from_matrix_unchecked(camera_from_world.rotation() * self.rotation.transpose());
        rotation.renormalize();
        let translation = camera_from_world.translation() * self.scale - rotation * self.translation;
        CameraFromWorld::new(rotation, translation)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector6;

    use super::*;
    use crate::lie::exp;

    #[test]
    fn cameras_see_the_same_directions_in_both_maps() {
        let first: CameraFromWorld =
            exp(&Vector6::new(0.3, -1.0, 0.4, 0.2, 0.5, -0.1)) * CameraFromWorld::identity();
        let second: CameraFromWorld =
            exp(&Vector6::new(-2.0, 0.5, 1.0, -0.7, 0.1, 0.3)) * CameraFromWorld::identity();
        let similarity = Similarity::between(&first, &second, 2.5);
        let there = similarity.pose(&first);
        assert!((there.rotation() - second.rotation()).norm() < 1e-12);
        assert!((there.translation() - second.translation()).norm() < 1e-12);
        let other: CameraFromWorld =
            exp(&Vector6::new(0.1, 0.2, -0.3, 0.4, -0.5, 0.6)) * CameraFromWorld::identity();
        let point = Point3::new(1.0, 2.0, 3.0);
        let seen = other.transform(&point).coords * 2.5;
        let seen_there = similarity.pose(&other).transform(&similarity.point(&point)).coords;
        assert!((seen - seen_there).norm() < 1e-12);
    }
}
