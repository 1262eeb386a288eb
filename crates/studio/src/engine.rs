//! Runs a session: commands as they come, steps at their pace, and nothing at all while nobody watches.

use std::{
    sync::mpsc::{Receiver, RecvTimeoutError},
    time::Duration,
};

use crate::{Clock, Command, Hub, Session, StudioError};

/// Steps that are late by more than this are not made up for, seconds.
const MAX_LATE_SECS: f64 = 0.1;
/// Commands taken in before the next picture.
const MAX_BATCH: usize = 64;
/// How often a session without steps looks whether it is to end, seconds.
const IDLE_SECS: f64 = 0.5;
/// How long a notice is part of all updates, seconds: a page that is busy leaves updates out.
const NOTICE_SECS: f64 = 2.0;

/// Opens the sessions that pages can choose.
pub trait Engine: Send {
    /// Opens a session by its id.
    ///
    /// # Errors
    /// If there is no such session or it cannot be opened.
    fn open(&mut self, scene: &str) -> Result<Box<dyn Session>, StudioError>;
}

/// Shows a session to the pages, with what the people there should know.
struct Screen<'a> {
    hub: &'a Hub,
    clock: &'a Clock,
    notice: Option<String>,
    notice_until_secs: f64,
}

impl Screen<'_> {
    fn show(&mut self, session: &mut dyn Session, problem: Option<StudioError>) {
        let now_secs = self.clock.secs();
        if let Some(problem) = problem {
            self.notice = Some(problem.to_string());
            self.notice_until_secs = now_secs + NOTICE_SECS;
        } else if now_secs > self.notice_until_secs {
            self.notice = None;
        }
        match session.update(self.notice.as_deref()) {
            Ok(update) => self.hub.publish(update),
            Err(error) => self.hub.complain(&error.to_string()),
        }
    }
}

/// Runs until the hub is closed. A session that somebody opens takes the place of the one before.
pub fn run_engine(
    mut engine: Box<dyn Engine>,
    mut session: Box<dyn Session>,
    hub: &Hub,
    commands: &Receiver<Command>,
    clock: &Clock,
) {
    let mut due_secs = clock.secs();
    let mut screen = Screen { hub, clock, notice: None, notice_until_secs: 0.0 };
    while !hub.is_closed() {
        if hub.num_viewers() == 0 {
            // Blocks without cost; a new page says hello.
            match commands.recv() {
                Ok(command) => react(engine.as_mut(), &mut session, command, commands, &mut screen),
                Err(_) => return,
            }
            due_secs = clock.secs();
            continue;
        }
        let wait_secs = session.step_secs().map(|_| (due_secs - clock.secs()).max(0.0));
        let wait = Duration::from_secs_f64(wait_secs.unwrap_or(IDLE_SECS).min(IDLE_SECS));
        match commands.recv_timeout(wait) {
            Ok(command) => react(engine.as_mut(), &mut session, command, commands, &mut screen),
            Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {}
        }
        let now_secs = clock.secs();
        match session.step_secs() {
            Some(step_secs) if now_secs >= due_secs => {
                let problem = session.step().err();
                screen.show(session.as_mut(), problem);
                due_secs = (due_secs + step_secs).max(now_secs - MAX_LATE_SECS);
            }
            Some(_) => {}
            None => due_secs = now_secs,
        }
    }
}

/// Takes in a command and all that wait behind it, and shows at once what came of them.
fn react(
    engine: &mut dyn Engine,
    session: &mut Box<dyn Session>,
    first: Command,
    commands: &Receiver<Command>,
    screen: &mut Screen<'_>,
) {
    let mut problem = None;
    let waiting = std::iter::from_fn(|| commands.try_recv().ok()).take(MAX_BATCH);
    for command in std::iter::once(first).chain(waiting) {
        let done = match &command {
            Command::Hello {} => Ok(()),
            Command::Open { scene } => engine.open(scene).map(|opened| *session = opened),
            command => session.handle(command),
        };
        problem = done.err().or(problem);
    }
    screen.show(session.as_mut(), problem);
}
