//! Looking on while a camera is found in a map.

use anyhow::Result;
use visloc_core::{CameraTrajectory, Frame, GrayFrame, Truth, geom::Camera};
use visloc_io::image_codec::resize_gray;
use visloc_slam::SlamConfig;
use visloc_vmap::{MapLocalizer, VisualMap};

/// An image, and what is known with it.
pub struct MapFrame {
    /// What the place is looked for in.
    pub gray: GrayFrame,
    /// Its camera.
    pub camera: Camera,
    /// All that a robot senses, and where it was, if the camera is on one.
    pub robot: Option<(Frame, Option<Truth>)>,
}

impl MapFrame {
    /// The same with the image shrunk by the whole number that makes its pixels about as fine as the finest of a map, which are `focal_px`
    /// pixels to the radian: what it shows finer has no counterpart there.
    #[must_use]
    pub fn no_finer_than(self, focal_px: Option<f64>) -> Self {
        let factor = focal_px.map_or(1.0, |focal_px| (self.camera.focal_px().0 / focal_px).round());
        if factor < 2.0 {
            return self;
        }
        let camera = self.camera.scaled(1.0 / factor);
        let image = resize_gray(self.gray.image, camera.size_px());
        Self { gray: GrayFrame { image, ..self.gray }, camera, ..self }
    }
}

/// Where a camera is to be looked for anew.
#[cfg_attr(not(feature = "ros2"), allow(dead_code, reason = "only services of ROS 2 ask for it"))]
pub enum MapWish {
    /// In the same map.
    Anew,
    /// In another one.
    In(Box<VisualMap>),
}

/// What there is to see after a frame.
#[cfg_attr(not(feature = "studio"), allow(dead_code))]
pub struct MapView<'a> {
    /// The map.
    pub map: &'a VisualMap,
    /// Where the camera really was.
    pub truth: Option<&'a CameraTrajectory>,
    /// After this frame.
    pub localizer: &'a MapLocalizer,
    /// The frame.
    pub frame: &'a MapFrame,
    /// Images of a live source that were left out so far.
    pub num_dropped: usize,
}

/// Somebody who looks on.
pub trait MapWatcher {
    /// What is asked for: to look for the camera anew, maybe with other parameters and another seed. Asking settles it.
    fn take_wish(&mut self, _config: &mut SlamConfig, _seed: &mut u64) -> Option<MapWish> {
        None
    }

    /// Called after every frame.
    fn look(&mut self, view: &MapView<'_>);

    /// Messages that could not be sent.
    fn num_unsent(&self) -> usize {
        0
    }

    /// Completes what is written.
    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
