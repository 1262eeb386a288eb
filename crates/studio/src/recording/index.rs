//! Where the frames of a recording lie in its file.
//!
//! Source: the MCAP specification, version 0. Only what our own recordings have is read: records one after the other, an opcode
//! and the length of the content before each.

use std::{
    fs::File,
    io::{self, BufReader, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
};

use thiserror::Error;
use visloc_core::{Frame, GrayImage, Truth, files};
use visloc_io::{
    bag::{
        BagError, BagTopics,
        messages::{CompressedImage, from_cdr},
    },
    image_codec,
};

use super::input::{CameraInput, read_camera_input, read_input};
use crate::{Message, MessageError, message::plain};

/// Topics of a recording.
pub(super) const SCENE_TOPIC: &str = "/studio/scene";
pub(super) const IMAGE_TOPIC: &str = "/studio/image";
pub(super) const STATE_TOPIC: &str = "/studio/state";
pub(super) const INPUT_TOPIC: &str = "/studio/input";

/// Arrays of a state that a recording has only from time to time, the landmarks first, and the field that says in which moment.
pub(super) const MAP_ARRAYS: [&str; 6] =
    ["landmarks", "candidates", "keyframes", "links", "trajectory", "truth"];
pub(super) const MAP_MOMENT: &str = "map_moment";
/// The array of an image message that is left out where the input has the same picture, and the quality with which it is made again.
pub(super) const PICTURE: &str = "jpeg";
const PICTURE_QUALITY: u8 = 85;

const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
const OP_CHANNEL: u8 = 0x04;
const OP_MESSAGE: u8 = 0x05;
const OP_CHUNK: u8 = 0x06;
const OP_DATA_END: u8 = 0x0f;
/// Bytes of a message record before its data: channel, sequence, two times.
const MESSAGE_PREFIX: u64 = 2 + 4 + 8 + 8;
/// A longer message is damage, bytes.
const MAX_MESSAGE_BYTES: u64 = 256 << 20;
/// A longer channel record is damage, bytes.
const MAX_CHANNEL_BYTES: u64 = 1 << 16;

/// A recording that cannot be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// It cannot be written.
    #[error(transparent)]
    Write(#[from] BagError),
    /// There is no room for a file in a folder.
    #[error("{}: cannot write a recording there: {reason}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The file cannot be read.
    #[error("{}: cannot read it: {source}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// It is no recording.
    #[error("{}: expected a recording of visloc (--record), {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What was found.
        reason: String,
    },
    /// A message in it is damaged.
    #[error("{}: {source}", path.display())]
    Message {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: MessageError,
    },
}

/// A place in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    offset: u64,
    num_bytes: u64,
}

/// A frame by the places of its messages.
#[derive(Debug, Clone, Copy)]
struct Entry {
    scene: Place,
    /// With the picture of the input at that moment.
    image: Option<(Place, Option<Place>)>,
    state: Place,
    /// Numbers and image that the algorithms were given.
    input: Option<(Place, Place)>,
}

/// A recording whose frames can be read in any order.
#[derive(Debug)]
pub struct RecordingIndex {
    path: PathBuf,
    file: BufReader<File>,
    entries: Vec<Entry>,
    damage: Option<String>,
}

