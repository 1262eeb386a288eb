//! Watches keyframes for places that were seen before.

use visloc_core::{Clock, Rng, RngTree, geom::Camera};

use super::{
    Meeting,
    closing::{bend, meet_where_lost, spread},
    global::GlobalAdjustment,
    revisit::{Revisit, RevisitStep, visit_began},
    sighting::Sighting,
};
use crate::{
    config::SlamConfig,
    map::{Correction, KeyframeId, LandmarkId, Map, MapId},
    mapping::adjust_local,
    recognize::{Located, Locator, Ranked, Refusal, View},
    timing::StageTimer,
    track::{FrameWork, Incoming, focal_px},
};

/// Views of a place in a row, each from elsewhere, that must agree.
pub(crate) const IN_A_ROW: usize = 3;
/// Keyframes in a row without agreement after which a hypothesis is dropped.
const MOST_MISSED: usize = 2;
/// Fewest descriptors in common for a candidate.
const LEAST_SHARED: u32 = 12;

/// Least score of a candidate, share of the one of the most alike keyframe that sees the same landmarks. Source: Mur-Artal,
/// Montiel and Tardos, "ORB-SLAM", 2015, section VII-A, takes the least alike of them, as is done here for faint candidates.
const LEAST_SCORE: f32 = 0.35;
/// Keyframes for which a refused candidate is not tried again.
const REFUSED_FOR: usize = 3;
/// Keyframes around a refused candidate that are refused with it.
const NEAR: usize = 3;
/// The newest keyframes are the same visit.
const RECENT: usize = 10;

/// A place that may be the same, and the keyframes that say so.
#[derive(Debug, Clone)]
struct Hypothesis {
    /// The map of the earlier place.
    map: MapId,
    /// A keyframe of the earlier place.
    candidate: KeyframeId,
    /// Whether the place looked less alike than the bar asks for when it was suspected.
    is_faint: bool,
    sightings: Vec<Sighting>,
    num_missed: usize,
}

impl Hypothesis {
    /// Whether enough keyframes agree. What is known of the way tells a loop from a place that looks alike; between maps, of which nothing is
    /// known, one of the keyframes must show most of what is there. A faint place is seen from afar at first, and the size of the maps to each
    /// other is off by a percent and more then; it waits until a keyframe shows no more of it than the one before.
    fn is_sure(&self, active: MapId) -> bool {
        let is_shown = self.map == active || self.sightings.iter().any(Sighting::shows_most);
        let is_growing = matches!(&self.sightings[..], [.., last, newest] if newest.found.0 > last.found.0);
        let may_show_more = self.is_faint && self.num_missed == 0 && is_growing;
        self.sightings.len() >= IN_A_ROW && is_shown && !may_show_more
    }
}

/// A candidate that was refused lately.
#[derive(Debug, Clone, Copy)]
struct Refused {
    by: KeyframeId,
    candidate: KeyframeId,
    is_faint: bool,
}

/// Watches keyframes for places that were seen before, and joins maps.
#[derive(Debug)]
pub struct Recognizer {
    camera: Camera,
    config: SlamConfig,
    locator: Locator,
    rng: Rng,
    pending: Option<Hypothesis>,
    revisit: Revisit,
    refused: Vec<Refused>,
    /// The adjustment after the last loop or joining, while it is under way.
    global: Option<GlobalAdjustment>,
}

impl Recognizer {
    /// The whole map was adjusted, maybe for a camera that is known better: an adjustment that is under way began with an older state of
    /// both and is given up.
    pub fn start_from(&mut self, camera: &Camera) {
        self.camera = *camera;
        self.locator.set_camera(camera);
        self.global = None;
    }

    /// For one camera. The seed fixes every random choice.
    #[must_use]
    pub fn new(camera: &Camera, config: &SlamConfig, seed: u64) -> Self {
        Self {
            camera: *camera,
            config: config.clone(),
            locator: Locator::new(camera, config),
            rng: RngTree::new(seed).stream("places", 0),
            pending: None,
            revisit: Revisit::default(),
            refused: Vec::new(),
            global: None,
        }
    }

    /// Drops what was pending: tracking goes on in another map.
    pub fn forget(&mut self) {
        self.pending = None;
        self.refused.clear();
        self.revisit = Revisit::default();
        self.global = None;
    }

    /// Whether the whole map is being adjusted.
    #[must_use]
    pub fn is_adjusting(&self) -> bool {
        self.global.is_some()
    }

