//! What a file holds.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use visloc_slam::{
    Slam,
    atlas::Similarity,
    map::{Map, MapId},
};

use crate::{
    Damage,
    frame::{move_map, odom_from_map},
};

/// Maps of a place.
#[derive(Debug, Clone, Default)]
pub struct VisualMap {
    /// Keyframes and landmarks.
    pub map: Map,
    /// The scale of each map, in order of their numbers. Those that are not listed are unknown.
    pub scales: Vec<MapScale>,
    /// Whether z points up in each map, in order of their numbers; in those that are not listed x points to the right of the first image, y
    /// down and z ahead.
    pub levels: Vec<bool>,
    /// What it was made of, oldest first.
    pub sessions: Vec<Session>,
}

/// A map that was read.
#[derive(Debug, Clone, Default)]
pub struct OpenedMap {
    /// The map.
    pub map: VisualMap,
    /// What is damaged.
    pub damages: Vec<Damage>,
}

/// How long a map unit is.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct MapScale {
    /// Where it comes from.
    pub source: ScaleSource,
    /// Standard deviation of the scale as a share of it; 0 where nobody has said.
    pub relative_sigma: f64,
}

visloc_core::worded_enum! {
    /// Where the scale of a map comes from.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
    pub enum ScaleSource {
        /// A map unit is anything.
        #[default]
        Unknown = "unknown",
        /// Aligned to places that are known: a map unit is a meter.
        Aligned = "aligned to known places",
        /// Two points at a known distance: a map unit is a meter.
        TwoPoints = "two points of known distance",
        /// The height of the camera above the ground: a map unit is a meter.
        CameraHeight = "height of the camera",
        /// The odometry of the robot that the map was made on: a map unit is a meter, as far as the odometry has no error of scale.
        Odometry = "odometry of the robot",
        /// Somebody has said how long a map unit is: it is a meter now.
        Told = "told by somebody",
    }

    /// The words for it.
    name
}

/// A run that made or extended a map.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Session {
    /// The source of the images, as it was named.
    pub source: String,
    /// The program and its version.
    pub program: String,
    /// Images that were used.
    pub num_images: u64,
    /// Seed of everything random.
    pub seed: u64,
}

impl VisualMap {
    /// What a run of SLAM has made, or made of this map, which it began with: its keyframes, the scales, and the session. A map that was
    /// there keeps its frame and its scale, also when others were joined to it; any other has the scale that the odometry says, and the
    /// frame of the odometry then.
    #[must_use]
    pub fn after(self, slam: &Slam, session: Session) -> Self {
        let standings = standings_after(&self, slam);
        let mut map = slam.map().clone();
        for (id, standing) in &standings {
            if standing.scale.source == ScaleSource::Odometry
                && !standing.was_level
                && let Some(odom_from_map) = odom_from_map(&map, *id)
            {
                move_map(&mut map, *id, &odom_from_map);
            }
        }
        let mut sessions = self.sessions;
        sessions.push(session);
        Self {
            levels: standings
                .iter()
                .map(|(_, it)| it.was_level || it.scale.source == ScaleSource::Odometry)
                .collect(),
            scales: standings.into_iter().map(|(_, standing)| standing.scale).collect(),
            map,
            sessions,
        }
    }

    /// Whether z points up in one of the maps.
    pub fn is_level(&self, map: MapId) -> bool {
        // Files of earlier versions do not say it: a map that was aligned is taken to be level.
        let is_aligned = || self.scale(map).source == ScaleSource::Aligned;
        self.levels.get(map.index()).copied().unwrap_or_else(is_aligned)
    }

    /// The scale of one of the maps.
    pub fn scale(&self, map: MapId) -> MapScale {
        self.scales.get(map.index()).copied().unwrap_or_default()
    }

    /// The scale of a map of a run that is not saved yet, by its number in the run: a file numbers maps in the order of their keyframes.
    pub fn scale_of_part(&self, map: MapId) -> MapScale {
        self.number_of(map).and_then(|number| self.scales.get(number).copied()).unwrap_or_default()
    }

    /// Says how long the unit of a map of a run is, meters, by its number in the run. A map that is not there is passed over.
    pub fn tell_scale(&mut self, map: MapId, meters_per_unit: f64) {
        let Some(number) = self.number_of(map) else { return };
        let (rotation, translation) = (Matrix3::identity(), Vector3::zeros());
        move_map(&mut self.map, map, &Similarity { scale: meters_per_unit, rotation, translation });
        if self.scales.len() <= number {
            self.scales.resize(number + 1, MapScale::default());
        }
        self.scales[number] = MapScale { source: ScaleSource::Told, relative_sigma: 0.0 };
    }

    /// The number that a file gives to a map.
    fn number_of(&self, map: MapId) -> Option<usize> {
        let mut before: Vec<MapId> = Vec::new();
        for (_, keyframe) in self.map.all_keyframes() {
            if keyframe.map == map {
                return Some(before.len());
            }
            if !before.contains(&keyframe.map) {
                before.push(keyframe.map);
            }
        }
        None
    }

    /// The map that has most keyframes; `None` if there is none.
    pub fn largest(&self) -> Option<MapId> {
        let count = |map: &MapId| self.map.all_keyframes().filter(|(_, k)| k.map == *map).count();
        // The oldest of equals.
        self.map.maps().into_iter().rev().max_by_key(count)
    }
}

/// Change of the scale of a keyframe, in logarithms, up to which it was only adjusted: more, and its map was moved into the frame of another.
const ADJUSTED: f64 = 0.1;

/// What is known of a map after a run.
struct Standing {
    scale: MapScale,
    /// Whether z pointed up in the map that was there before.
    was_level: bool,
}

/// What is known of the maps after a run, in the order in which a file numbers them.
fn standings_after(loaded: &VisualMap, slam: &Slam) -> Vec<(MapId, Standing)> {
    let map = slam.map();
    let mut standings: Vec<(MapId, Standing)> = Vec::new();
    for (id, keyframe) in map.all_keyframes() {
        let number = standings.iter().position(|(map, _)| *map == keyframe.map).unwrap_or_else(|| {
            let scale = scale_by_odometry(slam, keyframe.map);
            standings.push((keyframe.map, Standing { scale, was_level: false }));
            standings.len() - 1
        });
        let is_loaded = id.index() < loaded.map.num_keyframe_ids();
        if is_loaded && map.scale_of(id).ln().abs() < ADJUSTED {
            let before = loaded.map.keyframe(id).map;
            let known = loaded.scale(before);
            let standing = &mut standings[number].1;
            if known.source != ScaleSource::Unknown {
                standing.scale = known;
            }
            standing.was_level |= loaded.is_level(before);
        }
    }
    standings
}

fn scale_by_odometry(slam: &Slam, map: MapId) -> MapScale {
    slam.metric_scale(map).map_or_else(MapScale::default, |scale| MapScale {
        source: ScaleSource::Odometry,
        relative_sigma: scale.deviation,
    })
}
