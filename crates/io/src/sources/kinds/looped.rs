//! A folder of images or a video as if it were a camera: over and over, in real time, through the same program and the same code.

use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

use super::{
    SourceKind, Way, claims_nothing,
    video::{RATE_HZ, file_of, is_video},
};
use crate::{
    sequence::{ImageFile, Listing, SequenceOptions, list_sequence},
    sources::{
        SourceOption::{Camera, End, Ffmpeg, Fps, Frames, Mount, Patience, Scale, Start, Stride},
        SourcesError,
        adapt::pictures_in_range,
        open::Request,
        video::{self, Decoded, FfmpegInput, ffmpeg_problem},
    },
};

pub(super) const KIND: SourceKind = SourceKind {
    name: "loop",
    schemes: &["loop"],
    form: "loop:DIR|FILE.mp4",
    example: "loop:photos --fps 15",
    summary: "a folder of images or a video in place of a camera: over and over, live, at --fps images a second",
    is_live: true,
    is_robot: |_| false,
    problem: |options| ffmpeg_problem(options.ffmpeg()),
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

/// The images, and the calibration beside them.
fn input(request: &Request<'_>) -> Result<Decoded, SourcesError> {
    let folder = Path::new(request.address.rest());
    if is_video(folder) {
        return looped_video(request, folder);
    }
    let wrong = match folder.metadata() {
        Ok(found) => found.is_file().then_some("another file"),
        Err(error) => (error.kind() == ErrorKind::NotFound).then_some("nothing of that name"),
    };
    if let Some(found) = wrong {
        let expected = "expected a folder of images or a video file to repeat";
        return request.cannot(format!("{expected}, found {found}"));
    }
    let Listing { images, calibration, .. } = list_sequence(folder, &SequenceOptions::default())?;
    let rate_hz = request.options.rate_hz.unwrap_or(RATE_HZ);
    let Some((folder, pattern)) = place_of(&images) else {
        return request.cannot("expected images in one folder and of one format, found others");
    };
    // ffmpeg takes them by name: 'image10' before 'image2'.
    if !images.is_sorted_by_key(|image| image.path.file_name()) {
        return request.cannot(
            "expected images whose names are in their order, found numbers of different length or a list with another order; \
             'visloc extract' makes such a folder",
        );
    }
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
    let input = FfmpegInput {
        argument: request.argument(),
        args,
        sampled_hz: None,
        folder: Some(folder),
        is_live: true,
        rate_hz,
        has_own_times: true,
    };
    Ok((input, calibration.ok()))
}

/// A video that begins again at its end, at its own speed; at a given rate images are left out, or come twice, as those of a camera would.
fn looped_video(request: &Request<'_>, path: &Path) -> Result<Decoded, SourcesError> {
    let args = vec!["-re".into(), "-stream_loop".into(), "-1".into(), "-i".into(), file_of(request, path)?];
    let rate_hz = request.options.rate_hz;
    let input = FfmpegInput {
        argument: request.argument(),
        args,
        sampled_hz: rate_hz,
        folder: None,
        is_live: true,
        rate_hz: rate_hz.unwrap_or(RATE_HZ),
        has_own_times: true,
    };
    Ok((input, None))
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
