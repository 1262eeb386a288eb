//! A recorded game with messages between the robots.

use visloc_core::{Clock, RngTree, Timestamp};
use visloc_locate::{
    ConfigError, Estimate,
    team::{Liar, Member, Sighting, SightingKind, TeamConfig, TeamFilter, TeamMessage},
};
use visloc_sim::{Detection, DetectorSetup};

use super::{Game, network::Network};

/// When a robot begins anew, having forgotten everything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restart {
    /// The robot.
    pub robot: usize,
    /// After so much of the game, seconds.
    pub secs: f64,
}

/// What is different from a perfect team.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Whether anybody hears anybody.
    pub has_network: bool,
    /// Share of the messages that are lost.
    pub loss: f64,
    /// Least delay of messages, seconds.
    pub delay_secs: f64,
    /// From image to detection, seconds.
    pub detector_secs: f64,
    /// Clocks of robots are ahead by multiples of this, seconds.
    pub clock_secs: f64,
    /// Sightings are what the own detector finds in the images, not what the simulator makes.
    pub own_detector: bool,
    /// The last robot lies.
    pub liar: Option<Liar>,
    /// A robot begins anew.
    pub restart: Option<Restart>,
}

impl Default for Conditions {
    /// A local network: nothing is lost, 5 ms; a detector that needs 50 ms.
    fn default() -> Self {
        Self {
            has_network: true,
            loss: 0.0,
            delay_secs: 0.005,
            detector_secs: 0.05,
            clock_secs: 0.0,
            own_detector: false,
            liar: None,
            restart: None,
        }
    }
}

/// A played game.
#[derive(Debug, Clone)]
pub struct Played {
    /// What every robot answers at every moment, with its team.
    pub answers: Vec<Vec<Estimate>>,
    /// Messages of each robot.
    pub messages: Vec<Vec<TeamMessage>>,
    /// Time that the team took, by the given clock, for each image of a robot, milliseconds.
    pub ms_per_image: f64,
}

/// Plays a game.
///
/// # Errors
/// If the parameters are out of their ranges.
pub fn play(
    game: &Game,
    conditions: &Conditions,
    config: TeamConfig,
    seed: u64,
    clock: &Clock,
) -> Result<Played, ConfigError> {
    let num_robots = game.moments.first().map_or(0, Vec::len);
    let rng = RngTree::new(seed).subtree("team-play", 0);
    let mut network = Network::new(conditions.loss, conditions.delay_secs, rng.stream("network", 0));
    let filter = |robot: usize, session: u32| {
        let member = Member { team: "team".into(), number: 1 + robot as u8, session };
        TeamFilter::new(config, member, &game.map)
    };
    let mut filters = (0..num_robots).map(|robot| filter(robot, 1)).collect::<Result<Vec<_>, _>>()?;
    let mut liar_rng = rng.stream("liar", 0);
    let mut played =
        Played { answers: Vec::new(), messages: vec![Vec::new(); num_robots], ms_per_image: 0.0 };
    let ahead_secs = |robot: usize| conditions.clock_secs * robot as f64;
    let mut spent_secs = 0.0;
    for (step, moments) in game.moments.iter().enumerate() {
        let secs = step as f64 * game.step_secs;
        let began = clock.secs();
        let mut answers = Vec::new();
        for (robot, moment) in moments.iter().enumerate() {
            let mut estimate = moment.estimate.clone();
            if let Some(restart) = conditions.restart.filter(|r| r.robot == robot && secs >= r.secs) {
                if secs - game.step_secs < restart.secs {
                    filters[robot] = filter(robot, 2)?;
                }
                estimate = after_restart(estimate, secs - restart.secs);
            }
            let now = moment.at + ahead_secs(robot);
            let seen = late_sightings(game, step, robot, conditions, ahead_secs(robot));
            answers.push(filters[robot].step(now, &estimate, moment.odometry, &seen).estimate.clone());
            let Some(mut message) = filters[robot].message() else { continue };
            if let Some(liar) = conditions.liar.filter(|_| robot + 1 == num_robots) {
                liar.lie(&mut message, &moment.truth, &mut liar_rng);
            }
            for to in (0..num_robots).filter(|to| *to != robot && conditions.has_network) {
                network.send(moment.at, to, &message);
            }
            played.messages[robot].push(message);
        }
        played.answers.push(answers);
        let until = moments.first().map_or(Timestamp::default(), |moment| moment.at) + game.step_secs;
        for (at, to, message) in network.arrived(until) {
            // Whatever is wrong with a message, the robot goes on without it.
            let _ = filters[to].receive(&message, at + ahead_secs(to));
        }
        spent_secs += clock.secs() - began;
    }
    let num_images = (game.moments.len() * num_robots).max(1) as f64;
    played.ms_per_image = spent_secs * 1e3 / num_images;
    Ok(played)
}

/// What a localizer would say that began anew so long ago: nothing, then the place and nothing of the half.
fn after_restart(mut estimate: Estimate, secs: f64) -> Estimate {
    const SEARCH_SECS: f64 = 1.0;
    if secs < SEARCH_SECS {
        return Estimate::unknown();
    }
    estimate.reliability = 0.0;
    let share = 1.0 / estimate.hypotheses.len().max(1) as f64;
    estimate.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.probability = share);
    estimate
}

/// Detections that are ready by now and were not before.
fn late_sightings(
    game: &Game,
    step: usize,
    robot: usize,
    conditions: &Conditions,
    ahead_secs: f64,
) -> Vec<Sighting> {
    let late_steps = (conditions.detector_secs / game.step_secs).round() as usize;
    let Some(moment) = step.checked_sub(late_steps).map(|step| &game.moments[step][robot]) else {
        return Vec::new();
    };
    if conditions.own_detector {
        return moment.found.iter().map(|found| Sighting { at: found.at + ahead_secs, ..*found }).collect();
    }
    let sighting = |detection: &Detection| sighting(detection, moment.at + ahead_secs, &game.detector);
    moment.detections.iter().map(sighting).collect()
}

/// A detection as a sighting.
pub fn sighting(detection: &Detection, at: Timestamp, detector: &DetectorSetup) -> Sighting {
    let kind = if detection.is_ball { SightingKind::Ball } else { SightingKind::Teammate };
    let bearing = (detection.bearing_rad, detector.bearing_sigma_rad);
    Sighting::polar(at, kind, bearing, (detection.range_m, detector.range_sigma * detection.range_m))
}
