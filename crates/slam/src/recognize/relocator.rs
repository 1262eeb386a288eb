//! Finding a lost camera in any of the maps.

use std::cmp::Reverse;

use visloc_core::geom::Camera;

use super::{
    Located, Locator, Ranked, Refusal, View,
    locate::{NEIGHBORS_SHARE, ProposedPlace, SURE},
    support::num_supported,
};
use crate::{
    config::SlamConfig,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Map, MapId},
    track::{FrameWork, Incoming, TrackReport, focal_px, scene_depth},
};

/// One of so many descriptors in common with the place where the camera was found is the least of a rival.
const RIVAL_SHARE: u32 = 2;

/// Keyframes that are considered for each one that is tried.
const CONSIDERED: usize = 5;
/// Times as many keyframes are tried until one shows the place where pixels are larger than the map's: such an image has fewer places, so
/// that the right keyframes look less clearly like it, and each costs less.
const TIMES_OF_COARSE: usize = 4;

/// Looks for a lost camera.
#[derive(Debug, Clone)]
pub struct Relocator {
    camera: Camera,
    config: SlamConfig,
    locator: Locator,
}

impl Relocator {
    /// Takes over a camera that is known better.
    pub fn set_camera(&mut self, camera: &Camera) {
        self.camera = *camera;
        self.locator.set_camera(camera);
    }

    /// For one camera.
    #[must_use]
    pub fn new(camera: &Camera, config: &SlamConfig) -> Self {
        let locator = Locator::new(camera, config);
        Self { camera: *camera, config: config.clone(), locator }
    }

    /// Finds more in less time from now on, for those who doubt what is found until they see more of it.
    pub fn doubt(&mut self) {
        self.locator.doubt();
    }

    /// Tries the keyframes of all maps, or some of them, that look most like the image. The place where most landmarks were found is the
    /// answer.
    ///
    /// # Errors
    /// The keyframe that looks most like the image and why it is not the place; `None` if nothing looks like it.
    pub fn attempt(
        &self,
        map: &Map,
        is_candidate: impl Fn(KeyframeId) -> bool,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        let is_doubting = self.locator.is_doubting();
        let octaves = if is_doubting { self.octaves_coarser(map) } else { 0 };
        let view = View::of_coarse_image(incoming.pyramid, octaves, &self.camera, &self.config.features);
        let max_tries = self.config.relocation.max_tries;
        let max_until_found = if octaves > 0 { TIMES_OF_COARSE * max_tries } else { max_tries };
        let ranked =
            if is_doubting { self.by_support(map, &view, max_until_found) } else { map.index().query(&view) };
        let listed = self.locator.listed(&view);
        let (mut refused, mut found) = (None, Vec::<Located>::new());
        let (mut num_tried, mut is_tried) = (0, vec![false; map.num_keyframe_ids()]);
        // Most descriptors in common with a keyframe by which the camera was found: a place with far less in common is no rival.
        let mut most_shared = 0;
        // The map with the one active that was searched last: mostly there is no other.
        let mut searched = None::<Map>;
        for Ranked { keyframe: id, num_shared, .. } in ranked {
            let most = if found.is_empty() { max_until_found } else { max_tries };
            if num_tried >= most || RIVAL_SHARE * num_shared < most_shared {
                break;
            }
            if is_tried[id.index()] || !is_candidate(id) {
                continue;
            }
            num_tried += 1;
            // What is next to a keyframe that was refused would be refused, too.
            let connected = map.connected(id, NEIGHBORS_SHARE);
            let share =
                if is_doubting { map.keyframe(id).landmarks.len() as u32 / 2 } else { NEIGHBORS_SHARE };
            let near = connected.iter().filter(|(_, num)| *num >= share);
            near.for_each(|(near, _)| is_tried[near.index()] = true);
            let active = map.keyframe(id).map;
            let same = searched.take().filter(|searched| searched.active() == active);
            let searched = &*searched.insert(same.unwrap_or_else(|| map.with_active(active)));
            let proposed =
                self.locator.propose(searched, (id, &connected), (&view, listed.as_ref()), work.rng);
            // Where it is found already it need not be looked for again.
            let is_known = |proposal: &ProposedPlace| {
                let there = (searched.active(), &proposal.pose);
                found.iter().any(|it| !are_apart(map, (map.keyframe(it.keyframe).map, &it.report), there))
            };
            if is_doubting && proposed.as_ref().is_ok_and(is_known) {
                continue;
            }
            match proposed.and_then(|proposal| self.locator.confirm(searched, proposal, incoming, work)) {
                Ok(located) => {
                    if is_doubting {
                        most_shared = most_shared.max(num_shared);
                        // What is next to a place that is sure would be found to be there, too.
                        if located.report.num_matched >= SURE * self.config.relocation.min_matches {
                            let features = located.report.frame.features.iter();
                            let seen: Vec<LandmarkId> = features.map(|feature| feature.landmark).collect();
                            let near = map.sharing(&seen, NEIGHBORS_SHARE);
                            near.iter().for_each(|(near, _)| is_tried[near.index()] = true);
                        }
                    }
                    found.push(located);
                }
                Err(reason) => refused = refused.or(Some((id, reason))),
            }
        }
        let mut best = best_of(map, found).ok_or(refused)?;
        if is_doubting {
            let searched = map.with_active(map.keyframe(best.keyframe).map);
            best.report = self.locator.grown(&searched, best.report, incoming, work);
        }
        Ok(best)
    }

