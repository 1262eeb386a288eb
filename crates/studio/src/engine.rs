//! Runs a session: commands as they come, steps at their pace, and nothing at all while nobody watches.

use std::{
    path::PathBuf,
    sync::mpsc::{Receiver, RecvTimeoutError},
    time::Duration,
};

use serde_json::{Value, json};
use visloc_core::Clock;

use crate::{Command, Hub, Message, Scenes, Session, StudioError, recording::Tape};

/// Steps that are late by more than this are not made up for, seconds.
const MAX_LATE_SECS: f64 = 0.1;
/// Commands taken in before the next picture.
const MAX_BATCH: usize = 64;
/// How often a session without steps looks whether it is to end, seconds.
const IDLE_SECS: f64 = 0.5;
/// How long a notice is part of all updates, seconds: a page that is busy leaves updates out.
pub const NOTICE_SECS: f64 = 2.0;

/// What is shown: a session, with what the people there should know besides.
struct Stage<'a> {
    scenes: Scenes,
    session: Box<dyn Session>,
    tape: Tape,
    hub: &'a Hub,
    clock: &'a Clock,
    notice: Option<String>,
    notice_until_secs: f64,
    /// The last recording, for the page.
    recorded: Option<Value>,
}

/// Runs a session of some scenes until the hub is closed. A session that somebody opens takes the place of the one before. What pages record goes to `tape`.
pub fn run_engine(
    scenes: Scenes,
    session: Box<dyn Session>,
    tape: Tape,
    hub: &Hub,
    commands: &Receiver<Command>,
    clock: &Clock,
) {
    let mut due_secs = clock.secs();
    let mut stage =
        Stage { scenes, session, tape, hub, clock, notice: None, notice_until_secs: 0.0, recorded: None };
    while !hub.is_closed() {
        if hub.num_viewers() == 0 {
            // Blocks without cost; a new page says hello.
            match commands.recv() {
                Ok(command) => {
                    hub.work();
                    stage.react(command, commands);
                    hub.rest();
                }
                Err(_) => break,
            }
            due_secs = clock.secs();
            continue;
        }
        let wait_secs = stage.session.step_secs().map(|_| (due_secs - clock.secs()).max(0.0));
        let wait = Duration::from_secs_f64(wait_secs.unwrap_or(IDLE_SECS).min(IDLE_SECS));
        let received = commands.recv_timeout(wait);
        hub.work();
        match received {
            Ok(command) => stage.react(command, commands),
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {}
        }
        let now_secs = clock.secs();
        match stage.session.step_secs() {
            Some(step_secs) if now_secs >= due_secs => {
                let problem = stage.session.step().err();
                if problem.is_some() || stage.session.has_news() {
                    stage.show(problem);
                }
                due_secs = (due_secs + step_secs).max(now_secs - MAX_LATE_SECS);
            }
            Some(_) => {}
            None => due_secs = now_secs,
        }
        hub.rest();
    }
    stage.stop_tape();
}

impl Stage<'_> {
    /// Takes in a command and all that wait behind it, and shows at once what came of them.
    fn react(&mut self, first: Command, commands: &Receiver<Command>) {
        let mut problem = None;
        let waiting = std::iter::from_fn(|| commands.try_recv().ok()).take(MAX_BATCH);
        for command in std::iter::once(first).chain(waiting) {
            problem = self.handle(&command).err().or(problem);
        }
        self.show(problem);
    }

    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        match command {
            Command::Hello {} => Ok(()),
            Command::Open { scene } => self.open(scene),
            Command::OpenFile { path, is_place } => {
                let scene = if *is_place { self.scenes.add_place(path) } else { self.scenes.add_file(path) }?;
                self.open(&scene)
            }
            Command::Record { is_on: true } => {
                let scene = Message::read(&self.session.update(None)?.scene)?.header;
                let scene = scene.get("scene").and_then(Value::as_str).unwrap_or("scene");
                self.recorded = None;
                Ok(self.tape.start(scene)?)
            }
            Command::Record { is_on: false } => {
                self.stop_tape();
                Ok(())
            }
            command => self.session.handle(command),
        }
    }

    fn open(&mut self, scene: &str) -> Result<(), StudioError> {
        let opened = self.scenes.open(scene)?;
        self.stop_tape();
        self.session = opened;
        Ok(())
    }

    fn stop_tape(&mut self) {
        let stopped = self.tape.stop();
        self.keep(stopped.map_err(StudioError::from));
    }

    /// A recording that has ended can be opened; one that failed is told.
    fn keep(&mut self, ended: Result<Option<PathBuf>, StudioError>) {
        match ended {
            Ok(Some(path)) => {
                let file = path.display().to_string();
                let scene = self.scenes.add_recording(path);
                self.recorded = Some(json!({ "is_on": false, "file": file, "scene": scene }));
            }
            Ok(None) => {}
            Err(error) => self.tell(&error),
        }
    }

    fn tell(&mut self, problem: &StudioError) {
        self.notice = Some(problem.to_string());
        self.notice_until_secs = self.clock.secs() + NOTICE_SECS;
    }

    fn show(&mut self, problem: Option<StudioError>) {
        match problem {
            Some(problem) => self.tell(&problem),
            None if self.clock.secs() > self.notice_until_secs => self.notice = None,
            None => {}
        }
        let recorder = self.tape.status().or_else(|| self.recorded.clone());
        let aside = json!({ "notice": self.notice, "recorder": recorder });
        let update = match self.session.update(Some(&aside)) {
            Ok(update) => update,
            Err(error) => return self.hub.complain(&error.to_string()),
        };
        let input = self.session.input();
        let taped = self.tape.offer(&update, input.as_ref());
        self.hub.publish(update);
        self.keep(taped.map_err(StudioError::from));
    }
}
