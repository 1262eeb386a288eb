//! Where the images of a run come from.

use anyhow::{Result, bail};
use visloc_data::sequence::SequenceRange;
use visloc_sources::{OpenImages, SourceAddress, SourceOptions, open_images};

use crate::{
    args::SlamArgs,
    commands::bag_topics,
    host::host,
    run::{prepare, source_options},
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
        seed: args.seed.seed,
        num_threads: std::thread::available_parallelism().map_or(1, usize::from),
        ..source_options(&args.options, bag_topics(&args.topics)?)?
    };
    prepare(&args.source)?;
    Ok(open_images(&args.source, &options, host())?)
}
