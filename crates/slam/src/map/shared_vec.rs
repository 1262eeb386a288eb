//! A list that can be copied cheaply.

use std::{
    ops::{Index, IndexMut},
    sync::Arc,
};

/// Items of a chunk.
const CHUNK: usize = 128;

/// A growing list whose copies share their items; what is changed in one copy is copied first, unless no other copy has it.
/// So one thread can read a copy while another goes on writing.
#[derive(Debug)]
pub(super) struct SharedVec<T> {
    chunks: Vec<Arc<Vec<Arc<T>>>>,
}

impl<T> Default for SharedVec<T> {
    fn default() -> Self {
        Self { chunks: Vec::new() }
    }
}

impl<T> Clone for SharedVec<T> {
    fn clone(&self) -> Self {
        Self { chunks: self.chunks.clone() }
    }
}

impl<T> SharedVec<T> {
    pub fn len(&self) -> usize {
        self.chunks.last().map_or(0, |last| (self.chunks.len() - 1) * CHUNK + last.len())
    }

    pub fn push(&mut self, item: T) {
        match self.chunks.last_mut().filter(|last| last.len() < CHUNK) {
            Some(last) => Arc::make_mut(last).push(Arc::new(item)),
            None => self.chunks.push(Arc::new(vec![Arc::new(item)])),
        }
    }

    /// Puts an item in a place that other places, and other lists, may share.
    pub fn share(&mut self, index: usize, item: &Arc<T>) {
        Arc::make_mut(&mut self.chunks[index / CHUNK])[index % CHUNK] = Arc::clone(item);
    }

    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &T> + Clone {
        self.chunks.iter().flat_map(|chunk| chunk.iter().map(Arc::as_ref))
    }
}

impl<T> Index<usize> for SharedVec<T> {
    type Output = T;

    #[inline]
    fn index(&self, index: usize) -> &T {
        &self.chunks[index / CHUNK][index % CHUNK]
    }
}

impl<T: Clone> IndexMut<usize> for SharedVec<T> {
    #[inline]
    fn index_mut(&mut self, index: usize) -> &mut T {
        Arc::make_mut(&mut Arc::make_mut(&mut self.chunks[index / CHUNK])[index % CHUNK])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn behaves_as_a_vector_and_copies_do_not_see_changes(
            before in prop::collection::vec(0..100_u32, 0..400),
            changes in prop::collection::vec((any::<prop::sample::Index>(), 0..100_u32), 0..50),
            after in prop::collection::vec(0..100_u32, 0..200),
        ) {
            let mut plain = before.clone();
            let mut shared = SharedVec::default();
            before.iter().for_each(|item| shared.push(*item));
            let copy = shared.clone();
            for (index, value) in &changes {
                if !plain.is_empty() {
                    let index = index.index(plain.len());
                    plain[index] = *value;
                    shared[index] = *value;
                }
            }
            let same = Arc::new(7);
            for (index, _) in changes.iter().step_by(2).filter(|_| !before.is_empty()) {
                let index = index.index(before.len());
                plain[index] = *same;
                shared.share(index, &same);
            }
            for item in &after {
                plain.push(*item);
                shared.push(*item);
            }
            for (index, value) in changes.iter().skip(1).step_by(2).filter(|_| !before.is_empty()) {
                let index = index.index(before.len());
                plain[index] = *value;
                shared[index] = *value;
            }
            prop_assert_eq!(*same, 7);
            prop_assert_eq!(shared.len(), plain.len());
            prop_assert_eq!(shared.iter().copied().collect::<Vec<_>>(), plain.clone());
            prop_assert!((0..plain.len()).all(|i| shared[i] == plain[i]));
            prop_assert_eq!(copy.iter().copied().collect::<Vec<_>>(), before);
        }
    }
}
