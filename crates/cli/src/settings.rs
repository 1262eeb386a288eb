//! Settings from files and options.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use visloc_core::{
    files,
    geom::PlanarPose,
    settings::{Idle, Overrides, Settings, SettingsError, idle, idle_at, lay, overlay, parameters},
};
use visloc_io::{bag::BagTopics, sources::TopicOptions};
use visloc_locate::{
    ALGORITHMS, Algorithm, FeatureChoice, Half, PipelineConfig, PosePrior, Region, SideLines, StartPrior,
};
use visloc_slam::SlamConfig;
use visloc_world::Map;

use crate::args::{SlamParametersArgs, StartArg, TopicArgs};

/// A start may be so far outside of the map, meters.
const FAR_M: f64 = 2.0;
/// What stands before the keys of image analysis, observation model and lift detector in `--set`.
pub const OF_PIPELINE: &str = "pipeline.";

/// Text of a file.
pub fn read_text(path: &Path) -> Result<String> {
    files::read_text(path).with_context(|| format!("{}: cannot read it", path.display()))
}

/// Parameters in layers: what was given first, then a file, then single options. What counts for nothing is known when all are laid.
struct Layers<'a, T> {
    given: T,
    values: T,
    config: Option<&'a Path>,
}

impl<'a, T: Settings + Clone> Layers<'a, T> {
    /// Lays a file over what is given.
    fn new(given: T, config: Option<&'a Path>) -> Result<Self> {
        let values = match config {
            Some(path) => lay(&given, &read_text(path)?).map_err(|error| in_file(path, &error))?,
            None => given.clone(),
        };
        Ok(Self { given, values, config })
    }

    /// Lays single options over it, as `KEY=VALUE`. `before` stands before each in `--set`; `unused` says of a key why it is not used
    /// at all.
    fn with<'o>(
        mut self,
        options: impl Iterator<Item = &'o str> + Clone,
        before: &str,
        unused: impl Fn(&str) -> Option<&'static str>,
    ) -> Result<T> {
        for option in options.clone() {
            let (key, value) = setting(option)?;
            self.values = lay(&self.values, &format!("{key} = {value}"))
                .map_err(|error| anyhow!("--set {before}{option}: {}", error.reason))?;
        }
        let unused = |key: &str| unused(key).map(|reason| format!("it would change nothing: {reason}"));
        for option in options {
            let (key, value) = setting(option)?;
            for key in keys_of(&key, &value) {
                let idle = idle_at(&self.values, &key)?.map(|Idle { reason, .. }| reason);
                if let Some(reason) = idle.or_else(|| unused(&key)) {
                    bail!("--set {before}{option}: {reason}");
                }
            }
        }
        let Some(config) = self.config else { return Ok(self.values) };
        let changed = Overrides::between(&parameters(&self.given)?, parameters(&self.values)?);
        let unused = changed.paths().into_iter().find_map(|path| Some((path.to_owned(), unused(path)?)));
        let idle = idle(&self.given, &self.values)?.map(|Idle { path, reason }| (path, reason));
        match idle.or(unused) {
            Some((path, reason)) => bail!("{}: {path}: {reason}", config.display()),
            None => Ok(self.values),
        }
    }
}

/// What SLAM is used for, which decides on the parameters that count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlamJob {
    /// Making maps, and going on in them.
    Map,
    /// Finding the camera in a map and following it around it.
    Extend,
    /// Finding the camera in a map that stays as it is.
    Locate,
    /// Making a map of images with known poses.
    MapGivenPoses,
}

impl SlamJob {
    /// Why a parameter is not used.
    fn unused(self, key: &str) -> Option<&'static str> {
        let is_of =
            |parts: &[&str]| parts.iter().any(|part| key == *part || key.starts_with(&format!("{part}.")));
        let of_new_maps = ["start", "relocation.new_map_secs"];
        match self {
            Self::Extend if is_of(&of_new_maps) => Some("no new map is started"),
            Self::Locate if is_of(&of_new_maps) || is_of(&["mapping", "relocation.close_loops"]) => {
                Some("the map stays as it is")
            }
            Self::MapGivenPoses if !is_of(&["features", "mapping.max_new_candidates"]) => Some(
                "the poses are known; only features and mapping.max_new_candidates are used with --poses",
            ),
            _ => None,
        }
    }
}

/// Parameters of everything but the algorithm: a file, and the options of `--set` that are meant for it.
pub fn pipeline_config(path: Option<&Path>, set: &[String]) -> Result<PipelineConfig> {
    let options = set.iter().filter_map(|option| option.trim_start().strip_prefix(OF_PIPELINE));
    Layers::new(PipelineConfig::default(), path)?.with(options, OF_PIPELINE, |_| None)
}

