//! One robot followed by one algorithm.

use rand::RngExt;
use visloc_core::{
    PlanarTrajectory, RngTree, StampedPose, Timestamp,
    eval::{CarriedSpan, EstimateSample, Evaluation, EvaluationOptions, carried_spans, evaluate},
    geom::PlanarPose,
};
use visloc_locate::{Estimate, LOCALIZED_RELIABILITY, Pipeline};
use visloc_world::Map;

use super::{OfficeRecord, oracle::Oracle, place};
use crate::ExperimentError;

/// A hypothesis so near to the truth stands for it.
const NEAR_M: f64 = 0.6;
const NEAR_RAD: f64 = 0.5;
/// An answer so far from where the robot would be without the kidnap is another place.
const CHANGED_M: f64 = 1.0;

/// Who walks, and who follows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk<'a> {
    pub scenario: &'a str,
    pub algorithm: &'a str,
    pub max_frames: usize,
}

/// What came of it.
#[derive(Debug)]
pub(super) struct Followed {
    pub truth: PlanarTrajectory,
    pub estimates: Vec<EstimateSample>,
    pub evaluation: Evaluation,
    /// Whether the true place was among the hypotheses, image by image before the first localization.
    is_among: Vec<bool>,
    max_hypotheses: usize,
    /// For each kidnap, time until the place could be told from all others.
    told_secs: Vec<Option<f64>>,
}

/// Follows the walk with the seed of a run. All algorithms get the same images.
pub(super) fn follow(walk: &Walk<'_>, run: u64, seeds: &RngTree) -> Result<Followed, ExperimentError> {
    let refused = |error: &dyn std::fmt::Display| ExperimentError::Run {
        cell: walk.scenario.to_owned(),
        run,
        reason: error.to_string(),
    };
    let office = place::building(walk.scenario)?;
    let seed = seeds.stream(walk.scenario, run).random_range(0..=u64::MAX);
    let mut frames = place::frames(walk.scenario, seed, walk.max_frames)?;
    let mut oracle = Oracle::new(&office, seeds.stream("oracle", run)).map_err(|error| refused(&error))?;
    let rng = seeds.subtree(walk.algorithm, run);
    let map = Map::Office(office);
    let mut pipeline = Pipeline::builder(&map)
        .named(walk.algorithm, None)
        .rng(rng)
        .build()
        .map_err(|error| refused(&error))?;
    let options = EvaluationOptions::default();
    let mut followed = Followed {
        truth: PlanarTrajectory::new(),
        estimates: Vec::new(),
        evaluation: Evaluation::default(),
        is_among: Vec::new(),
        max_hypotheses: 0,
        told_secs: Vec::new(),
    };
    while let Some(next) = frames.next_item() {
        let next = next.map_err(|error| refused(&error))?;
        pipeline.step(&next.frame).map_err(|error| refused(&error))?;
        if let Some(truth) = next.truth {
            oracle.note(
                pipeline.percept(),
                &truth.world_from_robot,
                truth.height_m > options.max_ground_height_m,
            );
        }
        let estimate = pipeline.estimate();
        let Some(truth) = next.truth else { continue };
        let (at, world_from_robot) = (next.frame.at, truth.world_from_robot);
        followed.note(estimate, &world_from_robot);
        followed.estimates.push(EstimateSample {
            at,
            world_from_robot: estimate.world_from_robot,
            reliability: Some(estimate.reliability),
        });
        // The simulator's stamps are in order.
        let _ = followed.truth.push(StampedPose { at, world_from_robot, height_m: truth.height_m });
    }
    followed.told_secs = oracle.into_told_secs();
    followed.evaluation = evaluate(&followed.truth, &followed.estimates, &options);
    Ok(followed)
}

impl Followed {
    fn note(&mut self, estimate: &Estimate, truth: &PlanarPose) {
        self.max_hypotheses = self.max_hypotheses.max(estimate.hypotheses.len());
        let was_localized = self.estimates.iter().any(|sample| sample.reliability.is_some_and(|r| r > 0.6));
        if !was_localized && !estimate.hypotheses.is_empty() {
            let is_true = |pose: &PlanarPose| {
                pose.distance_m(truth) < NEAR_M && pose.heading_difference_rad(truth) < NEAR_RAD
            };
            self.is_among.push(estimate.hypotheses.iter().any(|h| is_true(&h.world_from_robot)));
        }
    }

    pub fn record(&self) -> OfficeRecord {
        let evaluation = &self.evaluation;
        let among = self.is_among.iter().filter(|is_among| **is_among).count();
        OfficeRecord {
            error_m: evaluation.position_error_m.mean,
            error_deg: evaluation.heading_error_deg.mean,
            first_localized_secs: evaluation.time_to_localize_s,
            recovery_secs: evaluation.kidnaps.iter().map(|kidnap| kidnap.recovery_s).collect(),
            changed_secs: self.changed_secs(),
            told_secs: self.told_secs.clone(),
            true_among_hypotheses: (!self.is_among.is_empty())
                .then(|| among as f64 / self.is_among.len() as f64),
            max_hypotheses: self.max_hypotheses,
        }
    }

    /// For each kidnap that the evaluation counts, time until another place is relied on.
    fn changed_secs(&self) -> Vec<Option<f64>> {
        let spans = carried_spans(&self.truth, &EvaluationOptions::default());
        let start = self.truth.poses().first().map(|pose| pose.at);
        let next_from = |i: usize| spans.get(i + 1).map(|next| next.from);
        let kidnaps = spans.iter().enumerate().filter(|(_, s)| Some(s.from) > start && s.until.is_some());
        kidnaps.map(|(i, span)| self.changed_after(span, next_from(i))).collect()
    }

    fn changed_after(&self, span: &CarriedSpan, next_from: Option<Timestamp>) -> Option<f64> {
        let down_at = span.until?;
        let before = self.estimates.iter().rfind(|sample| sample.at < span.from)?.world_from_robot;
        let poses = self.truth.poses();
        let true_at =
            |at| poses.get(poses.partition_point(|pose| pose.at < at)).map(|pose| pose.world_from_robot);
        let down = true_at(down_at)?;
        let is_elsewhere = |sample: &&EstimateSample| {
            let uncarried = true_at(sample.at).map(|now| before.compose(&now.relative_to(&down)));
            sample.reliability.is_some_and(|r| r > LOCALIZED_RELIABILITY)
                && uncarried.is_some_and(|pose| pose.distance_m(&sample.world_from_robot) > CHANGED_M)
        };
        let is_after = |at| at >= down_at && next_from.is_none_or(|from| at < from);
        let mut after = self.estimates.iter().filter(|sample| is_after(sample.at));
        after.find(is_elsewhere).map(|sample| sample.at.secs_since(down_at))
    }
}