    /// Goes on with the adjustment of the whole map, if there is one to be done; says whether keyframes have moved.
    pub fn adjust(&mut self, map: &mut Map, timer: &mut StageTimer) -> bool {
        let Some(global) = &mut self.global else { return false };
        let is_done = global.step();
        if is_done {
            global.apply(map);
            self.global = None;
        }
        timer.end("global adjustment");
        is_done
    }

    /// Notes what a keyframe looks like.
    pub fn describe(&self, map: &mut Map, keyframe: KeyframeId) {
        let view = View::of_keyframe(map, keyframe);
        map.describe(keyframe, view);
    }

    /// Compares a new keyframe with all earlier places, and joins its map to another one if they are sure to meet.
    pub fn look(&mut self, map: &mut Map, keyframe: KeyframeId, timer: &mut StageTimer) -> Option<Meeting> {
        self.describe(map, keyframe);
        timer.end("describe");
        if !self.config.relocation.close_loops {
            return None;
        }
        let revisit = self.revisit.add(map, keyframe);
        if let RevisitStep::Began(_) | RevisitStep::GoesOn = revisit {
            self.adjust_later(map);
        }
        let meeting = match (revisit, self.pending.take()) {
            (_, Some(pending)) => self.confirm(map, keyframe, pending),
            // The place is known; only other maps may know it, too.
            (RevisitStep::New, None) => self.suspect(map, keyframe),
            (_, None) if map.maps().len() > 1 && !map.has_fixed() => self.suspect(map, keyframe),
            _ => None,
        };
        timer.end("recognize");
        let active = map.active();
        let done = match (self.pending.take_if(|pending| pending.is_sure(active)), revisit) {
            (Some(sure), _) => self.close(map, &sure),
            (None, RevisitStep::Began(candidate)) => Some(Meeting::Followed { candidate }),
            _ => meeting,
        };
        timer.end("join");
        done
    }

    /// Joins two maps, or closes a loop.
    fn close(&mut self, map: &mut Map, sure: &Hypothesis) -> Option<Meeting> {
        // Those before are from farther away, and less exact.
        let nearest = sure.sightings.last_chunk::<IN_A_ROW>()?;
        let newest = nearest.last()?;
        let candidate = sure.candidate;
        let done = if sure.map == map.active() {
            match bend(map, newest) {
                Ok(bend) => {
                    spread(map, nearest);
                    Meeting::Closed { candidate, drift: bend.drift, scale: bend.scale }
                }
                Err(reason) => return Some(Meeting::Refused { candidate, reason }),
            }
        } else {
            let joined = move_over(map, newest, sure.map);
            if map.crossings().next().is_some() {
                // The maps know each other at both ends of one of them.
                let moved: Vec<Sighting> = nearest.iter().map(|s| s.after_joining(newest)).collect();
                spread(map, &moved);
            }
            joined
        };
        fuse(map, &sure.sightings);
        adjust_local(map, newest.keyframe, &self.config.mapping, focal_px(&self.camera));
        self.adjust_later(map);
        Some(done)
    }

    /// Starts to adjust the whole map. An adjustment that is under way is given up.
    fn adjust_later(&mut self, map: &Map) {
        let is_wanted = self.config.mapping.adjust_bundles;
        self.global = if is_wanted { GlobalAdjustment::start(map, focal_px(&self.camera)) } else { None };
    }

    /// Looks for a candidate.
    fn suspect(&mut self, map: &Map, keyframe: KeyframeId) -> Option<Meeting> {
        // The next keyframes look the same: what was refused just now would be refused again.
        self.refused.retain(|refused| refused.by.index() + REFUSED_FOR >= keyframe.index());
        let was_refused =
            self.refused.last().is_some_and(|refused| refused.by.index() + 1 >= keyframe.index());
        let (candidate, is_faint) = find_candidate(map, keyframe, !was_refused)?;
        let is_near = |other: KeyframeId| other.index().abs_diff(candidate.index()) <= NEAR;
        // One that looks more alike now may be found after all.
        if self.refused.iter().any(|refused| is_near(refused.candidate) && (is_faint || !refused.is_faint)) {
            return None;
        }
        match self.sight(map, keyframe, candidate, None) {
            Ok(sighting) => {
                let sightings = self.look_back(map, sighting);
                let num = sightings.len();
                let found = sightings.last().map_or((0, 0), |newest| newest.found);
                let map = map.keyframe(candidate).map;
                self.pending = Some(Hypothesis { map, candidate, is_faint, sightings, num_missed: 0 });
                Some(Meeting::Pending { candidate, num, found })
            }
            Err(reason) => {
                self.refused.push(Refused { by: keyframe, candidate, is_faint });
                Some(Meeting::Refused { candidate, reason })
            }
        }
    }

