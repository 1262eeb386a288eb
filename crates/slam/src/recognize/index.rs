//! An index of places that grows with the map.

use std::sync::LazyLock;

use rand::seq::SliceRandom;
use visloc_core::RngTree;

use super::{
    View,
    lists::{Entry, LESS_ALIKE, Listed, Lists, MOST_DIFFERENT},
};
use crate::{map::KeyframeId, orb::OrbDescriptor};

/// Tables. A descriptor of the same place, of which one bit in eight differs, has the same key in two of three places in at least
/// one of them.
const NUM_TABLES: usize = 4;
/// Bits of a key: as many as keep the lists short for some thousand keyframes.
const KEY_BITS: usize = 13;
/// Lists of all tables.
const NUM_LISTS: usize = NUM_TABLES << KEY_BITS;
/// Bits of a signature, which tells the descriptors of one list apart.
const SIGNATURE_BITS: usize = 32;
/// Length from which on a list may be passed over, mean lengths.
const STOPPED: usize = 12;
/// The same, descriptors: short ones cost nothing.
const LEAST_STOPPED: usize = 48;

/// Which bits of a descriptor make the keys and the signature: drawn once and for all, none of them twice.
static BITS: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut bits: Vec<u8> = (0..=255).collect();
    bits.shuffle(&mut RngTree::new(2018).stream("place index", 0));
    bits.truncate(NUM_TABLES * KEY_BITS + SIGNATURE_BITS);
    bits
});

/// A keyframe that looks alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ranked {
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Descriptors in common, each weighed by how few keyframes have it, in relation to how many the keyframe has: one that has many has
    /// something in common with every image. Source for the weights: Sivic and Zisserman, "Video Google", 2003.
    pub score: f32,
    /// Descriptors in common.
    pub num_shared: u32,
}

/// A place of a view and one of a keyframe that look alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Alike {
    /// Index of the place in its view.
    pub place: usize,
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Index of the place in the view of the keyframe.
    pub known: usize,
}

/// Finds the keyframes that look most like a view. There is no vocabulary to learn: a descriptor is listed under some of its own
/// bits, in several tables with different bits, and what is listed together is compared by other bits.
///
/// Source: Indyk and Motwani, "Approximate nearest neighbors", 1998 (bit sampling for Hamming distances).
#[derive(Debug, Clone, Default)]
pub struct PlaceIndex {
    /// For each table and key, one after the other, what is listed there.
    lists: Lists,
    num_keyframes: usize,
    /// Number of descriptors of each keyframe.
    sizes: Vec<u32>,
}

impl PlaceIndex {
    /// How many keyframes can be found.
    #[must_use]
    pub fn len(&self) -> usize {
        self.num_keyframes
    }

