//! Precision and recall of the composite features against the true pose.
//!
//! A detection is right if in the image it is within a stated distance of a thing of its kind that the map has there, seen
//! from the true place. The direction of the camera, which kinematics reports with an error of up to two degrees, is first
//! fitted to the borders of the lines at the true place. Visible is what lies in the image and within 4 m; whether another
//! robot stands before it is not asked.

mod counts;
mod ground;
mod objects;
mod posts;
mod scene;
mod scores;

pub use counts::DetectionScore;
pub use scores::DetectionScores;

/// Largest distance of a right detection in the image, pixels.
const TOLERANCE_PX: f64 = 6.0;
