//! The pinhole camera with lens distortion.

use nalgebra::{Matrix2, Matrix2x3, Point2, Point3, Vector3};
use thiserror::Error;

use crate::geom::Distortion;

/// Why a point has no pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ProjectionReject {
    /// The point is on or behind the camera's plane (z <= 0).
    #[error("the point is behind the camera")]
    BehindCamera,
    /// The point is so far from the axis that the distortion polynomial folds back.
    #[error("the point is outside the range of the lens model")]
    OutsideLensModel,
}

/// Calibration values that no camera can have.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CameraError {
    /// Width or height is zero.
    #[error("image size {0} x {1} px: expected both above 0")]
    Size(u32, u32),
    /// A focal length is not positive, or a value is not a number.
    #[error("camera calibration: expected finite values and positive focal lengths, found {0}")]
    Values(String),
    /// A side is longer than that of any image that is read.
    #[error("image size {0} x {1} px: expected at most {MAX_IMAGE_SIDE_PX} px a side")]
    TooLarge(u32, u32),
    /// No lens has such a focal length for images of this size.
    #[error(
        "focal length {focal_px:?} px for images of {side_px} px: the camera would see {view_deg} degrees, and no lens does \
         that; is it in pixels, of images of this size?"
    )]
    Focal {
        /// Focal length, pixels.
        focal_px: f64,
        /// Width or height of the image, pixels.
        side_px: u32,
        /// Angle of view that this would be, degrees, as text that can be read.
        view_deg: String,
    },
    /// The principal point is nowhere near the image.
    #[error(
        "principal point ({:?}, {:?}) px: expected one in the image of {} x {} px or near it", center_px.0, center_px.1,
        size_px.0, size_px.1
    )]
    Center {
        /// Principal point, pixels.
        center_px: (f64, f64),
        /// Width and height, pixels.
        size_px: (u32, u32),
    },
    /// The distortion leaves nothing of the image.
    #[error(
        "distortion {coefficients:?}: it folds or tears the middle of the image; are the coefficients those of this model, in \
         this order?"
    )]
    Lens {
        /// The coefficients.
        coefficients: Vec<f64>,
    },
}

/// Longest side of an image that is read or written, pixels: 16384 x 16384 x 4 bytes are 1 GB.
pub const MAX_IMAGE_SIDE_PX: u32 = 16_384;
/// Smallest and largest angle of view without distortion, degrees: telescopes have more, and no flat image has 175.
const VIEW_DEG: (f64, f64) = (0.1, 175.0);
/// Largest side of a fisheye's image in focal lengths; 6.3 are a view of 360 degrees, and images have black corners.
const MAX_FISHEYE_SIDE: f64 = 15.0;
/// The principal point is at most so many image sizes outside of the image: of cut images it may be outside.
const MAX_SIDES_OUTSIDE: f64 = 4.0;
/// The lens model holds for at least this share of the way to the nearest border.
const MIN_USABLE_SHARE: f64 = 0.1;
/// Half way to the border a lens magnifies or shrinks by less than this factor.
const MAX_MAGNIFICATION: f64 = 100.0;

crate::with_defaults! {
    /// A camera: image size, pinhole intrinsics and distortion. Pixel centers are at integer coordinates.
    /// By default a single pixel with focal length 1: a place holder until a calibration is known.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Camera {
        size_px: (u32, u32) = (1, 1),
        focal_px: (f64, f64) = (1.0, 1.0),
        center_px: (f64, f64) = (0.0, 0.0),
        distortion: Distortion = Distortion::None,
        /// Squared radius on the normalized plane up to which the distortion does not fold back.
        max_radius2: f64 = f64::INFINITY,
    }
}

