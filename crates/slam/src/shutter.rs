//! Cameras that expose the rows of an image one after the other, as most phones and webcams do: while they turn, straight things lean.
//!
//! An image is put right before it is looked at: each pixel is taken from where its ray was seen when its row was exposed. So everything else has to do with
//! images that were exposed at once. How long the camera takes from the first row to the last is estimated beside the map
//! where the whole map is adjusted.
//!
//! Sources: Meingast, Geyer and Sastry, "Geometric models of rolling-shutter cameras", 2005; Hedborg et al., "Rolling shutter bundle
//! adjustment", 2012.

use nalgebra::{Point2, Vector2, Vector3, Vector6};
use visloc_core::{GrayImage, geom::Camera};

/// Seconds between the exposures of the left and the right border of an image, and of its upper and its lower one. Images of phones that were
/// turned upright have columns one after the other, and upside down the last row is the first. Zero where all is exposed at once.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Readout(pub Vector2<f64>);

impl Readout {
    /// Whether all pixels are exposed at once.
    #[must_use]
    pub fn is_at_once(&self) -> bool {
        *self == Self::default()
    }

    /// Seconds from the middle of the exposures to that of a pixel.
    fn secs_at(&self, px: &Point2<f64>, camera: &Camera) -> f64 {
        place_in_image(px, camera).dot(&self.0)
    }
}

/// Where a pixel is, in sizes of the image from its middle.
fn place_in_image(px: &Point2<f64>, camera: &Camera) -> Vector2<f64> {
    let (width, height) = camera.size_px();
    Vector2::new((px.x + 0.5) / f64::from(width) - 0.5, (px.y + 0.5) / f64::from(height) - 0.5)
}

/// How an image was exposed: what the camera did meanwhile, and how long it took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// How the scene moved before the camera, per second: a twist whose lengths are in depths of the scene.
    pub motion: Vector6<f64>,
    /// The readout that is to be undone; of frames and keyframes, whose images have been put right, the one that was.
    pub readout: Readout,
}

/// Pixels between the places whose shift is worked out; between them it is linear.
const CELL_PX: usize = 32;

impl Exposure {
    /// What is left to be put right if the camera has another readout.
    #[must_use]
    pub fn left_by(&self, readout: &Readout) -> Self {
        Self { motion: self.motion, readout: Readout(readout.0 - self.readout.0) }
    }

    /// Where a ray (z = 1) at the depth of the scene goes, per second.
    fn drift(&self, ray: &Vector3<f64>) -> Vector3<f64> {
        self.motion.xyz() + self.turn().cross(ray)
    }

    fn turn(&self) -> Vector3<f64> {
        self.motion.fixed_rows::<3>(3).into()
    }

    /// Derivatives of where a ray (z = 1) is seen, on that plane, by the readout across and down, as far as the camera turned: how far a ray moves
    /// beside that depends on its depth, and depths may be wrong.
    pub(crate) fn ray_by_readout(
        &self,
        px: &Point2<f64>,
        ray: &Vector3<f64>,
        camera: &Camera,
    ) -> [Vector2<f64>; 2] {
        let drift = self.turn().cross(ray);
        let on_plane = drift.xy() - ray.xy() * drift.z;
        let place = place_in_image(px, camera);
        [on_plane * place.x, on_plane * place.y]
    }

    /// The image as it would be with all pixels exposed in the middle of the time; beyond its border its last pixels go on.
    #[must_use]
    pub fn at_once(&self, image: &GrayImage, camera: &Camera) -> GrayImage {
        let (width, height) = (image.width(), image.height());
        let (columns, rows) = (width.div_ceil(CELL_PX) + 1, height.div_ceil(CELL_PX) + 1);
        let corner = |i: usize| ((i % columns) * CELL_PX, (i / columns) * CELL_PX);
        let shifts: Vec<Vector2<f32>> = (0..columns * rows)
            .map(|i| {
                let (x, y) = corner(i);
                let px = Point2::new(x as f64, y as f64);
                (self.px_seen(&px, camera) - px).cast()
            })
            .collect();
        let mut out = GrayImage::new(width, height);
        for (y, row) in out.data_mut().chunks_exact_mut(width.max(1)).enumerate() {
            let above = &shifts[y / CELL_PX * columns..][..columns];
            let below = &shifts[(y / CELL_PX + 1) * columns..][..columns];
            let down = (y % CELL_PX) as f32 / CELL_PX as f32;
            let at = |i: usize| above[i] + (below[i] - above[i]) * down;
            for (cell, pixels) in row.chunks_mut(CELL_PX).enumerate() {
                let (first, last) = (at(cell), at(cell + 1));
                let start = Vector2::new((cell * CELL_PX) as f32, y as f32) + first;
                let step = (last - first) / CELL_PX as f32 + Vector2::x();
                sample_along(image, &start.map(fixed), &step.map(fixed), pixels);
            }
        }
        out
    }

    /// Where a pixel of the image of [`Exposure::at_once`] is seen.
    pub(crate) fn px_seen(&self, px: &Point2<f64>, camera: &Camera) -> Point2<f64> {
        let ray = camera.bearing(px);
        let drift = self.drift(&ray);
        let mut seen = *px;
        // Where it is seen tells when.
        for _ in 0..2 {
            let moved = ray + drift * self.readout.secs_at(&seen, camera);
            seen = camera.project(&moved.into()).unwrap_or(seen);
        }
        seen
    }

