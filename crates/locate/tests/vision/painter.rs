//! Draws images of a carpet by looking up, for every pixel, the ground point that it sees.

use nalgebra::{Point2, Point3};
use visloc_core::{
    Frame, RgbImage, Timestamp,
    geom::{Camera, CameraFrame, Plane, Rigid3, Robot, nao},
};

pub const GREEN: [u8; 3] = [60, 140, 80];
pub const WHITE: [u8; 3] = [230, 232, 228];
pub const GRAY: [u8; 3] = [120, 118, 115];
pub const YELLOW: [u8; 3] = [210, 190, 25];
pub const BLUE: [u8; 3] = [31, 79, 176];

/// A robot that looks straight ahead, slightly down.
pub struct Painter {
    pub camera: Camera,
    pub robot_from_camera: Rigid3<Robot, CameraFrame>,
}

impl Painter {
    pub fn new(pitch_deg: f64) -> Self {
        let head = nao::HeadAngles { yaw_rad: 0.0, pitch_rad: pitch_deg.to_radians() };
        Self {
            camera: Camera::pinhole((320, 240), (373.3, 373.3), (159.5, 119.5)).unwrap(),
            robot_from_camera: nao::robot_from_camera(&nao::Torso::upright(), &head, nao::NaoCamera::TopV3),
        }
    }

    /// Ground point (x ahead, y left, meters from the robot) seen at a pixel.
    pub fn ground(&self, u: f64, v: f64) -> Option<Point2<f64>> {
        let direction = self.robot_from_camera.rotate(&self.camera.bearing(&Point2::new(u, v)));
        let eye = Point3::from(*self.robot_from_camera.translation());
        Plane::ground().intersect_ray(&eye, &direction).map(|p| Point2::new(p.x, p.y))
    }

    /// Pixel of a point of the robot frame.
    pub fn pixel(&self, x: f64, y: f64, z: f64) -> Point2<f64> {
        self.camera.project(&self.robot_from_camera.inverse().transform(&Point3::new(x, y, z))).unwrap()
    }

    /// An image whose ground is colored by `ground` and whose sky is a gray wall; 3 x 3 rays a pixel.
    pub fn paint(&self, ground: impl Fn(&Point2<f64>) -> [u8; 3]) -> RgbImage {
        let mut image = RgbImage::new(320, 240);
        for v in 0..240 {
            for u in 0..320 {
                let mut sum = [0_u32; 3];
                for i in 0..9 {
                    let (du, dv) = (f64::from(i % 3 - 1) / 3.0, f64::from(i / 3 - 1) / 3.0);
                    let point = self.ground(f64::from(u) + du, f64::from(v) + dv);
                    let color = point.map_or(GRAY, |p| ground(&p));
                    sum.iter_mut().zip(color).for_each(|(s, c)| *s += u32::from(c));
                }
                image.set(u, v, sum.map(|s| (s / 9) as u8));
            }
        }
        image
    }

    pub fn frame(&self, image: RgbImage) -> Frame {
        Frame {
            at: Timestamp::default(),
            image,
            camera_index: 0,
            camera: self.camera,
            robot_from_camera: self.robot_from_camera,
            odometry: None,
            ground_contact: None,
        }
    }
}

/// Fills a rectangle of pixels: columns and rows, ends exclusive.
pub fn fill(image: &mut RgbImage, columns: std::ops::Range<u32>, rows: std::ops::Range<u32>, color: [u8; 3]) {
    for y in rows {
        for x in columns.clone() {
            image.set(x, y, color);
        }
    }
}

/// Carpet up to 3 m ahead, gray floor behind it.
pub fn carpet(p: &Point2<f64>) -> [u8; 3] {
    if p.x < 3.0 { GREEN } else { GRAY }
}

/// Carpet with a line across the view at 1.5 m, 5 cm wide.
pub fn carpet_with_line(p: &Point2<f64>) -> [u8; 3] {
    if (p.x - 1.5).abs() < 0.025 { WHITE } else { carpet(p) }
}
