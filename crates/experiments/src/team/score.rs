//! What the team was good for.

use serde::{Deserialize, Serialize};
use visloc_core::geom::PlanarPose;
use visloc_locate::{Estimate, LOCALIZED_RELIABILITY};

use super::{Conditions, Game, Played};

/// A claim is right within this.
const RIGHT_M: f64 = 0.5;
const RIGHT_RAD: f64 = 0.5;
/// A robot that claims a wrong place for so long has been dragged there, seconds.
pub(super) const DRAGGED_SECS: f64 = 1.0;
/// Two that see the ball within this time have seen it in common, seconds.
const SAME_BALL_SECS: f64 = 1.0;

/// One game, the robots that lie and that knew left out.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// For each robot that was ever tied to the one that knows by a chain of sightings: seconds from then until it was right, `None` if it
    /// never was.
    pub right_after_secs: Vec<Option<f64>>,
    /// Robots that were never tied.
    pub num_untied: usize,
    /// Robots that claimed a wrong place with the team, and by themselves they did not.
    pub num_dragged: usize,
    /// Share of the time in which robots were localized and right, with the team and by themselves.
    pub right_share: f64,
    /// By themselves.
    pub alone_right_share: f64,
    /// Share of the time in which they claimed a wrong place.
    pub wrong_share: f64,
    /// By themselves.
    pub alone_wrong_share: f64,
}

/// Compares answers with the truth.
pub fn score(game: &Game, conditions: &Conditions, played: &Played) -> Score {
    let num_robots = game.moments.first().map_or(0, Vec::len);
    let is_honest = |robot: usize| conditions.liar.is_none() || robot + 1 != num_robots;
    let tied_from = tied_from(game, num_robots);
    let mut score = Score::default();
    let mut judged = 0.0;
    for robot in (0..num_robots).filter(|robot| is_honest(*robot)) {
        let moments =
            || game.moments.iter().map(|all| &all[robot]).zip(played.answers.iter().map(|all| &all[robot]));
        let count = |holds: &dyn Fn(&Estimate, &Estimate, &PlanarPose) -> bool| {
            let held = moments().filter(|(m, answer)| !m.is_carried && holds(answer, &m.estimate, &m.truth));
            held.count() as f64
        };
        let wrong_secs =
            count(&|team, alone, truth| is_wrong(team, truth) && !is_wrong(alone, truth)) * game.step_secs;
        score.num_dragged += usize::from(wrong_secs > DRAGGED_SECS);
        if Some(robot) == game.who_knows {
            continue;
        }
        judged += 1.0;
        let share = count(&|_, _, _| true).max(1.0);
        score.right_share += count(&|team, _, truth| is_right(team, truth)) / share;
        score.alone_right_share += count(&|_, alone, truth| is_right(alone, truth)) / share;
        score.wrong_share += count(&|team, _, truth| is_wrong(team, truth)) / share;
        score.alone_wrong_share += count(&|_, alone, truth| is_wrong(alone, truth)) / share;
        let Some(from) = tied_from[robot] else {
            score.num_untied += 1;
            continue;
        };
        let right_at = moments().skip(from).position(|(moment, answer)| is_right(answer, &moment.truth));
        score.right_after_secs.push(right_at.map(|steps| steps as f64 * game.step_secs));
    }
    for share in [
        &mut score.right_share,
        &mut score.alone_right_share,
        &mut score.wrong_share,
        &mut score.alone_wrong_share,
    ] {
        *share /= f64::max(judged, 1.0);
    }
    score
}

pub(super) fn is_near(estimate: &Estimate, truth: &PlanarPose) -> bool {
    let pose = &estimate.world_from_robot;
    pose.distance_m(truth) < RIGHT_M && pose.heading_difference_rad(truth) < RIGHT_RAD
}

pub(super) fn is_right(estimate: &Estimate, truth: &PlanarPose) -> bool {
    estimate.is_localized() && is_near(estimate, truth)
}

pub(super) fn is_wrong(estimate: &Estimate, truth: &PlanarPose) -> bool {
    estimate.is_localized() && !is_near(estimate, truth)
}

/// For each robot the moment from which on a chain of sightings ties it to the one that knows: robots that saw each other or, within a
/// second, the ball, while both knew their places up to the symmetry.
fn tied_from(game: &Game, num_robots: usize) -> Vec<Option<usize>> {
    let mut groups: Vec<usize> = (0..num_robots).collect();
    let mut ball_at = vec![None::<usize>; num_robots];
    let mut tied = vec![None; num_robots];
    for (step, moments) in game.moments.iter().enumerate() {
        let knows = |robot: usize| moments[robot].estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY;
        let mut pairs = Vec::new();
        for robot in (0..num_robots).filter(|robot| knows(*robot)) {
            for seen in moments[robot].detections.iter().filter(|seen| seen.is_true) {
                pairs.extend(seen.who.filter(|who| knows(*who)).map(|who| (robot, who)));
                if seen.is_ball {
                    ball_at[robot] = Some(step);
                }
            }
        }
        let is_recent = |robot: usize| {
            ball_at[robot].is_some_and(|at| (step - at) as f64 * game.step_secs <= SAME_BALL_SECS)
        };
        let saw_ball: Vec<usize> = (0..num_robots).filter(|robot| is_recent(*robot)).collect();
        pairs.extend(saw_ball.windows(2).map(|pair| (pair[0], pair[1])));
        for (a, b) in pairs {
            let (from, to) = (groups[a], groups[b]);
            groups.iter_mut().filter(|group| **group == from).for_each(|group| *group = to);
        }
        let Some(who_knows) = game.who_knows else { continue };
        for robot in 0..num_robots {
            if tied[robot].is_none() && groups[robot] == groups[who_knows] {
                tied[robot] = Some(step);
            }
        }
    }
    tied
}
