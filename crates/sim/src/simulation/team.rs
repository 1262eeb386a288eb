//! Several robots on one field, each with its own camera.

use std::sync::Arc;

use nalgebra::Point2;
use rand::RngExt as _;
use visloc_core::{
    Rng, RngTree, SourceFrame,
    geom::{PlanarPose, angle},
};
use visloc_world::Map;

use super::{
    detector::{Detection, DetectorSetup},
    live::{LiveControls, LiveMotion, LiveSimulation, build_world},
};
use crate::{
    scenario::{Ball, Scenario, ScenarioError},
    scene::Color,
};

/// Name of the team's game as a simulation, `sim:team`.
pub const TEAM: &str = "team";

/// Jersey of the team.
const JERSEY: u32 = 0x28_50c0;
/// Robots keep this far apart, and begin at least so far apart, meters.
const CLEARANCE_M: f64 = 0.7;
const SPEED_M_PER_S: f64 = 0.3;
const TURN_RAD_PER_S: f64 = 0.7;
/// Targets and starts are so far from everything, meters.
const MARGIN_M: f64 = 0.3;
/// How high a robot is carried, meters.
const CARRIED_M: f64 = 0.35;

/// What one robot has of a moment.
#[derive(Debug, Clone)]
pub struct TeamFrame {
    /// What its own sensors tell.
    pub source: SourceFrame,
    /// What a detector would make of its image.
    pub detections: Vec<Detection>,
}

/// Robots of one team that walk from place to place and see each other. The ball lies still. The same scenario, number and seed give the
/// same bits.
#[derive(Debug)]
pub struct TeamSimulation {
    robots: Vec<LiveSimulation>,
    walks: Vec<Walk>,
    detector: DetectorSetup,
    ball: Point2<f64>,
}

/// Where a robot is going.
#[derive(Debug)]
struct Walk {
    target: Point2<f64>,
    rng: Rng,
    detector_rng: Rng,
    /// Where it is being carried, and for how many more frames.
    carried: Option<(PlanarPose, usize)>,
}

impl TeamSimulation {
    /// So many robots in the scenario's world, at random places.
    ///
    /// # Errors
    /// If the scenario's map cannot be loaded, its camera is impossible, or there is no place for the robots.
    pub fn new(
        scenario: &Scenario,
        num_robots: usize,
        detector: DetectorSetup,
        seed: u64,
    ) -> Result<Self, ScenarioError> {
        const TRIES: usize = 500;
        let random = RngTree::new(seed).subtree("team", 0);
        let rng = &mut random.stream("ball", 0);
        let ball = Point2::new(rng.random_range(-2.5..2.5), rng.random_range(-1.8..1.8));
        let mut scenario = scenario.drawn(&random);
        scenario.ball = Ball { is_present: true, at_m: Some([ball.x, ball.y]) };
        scenario.robots.clear();
        let mut world = build_world(&scenario, &random)?;
        world.prepare_company(Color::from_hex(JERSEY));
        let world = Arc::new(world);
        let (mut robots, mut walks): (Vec<LiveSimulation>, Vec<Walk>) = (Vec::new(), Vec::new());
        for number in 0..num_robots {
            let own = random.subtree("robot", number as u64);
            let mut rng = own.stream("walk", 0);
            let is_clear = |point: &Point2<f64>| {
                robots
                    .iter()
                    .all(|other| (other.truth().world_from_robot.position() - point).norm() > CLEARANCE_M)
            };
            let start = (0..TRIES)
                .filter_map(|_| world.floor.random_free_point(MARGIN_M, &mut rng))
                .find(is_clear)
                .ok_or_else(|| ScenarioError::NoSpace {
                    name: scenario.name.clone(),
                    what: "place for another robot",
                    tries: TRIES,
                })?;
            let yaw_rad = rng.random_range(-std::f64::consts::PI..std::f64::consts::PI);
            let start = PlanarPose::new(start.x, start.y, yaw_rad);
            robots.push(LiveSimulation::in_world(&scenario, Arc::clone(&world), own, start)?);
            let detector_rng = own.stream("detector", 0);
            walks.push(Walk { target: start.position(), rng, detector_rng, carried: None });
        }
        Ok(Self { robots, walks, detector, ball })
    }