    /// Whether it has no keyframe.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.num_keyframes == 0
    }

    /// Adds a keyframe.
    pub fn add(&mut self, keyframe: KeyframeId, view: &View) {
        for (number, descriptor) in view.descriptors().enumerate() {
            let listed = (signature(descriptor), Entry::new(keyframe, number));
            for list in lists_of(descriptor) {
                self.lists.add(NUM_LISTS, list, listed);
            }
        }
        self.count(keyframe, view);
    }

    fn count(&mut self, keyframe: KeyframeId, view: &View) {
        if keyframe.index() >= self.sizes.len() {
            self.sizes.resize(keyframe.index() + 1, 0);
        }
        self.sizes[keyframe.index()] = view.len() as u32;
        self.num_keyframes += 1;
    }

    /// Takes a keyframe out that was added with this view.
    pub fn remove(&mut self, keyframe: KeyframeId, view: &View) {
        for list in view.descriptors().flat_map(lists_of) {
            self.lists.remove(list, keyframe);
        }
        self.num_keyframes -= 1;
    }

    /// With the keyframes of a map that was read, in order.
    pub(crate) fn read<'a>(views: impl Iterator<Item = (KeyframeId, &'a View)> + Clone) -> Self {
        let mut index = Self::default();
        let num = views.clone().map(|(_, view)| view.len()).sum();
        let mut places = Vec::with_capacity(num);
        for (keyframe, view) in views {
            for (number, descriptor) in view.descriptors().enumerate() {
                let lists = lists_of(descriptor).map(|list| list as u16);
                places.push((lists, signature(descriptor), Entry::new(keyframe, number)));
            }
            index.count(keyframe, view);
        }
        index.lists = Lists::read(NUM_LISTS, &places);
        index
    }

    /// Keyframes that look like a view, those most alike first.
    #[must_use]
    pub fn query(&self, view: &View) -> Vec<Ranked> {
        self.query_beside(view, |_| false)
    }

    /// As [`PlaceIndex::query`], but lists that are far longer than others are passed over: what is listed there is everywhere, and most of
    /// the time goes into it. Source: Sivic and Zisserman, "Video Google", 2003, section 4.1 (stop list).
    ///
    /// With them, which of their places look alike.
    #[must_use]
    pub fn query_rare(&self, view: &View) -> (Vec<Ranked>, Vec<Alike>) {
        let mut alike = Vec::new();
        let mean = self.sizes.iter().map(|size| *size as usize).sum::<usize>() >> KEY_BITS;
        let ranked = self.ranked(view, |_| false, (LEAST_STOPPED.max(STOPPED * mean), |it| alike.push(it)));
        (ranked, alike)
    }

    /// The same for a view of a visit that is under way: what its own keyframes show, they show nearly the same. How much others have in common
    /// is counted as if there were none of them.
    #[must_use]
    pub fn query_beside(&self, view: &View, is_own: impl Fn(KeyframeId) -> bool) -> Vec<Ranked> {
        self.ranked(view, is_own, (usize::MAX, |_| ()))
    }

    /// Keyframes by lists up to a length.
    fn ranked(
        &self,
        view: &View,
        is_own: impl Fn(KeyframeId) -> bool,
        (most_listed, mut take_alike): (usize, impl FnMut(Alike)),
    ) -> Vec<Ranked> {
        let mut found: Vec<(f32, u32)> = vec![(0.0, 0); self.sizes.len()];
        // The number of the descriptor that each keyframe was found with last.
        let mut found_by: Vec<u32> = vec![0; self.sizes.len()];
        let mut near: Vec<(Entry, u32)> = Vec::new();
        let mut alike: Vec<KeyframeId> = Vec::new();
        for (number, descriptor) in (1_u32..).zip(view.descriptors()) {
            let wanted = signature(descriptor);
            near.clear();
            let lists = lists_of(descriptor).map(|list| self.lists.parts(list));
            let is_short = |parts: &[Listed<'_>; 2]| {
                parts.iter().map(|it| it.entries.len()).sum::<usize>() <= most_listed
            };
            let lists = lists.iter().filter(|parts| is_short(parts)).flatten();
            let is_other = |entry: &Entry| !is_own(entry.keyframe());
            let mut limit = MOST_DIFFERENT;
            lists.clone().for_each(|part| part.find(wanted, is_other, &mut limit, &mut near));
            // Where all others are less alike, all that are near count; where there are no others, none.
            let least =
                near.iter().filter(|(entry, _)| is_other(entry)).map(|(_, different)| *different).min();
            let Some(least) = least.or_else(|| {
                let has_others = !near.is_empty() && lists.flat_map(|part| part.entries).any(is_other);
                has_others.then_some(MOST_DIFFERENT)
            }) else {
                continue;
            };
            alike.clear();
            for (entry, different) in &near {
                let keyframe = entry.keyframe();
                let mut is_new = || std::mem::replace(&mut found_by[keyframe.index()], number) != number;
                if *different <= least + LESS_ALIKE && is_new() {
                    alike.push(keyframe);
                    if let Some(known) = entry.place() {
                        take_alike(Alike { place: number as usize - 1, keyframe, known });
                    }
                }
            }
            // What all have in common counts nothing where there are many.
            let weight = ((self.num_keyframes + 1) as f32 / alike.len().max(1) as f32).ln().powi(2);
            for keyframe in &alike {
                let (score, num_shared) = &mut found[keyframe.index()];
                *score += weight;
                *num_shared += 1;
            }
        }
        let mut ranked: Vec<Ranked> = (0_u32..)
            .map(KeyframeId)
            .zip(found)
            .filter(|(_, (_, num_shared))| *num_shared > 0)
            .map(|(keyframe, (score, num_shared))| {
                let score = score / (self.sizes[keyframe.index()] as f32).sqrt();
                Ranked { keyframe, score, num_shared }
            })
            .collect();
        ranked.sort_by(|a, b| b.score.total_cmp(&a.score));
        ranked
    }
}

/// The lists that a descriptor belongs to, one of each table.
fn lists_of(descriptor: &OrbDescriptor) -> [usize; NUM_TABLES] {
    std::array::from_fn(|table| {
        let bits = &BITS[table * KEY_BITS..(table + 1) * KEY_BITS];
        (table << KEY_BITS) | gather(descriptor, bits) as usize
    })
}

fn signature(descriptor: &OrbDescriptor) -> u32 {
    gather(descriptor, &BITS[NUM_TABLES * KEY_BITS..])
}

