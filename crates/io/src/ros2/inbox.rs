//! Messages between the thread that receives and the one that works.

use std::{
    collections::VecDeque,
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

use visloc_core::Timestamp;

use crate::bag::RosMessage;

/// Most images that wait; the oldest are dropped.
const MAX_IMAGES: usize = 16;
/// Most messages that wait.
const MAX_MESSAGES: usize = 10_000;

/// Something that was received.
// Nearly all are messages.
#[allow(clippy::large_enum_variant)]
#[derive(Debug)]
pub(crate) enum Received {
    /// A message, and when it came.
    Message(Timestamp, RosMessage),
    /// Messages that were lost on the way: numbers are missing.
    Lost(u64),
    /// Bytes that are no message of the expected type.
    Unreadable(String),
}

/// A bounded queue. Who puts never waits.
#[derive(Debug, Default)]
pub(crate) struct Inbox {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    waiting: VecDeque<Received>,
    num_images: usize,
    num_dropped: usize,
    fault: Option<String>,
}

impl Inbox {
    pub(crate) fn put(&self, received: Received) {
        let mut state = self.lock();
        state.num_images += usize::from(is_image(&received));
        state.waiting.push_back(received);
        if state.num_images > MAX_IMAGES
            && let Some(oldest) = state.waiting.iter().position(is_image)
        {
            state.waiting.remove(oldest);
            state.num_images -= 1;
            state.num_dropped += 1;
        }
        if state.waiting.len() > MAX_MESSAGES
            && let Some(received) = state.waiting.pop_front()
            && is_image(&received)
        {
            state.num_images -= 1;
            state.num_dropped += 1;
        }
        self.changed.notify_one();
    }

    /// Says that nothing more will come.
    pub(crate) fn fail(&self, fault: String) {
        self.lock().fault = Some(fault);
        self.changed.notify_one();
    }

    /// Everything that waits; waits a while if that is nothing.
    ///
    /// # Errors
    /// Why nothing more will come.
    pub(crate) fn take_all(&self, wait: Duration) -> Result<VecDeque<Received>, String> {
        let mut state = self.lock();
        if state.waiting.is_empty() && state.fault.is_none() && !wait.is_zero() {
            state = self.changed.wait_timeout(state, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
        if let (true, Some(fault)) = (state.waiting.is_empty(), &state.fault) {
            return Err(fault.clone());
        }
        state.num_images = 0;
        Ok(std::mem::take(&mut state.waiting))
    }

    /// Images that were dropped because nobody took them.
    pub(crate) fn num_dropped(&self) -> usize {
        self.lock().num_dropped
    }

    /// A panic elsewhere leaves nothing half done here.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn is_image(received: &Received) -> bool {
    matches!(received, Received::Message(_, RosMessage::Image(_) | RosMessage::CompressedImage(_)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bag::messages::{Bool, CompressedImage};

    #[test]
    fn memory_is_bounded_and_old_images_go_first() {
        let inbox = Inbox::default();
        for i in 0..100 {
            let image = CompressedImage { format: i.to_string(), ..CompressedImage::default() };
            inbox.put(Received::Message(Timestamp::default(), RosMessage::CompressedImage(image)));
            for _ in 0..200 {
                let message = RosMessage::FootContact(Bool { data: true });
                inbox.put(Received::Message(Timestamp::default(), message));
            }
        }
        assert_eq!(inbox.num_dropped(), 100 - MAX_IMAGES);
        let waiting = inbox.take_all(Duration::ZERO).unwrap();
        assert_eq!(waiting.len(), MAX_MESSAGES);
        let images: Vec<_> = waiting.iter().filter(|received| is_image(received)).collect();
        let Received::Message(_, RosMessage::CompressedImage(last)) = images[images.len() - 1] else {
            panic!()
        };
        assert_eq!((images.len(), last.format.as_str()), (MAX_IMAGES, "99"));
        inbox.fail("over".into());
        assert_eq!(inbox.take_all(Duration::ZERO).unwrap_err(), "over");
    }
}