    /// How much larger the pixels are than the smallest that a map was made with, octaves: 0 if they are not, at most so many that the finest
    /// level on which landmarks are made lies where the coarsest one would. A camera that sees more than those of the map is not enlarged
    /// beyond their images, so that a search costs what it would with them.
    fn octaves_coarser(&self, map: &Map) -> i32 {
        let larger_than = |own: &Camera, length: fn(&Camera) -> f64| {
            let lengths = map.all_keyframes().map(|(_, keyframe)| length(keyframe.camera(own)));
            lengths.fold(0.0, f64::max) / length(own)
        };
        let width = |camera: &Camera| f64::from(camera.size_px().0);
        let ratio = larger_than(&self.camera, focal_px).min(larger_than(&self.camera, width));
        let octaves = ratio.log2().round() as i32;
        octaves.clamp(0, self.config.features.search_levels.saturating_sub(1) as i32)
    }

    /// Keyframes that look most like the view, first those where most of what looks alike lies as it does here.
    fn by_support(&self, map: &Map, view: &View, max_tries: usize) -> Vec<Ranked> {
        let (mut ranked, mut alike) = map.index().query_rare(view);
        ranked.truncate(CONSIDERED * max_tries);
        let mut is_considered = vec![false; map.num_keyframe_ids()];
        ranked.iter().for_each(|it| is_considered[it.keyframe.index()] = true);
        alike.retain(|it| is_considered[it.keyframe.index()]);
        alike.sort_by_key(|it| it.keyframe);
        let num_supported = |it: &Ranked| {
            let start = alike.partition_point(|other| other.keyframe < it.keyframe);
            let places = alike[start..].iter().take_while(|other| other.keyframe == it.keyframe);
            num_supported(&self.camera, (view, places), map.keyframe(it.keyframe))
        };
        let num: Vec<usize> = ranked.iter().map(num_supported).collect();
        for (it, num) in ranked.iter_mut().zip(num) {
            it.num_shared = num as u32;
        }
        ranked.sort_by_key(|it| Reverse(it.num_shared));
        ranked
    }
}

/// Distance up to which two poses are the same place, share of the depth of the scene; radians for a turn.
const SAME_PLACE: f64 = 0.2;

/// Of the places where an image may have been taken, the one where most landmarks were found; it knows the others, each once.
fn best_of(map: &Map, mut found: Vec<Located>) -> Option<Located> {
    // The first of equals.
    found.sort_by_key(|located| Reverse(located.report.num_matched));
    let mut places: Vec<Located> = Vec::new();
    for located in found {
        let place = located.as_rival(map);
        let is_elsewhere =
            |other: &Located| are_apart(map, (map.keyframe(other.keyframe).map, &other.report), place.pose());
        if places.iter().all(is_elsewhere) {
            places.push(located);
        }
    }
    let mut places = places.into_iter();
    let mut best = places.next()?;
    best.rivals = places.map(|place| place.as_rival(map)).collect();
    Some(best)
}

/// Whether an image was taken at another place than here, in a map: it would be shifted by more than a fifth of its focal length.
pub(crate) fn are_apart(
    map: &Map,
    (of, here): (MapId, &TrackReport),
    (of_other, other): (MapId, &CameraFromWorld),
) -> bool {
    let here_from_other = here.frame.camera_from_world * other.inverse();
    of_other != of
        || here_from_other.translation().norm() > SAME_PLACE * scene_depth(map, &here.frame)
        || here_from_other.rotation_angle_rad() > SAME_PLACE
}
