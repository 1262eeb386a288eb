//! The scene message: what stays from frame to frame.

use serde_json::{Value, json};
use visloc_locate::{ALGORITHMS, PipelineConfig, algorithm_parameters};
use visloc_settings::{Parameter, parameters};
use visloc_vision::DropReason;
use visloc_world::Map;

use super::{contender::Contender, overrides::Overrides};
use crate::{MessageBuilder, MessageKind, StudioError, view::world_geometry};

/// What the message is made of.
pub(super) struct Scene<'a> {
    /// Id of the place.
    pub place: &'a str,
    /// Its map.
    pub map: &'a Map,
    /// Seed of everything random.
    pub seed: u64,
    /// Time between two frames.
    pub step_secs: f64,
    /// The algorithms.
    pub contenders: &'a [Contender],
    /// Parameters of everything but the algorithm.
    pub pipeline: &'a PipelineConfig,
    /// Which of them are changed.
    pub pipeline_overrides: &'a Overrides,
    /// What else can be opened.
    pub others: &'a Value,
}

impl Scene<'_> {
    /// The bytes.
    ///
    /// # Errors
    /// If a parameter cannot be written.
    pub fn message(&self) -> Result<Vec<u8>, StudioError> {
        let contenders: Result<Vec<Value>, StudioError> =
            self.contenders.iter().map(|contender| self.contender(contender)).collect();
        let settings = |error: visloc_settings::SettingsError| {
            StudioError::command("parameters", "a table", error.reason)
        };
        let pipeline = parameters(self.pipeline).map_err(settings)?;
        let defaults = parameters(&PipelineConfig::default()).map_err(settings)?;
        let algorithms =
            ALGORITHMS.map(|algorithm| json!({ "name": algorithm.name, "summary": algorithm.summary }));
        let header = json!({
            "mode": "playground",
            "scene": self.place,
            "scenes": self.others,
            "world": world_geometry(self.map),
            "seed": self.seed,
            "step_secs": self.step_secs,
            "algorithms": algorithms,
            "contenders": contenders?,
            "pipeline": {
                "parameters": with_defaults(pipeline, &defaults),
                "changed": self.pipeline_overrides.paths(),
            },
            "drop_reasons": DropReason::ALL.map(DropReason::name),
        });
        Ok(MessageBuilder::new(MessageKind::Scene, &header)?.finish())
    }

    fn contender(&self, contender: &Contender) -> Result<Value, StudioError> {
        let text = contender.overrides().toml()?;
        let values = algorithm_parameters(self.map, contender.name(), Some(&text))?;
        let defaults = algorithm_parameters(self.map, contender.name(), None)?;
        Ok(json!({
            "name": contender.name(),
            "parameters": with_defaults(values, &defaults),
            "changed": contender.overrides().paths(),
        }))
    }
}

/// Every parameter with its default beside its value.
fn with_defaults(values: Vec<Parameter>, defaults: &[Parameter]) -> Vec<Value> {
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
