//! The classes as a look-up table.

use visloc_core::hue_saturation_brightness;

use super::{ColorConfig, ColorSource, GoalColors, carpet_color::CarpetColor};

visloc_core::worded_enum! {
    /// What the color of a pixel says.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    #[repr(u8)]
    pub enum ColorClass {
        /// None of the others.
        Unknown = "unknown",
        /// Carpet.
        Green = "green",
        /// Learned carpet's color mixed with a little gray: a line if it is bright beside the carpet, else carpet.
        PaleGreen = "pale green",
        /// Another green than the carpet's.
        OtherGreen = "other green",
        /// Colorless: a line if it is bright beside the carpet, else wall, shadow or gray.
        Neutral = "gray",
        /// Colorless and bright beside the carpet.
        White = "white",
        /// Yellow goal.
        Yellow = "yellow",
        /// Blue goal.
        Blue = "blue",
        /// Ball.
        Orange = "orange",
    }

    /// The word for it.
    name
}

/// Bits of each color channel that choose an entry: 32,768 entries fit in a small cache.
const BITS: u32 = 5;
const SHIFT: u32 = 8 - BITS;

/// A class for every entry: of a known number, so that no look-up has to check its bounds.
type Classes = [ColorClass; 1 << (3 * BITS)];

/// The class of every color, 32 levels a channel. [`ColorClass::White`] is not in it: it depends on the carpet.
#[derive(Debug, Clone)]
pub struct ColorTable {
    classes: Box<Classes>,
    /// Entries that are green whatever the carpet's own green is.
    greens: Box<[u16]>,
    carpet_tolerance: f32,
    /// White if the luma is above the carpet's luma times this, in 1/256, and this more.
    white_over_green_256: u32,
    white_above_green: u32,
    is_learned: bool,
}

/// Learned white is brighter than three times the scatter of the carpet explains, at least a twentieth of its luma, and of the noise of a
/// pixel, two levels. Four mean deviations are three standard deviations.
const LEARNED_WHITE_OVER_GREEN: f64 = 1.15;
const LEARNED_WHITE_ABOVE_GREEN: u32 = 6;
const LEARNED_MEAN_DEVIATIONS: u32 = 4;

impl ColorTable {
    /// The table of a calibration that has been checked.
    pub fn new(config: &ColorConfig, goals: GoalColors) -> Self {
        let is_learned = config.source == ColorSource::Learned;
        let goals = if is_learned { goals } else { GoalColors::default() };
        let mut classes: Box<Classes> = Box::new([ColorClass::Unknown; _]);
        let mut greens = Vec::new();
        for (entry, class) in (0..).zip(classes.iter_mut()) {
            *class = class_of(config, goals, rgb_of(entry));
            greens.extend((*class == ColorClass::Green).then_some(entry));
        }
        Self {
            greens: greens.into(),
            classes,
            carpet_tolerance: config.carpet_tolerance as f32,
            white_over_green_256: ((if is_learned {
                LEARNED_WHITE_OVER_GREEN
            } else {
                config.white_over_green
            }) * 256.0)
                .round() as u32,
            white_above_green: if is_learned { LEARNED_WHITE_ABOVE_GREEN } else { 0 },
            is_learned,
        }
    }

    /// Whether the carpet's color is learned.
    pub(crate) fn is_learned(&self) -> bool {
        self.is_learned
    }

    /// From now on carpet, and what may be white beside it, is what a learned color says.
    pub(crate) fn follow(&mut self, carpet: &CarpetColor) {
        let levels = 1_usize << BITS;
        for sum in 0..=3 * (levels - 1) {
            // All entries of a brightness have the same noise.
            let Some(test) = carpet.at_brightness(((sum << SHIFT) + 3 * (1 << (SHIFT - 1))) as f64) else {
                continue;
            };
            for r in sum.saturating_sub(2 * (levels - 1))..=sum.min(levels - 1) {
                let rest = sum - r;
                for g in rest.saturating_sub(levels - 1)..=rest.min(levels - 1) {
                    let entry = (r << (2 * BITS)) | (g << BITS) | (rest - g);
                    let class = &mut self.classes[entry];
                    if matches!(class, ColorClass::Yellow | ColorClass::Blue | ColorClass::Orange) {
                        continue;
                    }
                    let rgb = rgb_of(entry as u16);
                    *class = test.class(rgb);
                }
            }
        }
    }

    /// Class of a color; never [`ColorClass::White`] or [`ColorClass::PaleGreen`].
    #[inline]
    pub fn class(&self, r: u8, g: u8, b: u8) -> ColorClass {
        match self.classes[entry_of([r, g, b])] {
            ColorClass::PaleGreen => ColorClass::Green,
            class => class,
        }
    }

