//! Named sets of parameters.

use super::{ConfigError, Descriptor, SlamConfig};

/// A named set of parameters: one of the eight configurations of the thesis, or one for small computers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlamPreset {
    /// Name on the command line.
    pub name: &'static str,
    /// One line about it.
    pub summary: &'static str,
    /// What landmarks are recognized by.
    pub descriptor: Descriptor,
    /// Whether bundles are adjusted.
    pub adjust_bundles: bool,
    /// Whether outliers are rejected by random samples.
    pub reject_outliers: bool,
    /// Whether fewer landmarks and smaller bundles spare a small computer.
    pub is_small: bool,
}

use Descriptor::{Orb, Patches};

/// All presets. `config1` to `config8` are the configurations of the thesis, section 7.2.1; two of them have a name.
pub const PRESETS: [SlamPreset; 11] = [
    preset("sdvl", "patches, bundle adjustment, outlier rejection (config4)", (Patches, true, true)),
    preset("orb-sdvl", "ORB, bundle adjustment, outlier rejection (config8)", (Orb, true, true)),
    SlamPreset {
        is_small: true,
        ..preset(
            "small",
            "as sdvl with fewer landmarks and smaller bundles, for small computers",
            (Patches, true, true),
        )
    },
    preset("config1", "patches", (Patches, false, false)),
    preset("config2", "patches, outlier rejection", (Patches, false, true)),
    preset("config3", "patches, bundle adjustment", (Patches, true, false)),
    preset("config4", "patches, bundle adjustment, outlier rejection", (Patches, true, true)),
    preset("config5", "ORB", (Orb, false, false)),
    preset("config6", "ORB, outlier rejection", (Orb, false, true)),
    preset("config7", "ORB, bundle adjustment", (Orb, true, false)),
    preset("config8", "ORB, bundle adjustment, outlier rejection", (Orb, true, true)),
];

const fn preset(
    name: &'static str,
    summary: &'static str,
    (descriptor, adjust_bundles, reject_outliers): (Descriptor, bool, bool),
) -> SlamPreset {
    SlamPreset { name, summary, descriptor, adjust_bundles, reject_outliers, is_small: false }
}

impl SlamPreset {
    /// A preset by name.
    ///
    /// # Errors
    /// If there is none; the error lists the names.
    pub fn find(name: &str) -> Result<Self, ConfigError> {
        PRESETS.iter().find(|preset| preset.name == name).copied().ok_or_else(|| ConfigError::UnknownPreset {
            name: name.to_owned(),
            known: PRESETS.map(|preset| preset.name).join(", "),
        })
    }

    /// Its parameters: the defaults with its switches.
    #[must_use]
    pub fn config(&self) -> SlamConfig {
        let mut config = SlamConfig::default();
        config.features.descriptor = self.descriptor;
        config.mapping.adjust_bundles = self.adjust_bundles;
        config.tracking.reject_outliers = self.reject_outliers;
        if self.is_small {
            spare(&mut config);
        }
        config
    }
}

/// Less of everything that costs time with each image and each keyframe: a third of the landmarks in view, larger cells, smaller bundles.
fn spare(config: &mut SlamConfig) {
    config.features.cell_px = 28.0;
    config.tracking.cell_px = 28.0;
    config.tracking.max_matches = 80;
    config.tracking.max_local_keyframes = 6;
    config.mapping.max_new_candidates = 50;
    config.mapping.search_keyframes = 2;
    config.mapping.min_gap_frames = 5;
    config.mapping.bundle_keyframes = 5;
    config.mapping.bundle_first_iterations = 2;
    config.mapping.bundle_last_iterations = 4;
}

impl SlamConfig {
    /// Parameters of a preset.
    ///
    /// # Errors
    /// If there is none of that name; the error lists the names.
    pub fn preset(name: &str) -> Result<Self, ConfigError> {
        Ok(SlamPreset::find(name)?.config())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eight_configurations_differ_and_two_have_names() {
        let configs: Vec<SlamConfig> =
            (1..=8).map(|i| SlamConfig::preset(&format!("config{i}")).unwrap()).collect();
        for (i, config) in configs.iter().enumerate() {
            config.check().unwrap();
            assert!(configs[..i].iter().all(|other| other != config), "config{}", i + 1);
        }
        assert_eq!(SlamConfig::preset("sdvl").unwrap(), configs[3]);
        assert_eq!(SlamConfig::preset("orb-sdvl").unwrap(), configs[7]);
        assert_eq!(configs[3], SlamConfig::default(), "the defaults are those of sdvl");
    }

    #[test]
    fn the_small_preset_is_within_range_and_asks_for_less() {
        let (small, usual) = (SlamConfig::preset("small").unwrap(), SlamConfig::default());
        small.check().unwrap();
        assert!(small.tracking.max_matches < usual.tracking.max_matches);
        assert_eq!(small.features.descriptor, usual.features.descriptor);
    }

    #[test]
    fn an_unknown_preset_lists_the_known_ones() {
        let error = SlamConfig::preset("svdl").unwrap_err().to_string();
        assert!(error.contains("svdl") && error.contains("orb-sdvl, small, config1"), "{error}");
    }
}