impl RecordingIndex {
    /// Opens a recording and finds its frames. What lies behind a cut or damage is left out.
    ///
    /// # Errors
    /// If it cannot be read, is no recording of visloc, or has no frame.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let read = |reason: String| RecordingError::Read { path: path.to_path_buf(), reason };
        let unread = |source| RecordingError::Open { path: path.to_path_buf(), source };
        let file = files::open(path).map_err(unread)?;
        let num_bytes = file.metadata().map_err(unread)?.len();
        let mut walk = Walk::new(BufReader::new(file), num_bytes);
        if !walk.has_magic() {
            return Err(read("found another kind of file".to_owned()));
        }
        while walk.next_record() {}
        if walk.entries.is_empty() {
            let reason = match walk.has_chunks {
                true => "found chunks, which another tool has made",
                false => "found no frame",
            };
            return Err(read(reason.to_owned()));
        }
        let damage = walk.damage();
        Ok(Self { path: path.to_path_buf(), file: walk.file, entries: walk.entries, damage })
    }

    /// Where and how the recording is damaged, if it is; what lies behind is left out.
    pub fn damage(&self) -> Option<&str> {
        self.damage.as_deref()
    }

    /// How many frames it has; at least one.
    pub fn num_frames(&self) -> usize {
        self.entries.len()
    }

    /// Whether two frames have the same scene.
    pub fn has_same_scene(&self, a: usize, b: usize) -> bool {
        self.entries[self.within(a)].scene == self.entries[self.within(b)].scene
    }

    /// The scene of a frame; numbers beyond the last one mean the last one.
    ///
    /// # Errors
    /// If the file cannot be read any more.
    pub fn scene(&mut self, frame: usize) -> Result<Message, RecordingError> {
        let place = self.entries[self.within(frame)].scene;
        self.message(place)
    }

    /// The state of a frame.
    ///
    /// # Errors
    /// As [`RecordingIndex::scene`].
    pub fn state(&mut self, frame: usize) -> Result<Message, RecordingError> {
        let mut state = self.short_state(frame)?;
        let moment =
            state.header.remove(MAP_MOMENT).and_then(|moment| usize::try_from(moment.as_u64()?).ok());
        Ok(match moment {
            Some(moment) => state.completed_by(&self.short_state(moment)?),
            None => state,
        })
    }

    /// The state of a frame without what was written for another one: numbers, but not the map.
    pub(crate) fn short_state(&mut self, frame: usize) -> Result<Message, RecordingError> {
        let place = self.entries[self.within(frame)].state;
        self.message(place)
    }

    /// The image of a frame as bytes; the last one before it, if it has none itself.
    ///
    /// # Errors
    /// As [`RecordingIndex::scene`].
    pub fn image(&mut self, frame: usize) -> Result<Option<Vec<u8>>, RecordingError> {
        let Some((place, picture)) = self.entries[self.within(frame)].image else { return Ok(None) };
        let bytes = plain(self.bytes(place)?);
        let Some(picture) = picture else { return Ok(Some(bytes)) };
        let Ok(message) = Message::read(&bytes) else { return Ok(Some(bytes)) };
        if message.bytes(PICTURE).is_some() {
            return Ok(Some(bytes));
        }
        let input = self.bytes(picture)?;
        let jpeg = from_cdr::<CompressedImage>(&input)
            .ok()
            .and_then(|image| image_codec::decode(&image.data).ok())
            .and_then(|image| image_codec::encode_jpeg(&image, PICTURE_QUALITY).ok());
        Ok(Some(jpeg.map_or(bytes, |jpeg| message.with_bytes(PICTURE, &jpeg, &[]))))
    }

    /// What the algorithms were given for a frame, and the truth; `None` if the recording does not hold it, or it is damaged.
    ///
    /// # Errors
    /// As [`RecordingIndex::scene`].
    pub fn input(&mut self, frame: usize) -> Result<Option<(Frame, Option<Truth>)>, RecordingError> {
        let Some((numbers, image)) = self.entries[self.within(frame)].input else { return Ok(None) };
        let numbers = self.message(numbers)?;
        let Ok(image) = from_cdr::<CompressedImage>(&self.bytes(image)?) else { return Ok(None) };
        let Ok(image) = image_codec::decode(&image.data) else { return Ok(None) };
        Ok(read_input(&numbers, image))
    }

    /// What SLAM was given for a frame but the image; `None` if the recording does not hold it, or it is damaged.
    pub(crate) fn camera_input(&mut self, frame: usize) -> Result<Option<CameraInput>, RecordingError> {
        let Some((numbers, _)) = self.entries[self.within(frame)].input else { return Ok(None) };
        Ok(read_camera_input(&self.message(numbers)?))
    }

    /// The image that SLAM was given for a frame; `None` if the recording does not hold it, or it is damaged.
    pub(crate) fn camera_image(&mut self, frame: usize) -> Result<Option<GrayImage>, RecordingError> {
        let Some((_, image)) = self.entries[self.within(frame)].input else { return Ok(None) };
        let bytes = self.bytes(image)?;
        Ok(from_cdr::<CompressedImage>(&bytes)
            .ok()
            .and_then(|image| image_codec::decode_gray(&image.data).ok()))
    }

    /// Whether the recording holds what the algorithms were given for all of its frames.
    pub fn has_input(&self) -> bool {
        self.entries.iter().all(|entry| entry.input.is_some())
    }

    fn within(&self, frame: usize) -> usize {
        frame.min(self.entries.len() - 1)
    }

    fn message(&mut self, place: Place) -> Result<Message, RecordingError> {
        let bytes = self.bytes(place)?;
        Message::read(&bytes).map_err(|source| RecordingError::Message { path: self.path.clone(), source })
    }

    fn bytes(&mut self, place: Place) -> Result<Vec<u8>, RecordingError> {
        let mut bytes = Vec::new();
        let file = &mut self.file;
        let done = file
            .seek(SeekFrom::Start(place.offset))
            .and_then(|_| file.by_ref().take(place.num_bytes).read_to_end(&mut bytes));
        match done {
            Ok(_) if bytes.len() as u64 == place.num_bytes => Ok(bytes),
            Ok(_) => Err(self.refused("found its end in a frame")),
            Err(error) => Err(self.refused(&error.to_string())),
        }
    }

    fn refused(&self, reason: &str) -> RecordingError {
        RecordingError::Read { path: self.path.clone(), reason: reason.to_owned() }
    }
}

