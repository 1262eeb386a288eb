//! The goalkeeper: from somewhere on the side line to the corner, left, to the middle of the goal, left.

use std::f64::consts::FRAC_PI_2;

use rand::RngExt;
use serde::{Deserialize, Serialize};
use visloc_core::{
    Rng, RngTree, gaussian,
    geom::{PlanarPose, angle},
};
use visloc_locate::{
    Localizer, StepInput,
    markov::{
        Action, Belief, CaseTables, Markov, MarkovConfig, MarkovFilter, Outcomes, Remedy, ViewLikelihoods,
    },
    observation::field::{FieldModelConfig, FieldObservationModel},
};

use super::stage::{Eye, Stage};
use crate::ExperimentError;

/// States of the way: corner, corner turned left, in front of the goal, turned left again.
const CORNER: usize = 352;
const CORNER_LEFT: usize = 355;
const GOAL_LEFT: usize = 371;
/// The last state of the way.
pub(super) const TARGET: usize = 370;

/// How the robot localizes itself and walks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Keeper {
    /// Head straight, one goal, whole tiles, and decisions by the published filter.
    Published,
    /// Head turning, both goals, a grid with a finer tile, and a way that is corrected by the estimate.
    Corrected,
}

/// Where the robot ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GoalkeeperRecord {
    /// From the middle of the target tile, meters.
    pub error_m: f64,
    /// From the target's heading, radians, 0 to pi.
    pub heading_error_rad: f64,
    /// Whether it is inside the target tile.
    pub is_in_tile: bool,
    /// Whether the robot itself knew that it had arrived.
    pub has_arrived: bool,
    /// Actions that it took.
    pub num_actions: usize,
}

/// One run.
pub(super) fn run(
    stage: &Stage,
    tables: &CaseTables,
    keeper: Keeper,
    run: u64,
    seeds: &RngTree,
) -> Result<GoalkeeperRecord, ExperimentError> {
    let mut rng = seeds.stream("goalkeeper", run);
    let mut body = Body {
        pose: start(stage, &mut rng),
        odometry: PlanarPose::default(),
        half_carpet_m: stage.field.half_carpet_m(),
    };
    let mut eye = stage.eye()?;
    let (has_arrived, num_actions) = match keeper {
        Keeper::Published => walk_by_tiles(stage, tables, &mut eye, &mut body, &mut rng),
        Keeper::Corrected => walk_corrected(stage, &mut eye, &mut body, &mut rng)?,
    };
    let target = stage.grid.pose(TARGET);
    Ok(GoalkeeperRecord {
        error_m: body.pose.distance_m(&target),
        heading_error_rad: body.pose.heading_difference_rad(&target),
        is_in_tile: stage.grid.is_in_tile(TARGET, &body.pose),
        has_arrived,
        num_actions,
    })
}

/// Put down by hand: anywhere along the side line's row of tiles but its last third, looking to its own end.
fn start(stage: &Stage, rng: &mut Rng) -> PlanarPose {
    let place = PlanarPose::new(rng.random_range(0.0..3.5), gaussian(rng, 0.05), gaussian(rng, 0.05));
    stage.grid.pose(0).compose(&place)
}

/// The robot's true pose, and what its odometry says.
struct Body {
    pose: PlanarPose,
    odometry: PlanarPose,
    half_carpet_m: (f64, f64),
}

impl Body {
    /// Walks: every part of the motion is 6 % off, and it drifts by 1 cm and 1 degree. The odometry reports the motion that
    /// was wanted.
    fn walk(&mut self, wanted: &PlanarPose, rng: &mut Rng) {
        const RELATIVE_SIGMA: f64 = 0.06;
        const DRIFT_SIGMA_M: f64 = 0.01;
        const DRIFT_SIGMA_RAD: f64 = 0.0175;
        let mut noisy =
            |value: f64, drift: f64| value * (1.0 + gaussian(rng, RELATIVE_SIGMA)) + gaussian(rng, drift);
        let done = PlanarPose::new(
            noisy(wanted.x_m, DRIFT_SIGMA_M),
            noisy(wanted.y_m, DRIFT_SIGMA_M),
            noisy(wanted.yaw_rad, DRIFT_SIGMA_RAD),
        );
        let moved = self.pose.compose(&done);
        // Boards around the carpet stop it.
        let (x, y) = self.half_carpet_m;
        self.pose = PlanarPose { x_m: moved.x_m.clamp(-x, x), y_m: moved.y_m.clamp(-y, y), ..moved };
        self.odometry = self.odometry.compose(wanted);
    }
}

