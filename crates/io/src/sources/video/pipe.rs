//! The images that ffmpeg writes, one after the other.

use std::{
    io::{BufRead, BufReader, ErrorKind},
    path::Path,
    process::{Child, ChildStderr, ChildStdout},
    sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel},
    thread::{self, JoinHandle},
    time::Duration,
};

use visloc_core::SourceError;

use super::{
    FfmpegInput, Pixels, PnmImage,
    ffmpeg::{command, fault_in, time_in},
    pnm::read_pnm,
};
use crate::sources::SourcesError;

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 20;
/// Most times that wait for their images.
const MAX_TIMES: usize = 4096;
/// How long an image waits for its time, which is said before the image is written.
const TIME_WAIT: Duration = Duration::from_secs(1);
/// Most faults that are kept: the first ones.
const MAX_FAULTS: usize = 8;
/// Faults that are quoted in an error.
const NUM_QUOTED: usize = 2;

/// An image with its time in the video, if that is known.
pub(crate) struct PipeImage {
    pub secs: Option<f64>,
    pub image: PnmImage,
}

/// A running ffmpeg. Dropping it ends the process.
pub(crate) struct VideoPipe {
    argument: String,
    child: Child,
    output: BufReader<ChildStdout>,
    times: Option<Receiver<f64>>,
    reader: Option<JoinHandle<Vec<String>>>,
    num_images: usize,
    faults: Vec<String>,
    is_done: bool,
}

impl VideoPipe {
    /// Starts the program.
    pub(crate) fn start(program: &Path, input: &FfmpegInput, pixels: Pixels) -> Result<Self, SourcesError> {
        let no_ffmpeg = |source| SourcesError::NoFfmpeg {
            argument: input.argument.clone(),
            program: program.to_path_buf(),
            source,
        };
        let mut child = command(program, input, pixels).and_then(|mut c| c.spawn()).map_err(no_ffmpeg)?;
        let (Some(stdout), Some(stderr)) = (child.stdout.take(), child.stderr.take()) else {
            return Err(no_ffmpeg(ErrorKind::BrokenPipe.into()));
        };
        let (sender, times) = sync_channel(MAX_TIMES);
        Ok(Self {
            argument: input.argument.clone(),
            child,
            output: BufReader::with_capacity(BUFFER_BYTES, stdout),
            times: Some(times),
            reader: Some(thread::spawn(move || listen(stderr, &sender))),
            num_images: 0,
            faults: Vec::new(),
            is_done: false,
        })
    }

    /// The next image; `None` at the end, or an error if the program ended with a fault or within an image.
    pub(crate) fn next_image(&mut self) -> Option<Result<PipeImage, SourceError>> {
        if self.is_done {
            return None;
        }
        let reason = match read_pnm(&mut self.output) {
            Ok(Some(image)) => {
                self.num_images += 1;
                return Some(Ok(PipeImage { secs: self.time(), image }));
            }
            Ok(None) => self.finish(None)?,
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                self.finish(Some("the last image is cut off".into()))?
            }
            Err(error) => self.finish(Some(error.to_string()))?,
        };
        Some(Err(SourceError::Broken { origin: self.argument.clone(), reason }))
    }

    /// What the program complained about although it went on; complete after the end.
    pub(crate) fn faults(&self) -> &[String] {
        &self.faults
    }

    /// The time of the image that was just read.
    fn time(&mut self) -> Option<f64> {
        match self.times.as_ref()?.recv_timeout(TIME_WAIT) {
            Ok(secs) => Some(secs),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                // A program that does not say times is not waited for again.
                self.times = None;
                None
            }
        }
    }

    /// Waits for the end of the program. What was wrong, if anything was.
    fn finish(&mut self, fault: Option<String>) -> Option<String> {
        self.is_done = true;
        if fault.is_some() {
            // It may be blocked in a write that nobody will read.
            let _ = self.child.kill();
        }
        let status = self.child.wait();
        self.faults = self.reader.take().and_then(|reader| reader.join().ok()).unwrap_or_default();
        let said = match self.faults.len() {
            0 => String::new(),
            _ => format!(": {}", self.faults.iter().take(NUM_QUOTED).cloned().collect::<Vec<_>>().join("; ")),
        };
        let after = format!("after {} images", self.num_images);
        match (fault, status) {
            (Some(fault), _) => Some(format!("{fault} ({after}){said}")),
            (None, Ok(status)) if status.success() && self.num_images > 0 => None,
            (None, Ok(status)) => Some(format!("ffmpeg ended {after} with {status}{said}")),
            (None, Err(error)) => Some(format!("ffmpeg is gone {after}: {error}{said}")),
        }
    }
}

impl Drop for VideoPipe {
    fn drop(&mut self) {
        if !self.is_done {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Sends the times of the images and keeps the first faults.
fn listen(stderr: ChildStderr, times: &SyncSender<f64>) -> Vec<String> {
    let mut faults: Vec<String> = Vec::new();
    for line in BufReader::new(stderr).split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line);
        if let Some(secs) = time_in(&line) {
            // Nobody who listens needs no times.
            let _ = times.try_send(secs);
        } else if let Some(fault) = fault_in(&line)
            && faults.len() < MAX_FAULTS
            && faults.iter().all(|known| known != fault)
        {
            faults.push(fault.to_owned());
        }
    }
    faults
}
