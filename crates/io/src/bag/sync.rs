//! Joins the messages of several topics to frames, by their stamps.

mod assemble;

use std::{collections::VecDeque, sync::Arc};

use visloc_core::{
    SkippedInput, SourceFrame, Timestamp, Truth,
    geom::{Camera, PlanarPose},
};

use crate::{
    bag::{
        BagTopics, EncodedImage, GivenInputs, SensorMessage, StampedTransform, TopicRole,
        decode::frame_name,
        history::{History, Pushed},
        joints::JointPoses,
        level::Level,
        tf_tree::{Teller, TfTree},
    },
    urdf::RobotDescription,
};

/// How long a picture waits for the other topics, seconds of the recording.
const MAX_WAIT_SECS: f64 = 0.25;
/// Most pictures that wait; bounds memory.
const MAX_WAITING: usize = 16;
/// After so many pictures in a row of the wrong size, the calibration is believed to be another camera's.
const MAX_WRONG_SIZE: u32 = 10;
/// Messages without a stamp count from when they were sent, if that clock agrees with the stamps this well, seconds.
const MAX_CLOCK_DIFFERENCE_SECS: f64 = 1.0;
/// A picture this far ahead of everything else does not move the time on, seconds.
const MAX_IMAGE_LEAD_SECS: f64 = 10.0;
/// Most reasons that are kept; bounds memory.
pub(crate) const MAX_SKIPPED: usize = 10_000;

/// Which topics there are, so that a picture waits for those only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ExpectedInputs {
    /// Odometry.
    pub has_odometry: bool,
    /// Tilt by an IMU.
    pub has_imu: bool,
    /// Contact of the feet, yes or no.
    pub has_foot_contact: bool,
    /// Forces under the feet.
    pub has_foot_pressure: bool,
    /// Ground truth.
    pub has_truth: bool,
}

/// A frame and how well it was joined.
#[derive(Debug, Clone)]
pub struct SynchronizedFrame {
    /// The frame.
    pub source_frame: SourceFrame,
    /// Whether the camera pose is the last known value or the odometry is guessed from it or missing, because nothing newer came.
    pub has_held_values: bool,
}

/// What [`Synchronizer::pop`] finds.
#[derive(Debug)]
pub enum SyncOutcome {
    /// A frame.
    Frame(Box<SynchronizedFrame>),
    /// No further picture can be used; why.
    Unusable(String),
}

/// Joins messages to frames in one pass. Messages of a topic come in order of time, topics in any order.
///
/// A picture with stamp t becomes a frame when all other topics are known at or after t: odometry and camera pose
/// interpolated at t, the foot sensors as they were last, the truth nearest to t within half a frame. If a topic falls
/// silent, the picture waits for 0.25 s of later messages and takes the last known camera pose, if that is at most 0.5 s old, and the
/// odometry of a robot that goes on as before, if the next sample is not overdue by the topic's own rate. Held for longer, it would tell
/// that the robot has stopped. Without odometry the frame has none, without a camera pose or calibration the picture is left out.
#[derive(Debug)]
pub struct Synchronizer {
    base_frame: String,
    camera_frame: Option<String>,
    topics: BagTopics,
    expected: ExpectedInputs,
    given: GivenInputs,
    images: VecDeque<EncodedImage>,
    cameras: History<Camera>,
    odometry: History<PlanarPose>,
    tree: TfTree,
    joints: JointPoses,
    level: Level,
    foot_contact: History<bool>,
    foot_pressure: History<[f64; 8]>,
    truth: History<Truth>,
    newest_at: Option<Timestamp>,
    last_image_at: Option<Timestamp>,
    image_interval_secs: f64,
    num_wrong_size: u32,
    num_backward: usize,
    is_finished: bool,
    skipped: Vec<SkippedInput>,
}

impl Synchronizer {
    /// A synchronizer for the given names.
    pub fn new(topics: &BagTopics, expected: ExpectedInputs) -> Self {
        Self {
            base_frame: frame_name(&topics.base_frame).to_string(),
            camera_frame: topics.camera_frame.as_deref().map(|name| frame_name(name).to_string()),
            topics: topics.clone(),
            expected,
            given: GivenInputs::default(),
            images: VecDeque::new(),
            cameras: History::default(),
            odometry: History::default(),
            tree: TfTree::default(),
            joints: JointPoses::default(),
            level: Level::default(),
            foot_contact: History::default(),
            foot_pressure: History::default(),
            truth: History::default(),
            newest_at: None,
            last_image_at: None,
            image_interval_secs: 1.0 / 30.0,
            num_wrong_size: 0,
            num_backward: 0,
            is_finished: false,
            skipped: Vec::new(),
        }
    }

    /// The same synchronizer with inputs that win over messages and are not waited for.
    #[must_use]
    pub fn with_given(mut self, given: GivenInputs) -> Self {
        self.give(given);
        self
    }

