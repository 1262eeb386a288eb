//! The observation model of the RoboCup field.

mod goal;
mod model;
mod outline;
mod reference;
mod table;

pub use model::{FieldModelConfig, FieldObservationModel};
pub use reference::DrawnFieldModel;
