//! The classes as a look-up table.

use super::{ColorConfig, classes::hue_saturation_brightness};

/// What the color of a pixel says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ColorClass {
    /// None of the others.
    Unknown,
    /// Carpet.
    Green,
    /// Colorless: a line if it is bright beside the carpet, else wall, shadow or gray.
    Neutral,
    /// Colorless and bright beside the carpet.
    White,
    /// Yellow goal.
    Yellow,
    /// Blue goal.
    Blue,
    /// Ball.
    Orange,
}

const BITS: u32 = 5;
const SHIFT: u32 = 8 - BITS;

/// The class of every color, 32 levels a channel. [`ColorClass::White`] is not in it: it depends on the carpet.
#[derive(Debug, Clone)]
pub struct ColorTable {
    classes: Box<[ColorClass]>,
    /// White if the luma is above the carpet's luma times this, in 1/256.
    white_over_green_256: u32,
}

impl ColorTable {
    /// The table of a calibration that has been checked.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn new(config: &ColorConfig) -> Self {
        let level = |i: usize| ((i << SHIFT) + (1 << (SHIFT - 1))) as u8;
        let side = 1_usize << BITS;
        let mut classes = Vec::with_capacity(side * side * side);
        for r in 0..side {
            for g in 0..side {
                for b in 0..side {
                    classes.push(class_of(config, [level(r), level(g), level(b)]));
                }
            }
        }
        Self {
            classes: classes.into_boxed_slice(),
            white_over_green_256: (config.white_over_green * 256.0).round() as u32,
        }
    }

    /// Class of a color; never [`ColorClass::White`].
    #[inline]
    #[must_use]
    pub fn class(&self, r: u8, g: u8, b: u8) -> ColorClass {
        let index = (usize::from(r >> SHIFT) << (2 * BITS))
            | (usize::from(g >> SHIFT) << BITS)
            | usize::from(b >> SHIFT);
        self.classes[index]
    }

    /// Class of a color beside carpet of the given luma.
    #[inline]
    #[must_use]
    pub fn class_beside_carpet(&self, rgb: [u8; 3], white_threshold: u32) -> ColorClass {
        match self.class(rgb[0], rgb[1], rgb[2]) {
            ColorClass::Neutral if luma(rgb) >= white_threshold => ColorClass::White,
            class => class,
        }
    }

    /// Luma from which a colorless pixel beside carpet of this luma is white.
    #[inline]
    #[must_use]
    pub fn white_threshold(&self, green_luma: u32) -> u32 {
        (green_luma * self.white_over_green_256) >> 8
    }
}

/// Brightness as people see it, 0 to 255.
#[inline]
#[must_use]
pub(crate) fn luma(rgb: [u8; 3]) -> u32 {
    (2 * u32::from(rgb[0]) + 5 * u32::from(rgb[1]) + u32::from(rgb[2])) >> 3
}

fn class_of(config: &ColorConfig, rgb: [u8; 3]) -> ColorClass {
    let (hue, saturation, brightness) = hue_saturation_brightness(rgb);
    let colored = [
        (config.orange, ColorClass::Orange),
        (config.yellow, ColorClass::Yellow),
        (config.blue, ColorClass::Blue),
        (config.green, ColorClass::Green),
    ];
    for (range, class) in colored {
        if range.contains(hue, saturation, brightness) {
            return class;
        }
    }
    if saturation <= config.white_max_saturation { ColorClass::Neutral } else { ColorClass::Unknown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typical_colors_have_their_class() {
        let table = ColorTable::new(&ColorConfig::default());
        for (rgb, class) in [
            ([60, 140, 80], ColorClass::Green),
            ([30, 80, 45], ColorClass::Green),
            ([210, 190, 25], ColorClass::Yellow),
            ([105, 95, 14], ColorClass::Yellow),
            ([31, 79, 176], ColorClass::Blue),
            ([232, 100, 28], ColorClass::Orange),
            ([235, 236, 232], ColorClass::Neutral),
            ([90, 91, 90], ColorClass::Neutral),
        ] {
            assert_eq!(table.class(rgb[0], rgb[1], rgb[2]), class, "{rgb:?}");
        }
    }

    #[test]
    fn white_depends_on_the_carpet_beside_it() {
        let table = ColorTable::new(&ColorConfig::default());
        let gray = [120, 120, 118];
        assert_eq!(table.class_beside_carpet(gray, table.white_threshold(50)), ColorClass::White);
        assert_eq!(table.class_beside_carpet(gray, table.white_threshold(110)), ColorClass::Neutral);
    }
}
