//! Image analysis, lift detector and localizer for the frames of one robot.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;
use visloc_base::{Frame, Rng, RngTree};
use visloc_settings::Parameter;
use visloc_vision::{
    AnalysisError, Percept,
    field::{FeatureDetectionConfig, FieldAnalysisConfig, FieldAnalysisConfigError, FieldAnalyzer},
    office::{OfficeAnalysisConfig, OfficeAnalysisConfigError, OfficeAnalyzer, OfficeColors},
};
use visloc_world::{
    Map,
    field::{Field, GoalColor},
    office::Office,
};

use crate::{
    ConfigError, Estimate, LiftConfig, LiftDetector, Localizer, ObservationModel, StartPrior, StepInput,
    observation::{
        features::FeatureModel,
        field::{FieldFeatureModel, FieldModelConfig, FieldObservationModel},
        office::{
            OfficeFeatureModel, OfficeModelConfig, OfficeObservationModel, algorithm_defaults,
            refined_algorithm_defaults, refinement_defaults,
        },
    },
    refine::{Refined, RefinementConfig},
    registry::{build_layered, describe_layered},
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

/// Parameters of the parts that are different inside a building.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OfficePipelineConfig {
    /// Image analysis.
    pub analysis: OfficeAnalysisConfig,
    /// Observation model.
    pub observation: OfficeModelConfig,
    /// Tracks, with rich features.
    pub refinement: RefinementConfig,
}

impl Default for OfficePipelineConfig {
    fn default() -> Self {
        Self {
            analysis: OfficeAnalysisConfig::default(),
            observation: OfficeModelConfig::default(),
            refinement: refinement_defaults(),
        }
    }
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
    /// A parameter of the image analysis inside a building.
    #[error(transparent)]
    OfficeAnalysis(#[from] OfficeAnalysisConfigError),
}

/// The image analysis of the map's kind of world.
#[derive(Debug)]
#[non_exhaustive]
pub enum ImageAnalyzer {
    /// On a field.
    Field(Box<FieldAnalyzer>),
    /// Inside a building.
    Office(Box<OfficeAnalyzer>),
}

impl ImageAnalyzer {
    fn analyze(&mut self, frame: &Frame, rng: &mut Rng) -> Result<&Percept, AnalysisError> {
        match self {
            Self::Field(analyzer) => analyzer.analyze(frame, rng),
            Self::Office(analyzer) => analyzer.analyze(frame, rng),
        }
    }

