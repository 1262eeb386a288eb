//! The simulation as a source of frames.

use std::{collections::VecDeque, sync::Arc};

use rayon::prelude::*;
use visloc_core::{
    Frame, RgbImage, RngTree, Source, SourceError, SourceFrame, SourceStatus,
    geom::{Camera, PlanarPose},
};
use visloc_world::Map;

use super::{
    states::{Carrier, State},
    world::World,
};
use crate::{
    render::{LabelImage, Renderer, Sensor, Shot},
    robot::MotionPlan,
    scenario::{FIRST_STAMP, Scenario, ScenarioError},
    scene::{Scene, Surface},
};

/// Pixels that all threads together draw at a time; each takes some 60 bytes.
const MAX_PIXELS_DRAWN: usize = 1 << 25;
/// Frames that each thread draws before the threads wait for each other.
const FRAMES_PER_BATCH: usize = 4;

/// A scenario with a seed: delivers its frames one after the other, of several cameras those of one moment in turn. The same scenario and seed
/// give the same bits, with any number of threads.
///
/// ```
/// use visloc_core::Source;
/// use visloc_sim::{Scenario, Simulation};
/// let scenario = Scenario::load("still")?;
/// let mut simulation = Simulation::new(&scenario, 1)?.with_num_frames(2);
/// let first = simulation.next_item().expect("two frames").expect("no reading, no error");
/// assert_eq!(first.frame.image.width(), 320);
/// # Ok::<(), visloc_sim::ScenarioError>(())
/// ```
#[derive(Debug)]
pub struct Simulation {
    scenario: Scenario,
    camera: Camera,
    sensor: Sensor,
    world: Arc<World>,
    random: RngTree,
    states: Vec<State>,
    step: usize,
    /// Number of the next frame to be drawn; those between it and the one after it are left out.
    next: usize,
    ready: VecDeque<SourceFrame>,
    pool: Option<rayon::ThreadPool>,
    workers: Vec<Worker>,
    camera_index: usize,
    /// What the further cameras see.
    further: Vec<Simulation>,
    /// Whose turn it is: 0 for the first camera.
    turn: usize,
}

/// What one thread needs to draw.
#[derive(Debug)]
struct Worker {
    renderer: Renderer,
    moving: Vec<Surface>,
    images: Vec<RgbImage>,
}

impl Worker {
    fn new(renderer: Renderer) -> Self {
        Self { renderer, moving: Vec::new(), images: Vec::with_capacity(FRAMES_PER_BATCH) }
    }
}

impl Simulation {
    /// Builds the world and plans all motion.
    ///
    /// # Errors
    /// If the scenario's map cannot be loaded, its camera is impossible, or there is no free way for the robot.
    pub fn new(scenario: &Scenario, seed: u64) -> Result<Self, ScenarioError> {
        let random = RngTree::new(seed).subtree("simulation", 0);
        let scenario = &scenario.drawn(&random);
        let camera = camera_of(scenario)?;
        let mut world = World::new(scenario, &random)?;
        let start = start_pose(scenario, &world, &random)?;
        let plan = MotionPlan::new(&scenario.name, start, &scenario.motion, &world.floor, &random)?;
        world.let_walk(scenario, scenario.duration_secs, |secs| plan.at(secs).position, &random)?;
        let (world, plan) = (Arc::new(world), Arc::new(plan));
        let mut first = Self::with_camera(scenario.clone(), camera, (world.clone(), plan.clone()), random);
        for further in &scenario.more_cameras {
            let scenario = scenario.seen_by(further);
            let camera = camera_of(&scenario)?;
            let mut seen = Self::with_camera(scenario, camera, (world.clone(), plan.clone()), random);
            seen.camera_index = first.further.len() + 1;
            first.further.push(seen);
        }
        Ok(first)
    }

    /// What one camera sees.
    fn with_camera(
        scenario: Scenario,
        camera: Camera,
        (world, plan): (Arc<World>, Arc<MotionPlan>),
        random: RngTree,
    ) -> Self {
        let states = Carrier::new(&scenario, plan, &random).states(&scenario, &random);
        Self {
            sensor: scenario.camera.sensor(),
            workers: vec![Worker::new(Renderer::new(&camera))],
            scenario,
            camera,
            world,
            random,
            states,
            step: 1,
            next: 0,
            ready: VecDeque::new(),
            pool: None,
            camera_index: 0,
            further: Vec::new(),
            turn: 0,
        }
    }

    /// Draws frames on `num_threads` threads, or on fewer if the images are large; 0 counts as 1. If the system refuses the
    /// threads, one is used.
    #[must_use]
    pub fn with_threads(mut self, num_threads: usize) -> Self {
        let (width, height) = self.camera.size_px();
        let num_threads = num_threads.min(MAX_PIXELS_DRAWN / (width as usize * height as usize)).max(1);
        self.pool = (num_threads > 1)
            .then(|| rayon::ThreadPoolBuilder::new().num_threads(num_threads).build().ok())
            .flatten();
        let num_workers = if self.pool.is_some() { num_threads } else { 1 };
        self.workers.truncate(1);
        while self.workers.len() < num_workers {
            let renderer = self.workers[0].renderer.sibling();
            self.workers.push(Worker::new(renderer));
        }
        self.further = self.further.into_iter().map(|camera| camera.with_threads(num_threads)).collect();
        self
    }

