//! What sources borrow from the program: clock, voice, and signals as a stop sign.

use std::{
    io::{self, Write},
    process,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use signal_hook::{consts, flag};
use visloc_core::{Host, Timestamp};

use crate::say;

/// Exit code of a program that was interrupted.
pub const INTERRUPTED: u8 = 130;
/// What a program says that was interrupted before there were results.
pub const NOTHING_YET: &str = "interrupted before anything was computed";
/// How often the stop sign is looked at while there is nothing yet.
const GLANCE: Duration = Duration::from_millis(50);
/// How long a command may take to end by itself while there is nothing yet.
const GRACE: Duration = Duration::from_millis(400);
/// How long results may be worked out and written after the stop sign before that is said.
const PATIENCE: Duration = Duration::from_secs(2);

/// Whether the command looks at the stop sign.
static LOOKS: AtomicBool = AtomicBool::new(false);
/// Whether the command works through a source.
static HAS_SOURCE: AtomicBool = AtomicBool::new(false);

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

/// Begins the program anew, as the same process, if it listens to topics. For hours messages of all sizes come and go then, and the GNU C library
/// keeps blocks of such sizes in pools, which grow by what is left over between them; from this limit on it returns them at once. It reads
/// the limit from the environment, when a program begins.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn return_blocks_of_messages() {
    use std::{env, os::unix::process::CommandExt};

    const LIMIT: &str = "MALLOC_MMAP_THRESHOLD_";
    const LIMIT_BYTES: &str = "16384";
    let mut args = env::args_os();
    let name = args.next().unwrap_or_default();
    let listens = args.any(|arg| arg == "--params-file" || arg.to_string_lossy().starts_with("ros2:"));
    if listens
        && env::var_os(LIMIT).is_none()
        && let Ok(program) = env::current_exe()
    {
        // If it cannot begin anew, it goes on as it is.
        let _ = process::Command::new(program)
            .arg0(name)
            .args(env::args_os().skip(1))
            .env(LIMIT, LIMIT_BYTES)
            .exec();
    }
}

/// From the program's start on, Ctrl-C, SIGTERM and hang-up set the stop sign, and a second one ends the program at once. A command that
/// does not look at the sign ends by the first one, with a word.
pub fn watch_signals() {
    for signal in signals() {
        let sign = || host().stop_sign();
        // In this order the first signal finds the sign not set yet. Without a handler the signal ends the program.
        let _ = flag::register_conditional_shutdown(signal, i32::from(INTERRUPTED), sign());
        let _ = flag::register(signal, sign());
    }
    // A file that has become too large for the user's limit is an error like a full disk then.
    #[cfg(unix)]
    let _ = flag::register(consts::SIGXFSZ, Arc::default());
    let _ = thread::Builder::new().spawn(end_unseen);
}

/// From now on the command looks at the stop sign, so that results are written.
pub fn stop_at_signals() {
    LOOKS.store(true, Ordering::Relaxed);
}

/// From now on the command computes something of which there is no half, so that the first signal ends it.
#[cfg(feature = "experiments")]
pub fn end_at_signals() {
    LOOKS.store(false, Ordering::Relaxed);
}

/// As [`stop_at_signals`], for commands that work through a source. Until that delivers something there are no results, and whatever
/// takes long then (a large map, a map of SLAM, the first image of a source that stalls) is ended by the first signal, too.
pub fn stop_source_at_signals() {
    HAS_SOURCE.store(true, Ordering::Relaxed);
    stop_at_signals();
}

/// Whether a source was asked to end before it has delivered anything.
pub fn is_stopped_before_begin() -> bool {
    HAS_SOURCE.load(Ordering::Relaxed) && host().is_stopped() && !host().has_begun()
}

/// Ends the program at the stop sign where nobody looks at it, or before there is anything; says what it does if its end takes long.
fn end_unseen() {
    let looks = || LOOKS.load(Ordering::Relaxed);
    let end = |said: &str| {
        let _ = writeln!(io::stderr(), "{said}");
        process::exit(i32::from(INTERRUPTED));
    };
    loop {
        thread::sleep(GLANCE);
        if host().is_stopped() {
            if !looks() {
                end("interrupted before the end");
            }
            thread::sleep(GRACE);
            if is_stopped_before_begin() {
                end(NOTHING_YET);
            }
            thread::sleep(PATIENCE);
            say::note!(
                "results of what came until the signal are being made; a second signal ends at once, without those that are not written yet"
            );
            return;
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
