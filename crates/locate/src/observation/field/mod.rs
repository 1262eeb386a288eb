//! The observation model of the RoboCup field.

mod composites;
mod features;
mod goal;
mod model;
mod outline;
mod reference;
mod suggest;
mod table;

pub use features::FieldFeatureModel;
pub use model::{FieldModelConfig, FieldObservationModel};
pub use reference::DrawnFieldModel;
