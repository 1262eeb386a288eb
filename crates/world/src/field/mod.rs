//! The RoboCup field: lines on a carpet and two goals.

mod dimensions;
mod junctions;
mod marks;

pub use dimensions::{BallColor, BoxDimensions, FieldDimensions, GoalColor, GoalDimensions};
pub use junctions::FieldJunction;
pub use marks::{Field, Goal, Segment};
