//! Pictures of a running camera.

use std::time::Duration;

use visloc_core::{Host, Picture, SkippedInput, Source, SourceError, SourceStatus, Timestamp, geom::Camera};

use crate::{
    backlog::Backlog,
    bag::{BagTopics, EncodedImage, MAX_SKIPPED, RosMessage, SensorMessage, TopicRole, camera_of},
    ros2::{
        LiveSettings, Ros2Error,
        inbox::Received,
        receive::Receiver,
        vigil::{Vigil, WAIT},
    },
};

/// How long a calibration is waited for once there are images, seconds.
const CAMERA_WAIT_SECS: f64 = 3.0;

/// Images of a topic, with the calibration beside them; kinematics and odometry are not needed.
pub struct LivePictures {
    receiver: Receiver,
    topics: BagTopics,
    host: Host,
    vigil: Vigil,
    camera: Option<Camera>,
    backlog: Backlog<EncodedImage>,
    last_at: Option<Timestamp>,
    num_lost: u64,
    skipped: Vec<SkippedInput>,
    is_done: bool,
}

visloc_core::debug_shows!([] LivePictures { topics, camera, last_at, num_lost });

impl LivePictures {
    /// Subscribes to images and calibration.
    ///
    /// # Errors
    /// If there is no network, or a name is wrong.
    pub fn open(settings: &LiveSettings, host: &Host) -> Result<Self, Ros2Error> {
        let receiver = Receiver::start(settings, &[TopicRole::Image, TopicRole::CameraInfo], host)?;
        let topics = settings.topics.clone();
        Ok(Self {
            vigil: Vigil::new(&topics.image, receiver.image_type, settings.patience_secs, host.now()),
            receiver,
            topics,
            host: host.clone(),
            camera: None,
            backlog: Backlog::new(settings.backlog_secs),
            last_at: None,
            num_lost: 0,
            skipped: Vec::new(),
            is_done: false,
        })
    }

    /// Waits for the calibration: with patience for the first image, and a moment longer.
    ///
    /// # Errors
    /// If the messages end or nothing comes.
    pub fn wait_for_camera(&mut self) -> Result<Option<Camera>, Ros2Error> {
        let mut first_image_at = None;
        while self.camera.is_none() && !self.host.is_stopped() {
            let is_silent = self.listen(WAIT).map_err(|error| Ros2Error::Silence(error.to_string()))?;
            let now = self.host.now();
            if !self.backlog.is_empty() {
                let since = now.secs_since(*first_image_at.get_or_insert(now));
                if since > CAMERA_WAIT_SECS {
                    break;
                }
            }
            if is_silent && self.vigil.is_over(&self.host, || self.receiver.node.topics()) {
                let why = self.vigil.why_silent(self.vigil.patience_secs(), &self.receiver.node.topics());
                return Err(Ros2Error::Silence(format!("{}: {why}", self.topics.image)));
            }
        }
        Ok(self.camera)
    }

    /// Takes in what has come. Whether that is nothing.
    fn listen(&mut self, wait: Duration) -> Result<bool, SourceError> {
        let broken = |reason: String| SourceError::Broken { origin: self.topics.image.clone(), reason };
        let received = self.receiver.inbox.take_all(wait).map_err(broken)?;
        let is_silent = received.is_empty();
        if is_silent && self.vigil.is_pause(&self.host) {
            self.receiver.keep_joined(&self.host).map_err(|error| broken(error.to_string()))?;
        }
        for received in received {
            match received {
                Received::Message(at, message) => self.accept(at, message),
                Received::Lost(number) => self.num_lost += number,
                Received::Unreadable(reason) => self.skip(None, reason),
            }
        }
        Ok(is_silent)
    }

    fn accept(&mut self, received_at: Timestamp, message: RosMessage) {
        if let RosMessage::CameraInfo(info) = &message {
            match camera_of(info) {
                Ok((_, camera)) => self.camera = Some(camera),
                Err(reject) if self.camera.is_none() && self.skipped.is_empty() => {
                    let origin = self.topics.camera_info.clone();
                    self.skipped.push(SkippedInput { at: reject.at, origin, reason: reject.reason });
                }
                Err(_) => {}
            }
            return;
        }
        let Some(SensorMessage::Image(image)) = message.sensed(received_at, &mut Vec::new()) else { return };
        self.vigil.image_came(received_at, &self.host);
        let back_secs = self.last_at.map_or(0.0, |last| last.secs_since(image.at));
        if self.vigil.began_anew(back_secs, &self.host) {
            self.last_at = None;
        }
        self.backlog.put(received_at, image);
    }

    fn skip(&mut self, at: Option<Timestamp>, reason: String) {
        if self.skipped.len() < MAX_SKIPPED {
            self.skipped.push(SkippedInput { at, origin: self.topics.image.clone(), reason });
        }
    }

    fn next(&mut self) -> Option<Result<Picture, SourceError>> {
        let mut wait = Duration::ZERO;
        while !self.host.is_stopped() {
            let is_silent = match self.listen(wait) {
                Ok(is_silent) => is_silent,
                Err(error) => return Some(Err(error)),
            };
            if let Some((_, image)) = self.backlog.take() {
                if let Some(last) = self.last_at.filter(|last| *last >= image.at) {
                    let reason = format!("expected an image later than {last}, found one at {}", image.at);
                    self.skip(Some(image.at), reason);
                    continue;
                }
                self.last_at = Some(image.at);
                match image.decode() {
                    Ok(pixels) => return Some(Ok(Picture { at: image.at, image: pixels, file: None })),
                    Err(reason) => self.skip(Some(image.at), reason),
                }
            }
            if is_silent && self.vigil.is_over(&self.host, || self.receiver.node.topics()) {
                return None;
            }
            wait = WAIT;
        }
        None
    }
}

impl Source<Picture> for LivePictures {
    fn next_item(&mut self) -> Option<Result<Picture, SourceError>> {
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
        let num_dropped = self.backlog.num_dropped() + self.receiver.inbox.num_dropped();
        SourceStatus { skipped: &self.skipped, num_dropped, ..SourceStatus::default() }
    }
}
