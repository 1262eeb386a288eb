//! Reads a recording as a stream of frames.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use visloc_core::{SkippedInput, Source, SourceError, SourceFrame, SourceStatus};

use crate::{
    bag::{
        BagError, BagTopics, ExpectedInputs, GivenInputs, SensorMessage, SyncOutcome, Synchronizer,
        TopicInfo, TopicRole,
        choose::{check_odometry, choose_topics, further_camera},
        decode::{RawMessage, Reject, decode},
        files::{BagFiles, bag_files},
        index::{check_topics, topics_of_files},
        pictures::time_goes_back,
        stream::MessageStream,
    },
    urdf::RobotDescription,
};

/// Frames from a bag: a file (`.mcap`, `.db3`, `.bag`) or a folder of rosbag2. Memory does not grow with its length.
pub struct BagReader {
    path: PathBuf,
    topics: BagTopics,
    given: GivenInputs,
    available: Vec<TopicInfo>,
    messages: MessageStream,
    synchronizer: Synchronizer,
    has_truth: bool,
    end: End,
    num_frames: usize,
    num_images: usize,
    num_held: usize,
}

/// How far the reading has come to its end.
enum End {
    NotReached,
    /// No more messages; the error, if any, follows after the frames that still wait.
    NoMoreMessages(Option<SourceError>),
    Delivered,
}

visloc_core::debug_shows!([] BagReader { path, topics, num_frames });

impl BagReader {
    /// Opens a recording and checks that the topics are there with types that can be read. Where the recording has none of a
    /// default name, the only topic of a fitting type is taken: see [`BagReader::topics`].
    ///
    /// # Errors
    /// If nothing can be read, or a topic is missing or has another type. The error lists the topics that are there.
    pub fn open(path: impl AsRef<Path>, topics: BagTopics) -> Result<Self, BagError> {
        Self::open_with(path, &topics, GivenInputs::default())
    }

    /// As [`BagReader::open`], with inputs that are used over those of the recording, or instead of them.
    ///
    /// # Errors
    /// As [`BagReader::open`]; topics that need not be read are not missed.
    pub fn open_with(
        path: impl AsRef<Path>,
        topics: &BagTopics,
        given: GivenInputs,
    ) -> Result<Self, BagError> {
        let path = path.as_ref();
        let asked = given.topics_to_read(topics);
        let files = bag_files(path)?;
        let available = topics_of_files(&files)?;
        check_odometry(path, &available, &asked)?;
        let topics = choose_topics(&available, &asked);
        check_topics(path, &available, (&asked, &topics), &given)?;
        let expected = expected_inputs(&available, &topics);
        let robot = given.robot.or_else(|| first_description(files.clone(), &available, &topics));
        let given = GivenInputs { robot, ..given };
        Ok(Self {
            path: path.to_path_buf(),
            synchronizer: Synchronizer::new(&topics, expected).with_given(given.clone()),
            messages: MessageStream::new(files, topics.clone()),
            topics,
            given,
            available,
            has_truth: true,
            end: End::NotReached,
            num_frames: 0,
            num_images: 0,
            num_held: 0,
        })
    }

    /// A reader for each camera of the topics, the first one first. Each reads the recording for itself and uses the same inputs over it;
    /// [`ManyCameras`] puts their frames in order.
    ///
    /// [`ManyCameras`]: crate::sources::ManyCameras
    ///
    /// # Errors
    /// As [`BagReader::open`].
    pub fn open_cameras(
        path: impl AsRef<Path>,
        topics: &BagTopics,
        given: &GivenInputs,
    ) -> Result<Vec<Self>, BagError> {
        let first = Self::open_with(&path, topics, given.clone())?;
        let mut readers = vec![first];
        for image in &topics.more_images {
            let further = further_camera(readers[0].available_topics(), readers[0].topics(), image);
            readers.push(Self::open_with(&path, &further, given.clone())?);
        }
        Ok(readers)
    }

    /// The same reader, with the truth left out of all frames.
    #[must_use]
    pub fn without_truth(mut self) -> Self {
        let expected = ExpectedInputs { has_truth: false, ..expected_inputs(&self.available, &self.topics) };
        self.synchronizer = Synchronizer::new(&self.topics, expected).with_given(self.given.clone());
        self.has_truth = false;
        self
    }

    /// The topics that are read.
    pub fn topics(&self) -> &BagTopics {
        &self.topics
    }

    /// The topics of the recording, sorted by name.
    pub fn available_topics(&self) -> &[TopicInfo] {
        &self.available
    }

    /// How many frames so far took the last known odometry or camera pose because nothing newer came within 0.25 s.
    pub fn num_frames_with_held_values(&self) -> usize {
        self.num_held
    }