    /// The map that the scenario names.
    ///
    /// # Panics
    /// Without robots.
    pub fn map(&self) -> &Map {
        self.robots[0].map()
    }

    /// Where the ball lies.
    pub fn ball(&self) -> Point2<f64> {
        self.ball
    }

    /// Where the robots are.
    pub fn truths(&self) -> Vec<PlanarPose> {
        self.robots.iter().map(|robot| robot.truth().world_from_robot).collect()
    }

    /// Carries a robot elsewhere for so many frames; its feet feel it.
    pub fn carry(&mut self, robot: usize, to: PlanarPose, num_frames: usize) {
        self.walks[robot].carried = Some((to, num_frames));
        self.walks[robot].target = to.position();
    }

    /// Carries a robot to a free place apart from all robots for so many frames, the same place for the same `choice`; whether there is one.
    pub fn kidnap(&mut self, robot: usize, choice: u64, num_frames: usize) -> bool {
        const TRIES: u64 = 100;
        let truths = self.truths();
        let is_apart = |to: &PlanarPose| truths.iter().all(|other| other.distance_m(to) > CLEARANCE_M);
        let mut places = (0..TRIES).filter_map(|i| self.robots[robot].random_pose(choice * TRIES + i));
        let place = places.find(is_apart);
        if let Some(to) = place {
            self.carry(robot, to, num_frames);
        }
        place.is_some()
    }

    /// Time between two frames.
    ///
    /// # Panics
    /// Without robots.
    pub fn step_secs(&self) -> f64 {
        self.robots[0].step_secs()
    }

