//! The color of a point of a surface.

use nalgebra::Vector3;

use super::prepare::{Local, Prepared};
use crate::scene::{Footprint, Lighting, Surface, Texture};

/// Light (red, green, blue) that comes from a surface along the ray (x, y, 1), and its opacity. `w` is the inverse depth
/// of the hit, `pitch` the step of the rays from pixel to pixel.
#[inline]
pub(super) fn shade(
    prepared: &Prepared,
    surface: &Surface,
    texture: &Texture,
    (x, y, w): (f32, f32, f32),
    pitch: (f32, f32),
) -> [f32; 4] {
    let ray = Vector3::new(x, y, 1.0);
    let (color, light) = match &prepared.local {
        Local::Quad { n, a, b, normal } => {
            let depth = 1.0 / w;
            let (u, v) = (a.dot(&ray) * depth, b.dot(&ray) * depth);
            let light = match &surface.lighting {
                Lighting::Grid(grid) => grid.at(u, v),
                Lighting::Even(light) => *light,
                Lighting::Shaded { ambient, .. } => ambient + normal.dot(&prepared.toward_light).max(0.0),
            };
            if texture.is_flat() {
                (texture.mean(), light)
            } else {
                // Derivatives of u = (a.d) / (n.d) and v by the ray's x and y.
                let (repeat_u, repeat_v) = surface.repeats;
                let (to_right, to_down) = (pitch.0 * depth, pitch.1 * depth);
                let footprint = Footprint {
                    right: [
                        (a.x - u * n.x) * to_right * repeat_u,
                        (b.x - v * n.x) * to_right * repeat_v,
                    ],
                    down: [(a.y - u * n.y) * to_down * repeat_u, (b.y - v * n.y) * to_down * repeat_v],
                };
                (texture.sample([u * repeat_u, v * repeat_v], &footprint), light)
            }
        }
        Local::Cylinder { base, axis, length_m, radius_m } => {
            let from_base = ray / w - base;
            let along = from_base.dot(axis);
            let across = from_base - axis * along;
            let is_end = across.norm_squared() < radius_m * radius_m * 0.998;
            let normal = match (is_end, along * 2.0 > *length_m) {
                (false, _) => across / *radius_m,
                (true, true) => *axis,
                (true, false) => -axis,
            };
            let light = round_light(surface, prepared, &normal);
            let size_m = (std::f32::consts::TAU * radius_m, *length_m);
            let around = normal.x.atan2(normal.z);
            (round_color(texture, (around, along / length_m), size_m, pitch.0 / w), light)
        }
        Local::Sphere { center, radius_m } => {
            let normal = (ray / w - center) / *radius_m;
            let light = round_light(surface, prepared, &normal);
            let size_m = (std::f32::consts::TAU * radius_m, std::f32::consts::PI * radius_m);
            let around = normal.x.atan2(normal.z);
            (round_color(texture, (around, 0.5 + normal.y * 0.5), size_m, pitch.0 / w), light)
        }
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

/// Color at an angle around and a share along a round shape, seen by pixels of a width in meters.
#[inline]
fn round_color(texture: &Texture, at: (f32, f32), size_m: (f32, f32), pixel_m: f32) -> [f32; 4] {
    if texture.is_flat() {
        return texture.mean();
    }
    let u = at.0 / std::f32::consts::TAU + 0.5;
    let footprint = Footprint { right: [pixel_m / size_m.0, 0.0], down: [0.0, pixel_m / size_m.1] };
    texture.sample([u, at.1], &footprint)
}
