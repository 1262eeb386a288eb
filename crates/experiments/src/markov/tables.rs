//! Learns the observation tables, from captures in the simulator or from a recording.

use std::path::Path;

use rayon::prelude::*;
use visloc_core::{Frame, RngTree, Source, geom::angle};
use visloc_io::bag::{BagReader, BagTopics};
use visloc_locate::markov::{
    BlobView, CaseLimits, CaseTables, TableError, ViewDensities, learn_densities, learn_tables,
};

use super::stage::{GOAL, Stage, analyzer};
use crate::ExperimentError;

/// What the captures of all states taught.
pub(super) struct Learned {
    /// The published tables, as plain shares of the captures.
    pub cases: CaseTables,
    /// The same captures without cases.
    pub densities: ViewDensities,
    /// A line about the recording, if they are from one.
    pub origin: Option<String>,
}

/// Images of a recording in a state from which on they teach something.
const LEAST_IMAGES: usize = 5;
/// The tables are those of a head that looks straight ahead: it is turned by no more than this, radians.
const MAX_HEAD_YAW_RAD: f64 = 0.15;
/// The robot stands on the ground if it is no higher than this, meters.
const MAX_HEIGHT_M: f64 = 0.02;

/// Tables learned from 50 captures in each state with seed 1.
const CASES: &str = include_str!("../../data/markov-tables.csv");
/// Densities learned from the same captures.
const DENSITIES: &str = include_str!("../../data/markov-densities.csv");
/// Share of views that can be anything, in the densities.
const OUTLIER: f64 = 0.03;

impl Learned {
    /// The tables that come with the program.
    pub fn shipped() -> Result<Self, ExperimentError> {
        Self::from_csv(CASES, DENSITIES)
    }

    fn from_csv(cases: &str, densities: &str) -> Result<Self, ExperimentError> {
        let refused = |error: TableError| ExperimentError::Run {
            cell: "tables".to_owned(),
            run: 0,
            reason: error.to_string(),
        };
        Ok(Self {
            cases: CaseTables::from_csv(CaseLimits::default(), cases).map_err(refused)?,
            densities: ViewDensities::from_csv(OUTLIER, densities).map_err(refused)?,
            origin: None,
        })
    }

    fn of(captures: &[(usize, Option<BlobView>)], num_states: usize) -> Self {
        let all = || captures.iter().copied();
        Self {
            cases: learn_tables(CaseLimits::default(), num_states, all()),
            densities: learn_densities(num_states, OUTLIER, all()),
            origin: None,
        }
    }

    /// What the images of a recording with truth teach, where the robot stands on the ground and looks straight ahead. States with
    /// hardly any image keep the tables that come with the program.
    pub fn from_recording(stage: &Stage, recording: &Path) -> Result<Self, ExperimentError> {
        let refused =
            |reason: String| ExperimentError::Setup { reason: format!("{}: {reason}", recording.display()) };
        let mut reader =
            BagReader::open(recording, BagTopics::default()).map_err(|error| refused(error.to_string()))?;
        let (mut analyzer, mut rng) = (analyzer()?, RngTree::new(0).stream("analysis", 0));
        let (mut captures, mut num_in_state) = (Vec::new(), vec![0; stage.grid.num_states()]);
        while let Some(next) = reader.next_item() {
            let next = next.map_err(|error| refused(error.to_string()))?;
            let Some(truth) = next.truth.filter(|truth| truth.height_m <= MAX_HEIGHT_M) else { continue };
            if head_yaw_rad(&next.frame).abs() > MAX_HEAD_YAW_RAD
                || analyzer.analyze(&next.frame, &mut rng).is_err()
            {
                continue;
            }
            let state = stage.grid.nearest(&truth.world_from_robot);
            num_in_state[state] += 1;
            captures.push((state, BlobView::of(analyzer.percept(), GOAL)));
        }
        let is_known = |state: usize| num_in_state[state] >= LEAST_IMAGES;
        let num_known = (0..num_in_state.len()).filter(|state| is_known(*state)).count();
        if num_known == 0 {
            let expected =
                "expected images with truth (/ground_truth/pose) of a robot that looks straight ahead, found";
            return Err(refused(format!("{expected} {} of them", captures.len())));
        }
        let here = Self::of(&captures, num_in_state.len());
        let cases = merged(&here.cases.to_csv(), CASES, is_known);
        let densities = merged(&here.densities.to_csv(), DENSITIES, is_known);
        let origin = format!(
            "Observation tables: from {} images of {}, in {num_known} of {} states; the others as they come with the program.",
            captures.len(),
            recording.display(),
            num_in_state.len()
        );
        Ok(Self { origin: Some(origin), ..Self::from_csv(&cases, &densities)? })
    }

    /// What captures in every state teach.
    ///
    /// Where the goal is far out of view no picture is drawn: nothing is seen.
    pub fn from_captures(stage: &Stage, captures: u64, seeds: &RngTree) -> Result<Self, ExperimentError> {
        let states: Vec<usize> = (0..stage.grid.num_states()).collect();
        let of_state = |state: &usize| captures_of(stage, *state, captures, seeds);
        let taken: Vec<Vec<_>> = states.par_iter().map(of_state).collect::<Result<_, _>>()?;
        Ok(Self::of(&taken.concat(), states.len()))
    }
}

/// How far the camera is turned to the left of where the robot looks.
fn head_yaw_rad(frame: &Frame) -> f64 {
    let ahead = frame.robot_from_camera.rotate(&nalgebra::Vector3::z());
    ahead.y.atan2(ahead.x)
}

/// Lines of the states that are known, and those of another table for the others; both have a header.
fn merged(known: &str, others: &str, is_known: impl Fn(usize) -> bool) -> String {
    let of_line = |(line, (known, other))| {
        let is_state_known = usize::checked_sub(line, 1).is_some_and(&is_known);
        if is_state_known { known } else { other }
    };
    let lines: Vec<&str> = known.lines().zip(others.lines()).enumerate().map(of_line).collect();
    lines.join("\n") + "\n"
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
