//! Composite features: what several border pixels together are.
//!
//! borders -> places where scan lines cross a line (`crossings`) -> pieces (`chains`) -> lines (`segments`) -> the circle
//! takes its pieces (`circle`) -> `junctions`; what is left over may be `marks`; runs of goal colors are `posts`, white ones with
//! `upright_borders` `white_posts`.
//! Straight things are fitted in the image, where their noise is the same everywhere; each detector looks again at the
//! image before it believes what it found.

mod chains;
mod circle;
mod config;
mod crossings;
mod detector;
mod junctions;
mod marks;
mod posts;
mod row_profile;
mod segments;
mod upright_borders;
mod view;
mod white_posts;

pub use config::FeatureDetectionConfig;
pub(super) use detector::FeatureDetector;
pub(super) use view::GroundView;
