//! Taking out what the map does not need.

use nalgebra::Point3;

use crate::{
    config::MappingConfig,
    map::{KeyframeId, LandmarkId, Map},
};

/// Misses in a row that are too many for a landmark that was hardly ever found. One that was found often may be hidden for
/// longer: a robot that comes back needs it.
const MANY_MISSES: u32 = 30;

/// Removes landmarks that are missed too often, and young ones that few keyframes saw again. Source for the second rule:
/// Mur-Artal, Montiel and Tardos, "ORB-SLAM", 2015, section VI-B.
pub fn cull_landmarks(map: &mut Map, newest: KeyframeId) {
    let frame = map.keyframe(newest).frame;
    let is_bad = |map: &Map, id: LandmarkId| {
        let landmark = map.landmark(id);
        landmark.is_converged()
            && (landmark.num_missed > MANY_MISSES + landmark.num_found / 2
                || (landmark.num_visible >= 15 && landmark.num_found * 4 < landmark.num_visible)
                || (frame.saturating_sub(landmark.made_at as usize) > 60 && landmark.observations.len() < 2))
    };
    let free = map.landmarks().map(|(id, _)| id).filter(|id| !map.is_fixed_landmark(*id));
    let bad: Vec<LandmarkId> = free.filter(|id| is_bad(map, *id)).collect();
    for id in bad {
        map.remove_landmark(id);
    }
}

/// Keyframes from which on redundant ones are culled. A culled keyframe keeps its pose relative to another one for good, with
/// the scale that the map had then; so a map that fits into memory keeps them all, and bundles keep the observers that hold them.
const MANY_KEYFRAMES: usize = 150;

/// Culls at most one redundant keyframe of a large map among those connected to the newest: one whose landmarks are nearly all
/// seen, at least as sharply, by three others. Then keeps the number of keyframes within its limit.
pub fn cull_keyframes(map: &mut Map, newest: KeyframeId, config: &MappingConfig) {
    let connected: Vec<KeyframeId> = map.connected(newest, 10).into_iter().map(|(id, _)| id).collect();
    // The newest ones still gather observations; the first hold the map in place.
    let is_free = |map: &Map, id: KeyframeId| id.index() > 1 && !map.is_fixed(id);
    let is_eligible = |map: &Map, id: KeyframeId| is_free(map, id) && id.index() + 3 < newest.index();
    let is_large = map.free_keyframes().count() > MANY_KEYFRAMES.min(config.max_keyframes / 2);
    let redundant = connected
        .iter()
        .filter(|id| is_large && is_eligible(map, **id))
        .find(|id| redundancy(map, **id).is_some_and(|share| share > config.redundant_ratio));
    if let Some(id) = redundant.copied() {
        cull(map, id);
    }
    while map.free_keyframes().count() > config.max_keyframes {
        // The map is thinned where most keyframes see the same: a place that nobody else has seen is worth more, however far away.
        let eligible = map.keyframes().map(|(id, _)| id).filter(|id| is_eligible(map, *id));
        let share = |id: KeyframeId| redundancy(map, id).unwrap_or(1.0);
        let shares: Vec<(KeyframeId, f64)> = eligible.map(|id| (id, share(id))).collect();
        let Some((id, _)) = shares.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        cull(map, id);
    }
}

/// What was taken out of a map to make it smaller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thinned {
    /// Keyframes that went.
    pub num_keyframes: usize,
    /// Landmarks that went with them: nobody else saw them twice.
    pub num_landmarks: usize,
    /// Of the keyframe that was missed most, the share of its landmarks that three others see; 1 if none went.
    pub least_redundancy: f64,
}

/// Keeps so many keyframes of the map that is active: those go first of which most is seen by others. Its first two stay.
pub fn thin(map: &mut Map, most: usize) -> Thinned {
    let counts = |map: &Map| (map.keyframes().count(), map.landmarks().count());
    let before = counts(map);
    let mut least_redundancy: f64 = 1.0;
    let ids: Vec<KeyframeId> = map.keyframes().map(|(id, _)| id).skip(2).collect();
    let mut shares: Vec<(KeyframeId, f64)> =
        ids.into_iter().map(|id| (id, redundancy(map, id).unwrap_or(1.0))).collect();
    while map.keyframes().count() > most {
        let Some(i) = (0..shares.len()).max_by(|a, b| shares[*a].1.total_cmp(&shares[*b].1)) else { break };
        let (id, share) = shares.swap_remove(i);
        least_redundancy = least_redundancy.min(share);
        // Only those that saw the same are needed more now.
        let connected = map.connected(id, 1);
        cull(map, id);
        for (other, share) in &mut shares {
            if connected.iter().any(|(near, _)| near == other) {
                *share = redundancy(map, *other).unwrap_or(1.0);
            }
        }
    }
    let after = counts(map);
    Thinned { num_keyframes: before.0 - after.0, num_landmarks: before.1 - after.1, least_redundancy }
}

