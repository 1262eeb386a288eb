//! The thread that receives.

use std::{
    collections::HashMap,
    path::PathBuf,
    sync::Arc,
    thread::{self, JoinHandle},
    time::Duration,
};

use futures::{
    StreamExt,
    channel::oneshot,
    executor::block_on,
    future::{self, Either},
    stream::{self, LocalBoxStream},
};
use ros2_client::{Gid, MessageInfo, ReadError, Subscription};
use serde::de::DeserializeOwned;
use visloc_core::{
    Host,
    geom::{CameraFrame, Rigid3, Robot},
};

use crate::{
    bag::{BagTopics, ImageQos, RosMessage, TopicRole},
    ros2::{
        Node, NodeSettings, Ros2Error,
        inbox::{Inbox, Received},
        node::{Delivery, Watch},
    },
    sequence::Calibration,
    urdf::RobotDescription,
};

/// How long it is looked for who publishes the images, to learn their type.
const TYPE_SEARCH: Duration = Duration::from_millis(1500);
const TYPE_SEARCH_STEP: Duration = Duration::from_millis(50);

/// Which topics are received, and how long silence is borne.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveSettings {
    /// The node.
    pub node: NodeSettings,
    /// Names of topics and frames; empty names are not subscribed to.
    pub topics: BagTopics,
    /// If no image comes for so long, that is the end, seconds. `None` waits on.
    pub patience_secs: Option<f64>,
    /// How images are asked for.
    pub image_qos: ImageQos,
    /// How long a picture may wait while those before it are worked on, seconds; with 0 only the newest counts.
    pub backlog_secs: f64,
    /// Calibration that wins over the topic's, and its file.
    pub calibration: Option<(Calibration, PathBuf)>,
    /// The camera's pose on the robot, over what tf says.
    pub robot_from_camera: Option<Rigid3<Robot, CameraFrame>>,
    /// Which joints the robot has, over what is published.
    pub robot: Option<Arc<RobotDescription>>,
}

impl LiveSettings {
    /// All usual names, no end, and nothing that is known over the messages.
    #[must_use]
    pub fn new(node: NodeSettings) -> Self {
        Self {
            node,
            topics: BagTopics::default(),
            patience_secs: None,
            image_qos: ImageQos::default(),
            backlog_secs: 0.0,
            calibration: None,
            robot_from_camera: None,
            robot: None,
        }
    }
}

/// Subscriptions that fill an inbox. Dropping it ends the thread.
pub(crate) struct Receiver {
    settings: LiveSettings,
    roles: Vec<TopicRole>,
    watch: Watch,
    pub inbox: Arc<Inbox>,
    pub node: Node,
    pub image_type: &'static str,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Receiver {
    /// Subscribes to the topics of some roles.
    pub(crate) fn start(
        settings: &LiveSettings,
        roles: &[TopicRole],
        host: &Host,
    ) -> Result<Self, Ros2Error> {
        Self::fill(Arc::default(), None, settings, roles, host)
    }

