//! What live sources borrow from the program: clock, voice, and Ctrl-C as a stop sign.

use std::{
    io::{self, Write},
    sync::{
        OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    time::{SystemTime, UNIX_EPOCH},
};

use visloc_base::{Host, Timestamp};

/// Exit code of a program that was ended with Ctrl-C.
const INTERRUPTED: i32 = 130;

/// The program's host. There is one.
pub fn host() -> &'static Host {
    static HOST: OnceLock<Host> = OnceLock::new();
    HOST.get_or_init(|| {
        Host::new(now, |text| {
            let _ = writeln!(io::stderr(), "note: {text}");
        })
    })
}

/// From now on the first Ctrl-C ends live sources, so that results are written; the second ends the program.
pub fn stop_at_interrupt() {
    static IS_SET: AtomicBool = AtomicBool::new(false);
    if IS_SET.swap(true, Ordering::Relaxed) {
        return;
    }
    let handler = || {
        if host().is_stopped() {
            std::process::exit(INTERRUPTED);
        }
        host().stop();
    };
    // Without a handler Ctrl-C ends the program at once, as ever.
    let _ = ctrlc::set_handler(handler);
}

/// The wall clock: stamps of live images have to agree with those of other programs.
#[allow(clippy::disallowed_methods)]
pub fn now() -> Timestamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Timestamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}
