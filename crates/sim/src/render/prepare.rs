//! Surfaces in the camera frame, bounded on the screen.

use std::ops::Range;

use nalgebra::{Matrix3, Point3, Vector3};

use super::rays::Rays;
use crate::scene::{Lighting, Shape, Surface};

/// Nothing nearer than this to the camera's center is drawn, meters.
const NEAR_M: f32 = 0.02;

/// The transform of points from the world to the camera, in the renderer's precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    pub(super) camera_from_world: Matrix3<f32>,
    pub(super) camera_in_world: Point3<f32>,
}

impl View {
    fn point(&self, point: &Point3<f32>) -> Vector3<f32> {
        self.camera_from_world * (point - self.camera_in_world)
    }

    fn direction(&self, direction: &Vector3<f32>) -> Vector3<f32> {
        self.camera_from_world * direction
    }
}

/// A shape in the camera frame, arranged for the intersection with rays (x, y, 1). Every intersection gives the
/// inverse depth w = 1 / z, which is larger for nearer points.
#[derive(Debug, Clone, Copy)]
pub(super) enum Local {
    /// With d the ray: w = n.d, and texture coordinates u = a.d / w, v = b.d / w.
    Quad { n: Vector3<f32>, a: Vector3<f32>, b: Vector3<f32>, normal: Vector3<f32> },
    /// `across` is the vector from the camera to the axis, at a right angle to it; `base_along` where the base lies on
    /// the axis from there; `clearance` the squared distance of the axis less the squared radius.
    Cylinder {
        axis: Vector3<f32>,
        across: Vector3<f32>,
        base_along: f32,
        length_m: f32,
        radius_m: f32,
        clearance: f32,
    },
    /// `clearance` is the squared distance of the center less the squared radius.
    Sphere { center: Vector3<f32>, radius_m: f32, clearance: f32 },
}

impl Local {
    /// The inverse depth of a quad's plane along the ray (x, y, 1), an upper bound of that of the quad; infinite for
    /// other shapes.
    #[inline]
    pub(super) fn plane_inverse_depth(&self, x: f32, y: f32) -> f32 {
        match self {
            Self::Quad { n, .. } => n.x * x + n.y * y + n.z,
            _ => f32::INFINITY,
        }
    }
}

/// A surface that may be in view.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub(super) local: Local,
    /// Index in the list of static surfaces, then of moving ones.
    pub(super) surface: u32,
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
    /// Direction to the light in the camera frame, for shaded surfaces.
    pub(super) toward_light: Vector3<f32>,
}

/// `None` if no pixel can see the surface.
pub(super) fn prepare(surface: &Surface, index: u32, view: &View, rays: &Rays) -> Option<Prepared> {
    let (local, x, y) = match &surface.shape {
        Shape::Quad { corner, right, down } => quad(view, corner, right, down)?,
        Shape::Cylinder { base, axis, radius_m } => cylinder(view, base, axis, *radius_m)?,
        Shape::Sphere { center, radius_m } => {
            let center = view.point(center);
            let (x, y) = box_bounds(&[center], *radius_m)?;
            {
                let clearance = center.norm_squared() - radius_m * radius_m;
                (Local::Sphere { center, radius_m: *radius_m, clearance }, x, y)
            }
        }
    };
    let (columns, rows) = rays.touched_by(x, y);
    if columns.is_empty() || rows.is_empty() {
        return None;
    }
    let toward_light = match &surface.lighting {
        Lighting::Shaded { toward, .. } => view.direction(toward),
        _ => Vector3::zeros(),
    };
    Some(Prepared { local, surface: index, columns, rows, toward_light })
}

type Bounded = (Local, (f32, f32), (f32, f32));

