//! Why a candidate does not count.

use std::fmt;

/// Why a keyframe that looks like an image is not taken for the same place.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// Too few descriptors have a landmark that looks alike.
    FewAlike {
        /// How many have one.
        num: usize,
    },
    /// Too few of them agree on one pose.
    NoCommonPose {
        /// How many agree at most.
        num: usize,
        /// How many there are.
        of: usize,
    },
    /// Around that pose, too few of the landmarks that should be seen are found.
    FewFound {
        /// Places of the image in which a landmark was found.
        num: usize,
        /// Places that were searched.
        of: usize,
    },
    /// What was found lies in a small part of the image.
    SmallPart {
        /// Parts of the image, of 16, with a landmark.
        parts: usize,
    },
    /// The landmarks of both maps do not agree on one scale.
    NoCommonScale {
        /// How many agree at most.
        num: usize,
        /// How many are known in both maps.
        of: usize,
    },
    /// The loop would bend the way farther than drift can.
    Implausible {
        /// Distance between both places in the map, share of the way between both visits.
        drift: f64,
        /// Turn between both, degrees.
        turn_deg: f64,
        /// Ratio of the scales.
        scale: f64,
    },
    /// Where the camera was lost between both maps, joining them would tear its way apart.
    Torn {
        /// Distance between both ends, share of the way since the earlier place.
        drift: f64,
        /// Turn between both, degrees.
        turn_deg: f64,
    },
    /// Other keyframes around do not agree.
    NotConsistent {
        /// How many agree.
        num: usize,
    },
}

fn percent(share: f64) -> f64 {
    100.0 * share
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewAlike { num } => write!(f, "only {num} corners look like a landmark"),
            Self::NoCommonPose { num, of } => write!(f, "only {num} of {of} alike corners agree on a pose"),
            Self::FewFound { num, of } => write!(f, "only {num} of {of} landmarks are found around the pose"),
            Self::SmallPart { parts } => write!(f, "landmarks are found in {parts} of 16 parts of the image"),
            Self::NoCommonScale { num, of } => write!(f, "only {num} of {of} landmarks agree on a scale"),
            Self::Implausible { drift, turn_deg, scale } => write!(
                f,
                "drift of {:.0} % of the way, {turn_deg:.0} degrees and a scale of {scale:.2} is not plausible",
                percent(*drift)
            ),
            Self::Torn { drift, turn_deg } => write!(
                f,
                "the ends of both maps where the camera was lost would be {turn_deg:.0} degrees and {:.0} % of the way apart",
                percent(*drift)
            ),
            Self::NotConsistent { num } => write!(f, "only {num} keyframes in a row agree"),
        }
    }
}
