//! Every parameter, with unit, default and source.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A parameter that cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The text is not TOML, or has a key that does not exist.
    #[error("{0}")]
    Parse(#[from] toml::de::Error),
    /// A value is out of its range.
    #[error("{key}: expected {expected}, found {found}")]
    Range {
        /// Name of the parameter.
        key: &'static str,
        /// What is allowed.
        expected: &'static str,
        /// What was given.
        found: String,
    },
}

/// All parameters of the system. "Thesis" is the doctoral thesis of 2017, "program" its published program.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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

/// Images and corners.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FeatureConfig {
    /// Levels of the image pyramid. Thesis: 5.
    pub pyramid_levels: usize,
    /// Levels on which corners are detected and landmarks are searched. Program: 3.
    pub search_levels: usize,
    /// FAST threshold, gray levels. Thesis: 10.
    pub fast_threshold: u8,
    /// FAST threshold of a second pass over cells that stay empty; found by trial on rooms of low texture.
    pub low_fast_threshold: u8,
    /// Least Shi-Tomasi score of a corner of the first pass, squared gray levels per pixel.
    pub min_score: f32,
    /// Least Shi-Tomasi score of a corner of the second pass.
    pub low_min_score: f32,
    /// Side of a cell that gets at most one new corner, pixels.
    pub cell_px: f64,
}

/// The first two keyframes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StartConfig {
    /// Fewest corners, and fewest points of the first map. Program: 50.
    pub min_points: usize,
    /// Median shift of the corners before a start is tried, pixels. Thesis: 10 to 20.
    pub min_shift_px: f64,
    /// Least median parallax, degrees.
    pub min_parallax_deg: f64,
    /// Least share of corners that must agree on one motion.
    pub min_inlier_ratio: f64,
    /// Share of the corners below which the start begins again from the newest image.
    pub min_followed_ratio: f64,
    /// Largest Sampson distance of an inlier, pixels.
    pub inlier_px: f64,
    /// Random samples for each of the two models.
    pub num_samples: usize,
    /// Frames after which the start begins again from the newest image.
    pub max_frames: usize,
}

/// Frame to frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrackingConfig {
    /// Finest level of the image alignment. Program: 2.
    pub finest_align_level: usize,
    /// Most iterations of the image alignment on each level. Program: 30.
    pub max_align_iterations: usize,
    /// Keyframes whose landmarks are searched.
    pub max_local_keyframes: usize,
    /// Side of a cell in which at most one landmark is matched, pixels. Program: 32.
    pub cell_px: f64,
    /// Matches after which the search ends. Program: 150 to 300.
    pub max_matches: usize,
    /// Fewest matches of a frame that is not bad. Thesis: 20; robust weights make fewer enough.
    pub min_matches: usize,
    /// Share of the searched landmarks that a good frame finds. Thesis: 0.2.
    pub min_match_ratio: f64,
    /// Bad frames in a row after which the camera is lost. Thesis: 3.
    pub max_bad_frames: usize,
    /// Whether outliers are rejected by random samples (the document's configurations); robust weights always are.
    pub reject_outliers: bool,
    /// Most hypotheses of the rejection. Thesis: 100.
    pub max_hypotheses: usize,
}

/// Keyframes, landmarks and bundle adjustment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MappingConfig {
    /// Frames after which a keyframe is made once `soft_lost_ratio` is reached. Thesis: 30.
    pub soft_gap_frames: usize,
    /// Share of the last keyframe's landmarks that must be lost then. Thesis: 0.1.
    pub soft_lost_ratio: f64,
    /// Share of lost landmarks that asks for a keyframe at once. Thesis: 0.3; less, so that turns are survived.
    pub lost_ratio: f64,
    /// Mean shift of the landmarks since the last keyframe that asks for a keyframe, share of the image's width.
    pub max_shift_ratio: f64,
    /// Fewest frames between keyframes.
    pub min_gap_frames: usize,
    /// Connected keyframes in which new corners are searched. Program: 5.
    pub search_keyframes: usize,
    /// Most new candidates of a keyframe.
    pub max_new_candidates: usize,
    /// Searches in a row without success after which a candidate is dropped.
    pub max_candidate_misses: u32,
    /// Keyframes after which a candidate that has not converged is dropped. Program: 10.
    pub max_candidate_age: usize,
    /// Relative standard deviation of the depth at which a candidate becomes a landmark.
    pub max_depth_deviation: f64,
    /// Whether bundles are adjusted (the document's configurations).
    pub adjust_bundles: bool,
    /// Keyframes adjusted together. Program: 11.
    pub bundle_keyframes: usize,
    /// Iterations before outliers are dropped. Thesis: 5.
    pub bundle_first_iterations: usize,
    /// Iterations after that. Thesis: 10.
    pub bundle_last_iterations: usize,
    /// Most keyframes of the map; beyond, the one farthest from the camera is removed. Program: 100 to 1000.
    pub max_keyframes: usize,
    /// Share of a keyframe's landmarks that others must see for it to be redundant.
    pub redundant_ratio: f64,
}

