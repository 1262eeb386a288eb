//! Motion blur.

use nalgebra::Vector3;
use visloc_geom::{CameraFrame, Rigid3, World};

use super::raster::Visible;
use super::rays::Rays;

/// Blur shorter than this is not worth the time, pixels.
const SHORTEST_PX: f32 = 0.7;
/// Longer blur is cut off, pixels.
const LONGEST_PX: f32 = 24.0;

/// Motion of the camera while the shutter is open, in the frame of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CameraMotion {
    /// Way of the center of projection, meters.
    pub translation_m: Vector3<f64>,
    /// Turn as axis times angle, radians.
    pub rotation_rad: Vector3<f64>,
}

impl CameraMotion {
    /// The motion from the pose at the opening of the shutter to the pose at its closing, for small turns.
    #[must_use]
    pub fn between(
        world_from_opening: &Rigid3<World, CameraFrame>,
        world_from_closing: &Rigid3<World, CameraFrame>,
    ) -> Self {
        let opening_from_closing = world_from_opening.inverse() * *world_from_closing;
        let r = opening_from_closing.rotation();
        let rotation_rad =
            Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]) / 2.0;
        Self { translation_m: *opening_from_closing.translation(), rotation_rad }
    }
}

/// How far the image of a still point moves, pixels, for the ray (x, y, 1) and inverse depth w.
fn flow_px(motion: &(Vector3<f32>, Vector3<f32>), (x, y, w): (f32, f32, f32), pitch: (f32, f32)) -> (f32, f32) {
    let (t, r) = motion;
    let turn = r.x * y - r.y * x;
    let dx = (x * t.z - t.x) * w - (r.y - r.z * y) + x * turn;
    let dy = (y * t.z - t.y) * w - (r.z * x - r.x) + y * turn;
    (dx / pitch.0, dy / pitch.1)
}

/// Averages every pixel along the way that its surface point takes over the image. Returns whether anything was done.
pub(super) fn blur(
    sharp: &[[f32; 4]],
    blurred: &mut [[f32; 4]],
    motion: &CameraMotion,
    visible: &Visible,
    rays: &Rays,
) -> bool {
    let motion = (motion.translation_m.cast::<f32>(), motion.rotation_rad.cast::<f32>());
    let (width, height) = (rays.width, rays.height);
    let is_worth_it = [0, width - 1, width * (height - 1), width * height - 1, width * (height / 2) + width / 2]
        .iter()
        .map(|i| flow_px(&motion, (rays.x[*i], rays.y[*i], visible.inverse_depth[*i]), rays.pitch))
        .any(|(dx, dy)| dx.hypot(dy) > SHORTEST_PX);
    if !is_worth_it {
        return false;
    }
    let (last_x, last_y) = (width as i32 - 1, height as i32 - 1);
    for row in 0..height {
        for column in 0..width {
            let i = row * width + column;
            let at = (rays.x[i], rays.y[i], visible.inverse_depth[i]);
            let (dx, dy) = flow_px(&motion, at, rays.pitch);
            let length_px = (dx * dx + dy * dy).sqrt().clamp(1e-3, LONGEST_PX);
            let taps = (length_px + 1.0) as i32;
            let step = 1.0 / taps as f32;
            let mut sum = [0.0_f32; 4];
            for tap in 0..taps {
                // Half a pixel of rounding and 64 against negative numbers, which would round up.
                let s = (tap as f32 + 0.5) * step - 0.5;
                let x = ((column as f32 + dx * s + 64.5) as i32 - 64).clamp(0, last_x);
                let y = ((row as f32 + dy * s + 64.5) as i32 - 64).clamp(0, last_y);
                let color = &sharp[(y * (last_x + 1) + x) as usize];
                for (total, part) in sum.iter_mut().zip(color) {
                    *total += part;
                }
            }
            blurred[i] = sum.map(|part| part * step);
        }
    }
    true
}
