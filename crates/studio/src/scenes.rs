//! What pages can choose to see.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::{Value, json};
use visloc_core::Clock;
use visloc_sim::{TEAM, TOURS};
use visloc_vmap::VisualMap;
use visloc_world::Map;

use crate::{
    Session, StudioError,
    playground::{PLACES, Playground},
    replay::Replay,
    server::{Remote, RemoteSession},
    slam::{ImagesOpener, Job, SequenceSource, SlamSession, TaughtMaps},
    source::{FramesOpener, SourceSession},
    team::TeamSession,
};

/// Before the number of a recording.
const RECORDING: &str = "recording-";
/// Before the name of a simulated tour, and of the simulated team.
const TOUR: &str = "sim:";
/// Before the number of a map to play on.
const MAP: &str = "map-";
/// Before the number of a source.
const SOURCE: &str = "source-";
/// Before the number of a map that was made at the page: to find the camera in it, and to go on in it.
const TAUGHT: &str = "taught-";
const TEACH: &str = "teach-";
/// The robot elsewhere.
const ROBOT: &str = "robot";

/// A source that the user has named.
#[derive(Clone)]
pub struct NamedSource {
    /// What the user wrote.
    pub name: String,
    /// Whether it goes on by itself.
    pub is_live: bool,
    /// How it is opened.
    pub opener: SourceOpener,
}

/// How a source is opened.
#[derive(Clone)]
pub enum SourceOpener {
    /// As frames of a robot on a map.
    Frames(FramesOpener),
    /// As images of a camera without a map.
    Images(ImagesOpener),
    /// As images of a camera in the map of an earlier session.
    InMap(ImagesOpener, Arc<VisualMap>),
}

/// What a file is that somebody at a page has handed over.
pub enum GivenFile {
    /// A recording of the studio.
    Recording(PathBuf),
    /// A source.
    Source(NamedSource),
    /// A map, without a source that it would be for: a place to play in.
    Place(PathBuf),
}

/// Says what a file is; what only tells how others are to be opened is kept, and refused with a sentence that says what is missing.
pub type FileOpener = Arc<dyn Fn(&Path) -> Result<GivenFile, StudioError> + Send + Sync>;

/// Opens playgrounds, the team, cameras without a map, sources, recordings, and a robot elsewhere.
#[derive(Clone)]
pub struct Scenes {
    clock: Clock,
    slam_clock: Clock,
    seed: u64,
    recordings: Vec<PathBuf>,
    maps: Vec<PathBuf>,
    taught: TaughtMaps,
    folder: PathBuf,
    sources: Vec<NamedSource>,
    robot: Option<Remote>,
    files: Option<FileOpener>,
    log: fn(&str),
}

impl Scenes {
    /// Everything that needs no files. `seed` is that of everything random; `slam_clock` measures the stages of SLAM.
    pub fn new(clock: Clock, slam_clock: Clock, seed: u64) -> Self {
        Self {
            clock,
            slam_clock,
            seed,
            recordings: Vec::new(),
            maps: Vec::new(),
            taught: TaughtMaps::default(),
            folder: std::env::temp_dir(),
            sources: Vec::new(),
            robot: None,
            files: None,
            log: |_| {},
        }
    }

    /// Recordings, too.
    #[must_use]
    pub fn with_recordings(self, recordings: Vec<PathBuf>) -> Self {
        Self { recordings, ..self }
    }

    /// Where recordings and maps are kept, and results of computing recordings again meanwhile.
    #[must_use]
    pub fn with_folder(self, folder: PathBuf) -> Self {
        Self { folder, ..self }
    }

    /// Sources, too.
    #[must_use]
    pub fn with_sources(self, sources: Vec<NamedSource>) -> Self {
        Self { sources, ..self }
    }

    /// A robot elsewhere, too; `log` gets what the person who runs the program should know.
    #[must_use]
    pub fn with_robot(self, robot: Remote, log: fn(&str)) -> Self {
        Self { robot: Some(robot), log, ..self }
    }

