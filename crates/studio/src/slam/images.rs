//! Where the images of a session come from.

use std::{path::Path, sync::Arc};

use visloc_core::{CameraTrajectory, GrayFrame, ImageSource, Source, geom::Camera};
use visloc_sim::CameraTour;

use crate::{
    StudioError,
    source::{Fed, Feed},
};

/// Images that are read ahead.
const NUM_AHEAD: usize = 2;
/// Pictures that are dark while somebody carries the camera elsewhere.
const CARRIED_FRAMES: usize = 12;

/// A source of images that has been opened.
pub struct OpenCamera {
    /// The images.
    pub images: Box<dyn ImageSource>,
    /// Where the camera was, if that is known.
    pub truth: Option<CameraTrajectory>,
}

/// Opens a source from its beginning, with the seed of whatever is random in it. A live one goes on where it is.
pub type ImagesOpener = Arc<dyn Fn(u64) -> Result<OpenCamera, StudioError> + Send + Sync>;

/// Where the images of a session come from.
#[derive(Clone)]
pub enum SequenceSource {
    /// A simulated tour by its name.
    Tour(String),
    /// Anything else, with its name, and whether it goes on by itself.
    Other(String, ImagesOpener, bool),
}

impl SequenceSource {
    /// The name as the beginning of that of a file.
    pub(super) fn stem(&self) -> String {
        let (Self::Tour(name) | Self::Other(name, ..)) = self;
        let name = Path::new(name).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
    }
}

/// Images of a session.
pub(super) enum Images {
    /// In a room where people can carry the camera away; with the pictures that are still dark.
    Tour(Box<CameraTour>, usize, bool),
    /// Read on a thread of their own.
    Fed(Camera, Feed<GrayFrame>),
}

impl Images {
    /// Images, truth and title.
    pub fn open(
        from: &SequenceSource,
        seed: u64,
    ) -> Result<(Self, Option<CameraTrajectory>, String), StudioError> {
        match from {
            SequenceSource::Tour(name) => {
                let tour = CameraTour::new(name, seed).map_err(|error| StudioError::input("tour", error))?;
                let truth = tour.truth();
                Ok((Self::Tour(Box::new(tour), 0, false), Some(truth), format!("sim:{name}")))
            }
            SequenceSource::Other(name, opener, is_live) => {
                let opener = Arc::clone(opener);
                let (images, truth) = Self::fed(move || opener(seed), *is_live)?;
                Ok((images, truth, name.clone()))
            }
        }
    }

    fn fed(
        open: impl FnOnce() -> Result<OpenCamera, StudioError> + Send + 'static,
        is_live: bool,
    ) -> Result<(Self, Option<CameraTrajectory>), StudioError> {
        let opened = move || {
            let OpenCamera { images, truth } = open()?;
            let head = (*images.camera(), truth);
            Ok((images, head))
        };
        let num_ahead = if is_live { 0 } else { NUM_AHEAD };
        let (feed, (camera, truth)) = Feed::start(opened, |images| images.next_item(), num_ahead)?;
        Ok((Self::Fed(camera, feed), truth))
    }

    pub fn camera(&self) -> &Camera {
        match self {
            Self::Tour(tour, ..) => tour.camera(),
            Self::Fed(camera, _) => camera,
        }
    }

    /// The next image, with another truth if somebody has carried the camera elsewhere.
    pub fn poll(&mut self) -> (Fed<GrayFrame>, Option<CameraTrajectory>) {
        let Self::Tour(tour, dark, is_covered) = self else {
            let Self::Fed(_, feed) = self else { return (Fed::End, None) };
            return (feed.poll(), None);
        };
        let mut truth = None;
        if *dark > 0 {
            *dark -= 1;
            if *dark == 0 {
                tour.kidnap();
                tour.cover(*is_covered);
                truth = Some(tour.truth());
            }
        }
        let next = match tour.next_item() {
            Some(Ok(frame)) => Fed::Item(frame),
            Some(Err(error)) => Fed::Failed(error),
            None => Fed::End,
        };
        (next, truth)
    }

    /// Somebody takes the camera and puts it down elsewhere; whether that is possible here.
    pub fn kidnap(&mut self) -> bool {
        let Self::Tour(tour, dark, _) = self else { return false };
        if *dark == 0 {
            *dark = CARRIED_FRAMES;
            tour.cover(true);
        }
        true
    }

    /// A hand over the camera; whether that is possible here.
    pub fn cover(&mut self, is_on: bool) -> bool {
        let Self::Tour(tour, dark, is_covered) = self else { return false };
        *is_covered = is_on;
        tour.cover(is_on || *dark > 0);
        true
    }

    /// Whether hands are in play, for the page: covered, carried; `None` where there are none.
    pub fn hands(&self) -> Option<(bool, bool)> {
        match self {
            Self::Tour(_, dark, is_covered) => Some((*is_covered, *dark > 0)),
            Self::Fed(..) => None,
        }
    }
}
