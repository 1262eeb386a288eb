//! The parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::{check_ranges, commented_toml, overlay};

use super::ConfigError;
use crate::orb::{OrbSearch, Recognition};

/// All parameters of the system. "Thesis" is the doctoral thesis of 2017, "program" its published program.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SlamConfig {
    /// Images and corners.
    pub features: FeatureConfig,
    /// The first two keyframes.
    pub start: StartConfig,
    /// Frame to frame.
    pub tracking: TrackingConfig,
    /// Keyframes, landmarks and bundle adjustment.
    pub mapping: MappingConfig,
    /// Finding the camera again.
    pub relocation: RelocationConfig,
}

/// What a landmark is recognized by where its place is not known to a few pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Descriptor {
    /// Its patch of 8 x 8 pixels, by the squared difference without the mean.
    Patches,
    /// The ORB descriptor of FAST corners, by the number of different bits.
    Orb,
}

/// Images and corners.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FeatureConfig {
    /// What landmarks are recognized by; one of the three switches of the thesis' configurations, section 7.2.1.
    pub descriptor: Descriptor,
    /// Most bits of 256 in which ORB descriptors of the same landmark differ. Thesis: 100.
    #[schemars(range(min = 0, max = 256))]
    #[schemars(extend("x-only-if" = "descriptor = orb"))]
    pub max_orb_distance: u32,
    /// Distance from the predicted place (of a landmark) or line (of a candidate) within which ORB corners are compared,
    /// pixels of their level. Program: 6.
    #[schemars(range(min = 1.0, max = 50.0))]
    #[schemars(extend("x-only-if" = "descriptor = orb"))]
    pub orb_margin_px: f64,
    /// Levels of the image pyramid. Thesis: 5.
    #[schemars(range(min = 1, max = 8))]
    pub pyramid_levels: usize,
    /// Levels on which corners are detected and landmarks are searched. Program: 3.
    #[schemars(range(min = 1, max = 8))]
    pub search_levels: usize,
    /// FAST threshold, gray levels. Thesis: 10.
    #[schemars(range(min = 1, max = 100))]
    pub fast_threshold: u8,
    /// FAST threshold of a second pass over cells that stay empty, gray levels. By trial on rooms of low texture.
    #[schemars(range(min = 1, max = 100))]
    pub low_fast_threshold: u8,
    /// Least Shi-Tomasi score of a corner of the first pass, squared gray levels per squared pixel. Program: 50.
    #[schemars(range(min = 0.0, max = 100_000.0))]
    pub min_score: f32,
    /// The same for a corner of the second pass; the noise of the image may ask for more. By trial.
    #[schemars(range(min = 0.0, max = 100_000.0))]
    pub low_min_score: f32,
    /// Side of a cell that gets at most one new corner, pixels. Program: 32; finer by trial.
    #[schemars(range(min = 4.0, max = 1000.0))]
    pub cell_px: f64,
}

/// The first two keyframes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StartConfig {
    /// Fewest corners, and fewest points of the first map. Program: 50.
    #[schemars(range(min = 10, max = 10_000))]
    pub min_points: usize,
    /// Median shift of the corners before a start is tried, pixels. Thesis: 10 to 20.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub min_shift_px: f64,
    /// Least parallax, degrees; a quarter of the corners must have it. By trial; the thesis has no such gate. Images before a later
    /// start get their poses afterwards.
    #[schemars(range(min = 0.01, max = 45.0))]
    pub min_parallax_deg: f64,
    /// Least share of corners that must agree on one motion. By trial.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_inlier_ratio: f64,
    /// Share of the corners below which the start begins again from the newest image. By trial.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_followed_ratio: f64,
    /// Largest epipolar error of an inlier that was followed as exactly as any, pixels; in proportion of others. Program: 2.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub inlier_px: f64,
    /// Random samples for each of the two models. Program: 100.
    #[schemars(range(min = 1, max = 100_000))]
    pub num_samples: usize,
    /// Frames after which the start begins again from the newest image. By trial.
    #[schemars(range(min = 2, max = 100_000))]
    pub max_frames: usize,
}

