//! What a run shows to others: a recording, and pages that watch it.

use std::{
    net::SocketAddr,
    path::{Path, PathBuf},
    sync::{Arc, mpsc::Receiver},
};

use anyhow::{Context, Result};
use serde_json::{Value, json};
use visloc_rerun::RerunFile;
use visloc_studio::{
    Clock, Command, Hub, StudioError, Update, new_file,
    recording::{Input, Recorder},
    server::Server,
};

use crate::{args::BroadcastArgs, say, stopwatch::Stopwatch};

/// How long a notice is part of all updates, seconds: a page that is busy leaves updates out.
const NOTICE_SECS: f64 = 2.0;
/// Where a run writes what a page asks it to save.
const FOLDER: &str = "out/studio";

/// Where updates go.
pub struct Broadcast {
    recording: Option<Recording>,
    publisher: Option<Publisher>,
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
struct Publisher {
    hub: Arc<Hub>,
    commands: Receiver<Command>,
    watch: Stopwatch,
    notice: Option<(String, f64)>,
    /// Somebody looks at one picture; the run goes on.
    is_paused: bool,
    _server: Server,
}

impl Broadcast {
    /// Opens what the user asks for.
    ///
    /// # Errors
    /// If the file cannot be created or nobody can listen at the address.
    pub fn open(args: &BroadcastArgs) -> Result<Self> {
        let recording = args.record.as_deref().map(Recording::create).transpose()?;
        let publisher = args.publish.map(|address| publish(address, args.token.clone())).transpose()?;
        Ok(Self { recording, publisher, error: None })
    }

    /// Whether frames are to come at the time at which they were taken.
    pub fn is_live(&self) -> bool {
        self.publisher.is_some()
    }

    /// What those who watch ask for since the last call. Pausing and playing the picture is done already.
    pub fn commands(&mut self) -> Vec<Command> {
        let Some(publisher) = &mut self.publisher else { return Vec::new() };
        let all: Vec<Command> = publisher.commands.try_iter().collect();
        let mut others = Vec::new();
        for command in all {
            match command {
                Command::Hello {} => {}
                Command::Pause {} => publisher.is_paused = true,
                Command::Play {} => publisher.is_paused = false,
                command => others.push(command),
            }
        }
        others
    }

    /// Says something to those who watch, and to whoever runs the program.
    pub fn tell(&mut self, notice: &str) {
        say::line!("note: {notice}");
        if let Some(publisher) = &mut self.publisher {
            publisher.notice = Some((notice.to_owned(), publisher.watch.secs() + NOTICE_SECS));
        }
    }

    /// What the state message has besides.
    pub fn aside(&self) -> Value {
        let Some(publisher) = &self.publisher else { return json!({}) };
        let now_secs = publisher.watch.secs();
        let notice = publisher.notice.as_ref().filter(|(_, until_secs)| now_secs < *until_secs);
        json!({ "is_playing": !publisher.is_paused, "notice": notice.map(|(text, _)| text) })
    }

    /// Whether anybody wants to see the next frame. While nobody does, it costs nothing.
    pub fn is_wanted(&self) -> bool {
        let is_watched = |publisher: &Publisher| publisher.hub.num_viewers() > 0;
        (self.recording.is_some() && self.error.is_none()) || self.publisher.as_ref().is_some_and(is_watched)
    }

    /// Shows an update of a moment, seconds since the first frame, and what the algorithms were given for it. What goes wrong is
    /// told at the end: a run is not stopped by it.
    pub fn send(&mut self, update: Result<(Update, f64), StudioError>, input: &Input<'_>) {
        let sent = update.map_err(anyhow::Error::from).and_then(|(update, secs)| {
            if let Some(recording) = &mut self.recording {
                recording.add(&update, secs, Some(input))?;
            }
            if let Some(publisher) = &self.publisher {
                publisher.show(update);
            }
            Ok(())
        });
        if let Err(error) = sent {
            self.error.get_or_insert(error);
        }
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// If anything went wrong on the way.
    pub fn finish(self) -> Result<()> {
        if let Some(recording) = self.recording {
            recording.finish()?;
        }
        self.error.map_or(Ok(()), Err)
    }
}

impl Publisher {
    /// While the picture is paused, those who watch get what was shown last, and what is to be told.
    fn show(&self, update: Update) {
        let shown = self.hub.latest().filter(|_| self.is_paused);
        let Some(shown) = shown else { return self.hub.publish(update) };
        let texts = [&shown.state, &update.state].map(|state| visloc_studio::Message::read(state).ok());
        let [Some(mut still), Some(now)] = texts else { return };
        let mut is_changed = !Arc::ptr_eq(&shown.scene, &update.scene);
        for key in ["is_playing", "notice"] {
            let value = now.header.get(key).cloned().unwrap_or(Value::Null);
            is_changed |= still.header.insert(key.to_owned(), value.clone()) != Some(value);
        }
        if is_changed {
            let state = still.write().into();
            self.hub.publish(Update { scene: update.scene, state, image: shown.image.clone() });
        }
    }
}

/// A file for what somebody who watches asks to save. Its name comes from here.
///
/// # Errors
/// If no file can be made.
pub fn new_saved_file(what: &str, extension: &str) -> Result<PathBuf> {
    new_file(Path::new(FOLDER), what, extension).with_context(|| FOLDER.to_owned())
}

impl Recording {
    /// Creates a file, and its folder.
    ///
    /// # Errors
    /// If that is not possible, or this program was built without such files.
    pub fn create(path: &Path) -> Result<Self> {
        let is_for_rerun = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("rrd"));
        Ok(match is_for_rerun {
            true => Self::Rerun(RerunFile::create(path)?),
            false => Self::Studio(Box::new(Recorder::create(path)?)),
        })
    }

    /// Appends an update of a moment, seconds since the first frame, and what the algorithms were given for it, which files for Rerun
    /// leave out.
    ///
    /// # Errors
    /// If the disk is full or the like.
    pub fn add(&mut self, update: &Update, secs: f64, input: Option<&Input<'_>>) -> Result<()> {
        match self {
            Self::Studio(recorder) => recorder.add(update, secs, input)?,
            Self::Rerun(file) => file.add(update, secs)?,
        }
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If the disk is full or the like.
    pub fn finish(self) -> Result<()> {
        match self {
            Self::Studio(recorder) => recorder.finish()?,
            Self::Rerun(file) => file.finish()?,
        }
        Ok(())
    }
}

fn publish(address: SocketAddr, token: Option<String>) -> Result<Publisher> {
    let watch = Stopwatch::start();
    let (hub, commands) = Hub::new(Clock::new(move || watch.secs()), |line| say::line!("note: {line}"));
    let server = Server::start(address, token, Arc::clone(&hub))?;
    let token = server.token().map(|token| format!(" --token {token}")).unwrap_or_default();
    say::line!("Watch it with: visloc studio --connect {}{token}", server.address());
    Ok(Publisher { hub, commands, watch, notice: None, is_paused: false, _server: server })
}
