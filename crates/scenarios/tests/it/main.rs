//! End-to-end tests.

#![allow(clippy::unwrap_used)] // a test may stop

mod determinism;
mod localization;
mod model_agreement;
