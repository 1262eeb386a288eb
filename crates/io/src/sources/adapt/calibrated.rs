//! Pictures with a calibration: images for SLAM, or frames of a robot on which the camera is fixed.

use std::path::PathBuf;

use visloc_core::{
    Frame, FrameSource, GrayFrame, ImageSource, Picture, PictureSource, SkippedInput, SourceError,
    SourceFrame, Timestamp,
    geom::{Camera, CameraFrame, Rigid3, Robot},
};

use super::{GrayOf, GrayStream, Ranged, skipped::SkippedLog};
use crate::{
    image_codec::resize_gray,
    sequence::{Calibration, check_scaled, fit_calibration, read_calibration},
    sources::{OpenFrames, OpenImages, OpenPictures, SourceOptions, SourcesError, open::Request},
};

/// After so many images in a row of another size than the first, the source ends.
const MAX_WRONG_SIZE: usize = 10;

/// Gray images of a calibrated camera. Images of another size are left out.
pub struct CalibratedImages {
    stream: Box<dyn GrayStream>,
    first: Option<GrayFrame>,
    size: SizeCheck,
    camera: Camera,
    skipped: SkippedLog,
}

/// Frames of a robot of which nothing is known but where its camera is: no odometry, no feet.
pub struct CalibratedFrames {
    pictures: Box<dyn PictureSource>,
    first: Option<Picture>,
    size: SizeCheck,
    camera: Camera,
    robot_from_camera: Rigid3<Robot, CameraFrame>,
    skipped: SkippedLog,
}

/// All images have to have the size of the first.
struct SizeCheck {
    origin: String,
    size_px: (u32, u32),
    num_wrong: usize,
}

impl SizeCheck {
    fn check(&mut self, at: Timestamp, found: (u32, u32)) -> Result<(), SkippedInput> {
        if found == self.size_px {
            self.num_wrong = 0;
            return Ok(());
        }
        self.num_wrong += 1;
        let reason = format!(
            "expected {} x {} px as in the first image, found {} x {}",
            self.size_px.0, self.size_px.1, found.0, found.1
        );
        Err(SkippedInput { at: Some(at), origin: self.origin.clone(), reason })
    }

    /// The end of a source whose images have got another size for good.
    fn verdict(&self, skipped: &SkippedInput) -> Option<SourceError> {
        (self.num_wrong >= MAX_WRONG_SIZE).then(|| SourceError::Broken {
            origin: self.origin.clone(),
            reason: format!("{}, {MAX_WRONG_SIZE} times in a row", skipped.reason),
        })
    }
}

impl CalibratedFrames {
    /// Pictures of a camera with the size of the calibration.
    #[must_use]
    pub fn new(
        pictures: Box<dyn PictureSource>,
        camera: Camera,
        robot_from_camera: Rigid3<Robot, CameraFrame>,
        origin: impl Into<String>,
    ) -> Self {
        let size = SizeCheck { origin: origin.into(), size_px: camera.size_px(), num_wrong: 0 };
        Self { pictures, first: None, size, camera, robot_from_camera, skipped: SkippedLog::default() }
    }
}

impl FrameSource for CalibratedFrames {
    fn next_frame(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        loop {
            let next = self.first.take().map(Ok).or_else(|| self.pictures.next_picture());
            self.skipped.follow(self.pictures.skipped());
            let Picture { at, image } = match next? {
                Ok(picture) => picture,
                Err(error) => return Some(Err(error)),
            };
            if let Err(skipped) = self.size.check(at, (image.width(), image.height())) {
                if let Some(error) = self.size.verdict(&skipped) {
                    return Some(Err(error));
                }
                self.skipped.push(skipped);
                continue;
            }
            let frame = Frame {
                at,
                image,
                camera_index: 0,
                camera: self.camera,
                robot_from_camera: self.robot_from_camera,
                odometry: None,
                ground_contact: None,
            };
            return Some(Ok(SourceFrame { frame, truth: None }));
        }
    }

    fn num_frames(&self) -> Option<usize> {
        self.pictures.num_pictures()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.skipped.all()
    }

    fn num_dropped(&self) -> usize {
        self.pictures.num_dropped()
    }
}

impl CalibratedImages {
    /// Pictures of a camera with the size of the calibration; the images, and the camera with them, are scaled.
    #[must_use]
    pub fn new(
        pictures: Box<dyn PictureSource>,
        camera: Camera,
        scale: f64,
        origin: impl Into<String>,
    ) -> Self {
        Self::of_gray(Box::new(GrayOf(pictures)), camera, scale, origin.into())
    }

