//! Where the images of a run come from.

use anyhow::{Context, Result, bail};
use visloc_core::{CalibratedImages, GrayFrame, Mapped, PutBack, Source, SourceFrame};
use visloc_io::{
    sequence::{MOST_SLAM_SIDE_PX, SequenceRange},
    sources::{OpenImages, SourceAddress, SourceOption, SourceOptions, open_images},
};

use super::pace::BACKLOG_SECS;
use crate::{
    args::SlamArgs,
    calibration::open_images_or_find_camera,
    host::host,
    run::{OpenSource, prepare, source_options},
    settings::topic_options,
};

/// Opens what the arguments name; `driven` opens the robot instead that carries the camera, if others may drive it.
pub fn open_input(
    args: &SlamArgs,
    driven: impl FnOnce(&SourceOptions) -> Result<Option<OpenSource>>,
) -> Result<OpenImages> {
    if args.realtime && SourceAddress::parse(&args.source)?.kind().is_live {
        bail!("--realtime: expected a recorded source, found {}, which is live already", args.source);
    }
    let mut options = SourceOptions {
        range: range_of(args),
        scale: args.scale,
        seed: args.seed.given,
        honored_elsewhere: honored_by_slam(args),
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    options.usual.backlog_secs = BACKLOG_SECS;
    // Photos with given poses are not followed from one to the next.
    options.usual.most_side_px = args.poses.is_none().then_some(MOST_SLAM_SIDE_PX);
    prepare(&args.source)?;
    match driven(&options)? {
        Some(driven) => {
            let images = Box::new(robot_images(driven.frames)?);
            Ok(OpenImages { images, truth: None, warnings: driven.warnings })
        }
        None if args.poses.is_none() => open_images_or_find_camera(&args.source, &options),
        None => Ok(open_images(&args.source, &options, host())?),
    }
}

/// The part of the sequence that is used.
pub fn range_of(args: &SlamArgs) -> SequenceRange {
    SequenceRange {
        start: args.from,
        end: args.until,
        stride: args.stride as usize,
        most: args.frames.map(|frames| frames as usize),
    }
}

/// The images of a robot's camera, which is that of the first frame, with what its odometry says of it.
fn robot_images(mut frames: Box<dyn Source<SourceFrame>>) -> Result<CalibratedImages> {
    let first = frames.next_item().context("no image came")??;
    let camera = first.frame.camera;
    let frames = Box::new(PutBack::new(first, frames));
    Ok(CalibratedImages::new(camera, Box::new(Mapped::new(frames, |frame| Ok(GrayFrame::of_robot(frame))))))
}

/// The seed is that of SLAM too, and the domain that of what is published.
fn honored_by_slam(args: &SlamArgs) -> Vec<SourceOption> {
    let mut honored = vec![SourceOption::Seed];
    if args.publish_ros {
        honored.push(SourceOption::RosDomain);
    }
    honored
}
