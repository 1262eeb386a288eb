//! Frames of a running robot.

use std::{collections::VecDeque, path::PathBuf, time::Duration};

use visloc_core::{Host, Source, SourceError, SourceFrame, SourceStatus, Timestamp};

use crate::{
    bag::{
        BagTopics, EncodedImage, ExpectedInputs, GivenInputs, Reject, RosMessage, SensorMessage, SyncOutcome,
        Synchronizer, TopicRole,
    },
    ros2::{
        LiveSettings, Ros2Error,
        inbox::Received,
        receive::Receiver,
        vigil::{Vigil, WAIT},
    },
    sequence::{Calibration, fit_calibration},
};

/// A topic that was silent for so long is not waited for.
const SILENT_SECS: f64 = 1.0;
/// Without a frame for so long after the first image, the user hears what is missing.
const NO_FRAME_SECS: f64 = 3.0;
/// Most images whose arrival is remembered.
const MAX_ARRIVALS: usize = 64;
/// The frame above odometry; what is known about it comes from localization, maybe from our own.
const MAP_FRAME: &str = "map";

/// The frames of live topics, the newest when there is no time for all.
pub struct LiveFrames {
    receiver: Receiver,
    synchronizer: Synchronizer,
    /// A calibration that waits for the size of the first image.
    calibration: Option<(Calibration, PathBuf)>,
    given: GivenInputs,
    topics: BagTopics,
    host: Host,
    vigil: Vigil,
    heard: Heard,
    newest_image_at: Option<Timestamp>,
    /// Stamps of the last images, and when they came.
    arrivals: VecDeque<(Timestamp, Timestamp)>,
    received_at: Option<Timestamp>,
    /// When the first image came; nothing once a frame is complete or the user knows why none is.
    waiting_since: Option<Timestamp>,
    num_stale: usize,
    num_lost: u64,
    is_done: bool,
}

visloc_core::debug_shows!([] LiveFrames { topics, newest_image_at, num_stale, num_lost });

/// When each of the topics that need not be there was heard last.
#[derive(Debug, Default)]
struct Heard {
    odometry: Option<Timestamp>,
    imu: Option<Timestamp>,
    foot_contact: Option<Timestamp>,
    foot_pressure: Option<Timestamp>,
    truth: Option<Timestamp>,
}

impl LiveFrames {
    /// Subscribes. Whether anybody publishes shows later.
    ///
    /// # Errors
    /// If there is no network, or a name is wrong.
    pub fn open(settings: &LiveSettings, host: &Host) -> Result<Self, Ros2Error> {
        let given = GivenInputs {
            robot_from_camera: settings.robot_from_camera,
            robot: settings.robot.clone(),
            ..GivenInputs::default()
        };
        let mut topics = given.topics_to_read(&settings.topics);
        if settings.calibration.is_some() {
            topics.camera_info.clear();
        }
        let settings = LiveSettings { topics: topics.clone(), ..settings.clone() };
        let receiver = Receiver::start(&settings, &TopicRole::ALL, host)?;
        Ok(Self {
            synchronizer: Synchronizer::new(&topics, ExpectedInputs::default()).with_given(given.clone()),
            calibration: settings.calibration,
            given,
            vigil: Vigil::new(&topics.image, receiver.image_type, settings.patience_secs, host.now()),
            receiver,
            topics,
            host: host.clone(),
            heard: Heard::default(),
            newest_image_at: None,
            arrivals: VecDeque::new(),
            received_at: None,
            waiting_since: None,
            num_stale: 0,
            num_lost: 0,
            is_done: false,
        })
    }

    /// Images that were lost on the way.
    #[must_use]
    pub fn num_lost(&self) -> u64 {
        self.num_lost
    }

    fn accept(&mut self, received: Received) -> Result<(), SourceError> {
        match received {
            Received::Message(at, message) => self.accept_message(at, message)?,
            Received::Lost(number) => self.num_lost += number,
            Received::Unreadable(reason) => self.synchronizer.skip(None, TopicRole::Image, reason),
        }
        Ok(())
    }

