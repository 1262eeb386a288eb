//! How the algorithm found the robot again after somebody carried it away.

use serde::{Deserialize, Serialize};

use crate::{
    Timestamp,
    eval::{CarriedSpan, EvaluationOptions, FrameError},
    mean,
};

/// One kidnap and what came of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct KidnapRecovery {
    /// When the robot was put down again, seconds since the first sample of the truth.
    pub time_s: f64,
    /// Whether the estimate was right again before the next kidnap or the end.
    pub recovered: bool,
    /// How long that took from the putting down, seconds; `None` if it did not.
    pub recovery_s: Option<f64>,
    /// Mean position error from then to the next kidnap or the end, meters; `None` if it did not.
    pub position_error_m: Option<f64>,
}

/// Stamps are compared with this slack, so that exactly one second at ten frames a second is one second.
const STAMP_SLACK_SECS: f64 = 1e-3;

/// Looks at the frames after every kidnap. A span at the very start of the trajectory is not a kidnap, because the
/// robot was nowhere before, and neither is one from which it never comes down.
pub(crate) fn recoveries(
    frames: &[FrameError],
    spans: &[CarriedSpan],
    start_at: Timestamp,
    options: &EvaluationOptions,
) -> Vec<KidnapRecovery> {
    let mut recoveries = Vec::new();
    for (i, span) in spans.iter().enumerate().filter(|(_, span)| span.from > start_at) {
        let Some(down_at) = span.until else { continue };
        let next_from = spans.get(i + 1).map(|next| next.from);
        let first = frames.partition_point(|frame| frame.at < down_at);
        let last = next_from.map_or(frames.len(), |from| frames.partition_point(|frame| frame.at < from));
        let after = frames.get(first..last).unwrap_or_default();
        let right_again = lasting_success(after, options).and_then(|index| after.get(index..));
        let errors_m: Option<Vec<f64>> =
            right_again.map(|frames| frames.iter().map(|frame| frame.position_error_m).collect());
        recoveries.push(KidnapRecovery {
            time_s: down_at.secs_since(start_at),
            recovered: right_again.is_some(),
            recovery_s: right_again
                .and_then(|frames| frames.first())
                .map(|frame| frame.at.secs_since(down_at)),
            position_error_m: errors_m.and_then(|errors_m| mean(&errors_m)),
        });
    }
    recoveries
}

/// The first frame from which the estimate is right for long enough without a break.
fn lasting_success(frames: &[FrameError], options: &EvaluationOptions) -> Option<usize> {
    let is_right = |frame: &FrameError| {
        frame.is_localized
            && frame.position_error_m < options.max_recovered_error_m
            && frame.heading_error_rad.to_degrees() < options.max_recovered_error_deg
    };
    let mut start: Option<usize> = None;
    for (i, frame) in frames.iter().enumerate() {
        if !is_right(frame) {
            start = None;
            continue;
        }
        let begin = *start.get_or_insert(i);
        if frame.at.secs_since(frames[begin].at) >= options.min_recovered_secs - STAMP_SLACK_SECS {
            return Some(begin);
        }
    }
    None
}
