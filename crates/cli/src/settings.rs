//! Settings from files and options.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use visloc_core::{
    files,
    settings::{Overrides, Settings, SettingsError, overlay},
};
use visloc_io::{bag::BagTopics, sources::TopicOptions};
use visloc_locate::{FeatureChoice, Half, PipelineConfig, PosePrior, Region, SideLines, StartPrior};
use visloc_slam::{Descriptor, SlamConfig};
use visloc_world::Map;

use crate::args::{SlamParametersArgs, StartArg, TopicArgs};

/// A start may be so far outside of the map, meters.
const FAR_M: f64 = 2.0;
/// What stands before the keys of image analysis, observation model and lift detector in `--set`.
pub const OF_PIPELINE: &str = "pipeline.";

/// Text of a file.
///
/// # Errors
/// If it cannot be read; the error names it.
pub fn read_text(path: &Path) -> Result<String> {
    files::read_text(path).with_context(|| format!("{}: cannot read it", path.display()))
}

/// Parameters of everything but the algorithm: a file, and the options of `--set` that are meant for it.
///
/// # Errors
/// If the file cannot be read or has a mistake; the error names file and line.
pub fn pipeline_config(path: Option<&Path>, set: &[String]) -> Result<PipelineConfig> {
    let mut config = path.map_or_else(|| Ok(PipelineConfig::default()), from_toml)?;
    for option in set {
        let Some(option) = option.trim_start().strip_prefix(OF_PIPELINE) else { continue };
        let (key, value) = setting(option)?;
        config = overlay(&config, &format!("{key} = {value}"))
            .with_context(|| format!("--set {OF_PIPELINE}{option}"))?;
    }
    Ok(config)
}

/// Parameters of the refinement that count where many places look alike.
const OF_BUILDINGS: [&str; 7] = [
    "evidence_per_image",
    "evidence_deadband",
    "max_evidence_difference",
    "max_bend_evidence",
    "evidence_kept",
    "stale_evidence_kept",
    "blurring_turn_rad_per_s",
];
/// Parameters of the analysis of a field that count for features.
const OF_FEATURES: [&str; 2] = ["analysis.max_line_borders", "analysis.max_goal_borders"];

/// Refuses options of the pipeline that change nothing in this map and with these features.
///
/// # Errors
/// The first of them, and why.
pub fn refuse_without_effect(set: &[String], map: &Map, features: FeatureChoice) -> Result<()> {
    for option in set {
        let Some(key) = option.trim_start().strip_prefix(OF_PIPELINE) else { continue };
        let key = key.split('=').next().unwrap_or_default().trim();
        let is_of = |part: &str| key.starts_with(&format!("{part}."));
        let is_of_field = ["analysis", "observation", "refinement"].into_iter().any(is_of);
        let reason = match map {
            Map::Field(_) if is_of("office") => "it is for buildings, and the map is a field",
            Map::Office(_) if is_of_field => {
                "it is for fields, and the map is a building; its keys begin with office"
            }
            Map::Field(_)
                if key.strip_prefix("refinement.").is_some_and(|key| OF_BUILDINGS.contains(&key)) =>
            {
                "it weighs places that look alike, which a field has only in pairs"
            }
            _ if features == FeatureChoice::Pixels && OF_FEATURES.contains(&key) => {
                "pixels are weighed alone with --features pixels"
            }
            _ if features == FeatureChoice::Pixels && (is_of("refinement") || is_of("office.refinement")) => {
                "nothing is refined with --features pixels"
            }
            _ => continue,
        };
        bail!("--set {option}: it would change nothing: {reason}");
    }
    Ok(())
}

/// Names of topics that were asked for.
///
/// # Errors
/// If the file cannot be read or has a mistake; the error names file and line.
pub fn topic_options(args: &TopicArgs) -> Result<TopicOptions> {
    Ok(TopicOptions {
        all: args.topics.as_deref().map(from_toml::<BagTopics>).transpose()?,
        image: args.image_topic.first().cloned(),
        more_images: args.image_topic.iter().skip(1).cloned().collect(),
        camera_info: args.camera_info_topic.clone(),
        odometry: args.odometry_topic.clone(),
        ground_truth: args.truth_topic.clone(),
        base_frame: args.base_frame.clone(),
        camera_frame: args.camera_frame.clone(),
    })
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
    with_set(config, &args.set)
}

