//! A node in the network of ROS 2.

use std::sync::{Arc, Mutex, PoisonError};

use ros2_client::{
    Context, ContextOptions, Message, MessageTypeName, Name, NodeName, NodeOptions, Publisher, QosProfile,
    Server, ServiceMapping, ServiceTypeName, Subscription,
    qos::{Durability, History, WhenFull},
};
use serde::Serialize;

use crate::ros2::{Middleware, Ros2Error};

/// How a node appears.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeSettings {
    /// Nodes of different domains do not see each other; 0 unless set.
    pub domain_id: u16,
    /// Name of the node.
    pub name: String,
}

/// A topic that somebody publishes or subscribes to.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct LiveTopic {
    /// Name.
    pub topic: String,
    /// Type, for instance `sensor_msgs/msg/Image`.
    pub type_name: String,
}

/// So many calls apart it is asked whether the network was left.
const CALLS_BETWEEN: u32 = 32;

/// The network of ROS 2 as a program takes part in it. Its clones are one participant, whose nodes share connections and threads; it
/// leaves with the last of them.
#[derive(Clone)]
pub struct Network {
    domain_id: u16,
    context: Arc<Mutex<Option<Context>>>,
}

visloc_core::debug_shows!([] Network { domain_id });

impl Network {
    /// A participant of a domain, which joins with its first node.
    #[must_use]
    pub fn new(domain_id: u16) -> Self {
        Self { domain_id, context: Arc::default() }
    }

    /// The participant, joined anew if it has left.
    fn context(&self) -> Result<Context, Ros2Error> {
        let mut current = self.context.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(context) = current.as_ref().filter(|context| !has_left(context)) {
            return Ok(context.clone());
        }
        let options = ContextOptions::new().domain_id(self.domain_id);
        let context = Context::with_options(options).map_err(|error| self.error(error.to_string()))?;
        *current = Some(context.clone());
        Ok(context)
    }

    fn error(&self, reason: String) -> Ros2Error {
        Ros2Error::Join { domain_id: self.domain_id, reason }
    }
}

/// Whether the network was left without being asked: the threads of `rustdds` end when the process is stopped and goes on (Ctrl-Z, a
/// debugger), since that interrupts what they wait for.
fn has_left(context: &Context) -> bool {
    context.domain_participant().assert_liveliness().is_err()
}

/// A node in the network of ROS 2. It leaves when it is dropped.
pub struct Node {
    network: Network,
    context: Context,
    node: ros2_client::Node,
}

visloc_core::debug_shows!([] Node { network });

/// How messages are sent and kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Delivery {
    /// Sensors: the newest counts. Fits publishers of both kinds.
    Newest,
    /// None is lost while both sides are there.
    Reliable,
    /// As reliable, but only the last one counts.
    Last,
    /// As the last one, and who comes later gets it.
    Kept,
    /// As reliable, and who comes later gets the last ones. Not for topics that go on and on: while nobody listens, the writer of
    /// `rustdds` keeps thousands of such messages.
    Latched,
}

impl Delivery {
    fn profile(self) -> QosProfile {
        let depth = match self {
            Self::Newest => 32,
            Self::Reliable => 32,
            Self::Last | Self::Kept => 1,
            Self::Latched => 100,
        };
        let profile = QosProfile::subscription_default().history(History::KeepLast { depth });
        match self {
            Self::Newest => profile,
            // A slow subscriber must not hold up the localization.
            Self::Reliable | Self::Last => profile.reliability_reliable(WhenFull::Fail),
            Self::Latched | Self::Kept => {
                profile.reliability_reliable(WhenFull::Fail).durability(Durability::TransientLocal)
            }
        }
    }
}

impl Node {
    /// Joins the network as a participant of its own.
    ///
    /// # Errors
    /// If there is no network, or the name is none.
    pub fn join(settings: &NodeSettings) -> Result<Self, Ros2Error> {
        Self::join_in(&Network::new(settings.domain_id), &settings.name)
    }

    /// Joins the network beside other nodes of this program.
    ///
    /// # Errors
    /// If there is no network, or the name is none.
    pub fn join_in(network: &Network, name: &str) -> Result<Self, Ros2Error> {
        let node_name = NodeName::new("/", name)
            .map_err(|error| Ros2Error::Name { name: name.to_owned(), reason: format!("{error:?}") })?;
        let context = network.context()?;
        let options = NodeOptions::new().enable_rosout(false);
        let node = context.new_node(node_name, options).map_err(|error| network.error(error.to_string()))?;
        Ok(Self { network: network.clone(), context, node })
    }

