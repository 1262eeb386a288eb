//! End-to-end tests.

#![allow(clippy::unwrap_used)] // a test may stop

mod blind;
mod determinism;
mod feature_detectors;
mod model_agreement;
mod odometry;
mod office;
mod photo;
mod pixels;
mod refined;
mod slam;
mod standing;
mod taught;
mod two_cameras;