    /// The type of the images is looked for unless it is known.
    fn fill(
        inbox: Arc<Inbox>,
        known_type: Option<&'static str>,
        settings: &LiveSettings,
        roles: &[TopicRole],
        host: &Host,
    ) -> Result<Self, Ros2Error> {
        let mut node = Node::join(&settings.node)?;
        let image_type = known_type.unwrap_or_else(|| image_type(&node, &settings.topics.image));
        let mut subscriptions = Vec::new();
        for role in roles.iter().filter(|role| !settings.topics.name(**role).is_empty()) {
            let image = (image_type, settings.image_qos);
            subscriptions.push(subscribe(&mut node, settings.topics.name(*role), *role, image)?);
        }
        let (stop, stopped) = oneshot::channel();
        let (to, host) = (Arc::clone(&inbox), host.clone());
        let thread = thread::spawn(move || {
            let streams = subscriptions.iter().map(|feed| feed.stream(&host));
            let all = stream::select_all(streams).for_each(|received| {
                received.into_iter().for_each(|received| to.put(received));
                future::ready(())
            });
            if let Either::Left(_) = block_on(future::select(all, stopped)) {
                to.fail("the subscriptions have ended".into());
            }
        });
        Ok(Self {
            settings: settings.clone(),
            roles: roles.to_vec(),
            watch: Watch::default(),
            inbox,
            node,
            image_type,
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Subscribes anew if the network was left. To be called again and again while nothing comes.
    pub(crate) fn keep_joined(&mut self, host: &Host) -> Result<(), Ros2Error> {
        if self.watch.sees_that_left(&self.node) {
            host.notice("the network of ROS 2 was left while this program was stopped; it is joined again");
            let (inbox, known) = (Arc::clone(&self.inbox), Some(self.image_type));
            *self = Self::fill(inbox, known, &self.settings, &self.roles, host)?;
        }
        Ok(())
    }
}

impl Drop for Receiver {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The type of the images: what is published, or what the name says.
fn image_type(node: &Node, topic: &str) -> &'static str {
    let types = TopicRole::Image.type_names();
    let mut waited = Duration::ZERO;
    while waited < TYPE_SEARCH {
        let published = node.topics().into_iter().filter(|live| live.topic == topic);
        let known = published.filter_map(|live| types.iter().copied().find(|name| *name == live.type_name));
        if let Some(type_name) = known.max() {
            return type_name;
        }
        thread::sleep(TYPE_SEARCH_STEP);
        waited += TYPE_SEARCH_STEP;
    }
    if topic.ends_with("compressed") { types[0] } else { types[1] }
}

/// A subscription to messages of some type.
trait Feed: Send {
    /// The messages as they come, with those that were lost between.
    fn stream<'a>(&'a self, host: &'a Host) -> LocalBoxStream<'a, Vec<Received>>;
}

struct FeedOf<M> {
    subscription: Subscription<M>,
    wrap: fn(M) -> RosMessage,
}

impl<M: DeserializeOwned + Send + 'static> Feed for FeedOf<M> {
    fn stream<'a>(&'a self, host: &'a Host) -> LocalBoxStream<'a, Vec<Received>> {
        let mut numbers = Numbers::default();
        let receive = move |result: Result<(M, MessageInfo), ReadError>| match result {
            Ok((message, info)) => {
                let message = (self.wrap)(message);
                let num_lost = match &message {
                    RosMessage::Image(_) | RosMessage::CompressedImage(_) => numbers.gap_before(&info),
                    _ => 0,
                };
                let lost = (num_lost > 0).then_some(Received::Lost(num_lost));
                lost.into_iter().chain([Received::Message(host.now(), message)]).collect()
            }
            Err(error) => vec![Received::Unreadable(error.to_string())],
        };
        self.subscription.async_stream().map(receive).boxed_local()
    }
}

fn feed<M: DeserializeOwned + Send + 'static>(
    node: &mut Node,
    (topic, type_name): (&str, &str),
    delivery: Delivery,
    wrap: fn(M) -> RosMessage,
) -> Result<Box<dyn Feed>, Ros2Error> {
    let subscription = node.subscribe(topic, type_name, delivery)?;
    Ok(Box::new(FeedOf { subscription, wrap }))
}

fn subscribe(
    node: &mut Node,
    topic: &str,
    role: TopicRole,
    (image_type, image_qos): (&'static str, ImageQos),
) -> Result<Box<dyn Feed>, Ros2Error> {
    let newest = Delivery::Newest;
    let images = match image_qos {
        ImageQos::BestEffort => newest,
        ImageQos::Reliable => Delivery::Reliable,
    };
    let at = (topic, role.type_names()[0]);
    match role {
        TopicRole::Image if image_type == at.1 => feed(node, at, images, RosMessage::CompressedImage),
        TopicRole::Image => feed(node, (topic, image_type), images, RosMessage::Image),
        TopicRole::CameraInfo => feed(node, at, newest, RosMessage::CameraInfo),
        TopicRole::Odometry => feed(node, at, newest, RosMessage::Odometry),
        // As tf2 does. Besides, this program also publishes on the topic: as long as a reader confirms nothing, the writer of
        // `rustdds` keeps thousands of messages for it.
        TopicRole::Tf => feed(node, at, Delivery::Reliable, RosMessage::Tf),
        TopicRole::TfStatic => feed(node, at, Delivery::Latched, RosMessage::TfStatic),
        TopicRole::JointStates => feed(node, at, newest, RosMessage::JointStates),
        TopicRole::RobotDescription => feed(node, at, Delivery::Kept, RosMessage::RobotDescription),
        TopicRole::Imu => feed(node, at, newest, RosMessage::Imu),
        TopicRole::FootContact => feed(node, at, newest, RosMessage::FootContact),
        TopicRole::FootPressure => feed(node, at, newest, RosMessage::FootPressure),
        TopicRole::GroundTruth => feed(node, at, newest, RosMessage::GroundTruth),
    }
}

/// The numbers that publishers give to their messages.
#[derive(Default)]
struct Numbers {
    last: HashMap<Gid, i64>,
}

impl Numbers {
    /// How many messages of the same publisher are missing before this one.
    fn gap_before(&mut self, info: &MessageInfo) -> u64 {
        let number = info.sequence_number();
        let last = self.last.insert(info.publisher_gid(), number);
        last.map_or(0, |last| u64::try_from(number - last - 1).unwrap_or(0))
    }
}
