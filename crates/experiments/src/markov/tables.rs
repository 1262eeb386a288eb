//! Learns the observation tables from captures in the simulator.

use rayon::prelude::*;
use visloc_base::RngTree;
use visloc_geom::angle;
use visloc_locate::markov::{BlobView, CaseLimits, CaseTables, learn_tables};

use super::stage::Stage;
use crate::ExperimentError;

/// Takes captures in every state and learns both tables.
///
/// Where the goal is far out of view no picture is drawn: nothing is seen.
pub(super) fn learn(stage: &Stage, captures: u64, seeds: &RngTree) -> Result<CaseTables, ExperimentError> {
    let states: Vec<usize> = (0..stage.grid.num_states()).collect();
    let of_state = |state: &usize| captures_of(stage, *state, captures, seeds);
    let taken: Result<Vec<_>, _> = states.par_iter().map(of_state).collect();
    let captures = taken?.into_iter().flatten();
    Ok(learn_tables(CaseLimits::default(), states.len(), captures))
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
