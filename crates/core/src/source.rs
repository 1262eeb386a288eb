//! Where everything comes from that visloc works on: the trait of all sources, and what is made of one source for another.

use thiserror::Error;

use crate::Timestamp;

/// Input that could not be used and was left out; the run goes on without it.
#[derive(Debug, Clone, PartialEq)]
pub struct SkippedInput {
    /// Stamp of the message, if it could be read.
    pub at: Option<Timestamp>,
    /// Where it came from, for instance the topic.
    pub origin: String,
    /// What was expected and what was found.
    pub reason: String,
}

/// Why a source has to stop. What came before stays valid.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The input ends in the middle or is damaged.
    #[error("{origin}: {reason}")]
    Broken {
        /// File or device, with the place in it.
        origin: String,
        /// What was expected and what was found.
        reason: String,
    },
}

/// What a source says of itself beside its items.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SourceStatus<'a> {
    /// How many items there will be, if that is known; those that cannot be read count. For progress bars.
    pub num_items: Option<usize>,
    /// What was left out so far.
    pub skipped: &'a [SkippedInput],
    /// How many items of a live source came while nobody was ready for them.
    pub num_dropped: usize,
    /// When the last item of a live source was complete, by the clock of its host: a message may have come later than its
    /// stamp says.
    pub received_at: Option<Timestamp>,
}

/// Everything that delivers [frames of a robot](crate::SourceFrame), [gray images](crate::GrayFrame) or [pictures](crate::Picture): a
/// simulator, a recording, a folder, a camera, a robot.
///
/// A *recorded* source waits for whoever reads it. A *live* one does not: what comes while nobody reads is dropped except
/// for the newest, and counted.
pub trait Source<T> {
    /// The next item in order of time, `None` at the end. After an error there are no more.
    fn next_item(&mut self) -> Option<Result<T, SourceError>>;

    /// What is known beside the items.
    fn status(&self) -> SourceStatus<'_> {
        SourceStatus::default()
    }
}

impl<T, S: Source<T> + ?Sized> Source<T> for Box<S> {
    fn next_item(&mut self) -> Option<Result<T, SourceError>> {
        (**self).next_item()
    }

    fn status(&self) -> SourceStatus<'_> {
        (**self).status()
    }
}

/// A source whose items become others, one by one.
pub struct Mapped<T, F> {
    inner: Box<dyn Source<T>>,
    change: F,
}

crate::debug_shows!([T, F] Mapped<T, F> {});

impl<T, U, F: FnMut(T) -> Result<U, SourceError>> Mapped<T, F> {
    /// Over a source.
    pub fn new(inner: Box<dyn Source<T>>, change: F) -> Self {
        Self { inner, change }
    }
}

impl<T, U, F: FnMut(T) -> Result<U, SourceError>> Source<U> for Mapped<T, F> {
    fn next_item(&mut self) -> Option<Result<U, SourceError>> {
        Some(self.inner.next_item()?.and_then(&mut self.change))
    }

    fn status(&self) -> SourceStatus<'_> {
        self.inner.status()
    }
}

/// A source whose first item was taken, looked at, and put back.
pub struct PutBack<T> {
    first: Option<T>,
    inner: Box<dyn Source<T>>,
}

crate::debug_shows!([T: std::fmt::Debug] PutBack<T> { first });

impl<T> PutBack<T> {
    /// Puts the item back that was taken from a source.
    pub fn new(first: T, inner: Box<dyn Source<T>>) -> Self {
        Self { first: Some(first), inner }
    }
}

impl<T> Source<T> for PutBack<T> {
    fn next_item(&mut self) -> Option<Result<T, SourceError>> {
        self.first.take().map(Ok).or_else(|| self.inner.next_item())
    }

    fn status(&self) -> SourceStatus<'_> {
        self.inner.status()
    }
}