/// Refuses focal lengths that no lens has for images with a side.
fn check_view(focal_px: f64, side_px: u32, is_fisheye: bool) -> Result<(), CameraError> {
    let side = f64::from(side_px) / focal_px;
    let view_deg = 2.0 * (0.5 * side).atan().to_degrees();
    let is_possible = if is_fisheye { side <= MAX_FISHEYE_SIDE } else { view_deg <= VIEW_DEG.1 };
    if is_possible && view_deg >= VIEW_DEG.0 {
        return Ok(());
    }
    let shown = if is_fisheye { side.to_degrees() } else { view_deg };
    let view_deg = if (0.01..1e6).contains(&shown) { format!("{shown:.2}") } else { format!("{shown:.0e}") };
    Err(CameraError::Focal { focal_px, side_px, view_deg })
}

impl Camera {
    /// A camera without distortion. Sizes as (width, height), the rest as (x, y), all in pixels. Numbers that somebody has typed are better
    /// given to [`Camera::checked`], which also refuses what no lens has.
    ///
    /// # Errors
    /// If the size is zero, a focal length is not positive or a value is not finite.
    pub fn pinhole(
        size_px: (u32, u32),
        focal_px: (f64, f64),
        center_px: (f64, f64),
    ) -> Result<Self, CameraError> {
        Self::new(size_px, focal_px, center_px, Distortion::None)
    }

    /// A camera with distortion. All-zero radial-tangential coefficients become [`Distortion::None`].
    ///
    /// # Errors
    /// As [`Camera::pinhole`].
    pub fn new(
        size_px: (u32, u32),
        focal_px: (f64, f64),
        center_px: (f64, f64),
        distortion: Distortion,
    ) -> Result<Self, CameraError> {
        if size_px.0 == 0 || size_px.1 == 0 {
            return Err(CameraError::Size(size_px.0, size_px.1));
        }
        let mut values = vec![focal_px.0, focal_px.1, center_px.0, center_px.1];
        values.extend(distortion.coefficients());
        if values.iter().any(|v| !v.is_finite()) || focal_px.0 <= 0.0 || focal_px.1 <= 0.0 {
            return Err(CameraError::Values(format!("{values:?}")));
        }
        let distortion = match distortion {
            Distortion::RadialTangential(k) if k == [0.0; 5] => Distortion::None,
            other => other,
        };
        let max_radius2 = distortion.max_radius().powi(2);
        Ok(Self { size_px, focal_px, center_px, distortion, max_radius2 })
    }

    /// As [`Camera::new`], for values from a file or a message: refuses those that no lens has. With them, every search in
    /// the image would be endless or empty.
    ///
    /// # Errors
    /// As [`Camera::new`], or if the image is too large, the angle of view impossible, the principal point far outside of
    /// the image, or nothing of the image is left by the distortion.
    pub fn checked(
        size_px: (u32, u32),
        focal_px: (f64, f64),
        center_px: (f64, f64),
        distortion: Distortion,
    ) -> Result<Self, CameraError> {
        let camera = Self::new(size_px, focal_px, center_px, distortion)?;
        if size_px.0.max(size_px.1) > MAX_IMAGE_SIDE_PX {
            return Err(CameraError::TooLarge(size_px.0, size_px.1));
        }
        let is_fisheye = matches!(distortion, Distortion::KannalaBrandt(_));
        for (focal_px, side_px) in [(focal_px.0, size_px.0), (focal_px.1, size_px.1)] {
            check_view(focal_px, side_px, is_fisheye)?;
        }
        let (width, height) = (f64::from(size_px.0), f64::from(size_px.1));
        let is_near = |center: f64, side: f64| (center / side - 0.5).abs() <= 0.5 + MAX_SIDES_OUTSIDE;
        if !is_near(center_px.0, width) || !is_near(center_px.1, height) {
            return Err(CameraError::Center { center_px, size_px });
        }
        camera.check_lens().map(|()| camera)
    }

    fn check_lens(&self) -> Result<(), CameraError> {
        let half = |side: u32, focal: f64| f64::from(side) / (2.0 * focal);
        let to_border = half(self.size_px.0, self.focal_px.0).min(half(self.size_px.1, self.focal_px.1));
        let half_way = Point2::new(0.5 * to_border, 0.0);
        let magnification = self.distortion.distort(&half_way).coords.norm() / half_way.x;
        let is_smooth = (1.0 / MAX_MAGNIFICATION..=MAX_MAGNIFICATION).contains(&magnification);
        if is_smooth && self.distortion.max_radius() >= MIN_USABLE_SHARE * to_border {
            return Ok(());
        }
        Err(CameraError::Lens { coefficients: self.distortion.coefficients().to_vec() })
    }

