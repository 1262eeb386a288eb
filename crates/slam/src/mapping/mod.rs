//! Making the map: new landmarks, depth filters, bundle adjustment, culling.

pub(crate) mod adjust;
mod candidate;
mod complete;
mod cull;
mod depth_filter;
mod epipolar;
mod errors;
mod given;
mod keyframes;
pub(crate) mod lens;
mod mapper;

pub(crate) use adjust::MOST_KEYFRAMES;
pub use adjust::{AdjustReport, WholeAdjustment, adjust_all, adjust_local, adjust_way};
pub(crate) use candidate::{corner_covariance, corners_in_two_passes};
pub use cull::{Thinned, thin};
pub use depth_filter::DepthFilter;
pub use epipolar::EpipolarSearch;
pub use errors::MapErrors;
pub use given::GivenViews;
pub use keyframes::{KeyframeDecision, KeyframeRule};
pub use mapper::{Mapper, MappingReport};