/// Frame to frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrackingConfig {
    /// Finest level of the image alignment, 0 is the image itself. Program: 2.
    #[schemars(range(min = 0, max = 4))]
    pub finest_align_level: usize,
    /// Most iterations of the image alignment on each level. Program: 30.
    #[schemars(range(min = 1, max = 1000))]
    pub max_align_iterations: usize,
    /// Keyframes whose landmarks are searched. By trial; the program searches those of the last frame only.
    #[schemars(range(min = 1, max = 100))]
    pub max_local_keyframes: usize,
    /// Side of a cell in which at most one landmark is matched, pixels. Program: 32.
    #[schemars(range(min = 4.0, max = 1000.0))]
    pub cell_px: f64,
    /// Matches after which the search ends. Program: 150 to 300.
    #[schemars(range(min = 4, max = 10_000))]
    pub max_matches: usize,
    /// Fewest matches of a frame that is not bad. Thesis: 20; robust weights make fewer enough.
    #[schemars(range(min = 4, max = 10_000))]
    pub min_matches: usize,
    /// Share of the searched landmarks that a good frame finds. Thesis: 0.2.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_match_ratio: f64,
    /// Bad frames in a row after which the camera is lost. Thesis: 3.
    #[schemars(range(min = 1, max = 1000))]
    pub max_bad_frames: usize,
    /// Whether outliers are rejected by random samples; one of the three switches of the thesis' configurations, section 7.2.1.
    pub reject_outliers: bool,
    /// Whether the pose weighs matches by how well they fit. Without them and without the rejection every match counts fully, and
    /// things that move carry the pose away.
    pub robust_weights: bool,
    /// Most hypotheses of the rejection. Thesis: 100.
    #[schemars(range(min = 1, max = 100_000))]
    #[schemars(extend("x-only-if" = "reject_outliers = true"))]
    pub max_hypotheses: usize,
}

/// Keyframes, landmarks and bundle adjustment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MappingConfig {
    /// Frames after which a keyframe is made once `soft_lost_ratio` is reached. Thesis: 30.
    #[schemars(range(min = 1, max = 100_000))]
    pub soft_gap_frames: usize,
    /// Share of the last keyframe's landmarks that must be lost then. Thesis: 0.1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub soft_lost_ratio: f64,
    /// Share of lost landmarks that asks for a keyframe at once. Thesis: 0.3; less, so that turns are survived.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lost_ratio: f64,
    /// Mean shift of the landmarks since the last keyframe that asks for a keyframe, share of the image's width. By trial.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub max_shift_ratio: f64,
    /// Fewest frames between keyframes. By trial.
    #[schemars(range(min = 1, max = 100_000))]
    pub min_gap_frames: usize,
    /// Connected keyframes in which new corners are searched. Program: 5.
    #[schemars(range(min = 1, max = 100))]
    pub search_keyframes: usize,
    /// Most new candidates of a keyframe. By trial.
    #[schemars(range(min = 1, max = 10_000))]
    pub max_new_candidates: usize,
    /// Searches in a row without success after which a candidate is dropped. Program: 15.
    #[schemars(range(min = 1, max = 1000))]
    pub max_candidate_misses: u32,
    /// Keyframes after which a candidate that has not converged is dropped. Program: 10.
    #[schemars(range(min = 1, max = 100_000))]
    pub max_candidate_age: usize,
    /// Relative standard deviation of the depth at which a candidate becomes a landmark, beside the linearity index of the thesis.
    /// By trial.
    #[schemars(range(min = 0.0001, max = 1.0))]
    pub max_depth_deviation: f64,
    /// Whether bundles are adjusted; one of the three switches of the thesis' configurations, section 7.2.1.
    pub adjust_bundles: bool,
    /// Whether the first radial coefficient of the lens is estimated with the map. An addition: a calibration that is a little off
    /// changes the scale in every turn.
    #[schemars(extend("x-only-if" = "adjust_bundles = true"))]
    pub adjust_lens: bool,
    /// Keyframes adjusted together. Program: 11.
    #[schemars(range(min = 2, max = 100))]
    #[schemars(extend("x-only-if" = "adjust_bundles = true"))]
    pub bundle_keyframes: usize,
    /// Iterations before outliers are dropped. Thesis: 5.
    #[schemars(range(min = 1, max = 1000))]
    #[schemars(extend("x-only-if" = "adjust_bundles = true"))]
    pub bundle_first_iterations: usize,
    /// Iterations after that. Thesis: 10.
    #[schemars(range(min = 1, max = 1000))]
    #[schemars(extend("x-only-if" = "adjust_bundles = true"))]
    pub bundle_last_iterations: usize,
    /// Most keyframes of the map; beyond, the one farthest from the camera is removed. Program: 100 to 1000.
    #[schemars(range(min = 3, max = 1_000_000))]
    pub max_keyframes: usize,
    /// Share of a keyframe's landmarks that three others must see for it to be redundant. Program: 0.8.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub redundant_ratio: f64,
}

