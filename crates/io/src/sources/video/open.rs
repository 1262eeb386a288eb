//! What ffmpeg decodes, as every form that a source is asked for.

use std::path::PathBuf;

use super::{
    FfmpegInput,
    pictures::{open_color, open_gray},
};
use crate::{
    sequence::Calibration,
    sources::{
        OpenFrames, OpenImages, OpenPictures, SourcesError,
        adapt::{frames_of_pictures, images_of_gray},
        open::Request,
    },
};

/// What is to be decoded, and the calibration beside it with its file.
pub(crate) type Decoded = (FfmpegInput, Option<(Calibration, PathBuf)>);

pub(crate) fn images(
    request: &Request<'_>,
    (input, calibration): Decoded,
) -> Result<OpenImages, SourcesError> {
    let stream = open_gray(&input, request.options, request.host)?;
    images_of_gray(request, stream, calibration, Vec::new())
}

pub(crate) fn pictures(
    request: &Request<'_>,
    (input, calibration): Decoded,
) -> Result<OpenPictures, SourcesError> {
    let pictures = open_color(&input, request.options, request.host)?;
    Ok(OpenPictures { pictures, calibration, warnings: Vec::new() })
}

pub(crate) fn frames(request: &Request<'_>, decoded: Decoded) -> Result<OpenFrames, SourcesError> {
    frames_of_pictures(request, pictures(request, decoded)?)
}
