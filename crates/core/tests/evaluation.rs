//! Hand-made trajectories with numbers computed by hand.

#![allow(clippy::unwrap_used)]

use visloc_core::{
    PlanarTrajectory, StampedPose, Timestamp,
    eval::{EstimateSample, Evaluation, EvaluationOptions, evaluate},
    geom::PlanarPose,
};

/// Ten frames a second.
fn at(index: usize) -> Timestamp {
    Timestamp::from_nanos(1_700_000_000_000_000_000 + index as i64 * 100_000_000)
}

/// A robot that stands at x = 0, is lifted from frame 20 to 29 and put down at x = 3.
fn kidnapped_truth(num_frames: usize) -> PlanarTrajectory {
    let mut truth = PlanarTrajectory::new();
    for i in 0..num_frames {
        let x_m = if i < 25 { 0.0 } else { 3.0 };
        let height_m = if (20..30).contains(&i) { 0.3 } else { 0.0 };
        truth
            .push(StampedPose { at: at(i), world_from_robot: PlanarPose::new(x_m, 0.0, 0.0), height_m })
            .unwrap();
    }
    truth
}

fn sample(index: usize, x_m: f64, reliability: f64) -> EstimateSample {
    EstimateSample {
        at: at(index),
        world_from_robot: PlanarPose::new(x_m, 0.0, 0.1),
        reliability: Some(reliability),
    }
}

/// Finds itself at frame 5 with 0.1 m error, and again at frame 45 with 0.2 m error.
fn recovering_estimate(num_frames: usize) -> Vec<EstimateSample> {
    (0..num_frames)
        .map(|i| match i {
            0..5 => sample(i, 5.0, 0.1),
            5..45 => sample(i, 0.1, if i < 30 { 0.9 } else { 0.2 }),
            _ => sample(i, 3.2, 0.9),
        })
        .collect()
}

fn near(value: Option<f64>, expected: f64) -> bool {
    value.is_some_and(|value| (value - expected).abs() < 1e-6)
}

fn run(truth: &PlanarTrajectory, estimate: &[EstimateSample]) -> Evaluation {
    evaluate(truth, estimate, &EvaluationOptions::default())
}

#[test]
fn numbers_of_a_kidnap_by_hand() {
    let evaluation = run(&kidnapped_truth(65), &recovering_estimate(65));
    assert_eq!(evaluation.frames, 65);
    assert!(near(evaluation.time_to_localize_s, 0.5));
    // On the ground: 0..20 and 30..65. Localized: 15 + 20.
    assert!(near(evaluation.localized_share, 35.0 / 55.0));
    // Counted: 15 frames with 0.1 m, 15 with 2.9 m, 20 with 0.2 m.
    let errors = &evaluation.position_error_m;
    assert!(near(errors.mean, (15.0 * 0.1 + 15.0 * 2.9 + 20.0 * 0.2) / 50.0), "{errors:?}");
    assert!(near(errors.median, 0.2) && near(errors.p95, 2.9) && near(errors.max, 2.9), "{errors:?}");
    assert!(near(errors.rmse, ((15.0 * 0.01 + 15.0 * 8.41 + 20.0 * 0.04) / 50.0_f64).sqrt()), "{errors:?}");
    assert!(near(evaluation.heading_error_deg.mean, 0.1_f64.to_degrees()));
    assert!(near(evaluation.tracking_position_error_m.mean, (15.0 * 0.1 + 20.0 * 0.2) / 35.0));
    let [kidnap] = evaluation.kidnaps[..] else { panic!("{:?}", evaluation.kidnaps) };
    assert!(kidnap.recovered && near(Some(kidnap.time_s), 3.0), "{kidnap:?}");
    assert!(near(kidnap.recovery_s, 1.5) && near(kidnap.position_error_m, 0.2), "{kidnap:?}");
    assert_eq!(evaluation.frame_errors.iter().filter(|frame| frame.is_carried).count(), 10);
}

#[test]
fn recovery_must_last_a_second() {
    // right from frame 45 on; at frame 55 it has lasted exactly one second
    assert!(run(&kidnapped_truth(56), &recovering_estimate(56)).kidnaps[0].recovered);
    assert!(!run(&kidnapped_truth(55), &recovering_estimate(55)).kidnaps[0].recovered);
    let mut estimate = recovering_estimate(65);
    estimate[50] = sample(50, 3.6, 0.9);
    let kidnap = run(&kidnapped_truth(65), &estimate).kidnaps[0];
    assert!(near(kidnap.recovery_s, 2.1), "{kidnap:?}");
    estimate[60].world_from_robot.yaw_rad = 0.4;
    let kidnap = run(&kidnapped_truth(65), &estimate).kidnaps[0];
    assert!(!kidnap.recovered && kidnap.recovery_s.is_none() && kidnap.position_error_m.is_none());
}

#[test]
fn recovery_ends_at_the_next_kidnap() {
    let mut truth = PlanarTrajectory::new();
    for pose in kidnapped_truth(65).poses() {
        let is_second =
            (50..52).contains(&pose.at.nanos().rem_euclid(1_000_000_000_000).div_euclid(100_000_000));
        let height_m = if is_second { 0.1 } else { pose.height_m };
        truth.push(StampedPose { height_m, ..*pose }).unwrap();
    }
    let evaluation = run(&truth, &recovering_estimate(65));
    let recovered: Vec<_> =
        evaluation.kidnaps.iter().map(|kidnap| (kidnap.recovered, kidnap.recovery_s)).collect();
    assert_eq!(recovered, [(false, None), (true, Some(0.0))]);
}

#[test]
fn without_reliabilities_every_estimate_counts() {
    let mut estimate = recovering_estimate(65);
    for sample in &mut estimate {
        sample.reliability = None;
    }
    let evaluation = run(&kidnapped_truth(65), &estimate);
    assert!(near(evaluation.time_to_localize_s, 0.0) && near(evaluation.localized_share, 1.0));
    assert!(near(evaluation.position_error_m.max, 5.0));
}

#[test]
fn nothing_known_is_null() {
    let json = serde_json::to_value(run(&PlanarTrajectory::new(), &recovering_estimate(3))).unwrap();
    let keys: Vec<_> = json.as_object().unwrap().keys().cloned().collect();
    let expected = [
        "frames",
        "heading_error_deg",
        "kidnaps",
        "localized_share",
        "position_error_m",
        "time_to_localize_s",
        "tracking_position_error_m",
    ];
    let mut sorted = keys.clone();
    sorted.sort();
    assert_eq!(sorted, expected);
    assert!(json["position_error_m"]["p95"].is_null() && json["time_to_localize_s"].is_null());
    let never = run(&kidnapped_truth(65), &[sample(0, 0.0, 0.6)]);
    assert_eq!((never.frames, never.time_to_localize_s), (1, None));
    assert!(near(never.localized_share, 0.0) && never.position_error_m.mean.is_none());
    assert!(!never.kidnaps[0].recovered);
}

#[test]
fn json_of_a_kidnap_has_its_keys() {
    let json = serde_json::to_value(run(&kidnapped_truth(65), &recovering_estimate(65))).unwrap();
    let kidnap = json["kidnaps"][0].as_object().unwrap();
    let mut keys: Vec<_> = kidnap.keys().map(String::as_str).collect();
    keys.sort_unstable();
    assert_eq!(keys, ["position_error_m", "recovered", "recovery_s", "time_s"]);
}
