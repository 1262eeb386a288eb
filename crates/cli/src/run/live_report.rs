//! What a run on live topics counted.

use serde::Serialize;
use visloc_core::eval::TimingSummary;

/// Results on live topics.
#[derive(Debug, Clone, Serialize)]
pub struct LiveReport {
    /// Images that came while others were worked on.
    pub dropped: usize,
    /// Messages that a subscriber was too slow for.
    pub unsent: usize,
    /// From receiving an image to publishing its pose, milliseconds.
    pub delay_ms: TimingSummary,
    /// The same without the algorithm's own time.
    pub overhead_ms: TimingSummary,
    /// With a team: what was told.
    #[cfg(feature = "ros2")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub team: Option<super::TeamReport>,
}
