//! From the moments of a run to its record.

use visloc_core::{
    PlanarTrajectory, StampedPose, Timestamp,
    eval::{
        CarriedSpan, ErrorSummary, EstimateSample, Evaluation, EvaluationOptions, FrameError, KidnapRecovery,
        carried_spans, evaluate,
    },
};
use visloc_locate::LOCALIZED_RELIABILITY;

use super::{
    record::{Calibration, Consistency, ContenderRecord, KidnapScore, TracePoint, TruthPoint},
    reliability::TRACKING,
    track::{Moment, Track},
};

/// Moments a second that pictures show.
const TRACE_PER_SEC: f64 = 5.0;

/// Everything that is kept of a contender.
pub(super) fn score(track: &Track, truth: &PlanarTrajectory, with_trace: bool) -> ContenderRecord {
    let options = EvaluationOptions::default();
    let sample = |moment: &Moment| EstimateSample {
        at: Timestamp::from_secs(moment.secs),
        world_from_robot: moment.estimate,
        reliability: Some(moment.reliability),
    };
    let samples: Vec<EstimateSample> = track.moments.iter().map(sample).collect();
    let evaluation = evaluate(truth, &samples, &options);
    ContenderRecord {
        contender: track.contender.label.clone(),
        position_error_m: evaluation.position_error_m,
        heading_error_deg: evaluation.heading_error_deg,
        localized_share: evaluation.localized_share,
        time_to_localize_s: evaluation.time_to_localize_s,
        kidnaps: kidnaps(track, truth, &evaluation, &options),
        calibration: Calibration::of(&track.moments),
        consistency: Consistency::of(&track.moments),
        trace: with_trace.then(|| every_trace_step(&track.moments).map(trace_point).collect()),
    }
}

/// The truth of a run as the comparison wants it.
pub(super) fn truth_of(moments: &[(f64, visloc_core::Truth)]) -> PlanarTrajectory {
    let mut truth = PlanarTrajectory::new();
    for (secs, at) in moments {
        let pose = StampedPose {
            at: Timestamp::from_secs(*secs),
            world_from_robot: at.world_from_robot,
            height_m: at.height_m,
        };
        // Frames come in order of time.
        let _ = truth.push(pose);
    }
    truth
}

/// The truth at the moments that pictures show.
pub(super) fn truth_trace(moments: &[(f64, visloc_core::Truth)]) -> Vec<TruthPoint> {
    let mut next_secs = 0.0;
    let mut points = Vec::new();
    for (secs, truth) in moments {
        if *secs + 1e-6 >= next_secs {
            next_secs += 1.0 / TRACE_PER_SEC;
            let pose = &truth.world_from_robot;
            let is_carried = truth.height_m > 0.0;
            points.push(TruthPoint(
                short(*secs),
                short(pose.x_m),
                short(pose.y_m),
                short(pose.yaw_rad),
                is_carried,
            ));
        }
    }
    points
}

fn every_trace_step(moments: &[Moment]) -> impl Iterator<Item = &Moment> {
    let mut next_secs = 0.0;
    moments.iter().filter(move |moment| {
        let is_due = moment.secs + 1e-6 >= next_secs;
        if is_due {
            next_secs += 1.0 / TRACE_PER_SEC;
        }
        is_due
    })
}

fn trace_point(moment: &Moment) -> TracePoint {
    let pose = &moment.estimate;
    TracePoint(
        short(moment.secs),
        short(pose.x_m),
        short(pose.y_m),
        short(pose.yaw_rad),
        short(moment.reliability),
    )
}

/// To millimeters, milliseconds and milliradians.
fn short(value: f64) -> f32 {
    ((value * 1e3).round() / 1e3) as f32
}

/// A kidnap, its frames until the next one, and what the comparison says of it.
fn kidnaps(
    track: &Track,
    truth: &PlanarTrajectory,
    evaluation: &Evaluation,
    options: &EvaluationOptions,
) -> Vec<KidnapScore> {
    let spans = carried_spans(truth, options);
    let Some(start) = truth.poses().first().map(|pose| pose.at) else { return Vec::new() };
    let landings = spans.iter().enumerate().filter(|(_, span)| span.from > start && span.until.is_some());
    landings
        .zip(&evaluation.kidnaps)
        .map(|((i, span), recovery)| {
            let next_from = spans.get(i + 1).map(|next| next.from);
            kidnap_score(track, evaluation, (span, next_from), recovery)
        })
        .collect()
}

fn kidnap_score(
    track: &Track,
    evaluation: &Evaluation,
    (span, next_from): (&CarriedSpan, Option<Timestamp>),
    recovery: &KidnapRecovery,
) -> KidnapScore {
    let Some(down_at) = span.until else { return KidnapScore::default() };
    let is_after = |at: Timestamp| at >= down_at && next_from.is_none_or(|from| at < from);
    let frames: Vec<&FrameError> = evaluation.frame_errors.iter().filter(|f| is_after(f.at)).collect();
    let right_at = recovery.recovery_s.map(|secs| down_at + secs);
    let headings: Vec<f64> = frames
        .iter()
        .filter(|frame| right_at.is_some_and(|at| frame.at >= at))
        .map(|frame| frame.heading_error_rad.to_degrees())
        .collect();
    let reliable = frames.iter().find(|f| f.reliability.is_some_and(|r| r > LOCALIZED_RELIABILITY));
    let last = track.moments.iter().rfind(|moment| is_after(Timestamp::from_secs(moment.secs)));
    let is_right = |m: &Moment| m.position_error_m() < TRACKING.0 && m.heading_error_rad() < TRACKING.1;
    KidnapScore {
        recovery_s: recovery.recovery_s,
        reliable_s: reliable.map(|frame| frame.at.secs_since(down_at)),
        is_right_at_end: last.is_some_and(is_right),
        position_error_m: recovery.position_error_m,
        heading_error_deg: ErrorSummary::of(&headings).mean,
        has_both: last.is_some_and(|moment| moment.has_both),
    }
}
