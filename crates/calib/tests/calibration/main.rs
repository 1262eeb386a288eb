//! Detector and solver against rendered boards with known truth, and against real photos.

// Helpers of tests are no tests for the lint, but they may stop in the same way.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod detector;
mod lines;
mod solver;
mod support;