    /// Files that pages hand over, too.
    #[must_use]
    pub fn with_files(self, files: FileOpener) -> Self {
        Self { files: Some(files), ..self }
    }

    /// The id of what is shown first: what the user has named, if anything.
    pub fn first(&self) -> String {
        let files = [(SOURCE, self.sources.len()), (RECORDING, self.recordings.len())];
        if self.robot.is_some() {
            return ROBOT.to_owned();
        }
        let named = files.iter().find(|(_, count)| *count > 0);
        named.map_or_else(|| PLACES[0].id.to_owned(), |(prefix, _)| format!("{prefix}0"))
    }

    /// All of them for the page: id, group and label.
    fn list(&self) -> Value {
        let scene = |id: &str, group: &str, label: &str| json!({ "id": id, "group": group, "label": label });
        let robot = self.robot.iter().map(|robot| scene(ROBOT, "Robot", &robot.address));
        let source = |(i, source): (usize, &NamedSource)| {
            scene(&format!("{SOURCE}{i}"), "Sources", short(Path::new(&source.name)))
        };
        let sources = self.sources.iter().enumerate().map(source);
        let map = |(i, path): (usize, &PathBuf)| scene(&format!("{MAP}{i}"), "Playground", short(path));
        let maps = self.maps.iter().enumerate().map(map);
        let places = PLACES.iter().map(|place| scene(place.id, "Playground", place.label));
        let team = std::iter::once(scene(&format!("{TOUR}{TEAM}"), "Playground", "Team of robots"));
        let tours =
            TOURS.iter().map(|(name, ..)| scene(&format!("{TOUR}{name}"), "SLAM", &format!("SLAM: {name}")));
        let recording =
            |(i, path): (usize, &PathBuf)| scene(&format!("{RECORDING}{i}"), "Recordings", short(path));
        let recordings = self.recordings.iter().enumerate().map(recording);
        let of_taught = self.taught.all().into_iter().enumerate().flat_map(|(i, map)| {
            let name = short(&map.path);
            let find = scene(&format!("{TAUGHT}{i}"), "Taught maps", name);
            [find, scene(&format!("{TEACH}{i}"), "Taught maps", &format!("{name}, go on"))]
        });
        let taught: Vec<Value> = of_taught.collect();
        robot
            .chain(sources)
            .chain(taught)
            .chain(recordings)
            .chain(places)
            .chain(team)
            .chain(maps)
            .chain(tours)
            .collect()
    }

    fn slam(&self, scene: &str, from: SequenceSource, job: Job) -> Result<Box<dyn Session>, StudioError> {
        let does = if matches!(job, Job::Teach(_)) { "teach" } else { "find" };
        let more = json!({ "scene": scene, "scenes": self.list(), "does": does });
        let session = SlamSession::open(from, job, more, self.slam_clock.clone(), self.seed)?;
        Ok(Box::new(session.with_shelf(self.folder.clone(), self.taught.clone())))
    }

    fn source(&self, scene: &str, source: &NamedSource) -> Result<Box<dyn Session>, StudioError> {
        let NamedSource { name, is_live, opener } = source.clone();
        match opener {
            SourceOpener::Images(open) => {
                self.slam(scene, SequenceSource::Other(name, open, is_live), Job::Teach(None))
            }
            SourceOpener::InMap(open, map) => {
                // Somebody can take the camera of a simulated tour into their hands.
                let tour = name.strip_prefix(TOUR).filter(|tour| TOURS.iter().any(|(name, ..)| name == tour));
                let from = match tour {
                    Some(tour) => SequenceSource::Tour(tour.to_owned()),
                    None => SequenceSource::Other(name, open, is_live),
                };
                self.slam(scene, from, Job::Find(map))
            }
            SourceOpener::Frames(open) => {
                let more = json!({ "scene": scene, "scenes": self.list() });
                let clock = self.clock.clone();
                Ok(Box::new(SourceSession::open(&name, open, is_live, &more, clock, self.seed)?))
            }
        }
    }
}

