//! What a run shows to others: a recording, and pages that watch it.

use std::{
    net::SocketAddr,
    path::Path,
    sync::{Arc, mpsc::Receiver},
};

use anyhow::Result;
use visloc_rerun::RerunFile;
use visloc_studio::{Clock, Command, Hub, StudioError, Update, recording::Recorder, server::Server};

use crate::{args::BroadcastArgs, say, stopwatch::Stopwatch};

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
    /// Nobody at a page can change a run on a recording, so commands are taken and left.
    commands: Receiver<Command>,
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

    /// Whether anybody wants to see the next frame. While nobody does, it costs nothing.
    pub fn is_wanted(&self) -> bool {
        let is_watched = |publisher: &Publisher| {
            publisher.commands.try_iter().for_each(drop);
            publisher.hub.num_viewers() > 0
        };
        (self.recording.is_some() && self.error.is_none()) || self.publisher.as_ref().is_some_and(is_watched)
    }

    /// Shows an update of a moment, seconds since the first frame. What goes wrong is told at the end: a run is not stopped by it.
    pub fn send(&mut self, update: Result<(Update, f64), StudioError>) {
        let sent = update.map_err(anyhow::Error::from).and_then(|(update, secs)| {
            if let Some(recording) = &mut self.recording {
                recording.add(&update, secs)?;
            }
            if let Some(publisher) = &self.publisher {
                publisher.hub.publish(update);
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

    /// Appends an update of a moment, seconds since the first frame.
    ///
    /// # Errors
    /// If the disk is full or the like.
    pub fn add(&mut self, update: &Update, secs: f64) -> Result<()> {
        match self {
            Self::Studio(recorder) => recorder.add(update, secs)?,
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
    Ok(Publisher { hub, commands, _server: server })
}
