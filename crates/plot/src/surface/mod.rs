//! A value for each place of the ground as a surface in space, seen obliquely from above.

mod draw;
mod view;

pub use draw::surface_picture;