/// Finding the camera again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RelocationConfig {
    /// Keyframes tried in each frame, those that look most like it; in a taught map four times as many until one fits where pixels are
    /// larger than the map's. The thesis tries all.
    #[schemars(range(min = 1, max = 1000))]
    pub max_tries: usize,
    /// Fewest matches. Thesis: 20.
    #[schemars(range(min = 4, max = 10_000))]
    pub min_matches: usize,
    /// Time after a loss from which on a new map is started if the camera is not recognized, seconds.
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub new_map_secs: f64,
    /// Whether places that are seen again close loops and join maps. Without it only a camera that is lost is recognized, and the way
    /// drifts as that of odometry does.
    pub close_loops: bool,
}

impl Default for FeatureConfig {
    fn default() -> Self {
        Self {
            descriptor: Descriptor::Patches,
            max_orb_distance: 100,
            orb_margin_px: 6.0,
            pyramid_levels: 5,
            search_levels: 3,
            fast_threshold: 10,
            low_fast_threshold: 5,
            min_score: 40.0,
            low_min_score: 8.0,
            cell_px: 18.0,
        }
    }
}

impl FeatureConfig {
    /// How landmarks are recognized.
    #[must_use]
    pub fn recognition(&self) -> Recognition {
        match self.descriptor {
            Descriptor::Patches => Recognition::Patches,
            Descriptor::Orb => Recognition::Orb(OrbSearch {
                threshold: self.fast_threshold,
                max_distance: self.max_orb_distance,
                margin_px: self.orb_margin_px,
            }),
        }
    }
}

impl Default for StartConfig {
    fn default() -> Self {
        Self {
            min_points: 50,
            min_shift_px: 8.0,
            min_parallax_deg: 1.2,
            min_inlier_ratio: 0.6,
            min_followed_ratio: 0.25,
            inlier_px: 1.0,
            num_samples: 150,
            max_frames: 90,
        }
    }
}

impl Default for TrackingConfig {
    fn default() -> Self {
        Self {
            finest_align_level: 2,
            max_align_iterations: 10,
            max_local_keyframes: 12,
            cell_px: 18.0,
            max_matches: 250,
            min_matches: 12,
            min_match_ratio: 0.2,
            max_bad_frames: 3,
            reject_outliers: true,
            robust_weights: true,
            max_hypotheses: 100,
        }
    }
}

