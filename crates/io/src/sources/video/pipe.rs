//! The images that ffmpeg writes, one after the other.

use std::{
    io::{BufRead, BufReader, ErrorKind},
    path::Path,
    process::{Child, ChildStderr, ChildStdout},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
        mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use visloc_core::SourceError;

use super::{
    FfmpegInput, Pixels, PnmImage,
    ffmpeg::{command, fault_in, time_in},
    pnm::read_pnm,
};
use crate::sources::{Host, SourcesError};

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 20;
/// Most times that wait for their images.
const MAX_TIMES: usize = 4096;
/// How long an image waits for its time, which is said before the image is written.
const TIME_WAIT: Duration = Duration::from_secs(1);
/// How often it is looked whether the program is asked to end.
const GLANCE: Duration = Duration::from_millis(100);
/// So many glances without an image are a silence that the user hears of.
const SILENT_GLANCES: usize = 30;
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
    child: Arc<Mutex<Child>>,
    /// Counts images; odd while one is waited for.
    turns: Arc<AtomicUsize>,
    is_over: Arc<AtomicBool>,
    output: BufReader<ChildStdout>,
    times: Option<Receiver<f64>>,
    reader: Option<JoinHandle<Vec<String>>>,
    num_images: usize,
    faults: Vec<String>,
    is_done: bool,
}

impl VideoPipe {
    /// Starts the program. It is ended at the host's stop sign, even while it delivers nothing.
    pub(crate) fn start(
        program: &Path,
        input: &FfmpegInput,
        pixels: Pixels,
        host: &Host,
    ) -> Result<Self, SourcesError> {
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
        let child = Arc::new(Mutex::new(child));
        let (turns, is_over) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        let watch = Watch {
            // Who waits for a live source hears of its silence there.
            argument: (!input.is_live).then(|| input.argument.clone()),
            child: Arc::clone(&child),
            turns: Arc::clone(&turns),
            is_over: Arc::clone(&is_over),
            host: host.clone(),
        };
        thread::spawn(move || watch.run());
        Ok(Self {
            argument: input.argument.clone(),
            child,
            turns,
            is_over,
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
        self.turns.fetch_add(1, Ordering::Relaxed);
        let next = read_pnm(&mut self.output);
        self.turns.fetch_add(1, Ordering::Relaxed);
        let reason = match next {
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

    /// Ends the program, from whatever thread.
    pub(crate) fn ender(&self) -> impl Fn() + Send + use<> {
        let child = Arc::clone(&self.child);
        move || end_child(&child)
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
        self.is_over.store(true, Ordering::Relaxed);
        let mut child = self.child.lock().unwrap_or_else(PoisonError::into_inner);
        if fault.is_some() {
            // It may be blocked in a write that nobody will read.
            let _ = child.kill();
        }
        let status = child.wait();
        drop(child);
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
            end_child(&self.child);
            self.is_over.store(true, Ordering::Relaxed);
        }
    }
}

fn end_child(child: &Mutex<Child>) {
    let mut child = child.lock().unwrap_or_else(PoisonError::into_inner);
    let _ = child.kill();
    let _ = child.wait();
}

/// Ends a program that delivers nothing when the user wants an end, and says that it is waited for.
struct Watch {
    /// Its name for the user; `None` if somebody else says it.
    argument: Option<String>,
    child: Arc<Mutex<Child>>,
    turns: Arc<AtomicUsize>,
    is_over: Arc<AtomicBool>,
    host: Host,
}

impl Watch {
    fn run(self) {
        let (mut last, mut num_glances) = (0, 0);
        while !self.is_over.load(Ordering::Relaxed) {
            if self.host.is_stopped() {
                return end_child(&self.child);
            }
            thread::sleep(GLANCE);
            let turn = self.turns.load(Ordering::Relaxed);
            let is_waiting = turn % 2 == 1 && turn == last;
            (last, num_glances) = (turn, if is_waiting { num_glances + 1 } else { 0 });
            if let Some(argument) = self.argument.as_ref().filter(|_| num_glances == SILENT_GLANCES) {
                let secs = (GLANCE * u32::try_from(SILENT_GLANCES).unwrap_or(u32::MAX)).as_secs_f64();
                self.host.notice(&format!("{argument}: no image for {secs:.1} s, waiting"));
            }
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
