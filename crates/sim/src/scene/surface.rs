//! The shapes that a scene is made of.

use nalgebra::{Point3, Vector3};

use super::{Label, light::LightGrid};

/// Index of a texture in a [`super::Scene`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureId(pub(crate) u32);

/// Shape of a surface in the world frame, meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A parallelogram, seen from both sides. The texture's top-left corner is at `corner`; its width runs along
    /// `right`, its height along `down`.
    Quad {
        /// Where the texture begins.
        corner: Point3<f32>,
        /// Along the texture's width.
        right: Vector3<f32>,
        /// Along the texture's height.
        down: Vector3<f32>,
    },
    /// A round bar with flat ends.
    Cylinder {
        /// Middle of one end.
        base: Point3<f32>,
        /// From one end to the other.
        axis: Vector3<f32>,
        /// Half the thickness.
        radius_m: f32,
    },
    /// A ball.
    Sphere {
        /// Its middle.
        center: Point3<f32>,
        /// Half its diameter.
        radius_m: f32,
    },
}

/// Light that falls on a surface, relative to the mean on the floor.
#[derive(Debug, Clone)]
pub enum Lighting {
    /// The same everywhere; also what a lamp emits.
    Even(f32),
    /// Sampled over a quad.
    Grid(LightGrid),
    /// For round and moving things: `ambient + max(0, normal . toward)`.
    Shaded {
        /// From all sides.
        ambient: f32,
        /// Points to the light, its length is the strength.
        toward: Vector3<f32>,
    },
}

/// A shape with its texture and light.
#[derive(Debug, Clone)]
pub struct Surface {
    pub(crate) shape: Shape,
    pub(crate) texture: TextureId,
    /// How often the texture repeats along its width and height.
    pub(crate) repeats: (f32, f32),
    pub(crate) lighting: Lighting,
    /// Laid over what is behind it, by the texture's opacity.
    pub(crate) is_overlay: bool,
    /// What it is; [`Label::Carpet`] has the field's lines on it.
    pub(crate) label: Label,
}

impl Surface {
    /// An opaque surface that shows its texture once.
    pub fn new(shape: Shape, texture: TextureId, lighting: Lighting) -> Self {
        Self { shape, texture, repeats: (1.0, 1.0), lighting, is_overlay: false, label: Label::Other }
    }

    /// The same surface as part of something.
    #[must_use]
    pub fn labelled(self, label: Label) -> Self {
        Self { label, ..self }
    }
}

impl Shape {
    /// A vertical quad standing on the line from `from` to `to` (x and y in meters), as seen by somebody who has
    /// `from` at the left.
    pub fn upright(from: (f32, f32), to: (f32, f32), bottom_m: f32, height_m: f32) -> Self {
        Self::Quad {
            corner: Point3::new(from.0, from.1, bottom_m + height_m),
            right: Vector3::new(to.0 - from.0, to.1 - from.1, 0.0),
            down: Vector3::new(0.0, 0.0, -height_m),
        }
    }

    /// A horizontal quad around a center, at a height, with its width along x.
    pub fn level(center: (f32, f32), size: (f32, f32), z_m: f32) -> Self {
        Self::Quad {
            corner: Point3::new(center.0 - size.0 / 2.0, center.1 + size.1 / 2.0, z_m),
            right: Vector3::new(size.0, 0.0, 0.0),
            down: Vector3::new(0.0, -size.1, 0.0),
        }
    }

    /// A point in the middle of the shape.
    pub(crate) fn middle(&self) -> Point3<f32> {
        match self {
            Self::Quad { corner, right, down } => corner + (right + down) * 0.5,
            Self::Cylinder { base, axis, .. } => base + axis * 0.5,
            Self::Sphere { center, .. } => *center,
        }
    }

    /// Width and height of the texture on the shape, meters.
    pub(crate) fn size_m(&self) -> (f32, f32) {
        match self {
            Self::Quad { right, down, .. } => (right.norm(), down.norm()),
            Self::Cylinder { axis, radius_m, .. } => (std::f32::consts::TAU * radius_m, axis.norm()),
            Self::Sphere { radius_m, .. } => {
                (std::f32::consts::TAU * radius_m, std::f32::consts::PI * radius_m)
            }
        }
    }
}

/// A box with its bottom on a horizontal plane, turned about the vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuboid {
    /// Middle of the bottom, meters.
    pub center: Point3<f32>,
    /// Length along its own x and y axis and height, meters.
    pub size: Vector3<f32>,
    /// Turn about the vertical, radians.
    pub yaw_rad: f32,
}

impl Cuboid {
    /// Front (its own +x side), back, left, right and top. Nobody sees the bottom.
    pub fn faces(&self) -> [Shape; 5] {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let (x, y) = (self.size.x / 2.0, self.size.y / 2.0);
        let at = |x: f32, y: f32| (self.center.x + cos * x - sin * y, self.center.y + sin * x + cos * y);
        let side = |from, to| Shape::upright(from, to, self.center.z, self.size.z);
        let (corner_x, corner_y) = at(-x, y);
        let top = Shape::Quad {
            corner: Point3::new(corner_x, corner_y, self.center.z + self.size.z),
            right: Vector3::new(cos, sin, 0.0) * self.size.x,
            down: Vector3::new(sin, -cos, 0.0) * self.size.y,
        };
        [
            side(at(x, -y), at(x, y)),
            side(at(-x, y), at(-x, -y)),
            side(at(x, y), at(-x, y)),
            side(at(-x, -y), at(x, -y)),
            top,
        ]
    }
}
