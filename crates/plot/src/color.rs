//! Colors that stay apart for color-blind people.

use std::fmt;

/// An opaque color.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Color {
    red: u8,
    green: u8,
    blue: u8,
}

impl Color {
    /// Truth.
    pub const BLACK: Self = Self::rgb(0x1a, 0x1a, 0x1a);
    /// Background and field lines.
    pub const WHITE: Self = Self::rgb(0xff, 0xff, 0xff);
    /// Secondary text, reference lines.
    pub const GRAY: Self = Self::rgb(0x6b, 0x6b, 0x6b);
    /// First series.
    pub const BLUE: Self = Self::rgb(0x00, 0x72, 0xb2);
    /// Second series.
    pub const VERMILION: Self = Self::rgb(0xd5, 0x5e, 0x00);
    /// Third series.
    pub const PURPLE: Self = Self::rgb(0xb0, 0x4a, 0x8a);
    /// Fourth series.
    pub const BLUISH_GREEN: Self = Self::rgb(0x00, 0x9e, 0x73);
    /// Fifth series.
    pub const ORANGE: Self = Self::rgb(0xe6, 0x9f, 0x00);
    /// Sixth series.
    pub const SKY_BLUE: Self = Self::rgb(0x56, 0xb4, 0xe9);

    /// The second six are the first, darker.
    const SERIES: [Self; 12] = [
        Self::BLUE,
        Self::VERMILION,
        Self::PURPLE,
        Self::BLUISH_GREEN,
        Self::ORANGE,
        Self::SKY_BLUE,
        Self::rgb(0x00, 0x3f, 0x62),
        Self::rgb(0x75, 0x34, 0x00),
        Self::rgb(0x61, 0x29, 0x4c),
        Self::rgb(0x00, 0x57, 0x3f),
        Self::rgb(0x7e, 0x57, 0x00),
        Self::rgb(0x2f, 0x63, 0x80),
    ];

    /// From its parts, 0 to 255 each.
    pub const fn rgb(red: u8, green: u8, blue: u8) -> Self {
        Self { red, green, blue }
    }

    /// Red, green and blue, 0 to 255 each.
    pub const fn parts(self) -> [u8; 3] {
        [self.red, self.green, self.blue]
    }

    /// Color of the series with the given index. After twelve series the colors repeat.
    ///
    /// Source: the palette of M. Okabe and K. Ito, "Color Universal Design" (2008). Deviations: the purple is darker,
    /// to stand out from a white background as a thin line; yellow is left out for the same reason.
    pub const fn series(index: usize) -> Self {
        Self::SERIES[index % Self::SERIES.len()]
    }

    /// Which series has this color, if one has.
    pub(crate) fn series_index(self) -> Option<usize> {
        Self::SERIES.iter().position(|color| *color == self)
    }

    /// Color of `fraction` in [0, 1] on a scale from dark violet over green to yellow, whose lightness rises evenly.
    /// Fractions outside are clamped; not a number gives the color of 0.
    ///
    /// Source: ten steps of the color map "viridis" of matplotlib (CC0), linear in between.
    pub fn scale(fraction: f64) -> Self {
        let position = fraction.clamp(0.0, 1.0) * 10.0;
        let lower = (position as usize).min(9);
        let share = if position.is_finite() { position - lower as f64 } else { 0.0 };
        VIRIDIS[lower].mix(VIRIDIS[lower + 1], share)
    }

    /// Between this (`share` 0) and `other` (`share` 1).
    pub(crate) fn mix(self, other: Self, share: f64) -> Self {
        let part = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * share).round() as u8;
        Self::rgb(part(self.red, other.red), part(self.green, other.green), part(self.blue, other.blue))
    }
}

impl Default for Color {
    /// Black.
    fn default() -> Self {
        Self::BLACK
    }
}

impl fmt::Display for Color {
    /// As SVG writes it: `#rrggbb`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.red, self.green, self.blue)
    }
}

const VIRIDIS: [Color; 11] = [
    Color::rgb(0x44, 0x01, 0x54),
    Color::rgb(0x48, 0x24, 0x75),
    Color::rgb(0x41, 0x44, 0x87),
    Color::rgb(0x35, 0x5f, 0x8d),
    Color::rgb(0x2a, 0x78, 0x8e),
    Color::rgb(0x21, 0x91, 0x8c),
    Color::rgb(0x22, 0xa8, 0x84),
    Color::rgb(0x44, 0xbf, 0x70),
    Color::rgb(0x7a, 0xd1, 0x51),
    Color::rgb(0xbd, 0xdf, 0x26),
    Color::rgb(0xfd, 0xe7, 0x25),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_is_clamped_and_gets_lighter() {
        assert_eq!(Color::scale(-1.0), Color::scale(0.0));
        assert_eq!(Color::scale(f64::NAN), Color::scale(0.0));
        assert_eq!(Color::scale(2.0).to_string(), "#fde725");
        let lightness = |i: i32| {
            let [r, g, b] = Color::scale(f64::from(i) / 20.0).parts().map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((0..20).all(|i| lightness(i) < lightness(i + 1)));
    }

    #[test]
    fn first_series_have_different_colors() {
        for i in 0..12 {
            assert!((0..i).all(|j| Color::series(i) != Color::series(j)));
        }
        assert_eq!(Color::series(12), Color::series(0));
    }
}
