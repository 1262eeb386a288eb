//! Images of a running camera.

use std::{
    sync::{Arc, atomic::Ordering},
    thread,
};

use visloc_core::{SourceError, Timestamp};

use super::{FfmpegInput, Pixels, PnmImage, pipe::VideoPipe};
use crate::{
    backlog::{SharedBacklog, Taken},
    sources::{Host, SourceOptions, SourcesError},
};

/// A silence that the user hears of, seconds.
const SILENCE_SECS: f64 = 3.0;

/// Images of a live source, stamped with the time at which they came.
pub(crate) struct LiveVideo {
    argument: String,
    backlog: Arc<SharedBacklog<PnmImage>>,
    host: Host,
    patience_secs: Option<f64>,
    last_at: Timestamp,
    is_silent: bool,
    is_done: bool,
    hang_up: Arc<std::sync::atomic::AtomicBool>,
    /// Ends ffmpeg, for whose next image the thread may wait.
    end: Box<dyn Fn() + Send>,
}

impl LiveVideo {
    /// Starts ffmpeg, and a thread that reads its images.
    pub(crate) fn start(
        input: &FfmpegInput,
        pixels: Pixels,
        options: &SourceOptions,
        host: &Host,
    ) -> Result<Self, SourcesError> {
        let mut pipe = VideoPipe::start(options.ffmpeg(), input, pixels, host)?;
        let end = Box::new(pipe.ender());
        let backlog = Arc::new(SharedBacklog::new(options.usual.backlog_secs));
        let hang_up = Arc::new(std::sync::atomic::AtomicBool::new(false));
        let (slot, clock, is_over) = (Arc::clone(&backlog), host.clone(), Arc::clone(&hang_up));
        thread::spawn(move || {
            while let Some(next) = pipe.next_image() {
                match next {
                    Ok(next) => slot.put(clock.now(), next.image),
                    Err(error) => return slot.end(Some(error)),
                }
                if is_over.load(Ordering::Relaxed) || clock.is_stopped() {
                    break;
                }
            }
            slot.end(None);
        });
        let last_at = host.now();
        Ok(Self {
            argument: input.argument.clone(),
            backlog,
            host: host.clone(),
            patience_secs: options.patience_secs,
            last_at,
            is_silent: false,
            is_done: false,
            hang_up,
            end,
        })
    }

    /// The next image that has not been seen; waits for it. `None` at the end.
    pub(crate) fn next_image(&mut self) -> Option<Result<(Timestamp, PnmImage), SourceError>> {
        while !self.is_done && !self.host.is_stopped() {
            match self.backlog.take() {
                Taken::New(at, image) => {
                    if std::mem::take(&mut self.is_silent) {
                        let secs = at.secs_since(self.last_at);
                        self.host.notice(&format!("{}: images again after {secs:.1} s", self.argument));
                    }
                    // Two images within the clock's grain still follow each other.
                    let at = at.max(Timestamp::from_nanos(self.last_at.nanos() + 1));
                    self.last_at = at;
                    return Some(Ok((at, image)));
                }
                Taken::Nothing => self.listen(),
                Taken::End(error) => {
                    self.is_done = true;
                    // A program that is asked to end with Ctrl-C says so as a fault; it is none.
                    return error.filter(|_| !self.host.is_stopped()).map(Err);
                }
            }
        }
        None
    }

    pub(crate) fn num_dropped(&self) -> usize {
        self.backlog.num_dropped()
    }

    /// Notes a silence; a long one ends the source, if it may.
    fn listen(&mut self) {
        let secs = self.host.now().secs_since(self.last_at);
        if self.patience_secs.is_some_and(|patience| secs > patience) {
            self.host.notice(&format!("{}: no image for {secs:.1} s; that is the end", self.argument));
            self.is_done = true;
        } else if secs > SILENCE_SECS && !self.is_silent {
            self.is_silent = true;
            self.host.notice(&format!("{}: no image for {secs:.1} s, waiting", self.argument));
        }
    }
}

impl Drop for LiveVideo {
    fn drop(&mut self) {
        self.hang_up.store(true, Ordering::Relaxed);
        (self.end)();
    }
}
