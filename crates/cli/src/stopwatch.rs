//! The only place that looks at the wall clock. What it measures is reported, never fed back into a result.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use rustix::time::{ClockId, clock_gettime};
use visloc_core::files;

/// Measures from its making on.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    start: Instant,
}

impl Stopwatch {
    /// Starts now.
    #[allow(clippy::disallowed_methods)]
    pub fn start() -> Self {
        Self { start: Instant::now() }
    }

    /// Time since the start.
    pub fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Seconds since the start.
    pub fn secs(&self) -> f64 {
        self.elapsed().as_secs_f64()
    }

    /// Milliseconds since the start.
    #[cfg(feature = "experiments")]
    pub fn ms(&self) -> f64 {
        self.secs() * 1e3
    }
}

/// Time that this thread has worked, seconds: other programs on the machine do not lengthen it.
pub fn thread_cpu_secs() -> f64 {
    cpu_secs(ClockId::ThreadCPUTime)
}

/// Time that all threads of the program have worked, seconds.
pub fn process_cpu_secs() -> f64 {
    cpu_secs(ClockId::ProcessCPUTime)
}

fn cpu_secs(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Most memory that the program had, megabytes, from the system's own account of the process; `None` where there is none.
pub fn peak_memory_mb() -> Option<f64> {
    let status = files::read_text(Path::new("/proc/self/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes / 1024.0)
}
