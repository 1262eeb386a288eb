//! `--params-file`: options and parameters in ROS's form, taken as if they had been typed before the other words.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

use anyhow::{Result, anyhow, bail};
use clap::{Arg, ArgAction, ArgMatches, Command, parser::ValueSource};
use toml::Value;
use visloc_core::settings::nearest_key;
use visloc_io::read_ros_parameters;

use crate::{args::InputPath, settings::read_text};

/// Name of the option, as clap knows it.
const PARAMS_FILE: &str = "params_file";
/// The node whose parameters are taken.
const NODE: &str = "visloc";
/// What `--set` changes, by the option whose file it would stand in, and what stands before the key there.
const TABLES: [(&str, &str); 2] = [("config", ""), ("pipeline", "pipeline.")];

/// The words of the command line, with those of a file of parameters behind the name of the command, and the file; what was typed wins.
pub fn with_params_file(command: &Command, words: Vec<OsString>) -> Result<(Vec<OsString>, Option<PathBuf>)> {
    let Ok(matches) = command.clone().ignore_errors(true).try_get_matches_from(&words) else {
        return Ok((words, None));
    };
    let Some((name, matches)) = matches.subcommand() else { return Ok((words, None)) };
    let path = matches.try_get_one::<InputPath>(PARAMS_FILE).ok().flatten();
    let (Some(path), Some(below)) = (path, command.find_subcommand(name)) else { return Ok((words, None)) };
    let path: PathBuf = path.to_path_buf();
    let place = || path.display().to_string();
    let parameters =
        read_ros_parameters(&read_text(&path)?, NODE).map_err(|reason| anyhow!("{}: {reason}", place()))?;
    let mut given = Vec::new();
    for (key, value) in &parameters {
        given.extend(words_of(below, matches, key, value).map_err(|error| anyhow!("{}: {error}", place()))?);
    }
    let (before, behind) = words.split_at(words.len().min(2));
    let all = before.iter().cloned().chain(given).chain(behind.iter().cloned()).collect();
    Ok((all, Some(path)))
}

/// What is wrong with the words that a file has added.
pub fn at_fault(path: &Path, error: &clap::Error) -> anyhow::Error {
    let text = error.to_string();
    let paragraph: Vec<&str> = text
        .trim_start_matches("error: ")
        .lines()
        .map(str::trim)
        .take_while(|line| !line.is_empty())
        .collect();
    anyhow!("{}: {}", path.display(), paragraph.join(" "))
}

/// What would be typed for a parameter; nothing if something else was typed for it.
fn words_of(command: &Command, typed: &ArgMatches, key: &str, value: &Value) -> Result<Vec<OsString>> {
    if let Some((table, name)) = key.split_once('.') {
        let (_, prefix) = TABLES
            .iter()
            .find(|(option, _)| *option == table && find(command, option).is_some())
            .ok_or_else(|| unknown(command, key, table))?;
        return Ok(vec![format!("--set={prefix}{name}={value}").into()]);
    }
    let arg = find(command, key).ok_or_else(|| unknown(command, key, key))?;
    if typed.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine) {
        return Ok(Vec::new());
    }
    let is_flag = matches!(arg.get_action(), ArgAction::SetTrue);
    match (value, arg.get_long()) {
        (Value::Boolean(is_set), Some(long)) if is_flag => {
            Ok(is_set.then(|| format!("--{long}").into()).into_iter().collect())
        }
        (_, Some(_)) if is_flag => bail!("{key}: expected true or false, found {value}"),
        (Value::Array(values), Some(long)) => {
            Ok(values.iter().map(|value| format!("--{long}={}", plain(value)).into()).collect())
        }
        (value, Some(long)) => Ok(vec![format!("--{long}={}", plain(value)).into()]),
        (value, None) => Ok(vec![plain(value).into()]),
    }
}

/// The argument of a name: an option with `_` for `-`, or a value such as `source`.
fn find<'a>(command: &'a Command, key: &str) -> Option<&'a Arg> {
    command.get_arguments().find(|arg| name_of(arg) == key && !is_excluded(arg))
}

fn name_of(arg: &Arg) -> String {
    arg.get_long().map_or_else(|| arg.get_id().to_string(), |long| long.replace('-', "_"))
}

/// What makes no sense in a file of parameters.
fn is_excluded(arg: &Arg) -> bool {
    let is_about_words =
        matches!(arg.get_action(), ArgAction::Help | ArgAction::HelpLong | ArgAction::HelpShort);
    is_about_words || [PARAMS_FILE, "set"].contains(&arg.get_id().as_str())
}

fn unknown(command: &Command, key: &str, name: &str) -> anyhow::Error {
    let known: Vec<String> = command.get_arguments().filter(|arg| !is_excluded(arg)).map(name_of).collect();
    let words: Vec<&str> = known.iter().map(String::as_str).collect();
    let hint = match nearest_key(name, &words) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => format!("known: {}, and config.KEY for parameters", known.join(", ")),
    };
    anyhow!("unknown parameter `{key}`, {hint}")
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::args::Cli;

    /// The words that a file adds to a command line.
    fn added(file: &str, words: &[&str]) -> Result<Vec<String>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.yaml");
        std::fs::write(&path, format!("/**:\n  ros__parameters: {{ {file} }}\n")).unwrap();
        let mut command = Cli::command();
        command.build();
        let mut all: Vec<OsString> = words.iter().map(OsString::from).collect();
        all.extend(["--params-file".into(), path.into_os_string()]);
        let (with, _) = with_params_file(&command, all.clone()).map_err(|error| format!("{error:#}"))?;
        let num = with.len() - all.len();
        assert_eq!((&with[..2], &with[2 + num..]), (&all[..2], &all[2..]), "what was typed stays");
        Ok(with[2..2 + num].iter().map(|word| word.to_string_lossy().into_owned()).collect())
    }

    #[test]
    fn parameters_become_words_and_what_was_typed_wins() {
        let file = "source: 'ros2:/eye', map: a.toml, seed: 7, publish_ros: true, overwrite: false, camera_height: 0.5, \
                    start: [half:negative, half:positive], config.evidence.per_image: 0.5, config: {explorers: {kind: grid}}, \
                    pipeline.analysis.column_step_px: 4";
        let words = added(file, &["visloc", "localize"]).unwrap();
        let expected = [
            "--camera-height=0.5",
            "--set=evidence.per_image=0.5",
            "--set=explorers.kind=\"grid\"",
            "--map=a.toml",
            "--set=pipeline.analysis.column_step_px=4",
            "--publish-ros",
            "--seed=7",
            "ros2:/eye",
            "--start=half:negative",
            "--start=half:positive",
        ];
        assert_eq!(words, expected);
        let words = added("source: a.mcap, seed: 7, fps: 15", &["visloc", "slam", "b.mcap", "--seed", "3"]);
        assert_eq!(words.unwrap(), ["--fps=15"]);
    }

    #[test]
    fn mistakes_name_the_nearest_parameter() {
        let why = |file: &str| added(file, &["visloc", "localize"]).unwrap_err();
        assert!(
            why("imagetopic: /eye").ends_with("unknown parameter `imagetopic`, did you mean `image_topic`?")
        );
        assert!(why("konfig.evidence.per_image: 1").ends_with("did you mean `config`?"));
        assert!(why("publish_ros: 3").ends_with("publish_ros: expected true or false, found 3"));
        assert!(why("params_file: a.yaml").contains("unknown parameter `params_file`"));
    }
}
