//! Learns the observation tables from captures in the simulator.

use rayon::prelude::*;
use visloc_base::RngTree;
use visloc_geom::angle;
use visloc_locate::markov::{
    BlobView, CaseLimits, CaseTables, TableError, ViewDensities, learn_densities, learn_tables,
};

use super::stage::Stage;
use crate::ExperimentError;

/// What the captures of all states taught.
pub(super) struct Learned {
    /// The published tables, as plain shares of the captures.
    pub cases: CaseTables,
    /// The same captures without cases.
    pub densities: ViewDensities,
}

/// Tables learned from 50 captures in each state with seed 1.
const CASES: &str = include_str!("../../data/markov-tables.csv");
/// Densities learned from the same captures.
const DENSITIES: &str = include_str!("../../data/markov-densities.csv");
/// Share of views that can be anything, in the densities.
const OUTLIER: f64 = 0.03;

impl Learned {
    /// The tables that come with the program.
    pub fn shipped() -> Result<Self, ExperimentError> {
        let refused = |error: TableError| ExperimentError::Run {
            cell: "tables".to_owned(),
            run: 0,
            reason: error.to_string(),
        };
        Ok(Self {
            cases: CaseTables::from_csv(CaseLimits::default(), CASES).map_err(refused)?,
            densities: ViewDensities::from_csv(OUTLIER, DENSITIES).map_err(refused)?,
        })
    }

    /// What captures in every state teach.
    ///
    /// Where the goal is far out of view no picture is drawn: nothing is seen.
    pub fn from_captures(stage: &Stage, captures: u64, seeds: &RngTree) -> Result<Self, ExperimentError> {
        let states: Vec<usize> = (0..stage.grid.num_states()).collect();
        let of_state = |state: &usize| captures_of(stage, *state, captures, seeds);
        let taken: Vec<Vec<_>> = states.par_iter().map(of_state).collect::<Result<_, _>>()?;
        let all = || taken.iter().flatten().copied();
        Ok(Self {
            cases: learn_tables(CaseLimits::default(), states.len(), all()),
            densities: learn_densities(states.len(), OUTLIER, all()),
        })
    }
}

/// The captures of one state.
pub(super) fn captures_of(
    stage: &Stage,
    state: usize,
    captures: u64,
    seeds: &RngTree,
) -> Result<Vec<(usize, Option<BlobView>)>, ExperimentError> {
    if !can_see_goal(stage, state) {
        return Ok((0..captures).map(|_| (state, None)).collect());
    }
    let mut eye = stage.eye()?;
    let mut rng = seeds.stream("captures", state as u64);
    Ok((0..captures).map(|_| (state, eye.goal_in_state(state, &mut rng))).collect())
}

/// Whether any part of the blue goal is within 45 degrees of the heading; the camera sees 23 degrees to either side.
fn can_see_goal(stage: &Stage, state: usize) -> bool {
    const MAX_BEARING_RAD: f64 = 0.8;
    let pose = stage.grid.pose(state);
    let goal = &stage.field.goals()[1];
    [goal.post_y_m, 0.0, -goal.post_y_m].into_iter().any(|y_m| {
        let direction = (y_m - pose.y_m).atan2(goal.x_m - pose.x_m);
        angle::difference(direction, pose.yaw_rad).abs() < MAX_BEARING_RAD
    })
}
