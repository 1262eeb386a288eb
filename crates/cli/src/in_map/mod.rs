//! `visloc localize` in a map that SLAM has made.

mod execute;
mod frames;
mod report;

pub use execute::execute;
pub use report::draw;

use crate::args::LocalizeArgs;

/// Whether the map of a command is one of SLAM.
pub fn is_wanted(args: &LocalizeArgs) -> bool {
    args.map.as_deref().is_some_and(|map| map.ends_with(".vmap"))
}
