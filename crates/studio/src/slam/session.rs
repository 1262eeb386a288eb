//! A sequence in the studio.

use std::path::PathBuf;

use serde_json::{Value, json};
use visloc_base::{CameraTrajectory, GrayFrame, ImageSource};
use visloc_data::sequence::{SequenceOptions, open_sequence};
use visloc_sim::CameraTour;
use visloc_slam::{Clock, FrameOutcome, Slam, SlamConfig};

use super::viewer::{SlamFrame, SlamViewer};
use crate::{Command, Session, StudioError, Update, message::lay_over, recording::Input};

/// Time between images until two of them tell it, seconds.
const USUAL_STEP_SECS: f64 = 0.05;
/// A gap in a sequence is waited for no longer than this, seconds.
const MAX_STEP_SECS: f64 = 0.5;
/// Fastest pace, as multiple of reality.
const MAX_SPEED: f64 = 16.0;

/// Where the images of a session come from.
#[derive(Debug, Clone)]
pub enum SequenceSource {
    /// A simulated tour by its name.
    Tour(String),
    /// The folder of a dataset.
    Folder(PathBuf),
}

/// A running system.
struct Running {
    source: Box<dyn ImageSource + Send>,
    slam: Slam,
    viewer: SlamViewer,
    last: Option<(GrayFrame, FrameOutcome)>,
}

/// SLAM on a sequence that is played and stepped.
pub struct SlamSession {
    from: SequenceSource,
    more: Value,
    clock: Clock,
    seed: u64,
    running: Running,
    step_secs: f64,
    is_playing: bool,
    is_over: bool,
    speed: f64,
}

impl SlamSession {
    /// Opens a sequence; `more` is laid over the scene message, `clock` measures stages.
    ///
    /// # Errors
    /// If there is no such sequence.
    pub fn open(from: SequenceSource, more: Value, clock: Clock, seed: u64) -> Result<Self, StudioError> {
        let running = Running::start(&from, &more, clock, seed)?;
        let mut session = Self {
            from,
            more,
            clock,
            seed,
            running,
            step_secs: USUAL_STEP_SECS,
            is_playing: true,
            is_over: false,
            speed: 1.0,
        };
        session.step()?;
        Ok(session)
    }

    fn reset(&mut self, seed: u64) -> Result<(), StudioError> {
        self.running = Running::start(&self.from, &self.more, self.clock, seed)?;
        (self.seed, self.is_over, self.is_playing) = (seed, false, true);
        self.step()
    }
}

impl Running {
    fn start(from: &SequenceSource, more: &Value, clock: Clock, seed: u64) -> Result<Self, StudioError> {
        let (source, truth, title) = open(from, seed)?;
        let refused = |error: visloc_slam::ConfigError| StudioError::input("SLAM", error);
        let mut slam = Slam::new(source.camera(), &SlamConfig::default(), seed).map_err(refused)?;
        slam.set_clock(clock);
        let viewer = SlamViewer::new(source.camera(), &title, truth, more.clone());
        Ok(Self { source, slam, viewer, last: None })
    }
}

type Opened = (Box<dyn ImageSource + Send>, Option<CameraTrajectory>, String);

fn open(from: &SequenceSource, seed: u64) -> Result<Opened, StudioError> {
    match from {
        SequenceSource::Tour(name) => {
            let tour = CameraTour::new(name, seed).map_err(|error| StudioError::input("tour", error))?;
            let truth = tour.truth();
            Ok((Box::new(tour), Some(truth), format!("sim:{name}")))
        }
        SequenceSource::Folder(folder) => {
            let sequence = open_sequence(folder, &SequenceOptions::default())
                .map_err(|error| StudioError::input(folder.display(), error))?;
            Ok((Box::new(sequence.images), sequence.truth, folder.display().to_string()))
        }
    }
}

impl Session for SlamSession {
    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        match command {
            Command::Play {} if self.is_over => self.reset(self.seed)?,
            Command::Play {} => self.is_playing = true,
            Command::Pause {} => self.is_playing = false,
            Command::Step {} => {
                self.is_playing = false;
                self.step()?;
            }
            Command::Speed { factor } if (0.0..=MAX_SPEED).contains(factor) => self.speed = *factor,
            Command::Reset { seed } => self.reset(*seed)?,
            command => {
                return Err(StudioError::command("command", "one for a camera", format!("{command:?}")));
            }
        }
        Ok(())
    }

    fn step_secs(&self) -> Option<f64> {
        let is_going = self.is_playing && !self.is_over;
        is_going.then(|| if self.speed > 0.0 { self.step_secs / self.speed } else { 0.0 })
    }

    fn step(&mut self) -> Result<(), StudioError> {
        let Running { source, slam, viewer, last } = &mut self.running;
        let frame = match source.next_image() {
            Some(Ok(frame)) => frame,
            Some(Err(error)) => {
                self.is_over = true;
                return Err(StudioError::input("sequence", error));
            }
            None => {
                self.is_over = true;
                return Ok(());
            }
        };
        let outcome = slam
            .add_frame(frame.at, frame.image.clone())
            .map_err(|error| StudioError::input("image", error))?;
        viewer.follow(slam, &SlamFrame { at: frame.at, image: &frame.image, outcome: &outcome });
        if let Some((before, _)) = last {
            self.step_secs = frame.at.secs_since(before.at).clamp(0.0, MAX_STEP_SECS);
        }
        *last = Some((frame, outcome));
        Ok(())
    }

    fn update(&mut self, aside: Option<&Value>) -> Result<Update, StudioError> {
        let mut more = json!({
            "seed": self.seed,
            "is_playing": self.is_playing && !self.is_over,
            "speed": self.speed,
        });
        lay_over(&mut more, aside.unwrap_or(&Value::Null));
        let Running { slam, viewer, last, .. } = &mut self.running;
        let Some((frame, outcome)) = last else {
            return Err(StudioError::input("sequence", "expected an image, found none"));
        };
        viewer.update(slam, &SlamFrame { at: frame.at, image: &frame.image, outcome }, &more)
    }

    fn input(&self) -> Option<Input<'_>> {
        let Running { source, last, .. } = &self.running;
        let (frame, _) = last.as_ref()?;
        Some(Input::Camera { at: frame.at, image: &frame.image, camera: source.camera() })
    }
}
