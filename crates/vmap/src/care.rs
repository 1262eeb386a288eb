//! Care of maps: two become one, and one becomes smaller.

use visloc_slam::{
    SlamConfig,
    atlas::{Apart, Merged, merge},
    map::MapId,
    mapping::{Thinned, thin},
};

use crate::{MapScale, ScaleSource, VisualMap};

impl VisualMap {
    /// Makes one map of two files: the largest map of the other one is recognized in the largest of this one and becomes a part of it, as do its
    /// further ones if they are recognized; what this one has stays where it is. Where only the other one has a known scale, it is the other way
    /// round. What is not recognized is kept beside.
    /// `None` in place of what was done if one of them has no map.
    ///
    /// # Errors
    /// If they show no common place.
    pub fn merged_with(
        self,
        other: Self,
        config: &SlamConfig,
        seed: u64,
    ) -> Result<Option<(Self, Merged)>, Apart> {
        let (Some(into), Some(from)) = (self.largest(), other.largest()) else { return Ok(None) };
        let is_known = |map: &Self, id: MapId| map.scale(id).source != ScaleSource::Unknown;
        if is_known(&other, from) && !is_known(&self, into) {
            return other.merged_with(self, config, seed);
        }
        let mut map = self.map.clone();
        map.fix();
        let offsets = map.append_all(&other.map);
        let mut merged = merge(&mut map, (offsets.map(from), into), config, seed)?;
        for further in other.map.maps().into_iter().filter(|further| *further != from) {
            // One that is not recognized stays beside.
            if let Ok(more) = merge(&mut map, (offsets.map(further), into), config, seed) {
                merged.num_keyframes += more.num_keyframes;
                merged.num_same += more.num_same;
            }
        }
        map.release();
        let before = |id: MapId| -> (MapScale, bool) {
            let own = self.map.maps().contains(&id);
            let of_other = || other.map.maps().into_iter().find(|other| offsets.map(*other) == id);
            match (own, of_other()) {
                (false, Some(id)) => (other.scale(id), other.is_level(id)),
                _ => (self.scale(id), self.is_level(id)),
            }
        };
        // In the order in which a file numbers them.
        let mut maps: Vec<MapId> = Vec::new();
        for (_, keyframe) in map.all_keyframes() {
            if !maps.contains(&keyframe.map) {
                maps.push(keyframe.map);
            }
        }
        let (scales, levels) = maps.into_iter().map(before).unzip();
        let sessions = self.sessions.iter().chain(&other.sessions).cloned().collect();
        Ok(Some((Self { map, scales, levels, sessions }, merged)))
    }

    /// Keeps so many keyframes of one of the maps: those go first of which most is seen by others.
    pub fn trim(&mut self, map: MapId, keyframes: usize) -> Thinned {
        self.map.activate(map);
        thin(&mut self.map, keyframes)
    }
}