/// Hangs a keyframe on its best connected one, or else the nearest, and takes it out.
fn cull(map: &mut Map, id: KeyframeId) {
    let center: Point3<f64> = *map.keyframe(id).center_in_world();
    let best = map.connected(id, 1).first().map(|(other, _)| *other);
    let nearest = || {
        let others = map.keyframes().filter(|(other, _)| *other != id);
        let distance = |k: &crate::map::Keyframe| (k.center_in_world() - center).norm();
        others.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).map(|(other, _)| other)
    };
    if let Some(anchor) = best.or_else(nearest) {
        map.cull_keyframe(id, anchor);
    }
}

/// Share of a keyframe's converged landmarks that three others see on the same or a finer level.
fn redundancy(map: &Map, id: KeyframeId) -> Option<f64> {
    let (mut total, mut redundant) = (0_u32, 0_u32);
    for landmark in map.keyframe(id).landmarks.iter().map(|l| map.landmark(*l)).filter(|l| l.is_converged()) {
        let level = landmark.observation_in(id)?.level;
        total += 1;
        let others =
            landmark.observations.iter().filter(|o| o.keyframe != id && o.level <= level + 1).count();
        redundant += u32::from(others >= 3);
    }
    (total >= 10).then(|| f64::from(redundant) / f64::from(total))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Matrix2, Point2, Rotation3, Vector3};
    use visloc_core::{GrayImage, Timestamp};

    use super::*;
    use crate::{
        image::Pyramid,
        lie::CameraFromWorld,
        map::{LandmarkState, NewKeyframe, Observation},
        mapping::DepthFilter,
    };

    fn observation(keyframe: KeyframeId) -> Observation {
        let ray = Vector3::new(0.0, 0.0, 1.0);
        Observation { keyframe, px: Point2::origin(), ray, level: 0, covariance_px: Matrix2::identity() }
    }

    /// Keyframes every tenth of a meter that see the same, but the third, which is far away and alone.
    fn map_with_a_place_of_its_own() -> (Map, Vec<KeyframeId>) {
        let mut map = Map::new();
        let pyramid = Arc::new(Pyramid::new(GrayImage::new(40, 30), 1));
        let mut ids = Vec::new();
        for i in 0..12_usize {
            let x = if i == 2 { -50.0 } else { 0.1 * i as f64 };
            ids.push(map.add_keyframe(NewKeyframe {
                frame: 10 * i,
                at: Timestamp::default(),
                pyramid: Arc::clone(&pyramid),
                camera_from_world: CameraFromWorld::new(Rotation3::identity(), Vector3::new(x, 0.0, 0.0)),
                turned_from: None,
                odometry: None,
            }));
        }
        let (alone, together): (Vec<KeyframeId>, Vec<KeyframeId>) =
            ids.iter().partition(|id| id.index() == 2);
        for seen_by in [alone, together] {
            for _ in 0..20 {
                let host = observation(seen_by[0]);
                let id = map.add_landmark(host, DepthFilter::new(1.0, 0.1), LandmarkState::Converged);
                seen_by[1..].iter().for_each(|other| map.add_observation(id, observation(*other)));
            }
        }
        (map, ids)
    }

    #[test]
    fn a_place_that_nobody_else_has_seen_is_kept_however_far_away() {
        let (mut map, ids) = map_with_a_place_of_its_own();
        let config = MappingConfig { max_keyframes: 8, ..MappingConfig::default() };
        cull_keyframes(&mut map, ids[11], &config);
        assert_eq!(map.keyframes().count(), 8);
        assert!(map.keyframe(ids[2]).is_alive());
        map.check().unwrap();
    }

    #[test]
    fn a_map_is_thinned_where_most_is_seen_twice() {
        let (mut map, ids) = map_with_a_place_of_its_own();
        let thinned = thin(&mut map, 5);
        assert_eq!((map.keyframes().count(), thinned.num_keyframes), (5, 7));
        assert!(map.keyframe(ids[2]).is_alive(), "nobody else sees its place");
        assert_eq!((thinned.num_landmarks, thinned.least_redundancy), (0, 1.0));
        map.check().unwrap();
        assert_eq!(thin(&mut map, 50).num_keyframes, 0);
        thin(&mut map, 0);
        assert_eq!(map.keyframes().count(), 2);
        map.check().unwrap();
    }

    #[test]
    fn what_is_fixed_is_not_culled() {
        let (mut map, ids) = map_with_a_place_of_its_own();
        map.fix();
        let config = MappingConfig { max_keyframes: 8, ..MappingConfig::default() };
        cull_keyframes(&mut map, ids[11], &config);
        cull_landmarks(&mut map, ids[11]);
        assert_eq!((map.keyframes().count(), map.landmarks().count()), (12, 40));
    }
}