    fn of_gray(stream: Box<dyn GrayStream>, camera: Camera, scale: f64, origin: String) -> Self {
        let size = SizeCheck { origin, size_px: camera.size_px(), num_wrong: 0 };
        let camera = if scale == 1.0 { camera } else { camera.scaled(scale) };
        Self { stream, first: None, size, camera, skipped: SkippedLog::default() }
    }
}

impl ImageSource for CalibratedImages {
    fn camera(&self) -> &Camera {
        &self.camera
    }

    fn next_image(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        loop {
            let next = self.first.take().map(Ok).or_else(|| self.stream.next_gray());
            self.skipped.follow(self.stream.skipped());
            let frame = match next? {
                Ok(frame) => frame,
                Err(error) => return Some(Err(error)),
            };
            if let Err(skipped) = self.size.check(frame.at, size_of(&frame)) {
                if let Some(error) = self.size.verdict(&skipped) {
                    return Some(Err(error));
                }
                self.skipped.push(skipped);
                continue;
            }
            let image = resize_gray(frame.image, self.camera.size_px());
            return Some(Ok(GrayFrame { image, ..frame }));
        }
    }

    fn num_images(&self) -> Option<usize> {
        self.stream.num_images()
    }

    fn skipped(&self) -> &[SkippedInput] {
        self.skipped.all()
    }

    fn num_dropped(&self) -> usize {
        self.stream.num_dropped()
    }
}

#[allow(clippy::cast_possible_truncation)]
fn size_of(frame: &GrayFrame) -> (u32, u32) {
    (frame.image.width() as u32, frame.image.height() as u32)
}

/// Images for SLAM from pictures; the calibration is the user's or the source's.
pub(crate) fn images_of_pictures(
    request: &Request<'_>,
    open: OpenPictures,
) -> Result<OpenImages, SourcesError> {
    images_of_gray(request, Box::new(GrayOf(open.pictures)), open.calibration, open.warnings)
}

/// Images for SLAM from gray ones; the calibration is the user's or the source's.
pub(crate) fn images_of_gray(
    request: &Request<'_>,
    stream: Box<dyn GrayStream>,
    calibration: Option<(Calibration, PathBuf)>,
    mut warnings: Vec<String>,
) -> Result<OpenImages, SourcesError> {
    let mut stream = Box::new(Ranged::new(stream, request.options.range));
    let (calibration, path) = calibration_of(request, calibration)?;
    let first = stream.next_gray();
    let first = first.ok_or_else(|| request.empty(stream.why_none()))??;
    let camera = fit_calibration(&calibration, size_of(&first), &path, &mut warnings)?;
    if let Err(reason) = check_scaled(&camera, request.options.scale()) {
        return request.cannot(reason);
    }
    let mut images = CalibratedImages::of_gray(stream, camera, request.options.scale(), request.argument());
    images.first = Some(first);
    Ok(OpenImages { images: Box::new(images), truth: None, warnings })
}

/// Frames for localization from pictures; the camera's place is the user's, the calibration the user's or the source's.
pub(crate) fn frames_of_pictures(
    request: &Request<'_>,
    open: OpenPictures,
) -> Result<OpenFrames, SourcesError> {
    let OpenPictures { pictures, calibration, mut warnings } = open;
    let SourceOptions { mount, range, .. } = request.options;
    let mount = mount.ok_or_else(|| SourcesError::NoMount { argument: request.argument() })?;
    let (calibration, path) = calibration_of(request, calibration)?;
    let mut pictures = Ranged::new(pictures, *range);
    let first = pictures.next_picture();
    let first = first.ok_or_else(|| request.empty(pictures.why_none()))??;
    let size_px = (first.image.width(), first.image.height());
    let camera = fit_calibration(&calibration, size_px, &path, &mut warnings)?;
    let place = mount.robot_from_camera();
    let mut frames = CalibratedFrames::new(Box::new(pictures), camera, place, request.argument());
    frames.first = Some(first);
    Ok(OpenFrames { frames: Box::new(frames), map: None, warnings })
}

/// The user's calibration, or that of the source.
fn calibration_of(
    request: &Request<'_>,
    of_source: Option<(Calibration, PathBuf)>,
) -> Result<(Calibration, PathBuf), SourcesError> {
    match &request.options.camera {
        Some(path) => Ok((read_calibration(path)?, path.clone())),
        None => of_source.ok_or_else(|| SourcesError::NoCamera { argument: request.argument() }),
    }
}
