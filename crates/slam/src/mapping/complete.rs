//! What is done once no more images come.

use super::{MOST_KEYFRAMES, Mapper, adjust_way};
use crate::{
    map::{KeyframeId, Map},
    track::{Matcher, collect_local_map, focal_px},
};

impl Mapper {
    /// Brings the map that is tracked to its end: links its keyframes to all landmarks that they show, and adjusts it as a whole. While it grows a
    /// landmark is looked for in the few keyframes around its host only, and what a later visit shows again hardly in those of the earlier one.
    /// Nothing is done to a fixed map, and to one that is too large to be adjusted as a whole.
    pub fn complete(&self, map: &mut Map) {
        let ids: Vec<KeyframeId> = map.keyframes().map(|(id, _)| id).collect();
        if map.has_fixed() || !self.config.mapping.adjust_bundles || ids.len() > 2 * MOST_KEYFRAMES {
            return;
        }
        // Everything may be seen from everywhere in a small map: each image would be unpacked again and again.
        let is_small = ids.len() <= MOST_KEYFRAMES;
        let held: Vec<_> =
            ids.iter().filter(|_| is_small).filter_map(|id| map.keyframe(*id).pyramid()).collect();
        let adjust = |map: &mut Map| adjust_way(map, &self.config.mapping, focal_px(&self.camera));
        // Landmarks are found near where they should be only, so the first round brings the second one nearer.
        adjust(map);
        for _ in 0..2 {
            ids.iter().for_each(|id| self.link_all(map, *id));
            adjust(map);
        }
        drop(held);
    }

    /// Looks in a keyframe for all landmarks around it that others see from nearly the same direction.
    fn link_all(&self, map: &mut Map, id: KeyframeId) {
        let keyframe = map.keyframe(id);
        let (Some(pyramid), Some(depth)) = (keyframe.pyramid(), map.depth_of(id)) else { return };
        let (camera, pose) = (*keyframe.camera(&self.camera), *keyframe.camera_from_world());
        let most = self.config.tracking.max_local_keyframes;
        let mut landmarks = collect_local_map(map, &keyframe.landmarks, &pose, depth, most).landmarks;
        let matcher = Matcher { camera: &camera, ..self.matcher(&pyramid, pose) };
        landmarks.retain(|id| matcher.sees_alike(map, map.landmark(*id)));
        self.link(map, id, &matcher, &landmarks);
    }
}
