//! Rigid transforms in space, typed by their frames.

use std::{fmt, marker::PhantomData, ops::Mul};

use nalgebra::{Matrix3, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use crate::geom::PlanarPose;

/// Rigid transform that takes points of frame `Src` to frame `Dst`; named `dst_from_src`.
///
/// ```
/// use visloc_core::geom::{CameraFrame, PlanarPose, Rigid3, Robot};
/// let robot_from_camera = Rigid3::<Robot, CameraFrame>::identity();
/// let world_from_camera = PlanarPose::new(1.0, 0.0, 0.0).to_rigid3() * robot_from_camera;
/// assert_eq!(world_from_camera.translation().x, 1.0);
/// ```
pub struct Rigid3<Dst, Src> {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    frames: PhantomData<fn() -> (Dst, Src)>,
}

impl<Dst, Src> Rigid3<Dst, Src> {
    /// The transform between two frames that coincide.
    pub fn identity() -> Self {
        Self::from_matrix_unchecked(Matrix3::identity(), Vector3::zeros())
    }

    /// From a rotation and the origin of `Src` in `Dst`, meters.
    pub fn new(rotation: Rotation3<f64>, translation: Vector3<f64>) -> Self {
        Self::from_matrix_unchecked(rotation.into_inner(), translation)
    }

    /// From a quaternion (x, y, z, w) and a translation in meters, as ROS and TUM files write them.
    /// `None` if a value is not finite or the quaternion has no length.
    pub fn from_quaternion(xyzw: [f64; 4], translation: [f64; 3]) -> Option<Self> {
        let [x, y, z, w] = xyzw;
        let quaternion = Quaternion::new(w, x, y, z);
        let is_usable = quaternion.norm() > 1e-6 && quaternion.norm().is_finite();
        if !is_usable || translation.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix();
        Some(Self::new(rotation, Vector3::from(translation)))
    }

    /// From a matrix that the caller knows to be a rotation.
    pub(crate) fn from_matrix_unchecked(rotation: Matrix3<f64>, translation: Vector3<f64>) -> Self {
        Self { rotation, translation, frames: PhantomData }
    }

    /// `dst_from_src.inverse()` is `src_from_dst`.
    pub fn inverse(&self) -> Rigid3<Src, Dst> {
        let rotation = self.rotation.transpose();
        Rigid3::from_matrix_unchecked(rotation, -(rotation * self.translation))
    }

    /// Takes a point of `Src` to `Dst`.
    #[inline]
    pub fn transform(&self, point_in_src: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * point_in_src.coords + self.translation)
    }

    /// Takes a direction of `Src` to `Dst`.
    #[inline]
    pub fn rotate(&self, direction_in_src: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * direction_in_src
    }

    /// Rotation as a matrix.
    #[inline]
    pub fn rotation(&self) -> &Matrix3<f64> {
        &self.rotation
    }

    /// Origin of `Src` in `Dst`, meters.
    #[inline]
    pub fn translation(&self) -> &Vector3<f64> {
        &self.translation
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.rotation.iter().chain(&self.translation).all(|value| value.is_finite())
    }

    /// Rotation as a quaternion (x, y, z, w); of one that is not finite no value is a number.
    pub fn quaternion_xyzw(&self) -> [f64; 4] {
        // There is no rotation that is near.
        if !self.rotation.iter().all(|value| value.is_finite()) {
            return [f64::NAN; 4];
        }
        let q = UnitQuaternion::from_rotation_matrix(&nearest_rotation(&self.rotation));
        [q.i, q.j, q.k, q.w]
    }

    /// Position and heading in the ground plane of `Dst`, for transforms whose `Src` stands upright.
    pub fn to_planar(&self) -> PlanarPose {
        let yaw_rad = self.rotation[(1, 0)].atan2(self.rotation[(0, 0)]);
        PlanarPose::new(self.translation.x, self.translation.y, yaw_rad)
    }

    /// Angle of the rotation, radians in [0, pi].
    pub fn rotation_angle_rad(&self) -> f64 {
        ((self.rotation.trace() - 1.0) / 2.0).clamp(-1.0, 1.0).acos()
    }
}

impl<A, B, C> Mul<Rigid3<B, C>> for Rigid3<A, B> {
    type Output = Rigid3<A, C>;

    fn mul(self, b_from_c: Rigid3<B, C>) -> Rigid3<A, C> {
        Rigid3::from_matrix_unchecked(
            self.rotation * b_from_c.rotation,
            self.rotation * b_from_c.translation + self.translation,
        )
    }
}

// Derives would demand the same of the frame types.
impl<Dst, Src> Default for Rigid3<Dst, Src> {
    /// The identity.
    fn default() -> Self {
        Self::identity()
    }
}
impl<Dst, Src> Clone for Rigid3<Dst, Src> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<Dst, Src> Copy for Rigid3<Dst, Src> {}
impl<Dst, Src> PartialEq for Rigid3<Dst, Src> {
    fn eq(&self, other: &Self) -> bool {
        self.rotation == other.rotation && self.translation == other.translation
    }
}
impl<Dst, Src> fmt::Debug for Rigid3<Dst, Src> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let t = &self.translation;
        write!(f, "Rigid3({:.4} {:.4} {:.4} m, xyzw {:.5?})", t.x, t.y, t.z, self.quaternion_xyzw())
    }
}

/// The rotation nearest to a matrix.
#[must_use]
pub fn nearest_rotation(matrix: &Matrix3<f64>) -> Rotation3<f64> {
    nearest_rotation_from(Rotation3::identity(), matrix)
}

