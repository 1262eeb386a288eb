//! What an index lists, by key.

use std::sync::Arc;

use crate::map::{KeyframeId, push_tightly};

/// Most different bits of two signatures of the same place: one in five. Of unrelated ones, one pair in a thousand is as near.
pub(super) const MOST_DIFFERENT: u32 = 6;

/// Different bits by which one that counts may be less alike than the most alike one.
pub(super) const LESS_ALIKE: u32 = 1;

/// Bits of the number of a place in its keyframe; of those with more places, the others do not tell how they lie.
const PLACE_BITS: u32 = 10;
/// Places that have a number of their own, and the number of all others.
const MOST_PLACES: usize = (1 << PLACE_BITS) - 1;

/// A place of a keyframe. There are as many as a map has places, in each table: keyframe and place share one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry(u32);

impl Entry {
    /// A keyframe is listed as long as its number fits: so many nobody makes in a month.
    pub fn new(keyframe: KeyframeId, place: usize) -> Self {
        Self(keyframe.0 << PLACE_BITS | place.min(MOST_PLACES) as u32)
    }

    pub fn keyframe(self) -> KeyframeId {
        KeyframeId(self.0 >> PLACE_BITS)
    }

    pub fn place(self) -> Option<usize> {
        let place = self.0 as usize & MOST_PLACES;
        (place < MOST_PLACES).then_some(place)
    }
}

/// What is listed together, signatures side by side: so that many are compared at a time.
#[derive(Debug, Clone, Default)]
struct List {
    signatures: Vec<u32>,
    entries: Vec<Entry>,
}

/// Signatures, or pairs, that are compared at once.
pub(super) const BLOCK: usize = 16;

/// A part of a list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Listed<'a> {
    signatures: &'a [u32],
    pub entries: &'a [Entry],
}

impl Listed<'_> {
    /// Adds those that are alike up to a limit, with how many bits are different. The limit falls to what counts beside the most alike one of
    /// others: of those that were added before, some may be above it.
    pub fn find(
        &self,
        wanted: u32,
        is_other: impl Fn(&Entry) -> bool,
        limit: &mut u32,
        near: &mut Vec<(Entry, u32)>,
    ) {
        let blocks = self.signatures.chunks(BLOCK).zip(self.entries.chunks(BLOCK));
        for (signatures, entries) in blocks {
            let mut different = [u32::MAX; BLOCK];
            match signatures.as_array() {
                // Of whole blocks the compiler makes vector instructions.
                Some(whole) => different = whole.map(|signature: u32| (signature ^ wanted).count_ones()),
                None => {
                    for (different, signature) in different.iter_mut().zip(signatures) {
                        *different = (signature ^ wanted).count_ones();
                    }
                }
            }
            // Most blocks have none, and their entries need not be fetched.
            let most = *limit;
            let is_alike = different.map(|different| u8::from(different <= most));
            if is_alike.iter().fold(0, |any, is_alike| any | is_alike) == 0 {
                continue;
            }
            for (entry, different) in
                entries.iter().zip(different).filter(|(_, different)| *different <= most)
            {
                near.push((*entry, different));
                if is_other(entry) {
                    *limit = (*limit).min(different + LESS_ALIKE);
                }
            }
        }
    }
}

/// All lists. What was read with a map lies in one piece, which copies share; what came later, in lists that grow.
#[derive(Debug, Clone, Default)]
pub(super) struct Lists {
    read: Arc<Read>,
    /// Empty until something is added.
    added: Vec<List>,
}

#[derive(Debug, Default)]
struct Read {
    num_keyframes: usize,
    /// Where each list begins, and where the last one ends; empty without any.
    starts: Vec<u32>,
    all: List,
}

