//! Which surface each pixel sees.

use nalgebra::Vector3;

use super::{
    prepare::{Local, Prepared},
    rays::Rays,
};

/// No surface.
pub(super) const NOTHING: u32 = u32::MAX;

/// For each pixel the nearest surface (index in the list of prepared surfaces) and its inverse depth.
#[derive(Debug)]
pub(super) struct Visible {
    pub(super) nearest: Vec<u32>,
    pub(super) inverse_depth: Vec<f32>,
}

impl Visible {
    pub(super) fn new(num_pixels: usize) -> Self {
        Self { nearest: vec![NOTHING; num_pixels], inverse_depth: vec![0.0; num_pixels] }
    }

    pub(super) fn clear(&mut self) {
        self.nearest.fill(NOTHING);
        self.inverse_depth.fill(0.0);
    }

    /// Enters a surface into all pixels where it is the nearest so far.
    pub(super) fn draw(&mut self, prepared: &Prepared, id: u32, rays: &Rays) {
        for row in prepared.rows.clone() {
            let range = row * rays.width + prepared.columns.start..row * rays.width + prepared.columns.end;
            let (x, y) = (&rays.x[range.clone()], &rays.y[range.clone()]);
            let depth = &mut self.inverse_depth[range.clone()];
            let nearest = &mut self.nearest[range];
            match &prepared.local {
                Local::Quad { n, a, b, .. } => draw_quad_row([n, a, b], id, (x, y), depth, nearest),
                round => {
                    for (i, (x, y)) in x.iter().zip(y).enumerate() {
                        let w = inverse_depth(round, *x, *y);
                        if w > depth[i] {
                            depth[i] = w;
                            nearest[i] = id;
                        }
                    }
                }
            }
        }
    }
}

/// Free of branches, so that the compiler does several pixels at once.
fn draw_quad_row(
    [n, a, b]: [&Vector3<f32>; 3],
    id: u32,
    (x, y): (&[f32], &[f32]),
    depth: &mut [f32],
    nearest: &mut [u32],
) {
    let len = x.len();
    assert!(y.len() == len && depth.len() == len && nearest.len() == len, "rows of one length");
    for i in 0..len {
        let w = n.x * x[i] + n.y * y[i] + n.z;
        let u = a.x * x[i] + a.y * y[i] + a.z;
        let v = b.x * x[i] + b.y * y[i] + b.z;
        let is_hit = (w > depth[i]) & (u >= 0.0) & (u <= w) & (v >= 0.0) & (v <= w);
        depth[i] = if is_hit { w } else { depth[i] };
        nearest[i] = if is_hit { id } else { nearest[i] };
    }
}

/// Inverse depth at which the ray (x, y, 1) meets a shape; 0 if it does not.
#[inline]
pub(super) fn inverse_depth(local: &Local, x: f32, y: f32) -> f32 {
    let ray = Vector3::new(x, y, 1.0);
    match local {
        Local::Quad { n, a, b, .. } => {
            let (w, u, v) = (n.dot(&ray), a.dot(&ray), b.dot(&ray));
            if w > 0.0 && u >= 0.0 && u <= w && v >= 0.0 && v <= w { w } else { 0.0 }
        }
        Local::Sphere { center, clearance, .. } => {
            let (aa, ab) = (ray.norm_squared(), ray.dot(center));
            let discriminant = ab * ab - aa * clearance;
            if discriminant <= 0.0 {
                return 0.0;
            }
            let z = (ab - discriminant.sqrt()) / aa;
            if z > 0.0 { 1.0 / z } else { 0.0 }
        }
        Local::Cylinder { axis, across, base_along, length_m, radius_m, clearance } => {
            // The parts of the ray across the axis: their products with `across` need no projection.
            let (ray_along, ab) = (ray.dot(axis), ray.dot(across));
            let aa = (ray.norm_squared() - ray_along * ray_along).max(1e-9);
            let discriminant = ab * ab - aa * clearance;
            if discriminant <= 0.0 {
                return 0.0;
            }
            let z = (ab - discriminant.sqrt()) / aa;
            let along = z * ray_along - base_along;
            if z > 0.0 && (0.0..=*length_m).contains(&along) {
                return 1.0 / z;
            }
            // The ray enters through the flat end that it meets first, or misses.
            let end = if ray_along > 0.0 { *base_along } else { base_along + length_m };
            let z = end / ray_along;
            let outwards = (ray - axis * ray_along) * z - across;
            let is_hit = z > 0.0 && outwards.norm_squared() <= radius_m * radius_m;
            if is_hit { 1.0 / z } else { 0.0 }
        }
    }
}
