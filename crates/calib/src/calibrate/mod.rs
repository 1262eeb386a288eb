//! From corners in pictures to a camera with its quality.

mod error;
mod result;
mod run;
mod same_view;

pub use error::{CalibrateError, DropReason, DroppedView};
pub use result::{Calibration, Parameter, SeenCorner, View};
pub use run::{ViewInput, calibrate};
