//! The field from above with what happened on it.

mod draw;
mod ground;
mod input;
mod kidnap;
mod office;
mod paths;

pub use draw::field_picture;
pub use ground::Ground;
pub(crate) use ground::GroundView;
pub use input::{FieldPath, FieldPicture, Kidnap, PathPoint};
pub(crate) use paths::draw_pose_arrow;
