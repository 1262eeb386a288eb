//! The image of the ground: from pixels to places and back, and what color a place has.

use nalgebra::{Matrix3, Point2, Point3, Vector2, Vector3};
use visloc_core::{
    Frame, RgbImage,
    geom::{Camera, Distortion},
};

use crate::vision::{
    blur_px,
    color::{ColorClass, ColorTable, luma},
    px_scale,
};

/// What is seen at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::vision::field) enum Seen {
    White,
    Carpet,
    /// Neither: most likely something stands there.
    Other,
    /// Not in the image.
    Nothing,
}

/// An image with the camera that took it.
pub(in crate::vision::field) struct GroundView<'a> {
    image: &'a RgbImage,
    table: &'a ColorTable,
    camera: Camera,
    is_rectified: bool,
    focal_px: Vector2<f64>,
    center_px: Vector2<f64>,
    robot_from_camera: Matrix3<f64>,
    eye: Vector3<f64>,
    /// Pixels of this image in a pixel of an image 320 px wide.
    pub scan_scale: f64,
    /// The same, never below 1: no image tells less than a pixel.
    pub scale: f64,
    /// Pixels of this image that blur into one.
    pub blur: f64,
}

impl<'a> GroundView<'a> {
    pub fn new(frame: &'a Frame, table: &'a ColorTable) -> Self {
        let ((fx, fy), (cx, cy)) = (frame.camera.focal_px(), frame.camera.center_px());
        Self {
            image: &frame.image,
            table,
            camera: frame.camera,
            is_rectified: frame.camera.distortion() == Distortion::None,
            focal_px: Vector2::new(fx, fy),
            center_px: Vector2::new(cx, cy),
            robot_from_camera: *frame.robot_from_camera.rotation(),
            eye: *frame.robot_from_camera.translation(),
            scan_scale: px_scale(frame.image.width()),
            scale: px_scale(frame.image.width()).max(1.0),
            blur: f64::from(blur_px(frame.image.width())),
        }
    }

    /// Direction of a pixel, free of distortion, in the robot frame.
    pub fn ray(&self, ideal_px: &Point2<f64>) -> Vector3<f64> {
        let p = (ideal_px.coords - self.center_px).component_div(&self.focal_px);
        self.robot_from_camera * Vector3::new(p.x, p.y, 1.0)
    }

    /// Place on the ground seen at a pixel, free of distortion.
    pub fn ground(&self, ideal_px: &Point2<f64>) -> Option<Point2<f64>> {
        let ray = self.ray(ideal_px);
        (ray.z < -1e-6).then(|| Point2::from((self.eye + ray * (-self.eye.z / ray.z)).xy()))
    }

    /// Pixel of a place on the ground, free of distortion; `None` behind the camera.
    pub fn px(&self, ground: &Point2<f64>) -> Option<Point2<f64>> {
        let p = self.robot_from_camera.tr_mul(&(ground.coords.push(0.0) - self.eye));
        (p.z > 1e-3).then(|| Point2::from((p.xy() / p.z).component_mul(&self.focal_px) + self.center_px))
    }

    /// Length on the ground of one pixel around a place in a direction (a unit vector), meters.
    pub fn meters_per_px(&self, ground: &Point2<f64>, direction: &Vector2<f64>) -> f64 {
        let offset = ground.coords - self.eye.xy();
        let distance = offset.norm().max(1e-3);
        let slant = distance.hypot(self.eye.z);
        let ahead = offset.dot(direction) / distance;
        let per_px = slant / self.focal_px.x;
        // Across the view a pixel is what its angle says, along the view the ground is seen at a slant.
        per_px / (1.0 - ahead * ahead + (ahead * self.eye.z / slant).powi(2)).sqrt().max(1e-3)
    }

    /// Width of the image, pixels.
    pub fn width(&self) -> u32 {
        self.image.width()
    }

    /// Focal length across, pixels.
    pub fn focal_px(&self) -> f64 {
        self.focal_px.x
    }

    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    pub fn eye(&self) -> &Vector3<f64> {
        &self.eye
    }

    /// What is seen at a pixel, free of distortion, beside carpet that makes this luma white.
    pub fn at_px(&self, ideal_px: &Point2<f64>, white: u32) -> Seen {
        match self.raw_px(ideal_px).and_then(|px| self.class_at_raw(&px, white)) {
            Some(ColorClass::White) => Seen::White,
            Some(ColorClass::Green) => Seen::Carpet,
            Some(_) => Seen::Other,
            None => Seen::Nothing,
        }
    }

    /// Whether a pixel, free of distortion, has the carpet's color, however bright it is; `None` outside of the image.
    pub fn is_carpet(&self, ideal_px: &Point2<f64>) -> Option<bool> {
        let class = self.class_at_raw(&self.raw_px(ideal_px)?, u32::MAX)?;
        Some(class == ColorClass::Green)
    }

    /// The pixel of the image as it is.
    fn raw_px(&self, ideal_px: &Point2<f64>) -> Option<Point2<f64>> {
        if self.is_rectified {
            return Some(*ideal_px);
        }
        let normalized = (ideal_px.coords - self.center_px).component_div(&self.focal_px);
        self.camera.pixel_of_normalized(&normalized.into()).ok()
    }

    /// Class of a pixel of the image as it is; `None` outside of it.
    pub fn class_at_raw(&self, px: &Point2<f64>, white: u32) -> Option<ColorClass> {
        // Truncated: rounding is a call of a library.
        let nearest = |at: f64| (at > -0.5).then_some((at + 0.5) as u32);
        let (x, y) = (nearest(px.x)?, nearest(px.y)?);
        (x < self.image.width() && y < self.image.height())
            .then(|| self.table.class_beside_carpet(self.image.get(x, y), white))
    }

    /// Pixel of the image as it is of a place seen from the robot; `None` behind the camera.
    pub fn raw_px_of(&self, in_robot: &Point3<f64>) -> Option<Point2<f64>> {
        let p = self.robot_from_camera.tr_mul(&(in_robot.coords - self.eye));
        let ideal = (p.z > 1e-3).then(|| (p.xy() / p.z).component_mul(&self.focal_px) + self.center_px)?;
        self.raw_px(&ideal.into())
    }

    /// Mean brightness of the pixel in a column of a row with that above and below it; `None` if those rows are outside of the image.
    pub fn lumas_around(&self, row: f64) -> Option<impl Fn(usize) -> f64> {
        let y = (row > 0.5 && row < f64::from(self.image.height()) - 1.5).then_some((row + 0.5) as usize)?;
        let width = self.image.width() as usize;
        let of_row = |y: usize| &self.image.pixels()[y * width..][..width];
        let [above, here, below] = [of_row(y - 1), of_row(y), of_row(y + 1)];
        Some(move |x| f64::from(luma(above[x]) + luma(here[x]) + luma(below[x])) / 3.0)
    }

    /// What is seen at a place of the ground: white also if it is white a pixel beside it in this direction.
    pub fn at_ground(&self, ground: &Point2<f64>, across_px: &Vector2<f64>, white: u32) -> Seen {
        let Some(px) = self.px(ground) else { return Seen::Nothing };
        let seen = self.at_px(&px, white);
        let is_white = |side: f64| self.at_px(&(px + across_px * side), white) == Seen::White;
        if seen != Seen::White && seen != Seen::Nothing && (is_white(self.blur) || is_white(-self.blur)) {
            return Seen::White;
        }
        seen
    }
}
