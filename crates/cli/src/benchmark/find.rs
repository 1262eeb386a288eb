//! Recordings below folders, found by what they are.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use visloc_core::files;
use visloc_io::{
    camera_trajectory::read_camera_trajectory,
    sequence::{SequenceOptions, list_sequence, sequence_layouts},
    sources::{SourceAddress, SourceOptions, open_images},
};
use visloc_world::Map;

use super::{Claims, Kind};
use crate::{host::another, run::open_source, say::one_line};

/// Folders within folders that are searched.
const MAX_DEPTH: usize = 12;
/// Names of maps that lie beside a recording.
const MAPS: [&str; 4] = ["map.toml", "field.toml", "map.yaml", "field.yaml"];
/// Names of true camera poses that lie beside a recording.
const TRUTHS: [&str; 3] = ["groundtruth.txt", "groundtruth.tum", "groundtruth.csv"];
/// Names of calibrations that lie beside a video.
const CAMERAS: [&str; 2] = ["camera.toml", "camera.yaml"];
/// Files without use that are named in a line.
const MAX_NAMED: usize = 3;
/// Images of a recording among which there must be a pose of the truth.
const MAX_LOOKED_AT: usize = 300;

/// A recording with a truth.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Its name in tables; no two have the same.
    pub name: String,
    /// Recordings that belong together.
    pub class: String,
    /// What runs on it.
    pub kind: Kind,
    /// As a source is written.
    pub source: String,
    /// Bytes of its files; 0 of a simulation.
    pub num_bytes: u64,
    /// Options of the command that belong to it: the map, and what is known about the start.
    pub words: Vec<String>,
    /// True camera poses that no reader of the recording finds by itself.
    pub truth_beside: Option<PathBuf>,
}

impl Recording {
    /// Whether each seed makes another recording.
    pub fn is_simulated(&self) -> bool {
        self.source.starts_with("sim:")
    }
}

/// All recordings with a truth below some folders, and the simulator's; and lines about what looks like a recording and is none.
pub fn find(folders: &[&Path], claims: &Claims) -> Result<(Vec<Recording>, Vec<String>)> {
    let mut search = Search { claims, recordings: Vec::new(), unused: Vec::new(), visited: BTreeSet::new() };
    for folder in folders {
        if !folder.exists() {
            bail!("--data {}: expected a folder, found nothing there", folder.display());
        }
        search.look(folder, 0);
    }
    let Search { mut recordings, unused, .. } = search;
    for class in &claims.classes {
        let simulated = class.recordings.iter().filter(|name| name.starts_with("sim:"));
        recordings.extend(simulated.map(|source| Recording {
            name: source.clone(),
            class: class.name.clone(),
            kind: class.kind,
            source: source.clone(),
            num_bytes: 0,
            words: Vec::new(),
            truth_beside: None,
        }));
    }
    name_apart(&mut recordings);
    let place = |recording: &Recording| claims.classes.iter().position(|class| class.name == recording.class);
    recordings.sort_by_key(|recording| (place(recording).unwrap_or(usize::MAX), recording.name.clone()));
    Ok((recordings, unused_lines(&unused)))
}

/// Lines about paths and reasons; those with the same reason stand in one line.
fn unused_lines(unused: &[(String, String)]) -> Vec<String> {
    let mut groups: BTreeMap<&str, Vec<&(String, String)>> = BTreeMap::new();
    for one in unused {
        // What follows is about the single file.
        let end = ["; ", ". "].iter().filter_map(|mark| one.1.find(mark)).min();
        groups.entry(&one.1[..end.unwrap_or(one.1.len())]).or_default().push(one);
    }
    let line = |(cause, group): (&str, Vec<&(String, String)>)| match group.as_slice() {
        [(path, reason)] => format!("{path}: {reason}"),
        several => {
            let named: Vec<&str> = several.iter().take(MAX_NAMED).map(|(path, _)| path.as_str()).collect();
            let others = if several.len() > MAX_NAMED { ", ..." } else { "" };
            format!("{} files or folders: {cause}: {}{others}", several.len(), named.join(", "))
        }
    };
    groups.into_iter().map(line).collect()
}

/// Gives recordings of the same name that of their folder as well, and if that does not help their whole paths.
fn name_apart(recordings: &mut [Recording]) {
    let with_folder = |source: &str| {
        let folder = Path::new(source).parent().map(name_of).unwrap_or_default();
        format!("{folder}/{}", name_of(Path::new(source)))
    };
    for longer in [with_folder, str::to_owned] {
        let names: Vec<String> = recordings.iter().map(|recording| recording.name.clone()).collect();
        for recording in recordings.iter_mut() {
            if names.iter().filter(|name| **name == recording.name).count() > 1 {
                recording.name = longer(&recording.source);
            }
        }
    }
}

/// A walk through folders.
struct Search<'a> {
    claims: &'a Claims,
    recordings: Vec<Recording>,
    /// Paths and reasons.
    unused: Vec<(String, String)>,
    visited: BTreeSet<PathBuf>,
}

