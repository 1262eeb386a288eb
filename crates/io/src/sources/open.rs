//! Opening a source for what it is needed for.

use std::path::PathBuf;

use visloc_core::{CameraTrajectory, ImageSource, Picture, Source, SourceFrame};
use visloc_world::Map;

use crate::{
    bag::BagTopics,
    sequence::{Calibration, read_calibration},
    sources::{Host, Purpose, SourceAddress, SourceOptions, SourcesError, UntilStopped},
};

/// All that a robot senses.
pub struct OpenFrames {
    /// The frames.
    pub frames: Box<dyn Source<SourceFrame>>,
    /// The map that they belong to; simulations know it.
    pub map: Option<Map>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

visloc_core::debug_shows!([] OpenFrames { map, warnings });

/// Gray images of a calibrated camera.
pub struct OpenImages {
    /// The images.
    pub images: Box<dyn ImageSource>,
    /// True poses of the camera, if they are known.
    pub truth: Option<CameraTrajectory>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

visloc_core::debug_shows!([] OpenImages { warnings });

/// Pictures of any camera.
pub struct OpenPictures {
    /// The pictures.
    pub pictures: Box<dyn Source<Picture>>,
    /// The calibration that comes with them, and where it is from.
    pub calibration: Option<(Calibration, PathBuf)>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

visloc_core::debug_shows!([] OpenPictures { calibration, warnings });

/// What a kind of source is asked to open.
pub(crate) struct Request<'a> {
    pub address: SourceAddress<'a>,
    pub options: &'a SourceOptions,
    pub host: &'a Host,
}

impl<'a> Request<'a> {
    /// Refuses options that the source has no use for.
    fn new(
        text: &'a str,
        options: &'a SourceOptions,
        host: &'a Host,
        purpose: Purpose,
    ) -> Result<Self, SourcesError> {
        let address = SourceAddress::parse(text)?;
        address.check(options, purpose)?;
        Ok(Self { address, options, host })
    }

    /// That the source has no such thing.
    pub fn cannot<T>(&self, reason: impl Into<String>) -> Result<T, SourcesError> {
        Err(SourcesError::CannotDeliver { argument: self.address.text().into(), reason: reason.into() })
    }

    /// That no image came, and why if that is known.
    pub fn empty(&self, why: String) -> SourcesError {
        SourcesError::Empty { argument: self.argument(), why }
    }

    /// Names of topics and frames.
    pub fn topics(&self) -> BagTopics {
        self.options.topics.names()
    }

    /// What the user wrote.
    pub fn argument(&self) -> String {
        self.address.text().into()
    }
}

/// Opens a source for localization on a known map.
///
/// # Errors
/// If there is no such source, it has no use for an option, or it has no frames of a robot and they cannot be made of what it has.
pub fn open_frames(text: &str, options: &SourceOptions, host: &Host) -> Result<OpenFrames, SourcesError> {
    let request = Request::new(text, options, host, Purpose::Frames)?;
    let kind = request.address.kind();
    let open = (kind.frames.open)(&request)?;
    let frames = Box::new(UntilStopped::of_kind(open.frames, host, kind.is_live));
    Ok(OpenFrames { frames, ..open })
}

/// Opens a source for SLAM.
///
/// # Errors
/// If there is no such source, it has no use for an option, or it has no images of a calibrated camera.
pub fn open_images(text: &str, options: &SourceOptions, host: &Host) -> Result<OpenImages, SourcesError> {
    let request = Request::new(text, options, host, Purpose::Images)?;
    let kind = request.address.kind();
    let open = (kind.images.open)(&request)?;
    let images = Box::new(UntilStopped::of_kind(open.images, host, kind.is_live));
    Ok(OpenImages { images, ..open })
}

/// Opens a source for whoever looks at its pictures only: calibration, viewers.
///
/// # Errors
/// If there is no such source, or it has no use for an option.
pub fn open_pictures(text: &str, options: &SourceOptions, host: &Host) -> Result<OpenPictures, SourcesError> {
    let request = Request::new(text, options, host, Purpose::Pictures)?;
    let kind = request.address.kind();
    let open = (kind.pictures.open)(&request)?;
    let pictures = Box::new(UntilStopped::of_kind(open.pictures, host, kind.is_live));
    let calibration = match &options.camera {
        Some(path) => Some((read_calibration(path)?, path.clone())),
        None => open.calibration,
    };
    Ok(OpenPictures { pictures, calibration, warnings: open.warnings })
}
