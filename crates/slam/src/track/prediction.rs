//! Where the camera probably is before a frame is looked at.

use nalgebra::{Matrix2x3, Matrix3, Point2, Rotation3, Vector2, Vector3, Vector6};
use visloc_core::{
    GrayImage,
    geom::{Camera, CameraFrame, Rigid3},
};

use crate::{
    image::{Pyramid, px_from_level},
    lie::{exp, log, skew},
};

/// Constant velocity.
#[derive(Debug, Clone, Copy, Default)]
pub struct MotionModel {
    /// Motion per second of the camera, `next_from_last` as a twist; `None` until it has moved.
    velocity: Option<Vector6<f64>>,
}

impl MotionModel {
    /// Motion expected within `secs`.
    #[must_use]
    pub fn predict(&self, secs: f64) -> Rigid3<CameraFrame, CameraFrame> {
        exp(&(self.velocity.unwrap_or_default() * secs))
    }

    /// Motion per second; `None` until the camera has moved.
    #[must_use]
    pub fn velocity(&self) -> Option<Vector6<f64>> {
        self.velocity
    }

    /// Learns from the motion of the last `secs`, which are negative where a recording is followed backwards; no time is ignored.
    pub fn update(&mut self, next_from_last: &Rigid3<CameraFrame, CameraFrame>, secs: f64) {
        if secs != 0.0 {
            self.velocity = Some(log(next_from_last) / secs);
        }
    }

    /// Takes over another unit of length.
    pub fn scale(&mut self, factor: f64) {
        if let Some(velocity) = &mut self.velocity {
            velocity.fixed_rows_mut::<3>(0).scale_mut(factor);
        }
    }

    /// Motion per second at the end of a further motion that takes `secs`, if it becomes faster as steadily as it has; `None` without an
    /// earlier motion.
    #[must_use]
    pub fn velocity_after(
        &self,
        next_from_last: &Rigid3<CameraFrame, CameraFrame>,
        secs: f64,
    ) -> Option<Vector6<f64>> {
        let velocity = log(next_from_last) / secs;
        (secs > 0.0).then_some(velocity + (velocity - self.velocity?) * 0.5)
    }

    /// Forgets the motion.
    pub fn reset(&mut self) {
        self.velocity = None;
    }
}

/// Finds the rotation between two images from all pixels of a coarse level.
///
/// Source: Klein and Murray, "Improving the agility of keyframe-based SLAM", 2008; here over SO(3) and inverse compositional.
#[derive(Debug, Clone)]
pub struct RotationAligner {
    camera: Camera,
    level: usize,
    size: (usize, usize),
    /// Rays (z = 1) of all pixels of the level.
    rays: Vec<Vector3<f64>>,
    /// Derivatives of a pixel of the level by a rotation of its ray.
    by_rotation: Vec<Matrix2x3<f64>>,
}

impl RotationAligner {
    /// For one camera and one level of its images.
    #[must_use]
    pub fn new(camera: &Camera, level: usize) -> Self {
        let (width, height) = camera.size_px();
        let size = (width as usize >> level, height as usize >> level);
        let mut rays = Vec::with_capacity(size.0 * size.1);
        let mut by_rotation = Vec::with_capacity(size.0 * size.1);
        for y in 0..size.1 {
            for x in 0..size.0 {
                let ray = camera.bearing(&px_from_level(&Point2::new(x as f64, y as f64), level));
                let by_point =
                    camera.project_with_jacobian(&ray.into()).map_or_else(|_| Matrix2x3::zeros(), |r| r.1);
                by_rotation.push(-by_point * skew(&ray) / f64::from(1_u32 << level));
                rays.push(ray);
            }
        }
        Self { camera: *camera, level, size, rays, by_rotation }
    }