    /// Where a pixel of the image is in that of [`Exposure::at_once`].
    pub(crate) fn px_at_once(&self, px: &Point2<f64>, camera: &Camera) -> Point2<f64> {
        let mut there = *px;
        for _ in 0..2 {
            there += px - self.px_seen(&there, camera);
        }
        there
    }
}

/// A place with 16 bits behind its point.
fn fixed(value: f32) -> i64 {
    (value * (1 << u16::BITS) as f32) as i64
}

/// An image at places on a line, between its pixels; beyond its border its last pixels go on.
fn sample_along(image: &GrayImage, start: &Vector2<i64>, step: &Vector2<i64>, out: &mut [u8]) {
    let (width, height) = (image.width(), image.height());
    // Just before the last column and row.
    let last = Vector2::new(width, height).map(|size| ((size.saturating_sub(1) as i64) << u16::BITS) - 1);
    let mut place = *start;
    for pixel in out {
        let (x, y) = (place.x.min(last.x).max(0) as usize, place.y.min(last.y).max(0) as usize);
        let first = (y >> u16::BITS) * width + (x >> u16::BITS);
        let [along, down] = [x, y].map(|at| u32::from((at >> u8::BITS) as u8));
        let Some(pixels) = image.data().get(first..first + width + 2) else { break };
        let [a, b, c, d] = [0, 1, width, width + 1].map(|i| u32::from(pixels[i]));
        let [top, bottom] =
            [(a, b), (c, d)].map(|(left, right)| (left << u8::BITS) + along * right - along * left);
        let value = (top << u8::BITS) + down * bottom - down * top;
        *pixel = ((value + (1 << (u16::BITS - 1))) >> u16::BITS) as u8;
        place += step;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::pinhole((320, 240), (262.5, 262.5), (159.5, 119.5)).unwrap()
    }

    fn exposure(readout: Vector2<f64>) -> Exposure {
        Exposure { motion: Vector6::new(0.1, -0.2, 0.1, 0.6, -1.3, 0.9), readout: Readout(readout) }
    }

    /// Gray levels of a smooth scene along a ray.
    fn scene(ray: &Vector3<f64>) -> f64 {
        128.0 + 50.0 * (9.0 * ray.x / ray.z).sin() + 50.0 * (11.0 * ray.y / ray.z).cos()
    }

    #[test]
    fn an_image_is_put_right_by_the_motion_of_its_rows() {
        let camera = camera();
        for readout in [Vector2::new(0.0, 0.025), Vector2::new(-0.03, 0.0)] {
            let exposure = exposure(readout);
            let (mut taken, mut wanted) = (GrayImage::new(320, 240), GrayImage::new(320, 240));
            for i in 0..320 * 240 {
                let px = Point2::new((i % 320) as f64, (i / 320) as f64);
                let ray = camera.bearing(&px);
                wanted.data_mut()[i] = scene(&ray) as u8;
                // A ray is seen at the pixel when the scene has moved from where it was in the middle of the time.
                let secs = exposure.readout.secs_at(&px, &camera);
                let back = crate::lie::exp::<visloc_core::geom::CameraFrame>(&(exposure.motion * -secs));
                taken.data_mut()[i] = scene(&back.transform(&ray.into()).coords) as u8;
            }
            let put_right = exposure.at_once(&taken, &camera);
            let worst = |other: &GrayImage| {
                let inside = (12..228).flat_map(|y| (12..308).map(move |x| (x, y)));
                inside.map(|(x, y)| other.get(x, y).abs_diff(wanted.get(x, y))).max().unwrap()
            };
            assert!(worst(&taken) > 12, "{}", worst(&taken));
            assert!(worst(&put_right) <= 3, "{}", worst(&put_right));
        }
    }

    #[test]
    fn pixels_go_where_their_image_goes() {
        let (camera, mut exposure) = (camera(), exposure(Vector2::new(0.0, 0.02)));
        for px in [Point2::new(10.0, 5.0), Point2::new(200.3, 220.0), Point2::new(160.0, 119.0)] {
            let there = exposure.px_at_once(&px, &camera);
            assert!((exposure.px_seen(&there, &camera) - px).norm() < 0.02);
        }
        // A camera that only turns, and a derivative.
        exposure.motion.fixed_rows_mut::<3>(0).fill(0.0);
        exposure.readout.0 *= 0.01;
        for px in [Point2::new(10.0, 5.0), Point2::new(200.3, 220.0)] {
            let ray = camera.bearing(&exposure.px_at_once(&px, &camera));
            let by = exposure.ray_by_readout(&px, &ray, &camera);
            let seen = ray.xy() + by[0] * exposure.readout.0.x + by[1] * exposure.readout.0.y;
            assert!((seen - camera.bearing(&px).xy()).norm() < 1e-5, "{seen}");
        }
    }

    #[test]
    fn what_is_right_stays_as_it_is() {
        let mut image = GrayImage::new(33, 17);
        image.data_mut().iter_mut().enumerate().for_each(|(i, value)| *value = (i * 7) as u8);
        let camera = Camera::pinhole((33, 17), (30.0, 30.0), (16.0, 8.0)).unwrap();
        let exposure = exposure(Vector2::new(0.0, 0.02));
        let none = exposure.left_by(&exposure.readout);
        assert!(none.readout.is_at_once());
        let same = none.at_once(&image, &camera);
        for (x, y) in (0..32).flat_map(|x| (0..16).map(move |y| (x, y))) {
            assert_eq!(same.get(x, y), image.get(x, y), "{x}, {y}");
        }
    }
}
