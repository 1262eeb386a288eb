//! The image analysis that a map needs.

use visloc_core::{Frame, Rng};
use visloc_world::{
    Map,
    field::{Field, GoalColor},
    office::Office,
};

use super::{FeatureChoice, PipelineConfig};
use crate::{
    ConfigError,
    vision::{
        AnalysisError, Percept,
        color::{ColorConfig, ColorSource, GoalColors},
        field::{FeatureDetectionConfig, FieldAnalysisConfig, FieldAnalyzer},
        office::{OfficeAnalyzer, OfficeColors},
    },
};

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
    pub fn percept(&self) -> &Percept {
        match self {
            Self::Field(analyzer) => analyzer.percept(),
            Self::Office(analyzer) => analyzer.percept(),
        }
    }
}

pub(super) fn unknown_kind(map: &Map) -> ConfigError {
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
