//! Planes and their intersection with rays.

use nalgebra::{Point3, Vector3};

/// The plane of all points p with `normal . p = offset_m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: Vector3<f64>,
    /// Signed distance of the plane from the origin along the normal, meters.
    pub offset_m: f64,
}

impl Plane {
    /// The floor, z = 0.
    pub fn ground() -> Self {
        Self { normal: Vector3::z(), offset_m: 0.0 }
    }

    /// Where the ray `origin + s * direction` with s > 0 meets the plane; `None` if it runs parallel or away.
    #[inline]
    pub fn intersect_ray(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<Point3<f64>> {
        let approach = self.normal.dot(direction);
        let s = (self.offset_m - self.normal.dot(&origin.coords)) / approach;
        (s > 0.0 && s.is_finite()).then(|| origin + direction * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ray_meets_the_ground_in_front_only() {
        let eye = Point3::new(0.0, 0.0, 1.0);
        let hit = Plane::ground().intersect_ray(&eye, &Vector3::new(1.0, 0.0, -0.5)).unwrap();
        assert!((hit - Point3::new(2.0, 0.0, 0.0)).norm() < 1e-12);
        assert!(Plane::ground().intersect_ray(&eye, &Vector3::new(1.0, 0.0, 0.5)).is_none());
        assert!(Plane::ground().intersect_ray(&eye, &Vector3::new(1.0, 0.0, 0.0)).is_none());
    }
}
