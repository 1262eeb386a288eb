//! Trajectories of a camera against the truth: alignment, absolute and relative errors, coverage.

mod absolute;
mod align;
mod pairs;
mod relative;

pub use absolute::{AbsoluteError, absolute_error};
pub use align::{Alignment, Similarity, align};
pub use pairs::{PosePair, associate};
pub use relative::{RelativeError, relative_error};
