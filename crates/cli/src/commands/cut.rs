//! A part of a recording with all its messages.

use std::collections::BTreeMap;

use visloc_io::{
    bag::{BagMessage, TopicRole},
    sequence::{Bound, SequenceRange},
};

/// Chooses messages by when they were recorded, against the images of the topic that shows the first one. What was said before the part
/// and holds in it is copied with it: static transforms, and the last message of every topic that is no image.
pub struct Cut {
    range: SequenceRange,
    first: Option<Image>,
    num_images: usize,
    num_taken: usize,
    last_secs: f64,
    has_begun: bool,
    static_transforms: Vec<BagMessage>,
    last: BTreeMap<String, BagMessage>,
}

/// The first image.
struct Image {
    topic: String,
    log_nanos: u64,
}

/// What becomes of a message.
pub enum Verdict {
    /// It is copied, behind these.
    Take(Vec<BagMessage>),
    /// It lies before the part.
    Wait,
    /// The part is over.
    End,
}

impl Cut {
    pub fn new(range: SequenceRange) -> Self {
        Self {
            has_begun: matches!(range.start, Bound::Frame(0)) || range.start == Bound::Secs(0.0),
            range,
            first: None,
            num_images: 0,
            num_taken: 0,
            last_secs: 0.0,
            static_transforms: Vec::new(),
            last: BTreeMap::new(),
        }
    }

    /// Why a recording that was read to its end does not have the part, as the end of a sentence; `None` if it has it.
    pub fn why_none(&self) -> Option<String> {
        if self.has_begun && (self.first.is_some() || self.range == SequenceRange::default()) {
            return None;
        }
        Some(match self.num_images {
            0 => "expected images, from which --from, --until and --frames count, found none".into(),
            num => format!(
                "no image in the range that was asked for: the source has {num} images, {:.1} s long",
                self.last_secs
            ),
        })
    }

    pub fn judge(&mut self, message: &BagMessage) -> Verdict {
        let is_image = has_role(message, TopicRole::Image);
        if is_image && self.first.is_none() {
            let topic = message.channel.topic.clone();
            self.first = Some(Image { topic, log_nanos: message.log_nanos });
        }
        let is_counted = is_image && self.first.as_ref().is_some_and(|i| i.topic == message.channel.topic);
        let secs =
            self.first.as_ref().map(|first| (message.log_nanos as f64 - first.log_nanos as f64) * 1e-9);
        if let Some(secs) = secs.filter(|_| is_counted) {
            self.last_secs = secs;
        }
        let is_behind = |bound: Bound| match bound {
            Bound::Frame(frame) => is_counted && self.num_images >= frame,
            Bound::Secs(bound) => secs.is_some_and(|secs| secs >= bound),
        };
        let is_enough = is_counted && self.range.most.is_some_and(|most| self.num_taken >= most);
        if is_enough || self.range.end.is_some_and(is_behind) {
            return Verdict::End;
        }
        let begins = !self.has_begun && is_behind(self.range.start);
        self.has_begun |= begins;
        self.num_images += usize::from(is_counted);
        if !self.has_begun {
            self.keep(message, is_image);
            return Verdict::Wait;
        }
        self.num_taken += usize::from(is_counted);
        Verdict::Take(if begins { self.kept() } else { Vec::new() })
    }

    fn keep(&mut self, message: &BagMessage, is_image: bool) {
        let topic = &message.channel.topic;
        if has_role(message, TopicRole::TfStatic) && topic.ends_with("static") {
            self.static_transforms.push(message.clone());
        } else if !is_image {
            self.last.insert(topic.clone(), message.clone());
        }
    }

    fn kept(&mut self) -> Vec<BagMessage> {
        let mut kept = std::mem::take(&mut self.static_transforms);
        kept.extend(std::mem::take(&mut self.last).into_values());
        kept.sort_by_key(|message| message.log_nanos);
        kept
    }
}

fn has_role(message: &BagMessage, role: TopicRole) -> bool {
    role.type_names().contains(&message.channel.type_name.as_str())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use visloc_io::bag::Channel;

    use super::*;

    /// A recording of four seconds: transforms at its beginning, an image and odometry each second, between them another camera's.
    fn recording() -> Vec<BagMessage> {
        let message = |topic: &str, type_name: &str, half_secs: u64| BagMessage {
            channel: Arc::new(Channel {
                topic: topic.into(),
                type_name: type_name.into(),
                ..Channel::default()
            }),
            sequence: 0,
            log_nanos: half_secs * 500_000_000,
            publish_nanos: 0,
            data: Vec::new(),
        };
        let mut all = vec![message("/tf_static", "tf2_msgs/msg/TFMessage", 20)];
        all.push(message("/tf_static", "tf2_msgs/msg/TFMessage", 20));
        for at in (20..28).step_by(2) {
            all.push(message("/odom", "nav_msgs/msg/Odometry", at));
            all.push(message("/eye", "sensor_msgs/msg/Image", at));
            all.push(message("/other", "sensor_msgs/msg/CompressedImage", at + 1));
        }
        all
    }

    fn copied(start: Bound, end: Option<Bound>, most: Option<usize>) -> String {
        let mut cut = Cut::new(SequenceRange { start, end, most, ..SequenceRange::default() });
        let mut copied = Vec::new();
        for message in recording() {
            match cut.judge(&message) {
                Verdict::Take(before) => copied.extend(before.into_iter().chain([message])),
                Verdict::Wait => {}
                Verdict::End => break,
            }
        }
        let name = |m: &BagMessage| format!("{}{}", &m.channel.topic[1..3], m.log_nanos / 500_000_000);
        copied.iter().map(name).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_part_has_what_was_said_before_it() {
        let all = "tf20 tf20 od20 ey20 ot21 od22 ey22 ot23 od24 ey24 ot25 od26 ey26 ot27";
        assert_eq!(copied(Bound::Frame(0), None, None), all);
        let second = "tf20 tf20 od22 ey22 ot23 od24";
        assert_eq!(copied(Bound::Frame(1), Some(Bound::Frame(2)), None), second);
        assert_eq!(copied(Bound::Frame(1), None, Some(1)), second);
        let by_time = "tf20 tf20 od20 ot21 od22 ey22 ot23";
        assert_eq!(copied(Bound::Secs(0.5), Some(Bound::Secs(2.0)), None), by_time);
        assert_eq!(copied(Bound::Secs(9.0), None, None), "");
    }
}
