//! Many observations without a goal, and how fast the filter recovers afterwards.

use rand::RngExt;
use serde::{Deserialize, Serialize};
use visloc_core::RngTree;
use visloc_locate::markov::{Action, Belief, CaseTables, MarkovFilter, Outcomes, Remedy, ViewLikelihoods};

use super::stage::Stage;
use crate::ExperimentError;

/// Why no goal is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Blindness {
    /// The robot turns round, looks at what is outside, and turns back.
    LooksAway,
    /// Somebody stands in front of the camera.
    Hidden,
    /// As `Hidden`, and before that the robot was carried to another place without noticing.
    Carried,
}

/// One sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct GoallessCell {
    /// Why no goal is seen.
    pub blindness: Blindness,
    /// Observations without a goal.
    pub num_without: usize,
    /// Whether the remedy is at work.
    pub has_remedy: bool,
}

/// What one run found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct GoallessRecord {
    /// Observations from the first one with the goal in view until the robot is found at its place; `None` if that did
    /// not happen on the way across the field.
    pub num_to_recover: Option<usize>,
}

/// The way across the field in its middle row, with the goal in view: states 48, 80, ..., 304.
const FIRST_COLUMN: usize = 1;
const LAST_COLUMN: usize = 9;
const MIDDLE_ROW_STATE: usize = 16;

/// One run: known start, then blind, then on the way.
pub(super) fn run(
    stage: &Stage,
    tables: &CaseTables,
    cell: &GoallessCell,
    run: u64,
    seeds: &RngTree,
) -> Result<GoallessRecord, ExperimentError> {
    // The same pictures for all cells, so that they differ by the blindness alone.
    let mut rng = seeds.stream("goalless", run);
    let mut eye = stage.eye()?;
    let first = 32 * FIRST_COLUMN + MIDDLE_ROW_STATE;
    let believed = match cell.blindness {
        Blindness::Carried => rng.random_range(0..stage.grid.num_states()),
        _ => first,
    };
    let remedy = if cell.has_remedy { Remedy::default() } else { Remedy::none() };
    let start = Belief::known(stage.grid, believed, 0.8);
    let mut filter = MarkovFilter::new(start, Outcomes::published(), remedy);
    let mut likelihoods = Vec::new();
    let turns = if cell.blindness == Blindness::LooksAway && cell.num_without > 0 { 2 } else { 0 };
    (0..turns).for_each(|_| filter.act(Action::TURN_LEFT));
    for _ in 0..cell.num_without {
        tables.likelihoods(None, &mut likelihoods);
        filter.observe(&likelihoods, false);
    }
    (0..turns).for_each(|_| filter.act(Action::TURN_RIGHT));
    for (count, column) in (FIRST_COLUMN..=LAST_COLUMN).enumerate() {
        let state = 32 * column + MIDDLE_ROW_STATE;
        if count > 0 {
            filter.act(Action::ADVANCE);
        }
        let view = eye.goal_in_state(state, &mut rng);
        tables.likelihoods(view.as_ref(), &mut likelihoods);
        filter.observe(&likelihoods, view.is_some());
        if filter.localized() == Some(state) {
            return Ok(GoallessRecord { num_to_recover: Some(count + 1) });
        }
    }
    Ok(GoallessRecord { num_to_recover: None })
}
