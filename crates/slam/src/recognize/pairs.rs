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
/// The first quarter of the bits may have a third of the different bits that are allowed: more is rare where the rest is alike.
const FIRST_WORD: u32 = 3;

/// Landmarks whose descriptors are compared at once.
const BLOCK: usize = 32;

/// Landmarks with their descriptors, word by word: the first word alone tells most of them apart.
#[derive(Default)]
struct Known {
    ids: Vec<LandmarkId>,
    first_words: Vec<u64>,
    descriptors: Vec<OrbDescriptor>,
}

impl Known {
    /// The converged landmarks of some keyframes, each as the first of them sees it.
    fn of(map: &Map, keyframes: &[KeyframeId]) -> Self {
        let mut known = Self::default();
        let mut is_known = vec![false; map.num_landmark_ids()];
        let views = keyframes.iter().filter_map(|id| map.keyframe(*id).view.as_deref());
        for place in views.flat_map(|view| &view.places) {
            if let Some(id) = place.landmark.filter(|id| map.landmark(*id).is_converged())
                && !std::mem::replace(&mut is_known[id.index()], true)
            {
                known.ids.push(id);
                known.first_words.push(place.descriptor.first_word());
                known.descriptors.push(place.descriptor);
            }
        }
        known
    }

    /// The landmark that is most like a descriptor, if it is clearly more alike than any other.
    fn best(&self, descriptor: &OrbDescriptor) -> Option<(LandmarkId, u32)> {
        let (mut best, mut least, mut second) = (None, u32::MAX, u32::MAX);
        let wanted = descriptor.first_word();
        for (block, words) in self.first_words.chunks(BLOCK).enumerate() {
            let mut different = [0_u32; BLOCK];
            for (different, word) in different.iter_mut().zip(words) {
                *different = (word ^ wanted).count_ones();
            }
            for (i, first) in different[..words.len()].iter().enumerate() {
                let limit = second.min(MOST_COMPARED);
                if FIRST_WORD * first > limit {
                    continue;
                }
                let index = BLOCK * block + i;
                let distance = descriptor.distance(&self.descriptors[index]);
                if distance < least {
                    (best, least, second) = (Some(self.ids[index]), distance, least);
                } else {
                    second = second.min(distance);
                }
            }
        }
        let is_clear = least <= MOST_DIFFERENT && f64::from(least) < LESS_THAN_SECOND * f64::from(second);
        best.filter(|_| is_clear).map(|id| (id, least))
    }
}

/// The most alike converged landmark of some keyframes for each place of an image: clearly more alike than any other, and itself
/// most like this place.
#[must_use]
pub fn pair_views(map: &Map, view: &View, keyframes: &[KeyframeId]) -> Vec<Pair> {
    let known = Known::of(map, keyframes);
    let places = view.places.iter().enumerate();
    let mut pairs: Vec<Pair> = places
        .filter_map(|(place, described)| {
            let (landmark, distance) = known.best(&described.descriptor)?;
            Some(Pair { place, landmark, distance })
        })
        .collect();
    // Each landmark for the place that is most like it.
    pairs.sort_by_key(|pair| (pair.landmark, pair.distance, pair.place));
    pairs.dedup_by_key(|pair| pair.landmark);
    pairs.sort_by_key(|pair| pair.place);
    pairs
}
