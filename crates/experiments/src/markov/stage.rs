//! The simulated field, and what the robot's camera sees from a pose.

use nalgebra::Rotation3;
use visloc_core::{
    Frame, Rng, RngTree, Timestamp, gaussian,
    geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot, nao},
};
use visloc_locate::{
    Region,
    markov::{BlobView, Direction, Grid},
    vision::{
        FeatureKind, Percept,
        color::ColorConfig,
        field::{FieldAnalysisConfig, FieldAnalyzer},
    },
};
use visloc_sim::{FieldLook, Lamp, Renderer, Room, Scene, Sensor, Shot};
use visloc_world::{Map, field::Field};

use crate::ExperimentError;

/// The goal that the published filter looks at: the one that its keeper guards.
pub(super) const GOAL: FeatureKind = FeatureKind::BlueGoal;

/// Field, scene and camera. The camera is that of the simulator's robots, in the forehead of a standing Nao.
pub(super) struct Stage {
    pub field: Field,
    /// The published grid: 12 x 8 tiles, 4 headings, columns towards the blue goal.
    pub grid: Grid,
    scene: Scene,
    camera: Camera,
    renderer: Renderer,
}

/// What one thread needs to take pictures.
pub(super) struct Eye<'a> {
    stage: &'a Stage,
    renderer: Renderer,
    analyzer: FieldAnalyzer,
}

impl Stage {
    pub fn new() -> Result<Self, ExperimentError> {
        let refused = |reason: String| ExperimentError::Run { cell: "field".to_owned(), run: 0, reason };
        let map = Map::load("robocup-spl-2010").map_err(|error| refused(error.to_string()))?;
        let Map::Field(field) = map else { return Err(refused("not a field".to_owned())) };
        let dimensions = field.dimensions();
        let (half_x, half_y) = (dimensions.length_m / 2.0, dimensions.width_m / 2.0);
        let region = Region { min_x_m: -half_x, max_x_m: half_x, min_y_m: -half_y, max_y_m: half_y };
        let camera = Camera::pinhole((320, 240), (373.3, 373.3), (159.5, 119.5))
            .map_err(|error| refused(error.to_string()))?;
        Ok(Self {
            grid: Grid::new(&region, 0.5, 4, Direction::MinusX),
            scene: scene(&field),
            renderer: Renderer::new(&camera),
            camera,
            field,
        })
    }

    pub fn eye(&self) -> Result<Eye<'_>, ExperimentError> {
        Ok(Eye { stage: self, renderer: self.renderer.sibling(), analyzer: analyzer()? })
    }
}

/// The image analysis of the experiment.
pub(super) fn analyzer() -> Result<FieldAnalyzer, ExperimentError> {
    // Every pixel of a goal counts for its size, so nearly every row is looked at.
    let config = FieldAnalysisConfig {
        colors: ColorConfig::table(),
        min_row_step_px: 1,
        max_row_step_px: 2,
        ..FieldAnalysisConfig::default()
    };
    FieldAnalyzer::new(config).map_err(|error| ExperimentError::Run {
        cell: "image analysis".to_owned(),
        run: 0,
        reason: error.to_string(),
    })
}

fn scene(field: &Field) -> Scene {
    let (half_x, half_y) = field.half_carpet_m();
    let half_floor_m = (half_x as f32, half_y as f32);
    let lamps: Vec<Lamp> = [(-1.5, -1.0), (-1.5, 1.0), (1.5, -1.0), (1.5, 1.0)]
        .into_iter()
        .map(|(x_m, y_m)| Lamp { x_m, y_m, z_m: 3.4, power: 1.0 })
        .collect();
    let mut scene = Scene::new(lamps.clone(), 0.6, half_floor_m);
    let rng = &mut RngTree::new(1).stream("scene", 0);
    scene.add_room(&Room::default(), &lamps, rng);
    scene.add_field(field, &FieldLook::default(), rng);
    scene
}

impl Eye<'_> {
    /// Takes a picture with the head turned to the left by an angle and looks at it. The joints report the camera's
    /// direction with an error of a quarter of a degree.
    pub fn look(&mut self, world_from_robot: &PlanarPose, head_yaw_rad: f64, rng: &mut Rng) -> &Percept {
        const JOINT_NOISE_RAD: f64 = 0.0044;
        let head = nao::HeadAngles { yaw_rad: head_yaw_rad, pitch_rad: 0.0 };
        let robot_from_camera = nao::robot_from_camera(&nao::Torso::upright(), &head, nao::NaoCamera::TopV3);
        let noise = [0; 3].map(|_| gaussian(rng, JOINT_NOISE_RAD));
        let lean = Rotation3::from_euler_angles(noise[0], noise[1], noise[2]);
        let leaning = Rigid3::<Robot, Robot>::new(lean, nalgebra::Vector3::zeros());
        self.picture(world_from_robot, &(leaning * robot_from_camera), robot_from_camera, rng)
    }

    fn picture(
        &mut self,
        world_from_robot: &PlanarPose,
        true_mount: &Rigid3<Robot, CameraFrame>,
        robot_from_camera: Rigid3<Robot, CameraFrame>,
        rng: &mut Rng,
    ) -> &Percept {
        let sensor = Sensor { vignetting: 0.3, shot_noise: 0.0009, read_noise: 0.0032 };
        let shot = Shot { sensor, noise_seed: rand::RngExt::random(rng), ..Shot::ideal() };
        let world_from_camera = world_from_robot.to_rigid3() * *true_mount;
        let image = self.renderer.render(&self.stage.scene, &[], &world_from_camera, &shot);
        let frame = Frame {
            at: Timestamp::from_nanos(0),
            image,
            camera_index: 0,
            camera: self.stage.camera,
            robot_from_camera,
            odometry: None,
            ground_contact: None,
        };
        // The image is as large as its calibration says, so that it cannot be refused.
        let _ = self.analyzer.analyze(&frame, rng);
        self.analyzer.percept()
    }

    /// The goal of the published filter in a picture with the head straight.
    pub fn goal(&mut self, world_from_robot: &PlanarPose, rng: &mut Rng) -> Option<BlobView> {
        BlobView::of(self.look(world_from_robot, 0.0, rng), GOAL)
    }

    /// The same from a pose near the middle of a state: the robot stands where it was put by hand.
    pub fn goal_in_state(&mut self, state: usize, rng: &mut Rng) -> Option<BlobView> {
        const PLACE_SIGMA_M: f64 = 0.05;
        const HEADING_SIGMA_RAD: f64 = 0.035;
        let place = PlanarPose::new(
            gaussian(rng, PLACE_SIGMA_M),
            gaussian(rng, PLACE_SIGMA_M),
            gaussian(rng, HEADING_SIGMA_RAD),
        );
        let pose = self.stage.grid.pose(state).compose(&place);
        self.goal(&pose, rng)
    }
}