    /// The keyframes just before one may show the earlier place, too.
    fn look_back(&mut self, map: &Map, newest: Sighting) -> Vec<Sighting> {
        let mut sightings = vec![newest];
        let before: Vec<KeyframeId> =
            map.keyframes().map(|(id, _)| id).rev().filter(|id| *id < sightings[0].keyframe).collect();
        for keyframe in before.into_iter().take(IN_A_ROW - 1) {
            let around = sightings[0].around;
            let next = &sightings[0];
            match self.sight(map, keyframe, around, Some(next)) {
                Ok(sighting) if sighting.agrees(map, next) => sightings.insert(0, sighting),
                _ => break,
            }
        }
        sightings
    }

    /// Looks for the earlier place of a hypothesis in a further keyframe.
    fn confirm(&mut self, map: &Map, keyframe: KeyframeId, mut pending: Hypothesis) -> Option<Meeting> {
        let last = pending.sightings.last()?;
        let seen: Vec<LandmarkId> = last.features.iter().map(|feature| feature.landmark).collect();
        let of_old = |id: &KeyframeId| map.keyframe(*id).map == pending.map;
        let around = map.sharing(&seen, 1).into_iter().map(|(id, _)| id).find(of_old);
        let sighting = self.sight(map, keyframe, around.unwrap_or(pending.candidate), Some(last));
        let candidate = pending.candidate;
        match sighting {
            Ok(sighting) if sighting.agrees(map, last) => {
                pending.sightings.push(sighting);
                pending.num_missed = 0;
            }
            Ok(_) => return Some(self.miss(pending, None)),
            Err(reason) => return Some(self.miss(pending, Some(reason))),
        }
        let num = pending.sightings.len();
        let found = pending.sightings.last().map_or((0, 0), |sighting| sighting.found);
        self.pending = Some(pending);
        Some(Meeting::Pending { candidate, num, found })
    }

    /// A keyframe does not confirm a hypothesis; it is kept for a while.
    fn miss(&mut self, mut pending: Hypothesis, reason: Option<Refusal>) -> Meeting {
        let num = pending.sightings.len();
        let reason = reason.unwrap_or(Refusal::NotConsistent { num });
        let candidate = pending.candidate;
        pending.num_missed += 1;
        self.pending = Some(pending).filter(|pending| pending.num_missed <= MOST_MISSED);
        Meeting::Refused { candidate, reason }
    }

    /// Looks for a keyframe around an earlier one: by its descriptors, or where an earlier sighting says.
    fn sight(
        &mut self,
        map: &Map,
        keyframe: KeyframeId,
        around: KeyframeId,
        expected: Option<&Sighting>,
    ) -> Result<Sighting, Refusal> {
        let nothing = Refusal::FewAlike { num: 0 };
        let own = map.keyframe(keyframe);
        let pyramid = own.pyramid().ok_or(nothing)?;
        let incoming = Incoming::of_image(own.frame, own.at, &pyramid);
        let mut searched = map.with_active(map.keyframe(around).map);
        // Landmarks of this visit are where the way has drifted to: they would pull the pose there.
        let began = visit_began(map, keyframe);
        searched.hide(map.keyframes().map(|(id, _)| id).filter(|id| *id >= began));
        let mut aside = StageTimer::start(Clock::still());
        let mut work = FrameWork { rng: &mut self.rng, timer: &mut aside };
        let located = match expected {
            Some(expected) => {
                let pose = expected.old_from_new.pose(own.camera_from_world());
                let report = self.locator.follow(&searched, (around, &pose), &incoming, &mut work)?;
                Located { report, keyframe: around, pairs: Vec::new(), rivals: Vec::new() }
            }
            None => {
                let view = own.view.as_deref().ok_or(nothing)?;
                self.locator.locate(&searched, around, (view, &incoming), &mut work)?
            }
        };
        let sighting = Sighting::new(map, keyframe, &located)?;
        meet_where_lost(map, &sighting)?;
        Ok(sighting)
    }
}

/// Moves the map that is tracked into the frame of another one and makes one of both.
pub(super) fn move_over(map: &mut Map, newest: &Sighting, into: MapId) -> Meeting {
    let joined = map.active();
    let old_from_new = newest.old_from_new;
    let corrections: Vec<Correction> = map
        .keyframes()
        .map(|(keyframe, k)| Correction {
            keyframe,
            camera_from_world: old_from_new.pose(k.camera_from_world()),
            scale: old_from_new.scale,
        })
        .collect();
    map.correct(&corrections);
    map.join(joined, into);
    Meeting::Joined { map: joined, into, scale: old_from_new.scale }
}

