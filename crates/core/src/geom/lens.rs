//! Lens models: what a lens does to the normalized image plane.

use nalgebra::{Matrix2, Point2};
use serde::{Deserialize, Serialize};

/// Lens distortion on the normalized image plane.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Distortion {
    /// None: the image is already rectified.
    #[default]
    None,
    /// Radial-tangential, the model of OpenCV and of ROS `plumb_bob`: k1, k2, p1, p2, k3. Source: Brown, "Decentering
    /// distortion of lenses", 1966; OpenCV, `calib3d` documentation.
    RadialTangential([f64; 5]),
    /// Equidistant fisheye, the model of OpenCV's `fisheye` and of ROS `equidistant`: k1, k2, k3, k4. A ray at the angle t
    /// from the axis is seen at the radius t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8). Source: Kannala and Brandt, "A generic
    /// camera model and calibration method", PAMI 2006, equation 6. All zero is a lens too: the ideal equidistant one.
    KannalaBrandt([f64; 4]),
}

/// Rays farther from the axis than this are not used, radians: points are projected through the plane z = 1.
const MAX_ANGLE_RAD: f64 = 1.56;
/// Radius below which the fisheye is as good as linear.
const TINY: f64 = 1e-9;

impl Distortion {
    /// The coefficients, in the order of the model; none for no distortion.
    pub fn coefficients(&self) -> &[f64] {
        match self {
            Self::None => &[],
            Self::RadialTangential(k) => k,
            Self::KannalaBrandt(k) => k,
        }
    }

    /// Where the lens moves a point of the normalized plane (z = 1).
    #[inline]
    pub fn distort(&self, normalized: &Point2<f64>) -> Point2<f64> {
        match self {
            Self::None => *normalized,
            Self::RadialTangential(k) => radial_tangential(k, normalized.x, normalized.y).0,
            Self::KannalaBrandt(k) => {
                let r = normalized.coords.norm();
                let factor = if r < TINY { 1.0 } else { equidistant(k, r.atan()).0 / r };
                normalized * factor
            }
        }
    }

    /// As [`Distortion::distort`], with the 2x2 Jacobian of the distorted point by the undistorted one.
    #[inline]
    pub fn distort_with_jacobian(&self, normalized: &Point2<f64>) -> (Point2<f64>, Matrix2<f64>) {
        match self {
            Self::None => (*normalized, Matrix2::identity()),
            Self::RadialTangential(k) => radial_tangential(k, normalized.x, normalized.y),
            Self::KannalaBrandt(k) => kannala_brandt(k, normalized),
        }
    }

    /// The point of the normalized plane that the lens moves here. Points beyond the range of the lens give a point at its
    /// border.
    pub fn undistort(&self, distorted: &Point2<f64>) -> Point2<f64> {
        match self {
            Self::None => *distorted,
            Self::RadialTangential(k) => undistort_radial_tangential(k, distorted),
            Self::KannalaBrandt(k) => undistort_kannala_brandt(k, distorted),
        }
    }

    /// Radius on the normalized plane up to which a larger radius is seen at a larger one; infinite if there is no end.
    pub fn max_radius(&self) -> f64 {
        match self {
            Self::None => f64::INFINITY,
            Self::RadialTangential([k1, k2, _, _, k3]) => (0..1000)
                .map(|step| f64::from(step) * 0.01)
                .find(|r| {
                    let r2 = r * r;
                    1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) <= 0.0
                })
                .unwrap_or(f64::INFINITY),
            Self::KannalaBrandt(k) => max_angle_rad(k).tan(),
        }
    }
}

/// Distorted point and its 2x2 Jacobian by the undistorted one.
fn radial_tangential(k: &[f64; 5], x: f64, y: f64) -> (Point2<f64>, Matrix2<f64>) {
    let [k1, k2, p1, p2, k3] = *k;
    let r2 = x * x + y * y;
    let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    let radial_by_r2 = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
    let point = Point2::new(
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    );
    let cross = 2.0 * x * y * radial_by_r2 + 2.0 * p1 * x + 2.0 * p2 * y;
    let jacobian = Matrix2::new(
        radial + 2.0 * x * x * radial_by_r2 + 2.0 * p1 * y + 6.0 * p2 * x,
        cross,
        cross,
        radial + 2.0 * y * y * radial_by_r2 + 6.0 * p1 * y + 2.0 * p2 * x,
    );
    (point, jacobian)
}

/// Newton's method on the distortion, from the distorted point. Converges in 3 to 5 steps for real lenses.
fn undistort_radial_tangential(k: &[f64; 5], distorted: &Point2<f64>) -> Point2<f64> {
    let mut point = *distorted;
    for _ in 0..20 {
        let (image, jacobian) = radial_tangential(k, point.x, point.y);
        let Some(inverse) = jacobian.try_inverse() else { break };
        let step = inverse * (distorted - image);
        point += step;
        if step.norm_squared() < 1e-24 {
            break;
        }
    }
    point
}

/// Radius at which the fisheye sees an angle, and its derivative by the angle.
#[inline]
fn equidistant(k: &[f64; 4], angle_rad: f64) -> (f64, f64) {
    let [k1, k2, k3, k4] = *k;
    let t2 = angle_rad * angle_rad;
    let radius = angle_rad * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
    let slope = 1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4)));
    (radius, slope)
}

