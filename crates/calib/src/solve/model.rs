//! The camera as a vector of parameters.

use nalgebra::{Matrix2, Matrix2x3, Point2, SMatrix, SVector, Vector2, Vector3};
use visloc_core::geom::{Camera, CameraError, Distortion};

/// Which lens is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LensModel {
    /// Radial-tangential with k1, k2, p1, p2, k3: ordinary lenses.
    RadialTangential,
    /// Radial-tangential without k3: what Kalibr calls radtan, and what few pictures can tell.
    RadialTangential4,
    /// Equidistant fisheye with k1 to k4: wide lenses.
    KannalaBrandt,
}

/// Length of the vector: fx, fy, cx, cy and up to five coefficients.
pub const NUM_INTRINSICS: usize = 9;

/// Focal lengths, principal point (pixels) and coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Which lens.
    pub model: LensModel,
    /// fx, fy, cx, cy and the coefficients; the last stays 0 for the fisheye.
    pub values: SVector<f64, NUM_INTRINSICS>,
}

/// A pixel with its derivatives.
pub(super) struct Projected {
    pub px: Vector2<f64>,
    pub by_point: Matrix2x3<f64>,
    pub by_intrinsics: SMatrix<f64, 2, NUM_INTRINSICS>,
}

impl Intrinsics {
    /// A camera without distortion; a fisheye's is ideal.
    pub fn ideal(model: LensModel, focal_px: (f64, f64), center_px: (f64, f64)) -> Self {
        let mut values = SVector::zeros();
        for (i, value) in [focal_px.0, focal_px.1, center_px.0, center_px.1].into_iter().enumerate() {
            values[i] = value;
        }
        Self { model, values }
    }

    /// The lens.
    pub fn distortion(&self) -> Distortion {
        let v = &self.values;
        match self.model {
            LensModel::RadialTangential | LensModel::RadialTangential4 => {
                Distortion::RadialTangential([v[4], v[5], v[6], v[7], v[8]])
            }
            LensModel::KannalaBrandt => Distortion::KannalaBrandt([v[4], v[5], v[6], v[7]]),
        }
    }

    /// How many of the values are parameters.
    pub fn num_parameters(&self) -> usize {
        match self.model {
            LensModel::RadialTangential => 9,
            LensModel::RadialTangential4 | LensModel::KannalaBrandt => 8,
        }
    }

    /// The camera for images of a size.
    ///
    /// # Errors
    /// If no camera has these values.
    pub fn camera(&self, size_px: (u32, u32)) -> Result<Camera, CameraError> {
        let v = &self.values;
        Camera::new(size_px, (v[0], v[1]), (v[2], v[3]), self.distortion())
    }

    /// Pixel of a point in front of the camera; `None` behind it. Asks for no range of the lens: the refinement may pass
    /// through lenses that fold.
    pub(super) fn project(&self, p: &Vector3<f64>) -> Option<Vector2<f64>> {
        if p.z <= 1e-6 {
            return None;
        }
        let d = self.distortion().distort(&Point2::new(p.x / p.z, p.y / p.z));
        let v = &self.values;
        Some(Vector2::new(v[0] * d.x + v[2], v[1] * d.y + v[3]))
    }

    /// As [`Intrinsics::project`], with derivatives.
    pub(super) fn linearize(&self, p: &Vector3<f64>) -> Option<Projected> {
        if p.z <= 1e-6 {
            return None;
        }
        let inv_z = 1.0 / p.z;
        let n = Point2::new(p.x * inv_z, p.y * inv_z);
        let (d, by_normalized) = self.distortion().distort_with_jacobian(&n);
        let v = &self.values;
        let focal = Matrix2::new(v[0], 0.0, 0.0, v[1]);
        let normalized_by_point = Matrix2x3::new(inv_z, 0.0, -n.x * inv_z, 0.0, inv_z, -n.y * inv_z);
        let mut by_intrinsics = SMatrix::<f64, 2, NUM_INTRINSICS>::zeros();
        by_intrinsics[(0, 0)] = d.x;
        by_intrinsics[(1, 1)] = d.y;
        by_intrinsics[(0, 2)] = 1.0;
        by_intrinsics[(1, 3)] = 1.0;
        by_intrinsics.fixed_view_mut::<2, 5>(0, 4).copy_from(&(focal * self.by_coefficients(&n)));
        if self.num_parameters() < NUM_INTRINSICS {
            by_intrinsics.column_mut(NUM_INTRINSICS - 1).fill(0.0);
        }
        Some(Projected {
            px: Vector2::new(v[0] * d.x + v[2], v[1] * d.y + v[3]),
            by_point: focal * by_normalized * normalized_by_point,
            by_intrinsics,
        })
    }

    /// Derivative of the distorted point by the coefficients; both models are linear in them.
    fn by_coefficients(&self, n: &Point2<f64>) -> SMatrix<f64, 2, 5> {
        let (x, y) = (n.x, n.y);
        let r2 = x * x + y * y;
        match self.model {
            LensModel::RadialTangential | LensModel::RadialTangential4 => {
                let (r4, r6) = (r2 * r2, r2 * r2 * r2);
                SMatrix::<f64, 2, 5>::from_row_slice(&[
                    x * r2,
                    x * r4,
                    2.0 * x * y,
                    r2 + 2.0 * x * x,
                    x * r6,
                    y * r2,
                    y * r4,
                    r2 + 2.0 * y * y,
                    2.0 * x * y,
                    y * r6,
                ])
            }
            LensModel::KannalaBrandt => {
                let r = r2.sqrt().max(1e-12);
                let angle = r.atan();
                let mut power = angle;
                let mut columns = SMatrix::<f64, 2, 5>::zeros();
                for i in 0..4 {
                    power *= angle * angle;
                    columns[(0, i)] = x / r * power;
                    columns[(1, i)] = y / r * power;
                }
                columns
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jacobians_equal_numeric() {
        for model in [LensModel::RadialTangential, LensModel::RadialTangential4, LensModel::KannalaBrandt] {
            let mut camera = Intrinsics::ideal(model, (400.0, 410.0), (320.0, 230.0));
            for (i, k) in
                [-0.1, 0.03, 0.002, -0.003, 0.01].into_iter().take(camera.num_parameters() - 4).enumerate()
            {
                camera.values[4 + i] = k;
            }
            for p in
                [Vector3::new(0.3, -0.2, 0.9), Vector3::new(-0.9, 0.8, 1.1), Vector3::new(0.01, 0.0, 2.0)]
            {
                let l = camera.linearize(&p).unwrap();
                assert!((l.px - camera.project(&p).unwrap()).norm() < 1e-9);
                for i in 0..camera.num_parameters() {
                    let shifted = |step: f64| {
                        let mut other = camera;
                        other.values[i] += step;
                        other.project(&p).unwrap()
                    };
                    let numeric = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
                    assert!((numeric - l.by_intrinsics.column(i)).norm() < 1e-5, "{model:?} {i}");
                }
                for i in 0..3 {
                    let shifted = |step: f64| {
                        let mut other = p;
                        other[i] += step;
                        camera.project(&other).unwrap()
                    };
                    let numeric = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
                    assert!((numeric - l.by_point.column(i)).norm() < 1e-4, "{model:?} {i}");
                }
            }
        }
    }
}
