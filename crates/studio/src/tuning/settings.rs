//! Everything that decides about a run besides its input.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Map as JsonMap, Value, json};
use visloc_core::settings::{Parameter, SettingsError, overlay, parameters};
use visloc_locate::{ALGORITHMS, PipelineConfig, StartPrior, algorithm_parameters};
use visloc_world::Map;

use super::overrides::Overrides;
use crate::StudioError;

/// Key of the settings in a scene message.
const RUN: &str = "run";

/// What an algorithm is run with. The same settings and the same frames give the same estimates, bit by bit.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    /// The map, which what is shown shares.
    pub map: Arc<Map>,
    /// Seed of everything random.
    pub seed: u64,
    /// What is known about the start.
    pub start: StartPrior,
    /// Parameters of everything but the algorithms.
    pub pipeline: PipelineConfig,
    /// Names of the algorithms, and what is different from their defaults.
    pub algorithms: Vec<(String, Overrides)>,
}

/// Settings as a recording holds them. Numbers are TOML: what is read back is exactly what was written.
#[derive(Serialize, Deserialize)]
struct Stored {
    map: String,
    seed: u64,
    start: String,
    pipeline: String,
    algorithms: Vec<(String, String)>,
}

#[derive(Serialize, Deserialize)]
struct StoredStart {
    start: StartPrior,
}

impl RunSettings {
    /// Parameters of everything but the algorithms that are not as by default.
    ///
    /// # Errors
    /// If the parameters cannot be written.
    pub fn pipeline_overrides(&self) -> Result<Overrides, StudioError> {
        let defaults = parameters(&PipelineConfig::default()).map_err(refused)?;
        Ok(Overrides::between(&defaults, parameters(&self.pipeline).map_err(refused)?))
    }

    /// The same with other parameters of everything but the algorithms.
    ///
    /// # Errors
    /// If a parameter is unknown or out of its range.
    pub fn with_pipeline(&self, overrides: &Overrides) -> Result<Self, StudioError> {
        let pipeline = overlay(&PipelineConfig::default(), &overrides.toml()?)
            .map_err(|error| StudioError::command("parameter", "a possible value", error.reason))?;
        Ok(Self { pipeline, ..self.clone() })
    }

    /// What a scene message says about algorithms and parameters: `algorithms` that there are, `contenders` that run, `pipeline`,
    /// `seed`, and `run`, from which [`RunSettings::of_scene`] reads them back.
    ///
    /// # Errors
    /// If a parameter cannot be written.
    pub fn scene_fields(&self) -> Result<Value, StudioError> {
        let contenders: Result<Vec<Value>, StudioError> =
            self.algorithms.iter().map(|(name, overrides)| self.contender(name, overrides)).collect();
        let pipeline = parameters(&self.pipeline).map_err(refused)?;
        let defaults = parameters(&PipelineConfig::default()).map_err(refused)?;
        let algorithms =
            ALGORITHMS.map(|algorithm| json!({ "name": algorithm.name, "summary": algorithm.summary }));
        Ok(json!({
            "seed": self.seed,
            "algorithms": algorithms,
            "contenders": contenders?,
            "pipeline": {
                "parameters": with_defaults(pipeline, &defaults),
                "changed": self.pipeline_overrides()?.paths(),
            },
            RUN: self.stored()?,
        }))
    }

    fn contender(&self, name: &str, overrides: &Overrides) -> Result<Value, StudioError> {
        let values = algorithm_parameters(&self.map, name, self.pipeline.features, Some(&overrides.toml()?))?;
        let defaults = algorithm_parameters(&self.map, name, self.pipeline.features, None)?;
        Ok(json!({
            "name": name,
            "parameters": with_defaults(values, &defaults),
            "changed": overrides.paths(),
        }))
    }

    fn stored(&self) -> Result<Stored, StudioError> {
        let unwritable = |error: toml::ser::Error| StudioError::command("settings", "TOML", error);
        let algorithm = |(name, overrides): &(String, Overrides)| Ok((name.clone(), overrides.toml()?));
        Ok(Stored {
            map: self.map.to_toml().map_err(unwritable)?,
            seed: self.seed,
            start: toml::to_string(&StoredStart { start: self.start.clone() }).map_err(unwritable)?,
            pipeline: self.pipeline_overrides()?.toml()?,
            algorithms: self.algorithms.iter().map(algorithm).collect::<Result<_, StudioError>>()?,
        })
    }

