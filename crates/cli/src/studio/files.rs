//! Files that somebody drops on the studio's page: recordings, sources, and maps and calibrations for them.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use visloc_io::{
    camera_file::read_calibration,
    sources::{Host, Purpose, SourceOptions},
};
use visloc_studio::{FileOpener, GivenFile, NamedSource, StudioError, recording::RecordingIndex};
use visloc_world::Map;

use super::command::named_source;
use crate::{
    say::one_line,
    slam::{is_map_of_slam, load_map},
};

/// Endings of maps and calibrations.
const TEXTS: [&str; 7] = ["toml", "yaml", "yml", "svg", "dxf", "json", "vmap"];

/// What was dropped last.
struct Given {
    map: Option<String>,
    camera: Option<PathBuf>,
    source: Option<String>,
}

/// Opens what is dropped: a recording is replayed, a source is followed, on the map if there is one. A map or a calibration counts for
/// the source that was dropped before, and for those that come; a map without a source is a place to play in.
pub(super) fn file_opener(map: Option<&str>, options: SourceOptions, host: &Host) -> FileOpener {
    let given =
        Mutex::new(Given { map: map.map(str::to_owned), camera: options.camera.clone(), source: None });
    let host = host.clone();
    Arc::new(move |path| {
        if RecordingIndex::open(path).is_ok() {
            return Ok(GivenFile::Recording(path.to_path_buf()));
        }
        let mut given = given.lock().unwrap_or_else(PoisonError::into_inner);
        let name = path.display().to_string();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if TEXTS.contains(&ending) {
            if given.learn(path, &name)? && given.source.is_none() {
                return Ok(GivenFile::Place(path.to_path_buf()));
            }
        } else {
            given.source = Some(name);
        }
        let options = SourceOptions { camera: given.camera.clone(), ..options.clone() };
        given.open(&options, &host).map(GivenFile::Source)
    })
}

impl Given {
    /// Takes in a map or a calibration; whether it is a map that a robot can play on.
    fn learn(&mut self, path: &Path, name: &str) -> Result<bool, StudioError> {
        if is_map_of_slam(name) {
            load_map(path).map_err(|error| StudioError::input(name, format!("{error:#}")))?;
            self.map = Some(name.to_owned());
            return Ok(false);
        }
        let no_map = match Map::load(name) {
            Ok(_) => {
                self.map = Some(name.to_owned());
                return Ok(true);
            }
            Err(error) => error,
        };
        match read_calibration(path) {
            Ok(_) => self.camera = Some(path.to_path_buf()),
            Err(no_camera) => {
                let reason = format!("no map ({no_map}) and no calibration ({no_camera})");
                return Err(StudioError::input(name, reason));
            }
        }
        Ok(false)
    }

    fn open(&self, options: &SourceOptions, host: &Host) -> Result<NamedSource, StudioError> {
        let Some(name) = &self.source else {
            return Err(StudioError::input("taken", "now drop the recording, bag or video that it is for"));
        };
        let purpose = if self.map.is_some() { Purpose::Frames } else { Purpose::Images };
        let source = named_source(name, purpose, self.map.as_deref(), options, host);
        source.map_err(|error| StudioError::input(name, one_line(&error)))
    }
}