    /// Moves everything by one frame, and takes a picture with every camera.
    pub fn step(&mut self) -> Vec<TeamFrame> {
        let poses = self.truths();
        let mut frames = Vec::new();
        for i in 0..self.robots.len() {
            let others: Vec<PlanarPose> =
                poses.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, p)| *p).collect();
            let motion = self.steer(i, &poses[i], &others);
            let robot = &mut self.robots[i];
            robot.set_company(&others);
            let source = robot.step(&LiveControls { motion, ..LiveControls::default() });
            let mut detections =
                robot.detect(&others, self.ball, &self.detector, &mut self.walks[i].detector_rng);
            for detection in &mut detections {
                // Numbers of the team, not of the others.
                detection.who = detection.who.map(|who| if who < i { who } else { who + 1 });
            }
            frames.push(TeamFrame { source, detections });
        }
        frames
    }

    /// Walks to the target, around others.
    fn steer(&mut self, i: usize, here: &PlanarPose, others: &[PlanarPose]) -> LiveMotion {
        let walk = &mut self.walks[i];
        if let Some((to, left)) = walk.carried {
            walk.carried = (left > 1).then_some((to, left - 1));
            return LiveMotion::Held { world_from_robot: to, height_m: CARRIED_M, is_felt: true };
        }
        let bearing_rad = |point: &Point2<f64>| {
            angle::difference((point.y - here.y_m).atan2(point.x - here.x_m), here.yaw_rad)
        };
        let is_in_way = |other: &PlanarPose| {
            other.distance_m(here) < CLEARANCE_M && bearing_rad(&other.position()).abs() < 1.2
        };
        if (walk.target - here.position()).norm() < 0.3
            || (others.iter().any(is_in_way) && walk.rng.random_bool(0.1))
            || walk.rng.random_bool(0.003)
        {
            let target = self.robots[i].floor().random_free_point(MARGIN_M, &mut walk.rng);
            walk.target = target.unwrap_or(walk.target);
        }
        let off_rad = match others.iter().find(|other| is_in_way(other)) {
            Some(other) if bearing_rad(&other.position()) > 0.0 => -1.0,
            Some(_) => 1.0,
            None => bearing_rad(&walk.target),
        };
        let is_ahead = off_rad.abs() < 0.6;
        LiveMotion::Walk {
            forward_m_per_s: if is_ahead { SPEED_M_PER_S } else { 0.0 },
            left_m_per_s: 0.0,
            turn_rad_per_s: (1.5 * off_rad).clamp(-TURN_RAD_PER_S, TURN_RAD_PER_S),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn team(num_robots: usize, seed: u64) -> TeamSimulation {
        let mut scenario = Scenario::load("tour-2024").unwrap();
        scenario.camera.size_px = [80, 60];
        scenario.camera.focal_px = [93.3, 93.3];
        scenario.camera.center_px = [39.5, 29.5];
        scenario.frames_per_sec = 5.0;
        TeamSimulation::new(&scenario, num_robots, DetectorSetup::default(), seed).unwrap()
    }

    #[test]
    fn the_same_seed_gives_the_same_bits() {
        let run = |seed| {
            let mut team = team(3, seed);
            let frames: Vec<TeamFrame> = (0..5).flat_map(|_| team.step()).collect();
            frames.into_iter().map(|frame| (frame.source.frame.image, frame.detections)).collect::<Vec<_>>()
        };
        assert!(run(3) == run(3) && run(3) != run(4));
    }

    #[test]
    fn a_kidnapped_robot_stands_elsewhere_apart_from_the_others() {
        let mut team = team(5, 2);
        let before = team.truths();
        assert!(team.kidnap(1, 7, 3));
        let frames: Vec<TeamFrame> = (0..3).map(|_| team.step().swap_remove(1)).collect();
        assert!(frames.iter().all(|frame| frame.source.truth.unwrap().height_m > 0.0));
        assert_eq!(team.step()[1].source.truth.unwrap().height_m, 0.0);
        let now = team.truths();
        assert!(now[1].distance_m(&before[1]) > CLEARANCE_M);
        let is_apart = |(i, other): (usize, &PlanarPose)| i == 1 || other.distance_m(&now[1]) > 0.3;
        assert!(now.iter().enumerate().all(is_apart), "{now:?}");
    }

    /// Half a minute of five robots: they walk, keep apart, and see each other where they are.
    #[test]
    fn robots_walk_apart_and_see_each_other() {
        let mut team = team(5, 1);
        let (mut way_m, mut num_seen, mut num_false, mut off_m) = (0.0, 0, 0, Vec::new());
        for _ in 0..150 {
            let before = team.truths();
            let frames = team.step();
            let now = team.truths();
            way_m += before.iter().zip(&now).map(|(a, b)| a.distance_m(b)).sum::<f64>();
            let is_apart = |(i, a): (usize, &PlanarPose)| now[..i].iter().all(|b| a.distance_m(b) > 0.3);
            assert!(now.iter().enumerate().all(is_apart), "{now:?}");
            for (frame, here) in frames.iter().zip(&now) {
                num_seen += frame.detections.iter().filter(|d| d.is_true).count();
                num_false += frame.detections.iter().filter(|d| !d.is_true).count();
                for seen in frame.detections.iter().filter(|d| d.who.is_some()) {
                    let (sin, cos) = (here.yaw_rad + seen.bearing_rad).sin_cos();
                    let at = Point2::new(here.x_m + seen.range_m * cos, here.y_m + seen.range_m * sin);
                    off_m.push((at - before[seen.who.unwrap()].position()).norm() / seen.range_m);
                }
            }
        }
        off_m.sort_by(f64::total_cmp);
        assert!(
            way_m > 10.0 && num_seen > 100 && (10..80).contains(&num_false),
            "{way_m} {num_seen} {num_false}"
        );
        assert!(off_m[off_m.len() / 2] < 0.15, "{}", off_m[off_m.len() / 2]);
    }
}
