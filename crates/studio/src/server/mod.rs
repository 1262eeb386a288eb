//! The page and its socket. Everything that is served is part of the program.

mod access;
mod assets;
mod building;
mod files;
mod guests;
pub mod hub;
mod link;
mod listen;
mod publisher;
mod pulse;
mod refusal;
mod remote;
mod remote_session;
mod routes;
mod seat;
mod smaller;
mod socket;
mod wheel;

pub use building::answer_to;
pub use listen::{Server, ServerError};
pub use publisher::Publisher;
pub use remote::Remote;
pub use remote_session::RemoteSession;
pub use wheel::{DriveLimits, DriveOrder, Wheel};
