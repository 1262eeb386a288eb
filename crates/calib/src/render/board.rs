//! The renderer.

use nalgebra::{Matrix3, Point2};
use visloc_core::{GrayImage, Rng, gaussian, geom::Camera};

use crate::{Board, CameraFromBoard, saddles::FloatImage};

visloc_core::with_defaults! {
    /// What happens to the picture between the board and the file.
    /// By default an ordinary webcam in a room.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RenderSettings {
        /// Standard deviation of a Gaussian blur, pixels.
        pub blur_px: f32 = 0.8,
        /// Standard deviation of the noise of a pixel, of 255.
        pub noise: f64 = 2.0,
        /// Brightness lost from one side of the image to the other, as a share.
        pub light_gradient: f64 = 0.3,
        /// Share of light lost in the corners.
        pub vignetting: f64 = 0.2,
    }
}

/// Brightness of printed squares and of paper in an ordinary picture, 0 to 255: neither is black or white.
const BLACK: f32 = 28.0;
const WHITE: f32 = 215.0;
/// Size of the wall's pattern: about pixels of an ordinary camera.
const WALL: f64 = 500.0;
/// Rays through a pixel with an edge in it, along each side.
const RAYS: usize = 7;

/// The picture of a board.
pub fn render(
    board: &Board,
    camera: &Camera,
    camera_from_board: &CameraFromBoard,
    settings: &RenderSettings,
    rng: &mut Rng,
) -> GrayImage {
    let (width, height) = (camera.size_px().0 as usize, camera.size_px().1 as usize);
    let scene = Scene::new(board, camera, camera_from_board);
    let mut data = Vec::with_capacity(width * height);
    for y in 0..height {
        data.extend((0..width).map(|x| scene.pixel(x, y)));
    }
    let mut image = FloatImage::from_raw(width, height, data);
    if settings.blur_px > 0.0 {
        image = image.blurred(settings.blur_px);
    }
    let mut bytes = Vec::with_capacity(width * height);
    for y in 0..height {
        for (x, value) in image.row(y).iter().enumerate() {
            let lit = f64::from(*value) * light(x, y, (width, height), settings);
            let noisy = lit + gaussian(rng, settings.noise);
            bytes.push(noisy.round().clamp(0.0, 255.0) as u8);
        }
    }
    GrayImage::from_raw(width, height, bytes).unwrap_or_default()
}

fn light(x: usize, y: usize, size: (usize, usize), settings: &RenderSettings) -> f64 {
    let (u, v) = (x as f64 / size.0 as f64 - 0.5, y as f64 / size.1 as f64 - 0.5);
    let corner = (u * u + v * v) / 0.5;
    (1.0 - settings.light_gradient * (u + 0.5)) * (1.0 - settings.vignetting * corner)
}

/// The board in front of the camera, as seen through a lattice of the pixels' corners.
struct Scene<'a> {
    board: &'a Board,
    /// Places of the board's plane; `None` where no ray meets it in front.
    lattice: Vec<Option<Point2<f64>>>,
    /// Where the rays meet a wall behind the board, in units of its pattern.
    wall: Vec<Point2<f64>>,
    columns: usize,
}

impl<'a> Scene<'a> {
    fn new(board: &'a Board, camera: &Camera, camera_from_board: &CameraFromBoard) -> Self {
        let (width, height) = (camera.size_px().0 as usize, camera.size_px().1 as usize);
        let r = camera_from_board.rotation();
        let camera_from_plane = Matrix3::from_columns(&[
            r.column(0).into_owned(),
            r.column(1).into_owned(),
            *camera_from_board.translation(),
        ]);
        let plane_from_camera = camera_from_plane.try_inverse().unwrap_or_else(Matrix3::zeros);
        let max_radius = 0.999 * camera.distortion().max_radius();
        let rays = (0..(width + 1) * (height + 1)).map(|i| {
            let px = Point2::new((i % (width + 1)) as f64 - 0.5, (i / (width + 1)) as f64 - 0.5);
            camera.bearing(&px)
        });
        let place = |ray: nalgebra::Vector3<f64>| {
            let p = plane_from_camera * ray;
            let is_seen = p.z > 1e-9 && ray.xy().norm() < max_radius;
            let on_board = is_seen.then(|| Point2::new(p.x / p.z, p.y / p.z));
            (on_board, Point2::from(ray.xy() * WALL))
        };
        let (lattice, wall) = rays.map(place).unzip();
        Self { board, lattice, wall, columns: width + 1 }
    }

    /// Mean brightness of a pixel.
    fn pixel(&self, x: usize, y: usize) -> f32 {
        let at = |dx: usize, dy: usize| self.lattice[(y + dy) * self.columns + x + dx];
        let (Some(a), Some(b), Some(c), Some(d)) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1)) else {
            return background(&self.wall[y * self.columns + x]);
        };
        // Between the corners of one pixel the lens is as good as linear.
        let place = |u: f64, v: f64| {
            let top = a.coords * (1.0 - u) + b.coords * u;
            let bottom = c.coords * (1.0 - u) + d.coords * u;
            Point2::from(top * (1.0 - v) + bottom * v)
        };
        let shade = |p: &Point2<f64>| match self.board.is_black(p) {
            Some(true) => BLACK,
            Some(false) => WHITE,
            None => background(&self.wall[y * self.columns + x]),
        };
        let probes = [shade(&a), shade(&b), shade(&c), shade(&d), shade(&place(0.5, 0.5))];
        if probes.iter().all(|v| *v == probes[0]) {
            return probes[0];
        }
        let mut sum = 0.0;
        for i in 0..RAYS {
            for j in 0..RAYS {
                sum += shade(&place((i as f64 + 0.5) / RAYS as f64, (j as f64 + 0.5) / RAYS as f64));
            }
        }
        sum / (RAYS * RAYS) as f32
    }
}

/// A wall with soft stripes and hard bands, so that the board is not the only thing in the picture, and that straight lines
/// are there to be bent by the lens.
fn background(place: &Point2<f64>) -> f32 {
    let (x, y) = (place.x as f32, place.y as f32);
    let soft = 110.0 + 25.0 * (x * 0.031 + 0.5 * (y * 0.017).sin()).sin();
    if (x * 0.8 + y).rem_euclid(190.0) < 24.0 || (x - 0.3 * y).rem_euclid(230.0) < 20.0 {
        soft - 45.0
    } else {
        soft
    }
}
