//! Where the images come from that a place is looked for in.

use anyhow::{Result, bail};
use visloc_core::{CameraTrajectory, GrayFrame, ImageSource, Source, SourceError, SourceFrame, SourceStatus};
use visloc_io::sources::{SourceAddress, SourceOptions, open_frames};

use crate::{
    args::CorrectionArgs,
    calibration::open_images_or_find_camera,
    host::host,
    run::{corrected, of_one_camera},
    slam::MapFrame,
    studio::Steering,
};

/// Where frames come from: a camera alone, or one on a robot.
pub enum MapFrames {
    /// A camera alone.
    Images(Box<dyn ImageSource>),
    /// A camera on a robot; its calibration comes with the first frame.
    Robot(Box<dyn Source<SourceFrame>>),
}

impl MapFrames {
    /// Opens a source, with a robot if it has one, and the camera's true way if that is known. A simulated robot goes where others
    /// drive it, if they may.
    pub fn open(
        name: &str,
        steering: Option<&Steering>,
        options: &SourceOptions,
        corrections: &CorrectionArgs,
    ) -> Result<(Self, Option<CameraTrajectory>, Vec<String>)> {
        if let Some(driven) =
            steering.map(|steering| steering.simulated(name, options)).transpose()?.flatten()
        {
            let frames = of_one_camera(driven.frames, name);
            return Ok((Self::Robot(corrected(frames, corrections)?), None, driven.warnings));
        }
        let mut warnings = Vec::new();
        if options.mount.is_some() || SourceAddress::parse(name)?.has_robot() {
            match open_frames(name, options, host()) {
                Ok(open) => {
                    let frames = of_one_camera(open.frames, name);
                    return Ok((Self::Robot(corrected(frames, corrections)?), None, open.warnings));
                }
                Err(error) if error.lacks_mount() => warnings.push(format!(
                    "{name} does not say where the camera is on a robot: the poses are those of the camera"
                )),
                Err(error) => return Err(error.into()),
            }
        }
        if corrections.robot.is_some() {
            bail!("--robot: there is no robot in {name}");
        }
        let open = open_images_or_find_camera(name, options)?;
        warnings.extend(open.warnings);
        Ok((Self::Images(open.images), open.truth, warnings))
    }

    /// Whether the camera is on a robot.
    pub fn has_robot(&self) -> bool {
        matches!(self, Self::Robot(_))
    }

    /// The next frame with its camera.
    pub fn next(&mut self) -> Option<Result<MapFrame, SourceError>> {
        Some(match self {
            Self::Images(images) => {
                let frame = images.next_item()?;
                frame.map(|gray| MapFrame { gray, camera: *images.camera(), robot: None })
            }
            Self::Robot(frames) => frames.next_item()?.map(|source| {
                let SourceFrame { frame, truth } = source.clone();
                let camera = frame.camera;
                MapFrame { gray: GrayFrame::of_robot(source), camera, robot: Some((frame, truth)) }
            }),
        })
    }

    /// What is known beside the frames.
    pub fn status(&self) -> SourceStatus<'_> {
        match self {
            Self::Images(images) => images.status(),
            Self::Robot(frames) => frames.status(),
        }
    }
}
