//! What the arguments of a command name.

use std::{
    any::Any,
    path::{Path, PathBuf},
};

use clap::{Arg, ArgMatches, Command};
use visloc_core::files;

use super::identity::{Identity, Kind};
use crate::args::{InputMap, InputName, InputPath, OutputFile, OutputFolder, OutputMap, OutputRecording};

/// Most bytes of a file of settings that is searched for names of other files.
const MAX_SETTINGS_BYTES: u64 = 1 << 16;
/// Most bytes of a list of images, or of a bag's parts.
const MAX_LIST_BYTES: u64 = 1 << 22;

/// All that a command reads and writes.
#[derive(Debug, Default)]
pub struct Claims {
    pub(super) inputs: Vec<Input>,
    pub(super) outputs: Vec<Output>,
    /// Whether recordings may be replaced; `None` if the command cannot be told so.
    pub(super) is_overwriting: Option<bool>,
}

/// Something that is read.
#[derive(Debug)]
pub(super) struct Input {
    /// The argument and its value, for people.
    pub text: String,
    pub identity: Identity,
    /// Whether it may become what is written of its kind.
    pub is_map: bool,
}

/// Something that is written.
#[derive(Debug)]
pub(super) struct Output {
    /// The argument and its value, for people.
    pub text: String,
    pub path: PathBuf,
    pub use_as: UseAs,
    /// The only ending that fits what is written.
    pub ending: Option<String>,
    pub identity: Identity,
    /// What an earlier run has left unfinished.
    pub part: Identity,
}

/// What is made of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum UseAs {
    File,
    Map,
    Folder,
    Recording,
}

impl Claims {
    /// What a command line names, by the types of its arguments.
    pub fn of(command: &Command, matches: &ArgMatches) -> Self {
        let (mut command, mut matches) = (command, matches);
        while let Some((name, below)) = matches.subcommand() {
            let Some(found) = command.find_subcommand(name) else { break };
            (command, matches) = (found, below);
        }
        let mut claims =
            Self { is_overwriting: values::<bool>(matches, "overwrite").next(), ..Self::default() };
        for arg in command.get_arguments() {
            let (id, name) = (arg.get_id().as_str(), name_of(arg));
            let num_before = claims.outputs.len();
            values::<InputPath>(matches, id)
                .for_each(|path| claims.add_input(&name, &path.to_string_lossy()));
            for path in values::<InputMap>(matches, id) {
                let text = format!("{name} {}", path.display());
                claims.inputs.push(Input { text, identity: Identity::of(&path), is_map: true });
            }
            values::<InputName>(matches, id).for_each(|text| claims.add_input(&name, &text));
            values::<OutputFile>(matches, id).for_each(|path| claims.add_output(&name, &path, UseAs::File));
            values::<OutputMap>(matches, id).for_each(|path| claims.add_output(&name, &path, UseAs::Map));
            values::<OutputFolder>(matches, id)
                .for_each(|path| claims.add_output(&name, &path, UseAs::Folder));
            values::<OutputRecording>(matches, id)
                .for_each(|path| claims.add_output(&name, &path, UseAs::Recording));
            claims.outputs[num_before..].iter_mut().for_each(|output| output.ending = ending_of(arg));
        }
        claims
    }

    /// One input, one recording and files beside it, for a command that chooses their names itself.
    pub fn of_recording<'a>(
        input: (&str, &str),
        output: (&str, &Path),
        beside: impl IntoIterator<Item = (&'a str, &'a Path)>,
        is_overwriting: bool,
    ) -> Self {
        let mut claims = Self { is_overwriting: Some(is_overwriting), ..Self::default() };
        claims.add_input(input.0, input.1);
        claims.add_output(output.0, output.1, UseAs::Recording);
        beside.into_iter().for_each(|(name, path)| claims.add_output(name, path, UseAs::File));
        claims
    }

    /// A path, or a kind of source and a path, and the files that are named in it.
    fn add_input(&mut self, argument: &str, value: &str) {
        let text = format!("{argument} {value}");
        let mut rest = value;
        // `loop:DIR`, `bag:FILE`: what stands behind the colon, unless the whole is a file.
        while let (false, Some((_, behind))) = (Path::new(rest).exists(), rest.split_once(':')) {
            rest = behind;
        }
        let path = Path::new(rest);
        let named =
            named_in(path).into_iter().map(|path| (format!("{}, named in {text}", path.display()), path));
        let all = std::iter::once((text.clone(), path.to_path_buf())).chain(named);
        let inputs = all.map(|(text, path)| Input { text, identity: Identity::of(&path), is_map: false });
        // What is not there, the name of a built-in map for instance, cannot be harmed.
        self.inputs.extend(inputs.filter(|input| input.identity.kind() != Kind::Missing));
    }

    fn add_output(&mut self, argument: &str, path: &Path, use_as: UseAs) {
        let text = format!("{argument} {}", path.display());
        self.outputs.push(Output {
            text,
            path: path.to_path_buf(),
            use_as,
            ending: None,
            identity: Identity::of(path),
            part: Identity::of(&files::part_path(path)),
        });
    }
}

/// The values of an argument, if it is of this type and there are any.
fn values<T: Any + Clone + Send + Sync>(matches: &ArgMatches, id: &str) -> impl Iterator<Item = T> {
    matches.try_get_many::<T>(id).ok().flatten().into_iter().flatten().cloned()
}

/// `--out`, or `SOURCE`.
fn name_of(arg: &Arg) -> String {
    let value_name = || arg.get_value_names().and_then(|names| names.first()).map(ToString::to_string);
    let long = arg.get_long().map(|long| format!("--{long}"));
    long.or_else(value_name).unwrap_or_else(|| arg.get_id().to_string())
}

/// What stands behind the dot in `FILE.svg`, the name of a value that can have this form only.
fn ending_of(arg: &Arg) -> Option<String> {
    let (_, ending) = arg.get_value_names()?.first()?.split_once('.')?;
    Some(ending.to_owned())
}

/// Files that a file of settings names, relative to itself or to the working folder: the picture of a map, the map of a scenario. Of a folder
/// those that its lists name outside of it: images, parts of a bag.
fn named_in(path: &Path) -> Vec<PathBuf> {
    let has_ending = |path: &Path, endings: &[&str]| {
        path.extension().is_some_and(|ending| endings.iter().any(|known| ending == *known))
    };
    if has_ending(path, &["yaml", "yml", "toml"]) {
        let folders = [path.parent().unwrap_or(Path::new("")), Path::new("")];
        let is_name = |word: &str| word.contains('.') && word.parse::<f64>().is_err();
        return files_named(path, MAX_SETTINGS_BYTES, &folders, is_name);
    }
    let folder = Identity::of(path);
    let lists = folder.entries().filter(|list| has_ending(list, &["yaml", "yml", "txt", "csv"]));
    let leads_outside = |word: &str| word.starts_with('/') || word.contains("..");
    lists.flat_map(|list| files_named(&list, MAX_LIST_BYTES, &[folder.path()], leads_outside)).collect()
}

/// The files that words of a text name, relative to some folders.
fn files_named(
    text: &Path,
    max_bytes: u64,
    folders: &[&Path],
    is_name: impl Fn(&str) -> bool,
) -> Vec<PathBuf> {
    let Ok(text) = files::read(text, max_bytes) else { return Vec::new() };
    let text = String::from_utf8_lossy(&text).into_owned();
    let words = text.split(|c: char| c.is_whitespace() || "\"'=,[]{}".contains(c));
    let names = words.filter(|word| is_name(word));
    let candidates = names.flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    candidates.filter(|path| Identity::of(path).kind() == Kind::File).collect()
}
