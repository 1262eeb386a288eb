//! Keyframes.

use std::sync::Arc;

use nalgebra::Point3;
use visloc_core::Timestamp;

use super::LandmarkId;
use crate::{
    image::{Pyramid, SmallImage},
    lie::CameraFromWorld,
};

/// Number of a keyframe, in order of creation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyframeId(pub(crate) u32);

impl KeyframeId {
    /// As an index.
    #[inline]
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A frame that the map keeps.
#[derive(Debug, Clone)]
pub struct Keyframe {
    /// Number of the frame in the sequence.
    pub frame: usize,
    /// When it was taken.
    pub at: Timestamp,
    /// Its images; dropped when the keyframe is culled.
    pub pyramid: Option<Arc<Pyramid>>,
    /// The whole view in small.
    pub small: SmallImage,
    /// Gradient noise of its levels, see [`crate::feature::gradient_noise`].
    pub gradient_noise: Vec<f32>,
    /// Landmarks observed here, in order of observation.
    pub landmarks: Vec<LandmarkId>,
    /// The keyframe that it has only turned from: both cameras are at the same place. It may have been culled since, see
    /// [`super::Map::turned_from`].
    pub turned_from: Option<KeyframeId>,
    pub(super) camera_from_world: CameraFromWorld,
    pub(super) center_in_world: Point3<f64>,
    /// Once culled: the keyframe that it hangs on, and its pose relative to that.
    pub(super) anchor: Option<(KeyframeId, CameraFromAnchor)>,
}

/// Pose of a culled keyframe relative to the one it hangs on.
pub(super) type CameraFromAnchor =
    visloc_core::geom::Rigid3<visloc_core::geom::CameraFrame, visloc_core::geom::CameraFrame>;

impl Keyframe {
    /// Its pose.
    #[inline]
    #[must_use]
    pub fn camera_from_world(&self) -> &CameraFromWorld {
        &self.camera_from_world
    }

    /// Center of the camera, map units.
    #[inline]
    #[must_use]
    pub fn center_in_world(&self) -> &Point3<f64> {
        &self.center_in_world
    }

    /// Whether it is still part of the map.
    #[inline]
    #[must_use]
    pub fn is_alive(&self) -> bool {
        self.anchor.is_none()
    }
}
