//! An image from a given pose.

use visloc_core::{Source, SourceFrame, geom::PlanarPose};
use visloc_sim::{
    BoxPiece, Color, Label, LabelImage, Motion, OtherRobot, Paint, PlacedPose, Room, Scenario, ScenarioError,
    Simulation, Stand,
};
use visloc_world::Map;

use crate::ExperimentError;

/// From where the robot looks, and what stands in its way.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Name or file of the map.
    pub map: String,
    /// The robot.
    pub world_from_robot: PlanarPose,
    /// How far the head is turned to the left, degrees.
    pub pan_deg: f64,
    /// How far the head looks down, degrees.
    pub tilt_deg: f64,
    /// Other robots, standing.
    pub robots: Vec<PlanarPose>,
    /// Yellow pillars as high as a goal, which are no goal posts, (x, y), meters.
    pub false_posts_m: Vec<[f64; 2]>,
}

impl View {
    /// Straight ahead and a little down, with nothing in the way.
    pub fn new(map: &str, world_from_robot: PlanarPose) -> Self {
        Self {
            map: map.to_owned(),
            world_from_robot,
            pan_deg: 0.0,
            tilt_deg: 13.0,
            robots: Vec::new(),
            false_posts_m: Vec::new(),
        }
    }
}

/// The image from a view, with the truth.
#[derive(Debug, Clone)]
pub struct SimulatedView {
    /// What the robot senses, and where it is.
    pub source: SourceFrame,
    /// What each pixel shows.
    pub labels: LabelImage,
    /// The map.
    pub map: Map,
}

/// Space between the carpet and the walls, meters.
const AISLE_M: f64 = 1.8;
/// Yellow of a goal, and side and height of a post, meters.
const POST_YELLOW: u32 = 0xdd_c414;
const POST_SIZE_M: [f32; 3] = [0.1, 0.1, 0.9];

impl SimulatedView {
    /// Takes the picture, with the usual errors of kinematics and sensor.
    ///
    /// # Errors
    /// If the map cannot be loaded.
    pub fn take(view: &View, seed: u64) -> Result<Self, ExperimentError> {
        let failed = |reason: String| ExperimentError::Setup { reason };
        let map = Map::load(&view.map).map_err(|error| failed(error.to_string()))?;
        let scenario = scenario(view, &map).map_err(|error| failed(error.to_string()))?;
        let simulation = Simulation::new(&scenario, seed).map_err(|error| failed(error.to_string()))?;
        let mut simulation = simulation.with_num_frames(1);
        let labels = simulation.labels(0);
        let source = simulation.next_item().and_then(Result::ok);
        let (Some(source), Some(labels)) = (source, labels) else {
            return Err(failed("the simulation has no frame".to_owned()));
        };
        Ok(Self { source, labels, map })
    }

    /// How many pixels show something.
    pub fn count(&self, label: Label) -> usize {
        self.labels.count(label)
    }
}

fn scenario(view: &View, map: &Map) -> Result<Scenario, ScenarioError> {
    let mut scenario = Scenario::load("still")?;
    scenario.map.clone_from(&view.map);
    scenario.furniture.clear();
    scenario.ball.is_present = false;
    if let Map::Field(field) = map {
        let (x_m, y_m) = field.half_carpet_m();
        let side = |half_m: f64| (2.0 * (half_m + AISLE_M)) as f32;
        scenario.room = Some(Room { length_m: side(x_m), width_m: side(y_m), ..Room::default() });
    }
    scenario.start = Some(placed(&view.world_from_robot));
    scenario.motion = vec![Motion::Stand(Stand::default())];
    let head = &mut scenario.robot.head;
    (head.pan_mean_deg, head.pan_deg) = (view.pan_deg, 0.0);
    (head.tilt_deg, head.tilt_swing_deg) = (view.tilt_deg, 0.0);
    let robot = |pose| OtherRobot { jersey: Color::from_hex(0x20_40c0), at: Some(placed(pose)) };
    scenario.robots = view.robots.iter().map(robot).collect();
    let post = |[x_m, y_m]: &[f64; 2]| BoxPiece {
        at: PlacedPose { x_m: *x_m, y_m: *y_m, yaw_deg: 0.0 },
        bottom_m: 0.0,
        size_m: POST_SIZE_M,
        paint: Paint { color: Color::from_hex(POST_YELLOW), ..Paint::default() },
    };
    scenario.boxes = view.false_posts_m.iter().map(post).collect();
    Ok(scenario)
}

fn placed(pose: &PlanarPose) -> PlacedPose {
    PlacedPose { x_m: pose.x_m, y_m: pose.y_m, yaw_deg: pose.yaw_rad.to_degrees() }
}
