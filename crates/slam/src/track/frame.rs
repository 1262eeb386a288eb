//! A tracked frame.

use std::sync::Arc;

use nalgebra::{Point2, Vector3};
use visloc_base::Timestamp;

use crate::{image::Pyramid, lie::CameraFromWorld, map::LandmarkId};

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
}
