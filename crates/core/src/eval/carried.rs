//! When somebody carried the robot, from the truth alone.

use crate::{PlanarTrajectory, StampedPose, Timestamp, eval::EvaluationOptions};

/// A time in which the robot was moved by hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CarriedSpan {
    /// First sample off the ground, or last one before a fast motion.
    pub from: Timestamp,
    /// First sample on the ground again; `None` if the trajectory ends before.
    pub until: Option<Timestamp>,
}

impl CarriedSpan {
    /// Whether the robot is in the hands of somebody at a time. At `until` it stands on the ground again.
    pub fn contains(&self, at: Timestamp) -> bool {
        at >= self.from && self.until.is_none_or(|until| at < until)
    }
}

/// All times in which the robot is above the ground or moves faster than it can walk. A fast motion counts if it covers
/// more than [`EvaluationOptions::min_carried_distance_m`] without a pause, so a jump from one sample to the next does
/// and the jitter of a tracking system does not.
pub fn carried_spans(truth: &PlanarTrajectory, options: &EvaluationOptions) -> Vec<CarriedSpan> {
    let poses = truth.poses();
    let mut is_carried: Vec<bool> =
        poses.iter().map(|pose| pose.height_m > options.max_ground_height_m).collect();
    for (first, last) in fast_runs(poses, options) {
        // The last sample of the run stands where the motion has ended.
        is_carried[first..last].fill(true);
    }
    let mut spans: Vec<CarriedSpan> = Vec::new();
    for (i, pose) in poses.iter().enumerate().filter(|(i, _)| is_carried[*i]) {
        let until = poses.get(i + 1).map(|next| next.at);
        match spans.last_mut() {
            Some(span) if span.until.is_some_and(|end| is_near(pose.at, end, options)) => span.until = until,
            _ => spans.push(CarriedSpan { from: pose.at, until }),
        }
    }
    spans
}

fn is_near(at: Timestamp, end: Timestamp, options: &EvaluationOptions) -> bool {
    at.secs_since(end) < options.max_carried_gap_secs
}

/// First and last index of every run of samples that moves faster than the robot walks and covers enough ground.
fn fast_runs(poses: &[StampedPose], options: &EvaluationOptions) -> Vec<(usize, usize)> {
    let is_fast = |i: usize| {
        let secs = poses[i + 1].at.secs_since(poses[i].at);
        let distance_m = poses[i].world_from_robot.distance_m(&poses[i + 1].world_from_robot);
        distance_m > options.max_walking_speed_m_per_s * secs
    };
    let num_steps = poses.len().saturating_sub(1);
    let mut runs = Vec::new();
    let mut start = 0;
    while start < num_steps {
        let num_fast = (start..num_steps).take_while(|i| is_fast(*i)).count();
        let end = start + num_fast;
        let covered_m = poses[start].world_from_robot.distance_m(&poses[end].world_from_robot);
        if covered_m > options.min_carried_distance_m {
            runs.push((start, end));
        }
        start = end + 1;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::PlanarPose;

    /// Ten samples a second with the given x and height.
    fn truth(samples: &[(f64, f64)]) -> PlanarTrajectory {
        let mut truth = PlanarTrajectory::new();
        for (i, (x_m, height_m)) in samples.iter().enumerate() {
            let at = Timestamp::from_nanos(i as i64 * 100_000_000);
            let world_from_robot = PlanarPose::new(*x_m, 0.0, 0.0);
            truth.push(StampedPose { at, world_from_robot, height_m: *height_m }).unwrap();
        }
        truth
    }

    /// Carried spans by the index of their samples.
    fn spans(samples: &[(f64, f64)]) -> Vec<(i64, Option<i64>)> {
        let index = |at: Timestamp| at.nanos() / 100_000_000;
        carried_spans(&truth(samples), &EvaluationOptions::default())
            .iter()
            .map(|span| (index(span.from), span.until.map(index)))
            .collect()
    }

    #[test]
    fn walking_is_not_carrying() {
        let walk: Vec<_> = (0..50).map(|i| (0.05 * f64::from(i), 0.0)).collect();
        assert!(spans(&walk).is_empty());
        assert!(spans(&[]).is_empty() && spans(&[(0.0, 0.0)]).is_empty());
    }

    #[test]
    fn lifting_counts_from_the_ground_to_the_ground() {
        let samples = [(0.0, 0.0), (0.0, 0.01), (0.0, 0.05), (0.05, 0.3), (0.1, 0.0), (0.1, 0.0)];
        assert_eq!(spans(&samples), [(2, Some(4))]);
        assert_eq!(spans(&samples[..4]), [(2, None)]);
    }

    #[test]
    fn dragging_and_jumping_count_and_jitter_does_not() {
        let drag = [(0.0, 0.0), (0.02, 0.0), (0.2, 0.0), (0.4, 0.0), (0.42, 0.0), (0.42, 0.0)];
        assert_eq!(spans(&drag), [(1, Some(3))]);
        let jump = [(0.0, 0.0), (0.0, 0.0), (2.0, 0.0), (2.0, 0.0)];
        assert_eq!(spans(&jump), [(1, Some(2))]);
        let jitter = [(0.0, 0.0), (0.15, 0.0), (0.0, 0.0), (0.15, 0.0), (0.0, 0.0)];
        assert!(spans(&jitter).is_empty());
    }

    #[test]
    fn near_spans_are_one() {
        let samples = [(0.0, 0.0), (0.0, 0.1), (0.0, 0.0), (0.0, 0.0), (0.0, 0.1), (0.0, 0.0)];
        assert_eq!(spans(&samples), [(1, Some(5))]);
    }
}
