//! Loops that tracking closes by itself: it finds landmarks of an earlier visit again, so the way is bent where it meets them.

use super::recognizer::IN_A_ROW;
use crate::map::{KeyframeId, Map};

/// Fewest landmarks that a keyframe shares with one of an earlier visit.
const LEAST_SHARED: u32 = 20;
/// Keyframes in a row without a landmark in common that are between two visits.
const BETWEEN: usize = 10;
/// Keyframes after which the map is adjusted again while the visit goes on; then after twice as many, and so on.
const AGAIN_AFTER: usize = 10;

/// What a keyframe says about an earlier visit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RevisitStep {
    /// It is a new place.
    New,
    /// It is a place of an earlier visit.
    Known,
    /// The visit is sure to be there: three keyframes in a row say so.
    Began(KeyframeId),
    /// The visit goes on, and more is known of it than when the map was adjusted last.
    GoesOn,
}

/// Counts keyframes that share landmarks with an earlier visit.
#[derive(Debug, Clone, Default)]
pub struct Revisit {
    num_in_a_row: usize,
    next_after: usize,
}

impl Revisit {
    /// Takes note of a new keyframe.
    pub fn add(&mut self, map: &Map, keyframe: KeyframeId) -> RevisitStep {
        let Some(earlier) = earlier_visit(map, keyframe) else {
            *self = Self::default();
            return RevisitStep::New;
        };
        self.num_in_a_row += 1;
        if self.num_in_a_row == IN_A_ROW {
            self.next_after = IN_A_ROW + AGAIN_AFTER;
            return RevisitStep::Began(earlier);
        }
        if self.num_in_a_row == self.next_after {
            self.next_after *= 2;
            return RevisitStep::GoesOn;
        }
        RevisitStep::Known
    }
}

/// Whether a place of the map that is tracked was visited again.
pub fn was_seen_again(map: &Map) -> bool {
    map.keyframes().any(|(id, _)| earlier_visit(map, id).is_some())
}

/// The newest keyframe of an earlier visit that shares landmarks with a keyframe.
fn earlier_visit(map: &Map, keyframe: KeyframeId) -> Option<KeyframeId> {
    let began = visit_began(map, keyframe);
    let connected = map.connected(keyframe, LEAST_SHARED);
    let earlier = connected.iter().map(|(id, _)| *id).filter(|id| *id < began);
    earlier.filter(|id| map.keyframe(*id).map == map.active()).max()
}

/// The first keyframe of the visit that a keyframe belongs to: before it, many keyframes in a row share no landmark with it.
pub fn visit_began(map: &Map, keyframe: KeyframeId) -> KeyframeId {
    let mut connected: Vec<KeyframeId> = map.connected(keyframe, 1).into_iter().map(|(id, _)| id).collect();
    connected.sort_unstable();
    let (mut began, mut num_between) = (keyframe, 0);
    for (id, _) in map.keyframes().rev().filter(|(id, _)| *id < keyframe) {
        if connected.binary_search(&id).is_ok() {
            (began, num_between) = (id, 0);
        } else {
            num_between += 1;
        }
        if num_between >= BETWEEN {
            break;
        }
    }
    began
}
