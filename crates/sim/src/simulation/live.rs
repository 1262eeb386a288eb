//! A simulation without a plan: somebody drives the robot, carries it and changes its world while it runs.

use std::sync::Arc;

use nalgebra::{Point2, Rotation3, Vector3};
use visloc_core::{
    Frame, GroundContact, Rng, RngTree, SourceFrame, Truth,
    geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot, nao::HeadAngles},
};
use visloc_world::Map;

use super::{
    detector::{Detection, DetectorSetup, View},
    source::{camera_of, start_pose},
    world::World,
};
use crate::{
    render::{CameraMotion, Renderer, Sensor, Shot},
    robot::{Activity, Body, Feet, Floor, Odometry},
    scenario::{FIRST_STAMP, LightSetup, OdometrySetup, OtherRobot, Scenario, ScenarioError},
    scene::Surface,
};

/// Ways of other robots are kept apart for so long; then they repeat.
const ORBIT_SECS: f64 = 60.0;
/// A driven robot may leave the region of planned walks by so much, meters.
const BEYOND_M: f64 = 0.25;
/// Walking starts and ends within this time.
const SWING_SECS: f64 = 0.3;
/// The body of somebody who is carried leans, radians.
const LEAN_RAD: f64 = 0.12;

/// What the robot does, or what is done to it, until the next frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LiveMotion {
    /// It walks with these speeds, seen from the robot; all 0 is standing.
    Walk {
        /// Ahead, meters per second.
        forward_m_per_s: f64,
        /// To the left, meters per second.
        left_m_per_s: f64,
        /// Counter-clockwise, radians per second.
        turn_rad_per_s: f64,
    },
    /// Somebody holds it.
    Held {
        /// Over this place.
        world_from_robot: PlanarPose,
        /// At this height, meters.
        height_m: f64,
        /// Whether the feet notice. If not, pressure stays normal and odometry marches on the spot.
        is_felt: bool,
    },
}

/// What is decided from outside for one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveControls {
    /// The body.
    pub motion: LiveMotion,
    /// Where the head looks; by itself from side to side if absent.
    pub head: Option<HeadAngles>,
    /// Whether a hand covers the camera.
    pub is_covered: bool,
    /// Brightness of the image, in powers of two.
    pub exposure_stops: f64,
}

impl Default for LiveControls {
    fn default() -> Self {
        let motion = LiveMotion::Walk { forward_m_per_s: 0.0, left_m_per_s: 0.0, turn_rad_per_s: 0.0 };
        Self { motion, head: None, is_covered: false, exposure_stops: 0.0 }
    }
}

/// A scenario's world with a robot that is steered from outside. The same scenario, seed and controls give the same bits.
#[derive(Debug)]
pub struct LiveSimulation {
    scenario: Scenario,
    random: RngTree,
    camera: Camera,
    sensor: Sensor,
    world: Arc<World>,
    /// Where other simulated robots are.
    company: Vec<PlanarPose>,
    body: Body,
    odometry: Odometry,
    feet: Feet,
    renderer: Renderer,
    moving: Vec<Surface>,
    index: u64,
    robot: Carried,
}

/// The robot between two frames.
#[derive(Debug, Clone, Copy)]
struct Carried {
    world_from_robot: PlanarPose,
    height_m: f64,
    swing: f64,
    activity: Activity,
}

impl LiveSimulation {
    /// Builds the world; the scenario's motions are left out.
    ///
    /// # Errors
    /// If the scenario's map cannot be loaded, its camera is impossible, or there is no place for the robots.
    pub fn new(scenario: &Scenario, seed: u64) -> Result<Self, ScenarioError> {
        let random = RngTree::new(seed).subtree("simulation", 0);
        let scenario = &scenario.drawn(&random);
        let world = build_world(scenario, &random)?;
        let world_from_robot = start_pose(scenario, &world, &random)?;
        Self::in_world(scenario, Arc::new(world), random, world_from_robot)
    }

