//! What can be wrong with live topics.

use thiserror::Error;

/// Why live topics cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Ros2Error {
    /// No node can be made.
    #[error("cannot join ROS 2 domain {domain_id}: {reason}")]
    Join {
        /// The domain.
        domain_id: u16,
        /// What the client says.
        reason: String,
    },
    /// A name is none of ROS 2.
    #[error("'{name}': expected the name of a topic, such as /camera/image_raw: {reason}")]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A topic cannot be subscribed to or published.
    #[error("topic '{topic}' ({type_name}): {reason}")]
    Topic {
        /// The topic.
        topic: String,
        /// Its type.
        type_name: String,
        /// What the client says.
        reason: String,
    },
    /// Nothing came.
    #[error("{0}")]
    Silence(String),
}
