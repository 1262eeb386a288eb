//! Videos and cameras as sources of pictures.

use visloc_core::{
    GrayFrame, GrayImage, Mapped, Picture, SkippedInput, Source, SourceError, SourceStatus, Timestamp,
};

use super::{
    FfmpegInput, Pixels, PnmImage,
    live::LiveVideo,
    pipe::{PipeImage, VideoPipe},
};
use crate::sources::{Host, SourceOptions, SourcesError};

/// A video or a camera, opened for gray or for color images.
struct Video {
    argument: String,
    feed: Feed,
    skipped: Vec<SkippedInput>,
}

enum Feed {
    Recorded { pipe: VideoPipe, rate_hz: f64, has_own_times: bool, last_at: Option<Timestamp> },
    Live(LiveVideo),
}

/// Opens a video or a camera for its pictures.
pub(super) fn open_color(
    input: &FfmpegInput,
    options: &SourceOptions,
    host: &Host,
) -> Result<Box<dyn Source<Picture>>, SourcesError> {
    let video = Video::open(input, options, host, Pixels::Color)?;
    Ok(Box::new(Mapped::new(Box::new(video), |(at, image)| {
        let image = match image {
            PnmImage::Color(image) => image,
            PnmImage::Gray(image) => image.to_rgb(),
        };
        Ok(Picture { at, image, file: None })
    })))
}

/// Opens a video or a camera for gray images.
pub(super) fn open_gray(
    input: &FfmpegInput,
    options: &SourceOptions,
    host: &Host,
) -> Result<Box<dyn Source<GrayFrame>>, SourcesError> {
    let video = Video::open(input, options, host, Pixels::Gray)?;
    Ok(Box::new(Mapped::new(Box::new(video), |(at, image)| {
        let image = match image {
            PnmImage::Gray(image) => image,
            PnmImage::Color(image) => GrayImage::from_rgb(&image),
        };
        Ok(GrayFrame::new(at, image))
    })))
}

impl Video {
    fn open(
        input: &FfmpegInput,
        options: &SourceOptions,
        host: &Host,
        pixels: Pixels,
    ) -> Result<Self, SourcesError> {
        let program = options.ffmpeg();
        let feed = if input.is_live {
            Feed::Live(LiveVideo::start(input, pixels, options, host)?)
        } else {
            let pipe = VideoPipe::start(program, input, pixels, host)?;
            let FfmpegInput { rate_hz, has_own_times, .. } = *input;
            Feed::Recorded { pipe, rate_hz, has_own_times, last_at: None }
        };
        Ok(Self { argument: input.argument.clone(), feed, skipped: Vec::new() })
    }
}

impl Source<(Timestamp, PnmImage)> for Video {
    fn next_item(&mut self) -> Option<Result<(Timestamp, PnmImage), SourceError>> {
        let (pipe, rate_hz, has_own_times, last_at) = match &mut self.feed {
            Feed::Live(live) => return live.next_image(),
            Feed::Recorded { pipe, rate_hz, has_own_times, last_at } => {
                (pipe, *rate_hz, *has_own_times, last_at)
            }
        };
        loop {
            let Some(next) = pipe.next_image() else {
                // Damage that the decoder got over.
                let skip = |reason: &String| SkippedInput {
                    at: *last_at,
                    origin: self.argument.clone(),
                    reason: reason.clone(),
                };
                if self.skipped.iter().all(|skipped| skipped.at != *last_at) {
                    self.skipped.extend(pipe.faults().iter().map(skip));
                }
                return None;
            };
            let PipeImage { secs, image } = match next {
                Ok(next) => next,
                Err(error) => return Some(Err(error)),
            };
            let following = last_at.map_or(0.0, |last| last.secs() + 1.0 / rate_hz);
            let at = Timestamp::from_secs(secs.filter(|_| has_own_times).unwrap_or(following));
            if let Some(last) = last_at.filter(|last| *last >= at) {
                let reason = format!("expected an image later than {last}, found one at {at}");
                self.skipped.push(SkippedInput { at: Some(at), origin: self.argument.clone(), reason });
                continue;
            }
            *last_at = Some(at);
            return Some(Ok((at, image)));
        }
    }

    fn status(&self) -> SourceStatus<'_> {
        let num_dropped = match &self.feed {
            Feed::Live(live) => live.num_dropped(),
            Feed::Recorded { .. } => 0,
        };
        SourceStatus { skipped: &self.skipped, num_dropped, ..SourceStatus::default() }
    }
}
