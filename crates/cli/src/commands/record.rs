//! `visloc record`: any source as a ROS 2 bag.

use anyhow::{Result, anyhow, bail};
use visloc_core::{Source, SourceError, SourceFrame, geom::Camera};
use visloc_io::{
    bag::{BagWriter, BagWriterOptions, ImageEncoding},
    sequence::{SequenceRange, fit_calibration},
    sources::{OpenPictures, SourceAddress, SourceOption, SourceOptions, open_frames, open_pictures},
};

use super::convert;
use crate::{
    args::{ImageFormat, RecordArgs, SourceArgs, TopicArgs},
    host::host,
    report::SkippedReport,
    run::{Progress, prepare, refuse_source_options, source_options},
    say,
    settings::topic_options,
};

/// What was recorded.
struct Recorded {
    num_images: usize,
    num_dropped: usize,
    skipped: SkippedReport,
    error: Option<SourceError>,
}

/// Runs the command.
pub fn execute(args: &RecordArgs) -> Result<()> {
    let mut options = SourceOptions {
        seed: args.seed.given,
        num_threads: args.threads.given(),
        range: args.range.range(),
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    if is_copied(args)? {
        options.honored_elsewhere = vec![SourceOption::Start, SourceOption::End];
        refuse_source_options(&options, "the messages of a bag are copied as they are; leave it out")?;
        let range = SequenceRange { most: args.frames.map(|frames| frames as usize), ..options.range };
        return convert::execute(&args.source, range, &args.out);
    }
    options.usual.max_frames = args.frames.map(|frames| frames as usize);
    let topics = options.topics.names();
    prepare(&args.source)?;
    let has_robot = SourceAddress::parse(&args.source)?.has_robot() || options.mount.is_some();
    let is_robot = has_robot && !args.images_only;
    // The bag that is written has these names.
    options.honored_elsewhere = match is_robot {
        true => SourceOption::TOPICS.to_vec(),
        false => vec![
            SourceOption::Topics,
            SourceOption::ImageTopic,
            SourceOption::CameraInfoTopic,
            SourceOption::CameraFrame,
        ],
    };
    let encoding = match args.images.unwrap_or(ImageFormat::Jpeg) {
        ImageFormat::Jpeg => ImageEncoding::Jpeg { quality: 90 },
        ImageFormat::Png => ImageEncoding::Png,
        ImageFormat::Raw => ImageEncoding::Raw,
    };
    let create = || -> Result<BagWriter> {
        let options = BagWriterOptions { image_encoding: encoding, ..BagWriterOptions::default() };
        Ok(BagWriter::create_with(&args.out, topics.clone(), options)?)
    };
    let recorded = if is_robot {
        let open =
            open_frames(&args.source, &options, host()).map_err(|error| match error.lacks_mount() {
                true => anyhow!("{error}; or record the images alone: --images-only"),
                false => error.into(),
            })?;
        warn(&open.warnings);
        record_frames(open.frames, create()?, args.frames)?
    } else {
        let open = open_pictures(&args.source, &options, host())?;
        warn(&open.warnings);
        record_pictures(open, create()?, args.frames)?
    };
    finish(args, recorded)
}

/// Whether all messages of a bag are wanted as they are.
fn is_copied(args: &RecordArgs) -> Result<bool> {
    let is_bag = SourceAddress::parse(&args.source)?.kind().schemes.contains(&"bag");
    let SourceArgs { camera, camera_height, urdf, .. } = &args.options;
    let is_changed = args.images.is_some()
        || args.images_only
        || camera.is_some()
        || camera_height.is_some()
        || urdf.is_some()
        || args.topics != TopicArgs::default();
    Ok(is_bag && !is_changed)
}

fn warn(warnings: &[String]) {
    warnings.iter().for_each(|warning| say::note!("{warning}"));
}

fn finish(args: &RecordArgs, recorded: Recorded) -> Result<()> {
    let dropped = match recorded.num_dropped {
        0 => String::new(),
        number => format!(", {number} dropped while others were written"),
    };
    if recorded.num_images > 0 {
        say::line!("{}: {}{dropped}", args.out.display(), say::count(recorded.num_images, "image"));
    }
    let error = recorded.error.as_ref().map(ToString::to_string);
    recorded.skipped.lines_beside(error.as_deref()).iter().for_each(|line| say::line!("{line}"));
    match recorded.error {
        Some(error) if recorded.num_images == 0 => Err(error.into()),
        Some(error) => Err(anyhow!("{error}{}", say::before(recorded.num_images, "image", "written"))),
        None if recorded.num_images == 0 => bail!("{}: no image came", args.source),
        None => Ok(()),
    }
}

fn record_frames(
    mut frames: Box<dyn Source<SourceFrame>>,
    mut writer: BagWriter,
    max_frames: Option<u32>,
) -> Result<Recorded> {
    let progress = Progress::new(frames.status().num_items);
    let (mut num_images, mut error) = (0, None);
    while max_frames.is_none_or(|most| num_images < most as usize) {
        match frames.next_item() {
            Some(Ok(frame)) => writer.write(&frame)?,
            Some(Err(broken)) => {
                error = Some(broken);
                break;
            }
            None => break,
        }
        num_images += 1;
        progress.advance();
    }
    writer.finish()?;
    progress.clear();
    let skipped = SkippedReport::new(frames.status().skipped);
    Ok(Recorded { num_images, num_dropped: frames.status().num_dropped, skipped, error })
}

fn record_pictures(open: OpenPictures, mut writer: BagWriter, max_frames: Option<u32>) -> Result<Recorded> {
    let OpenPictures { mut pictures, calibration, .. } = open;
    if calibration.is_none() {
        say::note!("the calibration is not known, so there is no CameraInfo; --camera FILE gives one");
    }
    let progress = Progress::new(pictures.status().num_items);
    let mut camera: Option<Camera> = None;
    let (mut num_images, mut error) = (0, None);
    while max_frames.is_none_or(|most| num_images < most as usize) {
        let picture = match pictures.next_item() {
            Some(Ok(picture)) => picture,
            Some(Err(broken)) => {
                error = Some(broken);
                break;
            }
            None => break,
        };
        if let (None, Some((calibration, path))) = (camera, &calibration) {
            let size_px = (picture.image.width(), picture.image.height());
            let mut warnings = Vec::new();
            camera = Some(fit_calibration(calibration, size_px, path, &mut warnings)?);
            warn(&warnings);
        }
        writer.write_picture(&picture, camera.as_ref())?;
        num_images += 1;
        progress.advance();
    }
    writer.finish()?;
    progress.clear();
    let skipped = SkippedReport::new(pictures.status().skipped);
    Ok(Recorded { num_images, num_dropped: pictures.status().num_dropped, skipped, error })
}
