//! Colors; those of the studio's page in the dark.

/// Red, green, blue and opacity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color(pub [u8; 4]);

impl Color {
    /// Behind the world.
    pub const BACKGROUND: Self = Self::rgb(0x0f_14_1a);
    /// The robot.
    pub const TRUTH: Self = Self::rgb(0xff_ff_ff);
    /// What the truth of a camera looks like beside its estimate.
    pub const TRUE_WAY: Self = Self::rgb(0x4c_c3_8a);
    /// One for each algorithm.
    pub const LANES: [Self; 4] =
        [Self::rgb(0xff_9f_1c), Self::rgb(0x3e_c1_ff), Self::rgb(0xc7_92_ea), Self::rgb(0xff_6f_91)];
    /// One for each reason to drop a pixel, in the order of the filters.
    pub const DROPPED: [Self; 14] = [
        Self::rgb(0xe4_1a_1c),
        Self::rgb(0xff_7f_00),
        Self::rgb(0xf7_81_bf),
        Self::rgb(0xb0_65_c9),
        Self::rgb(0x5a_9b_d4),
        Self::rgb(0xc0_74_3a),
        Self::rgb(0x00_c8_c8),
        Self::rgb(0x8b_74_ff),
        Self::rgb(0xb3_36_5f),
        Self::rgb(0x6f_d3_5f),
        Self::rgb(0xc9_a6_4a),
        Self::rgb(0xd4_a3_ff),
        Self::rgb(0x4f_b6_c9),
        Self::rgb(0x9a_9a_9a),
    ];

    /// From `0xRRGGBB`, opaque.
    pub const fn rgb(value: u32) -> Self {
        let [_, red, green, blue] = value.to_be_bytes();
        Self([red, green, blue, 255])
    }

    /// From `#rrggbb`; gray for anything else.
    pub fn from_hex(text: &str) -> Self {
        let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6);
        let value = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
        value.map_or(Self::rgb(0x80_80_80), Self::rgb)
    }

    /// The color of an algorithm by its number.
    pub fn lane(number: usize) -> Self {
        Self::LANES[number % Self::LANES.len()]
    }

    /// The same nearer to black: 1 is as it is, 0 is black. Lines of the viewer have no opacity.
    #[must_use]
    pub fn dimmed(self, share: f32) -> Self {
        let [red, green, blue, opacity] = self.0;
        let dim = |value: u8| (f32::from(value) * share.clamp(0.0, 1.0)).round() as u8;
        Self([dim(red), dim(green), dim(blue), opacity])
    }
}
