//! A part of a recording with all its messages.

use std::collections::BTreeMap;

use visloc_core::Timestamp;
use visloc_io::{
    bag::{BagMessage, TopicRole},
    sequence::{InRange, RangeJudge, SequenceRange},
};

/// Chooses messages by when they were recorded, against the images of the topic that shows the first one. What was said before the part
/// and holds in it is copied with it: static transforms, and the last message of every topic that is no image.
pub struct Cut {
    judge: RangeJudge,
    topic_of_images: Option<String>,
    static_transforms: Vec<BagMessage>,
    last: BTreeMap<String, BagMessage>,
}

/// What becomes of a message.
pub enum Verdict {
    /// These are copied, in this order: the message, and before it what holds since earlier.
    Take(Vec<BagMessage>),
    /// It lies before the part.
    Wait,
    /// The part is over.
    End,
}

impl Cut {
    pub fn new(range: SequenceRange) -> Self {
        Self {
            judge: RangeJudge::new(range),
            topic_of_images: None,
            static_transforms: Vec::new(),
            last: BTreeMap::new(),
        }
    }

    /// Why a recording that was read to its end does not have the part, as the end of a sentence; `None` if it has it.
    pub fn why_none(&self) -> Option<String> {
        let has_images = self.topic_of_images.is_some();
        if self.judge.has_begun() && (has_images || self.judge.range() == SequenceRange::default()) {
            return None;
        }
        Some(match self.judge.span_secs() {
            None => "expected images, from which --from, --until and --frames count, found none".into(),
            Some(_) if self.judge.has_ended() => {
                "no image in the range that was asked for: it ends before it begins".into()
            }
            Some(secs) => format!(
                "no image in the range that was asked for: the source has {} images, {secs:.1} s long",
                self.judge.num_seen()
            ),
        })
    }

    pub fn judge(&mut self, message: BagMessage) -> Verdict {
        let is_image = has_role(&message, TopicRole::Image);
        let topic = &message.channel.topic;
        if is_image && self.topic_of_images.is_none() {
            self.topic_of_images = Some(topic.clone());
        }
        let is_counted = is_image && self.topic_of_images.as_ref() == Some(topic);
        let at = Timestamp::from_nanos(i64::try_from(message.log_nanos).unwrap_or(i64::MAX));
        let had_begun = self.judge.has_begun();
        match if is_counted { self.judge.of_image(at) } else { self.judge.of_other(at) } {
            InRange::Behind => Verdict::End,
            InRange::Before => {
                self.keep(message, is_image);
                Verdict::Wait
            }
            InRange::Taken | InRange::Between => {
                let mut taken = if had_begun { Vec::new() } else { self.kept() };
                taken.push(message);
                Verdict::Take(taken)
            }
        }
    }

    fn keep(&mut self, message: BagMessage, is_image: bool) {
        let topic = &message.channel.topic;
        if has_role(&message, TopicRole::TfStatic) && topic.ends_with("static") {
            self.static_transforms.push(message);
        } else if let Some(last) = self.last.get_mut(topic) {
            *last = message;
        } else if !is_image {
            self.last.insert(topic.clone(), message);
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

    use visloc_io::{bag::Channel, sequence::Bound};

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
            match cut.judge(message) {
                Verdict::Take(taken) => copied.extend(taken),
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
