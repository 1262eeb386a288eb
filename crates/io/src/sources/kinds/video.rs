//! Video files.

use std::{ffi::OsString, path::Path};

use super::{SourceKind, Way, has_extension};
use crate::sources::{
    SourceOption::{Camera, End, Ffmpeg, Fps, Frames, Mount, Scale, Start, Stride},
    SourcesError,
    adapt::pictures_in_range,
    open::Request,
    video::{self, Decoded, FfmpegInput, ffmpeg_problem},
};

pub(super) const KIND: SourceKind = SourceKind {
    name: "video",
    schemes: &["video"],
    form: "FILE.mp4",
    example: "clip.mp4 --camera camera.toml",
    summary: "a video file of any format that ffmpeg knows (mp4, mkv, webm, avi, mov, ...); also video:FILE",
    is_live: false,
    is_robot: |_| false,
    problem: |options| ffmpeg_problem(options.ffmpeg()),
    claims: is_video,
    frames: Way {
        honors: |_| vec![Camera, Mount, Start, End, Stride, Frames, Fps, Ffmpeg],
        open: |request| video::frames(request, input(request)?),
    },
    images: Way {
        honors: |_| vec![Camera, Start, End, Stride, Frames, Scale, Fps, Ffmpeg],
        open: |request| video::images(request, input(request)?),
    },
    pictures: Way {
        honors: |_| vec![Camera, Start, End, Stride, Frames, Fps, Ffmpeg],
        open: |request| pictures_in_range(request, video::pictures(request, input(request)?)?),
    },
};

const EXTENSIONS: [&str; 14] =
    ["mp4", "m4v", "mov", "mkv", "webm", "avi", "mpg", "mpeg", "ts", "mts", "wmv", "ogv", "mjpeg", "3gp"];

/// Images a second, where the file has no times.
pub(super) const RATE_HZ: f64 = 30.0;

/// Whether a path says by itself that it is a video.
pub(super) fn is_video(path: &Path) -> bool {
    path.is_file() && has_extension(path, &EXTENSIONS)
}

/// A video file for ffmpeg.
pub(super) fn file_of(request: &Request<'_>, path: &Path) -> Result<OsString, SourcesError> {
    if let Err(error) = visloc_core::files::open(path) {
        return request.cannot(format!("expected a video file: '{}': {error}", path.display()));
    }
    // A name may begin with a dash or look like a protocol.
    let mut name = OsString::from("file:");
    name.push(path);
    Ok(name)
}

fn input(request: &Request<'_>) -> Result<Decoded, SourcesError> {
    let path = Path::new(request.address.rest());
    let input = FfmpegInput {
        argument: request.argument(),
        args: vec!["-i".into(), file_of(request, path)?],
        sampled_hz: None,
        folder: None,
        is_live: false,
        rate_hz: request.options.rate_hz.unwrap_or(RATE_HZ),
        has_own_times: request.options.rate_hz.is_none(),
    };
    Ok((input, None))
}
