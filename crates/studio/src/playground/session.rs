//! The playground as a whole.

use std::sync::Arc;

use nalgebra::Point2;
use serde_json::{Value, json};
use visloc_core::{
    Clock, SourceFrame,
    geom::{PlanarPose, nao::HeadAngles},
    settings::Overrides,
};
use visloc_locate::{
    PipelineConfig, StartPrior,
    lineup::{Lineup, RunSettings},
    vision::DropReason,
};
use visloc_sim::{LiveSimulation, Scenario};

use super::{
    driver::Driver,
    likelihood::LikelihoodMap,
    world::{WorldSettings, check_exposure, in_range},
};
use crate::{
    Command, MessageBuilder, MessageKind, Session, StudioError, Update,
    message::lay_over,
    playback::Playback,
    recording::Input,
    tuning,
    view::{LocalizationView, views, world_geometry},
};

/// Algorithms that run until somebody chooses others.
const FIRST_ALGORITHMS: [&str; 2] = ["evolutionary", "mce"];
/// Robot and light on maps of the user's own.
const OWN_MAP_SCENARIO: &str = "office-walk";
/// Coordinates beyond this are no place, meters.
const MAX_COORDINATE_M: f64 = 200.0;

/// A world to play in.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Its id.
    pub id: &'static str,
    /// What people read.
    pub label: &'static str,
    /// The scenario that furnishes it.
    pub scenario: &'static str,
}

/// All worlds, the first one first.
pub const PLACES: [Place; 4] = [
    Place { id: "robocup-2010", label: "RoboCup field 2010", scenario: "tour" },
    Place { id: "robocup-2024", label: "RoboCup field 2024", scenario: "tour-2024" },
    Place { id: "office", label: "Office corridor", scenario: "office-walk" },
    Place { id: "office-large", label: "Large office", scenario: "office-large" },
];

/// A simulated robot with algorithms that look for it.
pub struct Playground {
    /// Id of the place.
    place: String,
    scenes: Value,
    scenario: Scenario,
    simulation: LiveSimulation,
    settings: WorldSettings,
    driver: Driver,
    lineup: Lineup,
    likelihood: Option<LikelihoodMap>,
    playback: Playback,
    frame: SourceFrame,
    /// The message of the frame's image; made anew when anything in it has changed.
    image: Option<Arc<[u8]>>,
    number: u64,
    render_ms: f64,
    clock: Clock,
    /// With the number of changes of the lineup that it shows.
    scene: Option<(u64, Arc<[u8]>)>,
}

impl Playground {
    /// A playground in which the robot walks around; `scenes` is told to the pages as what else can be opened.
    ///
    /// # Errors
    /// If there is no such place or it cannot be built.
    pub fn new(place: &str, seed: u64, clock: Clock, scenes: Value) -> Result<Self, StudioError> {
        let place = PLACES
            .iter()
            .find(|known| known.id == place)
            .ok_or_else(|| StudioError::command("place", PLACES.map(|place| place.id).join(", "), place))?;
        Self::in_scenario(place.id, Scenario::load(place.scenario)?, seed, clock, scenes)
    }

    /// A playground on a map of the user's own, with the robot and the light of the usual ones, and nothing that stands around; `id` is told
    /// to the pages.
    ///
    /// # Errors
    /// If the map cannot be used, or has no place for a robot.
    pub fn on_map(map: &str, id: &str, seed: u64, clock: Clock, scenes: Value) -> Result<Self, StudioError> {
        let usual = Scenario::load(OWN_MAP_SCENARIO)?;
        let scenario = Scenario {
            name: map.to_owned(),
            map: map.to_owned(),
            robot: usual.robot,
            light: usual.light,
            ..Scenario::default()
        };
        Self::in_scenario(id, scenario, seed, clock, scenes)
    }

    fn in_scenario(
        id: &str,
        scenario: Scenario,
        seed: u64,
        clock: Clock,
        scenes: Value,
    ) -> Result<Self, StudioError> {
        let mut simulation = LiveSimulation::new(&scenario, seed)?;
        let mut driver = Driver::default();
        let frame = simulation.step(&driver.controls(&simulation));
        let algorithms = FIRST_ALGORITHMS.map(|name| (name.to_owned(), Overrides::default()));
        let settings = RunSettings {
            map: Arc::new(simulation.map().clone()),
            seed,
            start: StartPrior::Uniform,
            pipeline: PipelineConfig::default(),
            algorithms: algorithms.to_vec(),
        };
        let lineup = Lineup::new(settings, clock.clone())?;
        let mut playground = Self {
            place: id.to_owned(),
            scenes,
            settings: WorldSettings::of(&scenario),
            scenario,
            driver,
            lineup,
            likelihood: None,
            playback: Playback::default(),
            frame,
            image: None,
            number: 0,
            render_ms: 0.0,
            clock,
            scene: None,
            simulation,
        };
        playground.weigh()?;
        Ok(playground)
    }

