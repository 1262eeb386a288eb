//! A keyframe that shows an earlier place.

use visloc_core::median;

use crate::{
    atlas::Similarity,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Map},
    recognize::{Located, Refusal},
    track::Feature,
};

/// Distance of two landmarks in an image that may be the same, pixels of their level.
const SAME_PLACE_PX: f64 = 2.5;
/// Ratio of the depths of the same landmark in both maps, in relation to the median of all: within a factor of this.
const SAME_SCALE: f64 = 1.15;
/// Fewest landmarks that are known in both maps.
const LEAST_BOTH: usize = 8;
/// Share of them that must agree on the scale.
const LEAST_SHARE: f64 = 0.5;
/// Turn by which two keyframes may disagree on how the maps lie to each other, radians.
const MOST_TURN_RAD: f64 = 0.05;
/// Distance by which they may disagree, share of the depth of the scene.
const MOST_SHIFT: f64 = 0.1;

/// A keyframe found at an earlier place: where it is there, and which landmarks are the same.
#[derive(Debug, Clone)]
pub struct Sighting {
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// The keyframe of the earlier place that it was found by.
    pub around: KeyframeId,
    /// Its pose as the earlier place has it.
    pub pose_there: CameraFromWorld,
    /// From the map as the keyframe has it to the one of the earlier place.
    pub old_from_new: Similarity,
    /// Landmarks that were found there, and places of the image in which they were searched.
    pub found: (usize, usize),
    /// Landmarks of the earlier place, as the keyframe sees them.
    pub features: Vec<Feature>,
    /// Landmarks that are the same: of the earlier place, and of the keyframe.
    pub same: Vec<(LandmarkId, LandmarkId)>,
    /// Median depth of the earlier landmarks.
    pub depth: f64,
}

impl Sighting {
    /// Puts together what was found.
    ///
    /// # Errors
    /// If the scale of the maps to each other is not clear.
    pub fn new(map: &Map, keyframe: KeyframeId, located: &Located) -> Result<Self, Refusal> {
        let Located { report, keyframe: around, .. } = located;
        let own = map.keyframe(keyframe);
        let mut same = candidates_for_same(map, keyframe, located);
        let pose_there = report.frame.camera_from_world;
        let ratio = |(old, new): &(LandmarkId, LandmarkId)| {
            let there = pose_there.transform(&map.landmark(*old).point_in_world).z;
            let here = own.camera_from_world().transform(&map.landmark(*new).point_in_world).z;
            if there > 0.0 && here > 0.0 { there / here } else { 0.0 }
        };
        let ratios: Vec<f64> = same.iter().map(ratio).filter(|ratio| *ratio > 0.0).collect();
        let usual = median(ratios.iter().copied()).unwrap_or(0.0);
        let agrees = |ratio: f64| ratio > usual / SAME_SCALE && ratio < usual * SAME_SCALE;
        let num = ratios.iter().filter(|ratio| agrees(**ratio)).count();
        if num < LEAST_BOTH || (num as f64) < LEAST_SHARE * ratios.len() as f64 {
            return Err(Refusal::NoCommonScale { num, of: ratios.len() });
        }
        same.retain(|pair| agrees(ratio(pair)));
        let old_from_new = Similarity::between(own.camera_from_world(), &pose_there, usual);
        let depth = crate::track::scene_depth(map, &report.frame);
        let features = report.frame.features.clone();
        let found = (report.num_matched, report.num_searched);
        Ok(Self { found, keyframe, around: *around, pose_there, old_from_new, features, same, depth })
    }

    /// Whether more of what should be seen there is found than is missed. Rooms with the same furniture and windows show each other's landmarks,
    /// as alike as the right ones and in the right places to each other: they are told apart by what is missing.
    #[must_use]
    pub fn shows_most(&self) -> bool {
        2 * self.found.0 > self.found.1
    }

    /// The same once the map of the keyframe was moved to where another sighting says.
    #[must_use]
    pub fn after_joining(&self, by: &Self) -> Self {
        Self { old_from_new: self.old_from_new.after(&by.old_from_new.inverse()), ..self.clone() }
    }

    /// Whether another sighting says the same of how the maps lie to each other.
    #[must_use]
    pub fn agrees(&self, map: &Map, other: &Self) -> bool {
        let here = map.keyframe(self.keyframe).camera_from_world();
        let (mine, others) = (self.old_from_new.pose(here), other.old_from_new.pose(here));
        let turn = mine * others.inverse();
        let ratio = self.old_from_new.scale / other.old_from_new.scale;
        let shift = mine.inverse().translation() - others.inverse().translation();
        turn.rotation_angle_rad() < MOST_TURN_RAD
            && shift.norm() < MOST_SHIFT * self.depth
            && ratio < SAME_SCALE
            && ratio > 1.0 / SAME_SCALE
    }
}

/// Pairs of landmarks, of the earlier place and of the keyframe, that may be the same: their descriptors are alike, or the
/// keyframe sees both at the same place. Each landmark is in one pair at most.
fn candidates_for_same(map: &Map, keyframe: KeyframeId, located: &Located) -> Vec<(LandmarkId, LandmarkId)> {
    let own = map.keyframe(keyframe);
    let mut same: Vec<(LandmarkId, LandmarkId)> = Vec::new();
    for pair in &located.pairs {
        let view = own.view.as_deref().filter(|view| pair.place < view.len());
        if let Some(own) = view.and_then(|view| view.at(pair.place).landmark) {
            same.push((pair.landmark, own));
        }
    }
    for feature in &located.report.frame.features {
        let limit = SAME_PLACE_PX * f64::from(1_u32 << feature.level);
        let near = own.landmarks.iter().filter_map(|id| {
            let observation = map.landmark(*id).observation_in(keyframe)?;
            Some(((observation.px - feature.px).norm(), *id))
        });
        let nearest = near.filter(|(px, _)| *px < limit).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, id)) = nearest {
            same.push((feature.landmark, id));
        }
    }
    same.retain(|(old, new)| {
        old != new && map.landmark(*old).is_converged() && map.landmark(*new).is_converged()
    });
    same.sort_unstable();
    same.dedup_by_key(|(old, _)| *old);
    same.sort_unstable_by_key(|(old, new)| (*new, *old));
    same.dedup_by_key(|(_, new)| *new);
    same
}
