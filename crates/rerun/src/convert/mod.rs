//! From the studio's messages to shapes.

mod camera;
mod converter;
mod events;
mod numbers;
mod plots;
mod read;
mod rings;
mod robot;
mod space;
mod triangles;
mod world;

pub use converter::{Converter, Moment};