    /// Sets the inputs that win over messages, as soon as they are known.
    pub fn give(&mut self, given: GivenInputs) {
        if let Some(robot) = &given.robot {
            self.describe(robot.clone());
        }
        self.given = given;
    }

    fn describe(&mut self, robot: Arc<RobotDescription>) {
        for reason in self.joints.describe(robot, &mut self.tree) {
            self.skip(None, TopicRole::RobotDescription, reason);
        }
    }

    /// Changes which topics a picture waits for, as those of a live source come and go.
    pub fn expect(&mut self, expected: ExpectedInputs) {
        self.expected = expected;
    }

    /// Begins again after the sender's clock was set back: what moves is forgotten, what never moves and the calibration stay.
    pub fn restart(&mut self) {
        let mut anew = Self::new(&self.topics, self.expected).with_given(self.given.clone());
        anew.tree = self.tree.fixed();
        anew.joints = self.joints.clone();
        if let Some((_, camera)) = self.cameras.newest() {
            anew.cameras.push(Timestamp::from_nanos(i64::MIN / 4), camera);
        }
        anew.skipped = std::mem::take(&mut self.skipped);
        *self = anew;
    }

    /// Drops all pictures that are complete but for the newest of them, for whoever has no time for all. How many.
    pub fn drop_stale(&mut self) -> usize {
        let num_ready = self.images.iter().take_while(|image| self.is_ready(image)).count();
        let num_stale = num_ready.saturating_sub(1);
        for image in self.images.drain(..num_stale).collect::<Vec<_>>() {
            self.advance(image.at);
        }
        num_stale
    }

    /// Takes the next message. Afterwards call [`Synchronizer::pop`] until there is nothing more.
    pub fn push(&mut self, message: SensorMessage) {
        match message {
            SensorMessage::Image(image) => self.push_image(image),
            SensorMessage::CameraInfo(at, camera) => {
                let pushed = self.cameras.push(at, camera);
                self.note(TopicRole::CameraInfo, at, pushed);
            }
            SensorMessage::Odometry(at, pose) => {
                let pushed = self.odometry.push(at, pose);
                self.note(TopicRole::Odometry, at, pushed);
            }
            SensorMessage::Transforms(transforms) => {
                for transform in transforms {
                    let pushed = self.tree.add_moving(&transform, Teller::Transforms);
                    self.note(TopicRole::Tf, transform.at, pushed);
                }
            }
            SensorMessage::StaticTransforms(transforms) => {
                let add = |transform: &StampedTransform| self.tree.add_fixed(transform, Teller::Transforms);
                transforms.iter().for_each(add);
            }
            SensorMessage::JointStates(at, positions) => {
                let moved = self.joints.push(at, &positions, &self.base_frame, &mut self.tree);
                if let Some(reason) = moved.unusable {
                    self.skip(Some(at), TopicRole::JointStates, reason);
                }
                self.note(TopicRole::JointStates, at, moved.pushed);
            }
            SensorMessage::RobotDescription(robot) => {
                if self.given.robot.is_none() {
                    self.describe(robot);
                }
            }
            SensorMessage::Imu(at, imu_frame, world_from_imu) => {
                let pushed = self.level.push(at, &imu_frame, &world_from_imu);
                self.note(TopicRole::Imu, at, pushed);
            }
            SensorMessage::FootContact(sent_at, has_contact) => {
                let pushed = self.foot_contact.push(self.stamp_for(sent_at), has_contact);
                self.note_unstamped(TopicRole::FootContact, sent_at, pushed);
            }
            SensorMessage::FootPressure(sent_at, forces) => {
                let pushed = self.foot_pressure.push(self.stamp_for(sent_at), forces);
                self.note_unstamped(TopicRole::FootPressure, sent_at, pushed);
            }
            SensorMessage::GroundTruth(at, truth) => {
                let pushed = self.truth.push(at, truth);
                self.note(TopicRole::GroundTruth, at, pushed);
            }
        }
    }

    /// Says that no more messages come: the pictures that still wait become frames.
    pub fn finish(&mut self) {
        self.is_finished = true;
    }

    /// The next frame that is complete; `None` if more messages are needed.
    pub fn pop(&mut self) -> Option<SyncOutcome> {
        while self.images.front().is_some_and(|image| self.is_ready(image)) {
            let image = self.images.pop_front()?;
            match self.assemble(&image) {
                Ok(frame) => {
                    self.num_wrong_size = 0;
                    self.advance(image.at);
                    return Some(SyncOutcome::Frame(Box::new(frame)));
                }
                Err(reason) if self.num_wrong_size >= MAX_WRONG_SIZE => {
                    let calibration = match self.given.camera {
                        Some(_) => "the calibration that was given".to_owned(),
                        None => format!("'{}'", self.topics.camera_info),
                    };
                    let reason = format!(
                        "{reason}, {MAX_WRONG_SIZE} times in a row: {calibration} belongs to another camera or size"
                    );
                    self.images.clear();
                    return Some(SyncOutcome::Unusable(reason));
                }
                Err(reason) => {
                    self.advance(image.at);
                    self.skip(Some(image.at), TopicRole::Image, reason);
                }
            }
        }
        None
    }