    fn accept_message(&mut self, received_at: Timestamp, message: RosMessage) -> Result<(), SourceError> {
        self.heard.note(&message, received_at);
        let role = role_of(&message);
        let mut rejects = Vec::new();
        let sensed = message.sensed(received_at, &mut rejects);
        for Reject { at, reason, is_fatal } in rejects {
            if is_fatal {
                return Err(SourceError::Broken { origin: self.topics.name(role).to_owned(), reason });
            }
            self.synchronizer.skip(at, role, reason);
        }
        let mut sensed = match sensed {
            Some(sensed) => sensed,
            None => return Ok(()),
        };
        match &mut sensed {
            SensorMessage::Image(image) => {
                self.fit_camera(image)?;
                self.note_image(image.at, received_at);
            }
            SensorMessage::Transforms(transforms) => transforms.retain(|t| t.parent != MAP_FRAME),
            _ => {}
        }
        self.synchronizer.push(sensed);
        Ok(())
    }

    /// Makes the camera of the calibration that was given, once the size of the images is known.
    fn fit_camera(&mut self, image: &EncodedImage) -> Result<(), SourceError> {
        let Some((calibration, path)) = &self.calibration else { return Ok(()) };
        // An image that cannot be decoded is left out elsewhere.
        let Ok(pixels) = image.decode() else { return Ok(()) };
        let mut warnings = Vec::new();
        let camera =
            fit_calibration(calibration, (pixels.width(), pixels.height()), path, &mut warnings).map_err(
                |error| SourceError::Broken { origin: self.topics.image.clone(), reason: error.to_string() },
            )?;
        warnings.iter().for_each(|warning| self.host.notice(warning));
        self.given.camera = Some(camera);
        self.synchronizer.give(self.given.clone());
        self.calibration = None;
        Ok(())
    }

    /// Says once what is missing if images come but never become frames.
    fn mind_missing(&mut self) {
        let now = self.host.now();
        if self.waiting_since.is_none_or(|since| now.secs_since(since) < NO_FRAME_SECS) {
            return;
        }
        self.waiting_since = None;
        let skipped = self.synchronizer.skipped().iter().rfind(|skipped| skipped.origin == self.topics.image);
        let reason = skipped
            .map_or("expected a calibration, and tf or positions of joints", |skipped| &skipped.reason);
        let notice = format!("{}: images come, but none can be used: {reason}", self.topics.image);
        self.host.notice(&notice);
    }

    /// Follows the publisher's clock; one that jumps back begins a new recording.
    fn note_image(&mut self, at: Timestamp, received_at: Timestamp) {
        if !self.vigil.has_images() {
            self.waiting_since = Some(received_at);
        }
        self.vigil.image_came(received_at, &self.host);
        if self.arrivals.len() == MAX_ARRIVALS {
            self.arrivals.pop_front();
        }
        self.arrivals.push_back((at, received_at));
        let back_secs = self.newest_image_at.map_or(0.0, |newest| newest.secs_since(at));
        if self.vigil.began_anew(back_secs, &self.host) {
            self.synchronizer.restart();
            self.newest_image_at = Some(at);
        } else {
            self.newest_image_at = self.newest_image_at.max(Some(at));
        }
    }

    /// A frame if one is complete: the newest.
    fn pop(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        self.num_stale += self.synchronizer.drop_stale();
        match self.synchronizer.pop()? {
            SyncOutcome::Frame(frame) => {
                self.waiting_since = None;
                let at = frame.source_frame.frame.at;
                self.received_at =
                    self.arrivals.iter().find(|(stamp, _)| *stamp == at).map(|(_, came)| *came);
                Some(Ok(frame.source_frame))
            }
            SyncOutcome::Unusable(reason) => {
                Some(Err(SourceError::Broken { origin: self.topics.image.clone(), reason }))
            }
        }
    }