fn gather(descriptor: &OrbDescriptor, bits: &[u8]) -> u32 {
    bits.iter().fold(0, |gathered, bit| gathered << 1 | u32::from(descriptor.bit(usize::from(*bit))))
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use rand::{Rng as _, RngExt};
    use visloc_core::Rng;

    use super::*;
    use crate::recognize::Described;

    fn random(rng: &mut Rng) -> OrbDescriptor {
        OrbDescriptor::from_words(std::array::from_fn(|_| rng.next_u64()))
    }

    fn view(descriptors: impl Iterator<Item = OrbDescriptor>) -> View {
        let place = |descriptor| Described { px: Point2::origin(), level: 0, descriptor, landmark: None };
        descriptors.map(place).collect::<Vec<_>>().into()
    }

    /// A place as it is seen again: a third of it is new, and of the rest each bit is wrong with a probability of an eighth.
    fn seen_again(view_before: &View, rng: &mut Rng) -> View {
        let mut again = Vec::new();
        for place in view_before.iter() {
            if rng.random_range(0..3) == 0 {
                again.push(random(rng));
                continue;
            }
            let wrong: [u64; 4] = std::array::from_fn(|_| rng.next_u64() & rng.next_u64() & rng.next_u64());
            again.push(place.descriptor.with_wrong(wrong));
        }
        view(again.into_iter())
    }

    fn index_of(num: u32, rng: &mut Rng) -> (PlaceIndex, Vec<View>) {
        let mut index = PlaceIndex::default();
        let views: Vec<View> = (0..num)
            .map(|_| {
                let descriptors: Vec<OrbDescriptor> = (0..250).map(|_| random(rng)).collect();
                view(descriptors.into_iter())
            })
            .collect();
        for (id, view) in (0..).map(KeyframeId).zip(&views) {
            index.add(id, view);
        }
        (index, views)
    }

    #[test]
    fn a_place_is_found_among_others_until_it_is_removed() {
        let mut rng = RngTree::new(3).stream("index", 0);
        let (mut index, views) = index_of(60, &mut rng);
        for wanted in [0, 17, 59] {
            let again = seen_again(&views[wanted], &mut rng);
            let ranked = index.query(&again);
            assert_eq!(ranked[0].keyframe.index(), wanted);
            assert!(ranked[0].num_shared > 50, "{:?}", ranked[0]);
            let is_clear = ranked.get(1).is_none_or(|second| second.score < 0.2 * ranked[0].score);
            assert!(is_clear, "{ranked:?}");
        }
        // What every keyframe shows is passed over, and leaves the order as it is.
        let everywhere = random(&mut rng);
        for id in (100..400).map(KeyframeId) {
            index.add(id, &view(std::iter::repeat_n(everywhere, 5)));
        }
        let mut again = seen_again(&views[17], &mut rng);
        let rare = index.query_rare(&again).0;
        assert_eq!(rare[0].keyframe.index(), 17);
        let more: Vec<Described> =
            again.iter().chain(view(std::iter::repeat_n(everywhere, 100)).iter()).collect();
        again = more.into();
        assert_eq!(index.query_rare(&again).0, rare);
        (100..400).map(KeyframeId).for_each(|id| index.remove(id, &view(std::iter::once(everywhere))));
        index.remove(KeyframeId(17), &views[17]);
        let again = seen_again(&views[17], &mut rng);
        assert!(index.query(&again).iter().all(|ranked| ranked.keyframe != KeyframeId(17)));
        assert_eq!(index.len(), 59);
    }

    #[test]
    fn keyframes_that_were_read_are_found_as_those_that_were_added() {
        let mut rng = RngTree::new(4).stream("index", 0);
        let (mut added, views) = index_of(40, &mut rng);
        let all = (0..).map(KeyframeId).zip(&views);
        let mut read = PlaceIndex::read(all.clone().take(30));
        all.skip(30).for_each(|(id, view)| read.add(id, view));
        let again: Vec<View> =
            [3, 17, 35].into_iter().map(|wanted| seen_again(&views[wanted], &mut rng)).collect();
        let is_own = |id: KeyframeId| id.0 < 20;
        for removed in [None, Some(35), Some(3)] {
            for index in [&mut added, &mut read] {
                removed.into_iter().for_each(|id| index.remove(KeyframeId(id), &views[id as usize]));
            }
            for view in &again {
                assert_eq!(read.query_rare(view), added.query_rare(view));
                assert_eq!(read.query_beside(view, is_own), added.query_beside(view, is_own));
            }
            assert_eq!(read.len(), added.len());
        }
    }
}