    /// Images that came after later ones.
    pub fn num_backward(&self) -> usize {
        self.num_backward
    }

    /// What was left out so far. At most 10000 entries are kept.
    pub fn skipped(&self) -> &[SkippedInput] {
        &self.skipped
    }

    /// Records a message of a topic that cannot be used.
    pub fn skip(&mut self, at: Option<Timestamp>, role: TopicRole, reason: String) {
        if self.skipped.len() < MAX_SKIPPED {
            let name = match self.topics.name(role) {
                // What is given comes on no topic.
                "" => role.meaning(),
                name => name,
            };
            self.skipped.push(SkippedInput { at, origin: name.to_string(), reason });
        }
    }

    fn push_image(&mut self, image: EncodedImage) {
        let is_after_last = self.last_image_at.is_none_or(|last| image.at > last);
        let position = self.images.partition_point(|waiting| waiting.at < image.at);
        let is_twice = self.images.get(position).is_some_and(|waiting| waiting.at == image.at);
        if !is_after_last || is_twice {
            let last = self.last_image_at.filter(|_| !is_after_last).unwrap_or(image.at);
            self.num_backward += 1;
            let reason = format!("expected an image later than {last}, found one at {}", image.at);
            self.skip(Some(image.at), TopicRole::Image, reason);
            return;
        }
        if self.newest_at.is_none_or(|newest| image.at.secs_since(newest) < MAX_IMAGE_LEAD_SECS) {
            self.newest_at = self.newest_at.max(Some(image.at));
        }
        self.images.insert(position, image);
    }

    fn note(&mut self, role: TopicRole, at: Timestamp, pushed: Pushed) {
        match pushed {
            Pushed::Accepted => self.newest_at = self.newest_at.max(Some(at)),
            Pushed::Restarted => self.newest_at = Some(at),
            Pushed::Backward { newest } => {
                let reason = format!("time goes back: expected a message after {newest}, found one at {at}");
                self.skip(Some(at), role, reason);
            }
        }
    }

    fn note_unstamped(&mut self, role: TopicRole, sent_at: Timestamp, pushed: Pushed) {
        if let Pushed::Backward { newest } = pushed {
            let reason = format!("time goes back: expected a message after {newest}, found one at {sent_at}");
            self.skip(Some(sent_at), role, reason);
        }
    }

    /// Stamp of a message that has none: when it was sent, or the newest stamp if the sender's clock is another one.
    fn stamp_for(&self, sent_at: Timestamp) -> Timestamp {
        match self.newest_at {
            Some(newest) if sent_at.secs_since(newest).abs() <= MAX_CLOCK_DIFFERENCE_SECS => sent_at,
            Some(newest) => newest,
            // Before the first stamp: it holds from the beginning.
            None => Timestamp::from_nanos(i64::MIN / 4),
        }
    }

    fn is_ready(&self, image: &EncodedImage) -> bool {
        let at = image.at;
        let has_waited = self.newest_at.is_some_and(|newest| newest.secs_since(at) >= MAX_WAIT_SECS);
        if self.is_finished || has_waited || self.images.len() > MAX_WAITING {
            return true;
        }
        let reaches = |newest: Option<Timestamp>| newest.is_some_and(|newest| newest >= at);
        (self.given.camera.is_some() || self.cameras.newest_at().is_some())
            && (self.given.robot_from_camera.is_some()
                || self.tree.covers(&self.base_frame, self.camera_frame_of(image), at))
            && (!self.expected.has_odometry || reaches(self.odometry.newest_at()))
            && (!self.expected.has_imu || reaches(self.level.newest_at()))
            && (!self.expected.has_foot_contact || reaches(self.foot_contact.newest_at()))
            && (!self.expected.has_foot_pressure || reaches(self.foot_pressure.newest_at()))
            && (!self.expected.has_truth || reaches(self.truth.newest_at()))
    }

    fn camera_frame_of<'a>(&'a self, image: &'a EncodedImage) -> &'a str {
        self.camera_frame.as_deref().unwrap_or_else(|| frame_name(&image.frame_id))
    }

    /// Time between pictures: since the last one, or as before if there was a gap.
    fn interval_secs(&self, at: Timestamp) -> f64 {
        let since_last = self.last_image_at.map(|last| at.secs_since(last));
        since_last.filter(|secs| *secs < 0.25).unwrap_or(self.image_interval_secs)
    }

    /// Remembers the picture and forgets what only earlier ones needed.
    fn advance(&mut self, at: Timestamp) {
        self.image_interval_secs = self.interval_secs(at);
        self.last_image_at = Some(at);
        self.cameras.forget_before(at);
        self.odometry.forget_before(at);
        self.tree.forget_before(at);
        self.level.forget_before(at);
        self.foot_contact.forget_before(at);
        self.foot_pressure.forget_before(at);
        self.truth.forget_before(at);
    }
}
