//! Keyframes.

use std::sync::Arc;

use nalgebra::Point3;
use visloc_core::{
    Timestamp,
    geom::{Camera, CameraFrame, Rigid3},
};

use super::{KeyframePicture, LandmarkId};
use crate::{
    image::Pyramid,
    lie::CameraFromWorld,
    odometry::OdomPose,
    recognize::View,
    shutter::{Exposure, Readout},
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

/// Number of a map, in order of the starts. Maps that were joined have the number of the older one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MapId(pub(crate) u32);

impl MapId {
    /// As an index.
    #[inline]
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The camera of an earlier session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionCamera {
    /// As calibrated.
    pub calibrated: Camera,
    /// As the map knew it in the end.
    pub camera: Camera,
    /// How long it took to expose an image, as the map knew it in the end.
    pub readout: Readout,
}

impl SessionCamera {
    /// A camera that is as it was calibrated, as far as maps know.
    #[must_use]
    pub fn as_calibrated(camera: &Camera) -> Self {
        Self { calibrated: *camera, camera: *camera, readout: Readout::default() }
    }
}

/// A frame that the map keeps.
#[derive(Debug, Clone)]
pub struct Keyframe {
    /// Number of the frame in the sequence; 0 for a keyframe of an earlier session.
    pub frame: usize,
    /// When it was taken.
    pub at: Timestamp,
    /// The camera, if it was taken by another one than the camera that is followed now.
    pub foreign: Option<Arc<SessionCamera>>,
    /// Its image; dropped when the keyframe is culled.
    pub picture: Option<KeyframePicture>,
    /// What the place is recognized by; nothing until it was described, and once culled.
    pub view: Option<Arc<View>>,
    /// The map that it belongs to.
    pub map: MapId,
    /// Gradient noise of its levels, see [`crate::feature::gradient_noise`].
    pub gradient_noise: Vec<f32>,
    /// Landmarks observed here, in order of observation; copies of the keyframe share them.
    pub landmarks: Arc<Vec<LandmarkId>>,
    /// The keyframe that it has only turned from: both cameras are at the same place. It may have been culled since, see
    /// [`super::Map::turned_from`].
    pub turned_from: Option<KeyframeId>,
    /// Where the odometry has it.
    pub odometry: Option<OdomPose>,
    /// How it was exposed, if that is known.
    pub exposure: Option<Exposure>,
    pub(super) camera_from_world: CameraFromWorld,
    pub(super) center_in_world: Point3<f64>,
    /// Its unit of length, in units of the time when it was made: it changes when loops are closed and maps are joined.
    pub(super) scale: f64,
    /// Once culled: the keyframe that it hangs on.
    pub(super) anchor: Option<Anchor>,
    /// Whether its whole map was given up.
    pub(super) is_given_up: bool,
}

/// What a culled keyframe hangs on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Anchor {
    pub keyframe: KeyframeId,
    /// Pose of the culled keyframe relative to it.
    pub camera_from_anchor: Rigid3<CameraFrame, CameraFrame>,
    /// Scale of the anchor at that time.
    pub scale: f64,
}

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

    /// Its image and the halvings of it; `None` once culled.
    #[must_use]
    pub fn pyramid(&self) -> Option<Arc<Pyramid>> {
        self.picture.as_ref().and_then(KeyframePicture::pyramid)
    }

    /// The camera that took it, where `own` is the one that is followed now.
    #[inline]
    #[must_use]
    pub fn camera<'a>(&'a self, own: &'a Camera) -> &'a Camera {
        self.foreign.as_ref().map_or(own, |foreign| &foreign.camera)
    }

    /// Whether it is still part of the map.
    #[inline]
    #[must_use]
    pub fn is_alive(&self) -> bool {
        self.anchor.is_none() && !self.is_given_up
    }
}