    /// A robot in a world that it may share with others.
    pub(super) fn in_world(
        scenario: &Scenario,
        world: Arc<World>,
        random: RngTree,
        world_from_robot: PlanarPose,
    ) -> Result<Self, ScenarioError> {
        let camera = camera_of(scenario)?;
        Ok(Self {
            sensor: scenario.camera.sensor(),
            renderer: Renderer::new(&camera),
            body: Body::new(&scenario.robot, &random),
            odometry: Odometry::new(&scenario.robot.odometry, &random),
            feet: Feet::new(&scenario.robot.feet, &random),
            scenario: scenario.clone(),
            random,
            camera,
            world,
            company: Vec::new(),
            moving: Vec::new(),
            index: 0,
            robot: Carried { world_from_robot, height_m: 0.0, swing: 0.0, activity: Activity::Standing },
        })
    }

    /// Where other simulated robots of the same world are now.
    pub(super) fn set_company(&mut self, poses: &[PlanarPose]) {
        self.company.clear();
        self.company.extend_from_slice(poses);
    }

    /// What a detector would make of the last image.
    pub(super) fn detect(
        &self,
        others: &[PlanarPose],
        ball: Point2<f64>,
        setup: &DetectorSetup,
        rng: &mut Rng,
    ) -> Vec<Detection> {
        if self.robot.activity.is_carried() {
            return Vec::new();
        }
        let secs = self.index.saturating_sub(1) as f64 * self.step_secs();
        let robot_from_camera = self.robot_from_camera(secs, &LiveControls::default());
        let view = View {
            camera: &self.camera,
            world_from_camera: placed(&self.robot) * robot_from_camera,
            world_from_robot: self.robot.world_from_robot,
            others,
            ball,
        };
        view.detect(setup, rng)
    }

    pub(super) fn floor(&self) -> &Floor {
        &self.world.floor
    }

    /// The map that the scenario names.
    pub fn map(&self) -> &Map {
        &self.world.map
    }

    /// What the scenario says, with all changes.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Time between two frames.
    pub fn step_secs(&self) -> f64 {
        1.0 / self.scenario.frames_per_sec
    }

    /// Where the robot is.
    pub fn truth(&self) -> Truth {
        let is_carried = self.robot.activity.is_carried();
        let height_m = if is_carried { self.robot.height_m.max(0.001) } else { 0.0 };
        Truth { world_from_robot: self.robot.world_from_robot, height_m }
    }

    /// Where the other robots are that walk around.
    pub fn others(&self) -> Vec<PlanarPose> {
        self.world.others(self.secs())
    }

    /// Whether the robot could stand somewhere.
    pub fn is_free(&self, world_from_robot: &PlanarPose) -> bool {
        is_free(&self.world.floor, world_from_robot)
    }

    /// A random free pose, the same for the same `index`; `None` if there seems to be no place.
    pub fn random_pose(&self, index: u64) -> Option<PlanarPose> {
        const MARGIN_M: f64 = 0.2;
        let rng = &mut self.random.stream("live-place", index);
        self.world.floor.random_free_pose(MARGIN_M, rng)
    }

    /// A random place near the robot to which the straight way is free, the same for the same `index`; `None` if there seems
    /// to be none.
    pub fn random_target(&self, index: u64) -> Option<nalgebra::Point2<f64>> {
        const TRIES: usize = 200;
        const MARGIN_M: f64 = 0.18;
        let here = self.robot.world_from_robot.position();
        let (floor, rng) = (&self.world.floor, &mut self.random.stream("live-target", index));
        (0..TRIES).map(|_| floor.random_point_from(&here, rng)).find(|point| {
            (0.6..4.0).contains(&(point - here).norm()) && floor.is_way_free(&here, point, MARGIN_M)
        })
    }

    /// Changes the light, and builds the world anew.
    ///
    /// # Errors
    /// If the world cannot be built; then it stays as it was.
    pub fn set_light(&mut self, light: LightSetup) -> Result<(), ScenarioError> {
        self.rebuild(Scenario { light, ..self.scenario.clone() })
    }

    /// Changes the other robots, and builds the world anew.
    ///
    /// # Errors
    /// If there is no way for so many; then they stay as they were.
    pub fn set_robots(&mut self, robots: Vec<OtherRobot>) -> Result<(), ScenarioError> {
        self.rebuild(Scenario { robots, ..self.scenario.clone() })
    }

    /// Changes the errors of the odometry from now on.
    pub fn set_odometry(&mut self, setup: OdometrySetup) {
        self.odometry = self.odometry.with_setup(&setup, &self.random);
        self.scenario.robot.odometry = setup;
    }

