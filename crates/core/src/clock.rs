//! Time, passed in.

use std::{fmt, sync::Arc};

/// A clock that counts seconds from some start. Measures stages and paces sessions; never used for a result.
#[derive(Clone)]
pub struct Clock(Arc<dyn Fn() -> f64 + Send + Sync>);

impl Clock {
    /// A clock that reads seconds.
    pub fn new(secs: impl Fn() -> f64 + Send + Sync + 'static) -> Self {
        Self(Arc::new(secs))
    }

    /// A clock that stands still.
    pub fn still() -> Self {
        Self::new(|| 0.0)
    }

    /// Seconds since its start.
    pub fn secs(&self) -> f64 {
        (self.0)()
    }

    /// Milliseconds that a piece of work takes, with its result.
    pub fn measure<T>(&self, work: impl FnOnce() -> T) -> (T, f64) {
        let start = self.secs();
        let result = work();
        (result, (self.secs() - start) * 1e3)
    }
}

impl fmt::Debug for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Clock")
    }
}
