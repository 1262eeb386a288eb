//! What sources borrow from the program: clock, voice, and signals as a stop sign.

use std::{
    io::{self, Write},
    sync::{Once, OnceLock},
    time::{SystemTime, UNIX_EPOCH},
};

use signal_hook::{consts, flag};
use visloc_core::{Host, Timestamp};

/// Exit code of a program that was interrupted.
pub const INTERRUPTED: u8 = 130;

/// The program's host. There is one.
pub fn host() -> &'static Host {
    static HOST: OnceLock<Host> = OnceLock::new();
    HOST.get_or_init(another)
}

/// A host with a stop sign of its own.
pub fn another() -> Host {
    Host::new(now, |text| {
        let _ = writeln!(io::stderr(), "note: {text}");
    })
}

/// From now on the first Ctrl-C, SIGTERM or hang-up sets the stop sign, so that results are written; the second ends the
/// program at once. Only for commands that look at the sign: without this, a signal ends the program as ever.
pub fn stop_at_signals() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for signal in signals() {
            let sign = || host().stop_sign();
            // In this order the first signal finds the sign not set yet. Without a handler the signal ends the program.
            let _ = flag::register_conditional_shutdown(signal, i32::from(INTERRUPTED), sign());
            let _ = flag::register(signal, sign());
        }
    });
}

#[cfg(unix)]
fn signals() -> Vec<i32> {
    let mut signals = vec![consts::SIGINT, consts::SIGTERM];
    // Under nohup a run goes on when the terminal is closed.
    if !is_ignored(consts::SIGHUP) {
        signals.push(consts::SIGHUP);
    }
    signals
}

#[cfg(not(unix))]
fn signals() -> Vec<i32> {
    vec![consts::SIGINT, consts::SIGTERM]
}

/// From the system's own account of the process; false where there is none.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = visloc_core::files::read_text(std::path::Path::new("/proc/self/status")).unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}

/// The wall clock: stamps of live images have to agree with those of other programs.
#[allow(clippy::disallowed_methods)]
pub fn now() -> Timestamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Timestamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}
