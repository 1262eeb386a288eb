//! Image analysis, lift detector and localizer for the frames of one robot.

mod builder;
mod photo;

pub use builder::PipelineBuilder;
pub use photo::{Photo, PhotoAnswer, PhotoError, PhotoPose, locate_photo};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::{
    Clock, Frame, Rng, RngTree,
    settings::{Parameter, check_ranges},
};
use visloc_world::{
    Map,
    field::{Field, GoalColor},
    office::Office,
};

use crate::{
    Algorithm, ConfigError, Estimate, LiftConfig, LiftDetector, Localizer, ObservationModel, StartPrior,
    StepInput,
    algorithm::{in_building, refinement_defaults},
    observation::{
        features::FeatureModel,
        field::{FieldFeatureModel, FieldModelConfig, FieldObservationModel},
        office::{OfficeFeatureModel, OfficeModelConfig, OfficeObservationModel},
    },
    per_camera::OtherCameras,
    refine::{Refined, RefinementConfig},
    vision::{
        AnalysisError, Percept,
        color::{ColorConfig, ColorSource, GoalColors},
        field::{FeatureDetectionConfig, FieldAnalysisConfig, FieldAnalyzer},
        office::{OfficeAnalysisConfig, OfficeAnalyzer, OfficeColors},
    },
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
    #[must_use]
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
    /// Twenty pixels and the color table, as in the documents.
    Pixels,
    /// The algorithm finds places by twenty pixels; all border pixels refine them.
    #[default]
    Rich,
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
    /// The image analysis of a map.
    ///
    /// # Errors
    /// If a parameter is out of its range, or the map is of a kind that has none.
    pub fn new(map: &Map, config: &PipelineConfig) -> Result<Self, ConfigError> {
        match map {
            Map::Field(field) => {
                let analyzer = FieldAnalyzer::new(analysis_for(field, config))?;
                Ok(Self::Field(Box::new(analyzer)))
            }
            Map::Office(office) => {
                let analyzer = OfficeAnalyzer::new(config.office.analysis, &colors_of(office))?;
                Ok(Self::Office(Box::new(analyzer)))
            }
            other => Err(unknown_kind(other)),
        }
    }

    /// Looks at an image.
    ///
    /// # Errors
    /// If the image does not belong to its calibration.
    pub fn analyze(&mut self, frame: &Frame, rng: &mut Rng) -> Result<&Percept, AnalysisError> {
        match self {
            Self::Field(analyzer) => analyzer.analyze(frame, rng),
            Self::Office(analyzer) => analyzer.analyze(frame, rng),
        }
    }

    /// The same for another camera, of whose images it has learned nothing.
    #[must_use]
    pub fn anew(&self) -> Self {
        match self {
            Self::Field(analyzer) => Self::Field(Box::new(analyzer.anew())),
            Self::Office(analyzer) => Self::Office(Box::new(analyzer.anew())),
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

/// From frames to estimates: image analysis, lift detector and localizer of one robot with any number of cameras, whose frames come one after the
/// other: see [`Frame::camera_index`].
pub struct Pipeline {
    /// That of the last frame's camera.
    analyzer: ImageAnalyzer,
    camera_index: usize,
    other_analyzers: OtherCameras<ImageAnalyzer>,
    lift: LiftDetector,
    localizer: Box<dyn Localizer>,
    analysis_rng: Rng,
    localizer_rng: Rng,
    clock: Clock,
    times: StepTimes,
}

/// How long the last step took, by the clock of the pipeline.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StepTimes {
    /// Image analysis, milliseconds.
    pub analysis_ms: f64,
    /// Lift detector and localizer, milliseconds.
    pub localizer_ms: f64,
}

impl Pipeline {
    /// Settings of a pipeline for a map. By default: the evolutionary algorithm, which knows nothing of the pose, with seed 1.
    #[must_use]
    pub fn builder(map: &Map) -> PipelineBuilder<'_> {
        PipelineBuilder::new(map)
    }

    pub(crate) fn new(
        map: &Map,
        algorithm: Algorithm,
        config: &PipelineConfig,
        rng: RngTree,
        clock: Clock,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let parts = WorldParts::new(map, config)?;
        let mut localizer = algorithm.build(parts.model)?;
        if let Some(rich) = parts.rich {
            localizer = Box::new(Refined::new(rich.config, localizer, rich.features, rich.pixels)?);
        }
        Ok(Self {
            analyzer: ImageAnalyzer::new(map, config)?,
            camera_index: 0,
            other_analyzers: OtherCameras::none(),
            lift: LiftDetector::new(config.lift),
            localizer,
            analysis_rng: rng.stream("analysis", 0),
            localizer_rng: rng.stream("localizer", 0),
            clock,
            times: StepTimes::default(),
        })
    }

    /// Takes in the next frame: looks at its image, and at the robot's pose.
    ///
    /// # Errors
    /// If the image does not belong to its calibration. The frame is left out then, and the run can go on.
    pub fn step(&mut self, frame: &Frame) -> Result<&Estimate, AnalysisError> {
        let start = self.clock.secs();
        let cameras = (self.camera_index, frame.camera_index);
        self.other_analyzers.look_through(&mut self.analyzer, cameras, ImageAnalyzer::anew);
        self.camera_index = frame.camera_index;
        self.analyzer.analyze(frame, &mut self.analysis_rng)?;
        let analyzed = self.clock.secs();
        let is_lifted = self.lift.update(frame.at, frame.ground_contact.as_ref());
        let input = StepInput { percept: self.analyzer.percept(), odometry: frame.odometry, is_lifted };
        self.localizer.step(&input, &mut self.localizer_rng);
        let end = self.clock.secs();
        self.times =
            StepTimes { analysis_ms: (analyzed - start) * 1e3, localizer_ms: (end - analyzed) * 1e3 };
        Ok(self.localizer.estimate())
    }

    /// What the last step found in the image.
    #[must_use]
    pub fn percept(&self) -> &Percept {
        self.analyzer.percept()
    }

    /// The answer after the last step.
    #[must_use]
    pub fn estimate(&self) -> &Estimate {
        self.localizer.estimate()
    }

    /// How long the last step took.
    #[must_use]
    pub fn times(&self) -> StepTimes {
        self.times
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
    let parameters = algorithm_on(map, algorithm, features, algorithm_toml)?.parameters();
    parameters.map_err(|error| ConfigError::from_settings(algorithm, error))
}

/// An algorithm with the parameters that suit a map, and those that a text overrides.
pub(crate) fn algorithm_on(
    map: &Map,
    name: &str,
    features: FeatureChoice,
    toml: Option<&str>,
) -> Result<Algorithm, ConfigError> {
    let algorithm = Algorithm::named(name)?.on_map(map, features);
    let changed = toml.map_or(Ok(algorithm), |text| algorithm.with_toml(text));
    changed.map_err(|error| ConfigError::from_settings(name, error))
}

impl Algorithm {
    /// The same with what suits a map: in a building many places look alike, which needs more hypotheses.
    #[must_use]
    pub fn on_map(self, map: &Map, features: FeatureChoice) -> Self {
        match map {
            Map::Office(_) => in_building(self, features == FeatureChoice::Rich),
            _ => self,
        }
    }
}

/// What is different from world to world.
struct WorldParts {
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
    fn new(map: &Map, config: &PipelineConfig) -> Result<Self, ConfigError> {
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
            features: Box::new(FieldFeatureModel::new(field)),
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

fn unknown_kind(map: &Map) -> ConfigError {
    let (expected, found) = ("a field or a building", map.name().to_owned());
    ConfigError::Value { key: "map".to_owned(), expected, found }
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
    let has = |color| field.goals().iter().any(|goal| goal.color == color);
    let goal_colors = GoalColors { yellow: has(GoalColor::Yellow), blue: has(GoalColor::Blue) };
    let has_colored_goals = goal_colors.yellow || goal_colors.blue;
    let source = match config.features {
        FeatureChoice::Pixels => ColorSource::Table,
        FeatureChoice::Rich => analysis.colors.source,
    };
    FieldAnalysisConfig {
        colors: ColorConfig { source, ..analysis.colors },
        goal_colors,
        max_line_distance_m: analysis.max_line_distance_m * scale,
        line_width_m: d.line_width_m,
        goal_height_m: d.goals.inner_height_m + d.goals.post_diameter_m / 2.0,
        min_informative_lines: analysis
            .min_informative_lines
            .or((!has_colored_goals).then_some(MIN_LINES_ALONE)),
        composite: FeatureDetectionConfig {
            is_on: analysis.composite.is_on && config.features == FeatureChoice::Rich,
            circle_radius_m: field.circle_radius_m(),
            mark_size_m: d.penalty_mark_size_m,
            post_diameter_m: d.goals.post_diameter_m,
            has_white_goals: has(GoalColor::White),
        },
        ball_diameter_m: d.ball_diameter_m,
        ..analysis
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};
    use visloc_core::settings::{Settings, overlay, parameters};

    use super::*;

    /// Another value than that of a parameter.
    fn other(parameter: &Parameter) -> Value {
        let moved = |value: f64| match parameter.range {
            Some((least, most)) if value + 0.01 * (most - least) > most => value - 0.01 * (most - least),
            Some((least, most)) => value + 0.01 * (most - least),
            None => value * 1.01 + 0.001,
        };
        match &parameter.value {
            Value::Bool(is_on) => json!(!is_on),
            Value::Number(number) if number.is_u64() => json!(number.as_u64().unwrap() + 1),
            Value::Number(number) => json!(moved(number.as_f64().unwrap())),
            Value::String(name) => json!(parameter.choices.iter().find(|c| c.name != *name).unwrap().name),
            Value::Array(all) => {
                let first = all[0].as_f64().unwrap();
                json!([json!(first * 0.99)].iter().chain(&all[1..]).collect::<Vec<_>>())
            }
            _ => json!(7),
        }
    }

    /// Every key of some parameters that counts beside the others, set to something else, with the parameters that it leads to.
    fn each_changed<T: Settings>(defaults: &T) -> Vec<(String, T)> {
        let all = parameters(defaults).unwrap();
        assert!(all.len() > 5);
        let change = |parameter: &Parameter| {
            let text = format!("{} = {}", parameter.path, other(parameter));
            match overlay(defaults, &text) {
                Err(error) if error.reason.contains("it would change nothing") => {
                    assert!(parameter.only_if.is_some(), "{error}");
                    None
                }
                changed => {
                    Some((parameter.path.clone(), changed.unwrap_or_else(|error| panic!("{text}: {error}"))))
                }
            }
        };
        all.iter().filter_map(change).collect()
    }

    /// What the parts of a pipeline are given on a map.
    fn effective(map: &Map, config: &PipelineConfig) -> String {
        let Map::Field(field) = map else { panic!() };
        let analysis = analysis_for(field, config);
        format!(
            "{analysis:?} {:?} {:?} {:?} {:?} {:?}",
            config.observation, config.lift, config.features, config.refinement, config.office
        )
    }

    /// No key is accepted and ignored: on every kind of field each one changes what the parts are given.
    #[test]
    fn every_key_of_the_pipeline_has_an_effect() {
        for name in ["robocup-spl-2010", "robocup-spl-2024"] {
            let map = Map::load(name).unwrap();
            let before = effective(&map, &PipelineConfig::default());
            for (path, config) in each_changed(&PipelineConfig::default()) {
                assert_ne!(effective(&map, &config), before, "{name}: {path} is ignored");
            }
        }
    }

    #[test]
    fn what_the_map_says_is_refused_with_the_reason() {
        let refused = |text: &str| overlay(&PipelineConfig::default(), text).unwrap_err().reason;
        let keys = ["line_width_m", "goal_height_m", "composite.circle_radius_m", "composite.mark_size_m"];
        for key in keys.into_iter().chain(["composite.post_diameter_m", "composite.has_white_goals"]) {
            let reason = refused(&format!("analysis.{key} = 1.0"));
            assert!(reason.contains("cannot be set: the map says"), "{reason}");
        }
        assert_eq!(
            refused("[analysis]\nline_width_m = 0.1"),
            "`analysis.line_width_m` cannot be set: the map says how wide lines are"
        );
    }

    /// A number of line pixels that the user gives holds on every field, also 0.
    #[test]
    fn the_user_says_what_is_informative() {
        for name in ["robocup-spl-2010", "robocup-spl-2024"] {
            let Map::Field(field) = Map::load(name).unwrap() else { panic!() };
            for lines in [0, 4] {
                let text = format!("analysis.min_informative_lines = {lines}");
                let config = overlay(&PipelineConfig::default(), &text).unwrap();
                assert_eq!(analysis_for(&field, &config).min_informative_lines, Some(lines), "{name}");
            }
        }
    }

    /// Each parameter of each algorithm reaches it, or is refused by a limit that it has with another one.
    #[test]
    fn every_key_of_every_algorithm_changes_it() {
        let map = Map::load("robocup-spl-2010").unwrap();
        for algorithm in crate::ALGORITHMS {
            let all = algorithm_parameters(&map, algorithm.name, FeatureChoice::Rich, None).unwrap();
            for parameter in &all {
                let text = format!("{} = {}", parameter.path, other(parameter));
                match algorithm_parameters(&map, algorithm.name, FeatureChoice::Rich, Some(&text)) {
                    Ok(changed) => assert_ne!(changed, all, "{}: {text}", algorithm.name),
                    Err(error) => {
                        assert!(parameter.only_if.is_some(), "{}: {text}: {error}", algorithm.name);
                        assert!(error.to_string().contains("it would change nothing"), "{error}");
                    }
                }
            }
        }
    }
}
