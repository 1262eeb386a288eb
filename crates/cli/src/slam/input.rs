//! Where the images of a run come from.

use anyhow::{Context, Result, bail};
use visloc_core::{FrameSource, GrayFrame, ImageSource, SourceError, SourceFrame, geom::Camera};
use visloc_io::{
    sequence::SequenceRange,
    sources::{OpenImages, SourceAddress, SourceOption, SourceOptions, open_images},
};

use crate::{
    args::SlamArgs,
    host::host,
    run::{prepare, source_options},
    settings::topic_options,
    studio::Steering,
};

/// Opens what the arguments name, with what moves the robot that carries the camera, if others may.
///
/// # Errors
/// If there is no such source, or no camera can be made of its calibration.
pub fn open_input(args: &SlamArgs) -> Result<(Option<Steering>, OpenImages)> {
    if args.realtime && SourceAddress::parse(&args.source)?.kind().is_live {
        bail!("--realtime: expected a recorded source, found {}, which is live already", args.source);
    }
    let options = SourceOptions {
        range: SequenceRange { start: args.start, end: args.end, stride: args.stride as usize },
        scale: args.scale,
        seed: args.seed.given,
        honored_elsewhere: honored_by_slam(args),
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    prepare(&args.source)?;
    let steering = Steering::of(&args.broadcast.drive, &args.source, &options)?;
    let driven =
        steering.as_ref().map(|steering| steering.simulated(&args.source, &options)).transpose()?.flatten();
    let open = match driven {
        Some(driven) => {
            let images = Box::new(RobotImages::new(driven.frames)?);
            OpenImages { images, truth: None, warnings: driven.warnings }
        }
        None => open_images(&args.source, &options, host())?,
    };
    Ok((steering, open))
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
