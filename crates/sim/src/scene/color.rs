//! Colors as reflectance.

use serde::Deserialize;

/// How much of each part of the light (red, green, blue) a surface reflects, linear, 0 to 1. Written `"#rrggbb"` in
/// files, as a screen would show it under full light.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Color {
    linear: [f32; 3],
}

impl Color {
    /// From the usual six hexadecimal digits, for instance `0xd9c21a`.
    pub fn from_hex(rgb: u32) -> Self {
        let part = |shift: u32| srgb_to_linear(((rgb >> shift) & 0xff) as f32 / 255.0);
        Self { linear: [part(16), part(8), part(0)] }
    }

    /// Reflectance of red, green and blue, 0 to 1.
    pub fn linear(self) -> [f32; 3] {
        self.linear
    }

    /// This color with all parts multiplied.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        Self { linear: self.linear.map(|part| part * factor) }
    }
}

impl TryFrom<String> for Color {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6);
        digits
            .and_then(|digits| u32::from_str_radix(digits, 16).ok())
            .map(Self::from_hex)
            .ok_or_else(|| format!("expected a color like \"#d9c21a\", found {text:?}"))
    }
}

/// The decoding function of sRGB (IEC 61966-2-1).
fn srgb_to_linear(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// The encoding function of sRGB (IEC 61966-2-1).
pub(crate) fn linear_to_srgb(value: f32) -> f32 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_colors_round_trip_through_linear_light() {
        let [r, g, b] = Color::try_from("#d9c21a".to_owned()).unwrap().linear().map(linear_to_srgb);
        let close = |value: f32, byte: u8| (value * 255.0 - f32::from(byte)).abs() < 0.01;
        assert!(close(r, 0xd9) && close(g, 0xc2) && close(b, 0x1a));
    }

    #[test]
    fn other_texts_are_refused() {
        for text in ["d9c21a", "#d9c2", "#d9c21g", "red"] {
            assert!(Color::try_from(text.to_owned()).unwrap_err().contains(text));
        }
    }
}
