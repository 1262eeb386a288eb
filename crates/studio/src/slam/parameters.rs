//! Preset and parameters of SLAM, as people change them.

use serde::{Deserialize, Serialize};
use serde_json::{Map as JsonMap, Value, json};
use visloc_core::settings::{Overrides, parameters};
use visloc_locate::lineup::LineupError;
use visloc_slam::{ConfigError, PRESETS, SlamConfig};

use crate::{Command, StudioError, message::lay_over, tuning::with_defaults};

/// Key of the settings in a scene message.
const RUN: &str = "slam_run";
/// Key of a scene message that says that the camera was in a map of an earlier session.
const IN_MAP: &str = "is_in_map";

/// Settings as a recording holds them. Numbers are TOML: what is read back is exactly what was written.
#[derive(Serialize, Deserialize)]
struct Stored {
    preset: String,
    parameters: String,
}

/// A preset, and what is different from it.
#[derive(Debug, Clone)]
pub struct SlamSettings {
    preset: String,
    overrides: Overrides,
    config: SlamConfig,
}

impl SlamSettings {
    /// A preset as it is.
    ///
    /// # Errors
    /// If there is no such preset.
    pub fn preset(name: &str) -> Result<Self, StudioError> {
        let config = SlamConfig::preset(name).map_err(|error| refused(&error))?;
        Ok(Self { preset: name.to_owned(), overrides: Overrides::default(), config })
    }

    /// Parameters that somebody has put together, shown as what is different from the first preset.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn of(config: &SlamConfig) -> Result<Self, StudioError> {
        let settings = Self::preset(PRESETS[0].name)?;
        let defaults = parameters(&settings.config).map_err(unwritable)?;
        let overrides = Overrides::between(&defaults, parameters(config).map_err(unwritable)?);
        Ok(Self { overrides, config: config.clone(), ..settings })
    }

    /// The parameters.
    pub fn config(&self) -> &SlamConfig {
        &self.config
    }

    /// What a command makes of them; `None` if it is about something else.
    ///
    /// # Errors
    /// If a name or a value is impossible.
    pub fn changed(&self, command: &Command) -> Result<Option<Self>, StudioError> {
        match command {
            Command::Algorithms { names } => match names.as_slice() {
                [name] => Self::preset(name).map(Some),
                names => Err(StudioError::command("presets", "one", names.len())),
            },
            Command::Parameter { path, value, .. } => {
                let changed = self.with(self.overrides.with(path, value));
                changed.map(Some).map_err(|error| {
                    let (path, value) = (path.clone(), value.clone());
                    LineupError::Parameter { path, value, reason: error.to_string() }.into()
                })
            }
            Command::Defaults { .. } => Self::preset(&self.preset).map(Some),
            _ => Ok(None),
        }
    }

    fn with(&self, overrides: Overrides) -> Result<Self, StudioError> {
        let base = SlamConfig::preset(&self.preset).map_err(|error| refused(&error))?;
        let config = base.with_toml(&overrides.toml()?).map_err(|error| refused(&error))?;
        Ok(Self { preset: self.preset.clone(), overrides, config })
    }

    /// The settings and the seed of a recorded scene; `None` if it has none, as those of localization and of older versions, or if they are of
    /// use only with a map that is not in the recording.
    ///
    /// # Errors
    /// If they are damaged, or of another version that knew other parameters.
    pub fn of_scene(header: &JsonMap<String, Value>) -> Result<Option<(Self, u64)>, StudioError> {
        let (Some(stored), Some(seed)) = (header.get(RUN), header.get("seed").and_then(Value::as_u64)) else {
            return Ok(None);
        };
        if header.contains_key(IN_MAP) {
            return Ok(None);
        }
        let damaged = |error: serde_json::Error| StudioError::input("settings of the recording", error);
        let stored: Stored = serde_json::from_value(stored.clone()).map_err(damaged)?;
        let settings = Self::preset(&stored.preset)?.with(Overrides::from_toml(&stored.parameters)?)?;
        Ok(Some((settings, seed)))
    }

    /// For the scene message of a camera in a map of an earlier session, as [`SlamSettings::scene_fields`].
    ///
    /// # Errors
    /// If a parameter cannot be written.
    pub fn scene_fields_in_map(&self) -> Result<Value, StudioError> {
        let mut fields = self.scene_fields()?;
        lay_over(&mut fields, &json!({ IN_MAP: true }));
        Ok(fields)
    }

    /// For the scene message: `presets`, `preset`, `pipeline` with all parameters, and `slam_run`, from which
    /// [`SlamSettings::of_scene`] reads them back.
    ///
    /// # Errors
    /// If a parameter cannot be written.
    pub fn scene_fields(&self) -> Result<Value, StudioError> {
        let defaults = SlamConfig::preset(&self.preset).map_err(|error| refused(&error))?;
        let defaults = parameters(&defaults).map_err(unwritable)?;
        let values = parameters(&self.config).map_err(unwritable)?;
        let presets = PRESETS.map(|preset| json!({ "name": preset.name, "summary": preset.summary }));
        let run = Stored { preset: self.preset.clone(), parameters: self.overrides.toml()? };
        Ok(json!({
            RUN: run,
            "presets": presets,
            "preset": self.preset,
            "pipeline": {
                "parameters": with_defaults(values, &defaults),
                "changed": self.overrides.paths(),
            },
        }))
    }
}

fn refused(error: &ConfigError) -> StudioError {
    StudioError::input("SLAM", error)
}

fn unwritable(error: visloc_core::settings::SettingsError) -> StudioError {
    StudioError::command("parameters", "a table", error.reason)
}
