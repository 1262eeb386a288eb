//! Similarity transforms.

use nalgebra::{Matrix3, Point3, Rotation3, SVector, Vector3};

use super::{CameraFrame, Rigid3, World, renormalized, rotation_vector};

type CameraFromWorld = Rigid3<CameraFrame, World>;

/// Turns, enlarges and moves points, `scale * rotation * p + translation`: takes them from one map to another, from an estimate to the truth,
/// or from a map to a camera with a unit of length of its own.
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
    /// Leaves everything where it is.
    pub fn identity() -> Self {
        Self { scale: 1.0, rotation: Matrix3::identity(), translation: Vector3::zeros() }
    }

    /// Of a camera with the unit of length of its map.
    pub fn of_pose<F>(pose: &Rigid3<CameraFrame, F>) -> Self {
        Self { scale: 1.0, rotation: *pose.rotation(), translation: *pose.translation() }
    }

    /// From the pose of one camera in two maps, and the factor on lengths from the first map to the second.
    pub fn between(first: &CameraFromWorld, second: &CameraFromWorld, scale: f64) -> Self {
        let first = Self::of_pose(first).enlarged(scale);
        Self::of_pose(second).inverse().after(&first)
    }

    /// The same with all lengths that come out times a factor.
    pub fn enlarged(&self, factor: f64) -> Self {
        Self { scale: self.scale * factor, rotation: self.rotation, translation: self.translation * factor }
    }

    /// The way back.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { scale: 1.0 / self.scale, rotation, translation: -(rotation * self.translation) / self.scale }
    }

    /// First the other one, then this one.
    pub fn after(&self, first: &Self) -> Self {
        Self {
            scale: self.scale * first.scale,
            rotation: self.rotation * first.rotation,
            translation: self.rotation * first.translation * self.scale + self.translation,
        }
    }

    /// A point after it.
    pub fn point(&self, point: &Point3<f64>) -> Point3<f64> {
        self.place(&point.coords)
    }

    /// The same for a point that is given by its coordinates.
    pub fn place(&self, coordinates: &Vector3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * coordinates * self.scale + self.translation)
    }

    /// The pose in the other map of a camera of the first.
    pub fn pose(&self, camera_from_world: &CameraFromWorld) -> CameraFromWorld {
        Self::of_pose(camera_from_world).after(&self.inverse()).to_pose()
    }

    /// The pose of a camera that this takes points of a map to, whatever its unit of length.
    pub fn to_pose(&self) -> CameraFromWorld {
        let rotation = renormalized(Rotation3::from_matrix_unchecked(self.rotation));
        CameraFromWorld::new(rotation, self.translation / self.scale)
    }

    /// Rotation vector, translation over a length, and logarithm of the scale: all zero for the identity.
    pub fn coordinates(&self, length: f64) -> SVector<f64, 7> {
        let turn = rotation_vector(&self.rotation);
        let shift = self.translation / length;
        SVector::<f64, 7>::from_column_slice(&[
            turn.x,
            turn.y,
            turn.z,
            shift.x,
            shift.y,
            shift.z,
            self.scale.ln(),
        ])
    }

    /// The inverse of [`Similarity::coordinates`].
    pub fn from_coordinates(coordinates: &SVector<f64, 7>, length: f64) -> Self {
        let c = coordinates;
        Self {
            scale: c[6].exp(),
            rotation: Rotation3::from_scaled_axis(Vector3::new(c[0], c[1], c[2])).into_inner(),
            translation: Vector3::new(c[3], c[4], c[5]) * length,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose([x, y, z, turn @ ..]: [f64; 6]) -> CameraFromWorld {
        Rigid3::new(Rotation3::from_scaled_axis(Vector3::from(turn)), Vector3::new(x, y, z))
    }

    #[test]
    fn cameras_see_the_same_directions_in_both_maps() {
        let (first, second) =
            (pose([0.3, -1.0, 0.4, 0.2, 0.5, -0.1]), pose([-2.0, 0.5, 1.0, -0.7, 0.1, 0.3]));
        let similarity = Similarity::between(&first, &second, 2.5);
        let there = similarity.pose(&first);
        assert!((there.rotation() - second.rotation()).norm() < 1e-12);
        assert!((there.translation() - second.translation()).norm() < 1e-12);
        let other = pose([0.1, 0.2, -0.3, 0.4, -0.5, 0.6]);
        let point = Point3::new(1.0, 2.0, 3.0);
        let seen = other.transform(&point).coords * 2.5;
        let seen_there = similarity.pose(&other).transform(&similarity.point(&point)).coords;
        assert!((seen - seen_there).norm() < 1e-12);
    }

    #[test]
    fn coordinates_and_the_way_back() {
        let coordinates = SVector::<f64, 7>::from_column_slice(&[0.1, -0.2, 0.3, 1.0, 2.0, -3.0, 0.4]);
        let similarity = Similarity::from_coordinates(&coordinates, 2.0);
        assert!((similarity.coordinates(2.0) - coordinates).norm() < 1e-12);
        let none = similarity.inverse().after(&similarity);
        assert!(none.coordinates(1.0).norm() < 1e-12);
    }
}
