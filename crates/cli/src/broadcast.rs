//! What a run shows to others: a recording, and pages that watch it.

use std::{
    net::SocketAddr,
    path::Path,
    sync::{Arc, mpsc::Receiver},
};

use anyhow::Result;
use visloc_studio::{Clock, Command, Hub, StudioError, Update, recording::Recorder, server::Server};

use crate::{args::BroadcastArgs, say, stopwatch::Stopwatch};

/// Where updates go.
pub struct Broadcast {
    recorder: Option<Recorder>,
    publisher: Option<Publisher>,
    error: Option<anyhow::Error>,
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
        let recorder = args.record.as_deref().map(create).transpose()?;
        let publisher = args.publish.map(|address| publish(address, args.token.clone())).transpose()?;
        Ok(Self { recorder, publisher, error: None })
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
        (self.recorder.is_some() && self.error.is_none()) || self.publisher.as_ref().is_some_and(is_watched)
    }

    /// Shows an update of a moment, seconds since the first frame. What goes wrong is told at the end: a run is not stopped by it.
    pub fn send(&mut self, update: Result<(Update, f64), StudioError>) {
        let sent = update.map_err(anyhow::Error::from).and_then(|(update, secs)| {
            if let Some(recorder) = &mut self.recorder {
                recorder.add(&update, secs)?;
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
        if let Some(recorder) = self.recorder {
            recorder.finish()?;
        }
        self.error.map_or(Ok(()), Err)
    }
}

fn create(path: &Path) -> Result<Recorder> {
    Ok(Recorder::create(path)?)
}

fn publish(address: SocketAddr, token: Option<String>) -> Result<Publisher> {
    let watch = Stopwatch::start();
    let (hub, commands) = Hub::new(Clock::new(move || watch.secs()), |line| say::line!("note: {line}"));
    let server = Server::start(address, token, Arc::clone(&hub))?;
    let token = server.token().map(|token| format!(" --token {token}")).unwrap_or_default();
    say::line!("Watch it with: visloc studio --connect {}{token}", server.address());
    Ok(Publisher { hub, commands, _server: server })
}