    /// Where other nodes of this program may join as well.
    #[must_use]
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// All topics that were seen so far, sorted.
    #[must_use]
    pub fn topics(&self) -> Vec<LiveTopic> {
        let topics = self.context.discovered_topics().into_iter();
        let mut topics: Vec<LiveTopic> = topics
            .filter_map(|topic| {
                let name = topic.name.strip_prefix("rt")?.to_owned();
                Some(LiveTopic { topic: name, type_name: ros_type_name(&topic.type_name) })
            })
            .collect();
        topics.sort();
        topics.dedup();
        topics
    }

    pub(crate) fn subscribe<M: 'static>(
        &mut self,
        topic: &str,
        type_name: &str,
        delivery: Delivery,
    ) -> Result<Subscription<M>, Ros2Error> {
        let profile = delivery.profile();
        let dds_topic = self.topic(topic, type_name, &profile)?;
        let subscription = self.node.create_subscription(&dds_topic, Some(profile));
        subscription.map_err(|error| topic_error(topic, type_name, error.to_string()))
    }

    pub(crate) fn advertise<M: Serialize>(
        &mut self,
        topic: &str,
        type_name: &str,
        delivery: Delivery,
    ) -> Result<Publisher<M>, Ros2Error> {
        let profile = delivery.profile();
        let dds_topic = self.topic(topic, type_name, &profile)?;
        let publisher = self.node.create_publisher(&dds_topic, Some(profile));
        publisher.map_err(|error| topic_error(topic, type_name, error.to_string()))
    }

    /// Answers requests; they and the answers are reliable, as usual in ROS.
    pub(crate) fn serve<Request: Message + Clone + 'static, Answer: Message + 'static>(
        &mut self,
        service: &str,
        type_name: &str,
        middleware: Middleware,
    ) -> Result<Server<Request, Answer>, Ros2Error> {
        let name = Name::parse(service)
            .map_err(|error| Ros2Error::Name { name: service.to_owned(), reason: format!("{error:?}") })?;
        let (package, kind) = type_name.split_once("/srv/").unwrap_or(("", type_name));
        let mapping = match middleware {
            Middleware::FastDds => ServiceMapping::Enhanced,
            Middleware::CycloneDds => ServiceMapping::Cyclone,
        };
        let profile = Delivery::Reliable.profile();
        let kind = ServiceTypeName::new(package, kind);
        let server = self.node.create_server(mapping, &name, &kind, profile.clone(), profile);
        server.map_err(|error| topic_error(service, type_name, error.to_string()))
    }

    fn topic(
        &self,
        topic: &str,
        type_name: &str,
        profile: &QosProfile,
    ) -> Result<ros2_client::dds::rustdds::Topic, Ros2Error> {
        let name = Name::parse(topic)
            .map_err(|error| Ros2Error::Name { name: topic.to_owned(), reason: format!("{error:?}") })?;
        let (package, message) = type_name.split_once("/msg/").unwrap_or(("", type_name));
        let message_type = MessageTypeName::new(package, message);
        self.node
            .create_topic(&name, message_type, profile)
            .map_err(|error| topic_error(topic, type_name, error.to_string()))
    }
}

/// Asks now and then whether the network was left: the question costs more than most calls.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    num_calls: u32,
}

impl Watch {
    pub(crate) fn sees_that_left(&mut self, node: &Node) -> bool {
        self.num_calls = (self.num_calls + 1) % CALLS_BETWEEN;
        self.num_calls == 0 && has_left(&node.context)
    }
}

fn topic_error(topic: &str, type_name: &str, reason: String) -> Ros2Error {
    Ros2Error::Topic { topic: topic.to_owned(), type_name: type_name.to_owned(), reason }
}

/// `sensor_msgs::msg::dds_::Image_` as `sensor_msgs/msg/Image`.
fn ros_type_name(dds_name: &str) -> String {
    let plain = dds_name.replace("::dds_::", "/").replace("::", "/");
    plain.strip_suffix('_').unwrap_or(&plain).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_types() {
        assert_eq!(ros_type_name("sensor_msgs::msg::dds_::Image_"), "sensor_msgs/msg/Image");
        assert_eq!(ros_type_name("HelloWorld"), "HelloWorld");
    }
}