fn kannala_brandt(k: &[f64; 4], normalized: &Point2<f64>) -> (Point2<f64>, Matrix2<f64>) {
    let r = normalized.coords.norm();
    if r < TINY {
        return (*normalized, Matrix2::identity());
    }
    let (radius, slope) = equidistant(k, r.atan());
    let factor = radius / r;
    let radius_by_r = slope / (1.0 + r * r);
    // factor I + (d factor / d r) p p^T / r, and d factor / d r = (radius_by_r - factor) / r
    let outer = normalized.coords * normalized.coords.transpose();
    let jacobian = Matrix2::identity() * factor + outer * ((radius_by_r - factor) / (r * r));
    (normalized * factor, jacobian)
}

/// Largest angle up to which the radius grows.
fn max_angle_rad(k: &[f64; 4]) -> f64 {
    let angles = (0..=156).map(|step| f64::from(step) * 0.01);
    angles.take_while(|angle| equidistant(k, *angle).1 > 0.0).last().unwrap_or(0.0).min(MAX_ANGLE_RAD)
}

/// Newton's method on the angle, kept in the range where the radius grows.
fn undistort_kannala_brandt(k: &[f64; 4], distorted: &Point2<f64>) -> Point2<f64> {
    let radius = distorted.coords.norm();
    if radius < TINY {
        return *distorted;
    }
    // Looked for only if the first guess does not lead to the angle: the search costs more than the rest.
    let mut angle = radius.min(MAX_ANGLE_RAD);
    for _ in 0..20 {
        let (found, slope) = equidistant(k, angle);
        let step = (radius - found) / slope;
        angle += step;
        if step.abs() < 1e-13 || !step.is_finite() {
            break;
        }
    }
    let is_found = (0.0..=MAX_ANGLE_RAD).contains(&angle) && (equidistant(k, angle).0 - radius).abs() < 1e-9;
    if !is_found {
        angle = bisect(k, radius);
    }
    distorted * (angle.tan() / radius)
}

/// The angle that is seen at a radius, or the border of the range, by halving.
fn bisect(k: &[f64; 4], radius: f64) -> f64 {
    let (mut low, mut high) = (0.0, max_angle_rad(k));
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if equidistant(k, middle).0 < radius { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const LENSES: [Distortion; 5] = [
        Distortion::None,
        Distortion::RadialTangential([-0.28, 0.08, 1e-3, -5e-4, 0.0]),
        Distortion::KannalaBrandt([0.0; 4]),
        Distortion::KannalaBrandt([-0.03, 0.004, -0.003, 4e-4]),
        Distortion::KannalaBrandt([0.05, -0.02, 0.005, -1e-3]),
    ];

    proptest! {
        #[test]
        fn undistort_undoes(x in -0.6..0.6f64, y in -0.5..0.5f64) {
            for lens in LENSES {
                let p = Point2::new(x, y);
                prop_assert!((lens.undistort(&lens.distort(&p)) - p).norm() < 1e-9, "{lens:?} {p}");
            }
        }

        #[test]
        fn jacobian_equals_numeric(x in -2.0..2.0f64, y in -1.5..1.5f64) {
            for lens in LENSES {
                let p = Point2::new(x, y);
                let (image, jacobian) = lens.distort_with_jacobian(&p);
                prop_assert!((image - lens.distort(&p)).norm() < 1e-12);
                for axis in 0..2 {
                    let (mut ahead, mut behind) = (p, p);
                    ahead[axis] += 1e-6;
                    behind[axis] -= 1e-6;
                    let numeric = (lens.distort(&ahead) - lens.distort(&behind)) / 2e-6;
                    prop_assert!((numeric - jacobian.column(axis)).norm() < 1e-6 * (1.0 + jacobian.norm()));
                }
            }
        }
    }

    #[test]
    fn fisheye_sees_far_to_the_side() {
        // OpenCV: cv2.fisheye.distortPoints([[4, 3]], K = I, D = (0.1, 0.01, 0.001, 0.0001))
        let lens = Distortion::KannalaBrandt([0.1, 0.01, 1e-3, 1e-4]);
        let seen = lens.distort(&Point2::new(4.0, 3.0));
        let angle = 5.0_f64.atan();
        let a2 = angle * angle;
        let radius = angle * (1.0 + 0.1 * a2 + 0.01 * a2.powi(2) + 1e-3 * a2.powi(3) + 1e-4 * a2.powi(4));
        assert!((seen - Point2::new(0.8 * radius, 0.6 * radius)).norm() < 1e-12);
        assert!((lens.undistort(&seen) - Point2::new(4.0, 3.0)).norm() < 1e-8);
    }

    #[test]
    fn beyond_the_range_is_the_border() {
        let lens = Distortion::KannalaBrandt([-0.2, 0.0, 0.0, 0.0]);
        let limit = lens.max_radius();
        assert!(limit < 4.0);
        let border = lens.undistort(&Point2::new(5.0, 0.0));
        assert!(border.x <= limit + 1e-9 && border.x > 0.9 * limit, "{border}");
    }
}
