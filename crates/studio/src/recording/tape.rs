//! Recordings that people at a page start and stop.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::{Input, Recorder, RecordingError};
use crate::{Message, Update, new_file};

/// Writes recordings into one folder. Their names come from here: a page can only start and stop.
pub struct Tape {
    folder: PathBuf,
    running: Option<Running>,
}

/// A recording at work.
struct Running {
    recorder: Recorder,
    first_secs: Option<f64>,
    last: Option<u64>,
}

impl Tape {
    /// Into a folder, which is made when it is needed.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf(), running: None }
    }

    /// Begins a recording whose name tells the scene and a number.
    ///
    /// # Errors
    /// If no file can be made.
    pub fn start(&mut self, scene: &str) -> Result<(), RecordingError> {
        if self.running.is_some() {
            return Ok(());
        }
        let recorder = Recorder::create(&self.new_path(scene)?)?;
        self.running = Some(Running { recorder, first_secs: None, last: None });
        Ok(())
    }

    fn new_path(&self, scene: &str) -> Result<PathBuf, RecordingError> {
        let word: String = scene.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        new_file(&self.folder, &word, "mcap").map_err(|error| RecordingError::Folder {
            folder: self.folder.clone(),
            reason: error.to_string(),
        })
    }

    /// Takes in what is shown. A moment is recorded once, however often it is shown. When time goes back, the recording ends;
    /// then and after an error its file is the answer.
    ///
    /// # Errors
    /// If the disk is full or the like; the recording has ended then.
    pub fn offer(
        &mut self,
        update: &Update,
        input: Option<&Input<'_>>,
    ) -> Result<Option<PathBuf>, RecordingError> {
        let Some(running) = &mut self.running else { return Ok(None) };
        let Ok(state) = Message::read(&update.state) else { return Ok(None) };
        let number = state.header.get("number").and_then(Value::as_u64).unwrap_or(0);
        let secs = state.header.get("secs").and_then(Value::as_f64).unwrap_or(0.0);
        match running.last {
            Some(last) if number == last => return Ok(None),
            Some(last) if number < last => return self.stop(),
            _ => running.last = Some(number),
        }
        let first_secs = *running.first_secs.get_or_insert(secs);
        let added = running.recorder.add(update, secs - first_secs, input);
        if added.is_err() {
            self.running = None;
        }
        added.map(|()| None)
    }

    /// Ends the recording; its file, if there was one with a frame.
    ///
    /// # Errors
    /// If the file cannot be completed.
    pub fn stop(&mut self) -> Result<Option<PathBuf>, RecordingError> {
        let Some(Running { recorder, .. }) = self.running.take() else { return Ok(None) };
        let path = (recorder.num_updates() > 0).then(|| recorder.path().to_path_buf());
        if path.is_none() {
            // The name was reserved with an empty file.
            let _ = std::fs::remove_file(recorder.path());
        }
        recorder.finish()?;
        Ok(path)
    }

    /// For the page: file and number of frames; `None` while nothing is recorded.
    pub fn status(&self) -> Option<Value> {
        let Running { recorder, .. } = self.running.as_ref()?;
        let file = recorder.path().display().to_string();
        Some(json!({ "is_on": true, "file": file, "num_frames": recorder.num_updates() }))
    }
}