    /// The last percept.
    #[must_use]
    pub fn percept(&self) -> &Percept {
        match self {
            Self::Field(analyzer) => analyzer.percept(),
            Self::Office(analyzer) => analyzer.percept(),
        }
    }
}

/// From frames to estimates. The two halves are separate calls, so that a caller can time them and show the percept.
pub struct Pipeline {
    analyzer: ImageAnalyzer,
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
        config.lift.check()?;
        let parts = WorldParts::new(map, config)?;
        let layers = layers(map, algorithm, config.features, algorithm_toml);
        let mut localizer = build_layered(algorithm, &layers, parts.model)?;
        if let Some(rich) = parts.rich {
            localizer = Box::new(Refined::new(rich.config, localizer, rich.features, rich.pixels)?);
        }
        Ok(Self {
            analyzer: parts.analyzer,
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
    pub fn analyzer(&self) -> &ImageAnalyzer {
        &self.analyzer
    }

    /// The localizer, for pictures of its particles.
    #[must_use]
    pub fn localizer(&self) -> &dyn Localizer {
        self.localizer.as_ref()
    }
}

/// The parameters that an algorithm has on a map, one by one, with those that a text overrides.
///
/// # Errors
/// If there is no such algorithm or a parameter is unknown or out of its range.
pub fn algorithm_parameters(
    map: &Map,
    algorithm: &str,
    features: FeatureChoice,
    algorithm_toml: Option<&str>,
) -> Result<Vec<Parameter>, ConfigError> {
    describe_layered(algorithm, &layers(map, algorithm, features, algorithm_toml))
}

/// What lies over an algorithm's defaults: what is different in this world, then what the user says.
fn layers<'a>(
    map: &Map,
    algorithm: &str,
    features: FeatureChoice,
    algorithm_toml: Option<&'a str>,
) -> Vec<&'a str> {
    let is_office = matches!(map, Map::Office(_));
    let is_refined = features == FeatureChoice::Rich;
    let of_world = is_office.then(|| algorithm_defaults(algorithm)).flatten();
    let of_tracks = (is_office && is_refined).then(|| refined_algorithm_defaults(algorithm)).flatten();
    of_world.into_iter().chain(of_tracks).chain(algorithm_toml).collect()
}

/// What is different from world to world.
struct WorldParts {
    analyzer: ImageAnalyzer,
    model: Box<dyn ObservationModel>,
    /// What refines hypotheses, if that is wished for and the world has it.
    rich: Option<Rich>,
}

/// What refines hypotheses.
struct Rich {
    config: RefinementConfig,
    features: Box<dyn FeatureModel>,
    pixels: Box<dyn ObservationModel>,
}

impl WorldParts {
    fn new(map: &Map, config: &PipelineConfig) -> Result<Self, PipelineError> {
        match map {
            Map::Field(field) => Self::of_field(field, config),
            Map::Office(office) => Self::of_office(office, config),
            other => Err(ConfigError::Value {
                key: "map".to_owned(),
                expected: "a field or a building",
                found: other.name().to_owned(),
            }
            .into()),
        }
    }

    fn of_field(field: &Field, config: &PipelineConfig) -> Result<Self, PipelineError> {
        let analyzer = FieldAnalyzer::new(analysis_for(field, config))?;
        let model = FieldObservationModel::new(field, &config.observation)?;
        let rich = || Rich {
            config: config.refinement,
            features: Box::new(FieldFeatureModel::new(field)),
            pixels: Box::new(model.clone()),
        };
        let rich = (config.features == FeatureChoice::Rich).then(rich);
        Ok(Self { analyzer: ImageAnalyzer::Field(Box::new(analyzer)), model: Box::new(model), rich })
    }

    fn of_office(office: &Office, config: &PipelineConfig) -> Result<Self, PipelineError> {
        let analyzer = OfficeAnalyzer::new(config.office.analysis, &colors_of(office))?;
        let model = OfficeObservationModel::new(office, &config.office.observation)?;
        let rich = || Rich {
            config: config.office.refinement,
            features: Box::new(OfficeFeatureModel::new(&model)),
            pixels: Box::new(model.clone()),
        };
        let rich = (config.features == FeatureChoice::Rich).then(rich);
        Ok(Self { analyzer: ImageAnalyzer::Office(Box::new(analyzer)), model: Box::new(model), rich })
    }
}

/// Matches the features of images to a map, for whoever refines more than a pose.
///
/// # Errors
/// If the map is of a kind that has no such model.
pub fn feature_model(map: &Map, config: &PipelineConfig) -> Result<Box<dyn FeatureModel>, PipelineError> {
    let config = PipelineConfig { features: FeatureChoice::Rich, ..*config };
    let rich = WorldParts::new(map, &config)?.rich;
    rich.map(|rich| rich.features).ok_or_else(|| {
        ConfigError::Value {
            key: "map".to_owned(),
            expected: "a field or a building",
            found: map.name().to_owned(),
        }
        .into()
    })
}

/// The colors that the image analysis looks for.
fn colors_of(office: &Office) -> OfficeColors {
    OfficeColors {
        wall: office.plan().wall_color.rgb,
        floor: office.plan().floor_color.rgb,
        doors: office.door_colors().iter().map(|color| color.rgb).collect(),
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
        goal_height_m: d.goals.inner_height_m + d.goals.post_diameter_m / 2.0,
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
