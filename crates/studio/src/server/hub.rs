//! Between the thread of the engine and the pages.

use std::{
    fmt,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, OnceLock, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc::{Receiver, SyncSender, sync_channel},
    },
};

use tokio::sync::watch;
use visloc_core::Clock;

use super::{
    seat::{Seat, Visitor},
    wheel::Wheel,
};
use crate::{Command, Update};

/// Commands that wait for the engine; more are left out and counted.
const MAX_WAITING: usize = 256;

/// Hands the latest update to any number of pages and their commands to the engine. Neither side ever waits for the other: of
/// updates only the latest is kept, and of commands a bounded number.
pub struct Hub {
    updates: watch::Sender<Option<Arc<Update>>>,
    commands: SyncSender<Command>,
    clock: Clock,
    log: Box<dyn Fn(&str) + Send + Sync>,
    is_closed: AtomicBool,
    /// Where files of pages go.
    files: OnceLock<PathBuf>,
    /// What moves the robot, if others may.
    wheel: OnceLock<Arc<Wheel>>,
    seat: Mutex<Seat>,
    /// When the engine began to work, seconds as bits; NaN while it waits.
    busy_since: AtomicU64,
    num_malformed: AtomicU64,
    num_left_out: AtomicU64,
    num_refused: AtomicU64,
    num_complaints: AtomicU64,
}

impl Hub {
    /// A hub, and the end at which the engine takes commands. `log` gets what the person who runs the program should know; it is
    /// called rarely, however many mistakes there are.
    pub fn new(clock: Clock, log: impl Fn(&str) + Send + Sync + 'static) -> (Arc<Self>, Receiver<Command>) {
        let (commands, receiver) = sync_channel(MAX_WAITING);
        let hub = Self {
            updates: watch::Sender::new(None),
            commands,
            clock,
            log: Box::new(log),
            is_closed: AtomicBool::new(false),
            files: OnceLock::new(),
            wheel: OnceLock::new(),
            seat: Mutex::default(),
            busy_since: AtomicU64::new(f64::NAN.to_bits()),
            num_malformed: AtomicU64::new(0),
            num_left_out: AtomicU64::new(0),
            num_refused: AtomicU64::new(0),
            num_complaints: AtomicU64::new(0),
        };
        (Arc::new(hub), receiver)
    }

    /// Lets pages on this computer hand over files, which go below a folder.
    pub fn take_files(&self, folder: &Path) {
        let _ = self.files.set(folder.to_path_buf());
    }

    pub(crate) fn files_folder(&self) -> Option<&Path> {
        self.files.get().map(PathBuf::as_path)
    }

    /// Lets others drive. They need not wait for the engine: what they ask for goes to the wheel at once.
    pub fn let_drive(&self, wheel: Arc<Wheel>) {
        let _ = self.wheel.set(wheel);
    }

    /// Shows something to all pages.
    pub fn publish(&self, update: Update) {
        self.updates.send_replace(Some(Arc::new(update)));
    }

    /// What was shown last.
    pub fn latest(&self) -> Option<Arc<Update>> {
        self.updates.borrow().clone()
    }

    /// How many watch.
    pub fn num_viewers(&self) -> usize {
        self.updates.receiver_count()
    }

    /// The engine begins to work: until [`Hub::rest`] it answers nobody.
    pub fn work(&self) {
        self.busy_since.store(self.clock.secs().to_bits(), Ordering::Relaxed);
    }

    /// The engine waits, for a command, for the time of its next step, or for an image of its source.
    pub fn rest(&self) {
        self.busy_since.store(f64::NAN.to_bits(), Ordering::Relaxed);
    }

    /// How long the engine has answered nobody, seconds; 0 while it waits. Others may ask while it works, so that a program that stalls
    /// can be told from a source that has nothing new.
    pub fn busy_secs(&self) -> f64 {
        // NaN becomes 0.
        (self.clock.secs() - f64::from_bits(self.busy_since.load(Ordering::Relaxed))).max(0.0)
    }

    /// Whether it is over.
    pub fn is_closed(&self) -> bool {
        self.is_closed.load(Ordering::Acquire)
    }

    /// Ends the engine.
    pub fn close(&self) {
        self.is_closed.store(true, Ordering::Release);
        let _ = self.commands.try_send(Command::Hello {});
    }

    /// Messages that were no commands.
    pub fn num_malformed(&self) -> u64 {
        self.num_malformed.load(Ordering::Relaxed)
    }

    /// Commands for which there was no room.
    pub fn num_left_out(&self) -> u64 {
        self.num_left_out.load(Ordering::Relaxed)
    }

    /// How many wanted to watch or to command without the right to.
    pub fn num_refused(&self) -> u64 {
        self.num_refused.load(Ordering::Relaxed)
    }

