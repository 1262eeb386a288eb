//! What every robot of a game has seen and believed by itself.

use visloc_core::{RngTree, Timestamp, geom::PlanarPose};
use visloc_locate::{
    Estimate, Pipeline, PipelineConfig, StartPrior, team::Sighting, vision::field::FieldAnalysisConfig,
};
use visloc_sim::{Detection, DetectorSetup, Scenario, TeamFrame, TeamSimulation};
use visloc_world::Map;

use crate::ExperimentError;

/// The robot that is told its half.
pub const WHO_KNOWS: usize = 0;
/// Nearer to the middle line, meters, a robot knows no half, whatever it is told: three standard deviations of a place that can be relied on.
const MIN_FROM_MIDDLE_M: f64 = 0.3;

/// What is recorded.
#[derive(Debug, Clone, Copy)]
pub struct GameSetup {
    /// Robots on the field.
    pub num_robots: usize,
    /// Length, seconds.
    pub secs: f64,
    /// Images a second of each robot.
    pub images_per_sec: f64,
    /// Whether one robot is told its half at the start.
    pub one_knows: bool,
    /// A robot that is carried elsewhere, and when, seconds.
    pub kidnap: Option<(usize, f64)>,
    /// Seed of everything.
    pub seed: u64,
}

/// One robot at one moment.
#[derive(Debug, Clone)]
pub struct Moment {
    /// Stamp of the image.
    pub at: Timestamp,
    /// What its localizer says.
    pub estimate: Estimate,
    /// Its odometry.
    pub odometry: Option<PlanarPose>,
    /// Where it is.
    pub truth: PlanarPose,
    /// Whether somebody carries it.
    pub is_carried: bool,
    /// What a detector would see.
    pub detections: Vec<Detection>,
    /// What the own detector finds in the image.
    pub found: Vec<Sighting>,
}

/// A recorded game.
#[derive(Debug, Clone)]
pub struct Game {
    /// The map.
    pub map: Map,
    /// Errors of the detector.
    pub detector: DetectorSetup,
    /// All moments, each of all robots.
    pub moments: Vec<Vec<Moment>>,
    /// The robot that was told its half.
    pub who_knows: Option<usize>,
    /// Time between two moments, seconds.
    pub step_secs: f64,
}

impl Game {
    /// Plays a game on a field with white goals.
    ///
    /// # Errors
    /// If the simulation or a pipeline cannot be built.
    pub fn record(setup: &GameSetup) -> Result<Self, ExperimentError> {
        let (mut team, first, mut pipelines) = begin(setup)?;
        let map = team.map().clone();
        let detector = DetectorSetup::default();
        let mut first = Some(first);
        let num_steps = (setup.secs * setup.images_per_sec).round() as usize;
        let mut moments = Vec::with_capacity(num_steps);
        for step in 0..num_steps {
            if let Some((robot, secs)) = setup.kidnap
                && step == (secs * setup.images_per_sec).round() as usize
            {
                let here = team.truths()[robot];
                let to = PlanarPose::new(-0.6 * here.x_m + 0.8, -0.7 * here.y_m - 0.5, here.yaw_rad + 2.0);
                team.carry(robot, to, (2.0 * setup.images_per_sec).round() as usize);
            }
            let mut all = Vec::new();
            let frames = first.take().unwrap_or_else(|| team.step());
            for (frame, pipeline) in frames.into_iter().zip(&mut pipelines) {
                let estimate = pipeline.step(&frame.source.frame).map_err(setup_error)?.clone();
                let Some(truth) = frame.source.truth else { continue };
                let at = frame.source.frame.at;
                let objects = &pipeline.percept().objects;
                all.push(Moment {
                    at,
                    estimate,
                    odometry: frame.source.frame.odometry,
                    truth: truth.world_from_robot,
                    is_carried: truth.height_m > 0.0,
                    detections: frame.detections,
                    found: objects.iter().map(|object| Sighting::of_object(at, object)).collect(),
                });
            }
            moments.push(all);
        }
        let who_knows = setup.one_knows.then_some(WHO_KNOWS);
        Ok(Self { map, detector, moments, who_knows, step_secs: 1.0 / setup.images_per_sec })
    }
}

/// The robots on the field, what they see first, and a localizer for each of them.
pub(super) fn begin(
    setup: &GameSetup,
) -> Result<(TeamSimulation, Vec<TeamFrame>, Vec<Pipeline>), ExperimentError> {
    let mut scenario = Scenario::load("tour-2024").map_err(setup_error)?;
    scenario.frames_per_sec = setup.images_per_sec;
    let draws = RngTree::new(setup.seed);
    let (mut num_refused, mut seed) = (0, setup.seed);
    // The half is that of the first image.
    let (team, first) = loop {
        let mut team = TeamSimulation::new(&scenario, setup.num_robots, DetectorSetup::default(), seed)
            .map_err(setup_error)?;
        let first = team.step();
        if !setup.one_knows || team.truths()[WHO_KNOWS].x_m.abs() >= MIN_FROM_MIDDLE_M {
            break (team, first);
        }
        seed = draws.stream_seed("another game", num_refused);
        num_refused += 1;
    };
    let map = team.map().clone();
    let mut pipelines = Vec::new();
    for (robot, truth) in team.truths().iter().enumerate() {
        pipelines.push(localizer_of(setup, robot, &map, truth)?);
    }
    Ok((team, first, pipelines))
}

/// The localizer of a robot that begins there.
pub(super) fn localizer_of(
    setup: &GameSetup,
    robot: usize,
    map: &Map,
    truth: &PlanarPose,
) -> Result<Pipeline, ExperimentError> {
    let start = if setup.one_knows && robot == WHO_KNOWS {
        StartPrior::half_of(map, truth)
    } else {
        StartPrior::Uniform
    };
    let seed = setup.seed.wrapping_mul(16).wrapping_add(robot as u64);
    let analysis = FieldAnalysisConfig { detect_objects: true, ..FieldAnalysisConfig::default() };
    let config = PipelineConfig { analysis, ..PipelineConfig::default() };
    Pipeline::builder(map).config(config).seed(seed).start(start).build().map_err(setup_error)
}

pub(super) fn setup_error(error: impl std::fmt::Display) -> ExperimentError {
    ExperimentError::Setup { reason: error.to_string() }
}