/// The source's way: the next action follows from the state that the filter calls the robot's; as long as there is none,
/// from the last one.
fn walk_by_tiles(
    stage: &Stage,
    tables: &CaseTables,
    eye: &mut Eye<'_>,
    body: &mut Body,
    rng: &mut Rng,
) -> (bool, usize) {
    const MAX_ACTIONS: usize = 40;
    let mut filter = MarkovFilter::new(on_side_line(stage), Outcomes::of_odometry(), Remedy::default());
    let (mut likelihoods, mut leg) = (Vec::new(), CORNER);
    for num_actions in 0..MAX_ACTIONS {
        let view = eye.goal(&body.pose, rng);
        tables.likelihoods(view.as_ref(), &mut likelihoods);
        filter.observe(&likelihoods, view.is_some());
        if filter.localized() == Some(leg) {
            leg = match leg {
                CORNER => CORNER_LEFT,
                CORNER_LEFT => GOAL_LEFT,
                GOAL_LEFT => TARGET,
                _ => return (true, num_actions),
            };
        }
        let (action, motion) = if leg == CORNER_LEFT || leg == TARGET {
            (Action::TURN_LEFT, PlanarPose::new(0.0, 0.0, FRAC_PI_2))
        } else {
            (Action::ADVANCE, PlanarPose::new(stage.grid.tile_m(), 0.0, 0.0))
        };
        body.walk(&motion, rng);
        filter.act(action);
    }
    (false, MAX_ACTIONS)
}

/// The keeper knows that it was put on the side line: the states of row 0 that look along it share 0.8.
fn on_side_line(stage: &Stage) -> Belief {
    let mut belief = Belief::uniform(stage.grid);
    let num_columns = stage.grid.num_columns();
    let is_there = |index: usize| {
        let state = stage.grid.state(index);
        state.row == 0 && state.heading == 0
    };
    let others = stage.grid.num_states() - num_columns;
    let (there, elsewhere) = (0.8 / num_columns as f64, 0.2 / others as f64);
    belief.weigh(|index| if is_there(index) { there } else { elsewhere });
    belief
}

/// The same way with small motions that follow from the estimate.
fn walk_corrected(
    stage: &Stage,
    eye: &mut Eye<'_>,
    body: &mut Body,
    rng: &mut Rng,
) -> Result<(bool, usize), ExperimentError> {
    const MAX_ACTIONS: usize = 80;
    const HEAD_YAWS_RAD: [f64; 5] = [-1.8, -0.9, 0.0, 0.9, 1.8];
    let model = FieldObservationModel::new(&stage.field, &FieldModelConfig::default())?;
    let mut localizer = Markov::new(fine_config(), &model)?;
    let way = [CORNER, GOAL_LEFT, TARGET].map(|state| stage.grid.pose(state));
    let mut leg = 0;
    for num_actions in 0..MAX_ACTIONS {
        for head_yaw_rad in HEAD_YAWS_RAD {
            let percept = eye.look(&body.pose, head_yaw_rad, rng);
            let input = StepInput { percept, odometry: Some(body.odometry), is_lifted: false };
            localizer.step(&input, &mut RngTree::new(0).stream("unused", 0));
        }
        let estimate = localizer.estimate();
        let to_go = way[leg].relative_to(&estimate.world_from_robot);
        if !estimate.is_localized() {
            // Looks around until it knows where it is.
            body.walk(&PlanarPose::new(0.0, 0.0, 0.5), rng);
        } else if has_reached(&to_go, leg > 0) {
            leg += 1;
            if leg == way.len() {
                return Ok((true, num_actions));
            }
        } else {
            body.walk(&next_motion(&to_go), rng);
        }
    }
    Ok((false, MAX_ACTIONS))
}

/// Tiles of half the published size. Headings as fine as the bearing of a post tells: with 16 of them the few samples of
/// a state lie farther apart than the bearing's error, and the robot may walk on while its state stays.
fn fine_config() -> MarkovConfig {
    let mut config = MarkovConfig { tile_m: 0.25, num_headings: 32, ..MarkovConfig::default() };
    config.view.samples_per_state = 6;
    config.view.bearing_sigma_deg = 3.0;
    config.view.log_area_sigma = 0.15;
    config.view.weight = 1.0;
    config
}

fn has_reached(to_go: &PlanarPose, is_at_goal: bool) -> bool {
    let (distance_m, turn_rad) = if is_at_goal { (0.08, 0.15) } else { (0.25, 0.4) };
    to_go.x_m.hypot(to_go.y_m) < distance_m && to_go.yaw_rad.abs() < turn_rad
}

/// At most 0.3 m and 0.5 rad towards a pose that is seen from the robot.
fn next_motion(to_go: &PlanarPose) -> PlanarPose {
    const MAX_STEP_M: f64 = 0.3;
    const MAX_TURN_RAD: f64 = 0.5;
    let distance_m = to_go.x_m.hypot(to_go.y_m);
    let share = (MAX_STEP_M / distance_m.max(1e-6)).min(1.0);
    let turn_rad = angle::wrap(to_go.yaw_rad).clamp(-MAX_TURN_RAD, MAX_TURN_RAD);
    PlanarPose::new(to_go.x_m * share, to_go.y_m * share, turn_rad)
}
