//! What makes real fields harder than simulated ones: factors that can be added to any scenario on a field, each with its random draws.

use rand::RngExt as _;
use serde::Deserialize;
use visloc_core::{Rng, RngTree, gaussian};
use visloc_world::Map;

use super::{BoxPiece, PersonSetup, PlacedPose, Scenario};
use crate::scene::{Color, Paint, Pattern};

/// One of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Factor {
    /// Turf of another green, rougher, with worn lines.
    Turf,
    /// Sun through windows: patches with hard borders on the carpet.
    Sun,
    /// Bright white walls without pictures.
    Walls,
    /// Shoes and bags on the field, tripods, markers, cartons and people beside it.
    Things,
    /// Dark corners of the image.
    Corners,
    /// An exposure that jumps.
    Exposure,
    /// A camera that is bolted on some degrees wrong.
    Mount,
}

impl Factor {
    /// All, with their names.
    pub const ALL: [(&str, Self); 7] = [
        ("turf", Self::Turf),
        ("sun", Self::Sun),
        ("walls", Self::Walls),
        ("things", Self::Things),
        ("corners", Self::Corners),
        ("exposure", Self::Exposure),
        ("mount", Self::Mount),
    ];

    /// Whether it is about the carpet of a field or what stands around it.
    pub(super) fn needs_field(self) -> bool {
        matches!(self, Self::Turf | Self::Sun | Self::Walls | Self::Things)
    }

    /// The factors of a list like `sun+turf`; `real` stands for all. The first name that is none of them is the error.
    pub(super) fn of_list(list: &str) -> Result<Vec<Self>, String> {
        let mut factors = Vec::new();
        for name in list.split('+') {
            match Self::ALL.iter().find(|known| known.0 == name) {
                Some((_, factor)) => factors.push(*factor),
                None if name == "real" => factors.extend(Self::ALL.map(|known| known.1)),
                None => return Err(name.to_owned()),
            }
        }
        Ok(factors)
    }
}

impl Scenario {
    /// The scenario with what its factors draw, and without factors.
    pub(crate) fn drawn(&self, random: &RngTree) -> Self {
        let mut drawn = Self { factors: Vec::new(), ..self.clone() };
        for factor in &self.factors {
            let rng = &mut random.stream("factor", *factor as u64);
            match factor {
                Factor::Turf => drawn.roll_out_turf(rng),
                Factor::Sun => {
                    drawn.carpet.sun = rng.random_range(1.8..4.0);
                    // The exposure lies between sun and shade.
                    drawn.camera.exposure_stops += 0.5 * f64::from(drawn.carpet.sun).log2();
                }
                Factor::Walls => {
                    if let Some(room) = &mut drawn.room {
                        room.wall_color = Color::from_hex(0xf6_f6f4);
                        room.posters_per_wall = 0;
                    }
                }
                Factor::Things => drawn.scatter_things(rng),
                Factor::Corners => drawn.camera.vignetting = rng.random_range(0.45..0.8),
                Factor::Exposure => drawn.camera.exposure_step_stops = rng.random_range(0.5..1.2),
                Factor::Mount => {
                    // Roll, pitch and yaw of robots whose heads were mounted by hand.
                    drawn.robot.kinematics.mount_deg = [1.0, 1.5, 0.3].map(|sigma| gaussian(rng, sigma));
                }
            }
        }
        drawn
    }

    fn roll_out_turf(&mut self, rng: &mut Rng) {
        let turfs = [0x5c_7a34, 0x6e_8a3c, 0x48_8a3a, 0x2e_6e50, 0x3f_6b2c, 0x70_9048];
        self.carpet.carpet =
            Color::from_hex(turfs[rng.random_range(0..turfs.len())]).scaled(rng.random_range(0.7..1.3));
        self.carpet.grain = rng.random_range(0.1..0.35);
        self.carpet.wear = rng.random_range(0.1..0.5);
    }

    fn scatter_things(&mut self, rng: &mut Rng) {
        // A map that cannot be loaded is told when the world is built.
        let Ok(Map::Field(field)) = Map::load(&self.map) else { return };
        let (half_x, half_y) = field.half_carpet_m();
        let flat = |rgb| Paint::flat(Color::from_hex(rgb));
        let mut put = |x_m, y_m, size_m, paint, rng: &mut Rng| {
            let at = PlacedPose { x_m, y_m, yaw_deg: rng.random_range(-180.0..180.0) };
            self.boxes.push(BoxPiece { at, bottom_m: 0.0, size_m, paint });
        };
        for _ in 0..4 {
            let (x, y) = (rng.random_range(-0.9..0.9) * half_x, rng.random_range(-0.9..0.9) * half_y);
            let paint = flat([0xee_eeec, 0x20_2024, 0xc8_c8c4][rng.random_range(0..3)]);
            put(x, y, [0.28, 0.1, 0.09], paint, rng);
        }
        // Around the carpet, on a random side.
        for i in 0..12 {
            let along = rng.random_range(-1.0..1.0);
            let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            let beside = rng.random_range(0.15..0.5);
            let (x, y) = if rng.random_bool(0.5) {
                (along * half_x, side * (half_y + beside))
            } else {
                (side * (half_x + beside), along * half_y)
            };
            match i % 4 {
                0 => put(x, y, [0.03, 0.03, 1.3], flat(0x1c_1c20), rng),
                1 => put(
                    x,
                    y,
                    [0.2, 0.02, 0.2],
                    Paint { pitch_m: 0.04, ..Paint::of(Pattern::Checker, Color::from_hex(0xf0_f0ee)) },
                    rng,
                ),
                2 => put(x, y, [0.4, 0.3, 0.35], flat(0xe8_e8e4), rng),
                _ => self.people.push(PersonSetup {
                    at: PlacedPose { x_m: x, y_m: y, yaw_deg: rng.random_range(-180.0..180.0) },
                    height_m: rng.random_range(1.5..1.95),
                    shirt: Color::from_hex(rng.random_range(0..0xff_ffff)),
                    trousers: Color::from_hex(rng.random_range(0..0xff_ffff)),
                }),
            }
        }
    }
}
