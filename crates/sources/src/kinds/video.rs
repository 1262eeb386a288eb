//! Video files.

use std::path::Path;

use super::{SourceKind, has_extension};
use crate::{
    OpenFrames, OpenImages, OpenPictures, SourcesError,
    adapt::{frames_of_pictures, images_of_gray},
    open::Request,
    video::{FfmpegInput, ffmpeg_problem, open_color, open_gray},
};

pub(super) const KIND: SourceKind = SourceKind {
    name: "video",
    schemes: &["video"],
    form: "FILE.mp4",
    example: "clip.mp4 --camera camera.toml",
    summary: "a video file of any format that ffmpeg knows (mp4, mkv, webm, avi, mov, ...); also video:FILE",
    is_live: false,
    is_robot: |_| false,
    problem: |options| ffmpeg_problem(&options.ffmpeg),
    claims: |path| path.is_file() && has_extension(path, &EXTENSIONS),
    frames,
    images,
    pictures,
};

const EXTENSIONS: [&str; 14] =
    ["mp4", "m4v", "mov", "mkv", "webm", "avi", "mpg", "mpeg", "ts", "mts", "wmv", "ogv", "mjpeg", "3gp"];

/// Images a second, where the file has no times.
pub(super) const RATE_HZ: f64 = 30.0;

fn input(request: &Request<'_>) -> Result<FfmpegInput, SourcesError> {
    let path = Path::new(request.address.rest());
    if !path.is_file() {
        return request.cannot(format!("expected a video file, found no file '{}'", path.display()));
    }
    // A name may begin with a dash or look like a protocol.
    let mut name = std::ffi::OsString::from("file:");
    name.push(path);
    Ok(FfmpegInput {
        argument: request.argument(),
        args: vec!["-i".into(), name],
        folder: None,
        is_live: false,
        rate_hz: request.options.rate_hz.unwrap_or(RATE_HZ),
    })
}

fn images(request: &Request<'_>) -> Result<OpenImages, SourcesError> {
    let stream = open_gray(&input(request)?, request.options, request.host)?;
    images_of_gray(request, stream, None, Vec::new())
}

fn pictures(request: &Request<'_>) -> Result<OpenPictures, SourcesError> {
    let pictures = open_color(&input(request)?, request.options, request.host)?;
    Ok(OpenPictures { pictures, calibration: None, warnings: Vec::new() })
}

fn frames(request: &Request<'_>) -> Result<OpenFrames, SourcesError> {
    frames_of_pictures(request, pictures(request)?)
}
