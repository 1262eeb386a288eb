//! A robot that is carried elsewhere: how soon it knows its place again, by itself and when the others see it.
//!
//! Unlike under the other conditions its localizer is told where the team sees it, so the game is played with all of them.

use std::f64::consts::PI;

use visloc_core::{RngTree, geom::PlanarPose};
use visloc_locate::{
    Estimate, LOCALIZED_RELIABILITY, Pipeline,
    team::{Member, TeamConfig, TeamFilter, TeamMessage},
};
use visloc_sim::{DetectorSetup, TeamFrame};

use super::{
    ConditionRecord, GameSetup, Score,
    experiment::bytes_per_sec,
    game::{begin, localizer_of, setup_error},
    network::Network,
    play::{Conditions, sighting},
    score::{DRAGGED_SECS, is_near, is_right, is_wrong},
};
use crate::ExperimentError;

/// Who carries it takes so long, seconds.
const CARRY_SECS: f64 = 2.0;

/// What is told of the robot: alone, and with the team, up to the mirrored place; and with its half.
pub(super) const CONDITIONS: [&str; 3] =
    ["carried off: alone, up to the mirror", "carried off: team, up to the mirror", "carried off: team"];

/// A robot that listens to the others.
struct Player {
    pipeline: Pipeline,
    filter: TeamFilter,
}

impl Player {
    fn step(&mut self, frame: &TeamFrame) -> Result<Option<TeamMessage>, ExperimentError> {
        if let Some(prior) = self.filter.advice() {
            self.pipeline.reset_to(&prior);
        }
        let TeamFrame { source, detections } = frame;
        let estimate = self.pipeline.step(&source.frame).map_err(setup_error)?;
        let at = source.frame.at;
        let seen: Vec<_> =
            detections.iter().map(|seen| sighting(seen, at, &DetectorSetup::default())).collect();
        self.filter.step(at, estimate, source.frame.odometry, &seen);
        Ok(self.filter.message())
    }
}

/// What is counted from the moment when the robot stands again.
struct Count {
    right_after_secs: Option<f64>,
    right_secs: f64,
    wrong_secs: f64,
}

impl Count {
    fn add(&mut self, secs: f64, step_secs: f64, (is_right, is_wrong): (bool, bool)) {
        if is_right {
            self.right_after_secs.get_or_insert(secs);
            self.right_secs += step_secs;
        }
        self.wrong_secs += if is_wrong { step_secs } else { 0.0 };
    }
}

/// Plays a game in which the last robot is carried to a free place at half time.
pub(super) fn play_carried(setup: &GameSetup) -> Result<Vec<ConditionRecord>, ExperimentError> {
    let (mut team, first, pipelines) = begin(setup)?;
    let step_secs = 1.0 / setup.images_per_sec;
    let carried = setup.num_robots - 1;
    // The same localizer again, which hears nothing.
    let mut alone = localizer_of(setup, carried, team.map(), &team.truths()[carried])?;
    let player = |(i, pipeline)| {
        let member = Member { team: "team".into(), number: 1 + i as u8, session: 1 };
        let filter = TeamFilter::new(TeamConfig::default(), member, team.map()).map_err(setup_error)?;
        Ok(Player { pipeline, filter })
    };
    let mut players =
        pipelines.into_iter().enumerate().map(player).collect::<Result<Vec<_>, ExperimentError>>()?;
    let usual = Conditions::default();
    let rng = RngTree::new(setup.seed).subtree("carried", 0).stream("network", 0);
    let mut network = Network::new(usual.loss, usual.delay_secs, rng);
    let in_steps = |secs: f64| (secs * setup.images_per_sec).round() as usize;
    let (lifted_at, num_steps) = (in_steps(0.5 * setup.secs), in_steps(setup.secs));
    let down_at = lifted_at + in_steps(CARRY_SECS);
    let mut counts = CONDITIONS.map(|_| Count { right_after_secs: None, right_secs: 0.0, wrong_secs: 0.0 });
    let mut messages = Vec::new();
    let mut first = Some(first);
    for step in 0..num_steps {
        if step == lifted_at && !team.kidnap(carried, setup.seed, in_steps(CARRY_SECS)) {
            return Err(setup_error("there is no free place to carry a robot to"));
        }
        let frames = first.take().unwrap_or_else(|| team.step());
        for (robot, (frame, player)) in frames.iter().zip(&mut players).enumerate() {
            let Some(message) = player.step(frame)? else { continue };
            for to in (0..setup.num_robots).filter(|to| *to != robot) {
                network.send(frame.source.frame.at, to, &message);
            }
            messages.push(message);
        }
        let now = frames[carried].source.frame.at;
        for (at, to, message) in network.arrived(now + step_secs) {
            // Whatever is wrong with a message, the robot goes on without it.
            let _ = players[to].filter.receive(&message, at);
        }
        let by_itself = alone.step(&frames[carried].source.frame).map_err(setup_error)?;
        let truth = frames[carried].source.truth.filter(|truth| truth.height_m <= 0.0);
        if let (Some(truth), true) = (truth, step >= down_at) {
            let (truth, secs) = (truth.world_from_robot, (step - down_at) as f64 * step_secs);
            let Player { pipeline, filter } = &players[carried];
            let answer = &filter.answer().estimate;
            counts[0].add(secs, step_secs, up_to_mirror(by_itself, &truth));
            counts[1].add(secs, step_secs, up_to_mirror(pipeline.estimate(), &truth));
            counts[2].add(secs, step_secs, (is_right(answer, &truth), is_wrong(answer, &truth)));
        }
    }
    let bytes_per_sec = bytes_per_sec(messages.iter(), setup);
    let judged_secs = num_steps.saturating_sub(down_at).max(1) as f64 * step_secs;
    Ok(CONDITIONS
        .into_iter()
        .zip(counts)
        .map(|(name, count)| count.record(name, judged_secs, bytes_per_sec))
        .collect())
}

impl Count {
    fn record(self, name: &str, judged_secs: f64, bytes_per_sec: f64) -> ConditionRecord {
        let score = Score {
            right_after_secs: vec![self.right_after_secs],
            num_dragged: usize::from(self.wrong_secs > DRAGGED_SECS),
            right_share: self.right_secs / judged_secs,
            wrong_share: self.wrong_secs / judged_secs,
            ..Score::default()
        };
        ConditionRecord { name: name.to_owned(), score, bytes_per_sec }
    }
}

/// Whether a robot that claims to know its place, of two mirrored ones either, is right, and whether it is wrong.
fn up_to_mirror(estimate: &Estimate, truth: &PlanarPose) -> (bool, bool) {
    let mirrored = PlanarPose::new(-truth.x_m, -truth.y_m, truth.yaw_rad + PI);
    let is_there = is_near(estimate, truth) || is_near(estimate, &mirrored);
    let claims = estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY;
    (claims && is_there, claims && !is_there)
}
