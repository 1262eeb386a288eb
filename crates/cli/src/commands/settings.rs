//! Settings from files and options.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use visloc_base::files;
use visloc_data::bag::BagTopics;
use visloc_locate::{Half, PipelineConfig, PosePrior, Region, SideLines, StartPrior};
use visloc_settings::{Settings, SettingsError, overlay};
use visloc_slam::SlamConfig;
use visloc_world::Map;

use crate::args::{SlamParametersArgs, StartArg, TopicArgs};

/// Text of a file.
///
/// # Errors
/// If it cannot be read; the error names it.
pub fn read_text(path: &Path) -> Result<String> {
    files::read_text(path).with_context(|| format!("{}: cannot read it", path.display()))
}

/// Parameters of everything but the algorithm.
///
/// # Errors
/// If the file cannot be read or has a mistake; the error names file and line.
pub fn pipeline_config(path: Option<&Path>) -> Result<PipelineConfig> {
    path.map_or_else(|| Ok(PipelineConfig::default()), from_toml)
}

/// Names of topics: defaults, then the file, then single options.
///
/// # Errors
/// If the file cannot be read or has a mistake; the error names file and line.
pub fn bag_topics(args: &TopicArgs) -> Result<BagTopics> {
    let mut topics: BagTopics = args.topics.as_deref().map(from_toml).transpose()?.unwrap_or_default();
    let options = [
        (&args.image_topic, &mut topics.image),
        (&args.camera_info_topic, &mut topics.camera_info),
        (&args.odometry_topic, &mut topics.odometry),
        (&args.truth_topic, &mut topics.ground_truth),
        (&args.base_frame, &mut topics.base_frame),
    ];
    for (given, setting) in options {
        if let Some(given) = given {
            setting.clone_from(given);
        }
    }
    if args.camera_frame.is_some() {
        topics.camera_frame.clone_from(&args.camera_frame);
    }
    Ok(topics)
}

/// Parameters of SLAM: a preset, then the file, then single options.
///
/// # Errors
/// If there is no such preset, the file cannot be read, or a parameter is unknown or out of range; the error names file and
/// line, or the option.
pub fn slam_config(args: &SlamParametersArgs) -> Result<SlamConfig> {
    let mut config = SlamConfig::preset(&args.preset).context("--preset")?;
    if let Some(path) = &args.config {
        config = config.with_toml(&read_text(path)?).with_context(|| path.display().to_string())?;
    }
    for option in &args.set {
        let (key, value) = option
            .split_once('=')
            .ok_or_else(|| anyhow!("--set {option}: expected KEY=VALUE, such as tracking.max_matches=300"))?;
        let (key, value) = (key.trim(), value.trim());
        // A word that is no value of TOML is meant as a text.
        let is_value = toml::from_str::<toml::Table>(&format!("value = {value}")).is_ok();
        let text = if is_value { format!("{key} = {value}") } else { format!("{key} = {value:?}") };
        config = config.with_toml(&text).with_context(|| format!("--set {option}"))?;
    }
    Ok(config)
}

fn from_toml<T: Settings + Default>(path: &Path) -> Result<T> {
    let text = read_text(path)?;
    overlay(&T::default(), &text).map_err(|SettingsError { line, reason }| {
        let line = line.map(|line| format!(", line {line}")).unwrap_or_default();
        anyhow!("{}{line}: {reason}", path.display())
    })
}

/// What is known about the start, from the options given; nothing if there are none.
///
/// # Errors
/// If the map has no halves or side lines, or if options cannot go together.
pub fn start_prior(starts: &[StartArg], map: &Map) -> Result<StartPrior> {
    let Map::Field(field) = map else {
        bail_unless_poses(starts, map)?;
        return Ok(poses(starts));
    };
    let (half_x, half_y) = field.half_carpet_m();
    match starts {
        [] => Ok(StartPrior::Uniform),
        [StartArg::Half(half)] => {
            let (min_x_m, max_x_m) = match half {
                Half::Negative => (-half_x, 0.0),
                Half::Positive => (0.0, half_x),
                Half::Both => (-half_x, half_x),
            };
            let region = Region { min_x_m, max_x_m, min_y_m: -half_y, max_y_m: half_y };
            Ok(StartPrior::Region { region, heading: None })
        }
        [StartArg::SideLines(half)] => Ok(StartPrior::SideLines(SideLines::of(field, *half))),
        starts => {
            bail_unless_poses(starts, map)?;
            Ok(poses(starts))
        }
    }
}

fn bail_unless_poses(starts: &[StartArg], map: &Map) -> Result<()> {
    if starts.iter().all(|start| matches!(start, StartArg::Pose { .. })) {
        return Ok(());
    }
    match map {
        Map::Field(_) => bail!("--start: several are possible only for poses"),
        _ => bail!("--start: the map {} has no halves and side lines; give pose:X,Y,HEADING", map.name()),
    }
}

fn poses(starts: &[StartArg]) -> StartPrior {
    let poses = starts.iter().filter_map(|start| match start {
        StartArg::Pose { world_from_robot, spread } => Some(PosePrior {
            world_from_robot: *world_from_robot,
            position_spread_m: spread.0,
            heading_spread_rad: spread.1,
            weight: 1.0,
        }),
        _ => None,
    });
    let poses: Vec<_> = poses.collect();
    if poses.is_empty() { StartPrior::Uniform } else { StartPrior::Poses(poses) }
}
