//! What came of a place that looks like one that was seen before.

use std::fmt;

use crate::{
    map::{KeyframeId, MapId},
    recognize::Refusal,
};

/// What came of a place that looks like one that was seen before.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Meeting {
    /// It is another place.
    Refused {
        /// The earlier keyframe.
        candidate: KeyframeId,
        /// Why.
        reason: Refusal,
    },
    /// It may be the same; more keyframes have to agree.
    Pending {
        /// The earlier keyframe.
        candidate: KeyframeId,
        /// Keyframes that agree so far.
        num: usize,
        /// Landmarks of the earlier place that the newest of them shows, and places of the image in which they were searched.
        found: (usize, usize),
    },
    /// Two maps became one.
    Joined {
        /// The map that is no longer there.
        map: MapId,
        /// The map that it became part of.
        into: MapId,
        /// Factor on its lengths.
        scale: f64,
    },
    /// Tracking closed a loop: it found landmarks of an earlier visit.
    Followed {
        /// A keyframe of that visit.
        candidate: KeyframeId,
    },
    /// A loop was closed.
    Closed {
        /// The earlier keyframe.
        candidate: KeyframeId,
        /// Distance by which the way had drifted, share of its length since the earlier keyframe.
        drift: f64,
        /// Factor on the lengths of the newest keyframe.
        scale: f64,
    },
}

impl fmt::Display for Meeting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused { candidate, reason } => {
                write!(f, "not the place of keyframe {}: {reason}", candidate.index())
            }
            Self::Pending { candidate, num, found: (found, searched) } => write!(
                f,
                "perhaps the place of keyframe {}: {num} agree; {found} of {searched} landmarks found",
                candidate.index()
            ),
            Self::Joined { map, into, scale } => {
                write!(f, "map {} joined to map {}, scale {scale:.3}", map.index(), into.index())
            }
            Self::Followed { candidate } => {
                write!(f, "loop closed by tracking at keyframe {}", candidate.index())
            }
            Self::Closed { candidate, drift, scale } => write!(
                f,
                "loop closed at keyframe {}: drift {:.2} % of the way, scale {scale:.3}",
                candidate.index(),
                100.0 * drift
            ),
        }
    }
}
