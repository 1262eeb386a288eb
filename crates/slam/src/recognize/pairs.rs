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
pub(crate) const MOST_DIFFERENT: u32 = 64;
/// Different bits from which on a landmark does not matter, be it the second most alike one.
const MOST_COMPARED: u32 = 76;
/// Share of the different bits of the second most alike landmark that the most alike one may have at most.
pub(crate) const LESS_THAN_SECOND: f64 = 0.85;
/// The first quarter of the bits may have a third of the different bits that are allowed: more is rare where the rest is alike.
const FIRST_WORD: u32 = 3;

/// Landmarks whose descriptors are compared at once.
const BLOCK: usize = 32;

/// Landmarks with their descriptors, word by word: the first word alone tells most of them apart.
#[derive(Default)]
pub(super) struct Known {
    pub ids: Vec<LandmarkId>,
    /// Levels on which they were described.
    pub levels: Vec<i32>,
    first_words: Vec<u64>,
    descriptors: Vec<OrbDescriptor>,
}

impl Known {
    /// The converged landmarks of some keyframes, each as the first of them sees it.
    pub fn of(map: &Map, keyframes: &[KeyframeId]) -> Self {
        let mut known = Self::default();
        let mut is_known = vec![false; map.num_landmark_ids()];
        let views = keyframes.iter().filter_map(|id| map.keyframe(*id).view.as_deref());
        for place in views.flat_map(View::iter) {
            if let Some(id) = place.landmark.filter(|id| map.landmark(*id).is_converged())
                && !std::mem::replace(&mut is_known[id.index()], true)
            {
                known.ids.push(id);
                known.levels.push(place.level);
                known.first_words.push(place.descriptor.first_word());
                known.descriptors.push(place.descriptor);
            }
        }
        known
    }

    /// The landmark that is most like a descriptor, if it is clearly more alike than any other.
    fn best(&self, descriptor: &OrbDescriptor) -> Option<(LandmarkId, u32)> {
        let mut nearest = Nearest::default();
        let wanted = descriptor.first_word();
        for (block, words) in self.first_words.chunks(BLOCK).enumerate() {
            let mut different = [0_u32; BLOCK];
            for (different, word) in different.iter_mut().zip(words) {
                *different = (word ^ wanted).count_ones();
            }
            for (i, first) in different[..words.len()].iter().enumerate() {
                let limit = nearest.second.min(MOST_COMPARED);
                if FIRST_WORD * first > limit {
                    continue;
                }
                let index = BLOCK * block + i;
                nearest.offer(index, descriptor.distance(&self.descriptors[index]));
            }
        }
        nearest.clear().map(|(index, distance)| (self.ids[index], distance))
    }
}

/// The most alike of some landmarks, and how alike the second one is.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    index: usize,
    least: u32,
    second_index: usize,
    second: u32,
}

impl Default for Nearest {
    fn default() -> Self {
        Self { index: 0, least: u32::MAX, second_index: 0, second: u32::MAX }
    }
}

impl Nearest {
    #[inline]
    fn offer(&mut self, index: usize, distance: u32) {
        if distance < self.least {
            *self = Self { index, least: distance, second_index: self.index, second: self.least };
        } else if distance < self.second {
            (self.second_index, self.second) = (index, distance);
        }
    }

    /// Those that are alike at all, with their different bits.
    pub fn alike(&self) -> impl Iterator<Item = (usize, u32)> {
        let both = [(self.index, self.least), (self.second_index, self.second)];
        both.into_iter().filter(|(_, distance)| *distance <= MOST_DIFFERENT)
    }

    /// The most alike one with its different bits, if it is clearly more alike than any other.
    pub fn clear(&self) -> Option<(usize, u32)> {
        let is_clear =
            self.least <= MOST_DIFFERENT && f64::from(self.least) < LESS_THAN_SECOND * f64::from(self.second);
        is_clear.then_some((self.index, self.least))
    }
}

/// Bits of a piece of a descriptor.
const PIECE_BITS: usize = 10;
/// Pieces of a descriptor; the few bits that are left over count nothing here.
const NUM_PIECES: usize = 256 / PIECE_BITS;
/// Pieces in common from which on two descriptors are compared: of those that differ in 48 bits anywhere, four in five have as many, and
/// of those of different places one in thirty.
const LEAST_COMMON: u8 = 2;

/// Most places of an image that are listed: more than there are.
const MOST_PLACES: usize = 1 << 12;

/// The places of an image listed under each piece of their descriptors.
///
/// Source: Norouzi, Punjani and Fleet, "Fast search in Hamming space with multi-index hashing", 2012.
pub(super) struct ByPieces {
    descriptors: Vec<OrbDescriptor>,
    /// For each piece of a descriptor and each of its values where the list of those that have it begins; at the end of the values the
    /// end of the last list.
    starts: Vec<u16>,
    /// The lists of each piece, which have every place once.
    listed: Vec<u16>,
}

impl ByPieces {
    /// Begins of lists for each piece.
    const STARTS: usize = (1 << PIECE_BITS) + 1;

