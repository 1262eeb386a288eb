//! What a run shows to others: a recording, and pages that watch it.

use std::{
    net::SocketAddr,
    path::{Path, PathBuf},
    sync::{Arc, mpsc::Receiver},
    thread,
    time::Duration,
};

use anyhow::{Context, Result};
use serde_json::{Value, json};
use visloc_core::Clock;
use visloc_rerun::RerunFile;
use visloc_studio::{
    Command, Hub, NOTICE_SECS, StudioError, Update, new_file,
    recording::{Input, Recorder},
    server::{Publisher, Server, Wheel},
};

use super::steering::Steering;
use crate::{args::BroadcastArgs, say, stopwatch::Stopwatch};

/// Longest wait for a frame: a gap in a recording need not be sat out.
const MOST_WAIT_SECS: f64 = 1.0;
/// Where a run writes what a page asks it to save.
const FOLDER: &str = "out/studio";

/// Where updates go.
pub struct Broadcast {
    recording: Option<Recording>,
    watched: Option<Watched>,
    error: Option<anyhow::Error>,
}

/// A file that a run is recorded in; its name says for which program.
pub enum Recording {
    /// The studio.
    Studio(Box<Recorder>),
    /// The Rerun viewer: `.rrd`.
    Rerun(RerunFile),
}

/// A server that other programs watch.
struct Watched {
    hub: Arc<Hub>,
    publisher: Publisher,
    commands: Receiver<Command>,
    watch: Stopwatch,
    notice: Option<(String, f64)>,
    /// Somebody looks at one picture; the run goes on.
    is_paused: bool,
    /// What moves the robot, if those who watch may.
    wheel: Option<Arc<Wheel>>,
    _server: Server,
}

impl Broadcast {
    /// Opens what the user asks for; `None` if that is nothing.
    pub fn open(args: &BroadcastArgs, steering: Option<&Steering>) -> Result<Option<Self>> {
        if args.record.is_none() && args.publish.is_none() {
            return Ok(None);
        }
        let wheel = steering.map(|steering| Arc::clone(steering.wheel()));
        let open = |address| publish(address, args.token.clone(), wheel.clone());
        let watched = args.publish.map(open).transpose()?;
        let recording = args.record.as_deref().map(Recording::create).transpose()?;
        Ok(Some(Self { recording, watched, error: None }))
    }

    /// Waits until a frame is due, seconds since the first one: those who watch see frames at the time at which they were taken.
    pub fn wait_for(&self, secs: f64) {
        let ahead_secs = self.watched.as_ref().map_or(0.0, |watched| secs - watched.watch.secs());
        if ahead_secs > 0.0 {
            thread::sleep(Duration::from_secs_f64(ahead_secs.min(MOST_WAIT_SECS)));
        }
    }

    /// What those who watch ask for since the last call. Pausing and playing the picture is done already. From here to [`Broadcast::rest`]
    /// the run is at work on a frame: those who watch are told if that takes long.
    pub fn commands(&mut self) -> Vec<Command> {
        let Some(watched) = &mut self.watched else { return Vec::new() };
        watched.hub.work();
        let all: Vec<Command> = watched.commands.try_iter().collect();
        let mut others = Vec::new();
        for command in all {
            match command {
                Command::Hello {} => {}
                Command::Pause {} => watched.is_paused = true,
                Command::Play {} => watched.is_paused = false,
                command => others.push(command),
            }
        }
        others
    }

    /// The run waits for its next frame.
    pub fn rest(&self) {
        if let Some(watched) = &self.watched {
            watched.hub.rest();
        }
    }

    /// Says something to those who watch, and to whoever runs the program.
    pub fn tell(&mut self, notice: &str) {
        say::note!("{notice}");
        if let Some(watched) = &mut self.watched {
            watched.notice = Some((notice.to_owned(), watched.watch.secs() + NOTICE_SECS));
        }
    }

    /// What the state message has besides.
    pub fn aside(&self) -> Value {
        let Some(watched) = &self.watched else { return json!({}) };
        let now_secs = watched.watch.secs();
        let notice = watched.notice.as_ref().filter(|(_, until_secs)| now_secs < *until_secs);
        let mut aside = json!({ "is_playing": !watched.is_paused, "notice": notice.map(|(text, _)| text) });
        if let Some(wheel) = &watched.wheel {
            aside["drive"] = wheel.fields();
        }
        aside
    }

    /// Whether anybody wants to see the next frame. While nobody does, it costs nothing.
    pub fn is_wanted(&self) -> bool {
        let is_watched = |watched: &Watched| watched.hub.num_viewers() > 0;
        (self.recording.is_some() && self.error.is_none()) || self.watched.as_ref().is_some_and(is_watched)
    }

