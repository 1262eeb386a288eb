//! Where the images of a run come from.

use anyhow::{Result, bail};
use visloc_io::{
    sequence::SequenceRange,
    sources::{OpenImages, SourceAddress, SourceOption, SourceOptions, open_images},
};

use crate::{
    args::SlamArgs,
    host::host,
    run::{prepare, source_options},
    settings::topic_options,
};

/// Opens what the arguments name.
///
/// # Errors
/// If there is no such source, or no camera can be made of its calibration.
pub fn open_input(args: &SlamArgs) -> Result<OpenImages> {
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
    Ok(open_images(&args.source, &options, host())?)
}

/// The seed is that of SLAM too, and the domain that of what is published.
fn honored_by_slam(args: &SlamArgs) -> Vec<SourceOption> {
    let mut honored = vec![SourceOption::Seed];
    if args.publish_ros {
        honored.push(SourceOption::RosDomain);
    }
    honored
}
