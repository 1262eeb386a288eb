//! The loop of actions and observations.

use super::{Action, Belief, Outcomes, Remedy};

/// A belief with the tables of its actions, and the remedy against runs of observations without a landmark.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkovFilter {
    belief: Belief,
    outcomes: Outcomes,
    remedy: Remedy,
    /// Observations without a landmark since the last one with a landmark.
    num_without: u32,
}

impl MarkovFilter {
    /// From this probability of one state on the robot counts as localized. Source: section 4.3.
    pub const LOCALIZED_PROBABILITY: f64 = 0.5;

    /// A filter that starts with a belief.
    pub fn new(belief: Belief, outcomes: Outcomes, remedy: Remedy) -> Self {
        Self { belief, outcomes, remedy, num_without: 0 }
    }

    /// The belief.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// The robot did this.
    pub fn act(&mut self, action: Action) {
        self.belief.predict(action, &self.outcomes);
        self.belief.mix_uniform(self.remedy.floor);
    }

    /// The robot moved, but nobody knows where to: spreads the belief over neighbors with this standard deviation.
    pub fn diffuse(&mut self, position_sigma_m: f64, heading_sigma_rad: f64) {
        let grid = *self.belief.grid();
        let walked = (position_sigma_m / grid.tile_m()).powi(2).min(0.4);
        let turned = (heading_sigma_rad / grid.heading_step_rad()).powi(2).min(0.4);
        for (action, share) in [
            (Action::Walk { ahead: 1, left: 0 }, walked),
            (Action::Walk { ahead: -1, left: 0 }, walked),
            (Action::Walk { ahead: 0, left: 1 }, walked),
            (Action::Walk { ahead: 0, left: -1 }, walked),
            (Action::TURN_RIGHT, turned),
            (Action::TURN_LEFT, turned),
        ] {
            // To each side half of the variance.
            let shares = [1.0 - share / 2.0, share / 2.0, 0.0, 0.0];
            let outcomes = Outcomes { walk: shares, turn_right: shares, turn_left: shares };
            self.belief.predict(action, &outcomes);
        }
    }

    /// An observation with the given likelihood in each state. Observations without a landmark, one after the other,
    /// repeat each other and weigh less and less. Returns whether the observation was possible at all.
    pub fn observe(&mut self, likelihoods: &[f64], has_landmark: bool) -> bool {
        let weight = self.weight_of_next(has_landmark);
        let hidden = if has_landmark { 0.0 } else { self.remedy.hidden };
        let largest = likelihoods.iter().copied().fold(0.0, f64::max);
        let likelihood = |index: usize| {
            likelihoods.get(index).map_or(0.0, |likelihood| hidden * largest + (1.0 - hidden) * likelihood)
        };
        if weight >= 1.0 {
            self.belief.weigh(likelihood)
        } else {
            self.belief.weigh(|index| likelihood(index).powf(weight))
        }
    }

    /// The state in which the robot is, if one has more than half of the belief.
    pub fn localized(&self) -> Option<usize> {
        let (state, probability) = self.belief.best();
        (probability > Self::LOCALIZED_PROBABILITY).then_some(state)
    }

    fn weight_of_next(&mut self, has_landmark: bool) -> f64 {
        if has_landmark {
            self.num_without = 0;
            return 1.0;
        }
        let power = i32::try_from(self.num_without).unwrap_or(i32::MAX);
        self.num_without = self.num_without.saturating_add(1);
        self.remedy.first_weight * self.remedy.decay.powi(power)
    }
}
