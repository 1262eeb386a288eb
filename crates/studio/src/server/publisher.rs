//! Makes updates beside a run and publishes them.

use std::{
    fmt, io,
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::{self, JoinHandle},
};

use super::hub::Hub;
use crate::{StudioError, Update};

/// Makes an update, or nothing if there is nothing new to be shown.
type Make = Box<dyn FnOnce(&Hub) -> Result<Option<Update>, StudioError> + Send>;

/// Makes updates on a thread of its own, so that a run has nothing to do with encoding. Of what is offered only the latest is kept: the
/// run never waits, and nothing piles up.
pub struct Publisher {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    slot: Mutex<Slot>,
    is_filled: Condvar,
}

#[derive(Default)]
struct Slot {
    next: Option<Make>,
    is_over: bool,
}

impl Shared {
    fn slot(&self) -> MutexGuard<'_, Slot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is to be made next; `None` when it is over.
    fn wait(&self) -> Option<Make> {
        let is_idle = |slot: &mut Slot| slot.next.is_none() && !slot.is_over;
        let waited = self.is_filled.wait_while(self.slot(), is_idle);
        waited.unwrap_or_else(PoisonError::into_inner).next.take()
    }
}

impl Publisher {
    /// Starts the thread.
    ///
    /// # Errors
    /// If there is none.
    pub fn start(hub: Arc<Hub>) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let work = move || {
            while let Some(make) = theirs.wait() {
                match make(&hub) {
                    Ok(Some(update)) => hub.publish(update),
                    Ok(None) => {}
                    Err(error) => hub.complain(&error.to_string()),
                }
            }
        };
        let thread = thread::Builder::new().name("studio-publisher".to_owned()).spawn(work)?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Has an update made and published, unless a later one is offered before its turn comes.
    pub fn offer(&self, make: impl FnOnce(&Hub) -> Result<Option<Update>, StudioError> + Send + 'static) {
        let left_out = self.shared.slot().next.replace(Box::new(make));
        self.shared.is_filled.notify_one();
        drop(left_out);
    }
}

impl Drop for Publisher {
    /// What was offered last is still published.
    fn drop(&mut self) {
        self.shared.slot().is_over = true;
        self.shared.is_filled.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl fmt::Debug for Publisher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Publisher").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use visloc_core::Clock;

    use super::*;

    fn update(number: u8) -> Update {
        Update { scene: Arc::from([0; 4]), state: Arc::from([number; 4]), image: None }
    }

    #[test]
    fn a_slow_update_holds_up_nobody_and_the_latest_is_made_next() {
        let (hub, _commands) = Hub::new(Clock::still(), |_| {});
        let publisher = Publisher::start(Arc::clone(&hub)).unwrap();
        let ((started, has_started), (go_on, may_go_on)) = (sync_channel(1), sync_channel::<()>(1));
        publisher.offer(move |_| {
            let _ = started.send(());
            let _ = may_go_on.recv();
            Ok(Some(update(1)))
        });
        has_started.recv().unwrap();
        let (made, all_made) = sync_channel(100);
        for number in 2..100 {
            let made = made.clone();
            publisher.offer(move |hub| {
                assert_eq!(hub.latest().unwrap().state[0], 1, "in order");
                made.send(number).unwrap();
                Ok(Some(update(number)))
            });
        }
        go_on.send(()).unwrap();
        drop((publisher, made));
        assert_eq!(all_made.iter().collect::<Vec<_>>(), [99]);
        assert_eq!(hub.latest().unwrap().state[0], 99, "the last one is published in the end");
    }

    #[test]
    fn what_cannot_be_made_is_told_and_the_next_one_is_made() {
        let told = Arc::new(Mutex::new(Vec::new()));
        let log = Arc::clone(&told);
        let (hub, _commands) =
            Hub::new(Clock::still(), move |line: &str| log.lock().unwrap().push(line.to_owned()));
        drop({
            let publisher = Publisher::start(Arc::clone(&hub)).unwrap();
            publisher.offer(|_| Err(StudioError::input("image", "damaged")));
            publisher
        });
        assert_eq!(*told.lock().unwrap(), ["image: damaged"]);
        assert!(hub.latest().is_none());
        let publisher = Publisher::start(Arc::clone(&hub)).unwrap();
        publisher.offer(|_| Ok(None));
        publisher.offer(|_| Ok(Some(update(7))));
        drop(publisher);
        assert_eq!(hub.latest().unwrap().state[0], 7);
    }
}
