//! What a recording is computed with.

use serde_json::{Map, Value, json};
use visloc_core::Clock;
use visloc_locate::lineup::Lineup;

use super::camera_run::CameraRun;
use crate::{Command, StudioError, message::lay_over, recording::RecordingIndex, slam::SlamSettings, tuning};

/// Algorithms and parameters as people choose them.
pub(super) enum Draft {
    /// For a robot on a map.
    Robot(Box<Lineup>),
    /// For a camera without a map, with the seed.
    Camera(Box<SlamSettings>, u64),
}

/// Clocks that measure the parts of a computation.
#[derive(Debug, Clone)]
pub(super) struct Clocks {
    pub robot: Clock,
    pub camera: Clock,
}

/// A computation, ready for the first frame.
pub(super) enum Method {
    Robot(Box<Lineup>),
    Camera(Box<CameraRun>),
}

impl Draft {
    /// With what a recording was made, as its scene tells; `None` if it does not, or if it was another version.
    pub fn of_scene(header: &Map<String, Value>) -> Option<Self> {
        let robot = tuning::settings_of_scene(header).ok().flatten();
        let robot = robot.and_then(|settings| Lineup::new(settings, Clock::still()).ok());
        let camera = || SlamSettings::of_scene(header).ok().flatten();
        robot
            .map(|lineup| Self::Robot(Box::new(lineup)))
            .or_else(|| camera().map(|(settings, seed)| Self::Camera(Box::new(settings), seed)))
    }

    /// Changes what a command says; whether it was such a command.
    ///
    /// # Errors
    /// If a name or a value is impossible; then nothing has changed.
    pub fn handle(&mut self, command: &Command) -> Result<bool, StudioError> {
        match self {
            Self::Robot(lineup) => tuning::obey(lineup, command),
            Self::Camera(settings, _) => match settings.changed(command)? {
                Some(changed) => {
                    **settings = changed;
                    Ok(true)
                }
                None => Ok(false),
            },
        }
    }

    /// For the scene message.
    pub fn scene_fields(&self) -> Result<Value, StudioError> {
        match self {
            Self::Robot(lineup) => tuning::scene_fields(lineup.settings()),
            Self::Camera(settings, seed) => {
                let mut fields = settings.scene_fields()?;
                lay_over(&mut fields, &json!({ "seed": seed }));
                Ok(fields)
            }
        }
    }

    /// Another seed of everything random.
    pub fn set_seed(&mut self, new: u64) -> Result<(), StudioError> {
        match self {
            Self::Robot(lineup) => lineup.reset(new)?,
            Self::Camera(_, seed) => *seed = new,
        }
        Ok(())
    }

    /// Begins to compute a recording.
    pub fn start(&self, index: &mut RecordingIndex, clocks: &Clocks) -> Result<Method, StudioError> {
        if !index.has_input() {
            return Err(StudioError::command(
                "recompute",
                "a recording with its input (--record, or one made in the studio)",
                "none in some of the frames",
            ));
        }
        Ok(match self {
            Self::Robot(lineup) => {
                Method::Robot(Box::new(Lineup::new(lineup.settings().clone(), clocks.robot.clone())?))
            }
            Self::Camera(settings, seed) => {
                Method::Camera(Box::new(CameraRun::start(index, settings, *seed, clocks.camera.clone())?))
            }
        })
    }
}
