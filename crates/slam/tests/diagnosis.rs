//! One run for each cause of too few poses.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use visloc_core::Timestamp;
use visloc_slam::{
    FrameOutcome, StageTimes, TrackingState,
    diagnosis::{Cause, Diagnosis, RunCounters},
    start::{LostTracks, StartWait},
    track::Quality,
};

fn outcome(state: TrackingState) -> FrameOutcome {
    FrameOutcome {
        state,
        camera_from_world: None,
        covariance: None,
        map: None,
        matches: (0, 0),
        fixed: Vec::new(),
        fixed_tried: Vec::new(),
        num_fixed_searched: 0,
        refusal: None,
        is_relocalized: false,
        rivals: None,
        tracking: StageTimes::default(),
        features: Vec::new(),
        mapped: Vec::new(),
    }
}

/// A run of images that all have this state.
fn run(state: TrackingState, brightness: f64, step_secs: f64, num: u32) -> Diagnosis {
    let mut counters = RunCounters::default();
    for i in 0..num {
        counters.count(Timestamp::from_secs(step_secs * f64::from(i)), brightness, &outcome(state));
    }
    counters.diagnosis(0.0)
}

#[test]
fn each_cause_is_told_and_no_other() {
    let waits = |wait| run(TrackingState::Starting(wait), 100.0, 0.05, 60);
    let lost = |of| StartWait::TracksLost(LostTracks { num: 20, of, num_images: 5 });
    for cause in Cause::ALL {
        let diagnosis = match cause {
            Cause::Unusable => {
                let mut counters = RunCounters::default();
                (0..60).for_each(|_| counters.count_unusable());
                counters.diagnosis(0.0)
            }
            Cause::Black => run(TrackingState::Starting(StartWait::FewCorners(0)), 2.0, 0.05, 60),
            Cause::White => run(TrackingState::Lost, 254.0, 0.05, 60),
            Cause::NoTexture => waits(StartWait::FewCorners(12)),
            Cause::StandingStill => waits(StartWait::LittleMotion(0.3)),
            Cause::OnlyTurned => waits(StartWait::LittleParallax(0.001)),
            Cause::FewImages => run(TrackingState::Starting(lost(300)), 100.0, 0.5, 60),
            Cause::TooFast => waits(lost(300)),
            Cause::NoCommonMotion => waits(StartWait::Ambiguous),
            Cause::NotRecognized => run(TrackingState::Lost, 100.0, 0.05, 60),
            Cause::Lost => run(TrackingState::Tracking(Quality::Bad), 100.0, 0.05, 60),
            Cause::ShortRun => run(TrackingState::Starting(StartWait::LittleMotion(0.3)), 100.0, 0.05, 9),
        };
        let found: Vec<Cause> = diagnosis.findings.iter().map(|finding| finding.cause).collect();
        // The first image of a run has nothing before it, so the time to it is unknown.
        let wanted_share = if cause == Cause::FewImages { 59.0 / 60.0 } else { 1.0 };
        assert_eq!(found, [cause], "{diagnosis:?}");
        assert_eq!(diagnosis.facts.lost_at_secs.is_some(), cause == Cause::Lost, "{diagnosis:?}");
        assert!((diagnosis.findings[0].share - wanted_share).abs() < 1e-9, "{diagnosis:?}");
    }
}

#[test]
fn a_start_that_lost_its_corners_before_they_had_moved_did_not_stand() {
    let run = |num_still: usize, num_images| {
        let mut counters = RunCounters::default();
        for i in 0..100 {
            let wait = match i % (num_still + 1) {
                0 => StartWait::TracksLost(LostTracks { num: 20, of: 300, num_images }),
                _ => StartWait::LittleMotion(1.0),
            };
            let at = Timestamp::from_secs(0.05 * i as f64);
            counters.count(at, 100.0, &outcome(TrackingState::Starting(wait)));
        }
        counters.diagnosis(0.0).findings[0]
    };
    let moving = run(10, 10);
    assert_eq!(moving.cause, Cause::TooFast);
    assert!(moving.share > 0.98, "{moving:?}");
    // It stood for long, and the corners of the last few images alone were lost.
    assert_eq!(run(30, 3).cause, Cause::StandingStill);
}

#[test]
fn enough_poses_need_no_cause_and_a_loss_has_its_time() {
    let mut counters = RunCounters::default();
    for i in 0..100 {
        let state = if i < 30 { TrackingState::Tracking(Quality::Good) } else { TrackingState::Lost };
        counters.count(Timestamp::from_secs(0.1 * f64::from(i)), 100.0, &outcome(state));
    }
    assert!(counters.diagnosis(0.7).findings.is_empty());
    let diagnosis = counters.diagnosis(0.3);
    assert_eq!(diagnosis.findings[0].cause, Cause::Lost);
    assert!((diagnosis.facts.lost_at_secs.unwrap() - 3.0).abs() < 1e-6);
    assert!(Cause::ALL.iter().enumerate().all(|(i, cause)| *cause as usize == i), "the list is in order");
    assert!(RunCounters::default().diagnosis(0.0).findings.is_empty());
}

#[test]
fn images_of_maps_that_were_given_up_count_as_lost() {
    let mut counters = RunCounters::default();
    for i in 0..100 {
        let state = match i % 20 {
            0..4 => TrackingState::Starting(StartWait::LittleMotion(1.0)),
            4..18 => TrackingState::Tracking(Quality::Good),
            _ => TrackingState::Tracking(Quality::Bad),
        };
        counters.count(Timestamp::from_secs(0.1 * f64::from(i)), 100.0, &outcome(state));
    }
    // One of five maps was kept.
    let diagnosis = counters.diagnosis(0.14);
    let shares: Vec<_> = diagnosis.findings.iter().map(|finding| (finding.cause, finding.share)).collect();
    assert_eq!(shares, [(Cause::Lost, 0.66), (Cause::StandingStill, 0.2)]);
}
