//! What pages can choose to see.

use std::path::PathBuf;

use serde_json::{Value, json};
use visloc_sim::TOURS;

use crate::{
    Clock, Engine, Session, StudioError,
    playground::{PLACES, Playground},
    recording::Replay,
    slam::{SequenceSource, SlamSession},
};

/// Before the number of a recording.
const RECORDING: &str = "recording-";

/// Before the name of a simulated tour.
const TOUR: &str = "sim:";
/// Before the number of a dataset.
const SEQUENCE: &str = "sequence-";

/// Opens playgrounds, cameras without a map, and recordings.
#[derive(Debug, Clone)]
pub struct Scenes {
    clock: Clock,
    slam_clock: visloc_slam::Clock,
    seed: u64,
    recordings: Vec<PathBuf>,
    folder: PathBuf,
    sequences: Vec<PathBuf>,
}

impl Scenes {
    /// Everything that needs no files. `seed` is that of everything random; `slam_clock` measures the stages of SLAM.
    #[must_use]
    pub fn new(clock: Clock, slam_clock: visloc_slam::Clock, seed: u64) -> Self {
        Self {
            clock,
            slam_clock,
            seed,
            recordings: Vec::new(),
            folder: std::env::temp_dir(),
            sequences: Vec::new(),
        }
    }

    /// Recordings, too.
    #[must_use]
    pub fn with_recordings(self, recordings: Vec<PathBuf>) -> Self {
        Self { recordings, ..self }
    }

    /// Where recordings are kept, and results of computing them again meanwhile.
    #[must_use]
    pub fn with_folder(self, folder: PathBuf) -> Self {
        Self { folder, ..self }
    }

    /// Folders of datasets, too.
    #[must_use]
    pub fn with_sequences(self, sequences: Vec<PathBuf>) -> Self {
        Self { sequences, ..self }
    }

    /// The id of what is shown first: the first recording or dataset, if there is one.
    #[must_use]
    pub fn first(&self) -> String {
        match (self.recordings.is_empty(), self.sequences.is_empty()) {
            (false, _) => format!("{RECORDING}0"),
            (true, false) => format!("{SEQUENCE}0"),
            (true, true) => PLACES[0].id.to_owned(),
        }
    }

    /// All of them for the page: id, group and label.
    fn list(&self) -> Value {
        let scene = |id: &str, group: &str, label: &str| json!({ "id": id, "group": group, "label": label });
        let places = PLACES.iter().map(|place| scene(place.id, "Playground", place.label));
        let tours =
            TOURS.iter().map(|(name, ..)| scene(&format!("{TOUR}{name}"), "SLAM", &format!("SLAM: {name}")));
        let files = |paths: &[PathBuf], prefix: &str, group: &str| -> Vec<Value> {
            let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
            let entry = |(i, path)| scene(&format!("{prefix}{i}"), group, &name(path).unwrap_or_default());
            paths.iter().enumerate().map(entry).collect()
        };
        let recordings = files(&self.recordings, RECORDING, "Recordings");
        let sequences = files(&self.sequences, SEQUENCE, "SLAM");
        recordings.into_iter().chain(places).chain(tours).chain(sequences).collect()
    }

    fn slam(&self, scene: &str, from: SequenceSource) -> Result<Box<dyn Session>, StudioError> {
        let more = json!({ "scene": scene, "scenes": self.list() });
        Ok(Box::new(SlamSession::open(from, more, self.slam_clock, self.seed)?))
    }
}

/// The file that an id names.
fn file<'a>(scene: &str, prefix: &str, files: &'a [PathBuf]) -> Option<&'a PathBuf> {
    files.get(scene.strip_prefix(prefix)?.parse::<usize>().ok()?)
}

impl Engine for Scenes {
    fn open(&mut self, scene: &str) -> Result<Box<dyn Session>, StudioError> {
        if let Some(path) = file(scene, RECORDING, &self.recordings) {
            let replay = Replay::open(path, scene, self.list())?;
            return Ok(Box::new(replay.with_scratch(&self.folder, self.clock.clone())));
        }
        if let Some(path) = file(scene, SEQUENCE, &self.sequences) {
            return self.slam(scene, SequenceSource::Folder(path.clone()));
        }
        if let Some(name) = scene.strip_prefix(TOUR) {
            return self.slam(scene, SequenceSource::Tour(name.to_owned()));
        }
        Ok(Box::new(Playground::new(scene, self.seed, self.clock.clone(), self.list())?))
    }

    fn add_recording(&mut self, path: PathBuf) -> String {
        self.recordings.push(path);
        format!("{RECORDING}{}", self.recordings.len() - 1)
    }
}
