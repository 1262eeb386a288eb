//! Image analysis on drawn images: what is on them is known exactly.

#![allow(clippy::unwrap_used)] // a test may stop

mod features;
mod filters;
mod office;
mod painter;
mod percepts;