    fn rebuild(&mut self, scenario: Scenario) -> Result<(), ScenarioError> {
        self.world = Arc::new(build_world(&scenario, &self.random)?);
        self.scenario = scenario;
        Ok(())
    }

    fn secs(&self) -> f64 {
        self.index as f64 * self.step_secs()
    }

    /// Moves everything by one frame and takes the picture.
    pub fn step(&mut self, controls: &LiveControls) -> SourceFrame {
        let before = self.robot;
        self.robot = self.moved(&controls.motion);
        let secs = self.secs();
        let robot_from_camera = self.robot_from_camera(secs, controls);
        let shutter_share = self.scenario.camera.shutter_secs / self.step_secs();
        let motion = if before.activity == self.robot.activity {
            blur_of(&before, &self.robot, &robot_from_camera, shutter_share)
        } else {
            CameraMotion::default()
        };
        let frame = SourceFrame {
            frame: Frame {
                at: FIRST_STAMP + secs,
                image: self.picture(&robot_from_camera, motion, controls),
                camera_index: 0,
                camera: self.camera,
                robot_from_camera: self.body.reported(&robot_from_camera, secs, self.index),
                odometry: Some(self.odometry.step(self.robot.world_from_robot, self.robot.activity)),
                ground_contact: Some(GroundContact::Pressure(self.feet.pressure(
                    self.robot.activity,
                    (self.body.stride_rad(secs), self.robot.swing),
                    self.index,
                ))),
            },
            truth: Some(self.truth()),
        };
        self.index += 1;
        frame
    }

    fn robot_from_camera(&self, secs: f64, controls: &LiveControls) -> Rigid3<Robot, CameraFrame> {
        let head = controls.head.unwrap_or_else(|| self.body.head(secs));
        self.body.robot_from_camera_with(&head, secs, self.robot.swing)
    }

    fn picture(
        &mut self,
        robot_from_camera: &Rigid3<Robot, CameraFrame>,
        motion: CameraMotion,
        controls: &LiveControls,
    ) -> visloc_core::RgbImage {
        self.world.moving(self.secs(), &mut self.moving);
        self.world.place_company(&self.company, self.secs(), &mut self.moving);
        let exposure_stops = self.scenario.camera.exposure_stops + controls.exposure_stops;
        let gain = if controls.is_covered { 0.0 } else { exposure_stops.exp2() as f32 };
        let noise_seed = self.random.stream_seed("sensor-noise", self.index);
        let light = self.scenario.light.at(self.secs());
        let gain = gain * light.share;
        let shot = Shot { sensor: self.sensor, gain, light_color: light.color, motion, noise_seed };
        let world_from_camera = placed(&self.robot) * *robot_from_camera;
        self.renderer.render(&self.world.scene, &self.moving, &world_from_camera, &shot)
    }

    /// The robot one frame later.
    fn moved(&self, motion: &LiveMotion) -> Carried {
        match *motion {
            LiveMotion::Held { world_from_robot, height_m, is_felt } => Carried {
                world_from_robot,
                height_m,
                swing: 0.0,
                activity: if is_felt { Activity::Lifted } else { Activity::LiftedUnnoticed },
            },
            LiveMotion::Walk { forward_m_per_s, left_m_per_s, turn_rad_per_s } => {
                self.walked([forward_m_per_s, left_m_per_s, turn_rad_per_s])
            }
        }
    }

    fn walked(&self, speeds: [f64; 3]) -> Carried {
        let is_walking = speeds.iter().any(|speed| speed.abs() > 1e-9);
        let step_secs = self.step_secs();
        let [x_m, y_m, yaw_rad] = speeds.map(|speed| speed * step_secs);
        let here = self.robot.world_from_robot;
        let there = here.compose(&PlanarPose::new(x_m, y_m, yaw_rad));
        // Who was put down outside may walk back in.
        let is_possible = is_free(&self.world.floor, &there) || !is_free(&self.world.floor, &here);
        let there = if is_possible { there } else { PlanarPose::new(here.x_m, here.y_m, there.yaw_rad) };
        let change = step_secs / SWING_SECS * if is_walking { 1.0 } else { -1.0 };
        Carried {
            world_from_robot: there,
            height_m: 0.0,
            swing: (self.robot.swing + change).clamp(0.0, 1.0),
            activity: if is_walking { Activity::Walking } else { Activity::Standing },
        }
    }
}

