//! A source that is read on a thread of its own.

use std::{
    sync::mpsc::{Receiver, TryRecvError, sync_channel},
    thread,
};

use visloc_core::SourceError;

use crate::StudioError;

/// Items of a source, as they come. No more than a few are read ahead: whoever reads slowly slows down a recorded source, and a live
/// one leaves out what it has no room for.
pub struct Feed<T> {
    items: Receiver<Result<T, SourceError>>,
}

/// What a feed has.
#[derive(Debug)]
pub enum Fed<T> {
    /// The next item.
    Item(T),
    /// Nothing at the moment.
    NotYet,
    /// Nothing any more.
    End,
    /// Nothing any more, and why.
    Failed(SourceError),
}

impl<T: Send + 'static> Feed<T> {
    /// Opens a source on a thread of its own and begins to read. `open` also tells what must be known of it first. `num_ahead` items
    /// are read ahead: 0 for what is live.
    ///
    /// # Errors
    /// What `open` refuses, and if there is no thread.
    pub fn start<S, H: Send + 'static>(
        open: impl FnOnce() -> Result<(S, H), StudioError> + Send + 'static,
        next: impl Fn(&mut S) -> Option<Result<T, SourceError>> + Send + 'static,
        num_ahead: usize,
    ) -> Result<(Self, H), StudioError> {
        let (opened, head) = sync_channel(1);
        let (sender, items) = sync_channel(num_ahead);
        let read = move || {
            let mut source = match open() {
                Ok((source, head)) => {
                    let _ = opened.send(Ok(head));
                    source
                }
                Err(error) => {
                    let _ = opened.send(Err(error));
                    return;
                }
            };
            while let Some(item) = next(&mut source) {
                let is_last = item.is_err();
                // Nobody wants more.
                if sender.send(item).is_err() || is_last {
                    return;
                }
            }
        };
        let thread = thread::Builder::new().name("studio-source".to_owned()).spawn(read);
        thread.map_err(|error| StudioError::input("source", error))?;
        let head = head.recv().map_err(|error| StudioError::input("source", error))??;
        Ok((Self { items }, head))
    }

    /// What there is now.
    pub fn poll(&self) -> Fed<T> {
        match self.items.try_recv() {
            Ok(Ok(item)) => Fed::Item(item),
            Ok(Err(error)) => Fed::Failed(error),
            Err(TryRecvError::Empty) => Fed::NotYet,
            Err(TryRecvError::Disconnected) => Fed::End,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_in_order_and_no_more_than_asked_for_are_read_ahead() {
        let open = || Ok((0..5_u32, "head"));
        let (feed, head) = Feed::start(open, |numbers| numbers.next().map(Ok), 1).unwrap();
        assert_eq!(head, "head");
        let mut all = Vec::new();
        loop {
            match feed.poll() {
                Fed::Item(number) => all.push(number),
                Fed::NotYet => thread::yield_now(),
                Fed::End => break,
                Fed::Failed(error) => panic!("{error}"),
            }
        }
        assert_eq!(all, [0, 1, 2, 3, 4]);
    }

    #[test]
    fn what_cannot_be_opened_is_told_at_once() {
        let open = || Err::<((), ()), _>(StudioError::input("camera", "none"));
        let error = Feed::<u32>::start(open, |()| None, 0).err().unwrap();
        assert_eq!(error.to_string(), "camera: none");
    }
}
