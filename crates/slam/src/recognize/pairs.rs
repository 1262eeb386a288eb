//! Which landmark a place of an image may be.

use crate::{
    map::{KeyframeId, LandmarkId, Map},
    orb::OrbDescriptor,
    recognize::View,
};

/// A place of an image and the landmark that looks like it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// Index of the place in its view.
    pub place: usize,
    /// The landmark.
    pub landmark: LandmarkId,
    /// Different bits.
    pub distance: u32,
}

/// Most different bits of a pair. Thesis: 100 around a predicted place; here the place is not known.
const MOST_DIFFERENT: u32 = 64;
/// Different bits from which on a second most alike landmark does not matter.
const MOST_COMPARED: u32 = 76;
/// Share of the different bits of the second most alike landmark that the most alike one may have at most.
const LESS_THAN_SECOND: f64 = 0.85;

/// The most alike converged landmark of some keyframes for each place of an image: clearly more alike than any other, and itself
/// most like this place.
#[must_use]
pub fn pair_views(map: &Map, view: &View, keyframes: &[KeyframeId]) -> Vec<Pair> {
    let mut known: Vec<(LandmarkId, OrbDescriptor)> = Vec::new();
    for place in keyframes.iter().filter_map(|id| map.keyframe(*id).view.as_deref()).flat_map(|v| &v.places) {
        if let Some(id) = place.landmark.filter(|id| map.landmark(*id).is_converged()) {
            known.push((id, place.descriptor));
        }
    }
    let mut pairs: Vec<Pair> = view
        .places
        .iter()
        .enumerate()
        .filter_map(|(place, described)| {
            let (landmark, distance) = best(&described.descriptor, &known)?;
            Some(Pair { place, landmark, distance })
        })
        .collect();
    // Each landmark for the place that is most like it.
    pairs.sort_by_key(|pair| (pair.landmark, pair.distance, pair.place));
    pairs.dedup_by_key(|pair| pair.landmark);
    pairs.sort_by_key(|pair| pair.place);
    pairs
}

fn best(descriptor: &OrbDescriptor, known: &[(LandmarkId, OrbDescriptor)]) -> Option<(LandmarkId, u32)> {
    let mut best: Option<(LandmarkId, u32)> = None;
    let mut second = u32::MAX;
    for (id, other) in known {
        let Some(distance) = descriptor.distance_up_to(other, second.min(MOST_COMPARED)) else { continue };
        match best {
            Some((known, least)) if distance >= least => {
                if known != *id {
                    second = second.min(distance);
                }
            }
            Some((known, least)) => {
                if known != *id {
                    second = second.min(least);
                }
                best = Some((*id, distance));
            }
            None => best = Some((*id, distance)),
        }
    }
    best.filter(|(_, distance)| {
        *distance <= MOST_DIFFERENT && f64::from(*distance) < LESS_THAN_SECOND * f64::from(second)
    })
}