impl Lists {
    /// Of places in order, each with its signature and the lists that it belongs to.
    pub fn read<const N: usize>(num_lists: usize, places: &[([u16; N], u32, Entry)]) -> Self {
        let mut starts = vec![0_u32; num_lists + 1];
        for list in places.iter().flat_map(|(lists, ..)| lists) {
            starts[usize::from(*list) + 1] += 1;
        }
        for list in 0..num_lists {
            starts[list + 1] += starts[list];
        }
        let num = N * places.len();
        let mut all = List { signatures: vec![0; num], entries: vec![Entry(0); num] };
        let mut next = starts.clone();
        for (lists, signature, entry) in places {
            for list in lists {
                let next = &mut next[usize::from(*list)];
                all.signatures[*next as usize] = *signature;
                all.entries[*next as usize] = *entry;
                *next += 1;
            }
        }
        let num_keyframes = places.last().map_or(0, |(_, _, entry)| entry.keyframe().index() + 1);
        Self { read: Arc::new(Read { num_keyframes, starts, all }), added: Vec::new() }
    }

    /// The parts of a list, in order.
    pub fn parts(&self, list: usize) -> [Listed<'_>; 2] {
        let read = match self.read.starts.get(list..list + 2) {
            Some([start, end]) => *start as usize..*end as usize,
            _ => 0..0,
        };
        let all = &self.read.all;
        let added = self.added.get(list).map_or((&[][..], &[][..]), |it| (&it.signatures, &it.entries));
        [
            Listed { signatures: &all.signatures[read.clone()], entries: &all.entries[read] },
            Listed { signatures: added.0, entries: added.1 },
        ]
    }

    /// Adds a place of a keyframe to one of so many lists.
    pub fn add(&mut self, num_lists: usize, list: usize, (signature, entry): (u32, Entry)) {
        if self.added.is_empty() {
            self.added = vec![List::default(); num_lists];
        }
        let List { signatures, entries } = &mut self.added[list];
        push_tightly(signatures, signature);
        push_tightly(entries, entry);
    }

    /// Takes a keyframe out of a list.
    pub fn remove(&mut self, list: usize, keyframe: KeyframeId) {
        if keyframe.index() < self.read.num_keyframes {
            self.take_apart();
        }
        let Some(List { signatures, entries }) = self.added.get_mut(list) else { return };
        let mut is_kept = entries.iter().map(|entry| entry.keyframe() != keyframe);
        signatures.retain(|_| is_kept.next().unwrap_or(false));
        entries.retain(|entry| entry.keyframe() != keyframe);
    }

    /// Makes lists of what lies in one piece.
    fn take_apart(&mut self) {
        let list = |list| {
            let parts = self.parts(list);
            List {
                signatures: parts.iter().flat_map(|part| part.signatures).copied().collect(),
                entries: parts.iter().flat_map(|part| part.entries).copied().collect(),
            }
        };
        self.added = (0..self.read.starts.len() - 1).map(list).collect();
        self.read = Arc::default();
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng as _, RngExt};
    use visloc_core::RngTree;

    use super::*;

    #[test]
    fn what_counts_is_found_whether_or_not_the_limit_falls() {
        let mut rng = RngTree::new(9).stream("lists", 0);
        let mut num_all = [0, 0];
        for num in [0, 5, 16, 50, 333] {
            let wanted = rng.next_u32();
            let wrong = |num| (0..num).fold(0, |wrong: u32, bit: u32| wrong | 1 << bit);
            let signatures: Vec<u32> =
                (0..num).map(|_| wanted ^ wrong(rng.random_range(1..12)).rotate_left(7)).collect();
            let entries: Vec<Entry> = (0..num).map(|i| Entry::new(KeyframeId(i % 9), i as usize)).collect();
            let list = Listed { signatures: &signatures, entries: &entries };
            let is_other = |entry: &Entry| entry.keyframe().0 != 3;
            let (mut all, mut few) = (Vec::new(), Vec::new());
            list.find(wanted, |_| false, &mut MOST_DIFFERENT.clone(), &mut all);
            list.find(wanted, is_other, &mut MOST_DIFFERENT.clone(), &mut few);
            let least =
                all.iter().filter(|(entry, _)| is_other(entry)).map(|(_, different)| *different).min();
            num_all[0] += all.len();
            num_all[1] += few.len();
            for near in [&mut all, &mut few] {
                near.retain(|(_, different)| *different <= least.unwrap_or(MOST_DIFFERENT) + LESS_ALIKE);
            }
            assert_eq!(all, few);
        }
        assert!(2 * num_all[1] < num_all[0], "{num_all:?}");
    }
}
