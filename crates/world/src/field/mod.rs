//! The RoboCup field: lines on a carpet and two goals.

mod dimensions;
mod marks;

pub use dimensions::{BallColor, BoxDimensions, FieldDimensions, GoalColor, GoalDimensions};
pub use marks::{Field, Goal, Segment};
