//! Parameters of the pipeline.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::check_ranges;

use crate::{
    ConfigError, LiftConfig,
    algorithm::refinement_defaults,
    observation::{field::FieldModelConfig, office::OfficeModelConfig},
    refine::RefinementConfig,
    vision::{color::ColorConfig, field::FieldAnalysisConfig, office::OfficeAnalysisConfig},
};

/// Parameters of everything but the algorithm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PipelineConfig {
    /// Image analysis on a field.
    pub analysis: FieldAnalysisConfig,
    /// Observation model of a field.
    pub observation: FieldModelConfig,
    /// Lift detector.
    pub lift: LiftConfig,
    /// What the pose is computed from.
    pub features: FeatureChoice,
    /// Tracks that refine what the algorithm finds, with rich features.
    pub refinement: RefinementConfig,
    /// What is different inside a building.
    pub office: OfficePipelineConfig,
}

impl PipelineConfig {
    /// The defaults with the documents' color table.
    pub fn with_color_table() -> Self {
        let analysis = FieldAnalysisConfig { colors: ColorConfig::table(), ..FieldAnalysisConfig::default() };
        Self { analysis, ..Self::default() }
    }

    /// Checks the ranges of all values, and those that must go together.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        self.refinement.reliability.check()?;
        self.office.refinement.reliability.check()
    }
}

visloc_core::with_defaults! {
    /// Parameters of the parts that are different inside a building.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct OfficePipelineConfig {
        /// Image analysis.
        pub analysis: OfficeAnalysisConfig = OfficeAnalysisConfig::default(),
        /// Observation model.
        pub observation: OfficeModelConfig = OfficeModelConfig::default(),
        /// Tracks, with rich features.
        pub refinement: RefinementConfig = refinement_defaults(),
    }
}

/// What the pose is computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureChoice {
    /// Twenty pixels and the color table, as in the documents.
    Pixels,
    /// The algorithm finds places by twenty pixels; all border pixels refine them.
    #[default]
    Rich,
}
