//! What the world looks like: surfaces with textures and light.
//!
//! A [`Scene`] is a list of quads, cylinders and spheres. [`Scene::new`] takes the lamps; `add_` methods take shapes
//! with paint and work out the light once. Builders for whole things are one file each: `field` (carpet, goals, ball),
//! `room` (floor, walls, ceiling), `office` (corridors
//! with doors), `furniture`, `figures` (robots and people, which may move).

mod build;
mod canvas;
mod color;
mod field;
mod figures;
mod furniture;
mod glyphs;
mod ground_marks;
mod label;
mod light;
mod noise;
mod office;
mod paint;
mod room;
mod surface;
mod texture;

pub use build::Scene;
pub use canvas::Canvas;
pub use color::Color;
pub(crate) use color::linear_to_srgb;
pub use field::FieldLook;
pub use figures::{Figure, FigureKind};
pub use furniture::FurnitureKind;
pub(crate) use ground_marks::GroundMark;
pub use label::Label;
pub use light::{Lamp, LightGrid};
pub(crate) use office::{office_lamps, spots};
pub use paint::{Paint, Pattern};
pub use room::Room;
pub use surface::{Cuboid, Lighting, Shape, Surface, TextureId};
pub(crate) use texture::Footprint;
pub use texture::{Texture, Wrap};
