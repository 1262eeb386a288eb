//! Finding a lost camera in any of the maps.

use std::cmp::Reverse;

use visloc_core::geom::Camera;

use super::{
    Located, Locator, Ranked, Refusal, Rival, View,
    guided::Guide,
    locate::{NEIGHBORS_SHARE, Proposal},
    support::num_supported,
};
use crate::{
    config::SlamConfig,
    lie::CameraFromWorld,
    map::{KeyframeId, Map, MapId},
    track::{FrameWork, Incoming, TrackReport, scene_depth},
};

/// Keyframes that are considered for each one that is tried.
const CONSIDERED: usize = 5;

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

    /// Tries the keyframes of all maps that look most like the image. The place where most landmarks were found is the answer.
    ///
    /// # Errors
    /// The keyframe that looks most like the image and why it is not the place; `None` if nothing looks like it.
    pub fn attempt(
        &self,
        map: &Map,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        self.attempt_among(map, |_| true, incoming, work)
    }

    /// Tries only some of the keyframes, see [`Relocator::attempt`].
    ///
    /// # Errors
    /// As [`Relocator::attempt`].
    pub fn attempt_among(
        &self,
        map: &Map,
        is_candidate: impl Fn(KeyframeId) -> bool,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        let view = View::of_image(incoming.pyramid, &self.camera, &self.config.features);
        if self.locator.is_doubting() {
            return self.attempt_doubting(map, is_candidate, (&view, incoming), work);
        }
        let (mut refused, mut found) = (None, Vec::<Located>::new());
        for (id, _) in self.candidates(map, map.index().query(&view), is_candidate, |_| NEIGHBORS_SHARE) {
            let searched = map.with_active(map.keyframe(id).map);
            match self.locator.locate(&searched, id, (&view, incoming), work) {
                Ok(located) => found.push(located),
                Err(reason) => refused = refused.or(Some((id, reason))),
            }
        }
        best_of(map, found).ok_or(refused)
    }

    /// Asks more keyframes where the image may have been taken; the patches of landmarks are looked for at the most probable of these places.
    fn attempt_doubting(
        &self,
        map: &Map,
        is_candidate: impl Fn(KeyframeId) -> bool,
        (view, incoming): (&View, &Incoming<'_>),
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        let guide = Guide::new(view, &self.camera);
        let (mut unlike, mut proposals) = (None, Vec::<Proposal>::new());
        let half = |id| map.keyframe(id).landmarks.len() as u32 / 2;
        for (id, connected) in self.candidates(map, self.by_support(map, view), is_candidate, half) {
            let searched = map.with_active(map.keyframe(id).map);
            match self.locator.propose(&searched, (id, &connected), &guide, work.rng) {
                Ok(proposal) => proposals.push(proposal),
                Err(reason) => unlike = unlike.or(Some((id, reason))),
            }
        }
        proposals.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        let (mut found, mut missed, mut refused) = (Vec::<Located>::new(), Vec::new(), None);
        let is_same = |it: &Located, id: KeyframeId, pose: &CameraFromWorld| {
            let here = (map.keyframe(it.keyframe).map, &it.report.frame.camera_from_world);
            !are_apart_by(here, (map.keyframe(id).map, pose), (scene_depth(map, &it.report.frame), SAME_POSE))
        };
        for proposal in proposals {
            let (id, pose) = (proposal.keyframe, proposal.pose);
            if found.iter().any(|it| is_same(it, id, &pose)) {
                continue;
            }
            let searched = map.with_active(map.keyframe(id).map);
            match self.locator.confirm(&searched, proposal, incoming, work) {
                Ok(located) => found.push(located),
                Err(reason) => {
                    if let Refusal::FewFound { num, .. } = reason {
                        missed.push((id, pose, num));
                    }
                    refused = refused.or(Some((id, reason)));
                }
            }
        }
        // Where more is found elsewhere, though too little of what should be seen there, nobody knows which of both it is.
        found.retain(|it| {
            let is_more = |num: usize| num > it.report.num_matched;
            !missed.iter().any(|(id, pose, num)| is_more(*num) && !is_same(it, *id, pose))
        });
        best_of(map, found).ok_or(refused.or(unlike))
    }

    /// The keyframes to try with those connected to them. What shares enough with one of them would be refused, too.
    fn candidates<'a>(
        &self,
        map: &'a Map,
        ranked: Vec<Ranked>,
        is_candidate: impl Fn(KeyframeId) -> bool + 'a,
        share: impl Fn(KeyframeId) -> u32 + 'a,
    ) -> impl Iterator<Item = (KeyframeId, Vec<(KeyframeId, u32)>)> + 'a {
        let mut is_tried = vec![false; map.num_keyframe_ids()];
        let ids = ranked.into_iter().map(|it| it.keyframe).filter(move |id| is_candidate(*id));
        let tried = ids.filter_map(move |id| {
            if is_tried[id.index()] {
                return None;
            }
            let connected = map.connected(id, NEIGHBORS_SHARE);
            let near = connected.iter().filter(|(_, num)| *num >= share(id));
            near.for_each(|(near, _)| is_tried[near.index()] = true);
            Some((id, connected))
        });
        tried.take(self.config.relocation.max_tries)
    }

    /// Keyframes that look most like the view, first those where most of what looks alike lies as it does here.
    fn by_support(&self, map: &Map, view: &View) -> Vec<Ranked> {
        let (mut ranked, mut alike) = map.index().query_rare(view);
        ranked.truncate(CONSIDERED * self.config.relocation.max_tries);
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
/// The same for poses that differ by no more than they are known.
const SAME_POSE: f64 = 0.05;

/// Of the places where an image may have been taken, the one where most landmarks were found; it knows the others, each once.
fn best_of(map: &Map, mut found: Vec<Located>) -> Option<Located> {
    // The first of equals.
    found.sort_by_key(|located| Reverse(located.report.num_matched));
    let mut places: Vec<Located> = Vec::new();
    for located in found {
        let place = located.as_rival(map);
        let is_elsewhere =
            |other: &Located| are_apart(map, (map.keyframe(other.keyframe).map, &other.report), &place);
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
pub(crate) fn are_apart(map: &Map, (of, here): (MapId, &TrackReport), other: &Rival) -> bool {
    let there = (other.map, &other.camera_from_world);
    are_apart_by((of, &here.frame.camera_from_world), there, (scene_depth(map, &here.frame), SAME_PLACE))
}

/// Whether two poses are farther apart than a share of the depth of the scene, or as many radians.
fn are_apart_by(
    here: (MapId, &CameraFromWorld),
    there: (MapId, &CameraFromWorld),
    (depth, share): (f64, f64),
) -> bool {
    let here_from_there = *here.1 * there.1.inverse();
    here.0 != there.0
        || here_from_there.translation().norm() > share * depth
        || here_from_there.rotation_angle_rad() > share
}
