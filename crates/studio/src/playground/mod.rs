//! A simulated robot that people drive and kidnap, with several algorithms that look for it in the same images.
//!
//! `session` is the whole, `driver` moves the robot, `contender` is one algorithm with its parameters, `likelihood` how well
//! every place explains the image, `world` what people
//! change around the robot.

mod contender;
mod driver;
mod likelihood;
mod overrides;
mod scene;
mod session;
mod world;

pub use session::{PLACES, Place, Playground};
