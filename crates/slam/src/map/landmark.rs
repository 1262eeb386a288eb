//! Landmarks.

use nalgebra::Point3;

use super::{KeyframeId, Observation, Observations};
use crate::mapping::DepthFilter;

/// Number of a landmark, in order of creation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LandmarkId(pub(crate) u32);

impl LandmarkId {
    /// As an index.
    #[inline]
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// How much is known of a landmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LandmarkState {
    /// Its depth is still uncertain; its place follows its host keyframe.
    Candidate,
    /// Its place is known.
    Converged,
    /// It is no longer part of the map.
    Removed,
}

/// A point of the world.
#[derive(Debug, Clone)]
pub struct Landmark {
    /// Place, map units.
    pub point_in_world: Point3<f64>,
    /// Where keyframes see it; the first is its host.
    pub observations: Observations,
    /// Inverse depth along the host's ray (z = 1), while it is a candidate.
    pub filter: Option<Box<DepthFilter>>,
    /// Frames in which it should have been seen.
    pub num_visible: u32,
    /// Frames in which it was found.
    pub num_found: u32,
    /// Misses in a row.
    pub num_missed: u32,
    /// Frame in which it was made.
    pub made_at: u32,
}

impl Landmark {
    /// The observation that it was made from.
    ///
    /// # Panics
    /// If the landmark was removed.
    #[inline]
    #[must_use]
    pub fn host(&self) -> Observation {
        self.observations.at(0)
    }

    /// What stands for every landmark that was removed: a map that is used for hours has given out far more numbers than it has
    /// landmarks.
    pub(super) fn removed() -> Self {
        Self {
            point_in_world: Point3::origin(),
            observations: Observations::from(Vec::new()),
            filter: None,
            num_visible: 0,
            num_found: 0,
            num_missed: 0,
            made_at: 0,
        }
    }

    /// Its depth, if it is still a candidate, is so many times as large.
    pub(super) fn scale_depth(&mut self, factor: f64) {
        if let Some(filter) = &mut self.filter {
            **filter = filter.with_depths_times(factor);
        }
    }

    /// How much is known of it.
    #[inline]
    #[must_use]
    pub fn state(&self) -> LandmarkState {
        match &self.filter {
            Some(_) => LandmarkState::Candidate,
            None if self.is_alive() => LandmarkState::Converged,
            None => LandmarkState::Removed,
        }
    }

    /// Whether its place is known.
    #[inline]
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.filter.is_none() && self.is_alive()
    }

    /// Whether it is part of the map.
    #[inline]
    #[must_use]
    pub fn is_alive(&self) -> bool {
        !self.observations.is_empty()
    }

    /// What a keyframe sees of it.
    #[must_use]
    pub fn observation_in(&self, keyframe: KeyframeId) -> Option<Observation> {
        self.observations.of(keyframe)
    }
}