/// Parameters of SLAM with single options over them.
///
/// # Errors
/// If one is unknown or out of range; the error names the option.
pub fn with_set(mut config: SlamConfig, set: &[String]) -> Result<SlamConfig> {
    for option in set {
        let (key, value) = setting(option)?;
        config = config.with_toml(&format!("{key} = {value}")).with_context(|| format!("--set {option}"))?;
    }
    for option in set {
        let key = option.split('=').next().unwrap_or_default().trim();
        let idle = OF_SLAM_PARTS.iter().find(|(is_off, keys, _)| is_off(&config) && keys.contains(&key));
        if let Some((_, _, reason)) = idle {
            bail!("--set {option}: it would change nothing: {reason}");
        }
    }
    Ok(config)
}

/// Whether a part of SLAM is off.
type IsOff = fn(&SlamConfig) -> bool;

/// Parts of SLAM that can be off, the parameters that count for them alone, and what is off then.
const OF_SLAM_PARTS: [(IsOff, &[&str], &str); 3] = [
    (
        |config| config.features.descriptor == Descriptor::Patches,
        &["features.max_orb_distance", "features.orb_margin_px"],
        "landmarks are recognized by patches; add --set features.descriptor=orb, or --preset orb-sdvl",
    ),
    (
        |config| !config.tracking.reject_outliers,
        &["tracking.max_hypotheses"],
        "outliers are not rejected with tracking.reject_outliers = false",
    ),
    (
        |config| !config.mapping.adjust_bundles,
        &[
            "mapping.adjust_lens",
            "mapping.bundle_keyframes",
            "mapping.bundle_first_iterations",
            "mapping.bundle_last_iterations",
        ],
        "bundles are not adjusted with mapping.adjust_bundles = false",
    ),
];

/// Parameters of an algorithm as TOML: those of a file, and single options over them; nothing if there are none.
///
/// # Errors
/// If the file cannot be read, or one of both is no TOML.
pub fn algorithm_toml(config: Option<&Path>, set: &[String]) -> Result<Option<String>> {
    let text = config.map(read_text).transpose()?;
    let options = set.iter().filter(|option| !option.trim_start().starts_with(OF_PIPELINE));
    let options = options.map(|option| setting(option)).collect::<Result<Vec<_>>>()?;
    if options.is_empty() {
        return Ok(text);
    }
    let mut overrides = Overrides::from_toml(text.as_deref().unwrap_or_default())
        .with_context(|| config.map(|path| path.display().to_string()).unwrap_or_default())?;
    for (key, value) in options {
        overrides = overrides.with(&key, &serde_json::to_value(value)?);
    }
    Ok(Some(overrides.toml()?))
}

/// A single option as a key and its value.
fn setting(option: &str) -> Result<(String, toml::Value)> {
    let (key, value) = option
        .split_once('=')
        .ok_or_else(|| anyhow!("--set {option}: expected KEY=VALUE, such as tracking.max_matches=300"))?;
    let value = value.trim();
    let table = toml::from_str::<toml::Table>(&format!("value = {value}"));
    let typed = table.ok().and_then(|mut table| table.remove("value"));
    // A whole number that TOML has no room for is a number all the same.
    let typed = typed.or_else(|| value.parse::<f64>().ok().map(toml::Value::Float));
    // A word that is no value of TOML is meant as a text.
    Ok((key.trim().to_owned(), typed.unwrap_or_else(|| value.into())))
}

/// Settings of a file, laid over the usual ones.
///
/// # Errors
/// If the file cannot be read or has a mistake; the error names file and line.
pub fn from_toml<T: Settings + Default>(path: &Path) -> Result<T> {
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
    starts.iter().try_for_each(|start| refuse_far_from(start, map))?;
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

/// A start so far from the map that nothing of it can be seen is a mistake.
fn refuse_far_from(start: &StartArg, map: &Map) -> Result<()> {
    let StartArg::Pose { world_from_robot, .. } = start else { return Ok(()) };
    let (low, high) = match map {
        Map::Field(field) => {
            let (x, y) = field.half_carpet_m();
            ((-x, -y), (x, y))
        }
        Map::Office(office) => {
            let [low, high] = office.free_space().bounds_m();
            ((low.x, low.y), (high.x, high.y))
        }
        _ => return Ok(()),
    };
    let (x_m, y_m) = (world_from_robot.x_m, world_from_robot.y_m);
    let is_near = |value: f64, low: f64, high: f64| (low - FAR_M..=high + FAR_M).contains(&value);
    if is_near(x_m, low.0, high.0) && is_near(y_m, low.1, high.1) {
        return Ok(());
    }
    bail!(
        "--start pose:{x_m},{y_m}: expected a place on the map {}, x from {:.1} to {:.1} m and y from {:.1} to {:.1} m",
        map.name(),
        low.0,
        high.0,
        low.1,
        high.1
    )
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