    /// Everything from the beginning, with the algorithms, parameters and world as they are.
    fn reset(&mut self, seed: u64) -> Result<(), StudioError> {
        let mut simulation = LiveSimulation::new(&self.scenario, seed)?;
        self.settings.apply(&WorldSettings::of(&self.scenario), &self.scenario, &mut simulation)?;
        self.lineup.reset(seed)?;
        self.simulation = simulation;
        self.driver = self.driver.anew();
        self.number = 0;
        self.take_frame();
        self.weigh()
    }

    fn take_frame(&mut self) {
        let controls = self.driver.controls(&self.simulation);
        let simulation = &mut self.simulation;
        (self.frame, self.render_ms) = self.clock.measure(|| simulation.step(&controls));
    }

    /// All algorithms take in the frame.
    fn weigh(&mut self) -> Result<(), StudioError> {
        self.image = None;
        Ok(self.lineup.step(&self.frame.frame)?)
    }

    fn set_world(&mut self, settings: WorldSettings) -> Result<(), StudioError> {
        settings.apply(&self.settings, &self.scenario, &mut self.simulation)?;
        self.settings = settings;
        Ok(())
    }

    fn kidnap(&mut self, place: Option<PlanarPose>) -> Result<(), StudioError> {
        let choice = self.driver.next_choice();
        let place = place.or_else(|| self.simulation.random_pose(choice));
        let place =
            place.ok_or_else(|| StudioError::command("kidnap", "a free place", "none; give coordinates"))?;
        self.driver.kidnap(self.simulation.truth().world_from_robot, place);
        Ok(())
    }

    fn set_head(&mut self, yaw_deg: Option<f64>, pitch_deg: Option<f64>) -> Result<(), StudioError> {
        let (yaw_deg, pitch_deg) = match (yaw_deg, pitch_deg) {
            (None, None) => {
                self.driver.head = None;
                return Ok(());
            }
            (yaw, pitch) => (yaw.unwrap_or(0.0), pitch.unwrap_or(0.0)),
        };
        in_range("head to the left", yaw_deg, -120.0, 120.0)?;
        in_range("head down", pitch_deg, -40.0, 60.0)?;
        let (yaw_rad, pitch_rad) = (yaw_deg.to_radians(), pitch_deg.to_radians());
        self.driver.head = Some(HeadAngles { yaw_rad, pitch_rad });
        Ok(())
    }

    /// What moves the robot.
    fn handle_motion(&mut self, command: &Command) -> Result<(), StudioError> {
        match *command {
            Command::Drive { forward, left, turn, .. } => self.driver.drive([forward, left, turn]),
            Command::WalkTo { x_m, y_m } => {
                let place = pose(x_m, y_m, 0.0)?;
                self.driver.walk_to(Point2::new(place.x_m, place.y_m));
            }
            Command::Autopilot { is_on } => self.driver.set_autopilot(is_on),
            Command::Head { yaw_deg, pitch_deg } => self.set_head(yaw_deg, pitch_deg)?,
            Command::Carry { x_m, y_m, yaw_rad } => self.driver.hold(pose(x_m, y_m, yaw_rad)?),
            Command::Lift {} => self.driver.hold(self.simulation.truth().world_from_robot),
            Command::PutDown {} => self.driver.release(),
            Command::Kidnap { robot: None, x_m, y_m, yaw_rad } => {
                let here = self.simulation.truth().world_from_robot;
                let place = match (x_m, y_m) {
                    (Some(x_m), Some(y_m)) => Some(pose(x_m, y_m, yaw_rad.unwrap_or(here.yaw_rad))?),
                    _ => None,
                };
                self.kidnap(place)?;
            }
            Command::Felt { is_on } => self.driver.is_felt = is_on,
            Command::Cover { is_on } => self.driver.is_covered = is_on,
            _ => return Err(StudioError::command("command", "one for a playground", command.name())),
        }
        Ok(())
    }

    /// What is decided beside the robot; only a frame tells what it sees of it, so there is one at once.
    fn handle_world(&mut self, command: &Command) -> Result<(), StudioError> {
        match *command {
            Command::Light { exposure_stops, unevenness } => {
                check_exposure(exposure_stops)?;
                self.set_world(WorldSettings { unevenness, ..self.settings })?;
                self.driver.exposure_stops = exposure_stops;
            }
            Command::Odometry { factor } => {
                self.set_world(WorldSettings { odometry_factor: factor, ..self.settings })?;
            }
            Command::Robots { count } => {
                self.set_world(WorldSettings { num_robots: count, ..self.settings })?;
            }
            _ => return self.handle_motion(command),
        }
        Ok(())
    }

