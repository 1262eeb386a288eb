//! The comparison.

use serde::{Deserialize, Serialize};

use crate::{
    PlanarTrajectory, Timestamp,
    eval::{
        CarriedSpan, ErrorSummary, EstimateSample, EvaluationOptions, KidnapRecovery, association::associate,
        carried_spans, recovery::recoveries,
    },
};

/// Error of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameError {
    /// Stamp of the truth.
    pub at: Timestamp,
    /// Distance between estimate and truth, meters.
    pub position_error_m: f64,
    /// Difference of the headings, radians in [0, pi].
    pub heading_error_rad: f64,
    /// How much the algorithm trusted the estimate, in [0, 1].
    pub reliability: Option<f64>,
    /// Whether the estimate claims to know where the robot is.
    pub is_localized: bool,
    /// Whether the robot is above the ground or moved by hand.
    pub is_carried: bool,
}

/// How good an estimate is. Values that are not known are `None`, `null` in JSON.
///
/// A frame is *localized* if its reliability is above 0.6; without reliabilities every frame is. The *first
/// localization* is the first localized frame. A frame is *on the ground* if the robot is at most 2 cm above it and not
/// moved by hand (see [`carried_spans`]).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Evaluation {
    /// Frames with an estimate and a truth.
    pub frames: usize,
    /// Position errors, meters, of the frames on the ground from the first localization on.
    pub position_error_m: ErrorSummary,
    /// Heading errors, degrees, of the same frames.
    pub heading_error_deg: ErrorSummary,
    /// Position errors, meters, of those among them that are localized.
    pub tracking_position_error_m: ErrorSummary,
    /// Share of the frames on the ground that are localized, in [0, 1].
    pub localized_share: Option<f64>,
    /// Time from the first frame to the first localization, seconds.
    pub time_to_localize_s: Option<f64>,
    /// Every kidnap: the robot was carried away and put down elsewhere.
    pub kidnaps: Vec<KidnapRecovery>,
    /// Every frame in order of time, for pictures.
    #[serde(skip)]
    pub frame_errors: Vec<FrameError>,
}

/// Compares an estimate with the truth. Each truth is used once, by the nearest estimate within the stamp tolerance.
pub fn evaluate(
    truth: &PlanarTrajectory,
    estimate: &[EstimateSample],
    options: &EvaluationOptions,
) -> Evaluation {
    let spans = carried_spans(truth, options);
    let frames = frame_errors(truth, estimate, &spans, options);
    let first_localized = frames.iter().position(|frame| frame.is_localized);
    let on_ground: Vec<_> = frames.iter().filter(|frame| !frame.is_carried).copied().collect();
    let counted: Vec<_> = first_localized
        .and_then(|first| frames.get(first..))
        .unwrap_or_default()
        .iter()
        .filter(|frame| !frame.is_carried)
        .copied()
        .collect();
    let tracked: Vec<_> = counted.iter().filter(|frame| frame.is_localized).copied().collect();
    let time_to_localize_s = match (frames.first(), first_localized.and_then(|first| frames.get(first))) {
        (Some(start), Some(first)) => Some(first.at.secs_since(start.at)),
        _ => None,
    };
    let kidnaps =
        truth.poses().first().map_or_else(Vec::new, |start| recoveries(&frames, &spans, start.at, options));
    Evaluation {
        frames: frames.len(),
        position_error_m: position_summary(&counted),
        heading_error_deg: heading_summary(&counted),
        tracking_position_error_m: position_summary(&tracked),
        localized_share: localized_share(&on_ground),
        time_to_localize_s,
        kidnaps,
        frame_errors: frames,
    }
}

fn frame_errors(
    truth: &PlanarTrajectory,
    estimate: &[EstimateSample],
    spans: &[CarriedSpan],
    options: &EvaluationOptions,
) -> Vec<FrameError> {
    associate(truth, estimate, options.stamp_tolerance_secs)
        .into_iter()
        .map(|(pose, sample)| FrameError {
            at: pose.at,
            position_error_m: sample.world_from_robot.distance_m(&pose.world_from_robot),
            heading_error_rad: sample.world_from_robot.heading_difference_rad(&pose.world_from_robot),
            reliability: sample.reliability,
            is_localized: sample.reliability.is_none_or(|reliability| reliability > options.min_reliability),
            is_carried: spans.iter().any(|span| span.contains(pose.at)),
        })
        .collect()
}

fn position_summary(frames: &[FrameError]) -> ErrorSummary {
    ErrorSummary::of(&frames.iter().map(|frame| frame.position_error_m).collect::<Vec<_>>())
}

fn heading_summary(frames: &[FrameError]) -> ErrorSummary {
    ErrorSummary::of(&frames.iter().map(|frame| frame.heading_error_rad.to_degrees()).collect::<Vec<_>>())
}

fn localized_share(frames: &[FrameError]) -> Option<f64> {
    let num_localized = frames.iter().filter(|frame| frame.is_localized).count();
    (!frames.is_empty()).then(|| num_localized as f64 / frames.len() as f64)
}
