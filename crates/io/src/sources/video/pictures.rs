//! Videos and cameras as sources of pictures.

use visloc_core::{
    GrayFrame, GrayImage, Picture, PictureSource, RgbImage, SkippedInput, SourceError, Timestamp,
};

use super::{
    FfmpegInput, Pixels, PnmImage,
    live::LiveVideo,
    pipe::{PipeImage, VideoPipe},
};
use crate::sources::{Host, SourceOptions, SourcesError, adapt::GrayStream};

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
) -> Result<Box<dyn PictureSource>, SourcesError> {
    Ok(Box::new(Color(Video::open(input, options, host, Pixels::Color)?)))
}

/// Opens a video or a camera for gray images.
pub(super) fn open_gray(
    input: &FfmpegInput,
    options: &SourceOptions,
    host: &Host,
) -> Result<Box<dyn GrayStream>, SourcesError> {
    Ok(Box::new(Gray(Video::open(input, options, host, Pixels::Gray)?)))
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

    fn next(&mut self) -> Option<Result<(Timestamp, PnmImage), SourceError>> {
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

    fn num_dropped(&self) -> usize {
        match &self.feed {
            Feed::Live(live) => live.num_dropped(),
            Feed::Recorded { .. } => 0,
        }
    }
}

struct Color(Video);

impl PictureSource for Color {
    fn next_picture(&mut self) -> Option<Result<Picture, SourceError>> {
        Some(self.0.next()?.map(|(at, image)| Picture {
            at,
            image: match image {
                PnmImage::Color(image) => image,
                PnmImage::Gray(image) => in_color(&image),
            },
        }))
    }

    fn skipped(&self) -> &[SkippedInput] {
        &self.0.skipped
    }

    fn num_dropped(&self) -> usize {
        self.0.num_dropped()
    }
}

struct Gray(Video);

impl GrayStream for Gray {
    fn next_gray(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        let gray = |image| match image {
            PnmImage::Gray(image) => image,
            PnmImage::Color(image) => GrayImage::from_rgb(&image),
        };
        Some(self.0.next()?.map(|(at, image)| GrayFrame::new(at, gray(image))))
    }

    fn num_images(&self) -> Option<usize> {
        None
    }

    fn skipped(&self) -> &[SkippedInput] {
        &self.0.skipped
    }

    fn num_dropped(&self) -> usize {
        self.0.num_dropped()
    }
}

/// A gray image with three equal channels.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn in_color(image: &GrayImage) -> RgbImage {
    let data = image.data().iter().flat_map(|gray| [*gray; 3]).collect();
    let (width, height) = (image.width() as u32, image.height() as u32);
    RgbImage::from_raw(width, height, data).unwrap_or_else(|_| RgbImage::new(width, height))
}
