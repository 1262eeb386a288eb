//! `visloc studio`: the page in the browser.

use std::{
    io::{self, Write as _},
    net::{IpAddr, Ipv4Addr, SocketAddr},
    path::Path,
    process::{Command, Stdio},
    sync::{Arc, mpsc::Receiver},
    thread::{self, JoinHandle},
    time::Duration,
};

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;
use visloc_core::Clock;
use visloc_io::{
    sequence::MOST_SLAM_SIDE_PX,
    sources::{Host, Purpose, SourceAddress, SourceOption, SourceOptions, open_frames, open_images},
};
use visloc_sim::TEAM;
use visloc_studio::{
    Command as VisitorCommand, Hub, NamedSource, Scenes, SourceOpener, StudioError, Update,
    recording::{RecordingIndex, Tape},
    run_engine,
    server::{Remote, Server},
    slam::{ImagesOpener, OpenCamera},
    source::{FramesOpener, OpenRun},
};
use visloc_world::Map;

use super::{broadcast::Recording, files::file_opener};
use crate::{
    args::StudioArgs,
    host::{another, host, stop_at_signals},
    run::{refuse_source_options, source_options},
    say,
    settings::topic_options,
    slam::{is_map_of_slam, load_fixed_map},
    stopwatch::{Stopwatch, thread_cpu_secs},
};

/// How often it is looked whether the program is to end.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Runs the command, until it is interrupted.
pub fn execute(args: &StudioArgs) -> Result<()> {
    if let Some(target) = &args.export {
        let [source] = &args.replay[..] else {
            bail!("--export: expected one recording in --replay, found {}", args.replay.len());
        };
        let options = SourceOptions {
            seed: args.seed.given,
            ..source_options(&args.options, topic_options(&args.topics)?)?
        };
        refuse_source_options(&options, "makes no difference to a recording; leave it out")?;
        return export(source, target);
    }
    let watch = Stopwatch::start();
    let clock = Clock::new(move || watch.secs());
    let (hub, commands) = Hub::new(clock.clone(), log);
    // Sources are stopped after the end, so that none that waits for images keeps the engine from it.
    let sources = another();
    let engine = start_engine(args, &hub, commands, clock, &sources)?;
    let address = args.listen.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST));
    let server = Server::start(SocketAddr::new(address, args.port), None, Arc::clone(&hub))?;
    let url = server.url();
    stop_at_signals();
    say::line!("The studio is at {url}  (Ctrl+C ends it)");
    if !args.no_open {
        open_browser(&url);
    }
    while !host().is_stopped() {
        thread::sleep(LOOK_EVERY);
    }
    // What is recorded is completed before the program ends.
    hub.close();
    sources.stop();
    let _ = engine.join();
    drop(server);
    Ok(())
}

/// Starts what the pages show, on a thread of its own.
fn start_engine(
    args: &StudioArgs,
    hub: &Arc<Hub>,
    commands: Receiver<VisitorCommand>,
    clock: Clock,
    host: &Host,
) -> Result<JoinHandle<()>> {
    let hub = Arc::clone(hub);
    let robot = args.connect.clone().map(|address| Remote { address, token: args.token.clone() });
    for path in &args.replay {
        // Before the page opens, whichever of them is shown first.
        RecordingIndex::open(path)?;
    }
    let mut scenes = Scenes::new(clock.clone(), Clock::new(thread_cpu_secs), args.seed.value())
        .with_recordings(args.replay.iter().map(|path| path.to_path_buf()).collect())
        .with_folder(args.recordings().to_path_buf())
        .with_sources(named_sources(args, host)?);
    if let Some(robot) = robot {
        scenes = scenes.with_robot(robot, log);
    }
    // Elsewhere nobody hands over files.
    if args.listen.is_none() {
        let options = source_options(&args.options, topic_options(&args.topics)?)?;
        let options = SourceOptions { honored_elsewhere: vec![SourceOption::Seed], ..options };
        scenes = scenes.with_files(file_opener(args.map.as_deref(), options, host));
        hub.take_files(args.recordings());
    }
    let tape = Tape::new(args.recordings());
    let team = args.source.as_deref().filter(|source| is_team(source));
    let first = args.scene.as_deref().or(team).map_or_else(|| scenes.first(), str::to_owned);
    let session = scenes.open(&first)?;
    thread::Builder::new()
        .name("studio-engine".to_owned())
        .spawn(move || run_engine(scenes, session, tape, &hub, &commands, &clock))
        .context("cannot start the engine")
}

