//! visloc for Python. What each class does, its shapes and its units stand in `visloc/_visloc.pyi`.

mod arrays;
mod calibration;
mod evaluation;
mod frames;
mod localizer;
mod slam;
mod taught;
mod world;

use std::sync::{Mutex, MutexGuard, PoisonError};

use pyo3::{create_exception, exceptions::PyException, prelude::*};

create_exception!(visloc, VislocError, PyException, "What was expected and found, where, and what to do.");

/// Any error of the library as an exception with the same sentence, causes behind it.
fn refused(error: impl std::error::Error) -> PyErr {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let reason = error.to_string();
        if !text.contains(&reason) {
            text = format!("{text}: {reason}");
        }
        cause = error.source();
    }
    VislocError::new_err(text)
}

/// What only one thread may use at a time.
fn locked<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    // A step that stopped in the middle leaves what it had.
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A sentence of our own.
fn refuse<T>(sentence: impl Into<String>) -> PyResult<T> {
    Err(VislocError::new_err(sentence.into()))
}

#[pymodule]
mod _visloc {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::{
        VislocError,
        calibration::{Calibration, calibrate, find_board},
        evaluation::{evaluate_camera, evaluate_robot},
        frames::{Frame, Frames, Images, frames, images},
        localizer::{Estimate, Hypothesis, Localizer, algorithms},
        slam::{Slam, SlamOutcome},
        taught::{CameraEstimate, MapLocalizer, VisualMap},
        world::{Camera, Map, map_names},
    };

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
