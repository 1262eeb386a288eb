//! `visloc studio`: the page in the browser.

use std::{
    io::{self, Write as _},
    net::{IpAddr, Ipv4Addr, SocketAddr},
    path::Path,
    process::{Command, Stdio},
    sync::{Arc, mpsc::Receiver},
    thread,
};

use anyhow::{Context, Result, bail};
use serde_json::Value;
use visloc_slam::Clock as SlamClock;
use visloc_studio::{
    Clock, Command as VisitorCommand, Engine as _, Hub, Scenes, Update,
    recording::RecordingIndex,
    run_engine,
    server::{Remote, Server},
};

use crate::{
    args::StudioArgs,
    broadcast::Recording,
    say,
    stopwatch::{Stopwatch, thread_cpu_secs},
};

/// Runs the command, until it is interrupted.
///
/// # Errors
/// If the address is taken, or what is to be shown cannot be opened.
pub fn execute(args: &StudioArgs) -> Result<()> {
    if let Some(target) = &args.export {
        let [source] = &args.replay[..] else {
            bail!("--export: expected one recording in --replay, found {}", args.replay.len());
        };
        return export(source, target);
    }
    let watch = Stopwatch::start();
    let clock = Clock::new(move || watch.secs());
    let (hub, commands) = Hub::new(clock.clone(), log);
    start_engine(args, &hub, commands, clock)?;
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

/// Starts what the pages show, on a thread of its own.
fn start_engine(
    args: &StudioArgs,
    hub: &Arc<Hub>,
    commands: Receiver<VisitorCommand>,
    clock: Clock,
) -> Result<()> {
    let hub = Arc::clone(hub);
    let thread = thread::Builder::new().name("studio-engine".to_owned());
    if let Some(address) = args.connect.clone() {
        let remote = Remote { address, token: args.token.clone() };
        thread.spawn(move || {
            if let Err(error) = remote.watch(&hub, &commands) {
                log(&error.to_string());
            }
        })
    } else {
        let mut scenes = Scenes::new(clock.clone(), SlamClock::new(thread_cpu_secs), args.seed.seed)
            .with_recordings(args.replay.clone())
            .with_sequences(args.sequence.clone());
        let first = args.scene.clone().unwrap_or_else(|| scenes.first());
        let session = scenes.open(&first)?;
        thread.spawn(move || run_engine(Box::new(scenes), session, &hub, &commands, &clock))
    }
    .context("cannot start the engine")?;
    Ok(())
}

/// Writes a recording as another file.
fn export(source: &Path, target: &Path) -> Result<()> {
    let mut index = RecordingIndex::open(source)?;
    let mut file = Recording::create(target)?;
    for frame in 0..index.num_frames() {
        let state = index.state(frame)?;
        let secs = state.header.get("secs").and_then(Value::as_f64).unwrap_or(0.0);
        let scene = index.scene(frame)?.write().into();
        let image = index.image(frame)?.map(Into::into);
        file.add(&Update { scene, state: state.write().into(), image }, secs)?;
    }
    file.finish()?;
    say::line!("{}: {} frames", target.display(), index.num_frames());
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
    let _ =
        Command::new(program).args(arguments).arg(url).stdin(quiet()).stdout(quiet()).stderr(quiet()).spawn();
}