/// The way through a file.
struct Walk {
    file: BufReader<File>,
    num_bytes: u64,
    at: u64,
    /// Names of the topics, and their channels.
    topics: [String; 5],
    channels: [Option<u16>; 5],
    scene: Option<Place>,
    image: Option<(Place, Option<Place>)>,
    /// Of the next state.
    numbers: Option<Place>,
    picture: Option<Place>,
    entries: Vec<Entry>,
    has_chunks: bool,
    has_data_end: bool,
}

impl Walk {
    fn new(file: BufReader<File>, num_bytes: u64) -> Self {
        Self {
            file,
            num_bytes,
            at: 0,
            topics: [SCENE_TOPIC, IMAGE_TOPIC, STATE_TOPIC, INPUT_TOPIC, &BagTopics::default().image]
                .map(str::to_owned),
            channels: [None; 5],
            scene: None,
            image: None,
            numbers: None,
            picture: None,
            entries: Vec::new(),
            has_chunks: false,
            has_data_end: false,
        }
    }

    fn has_magic(&mut self) -> bool {
        self.read::<8>() == Some(MAGIC)
    }

    fn read<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut bytes = [0; N];
        self.file.read_exact(&mut bytes).ok()?;
        self.at += N as u64;
        Some(bytes)
    }

    /// Whether there may be more.
    fn next_record(&mut self) -> bool {
        let Some([opcode]) = self.read::<1>() else { return false };
        let Some(length) = self.read::<8>().map(u64::from_le_bytes) else { return false };
        let Some(end) = self.at.checked_add(length).filter(|end| *end <= self.num_bytes) else {
            return false;
        };
        let is_good = match opcode {
            OP_DATA_END => {
                self.has_data_end = true;
                return false;
            }
            OP_CHANNEL => self.channel(length).is_some(),
            OP_MESSAGE => self.message(length).is_some(),
            OP_CHUNK => {
                self.has_chunks = true;
                true
            }
            _ => true,
        };
        let offset = i64::try_from(end.saturating_sub(self.at)).unwrap_or(i64::MAX);
        self.at = end;
        is_good && self.file.seek_relative(offset).is_ok()
    }

    /// What is wrong at the place where the walk ended, if that is not the end of the recording.
    fn damage(&mut self) -> Option<String> {
        let mut mark = [0; MAGIC.len()];
        let end = SeekFrom::End(-(MAGIC.len() as i64));
        let has_mark =
            self.file.seek(end).and_then(|_| self.file.read_exact(&mut mark)).is_ok() && mark == MAGIC;
        (!self.has_data_end || !has_mark).then(|| {
            format!(
                "byte {}: expected more records and the end mark of MCAP, found none (was the recording cut off?)",
                self.at
            )
        })
    }

    fn channel(&mut self, length: u64) -> Option<()> {
        if length > MAX_CHANNEL_BYTES {
            return None;
        }
        let id = u16::from_le_bytes(self.read::<2>()?);
        let _schema = self.read::<2>()?;
        let topic_bytes = u32::from_le_bytes(self.read::<4>()?);
        if u64::from(topic_bytes) > length {
            return None;
        }
        let mut topic = vec![0; topic_bytes as usize];
        self.file.read_exact(&mut topic).ok()?;
        self.at += u64::from(topic_bytes);
        if let Some(place) = self.topics.iter().position(|known| known.as_bytes() == topic) {
            self.channels[place] = Some(id);
        }
        Some(())
    }

    fn message(&mut self, length: u64) -> Option<()> {
        if !(MESSAGE_PREFIX..=MAX_MESSAGE_BYTES).contains(&length) {
            return None;
        }
        let channel = u16::from_le_bytes(self.read::<2>()?);
        let place = Place { offset: self.at + MESSAGE_PREFIX - 2, num_bytes: length - MESSAGE_PREFIX };
        match self.channels.iter().position(|known| *known == Some(channel)) {
            Some(0) => self.scene = Some(place),
            Some(1) => self.image = Some((place, self.picture)),
            Some(2) => {
                let input = self.numbers.take().zip(self.picture.take());
                let entry = |scene| Entry { scene, image: self.image, state: place, input };
                self.entries.extend(self.scene.map(entry));
            }
            Some(3) => self.numbers = Some(place),
            Some(4) => self.picture = Some(place),
            _ => {}
        }
        Some(())
    }
}
