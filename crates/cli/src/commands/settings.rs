//! Settings from files and options.

use std::{fs, path::Path};

use anyhow::{Context, Result, anyhow};
use visloc_data::bag::BagTopics;
use visloc_locate::PipelineConfig;
use visloc_settings::{Settings, SettingsError, overlay};

use crate::args::TopicArgs;

/// Text of a file.
///
/// # Errors
/// If it cannot be read; the error names it.
pub fn read_text(path: &Path) -> Result<String> {
    fs::read_to_string(path).with_context(|| format!("{}: cannot read it", path.display()))
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

fn from_toml<T: Settings + Default>(path: &Path) -> Result<T> {
    let text = read_text(path)?;
    overlay(&T::default(), &text).map_err(|SettingsError { line, reason }| {
        let line = line.map(|line| format!(", line {line}")).unwrap_or_default();
        anyhow!("{}{line}: {reason}", path.display())
    })
}
