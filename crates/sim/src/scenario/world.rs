//! The tables of what stands around: light, ball, furniture, boards, people, robots.

use serde::Deserialize;

use super::PlacedPose;
use crate::scene::{Color, FurnitureKind, Paint};

visloc_core::with_defaults! {
    /// The table `[light]`: regular lamps in the ceiling, unless `[[lamps]]` lists them.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct LightSetup {
        /// Lamps along x and along y.
        pub lamps: [u32; 2] = [4, 3],
        /// How much the lamps differ: each has a random strength from 1 - this to 1 + this. 0 to 1.
        pub unevenness: f32 = 0.2,
        /// Light from everywhere, as multiple of the lamps' mean light on the floor.
        pub ambient: f32 = 0.6,
        /// Color of all light, red, green and blue; white is 1, 1, 1. The camera has no white balance.
        pub color: [f32; 3] = white(),
        /// How the light changes while the robot walks.
        pub fade: Option<LightFade> = None,
    }
}

/// The table `[light.fade]`: the light goes from what `[light]` says to what stands here and back again, and so on.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightFade {
    /// Strength at the other end, as multiple of that of `[light]`.
    pub share: f32,
    /// Color at the other end.
    #[serde(default = "white")]
    pub color: [f32; 3],
    /// There and back, seconds.
    pub period_secs: f64,
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

/// All light at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LightNow {
    /// Strength, as multiple of that of `[light]`.
    pub share: f32,
    /// Red, green and blue.
    pub color: [f32; 3],
}

impl LightSetup {
    /// The light at a time since the start.
    pub(crate) fn at(&self, secs: f64) -> LightNow {
        let Some(fade) = &self.fade else { return LightNow { share: 1.0, color: self.color } };
        let there = 0.5 - 0.5 * (secs / fade.period_secs * std::f64::consts::TAU).cos();
        let there = there as f32;
        // Eyes and exposures see ratios, so strength and color change by equal ratios.
        let between = |from: f32, to: f32| from.powf(1.0 - there) * to.powf(there);
        LightNow {
            share: between(1.0, fade.share),
            color: std::array::from_fn(|i| between(self.color[i], fade.color[i])),
        }
    }
}

visloc_core::with_defaults! {
    /// The table `[ball]`. Without coordinates the ball lies at a random place.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Ball {
        /// Whether there is one.
        pub is_present: bool = true,
        /// Where, (x, y) in meters.
        pub at_m: Option<[f64; 2]> = None,
    }
}

/// An entry of `[[furniture]]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FurniturePiece {
    /// What it is.
    pub kind: FurnitureKind,
    /// Where; the front looks along the heading.
    pub at: PlacedPose,
}

/// An entry of `[[panels]]`: anything flat and upright, for instance a wall, a door or an advertising board.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// The left end for somebody who looks at it, (x, y) in meters.
    pub from_m: [f32; 2],
    /// The right end.
    pub to_m: [f32; 2],
    /// Height of the lower edge, meters.
    #[serde(default)]
    pub bottom_m: f32,
    /// From the lower to the upper edge, meters.
    pub height_m: f32,
    /// How it is painted.
    #[serde(default)]
    pub paint: Paint,
}

/// An entry of `[[boxes]]`: anything with six sides.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxPiece {
    /// Middle of the bottom and heading.
    pub at: PlacedPose,
    /// Height of the bottom, meters.
    #[serde(default)]
    pub bottom_m: f32,
    /// Length along its heading, width, height, meters.
    pub size_m: [f32; 3],
    /// How its sides are painted.
    #[serde(default)]
    pub paint: Paint,
}

/// An entry of `[[people]]`: somebody who stands and watches.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PersonSetup {
    /// Where, looking along the heading.
    pub at: PlacedPose,
    /// Height, meters.
    #[serde(default = "PersonSetup::usual_height_m")]
    pub height_m: f32,
    /// Color of the shirt.
    pub shirt: Color,
    /// Color of the trousers.
    pub trousers: Color,
}

impl PersonSetup {
    fn usual_height_m() -> f32 {
        1.75
    }
}

/// An entry of `[[robots]]`: another robot. It rests where `at` says; without that it walks on a random ellipse that
/// keeps clear of everything.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OtherRobot {
    /// Color of the jersey.
    pub jersey: Color,
    /// Where it rests.
    #[serde(default)]
    pub at: Option<PlacedPose>,
}