    /// Rotation `current_from_reference`, started from a guess. Falls back to the guess where the images do not fit.
    #[must_use]
    pub fn align(&self, reference: &Pyramid, current: &Pyramid, guess: &Rotation3<f64>) -> Rotation3<f64> {
        if reference.num_levels() <= self.level || current.num_levels() <= self.level {
            return *guess;
        }
        let (reference, current) = (reference.level(self.level), current.level(self.level));
        if (reference.width(), reference.height()) != self.size
            || (current.width(), current.height()) != self.size
        {
            return *guess;
        }
        let mut rotation = *guess;
        let mut best = (f64::INFINITY, *guess);
        for _ in 0..12 {
            let Some((cost, step)) = self.step(reference, current, &rotation) else { break };
            if cost >= best.0 {
                break;
            }
            best = (cost, rotation);
            rotation *= Rotation3::from_scaled_axis(step).inverse();
            if step.norm() < 1e-4 {
                break;
            }
        }
        best.1
    }

    /// Mean squared difference after gain and offset, and the Gauss-Newton step.
    fn step(
        &self,
        reference: &GrayImage,
        current: &GrayImage,
        rotation: &Rotation3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        let (width, height) = self.size;
        let mut samples = Vec::with_capacity(self.rays.len());
        let (mut sum_t, mut sum_s, mut sum_tt, mut sum_ts) = (0.0, 0.0, 0.0, 0.0);
        for y in 1..height - 1 {
            for x in 1..width - 1 {
                let i = y * width + x;
                let Some(value) = self.sample(current, &(rotation * self.rays[i])) else { continue };
                let t = f64::from(reference.get(x, y));
                samples.push((x, y, value));
                sum_t += t;
                sum_s += value;
                sum_tt += t * t;
                sum_ts += t * value;
            }
        }
        let n = samples.len() as f64;
        if n < 0.3 * self.rays.len() as f64 {
            return None;
        }
        let variance = sum_tt / n - (sum_t / n).powi(2);
        let gain = if variance > 1.0 {
            ((sum_ts / n - sum_t * sum_s / n / n) / variance).clamp(0.3, 3.0)
        } else {
            1.0
        };
        let offset = sum_s / n - gain * sum_t / n;
        let (mut hessian, mut gradient, mut cost) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
        for (x, y, value) in samples {
            let i = y * width + x;
            let pixel = |x: usize, y: usize| f64::from(reference.get(x, y));
            let slope =
                Vector2::new(pixel(x + 1, y) - pixel(x - 1, y), pixel(x, y + 1) - pixel(x, y - 1)) * 0.5;
            let jacobian = self.by_rotation[i].transpose() * slope * gain;
            let error = value - gain * pixel(x, y) - offset;
            let weight = 1.0 / (1.0 + (error / 15.0).powi(2));
            hessian += jacobian * jacobian.transpose() * weight;
            gradient += jacobian * error * weight;
            cost += weight * error * error;
        }
        for i in 0..3 {
            hessian[(i, i)] += 1e-3;
        }
        Some((cost / n, hessian.cholesky()?.solve(&gradient)))
    }

    #[inline]
    fn sample(&self, image: &GrayImage, ray: &Vector3<f64>) -> Option<f64> {
        let px = self.camera.project(&(*ray).into()).ok()?;
        let at = crate::image::level_from_px(&px, self.level);
        let is_inside = at.x >= 0.0
            && at.y >= 0.0
            && at.x < image.width() as f64 - 1.0
            && at.y < image.height() as f64 - 1.0;
        if !is_inside {
            return None;
        }
        let (x, y) = (at.x as usize, at.y as usize);
        let (fx, fy) = (at.x - x as f64, at.y - y as f64);
        let pixel = |x: usize, y: usize| f64::from(image.get(x, y));
        let top = pixel(x, y) + fx * (pixel(x + 1, y) - pixel(x, y));
        let bottom = pixel(x, y + 1) + fx * (pixel(x + 1, y + 1) - pixel(x, y + 1));
        Some(top + fy * (bottom - top))
    }
}
