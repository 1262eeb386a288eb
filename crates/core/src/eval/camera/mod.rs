//! Trajectories of a camera against the truth: alignment, absolute and relative errors, coverage.

mod absolute;
mod align;
mod pairs;
mod relative;
mod statistics;

pub use absolute::{AbsoluteError, absolute_error};
pub use align::{Alignment, align};
pub use pairs::{PosePair, associate, coverage};
pub use relative::{Motions, RelativeError, RelativeErrors, Step, relative_error, relative_errors};
pub use statistics::Statistics;