    /// Counts somebody who may not open the socket, and says so the first, second, fourth, eighth, ... time.
    pub(crate) fn count_refused(&self, reason: &str) {
        let num = self.num_refused.fetch_add(1, Ordering::Relaxed) + 1;
        if num.is_power_of_two() {
            (self.log)(&format!("{num} times somebody was refused; the last time: {reason}"));
        }
    }

    /// The clock.
    pub(crate) fn clock(&self) -> &Clock {
        &self.clock
    }

    /// One more who watches.
    pub(crate) fn subscribe(&self) -> watch::Receiver<Option<Arc<Update>>> {
        let mut receiver = self.updates.subscribe();
        receiver.mark_changed();
        receiver
    }

    /// Takes in the text of a command; what is none is counted.
    pub fn take_text(&self, text: &str) {
        if let Some(command) = self.command_of(text) {
            self.take(command);
        }
    }

    fn command_of(&self, text: &str) -> Option<Command> {
        serde_json::from_str(text).inspect_err(|error| self.count_malformed(&error.to_string())).ok()
    }

    /// Takes in the text of a command from somebody in particular; of those who would drive, from one at a time.
    ///
    /// # Errors
    /// Why the robot does not do it, for that person.
    pub(crate) fn take_text_of(&self, visitor: &Visitor, text: &str) -> Result<(), String> {
        let Some(command) = self.command_of(text) else { return Ok(()) };
        let mut seat = self.seat.lock().unwrap_or_else(PoisonError::into_inner);
        seat.take(visitor, &command, self.clock.secs())?;
        match self.wheel.get().filter(|_| Wheel::is_for(&command)) {
            Some(wheel) => wheel.take(&visitor.name(), &command),
            None => {
                self.take(command);
                Ok(())
            }
        }
    }

    /// Somebody has left. If they drove, the robot stands.
    pub(crate) fn leave(&self, visitor: &Visitor) {
        let mut seat = self.seat.lock().unwrap_or_else(PoisonError::into_inner);
        if !seat.leave(visitor) {
            return;
        }
        match self.wheel.get() {
            Some(wheel) => wheel.let_go(),
            None => self.take(Command::Drive { forward: 0.0, left: 0.0, turn: 0.0, seen_secs: None }),
        }
    }

    /// Takes in a command, if there is room.
    pub(crate) fn take(&self, command: Command) {
        if self.commands.try_send(command).is_err() {
            self.num_left_out.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Counts a message that is no command, and says so the first, second, fourth, eighth, ... time.
    pub(crate) fn count_malformed(&self, reason: &str) {
        let num = self.num_malformed.fetch_add(1, Ordering::Relaxed) + 1;
        if num.is_power_of_two() {
            (self.log)(&format!("{num} messages of pages could not be read; the last one: {reason}"));
        }
    }

    /// Says what is wrong, the first, second, fourth, eighth, ... time.
    pub(crate) fn complain(&self, what: &str) {
        let num = self.num_complaints.fetch_add(1, Ordering::Relaxed) + 1;
        if num.is_power_of_two() {
            (self.log)(what);
        }
    }
}

impl fmt::Debug for Hub {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Hub").field("num_viewers", &self.num_viewers()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn a_hundred_thousand_malformed_messages_are_counted_and_hardly_logged() {
        let lines = Arc::new(Mutex::new(Vec::new()));
        let log = Arc::clone(&lines);
        let (hub, commands) =
            Hub::new(Clock::still(), move |line: &str| log.lock().unwrap().push(line.to_owned()));
        for i in 0..100_000 {
            hub.take_text(if i % 2 == 0 { "{\"type\":\"fly\"}" } else { "\u{0}[" });
        }
        assert_eq!(hub.num_malformed(), 100_000);
        assert!(lines.lock().unwrap().len() < 20);
        assert!(commands.try_recv().is_err(), "none became a command");
    }

    #[test]
    fn commands_without_room_are_left_out() {
        let (hub, commands) = Hub::new(Clock::still(), |_| {});
        (0..1000).for_each(|_| hub.take_text("{\"type\":\"play\"}"));
        assert_eq!(commands.try_iter().count() as u64 + hub.num_left_out(), 1000);
        assert_eq!(hub.num_left_out(), 1000 - MAX_WAITING as u64);
    }

    #[test]
    fn of_updates_only_the_latest_is_kept() {
        let (hub, _commands) = Hub::new(Clock::still(), |_| {});
        let stalled = hub.subscribe();
        let kept: Vec<_> = (0..100_u8)
            .map(|i| {
                let state: Arc<[u8]> = vec![i; 10].into();
                let weak = Arc::downgrade(&state);
                hub.publish(Update { scene: Arc::from([0; 4]), state, image: None });
                weak
            })
            .collect();
        assert_eq!(kept.iter().filter(|state| state.upgrade().is_some()).count(), 1);
        assert_eq!(stalled.borrow().as_ref().unwrap().state[0], 99);
        assert_eq!(hub.num_viewers(), 1);
    }
}
