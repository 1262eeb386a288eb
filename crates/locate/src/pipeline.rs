//! Image analysis, lift detector and localizer for the frames of one robot.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;
use visloc_base::{Frame, Rng, RngTree};
use visloc_vision::{
    AnalysisError, Percept,
    field::{FeatureDetectionConfig, FieldAnalysisConfig, FieldAnalysisConfigError, FieldAnalyzer},
};
use visloc_world::{
    Map,
    field::{Field, GoalColor},
};

use crate::{
    ConfigError, Estimate, LiftConfig, LiftDetector, Localizer, StartPrior, StepInput, build_localizer,
    observation::field::{FieldFeatureModel, FieldModelConfig, FieldObservationModel},
    refine::{Refined, RefinementConfig},
};

/// Parameters of everything but the algorithm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PipelineConfig {
    /// Image analysis.
    pub analysis: FieldAnalysisConfig,
    /// Observation model.
    pub observation: FieldModelConfig,
    /// Lift detector.
    pub lift: LiftConfig,
    /// What the pose is computed from.
    pub features: FeatureChoice,
    /// Tracks that refine what the algorithm finds, with rich features.
    pub refinement: RefinementConfig,
}

/// What the pose is computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureChoice {
    /// Twenty pixels, as in the documents.
    Pixels,
    /// The algorithm finds places by twenty pixels; all border pixels refine them.
    #[default]
    Rich,
}

/// A pipeline that cannot be built.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The algorithm or one of its parameters.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A parameter of the image analysis.
    #[error(transparent)]
    Analysis(#[from] FieldAnalysisConfigError),
}

/// From frames to estimates. The two halves are separate calls, so that a caller can time them and show the percept.
pub struct Pipeline {
    analyzer: FieldAnalyzer,
    lift: LiftDetector,
    localizer: Box<dyn Localizer>,
    analysis_rng: Rng,
    localizer_rng: Rng,
}

impl Pipeline {
    /// A pipeline for a map. `algorithm_toml` overrides parameters of the algorithm.
    ///
    /// # Errors
    /// If there is no such algorithm or a parameter is unknown or out of its range.
    pub fn new(
        map: &Map,
        algorithm: &str,
        algorithm_toml: Option<&str>,
        config: &PipelineConfig,
        rng: RngTree,
    ) -> Result<Self, PipelineError> {
        let Map::Field(field) = map else {
            return Err(ConfigError::Value {
                key: "map".to_owned(),
                expected: "a RoboCup field",
                found: map.name().to_owned(),
            }
            .into());
        };
        config.lift.check()?;
        let model = FieldObservationModel::new(field, &config.observation)?;
        let mut localizer = build_localizer(algorithm, algorithm_toml, Box::new(model.clone()))?;
        if config.features == FeatureChoice::Rich {
            let features = Box::new(FieldFeatureModel::new(field));
            localizer = Box::new(Refined::new(config.refinement, localizer, features, Box::new(model))?);
        }
        Ok(Self {
            analyzer: FieldAnalyzer::new(analysis_for(field, config))?,
            lift: LiftDetector::new(config.lift),
            localizer,
            analysis_rng: rng.stream("analysis", 0),
            localizer_rng: rng.stream("localizer", 0),
        })
    }

    /// First half: the image.
    ///
    /// # Errors
    /// If the image does not belong to its calibration. The frame can be left out and the run go on.
    pub fn analyze(&mut self, frame: &Frame) -> Result<&Percept, AnalysisError> {
        self.analyzer.analyze(frame, &mut self.analysis_rng)
    }

    /// Second half: the pose, from the percept of the last [`Pipeline::analyze`].
    pub fn localize(&mut self, frame: &Frame) -> &Estimate {
        let is_lifted = self.lift.update(frame.at, frame.ground_contact.as_ref());
        let input = StepInput { percept: self.analyzer.percept(), odometry: frame.odometry, is_lifted };
        self.localizer.step(&input, &mut self.localizer_rng)
    }

    /// Begins again with what is known about the pose, for instance the half in which the robot is put down.
    pub fn reset_to(&mut self, prior: &StartPrior) {
        self.localizer.reset_to(prior);
    }

    /// The image analysis, for pictures of what it found.
    #[must_use]
    pub fn analyzer(&self) -> &FieldAnalyzer {
        &self.analyzer
    }

    /// The localizer, for pictures of its particles.
    #[must_use]
    pub fn localizer(&self) -> &dyn Localizer {
        self.localizer.as_ref()
    }
}

/// On a field without colored goals so many line pixels make an image informative.
const MIN_LINES_ALONE: usize = 10;

/// Lines, circle, marks and posts have the map's sizes, and lines are visible farther away on a larger field than the
/// documents' 6 m. Composite features are looked for only if something uses them.
#[must_use]
pub fn analysis_for(field: &Field, config: &PipelineConfig) -> FieldAnalysisConfig {
    let (d, analysis) = (field.dimensions(), config.analysis);
    let scale = (d.length_m / 6.0).max(1.0);
    let has_colored_goals = field.goals().iter().any(|goal| goal.color != GoalColor::White);
    FieldAnalysisConfig {
        max_line_distance_m: analysis.max_line_distance_m * scale,
        line_width_m: d.line_width_m,
        min_informative_lines: if has_colored_goals {
            analysis.min_informative_lines
        } else {
            MIN_LINES_ALONE
        },
        composite: FeatureDetectionConfig {
            is_on: analysis.composite.is_on && config.features == FeatureChoice::Rich,
            circle_radius_m: field.circle_radius_m(),
            mark_size_m: d.penalty_mark_size_m,
            post_diameter_m: d.goals.post_diameter_m,
            has_white_goals: field.goals().iter().any(|goal| goal.color == GoalColor::White),
        },
        ..analysis
    }
}
