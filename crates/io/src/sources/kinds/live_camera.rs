//! Cameras at Video4Linux, webcams for instance.

use std::path::Path;

use super::{SourceKind, Way, claims_nothing, video::RATE_HZ};
use crate::sources::{
    SourceOption::{Camera, End, Ffmpeg, Fps, Frames, Mount, Patience, Scale, Start, Stride},
    SourcesError,
    adapt::pictures_in_range,
    open::Request,
    video::{self, Decoded, FfmpegInput, ffmpeg_problem},
};

pub(super) const KIND: SourceKind = SourceKind {
    name: "camera",
    schemes: &["v4l2"],
    form: "v4l2:DEVICE",
    example: "v4l2:/dev/video0 --camera camera.toml",
    summary: "a webcam or other camera of Video4Linux, live; v4l2:/dev/video0?640x480 asks for a size",
    is_live: true,
    is_robot: |_| false,
    problem: |options| match (devices().is_empty(), ffmpeg_problem(options.ffmpeg())) {
        (_, Some(problem)) => Some(problem),
        (true, None) => Some("no camera: there is no /dev/video*".into()),
        (false, None) => None,
    },
    claims: claims_nothing,
    frames: Way {
        honors: |_| vec![Camera, Mount, Start, End, Stride, Frames, Fps, Patience, Ffmpeg],
        open: |request| video::frames(request, input(request)?),
    },
    images: Way {
        honors: |_| vec![Camera, Start, End, Stride, Frames, Scale, Fps, Patience, Ffmpeg],
        open: |request| video::images(request, input(request)?),
    },
    pictures: Way {
        honors: |_| vec![Camera, Start, End, Stride, Frames, Fps, Patience, Ffmpeg],
        open: |request| pictures_in_range(request, video::pictures(request, input(request)?)?),
    },
};

/// Cameras that are there.
fn devices() -> Vec<String> {
    let entries = std::fs::read_dir("/dev").into_iter().flatten().filter_map(Result::ok);
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let mut devices: Vec<String> =
        names.filter(|name| name.starts_with("video")).map(|name| format!("/dev/{name}")).collect();
    devices.sort();
    devices
}

fn input(request: &Request<'_>) -> Result<Decoded, SourcesError> {
    let (device, size) = match request.address.rest().split_once('?') {
        Some((device, size)) => (device, Some(size)),
        None => (request.address.rest(), None),
    };
    if !Path::new(device).exists() {
        let found = devices();
        let found = if found.is_empty() { "no camera at all".into() } else { found.join(", ") };
        return request.cannot(format!("expected a camera such as /dev/video0, found {found}"));
    }
    let mut args: Vec<std::ffi::OsString> = vec!["-f".into(), "v4l2".into()];
    if let Some(size) = size {
        let is_size =
            size.split_once('x').is_some_and(|(w, h)| [w, h].iter().all(|n| n.parse::<u16>().is_ok()));
        if !is_size {
            return request.cannot(format!("expected a size such as 640x480 behind '?', found '{size}'"));
        }
        args.extend(["-video_size".into(), size.into()]);
    }
    if let Some(rate_hz) = request.options.rate_hz {
        args.extend(["-framerate".into(), rate_hz.to_string().into()]);
    }
    args.extend(["-i".into(), device.into()]);
    let rate_hz = request.options.rate_hz.unwrap_or(RATE_HZ);
    let input = FfmpegInput {
        argument: request.argument(),
        args,
        sampled_hz: None,
        folder: None,
        is_live: true,
        rate_hz,
        has_own_times: true,
    };
    Ok((input, None))
}
