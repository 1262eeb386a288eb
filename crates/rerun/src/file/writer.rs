//! Writes a file of the Rerun viewer.

use std::{
    fs,
    path::{Path, PathBuf},
};

use re_sdk::{RecordingStream, RecordingStreamBuilder, RecordingStreamError};
use visloc_studio::Update;

use super::{archetypes, blueprint};
use crate::{Converter, Entry, Moment, RerunError};

/// The viewer keeps one layout for each application.
const APPLICATION: &str = "visloc";
/// Time line of the stamps: since the first frame.
pub(super) const TIME: &str = "time";
/// Time line of the numbers of frames.
pub(super) const FRAME: &str = "frame";

/// A file that grows while a run goes on.
pub struct RerunFile {
    path: PathBuf,
    stream: RecordingStream,
    converter: Converter,
    has_layout: bool,
}

impl RerunFile {
    /// Creates a file, and its folder.
    ///
    /// # Errors
    /// If that is not possible.
    pub fn create(path: &Path) -> Result<Self, RerunError> {
        let refused = |reason: String| RerunError::Write { path: path.to_path_buf(), reason };
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|error| refused(error.to_string()))?;
        }
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let stream = RecordingStreamBuilder::new(APPLICATION)
            .recording_id(name.clone())
            .recording_name(name)
            .save(path)
            .map_err(|error| refused(error.to_string()))?;
        // Stamps are the camera's; when they were written tells nothing.
        stream.set_log_time_enabled(false);
        stream.set_log_tick_enabled(false);
        Ok(Self { path: path.to_path_buf(), stream, converter: Converter::new(), has_layout: false })
    }

    /// Appends an update of a moment, seconds since the first frame.
    ///
    /// # Errors
    /// If it is not one of the studio's, or cannot be written.
    pub fn add(&mut self, update: &Update, secs: f64) -> Result<(), RerunError> {
        let (moment, entries) = self.converter.update(update, secs)?;
        self.log(moment, entries).map_err(|error| self.refused(&error.to_string()))?;
        if let Some(layout) = self.converter.layout().filter(|_| !self.has_layout) {
            blueprint::send(&self.stream, APPLICATION, layout)
                .map_err(|error| self.refused(&error.to_string()))?;
            self.has_layout = true;
        }
        Ok(())
    }

    fn log(
        &self,
        moment: Moment,
        entries: impl IntoIterator<Item = Entry>,
    ) -> Result<(), RecordingStreamError> {
        self.stream.set_duration_secs(TIME, moment.secs);
        self.stream.set_time_sequence(FRAME, moment.frame);
        entries.into_iter().try_for_each(|entry| archetypes::log(&self.stream, entry))
    }

    /// Writes what happened and ends the file.
    ///
    /// # Errors
    /// If the disk is full or the like.
    pub fn finish(self) -> Result<(), RerunError> {
        for (moment, entry) in self.converter.events() {
            self.log(moment, [entry]).map_err(|error| self.refused(&error.to_string()))?;
        }
        let flushed = self.stream.flush_blocking();
        flushed.map_err(|error| self.refused(&error.to_string()))?;
        self.stream.finalize_deferred_sinks();
        Ok(())
    }

    fn refused(&self, reason: &str) -> RerunError {
        RerunError::Write { path: self.path.clone(), reason: reason.to_owned() }
    }
}
