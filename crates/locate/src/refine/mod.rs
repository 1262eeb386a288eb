//! From places to poses: every hypothesis of a localizer is tracked by a filter of its own, which matches all border
//! pixels of an image to the map.
//!
//! A localizer of the documents weighs twenty pixels and answers with the mean of a population, good to a decimeter. Here
//! its hypotheses only begin *tracks*. A track is an iterated extended Kalman filter over the pose, the slow error of the
//! camera's direction and the systematic error of the odometry; its update is a robust least-squares fit. Tracks compete:
//! the marginal likelihood of the features is evidence (`evidence.rs`); images of one view count as one, what is new adds up (`view.rs`).
//! Where places look alike it is the share of the features that they explain, over time.
//!
//! Sources of the ideas: the refinement of the winner and the odometry correction estimated on line are goals that the
//! theses name (2017 chapter 8); several Kalman filters that compete after Reid, "An algorithm for tracking multiple
//! targets", 1979; the iterated update after Bell and Cathey, "The iterated Kalman filter update as a Gauss-Newton method",
//! 1993.

mod config;
mod evidence;
mod filter;
mod known;
mod likelihood;
mod localizer;
mod mount;
mod other_mounts;
mod place;
mod robot;
mod search;
mod single;
#[cfg(test)]
mod tests;
mod track;
mod tracks;
mod turned;
mod turning;
mod view;

pub use config::RefinementConfig;
pub use localizer::Refined;
pub(crate) use search::Effort;
pub(crate) use single::SingleImage;
