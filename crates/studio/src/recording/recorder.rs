//! Writes a recording.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::json;
use visloc_core::Timestamp;
use visloc_io::bag::{BagError, BagTopics, BagWriter, BagWriterOptions, ImageEncoding};

use super::{
    index::{
        IMAGE_TOPIC, INPUT_TOPIC, MAP_ARRAYS, MAP_MOMENT, PICTURE, RecordingError, SCENE_TOPIC, STATE_TOPIC,
    },
    input::{Input, input_message},
};
use crate::{Message, Update, message::packed};

/// What the messages are, for other tools.
const ENCODING: &str = "visloc-studio";
/// A map of landmarks is written once in so many moments, or when the number of its landmarks has changed by this share.
const MAP_EVERY: usize = 15;
const MAP_GROWTH: f64 = 0.1;

/// The map that was written last.
struct WrittenMap {
    moment: usize,
    num_numbers: usize,
}

/// Writes updates to a file, with what the algorithms were given.
pub struct Recorder {
    path: PathBuf,
    writer: BagWriter,
    scene: Option<Arc<[u8]>>,
    map: Option<WrittenMap>,
    num_updates: usize,
}

impl Recorder {
    /// Creates a file, and its folder.
    ///
    /// # Errors
    /// If that is not possible.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        let options = BagWriterOptions {
            image_encoding: ImageEncoding::Png,
            has_chunks: false,
            ..BagWriterOptions::default()
        };
        let writer = BagWriter::create_file(path, BagTopics::default(), options)?;
        Ok(Self { path: path.to_path_buf(), writer, scene: None, map: None, num_updates: 0 })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How many updates it has.
    pub fn num_updates(&self) -> usize {
        self.num_updates
    }

    /// Appends an update of a moment, seconds since the first frame, and what the algorithms were given for it, if that is known.
    ///
    /// # Errors
    /// If the disk is full or the like.
    pub fn add(
        &mut self,
        update: &Update,
        secs: f64,
        input: Option<&Input<'_>>,
    ) -> Result<(), RecordingError> {
        let at = input.map_or_else(|| Timestamp::default() + secs, Input::at);
        let written = self.write(update, at, input);
        self.num_updates += 1;
        Ok(written?)
    }

    /// The state comes last and ends the moment.
    fn write(&mut self, update: &Update, at: Timestamp, input: Option<&Input<'_>>) -> Result<(), BagError> {
        if !self.scene.as_ref().is_some_and(|known| Arc::ptr_eq(known, &update.scene)) {
            self.writer.write_raw((SCENE_TOPIC, ENCODING), at, &packed(&update.scene))?;
            self.scene = Some(Arc::clone(&update.scene));
            self.map = None;
        }
        if let Some(input) = input {
            self.write_input(input)?;
        }
        if let Some(bytes) = &update.image {
            let thinned = input.and_then(|input| without_picture(bytes, input));
            self.writer.write_raw(
                (IMAGE_TOPIC, ENCODING),
                at,
                &packed(thinned.as_deref().unwrap_or(bytes)),
            )?;
        }
        let thinned = self.without_map(&update.state);
        self.writer.write_raw(
            (STATE_TOPIC, ENCODING),
            at,
            &packed(thinned.as_deref().unwrap_or(&update.state)),
        )?;
        self.writer.end_moment(at)
    }

    /// The state of a camera without its map, if that was written a moment ago; `None` if it is to be written as it is.
    fn without_map(&mut self, state: &[u8]) -> Option<Vec<u8>> {
        let state = Message::read(state).ok()?;
        let num_numbers = state.floats(MAP_ARRAYS[0])?.len();
        let fresh = self.map.as_ref().filter(|map| {
            let growth = num_numbers.abs_diff(map.num_numbers) as f64 / num_numbers.max(1) as f64;
            self.num_updates - map.moment < MAP_EVERY && growth < MAP_GROWTH
        });
        let Some(map) = fresh else {
            self.map = Some(WrittenMap { moment: self.num_updates, num_numbers });
            return None;
        };
        let mut thinned = state.without(&MAP_ARRAYS);
        thinned.field(MAP_MOMENT, map.moment.into());
        Some(thinned.finish())
    }

    fn write_input(&mut self, input: &Input<'_>) -> Result<(), BagError> {
        match input {
            Input::Robot { frame, truth } => self.writer.write_frame(frame, *truth)?,
            Input::Camera { at, image, camera, .. } => self.writer.write_gray(*at, image, camera)?,
        }
        let Ok(message) = input_message(input) else { return Ok(()) };
        self.writer.write_raw((INPUT_TOPIC, ENCODING), input.at(), &message)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If the disk is full or the like.
    pub fn finish(self) -> Result<(), RecordingError> {
        Ok(self.writer.finish()?)
    }
}

/// An image message without its picture, which stands in the recording as input as well; `None` if that is another one.
fn without_picture(message: &[u8], input: &Input<'_>) -> Option<Vec<u8>> {
    let message = Message::read(message).ok()?;
    let (width, height) = input.size_px();
    (message.header.get("size_px") == Some(&json!([width, height])))
        .then(|| message.without(&[PICTURE]).finish())
}