/// What to say of parameters that were refused if they are those of the pipeline, given for the algorithm, or the other way round.
pub fn swapped(
    algorithm: &str,
    (config, pipeline): (Option<&Path>, Option<&Path>),
    set: &[String],
) -> Option<anyhow::Error> {
    let known = Algorithm::named(algorithm).ok()?;
    let is_of_algorithm = |text: &str| known.with_toml(text).is_ok();
    let is_of_pipeline = |text: &str| lay(&PipelineConfig::default(), text).is_ok();
    let only_algorithm = |text: &str| is_of_algorithm(text) && !is_of_pipeline(text);
    let only_pipeline = |text: &str| is_of_pipeline(text) && !is_of_algorithm(text);
    let of_algorithm = format!("of {algorithm}");
    let (of_pipeline, of_algorithm) = ("of the pipeline", of_algorithm.as_str());
    let option = set.iter().find_map(|option| {
        let (key, value) = setting(option).ok()?;
        let text = |key: &str| format!("{key} = {value}");
        let (expected, found, right) = match key.strip_prefix(OF_PIPELINE) {
            Some(key) if only_algorithm(&text(key)) => (of_pipeline, of_algorithm, key.to_owned()),
            None if only_pipeline(&text(&key)) => (of_algorithm, of_pipeline, format!("{OF_PIPELINE}{key}")),
            _ => return None,
        };
        Some(anyhow!(
            "--set {option}: expected a parameter {expected}, found one {found}: --set {right}={value}"
        ))
    });
    // What is no file can be read once only.
    let text = |path: Option<&Path>| path.filter(|path| path.is_file()).and_then(|path| read_text(path).ok());
    let in_file = |path: Option<&Path>, expected: &str, found: &str, right: &str| {
        let name = path.unwrap_or_else(|| Path::new("")).display();
        anyhow!("{name}: expected parameters {expected}, found those {found}: give it with {right}")
    };
    let in_config = || {
        let text = text(config)?;
        if only_pipeline(&text) {
            return Some(in_file(config, of_algorithm, of_pipeline, "--pipeline"));
        }
        let takes = |name: &str| Algorithm::named(name).is_ok_and(|other| other.with_toml(&text).is_ok());
        let other = ALGORITHMS.iter().map(|info| info.name).find(|name| takes(name))?;
        let is_other = !is_of_algorithm(&text);
        is_other
            .then(|| in_file(config, of_algorithm, &format!("of {other}"), &format!("--algorithm {other}")))
    };
    let in_pipeline = || {
        let is_swapped = only_algorithm(&text(pipeline)?);
        is_swapped.then(|| in_file(pipeline, of_pipeline, of_algorithm, "--config"))
    };
    option.or_else(in_config).or_else(in_pipeline)
}

/// Parameters of the analysis of a field that count for features.
const OF_FEATURES: [&str; 2] = ["analysis.max_line_borders", "analysis.max_goal_borders"];

/// Refuses options of the pipeline that change nothing in this map and with these features.
pub fn refuse_without_effect(set: &[String], map: &Map, features: FeatureChoice) -> Result<()> {
    for option in set {
        let Some(key) = option.trim_start().strip_prefix(OF_PIPELINE) else { continue };
        let key = key.split('=').next().unwrap_or_default().trim();
        let is_of = |part: &str| key == part || key.starts_with(&format!("{part}."));
        let is_of_field = ["analysis", "observation", "refinement"].into_iter().any(is_of);
        let reason = match map {
            Map::Field(_) if is_of("office") => "it is for buildings, and the map is a field",
            Map::Office(_) if is_of_field => {
                "it is for fields, and the map is a building; its keys begin with office"
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

/// Parameters of SLAM for a job: a preset, then the file, then single options.
pub fn slam_config(args: &SlamParametersArgs, job: SlamJob) -> Result<SlamConfig> {
    let preset = SlamConfig::preset(&args.preset).context("--preset")?;
    slam_config_over(preset, args.config.as_deref(), &args.set, job)
}

/// As [`slam_config`], over given parameters.
pub fn slam_config_over(
    given: SlamConfig,
    config: Option<&Path>,
    set: &[String],
    job: SlamJob,
) -> Result<SlamConfig> {
    let options = set.iter().map(String::as_str);
    let checked = Layers::new(given, config)?.with(options, "", |key| job.unused(key))?;
    let origins = config.map(|path| path.display().to_string()).into_iter();
    let origins = origins.chain(set.iter().map(|option| format!("--set {option}"))).collect::<Vec<_>>();
    checked.check().with_context(|| origins.join(", "))?;
    Ok(checked)
}

/// Parameters of an algorithm as TOML: those of a file, and single options over them; nothing if there are none.
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

/// The keys that an option sets: itself, or those below if its value is a table.
fn keys_of(key: &str, value: &toml::Value) -> Vec<String> {
    match value.as_table().filter(|table| !table.is_empty()) {
        Some(table) => {
            table.iter().flat_map(|(below, value)| keys_of(&format!("{key}.{below}"), value)).collect()
        }
        None => vec![key.to_owned()],
    }
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
pub fn from_toml<T: Settings + Default>(path: &Path) -> Result<T> {
    let text = read_text(path)?;
    overlay(&T::default(), &text).map_err(|error| in_file(path, &error))
}

fn in_file(path: &Path, error: &SettingsError) -> anyhow::Error {
    let line = error.line.map(|line| format!(", line {line}")).unwrap_or_default();
    anyhow!("{}{line}: {}", path.display(), error.reason)
}

/// What is known about the start, from the options given; nothing if there are none.
pub fn start_prior(starts: &[StartArg], map: &Map) -> Result<StartPrior> {
    for start in starts {
        if let StartArg::Pose { world_from_robot: PlanarPose { x_m, y_m, yaw_rad }, .. } = start {
            let heading_deg = yaw_rad.to_degrees();
            refuse_far_from(map, (*x_m, *y_m), &format!("--start pose:{x_m},{y_m},{heading_deg:.0}"))?;
        }
    }
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

/// A place so far from the map that nothing of it can be seen is a mistake. `typed` is what was typed before its numbers.
pub fn refuse_far_from(map: &Map, (x_m, y_m): (f64, f64), typed: &str) -> Result<()> {
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
    let is_near = |value: f64, low: f64, high: f64| (low - FAR_M..=high + FAR_M).contains(&value);
    if is_near(x_m, low.0, high.0) && is_near(y_m, low.1, high.1) {
        return Ok(());
    }
    bail!(
        "{typed}: expected a place on the map {}, x from {:.1} to {:.1} m and y from {:.1} to {:.1} m",
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
        _ => bail!(
            "--start: the building {:?} has no halves and side lines; give pose:X,Y,HEADING",
            map.name()
        ),
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