fn is_free(floor: &Floor, world_from_robot: &PlanarPose) -> bool {
    floor.is_free(&world_from_robot.position(), -BEYOND_M)
}

pub(super) fn build_world(scenario: &Scenario, random: &RngTree) -> Result<World, ScenarioError> {
    let mut world = World::new(scenario, random)?;
    // Nobody knows where the own robot will be, so the others keep clear of each other only.
    world.let_walk(scenario, ORBIT_SECS, |_| Point2::new(1e6, 1e6), random)?;
    Ok(world)
}

fn placed(robot: &Carried) -> Rigid3<visloc_core::geom::World, Robot> {
    let lean_rad = if robot.activity.is_carried() { LEAN_RAD } else { 0.0 };
    let lean = Rotation3::from_euler_angles(0.0, lean_rad, 0.0);
    let leaning = Rigid3::<Robot, Robot>::new(lean, Vector3::new(0.0, 0.0, robot.height_m));
    robot.world_from_robot.to_rigid3() * leaning
}

/// Motion of the camera while the shutter is open: a share of the robot's last step.
fn blur_of(
    before: &Carried,
    now: &Carried,
    robot_from_camera: &Rigid3<Robot, CameraFrame>,
    share: f64,
) -> CameraMotion {
    let way =
        CameraMotion::between(&(placed(before) * *robot_from_camera), &(placed(now) * *robot_from_camera));
    CameraMotion { translation_m: way.translation_m * share, rotation_rad: way.rotation_rad * share }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn simulation(seed: u64) -> LiveSimulation {
        LiveSimulation::new(&Scenario::load("tour").unwrap(), seed).unwrap()
    }

    fn ahead() -> LiveControls {
        let motion = LiveMotion::Walk { forward_m_per_s: 0.2, left_m_per_s: 0.0, turn_rad_per_s: 0.1 };
        LiveControls { motion, ..LiveControls::default() }
    }

    #[test]
    fn the_same_controls_give_the_same_bits() {
        let run = |seed| {
            let mut simulation = simulation(seed);
            (0..5).map(|_| simulation.step(&ahead()).frame.image).collect::<Vec<_>>()
        };
        assert_eq!(run(3), run(3));
        assert_ne!(run(3), run(4));
    }

    #[test]
    fn a_robot_goes_where_it_is_driven_and_stays_on_the_floor() {
        let mut simulation = simulation(1);
        let start = simulation.truth().world_from_robot;
        let first = simulation.step(&ahead()).truth.unwrap();
        assert!(first.world_from_robot.distance_m(&start) < 0.01);
        for _ in 0..2000 {
            let motion = LiveMotion::Walk { forward_m_per_s: 0.5, left_m_per_s: 0.0, turn_rad_per_s: 0.0 };
            simulation.robot = simulation.moved(&motion);
        }
        assert!(simulation.is_free(&simulation.truth().world_from_robot));
        assert!(simulation.truth().world_from_robot.distance_m(&start) > 0.3);
    }

    #[test]
    fn who_is_held_is_off_the_ground_and_feels_it_only_if_told_so() {
        let mut simulation = simulation(1);
        let there = PlanarPose::new(1.0, 0.5, 0.3);
        for is_felt in [true, false] {
            let motion = LiveMotion::Held { world_from_robot: there, height_m: 0.3, is_felt };
            let frame = simulation.step(&LiveControls { motion, ..LiveControls::default() });
            assert!(frame.truth.unwrap().height_m > 0.2);
            let Some(GroundContact::Pressure(forces)) = frame.frame.ground_contact else { panic!("feet") };
            assert_eq!(forces.iter().sum::<f64>() < 5.0, is_felt);
        }
        assert_eq!(simulation.step(&LiveControls::default()).truth.unwrap().world_from_robot, there);
    }

    #[test]
    fn a_covered_camera_sees_nothing_and_others_can_be_added() {
        let mut simulation = simulation(1);
        let covered = LiveControls { is_covered: true, ..LiveControls::default() };
        let dark = simulation.step(&covered).frame.image;
        assert!(dark.data().iter().all(|value| *value < 40));
        let jersey = crate::scene::Color::from_hex(0xc8_1e_1e);
        simulation.set_robots(vec![OtherRobot { jersey, at: None }; 2]).unwrap();
        assert_eq!(simulation.others().len(), 2);
    }
}