fn quad(view: &View, corner: &Point3<f32>, right: &Vector3<f32>, down: &Vector3<f32>) -> Option<Bounded> {
    let (p, r, d) = (view.point(corner), view.direction(right), view.direction(down));
    let (x, y) = polygon_bounds(&[p, p + r, p + r + d, p + d])?;
    // The plane's normal and the edges' dual vectors: u = r_dual . (point - p), v = d_dual . (point - p).
    let cross = r.cross(&d);
    let area2 = cross.norm_squared();
    let offset = cross.dot(&p);
    if area2 < 1e-14 || offset.abs() < 1e-9 {
        return None;
    }
    let (r_dual, d_dual) = (d.cross(&cross) / area2, cross.cross(&r) / area2);
    let n = cross / offset;
    // u w = r_dual . (d - p w) for the ray d = point * w.
    let (a, b) = (r_dual - n * r_dual.dot(&p), d_dual - n * d_dual.dot(&p));
    // The normal of the side that the camera sees.
    let normal = if offset > 0.0 { -cross } else { cross } / area2.sqrt();
    Some((Local::Quad { n, a, b, normal }, x, y))
}

fn cylinder(view: &View, base: &Point3<f32>, axis: &Vector3<f32>, radius_m: f32) -> Option<Bounded> {
    let (base, along) = (view.point(base), view.direction(axis));
    let length_m = along.norm();
    if length_m < 1e-6 {
        return None;
    }
    let (x, y) = box_bounds(&[base, base + along], radius_m)?;
    let axis = along / length_m;
    let base_along = base.dot(&axis);
    let across = base - axis * base_along;
    let clearance = across.norm_squared() - radius_m * radius_m;
    Some((Local::Cylinder { axis, across, base_along, length_m, radius_m, clearance }, x, y))
}

/// Ranges of x / z and y / z over a polygon cut off at the near plane; `None` if nothing is in front of it.
fn polygon_bounds(corners: &[Vector3<f32>; 4]) -> Option<((f32, f32), (f32, f32))> {
    let mut bounds = Extent::default();
    for (i, corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % 4];
        if corner.z >= NEAR_M {
            bounds.include(corner);
        }
        if (corner.z >= NEAR_M) != (next.z >= NEAR_M) {
            let s = (NEAR_M - corner.z) / (next.z - corner.z);
            let mut cut = corner + (next - corner) * s;
            cut.z = NEAR_M;
            bounds.include(&cut);
        }
    }
    bounds.finish()
}

/// Ranges of x / z and y / z over everything within `radius_m` of the line through the points: bounded by camera-aligned
/// boxes. Everything if a box reaches the camera's plane.
fn box_bounds(points: &[Vector3<f32>], radius_m: f32) -> Option<((f32, f32), (f32, f32))> {
    if points.iter().all(|p| p.z + radius_m < NEAR_M) {
        return None;
    }
    if points.iter().any(|p| p.z - radius_m < NEAR_M) {
        let everything = (f32::NEG_INFINITY, f32::INFINITY);
        return Some((everything, everything));
    }
    let mut bounds = Extent::default();
    for p in points {
        for (i, sign) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)] {
            for z in [p.z - radius_m, p.z + radius_m] {
                let mut corner = Vector3::new(p.x, p.y, z);
                corner[i] += sign * radius_m;
                bounds.include(&corner);
            }
        }
    }
    bounds.finish()
}

visloc_core::with_defaults! {
    struct Extent {
        low: (f32, f32) = (f32::INFINITY, f32::INFINITY),
        high: (f32, f32) = (f32::NEG_INFINITY, f32::NEG_INFINITY),
    }
}

impl Extent {
    fn include(&mut self, point: &Vector3<f32>) {
        let (x, y) = (point.x / point.z, point.y / point.z);
        self.low = (self.low.0.min(x), self.low.1.min(y));
        self.high = (self.high.0.max(x), self.high.1.max(y));
    }

    fn finish(self) -> Option<((f32, f32), (f32, f32))> {
        (self.low.0 <= self.high.0).then_some(((self.low.0, self.high.0), (self.low.1, self.high.1)))
    }
}