    /// Shows a moment, seconds since the first frame, of which `make` makes an update, and what the algorithms were given for it. Without
    /// a recording the update is made on another thread. What goes wrong is told at the end: a run is not stopped by it.
    pub fn send(
        &mut self,
        secs: f64,
        make: impl FnOnce() -> Result<Update, StudioError> + Send + 'static,
        input: &Input<'_>,
    ) {
        let Some(recording) = self.recording.as_mut().filter(|_| self.error.is_none()) else {
            if let Some(watched) = &self.watched {
                watched.show(make);
            }
            return;
        };
        let recorded = make().map_err(anyhow::Error::from).and_then(|update| {
            recording.add(&update, secs, Some(input))?;
            Ok(update)
        });
        match (recorded, &self.watched) {
            (Ok(update), Some(watched)) => watched.show(|| Ok(update)),
            (Ok(_), None) => {}
            (Err(error), _) => self.fail(error),
        }
    }

    /// Keeps the first error until the end.
    pub fn fail(&mut self, error: anyhow::Error) {
        self.error.get_or_insert(error);
    }

    /// Ends the recording.
    pub fn finish(self) -> Result<()> {
        if let Some(recording) = self.recording {
            recording.finish()?;
        }
        self.error.map_or(Ok(()), Err)
    }
}

impl Watched {
    /// While the picture is paused, those who watch get what was shown last, and what is to be told.
    fn show(&self, make: impl FnOnce() -> Result<Update, StudioError> + Send + 'static) {
        let is_paused = self.is_paused;
        self.publisher.offer(move |hub| match hub.latest().filter(|_| is_paused) {
            None => make().map(Some),
            Some(shown) => Ok(still(&shown, make()?)),
        });
    }
}

/// The picture that is shown already with what is to be told now; nothing if that has not changed.
fn still(shown: &Update, update: Update) -> Option<Update> {
    let texts = [&shown.state, &update.state].map(|state| visloc_studio::Message::read(state).ok());
    let [Some(mut still), Some(now)] = texts else { return None };
    let mut is_changed = !Arc::ptr_eq(&shown.scene, &update.scene);
    for key in ["is_playing", "notice"] {
        let value = now.header.get(key).cloned().unwrap_or(Value::Null);
        is_changed |= still.header.insert(key.to_owned(), value.clone()) != Some(value);
    }
    is_changed.then(|| Update {
        scene: update.scene,
        state: still.write().into(),
        image: shown.image.clone(),
    })
}

/// A file for what somebody who watches asks to save. Its name comes from here.
pub fn new_saved_file(what: &str, extension: &str) -> Result<PathBuf> {
    new_file(Path::new(FOLDER), what, extension).with_context(|| FOLDER.to_owned())
}

impl Recording {
    /// Creates a file, and its folder.
    pub fn create(path: &Path) -> Result<Self> {
        let is_for_rerun = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("rrd"));
        Ok(match is_for_rerun {
            true => Self::Rerun(RerunFile::create(path)?),
            false => Self::Studio(Box::new(Recorder::create(path)?)),
        })
    }

    /// Appends an update of a moment, seconds since the first frame, and what the algorithms were given for it, which files for Rerun
    /// leave out.
    pub fn add(&mut self, update: &Update, secs: f64, input: Option<&Input<'_>>) -> Result<()> {
        match self {
            Self::Studio(recorder) => recorder.add(update, secs, input)?,
            Self::Rerun(file) => file.add(update, secs)?,
        }
        Ok(())
    }

    /// Ends the file.
    pub fn finish(self) -> Result<()> {
        match self {
            Self::Studio(recorder) => recorder.finish()?,
            Self::Rerun(file) => file.finish()?,
        }
        Ok(())
    }
}

fn publish(address: SocketAddr, token: Option<String>, wheel: Option<Arc<Wheel>>) -> Result<Watched> {
    let watch = Stopwatch::start();
    let (hub, commands) = Hub::new(Clock::new(move || watch.secs()), |line| say::note!("{line}"));
    let server = match &wheel {
        Some(wheel) => {
            hub.let_drive(Arc::clone(wheel));
            Server::start_guarded(address, token, Arc::clone(&hub))?
        }
        None => Server::start(address, token, Arc::clone(&hub))?,
    };
    let token = server.token().map(|token| format!(" --token {token}")).unwrap_or_default();
    let address = server.address();
    // Nobody can connect to all addresses at once.
    let address = match address.ip().is_unspecified() {
        true => format!("THIS_COMPUTER:{}", address.port()),
        false => address.to_string(),
    };
    say::line!("Watch it with: visloc studio --connect {address}{token}");
    let publisher = Publisher::start(Arc::clone(&hub))?;
    Ok(Watched { hub, publisher, commands, watch, notice: None, is_paused: false, wheel, _server: server })
}
