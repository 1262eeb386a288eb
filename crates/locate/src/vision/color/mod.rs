//! Color classes: which pixels are carpet, line, goal or ball.

mod calibrate;
mod carpet_color;
mod classes;
mod table;

pub use calibrate::{CalibrationError, calibrate_colors};
pub(crate) use carpet_color::{CarpetColor, CarpetLearner, FOLLOW};
pub use classes::{ColorConfig, ColorSource, GoalColors, HueRange};
pub use table::{ColorClass, ColorTable, Shares};
pub(crate) use table::{luma, shares};