impl Default for MappingConfig {
    fn default() -> Self {
        Self {
            soft_gap_frames: 30,
            soft_lost_ratio: 0.1,
            lost_ratio: 0.2,
            max_shift_ratio: 0.06,
            min_gap_frames: 2,
            search_keyframes: 6,
            max_new_candidates: 250,
            max_candidate_misses: 8,
            max_candidate_age: 6,
            max_depth_deviation: 0.03,
            adjust_bundles: true,
            adjust_lens: true,
            bundle_keyframes: 12,
            bundle_first_iterations: 5,
            bundle_last_iterations: 10,
            max_keyframes: 400,
            redundant_ratio: 0.9,
        }
    }
}

impl Default for RelocationConfig {
    fn default() -> Self {
        Self { max_tries: 6, min_matches: 20, new_map_secs: 1.0, close_loops: true }
    }
}

impl SlamConfig {
    /// Reads and checks a TOML text; keys that are missing keep their defaults.
    ///
    /// # Errors
    /// If the text is not TOML, a key does not exist, or a value is out of range.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        Self::default().with_toml(text)
    }

    /// These parameters with what a TOML text says differently.
    ///
    /// # Errors
    /// If the text is not TOML, a key does not exist, or a value is out of range.
    pub fn with_toml(&self, text: &str) -> Result<Self, ConfigError> {
        let config = overlay(self, text)?;
        config.check()?;
        Ok(config)
    }

    /// All parameters as TOML, each with meaning, unit, source and range as a comment.
    ///
    /// # Errors
    /// If a value cannot be written as TOML.
    pub fn commented_toml(&self) -> Result<String, ConfigError> {
        Ok(commented_toml(self)?)
    }

    /// Checks all ranges, and values that must go together.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        let (f, t) = (&self.features, &self.tracking);
        at_most("features.search_levels", f.search_levels, ("features.pyramid_levels", f.pyramid_levels))?;
        at_most("tracking.min_matches", t.min_matches, ("tracking.max_matches", t.max_matches))
    }
}

fn at_most(key: &'static str, value: usize, (other, most): (&str, usize)) -> Result<(), ConfigError> {
    if value <= most {
        return Ok(());
    }
    Err(ConfigError::Relation {
        key,
        expected: format!("at most {most}, the value of {other}"),
        found: value.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_survive_a_round_trip() {
        let config = SlamConfig::default();
        config.check().unwrap();
        let text = config.commented_toml().unwrap();
        assert_eq!(SlamConfig::from_toml(&text).unwrap(), config);
        let lines: Vec<&str> = text.lines().collect();
        let is_value = |line: &str| line.contains(" = ") && !line.starts_with('#');
        let is_explained = |pair: &[&str]| !is_value(pair[1]) || pair[0].starts_with('#');
        assert!(lines.windows(2).all(is_explained), "{text}");
        assert!(text.contains("Thesis: 5. Range: 1 to 8.\npyramid_levels = 5\n"), "{text}");
    }

    #[test]
    fn wrong_keys_and_values_are_named() {
        let error = SlamConfig::from_toml("[tracking]\nmin_machtes = 3").unwrap_err().to_string();
        assert!(error.contains("min_machtes") && error.contains("did you mean `min_matches`?"), "{error}");
        let error = SlamConfig::from_toml("[mapping]\nlost_ratio = 1.5").unwrap_err().to_string();
        assert!(error.contains("mapping.lost_ratio") && error.contains("1.5"), "{error}");
        assert!(SlamConfig::from_toml("[tracking]\ncell_px = nan").is_err());
        let error = SlamConfig::from_toml("[features]\nsearch_levels = 7").unwrap_err().to_string();
        assert!(error.contains("features.search_levels") && error.contains("at most 5"), "{error}");
        let wrong = SlamConfig {
            tracking: TrackingConfig { max_bad_frames: 0, ..TrackingConfig::default() },
            ..SlamConfig::default()
        };
        let error = wrong.check().unwrap_err().to_string();
        assert!(error.contains("tracking.max_bad_frames") && error.contains("found 0"), "{error}");
    }
}
