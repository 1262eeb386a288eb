//! Making one map of two that were made on their own, where both show the same places.

use std::collections::BTreeSet;

use visloc_core::{Clock, Rng, RngTree, geom::Camera};

use super::{
    Meeting,
    recognizer::{IN_A_ROW, fuse, move_over},
    sighting::Sighting,
};
use crate::{
    config::SlamConfig,
    map::{KeyframeId, LandmarkId, Map, MapId},
    mapping::{adjust_all, adjust_local},
    recognize::{Locator, Refusal},
    timing::StageTimer,
    track::{FrameWork, Incoming, focal_px},
};

/// Keyframes of the other map that are tried for each one: those that look most alike.
const TRIES: usize = 3;
/// Keyframes from which on a map is adjusted piece by piece: time and memory grow with their square.
const MOST_AT_ONCE: usize = 200;

/// How a map became part of another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Merged {
    /// Keyframes that show places of the other map and agree on how the maps lie to each other.
    pub num_keyframes: usize,
    /// Landmarks that are the same in both.
    pub num_same: usize,
    /// Factor on the lengths of the map that was moved.
    pub scale: f64,
}

/// Why two maps stay two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// Most keyframes that agree on how the maps lie to each other.
    pub num_agreeing: usize,
    /// Keyframes that may show a place of the other map.
    pub num_alike: usize,
    /// Keyframes that were looked at.
    pub num_keyframes: usize,
    /// Whether enough of them agree, but each misses most of what should be seen there.
    pub is_shown_too_little: bool,
    /// Why the last of them, or the one that agrees with most, is no place of the other map.
    pub reason: Option<Refusal>,
}

/// Makes the map `from` a part of the map `into`, whose frame and unit of length stay, as does all that is fixed. The cameras of the keyframes
/// are those that they came with; the seed fixes every random choice. Then `into` is the active map.
///
/// # Errors
/// If fewer than three keyframes agree on how the maps lie to each other, or none of them shows most of what is there; nothing has changed then.
pub fn merge(
    map: &mut Map,
    (from, into): (MapId, MapId),
    config: &SlamConfig,
    seed: u64,
) -> Result<Merged, Apart> {
    let mut rng = RngTree::new(seed).stream("merge", 0);
    let mut apart =
        Apart { num_agreeing: 0, num_alike: 0, num_keyframes: 0, is_shown_too_little: false, reason: None };
    let sightings = sightings(map, (from, into), config, &mut rng, &mut apart);
    apart.num_alike = sightings.len();
    let agreeing = |sighting: &Sighting| sightings.iter().filter(|other| sighting.agrees(map, other)).count();
    // The first of those with which most agree.
    let best = sightings.iter().rev().max_by_key(|sighting| agreeing(sighting));
    let camera = best.and_then(|best| map.keyframe(best.keyframe).foreign.as_deref()).map(|own| own.camera);
    let (Some(best), Some(camera)) = (best.filter(|best| agreeing(best) >= IN_A_ROW), camera) else {
        apart.num_agreeing = best.map_or(0, agreeing);
        return Err(apart);
    };
    let sure: Vec<Sighting> = sightings.iter().filter(|other| best.agrees(map, other)).cloned().collect();
    if !sure.iter().any(Sighting::shows_most) {
        let (num, of) = best.found;
        let reason = Some(Refusal::FewFound { num, of });
        return Err(Apart { num_agreeing: sure.len(), is_shown_too_little: true, reason, ..apart });
    }
    let best = best.clone();
    map.activate(from);
    let scale = match move_over(map, &best, into) {
        Meeting::Joined { scale, .. } => scale,
        _ => 1.0,
    };
    map.activate(into);
    // Each landmark counts once, however many keyframes show it.
    let same: BTreeSet<LandmarkId> = sure.iter().flat_map(|s| s.same.iter().map(|(_, new)| *new)).collect();
    let num_same = same.len();
    fuse(map, &sure);
    let focal = focal_px(&camera);
    if map.free_keyframes().count() <= MOST_AT_ONCE {
        adjust_all(map, &config.mapping, focal);
    } else {
        for sighting in &sure {
            adjust_local(map, sighting.keyframe, &config.mapping, focal);
        }
    }
    Ok(Merged { num_keyframes: sure.len(), num_same, scale })
}

/// The keyframes of a map that show places of another one.
fn sightings(
    map: &Map,
    (from, into): (MapId, MapId),
    config: &SlamConfig,
    rng: &mut Rng,
    apart: &mut Apart,
) -> Vec<Sighting> {
    let searched = map.with_active(into);
    let mut locator: Option<(Camera, Locator)> = None;
    let mut sightings = Vec::new();
    for (id, keyframe) in map.all_keyframes().filter(|(_, keyframe)| keyframe.map == from) {
        let Some(camera) = keyframe.foreign.as_deref().map(|own| own.camera) else { continue };
        if locator.as_ref().is_none_or(|(known, _)| *known != camera) {
            locator = Some((camera, Locator::new(&camera, config)));
        }
        let Some((_, locator)) = &locator else { continue };
        apart.num_keyframes += 1;
        match sight(&searched, id, into, locator, rng) {
            Ok(sighting) => sightings.push(sighting),
            Err(reason) => apart.reason = reason.or(apart.reason),
        }
    }
    sightings
}

/// Looks for a keyframe in a map, which is the active one.
fn sight(
    map: &Map,
    id: KeyframeId,
    into: MapId,
    locator: &Locator,
    rng: &mut Rng,
) -> Result<Sighting, Option<Refusal>> {
    let own = map.keyframe(id);
    let (pyramid, view) = (own.pyramid().ok_or(None)?, own.view.as_deref().ok_or(None)?);
    let incoming = Incoming::of_image(own.frame, own.at, &pyramid);
    let ranked = map.index().query_beside(view, |other| map.keyframe(other).map != into);
    let mut refused = None;
    for candidate in ranked.iter().filter(|ranked| map.keyframe(ranked.keyframe).map == into).take(TRIES) {
        let mut aside = StageTimer::start(Clock::still());
        let mut work = FrameWork { rng, timer: &mut aside };
        let located = locator.locate(map, candidate.keyframe, (view, &incoming), &mut work);
        match located.and_then(|located| Sighting::new(map, id, &located)) {
            Ok(sighting) => return Ok(sighting),
            Err(reason) => refused = refused.or(Some(reason)),
        }
    }
    Err(refused)
}