/// Finding the camera again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RelocationConfig {
    /// Keyframes tried in each frame, most similar first.
    pub max_tries: usize,
    /// Fewest matches. Thesis: 20.
    pub min_matches: usize,
}

impl Default for FeatureConfig {
    fn default() -> Self {
        Self {
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

impl Default for StartConfig {
    fn default() -> Self {
        Self {
            min_points: 50,
            min_shift_px: 8.0,
            min_parallax_deg: 0.9,
            min_inlier_ratio: 0.6,
            min_followed_ratio: 0.4,
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
        Self { max_tries: 1, min_matches: 20 }
    }
}

impl SlamConfig {
    /// Reads and checks a TOML text; keys that are missing keep their defaults.
    ///
    /// # Errors
    /// If the text is not TOML, a key does not exist, or a value is out of range.
    pub fn from_toml(text: &str) -> Result<Self, ConfigError> {
        let config: Self = toml::from_str(text)?;
        config.check()?;
        Ok(config)
    }

    /// Checks all ranges.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let (f, s, t, m, r) = (&self.features, &self.start, &self.tracking, &self.mapping, &self.relocation);
        in_range("features.pyramid_levels", f.pyramid_levels, 1, 8)?;
        in_range("features.search_levels", f.search_levels, 1, f.pyramid_levels)?;
        in_range("start.min_points", s.min_points, 10, 10_000)?;
        in_range("tracking.max_local_keyframes", t.max_local_keyframes, 1, 100)?;
        in_range("tracking.max_matches", t.max_matches, t.min_matches, 10_000)?;
        in_range("tracking.min_matches", t.min_matches, 4, 10_000)?;
        in_range("tracking.max_bad_frames", t.max_bad_frames, 1, 1000)?;
        in_range("mapping.bundle_keyframes", m.bundle_keyframes, 2, 100)?;
        in_range("mapping.max_keyframes", m.max_keyframes, 3, 1_000_000)?;
        in_range("relocation.max_tries", r.max_tries, 1, 1000)?;
        for (key, value) in [
            ("features.cell_px", f.cell_px),
            ("tracking.cell_px", t.cell_px),
            ("start.min_parallax_deg", s.min_parallax_deg),
            ("start.inlier_px", s.inlier_px),
            ("mapping.max_depth_deviation", m.max_depth_deviation),
            ("mapping.max_shift_ratio", m.max_shift_ratio),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ConfigError::Range {
                    key,
                    expected: "a number above 0",
                    found: value.to_string(),
                });
            }
        }
        for (key, value) in [
            ("start.min_inlier_ratio", s.min_inlier_ratio),
            ("start.min_followed_ratio", s.min_followed_ratio),
            ("tracking.min_match_ratio", t.min_match_ratio),
            ("mapping.soft_lost_ratio", m.soft_lost_ratio),
            ("mapping.lost_ratio", m.lost_ratio),
            ("mapping.redundant_ratio", m.redundant_ratio),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return Err(ConfigError::Range {
                    key,
                    expected: "a number from 0 to 1",
                    found: value.to_string(),
                });
            }
        }
        Ok(())
    }
}

fn in_range(key: &'static str, value: usize, least: usize, most: usize) -> Result<(), ConfigError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(ConfigError::Range {
        key,
        expected: "a whole number in its range",
        found: format!("{value}, outside of {least} to {most}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_survive_a_round_trip() {
        let config = SlamConfig::default();
        config.check().unwrap();
        let text = toml::to_string(&config).unwrap();
        assert_eq!(SlamConfig::from_toml(&text).unwrap(), config);
    }

    #[test]
    fn wrong_keys_and_values_are_named() {
        let error = SlamConfig::from_toml("[tracking]\nmin_machtes = 3").unwrap_err().to_string();
        assert!(error.contains("min_machtes"), "{error}");
        let error = SlamConfig::from_toml("[mapping]\nlost_ratio = 1.5").unwrap_err().to_string();
        assert!(error.contains("mapping.lost_ratio") && error.contains("1.5"), "{error}");
        assert!(SlamConfig::from_toml("[tracking]\ncell_px = nan").is_err());
    }
}
