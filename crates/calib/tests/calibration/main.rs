//! Detector and solver against rendered boards with known truth, and against real photos.

mod detector;
mod lines;
mod solver;
mod support;
