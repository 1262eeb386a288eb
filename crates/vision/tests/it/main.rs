//! Image analysis on drawn images: what is on them is known exactly.

mod filters;
mod painter;
mod percepts;
