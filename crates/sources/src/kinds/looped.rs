//! A folder of images as if it were a camera: over and over, in real time, through the same program and the same code.

use std::path::{Path, PathBuf};

use visloc_data::sequence::{Calibration, ImageFile, Listing, SequenceOptions, list_sequence};

use super::{SourceKind, claims_nothing, video::RATE_HZ};
use crate::{
    OpenFrames, OpenImages, OpenPictures, SourcesError,
    adapt::{frames_of_pictures, images_of_gray},
    open::Request,
    video::{FfmpegInput, ffmpeg_problem, open_color, open_gray},
};

pub(super) const KIND: SourceKind = SourceKind {
    name: "loop",
    schemes: &["loop"],
    form: "loop:DIR",
    example: "loop:photos --fps 15",
    summary: "a folder of images in place of a camera: over and over, live, at --fps images a second",
    is_live: true,
    is_robot: |_| false,
    problem: |options| ffmpeg_problem(&options.ffmpeg),
    claims: claims_nothing,
    frames,
    images,
    pictures,
};

/// The images, and the calibration beside them.
fn input(request: &Request<'_>) -> Result<(FfmpegInput, Option<(Calibration, PathBuf)>), SourcesError> {
    let folder = Path::new(request.address.rest());
    let Listing { images, calibration, .. } = list_sequence(folder, &SequenceOptions::default())?;
    let rate_hz = request.options.rate_hz.unwrap_or(RATE_HZ);
    let Some((folder, pattern)) = place_of(&images) else {
        return request.cannot("expected images in one folder and of one format, found others");
    };
    let args: Vec<std::ffi::OsString> = vec![
        "-re".into(),
        "-stream_loop".into(),
        "-1".into(),
        "-f".into(),
        "image2".into(),
        "-framerate".into(),
        rate_hz.to_string().into(),
        "-pattern_type".into(),
        "glob".into(),
        "-i".into(),
        pattern.into(),
    ];
    let input =
        FfmpegInput { argument: request.argument(), args, folder: Some(folder), is_live: true, rate_hz };
    Ok((input, calibration.ok()))
}

/// Folder and ending that all images share; ffmpeg sorts them by name.
fn place_of(images: &[ImageFile]) -> Option<(PathBuf, String)> {
    let place = |image: &ImageFile| {
        let extension = image.path.extension()?.to_str()?.to_owned();
        Some((image.path.parent()?.to_path_buf(), format!("*.{extension}")))
    };
    let first = place(images.first()?)?;
    images.iter().all(|image| place(image).as_ref() == Some(&first)).then_some(first)
}

fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
    let (input, calibration) = input(request)?;
    let stream = open_gray(&input, request.options, request.host)?;
    images_of_gray(request, stream, calibration, Vec::new())
}

fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
    let (input, calibration) = input(request)?;
    let pictures = open_color(&input, request.options, request.host)?;
    Ok(OpenPictures { pictures, calibration, warnings: Vec::new() })
}

fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
    frames_of_pictures(request, pictures(request)?)
}