/// The last part of a path.
fn short(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).unwrap_or_default()
}

/// What an id with a number names.
fn named<'a, T>(scene: &str, prefix: &str, all: &'a [T]) -> Option<&'a T> {
    all.get(scene.strip_prefix(prefix)?.parse::<usize>().ok()?)
}

impl Scenes {
    /// Opens a session by its id.
    ///
    /// # Errors
    /// If there is no such session or it cannot be opened.
    pub fn open(&mut self, scene: &str) -> Result<Box<dyn Session>, StudioError> {
        if let Some(robot) = self.robot.as_ref().filter(|_| scene == ROBOT) {
            let session =
                RemoteSession::open(robot.clone(), ROBOT, self.list(), self.clock.clone(), self.log)?;
            return Ok(Box::new(session));
        }
        if let Some(source) = named(scene, SOURCE, &self.sources) {
            return self.source(scene, source);
        }
        if let Some(path) = named(scene, RECORDING, &self.recordings) {
            let replay = Replay::open(path, scene, self.list())?;
            return Ok(Box::new(replay.with_scratch(
                &self.folder,
                self.clock.clone(),
                self.slam_clock.clone(),
            )));
        }
        if let Some(path) = named(scene, MAP, &self.maps) {
            let path = path.display().to_string();
            let playground = Playground::on_map(&path, scene, self.seed, self.clock.clone(), self.list())?;
            return Ok(Box::new(playground));
        }
        let taught = self.taught.all();
        if let Some(known) = named(scene, TAUGHT, &taught) {
            return self.slam(scene, known.from.clone(), Job::Find(known.map.clone()));
        }
        if let Some(known) = named(scene, TEACH, &taught) {
            return self.slam(scene, known.from.clone(), Job::Teach(Some(known.map.clone())));
        }
        if scene.strip_prefix(TOUR) == Some(TEAM) {
            return Ok(Box::new(TeamSession::new(self.seed, self.clock.clone(), self.list())?));
        }
        if let Some(name) = scene.strip_prefix(TOUR) {
            return self.slam(scene, SequenceSource::Tour(name.to_owned()), Job::Teach(None));
        }
        let list = self.list();
        if !PLACES.iter().any(|place| place.id == scene) {
            let ids = list.as_array().into_iter().flatten().filter_map(|entry| entry["id"].as_str());
            return Err(StudioError::command("scene", ids.collect::<Vec<_>>().join(", "), scene));
        }
        Ok(Box::new(Playground::new(scene, self.seed, self.clock.clone(), list)?))
    }

    /// Takes in a file that somebody at a page has handed over; the id by which it can be opened.
    ///
    /// # Errors
    /// If it is of no known kind, or says only how others are to be opened, as a map does.
    pub fn add_file(&mut self, path: &Path) -> Result<String, StudioError> {
        let open = self
            .files
            .as_ref()
            .ok_or_else(|| StudioError::input(path.display(), "nothing is opened here"))?;
        Ok(match open(path)? {
            GivenFile::Recording(path) => self.add_recording(path),
            GivenFile::Source(source) => {
                self.sources.push(source);
                format!("{SOURCE}{}", self.sources.len() - 1)
            }
            GivenFile::Place(path) => self.add_place(&path)?,
        })
    }

    /// Takes in a map to play on; the id by which it can be opened.
    ///
    /// # Errors
    /// If it is none.
    pub fn add_place(&mut self, path: &Path) -> Result<String, StudioError> {
        Map::load(&path.display().to_string())
            .map_err(|error| StudioError::input(path.display(), format!("no map to play on: {error}")))?;
        self.maps.push(path.to_path_buf());
        Ok(format!("{MAP}{}", self.maps.len() - 1))
    }

    /// Takes in a recording that has been made; the id by which it can be opened.
    pub fn add_recording(&mut self, path: PathBuf) -> String {
        self.recordings.push(path);
        format!("{RECORDING}{}", self.recordings.len() - 1)
    }
}
