//! All robots of the team, step by step.

use std::sync::Arc;

use nalgebra::Point2;
use visloc_core::{Clock, RngTree};
use visloc_locate::StartPrior;
use visloc_sim::{DetectorSetup, Scenario, TeamSimulation};
use visloc_world::Map;

use super::robot::Robot;
use crate::StudioError;

/// The field, with white goals.
const SCENARIO: &str = "tour-2024";
/// Images a second of each robot.
const IMAGES_PER_SEC: f64 = 10.0;
/// A message takes so long, seconds.
const LINK_SECS: f64 = 0.005;
/// A kidnapped robot is in somebody's hands for so long, seconds.
const KIDNAP_SECS: f64 = 2.0;
/// This one is told its half at the start.
const WHO_KNOWS: usize = 0;

/// A game.
pub(super) struct Game {
    simulation: TeamSimulation,
    detector: DetectorSetup,
    map: Arc<Map>,
    robots: Vec<Robot>,
    num_kidnaps: u64,
    /// Time that the last step took to draw all images, milliseconds.
    render_ms: f64,
    clock: Clock,
}

impl Game {
    /// Robots at random places, of which the first one is told its half. Each has an image to show, and has not looked for anything yet.
    pub fn new(num_robots: usize, seed: u64, clock: &Clock) -> Result<Self, StudioError> {
        let scenario = Scenario { frames_per_sec: IMAGES_PER_SEC, ..Scenario::load(SCENARIO)? };
        let detector = DetectorSetup::default();
        let mut simulation = TeamSimulation::new(&scenario, num_robots, detector, seed)?;
        let map = Arc::new(simulation.map().clone());
        let random = RngTree::new(seed).subtree("studio-team", 0);
        let (frames, render_ms) = clock.measure(|| simulation.step());
        let starts: Vec<StartPrior> = simulation
            .truths()
            .iter()
            .enumerate()
            .map(|(i, truth)| match i {
                WHO_KNOWS => StartPrior::half_of(&map, truth),
                _ => StartPrior::Uniform,
            })
            .collect();
        let robots = (1..)
            .zip(starts.into_iter().zip(frames))
            .map(|(number, (start, frame))| Robot::new(number, (&map, start), frame.source, &random, clock));
        let robots = robots.collect::<Result<_, _>>()?;
        Ok(Self { simulation, detector, map, robots, num_kidnaps: 0, render_ms, clock: clock.clone() })
    }

    /// Everybody walks on, looks, and tells the others.
    pub fn step(&mut self) -> Result<(), StudioError> {
        let (frames, render_ms) = self.clock.measure(|| self.simulation.step());
        self.render_ms = render_ms;
        let mut messages = Vec::new();
        for (robot, frame) in self.robots.iter_mut().zip(frames) {
            messages.extend(robot.take(frame, &self.detector)?);
        }
        for message in &messages {
            for robot in self.robots.iter_mut().filter(|robot| robot.number() != message.number) {
                robot.hear(message, message.at + LINK_SECS);
            }
        }
        Ok(())
    }

    /// Somebody carries a robot elsewhere; its feet feel it. Whether there is a place.
    pub fn kidnap(&mut self, robot: usize) -> bool {
        self.num_kidnaps += 1;
        let num_frames = (KIDNAP_SECS * IMAGES_PER_SEC).round() as usize;
        self.simulation.kidnap(robot, self.num_kidnaps, num_frames)
    }

    pub fn robots(&self) -> &[Robot] {
        &self.robots
    }

    /// A robot by its place.
    pub fn robot_mut(&mut self, robot: usize) -> Option<&mut Robot> {
        self.robots.get_mut(robot)
    }

    pub fn map(&self) -> &Arc<Map> {
        &self.map
    }

    pub fn ball(&self) -> Point2<f64> {
        self.simulation.ball()
    }

    pub fn step_secs(&self) -> f64 {
        self.simulation.step_secs()
    }

    pub fn render_ms(&self) -> f64 {
        self.render_ms
    }
}