    fn controls(&self) -> Value {
        let degrees = |head: HeadAngles| [head.yaw_rad.to_degrees(), head.pitch_rad.to_degrees()];
        json!({
            "is_autopilot": self.driver.is_autopilot,
            "is_felt": self.driver.is_felt,
            "is_covered": self.driver.is_covered,
            "is_held": self.driver.is_held(),
            "head": self.driver.head.map(degrees),
            "target": self.driver.target().map(|target| [target.x, target.y]),
            "exposure_stops": self.driver.exposure_stops,
            "unevenness": self.settings.unevenness,
            "odometry_factor": self.settings.odometry_factor,
            "num_robots": self.settings.num_robots,
            "has_likelihood": self.likelihood.is_some(),
        })
    }

    fn scene_message(&mut self) -> Result<Arc<[u8]>, StudioError> {
        let num_changes = self.lineup.num_changes();
        if let Some((_, scene)) = self.scene.as_ref().filter(|(shown, _)| *shown == num_changes) {
            return Ok(Arc::clone(scene));
        }
        let settings = self.lineup.settings();
        let mut header = json!({
            "mode": "playground",
            "scene": self.place,
            "scenes": self.scenes,
            "world": world_geometry(&settings.map),
            "step_secs": self.simulation.step_secs(),
            "drop_reasons": DropReason::ALL.map(DropReason::name),
        });
        lay_over(&mut header, &tuning::scene_fields(settings)?);
        let bytes: Arc<[u8]> = MessageBuilder::new(MessageKind::Scene, &header)?.finish().into();
        self.scene = Some((num_changes, Arc::clone(&bytes)));
        Ok(bytes)
    }
}

/// A pose that makes sense.
fn pose(x_m: f64, y_m: f64, yaw_rad: f64) -> Result<PlanarPose, StudioError> {
    in_range("x", x_m, -MAX_COORDINATE_M, MAX_COORDINATE_M)?;
    in_range("y", y_m, -MAX_COORDINATE_M, MAX_COORDINATE_M)?;
    in_range("heading", yaw_rad, -10.0, 10.0)?;
    Ok(PlanarPose::new(x_m, y_m, yaw_rad))
}

impl Session for Playground {
    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        match command {
            Command::Step {} => {
                self.playback.pause();
                self.step()?;
            }
            Command::Reset { seed } => self.reset(*seed)?,
            Command::Likelihood { is_on } => {
                let map = || LikelihoodMap::new(self.simulation.map(), &self.lineup.settings().pipeline);
                self.likelihood = is_on.then(map).transpose()?;
            }
            command => {
                if tuning::obey(&mut self.lineup, command)? {
                    self.image = None;
                } else if !self.playback.handle(command)? {
                    self.handle_world(command)?;
                }
            }
        }
        Ok(())
    }

    fn step_secs(&self) -> Option<f64> {
        self.playback.wait_secs(self.simulation.step_secs())
    }

    fn step(&mut self) -> Result<(), StudioError> {
        self.take_frame();
        self.number += 1;
        self.weigh()
    }

    fn update(&mut self, aside: Option<&Value>) -> Result<Update, StudioError> {
        let scene = self.scene_message()?;
        let controls = self.controls();
        let contenders = views(&self.lineup);
        let view = LocalizationView {
            map: self.simulation.map(),
            number: self.number,
            secs: self.number as f64 * self.simulation.step_secs(),
            frame: &self.frame.frame,
            truth: self.frame.truth,
            contenders: &contenders,
        };
        let others: Vec<[f64; 3]> =
            self.simulation.others().iter().map(|pose| [pose.x_m, pose.y_m, pose.yaw_rad]).collect();
        let likelihood = self.likelihood.as_mut().zip(contenders.first());
        let likelihood = likelihood.map(|(map, contender)| map.values(&contender.percept));
        let mut more = json!({
            "seed": self.lineup.settings().seed,
            "others": others,
            "render_ms": self.render_ms,
            "controls": controls,
        });
        lay_over(&mut more, &self.playback.fields());
        lay_over(&mut more, aside.unwrap_or(&Value::Null));
        let state = view.state(more, likelihood)?;
        let image = match &self.image {
            Some(image) => Arc::clone(image),
            None => view.image()?.into(),
        };
        self.image = Some(Arc::clone(&image));
        Ok(Update { scene, state: state.into(), image: Some(image) })
    }

    fn input(&self) -> Option<Input<'_>> {
        Some(Input::Robot { frame: &self.frame.frame, truth: self.frame.truth.as_ref() })
    }
}
