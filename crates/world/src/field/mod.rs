//! The RoboCup field: lines on a carpet and two goals.

mod dimensions;
mod junctions;
mod list;
mod marks;

pub use dimensions::{BallColor, BoxDimensions, FieldDimensions, GoalColor, GoalDimensions};
pub use junctions::FieldJunction;
pub(crate) use list::{is_field_list, read_field_list};
pub use marks::{Field, Goal, Segment};
