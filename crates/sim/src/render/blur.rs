//! Motion blur.

use nalgebra::Vector3;
use visloc_core::geom::{CameraFrame, Rigid3, World};

use super::{raster::Visible, rays::Rays};

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
fn flow_px(
    motion: &(Vector3<f32>, Vector3<f32>),
    (x, y, w): (f32, f32, f32),
    pitch: (f32, f32),
) -> (f32, f32) {
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
    let is_worth_it =
        [0, width - 1, width * (height - 1), width * height - 1, width * (height / 2) + width / 2]
            .iter()
            .map(|i| flow_px(&motion, (rays.x[*i], rays.y[*i], visible.inverse_depth[*i]), rays.pitch))
            .any(|(dx, dy)| dx.hypot(dy) > SHORTEST_PX);
    if !is_worth_it {
        return false;
    }
    for row in 0..height {
        for column in (0..width).step_by(CHUNK) {
            let len = CHUNK.min(width - column);
            let start = row * width + column;
            let i = start + len / 2;
            let at = (rays.x[i], rays.y[i], visible.inverse_depth[i]);
            let way = Way::new(flow_px(&motion, at, rays.pitch));
            let out = &mut blurred[start..start + len];
            if way.stays_inside((column, row), len, (width, height)) {
                way.average_row(sharp, start, width, out);
            } else {
                for (k, color) in out.iter_mut().enumerate() {
                    *color = way.average_clamped(sharp, (column + k, row), (width, height));
                }
            }
        }
    }
    true
}

/// Neighbors in a row that move alike.
const CHUNK: usize = 8;

/// Taps along the way of an image point, in 1/256 pixel.
struct Way {
    taps: i32,
    step: (i32, i32),
    first: (i32, i32),
}

impl Way {
    fn new((dx, dy): (f32, f32)) -> Self {
        let length_px = (dx * dx + dy * dy).sqrt();
        let shorten = if length_px > LONGEST_PX { LONGEST_PX / length_px } else { 1.0 };
        // Neighbors resemble each other, so three taps for four pixels do.
        let taps = (length_px.min(LONGEST_PX) * 0.75 + 1.3) as i32;
        let scale = 256.0 * shorten / taps as f32;
        let step = ((dx * scale) as i32, (dy * scale) as i32);
        let first = (128 - step.0 * (taps - 1) / 2, 128 - step.1 * (taps - 1) / 2);
        Self { taps, step, first }
    }

    /// Whole pixels from the middle to each tap.
    fn offsets(&self) -> impl Iterator<Item = (i32, i32)> {
        let (step, first) = (self.step, self.first);
        (0..self.taps).map(move |tap| ((first.0 + step.0 * tap) >> 8, (first.1 + step.1 * tap) >> 8))
    }

    fn stays_inside(
        &self,
        (column, row): (usize, usize),
        len: usize,
        (width, height): (usize, usize),
    ) -> bool {
        let inside = |dx: i32, dy: i32| {
            let (x, y) = (column as i32 + dx, row as i32 + dy);
            x >= 0 && y >= 0 && x + len as i32 <= width as i32 && y < height as i32
        };
        let last = self.offsets().last().unwrap_or((0, 0));
        let first = (self.first.0 >> 8, self.first.1 >> 8);
        inside(first.0, first.1) && inside(last.0, last.1)
    }

    /// Means for a row of pixels whose taps are all inside the image.
    fn average_row(&self, image: &[[f32; 4]], start: usize, width: usize, out: &mut [[f32; 4]]) {
        out.fill([0.0; 4]);
        for (dx, dy) in self.offsets() {
            let from = (start as i32 + dy * width as i32 + dx) as usize;
            for (total, color) in out.iter_mut().zip(&image[from..from + CHUNK.min(image.len() - from)]) {
                for part in 0..4 {
                    total[part] += color[part];
                }
            }
        }
        let share = 1.0 / self.taps as f32;
        for part in out.iter_mut().flatten() {
            *part *= share;
        }
    }

    /// The mean for one pixel; beyond the border the border's pixels go on.
    fn average_clamped(
        &self,
        image: &[[f32; 4]],
        (column, row): (usize, usize),
        (width, height): (usize, usize),
    ) -> [f32; 4] {
        let mut sum = [0.0_f32; 4];
        for (dx, dy) in self.offsets() {
            let x = (column as i32 + dx).clamp(0, width as i32 - 1) as usize;
            let y = (row as i32 + dy).clamp(0, height as i32 - 1) as usize;
            let color = image[y * width + x];
            sum = [sum[0] + color[0], sum[1] + color[1], sum[2] + color[2], sum[3] + color[3]];
        }
        sum.map(|part| part / self.taps as f32)
    }
}
