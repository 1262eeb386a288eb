//! Writes a recording.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::BufWriter,
    path::{Path, PathBuf},
    sync::Arc,
};

use mcap::{WriteOptions, Writer, records::MessageHeader};

use super::index::{IMAGE_TOPIC, RecordingError, SCENE_TOPIC, STATE_TOPIC};
use crate::Update;

/// What the messages are, for other tools.
const ENCODING: &str = "visloc-studio";

/// Writes updates to a file.
pub struct Recorder {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: [u16; 3],
    scene: Option<Arc<[u8]>>,
    num_updates: u32,
}

impl Recorder {
    /// Creates a file, and its folder.
    ///
    /// # Errors
    /// If that is not possible.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        let refused = |reason: String| RecordingError::Write { path: path.to_path_buf(), reason };
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|error| refused(error.to_string()))?;
        }
        let file = File::create(path).map_err(|error| refused(error.to_string()))?;
        let options = WriteOptions::new()
            .use_chunks(false)
            .compression(None)
            .profile("")
            .library(concat!("visloc ", env!("CARGO_PKG_VERSION")));
        let written = |error: mcap::McapError| refused(error.to_string());
        let mut writer = options.create(BufWriter::new(file)).map_err(written)?;
        let mut channels = [0; 3];
        for (channel, topic) in channels.iter_mut().zip([SCENE_TOPIC, IMAGE_TOPIC, STATE_TOPIC]) {
            *channel = writer.add_channel(0, topic, ENCODING, &BTreeMap::new()).map_err(written)?;
        }
        Ok(Self { path: path.to_path_buf(), writer, channels, scene: None, num_updates: 0 })
    }

    /// Appends an update of a moment, seconds since the first frame.
    ///
    /// # Errors
    /// If the disk is full or the like.
    pub fn add(&mut self, update: &Update, secs: f64) -> Result<(), RecordingError> {
        let [scene, image, state] = self.channels;
        if !self.scene.as_ref().is_some_and(|known| Arc::ptr_eq(known, &update.scene)) {
            self.write(scene, &update.scene, secs)?;
            self.scene = Some(Arc::clone(&update.scene));
        }
        if let Some(bytes) = &update.image {
            self.write(image, bytes, secs)?;
        }
        self.write(state, &update.state, secs)?;
        self.num_updates += 1;
        Ok(())
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn write(&mut self, channel_id: u16, bytes: &[u8], secs: f64) -> Result<(), RecordingError> {
        let log_time = (secs.max(0.0) * 1e9).round() as u64;
        let header =
            MessageHeader { channel_id, sequence: self.num_updates, log_time, publish_time: log_time };
        let written = self.writer.write_to_known_channel(&header, bytes);
        written.map_err(|error| self.refused(&error))
    }

    fn refused(&self, error: &mcap::McapError) -> RecordingError {
        RecordingError::Write { path: self.path.clone(), reason: error.to_string() }
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If the disk is full or the like.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        match self.writer.finish() {
            Ok(_) => Ok(()),
            Err(error) => Err(self.refused(&error)),
        }
    }
}
