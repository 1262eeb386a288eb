//! What the file of a building says.

use serde::{Deserialize, Deserializer, Serialize, de::Error};

use super::SurfaceColor;

/// A building. All lengths in meters, in the frame of the map, z up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OfficePlan {
    /// Always `office`.
    pub kind: String,
    /// Name of the map.
    pub name: String,
    /// Height of the rooms; only pictures and the simulator need it.
    #[serde(default = "default_ceiling_height_m")]
    pub ceiling_height_m: f64,
    /// Color of all walls.
    #[serde(default = "default_wall_color")]
    pub wall_color: SurfaceColor,
    /// Color of the floor.
    #[serde(default = "default_floor_color")]
    pub floor_color: SurfaceColor,
    /// Floors with walls all around. Without any, the floor is what the walls enclose.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub corridors: Vec<CorridorPlan>,
    /// Walls that stand by themselves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<WallPlan>,
    /// Doors in these walls.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doors: Vec<DoorPlan>,
}

/// A floor with walls all around. Outlines may have other outlines inside, such as pillars or courtyards: what lies in
/// an even number of outlines is not floor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorridorPlan {
    /// The corners in order, either way around.
    #[serde(deserialize_with = "pairs")]
    pub outline: Vec<[f64; 2]>,
    /// Sides without a wall: the known floor ends there, and nobody knows what comes behind. Side k goes from corner k to
    /// the next one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open_sides: Vec<usize>,
}

impl CorridorPlan {
    /// A floor with walls all around.
    pub fn closed(outline: Vec<[f64; 2]>) -> Self {
        Self { outline, open_sides: Vec::new() }
    }
}

/// A wall that stands by itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallPlan {
    /// One end (x, y).
    #[serde(deserialize_with = "pair")]
    pub from: [f64; 2],
    /// The other end (x, y).
    #[serde(deserialize_with = "pair")]
    pub to: [f64; 2],
    /// From where it is seen.
    #[serde(default)]
    pub sides: WallSides,
}

/// From where a wall is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WallSides {
    /// From both sides.
    #[default]
    Both,
    /// From the right of somebody who walks from its first to its second end.
    Right,
}

/// A door, or the hole in the wall if it stands open.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorPlan {
    /// One edge (x, y), on a wall.
    #[serde(deserialize_with = "pair")]
    pub from: [f64; 2],
    /// The other edge (x, y), on the same wall.
    #[serde(deserialize_with = "pair")]
    pub to: [f64; 2],
    /// From the floor to the upper edge.
    #[serde(default = "default_door_height_m")]
    pub height_m: f64,
    /// Its color.
    #[serde(default = "default_door_color")]
    pub color: SurfaceColor,
    /// Whether it always stands open. Its color is not seen then, nor is a wall.
    #[serde(default)]
    pub is_open: bool,
}

/// As an array, but more than two numbers are a mistake instead of passed over.
fn pair<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    let found = Vec::deserialize(deserializer)?;
    found.try_into().map_err(|found: Vec<f64>| {
        D::Error::custom(format!("expected x and y in meters, found {} numbers", found.len()))
    })
}

/// [`pair`] by pair.
fn pairs<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<[f64; 2]>, D::Error> {
    #[derive(Deserialize)]
    struct Pair(#[serde(deserialize_with = "pair")] [f64; 2]);
    Ok(Vec::<Pair>::deserialize(deserializer)?.into_iter().map(|pair| pair.0).collect())
}

pub(super) fn default_ceiling_height_m() -> f64 {
    2.6
}

pub(super) fn default_door_height_m() -> f64 {
    2.05
}

pub(super) fn default_wall_color() -> SurfaceColor {
    SurfaceColor::WHITE
}

pub(super) fn default_floor_color() -> SurfaceColor {
    SurfaceColor::YELLOW
}

pub(super) fn default_door_color() -> SurfaceColor {
    SurfaceColor::RED
}

/// What a map file calls a building.
pub(super) const OFFICE: &str = "office";

impl OfficePlan {
    /// A building without walls, to be filled.
    pub fn named(name: &str) -> Self {
        Self {
            kind: OFFICE.to_owned(),
            name: name.to_owned(),
            ceiling_height_m: default_ceiling_height_m(),
            wall_color: default_wall_color(),
            floor_color: default_floor_color(),
            corridors: Vec::new(),
            walls: Vec::new(),
            doors: Vec::new(),
        }
    }

    /// The text of a map file.
    ///
    /// # Errors
    /// If a value cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self)
    }
}
