//! The color classes as a person writes them: ranges of hue, saturation and brightness.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::check_ranges;

use crate::ConfigError;

/// One colored class: a range of hue, and how colorful and bright a pixel must be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HueRange {
    /// Start of the range on the color circle, degrees (red 0, yellow 60, green 120, blue 240).
    #[schemars(range(min = 0.0, max = 360.0))]
    pub from_deg: f64,
    /// End of the range, degrees; may be below `from_deg` to cross 0.
    #[schemars(range(min = 0.0, max = 360.0))]
    pub to_deg: f64,
    /// Least saturation, 0 (gray) to 1 (pure).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_saturation: f64,
    /// Least brightness (largest of red, green, blue), 0 to 255.
    #[schemars(range(min = 0.0, max = 255.0))]
    pub min_brightness: f64,
}

impl HueRange {
    /// Whether a color belongs to the class.
    pub fn contains(&self, hue_deg: f64, saturation: f64, brightness: f64) -> bool {
        let in_hue = if self.from_deg <= self.to_deg {
            (self.from_deg..=self.to_deg).contains(&hue_deg)
        } else {
            hue_deg >= self.from_deg || hue_deg <= self.to_deg
        };
        in_hue && saturation >= self.min_saturation && brightness >= self.min_brightness
    }
}

/// Where the color of the carpet comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ColorSource {
    /// From the ranges below: the documents' way, and that of `features = "pixels"`.
    Table,
    /// Learned from the ground near the robot, in any green and light; white is what is brighter than the carpet beside it and between
    /// its color and gray, goals have the ranges below if the map has goals of that color.
    #[default]
    Learned,
}

visloc_core::with_defaults! {
    /// Which colored goals there are.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct GoalColors {
        /// A yellow one.
        pub yellow: bool = true,
        /// A blue one.
        pub blue: bool = true,
    }
}

/// What a carpet can look like, in any light.
pub(super) const ANY_GREEN: HueRange =
    HueRange { from_deg: 50.0, to_deg: 190.0, min_saturation: 0.15, min_brightness: 0.0 };

/// All classes of a RoboCup field. Hue and saturation hardly change with brightness, and white is judged against the
/// carpet beside it, so one calibration holds under changing and uneven light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ColorConfig {
    /// Where the color of the carpet comes from. If it is learned, other values of `green`, `carpet_tolerance` and the limits of white are refused.
    pub source: ColorSource,
    /// The carpet.
    pub green: HueRange,
    /// The yellow goal.
    pub yellow: HueRange,
    /// The blue goal.
    pub blue: HueRange,
    /// The ball.
    pub orange: HueRange,
    /// The carpet's own color is learned from the ground near the robot. A green whose shares of red and green in the sum of its
    /// three levels differ from the carpet's by more than this is something else, 0 to 1; 1 to take every green for carpet.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub carpet_tolerance: f64,
    /// A line's pixels are at most this colorful, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub white_max_saturation: f64,
    /// A line is at least this many times as bright as the carpet beside it.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub white_over_green: f64,
}

impl Default for ColorConfig {
    fn default() -> Self {
        let hue = |from_deg, to_deg, min_saturation, min_brightness| HueRange {
            from_deg,
            to_deg,
            min_saturation,
            min_brightness,
        };
        Self {
            source: ColorSource::default(),
            green: hue(85.0, 185.0, 0.28, 22.0),
            yellow: hue(45.0, 70.0, 0.55, 45.0),
            blue: hue(200.0, 255.0, 0.5, 35.0),
            orange: hue(5.0, 32.0, 0.6, 60.0),
            carpet_tolerance: 0.06,
            white_max_saturation: 0.26,
            white_over_green: 1.35,
        }
    }
}

impl ColorConfig {
    /// Fixed classes, as in the documents.
    pub fn table() -> Self {
        Self { source: ColorSource::Table, ..Self::default() }
    }

    /// All colors that a carpet can have.
    pub fn carpet(&self) -> HueRange {
        match self.source {
            ColorSource::Table => self.green,
            ColorSource::Learned => ANY_GREEN,
        }
    }

    /// Checks the ranges of all values, and refuses limits of the table that would make no difference.
    ///
    /// # Errors
    /// The first of them.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        let (table, is_learned) = (Self::table(), self.source == ColorSource::Learned);
        let changed = [
            ("green", self.green != table.green),
            ("carpet_tolerance", self.carpet_tolerance != table.carpet_tolerance),
            ("white_max_saturation", self.white_max_saturation != table.white_max_saturation),
            ("white_over_green", self.white_over_green != table.white_over_green),
        ];
        match changed.into_iter().find(|(_, is_changed)| is_learned && *is_changed) {
            Some((key, _)) => Err(ConfigError::NoTable { key }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_the_table_need_the_table() {
        let mut config = ColorConfig { white_over_green: 1.2, ..ColorConfig::table() };
        assert_eq!(config.check(), Ok(()));
        config.source = ColorSource::Learned;
        assert_eq!(config.check(), Err(ConfigError::NoTable { key: "white_over_green" }));
        assert_eq!(ColorConfig::default().check(), Ok(()));
    }

    #[test]
    fn a_range_may_cross_zero() {
        let red = HueRange { from_deg: 350.0, to_deg: 10.0, min_saturation: 0.0, min_brightness: 0.0 };
        assert!(
            red.contains(355.0, 1.0, 100.0)
                && red.contains(5.0, 1.0, 100.0)
                && !red.contains(20.0, 1.0, 100.0)
        );
    }

    #[test]
    fn impossible_values_are_named() {
        let mut config = ColorConfig::default();
        config.check().unwrap();
        config.blue.min_saturation = 1.5;
        assert_eq!(
            config.check().unwrap_err().to_string(),
            "blue.min_saturation: expected 0 to 1, found 1.5"
        );
    }
}
