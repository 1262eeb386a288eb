//! The walk along the right edge: states 0, 32, 64, ..., 352.

use rand::RngExt;
use serde::{Deserialize, Serialize};
use visloc_core::{Rng, RngTree};
use visloc_locate::markov::{
    Action, Belief, CaseTables, MarkovFilter, NUM_CASES, Outcomes, Remedy, ViewLikelihoods,
};

use super::stage::Stage;
use crate::ExperimentError;

/// Steps after the start: from state 0 to state 352.
pub(super) const NUM_STEPS: usize = 11;

/// What one walk found, one entry for each instant from 0 to 11.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WalkRecord {
    /// The state that the filter calls the robot's, if any.
    pub localized: Vec<Option<usize>>,
    /// Belief of the true state.
    pub true_belief: Vec<f64>,
    /// All beliefs of all instants; of the first run only, for the pictures.
    pub beliefs: Vec<Vec<f64>>,
}

impl WalkRecord {
    /// Whether the robot is found at an instant, and at the right place.
    pub fn is_right_at(&self, t: usize) -> bool {
        self.localized.get(t).copied().flatten() == Some(32 * t)
    }

    /// The first instant from which on the right state is always known.
    pub fn right_from(&self) -> Option<usize> {
        let wrong = (0..self.localized.len()).rev().take_while(|t| self.is_right_at(*t)).count();
        (wrong > 0).then(|| self.localized.len() - wrong)
    }

    fn push(&mut self, filter: &MarkovFilter, t: usize, keeps_belief: bool) {
        self.localized.push(filter.localized());
        self.true_belief.push(filter.belief().probabilities()[32 * t]);
        if keeps_belief {
            self.beliefs.push(filter.belief().probabilities().to_vec());
        }
    }
}

/// Experiment 1: known start, ideal motion, observations drawn from the tables.
pub(super) fn synthetic(stage: &Stage, tables: &CaseTables, run: u64, seeds: &RngTree) -> WalkRecord {
    let mut rng = seeds.stream("synthetic", run);
    let start = Belief::known(stage.grid, 0, 0.8);
    let mut filter = MarkovFilter::new(start, Outcomes::published(), Remedy::default());
    let mut record = empty();
    let mut likelihoods = Vec::new();
    record.push(&filter, 0, run == 0);
    for t in 1..=NUM_STEPS {
        filter.act(Action::ADVANCE);
        let size = draw(tables.size(32 * t), &mut rng);
        let centroid = draw(tables.centroid(32 * t), &mut rng);
        tables.likelihoods_of_cases(size, centroid, &mut likelihoods);
        filter.observe(&likelihoods, centroid > 0);
        record.push(&filter, t, run == 0);
    }
    record
}

/// Experiment 2: unknown start, pictures from the simulator, the robot within a few centimeters of the tiles' middles.
pub(super) fn images(
    stage: &Stage,
    views: &dyn ViewLikelihoods,
    outcomes: Outcomes,
    remedy: Remedy,
    (run, seeds): (u64, &RngTree),
) -> Result<WalkRecord, ExperimentError> {
    // The same pictures for all readings.
    let mut rng = seeds.stream("images", run);
    let mut eye = stage.eye()?;
    let mut filter = MarkovFilter::new(Belief::uniform(stage.grid), outcomes, remedy);
    let mut record = empty();
    let mut likelihoods = Vec::new();
    for t in 0..=NUM_STEPS {
        if t > 0 {
            filter.act(Action::ADVANCE);
        }
        let view = eye.goal_in_state(32 * t, &mut rng);
        views.likelihoods(view.as_ref(), &mut likelihoods);
        filter.observe(&likelihoods, view.is_some());
        record.push(&filter, t, run == 0);
    }
    Ok(record)
}

fn empty() -> WalkRecord {
    WalkRecord { localized: Vec::new(), true_belief: Vec::new(), beliefs: Vec::new() }
}

fn draw(shares: &[f64; NUM_CASES], rng: &mut Rng) -> usize {
    let mut mark: f64 = rng.random();
    for (case, share) in shares.iter().enumerate() {
        mark -= share;
        if mark < 0.0 {
            return case;
        }
    }
    NUM_CASES - 1
}