    /// Image width and height, pixels.
    pub fn size_px(&self) -> (u32, u32) {
        self.size_px
    }

    /// Focal lengths (fx, fy), pixels.
    pub fn focal_px(&self) -> (f64, f64) {
        self.focal_px
    }

    /// Principal point (cx, cy), pixels.
    pub fn center_px(&self) -> (f64, f64) {
        self.center_px
    }

    /// The lens distortion.
    pub fn distortion(&self) -> Distortion {
        self.distortion
    }

    /// Whether a pixel lies in the image, with its center at least half a pixel inside the border.
    #[inline]
    pub fn contains(&self, px: &Point2<f64>) -> bool {
        let (w, h) = (f64::from(self.size_px.0), f64::from(self.size_px.1));
        px.x >= 0.0 && px.y >= 0.0 && px.x <= w - 1.0 && px.y <= h - 1.0
    }

    /// Pixel of a point given in the camera frame (meters). The pixel may lie outside the image.
    ///
    /// # Errors
    /// If the point has no pixel.
    #[inline]
    pub fn project(&self, point_in_camera: &Point3<f64>) -> Result<Point2<f64>, ProjectionReject> {
        if point_in_camera.z <= 0.0 {
            return Err(ProjectionReject::BehindCamera);
        }
        let normalized =
            Point2::new(point_in_camera.x / point_in_camera.z, point_in_camera.y / point_in_camera.z);
        self.pixel_of_normalized(&normalized)
    }

    /// As [`Camera::project`], with the 2x3 Jacobian of the pixel by the point, pixels per meter.
    ///
    /// # Errors
    /// If the point has no pixel.
    pub fn project_with_jacobian(
        &self,
        point_in_camera: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionReject> {
        let px = self.project(point_in_camera)?;
        let inv_z = 1.0 / point_in_camera.z;
        let (x, y) = (point_in_camera.x * inv_z, point_in_camera.y * inv_z);
        let normalized_by_point = Matrix2x3::new(inv_z, 0.0, -x * inv_z, 0.0, inv_z, -y * inv_z);
        let distorted_by_normalized = self.distortion.distort_with_jacobian(&Point2::new(x, y)).1;
        let px_by_distorted = Matrix2::new(self.focal_px.0, 0.0, 0.0, self.focal_px.1);
        Ok((px, px_by_distorted * distorted_by_normalized * normalized_by_point))
    }

    /// Direction of a pixel's ray in the camera frame, with z = 1. Undistorts where the lens has distortion.
    pub fn bearing(&self, px: &Point2<f64>) -> Vector3<f64> {
        let n = self.normalized(px);
        Vector3::new(n.x, n.y, 1.0)
    }

    /// Undistorted point of a pixel on the normalized image plane (z = 1).
    pub fn normalized(&self, px: &Point2<f64>) -> Point2<f64> {
        let distorted = Point2::new(
            (px.x - self.center_px.0) / self.focal_px.0,
            (px.y - self.center_px.1) / self.focal_px.1,
        );
        self.distortion.undistort(&distorted)
    }

    /// Where a pixel would be if the lens had no distortion: the "ideal" pixel.
    pub fn ideal_px(&self, px: &Point2<f64>) -> Point2<f64> {
        if self.distortion == Distortion::None {
            return *px;
        }
        let n = self.normalized(px);
        Point2::new(n.x * self.focal_px.0 + self.center_px.0, n.y * self.focal_px.1 + self.center_px.1)
    }

    /// The same camera with the distortion removed.
    #[must_use]
    pub fn without_distortion(&self) -> Self {
        Self { distortion: Distortion::None, max_radius2: f64::INFINITY, ..*self }
    }

    /// The same camera with images resized by a factor above 0; sizes are rounded to whole pixels.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let side = |px: u32| (f64::from(px) * factor).round().max(1.0) as u32;
        self.scaled_to((side(self.size_px.0), side(self.size_px.1)))
    }