impl Search<'_> {
    fn look(&mut self, path: &Path, depth: usize) {
        let is_new = fs::canonicalize(path).is_ok_and(|path| self.visited.insert(path));
        if !is_new || depth > MAX_DEPTH {
            return;
        }
        if path.is_file() {
            // Bags and videos.
            if SourceAddress::parse(&path.to_string_lossy()).is_ok() {
                let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
                self.take(path, recording(path, &stem.unwrap_or_default(), self.claims));
            }
            return;
        }
        let name = name_of(path);
        if is_bag(path) && path.join("metadata.yaml").exists() {
            return self.take(path, recording(path, &name, self.claims));
        }
        let listing = list_sequence(path, &SequenceOptions::default()).ok();
        let found = listing.as_ref().map(|_| recording(path, &name, self.claims));
        // A picture that lies among recordings makes a folder look like a sequence.
        let is_plain = |layout| sequence_layouts().any(|(key, name)| key == "images" && name == layout);
        let may_have_others = listing.is_none_or(|listing| is_plain(listing.layout));
        match found {
            Some(found) if found.is_ok() || !may_have_others => self.take(path, found),
            found => {
                let num_before = self.recordings.len() + self.unused.len();
                self.look_inside(path, depth);
                let is_empty = self.recordings.len() + self.unused.len() == num_before;
                if let Some(found) = found.filter(|_| is_empty) {
                    self.take(path, found);
                }
            }
        }
    }

    fn look_inside(&mut self, path: &Path, depth: usize) {
        match fs::read_dir(path) {
            Ok(entries) => {
                let mut paths: Vec<PathBuf> =
                    entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
                paths.retain(|path| !name_of(path).starts_with('.'));
                paths.sort();
                paths.iter().for_each(|path| self.look(path, depth + 1));
            }
            Err(error) => self.take(path, Err(error).context("the folder cannot be read")),
        }
    }

    /// Takes in a recording, or the reason why it cannot be used.
    fn take(&mut self, path: &Path, found: Result<Recording>) {
        match found {
            Ok(recording) => self.recordings.push(recording),
            Err(error) => {
                // Many messages begin with the path already.
                let (path, reason) = (path.display().to_string(), one_line(&error));
                let reason = reason.strip_prefix(&format!("{path}: ")).unwrap_or(&reason).to_owned();
                self.unused.push((path, reason));
            }
        }
    }
}

fn is_bag(path: &Path) -> bool {
    SourceAddress::parse(&path.to_string_lossy()).is_ok_and(|address| address.has_robot())
}

fn name_of(path: &Path) -> String {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Opens a candidate and looks for its map and its truth.
fn recording(path: &Path, name: &str, claims: &Claims) -> Result<Recording> {
    let source = path.to_string_lossy().into_owned();
    let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
    let beside = |names: &[&str]| names.iter().map(|name| folder.join(name)).find(|path| path.is_file());
    let map = beside(&MAPS).filter(|_| is_bag(path));
    let kind = if map.is_some() { Kind::Map } else { Kind::Slam };
    let mut truth_beside = None;
    let words = if let Some(map) = &map {
        start_words(&source, Some(&map.to_string_lossy()), None)?
    } else {
        // A video does not say which camera took it.
        let camera = beside(&CAMERAS).filter(|_| path.is_file() && !is_bag(path));
        let options = SourceOptions { camera: camera.clone(), ..SourceOptions::default() };
        if open_images(&source, &options, &another())?.truth.is_none() {
            truth_beside = beside(&TRUTHS);
            let path = truth_beside.as_deref().context(
                "it has no truth to compare with: no camera poses in it or beside it, and no map for a robot",
            )?;
            read_camera_trajectory(path)?;
        }
        let words = camera.map(|camera| ["--camera".to_owned(), camera.to_string_lossy().into_owned()]);
        words.into_iter().flatten().collect()
    };
    // The folder of a rendered recording may have any name.
    let class = sequence_in(folder).and_then(|sequence| claims.class_of(kind, &sequence));
    let class = class.or_else(|| claims.class_of(kind, name)).unwrap_or(name).to_owned();
    let num_bytes = num_bytes(path, 0);
    Ok(Recording { name: name.to_owned(), class, kind, source, num_bytes, words, truth_beside })
}

/// The sequence that a rendered recording is one of, from its `meta.json`.
pub fn sequence_in(folder: &Path) -> Option<String> {
    let text = files::read_text(&folder.join("meta.json")).ok()?;
    let meta: serde_json::Value = serde_json::from_str(&text).ok()?;
    meta["sequence"].as_str().map(str::to_owned)
}

/// Options for map and start of a robot's recording; the seed is that of a simulation. Where each place has a mirror image, the
/// half of the start is given, as a robot in a game is told it.
pub fn start_words(source: &str, map: Option<&str>, seed: Option<u64>) -> Result<Vec<String>> {
    let mut words: Vec<String> = map.map(|map| vec!["--map".to_owned(), map.to_owned()]).unwrap_or_default();
    let mut options = SourceOptions { seed, ..SourceOptions::default() };
    options.usual.max_frames = seed.map(|_| 1);
    let mut open = open_source(source, map, &options)?;
    let is_mirrored = matches!(&open.map, Map::Field(field) if field.is_point_symmetric());
    for _ in 0..MAX_LOOKED_AT {
        let Some(next) = open.frames.next_item() else { break };
        let Some(truth) = next?.truth else { continue };
        let half = if truth.world_from_robot.x_m < 0.0 { "negative" } else { "positive" };
        words.extend(is_mirrored.then(|| format!("--start=half:{half}")));
        return Ok(words);
    }
    bail!("it has no truth to compare with: no pose of the robot among its first {MAX_LOOKED_AT} images")
}

/// Bytes of a file, or of all files below a folder.
fn num_bytes(path: &Path, depth: usize) -> u64 {
    let Ok(found) = fs::metadata(path) else { return 0 };
    if found.is_file() || depth > MAX_DEPTH {
        return found.len();
    }
    let entries = fs::read_dir(path).into_iter().flatten().filter_map(Result::ok);
    entries.map(|entry| num_bytes(&entry.path(), depth + 1)).sum()
}
