//! What is kept of a run. Small: everything that the report needs, and the frames of the first run only.

use serde::{Deserialize, Serialize};
use visloc_core::eval::ErrorSummary;

/// What one run found: the same frames for all contenders.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobocupRecord {
    /// Seed of the simulation.
    pub simulation_seed: u64,
    /// Frames of the run.
    pub frames: usize,
    /// The contenders in their order.
    pub contenders: Vec<ContenderRecord>,
    /// The truth at a few moments a second, for pictures; in the first run only.
    pub truth: Option<Vec<TruthPoint>>,
}

/// One contender in one run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ContenderRecord {
    /// Its name.
    pub contender: String,
    /// Position errors, meters, of the frames on the ground from the first localization on.
    pub position_error_m: ErrorSummary,
    /// Heading errors of the same frames, degrees.
    pub heading_error_deg: ErrorSummary,
    /// Share of the frames on the ground that are localized, 0 to 1.
    pub localized_share: Option<f64>,
    /// Time until the first localization, seconds.
    pub time_to_localize_s: Option<f64>,
    /// Every kidnap.
    pub kidnaps: Vec<KidnapScore>,
    /// What became of the frames by their reported reliability.
    pub calibration: Calibration,
    /// Whether the covariance fits the errors.
    pub consistency: Consistency,
    /// The answers at a few moments a second, for pictures; in the first run only.
    pub trace: Option<Vec<TracePoint>>,
}

/// What came of one kidnap.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct KidnapScore {
    /// Time from the putting down until the answer is right and stays so for a second, seconds; `None` if never.
    pub recovery_s: Option<f64>,
    /// Time from the putting down until the reliability is above 0.6, right or not, seconds; `None` if never.
    pub reliable_s: Option<f64>,
    /// Whether the answer is right in the last frame before the next kidnap or the end.
    pub is_right_at_end: bool,
    /// Mean position error from the recovery on, meters.
    pub position_error_m: Option<f64>,
    /// Mean heading error from the recovery on, degrees.
    pub heading_error_deg: Option<f64>,
    /// In that last frame: whether the true pose and its mirror image are both among the hypotheses.
    pub has_both: bool,
}

/// Frames by their reported reliability, in ten equal intervals from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Calibration {
    /// Frames in each interval.
    pub frames: [u64; 10],
    /// Those of them that are near the truth.
    pub near: [u64; 10],
    /// Sum of the reported reliabilities.
    pub reliability: [f64; 10],
    /// Frames that claim to be localized.
    pub claimed: u64,
    /// Those of them that are near the truth.
    pub claimed_near: u64,
}

/// Normalized estimation error squared, `e^T C^-1 e` over (x, y, heading), in the frames that track the robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Consistency {
    /// Frames that track the robot.
    pub frames: u64,
    /// Sum over these frames.
    pub sum: f64,
    /// Frames in the ellipsoid of 95 %.
    pub in_ellipsoid: u64,
    /// Frames whose position alone is in its ellipse of 95 %.
    pub in_position_ellipse: u64,
    /// Frames whose covariance cannot be inverted; they count as outside, and not in the sum.
    pub singular: u64,
    /// The value in the first tracking frame of every second; none where nothing is tracked.
    pub at_secs: Vec<Option<f32>>,
}

/// Where the robot was: seconds, meters, radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TruthPoint(pub f32, pub f32, pub f32, pub f32, pub bool);

/// Where a contender said that the robot was: seconds, meters, meters, radians, reliability.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TracePoint(pub f32, pub f32, pub f32, pub f32, pub f32);

impl ContenderRecord {
    /// Mean of the normalized error over the tracking frames; `None` if there are none.
    pub fn mean_nees(&self) -> Option<f64> {
        let count = self.consistency.frames - self.consistency.singular;
        (count > 0).then(|| self.consistency.sum / count as f64)
    }
}
