//! Colors of walls, floors and doors.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};
use visloc_core::hue_saturation_brightness;

/// Names that a file may use, with the color that is meant.
const NAMED: [(&str, [u8; 3]); 11] = [
    ("white", [235, 234, 228]),
    ("gray", [128, 128, 128]),
    ("black", [24, 24, 24]),
    ("red", [176, 39, 31]),
    ("orange", [226, 122, 28]),
    ("yellow", [216, 181, 58]),
    ("green", [52, 138, 66]),
    ("cyan", [40, 150, 160]),
    ("blue", [36, 76, 168]),
    ("purple", [116, 52, 140]),
    ("brown", [120, 76, 40]),
];

/// The color of a surface in white light: a name such as `red`, or `#rrggbb`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct SurfaceColor {
    /// Red, green, blue.
    pub rgb: [u8; 3],
}

impl SurfaceColor {
    /// White walls.
    pub const WHITE: Self = Self { rgb: NAMED[0].1 };
    /// Red doors.
    pub const RED: Self = Self { rgb: NAMED[3].1 };
    /// A yellow floor.
    pub const YELLOW: Self = Self { rgb: NAMED[5].1 };

    /// Whether the color is too gray to have a hue that a camera can see in any light.
    pub fn is_gray(&self) -> bool {
        hue_saturation_brightness(self.rgb).1 < 0.3
    }

    /// Whether a camera can tell two surfaces apart in any light: one is gray and the other is not, or their hues are
    /// at least 25 degrees apart.
    pub fn differs_from(&self, other: &Self) -> bool {
        if self.is_gray() || other.is_gray() {
            return self.is_gray() != other.is_gray();
        }
        let [own, others] = [self, other].map(|color| hue_saturation_brightness(color.rgb).0);
        let apart = (own - others).rem_euclid(360.0);
        apart.min(360.0 - apart) >= 25.0
    }
}

impl FromStr for SurfaceColor {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((_, rgb)) = NAMED.iter().find(|(name, _)| *name == text) {
            return Ok(Self { rgb: *rgb });
        }
        let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6);
        let value = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()).ok_or_else(|| {
            format!(
                "expected a color such as #b0271f or one of {}, found {text:?}",
                NAMED.map(|n| n.0).join(", ")
            )
        })?;
        let [_, r, g, b] = value.to_be_bytes();
        Ok(Self { rgb: [r, g, b] })
    }
}

impl TryFrom<String> for SurfaceColor {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<SurfaceColor> for String {
    fn from(color: SurfaceColor) -> Self {
        color.to_string()
    }
}

impl fmt::Display for SurfaceColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((name, _)) = NAMED.iter().find(|(_, rgb)| *rgb == self.rgb) {
            return f.write_str(name);
        }
        let [r, g, b] = self.rgb;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_written_as_they_are_read() {
        for text in ["red", "white", "#12a0ff"] {
            assert_eq!(text.parse::<SurfaceColor>().unwrap().to_string(), text);
        }
        assert!("rde".parse::<SurfaceColor>().unwrap_err().contains("red"));
        assert!("#12".parse::<SurfaceColor>().is_err());
    }

    #[test]
    fn what_a_camera_can_tell_apart() {
        let color = |text: &str| text.parse::<SurfaceColor>().unwrap();
        assert!(color("red").differs_from(&color("white")) && color("red").differs_from(&color("yellow")));
        assert!(!color("white").differs_from(&color("gray")));
        assert!(!color("red").differs_from(&color("#b03020")));
    }
}
