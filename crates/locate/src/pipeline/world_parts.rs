//! Observation models of a map.

use visloc_world::{Map, field::Field, office::Office};

use super::{FeatureChoice, PipelineConfig, analyzer::unknown_kind};
use crate::{
    ConfigError, ObservationModel,
    observation::{
        features::FeatureModel,
        field::{FieldFeatureModel, FieldObservationModel},
        office::{OfficeFeatureModel, OfficeObservationModel},
    },
    refine::RefinementConfig,
};

/// What is different from world to world.
pub(super) struct WorldParts {
    pub model: Box<dyn ObservationModel>,
    /// What refines hypotheses, if that is wished for and the world has it.
    pub rich: Option<Rich>,
}

/// What refines hypotheses.
pub(super) struct Rich {
    pub config: RefinementConfig,
    pub features: Box<dyn FeatureModel>,
    pub pixels: Box<dyn ObservationModel>,
}

impl WorldParts {
    pub fn new(map: &Map, config: &PipelineConfig) -> Result<Self, ConfigError> {
        match map {
            Map::Field(field) => Self::of_field(field, config),
            Map::Office(office) => Self::of_office(office, config),
            other => Err(unknown_kind(other)),
        }
    }

    fn of_field(field: &Field, config: &PipelineConfig) -> Result<Self, ConfigError> {
        let model = FieldObservationModel::new(field, &config.observation)?;
        let rich = || Rich {
            config: config.refinement,
            features: Box::new(FieldFeatureModel::beside(field, &model)),
            pixels: Box::new(model.clone()),
        };
        let rich = (config.features == FeatureChoice::Rich).then(rich);
        Ok(Self { model: Box::new(model), rich })
    }

    fn of_office(office: &Office, config: &PipelineConfig) -> Result<Self, ConfigError> {
        let model = OfficeObservationModel::new(office, &config.office.observation)?;
        let rich = || Rich {
            config: config.office.refinement,
            features: Box::new(OfficeFeatureModel::new(&model)),
            pixels: Box::new(model.clone()),
        };
        let rich = (config.features == FeatureChoice::Rich).then(rich);
        Ok(Self { model: Box::new(model), rich })
    }
}

/// Matches the features of images to a map, for whoever refines more than a pose.
///
/// # Errors
/// If the map is of a kind that has no such model.
pub fn feature_model(map: &Map, config: &PipelineConfig) -> Result<Box<dyn FeatureModel>, ConfigError> {
    let config = PipelineConfig { features: FeatureChoice::Rich, ..*config };
    let rich = WorldParts::new(map, &config)?.rich;
    rich.map(|rich| rich.features).ok_or_else(|| unknown_kind(map))
}
