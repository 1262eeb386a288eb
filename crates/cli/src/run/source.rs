//! Opens what the user names.

use std::path::Path;

use anyhow::{Result, anyhow};
use visloc_core::{Source, SourceFrame, geom::Mount};
use visloc_io::sources::{
    SourceAddress, SourceOptions, TopicOptions, UntilStopped, Usual, open_frames, simulated_scenario,
};
use visloc_sim::Simulation;
use visloc_world::Map;

use crate::{
    args::{PictureArgs, SourceArgs, num_cores},
    host::{host, stop_source_at_signals},
};

/// Frames and the map that they belong to.
pub struct OpenSource {
    /// The frames.
    pub frames: Box<dyn Source<SourceFrame>>,
    /// The map.
    pub map: Map,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Options of a source from those of the command line.
pub fn source_options(args: &SourceArgs, topics: TopicOptions) -> Result<SourceOptions> {
    let mount = args.camera_height.map(|height_m| Mount {
        height_m,
        forward_m: args.camera_forward,
        tilt_rad: args.camera_tilt.to_radians(),
        pan_rad: args.camera_pan.to_radians(),
        roll_rad: args.camera_roll.to_radians(),
    });
    Ok(SourceOptions {
        camera: args.camera.as_deref().map(Path::to_path_buf),
        mount,
        urdf: args.urdf.as_deref().map(Path::to_path_buf),
        ..picture_options(&args.pictures, topics)?
    })
}

/// Options of a source that only pictures are taken from.
pub fn picture_options(args: &PictureArgs, topics: TopicOptions) -> Result<SourceOptions> {
    Ok(SourceOptions {
        topics,
        rate_hz: args.fps,
        patience_secs: args.patience,
        ffmpeg: args.ffmpeg.as_deref().map(Path::to_path_buf),
        image_qos: args.image_qos,
        domain_id: args.ros_domain,
        usual: Usual { num_threads: num_cores(), domain_id: usual_domain_id(args)?, ..Usual::default() },
        ..SourceOptions::default()
    })
}

/// The domain that programs of ROS take from the environment, unless one is asked for.
fn usual_domain_id(args: &PictureArgs) -> Result<u16> {
    match std::env::var("ROS_DOMAIN_ID") {
        Ok(text) if args.ros_domain.is_none() && !text.trim().is_empty() => {
            let id = text.trim().parse().ok().filter(|id| *id <= 232);
            id.ok_or_else(|| anyhow!("ROS_DOMAIN_ID: expected a number from 0 to 232, found '{text}'"))
        }
        _ => Ok(0),
    }
}

/// Refuses options of a source where none is opened.
pub fn refuse_source_options(options: &SourceOptions, reason: &str) -> Result<()> {
    let is_spare = |option: &visloc_io::sources::SourceOption| !options.honored_elsewhere.contains(option);
    match options.given().find(is_spare) {
        Some(option) => Err(anyhow!("{}: {reason}", option.flag())),
        None => Ok(()),
    }
}

/// Opens a source for localization, and loads the map.
pub fn open_source(name: &str, map: Option<&str>, options: &SourceOptions) -> Result<OpenSource> {
    let given_map = map.map(Map::load).transpose()?;
    let is_simulated = name.starts_with("sim:");
    if given_map.is_none() && !is_simulated {
        SourceAddress::parse(name)?;
        return Err(anyhow!("{name} needs a map: --map robocup-spl-2010, or your own TOML file"));
    }
    let open = open_frames(name, options, host())?;
    let map = given_map.or(open.map).ok_or_else(|| anyhow!("{name}: expected --map NAME|FILE"))?;
    Ok(OpenSource { frames: open.frames, map, warnings: open.warnings })
}

/// Sources end with Ctrl-C, and the results are kept.
pub fn prepare(name: &str) -> Result<()> {
    SourceAddress::parse(name)?;
    stop_source_at_signals();
    Ok(())
}

/// A simulation that ends with Ctrl-C, and the results are kept.
pub fn until_stopped(
    frames: impl Source<SourceFrame> + 'static,
) -> UntilStopped<Box<dyn Source<SourceFrame>>> {
    stop_source_at_signals();
    UntilStopped::new(Box::new(frames), host())
}

/// Starts the simulation of a scenario, or of its first frames; it ends with Ctrl-C as other sources do (see
/// [`until_stopped`]).
pub fn simulation(
    scenario: &str,
    seed: u64,
    num_threads: usize,
    max_frames: Option<u32>,
) -> Result<Simulation> {
    let address = format!("sim:{scenario}");
    let scenario = simulated_scenario(&SourceAddress::parse(&address)?)?;
    let simulation = Simulation::new(&scenario, seed)?.with_threads(num_threads);
    Ok(simulation.with_num_frames(max_frames.map_or(usize::MAX, |frames| frames as usize)))
}
