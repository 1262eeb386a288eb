//! Counts of what a detector found and what there was.

use visloc_core::median;

/// Counts of one detector.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DetectionScore {
    /// Detections.
    pub num_found: usize,
    /// Of these right.
    pub num_right: usize,
    /// Things in view.
    pub num_visible: usize,
    /// Of these found.
    pub num_recalled: usize,
    /// Distances on the ground of right detections from the truth, meters.
    pub errors_m: Vec<f64>,
}

impl DetectionScore {
    /// Share of the detections that are right.
    pub fn precision(&self) -> f64 {
        share(self.num_right, self.num_found)
    }

    /// Share of the things in view that are found.
    pub fn recall(&self) -> f64 {
        share(self.num_recalled, self.num_visible)
    }

    /// Median error on the ground of the right detections, meters; it contains that of the reported camera.
    pub fn median_error_m(&self) -> Option<f64> {
        median(self.errors_m.iter().copied())
    }
}

/// Part of all; 1 of nothing.
pub(super) fn share(part: usize, all: usize) -> f64 {
    if all == 0 { 1.0 } else { part as f64 / all as f64 }
}
