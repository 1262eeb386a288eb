//! `visloc studio`: the page in the browser.

use std::{
    io::{self, Write as _},
    net::{IpAddr, Ipv4Addr, SocketAddr},
    process::{Command, Stdio},
    thread,
};

use anyhow::{Context, Result};
use visloc_slam::Clock as SlamClock;
use visloc_studio::{Clock, Engine as _, Hub, Scenes, run_engine, server::Server};

use crate::{
    args::StudioArgs,
    say,
    stopwatch::{Stopwatch, thread_cpu_secs},
};

/// Runs the command, until it is interrupted.
///
/// # Errors
/// If the address is taken, or what is to be shown cannot be opened.
pub fn execute(args: &StudioArgs) -> Result<()> {
    let watch = Stopwatch::start();
    let clock = Clock::new(move || watch.secs());
    let mut scenes = Scenes::new(clock.clone(), SlamClock::new(thread_cpu_secs), args.seed.seed)
        .with_recordings(args.replay.clone())
        .with_sequences(args.sequence.clone());
    let first = args.scene.clone().unwrap_or_else(|| scenes.first());
    let session = scenes.open(&first)?;
    let (hub, commands) = Hub::new(clock.clone(), log);
    let engine_hub = hub.clone();
    thread::Builder::new()
        .name("studio-engine".to_owned())
        .spawn(move || run_engine(Box::new(scenes), session, &engine_hub, &commands, &clock))
        .context("cannot start the engine")?;
    let host = args.listen.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST));
    let server = Server::start(SocketAddr::new(host, args.port), None, hub)?;
    let url = server.url();
    say::line!("The studio is at {url}  (Ctrl+C ends it)");
    if !args.no_open {
        open_browser(&url);
    }
    server.wait();
    Ok(())
}

fn log(line: &str) {
    let _ = writeln!(io::stderr(), "studio: {line}");
}

/// Asks the desktop to open an address; who has none reads it in the terminal.
fn open_browser(url: &str) {
    let (program, arguments): (&str, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("cmd", &["/C", "start", ""]),
        _ => ("xdg-open", &[]),
    };
    let quiet = || Stdio::null();
    let _ = Command::new(program)
        .args(arguments)
        .arg(url)
        .stdin(quiet())
        .stdout(quiet())
        .stderr(quiet())
        .spawn();
}
