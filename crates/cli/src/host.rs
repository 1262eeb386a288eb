//! What sources borrow from the program: clock, voice, and signals as a stop sign.

use std::{
    io::{self, Write},
    process,
    sync::{Once, OnceLock},
    thread,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use signal_hook::{consts, flag};
use visloc_core::{Host, Timestamp};

/// Exit code of a program that was interrupted.
pub const INTERRUPTED: u8 = 130;
/// What a program says that was interrupted before there were results.
pub const NOTHING_YET: &str = "interrupted before anything was computed";
/// How often the stop sign is looked at while there is nothing yet.
const GLANCE: Duration = Duration::from_millis(50);
/// How long a command may take to end by itself while there is nothing yet.
const GRACE: Duration = Duration::from_millis(400);

/// Whether the command works through a source.
static SOURCE: Once = Once::new();

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

/// As [`stop_at_signals`], for commands that work through a source. Until that delivers something there are no results, and whatever
/// takes long then (a large map, a map of SLAM, the first image of a source that stalls) is ended by the first signal, too.
pub fn stop_source_at_signals() {
    stop_at_signals();
    SOURCE.call_once(|| drop(thread::spawn(end_before_begin)));
}

/// Whether a source was asked to end before it has delivered anything.
pub fn is_stopped_before_begin() -> bool {
    SOURCE.is_completed() && host().is_stopped() && !host().has_begun()
}

/// Ends the program at the stop sign, unless a source has delivered something before.
fn end_before_begin() {
    while !host().has_begun() {
        thread::sleep(GLANCE);
        if host().is_stopped() {
            thread::sleep(GRACE);
            if is_stopped_before_begin() {
                let _ = writeln!(io::stderr(), "{NOTHING_YET}");
                process::exit(i32::from(INTERRUPTED));
            }
        }
    }
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