/// A product of many rotations made orthonormal again, what rounding has taken from it.
#[must_use]
pub fn renormalized(rotation: Rotation3<f64>) -> Rotation3<f64> {
    let mut near = UnitQuaternion::from_rotation_matrix(&rotation);
    near.renormalize();
    nearest_rotation_from(near.to_rotation_matrix(), rotation.matrix())
}

/// The search of `Rotation3::from_matrix` does not end for numbers that are not finite, and not for some matrices of large numbers: whether it
/// has arrived is lost in rounding, and it turns away by 1e-8 and comes back. Where it ends, it has ended long before this.
fn nearest_rotation_from(near: Rotation3<f64>, matrix: &Matrix3<f64>) -> Rotation3<f64> {
    const MOST_TURNS: usize = 100_000;
    if !matrix.iter().all(|value| value.is_finite()) {
        return Rotation3::from_matrix_unchecked(Matrix3::repeat(f64::NAN));
    }
    Rotation3::from_matrix_eps(matrix, f64::EPSILON, MOST_TURNS, near)
}

/// Axis times angle of a rotation below pi. From the antisymmetric part, because the trace alone cannot tell small angles.
pub fn rotation_vector(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let r = rotation;
    let axis = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]) * 0.5;
    let sine = axis.norm();
    let angle = sine.atan2(0.5 * (r.trace() - 1.0));
    if sine < 1e-9 { axis } else { axis * (angle / sine) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geom::{CameraFrame, Robot, World};

    fn rigid<A, B>() -> impl Strategy<Value = Rigid3<A, B>> {
        (prop::array::uniform3(-3.0..3.0f64), prop::array::uniform3(-5.0..5.0f64))
            .prop_map(|(w, t)| Rigid3::new(Rotation3::from_scaled_axis(Vector3::from(w)), Vector3::from(t)))
    }

    proptest! {
        #[test]
        fn inverse_undoes(a in rigid::<World, Robot>(), p in prop::array::uniform3(-5.0..5.0f64)) {
            let p = Point3::from(p);
            prop_assert!((a.inverse().transform(&a.transform(&p)) - p).norm() < 1e-9);
        }

        #[test]
        fn product_applies_right_first(a in rigid::<World, Robot>(), b in rigid::<Robot, CameraFrame>(),
                                       p in prop::array::uniform3(-5.0..5.0f64)) {
            let p = Point3::from(p);
            prop_assert!(((a * b).transform(&p) - a.transform(&b.transform(&p))).norm() < 1e-9);
        }

        #[test]
        fn quaternion_round_trip(a in rigid::<World, Robot>()) {
            let t = a.translation();
            let b = Rigid3::<World, Robot>::from_quaternion(a.quaternion_xyzw(), [t.x, t.y, t.z]).unwrap();
            prop_assert!((a.rotation() - b.rotation()).norm() < 1e-9);
        }
    }

    #[test]
    fn the_search_for_the_nearest_rotation_ends() {
        // A sum of products of rays.
        let wide = Matrix3::new(
            53.444_856_005_197_67,
            -6.359_644_506_215_447,
            -2.796_937_224_828_926_4,
            -5.538_682_278_740_429_5,
            53.464_364_213_857_82,
            -7.557_962_542_819_85,
            5.516_833_380_962_133,
            -1.713_625_250_245_348_4,
            92.698_547_317_019_12,
        );
        let found = nearest_rotation(&wide);
        assert!((found.matrix().transpose() * found.matrix() - Matrix3::identity()).norm() < 1e-9);
        // Nearest: what is left is symmetric.
        let left = found.matrix().transpose() * wide;
        assert!((left - left.transpose()).norm() < 1e-5, "{left}");
        let unturned = Rotation3::from_matrix_unchecked(Matrix3::repeat(f64::INFINITY));
        assert!(renormalized(unturned).matrix().iter().all(|value| value.is_nan()));
        let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -2.0, 0.4));
        let drifted = Rotation3::from_matrix_unchecked(turn.matrix() * (1.0 + 1e-9));
        assert!((renormalized(drifted).matrix() - turn.matrix()).norm() < 1e-12);
    }

    #[test]
    fn what_is_not_finite_says_so_and_can_be_printed() {
        let turned = |angle| Rotation3::from_axis_angle(&Vector3::y_axis(), angle);
        assert!(Rigid3::<World, Robot>::new(turned(0.3), Vector3::zeros()).is_finite());
        let nowhere = Rigid3::<World, Robot>::new(turned(0.3), Vector3::new(0.0, f64::INFINITY, 0.0));
        assert!(!nowhere.is_finite() && nowhere.quaternion_xyzw()[1].is_finite());
        let unturned = Rigid3::<World, Robot>::new(turned(f64::NAN), Vector3::zeros());
        assert!(!unturned.is_finite() && format!("{unturned:?}").contains("NaN"));
    }

    #[test]
    fn bad_quaternions_are_refused() {
        assert!(Rigid3::<World, Robot>::from_quaternion([0.0; 4], [0.0; 3]).is_none());
        assert!(Rigid3::<World, Robot>::from_quaternion([f64::NAN, 0.0, 0.0, 1.0], [0.0; 3]).is_none());
        assert!(
            Rigid3::<World, Robot>::from_quaternion([0.0, 0.0, 0.0, 1.0], [f64::NAN, 0.0, 0.0]).is_none()
        );
    }
}