    /// The same camera with images resized to a size in pixels, both sides at least 1. The borders of the image stay where
    /// they are: they lie half a pixel outside of the centers of the outermost pixels.
    #[must_use]
    pub fn scaled_to(&self, size_px: (u32, u32)) -> Self {
        let size_px = (size_px.0.max(1), size_px.1.max(1));
        let x = f64::from(size_px.0) / f64::from(self.size_px.0);
        let y = f64::from(size_px.1) / f64::from(self.size_px.1);
        Self {
            size_px,
            focal_px: (self.focal_px.0 * x, self.focal_px.1 * y),
            center_px: ((self.center_px.0 + 0.5) * x - 0.5, (self.center_px.1 + 0.5) * y - 0.5),
            ..*self
        }
    }

    /// Pixel of a point on the normalized image plane.
    ///
    /// # Errors
    /// If the point is outside the range of the lens model.
    #[inline]
    pub fn pixel_of_normalized(&self, normalized: &Point2<f64>) -> Result<Point2<f64>, ProjectionReject> {
        // Past the fold the image runs backwards; such points would land on wrong pixels.
        if normalized.coords.norm_squared() > self.max_radius2 {
            return Err(ProjectionReject::OutsideLensModel);
        }
        let d = self.distortion.distort(normalized);
        Ok(Point2::new(d.x * self.focal_px.0 + self.center_px.0, d.y * self.focal_px.1 + self.center_px.1))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cameras() -> Vec<Camera> {
        let size = (320, 240);
        let (focal, center) = ((373.3, 371.0), (159.5, 119.5));
        vec![
            Camera::pinhole(size, focal, center).unwrap(),
            Camera::new(size, focal, center, Distortion::RadialTangential([-0.28, 0.02, 1e-4, 2e-5, 0.0]))
                .unwrap(),
            Camera::new(size, focal, center, Distortion::RadialTangential([0.2, -0.3, -8e-4, 1e-3, 0.1]))
                .unwrap(),
            Camera::new(size, focal, center, Distortion::KannalaBrandt([-0.02, 0.01, -0.004, 5e-4])).unwrap(),
            Camera::new(size, (150.0, 149.0), center, Distortion::KannalaBrandt([0.03, -0.01, 2e-3, -1e-3]))
                .unwrap(),
        ]
    }

    proptest! {
        #[test]
        fn bearing_then_project_returns_the_pixel(u in 0.0..319.0f64, v in 0.0..239.0f64, depth in 0.1..10.0f64) {
            for camera in cameras() {
                let px = Point2::new(u, v);
                let point = Point3::from(camera.bearing(&px) * depth);
                let back = camera.project(&point).unwrap();
                prop_assert!((back - px).norm() < 1e-6, "{camera:?}: {px} came back as {back}");
            }
        }

        #[test]
        fn jacobian_equals_numeric(x in -0.3..0.3f64, y in -0.25..0.25f64, z in 0.5..5.0f64) {
            for camera in cameras() {
                let point = Point3::new(x * z, y * z, z);
                let (_, jacobian) = camera.project_with_jacobian(&point).unwrap();
                let h = 1e-6;
                for axis in 0..3 {
                    let (mut ahead, mut behind) = (point, point);
                    ahead[axis] += h;
                    behind[axis] -= h;
                    let numeric = (camera.project(&ahead).unwrap() - camera.project(&behind).unwrap()) / (2.0 * h);
                    prop_assert!((numeric - jacobian.column(axis)).norm() < 1e-3 * (1.0 + jacobian.norm()));
                }
            }
        }

        #[test]
        fn ideal_pixel_is_the_projection_without_distortion(u in 0.0..319.0f64, v in 0.0..239.0f64) {
            for camera in cameras() {
                let px = Point2::new(u, v);
                let ideal = camera.without_distortion().project(&Point3::from(camera.bearing(&px))).unwrap();
                prop_assert!((ideal - camera.ideal_px(&px)).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn a_resized_image_shows_the_same_directions() {
        for camera in cameras() {
            let half = camera.scaled(0.5);
            assert_eq!(half.size_px(), (160, 120));
            // The corner between four pixels is the middle of one.
            let corner = camera.bearing(&Point2::new(100.5, 60.5));
            assert!((corner - half.bearing(&Point2::new(50.0, 30.0))).norm() < 1e-9);
            assert_eq!(half.scaled_to((320, 240)).size_px(), (320, 240));
            assert!((half.scaled(2.0).center_px().0 - camera.center_px().0).abs() < 1e-12);
        }
    }

    #[test]
    fn points_behind_and_beyond_the_lens_are_refused() {
        let camera = cameras()[1];
        let behind = camera.project(&Point3::new(0.0, 0.0, -1.0));
        assert_eq!(behind, Err(ProjectionReject::BehindCamera));
        assert_eq!(camera.project(&Point3::new(5.0, 0.0, 1.0)), Err(ProjectionReject::OutsideLensModel));
    }

    #[test]
    fn what_no_lens_has_is_refused_with_what_it_would_mean() {
        let error = |focal: f64, center: f64, lens: Distortion| {
            Camera::checked((320, 240), (focal, focal), (center, 119.5), lens).unwrap_err().to_string()
        };
        for focal in [1e-9, 1e-300, 1.0, 6.0] {
            let error = error(focal, 159.5, Distortion::None);
            assert!(error.contains("degrees, and no lens does that") && error.len() < 200, "{error}");
        }
        assert!(error(1e9, 159.5, Distortion::None).contains("would see 2e-5 degrees"));
        assert!(error(1e300, 159.5, Distortion::None).contains("focal length 1e300 px"));
        assert!(error(300.0, 1e9, Distortion::None).contains("principal point (1000000000.0, 119.5)"));
        for k1 in [-1e3, 1e6, 1e300, -1e300] {
            let error = error(300.0, 159.5, Distortion::RadialTangential([k1, 0.0, 0.0, 0.0, 0.0]));
            assert!(error.contains("distortion") && error.len() < 200, "{error}");
        }
        assert!(error(300.0, 159.5, Distortion::KannalaBrandt([-1e4, 0.0, 0.0, 0.0])).contains("distortion"));
        assert!(error(1.0, 159.5, Distortion::KannalaBrandt([0.0; 4])).contains("degrees"));
        assert!(matches!(
            Camera::checked((100_000, 100_000), (1e5, 1e5), (5e4, 5e4), Distortion::None),
            Err(CameraError::TooLarge(..))
        ));
        for camera in cameras() {
            let again =
                Camera::checked(camera.size_px(), camera.focal_px(), camera.center_px(), camera.distortion());
            assert_eq!(again, Ok(camera));
        }
        // A telephoto lens, an action camera, a fisheye of 220 degrees, a cut image.
        let strong = Distortion::RadialTangential([-0.26, 0.11, 0.0, 0.0, -0.02]);
        assert!(Camera::checked((320, 240), (30_000.0, 30_000.0), (159.5, 119.5), Distortion::None).is_ok());
        assert!(Camera::checked((320, 240), (140.0, 140.0), (159.5, 119.5), strong).is_ok());
        let fisheye = Distortion::KannalaBrandt([0.0; 4]);
        assert!(Camera::checked((320, 240), (62.0, 62.0), (159.5, 119.5), fisheye).is_ok());
        assert!(Camera::checked((320, 240), (300.0, 300.0), (-400.0, 119.5), Distortion::None).is_ok());
    }

    #[test]
    fn impossible_calibrations_are_refused() {
        assert!(matches!(Camera::pinhole((0, 240), (1.0, 1.0), (0.0, 0.0)), Err(CameraError::Size(0, 240))));
        assert!(Camera::pinhole((320, 240), (-1.0, 1.0), (0.0, 0.0)).is_err());
        assert!(Camera::pinhole((320, 240), (f64::NAN, 1.0), (0.0, 0.0)).is_err());
    }
}
