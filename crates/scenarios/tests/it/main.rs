//! End-to-end tests.

mod determinism;
mod localization;
mod model_agreement;