    fn next(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        let mut wait = Duration::ZERO;
        while !self.host.is_stopped() {
            let received = match self.receiver.inbox.take_all(wait) {
                Ok(received) => received,
                Err(reason) => {
                    return Some(Err(SourceError::Broken { origin: self.topics.image.clone(), reason }));
                }
            };
            let is_silent = received.is_empty();
            for received in received {
                if let Err(error) = self.accept(received) {
                    return Some(Err(error));
                }
            }
            self.synchronizer.expect(self.heard.expected(self.host.now()));
            if let Some(frame) = self.pop() {
                return Some(frame);
            }
            self.mind_missing();
            if is_silent
                && self.vigil.is_pause(&self.host)
                && let Err(error) = self.receiver.keep_joined(&self.host)
            {
                let origin = self.topics.image.clone();
                return Some(Err(SourceError::Broken { origin, reason: error.to_string() }));
            }
            if is_silent && self.vigil.is_over(&self.host, || self.receiver.node.topics()) {
                return self.last_words();
            }
            wait = WAIT;
        }
        None
    }

    /// At the end: whether there was anything at all.
    fn last_words(&self) -> Option<Result<SourceFrame, SourceError>> {
        if self.received_at.is_some() {
            return None;
        }
        let origin = self.topics.image.clone();
        let first = self.synchronizer.skipped().iter().find(|skipped| skipped.origin == origin);
        let reason = match first {
            Some(first) => format!("no image could be used; the first: {}", first.reason),
            None if self.vigil.has_images() => {
                "images came, but never with calibration and tf (or joints)".into()
            }
            None => self.vigil.why_silent(self.vigil.patience_secs(), &self.receiver.node.topics()),
        };
        Some(Err(SourceError::Broken { origin, reason }))
    }
}

impl Source<SourceFrame> for LiveFrames {
    fn next_item(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        if self.is_done {
            return None;
        }
        let next = self.next();
        self.is_done = !matches!(next, Some(Ok(_)));
        if self.is_done {
            self.vigil.end(self.num_lost, &self.host);
        }
        next
    }

    fn status(&self) -> SourceStatus<'_> {
        SourceStatus {
            num_items: None,
            skipped: self.synchronizer.skipped(),
            num_dropped: self.num_stale + self.receiver.inbox.num_dropped(),
            received_at: self.received_at,
        }
    }
}

impl Heard {
    fn note(&mut self, message: &RosMessage, at: Timestamp) {
        match message {
            RosMessage::Odometry(_) => self.odometry = Some(at),
            RosMessage::Imu(_) => self.imu = Some(at),
            RosMessage::FootContact(_) => self.foot_contact = Some(at),
            RosMessage::FootPressure(_) => self.foot_pressure = Some(at),
            RosMessage::GroundTruth(_) => self.truth = Some(at),
            _ => {}
        }
    }

    /// The topics that an image waits for: those that were heard a moment ago.
    fn expected(&self, now: Timestamp) -> ExpectedInputs {
        let is_heard = |at: Option<Timestamp>| at.is_some_and(|at| now.secs_since(at) < SILENT_SECS);
        ExpectedInputs {
            has_odometry: is_heard(self.odometry),
            has_imu: is_heard(self.imu),
            has_foot_contact: is_heard(self.foot_contact),
            has_foot_pressure: is_heard(self.foot_pressure),
            has_truth: is_heard(self.truth),
        }
    }
}

fn role_of(message: &RosMessage) -> TopicRole {
    match message {
        RosMessage::CompressedImage(_) | RosMessage::Image(_) => TopicRole::Image,
        RosMessage::CameraInfo(_) => TopicRole::CameraInfo,
        RosMessage::Odometry(_) => TopicRole::Odometry,
        RosMessage::Tf(_) => TopicRole::Tf,
        RosMessage::TfStatic(_) => TopicRole::TfStatic,
        RosMessage::JointStates(_) => TopicRole::JointStates,
        RosMessage::RobotDescription(_) => TopicRole::RobotDescription,
        RosMessage::Imu(_) => TopicRole::Imu,
        RosMessage::FootContact(_) => TopicRole::FootContact,
        RosMessage::FootPressure(_) => TopicRole::FootPressure,
        RosMessage::GroundTruth(_) => TopicRole::GroundTruth,
    }
}