    pub fn new(view: &View) -> Self {
        let descriptors: Vec<OrbDescriptor> = view.descriptors().take(MOST_PLACES).copied().collect();
        let num = descriptors.len();
        let mut starts = vec![0; NUM_PIECES * Self::STARTS];
        let mut listed = vec![0; NUM_PIECES * num];
        let pieces = starts.chunks_exact_mut(Self::STARTS).zip(listed.chunks_exact_mut(num.max(1)));
        for (piece, (starts, listed)) in pieces.enumerate() {
            let value = |descriptor: &OrbDescriptor| descriptor.bits(PIECE_BITS * piece, PIECE_BITS) as usize;
            for place in &descriptors {
                starts[value(place) + 1] += 1;
            }
            let mut total = 0;
            for start in &mut *starts {
                total += *start;
                *start = total;
            }
            // Filled from behind, each list ends where the next one begins.
            for (index, place) in (0..num as u16).zip(&descriptors).rev() {
                let end = &mut starts[value(place) + 1];
                *end -= 1;
                listed[usize::from(*end)] = index;
            }
            starts.rotate_left(1);
            starts[Self::STARTS - 1] = num as u16;
        }
        Self { descriptors, starts, listed }
    }

    /// For each place the landmarks that are most like it, of those that have some pieces in common with it.
    pub fn nearest(&self, known: &Known) -> Vec<Nearest> {
        let num = self.descriptors.len();
        let mut nearest = vec![Nearest::default(); num];
        let mut num_common = [0_u8; MOST_PLACES];
        // Places that are compared. Written without branches, which nobody can predict here.
        let mut compared = [0_u16; MOST_PLACES];
        for (index, descriptor) in known.descriptors.iter().enumerate() {
            num_common[..num].fill(0);
            let mut num_compared = 0;
            // Where all lists lie is looked up first: how long each one is cannot be predicted, and nothing is fetched beyond.
            let mut ranges = [[0_u16; 2]; NUM_PIECES];
            for (piece, (range, starts)) in
                ranges.iter_mut().zip(self.starts.chunks_exact(Self::STARTS)).enumerate()
            {
                let value = descriptor.bits(PIECE_BITS * piece, PIECE_BITS) as usize;
                *range = [starts[value], starts[value + 1]];
            }
            for ([start, end], listed) in ranges.iter().zip(self.listed.chunks_exact(num.max(1))) {
                for place in &listed[usize::from(*start)..usize::from(*end)] {
                    let common = &mut num_common[usize::from(*place) % MOST_PLACES];
                    *common += 1;
                    compared[num_compared % MOST_PLACES] = *place;
                    num_compared += usize::from(*common == LEAST_COMMON);
                }
            }
            for place in compared[..num_compared].iter().map(|place| usize::from(*place)) {
                let distance = descriptor.distance(&self.descriptors[place]);
                if distance < MOST_COMPARED {
                    nearest[place].offer(index, distance);
                }
            }
        }
        nearest
    }
}

/// The most alike converged landmark of some keyframes for each place of an image: clearly more alike than any other, and itself
/// most like this place.
#[must_use]
pub fn pair_views(map: &Map, view: &View, keyframes: &[KeyframeId]) -> Vec<Pair> {
    let known = Known::of(map, keyframes);
    let places = view.descriptors().enumerate();
    let mut pairs: Vec<Pair> = places
        .filter_map(|(place, descriptor)| {
            let (landmark, distance) = known.best(descriptor)?;
            Some(Pair { place, landmark, distance })
        })
        .collect();
    // Each landmark for the place that is most like it.
    pairs.sort_by_key(|pair| (pair.landmark, pair.distance, pair.place));
    pairs.dedup_by_key(|pair| pair.landmark);
    pairs.sort_by_key(|pair| pair.place);
    pairs
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use rand::Rng as _;
    use visloc_core::RngTree;

    use super::*;
    use crate::recognize::Described;

    #[test]
    fn what_has_pieces_in_common_is_nearly_all_that_is_alike() {
        let mut rng = RngTree::new(6).stream("pairs", 0);
        let mut known = Known::default();
        for id in (0..600).map(LandmarkId) {
            let descriptor = OrbDescriptor::from_words(std::array::from_fn(|_| rng.next_u64()));
            known.ids.push(id);
            known.first_words.push(descriptor.first_word());
            known.descriptors.push(descriptor);
        }
        let mut places = Vec::new();
        let mut see = |descriptor| {
            places.push(Described { px: Point2::origin(), level: 0, descriptor, landmark: None });
        };
        for known_descriptor in &known.descriptors {
            // Each bit is wrong with a probability of an eighth.
            see(known_descriptor
                .with_wrong(std::array::from_fn(|_| rng.next_u64() & rng.next_u64() & rng.next_u64())));
        }
        let foreign = OrbDescriptor::from_words(std::array::from_fn(|_| rng.next_u64()));
        see(foreign);
        let view = View::from(places);
        let nearest = ByPieces::new(&view).nearest(&known);
        let found = |nearest: &Nearest| nearest.clear().map(|(index, distance)| (known.ids[index], distance));
        let best = view.descriptors().map(|descriptor| known.best(descriptor));
        let both: Vec<_> = best.zip(nearest.iter().map(found)).filter(|(best, _)| best.is_some()).collect();
        let num_same = both.iter().filter(|(best, found)| best == found).count();
        assert!(both.len() > 550 && num_same > both.len() - 6, "{num_same} of {}", both.len());
        assert_eq!(found(&nearest[600]), None);
    }
}