    /// From now on only greens near that of the carpet are [`ColorClass::Green`]; others are [`ColorClass::OtherGreen`].
    pub fn narrow_green(&mut self, carpet: Shares) {
        for entry in &self.greens {
            let rgb = rgb_of(*entry);
            // Colors of a dark entry differ by more, since all its levels are so near to 0.
            let rounding = f32::from(1_u8 << (SHIFT - 2)) / rgb.iter().map(|v| f32::from(*v)).sum::<f32>();
            let is_carpet = shares(rgb).difference(carpet) <= f64::from(self.carpet_tolerance + rounding);
            self.classes[usize::from(*entry)] =
                if is_carpet { ColorClass::Green } else { ColorClass::OtherGreen };
        }
    }

    /// Class of a color beside carpet of the given luma.
    #[inline]
    pub fn class_beside_carpet(&self, rgb: [u8; 3], white_threshold: u32) -> ColorClass {
        self.class_beside(rgb, || white_threshold)
    }

    /// The same, of a threshold that is only asked for if the color may be white.
    #[inline]
    pub(crate) fn class_beside(&self, rgb: [u8; 3], white_threshold: impl FnOnce() -> u32) -> ColorClass {
        let class = self.classes[entry_of(rgb)];
        if !matches!(class, ColorClass::Neutral | ColorClass::PaleGreen) {
            class
        } else if luma(rgb) >= white_threshold() {
            ColorClass::White
        } else if class == ColorClass::PaleGreen {
            ColorClass::Green
        } else {
            ColorClass::Neutral
        }
    }

    /// Luma from which a colorless pixel beside carpet of this luma is white.
    #[inline]
    pub fn white_threshold(&self, green_luma: u32) -> u32 {
        ((green_luma * self.white_over_green_256) >> 8) + self.white_above_green
    }

    /// The same beside carpet whose luma has this mean deviation, in 1/16: what is learned counts it.
    #[inline]
    pub(crate) fn white_threshold_beside(&self, green_luma: u32, deviation_16: u32) -> u32 {
        let least = self.white_threshold(green_luma);
        if !self.is_learned {
            return least;
        }
        least.max(green_luma + LEARNED_MEAN_DEVIATIONS * deviation_16 / 16 + self.white_above_green)
    }
}

/// Shares of red and green in the sum of a color's levels: what is left of a color without its brightness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Of red, 0 to 1.
    pub red: f32,
    /// Of green, 0 to 1.
    pub green: f32,
}

impl Shares {
    /// The larger one of the differences of both shares.
    pub(crate) fn difference(self, other: Self) -> f64 {
        f64::from((self.red - other.red).abs().max((self.green - other.green).abs()))
    }

    /// A part of the way to another color.
    pub(crate) fn toward(self, other: Self, part: f64) -> Self {
        let part = part as f32;
        let mix = |a: f32, b: f32| a + (b - a) * part;
        Self { red: mix(self.red, other.red), green: mix(self.green, other.green) }
    }
}

/// Shares of a color; of black those of gray.
pub(crate) fn shares(rgb: [u8; 3]) -> Shares {
    let [r, g, b] = rgb.map(f32::from);
    let sum = r + g + b;
    if sum == 0.0 {
        return Shares { red: 1.0 / 3.0, green: 1.0 / 3.0 };
    }
    Shares { red: r / sum, green: g / sum }
}

/// Place of a color in the table.
#[inline]
fn entry_of([r, g, b]: [u8; 3]) -> usize {
    (usize::from(r >> SHIFT) << (2 * BITS)) | (usize::from(g >> SHIFT) << BITS) | usize::from(b >> SHIFT)
}

/// The color in the middle of an entry.
fn rgb_of(entry: u16) -> [u8; 3] {
    let level = |shift: u32| ((((entry >> shift) & ((1 << BITS) - 1)) as u8) << SHIFT) + (1 << (SHIFT - 1));
    [level(2 * BITS), level(BITS), level(0)]
}

/// Brightness as people see it, 0 to 255.
#[inline]
pub(crate) fn luma(rgb: [u8; 3]) -> u32 {
    (2 * u32::from(rgb[0]) + 5 * u32::from(rgb[1]) + u32::from(rgb[2])) >> 3
}

fn class_of(config: &ColorConfig, goals: GoalColors, rgb: [u8; 3]) -> ColorClass {
    let (hue, saturation, brightness) = hue_saturation_brightness(rgb);
    let colored = [
        (true, config.orange, ColorClass::Orange),
        (goals.yellow, config.yellow, ColorClass::Yellow),
        (goals.blue, config.blue, ColorClass::Blue),
        (true, config.green, ColorClass::Green),
    ];
    for (exists, range, class) in colored {
        if exists && range.contains(hue, saturation, brightness) {
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
        let table = ColorTable::new(&ColorConfig::default(), GoalColors::default());
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
        let table = ColorTable::new(&ColorConfig::default(), GoalColors::default());
        let gray = [120, 120, 118];
        assert_eq!(table.class_beside_carpet(gray, table.white_threshold(50)), ColorClass::White);
        assert_eq!(table.class_beside_carpet(gray, table.white_threshold(110)), ColorClass::Neutral);
    }
}