    /// Ends after `num_frames` frames of each camera, or with the scenario if that is shorter.
    #[must_use]
    pub fn with_num_frames(mut self, num_frames: usize) -> Self {
        self.states.truncate(num_frames);
        self.further = self.further.into_iter().map(|camera| camera.with_num_frames(num_frames)).collect();
        self
    }

    /// Delivers the first frame of every `step`, 0 counting as 1. The robot moves as ever; the frames between are not drawn.
    #[must_use]
    pub fn with_step(mut self, step: usize) -> Self {
        self.step = step.max(1);
        self.further = self.further.into_iter().map(|camera| camera.with_step(step)).collect();
        self
    }

    /// The map that the scenario names.
    pub fn map(&self) -> &Map {
        &self.world.map
    }

    /// The camera of every frame; of several, the first one.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// What stands still in the world.
    pub fn scene(&self) -> &Scene {
        &self.world.scene
    }

    /// What the scenario says.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// What every pixel of a frame shows, by the frame's number from 0, before any blur; `None` beyond the last frame.
    pub fn labels(&mut self, index: usize) -> Option<LabelImage> {
        let state = self.states.get(index)?;
        let worker = &mut self.workers[0];
        self.world.moving(state.secs, &mut worker.moving);
        Some(worker.renderer.labels(&self.world.scene, &worker.moving, &state.world_from_camera))
    }

    /// Draws the next frames, one batch on all threads.
    fn draw_batch(&mut self) {
        let num_workers = self.workers.len();
        let per_worker = if num_workers == 1 { 1 } else { FRAMES_PER_BATCH };
        let indices: Vec<usize> =
            (self.next..self.states.len()).step_by(self.step).take(num_workers * per_worker).collect();
        let (world, sensor, random) = (&*self.world, self.sensor, self.random);
        let noise =
            if self.camera_index == 0 { random } else { random.subtree("camera", self.camera_index as u64) };
        let states = &self.states;
        let draw = |(offset, worker): (usize, &mut Worker)| {
            worker.images.clear();
            for &index in indices.iter().skip(offset).step_by(num_workers) {
                let state = &states[index];
                world.moving(state.secs, &mut worker.moving);
                let shot = Shot {
                    sensor,
                    gain: state.gain,
                    light_color: state.light_color,
                    motion: state.motion,
                    noise_seed: noise.stream_seed("sensor-noise", index as u64),
                };
                let image =
                    worker.renderer.render(&world.scene, &worker.moving, &state.world_from_camera, &shot);
                worker.images.push(image);
            }
        };
        match &self.pool {
            Some(pool) => pool.install(|| self.workers.par_iter_mut().enumerate().for_each(draw)),
            None => self.workers.iter_mut().enumerate().for_each(draw),
        }
        self.next += indices.len() * self.step;
        for (number, index) in indices.into_iter().enumerate() {
            let image = std::mem::take(&mut self.workers[number % num_workers].images[number / num_workers]);
            let frame = self.frame(index, image);
            self.ready.push_back(frame);
        }
    }

    fn frame(&self, index: usize, image: RgbImage) -> SourceFrame {
        let state = &self.states[index];
        let frame = Frame {
            at: FIRST_STAMP + state.secs,
            image,
            camera_index: self.camera_index,
            camera: self.camera,
            robot_from_camera: state.robot_from_camera,
            odometry: Some(state.odometry),
            ground_contact: Some(state.ground_contact),
        };
        SourceFrame { frame, truth: Some(state.truth) }
    }
}

impl Source<SourceFrame> for Simulation {
    fn next_item(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        let turn = self.turn;
        self.turn = (turn + 1) % (1 + self.further.len());
        if let Some(further) = turn.checked_sub(1) {
            return self.further[further].next_item();
        }
        if self.ready.is_empty() && self.next < self.states.len() {
            self.draw_batch();
        }
        self.ready.pop_front().map(Ok)
    }

    fn status(&self) -> SourceStatus<'_> {
        let num_items = Some(self.states.len().div_ceil(self.step) * (1 + self.further.len()));
        SourceStatus { num_items, ..SourceStatus::default() }
    }
}

/// The camera of a scenario.
pub(super) fn camera_of(scenario: &Scenario) -> Result<Camera, ScenarioError> {
    scenario.camera.camera().map_err(|error| ScenarioError::Value {
        name: scenario.name.clone(),
        line: None,
        key: "camera".to_owned(),
        expected: "a possible calibration".to_owned(),
        found: error.to_string(),
    })
}

/// Where the robot starts.
pub(super) fn start_pose(
    scenario: &Scenario,
    world: &World,
    random: &RngTree,
) -> Result<PlanarPose, ScenarioError> {
    const MARGIN_M: f64 = 0.3;
    if let Some(start) = &scenario.start {
        return Ok(start.pose());
    }
    let rng = &mut random.stream("start", 0);
    world.floor.random_free_pose(MARGIN_M, rng).ok_or_else(|| ScenarioError::NoSpace {
        name: scenario.name.clone(),
        what: "place to start",
        tries: 500,
    })
}
