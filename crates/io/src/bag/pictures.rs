//! The pictures of a recording, whatever else is in it.

use std::path::{Path, PathBuf};

use visloc_core::{Picture, SkippedInput, Source, SourceError, SourceStatus, Timestamp, geom::Camera};

use crate::bag::{
    BagError, BagTopics, ImagePayload, SensorMessage, TopicInfo, TopicRole,
    choose::choose_topics,
    decode::decode,
    files::{BagFiles, bag_files},
    index::{check_topic, no_messages, topics_of_files},
    stream::MessageStream,
};

/// The pictures of a bag, and its calibration if it has one. Kinematics and odometry are not needed.
pub struct BagPictures {
    path: PathBuf,
    topics: BagTopics,
    messages: MessageStream,
    camera: Option<Camera>,
    /// Whether another calibration came.
    has_changed: bool,
    num_pictures: Option<usize>,
    last_at: Option<Timestamp>,
    num_used: usize,
    num_backward: usize,
    /// The file of the last picture, if it was one.
    skipped: Vec<SkippedInput>,
    is_done: bool,
}

visloc_core::debug_shows!([] BagPictures { path, topics, num_used });

impl BagPictures {
    /// Opens a recording.
    ///
    /// # Errors
    /// If nothing can be read, or the topic of the pictures is missing or has another type.
    pub fn open(path: impl AsRef<Path>, topics: &BagTopics) -> Result<Self, BagError> {
        let path = path.as_ref();
        let files = bag_files(path)?;
        let available = topics_of_files(&files)?;
        let topics = &choose_topics(&available, topics);
        let images = check_topic(path, &available, topics, TopicRole::Image)?;
        if images.num_messages == 0 {
            return Err(no_messages(path, &available, images, TopicRole::Image));
        }
        let num_pictures = usize::try_from(images.num_messages).ok();
        let camera = first_camera(files.clone(), &available, topics);
        let camera_info = camera.map(|_| topics.camera_info.clone()).unwrap_or_default();
        let names = BagTopics { image: topics.image.clone(), camera_info, ..BagTopics::none() };
        Ok(Self {
            path: path.to_path_buf(),
            messages: MessageStream::new(files, names.clone()),
            camera,
            has_changed: false,
            topics: names,
            num_pictures,
            last_at: None,
            num_used: 0,
            num_backward: 0,
            skipped: Vec::new(),
            is_done: false,
        })
    }

    /// Topic of the pictures.
    pub fn topic(&self) -> &str {
        &self.topics.image
    }

    /// The first calibration of the recording.
    pub fn camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    fn skip(&mut self, at: Option<Timestamp>, reason: String) {
        self.skipped.push(SkippedInput { at, origin: self.topics.image.clone(), reason });
    }

    /// One camera has one calibration: of others the first is told.
    fn note_calibration(&mut self, at: Timestamp, camera: &Camera) {
        if self.has_changed || self.camera.as_ref().is_none_or(|first| first == camera) {
            return;
        }
        self.has_changed = true;
        let of = |camera: &Camera| {
            format!("{} x {} px, fx {:.1}", camera.size_px().0, camera.size_px().1, camera.focal_px().0)
        };
        let first = self.camera.as_ref().map(of).unwrap_or_default();
        let reason =
            format!("another calibration ({}): the first one ({first}) is used for all images", of(camera));
        self.skipped.push(SkippedInput { at: Some(at), origin: self.topics.camera_info.clone(), reason });
    }

    /// The next picture that can be used, or why the recording ends early.
    fn read_on(&mut self) -> Option<Result<Picture, SourceError>> {
        loop {
            let raw = match self.messages.next_message()? {
                Ok(raw) => raw,
                Err(error) => {
                    let origin = error.origin();
                    if !error.is_recoverable {
                        return Some(Err(SourceError::Broken { origin, reason: error.reason }));
                    }
                    self.skip(None, format!("{origin}: {}", error.reason));
                    continue;
                }
            };
            let mut rejects = Vec::new();
            let message = decode(&raw, &mut rejects);
            if raw.role == TopicRole::Image {
                rejects.into_iter().for_each(|reject| self.skip(reject.at, reject.reason));
            }
            let image = match message {
                Some(SensorMessage::Image(image)) => image,
                Some(SensorMessage::CameraInfo(at, camera)) => {
                    self.note_calibration(at, &camera);
                    continue;
                }
                _ => continue,
            };
            if let Some(last) = self.last_at.filter(|last| *last >= image.at) {
                self.num_backward += 1;
                self.skip(Some(image.at), format!("expected an image later than {last}, found {}", image.at));
                continue;
            }
            match image.decode() {
                Ok(pixels) => {
                    self.last_at = Some(image.at);
                    self.num_used += 1;
                    let file = match image.payload {
                        ImagePayload::Compressed(bytes) => Some(bytes),
                        ImagePayload::Raw(_) => None,
                    };
                    return Some(Ok(Picture { at: image.at, image: pixels, file }));
                }
                Err(reason) => self.skip(Some(image.at), reason),
            }
        }
    }
}

impl Source<Picture> for BagPictures {
    fn next_item(&mut self) -> Option<Result<Picture, SourceError>> {
        if self.is_done {
            return None;
        }
        let next = self.read_on();
        self.is_done = !matches!(next, Some(Ok(_)));
        if next.is_none() && self.num_backward > self.num_used {
            let origin = format!("{}: {}", self.path.display(), self.topics.image);
            let reason = time_goes_back(self.num_backward, self.num_used);
            return Some(Err(SourceError::Broken { origin, reason }));
        }
        if next.is_none() && self.last_at.is_none() {
            let first = self.skipped.first().map_or("it has no images", |skipped| &skipped.reason);
            let origin = format!("{}: {}", self.path.display(), self.topics.image);
            let reason = format!("none of its images could be used: {first}");
            return Some(Err(SourceError::Broken { origin, reason }));
        }
        next
    }

    fn status(&self) -> SourceStatus<'_> {
        SourceStatus { num_items: self.num_pictures, skipped: &self.skipped, ..SourceStatus::default() }
    }
}

/// Why a recording is of no use of which most images are left out since their stamps go back.
pub(super) fn time_goes_back(num_backward: usize, num_used: usize) -> String {
    format!(
        "the stamps of its images do not grow: {num_backward} are not later than those before and are left out, {num_used} were used; \
         expected a clock that runs on: cut the recording where it was set, or have the driver stamp its images"
    )
}

/// Reads ahead to the first calibration that can be used; nothing if there is none.
fn first_camera(files: BagFiles, available: &[TopicInfo], topics: &BagTopics) -> Option<Camera> {
    let name = &topics.camera_info;
    let info = available.iter().find(|info| info.topic == *name)?;
    if name.is_empty() || info.type_name != TopicRole::CameraInfo.type_names()[0] {
        return None;
    }
    let mut messages =
        MessageStream::new(files, BagTopics { camera_info: name.clone(), ..BagTopics::none() });
    while let Some(Ok(raw)) = messages.next_message() {
        if let Some(SensorMessage::CameraInfo(_, camera)) = decode(&raw, &mut Vec::new()) {
            return Some(camera);
        }
    }
    None
}