/// Writes a recording as another file.
fn export(source: &Path, target: &Path) -> Result<()> {
    let mut index = RecordingIndex::open(source)?;
    let mut file = Recording::create(target)?;
    stop_at_signals();
    let mut num_written = 0;
    for frame in 0..index.num_frames() {
        if host().is_stopped() {
            host().note_interruption();
            break;
        }
        let state = index.state(frame)?;
        let secs = state.header.get("secs").and_then(Value::as_f64).unwrap_or(0.0);
        let scene = index.scene(frame)?.write().into();
        let image = index.image(frame)?.map(Into::into);
        file.add(&Update { scene, state: state.write().into(), image }, secs, None)?;
        num_written += 1;
    }
    file.finish()?;
    say::line!("{}: {}", target.display(), say::count(num_written, "frame"));
    if let Some(damage) = index.damage().filter(|_| !host().is_stopped()) {
        bail!("{}: {damage}{}", source.display(), say::before(num_written, "frame", "written"));
    }
    Ok(())
}

/// Whether it is the simulated team: a scene, and no source of one robot's frames.
fn is_team(source: &str) -> bool {
    source.strip_prefix("sim:") == Some(TEAM)
}

/// The sources that the user names.
fn named_sources(args: &StudioArgs, host: &Host) -> Result<Vec<NamedSource>> {
    let options = SourceOptions {
        seed: args.seed.given,
        // The algorithms take it too.
        honored_elsewhere: vec![SourceOption::Seed],
        ..source_options(&args.options, topic_options(&args.topics)?)?
    };
    let team = args.source.as_deref().filter(|source| is_team(source));
    if let Some(team) = team {
        ensure!(args.map.is_none(), "--map: {team} has a field of its own; leave it out");
    }
    let source = args.source.as_ref().filter(|_| team.is_none());
    if source.is_none() && args.sequence.is_empty() {
        refuse_source_options(&options, "expected a SOURCE or --sequence that it belongs to")?;
    }
    let mut sources = Vec::new();
    if let Some(name) = source {
        let is_robot =
            args.map.is_some() || (name.starts_with("sim:") && SourceAddress::parse(name)?.has_robot());
        let purpose = if is_robot { Purpose::Frames } else { Purpose::Images };
        sources.push(named_source(name, purpose, args.map.as_deref(), &options, host)?);
    }
    for name in &args.sequence {
        sources.push(named_source(name, Purpose::Images, None, &options, host)?);
    }
    Ok(sources)
}

/// A source of a robot's frames or of images; in a map of SLAM always of images.
pub(super) fn named_source(
    name: &str,
    purpose: Purpose,
    map: Option<&str>,
    options: &SourceOptions,
    host: &Host,
) -> Result<NamedSource> {
    let of_slam = map.filter(|map| is_map_of_slam(map));
    let purpose = if of_slam.is_some() { Purpose::Images } else { purpose };
    let address = SourceAddress::parse(name)?;
    address.check(options, purpose)?;
    let opener = match (of_slam, purpose) {
        (Some(map), _) => {
            let map = Arc::new(load_fixed_map(Path::new(map))?);
            SourceOpener::InMap(images_opener(name, options, host), map)
        }
        (None, Purpose::Frames) => SourceOpener::Frames(frames_opener(name, map, options, host)?),
        (None, _) => SourceOpener::Images(images_opener(name, options, host)),
    };
    Ok(NamedSource { name: name.to_owned(), is_live: address.kind().is_live, opener })
}

fn frames_opener(
    name: &str,
    map: Option<&str>,
    options: &SourceOptions,
    host: &Host,
) -> Result<FramesOpener> {
    let map = map.map(Map::load).transpose()?;
    let (name, options, host) = (name.to_owned(), options.clone(), host.clone());
    Ok(Arc::new(move |seed| {
        let options = SourceOptions { seed: Some(seed), ..options.clone() };
        let open = open_frames(&name, &options, &host).map_err(|error| StudioError::input(&name, error))?;
        open.warnings.iter().for_each(|warning| log(warning));
        let map =
            map.clone().or(open.map).ok_or_else(|| StudioError::input(&name, "expected --map NAME|FILE"))?;
        Ok(OpenRun { frames: open.frames, map })
    }))
}

fn images_opener(name: &str, options: &SourceOptions, host: &Host) -> ImagesOpener {
    let (name, options, host) = (name.to_owned(), options.clone(), host.clone());
    Arc::new(move |seed| {
        let mut options = SourceOptions { seed: Some(seed), ..options.clone() };
        options.usual.most_side_px = Some(MOST_SLAM_SIDE_PX);
        let open = open_images(&name, &options, &host).map_err(|error| StudioError::input(&name, error))?;
        open.warnings.iter().for_each(|warning| log(warning));
        Ok(OpenCamera { images: open.images, truth: open.truth })
    })
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
