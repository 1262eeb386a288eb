//! From frames to percepts and a model to weigh poses with.

use visloc_core::{Frame, Rng, RngTree};
use visloc_locate::{
    ImageAnalyzer, ObservationModel, PipelineConfig, observation::field::FieldObservationModel,
    vision::Percept,
};
use visloc_world::{Map, field::Field};

use crate::ExperimentError;

/// Image analysis and observation model of a field.
pub struct Eye {
    analyzer: ImageAnalyzer,
    analysis_rng: Rng,
    model: FieldObservationModel,
    field: Field,
}

impl Eye {
    /// For a map, with the parameters of a pipeline. `rng` decides which pixels a random discard takes out.
    ///
    /// # Errors
    /// If the map is not a field or a parameter is out of its range.
    pub fn new(map: &Map, config: &PipelineConfig, rng: RngTree) -> Result<Self, ExperimentError> {
        let failed = |reason: String| ExperimentError::Setup { reason };
        config.check()?;
        let analyzer = ImageAnalyzer::new(map, config).map_err(|error| failed(error.to_string()))?;
        let Map::Field(field) = map else {
            return Err(failed(format!(
                "expected the map of a RoboCup field, found a building, {:?}",
                map.name()
            )));
        };
        let model = FieldObservationModel::new(field, &config.observation)?;
        Ok(Self { analyzer, analysis_rng: rng.stream("analysis", 0), model, field: field.clone() })
    }

    /// Analyzes a frame. The model then weighs poses by what it shows.
    ///
    /// # Errors
    /// If the image does not belong to its calibration.
    pub fn look(&mut self, frame: &Frame) -> Result<&Percept, ExperimentError> {
        let percept = self.analyzer.analyze(frame, &mut self.analysis_rng);
        let percept = percept.map_err(|error| ExperimentError::Setup { reason: error.to_string() })?;
        self.model.condition_on(percept);
        Ok(percept)
    }

    /// What the last frame shows.
    pub fn percept(&self) -> &Percept {
        self.analyzer.percept()
    }

    /// Conditions the model on a percept other than the last frame's.
    pub fn condition_on(&mut self, percept: &Percept) {
        self.model.condition_on(percept);
    }

    /// The model, conditioned on what was seen last.
    pub fn model(&self) -> &dyn ObservationModel {
        &self.model
    }

    /// The field.
    pub fn field(&self) -> &Field {
        &self.field
    }
}
