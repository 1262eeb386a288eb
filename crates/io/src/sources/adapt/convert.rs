//! Frames of a robot, gray images and pictures, made of each other.

use std::path::PathBuf;

use visloc_core::{
    CalibratedImages, Frame, GrayFrame, GrayImage, ImageSource, Mapped, Picture, PutBack, Source,
    SourceError, SourceFrame, geom::Camera,
};

use super::{Shot, ranged::Ranged, same_size::SameSize};
use crate::{
    image_codec::resize_gray,
    sequence::{Calibration, SequenceRange, fit_calibration, read_calibration, resized},
    sources::{OpenFrames, OpenImages, OpenPictures, SourceOptions, SourcesError, open::Request},
};

/// The frames of a robot with one camera.
pub(crate) struct CameraFrames {
    pub camera: Camera,
    pub frames: Box<dyn Source<SourceFrame>>,
}

impl CameraFrames {
    /// The camera is that of the first frame; `None` if there is none.
    pub(crate) fn new(mut frames: Box<dyn Source<SourceFrame>>) -> Option<Result<Self, SourceError>> {
        let first = frames.next_item()?;
        Some(
            first.map(|first| Self {
                camera: first.frame.camera,
                frames: Box::new(PutBack::new(first, frames)),
            }),
        )
    }
}

/// The gray images of a robot's camera, with what its odometry says of it.
pub(crate) fn gray_of_frames(frames: Box<dyn Source<SourceFrame>>) -> Box<dyn Source<GrayFrame>> {
    Box::new(Mapped::new(frames, |frame| Ok(GrayFrame::of_robot(frame))))
}

/// The pictures of a robot's camera.
pub(crate) fn pictures_of_frames(frames: Box<dyn Source<SourceFrame>>) -> Box<dyn Source<Picture>> {
    Box::new(Mapped::new(frames, |SourceFrame { frame, .. }| {
        Ok(Picture { at: frame.at, image: frame.image, file: None })
    }))
}

/// Gray images as pictures.
pub(crate) fn pictures_of_images(images: Box<dyn ImageSource>) -> Box<dyn Source<Picture>> {
    Box::new(Mapped::new(images, |frame| {
        Ok(Picture { at: frame.at, image: frame.image.to_rgb(), file: None })
    }))
}

/// Images for SLAM from pictures; the calibration is the user's or the source's.
pub(crate) fn images_of_pictures(
    request: &Request<'_>,
    open: OpenPictures,
) -> Result<OpenImages, SourcesError> {
    let gray = Mapped::new(open.pictures, |picture| {
        Ok(GrayFrame::new(picture.at, GrayImage::from_rgb(&picture.image)))
    });
    images_of_gray(request, Box::new(gray), open.calibration, open.warnings)
}

/// Images for SLAM from gray ones; the calibration is the user's or the source's.
pub(crate) fn images_of_gray(
    request: &Request<'_>,
    gray: Box<dyn Source<GrayFrame>>,
    calibration: Option<(Calibration, PathBuf)>,
    mut warnings: Vec<String>,
) -> Result<OpenImages, SourcesError> {
    let SourceOptions { scale, usual, .. } = request.options;
    let (camera, images) = calibrated(request, gray, calibration, &mut warnings)?;
    let camera = match resized(&camera, *scale, usual.most_side_px, &mut warnings) {
        Ok(camera) => camera,
        Err(reason) => return request.cannot(reason),
    };
    let images = Mapped::new(images, move |frame: GrayFrame| {
        let image = resize_gray(frame.image, camera.size_px());
        Ok(GrayFrame { image, ..frame })
    });
    let images = CalibratedImages::new(camera, Box::new(images));
    Ok(OpenImages { images: Box::new(images), truth: None, warnings })
}

/// Frames for localization from pictures: those of a robot of which nothing is known but where its camera is. The camera's place is the
/// user's, the calibration the user's or the source's.
pub(crate) fn frames_of_pictures(
    request: &Request<'_>,
    open: OpenPictures,
) -> Result<OpenFrames, SourcesError> {
    let OpenPictures { pictures, calibration, mut warnings } = open;
    let mount =
        request.options.mount.ok_or_else(|| SourcesError::NoMount { argument: request.argument() })?;
    let (camera, pictures) = calibrated(request, pictures, calibration, &mut warnings)?;
    let robot_from_camera = mount.robot_from_camera();
    let frames = Mapped::new(pictures, move |Picture { at, image, .. }| {
        Ok(SourceFrame { frame: Frame::new(at, image, camera, robot_from_camera), truth: None })
    });
    Ok(OpenFrames { frames: Box::new(frames), map: None, warnings })
}

/// The frames of a robot in the range that was asked for.
pub(crate) fn frames_in_range(request: &Request<'_>, open: OpenFrames) -> Result<OpenFrames, SourcesError> {
    Ok(OpenFrames { frames: in_range(request, open.frames)?, ..open })
}

/// The pictures in the range that was asked for.
pub(crate) fn pictures_in_range(
    request: &Request<'_>,
    open: OpenPictures,
) -> Result<OpenPictures, SourcesError> {
    Ok(OpenPictures { pictures: in_range(request, open.pictures)?, ..open })
}

fn in_range<T: Shot + 'static>(
    request: &Request<'_>,
    images: Box<dyn Source<T>>,
) -> Result<Box<dyn Source<T>>, SourcesError> {
    if request.options.range == SequenceRange::default() {
        return Ok(images);
    }
    let mut images = Ranged::new(images, request.options.range);
    if request.address.kind().is_live {
        return Ok(Box::new(images));
    }
    let first = images.next_item();
    let first = first.ok_or_else(|| request.empty(images.why_none()))??;
    Ok(Box::new(PutBack::new(first, Box::new(images))))
}

/// The camera of the first image of the range that was asked for, and the images of that size.
fn calibrated<T: Shot + 'static>(
    request: &Request<'_>,
    images: Box<dyn Source<T>>,
    calibration: Option<(Calibration, PathBuf)>,
    warnings: &mut Vec<String>,
) -> Result<(Camera, Box<dyn Source<T>>), SourcesError> {
    let (calibration, path) = match &request.options.camera {
        Some(path) => (read_calibration(path)?, path.clone()),
        None => calibration
            .or_else(|| Some((Calibration::of(&request.options.usual.camera?), PathBuf::new())))
            .ok_or_else(|| SourcesError::NoCamera { argument: request.argument() })?,
    };
    let mut images = Ranged::new(images, request.options.range);
    let first = images.next_item();
    let first = first.ok_or_else(|| request.empty(images.why_none()))??;
    let size_px = first.size_px();
    let camera = fit_calibration(&calibration, size_px, &path, warnings)?;
    let images = SameSize::new(Box::new(PutBack::new(first, Box::new(images))), size_px, request.argument());
    Ok((camera, Box::new(images)))
}
