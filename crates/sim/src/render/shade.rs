//! The colors of surfaces.

use nalgebra::Vector3;

use super::prepare::{Local, Prepared};
use crate::scene::{Footprint, Lighting, Surface, Texture};

/// Pixels that share the light's slope and the footprint: both change slowly along a row.
const CHUNK: usize = 8;

/// Some neighboring pixels of one row: the rays and where they hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run<'a> {
    pub(super) x: &'a [f32],
    pub(super) y: &'a [f32],
    pub(super) inverse_depth: &'a [f32],
    /// Step of the rays from pixel to pixel.
    pub(super) pitch: (f32, f32),
}

/// Colors (light of red, green, blue and opacity) of a run of pixels that all see the same surface.
pub(super) fn shade_run(
    prepared: &Prepared,
    surface: &Surface,
    texture: &Texture,
    run: Run<'_>,
    out: &mut [[f32; 4]],
) {
    for from in (0..out.len()).step_by(CHUNK) {
        let range = from..(from + CHUNK).min(out.len());
        let chunk = Run {
            x: &run.x[range.clone()],
            y: &run.y[range.clone()],
            inverse_depth: &run.inverse_depth[range.clone()],
            pitch: run.pitch,
        };
        match &prepared.local {
            Local::Quad { n, a, b, normal } => {
                let quad = Quad { n, a, b, surface, pitch: run.pitch };
                let even_light = match &surface.lighting {
                    Lighting::Grid(_) => None,
                    Lighting::Even(light) => Some(*light),
                    Lighting::Shaded { ambient, .. } => {
                        Some(ambient + normal.dot(&prepared.toward_light).max(0.0))
                    }
                };
                quad.shade(even_light, texture, chunk, &mut out[range]);
            }
            _ => {
                for (i, color) in out[range].iter_mut().enumerate() {
                    let at = (chunk.x[i], chunk.y[i], chunk.inverse_depth[i]);
                    *color = shade_round(prepared, surface, texture, at, run.pitch.0);
                }
            }
        }
    }
}

/// See [`Local::Quad`].
struct Quad<'a> {
    n: &'a Vector3<f32>,
    a: &'a Vector3<f32>,
    b: &'a Vector3<f32>,
    surface: &'a Surface,
    pitch: (f32, f32),
}

impl Quad<'_> {
    #[inline]
    fn uv(&self, x: f32, y: f32, inverse_depth: f32) -> (f32, f32) {
        let depth = 1.0 / inverse_depth;
        let (a, b) = (self.a, self.b);
        ((a.x * x + a.y * y + a.z) * depth, (b.x * x + b.y * y + b.z) * depth)
    }

    fn shade(&self, even_light: Option<f32>, texture: &Texture, run: Run<'_>, out: &mut [[f32; 4]]) {
        let last = out.len() - 1;
        let uv_at = |i: usize| self.uv(run.x[i], run.y[i], run.inverse_depth[i]);
        let (light, light_step) = match (&self.surface.lighting, even_light) {
            (Lighting::Grid(grid), None) => {
                let ((u0, v0), (u1, v1)) = (uv_at(0), uv_at(last));
                let (first, end) = (grid.at(u0, v0), grid.at(u1, v1));
                (first, (end - first) / last.max(1) as f32)
            }
            (_, even) => (even.unwrap_or(1.0), 0.0),
        };
        let mean = texture.mean();
        if texture.is_flat() {
            for (i, color) in out.iter_mut().enumerate() {
                let light = light + light_step * i as f32;
                *color = [mean[0] * light, mean[1] * light, mean[2] * light, mean[3]];
            }
            return;
        }
        let (repeat_u, repeat_v) = self.surface.repeats;
        let middle = out.len() / 2;
        let taps = texture.taps(&self.footprint(uv_at(middle), 1.0 / run.inverse_depth[middle]));
        for (i, color) in out.iter_mut().enumerate() {
            let (u, v) = uv_at(i);
            let paint = taps.sample([u * repeat_u, v * repeat_v]);
            let light = light + light_step * i as f32;
            *color = [paint[0] * light, paint[1] * light, paint[2] * light, paint[3]];
        }
    }

    /// Derivatives of u = (a.d) / (n.d) and v by the ray's x and y.
    fn footprint(&self, (u, v): (f32, f32), depth: f32) -> Footprint {
        let (repeat_u, repeat_v) = self.surface.repeats;
        let (to_right, to_down) = (self.pitch.0 * depth, self.pitch.1 * depth);
        let (n, a, b) = (self.n, self.a, self.b);
        Footprint {
            right: [(a.x - u * n.x) * to_right * repeat_u, (b.x - v * n.x) * to_right * repeat_v],
            down: [(a.y - u * n.y) * to_down * repeat_u, (b.y - v * n.y) * to_down * repeat_v],
        }
    }
}

/// The color of a cylinder or sphere along the ray (x, y, 1) at an inverse depth w, for rays a `pitch` apart.
#[inline]
fn shade_round(
    prepared: &Prepared,
    surface: &Surface,
    texture: &Texture,
    (x, y, w): (f32, f32, f32),
    pitch: f32,
) -> [f32; 4] {
    let hit = Vector3::new(x, y, 1.0) / w;
    let (normal, along, size_m) = match &prepared.local {
        Local::Quad { normal, .. } => (*normal, 0.5, (1.0, 1.0)),
        Local::Cylinder { axis, across, base_along, length_m, radius_m, .. } => {
            let along = hit.dot(axis);
            let outwards = hit - axis * along - across;
            let share = (along - base_along) / length_m;
            let is_end = outwards.norm_squared() < radius_m * radius_m * 0.998;
            let normal = match (is_end, share > 0.5) {
                (false, _) => outwards / *radius_m,
                (true, true) => *axis,
                (true, false) => -axis,
            };
            (normal, share, (std::f32::consts::TAU * radius_m, *length_m))
        }
        Local::Sphere { center, radius_m, .. } => {
            let normal = (hit - center) / *radius_m;
            let size_m = (std::f32::consts::TAU * radius_m, std::f32::consts::PI * radius_m);
            (normal, 0.5 + normal.y * 0.5, size_m)
        }
    };
    let light = round_light(surface, prepared, &normal);
    let color = if texture.is_flat() {
        texture.mean()
    } else {
        let u = normal.x.atan2(normal.z) / std::f32::consts::TAU + 0.5;
        let pixel_m = pitch / w;
        let footprint = Footprint { right: [pixel_m / size_m.0, 0.0], down: [0.0, pixel_m / size_m.1] };
        texture.taps(&footprint).sample([u, along])
    };
    [color[0] * light, color[1] * light, color[2] * light, color[3]]
}

#[inline]
fn round_light(surface: &Surface, prepared: &Prepared, normal: &Vector3<f32>) -> f32 {
    match &surface.lighting {
        Lighting::Shaded { ambient, .. } => ambient + normal.dot(&prepared.toward_light).max(0.0),
        Lighting::Even(light) => *light,
        Lighting::Grid(grid) => grid.at(0.5, 0.5),
    }
}