/// The keyframe that looks most like this one, of another map or of a place that the camera has left since, and whether it is faint. Who
/// misses a loop goes on with what the way has drifted, who misses another map has lost it: only those may be faint.
fn find_candidate(map: &Map, keyframe: KeyframeId, may_be_faint: bool) -> Option<(KeyframeId, bool)> {
    let own = map.keyframe(keyframe);
    let began = visit_began(map, keyframe);
    let ranked = map.index().query_beside(own.view.as_ref()?, |id| is_own_visit(map, keyframe, began, id));
    let connected = map.connected(keyframe, 1);
    let is_connected = |id: KeyframeId| connected.iter().any(|(other, _)| *other == id);
    let mut near =
        ranked.iter().filter(|ranked| ranked.keyframe != keyframe && is_connected(ranked.keyframe));
    let least = near.next().map_or(0.0, |near| LEAST_SCORE * near.score);
    let least_faint = near.next_back().map_or(least, |near| near.score.min(least));
    let is_alike = |ranked: &&Ranked| {
        let may_be_faint = may_be_faint && map.keyframe(ranked.keyframe).map != own.map;
        ranked.num_shared >= LEAST_SHARED && ranked.score >= if may_be_faint { least_faint } else { least }
    };
    let may_meet = |ranked: &&Ranked| {
        // Fixed maps do not move into each other.
        let may_meet = map.keyframe(ranked.keyframe).map == own.map || !map.has_fixed();
        may_meet && !is_own_visit(map, keyframe, began, ranked.keyframe)
    };
    let found = ranked.iter().filter(is_alike).find(may_meet)?;
    Some((found.keyframe, found.score < least))
}

/// Whether a keyframe belongs to the same visit as another one, which began with the third.
fn is_own_visit(map: &Map, keyframe: KeyframeId, began: KeyframeId, other: KeyframeId) -> bool {
    let is_old = other.index() + RECENT < keyframe.index() && other < began;
    map.keyframe(other).map == map.keyframe(keyframe).map && !is_old
}

/// Makes one of landmarks that are the same, and links the others to the keyframes that see them.
pub(super) fn fuse(map: &mut Map, sightings: &[Sighting]) {
    for sighting in sightings {
        for (old, new) in &sighting.same {
            map.fuse(*old, *new);
        }
        for feature in &sighting.features {
            if map.landmark(feature.landmark).is_converged() {
                map.add_observation(feature.landmark, feature.in_keyframe(sighting.keyframe));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{atlas::Similarity, lie::CameraFromWorld};

    /// What keyframes in a row say that found so many landmarks of an earlier place.
    fn seen(num_found: &[usize], is_faint: bool) -> Hypothesis {
        let sighting = |(index, num): (usize, &usize)| Sighting {
            keyframe: KeyframeId(100 + index as u32),
            around: KeyframeId(0),
            pose_there: CameraFromWorld::identity(),
            old_from_new: Similarity::identity(),
            found: (*num, 100),
            features: Vec::new(),
            same: Vec::new(),
            depth: 1.0,
        };
        let sightings = num_found.iter().enumerate().map(sighting).collect();
        Hypothesis { map: MapId(0), candidate: KeyframeId(0), is_faint, sightings, num_missed: 0 }
    }

    /// The active map where it is not the one of the earlier place.
    const ANOTHER: MapId = MapId(1);

    #[test]
    fn a_faint_place_is_joined_once_no_more_of_it_comes_into_view() {
        assert!(!seen(&[60, 60], false).is_sure(ANOTHER), "two keyframes are too few");
        assert!(seen(&[60, 70, 80], false).is_sure(ANOTHER));
        assert!(!seen(&[60, 70, 80], true).is_sure(ANOTHER), "the next one may show more");
        assert!(seen(&[60, 70, 80, 80], true).is_sure(ANOTHER));
        let missed = Hypothesis { num_missed: 1, ..seen(&[60, 70, 80], true) };
        assert!(missed.is_sure(ANOTHER), "it is out of view");
    }

    #[test]
    fn a_room_with_the_same_windows_is_not_joined() {
        assert!(!seen(&[26, 27, 25, 25], true).is_sure(ANOTHER), "most that should be there is not");
        assert!(seen(&[26, 27, 25, 55, 45], true).is_sure(ANOTHER), "the camera has come nearer");
        assert!(seen(&[26, 27, 25], false).is_sure(MapId(0)), "a loop is known by the way, too");
    }
}
