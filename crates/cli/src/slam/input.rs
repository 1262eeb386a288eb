//! Where the images of a run come from.

use anyhow::{Context, Result, bail};
use visloc_core::{FrameSource, GrayFrame, ImageSource, SourceError, SourceFrame, geom::Camera};
use visloc_io::{
    sequence::SequenceRange,
    sources::{OpenImages, SourceAddress, SourceOption, SourceOptions, open_images},
};

use super::pace::BACKLOG_SECS;
use crate::{
    args::SlamArgs,
    host::host,
    run::{OpenSource, prepare, source_options},
    settings::topic_options,
};

/// Opens what the arguments name; `driven` opens the robot instead that carries the camera, if others may drive it.
///
/// # Errors
/// If there is no such source, or no camera can be made of its calibration.
pub fn open_input(
    args: &SlamArgs,
    driven: impl FnOnce(&SourceOptions) -> Result<Option<OpenSource>>,
) -> Result<OpenImages> {
    if args.realtime && SourceAddress::parse(&args.source)?.kind().is_live {
        bail!("--realtime: expected a recorded source, found {}, which is live already", args.source);
    }
    let mut options = SourceOptions {
        range: SequenceRange { start: args.start, end: args.end, stride: args.stride as usize },
        scale: args.scale,
        seed: args.seed.given,
        honored_elsewhere: honored_by_slam(args),
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    options.usual.backlog_secs = BACKLOG_SECS;
    prepare(&args.source)?;
    match driven(&options)? {
        Some(driven) => {
            let images = Box::new(RobotImages::new(driven.frames)?);
            Ok(OpenImages { images, truth: None, warnings: driven.warnings })
        }
        None => Ok(open_images(&args.source, &options, host())?),
    }
}

/// The images of a robot's camera, with what its odometry says of it.
struct RobotImages {
    frames: Box<dyn FrameSource>,
    first: Option<SourceFrame>,
    camera: Camera,
}

impl RobotImages {
    /// The camera is that of the first frame.
    fn new(mut frames: Box<dyn FrameSource>) -> Result<Self> {
        let first = frames.next_frame().context("no image came")??;
        Ok(Self { frames, camera: first.frame.camera, first: Some(first) })
    }
}

impl ImageSource for RobotImages {
    fn camera(&self) -> &Camera {
        &self.camera
    }

    fn next_image(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        let next = self.first.take().map(Ok).or_else(|| self.frames.next_frame())?;
        Some(next.map(GrayFrame::of_robot))
    }
}

/// The seed is that of SLAM too, and the domain that of what is published.
fn honored_by_slam(args: &SlamArgs) -> Vec<SourceOption> {
    let mut honored = vec![SourceOption::Seed];
    if args.publish_ros {
        honored.push(SourceOption::RosDomain);
    }
    honored
}
