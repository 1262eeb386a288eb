//! A tracked frame.

use std::sync::Arc;

use nalgebra::{Matrix2, Point2, Vector3};
use visloc_core::{Rng, Timestamp};

use super::Found;
use crate::{
    image::Pyramid,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Observation},
    odometry::OdomPose,
    shutter::{Exposure, Readout},
    timing::StageTimer,
};

/// An image that has just come in.
#[derive(Debug, Clone, Copy)]
pub struct Incoming<'a> {
    /// Number in the sequence.
    pub number: usize,
    /// When it was taken.
    pub at: Timestamp,
    /// Its images.
    pub pyramid: &'a Arc<Pyramid>,
    /// Where the odometry has the camera.
    pub odometry: Option<OdomPose>,
    /// With what the image has been put right.
    pub readout: Readout,
}

impl<'a> Incoming<'a> {
    /// An image of a camera without odometry, as it is.
    #[must_use]
    pub fn of_image(number: usize, at: Timestamp, pyramid: &'a Arc<Pyramid>) -> Self {
        Self { number, at, pyramid, odometry: None, readout: Readout::default() }
    }
}

/// What the work on a frame draws from and is measured by.
#[derive(Debug)]
pub struct FrameWork<'a> {
    /// Random choices.
    pub rng: &'a mut Rng,
    /// Times of the stages.
    pub timer: &'a mut StageTimer,
}

/// A landmark found in a frame.
#[derive(Debug, Clone, Copy)]
pub struct Feature {
    /// The landmark.
    pub landmark: LandmarkId,
    /// Pixel of level 0.
    pub px: Point2<f64>,
    /// The same on the plane z = 1, without distortion.
    pub ray: Vector3<f64>,
    /// Level on which it was measured.
    pub level: usize,
    /// Covariance of the place, squared pixels of level 0.
    pub covariance_px: Matrix2<f64>,
}

impl Feature {
    /// A landmark and where it was found.
    #[must_use]
    pub fn new(landmark: LandmarkId, found: &Found) -> Self {
        let Found { px, ray, level, covariance_px } = *found;
        Self { landmark, px, ray, level, covariance_px }
    }

    /// The same as an observation of a keyframe.
    #[must_use]
    pub fn in_keyframe(&self, keyframe: KeyframeId) -> Observation {
        let Self { px, ray, level, covariance_px, .. } = *self;
        Observation { keyframe, px, ray, level, covariance_px }
    }
}

/// A frame with its pose and the landmarks that agree with it.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Number in the sequence.
    pub number: usize,
    /// When it was taken.
    pub at: Timestamp,
    /// Its images.
    pub pyramid: Arc<Pyramid>,
    /// Its pose.
    pub camera_from_world: CameraFromWorld,
    /// Landmarks found in it.
    pub features: Vec<Feature>,
    /// The keyframe that it has only turned from: both cameras are at the same place.
    pub turned_from: Option<KeyframeId>,
    /// Where the odometry has it.
    pub odometry: Option<OdomPose>,
    /// How it was exposed, if that is known.
    pub exposure: Option<Exposure>,
}
