//! A simulated robot that people drive and kidnap, with several algorithms that look for it in the same images.
//!
//! `session` is the whole, `driver` moves the robot, `likelihood` how well every place explains the image, `world` what people
//! change around the robot. The algorithms with their parameters are a [`visloc_locate::lineup::Lineup`].

mod driver;
mod likelihood;
mod session;
mod world;

pub use session::{PLACES, Place, Playground};
