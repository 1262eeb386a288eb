//! The topics of a team.

use ros2_client::{Publisher, Subscription};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::ros2::{
    Network, Node, Ros2Error,
    node::{Delivery, Watch},
};

/// Most messages that are taken at a time.
const MAX_TAKEN: usize = 256;

/// Says what the own robot knows, and hears the others and the own detectors. `M` is a team message and `S` what a detector sees.
pub struct TeamLink<M: Serialize, S> {
    publisher: Publisher<M>,
    messages: Subscription<M>,
    sightings: Subscription<S>,
    num_failed: usize,
    num_damaged: usize,
    name: String,
    member: (String, u8),
    watch: Watch,
    /// Leaves the network last.
    node: Node,
}

visloc_core::debug_shows!([M: Serialize, S] TeamLink<M, S> { name, member, num_failed, num_damaged });

impl<M: Serialize + DeserializeOwned + 'static, S: DeserializeOwned + 'static> TeamLink<M, S> {
    /// Joins the topics of a team, `/visloc/team/NAME/messages` and `/visloc/team/NAME/robot_N/sightings`, as a node of this name.
    ///
    /// # Errors
    /// If there is no network, or the name of the team is no part of a topic's name.
    pub fn open(network: &Network, name: &str, team: &str, number: u8) -> Result<Self, Ros2Error> {
        let mut node = Node::join_in(network, name)?;
        let messages = format!("/visloc/team/{team}/messages");
        let sightings = format!("/visloc/team/{team}/robot_{number}/sightings");
        let (message_type, sightings_type) = ("visloc_msgs/msg/TeamMessage", "visloc_msgs/msg/Sightings");
        Ok(Self {
            // Of old messages only the newest is of use, and who is slow must hold up nobody.
            publisher: node.advertise(&messages, message_type, Delivery::Newest)?,
            messages: node.subscribe(&messages, message_type, Delivery::Newest)?,
            sightings: node.subscribe(&sightings, sightings_type, Delivery::Newest)?,
            num_failed: 0,
            num_damaged: 0,
            name: name.to_owned(),
            member: (team.to_owned(), number),
            watch: Watch::default(),
            node,
        })
    }

    /// Joins anew if the network was left.
    fn keep_joined(&mut self) {
        let (team, number) = &self.member;
        if self.watch.sees_that_left(&self.node)
            && let Ok(anew) = Self::open(self.node.network(), &self.name, team, *number)
        {
            *self = Self { num_failed: self.num_failed, num_damaged: self.num_damaged, ..anew };
        }
    }

    /// Tells the others.
    pub fn publish(&mut self, message: M) {
        self.num_failed += usize::from(self.publisher.publish(message).is_err());
    }

    /// What has come since the last time, the own messages among it. Nothing is waited for.
    pub fn messages(&mut self) -> Vec<M> {
        self.keep_joined();
        take(&self.messages, &mut self.num_damaged)
    }

    /// What the detectors have seen since the last time.
    pub fn sightings(&mut self) -> Vec<S> {
        take(&self.sightings, &mut self.num_damaged)
    }

    /// Messages that could not be sent, and those that came and could not be read.
    #[must_use]
    pub fn num_failed(&self) -> (usize, usize) {
        (self.num_failed, self.num_damaged)
    }
}

fn take<T: DeserializeOwned + 'static>(subscription: &Subscription<T>, num_damaged: &mut usize) -> Vec<T> {
    let mut taken = Vec::new();
    for _ in 0..MAX_TAKEN {
        match subscription.take() {
            Ok(Some((message, _))) => taken.push(message),
            Ok(None) => break,
            Err(_) => *num_damaged += 1,
        }
    }
    taken
}
