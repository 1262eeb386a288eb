//! Silence, and what the user should hear of it.

use std::time::Duration;

use visloc_core::{Host, Timestamp};

use crate::ros2::LiveTopic;

/// A silence that the user hears of, seconds.
const SILENCE_SECS: f64 = 3.0;
/// Longest wait before it is looked again whether to stop.
pub(super) const WAIT: Duration = Duration::from_millis(50);
/// An image this far before the last one means that the publisher's clock was set back, or a recording began again, seconds.
const CLOCK_BACK_SECS: f64 = 1.0;
/// After such a silence it is worth asking whether the network is still there, seconds.
const PAUSE_SECS: f64 = 0.5;

/// Watches the images of a topic.
#[derive(Debug)]
pub(crate) struct Vigil {
    topic: String,
    type_name: &'static str,
    last_at: Timestamp,
    has_images: bool,
    has_spoken: bool,
    patience_secs: Option<f64>,
}

impl Vigil {
    pub(crate) fn new(
        topic: &str,
        type_name: &'static str,
        patience_secs: Option<f64>,
        now: Timestamp,
    ) -> Self {
        Self {
            topic: topic.to_owned(),
            type_name,
            last_at: now,
            has_images: false,
            has_spoken: false,
            patience_secs,
        }
    }

    /// An image came.
    pub(crate) fn image_came(&mut self, now: Timestamp, host: &Host) {
        if std::mem::take(&mut self.has_spoken) && self.has_images {
            host.notice(&format!("{}: images again after {:.1} s", self.topic, now.secs_since(self.last_at)));
        }
        self.has_images = true;
        self.last_at = now;
    }

    /// Whether the publisher began anew, which the user hears then: an image is so much older than the last one, seconds.
    pub(crate) fn began_anew(&self, back_secs: f64, host: &Host) -> bool {
        let is_anew = back_secs > CLOCK_BACK_SECS;
        if is_anew {
            host.notice(&format!(
                "{}: time went back by {back_secs:.1} s; its publisher began anew",
                self.topic
            ));
        }
        is_anew
    }

    /// The source has ended: so many images never came.
    pub(crate) fn end(&self, num_lost: u64, host: &Host) {
        if num_lost > 0 {
            host.notice(&format!("{}: {num_lost} images were lost on the way", self.topic));
        }
    }

    /// Nothing came. Whether that is the end.
    pub(crate) fn is_over(&mut self, host: &Host, topics: impl FnOnce() -> Vec<LiveTopic>) -> bool {
        let secs = host.now().secs_since(self.last_at);
        if self.patience_secs.is_some_and(|patience| secs > patience) {
            return true;
        }
        if secs > SILENCE_SECS && !self.has_spoken {
            self.has_spoken = true;
            host.notice(&format!("{}: {}", self.topic, self.why_silent(secs, &topics())));
        }
        false
    }

    /// Whether nothing has come for a moment.
    pub(crate) fn is_pause(&self, host: &Host) -> bool {
        host.now().secs_since(self.last_at) > PAUSE_SECS
    }

    /// How long silence is borne, seconds; 0 if for ever.
    pub(crate) fn patience_secs(&self) -> f64 {
        self.patience_secs.unwrap_or(0.0)
    }

    /// Whether any image has come.
    pub(crate) fn has_images(&self) -> bool {
        self.has_images
    }

    /// What may be the reason that nothing comes.
    pub(crate) fn why_silent(&self, secs: f64, topics: &[LiveTopic]) -> String {
        let Self { topic, type_name, .. } = self;
        if self.has_images {
            return format!("no image for {secs:.1} s; is its publisher still there?");
        }
        let others: Vec<&LiveTopic> = topics.iter().filter(|live| live.topic == *topic).collect();
        if let Some(other) = others.iter().find(|live| live.type_name != *type_name) {
            return format!("expected {type_name}, but {} is published there", other.type_name);
        }
        let is_image = |live: &&LiveTopic| {
            live.type_name.starts_with("sensor_msgs/msg/") && live.type_name.ends_with("Image")
        };
        let images: Vec<String> = topics
            .iter()
            .filter(is_image)
            .filter(|live| live.topic != *topic)
            .map(|live| format!("{} ({})", live.topic, live.type_name))
            .collect();
        let seen = match (images.is_empty(), topics.is_empty()) {
            (false, _) => format!("images are on {}", images.join(", ")),
            (true, false) => format!("no images on any of the {} topics seen", topics.len()),
            (true, true) => "no topics seen at all (other ROS_DOMAIN_ID or network?)".into(),
        };
        format!("no {type_name} for {secs:.1} s; {seen}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topic(topic: &str, type_name: &str) -> LiveTopic {
        LiveTopic { topic: topic.into(), type_name: type_name.into() }
    }

    #[test]
    fn reasons_for_silence() {
        let mut vigil = Vigil::new("/eye", "sensor_msgs/msg/Image", None, Timestamp::default());
        let why = |vigil: &Vigil, topics: &[LiveTopic]| vigil.why_silent(4.0, topics);
        assert!(why(&vigil, &[]).contains("ROS_DOMAIN_ID"));
        let scan = topic("/eye", "sensor_msgs/msg/LaserScan");
        assert!(
            why(&vigil, &[scan]).contains("expected sensor_msgs/msg/Image, but sensor_msgs/msg/LaserScan")
        );
        let camera = topic("/camera/image_raw", "sensor_msgs/msg/Image");
        let own = topic("/eye", "sensor_msgs/msg/Image");
        assert!(why(&vigil, &[own, camera]).contains("images are on /camera/image_raw"));
        vigil.image_came(Timestamp::from_secs(1.0), &Host::silent());
        assert!(why(&vigil, &[]).contains("still there?"));
    }

    #[test]
    fn patience_ends() {
        let host = Host::new(|| Timestamp::from_secs(5.0), |_| {});
        let mut vigil = Vigil::new("/eye", "sensor_msgs/msg/Image", Some(4.0), Timestamp::from_secs(2.0));
        assert!(!vigil.is_over(&host, Vec::new));
        let mut vigil = Vigil::new("/eye", "sensor_msgs/msg/Image", Some(2.0), Timestamp::from_secs(2.0));
        assert!(vigil.is_over(&host, Vec::new));
    }
}
