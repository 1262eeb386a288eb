//! Small motions of a camera: the exponential map of SE(3).
//!
//! A twist is `[v; w]`: translation first, rotation (radians) after it. Source: Blanco, "A tutorial on SE(3)
//! transformation parameterizations and on-manifold optimization", 2010, section 9.

use nalgebra::{Matrix2x3, Matrix2x6, Matrix3, Matrix6, Rotation3, Vector3, Vector6};
pub use visloc_core::geom::rotation_vector;
use visloc_core::geom::{CameraFrame, Rigid3, World, renormalized};

/// Where a camera is: takes points of the world to the camera.
pub type CameraFromWorld = Rigid3<CameraFrame, World>;

/// The matrix of the cross product with `v`.
#[inline]
#[must_use]
pub fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// The motion of a twist.
#[must_use]
pub fn exp<F>(twist: &Vector6<f64>) -> Rigid3<F, F> {
    let v = Vector3::new(twist[0], twist[1], twist[2]);
    let w = Vector3::new(twist[3], twist[4], twist[5]);
    let angle = w.norm();
    let (a, b) = if angle < 1e-6 {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / angle.powi(3))
    };
    let k = skew(&w);
    let left_jacobian = Matrix3::identity() + k * a + k * k * b;
    Rigid3::new(Rotation3::from_scaled_axis(w), left_jacobian * v)
}

/// The twist of a motion; the inverse of [`exp`] for rotations below pi.
#[must_use]
pub fn log<A, B>(motion: &Rigid3<A, B>) -> Vector6<f64> {
    let w = rotation_vector(motion.rotation());
    let angle = w.norm();
    let c = if angle < 1e-6 {
        1.0 / 12.0
    } else {
        (1.0 - 0.5 * angle * (1.0 + angle.cos()) / angle.sin()) / (angle * angle)
    };
    let k = skew(&w);
    let v = (Matrix3::identity() - k * 0.5 + k * k * c) * motion.translation();
    Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
}

/// `exp(twist) * pose`, with the rotation made orthonormal again.
#[must_use]
pub fn moved<A, B>(twist: &Vector6<f64>, pose: &Rigid3<A, B>) -> Rigid3<A, B> {
    let product = exp::<A>(twist) * *pose;
    let rotation = renormalized(Rotation3::from_matrix_unchecked(*product.rotation()));
    Rigid3::new(rotation, *product.translation())
}

/// Takes a twist of the source frame of a motion to its destination: `motion * exp(twist) = exp(adjoint * twist) * motion`.
#[must_use]
pub fn adjoint<A, B>(motion: &Rigid3<A, B>) -> Matrix6<f64> {
    let mut adjoint = Matrix6::zeros();
    adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(motion.rotation());
    adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(motion.rotation());
    adjoint.fixed_view_mut::<3, 3>(0, 3).copy_from(&(skew(motion.translation()) * motion.rotation()));
    adjoint
}

/// Jacobian of a camera point's image by a twist applied from the left, given the Jacobian of the image by the point.
#[inline]
#[must_use]
pub fn image_by_twist(image_by_point: &Matrix2x3<f64>, point_in_camera: &Vector3<f64>) -> Matrix2x6<f64> {
    let mut jacobian = Matrix2x6::zeros();
    jacobian.fixed_view_mut::<2, 3>(0, 0).copy_from(image_by_point);
    jacobian.fixed_view_mut::<2, 3>(0, 3).copy_from(&(-image_by_point * skew(point_in_camera)));
    jacobian
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use proptest::prelude::*;
    use visloc_core::geom::Camera;

    use super::*;

    proptest! {
        #[test]
        fn log_undoes_exp(v in prop::array::uniform3(-2.0..2.0f64), w in prop::array::uniform3(-1.7..1.7f64)) {
            let twist = Vector6::new(v[0], v[1], v[2], w[0], w[1], w[2]);
            prop_assert!((log(&exp::<World>(&twist)) - twist).norm() < 1e-9);
            let small = twist * 1e-7;
            prop_assert!((log(&exp::<World>(&small)) - small).norm() < 1e-13);
        }

        #[test]
        fn a_twist_from_behind_is_one_in_front(v in prop::array::uniform6(-1.0..1.0f64), w in prop::array::uniform6(-1.0..1.0f64)) {
            let (motion, twist) = (exp::<World>(&Vector6::from(v)), Vector6::from(w));
            let behind = motion * exp::<World>(&twist);
            let in_front = exp::<World>(&(adjoint(&motion) * twist)) * motion;
            prop_assert!((behind.rotation() - in_front.rotation()).norm() < 1e-9);
            prop_assert!((behind.translation() - in_front.translation()).norm() < 1e-9);
        }

        #[test]
        fn twist_jacobian_is_the_numeric_one(p in prop::array::uniform3(-0.6..0.6f64)) {
            let camera = Camera::pinhole((640, 480), (500.0, 510.0), (320.0, 240.0)).unwrap();
            let point = Point3::new(p[0], p[1], p[2] + 2.0);
            let (_, by_point) = camera.project_with_jacobian(&point).unwrap();
            let analytic = image_by_twist(&by_point, &point.coords);
            for i in 0..6 {
                let mut step = Vector6::zeros();
                step[i] = 1e-6;
                let plus = camera.project(&exp::<CameraFrame>(&step).transform(&point)).unwrap();
                let minus = camera.project(&exp::<CameraFrame>(&-step).transform(&point)).unwrap();
                let numeric = (plus - minus) / 2e-6;
                prop_assert!((numeric - analytic.column(i)).norm() < 1e-4);
            }
        }
    }
}