    /// Reads one message and gives it to the synchronizer, or notes the end.
    fn read_on(&mut self) {
        match self.messages.next_message() {
            Some(Ok(raw)) => self.accept(&raw),
            Some(Err(error)) => {
                let origin = error.origin();
                if error.is_recoverable {
                    let reason = format!("{origin}: {}", error.reason);
                    self.synchronizer.skip(None, TopicRole::Image, reason);
                } else {
                    self.stop(Some(SourceError::Broken { origin, reason: error.reason }));
                }
            }
            None => self.stop(None),
        }
    }

    fn accept(&mut self, raw: &RawMessage) {
        let mut rejects = Vec::new();
        let message = decode(raw, &mut rejects);
        for Reject { at, reason, is_fatal } in rejects {
            if is_fatal {
                let origin = format!("{}: {}", self.path.display(), self.topics.name(raw.role));
                self.stop(Some(SourceError::Broken { origin, reason }));
            } else {
                self.synchronizer.skip(at, raw.role, reason);
            }
        }
        let Some(message) = message else { return };
        if matches!(message, SensorMessage::Image(_)) {
            self.num_images += 1;
        }
        if self.has_truth || !matches!(message, SensorMessage::GroundTruth(..)) {
            self.synchronizer.push(message);
        }
    }

    fn stop(&mut self, error: Option<SourceError>) {
        self.synchronizer.finish();
        self.end = End::NoMoreMessages(error);
    }

    /// At the end: the error that ended it, or that nothing could be used at all.
    fn last_words(&self, error: Option<SourceError>) -> Option<SourceError> {
        let num_backward = self.synchronizer.num_backward();
        if error.is_none() && num_backward > self.num_frames && self.num_frames > 0 {
            let origin = format!("{}: {}", self.path.display(), self.topics.image);
            return Some(SourceError::Broken {
                origin,
                reason: time_goes_back(num_backward, self.num_frames),
            });
        }
        if error.is_some() || self.num_frames > 0 || self.num_images == 0 {
            return error;
        }
        let is_image = |skipped: &&SkippedInput| skipped.origin == self.topics.image;
        let first = self.synchronizer.skipped().iter().find(is_image)?;
        Some(SourceError::Broken {
            origin: format!("{}: {}", self.path.display(), self.topics.image),
            reason: format!(
                "none of its {} images could be used; the first: {}",
                self.num_images, first.reason
            ),
        })
    }
}

impl Source<SourceFrame> for BagReader {
    fn next_item(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        loop {
            match self.synchronizer.pop() {
                Some(SyncOutcome::Frame(frame)) => {
                    self.num_frames += 1;
                    self.num_held += usize::from(frame.has_held_values);
                    return Some(Ok(frame.source_frame));
                }
                Some(SyncOutcome::Unusable(reason)) => {
                    self.end = End::Delivered;
                    let origin = format!("{}: {}", self.path.display(), self.topics.image);
                    return Some(Err(SourceError::Broken { origin, reason }));
                }
                None => {}
            }
            match &mut self.end {
                End::NotReached => self.read_on(),
                End::NoMoreMessages(error) => {
                    let error = error.take();
                    self.end = End::Delivered;
                    return self.last_words(error).map(Err);
                }
                End::Delivered => return None,
            }
        }
    }

    fn status(&self) -> SourceStatus<'_> {
        let images = self.available.iter().find(|info| info.topic == self.topics.image);
        SourceStatus {
            num_items: images.and_then(|images| usize::try_from(images.num_messages).ok()),
            skipped: self.synchronizer.skipped(),
            ..SourceStatus::default()
        }
    }
}

fn expected_inputs(available: &[TopicInfo], topics: &BagTopics) -> ExpectedInputs {
    let has =
        |role| available.iter().any(|info| topics.role(&info.topic) == Some(role) && info.num_messages > 0);
    ExpectedInputs {
        has_odometry: has(TopicRole::Odometry),
        has_imu: has(TopicRole::Imu),
        has_foot_contact: has(TopicRole::FootContact),
        has_foot_pressure: has(TopicRole::FootPressure),
        has_truth: has(TopicRole::GroundTruth),
    }
}

/// Reads ahead to the first description of the robot that can be used: it holds for the whole recording, wherever it stands.
fn first_description(
    files: BagFiles,
    available: &[TopicInfo],
    topics: &BagTopics,
) -> Option<Arc<RobotDescription>> {
    let name = &topics.robot_description;
    available.iter().find(|info| !name.is_empty() && info.topic == *name && info.num_messages > 0)?;
    let only = BagTopics { robot_description: name.clone(), ..BagTopics::none() };
    let mut messages = MessageStream::new(files, only);
    while let Some(Ok(raw)) = messages.next_message() {
        if let Some(SensorMessage::RobotDescription(robot)) = decode(&raw, &mut Vec::new()) {
            return Some(robot);
        }
    }
    None
}