    /// The settings of a recorded scene; `None` if it has none, as those of SLAM and of older versions.
    ///
    /// # Errors
    /// If they are damaged, or of another version that knew other parameters.
    pub fn of_scene(header: &JsonMap<String, Value>) -> Result<Option<Self>, StudioError> {
        let Some(stored) = header.get(RUN) else { return Ok(None) };
        let damaged = |reason: String| StudioError::input("settings of the recording", reason);
        let stored: Stored =
            serde_json::from_value(stored.clone()).map_err(|error| damaged(error.to_string()))?;
        let map = Map::parse("of the recording", &stored.map).map_err(|error| damaged(error.to_string()))?;
        let start: StoredStart = toml::from_str(&stored.start).map_err(|error| damaged(error.to_string()))?;
        let algorithm = |(name, text): &(String, String)| Ok((name.clone(), Overrides::from_toml(text)?));
        let settings = Self {
            map: Arc::new(map),
            seed: stored.seed,
            start: start.start,
            pipeline: PipelineConfig::default(),
            algorithms: stored.algorithms.iter().map(algorithm).collect::<Result<_, StudioError>>()?,
        };
        settings.with_pipeline(&Overrides::from_toml(&stored.pipeline)?).map(Some)
    }
}

fn refused(error: SettingsError) -> StudioError {
    StudioError::command("parameters", "a table", error.reason)
}

/// Every parameter with its default beside its value.
pub(crate) fn with_defaults(values: Vec<Parameter>, defaults: &[Parameter]) -> Vec<Value> {
    let with_default = |parameter: Parameter| {
        let default = defaults.iter().find(|default| default.path == parameter.path);
        let default = default.map(|default| default.value.clone());
        let mut value = serde_json::to_value(parameter).unwrap_or(Value::Null);
        if let Some(table) = value.as_object_mut() {
            table.insert("default".to_owned(), default.unwrap_or(Value::Null));
        }
        value
    };
    values.into_iter().map(with_default).collect()
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::PlanarPose;
    use visloc_locate::PosePrior;

    use super::*;

    fn settings(map: &str) -> RunSettings {
        let start = StartPrior::Poses(vec![PosePrior {
            world_from_robot: PlanarPose::new(0.1, -1.0 / 3.0, 0.7),
            position_spread_m: 0.2,
            heading_spread_rad: 0.1,
            weight: 1.0,
        }]);
        let changed = Overrides::default().with("num_particles", &json!(333));
        let settings = RunSettings {
            map: Arc::new(Map::load(map).unwrap()),
            seed: u64::MAX,
            start,
            pipeline: PipelineConfig::default(),
            algorithms: vec![("mc".to_owned(), changed), ("evolutionary".to_owned(), Overrides::default())],
        };
        let pipeline = Overrides::default().with("lift.min_unloaded_secs", &json!(1.0 / 3.0));
        settings.with_pipeline(&pipeline).unwrap()
    }

    #[test]
    fn what_is_stored_is_read_back_exactly() {
        for map in ["robocup-spl-2010", "robocup-spl-2024", "office"] {
            let settings = settings(map);
            let text = serde_json::to_string(&settings.scene_fields().unwrap()).unwrap();
            let header = serde_json::from_str(&text).unwrap();
            assert_eq!(RunSettings::of_scene(&header).unwrap().unwrap(), settings);
        }
    }

    #[test]
    fn damage_is_told() {
        let settings = settings("robocup-spl-2010");
        let fields = settings.scene_fields().unwrap();
        let mut header = fields.as_object().unwrap().clone();
        header[RUN]["map"] = json!("kind = 'moon'");
        assert!(RunSettings::of_scene(&header).unwrap_err().to_string().contains("robocup-field"));
        header.remove(RUN);
        assert_eq!(RunSettings::of_scene(&header).unwrap(), None);
    }
}
