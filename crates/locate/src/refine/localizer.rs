//! A localizer whose hypotheses are refined.

use visloc_base::{Rng, Timestamp};
use visloc_geom::PlanarPose;

use super::{RefinementConfig, tracks::Tracks};
use crate::{
    ConfigError, Estimate, Hypothesis, Individual, Localizer, Reliability, StartPrior, StepInput,
    observation::features::FeatureModel,
};

/// Longest time between two images that is taken for one step, seconds.
const MAX_STEP_SECS: f64 = 1.0;

/// Tracks the hypotheses of another localizer.
pub struct Refined {
    config: RefinementConfig,
    search: Box<dyn Localizer>,
    model: Box<dyn FeatureModel>,
    tracks: Tracks,
    reliability: Reliability,
    last_odometry: Option<PlanarPose>,
    last_at: Option<Timestamp>,
    winner: Option<(u64, PlanarPose)>,
    max_jump_m: f64,
    estimate: Estimate,
}

impl Refined {
    /// Refines what `search` finds. `max_jump_m` is the distance at which two poses share nothing.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(
        config: RefinementConfig,
        search: Box<dyn Localizer>,
        model: Box<dyn FeatureModel>,
        max_jump_m: f64,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            reliability: Reliability::new(config.reliability),
            config,
            search,
            model,
            tracks: Tracks::default(),
            last_odometry: None,
            last_at: None,
            winner: None,
            max_jump_m,
            estimate: Estimate::unknown(),
        })
    }

    fn forget(&mut self) {
        self.tracks.clear();
        self.reliability.reset();
        self.winner = None;
        self.estimate.forget();
    }

    /// Motion since the last step, seen from the robot, and the time that passed.
    fn motion(&mut self, input: &StepInput<'_>) -> (Option<PlanarPose>, f64) {
        let at = input.percept.at;
        let secs = self.last_at.map_or(0.0, |last| at.secs_since(last)).clamp(0.0, MAX_STEP_SECS);
        self.last_at = Some(at);
        let odometry = input.odometry.filter(PlanarPose::is_finite);
        let motion = match (self.last_odometry, odometry) {
            (Some(last), Some(now)) => Some(now.relative_to(&last)),
            (None, Some(_)) => Some(PlanarPose::default()),
            (_, None) => None,
        };
        self.last_odometry = odometry;
        // An odometry that jumps says nothing.
        (motion.filter(|m| m.x_m.hypot(m.y_m) < self.max_jump_m / 2.0), secs)
    }

    fn update_reliability(&mut self, quality: f64) {
        let Some(best) = self.tracks.best() else {
            self.reliability.reset();
            self.winner = None;
            return;
        };
        self.reliability.update(best.last_agreement, quality);
        let pose = best.filter.pose();
        if let Some((id, last)) = self.winner
            && id != best.id
        {
            self.reliability.jump(last.distance_m(&pose), self.max_jump_m);
        }
        self.winner = Some((best.id, pose));
    }

    fn update_estimate(&mut self) {
        let estimate = &mut self.estimate;
        estimate.hypotheses.clear();
        let Some(best) = self.tracks.best() else {
            estimate.reliability = 0.0;
            return;
        };
        estimate.world_from_robot = best.filter.pose();
        estimate.covariance = best.filter.pose_covariance();
        estimate.likelihood = best.last_agreement;
        for track in self.tracks.iter() {
            let hypothesis = Hypothesis {
                world_from_robot: track.filter.pose(),
                covariance: track.filter.pose_covariance(),
                probability: track.evidence.exp(),
            };
            if let Some(mirrored) = self.model.mirrored(&hypothesis.world_from_robot) {
                estimate.hypotheses.push(Hypothesis { world_from_robot: mirrored, ..hypothesis });
            }
            estimate.hypotheses.push(hypothesis);
        }
        estimate.normalize_hypotheses();
        let spread = (self.config.reliable_spread_m / best.filter.spread_m()).min(1.0);
        let total: f64 = self.tracks.iter().map(|track| track.evidence.exp()).sum();
        estimate.reliability = self.reliability.value() * spread / total;
    }
}

impl Localizer for Refined {
    fn reset(&mut self) {
        self.search.reset();
        self.forget();
    }

    fn reset_to(&mut self, prior: &StartPrior) {
        self.search.reset_to(prior);
        self.forget();
    }

    fn step(&mut self, input: &StepInput<'_>, rng: &mut Rng) -> &Estimate {
        let (motion, secs) = self.motion(input);
        self.search.step(input, rng);
        if input.is_lifted {
            self.forget();
            return &self.estimate;
        }
        self.tracks.predict(motion.as_ref(), secs, &self.config);
        self.model.condition_on(input.percept);
        self.tracks.update(self.model.as_ref(), self.search.estimate(), secs, &self.config);
        self.update_reliability(input.percept.quality);
        self.update_estimate();
        &self.estimate
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    fn individuals(&self, out: &mut Vec<Individual>) {
        self.search.individuals(out);
    }
}
