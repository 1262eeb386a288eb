//! Algorithms at work on frames of a source.

use std::sync::Arc;

use serde_json::{Value, json};
use visloc_core::{Clock, Frame, Source, SourceFrame, Truth, settings::Overrides};
use visloc_locate::{
    PipelineConfig, StartPrior,
    lineup::{Lineup, RunSettings},
};
use visloc_world::Map;

use super::{Fed, Feed};
use crate::{
    Command, Session, StudioError, Update, message::lay_over, playback::Playback, recording::Input, tuning,
    view::RunViewer,
};

/// Algorithms that run until somebody chooses others.
const FIRST_ALGORITHMS: [&str; 1] = ["evolutionary"];
/// Frames that are read ahead.
const NUM_AHEAD: usize = 2;
/// How often a source that has nothing is asked again, seconds.
const POLL_SECS: f64 = 0.004;
/// A gap in a recording is waited for no longer than this, seconds.
const MAX_STEP_SECS: f64 = 0.5;

/// A source that has been opened.
pub struct OpenRun {
    /// The frames.
    pub frames: Box<dyn Source<SourceFrame>>,
    /// The map that they belong to.
    pub map: Map,
}

/// Opens a source from its beginning, with the seed of whatever is random in it. A live one goes on where it is.
pub type FramesOpener = Arc<dyn Fn(u64) -> Result<OpenRun, StudioError> + Send + Sync>;

/// Algorithms on frames of a source that is played and stepped.
pub struct SourceSession {
    open: FramesOpener,
    is_live: bool,
    title: String,
    more: Value,
    feed: Feed<SourceFrame>,
    lineup: Lineup,
    viewer: RunViewer,
    frame: Option<(Arc<Frame>, Option<Truth>)>,
    next: Option<SourceFrame>,
    /// The message of the frame's image; made anew when anything in it has changed.
    image: Option<Arc<[u8]>>,
    playback: Playback,
    is_over: bool,
    has_news: bool,
}

impl SourceSession {
    /// Opens a source; `more` is laid over the scene message. Waits for the first frame of a recorded source.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open(
        title: &str,
        open: FramesOpener,
        is_live: bool,
        more: &Value,
        clock: Clock,
        seed: u64,
    ) -> Result<Self, StudioError> {
        let (feed, map) = start(&open, is_live, seed)?;
        let algorithms = FIRST_ALGORITHMS.map(|name| (name.to_owned(), Overrides::default()));
        let settings = RunSettings {
            map: Arc::new(map),
            seed,
            start: StartPrior::Uniform,
            pipeline: PipelineConfig::default(),
            algorithms: algorithms.to_vec(),
        };
        let lineup = Lineup::new(settings, clock)?;
        let mut own = json!({ "mode": "source", "is_live": is_live });
        lay_over(&mut own, more);
        Ok(Self {
            open,
            is_live,
            title: title.to_owned(),
            viewer: RunViewer::new(title).with(&own),
            more: own,
            feed,
            lineup,
            frame: None,
            next: None,
            image: None,
            playback: Playback::default(),
            is_over: false,
            has_news: false,
        })
    }

    fn reset(&mut self, seed: u64) -> Result<(), StudioError> {
        (self.feed, _) = start(&self.open, self.is_live, seed)?;
        self.lineup.reset(seed)?;
        self.viewer = RunViewer::new(&self.title).with(&self.more);
        (self.frame, self.next, self.image) = (None, None, None);
        self.is_over = false;
        self.playback.play();
        Ok(())
    }

    /// Looks for the frame after this one.
    fn look_ahead(&mut self) -> Result<(), StudioError> {
        if self.next.is_some() || self.is_over {
            return Ok(());
        }
        match self.feed.poll() {
            Fed::Item(frame) => self.next = Some(frame),
            Fed::NotYet => {}
            Fed::End => {
                self.end();
                self.has_news = true;
            }
            Fed::Failed(error) => {
                self.end();
                return Err(StudioError::input(&self.title, error));
            }
        }
        Ok(())
    }

    fn end(&mut self) {
        self.is_over = true;
        self.playback.pause();
    }
}

fn start(open: &FramesOpener, is_live: bool, seed: u64) -> Result<(Feed<SourceFrame>, Map), StudioError> {
    let open = Arc::clone(open);
    let opened = move || open(seed).map(|run| (run.frames, run.map));
    Feed::start(opened, |frames| frames.next_item(), if is_live { 0 } else { NUM_AHEAD })
}

impl Session for SourceSession {
    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        match command {
            Command::Play {} if self.is_over => self.reset(self.lineup.settings().seed)?,
            Command::Step {} => {
                self.playback.pause();
                self.step()?;
            }
            Command::Reset { seed } => self.reset(*seed)?,
            command => {
                if tuning::obey(&mut self.lineup, command)? {
                    self.image = None;
                } else if !self.playback.handle(command)? {
                    return Err(StudioError::command("command", "one for a source", command.name()));
                }
            }
        }
        Ok(())
    }

    fn step_secs(&self) -> Option<f64> {
        if self.is_over && self.next.is_none() {
            return None;
        }
        if self.is_live {
            // A live source is read on while the picture rests: what comes then is out of date later.
            return Some(POLL_SECS);
        }
        let secs = match (&self.frame, &self.next) {
            (Some((frame, _)), Some(next)) => next.frame.at.secs_since(frame.at).clamp(0.0, MAX_STEP_SECS),
            _ => POLL_SECS,
        };
        self.playback.wait_secs(secs)
    }

    fn step(&mut self) -> Result<(), StudioError> {
        self.has_news = false;
        self.look_ahead()?;
        let Some(next) = self.next.take() else { return Ok(()) };
        if self.is_live && !self.playback.is_playing() && self.frame.is_some() {
            return Ok(());
        }
        if self.frame.is_some() {
            self.viewer.next_frame();
        }
        (self.has_news, self.image) = (true, None);
        let stepped = self.lineup.step(&next.frame);
        self.frame = Some((Arc::new(next.frame), next.truth));
        self.look_ahead()?;
        Ok(stepped?)
    }

    fn has_news(&self) -> bool {
        self.has_news
    }

    fn update(&mut self, aside: Option<&Value>) -> Result<Update, StudioError> {
        let mut more = json!({ "seed": self.lineup.settings().seed });
        lay_over(&mut more, &self.playback.fields());
        lay_over(&mut more, aside.unwrap_or(&Value::Null));
        match &self.frame {
            Some((frame, truth)) => {
                let moment = self.viewer.moment(frame, *truth, &self.lineup, &more)?;
                let update = moment.update(self.image.take())?;
                self.image.clone_from(&update.image);
                Ok(update)
            }
            None => self.viewer.waiting(&self.lineup, &more),
        }
    }

    fn input(&self) -> Option<Input<'_>> {
        let (frame, truth) = self.frame.as_ref()?;
        Some(Input::Robot { frame, truth: truth.as_ref() })
    }
}
